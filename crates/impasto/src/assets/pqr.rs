//! PQR files: atoms with charges and radii, as PDB2PQR writes them.
//!
//! Fields are separated by blanks: record, number, name, residue, its chain (which may be absent) and number, place,
//! charge, radius; so the last five count from the end.

use crate::assets::molecule::{Atom, Molecule};
use crate::assets::pdb::{FARTHEST, element_of};
use crate::assets::text::{self, Lines, Words, format_error, number, string};
use crate::error::{Report, Result, note};
use crate::math::DVec3;
use std::path::Path;

/// Reads the atoms of a PQR file; bonds are made by distance.
pub fn read(bytes: &[u8], path: &Path) -> Result<Report<Molecule>> {
    let text = text::utf8(bytes);
    let mut molecule = Molecule::default();
    let mut n_bad = 0;
    for (_, line) in Lines::new(&text) {
        let words: Vec<&[u8]> = Words(&line).collect();
        if !matches!(words.first(), Some(&(b"ATOM" | b"HETATM"))) {
            continue;
        }
        match atom(&words) {
            Some(atom) => molecule.atoms.push(atom),
            None => n_bad += 1,
        }
    }
    let mut mended = Vec::new();
    note(&mut mended, n_bad, "atoms without place, charge and radius left out");
    if molecule.atoms.is_empty() {
        return Err(format_error(path, "no atom in it"));
    }
    molecule.bond_by_distance();
    Ok(Report { value: molecule, mended })
}

fn atom(words: &[&[u8]]) -> Option<Atom> {
    let (rest, last) = words.split_at(words.len().checked_sub(5).filter(|n| *n >= 3)?);
    let mut x = [0.0; 5];
    for (x, word) in x.iter_mut().zip(last) {
        *x = number(word).filter(|x| x.abs() <= FARTHEST)?;
    }
    let (name, residue) = (rest[2], rest.get(3).copied().unwrap_or_default());
    // Blanks are lost, so an ion is told by its residue, which has the element's name.
    let is_ion = name.iter().zip(residue).take(2).all(|(a, b)| a.eq_ignore_ascii_case(b)) && residue.len() <= 3;
    let mut columns = name.to_vec();
    if !(is_ion && name.len() >= 2) {
        columns.insert(0, b' ');
    }
    let number = rest[4.min(rest.len())..].iter().map(|w| string(w)).collect::<Vec<_>>().join(" ");
    Some(Atom {
        charge: Some(x[3] as f32),
        radius: x[4].max(0.0) as f32,
        name: string(name),
        residue: format!("{} {number}", string(residue)).trim().into(),
        ..Atom::new(element_of(&columns), DVec3::new(x[0], x[1], x[2]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "\
REMARK   1 by hand
ATOM      1  N   VAL     1      -2.330  -0.205   1.496 -0.4000 1.5000
ATOM      2  CA  VAL A   1      -3.501   0.435   2.070 -0.0000 2.0000
ATOM     11 HG11 VAL     1      -3.775   1.344   1.739  0.0000 0.0000
HETATM   12 CA   CA      2      -9.775   1.344   1.739  2.0000 1.3670
ATOM     13 HG11 VAL     1      -3.775   1.344
TER
";

    #[test]
    fn charges_and_radii_are_kept() {
        let report = read(FILE.as_bytes(), Path::new("a.pqr")).unwrap();
        let atoms = &report.value.atoms;
        assert_eq!(atoms.iter().map(|a| a.element).collect::<Vec<_>>(), [7, 6, 1, 20]);
        assert_eq!((atoms[0].charge, atoms[0].radius, atoms[2].radius), (Some(-0.4), 1.5, 0.0));
        assert_eq!((atoms[0].residue.as_str(), atoms[1].residue.as_str()), ("VAL 1", "VAL A 1"));
        assert_eq!(report.value.bonds, [[0, 1], [1, 2]]);
        assert_eq!(report.mended[0].to_string(), "1 atoms without place, charge and radius left out");
        assert!(read(b"TER\n", Path::new("a.pqr")).unwrap_err().to_string().contains("no atom in it"));
    }

    #[test]
    fn damage_gives_atoms_or_one_line() {
        crate::assets::volume::tests::for_each_damage(FILE.as_bytes(), |bytes| match read(bytes, Path::new("a.pqr")) {
            Ok(r) => assert!(r.value.atoms.iter().all(|a| a.position.is_finite() && a.radius >= 0.0)),
            Err(e) => assert!(!e.to_string().contains('\n')),
        });
    }
}
