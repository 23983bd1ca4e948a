//! Ethanol: nine atoms, their smooth surface, and the potentials on it.
//!
//! Bond lengths, angles and partial charges of the force field OPLS-AA (Jorgensen, Maxwell and Tirado-Rives, "Development
//! and Testing of the OPLS All-Atom Force Field on Conformational Energetics and Properties of Organic Liquids", 1996),
//! all bonds staggered, the hydroxyl group's hydrogen away from the methyl group.

use crate::assets::molecular_surface::{self, Options};
use crate::assets::{Atom, Molecule, Scene};
use crate::math::DVec3;
use crate::math::exact::{cos, sin};

/// The surface, about 7 units (angstrom) long, `resolution` edges along it, coloured by element. Fields `element`, `atom`,
/// `charge`, `potential` (volts) and `lipophilicity` (log P).
pub fn scene(resolution: u32) -> Scene {
    let spacing = Some(LENGTH / resolution.max(8) as f64);
    molecular_surface::scene(&molecule(), "ethanol".into(), &Options { spacing }).value
}

/// Of the surface, angstrom.
const LENGTH: f64 = 6.6;

/// The nine atoms about their middle: the carbons, the oxygen and its hydrogen in the plane z = 0, the chain along x.
pub fn molecule() -> Molecule {
    const CC: f64 = 1.529;
    const CO: f64 = 1.410;
    const CH: f64 = 1.090;
    const OH: f64 = 0.945;
    let in_plane = |degrees: f64| DVec3::new(cos(degrees.to_radians()), sin(degrees.to_radians()), 0.0);
    let methyl = DVec3::ZERO;
    let methylene = DVec3::X * CC;
    // Angles CCO 109.5 and COH 108.5 degrees; the chain goes zigzag.
    let to_oxygen = in_plane(180.0 - 109.5);
    let oxygen = methylene + to_oxygen * CO;
    let hydroxyl = oxygen + in_plane(180.0 - 109.5 - (180.0 - 108.5)) * OH;
    // Two hydrogens, 107.8 degrees apart, on the other side of the methylene carbon.
    let away = -(to_oxygen - DVec3::X).normalize();
    let [out, aside] = [cos(53.9f64.to_radians()), sin(53.9f64.to_radians())];
    // Three hydrogens, 110.7 degrees from the chain, one of them opposite to the oxygen.
    let [along, across] = [cos(110.7f64.to_radians()), sin(110.7f64.to_radians())];
    let methyl_hydrogen = |degrees: f64| {
        let turn = degrees.to_radians();
        methyl + (DVec3::X * along + DVec3::new(0.0, cos(turn), sin(turn)) * across) * CH
    };
    let atoms = [
        (6, "CH3", -0.180, methyl),
        (6, "CH2", 0.145, methylene),
        (8, "O", -0.683, oxygen),
        (1, "HO", 0.418, hydroxyl),
        (1, "H", 0.060, methylene + (away * out + DVec3::Z * aside) * CH),
        (1, "H", 0.060, methylene + (away * out - DVec3::Z * aside) * CH),
        (1, "H", 0.060, methyl_hydrogen(180.0)),
        (1, "H", 0.060, methyl_hydrogen(60.0)),
        (1, "H", 0.060, methyl_hydrogen(-60.0)),
    ];
    let middle = atoms.iter().map(|a| a.3).sum::<DVec3>() / atoms.len() as f64;
    let atoms = atoms.map(|(element, name, charge, place)| Atom {
        charge: Some(charge),
        name: name.into(),
        residue: "EOH 1".into(),
        ..Atom::new(element, place - middle)
    });
    let mut molecule = Molecule { atoms: atoms.into(), bonds: Vec::new() };
    molecule.bond_by_distance();
    molecule
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::Topology;

    #[test]
    fn the_molecule_is_neutral_and_well_built() {
        let molecule = molecule();
        let charge: f32 = molecule.atoms.iter().filter_map(|a| a.charge).sum();
        assert!(charge.abs() < 1e-6);
        assert_eq!(molecule.bonds, [[0, 1], [0, 6], [0, 7], [0, 8], [1, 2], [1, 4], [1, 5], [2, 3]]);
        // Hydrogens keep their distance: 1.7 angstrom at least.
        for (i, a) in molecule.atoms.iter().enumerate().filter(|(_, a)| a.element == 1) {
            for b in molecule.atoms[..i].iter().filter(|b| b.element == 1) {
                assert!(a.position.distance(b.position) > 1.7);
            }
        }
    }

    #[test]
    fn the_surface_tells_oxygen_from_hydrogen() {
        let mesh = scene(48).mesh;
        let topology = Topology::of(&mesh);
        assert!(topology.is_solid() && topology.genus() == Some(0) && topology.n_pieces == 1, "{topology:?}");
        let names: Vec<_> = mesh.fields().iter().map(|f| f.name.as_str()).collect();
        assert_eq!(names, ["element", "atom", "charge", "potential", "lipophilicity"]);
        let extreme = |field: usize, wanted: &dyn Fn(f64, f64) -> bool| {
            let f = &mesh.fields()[field];
            let best = (0..f.n_elements()).reduce(|a, b| if wanted(f.values.at(b), f.values.at(a)) { b } else { a });
            mesh.fields()[1].values.at(best.unwrap()) as usize
        };
        // Most negative at the oxygen, most positive at the hydroxyl group's hydrogen; least lipophilic at one of the two.
        assert_eq!((extreme(3, &|a, b| a < b), extreme(3, &|a, b| a > b)), (2, 3));
        assert!(matches!(extreme(4, &|a, b| a < b), 2 | 3));
        let longest = mesh.bounds().extent().max_element() as f64;
        assert!((longest / LENGTH - 1.0).abs() < 0.1, "{longest}");
    }
}
