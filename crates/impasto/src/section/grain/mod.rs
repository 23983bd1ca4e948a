//! Grain: a solid texture of particles. What does a cut show at a point?
//!
//! The model is filled with particles on a perturbed lattice. A cut shows them in one of three ways: torn, they stay whole
//! and go with the half that holds their centre; liquid, they leave hollows on both halves; hard, they show flat discs on
//! both, and what is around them is recessed. After Li 2022 with the slips of the paper repaired ([`Profile::Fixed`]) or
//! kept ([`Profile::Paper`]); all three are height fields over the section, so one function answers: [`Grain::eval`].
//!
//! Inside, lengths are in spacings and directions along the lattice's axes. A point is an integer cell and an offset from
//! its node, so that nothing is lost far from the origin.

mod bands;
mod block;
mod blocks;
mod bodies;
mod cell_slices;
mod cells;
mod chambers;
mod chance;
mod check;
#[cfg(test)]
mod conformance_tests;
pub mod curve;
mod discs;
#[cfg(test)]
mod discs_tests;
mod disc_kernel;
mod druse;
mod ellipsoid;
mod eval;
mod far;
mod fibres;
pub mod figures;
mod filling;
mod letter;
mod mottle;
mod openness;
mod outline;
mod outlines;
#[cfg(test)]
mod outlines_tests;
mod particle;
mod question;
mod rings;
mod rod;
mod scales;
mod shape;
mod soft;
mod sections;
#[cfg(test)]
mod sections_tests;
mod slices;
mod spec;
mod superquadric;
mod trabeculae;
#[cfg(test)]
mod filling_tests;
#[cfg(test)]
mod shape_tests;
#[cfg(test)]
mod solids_tests;
#[cfg(test)]
mod tests;

pub use bands::{Bands, BandsSpec};
pub use cells::{Cells, CellsSpec, Nucleus};
pub use chambers::{Chambers, ChambersSpec, Rooms, Wedges};
pub use disc_kernel::Hits;
pub use discs::{Disc, Discs, Window};
pub use druse::{Druse, DruseSpec};
pub use eval::{Candidate, Hit, HitKind, Look, SectionKind, Side};
pub use far::{Far, Filtered, Footprint, fade, filtered};
pub use fibres::{Fibres, FibresSpec};
pub use filling::{Filling, Layer};
pub use mottle::{Mottle, Mottled, Pattern, Waves, Wavy};
pub use openness::with_interreflection;
pub use outlines::{Outline, outlines};
pub use rings::{Knots, Pores, Rings, RingsSpec};
pub use scales::{Mixing, Scales, Size};
pub use sections::Sections;
pub use spec::{Axis, Chance, Contact, Ends, GrainSpec, LatticeAxes, Polyhedron, Profile, Shape};
pub use trabeculae::{Field, Skeleton, Trabeculae, TrabeculaeSpec};

use crate::Result;
use crate::math::{DMat3, DVec3, Vec3};
use chance::Source;
use particle::Recipe;

/// A grain that has been checked, ready to be asked.
#[derive(Clone, Debug)]
pub struct Grain {
    spec: GrainSpec,
    source: Source,
    /// A rotation: the model's directions from the lattice's.
    model_from_lattice: DMat3,
    recipe: Recipe,
    /// No particle reaches farther from its centre, spacings.
    reach: f32,
    /// Rings of cells around a point that may hold a particle with this point inside.
    n_rings: i32,
    /// The same for a solid cut, where a bevel lies around each particle.
    n_rings_solid: i32,
    /// Rings of cells whose particles may touch.
    n_rings_contact: i32,
}

/// A point as the lattice sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The nearest node.
    pub cell: [i32; 3],
    /// From this node to the point, spacings, each in [-0.5, 0.5].
    pub local: Vec3,
}

/// Rounding must not make particles touch that a rule keeps apart.
const MARGIN: f32 = 2e-6;

impl Grain {
    /// A grain from its description.
    ///
    /// # Errors
    /// A number that makes no sense, one line for each kind.
    pub fn new(spec: GrainSpec) -> Result<Self> {
        check::check(&spec)?;
        let model_from_lattice = lattice_rotation(spec.lattice);
        let recipe = Recipe::of(&spec, model_from_lattice);
        let reach = recipe.reach();
        let rings = |extent: f32| ((extent + spec.jitter - 0.5).ceil() as i32).max(0);
        let (n_rings, n_rings_solid) = match spec.profile {
            // The paper always looks at 27 cells.
            Profile::Paper => (1, 1),
            Profile::Fixed => (rings(reach), rings(reach + spec.bevel)),
        };
        let n_rings_contact = match spec.contact {
            Contact::Apart { .. } => ((2.0 * reach + 2.0 * spec.jitter - 1.0).ceil() as i32).max(1),
            Contact::Overlapping => 0,
        };
        let source = Source { chance: spec.chance, seed: spec.seed };
        Ok(Self { spec, source, model_from_lattice, recipe, reach, n_rings, n_rings_solid, n_rings_contact })
    }

    /// The description it was made from.
    pub fn spec(&self) -> &GrainSpec {
        &self.spec
    }

    /// The farthest that any particle's surface is from its centre, model units. Where particles do not overlap, no relief
    /// is higher or deeper than twice this.
    pub fn reach(&self) -> f32 {
        self.reach * self.spec.spacing
    }

    /// Where a point of the model lies on the lattice; points beyond 2 billion cells count as at the border.
    pub fn place(&self, p: DVec3) -> Place {
        let q = self.model_from_lattice.transpose() * p / self.spec.spacing as f64;
        let (cell, local) = place_of(q);
        Place { cell, local }
    }

    /// The model's point of a place on the lattice, `offset` from a cell's node.
    fn model_point(&self, cell: [i32; 3], offset: Vec3) -> DVec3 {
        let node = DVec3::new(cell[0] as f64, cell[1] as f64, cell[2] as f64);
        self.model_from_lattice * ((node + offset.as_dvec3()) * self.spec.spacing as f64)
    }

    fn to_lattice(&self, direction: DVec3) -> Vec3 {
        (self.model_from_lattice.transpose() * direction).as_vec3()
    }

    fn to_model(&self, direction: Vec3) -> Vec3 {
        (self.model_from_lattice * direction.as_dvec3()).as_vec3()
    }
}

/// The nearest node of the integer lattice, and the way from it.
fn place_of(q: DVec3) -> ([i32; 3], Vec3) {
    let node = (q + DVec3::splat(0.5)).floor();
    ([node.x as i32, node.y as i32, node.z as i32], (q - node).as_vec3())
}

/// The model's directions from a lattice's.
pub(in crate::section) fn lattice_rotation(axes: LatticeAxes) -> DMat3 {
    match axes {
        LatticeAxes::Model => DMat3::IDENTITY,
        LatticeAxes::Turned => turned(),
    }
}

/// A rotation by the unit quaternion along (1, sqrt 2, sqrt 3, sqrt 5): none of its rows has a rational direction.
fn turned() -> DMat3 {
    let s = 1.0 / 11f64.sqrt();
    let (w, x, y, z) = (s, 2f64.sqrt() * s, 3f64.sqrt() * s, 5f64.sqrt() * s);
    DMat3::from_cols(
        DVec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        DVec3::new(2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        DVec3::new(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
}

impl Place {
    /// The place a little farther; both name the same points.
    fn moved(self, by: Vec3) -> Self {
        let to = self.local + by;
        let step = (to + Vec3::splat(0.5)).floor();
        let cell = [0, 1, 2].map(|k| self.cell[k].wrapping_add(step[k] as i32));
        Self { cell, local: to - step }
    }
}
