//! Atoms and the bonds between them. Lengths are in angstrom.

use crate::assets::elements;
use crate::assets::nearby::Cells;
use crate::math::DVec3;

/// An atom.
#[derive(Clone, Debug, PartialEq)]
pub struct Atom {
    /// Atomic number; 0 is unknown.
    pub element: u8,
    /// Angstrom.
    pub position: DVec3,
    /// In elementary charges; none where the file does not tell.
    pub charge: Option<f32>,
    /// Angstrom; as the file says, or the van der Waals radius of the element.
    pub radius: f32,
    /// Mean square displacement times 8 pi squared, in square angstrom; NaN where the file does not tell.
    pub b_factor: f32,
    /// As the file names it: `CA`, `HG11` ...
    pub name: String,
    /// What it is part of: `VAL 1`, `HOH 301`; empty where the file does not tell.
    pub residue: String,
}

impl Atom {
    /// An atom of which only element and place are known.
    pub fn new(element: u8, position: DVec3) -> Self {
        Self {
            element,
            position,
            charge: None,
            radius: elements::van_der_waals(element),
            b_factor: f32::NAN,
            name: elements::symbol(element).into(),
            residue: String::new(),
        }
    }

    /// Whether it is part of a water molecule.
    pub fn is_water(&self) -> bool {
        let name = self.residue.split(' ').next().unwrap_or_default();
        matches!(name, "HOH" | "WAT" | "DOD" | "H2O" | "TIP" | "TIP3" | "TIP4" | "SOL")
    }
}

/// Atoms and bonds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Molecule {
    /// In the file's order; positions are finite.
    pub atoms: Vec<Atom>,
    /// Pairs of atoms, the lower index first, rising; none twice.
    pub bonds: Vec<[u32; 2]>,
}

/// Atoms are bonded when they are at most this much further apart than their covalent radii, angstroms.
const TOLERANCE: f64 = 0.45;

/// No atom has more; of a crowd the first count.
const MOST_BONDS: u8 = 16;

/// Atoms that are nearer are one atom in two places rather than bonded, angstroms.
const NEAREST: f64 = 0.4;

impl Molecule {
    /// Bonds the atoms that have no bond yet with those near enough.
    pub fn bond_by_distance(&mut self) {
        let mut is_bonded = vec![false; self.atoms.len()];
        self.bonds.iter().flatten().for_each(|&a| is_bonded[a as usize] = true);
        if is_bonded.iter().all(|b| *b) {
            return;
        }
        let radius = |a: &Atom| elements::covalent(a.element) as f64;
        let widest = self.atoms.iter().map(radius).fold(0.0, f64::max);
        let cells = Cells::of(self.atoms.iter().map(|a| a.position), 2.0 * widest + TOLERANCE);
        let mut n_new = vec![0; self.atoms.len()];
        for (i, a) in self.atoms.iter().enumerate() {
            cells.near(a.position, |j| {
                let b = &self.atoms[j as usize];
                let d = a.position.distance(b.position);
                let is_apart = a.element == 1 && b.element == 1;
                let is_near = (NEAREST..=radius(a) + radius(b) + TOLERANCE).contains(&d);
                let j = j as usize;
                let has_room = n_new[i] < MOST_BONDS && n_new[j] < MOST_BONDS;
                if j > i && is_near && !is_apart && has_room && !(is_bonded[i] && is_bonded[j]) {
                    self.bonds.push([i as u32, j as u32]);
                    n_new[i] += 1;
                    n_new[j] += 1;
                }
            });
        }
        self.sort_bonds();
    }

    /// Lower indices first, rising, none twice, none between an atom and itself.
    pub(super) fn sort_bonds(&mut self) {
        self.bonds.iter_mut().for_each(|b| b.sort_unstable());
        self.bonds.retain(|[a, b]| a != b);
        self.bonds.sort_unstable();
        self.bonds.dedup();
    }

    /// For each atom the atoms it is bonded to.
    pub fn neighbours(&self) -> Vec<Vec<u32>> {
        let mut neighbours = vec![Vec::new(); self.atoms.len()];
        for &[a, b] in &self.bonds {
            neighbours[a as usize].push(b);
            neighbours[b as usize].push(a);
        }
        neighbours
    }
}
