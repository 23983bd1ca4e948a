//! How much sky a point in a cavity sees.
//!
//! A convex cavity hides nothing of its own opening, and the opening lies above the tangent plane of each of its points:
//! so a uniform sky lights the point by the form factor of the opening, a contour integral (Lambert, "Photometria", 1760).
//! For a ball it is the same at all of its points: (R + h) / 2R with h the centre's height above the section.

use super::shape::{Body, Exit};
use crate::math::{Vec3, acos, floor};

impl Body<'_> {
    /// The part of a uniform sky that lights the point where a ray from `m` along `-n` comes out; `n` is the section's
    /// outward normal.
    pub(super) fn cavity_openness(&self, m: Vec3, n: Vec3, exit: &Exit) -> f32 {
        if let Body::Ball(ball) = self {
            let h = -m.dot(n);
            return ((ball.radius + h) / (2.0 * ball.radius)).clamp(0.0, 1.0);
        }
        form_factor(&self.opening(stepped(m.dot(n)), n), m - n * exit.distance, -exit.normal)
    }
}

/// Where an opening is worked out for a plane of this offset: in steps, so that all points of a section have the same
/// opening, whatever their rounding. Half a step is far below what a polygon in a smooth outline's stead costs.
pub(super) fn stepped(offset: f32) -> f32 {
    const PER_SPACING: f32 = 65536.0;
    floor(offset * PER_SPACING + 0.5) / PER_SPACING
}

/// The form factor from a point with a unit normal to a polygon above its horizon, whichever way it turns.
pub(super) fn form_factor<const N: usize>(polygon: &[Vec3; N], q: Vec3, normal: Vec3) -> f32 {
    let mut rays = [[0.0f32; N]; 3];
    for k in 0..N {
        let to = polygon[k] - q;
        let squared = to.dot(to);
        let scale = if squared > 1e-20 { 1.0 / squared.sqrt() } else { 0.0 };
        for c in 0..3 {
            rays[c][k] = to[c] * scale;
        }
    }
    let [x, y, z] = rays;
    let mut parts = [0.0f32; N];
    for k in 0..N {
        let j = if k + 1 < N { k + 1 } else { 0 };
        let (cx, cy, cz) = (y[k] * z[j] - z[k] * y[j], z[k] * x[j] - x[k] * z[j], x[k] * y[j] - y[k] * x[j]);
        let squared = cx * cx + cy * cy + cz * cz;
        let scale = if squared > 1e-20 { 1.0 / squared.sqrt() } else { 0.0 };
        let angle = acos(x[k] * x[j] + y[k] * y[j] + z[k] * z[j]);
        parts[k] = angle * scale * (cx * normal.x + cy * normal.y + cz * normal.z);
    }
    let sum: f32 = parts.iter().sum();
    (sum.abs() * (0.5 / std::f32::consts::PI)).min(1.0)
}

/// How many points [`form_factors`] takes.
pub(super) const LANES: usize = 8;

/// The form factors from several points with their normals to one polygon: the bits of [`form_factor`], side by side.
#[inline(always)]
pub(super) fn form_factors<const N: usize>(
    polygon: &[Vec3; N],
    q: &[[f32; LANES]; 3],
    normal: &[[f32; LANES]; 3],
) -> [f32; LANES] {
    let ray = |corner: Vec3| {
        let mut ray = [[0.0f32; LANES]; 3];
        for i in 0..LANES {
            let to = [corner.x - q[0][i], corner.y - q[1][i], corner.z - q[2][i]];
            let squared = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
            let scale = if squared > 1e-20 { 1.0 / squared.sqrt() } else { 0.0 };
            ray[0][i] = to[0] * scale;
            ray[1][i] = to[1] * scale;
            ray[2][i] = to[2] * scale;
        }
        ray
    };
    let first = ray(polygon[0]);
    let (mut a, mut sum) = (first, [0.0f32; LANES]);
    for k in 0..N {
        let b = if k + 1 < N { ray(polygon[k + 1]) } else { first };
        for i in 0..LANES {
            let ([ax, ay, az], [bx, by, bz]) = ([a[0][i], a[1][i], a[2][i]], [b[0][i], b[1][i], b[2][i]]);
            let (cx, cy, cz) = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx);
            let squared = cx * cx + cy * cy + cz * cz;
            let scale = if squared > 1e-20 { 1.0 / squared.sqrt() } else { 0.0 };
            let angle = acos(ax * bx + ay * by + az * bz);
            sum[i] += angle * scale * (cx * normal[0][i] + cy * normal[1][i] + cz * normal[2][i]);
        }
        a = b;
    }
    sum.map(|sum| {
        let part = sum.abs() * (0.5 / std::f32::consts::PI);
        if part < 1.0 { part } else { 1.0 }
    })
}

/// What interreflection adds to a cavity's openness: the light that reaches its wall in all, with walls of this albedo, as
/// a part of the sky's (the integrating sphere).
pub fn with_interreflection(openness: f32, albedo: f32) -> f32 {
    let left = 1.0 - albedo * (1.0 - openness);
    if left > 0.0 { openness / left } else { 1.0 }
}
