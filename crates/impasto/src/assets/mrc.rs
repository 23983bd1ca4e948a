//! MRC and CCP4 maps (Cheng et al., "MRC2014: Extensions to the MRC format header for electron cryo-microscopy and
//! tomography", 2015).
//!
//! Columns run fastest, then rows, then sections; which of the cell's axes these are, the header tells. The grid keeps the
//! file's order and takes its steps from those axes. It begins at `ORIGIN` where that is set, else at `NSTART`. Of a stack
//! of volumes the first is read. Lengths are in angstrom.

use crate::assets::Lattice;
use crate::assets::molecule::Molecule;
use crate::assets::npy::half;
use crate::assets::text::format_error;
use crate::assets::volume::{self, Volume};
use crate::error::{Mended, Report, Result, note};
use crate::math::{DVec3, exact};
use std::path::Path;

/// Bytes before the extended header.
const HEADER: usize = 1024;

/// Reads a map of mode 0, 1, 2, 6 or 12 in either byte order.
pub fn read(bytes: &[u8], path: &Path) -> Result<Report<Volume>> {
    if bytes.len() < HEADER {
        return Err(format_error(path, format!("an MRC header has {HEADER} bytes, the file {}", bytes.len())));
    }
    let mut mended = Vec::new();
    let head = Head { bytes, is_big: is_big_endian(bytes) };
    let mode = head.integer(4);
    let is_unsigned = head.integer(39) == IMOD && head.integer(40) & 1 == 0;
    let size = [1, 2, 3].map(|w| head.integer(w));
    let [Ok(nx), Ok(ny), Ok(mut nz)] = size.map(u64::try_from) else {
        return Err(format_error(path, format!("a map of {} x {} x {} values", size[0], size[1], size[2])));
    };
    // Space group 401 and up: NZ counts the sections of all volumes, MZ those of one.
    let mz = head.integer(10).max(0) as u64;
    if head.integer(23) >= 401 && mz > 0 && mz < nz {
        note(&mut mended, (nz / mz) as usize - 1, "further volumes of the stack left out");
        nz = mz;
    }
    let n_bytes = match mode {
        0 => 1,
        1 | 6 | 12 => 2,
        2 => 4,
        3 | 4 => return Err(format_error(path, format!("mode {mode}: transforms of complex numbers are not read"))),
        _ => return Err(format_error(path, format!("mode {mode} is none that is read (0, 1, 2, 6, 12)"))),
    };
    let start = HEADER as u64 + head.integer(24).max(0) as u64;
    let data = bytes.get(start as usize..).unwrap_or_default();
    let n = volume::room_for([nx, ny, nz], 1, 8 * n_bytes as u64, data.len(), path)?;
    let two = |b: &[u8]| if head.is_big { [b[1], b[0]] } else { [b[0], b[1]] };
    let items = data[..n * n_bytes].chunks_exact(n_bytes);
    let values: Vec<f32> = match mode {
        0 if is_unsigned => items.map(|b| b[0] as f32).collect(),
        0 => items.map(|b| b[0] as i8 as f32).collect(),
        1 => items.map(|b| i16::from_le_bytes(two(b)) as f32).collect(),
        6 => items.map(|b| u16::from_le_bytes(two(b)) as f32).collect(),
        12 => items.map(|b| half(u16::from_le_bytes(two(b))) as f32).collect(),
        _ => items.map(|b| f32::from_bits(head.four([b[0], b[1], b[2], b[3]]))).collect(),
    };
    let lattice = head.lattice([nx as u32, ny as u32, nz as u32], &mut mended);
    let grid = volume::checked(lattice, values, path)?.named("density", "");
    Ok(Report { value: Volume { grids: vec![grid], molecule: Molecule::default(), length_unit: "Å" }, mended })
}

/// The stamp that IMOD leaves in word 39.
const IMOD: i32 = 1_146_047_817;

/// By the machine stamp in word 54; where there is none, by which order gives a mode and axes that exist.
fn is_big_endian(bytes: &[u8]) -> bool {
    match bytes[212] {
        0x44 => false,
        0x11 => true,
        _ => {
            let makes_sense = |is_big| {
                let head = Head { bytes, is_big };
                (0..=16).contains(&head.integer(4)) && (0..=3).contains(&head.integer(17)) && head.integer(1) < 1 << 16
            };
            !makes_sense(false) && makes_sense(true)
        }
    }
}

/// Words of four bytes, counted from 1.
struct Head<'a> {
    bytes: &'a [u8],
    is_big: bool,
}

impl Head<'_> {
    fn four(&self, b: [u8; 4]) -> u32 {
        if self.is_big { u32::from_be_bytes(b) } else { u32::from_le_bytes(b) }
    }

    fn word(&self, i: usize) -> u32 {
        let at = (i - 1) * 4;
        self.four([self.bytes[at], self.bytes[at + 1], self.bytes[at + 2], self.bytes[at + 3]])
    }

    fn integer(&self, i: usize) -> i32 {
        self.word(i) as i32
    }

    fn real(&self, i: usize) -> f64 {
        f32::from_bits(self.word(i)) as f64
    }

    /// Where the points lie.
    fn lattice(&self, size: [u32; 3], mended: &mut Vec<Mended>) -> Lattice {
        // Which axis of the cell columns, rows and sections run along.
        let axis_of = [17, 18, 19].map(|w| self.integer(w));
        let is_permutation = (1..=3).all(|a| axis_of.contains(&a));
        if !is_permutation && axis_of != [0; 3] {
            note(mended, 1, "order of axes that is none taken as X, Y, Z");
        }
        let axis_of = if is_permutation { axis_of.map(|a| a as usize - 1) } else { [0, 1, 2] };
        // The cell, and into how many steps it is divided.
        let mut lengths = [11, 12, 13].map(|w| self.real(w));
        let mut angles = [14, 15, 16].map(|w| self.real(w));
        let mut steps = [8, 9, 10].map(|w| self.integer(w) as f64);
        for column in 0..3 {
            let n = &mut steps[axis_of[column]];
            if *n < 1.0 {
                *n = size[column] as f64;
            }
        }
        if !lengths.iter().all(|l| *l > 0.0 && l.is_finite()) {
            note(mended, 1, "cell without lengths taken as one angstrom a step");
            lengths = steps;
        }
        if !angles.iter().all(|a| *a > 0.0 && *a < 180.0) {
            angles = [90.0; 3];
        }
        let cell = cell_axes(lengths, angles);
        let step = |axis: usize| cell[axis] / steps[axis];
        let axes = axis_of.map(step);
        let origin = DVec3::from([50, 51, 52].map(|w| self.real(w)));
        let has_origin = origin != DVec3::ZERO && origin.is_finite() && &self.bytes[208..211] == b"MAP";
        let origin = if has_origin {
            origin
        } else {
            [5, 6, 7].map(|w| self.integer(w) as f64).iter().zip(&axes).map(|(n, a)| *a * *n).sum()
        };
        Lattice { size, origin, axes }
    }
}

/// The edges of a cell: the first along x, the second in the plane of x and y.
fn cell_axes([a, b, c]: [f64; 3], angles: [f64; 3]) -> [DVec3; 3] {
    // A right angle is exactly one.
    let cosine = |angle: f64| if angle == 90.0 { 0.0 } else { exact::cos(angle.to_radians()) };
    let [cos_alpha, cos_beta, cos_gamma] = angles.map(cosine);
    let sin_gamma = (1.0 - cos_gamma * cos_gamma).sqrt();
    let y = (cos_alpha - cos_beta * cos_gamma) / sin_gamma;
    let z = (1.0 - cos_beta * cos_beta - y * y).max(0.0).sqrt();
    [DVec3::X * a, DVec3::new(cos_gamma, sin_gamma, 0.0) * b, DVec3::new(cos_beta, y, z) * c]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::volume::Kind;
    use crate::assets::volume::tests::survives_damage;

    /// A map of 2 x 3 x 4 values 0, 1, 2 ... in a cell of 4 x 6 x 8 angstrom.
    fn file(mode: i32, is_big: bool, words: &[(usize, i32)]) -> Vec<u8> {
        let mut bytes = vec![0; HEADER];
        let mut put = |word: usize, bits: u32| {
            let b = if is_big { bits.to_be_bytes() } else { bits.to_le_bytes() };
            bytes[(word - 1) * 4..word * 4].copy_from_slice(&b);
        };
        for (word, n) in [(1, 2), (2, 3), (3, 4), (4, mode), (8, 2), (9, 3), (10, 4), (17, 1), (18, 2), (19, 3)] {
            put(word, n as u32);
        }
        for (word, x) in [(11, 4.0f32), (12, 6.0), (13, 8.0), (14, 90.0), (15, 90.0), (16, 90.0)] {
            put(word, x.to_bits());
        }
        words.iter().for_each(|(word, bits)| put(*word, *bits as u32));
        bytes[208..212].copy_from_slice(b"MAP ");
        bytes[212] = if is_big { 0x11 } else { 0x44 };
        for i in 0..24u32 {
            let le: Vec<u8> = match mode {
                0 => vec![i as u8],
                1 | 6 => (i as u16).to_le_bytes().into(),
                12 => [0u16, 0x3c00, 0x4000, 0x4200][i as usize % 4].to_le_bytes().into(),
                _ => (i as f32).to_le_bytes().into(),
            };
            bytes.extend(if is_big { le.into_iter().rev().collect() } else { le });
        }
        bytes
    }

    fn grid(bytes: &[u8]) -> crate::assets::Grid {
        read(bytes, Path::new("a.mrc")).unwrap_or_else(|e| panic!("{e}")).value.grids.remove(0)
    }

    #[test]
    fn all_modes_and_both_byte_orders_are_read() {
        for mode in [0, 1, 2, 6, 12] {
            for is_big in [false, true] {
                let mut bytes = file(mode, is_big, &[]);
                let g = grid(&bytes);
                let wanted = if mode == 12 { [1.0, 3.0] } else { [1.0, 23.0] };
                assert_eq!(([g.at(1, 0, 0), g.at(1, 2, 3)], g.size()), (wanted, [2, 3, 4]), "{mode} {is_big}");
                assert_eq!((g.axes(), g.origin()), ([DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0], DVec3::ZERO));
                bytes[212] = 0;
                assert_eq!(grid(&bytes).size(), [2, 3, 4], "without a stamp");
            }
        }
    }

    #[test]
    fn axes_and_origin_are_those_of_the_header() {
        // Columns along Z, rows along X, sections along Y; steps 4, 2, 2 of a cell of 4, 6, 8.
        let g = grid(&file(2, false, &[(17, 3), (18, 1), (19, 2), (5, 10), (6, -1), (8, 4), (9, 2), (10, 2)]));
        assert_eq!(g.axes(), [DVec3::Z * 4.0, DVec3::X, DVec3::Y * 3.0]);
        assert_eq!(g.origin(), DVec3::new(-1.0, 0.0, 40.0));
        let origin = [(5, 10), (50, 1.5f32.to_bits() as i32)];
        assert_eq!(grid(&file(2, true, &origin)).origin(), DVec3::X * 1.5);
        let hexagonal = grid(&file(2, false, &[(16, 120.0f32.to_bits() as i32)]));
        assert!((hexagonal.axes()[1] - DVec3::new(-1.0, 3f64.sqrt(), 0.0)).length() < 1e-6);
        let stack = read(&file(1, false, &[(23, 401), (10, 2)]), Path::new("a.mrc")).unwrap();
        assert_eq!(stack.value.grids[0].size(), [2, 3, 2]);
        assert_eq!(stack.mended[0].to_string(), "1 further volumes of the stack left out");
    }

    #[test]
    fn faults_are_told_in_one_line() {
        let fault = |bytes: &[u8]| read(bytes, Path::new("a.mrc")).unwrap_err().to_string();
        assert!(fault(b"MAP").contains("an MRC header has 1024 bytes, the file 3"));
        assert!(fault(&file(4, false, &[])).contains("mode 4: transforms"));
        assert!(fault(&file(9, false, &[])).contains("mode 9 is none"));
        assert!(fault(&file(2, false, &[(1, -2)])).contains("a map of -2 x 3 x 4"));
        assert!(fault(&file(2, false, &[(1, i32::MAX), (2, i32::MAX)])).contains("values are claimed"));
        assert!(fault(&file(2, false, &[(24, 8)])).contains("values are claimed"));
    }

    #[test]
    fn damage_gives_a_grid_or_one_line() {
        survives_damage(Kind::Mrc, &file(1, false, &[]));
        survives_damage(Kind::Mrc, &file(2, true, &[])[..]);
    }
}
