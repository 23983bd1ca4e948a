//! How much sky a point in a cavity sees.
//!
//! A convex cavity hides nothing of its own opening, and the opening lies above the tangent plane of each of its points:
//! so a uniform sky lights the point by the form factor of the opening, a contour integral (Lambert, "Photometria", 1760).
//! For a ball it is the same at all of its points: (R + h) / 2R with h the centre's height above the section.

use super::shape::{Body, Exit};
use crate::math::{Vec3, acos};

impl Body<'_> {
    /// The part of a uniform sky that lights the point where a ray from `m` along `-n` comes out; `n` is the section's
    /// outward normal.
    pub(super) fn cavity_openness(&self, m: Vec3, n: Vec3, exit: &Exit) -> f32 {
        if let Body::Ball(ball) = self {
            let h = -m.dot(n);
            return ((ball.radius + h) / (2.0 * ball.radius)).clamp(0.0, 1.0);
        }
        form_factor(&self.opening(m.dot(n), n), m - n * exit.distance, -exit.normal)
    }
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

/// What interreflection adds to a cavity's openness: the light that reaches its wall in all, with walls of this albedo, as
/// a part of the sky's (the integrating sphere).
pub fn with_interreflection(openness: f32, albedo: f32) -> f32 {
    let left = 1.0 - albedo * (1.0 - openness);
    if left > 0.0 { openness / left } else { 1.0 }
}
