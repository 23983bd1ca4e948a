//! Superquadrics: `|x/a|^p + |y/b|^p + |z/c|^p = 1`, between octahedron, ellipsoid and box.
//!
//! After Barr, "Superquadrics and Angle-Preserving Transformations", 1981.

use super::shape::{Convex, Exit, Level, newton_exit};
use crate::math::{Mat3, Vec3, pow};

/// A superquadric with one exponent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Superquadric {
    /// Its axes as columns, a rotation.
    pub(crate) frame: Mat3,
    /// Half lengths along them.
    pub(crate) semi: Vec3,
    /// The exponent p > 1.
    pub(crate) power: f32,
}

impl Superquadric {
    /// The p-norm of numbers that are not negative.
    fn norm(v: Vec3, p: f32) -> f32 {
        let most = v.max_element();
        if most <= 0.0 {
            return 0.0;
        }
        let v = v / most;
        most * pow(pow(v.x, p) + pow(v.y, p) + pow(v.z, p), 1.0 / p)
    }
}

impl Convex for Superquadric {
    /// The box around it has this half diagonal; below p = 2 the tips are farthest.
    fn reach(&self) -> f32 {
        if self.power <= 2.0 { self.semi.max_element() } else { self.semi.length() }
    }

    fn holds(&self, m: Vec3) -> bool {
        self.level(m).value <= 0.0
    }

    fn exit(&self, m: Vec3, t: Vec3) -> Exit {
        let (p, d) = (self.frame.transpose() * m, self.frame.transpose() * t);
        let mut start = f32::INFINITY;
        for k in 0..3 {
            if d[k] != 0.0 {
                start = start.min((self.semi[k] * d[k].signum() - p[k]) / d[k]);
            }
        }
        newton_exit(self, m, t, start.max(0.0))
    }

    fn support(&self, n: Vec3) -> Vec3 {
        let local = self.semi * (self.frame.transpose() * n);
        let dual = self.power / (self.power - 1.0);
        let norm = Self::norm(local.abs(), dual);
        if norm <= 0.0 {
            return Vec3::ZERO;
        }
        let tip = |k: usize| self.semi[k] * pow(local[k].abs() / norm, dual - 1.0) * local[k].signum();
        self.frame * Vec3::from_array(std::array::from_fn(tip))
    }

    /// The norm less one, times the least half length: near the surface about a distance.
    fn level(&self, m: Vec3) -> Level {
        let p = self.frame.transpose() * m / self.semi;
        let norm = Self::norm(p.abs(), self.power);
        let least = self.semi.min_element();
        let slope = |k: usize| {
            if norm > 0.0 {
                pow(p[k].abs() / norm, self.power - 1.0) * p[k].signum() * (least / self.semi[k])
            } else {
                0.0
            }
        };
        let gradient = self.frame * Vec3::from_array(std::array::from_fn(slope));
        Level { value: (norm - 1.0) * least, gradient }
    }

    fn scaled(self, s: f32) -> Self {
        Self { semi: self.semi * s, ..self }
    }
}
