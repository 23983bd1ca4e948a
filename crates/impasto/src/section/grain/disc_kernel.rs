//! Batches of places on a plane, against its list of discs.
//!
//! Short passes over arrays: for each disc that may matter, all lanes ask whether they are in it; then each lane works out
//! its own relief. A lane's answer depends on its own place only, whatever else is in its batch.

use super::discs::{Disc, Discs};
use super::eval::{Hit, HitKind, Look, SectionKind, Side};
use super::openness::form_factor;
use super::shape::{Body, Convex};
use crate::math::{BATCH, Lane, Vec2, Vec3, vec2};
use crate::par::Level;
use fearless_simd::{Simd, dispatch};

/// What a section shows at a batch of places: one entry a lane. Normals along the model's axes, heights in model units.
#[derive(Clone, Debug)]
pub struct Hits {
    /// As [`Hit::height`].
    pub height: Lane,
    /// As [`Hit::normal`].
    pub normal: [Lane; 3],
    /// As [`Hit::openness`].
    pub openness: Lane,
    /// As [`Hit::kind`].
    pub kind: [HitKind; BATCH],
    /// As [`Hit::particle`].
    pub particle: [u32; BATCH],
    /// From the disc's centre to the place.
    dx: Lane,
    dy: Lane,
    /// Which disc, as a lane number that fits an f32; -1 is none.
    owner: [i32; BATCH],
    /// Squared distance to the rim of the ball along the normal, or the gap to the nearest disc.
    depth: Lane,
}

impl Hits {
    /// Room for a batch.
    pub fn new() -> Box<Self> {
        Box::new(Self {
            height: [0.0; BATCH],
            normal: [[0.0; BATCH]; 3],
            openness: [1.0; BATCH],
            kind: [HitKind::Matrix; BATCH],
            particle: [Hit::MATRIX; BATCH],
            dx: [0.0; BATCH],
            dy: [0.0; BATCH],
            owner: [-1; BATCH],
            depth: [0.0; BATCH],
        })
    }

    /// One lane.
    pub fn hit(&self, i: usize) -> Hit {
        Hit {
            height: self.height[i],
            normal: Vec3::new(self.normal[0][i], self.normal[1][i], self.normal[2][i]),
            kind: self.kind[i],
            particle: self.particle[i],
            openness: self.openness[i],
            leaf: 0,
            tone: 0.0,
        }
    }
}

impl Discs<'_> {
    /// What the section shows at the first `n` of a batch of places: plane coordinates, model units. `near` is room to work
    /// in.
    pub fn eval_batch(
        &self,
        level: Level,
        at: [&Lane; 2],
        n: usize,
        look: Look,
        (near, out): (&mut Vec<u32>, &mut Hits),
    ) {
        let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for i in 0..n {
            let p = vec2(at[0][i], at[1][i]);
            (min, max) = (min.min(p), max.max(p));
        }
        // Nothing is near a place that is none.
        near.clear();
        if min.is_finite() && max.is_finite() {
            self.near(min, max, near);
        }
        let is_balls = self.discs.first().is_none_or(|d| matches!(d.body, Body::Ball(_)));
        match (is_balls, look.kind) {
            (true, SectionKind::Solid) => dispatch!(level, simd => self.solid_balls(simd, at, look, near, out)),
            (true, _) => dispatch!(level, simd => self.balls(simd, at, look, near, out)),
            (false, _) => (0..n).for_each(|i| self.one(vec2(at[0][i], at[1][i]), look, near, out, i)),
        }
    }

    /// Torn and hollow balls.
    #[inline(always)]
    fn balls<S: Simd>(&self, simd: S, [xs, ys]: [&Lane; 2], look: Look, near: &[u32], out: &mut Hits) {
        let [u, v, n] = self.frame(look);
        let upwards = if look.side == Side::Below { 1.0 } else { -1.0 };
        simd.vectorize(
            #[inline(always)]
            || {
                out.owner = [-1; BATCH];
                for &k in near {
                    let disc = &self.discs[k as usize];
                    let squared = disc.radius * disc.radius;
                    for i in 0..BATCH {
                        let (dx, dy) = (xs[i] - disc.at.x, ys[i] - disc.at.y);
                        let left = squared - (dx * dx + dy * dy);
                        let is_in = left >= 0.0;
                        out.owner[i] = if is_in { k as i32 } else { out.owner[i] };
                        out.dx[i] = if is_in { dx } else { out.dx[i] };
                        out.dy[i] = if is_in { dy } else { out.dy[i] };
                        out.depth[i] = if is_in { left } else { out.depth[i] };
                    }
                }
            },
        );
        // What differs from disc to disc, gathered: height above the section, radius, +1 for a bump.
        let (mut h, mut r, mut s) = ([0.0; BATCH], [1.0; BATCH], [0.0; BATCH]);
        for i in 0..BATCH {
            let owner = out.owner[i];
            (out.kind[i], out.particle[i]) = (HitKind::Matrix, Hit::MATRIX);
            if owner >= 0 {
                let disc = &self.discs[owner as usize];
                let is_bump = Self::is_bump(disc, look);
                h[i] = disc.height * upwards;
                r[i] = disc.particle.reach;
                s[i] = if is_bump { 1.0 } else { -1.0 };
                out.kind[i] = if is_bump { HitKind::Bump } else { HitKind::Cavity };
                out.particle[i] = disc.particle.id;
            }
        }
        simd.vectorize(
            #[inline(always)]
            || {
                for i in 0..BATCH {
                    let is_hit = s[i] != 0.0;
                    // R^2 - rho^2 = (R^2 - h^2 - rho^2) + h^2.
                    let w = (out.depth[i] + h[i] * h[i]).sqrt();
                    let per_r = 1.0 / r[i];
                    let (a, b, c) = (s[i] * out.dx[i] * per_r, s[i] * out.dy[i] * per_r, w * per_r);
                    out.height[i] = if is_hit { h[i] + s[i] * w } else { 0.0 };
                    let c = if is_hit { c } else { 1.0 };
                    let (a, b) = if is_hit { (a, b) } else { (0.0, 0.0) };
                    out.normal[0][i] = u.x * a + v.x * b + n.x * c;
                    out.normal[1][i] = u.y * a + v.y * b + n.y * c;
                    out.normal[2][i] = u.z * a + v.z * b + n.z * c;
                    let deep = 0.5 + 0.5 * h[i] * per_r;
                    out.openness[i] = if s[i] < 0.0 { deep } else { 0.5 + 0.5 * c };
                }
            },
        );
    }

    /// Balls cut flat, with their bevels.
    #[inline(always)]
    fn solid_balls<S: Simd>(&self, simd: S, [xs, ys]: [&Lane; 2], look: Look, near: &[u32], out: &mut Hits) {
        let [u, v, n] = self.frame(look);
        let t = self.bevel();
        simd.vectorize(
            #[inline(always)]
            || {
                out.owner = [-1; BATCH];
                out.depth = [t; BATCH];
                for &k in near {
                    let disc = &self.discs[k as usize];
                    let width = self.bevel_of(disc);
                    for i in 0..BATCH {
                        let (dx, dy) = (xs[i] - disc.at.x, ys[i] - disc.at.y);
                        let rho = (dx * dx + dy * dy).sqrt();
                        let gap = rho - disc.radius;
                        let gap = if gap > 0.0 { gap } else { 0.0 };
                        let is_nearest = gap < out.depth[i] && gap < width;
                        let per_rho = if gap > 0.0 { 1.0 / rho } else { 0.0 };
                        out.owner[i] = if is_nearest { k as i32 } else { out.owner[i] };
                        out.dx[i] = if is_nearest { dx * per_rho } else { out.dx[i] };
                        out.dy[i] = if is_nearest { dy * per_rho } else { out.dy[i] };
                        out.depth[i] = if is_nearest { gap } else { out.depth[i] };
                    }
                }
                const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;
                for i in 0..BATCH {
                    let is_bevel = out.owner[i] >= 0 && out.depth[i] > 0.0;
                    let (a, b) = if is_bevel { (out.dx[i] * HALF, out.dy[i] * HALF) } else { (0.0, 0.0) };
                    let c = if is_bevel { HALF } else { 1.0 };
                    out.height[i] = -out.depth[i];
                    out.normal[0][i] = u.x * a + v.x * b + n.x * c;
                    out.normal[1][i] = u.y * a + v.y * b + n.y * c;
                    out.normal[2][i] = u.z * a + v.z * b + n.z * c;
                    out.openness[i] = 0.5 + 0.5 * c;
                }
            },
        );
        for i in 0..BATCH {
            (out.kind[i], out.particle[i]) = match out.owner[i] {
                -1 => (HitKind::Matrix, Hit::MATRIX),
                k => {
                    let kind = if out.depth[i] > 0.0 { HitKind::Bevel } else { HitKind::Disc };
                    (kind, self.discs[k as usize].particle.id)
                }
            };
        }
    }

    fn bevel_of(&self, disc: &Disc) -> f32 {
        let t = self.bevel();
        if self.grain.spec.bevel_within_particle { t.min(disc.particle.reach * 0.5) } else { t }
    }

    /// One lane of other shapes.
    fn one(&self, at: Vec2, look: Look, near: &[u32], out: &mut Hits, i: usize) {
        let spacing = self.grain.spec.spacing;
        let side = if look.side == Side::Below { self.plane.normal } else { -self.plane.normal };
        let [u, v] = self.window.axes.map(|a| self.grain.to_lattice(a));
        let (plane_normal, n) = (self.grain.to_lattice(self.plane.normal), self.grain.to_lattice(side));
        let t = self.bevel();
        let rest = if look.kind == SectionKind::Solid { -t } else { 0.0 };
        let mut best = Hit::matrix(side.as_vec3(), rest);
        for &k in near {
            let disc = &self.discs[k as usize];
            let reach = disc.radius + if look.kind == SectionKind::Solid { t } else { 0.0 };
            if (at - disc.at).length_squared() > reach * reach {
                continue;
            }
            let m = self.seen_from(disc, [u, v, plane_normal], at);
            if look.kind != SectionKind::Solid {
                if !disc.body.holds(m) {
                    continue;
                }
                let is_bump = Self::is_bump(disc, look);
                let exit = disc.body.exit(m, if is_bump { n } else { -n });
                let sign = if is_bump { 1.0 } else { -1.0 };
                best = Hit {
                    height: exit.distance * sign * spacing,
                    normal: self.grain.to_model(exit.normal * sign),
                    kind: if is_bump { HitKind::Bump } else { HitKind::Cavity },
                    particle: disc.particle.id,
                    openness: match is_bump {
                        true => 0.5 + 0.5 * exit.normal.dot(n),
                        false => form_factor(&self.openings[k as usize], m - n * exit.distance, -exit.normal),
                    },
                    ..best
                };
                continue;
            }
            let gap = disc.body.gap(m, n);
            let distance = gap.distance.max(0.0) * spacing;
            if distance < self.bevel_of(disc) && -distance > best.height {
                let normal = if distance > 0.0 { (n + gap.away).normalize_or(n) } else { n };
                best = Hit {
                    height: -distance,
                    normal: self.grain.to_model(normal),
                    kind: if distance > 0.0 { HitKind::Bevel } else { HitKind::Disc },
                    particle: disc.particle.id,
                    openness: 0.5 + 0.5 * normal.dot(n),
                    ..best
                };
            }
        }
        out.height[i] = best.height;
        for k in 0..3 {
            out.normal[k][i] = best.normal[k];
        }
        (out.openness[i], out.kind[i], out.particle[i]) = (best.openness, best.kind, best.particle);
    }
}
