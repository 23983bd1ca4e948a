//! Li 2022 to the letter, for comparison: numbers in brackets are the paper's equations.
//!
//! Kept are: the first particle found wins; a centre on the cut is below it for both halves; cylinders hang by their base,
//! lean by the longer of the two ways out at each point, with normals (17) and (18) as printed, and are measured in space,
//! not in the section. A failed test of one particle goes on to the next: that it ends the search (11, 12) would leave the
//! paper's figures empty.

use super::eval::{Hit, HitKind, Raw, SectionKind};
use super::particle::{add, for_cells};
use super::rod::Rod;
use super::shape::{Body, Convex};
use super::{Grain, Place};
use crate::math::{Vec3, vec3};

/// A particle of the paper at a point.
struct Near<'a> {
    id: u32,
    /// The point from the anchor: a sphere's centre, a cylinder's base.
    m: Vec3,
    body: Body<'a>,
}

impl Grain {
    /// `n` is the unit normal out of the half that is looked at.
    pub(super) fn eval_letter(
        &self,
        place: Place,
        n: Vec3,
        kind: SectionKind,
        keep: impl Fn([i32; 3], Vec3, &Body) -> bool,
    ) -> Raw {
        let mut holder = None;
        let mut least: Option<(f32, Vec3, u32)> = None;
        for_cells(1, |step| {
            if holder.is_some() {
                return;
            }
            let cell = add(place.cell, step);
            let offset = self.offset(cell);
            let m = place.local - (vec3(step[0] as f32, step[1] as f32, step[2] as f32) + offset);
            let near = Near { id: self.source.id(cell), m, body: self.free_body(cell) };
            if !keep(cell, offset, &near.body) {
                return;
            }
            if near.holds() {
                holder = Some(near);
            } else if kind == SectionKind::Solid
                && let Some((distance, away)) = near.gap(n)
                && least.is_none_or(|(d, ..)| distance < d)
            {
                least = Some((distance, away, near.id));
            }
        });
        let t = self.spec.bevel;
        match (kind, holder) {
            (SectionKind::Solid, Some(near)) => {
                Raw { height: 0.0, normal: n, kind: HitKind::Disc, particle: near.id, openness: 1.0 }
            }
            (SectionKind::Solid, None) => match least {
                Some((distance, away, id)) if distance <= t => {
                    // (9), (10); (20), (21).
                    let normal = (n + away).normalize_or(n);
                    Raw { height: -distance, normal, kind: HitKind::Bevel, particle: id, openness: 1.0 }
                }
                _ => Raw::matrix(n, -t),
            },
            (_, None) => Raw { particle: Hit::MATRIX, ..Raw::matrix(n, 0.0) },
            (SectionKind::Tear, Some(near)) => near.torn(n),
            (SectionKind::Hollow, Some(near)) => near.hollow(n),
        }
    }
}

impl Near<'_> {
    /// (1); (11) and (12).
    fn holds(&self) -> bool {
        match &self.body {
            Body::Rod(rod) => {
                let l = self.m.dot(rod.axis);
                (0.0..=2.0 * rod.half).contains(&l) && self.m.dot(self.m) - l * l <= rod.radius * rod.radius
            }
            body => body.holds(self.m),
        }
    }

    /// (2)-(7); (13)-(18).
    fn torn(&self, n: Vec3) -> Raw {
        match &self.body {
            Body::Rod(rod) => {
                let v = ways_out(rod, self.m, n);
                let w = ways_out(rod, self.m, -n);
                if v > w { self.rod_hit(rod, n, v) } else { self.rod_hit(rod, n, -w) }
            }
            body => {
                let is_bump = -self.m.dot(n) <= 0.0;
                let exit = body.exit(self.m, if is_bump { n } else { -n });
                let sign = if is_bump { 1.0 } else { -1.0 };
                self.hit(exit.distance * sign, exit.normal * sign)
            }
        }
    }

    fn hollow(&self, n: Vec3) -> Raw {
        match &self.body {
            Body::Rod(rod) => self.rod_hit(rod, n, -ways_out(rod, self.m, -n)),
            body => {
                let exit = body.exit(self.m, -n);
                self.hit(-exit.distance, -exit.normal)
            }
        }
    }

    /// (16)-(18): the normal is taken from the foot of the point, not of the exit, on the axis - and the wrong way round.
    fn rod_hit(&self, rod: &Rod, n: Vec3, height: f32) -> Raw {
        let q = self.m + n * height;
        let foot = rod.axis * self.m.dot(rod.axis);
        let normal = if height > 0.0 { foot - q } else { q - foot };
        self.hit(height, normal.normalize_or(n))
    }

    fn hit(&self, height: f32, normal: Vec3) -> Raw {
        let kind = if height > 0.0 { HitKind::Bump } else { HitKind::Cavity };
        Raw { height, normal, kind, particle: self.id, openness: 1.0 }
    }

    /// (8); (19). How far outside, and which way.
    fn gap(&self, n: Vec3) -> Option<(f32, Vec3)> {
        match &self.body {
            Body::Rod(rod) => {
                let l = self.m.dot(rod.axis);
                let from_axis = self.m - rod.axis * l;
                let meets = (0.0..=2.0 * rod.half).contains(&l);
                meets.then(|| (from_axis.length() - rod.radius, from_axis.normalize_or_zero()))
            }
            body if body.meets(self.m, n) => {
                let gap = body.gap(self.m, n);
                Some((gap.distance, gap.away))
            }
            _ => None,
        }
    }
}

/// (13)-(15): how far along `t` a point, seen from the base, leaves the cylinder.
fn ways_out(rod: &Rod, m: Vec3, t: Vec3) -> f32 {
    rod.exit(m - rod.axis * rod.half, t).distance
}
