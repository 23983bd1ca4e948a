//! What a person says about a grain, in model units.

use crate::math::{Vec3, Vec4};
use crate::{Error, Result};
use std::sync::Arc;

/// A particle's shape before it is perturbed. Lengths in model units.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A ball.
    Sphere {
        /// Its radius.
        radius: f32,
    },
    /// A ball stretched along three axes; the third is the grain's axis.
    Ellipsoid {
        /// Half lengths.
        radii: Vec3,
    },
    /// A round bar with flat ends, along the grain's axis.
    Cylinder {
        /// Its radius.
        radius: f32,
        /// From end to end.
        height: f32,
        /// How its ends look.
        ends: Ends,
    },
    /// A round bar with half balls on its ends.
    Capsule {
        /// Its radius.
        radius: f32,
        /// From end to end, the half balls included.
        height: f32,
    },
    /// A box; its third edge is along the grain's axis.
    Box {
        /// Edge lengths.
        edges: Vec3,
        /// Radius of the rounded edges; 0 is sharp.
        rounding: f32,
    },
    /// A convex polyhedron around its centre.
    Polyhedron(Polyhedron),
    /// Between octahedron (1), ellipsoid (2) and box.
    Superquadric {
        /// Half lengths.
        radii: Vec3,
        /// The exponent, 1.1 to 32.
        power: f32,
    },
}

/// The ends of a cylinder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Ends {
    /// Flat: a tear across the axis shows nothing of the particle.
    Flat,
    /// Flat, but shaded as domes: how the paper's equation (16) reads.
    Domed,
    /// Flat with a rounded rim, of this part of the radius.
    Rounded(f32),
    /// Rounded by 0.15 of the radius.
    #[default]
    Soft,
}

/// A convex polyhedron: the points below all of its faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    /// Unit normals and distances from the centre, model units.
    pub(in crate::section) faces: Arc<[Vec4]>,
    /// Corners.
    pub(in crate::section) corners: Arc<[Vec3]>,
}

impl Polyhedron {
    /// From the faces' normals (any length) and their distances from the centre.
    ///
    /// # Errors
    /// More than 64 faces; faces that leave it open; a centre that is not inside.
    pub fn new(faces: &[(Vec3, f32)]) -> Result<Self> {
        let fault = |why: &str| parameter("polyhedron", format!("{} faces", faces.len()), why);
        if faces.len() > 64 {
            return Err(fault("at most 64 faces"));
        }
        let unit = |(n, d): &(Vec3, f32)| {
            let n = n.as_dvec3();
            let length = n.length();
            (length > 0.0 && length.is_finite() && *d > 0.0 && d.is_finite())
                .then(|| (n / length).extend(*d as f64))
                .ok_or_else(|| fault("every face needs a normal and a distance above zero"))
        };
        let planes = faces.iter().map(unit).collect::<Result<Vec<_>>>()?;
        let size = planes.iter().map(|f| f.w).fold(0.0, f64::max);
        let mut corners = Vec::new();
        // Every three faces meet in a point; those below all others are corners.
        for (i, a) in planes.iter().enumerate() {
            for (j, b) in planes.iter().enumerate().skip(i + 1) {
                for c in &planes[j + 1..] {
                    let (na, nb, nc) = (a.truncate(), b.truncate(), c.truncate());
                    let volume = na.dot(nb.cross(nc));
                    if volume.abs() < 1e-9 {
                        continue;
                    }
                    let p = (nb.cross(nc) * a.w + nc.cross(na) * b.w + na.cross(nb) * c.w) / volume;
                    if planes.iter().all(|f| f.truncate().dot(p) <= f.w + 1e-6 * size) {
                        corners.push(p);
                    }
                }
            }
        }
        // Closed if the corners see no direction in which nothing ends: enough that every axis is bounded well.
        let is_open = corners.len() < 4 || corners.iter().any(|p| p.length() > 100.0 * size);
        let spans = |n: crate::math::DVec3| corners.iter().any(|p| p.dot(n) > 1e-6 * size);
        if is_open || !planes.iter().all(|f| spans(-f.truncate())) {
            return Err(fault("its faces do not close it"));
        }
        Ok(Self {
            faces: planes.iter().map(|f| f.as_vec4()).collect(),
            corners: corners.iter().map(|p| p.as_vec3()).collect(),
        })
    }

    /// Distance of the nearest face from the centre.
    pub fn inradius(&self) -> f32 {
        self.faces.iter().map(|f| f.w).fold(f32::INFINITY, f32::min)
    }

    /// A regular one with 4, 6, 8, 12 or 20 faces at a distance from its centre.
    pub fn regular(n_faces: u32, inradius: f32) -> Result<Self> {
        let golden = (1.0 + 5f32.sqrt()) * 0.5;
        let mut normals = Vec::new();
        let signs = [-1.0f32, 1.0];
        match n_faces {
            4 => normals.extend([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]),
            6 => (0..3).for_each(|k| {
                normals.extend(signs.map(|s| std::array::from_fn(|i| if i == k { s } else { 0.0 })));
            }),
            8 | 20 => {
                for i in 0..8 {
                    normals.push(std::array::from_fn(|k| signs[i >> k & 1]));
                }
            }
            12 => {}
            _ => return Err(parameter("polyhedron", n_faces.to_string(), "4, 6, 8, 12 or 20 faces")),
        }
        // Twelve faces lie at an icosahedron's corners; twenty at a dodecahedron's: a cube's and these.
        if n_faces == 12 || n_faces == 20 {
            let (short, long) = if n_faces == 12 { (1.0, golden) } else { (1.0 / golden, golden) };
            for (a, b) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0f32)] {
                let (s, l) = (a * short, b * long);
                normals.extend([[0.0, s, l], [s, l, 0.0], [l, 0.0, s]]);
            }
        }
        Self::new(&normals.iter().map(|n| (Vec3::from_array(*n), inradius)).collect::<Vec<_>>())
    }
}

/// Where particles' axes point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Axis {
    /// All along one direction.
    Along(Vec3),
    /// One direction with a random vector of up to this length (1 is as long as the direction) added: how Fig. 12 reads.
    Perturbed(Vec3, f32),
    /// Evenly within a cone of this half angle, radians.
    Cone(Vec3, f32),
    /// Evenly in all directions.
    Isotropic,
    /// Away from a point, as in a citrus fruit; the vesicles lie across with a negative one.
    Radial(Vec3),
}

/// Where the perturbations come from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Chance {
    /// A hash of the cell: neighbours are independent, nothing repeats.
    #[default]
    Hash,
    /// The paper's texture: 256 x 256 x 256 texels, four channels of classic Perlin noise, `frequency` lattice units a
    /// texel (not an integer: there the noise is zero). Radius and height share a channel, and it repeats.
    Noise {
        /// Lattice units a texel; 0.37 by default, lower moves whole regions alike.
        frequency: f32,
    },
}

/// How the lattice lies in the model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LatticeAxes {
    /// Turned by a fixed rotation without a rational direction: no section runs along its layers.
    #[default]
    Turned,
    /// Along the model's axes, as in the paper: sections along an axis show bands.
    Model,
}

/// What happens where particles would overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contact {
    /// They shrink until a plane parts each two, by a rule that looks at their neighbours only. They may grow by this
    /// factor first (1: only shrink).
    Apart {
        /// At most this times the wanted size.
        grow: f32,
    },
    /// They overlap, as in the paper.
    Overlapping,
}

/// Whose formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// Ours: with the paper's slips repaired.
    #[default]
    Fixed,
    /// Li's, to the letter. Spheres and cylinders only.
    Paper,
}

/// A grain as a person describes it; [`Grain::new`](super::Grain::new) checks it.
#[derive(Clone, Debug, PartialEq)]
pub struct GrainSpec {
    /// Between neighbouring nodes of the lattice, model units.
    pub spacing: f32,
    /// What stands at each node.
    pub shape: Shape,
    /// How particles are turned, model space. Spheres do not mind.
    pub axis: Axis,
    /// How far centres move off the nodes along each axis, in spacings: 0 to 0.5.
    pub jitter: f32,
    /// How much sizes differ: 0.35 is between 65 % and 135 %.
    pub size_spread: f32,
    /// The same for the heights of cylinders and capsules, independently of their radii.
    pub height_spread: f32,
    /// Sizes only shrink, from 100 % down to 1 - spread.
    pub shrink_only: bool,
    /// What all this draws from.
    pub chance: Chance,
    /// How the lattice lies.
    pub lattice: LatticeAxes,
    /// Whether particles may overlap.
    pub contact: Contact,
    /// Depth and width of a solid cut's bevel, in spacings (the paper's t is 0.07).
    pub bevel: f32,
    /// The bevel is at most half as wide as a particle's radius.
    pub bevel_within_particle: bool,
    /// Whose formulas.
    pub profile: Profile,
    /// Another seed, another grain.
    pub seed: u32,
}

impl GrainSpec {
    /// Of a shape with the usual irregularity.
    pub fn of(shape: Shape, spacing: f32) -> Self {
        Self {
            spacing,
            shape,
            axis: Axis::Isotropic,
            jitter: 0.25,
            size_spread: 0.35,
            height_spread: 0.2,
            shrink_only: false,
            chance: Chance::Hash,
            lattice: LatticeAxes::Turned,
            contact: Contact::Apart { grow: 1.0 },
            bevel: 0.07,
            bevel_within_particle: false,
            profile: Profile::Fixed,
            seed: 0,
        }
    }

    /// Balls.
    pub fn spheres(spacing: f32, radius: f32) -> Self {
        Self::of(Shape::Sphere { radius }, spacing)
    }

    /// Cylinders along an axis, ends softly rounded.
    pub fn cylinders(spacing: f32, radius: f32, height: f32, axis: Vec3) -> Self {
        let shape = Shape::Cylinder { radius, height, ends: Ends::Soft };
        Self { axis: Axis::Along(axis), jitter: 0.15, ..Self::of(shape, spacing) }
    }

    /// The same as Li 2022 has it, slips included: noise texture, upright lattice, overlapping particles, ends shaded
    /// as domes.
    pub fn to_the_letter(mut self) -> Self {
        if let Shape::Cylinder { ends, .. } = &mut self.shape {
            *ends = Ends::Domed;
        }
        Self {
            chance: Chance::Noise { frequency: 0.37 },
            lattice: LatticeAxes::Model,
            contact: Contact::Overlapping,
            profile: Profile::Paper,
            ..self
        }
    }
}

pub(super) fn parameter(what: &str, given: impl ToString, why: &str) -> Error {
    Error::Parameter { what: what.into(), given: given.to_string(), why: why.into() }
}
