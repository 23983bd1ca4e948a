//! What a convex particle must be able to tell, and the particles that can.
//!
//! Everything is in the particle's own place: `m` is the point asked for, seen from the particle's centre, in spacings and
//! along the lattice's axes. Directions are unit vectors.

use super::block::{Block, Facets};
use super::ellipsoid::{Ball, Ellipsoid};
use super::rod::{Capsule, Rod};
use super::superquadric::Superquadric;
use crate::math::{Frame, Vec3, exact};

/// Where a ray leaves a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Exit {
    /// How far from the start, never negative.
    pub(super) distance: f32,
    /// Unit normal of the particle there, outwards.
    pub(super) normal: Vec3,
}

/// How far a point of a plane is from the outline that the plane cuts out of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gap {
    /// Distance within the plane; negative inside.
    pub(super) distance: f32,
    /// Unit vector in the plane, away from the particle.
    pub(super) away: Vec3,
}

/// An implicit function at a point: negative inside, with its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Level {
    pub(super) value: f32,
    pub(super) gradient: Vec3,
}

/// A convex body around its centre.
pub(super) trait Convex: Sized {
    /// No point is farther from the centre.
    fn reach(&self) -> f32;
    /// Whether a point is inside or on the surface.
    fn holds(&self, m: Vec3) -> bool;
    /// Where the ray from `m`, a point inside, along `t` comes out.
    fn exit(&self, m: Vec3, t: Vec3) -> Exit;
    /// A point of the body that is farthest along `n`.
    fn support(&self, n: Vec3) -> Vec3;
    /// A function whose zero is the surface.
    fn level(&self, m: Vec3) -> Level;
    /// The same body at another size.
    fn scaled(self, s: f32) -> Self;

    /// In the plane through `m` with normal `n`, which meets the body: how far is its outline?
    fn gap(&self, m: Vec3, n: Vec3) -> Gap {
        first_order_gap(self, m, n)
    }
}

/// The distance to an outline to first order, twice: within a bevel's width of the outline the rest is below a hundredth.
pub(super) fn first_order_gap(body: &impl Convex, m: Vec3, n: Vec3) -> Gap {
    let step = |at: Vec3| {
        let Level { value, gradient } = body.level(at);
        let flat = gradient - n * gradient.dot(n);
        let length = flat.length();
        (length > 1e-6).then(|| (value / length, flat / length))
    };
    // At a point without a slope (the middle of the outline) there is nothing to be told but that it is inside.
    let Some((first, away)) = step(m) else { return Gap { distance: -body.reach(), away: Vec3::ZERO } };
    match step(m - away * first) {
        Some((second, away)) if first > 0.0 => Gap { distance: first + second, away },
        _ => Gap { distance: first, away },
    }
}

/// Newton's steps from outside along a ray: on a convex function they approach the exit from one side and never pass it.
pub(super) fn newton_exit(body: &impl Convex, m: Vec3, t: Vec3, start: f32) -> Exit {
    let mut distance = start;
    let mut level = body.level(m + t * distance);
    for _ in 0..16 {
        let slope = level.gradient.dot(t);
        // Below an f32's noise, or turned by it.
        if level.value <= 1e-7 || slope <= 1e-6 {
            break;
        }
        distance -= level.value / slope;
        level = body.level(m + t * distance);
    }
    Exit { distance: distance.max(0.0), normal: level.gradient.normalize_or(t) }
}

/// A particle's body.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Body<'a> {
    Ball(Ball),
    Ellipsoid(Ellipsoid),
    Rod(Rod),
    Capsule(Capsule),
    Block(Block),
    Facets(Facets<'a>),
    Superquadric(Superquadric),
}

macro_rules! each_body {
    ($self:expr, $b:ident => $e:expr) => {
        match $self {
            Body::Ball($b) => $e,
            Body::Ellipsoid($b) => $e,
            Body::Rod($b) => $e,
            Body::Capsule($b) => $e,
            Body::Block($b) => $e,
            Body::Facets($b) => $e,
            Body::Superquadric($b) => $e,
        }
    };
}

impl Convex for Body<'_> {
    fn reach(&self) -> f32 {
        each_body!(self, b => b.reach())
    }
    fn holds(&self, m: Vec3) -> bool {
        each_body!(self, b => b.holds(m))
    }
    fn exit(&self, m: Vec3, t: Vec3) -> Exit {
        each_body!(self, b => b.exit(m, t))
    }
    fn support(&self, n: Vec3) -> Vec3 {
        each_body!(self, b => b.support(n))
    }
    fn level(&self, m: Vec3) -> Level {
        each_body!(self, b => b.level(m))
    }
    fn gap(&self, m: Vec3, n: Vec3) -> Gap {
        each_body!(self, b => b.gap(m, n))
    }
    fn scaled(self, s: f32) -> Self {
        match self {
            Body::Ball(b) => Body::Ball(b.scaled(s)),
            Body::Ellipsoid(b) => Body::Ellipsoid(b.scaled(s)),
            Body::Rod(b) => Body::Rod(b.scaled(s)),
            Body::Capsule(b) => Body::Capsule(b.scaled(s)),
            Body::Block(b) => Body::Block(b.scaled(s)),
            Body::Facets(b) => Body::Facets(b.scaled(s)),
            Body::Superquadric(b) => Body::Superquadric(b.scaled(s)),
        }
    }
}

/// How many corners stand for a cavity's opening where its openness is worked out: more gain less than a hundredth.
pub(super) const N_OPENING: usize = 16;

impl Body<'_> {
    /// Whether the plane through `m` with normal `n` goes through the body.
    pub(super) fn meets(&self, m: Vec3, n: Vec3) -> bool {
        let offset = m.dot(n);
        if offset.abs() >= self.reach() {
            return false;
        }
        offset < self.support(n).dot(n) && -offset < self.support(-n).dot(-n)
    }

    /// A point inside the section by the plane `n . m = offset`, which meets the body: between the centre and the
    /// farthest point on that side.
    pub(super) fn section_point(&self, offset: f32, n: Vec3) -> Vec3 {
        let n = if offset < 0.0 { -n } else { n };
        let tip = self.support(n);
        let height = tip.dot(n);
        if height > 0.0 { tip * (offset.abs() / height).min(1.0) } else { Vec3::ZERO }
    }

    /// Outline of the section by the plane `n . m = offset`, which meets the body: counter-clockwise seen from the tip of
    /// `n`, in `n_corners` even steps of the angle about a point inside.
    pub(crate) fn outline(&self, offset: f32, n: Vec3, n_corners: usize) -> impl Iterator<Item = Vec3> {
        let middle = self.section_point(offset, n);
        let frame = Frame::about(n);
        (0..n_corners).map(move |k| {
            let angle = k as f64 * (std::f64::consts::TAU / n_corners as f64);
            let t = frame.tangent * exact::cos(angle) as f32 + frame.bitangent * exact::sin(angle) as f32;
            middle + t * self.exit(middle, t).distance
        })
    }

    /// A polygon that stands for the opening a plane cuts into the body: as large as a smooth outline of these corners.
    pub(super) fn opening(&self, offset: f32, n: Vec3) -> [Vec3; N_OPENING] {
        let middle = self.section_point(offset, n);
        let mut corners = [middle; N_OPENING];
        let step = std::f64::consts::TAU / N_OPENING as f64;
        let swell = (step / exact::sin(step)).sqrt() as f32;
        for (slot, corner) in corners.iter_mut().zip(self.outline(offset, n, N_OPENING)) {
            *slot = middle + (corner - middle) * swell;
        }
        corners
    }
}
