//! Protein Data Bank files: the first model's atoms, and the bonds they name.
//!
//! Columns are fixed. Elements come from columns 77 and 78, or from the atom's name, which the format sets so that
//! elements of one letter begin in column 14. Of alternate places the first is taken. Atoms that no `CONECT` names are
//! bonded by distance.

use crate::assets::elements;
use crate::assets::molecule::{Atom, Molecule};
use crate::assets::text::{self, Lines, format_error, integer, number, string, trimmed};
use crate::error::{Report, Result, note};
use crate::math::DVec3;
use std::collections::HashMap;
use std::path::Path;

/// Reads the atoms of a PDB file.
pub fn read(bytes: &[u8], path: &Path) -> Result<Report<Molecule>> {
    let text = text::utf8(bytes);
    let mut reader = Reader::default();
    for (_, line) in Lines::new(&text) {
        match column(&line, 1..7) {
            b"ATOM" | b"HETATM" if !reader.is_done => reader.atom(&line),
            b"CONECT" => reader.bonds_of(&line),
            // What follows are other models of the same molecule.
            b"ENDMDL" => reader.is_done = true,
            _ => {}
        }
    }
    let mut mended = Vec::new();
    note(&mut mended, reader.n_bad, "atoms without a place left out");
    note(&mut mended, reader.n_alternate, "alternate places of atoms left out");
    let mut molecule = reader.molecule;
    if molecule.atoms.is_empty() {
        return Err(format_error(path, "no atom in it"));
    }
    let bonds = reader.bonds.iter().filter_map(|[a, b]| Some([*reader.by_serial.get(a)?, *reader.by_serial.get(b)?]));
    molecule.bonds = bonds.collect();
    molecule.sort_bonds();
    molecule.bond_by_distance();
    Ok(Report { value: molecule, mended })
}

/// What stands in columns, counted from 1, without blanks.
fn column(line: &[u8], columns: std::ops::Range<usize>) -> &[u8] {
    let end = (columns.end - 1).min(line.len());
    trimmed(line.get(columns.start - 1..end).unwrap_or_default())
}

/// Coordinates beyond this are no molecule's, angstroms.
pub(super) const FARTHEST: f64 = 1e6;

#[derive(Default)]
struct Reader {
    molecule: Molecule,
    /// Where an atom with a serial number is; of several the first. Never enumerated.
    by_serial: HashMap<i64, u32>,
    bonds: Vec<[i64; 2]>,
    /// The alternate place that counts in the residue at hand.
    residue: String,
    alternate: u8,
    is_done: bool,
    n_bad: usize,
    n_alternate: usize,
}

impl Reader {
    fn atom(&mut self, line: &[u8]) {
        let coordinate = |columns| number(column(line, columns)).filter(|x| x.abs() <= FARTHEST);
        let (Some(x), Some(y), Some(z)) = (coordinate(31..39), coordinate(39..47), coordinate(47..55)) else {
            self.n_bad += 1;
            return;
        };
        let residue = format!("{} {}{}", string(column(line, 18..21)), chain(line), string(column(line, 23..28)));
        if residue != self.residue {
            (self.residue, self.alternate) = (residue.clone(), b' ');
        }
        match line.get(16) {
            None | Some(b' ') => {}
            Some(&a) if self.alternate == b' ' || self.alternate == a => self.alternate = a,
            Some(_) => {
                self.n_alternate += 1;
                return;
            }
        }
        let name = string(column(line, 13..17));
        let named = std::str::from_utf8(column(line, 77..79)).ok().and_then(elements::by_symbol);
        let element = named.unwrap_or_else(|| element_of(line.get(12..16).unwrap_or_default()));
        let b_factor = number(column(line, 61..67)).map_or(f32::NAN, |b| b as f32);
        let atom = Atom {
            charge: charge(column(line, 79..81)),
            b_factor: if b_factor.is_finite() { b_factor } else { f32::NAN },
            name,
            residue: residue.trim().into(),
            ..Atom::new(element, DVec3::new(x, y, z))
        };
        if let Some(serial) = integer(column(line, 7..12)) {
            self.by_serial.entry(serial).or_insert(self.molecule.atoms.len() as u32);
        }
        self.molecule.atoms.push(atom);
    }

    fn bonds_of(&mut self, line: &[u8]) {
        let serial = |columns| integer(column(line, columns));
        let Some(a) = serial(7..12) else { return };
        let others = [serial(12..17), serial(17..22), serial(22..27), serial(27..32)];
        self.bonds.extend(others.into_iter().flatten().map(|b| [a, b]));
    }
}

/// The chain's letter and a blank; nothing when there is none.
fn chain(line: &[u8]) -> String {
    match column(line, 22..23) {
        [] => String::new(),
        c => format!("{} ", string(c)),
    }
}

/// A formal charge: `2+`, `+2`, `1-`.
fn charge(columns: &[u8]) -> Option<f32> {
    let digit = columns.iter().find(|b| b.is_ascii_digit())? - b'0';
    Some(if columns.contains(&b'-') { -(digit as f32) } else { digit as f32 })
}

/// The element of an atom's name in its four columns: one letter elements begin in the second.
pub(super) fn element_of(columns: &[u8]) -> u8 {
    let letters: Vec<u8> = columns.iter().copied().filter(u8::is_ascii_alphabetic).collect();
    let symbol = |n: usize| std::str::from_utf8(letters.get(..n)?).ok().and_then(elements::by_symbol);
    let begins_early = columns.first().is_some_and(u8::is_ascii_alphabetic);
    // Names of hydrogen fill all four columns: HG11.
    let is_full = columns.len() == 4 && !columns.contains(&b' ');
    let two = if begins_early && !(is_full && letters[0] == b'H') { symbol(2) } else { None };
    two.or_else(|| symbol(1)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "\
HEADER    BY HAND
MODEL        1
ATOM      1  N   GLY A   1      11.104   6.134  -6.504  1.00 20.50           N  
ATOM      2  CA AGLY A   1      11.639   6.071  -5.147  0.50 21.00              
ATOM      3  CA BGLY A   1      11.739   6.171  -5.147  0.50 21.00              
ATOM      4 HA11 GLY A   1      11.339   6.971  -4.547  1.00 21.00              
HETATM    5 CA    CA A 301      21.639   6.071  -5.147  1.00  9.00          CA2+
HETATM    6 ZN    ZN A 302      28.639   6.071  -5.147  1.00
HETATM    7  O   HOH A 303      31.639      **  -5.147  1.00
ENDMDL
MODEL        2
ATOM      1  N   GLY A   1      11.104   6.134  -6.504  1.00 20.50           N  
ENDMDL
CONECT    5    6    0
END
";

    #[test]
    fn the_first_model_is_read_by_its_columns() {
        let report = read(FILE.as_bytes(), Path::new("a.pdb")).unwrap();
        let atoms = &report.value.atoms;
        assert_eq!(atoms.iter().map(|a| a.element).collect::<Vec<_>>(), [7, 6, 1, 20, 30]);
        assert_eq!((atoms[0].b_factor, atoms[0].name.as_str(), atoms[0].residue.as_str()), (20.5, "N", "GLY A 1"));
        assert_eq!((atoms[0].charge, atoms[3].charge), (None, Some(2.0)));
        assert!(atoms[4].b_factor.is_nan());
        assert_eq!(report.value.bonds, [[0, 1], [1, 2], [3, 4]]);
        let told: Vec<_> = report.mended.iter().map(|m| m.to_string()).collect();
        assert_eq!(told, ["1 atoms without a place left out", "1 alternate places of atoms left out"]);
        assert!(read(b"HEADER\nEND\n", Path::new("a.pdb")).unwrap_err().to_string().contains("no atom in it"));
    }

    #[test]
    fn names_tell_elements() {
        for (name, wanted) in
            [(" CA ", 6), ("CA  ", 20), ("HG11", 1), ("1HB ", 1), (" OXT", 8), ("FE  ", 26), ("CL1 ", 17), ("    ", 0)]
        {
            assert_eq!(element_of(name.as_bytes()), wanted, "{name}");
        }
    }

    #[test]
    fn damage_gives_atoms_or_one_line() {
        crate::assets::volume::tests::for_each_damage(FILE.as_bytes(), |bytes| match read(bytes, Path::new("a.pdb")) {
            Ok(r) => {
                let n = r.value.atoms.len() as u32;
                assert!(r.value.bonds.iter().all(|[a, b]| a < b && *b < n));
                assert!(r.value.atoms.iter().all(|a| a.position.is_finite()));
            }
            Err(e) => assert!(!e.to_string().contains('\n')),
        });
    }
}
