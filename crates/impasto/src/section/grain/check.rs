//! Bad numbers of a grain give one clear line.

use super::spec::{Axis, Chance, Contact, Ends, GrainSpec, Profile, Shape, parameter};
use crate::math::Vec3;
use crate::{Error, Result};

/// The farthest that particles may reach, in spacings: more would take too many neighbours.
const MAX_REACH: f32 = 4.0;

/// Checks every number.
pub(super) fn check(spec: &GrainSpec) -> Result<()> {
    positive("spacing", spec.spacing)?;
    within("jitter", spec.jitter, 0.0..=0.5, "from 0 to 0.5 spacings")?;
    within("size spread", spec.size_spread, 0.0..=0.95, "from 0 to 0.95")?;
    within("height spread", spec.height_spread, 0.0..=0.95, "from 0 to 0.95")?;
    within("bevel", spec.bevel, 0.0..=0.5, "from 0 to 0.5 spacings")?;
    if let Contact::Apart { grow } = spec.contact {
        within("growth", grow, 1.0..=4.0, "from 1 to 4 times the wanted size")?;
    }
    if let Chance::Noise { frequency } = spec.chance {
        within("noise frequency", frequency, 0.001..=8.0, "from 0.001 to 8 lattice units a texel")?;
    }
    shape(&spec.shape)?;
    axis(&spec.axis)?;
    let is_in_paper = matches!(spec.shape, Shape::Sphere { .. } | Shape::Cylinder { .. });
    if spec.profile == Profile::Paper && !is_in_paper {
        return Err(parameter("profile", "paper", "it has spheres and cylinders only"));
    }
    let reach = reach(&spec.shape) / spec.spacing;
    if reach > MAX_REACH {
        let given = format!("{reach} spacings");
        return Err(parameter("particle size", given, "a particle reaches at most 4 spacings from its centre"));
    }
    Ok(())
}

/// How far the unperturbed particle reaches from its centre.
fn reach(shape: &Shape) -> f32 {
    match shape {
        Shape::Sphere { radius } => *radius,
        Shape::Ellipsoid { radii } => radii.max_element(),
        Shape::Cylinder { radius, height, .. } => (radius * radius + height * height * 0.25).sqrt(),
        Shape::Capsule { radius, height } => radius.max(height * 0.5),
        Shape::Box { edges, .. } => edges.length() * 0.5,
        Shape::Polyhedron(p) => p.corners.iter().map(|c| c.length()).fold(0.0, f32::max),
        Shape::Superquadric { radii, .. } => radii.length(),
    }
}

fn shape(shape: &Shape) -> Result<()> {
    match *shape {
        Shape::Sphere { radius } => positive("radius", radius),
        Shape::Ellipsoid { radii } => lengths("radii", radii),
        Shape::Cylinder { radius, height, ends } => {
            positive("radius", radius)?;
            positive("height", height)?;
            match ends {
                Ends::Rounded(e) => within("rounding", e, 0.0..=1.0, "from 0 to 1 radius"),
                _ => Ok(()),
            }
        }
        Shape::Capsule { radius, height } => {
            positive("radius", radius)?;
            positive("height", height)?;
            if height < 2.0 * radius {
                return Err(parameter("height", height, "a capsule is at least as long as it is wide"));
            }
            Ok(())
        }
        Shape::Box { edges, rounding } => {
            lengths("edges", edges)?;
            let most = edges.min_element() * 0.5;
            within("rounding", rounding, 0.0..=most, "from 0 to half of the shortest edge")
        }
        Shape::Polyhedron(_) => Ok(()),
        Shape::Superquadric { radii, power } => {
            lengths("radii", radii)?;
            within("exponent", power, 1.1..=32.0, "from 1.1 to 32")
        }
    }
}

fn axis(axis: &Axis) -> Result<()> {
    let direction = |v: Vec3| match v.is_finite() && v.as_dvec3().length() > 1e-30 {
        true => Ok(()),
        false => Err(parameter("axis", triple(v), "it needs three finite numbers that are not all zero")),
    };
    match *axis {
        Axis::Along(v) => direction(v),
        Axis::Perturbed(v, amount) => {
            direction(v)?;
            within("axis perturbation", amount, 0.0..=100.0, "from 0 to 100")
        }
        Axis::Cone(v, angle) => {
            direction(v)?;
            within("cone", angle, 0.0..=std::f32::consts::PI, "a half angle from 0 to 180 degrees")
        }
        Axis::Isotropic => Ok(()),
        Axis::Radial(center) if center.is_finite() => Ok(()),
        Axis::Radial(center) => Err(parameter("axis centre", triple(center), "it needs three finite numbers")),
    }
}

pub(super) fn positive(what: &str, x: f32) -> Result<()> {
    if x > 0.0 && x.is_finite() { Ok(()) } else { Err(parameter(what, x, "it is a length above zero")) }
}

fn lengths(what: &str, v: Vec3) -> Result<()> {
    if v.is_finite() && v.min_element() > 0.0 { Ok(()) } else { Err(parameter(what, triple(v), "lengths above zero")) }
}

pub(super) fn within(what: &str, x: f32, range: std::ops::RangeInclusive<f32>, why: &str) -> Result<()> {
    if range.contains(&x) { Ok(()) } else { Err::<(), Error>(parameter(what, x, why)) }
}

fn triple(v: Vec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}
