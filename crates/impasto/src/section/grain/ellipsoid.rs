//! Balls and ellipsoids.

use super::shape::{Convex, Exit, Gap, Level};
use crate::math::{Mat3, Vec3};

/// A sphere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) radius: f32,
}

impl Convex for Ball {
    fn reach(&self) -> f32 {
        self.radius
    }

    fn holds(&self, m: Vec3) -> bool {
        m.dot(m) <= self.radius * self.radius
    }

    /// The closed form of Li's equations (5)-(7): half the chord, seen from its middle.
    fn exit(&self, m: Vec3, t: Vec3) -> Exit {
        let along = m.dot(t);
        let flat = m - t * along;
        let half = (self.radius * self.radius - flat.dot(flat)).max(0.0).sqrt();
        Exit { distance: (half - along).max(0.0), normal: (flat + t * half).normalize_or(t) }
    }

    fn support(&self, n: Vec3) -> Vec3 {
        n * self.radius
    }

    fn level(&self, m: Vec3) -> Level {
        let length = m.length();
        Level { value: length - self.radius, gradient: if length > 0.0 { m / length } else { Vec3::ZERO } }
    }

    /// Exact: the distance to the disc of equation (8).
    fn gap(&self, m: Vec3, n: Vec3) -> Gap {
        let height = m.dot(n);
        let flat = m - n * height;
        let distance = flat.length();
        let disc = (self.radius * self.radius - height * height).max(0.0).sqrt();
        Gap { distance: distance - disc, away: flat.normalize_or_zero() }
    }

    fn scaled(self, s: f32) -> Self {
        Self { radius: self.radius * s }
    }
}

/// A sphere stretched along three axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ellipsoid {
    /// Its axes as columns: lattice from own coordinates, a rotation.
    pub(crate) frame: Mat3,
    /// Half lengths along them.
    pub(crate) semi: Vec3,
}

impl Ellipsoid {
    /// To the space in which it is the unit sphere.
    fn unit(&self, v: Vec3) -> Vec3 {
        self.frame.transpose() * v / self.semi
    }
}

impl Convex for Ellipsoid {
    fn reach(&self) -> f32 {
        self.semi.max_element()
    }

    fn holds(&self, m: Vec3) -> bool {
        self.unit(m).length_squared() <= 1.0
    }

    fn exit(&self, m: Vec3, t: Vec3) -> Exit {
        let (p, d) = (self.unit(m), self.unit(t));
        let (a, b, c) = (d.dot(d), p.dot(d), p.dot(p) - 1.0);
        let distance = far_root(a, b, c);
        let normal = self.frame * ((p + d * distance) / self.semi);
        Exit { distance, normal: normal.normalize_or(t) }
    }

    fn support(&self, n: Vec3) -> Vec3 {
        let w = self.semi * (self.frame.transpose() * n);
        self.frame * (self.semi * w.normalize_or_zero())
    }

    fn level(&self, m: Vec3) -> Level {
        let p = self.unit(m);
        let length = p.length();
        let gradient = if length > 0.0 { self.frame * (p / (self.semi * length)) } else { Vec3::ZERO };
        Level { value: length - 1.0, gradient }
    }

    fn scaled(self, s: f32) -> Self {
        Self { semi: self.semi * s, ..self }
    }
}

/// The greater root of `a x^2 + 2 b x + c` for a > 0 >= c, without cancellation; not negative.
pub(super) fn far_root(a: f32, b: f32, c: f32) -> f32 {
    let c = c.min(0.0);
    let root = (b * b - a * c).max(0.0).sqrt();
    let far = if b > 0.0 { -c / (b + root) } else { (root - b) / a };
    if far > 0.0 { far } else { 0.0 }
}
