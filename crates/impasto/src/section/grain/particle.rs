//! The particle of a cell: where its centre is, how it is turned, how large it may be.
//!
//! Non-overlap is a pure function of the cell: each particle shrinks until, for each neighbour, the two support functions
//! along the line of centres fit between them. Then a plane parts them, whatever their shapes.

use super::block::{Block, Facets};
use super::ellipsoid::{Ball, Ellipsoid};
use super::rod::{Capsule, Rod};
use super::shape::{Body, Convex};
use super::spec::{Axis, Contact, Ends, GrainSpec, Shape};
use super::superquadric::Superquadric;
use super::{Grain, MARGIN};
use crate::math::{DMat3, DVec3, Frame, Mat3, Vec3, Vec4, exact, sin_cos, vec3};

/// A shape in spacings, and how its copies differ.
#[derive(Clone, Debug)]
pub(super) struct Recipe {
    shape: Local,
    axis: Turning,
    /// (least, most) factor of the radius, and of the height.
    size: [f32; 2],
    height: [f32; 2],
    /// No factor makes the radius greater than this, spacings.
    max_radius: f32,
    reach: f32,
}

/// [`Shape`] in spacings.
#[derive(Clone, Debug)]
enum Local {
    Ball(f32),
    Ellipsoid(Vec3),
    Rod { radius: f32, half: f32, rounding: f32, domed: bool },
    Capsule { radius: f32, half: f32 },
    Block { half: Vec3, rounding: f32 },
    Facets { faces: Vec<Vec4>, corners: Vec<Vec3>, reach: f32 },
    Superquadric { semi: Vec3, power: f32 },
}

/// [`Axis`] along the lattice's axes.
#[derive(Clone, Copy, Debug)]
enum Turning {
    Along(Vec3),
    Perturbed(Vec3, f32),
    /// Direction and cosine of the half angle.
    Cone(Vec3, f32),
    /// From this point of the lattice.
    Radial(DVec3),
}

impl Recipe {
    pub(super) fn of(spec: &GrainSpec, model_from_lattice: DMat3) -> Self {
        let per_spacing = 1.0 / spec.spacing;
        let shape = match &spec.shape {
            Shape::Sphere { radius } => Local::Ball(radius * per_spacing),
            Shape::Ellipsoid { radii } => Local::Ellipsoid(*radii * per_spacing),
            Shape::Cylinder { radius, height, ends } => {
                let part = match ends {
                    Ends::Flat | Ends::Domed => 0.0,
                    Ends::Rounded(e) => *e,
                    Ends::Soft => 0.15,
                };
                Local::Rod {
                    radius: radius * per_spacing,
                    half: height * 0.5 * per_spacing,
                    rounding: part,
                    domed: *ends == Ends::Domed,
                }
            }
            Shape::Capsule { radius, height } => {
                Local::Capsule { radius: radius * per_spacing, half: (height * 0.5 - radius) * per_spacing }
            }
            Shape::Box { edges, rounding } => {
                Local::Block { half: *edges * (0.5 * per_spacing), rounding: rounding * per_spacing }
            }
            Shape::Polyhedron(p) => {
                let corners: Vec<Vec3> = p.corners.iter().map(|&c| c * per_spacing).collect();
                let reach = corners.iter().map(|c| c.length()).fold(0.0, f32::max);
                let faces = p.faces.iter().map(|f| f.truncate().extend(f.w * per_spacing)).collect();
                Local::Facets { faces, corners, reach }
            }
            Shape::Superquadric { radii, power } => Local::Superquadric { semi: *radii * per_spacing, power: *power },
        };
        let unit = |v: Vec3| (model_from_lattice.transpose() * v.as_dvec3().normalize()).as_vec3().normalize();
        let axis = match spec.axis {
            Axis::Along(v) => Turning::Along(unit(v)),
            Axis::Perturbed(v, amount) => Turning::Perturbed(unit(v), amount),
            Axis::Cone(v, angle) => Turning::Cone(unit(v), exact::cos(angle as f64) as f32),
            Axis::Isotropic => Turning::Cone(Vec3::Z, -1.0),
            Axis::Radial(c) => Turning::Radial(model_from_lattice.transpose() * c.as_dvec3() / spec.spacing as f64),
        };
        let range = |spread: f32| [1.0 - spread, if spec.shrink_only { 1.0 } else { 1.0 + spread }];
        let mut recipe = Self {
            shape,
            axis,
            size: range(spec.size_spread),
            height: range(spec.height_spread),
            max_radius: f32::INFINITY,
            reach: 0.0,
        };
        // "The perturbation of the radius never exceeds half the spacing": the radius does not, as far as it can be helped.
        if let Local::Ball(radius) | Local::Rod { radius, .. } = recipe.shape {
            recipe.max_radius = radius.max(0.5);
        }
        let grow = match spec.contact {
            Contact::Apart { grow } => grow,
            Contact::Overlapping => 1.0,
        };
        recipe.reach = recipe.largest().reach() * grow * 1.000_001;
        recipe
    }

    /// No particle reaches farther from its centre, spacings.
    pub(super) fn reach(&self) -> f32 {
        self.reach
    }

    fn largest(&self) -> Body<'_> {
        self.body(self.size[1], self.height[1], Mat3::IDENTITY)
    }

    /// The shape with its radii and its height multiplied, in a frame.
    fn body(&self, size: f32, height: f32, frame: Mat3) -> Body<'_> {
        let radius_of = |radius: f32| (radius * size).min(self.max_radius);
        match &self.shape {
            Local::Ball(radius) => Body::Ball(Ball { radius: radius_of(*radius) }),
            Local::Ellipsoid(semi) => Body::Ellipsoid(Ellipsoid { frame, semi: *semi * size }),
            Local::Rod { radius, half, rounding, domed } => {
                let (radius, half) = (radius_of(*radius), half * height);
                let rounding = (rounding * radius).min(half);
                Body::Rod(Rod { axis: frame.z_axis, radius, half, rounding, domed: *domed })
            }
            Local::Capsule { radius, half } => {
                Body::Capsule(Capsule { axis: frame.z_axis, radius: radius * size, half: half * height })
            }
            Local::Block { half, rounding } => {
                Body::Block(Block { frame, half: *half * size, rounding: rounding * size })
            }
            Local::Facets { faces, corners, reach } => {
                Body::Facets(Facets { frame, scale: size, faces, corners, reach: *reach })
            }
            Local::Superquadric { semi, power } => {
                Body::Superquadric(Superquadric { frame, semi: *semi * size, power: *power })
            }
        }
    }

    /// Whether all directions are alike, so that no frame is needed.
    fn is_round(&self) -> bool {
        matches!(self.shape, Local::Ball(_))
    }

    fn has_roll(&self) -> bool {
        !matches!(self.shape, Local::Ball(_) | Local::Rod { .. } | Local::Capsule { .. })
    }
}

impl Grain {
    /// From a cell's node to its particle's centre.
    pub(super) fn offset(&self, cell: [i32; 3]) -> Vec3 {
        self.source.center(cell) * self.spec.jitter
    }

    /// The particle of a cell as it would be alone.
    pub(super) fn free_body(&self, cell: [i32; 3]) -> Body<'_> {
        let recipe = &self.recipe;
        let drawn = self.source.sizes(cell);
        let factor = |[low, high]: [f32; 2], x: f32| low + (high - low) * (0.5 + 0.5 * x);
        let frame = if recipe.is_round() { Mat3::IDENTITY } else { self.frame(cell) };
        recipe.body(factor(recipe.size, drawn[0]), factor(recipe.height, drawn[1]), frame)
    }

    /// How much the particle of a cell shrinks (or grows) for its neighbours' sake.
    ///
    /// The weighted split of Li's future work: s_i = min(s_max, min_j L_ij / (h_i(n_ij) + h_j(-n_ij))).
    pub(super) fn scale(&self, cell: [i32; 3], offset: Vec3, body: &Body) -> f32 {
        let Contact::Apart { grow } = self.spec.contact else { return 1.0 };
        let mut scale = grow;
        let rings = self.n_rings_contact;
        // A neighbour farther than both can reach cannot matter.
        let far = grow * body.reach() + self.reach;
        let margin = if matches!(body, Body::Superquadric(_)) { 2e-4 } else { MARGIN };
        for_cells(rings, |step| {
            if step == [0; 3] {
                return;
            }
            let other = add(cell, step);
            let to = vec3(step[0] as f32, step[1] as f32, step[2] as f32) + (self.offset(other) - offset);
            let squared = to.dot(to);
            if squared >= far * far {
                return;
            }
            let length = squared.sqrt();
            if length <= 0.0 {
                scale = 0.0;
                return;
            }
            let n = to / length;
            let neighbour = self.free_body(other);
            let room = length / (body.support(n).dot(n) - neighbour.support(-n).dot(n));
            scale = scale.min(room);
        });
        (scale * (1.0 - margin)).max(0.0)
    }

    /// A frame whose third axis is the particle's.
    fn frame(&self, cell: [i32; 3]) -> Mat3 {
        let even = self.source.even(cell);
        let axis = match self.recipe.axis {
            Turning::Along(v) => v,
            Turning::Perturbed(v, amount) => (v + self.source.tilt(cell) * amount).normalize_or(v),
            Turning::Cone(v, least) => in_cone(v, least, even[0], even[1]),
            Turning::Radial(from) => {
                let offset = self.offset(cell).as_dvec3();
                let center = DVec3::new(cell[0] as f64, cell[1] as f64, cell[2] as f64) + offset;
                (center - from).normalize_or(DVec3::Z).as_vec3()
            }
        };
        let about = Frame::about(axis);
        if !self.recipe.has_roll() {
            return Mat3::from_cols(about.tangent, about.bitangent, axis);
        }
        let (sin, cos) = sin_cos(even[2] * std::f32::consts::TAU);
        let x = about.tangent * cos + about.bitangent * sin;
        Mat3::from_cols(x, axis.cross(x), axis)
    }
}

/// A direction evenly within the cap around `v` of at least this cosine.
fn in_cone(v: Vec3, least: f32, a: f32, b: f32) -> Vec3 {
    let z = 1.0 - a * (1.0 - least);
    let (sin, cos) = sin_cos(b * std::f32::consts::TAU);
    let frame = Frame::about(v);
    let out = (1.0 - z * z).max(0.0).sqrt();
    (frame.tangent * (out * cos) + frame.bitangent * (out * sin) + v * z).normalize_or(v)
}

/// All steps within so many rings, in a fixed order.
pub(super) fn for_cells(rings: i32, mut visit: impl FnMut([i32; 3])) {
    for x in -rings..=rings {
        for y in -rings..=rings {
            for z in -rings..=rings {
                visit([x, y, z]);
            }
        }
    }
}

pub(super) fn add(cell: [i32; 3], step: [i32; 3]) -> [i32; 3] {
    std::array::from_fn(|k| cell[k].wrapping_add(step[k]))
}
