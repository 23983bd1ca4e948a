//! The smooth surface of a molecule, and what it knows of its atoms.
//!
//! The sum of a Gaussian an atom (Blinn, "A Generalization of Algebraic Surface Drawing", 1982), as wide as makes spheres
//! of one atom have its radius and overlapping ones the volumes of hard spheres (Grant and Pickup, "A Gaussian Description
//! of Molecular Shape", 1995). The isosurface of its grid is moved onto the sum itself, so that the surface and its
//! normals are smooth at any resolution.

use crate::assets::isosurface;
use crate::assets::molecule::Molecule;
use crate::assets::nearby::Cells;
use crate::assets::{Element, Field, Grid, Lattice, Material, Mesh, Part, Scene, Values, elements, lipophilicity};
use crate::error::{Mended, Report, note};
use crate::math::{DVec3, Vec4, exp2, unit_or, vec4};

/// How a molecule becomes a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Distance between the points of the grid, angstroms. None: as suits the molecule's size.
    pub spacing: Option<f64>,
}

/// Steepness of the Gaussians: pi (3 p / 4 pi)^(2/3) for Grant and Pickup's p = 2.7.
const STEEPNESS: f32 = 2.3442;

/// Gaussians end where they are e^-7, at this many radii; a little is taken off so that they end smoothly.
const REACH: f64 = 2.0;

/// What is taken off: e^(-3 STEEPNESS).
const OFFSET: f32 = 8.83e-4;

/// Points in the grid, at most.
const MOST_POINTS: f64 = (1 << 24) as f64;

/// Values added to the grid's points, at most: bounds the time that crowded atoms take.
const MOST_ADDED: f64 = (1u64 << 31) as f64;

/// Pairs of charges and vertices, at most.
const MOST_PAIRS: usize = 1 << 31;

/// The Coulomb constant: volts at one angstrom from an elementary charge.
pub const VOLT_ANGSTROMS: f64 = 14.399_645;

/// The surface, with colours by element and vertex fields.
///
/// `element` (atomic number) and `atom` (index) of the atom that counts most there; `b_factor` (square angstrom), mixed as
/// the atoms count; `charge` (elementary charges) of that atom; `potential` (volts), the Coulomb sum of all charges
/// without screening, when each atom has one; `lipophilicity` (log P), the mean of the atoms' contributions around.
/// Water is left out where there is anything else, atoms without radius are not part of the surface.
pub fn of(molecule: &Molecule, options: &Options) -> Report<Mesh> {
    let mut mended = Vec::new();
    let sum = Sum::of(molecule, &mut mended);
    let Some(grid) = sum.grid(options) else { return Report { value: Mesh::default(), mended } };
    let options = isosurface::Options { level: 1.0, closed: true, ..Default::default() };
    let mut raw = isosurface::of(&grid, &options).into_raw();
    let step = grid.axes()[0].x;
    for (p, n) in raw.positions.iter_mut().zip(&mut raw.normals) {
        let (place, slope) = sum.onto(p.as_dvec3(), step);
        *p = place.as_vec3();
        *n = unit_or(-slope.as_vec3(), *n);
    }
    raw.fields = sum.fields(molecule, &raw.positions.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>(), &mut mended);
    raw.colors = raw.positions.iter().map(|p| sum.color(molecule, p.as_dvec3())).collect();
    Report { value: raw.trusted(), mended }
}

/// The surface as a scene of one glossy material.
pub fn scene(molecule: &Molecule, name: String, options: &Options) -> Report<Scene> {
    of(molecule, options).map(|mesh| {
        let mut raw = mesh.into_raw();
        let triangles = 0..raw.triangles.len() as u32;
        raw.parts = vec![Part { name: "surface".into(), triangles, material: Some(0) }];
        let material =
            Material { name: "molecule".into(), base_color: [1.0; 4], roughness: 0.38, ..Material::default() };
        Scene { materials: vec![material], ..Scene::of(name, raw.trusted()) }
    })
}

/// The atoms of a surface.
struct Sum {
    /// Place, radius, index in the molecule.
    atoms: Vec<(DVec3, f32, u32)>,
    cells: Cells,
}

impl Sum {
    fn of(molecule: &Molecule, mended: &mut Vec<Mended>) -> Self {
        let n_water = molecule.atoms.iter().filter(|a| a.is_water()).count();
        let has_more = n_water < molecule.atoms.len();
        let has_radii = molecule.atoms.iter().any(|a| a.radius > 0.0);
        let mut atoms = Vec::new();
        for (i, a) in molecule.atoms.iter().enumerate().filter(|(_, a)| !(has_more && a.is_water())) {
            let radius = if has_radii { a.radius } else { elements::van_der_waals(a.element) };
            if radius > 0.0 {
                atoms.push((a.position, radius.clamp(0.2, 10.0), i as u32));
            }
        }
        note(mended, if has_more { n_water } else { 0 }, "atoms of water left out of the surface");
        let widest = atoms.iter().map(|a| a.1).fold(0.0, f32::max) as f64;
        let cells = Cells::of(atoms.iter().map(|a| a.0), REACH * widest);
        Self { atoms, cells }
    }

    /// The sum on a grid that holds all of it; none without atoms.
    fn grid(&self, options: &Options) -> Option<Grid> {
        let low = self.atoms.iter().fold(DVec3::INFINITY, |l, a| l.min(a.0 - REACH * a.1 as f64));
        let high = self.atoms.iter().fold(DVec3::NEG_INFINITY, |h, a| h.max(a.0 + REACH * a.1 as f64));
        if self.atoms.is_empty() {
            return None;
        }
        let extent = high - low;
        let volume = extent.x * extent.y * extent.z;
        let added = self.atoms.iter().map(|a| (2.0 * REACH * a.1 as f64).powi(3)).sum::<f64>();
        let suits = (volume / (1 << 21) as f64).cbrt().clamp(0.1, 0.6);
        let wanted = options.spacing.filter(|s| *s > 0.0).unwrap_or(suits);
        let mut spacing = wanted.max((volume / MOST_POINTS).cbrt()).max((added / MOST_ADDED).cbrt());
        let counts = |spacing: f64| extent.to_array().map(|e| (e / spacing).ceil() as usize + 1);
        while counts(spacing).iter().map(|n| *n as f64).product::<f64>() > MOST_POINTS {
            spacing *= 1.05;
        }
        let size = counts(spacing);
        let mut values = vec![0f32; size[0] * size[1] * size[2]];
        for &(center, radius, _) in &self.atoms {
            let reach = REACH * radius as f64;
            let [x, y, z] = [0, 1, 2].map(|a| {
                let at = |d: f64| ((center[a] + d - low[a]) / spacing).max(0.0);
                at(-reach).ceil() as usize..(at(reach).floor() as usize + 1).min(size[a])
            });
            let gap = |i: usize, axis: usize| (low[axis] + i as f64 * spacing - center[axis]) as f32;
            for k in z {
                for j in y.clone() {
                    let across = gap(j, 1) * gap(j, 1) + gap(k, 2) * gap(k, 2);
                    let row = (k * size[1] + j) * size[0];
                    for i in x.clone() {
                        let value = &mut values[row + i];
                        *value += share(gap(i, 0) * gap(i, 0) + across, radius);
                    }
                }
            }
        }
        let axes = [DVec3::X * spacing, DVec3::Y * spacing, DVec3::Z * spacing];
        let lattice = Lattice { size: size.map(|n| n as u32), origin: low, axes };
        Grid::new(lattice, values).ok()
    }

    /// Calls `visit(index in the molecule, share)` for each atom that counts at a place.
    fn near(&self, p: DVec3, mut visit: impl FnMut(u32, f32)) {
        self.cells.near(p, |i| {
            let (center, radius, atom) = self.atoms[i as usize];
            let share = share(p.distance_squared(center) as f32, radius);
            if share > 0.0 {
                visit(atom, share);
            }
        });
    }

    /// The sum and its gradient.
    fn at(&self, p: DVec3) -> (f64, DVec3) {
        let (mut sum, mut slope) = (0.0, DVec3::ZERO);
        self.cells.near(p, |i| {
            let (center, radius, _) = self.atoms[i as usize];
            let d = p - center;
            let share = share(d.length_squared() as f32, radius);
            if share > 0.0 {
                sum += share as f64;
                let whole = (share * (1.0 - OFFSET) + OFFSET) / (1.0 - OFFSET);
                slope -= d * (2.0 * STEEPNESS * whole / (radius * radius)) as f64;
            }
        });
        (sum, slope)
    }

    /// Moves a place near the surface onto it by Newton's steps along the gradient, none longer than a quarter of the
    /// grid's; with the gradient there.
    fn onto(&self, mut p: DVec3, step: f64) -> (DVec3, DVec3) {
        for _ in 0..2 {
            let (sum, slope) = self.at(p);
            let squared = slope.length_squared();
            if squared > 1e-12 {
                p += (slope * ((1.0 - sum) / squared)).clamp_length_max(0.25 * step);
            }
        }
        (p, self.at(p).1)
    }

    /// Mixed from the atoms' colours, the nearest one's outweighing all others but along its border.
    fn color(&self, molecule: &Molecule, p: DVec3) -> Vec4 {
        let mut sum = Vec4::ZERO;
        self.near(p, |atom, share| {
            let [r, g, b] = elements::color(molecule.atoms[atom as usize].element);
            let weight = share * share * share;
            sum += vec4(r, g, b, 1.0) * (weight * weight);
        });
        if sum.w > 0.0 { sum / sum.w } else { Vec4::ONE }
    }

    fn fields(&self, molecule: &Molecule, places: &[DVec3], mended: &mut Vec<Mended>) -> Vec<Field> {
        let atoms = &molecule.atoms;
        let field = |name: &str, unit: &str, values: Vec<f32>| Field {
            name: name.into(),
            unit: unit.into(),
            element: Element::Vertex,
            n_components: 1,
            values: Values::F32(values),
        };
        // The atom that counts most, and the mean of what the atoms know.
        let mut nearest = Vec::with_capacity(places.len());
        let mut b_factor = Vec::with_capacity(places.len());
        for p in places {
            let (mut best, mut most, mut sum, mut weights) = (0, 0.0, 0.0, 0.0);
            self.near(*p, |atom, share| {
                if share > most {
                    (best, most) = (atom, share);
                }
                let b = atoms[atom as usize].b_factor;
                if !b.is_nan() {
                    (sum, weights) = (sum + b * share, weights + share);
                }
            });
            nearest.push(best);
            b_factor.push(if weights > 0.0 { sum / weights } else { f32::NAN });
        }
        let of_nearest = |f: &dyn Fn(u32) -> f32| nearest.iter().map(|a| f(*a)).collect::<Vec<_>>();
        let mut fields = vec![
            field("element", "", of_nearest(&|a| atoms[a as usize].element as f32)),
            field("atom", "", of_nearest(&|a| a as f32)),
        ];
        if atoms.iter().any(|a| a.b_factor != 0.0 && !a.b_factor.is_nan()) {
            fields.push(field("b_factor", "Å²", b_factor));
        }
        let is_charged = atoms.iter().any(|a| a.charge.is_some_and(|q| q != 0.0));
        if is_charged {
            fields.push(field("charge", "e", of_nearest(&|a| atoms[a as usize].charge.unwrap_or(f32::NAN))));
        }
        if is_charged && atoms.iter().all(|a| a.charge.is_some()) {
            if atoms.len().saturating_mul(places.len()) <= MOST_PAIRS {
                fields.push(field("potential", "V", places.iter().map(|p| potential(molecule, *p)).collect()));
            } else {
                note(mended, 1, "field potential left out, as there are too many charges");
            }
        }
        fields.push(field("lipophilicity", "log P", lipophilic_potential(molecule, places)));
        fields
    }
}

/// What an atom adds to the sum at a squared distance: 1 at its radius, nothing from `REACH` radii on.
#[inline(always)]
fn share(squared: f32, radius: f32) -> f32 {
    let ratio = squared / (radius * radius);
    let share = (exp2(STEEPNESS * std::f32::consts::LOG2_E * (1.0 - ratio)) - OFFSET) / (1.0 - OFFSET);
    if share > 0.0 { share } else { 0.0 }
}

/// The Coulomb sum at a place, volts.
pub fn potential(molecule: &Molecule, p: DVec3) -> f32 {
    let mut sum = 0.0;
    for a in &molecule.atoms {
        // Inside of an atom's core there is nothing to see; this keeps the sum finite.
        sum += a.charge.unwrap_or(0.0) as f64 / p.distance(a.position).max(0.1);
    }
    (sum * VOLT_ANGSTROMS) as f32
}

/// The mean of the atoms' contributions to log P at each place, by [`lipophilicity::weight`].
fn lipophilic_potential(molecule: &Molecule, places: &[DVec3]) -> Vec<f32> {
    let contributions = lipophilicity::contributions(molecule);
    let cells = Cells::of(molecule.atoms.iter().map(|a| a.position), lipophilicity::REACH);
    let at = |p: &DVec3| {
        let (mut sum, mut weights) = (0.0, 0.0);
        cells.near(*p, |i| {
            let squared = p.distance_squared(molecule.atoms[i as usize].position);
            if squared < lipophilicity::REACH * lipophilicity::REACH {
                let weight = lipophilicity::weight(squared.sqrt() as f32);
                sum += weight * contributions[i as usize];
                weights += weight;
            }
        });
        if weights > 0.0 { sum / weights } else { f32::NAN }
    };
    places.iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::{Atom, Topology};

    fn molecule(atoms: &[(u8, DVec3)]) -> Molecule {
        let mut molecule =
            Molecule { atoms: atoms.iter().map(|(e, p)| Atom::new(*e, *p)).collect(), bonds: Vec::new() };
        molecule.bond_by_distance();
        molecule
    }

    fn values<'a>(mesh: &'a Mesh, name: &str) -> Option<&'a [f32]> {
        match &mesh.fields().iter().find(|f| f.name == name)?.values {
            Values::F32(v) => Some(v),
            Values::F64(_) => None,
        }
    }

    #[test]
    fn one_atom_is_a_sphere_of_its_radius() {
        let mesh = of(&molecule(&[(8, DVec3::new(3.0, 4.0, 5.0))]), &Options { spacing: Some(0.4) }).value;
        assert!(Topology::of(&mesh).is_solid());
        for (p, n) in mesh.positions().iter().zip(mesh.normals()) {
            let d = p.as_dvec3() - DVec3::new(3.0, 4.0, 5.0);
            assert!((d.length() - 1.52).abs() < 1e-3 && d.normalize().dot(n.as_dvec3()) > 0.9999, "{p}");
        }
        assert!(values(&mesh, "element").unwrap().iter().all(|e| *e == 8.0) && values(&mesh, "potential").is_none());
        let share_at_end = share((REACH * 1.52).powi(2) as f32, 1.52);
        assert!(share_at_end < 1e-4 && (share(1.52 * 1.52, 1.52) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_pair_of_charges_has_its_potential() {
        let mut pair = molecule(&[(9, DVec3::ZERO), (1, DVec3::X * 0.92)]);
        (pair.atoms[0].charge, pair.atoms[1].charge) = (Some(-0.5), Some(0.5));
        (pair.atoms[0].b_factor, pair.atoms[1].b_factor) = (10.0, 30.0);
        let mesh = of(&pair, &Options::default()).value;
        let topology = Topology::of(&mesh);
        assert!(topology.is_solid() && topology.n_pieces == 1);
        let (potential, b) = (values(&mesh, "potential").unwrap(), values(&mesh, "b_factor").unwrap());
        for (i, p) in mesh.positions().iter().enumerate() {
            let truth = 7.2 * (1.0 / p.distance(crate::math::Vec3::X * 0.92) - 1.0 / p.length());
            assert!((potential[i] - truth).abs() < 1e-2 && (10.0..=30.0).contains(&b[i]));
        }
        let atom = values(&mesh, "atom").unwrap();
        assert!(atom.contains(&0.0) && atom.contains(&1.0));
    }

    #[test]
    fn hostile_molecules_cost_little() {
        let crowd: Vec<_> = (0..3000).map(|_| (6, DVec3::ONE)).collect();
        assert!(Topology::of(&of(&molecule(&crowd), &Options { spacing: Some(0.5) }).value).n_triangles > 0);
        let far = molecule(&[(6, DVec3::ZERO), (6, DVec3::splat(1e6))]);
        let mesh = of(&far, &Options { spacing: Some(1e-9) }).value;
        assert!(mesh.positions().iter().all(|p| p.is_finite()));
        assert!(of(&Molecule::default(), &Options::default()).value.triangles().is_empty());
    }
}
