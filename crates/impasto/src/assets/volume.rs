//! Files of values on 3-D grids: the kinds, and what they have in common.

use crate::assets::text::{self, format_error};
use crate::assets::{Grid, Lattice, Molecule, cube, dx, mrc, nrrd};
use crate::error::{Report, Result};
use std::path::Path;

/// What a file of grids holds.
#[derive(Clone, Debug)]
pub struct Volume {
    /// At least one; all of one shape.
    pub grids: Vec<Grid>,
    /// Atoms that come with it; may be none.
    pub molecule: Molecule,
    /// The unit of lengths as text; empty when unknown.
    pub length_unit: &'static str,
}

/// Which kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Gaussian cube.
    Cube,
    /// OpenDX scalar field.
    Dx,
    /// MRC or CCP4 map.
    Mrc,
    /// Nearly raw raster data.
    Nrrd,
}

/// Reads the grids of a file of a kind.
pub fn read_as(kind: Kind, bytes: &[u8], path: &Path) -> Result<Report<Volume>> {
    match kind {
        Kind::Cube => cube::read(bytes, path),
        Kind::Dx => dx::read(bytes, path),
        Kind::Mrc => mrc::read(bytes, path),
        Kind::Nrrd => nrrd::read(bytes, path),
    }
}

/// A grid, or one line about the file that describes none.
pub(super) fn checked(lattice: Lattice, values: Vec<f32>, path: &Path) -> Result<Grid> {
    Grid::new(lattice, values).map_err(|fault| format_error(path, fault))
}

/// How many values a head claims, if the file has room for them at `bits` bits a value.
pub(super) fn room_for(size: [u64; 3], n_each: u64, bits: u64, n_bytes: usize, path: &Path) -> Result<usize> {
    let n = size.iter().try_fold(n_each, |n, s| n.checked_mul(*s));
    let n_most = n_bytes as u64 * 8 / bits;
    match n.and_then(|n| usize::try_from(n).ok()) {
        Some(n) if n as u64 <= n_most && n > 0 && size.iter().all(|s| *s <= u32::MAX as u64) => Ok(n),
        _ => {
            let [x, y, z] = size;
            let times = if n_each == 1 { String::new() } else { format!(" x {n_each}") };
            let fault = format!("{x} x {y} x {z}{times} values are claimed, the file has room for at most {n_most}");
            Err(format_error(path, fault))
        }
    }
}

/// A number as Fortran may write it: `1.5D-03`, `0.1-103`; asterisks, where it did not fit its field, are missing.
pub(super) fn fortran_number(word: &[u8]) -> Option<f64> {
    if let Some(x) = text::number(word) {
        return Some(x);
    }
    if word.iter().all(|b| *b == b'*') {
        return Some(f64::NAN);
    }
    let mut mended: Vec<u8> = word.iter().map(|b| if matches!(b, b'd' | b'D') { b'e' } else { *b }).collect();
    if !mended.contains(&b'e') {
        let sign = mended.iter().rposition(|b| matches!(b, b'+' | b'-')).filter(|i| *i > 0)?;
        mended.insert(sign, b'e');
    }
    text::number(&mended)
}

/// The line, from 1, at which `rest` of `text` begins.
pub(super) fn line_of(text: &[u8], rest: &[u8]) -> usize {
    1 + text[..text.len() - rest.len()].iter().filter(|b| **b == b'\n').count()
}

#[cfg(test)]
#[path = "volume_tests.rs"]
pub(super) mod tests;
