//! Round bars: cylinders with sharp, domed or rounded ends, and capsules.

use super::ellipsoid::far_root;
use super::shape::{Convex, Exit, Gap, Level, first_order_gap, newton_exit};
use crate::math::Vec3;

/// A circular cylinder about its centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rod {
    /// Unit vector.
    pub(crate) axis: Vec3,
    pub(crate) radius: f32,
    /// Half the height.
    pub(crate) half: f32,
    /// Radius of the rounded rim, at most the radius and half the height.
    pub(crate) rounding: f32,
    /// Flat ends are shaded as domes.
    pub(crate) domed: bool,
}

impl Rod {
    /// Whether a point of the surface, so far along the axis and at that squared distance from it, is off the rounded rims.
    fn is_sharp_at(&self, along: f32, squared: f32) -> bool {
        let inner = self.radius - self.rounding;
        along.abs() <= self.half - self.rounding || squared <= inner * inner
    }

    /// The exit of a cylinder with sharp rims (equations 13-15), and whether it is through an end.
    fn sharp_exit(&self, m: Vec3, t: Vec3) -> (f32, bool) {
        let (along, slope) = (m.dot(self.axis), t.dot(self.axis));
        let a = 1.0 - slope * slope;
        let side = if a > 1e-7 {
            far_root(a, m.dot(t) - along * slope, m.dot(m) - along * along - self.radius * self.radius)
        } else {
            f32::INFINITY
        };
        let end = if slope > 0.0 {
            (self.half - along) / slope
        } else if slope < 0.0 {
            (-self.half - along) / slope
        } else {
            f32::INFINITY
        };
        if end < side { (end.max(0.0), true) } else { (side, false) }
    }
}

impl Rod {
    /// [`Convex::exit`] of the first `n` places, side by side, to the bit: rounded rims are left to it.
    #[inline(always)]
    pub(super) fn exits<const N: usize>(&self, places: &[Vec3; N], t: Vec3, n: usize, out: &mut [Exit; N]) {
        let slope = t.dot(self.axis);
        let a = 1.0 - slope * slope;
        let tip = self.axis * slope.signum();
        let inner = self.radius - self.rounding;
        let (has_side, squared) = (a > 1e-7, self.radius * self.radius);
        let [mut x, mut y, mut z] = [[0.0f32; N]; 3];
        for i in 0..N {
            (x[i], y[i], z[i]) = (places[i].x, places[i].y, places[i].z);
        }
        let (mut distance, mut normal, mut is_sharp) = ([0.0f32; N], [[0.0f32; N]; 3], [true; N]);
        for i in 0..N {
            let m = Vec3::new(x[i], y[i], z[i]);
            let along = m.dot(self.axis);
            // `far_root`, by selection.
            let (b, c) = (m.dot(t) - along * slope, m.dot(m) - along * along - squared);
            let c = c.min(0.0);
            let root = (b * b - a * c).max(0.0).sqrt();
            let far = if b > 0.0 { -c / (b + root) } else { (root - b) / a };
            let far = if far > 0.0 { far } else { 0.0 };
            let side = if has_side { far } else { f32::INFINITY };
            let to_end = if slope > 0.0 { self.half - along } else { -self.half - along };
            let end = if slope == 0.0 { f32::INFINITY } else { to_end / slope };
            let is_end = end < side;
            let way = if is_end { end.max(0.0) } else { side };
            let q = m + t * way;
            let foot = q.dot(self.axis);
            let off = q - self.axis * foot;
            let dome = q - self.axis * along;
            let flat = if self.domed { dome } else { tip };
            let v = if is_end { flat } else { off };
            let per = 1.0 / v.length();
            let is_long = per.is_finite() & (per > 0.0);
            distance[i] = way;
            normal[0][i] = if is_long { v.x * per } else { t.x };
            normal[1][i] = if is_long { v.y * per } else { t.y };
            normal[2][i] = if is_long { v.z * per } else { t.z };
            is_sharp[i] = (foot.abs() <= self.half - self.rounding) | (q.dot(q) - foot * foot <= inner * inner);
        }
        for i in 0..n {
            let normal = Vec3::new(normal[0][i], normal[1][i], normal[2][i]);
            out[i] = match self.rounding > 0.0 && !is_sharp[i] {
                true => newton_exit(self, places[i], t, distance[i]),
                false => Exit { distance: distance[i], normal },
            };
        }
    }
}

impl Convex for Rod {
    fn reach(&self) -> f32 {
        (self.half * self.half + self.radius * self.radius).sqrt()
    }

    fn holds(&self, m: Vec3) -> bool {
        let along = m.dot(self.axis);
        let flat = m.dot(m) - along * along;
        let inside = along.abs() <= self.half && flat <= self.radius * self.radius;
        if self.rounding > 0.0 && inside && !self.is_sharp_at(along, flat) {
            return self.level(m).value <= 0.0;
        }
        inside
    }

    fn exit(&self, m: Vec3, t: Vec3) -> Exit {
        let (distance, is_end) = self.sharp_exit(m, t);
        let q = m + t * distance;
        let along = q.dot(self.axis);
        if self.rounding > 0.0 && !self.is_sharp_at(along, q.dot(q) - along * along) {
            return newton_exit(self, m, t, distance);
        }
        let normal = if is_end && self.domed {
            q - self.axis * m.dot(self.axis)
        } else if is_end {
            self.axis * t.dot(self.axis).signum()
        } else {
            q - self.axis * q.dot(self.axis)
        };
        Exit { distance, normal: normal.normalize_or(t) }
    }

    fn support(&self, n: Vec3) -> Vec3 {
        let along = n.dot(self.axis);
        let out = (n - self.axis * along).normalize_or_zero();
        let e = self.rounding;
        self.axis * ((self.half - e) * if along < 0.0 { -1.0 } else { 1.0 }) + out * (self.radius - e) + n * e
    }

    /// Distance to the surface, rims rounded.
    fn level(&self, m: Vec3) -> Level {
        let along = m.dot(self.axis);
        let flat = m - self.axis * along;
        let distance = flat.length();
        let out = if distance > 0.0 { flat / distance } else { Vec3::ZERO };
        let end = if along < 0.0 { -self.axis } else { self.axis };
        let e = self.rounding;
        let (x, y) = (distance - (self.radius - e), along.abs() - (self.half - e));
        let (value, gradient) = if x > 0.0 && y > 0.0 {
            let length = (x * x + y * y).sqrt();
            (length, (out * x + end * y) / length)
        } else if x > y {
            (x, out)
        } else {
            (y, end)
        };
        Level { value: value - e, gradient }
    }

    /// The outline is an ellipse cut by two lines: first order at the ellipse, exact at the lines, mitred between them.
    fn gap(&self, m: Vec3, n: Vec3) -> Gap {
        if self.rounding > 0.0 {
            return first_order_gap(self, m, n);
        }
        let side = |at: Vec3| {
            let flat = at - self.axis * at.dot(self.axis);
            let distance = flat.length();
            let slope = (flat - n * flat.dot(n)) / distance.max(1e-12);
            let length = slope.length();
            if length > 1e-6 {
                Gap { distance: (distance - self.radius) / length, away: slope / length }
            } else {
                Gap { distance: -self.radius, away: Vec3::ZERO }
            }
        };
        let mut gap = side(m);
        if gap.distance > 0.0 {
            let foot = side(m - gap.away * gap.distance);
            gap = Gap { distance: gap.distance + foot.distance, away: foot.away };
        }
        let along = m.dot(self.axis);
        let slope = self.axis - n * self.axis.dot(n);
        let length = slope.length();
        if length > 1e-6 {
            let end = (along.abs() - self.half) / length;
            if end > gap.distance {
                gap = Gap { distance: end, away: slope * (if along < 0.0 { -1.0 } else { 1.0 } / length) };
            }
        }
        gap
    }

    fn scaled(self, s: f32) -> Self {
        Self { radius: self.radius * s, half: self.half * s, rounding: self.rounding * s, ..self }
    }
}

/// A cylinder with half spheres on both ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Capsule {
    /// Unit vector.
    pub(crate) axis: Vec3,
    pub(crate) radius: f32,
    /// Half the distance between the two spheres' centres.
    pub(crate) half: f32,
}

impl Convex for Capsule {
    fn reach(&self) -> f32 {
        self.half + self.radius
    }

    fn holds(&self, m: Vec3) -> bool {
        let along = m.dot(self.axis).clamp(-self.half, self.half);
        (m - self.axis * along).length_squared() <= self.radius * self.radius
    }

    fn exit(&self, m: Vec3, t: Vec3) -> Exit {
        let (along, slope) = (m.dot(self.axis), t.dot(self.axis));
        let a = 1.0 - slope * slope;
        let squared = self.radius * self.radius;
        if a > 1e-7 {
            let side = far_root_any(a, m.dot(t) - along * slope, m.dot(m) - along * along - squared);
            let q = m + t * side;
            let foot = q.dot(self.axis);
            if foot.abs() <= self.half {
                return Exit { distance: side.max(0.0), normal: (q - self.axis * foot).normalize_or(t) };
            }
        }
        // Through the end that the ray, or its way out of the side, points to.
        let leaning = if a > 1e-7 {
            let side = far_root_any(a, m.dot(t) - along * slope, m.dot(m) - along * along - squared);
            (m + t * side).dot(self.axis)
        } else {
            slope
        };
        let center = self.axis * (self.half * if leaning < 0.0 { -1.0 } else { 1.0 });
        let from = m - center;
        let distance = far_root_any(1.0, from.dot(t), from.dot(from) - squared);
        Exit { distance: distance.max(0.0), normal: (from + t * distance).normalize_or(t) }
    }

    fn support(&self, n: Vec3) -> Vec3 {
        let sign = if n.dot(self.axis) < 0.0 { -1.0 } else { 1.0 };
        self.axis * (self.half * sign) + n * self.radius
    }

    fn level(&self, m: Vec3) -> Level {
        let along = m.dot(self.axis).clamp(-self.half, self.half);
        let from = m - self.axis * along;
        let length = from.length();
        Level { value: length - self.radius, gradient: if length > 0.0 { from / length } else { Vec3::ZERO } }
    }

    fn scaled(self, s: f32) -> Self {
        Self { radius: self.radius * s, half: self.half * s, ..self }
    }
}

/// The greater root of `a x^2 + 2 b x + c`, of either sign; c may be positive.
fn far_root_any(a: f32, b: f32, c: f32) -> f32 {
    let root = (b * b - a * c).max(0.0).sqrt();
    if b > 0.0 { -c / (b + root) } else { (root - b) / a }
}
