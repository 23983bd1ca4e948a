//! How much each atom adds to a molecule's log P, octanol over water.
//!
//! Wildman and Crippen, "Prediction of Physicochemical Parameters by Atomic Contributions", 1999, the revision of Ghose
//! and Crippen's atom types; here the types of common organic matter. Bond orders are not in the files: an atom counts as
//! unsaturated where a bond is short, a carbon as aromatic where two bonds to its ring are. What hydrogens the file leaves
//! out is guessed from free valences, and they are added to the atom that bears them.

use crate::assets::elements;
use crate::assets::molecule::Molecule;

/// The contribution of a hydrogen by what bears it.
const H_ON_CARBON: f32 = 0.1230;
const H_ON_OXYGEN: f32 = -0.2677;
const H_ON_ACID: f32 = 0.2980;
const H_ON_NITROGEN: f32 = 0.2142;
const H_ELSEWHERE: f32 = 0.1125;

/// An atom's surroundings.
struct Site<'a> {
    molecule: &'a Molecule,
    atom: usize,
    bonded: &'a [u32],
    /// Whether the file names hydrogens; if it names some, it names all.
    has_hydrogens: bool,
}

/// Of more bonds only the first count: no file can make work without end.
const MOST_BONDS: usize = 12;

impl Site<'_> {
    fn element_of(&self, atom: u32) -> u8 {
        self.molecule.atoms[atom as usize].element
    }

    fn count(&self, is_it: impl Fn(u8) -> bool) -> usize {
        self.bonded.iter().filter(|b| is_it(self.element_of(**b))).count()
    }

    fn n_hydrogens(&self) -> usize {
        self.count(|e| e == 1)
    }

    /// The bond's length over the sum of the covalent radii.
    fn share(&self, other: u32) -> f64 {
        let [a, b] = [self.atom, other as usize].map(|i| &self.molecule.atoms[i]);
        let radii = elements::covalent(a.element) + elements::covalent(b.element);
        a.position.distance(b.position) / radii as f64
    }

    /// Bonds to atoms that are shorter than single ones.
    fn n_short(&self, is_it: impl Fn(u8) -> bool) -> usize {
        self.bonded.iter().filter(|b| is_it(self.element_of(**b)) && self.share(**b) < SHORT).count()
    }
}

/// Single bonds are about as long as the covalent radii, those in benzene 0.92, double bonds 0.88 of it.
const SHORT: f64 = 0.945;

fn is_hetero(element: u8) -> bool {
    matches!(element, 7 | 8 | 9 | 16 | 17 | 35 | 53)
}

/// One number an atom. Their sum is the molecule's log P.
pub(super) fn contributions(molecule: &Molecule) -> Vec<f32> {
    let neighbours = molecule.neighbours();
    let has_hydrogens = molecule.atoms.iter().any(|a| a.element == 1);
    let bonded = |atom: usize| &neighbours[atom][..neighbours[atom].len().min(MOST_BONDS)];
    let site = |atom: usize| Site { molecule, atom, bonded: bonded(atom), has_hydrogens };
    (0..molecule.atoms.len()).map(|i| contribution(&site(i), &site)).collect()
}

fn contribution<'a>(site: &Site, at: &impl Fn(usize) -> Site<'a>) -> f32 {
    let n_heavy = site.bonded.len() - site.n_hydrogens();
    match site.molecule.atoms[site.atom].element {
        1 => match site.bonded.first() {
            None => H_ELSEWHERE,
            Some(&bearer) => match site.element_of(bearer) {
                1 | 6 => H_ON_CARBON,
                7 => H_ON_NITROGEN,
                8 if is_acid(&at(bearer as usize), at) => H_ON_ACID,
                8 => H_ON_OXYGEN,
                _ => H_ON_OXYGEN,
            },
        },
        6 => carbon(site, n_heavy),
        7 => nitrogen(site, n_heavy),
        8 => oxygen(site, n_heavy, at),
        9 => 0.4202,
        15 => 0.8612,
        16 => 0.6482 + hidden(site, 2, n_heavy) * H_ON_OXYGEN,
        17 => 0.6895,
        35 => 0.8456,
        53 => 0.8857,
        3 | 4 | 5 | 11..=14 | 19 | 20 | 31..=34 | 37 | 38 | 49..=52 | 55 | 56 | 81..=84 => -0.3808,
        21..=30 | 39..=48 | 72..=80 => -0.0025,
        _ => 0.0,
    }
}

/// Hydrogens that an atom of this valence bears but the file leaves out.
fn hidden(site: &Site, valence: usize, n_heavy: usize) -> f32 {
    if site.has_hydrogens { 0.0 } else { valence.saturating_sub(n_heavy) as f32 }
}

fn carbon(site: &Site, n_heavy: usize) -> f32 {
    let (n_short_carbon, n_double_hetero) = (site.n_short(|e| e == 6), site.n_short(|e| matches!(e, 8 | 16)));
    let is_flat = n_short_carbon + site.n_short(is_hetero) > 0 && site.bonded.len() <= 3;
    if !is_flat {
        let n_hydrogens = hidden(site, 4, n_heavy);
        let n_all = n_hydrogens + site.n_hydrogens() as f32;
        let own = match () {
            _ if site.count(is_hetero) > 0 && n_all >= 2.0 => -0.2035,
            _ if site.count(is_hetero) > 0 => -0.2051,
            _ if n_heavy <= 2 => 0.1441,
            _ => 0.0,
        };
        return own + n_hydrogens * H_ON_CARBON;
    }
    let n_hydrogens = hidden(site, 3, n_heavy);
    let bears = n_hydrogens + site.n_hydrogens() as f32 > 0.0;
    let own = match () {
        _ if n_double_hetero > 0 => -0.2783,
        // In a ring.
        _ if n_short_carbon >= 2 || (n_short_carbon == 1 && site.n_short(|e| e == 7) > 0) => match () {
            _ if bears => 0.1581,
            _ if site.count(|e| e == 8) > 0 => 0.5437,
            _ if site.count(|e| e == 7) > site.n_short(|e| e == 7) => 0.4619,
            _ if n_short_carbon == 3 => 0.2955,
            _ => 0.1360,
        },
        _ if site.n_short(|e| e == 7) > 0 => -0.2783,
        _ => 0.1551,
    };
    own + n_hydrogens * H_ON_CARBON
}

fn nitrogen(site: &Site, n_heavy: usize) -> f32 {
    let is_short_twice = site.n_short(|e| e != 1) >= 2 && n_heavy == 2;
    // Aromatic and imine nitrogen without hydrogen, when hydrogens are told.
    if is_short_twice && site.n_hydrogens() == 0 && hidden(site, 3, n_heavy) == 0.0 {
        return -0.3239;
    }
    let n_hydrogens = hidden(site, 3, n_heavy);
    let own = match n_hydrogens as usize + site.n_hydrogens() {
        0 if n_heavy == 1 => 0.01508,
        0 if n_heavy >= 4 => -0.3396,
        0 => -0.3187,
        1 => -0.7096,
        2 => -1.0190,
        _ => -1.9500,
    };
    own + n_hydrogens * H_ON_NITROGEN
}

fn oxygen<'a>(site: &Site, n_heavy: usize, at: &impl Fn(usize) -> Site<'a>) -> f32 {
    let is_double = n_heavy == 1 && site.n_hydrogens() == 0 && site.n_short(|e| e != 1) == 1;
    if is_double {
        // Carboxylate: its carbon has another such oxygen.
        let is_carboxylate = site.bonded.iter().any(|&c| {
            let carbon = at(c as usize);
            let ends = carbon.bonded.iter().filter(|o| {
                carbon.element_of(**o) == 8 && at(**o as usize).bonded.len() == 1 && carbon.share(**o) < SHORT
            });
            carbon.element_of(site.atom as u32) == 8 && ends.count() >= 2
        });
        return if is_carboxylate { -1.3260 } else { -0.1526 };
    }
    let n_hydrogens = hidden(site, 2, n_heavy);
    let own = if n_hydrogens + site.n_hydrogens() as f32 > 0.0 { -0.2893 } else { -0.0684 };
    own + n_hydrogens * H_ON_OXYGEN
}

/// Whether an oxygen that bears a hydrogen stands beside C=O.
fn is_acid<'a>(site: &Site, at: &impl Fn(usize) -> Site<'a>) -> bool {
    site.bonded.iter().any(|&c| {
        let carbon = at(c as usize);
        let is_other = |o: u32| o as usize != site.atom && carbon.element_of(o) == 8 && carbon.share(o) < 0.9;
        carbon.molecule.atoms[c as usize].element == 6 && carbon.bonded.iter().any(|&o| is_other(o))
    })
}

/// Heiden, Moeckel and Brickmann, "A new approach to analysis and display of local lipophilicity/hydrophilicity mapped on
/// molecular surfaces", 1993: an atom's weight at a distance (angstrom) falls as Fermi's distribution, so that a point on
/// the surface takes the mean of what lies within some four angstroms.
pub(super) fn weight(distance: f32) -> f32 {
    const PER_ANGSTROM: f32 = 1.5;
    const PROXIMITY: f32 = 4.0;
    let exp = |x: f32| crate::math::exp2(x * std::f32::consts::LOG2_E);
    (exp(-PER_ANGSTROM * PROXIMITY) + 1.0) / (exp(PER_ANGSTROM * (distance - PROXIMITY)) + 1.0)
}

/// Beyond this an atom's weight is below 2e-4, angstroms.
pub(super) const REACH: f64 = 10.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::pdb;
    use std::path::Path;

    #[test]
    fn ethanol_has_the_published_log_p() {
        // The CACTUS geometry, with and without its hydrogens.
        let atoms = [
            ("C", 0.011, -0.566, 0.0),
            ("C", -1.285, 0.246, 0.0),
            ("O", 1.130, 0.322, 0.0),
            ("H", 1.925, -0.229, 0.0),
            ("H", 0.046, -1.195, 0.89),
            ("H", 0.046, -1.195, -0.89),
            ("H", -2.139, -0.432, 0.0),
            ("H", -1.32, 0.875, 0.89),
            ("H", -1.32, 0.875, -0.89),
        ];
        for n in [9, 3] {
            let text: String = atoms[..n]
                .iter()
                .map(|(e, x, y, z)| {
                    format!("HETATM    1  {e}   EOH     1    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00          {e:>2}\n")
                })
                .collect();
            let molecule = pdb::read(text.as_bytes(), Path::new("a.pdb")).unwrap().value;
            let sum: f32 = contributions(&molecule).iter().sum();
            assert!((sum - -0.0014).abs() < 1e-5, "{n} atoms: {sum}");
        }
    }

    #[test]
    fn weights_are_one_at_the_atom_and_a_half_at_the_proximity() {
        assert!((weight(0.0) - 1.0).abs() < 1e-5 && (weight(4.0) - 0.5).abs() < 2e-3);
        assert!(weight(REACH as f32) < 2e-4);
    }
}
