//! Bodies with faces: boxes, sharp or rounded, and convex polyhedra.

use super::shape::{Convex, Exit, Gap, Level, first_order_gap, newton_exit};
use crate::math::{Mat3, Vec3, Vec4};

/// A box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    /// Its axes as columns, a rotation.
    pub(crate) frame: Mat3,
    /// Half edge lengths.
    pub(crate) half: Vec3,
    /// Radius of the rounded edges, at most the least half edge.
    pub(crate) rounding: f32,
}

impl Block {
    fn sharp_exit(&self, m: Vec3, t: Vec3) -> (f32, Vec3) {
        let (p, d) = (self.frame.transpose() * m, self.frame.transpose() * t);
        let mut best = (f32::INFINITY, t);
        for k in 0..3 {
            if d[k] != 0.0 {
                let way = if d[k] > 0.0 { (self.half[k] - p[k]) / d[k] } else { (-self.half[k] - p[k]) / d[k] };
                if way < best.0 {
                    best = (way, self.frame.col(k) * d[k].signum());
                }
            }
        }
        (best.0.max(0.0), best.1)
    }
}

impl Convex for Block {
    fn reach(&self) -> f32 {
        self.half.length()
    }

    fn holds(&self, m: Vec3) -> bool {
        if self.rounding > 0.0 {
            return self.level(m).value <= 0.0;
        }
        (self.frame.transpose() * m).abs().cmple(self.half).all()
    }

    fn exit(&self, m: Vec3, t: Vec3) -> Exit {
        let (distance, normal) = self.sharp_exit(m, t);
        // On a face, away from its rounded edges, the body is the sharp box.
        let inner = self.half - Vec3::splat(self.rounding);
        let p = (self.frame.transpose() * (m + t * distance)).abs();
        let n_beyond = p.cmpgt(inner).bitmask().count_ones();
        if self.rounding > 0.0 && n_beyond > 1 {
            return newton_exit(self, m, t, distance);
        }
        Exit { distance, normal }
    }

    fn support(&self, n: Vec3) -> Vec3 {
        let local = self.frame.transpose() * n;
        let inner = self.half - Vec3::splat(self.rounding);
        let corner = Vec3::from_array(std::array::from_fn(|k| if local[k] < 0.0 { -inner[k] } else { inner[k] }));
        self.frame * corner + n * self.rounding
    }

    fn level(&self, m: Vec3) -> Level {
        let p = self.frame.transpose() * m;
        let q = p.abs() - (self.half - Vec3::splat(self.rounding));
        let signs = Vec3::from_array(std::array::from_fn(|k| if p[k] < 0.0 { -1.0 } else { 1.0 }));
        let out = q.max(Vec3::ZERO);
        let length = out.length();
        let (value, local) = if length > 0.0 {
            (length, out * signs / length)
        } else {
            let k = if q.x >= q.y && q.x >= q.z {
                0
            } else if q.y >= q.z {
                1
            } else {
                2
            };
            (q[k], Vec3::AXES[k] * signs)
        };
        Level { value: value - self.rounding, gradient: self.frame * local }
    }

    /// Exact from the faces' lines, mitred at the corners.
    fn gap(&self, m: Vec3, n: Vec3) -> Gap {
        if self.rounding > 0.0 {
            return first_order_gap(self, m, n);
        }
        let p = self.frame.transpose() * m;
        let mut gap = Gap { distance: f32::NEG_INFINITY, away: Vec3::ZERO };
        for k in 0..3 {
            let normal = self.frame.col(k) * if p[k] < 0.0 { -1.0 } else { 1.0 };
            widen(&mut gap, p[k].abs() - self.half[k], normal, n);
        }
        gap
    }

    fn scaled(self, s: f32) -> Self {
        Self { half: self.half * s, rounding: self.rounding * s, ..self }
    }
}

/// Takes in one face: a point `above` it (negative: below), its normal, and the plane's normal `n`.
fn widen(gap: &mut Gap, above: f32, face: Vec3, n: Vec3) {
    let slope = face - n * face.dot(n);
    let length = slope.length();
    if length > 1e-6 && above / length > gap.distance {
        *gap = Gap { distance: above / length, away: slope / length };
    }
}

/// A convex polyhedron: the points that lie below all its faces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facets<'a> {
    /// Its axes as columns, a rotation.
    pub(crate) frame: Mat3,
    pub(crate) scale: f32,
    /// Unit normals and distances from the centre, before scaling.
    pub(crate) faces: &'a [Vec4],
    /// Corners, before scaling.
    pub(crate) corners: &'a [Vec3],
    /// Distance of the farthest corner, before scaling.
    pub(crate) reach: f32,
}

impl Convex for Facets<'_> {
    fn reach(&self) -> f32 {
        self.reach * self.scale
    }

    fn holds(&self, m: Vec3) -> bool {
        let p = self.frame.transpose() * m;
        self.faces.iter().all(|f| f.truncate().dot(p) <= f.w * self.scale)
    }

    fn exit(&self, m: Vec3, t: Vec3) -> Exit {
        let (p, d) = (self.frame.transpose() * m, self.frame.transpose() * t);
        let mut best = (f32::INFINITY, d);
        for face in self.faces {
            let slope = face.truncate().dot(d);
            if slope > 0.0 {
                let way = (face.w * self.scale - face.truncate().dot(p)) / slope;
                if way < best.0 {
                    best = (way, face.truncate());
                }
            }
        }
        Exit { distance: best.0.max(0.0), normal: self.frame * best.1 }
    }

    fn support(&self, n: Vec3) -> Vec3 {
        let local = self.frame.transpose() * n;
        let mut best = (f32::NEG_INFINITY, Vec3::ZERO);
        for &corner in self.corners {
            if corner.dot(local) > best.0 {
                best = (corner.dot(local), corner);
            }
        }
        self.frame * (best.1 * self.scale)
    }

    fn level(&self, m: Vec3) -> Level {
        let p = self.frame.transpose() * m;
        let mut best = (f32::NEG_INFINITY, Vec3::ZERO);
        for face in self.faces {
            let above = face.truncate().dot(p) - face.w * self.scale;
            if above > best.0 {
                best = (above, face.truncate());
            }
        }
        Level { value: best.0, gradient: self.frame * best.1 }
    }

    fn gap(&self, m: Vec3, n: Vec3) -> Gap {
        let p = self.frame.transpose() * m;
        let mut gap = Gap { distance: f32::NEG_INFINITY, away: Vec3::ZERO };
        for face in self.faces {
            widen(&mut gap, face.truncate().dot(p) - face.w * self.scale, self.frame * face.truncate(), n);
        }
        gap
    }

    fn scaled(self, s: f32) -> Self {
        Self { scale: self.scale * s, ..self }
    }
}
