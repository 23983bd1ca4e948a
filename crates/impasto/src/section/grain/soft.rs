//! Cells with rounded edges and corners: vesicles, arils, bubbles of a foam, cells of a tissue.
//!
//! A rounded cell is where the root of the sum of (r - d_j)^2 over the walls nearer than r is below r, d_j being the
//! distance from wall j: a convex body, so that Newton's steps from the sharp cell's surface never pass its own.

use super::cells::{Asked, Seed};
use super::openness::form_factor;
use super::shape::{Gap, N_OPENING};
use crate::math::{DVec3, Frame, Vec3, exact};

/// A wall seen from the place asked for.
#[derive(Clone, Copy, Default)]
struct Wall {
    /// To the wall's surface, model units; negative behind it.
    distance: f32,
    /// Unit vector towards it, model space.
    out: Vec3,
}

/// Walls a cell may have: as many as there are seeds around.
const MOST: usize = 124;

/// A rounded cell seen from a place.
pub(super) struct Soft {
    rounding: f32,
    walls: [Wall; MOST],
    n: usize,
}

impl Soft {
    /// The cell of a seed. None if the place is outside of the sharp cell already.
    pub(super) fn of(asked: &Asked, seed: Seed, wall: f32, rounding: f32) -> Option<Self> {
        let mut soft = Self { rounding, walls: [Wall::default(); MOST], n: 0 };
        let mut is_inside = true;
        asked.for_seeds(asked.local, |s| {
            if s.cell == seed.cell || soft.n == MOST {
                return;
            }
            let (value, gradient) = asked.border(seed, s, asked.local);
            let per = 1.0 / gradient.length();
            let distance = value * per - wall * 0.5;
            is_inside &= distance > 0.0;
            soft.walls[soft.n] = Wall { distance, out: -gradient * per };
            soft.n += 1;
        });
        is_inside.then_some(soft)
    }

    fn walls(&self) -> &[Wall] {
        &self.walls[..self.n]
    }

    /// The rounded cell's function, and its gradient, so far along a ray: negative inside.
    fn level(&self, t: Vec3, way: f32) -> (f32, Vec3) {
        let (mut squares, mut sum) = (0.0, Vec3::ZERO);
        for wall in self.walls() {
            let near = self.rounding - wall.distance + way * wall.out.dot(t);
            if near > 0.0 {
                squares += near * near;
                sum += wall.out * near;
            }
        }
        let root = squares.sqrt();
        if root > 0.0 { (root - self.rounding, sum / root) } else { (-self.rounding, Vec3::ZERO) }
    }

    /// Whether the place is inside.
    pub(super) fn holds(&self) -> bool {
        self.level(Vec3::ZERO, 0.0).0 <= 0.0
    }

    /// Where a ray along a unit vector leaves it: way and outward unit normal.
    pub(super) fn exit(&self, t: Vec3) -> (f32, Vec3) {
        let mut way = self.sharp_exit(t);
        let mut level = self.level(t, way);
        for _ in 0..12 {
            let slope = level.1.dot(t);
            if level.0 <= 1e-6 * self.rounding || slope <= 1e-6 {
                break;
            }
            way -= level.0 / slope;
            level = self.level(t, way);
        }
        (way.max(0.0), level.1.normalize_or(t))
    }

    fn sharp_exit(&self, t: Vec3) -> f32 {
        let mut least = f32::INFINITY;
        for wall in self.walls() {
            let towards = wall.out.dot(t);
            if towards > 0.0 && wall.distance < least * towards {
                least = wall.distance / towards;
            }
        }
        if least < f32::INFINITY { least } else { 0.0 }
    }

    /// How far in the section with normal `n` the place is outside of the outline, to first order.
    pub(super) fn gap(&self, n: Vec3) -> Gap {
        let (value, gradient) = self.level(Vec3::ZERO, 0.0);
        let flat = gradient - n * gradient.dot(n);
        let steep = flat.length();
        if steep > 1e-6 {
            Gap { distance: value / steep, away: flat / steep }
        } else {
            Gap { distance: -self.rounding, away: Vec3::ZERO }
        }
    }

    /// The part of the sky that a cavity's wall sees, so deep below the place: `outward` is the section's normal.
    pub(super) fn openness(&self, depth: f32, normal: Vec3, outward: DVec3) -> f32 {
        let n = outward.as_vec3();
        let frame = Frame::about(n);
        let step = std::f64::consts::TAU / N_OPENING as f64;
        let opening: [Vec3; N_OPENING] = std::array::from_fn(|k| {
            let (sin, cos) = (exact::sin(k as f64 * step) as f32, exact::cos(k as f64 * step) as f32);
            let t = frame.tangent * cos + frame.bitangent * sin;
            t * self.sharp_exit(t)
        });
        form_factor(&opening, n * -depth, normal)
    }
}
