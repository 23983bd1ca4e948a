//! Gaussian cube files: one grid or several orbitals, and the atoms they belong to.
//!
//! Two lines of title; the number of atoms (negative: a list of orbitals follows them), origin, and how many values a
//! point has; three lines of counts and steps; the atoms; the values, the last index fastest, those of a point together.
//! Lengths are in bohr, or in angstrom where the count of an axis is negative; here all become angstrom.

use crate::assets::molecule::{Atom, Molecule};
use crate::assets::text::{self, Line, Lines, Words, format_error, integer, parse_error, string};
use crate::assets::volume::{self, Volume, fortran_number, line_of};
use crate::assets::{Lattice, elements};
use crate::error::{Report, Result, note};
use crate::math::DVec3;
use std::path::Path;

/// Angstroms in a bohr (CODATA 2018).
pub const ANGSTROMS_PER_BOHR: f64 = 0.529_177_210_903;

/// Reads the grids and atoms of a cube file.
pub fn read(bytes: &[u8], path: &Path) -> Result<Report<Volume>> {
    let text = text::utf8(bytes);
    let mut mended = Vec::new();
    let mut lines = Lines::new(&text);
    let mut next = |what: &str| lines.next().ok_or_else(|| format_error(path, format!("the file ends before {what}")));
    let title = [next("its title")?, next("its title")?].map(|l| string(text::trimmed(&l.1)));

    // How many atoms, where the grid begins, how many values a point has.
    let head = next("the number of atoms")?;
    let (n_atoms, origin, n_each) = counted_place(&head, path)?;
    let mut size = [0; 3];
    let mut axes = [DVec3::ZERO; 3];
    let mut is_angstrom = false;
    for axis in 0..3 {
        let line = next("the counts and steps of its axes")?;
        let (n, step, _) = counted_place(&line, path)?;
        is_angstrom |= n < 0;
        (size[axis], axes[axis]) = (n.unsigned_abs(), step);
    }
    let scale = if is_angstrom { 1.0 } else { ANGSTROMS_PER_BOHR };

    // The atoms: number, nuclear charge, place.
    let mut molecule = Molecule::default();
    for _ in 0..n_atoms.unsigned_abs() {
        let line = next("the last of its atoms")?;
        let mut x = [0.0; 5];
        let mut words = Words(&line.1);
        for x in &mut x {
            let word = words.next().unwrap_or_default();
            let expected = "an atom's number, charge and place";
            *x = fortran_number(word).ok_or_else(|| parse_error(path, line.0, expected, word))?;
        }
        let element = if (0.0..=elements::MOST as f64).contains(&x[0]) { x[0] as u8 } else { 0 };
        let position = DVec3::new(x[2], x[3], x[4]) * scale;
        if position.is_finite() {
            molecule.atoms.push(Atom::new(element, position));
        }
    }
    molecule.bond_by_distance();

    // The orbitals' numbers, then the values.
    let rest = lines.rest();
    let mut words = Words(rest);
    let line_now = |words: &Words| line_of(&text, words.0);
    let mut orbitals: Vec<String> = Vec::new();
    if n_atoms < 0 {
        let number = |words: &mut Words| {
            let word = words.next().unwrap_or_default();
            integer(word).ok_or_else(|| parse_error(path, line_now(words), "the number of an orbital", word))
        };
        let n = number(&mut words)?;
        if n < 1 || n as u64 > rest.len() as u64 / 2 {
            return Err(format_error(path, format!("a list of {n} orbitals")));
        }
        for _ in 0..n {
            orbitals.push(number(&mut words)?.to_string());
        }
    }
    let n_each = match (orbitals.len(), n_each) {
        (0, n) => n.max(1) as usize,
        (n, _) => n,
    };
    let n = volume::room_for(size, n_each as u64, 16, words.0.len() + 1, path)?;
    let mut values = Vec::with_capacity(n);
    while values.len() < n {
        let Some(word) = words.next() else { break };
        let x = fortran_number(word).ok_or_else(|| parse_error(path, line_now(&words), "a value", word))?;
        values.push(x as f32);
    }
    note(&mut mended, n - values.len(), "values that the head claims are not in the file");
    values.resize(n, f32::NAN);

    let size = size.map(|s| s as u32);
    let lattice = Lattice { size, origin: origin * scale, axes: axes.map(|a| a * scale) };
    let [nx, ny, nz] = size.map(|n| n as usize);
    let mut grids = Vec::new();
    for o in 0..n_each {
        let mut turned = Vec::with_capacity(n / n_each);
        for k in 0..nz {
            for j in 0..ny {
                turned.extend((0..nx).map(|i| values[((i * ny + j) * nz + k) * n_each + o]));
            }
        }
        let (name, unit) = named(&title);
        let name = match orbitals.get(o) {
            Some(number) => format!("orbital {number}"),
            None if n_each > 1 => format!("{name} {}", o + 1),
            None => name,
        };
        grids.push(volume::checked(lattice, turned, path)?.named(name, unit));
    }
    Ok(Report { value: Volume { grids, molecule, length_unit: "Å" }, mended })
}

/// A count, three numbers, and one more that may be absent.
fn counted_place((number, line): &Line, path: &Path) -> Result<(i64, DVec3, i64)> {
    let mut words = Words(line);
    let word = words.next().unwrap_or_default();
    let n = integer(word).ok_or_else(|| parse_error(path, *number, "a count and three numbers", word))?;
    let mut x = [0.0; 3];
    for x in &mut x {
        let word = words.next().unwrap_or_default();
        *x = fortran_number(word).ok_or_else(|| parse_error(path, *number, "a count and three numbers", word))?;
    }
    let n_each = words.next().and_then(integer).unwrap_or(1);
    Ok((n, DVec3::from(x), n_each))
}

/// What the title says the values are, and their unit in the atomic units of such files.
fn named(title: &[String; 2]) -> (String, &'static str) {
    let text = title.join(" ").to_lowercase();
    match () {
        _ if text.contains("potential") => ("potential".into(), "hartree/e"),
        _ if text.contains("spin density") => ("spin density".into(), "e/bohr^3"),
        _ if text.contains("density") => ("density".into(), "e/bohr^3"),
        _ => ("value".into(), ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::volume::Kind;
    use crate::assets::volume::tests::survives_damage;

    /// Two atoms, 2 x 3 x 4 points; `head` is put in place of the number of atoms.
    fn file(n_atoms: i32, n_each: &str, counts: [i32; 3], list: &str, n_values: usize) -> String {
        let mut text = format!("Electron density\nby hand\n {n_atoms} 1.0 2.0 3.0 {n_each}\n");
        for (axis, n) in counts.iter().enumerate() {
            let step = [0, 1, 2].map(|a| if a == axis { "0.5" } else { "0.0" });
            text += &format!("{n} {}\n", step.join(" "));
        }
        text += "6 6.0 1.0 2.0 3.0\n1 1.0 3.0 2.0 3.0\n";
        text += list;
        for i in 0..n_values {
            text += &format!(" {}.0E-01{}", i, if i % 6 == 5 { "\n" } else { "" });
        }
        text
    }

    fn cube(text: &str) -> Report<Volume> {
        read(text.as_bytes(), Path::new("a.cube")).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn the_last_index_runs_fastest_and_lengths_become_angstrom() {
        let report = cube(&file(2, "", [2, 3, 4], "", 24));
        let grid = &report.value.grids[0];
        assert!(report.mended.is_empty() && grid.size() == [2, 3, 4]);
        assert_eq!([grid.at(0, 0, 1), grid.at(0, 1, 0), grid.at(1, 0, 0)], [0.1, 0.4, 1.2]);
        assert_eq!((grid.name.as_str(), grid.unit.as_str()), ("density", "e/bohr^3"));
        assert!((grid.axes()[1].y - 0.5 * ANGSTROMS_PER_BOHR).abs() < 1e-12);
        assert!((grid.origin().z - 3.0 * ANGSTROMS_PER_BOHR).abs() < 1e-12);
        let atoms = &report.value.molecule.atoms;
        assert_eq!(atoms.iter().map(|a| a.element).collect::<Vec<_>>(), [6, 1]);
        assert_eq!(report.value.molecule.bonds, [[0, 1]], "two bohr apart");
        let angstrom = cube(&file(2, "", [-2, -3, -4], "", 24)).value;
        assert_eq!(angstrom.grids[0].axes()[0].x, 0.5);
        assert_eq!(angstrom.molecule.atoms[1].position.x, 3.0);
    }

    #[test]
    fn several_values_a_point_become_several_grids() {
        let volume = cube(&file(-2, "", [2, 3, 4], "2 7 8\n", 48)).value;
        let names: Vec<_> = volume.grids.iter().map(|g| g.name.as_str()).collect();
        assert_eq!(names, ["orbital 7", "orbital 8"]);
        assert_eq!([volume.grids[0].at(0, 0, 1), volume.grids[1].at(0, 0, 1)], [0.2, 0.3]);
        assert_eq!(cube(&file(2, "2", [2, 3, 4], "", 48)).value.grids[1].name, "density 2");
    }

    #[test]
    fn fortrans_numbers_are_read() {
        let text = file(2, "", [2, 3, 4], "", 24).replace("3.0E-01", "3.0D-01").replace("5.0E-01", "0.5-100");
        let grid = &cube(&text.replacen("7.0E-01", "********", 1)).value.grids[0];
        assert_eq!((grid.at(0, 0, 3), grid.at(0, 1, 1)), (0.3, 0.0));
        assert!(grid.at(0, 1, 3).is_nan());
    }

    #[test]
    fn faults_are_told_in_one_line() {
        let fault = |text: &str| read(text.as_bytes(), Path::new("a.cube")).unwrap_err().to_string();
        assert!(fault("a\nb\n").contains("ends before the number of atoms"));
        assert!(fault(&file(2, "", [2, 3, 4], "", 24).replace("2.0E-01", "two")).contains("line 9: expected a value"));
        assert!(fault(&file(2, "", [2000, 3000, 4000], "", 24)).contains("values are claimed"));
        assert!(fault(&file(2, "", [0, 3, 4], "", 24)).contains("values are claimed"));
        assert!(fault(&file(-2, "", [2, 3, 4], "99999999 1\n", 24)).contains("a list of 99999999 orbitals"));
        assert!(fault(&file(999999999, "", [2, 3, 4], "", 24)).contains("ends before the last of its atoms"));
        let short = cube(&file(2, "", [2, 3, 4], "", 20));
        assert_eq!(short.mended[0].to_string(), "4 values that the head claims are not in the file");
        assert_eq!(short.value.grids[0].range().n_missing, 4);
    }

    #[test]
    fn damage_gives_a_grid_or_one_line() {
        survives_damage(Kind::Cube, file(-2, "", [2, 3, 4], "2 7 8\n", 48).as_bytes());
    }
}
