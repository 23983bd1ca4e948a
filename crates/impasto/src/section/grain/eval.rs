//! What a cut shows at a point: constructive geometry of particles and half spaces, seen along the section's normal.
//!
//! With d < 0 inside a particle and phi < 0 below the cut, and with the particles split into those whose centre is below and
//! those whose centre is above: torn, the half below is max(min(phi, d_below), -d_above); hollow, max(phi, -d); solid, the
//! section recessed by the bevel's height. A tear of the half above is the exact complement: same particle, same ray, same
//! point.

use super::particle::{add, for_cells};
use super::shape::{Body, Convex, Exit};
use super::{Contact, Grain, Place, Profile};
use crate::math::{DVec3, Vec3, vec3};
use crate::section::CutSurface;

/// How particles behave under the knife.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SectionKind {
    /// They stay whole; each goes with the half that holds its centre, the other half shows a cavity.
    Tear,
    /// They run out: both halves show cavities.
    Hollow,
    /// They are hard: both halves show flat discs, what is around them is recessed.
    Solid,
}

/// Which half is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Where the cut's distance is negative; its section's normal is the cut's.
    Below,
    /// The other; its section's normal is the negated one.
    Above,
}

/// Which section is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Look {
    /// How particles behave.
    pub kind: SectionKind,
    /// Which half.
    pub side: Side,
}

/// What is at a point of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HitKind {
    /// What is between the particles, or its bevel.
    Matrix,
    /// A particle that stands out of the section.
    Bump,
    /// Where a particle was.
    Cavity,
    /// A particle cut flat.
    Disc,
    /// The slope from a disc down to the matrix.
    Bevel,
}

/// What a cut shows at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Above the section, along the outward normal of the half that is looked at; model units, negative below it.
    pub height: f32,
    /// Unit normal in model space.
    pub normal: Vec3,
    /// What is there.
    pub kind: HitKind,
    /// The particle there, or whose bevel it is; [`Hit::MATRIX`] for none.
    pub particle: u32,
    /// How much of a uniform sky lights the point, 0 to 1: exact in the cavities of balls, within about 0.03 in those
    /// of other particles, whose opening a polygon stands for; for all else only the section's own plane hides sky.
    pub openness: f32,
    /// Which leaf of the filling answers, counted as [`Filling::n_leaves`](super::Filling::n_leaves) says; 0 where there is
    /// but one.
    pub leaf: u16,
    /// A place on the leaf's colour ramp, 0 to 1; 0 where the leaf has none.
    pub tone: f32,
}

impl Hit {
    /// No particle.
    pub const MATRIX: u32 = 0;

    /// Flat matrix at a height; `normal` is the section's.
    pub fn matrix(normal: Vec3, height: f32) -> Self {
        let (kind, particle) = (HitKind::Matrix, Self::MATRIX);
        Self { height, normal, kind, particle, openness: 1.0, leaf: 0, tone: 0.0 }
    }
}

/// A particle near a point, as a caller may choose by: see [`Grain::eval_where`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Its lattice cell.
    pub cell: [i32; 3],
    /// Its name.
    pub id: u32,
    /// Its centre, model units.
    pub center: DVec3,
    /// No point of it is farther from the centre, model units.
    pub reach: f32,
}

/// A hit along the lattice's axes, in spacings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Raw {
    pub(super) height: f32,
    pub(super) normal: Vec3,
    pub(super) kind: HitKind,
    pub(super) particle: u32,
    pub(super) openness: f32,
}

/// How far beyond its exit a ray looks for the next particle, spacings: below what is seen, above an f32's rounding.
const ON: f32 = 1e-5;

impl Raw {
    pub(super) fn matrix(normal: Vec3, height: f32) -> Self {
        Self { height, normal, kind: HitKind::Matrix, particle: Hit::MATRIX, openness: 1.0 }
    }
}

/// A particle that holds the point.
#[derive(Clone, Copy)]
pub(super) struct Holder<'a> {
    cell: [i32; 3],
    /// The point seen from the particle's centre.
    m: Vec3,
    body: Body<'a>,
}

impl Holder<'_> {
    #[cfg(test)]
    pub(super) fn id(&self, grain: &Grain) -> u32 {
        grain.source.id(self.cell)
    }
}

impl Grain {
    /// What a cut shows at a point `p` of it, in model space.
    ///
    /// The side of a particle is that of its centre, so that all of its points agree; its shape at the point is seen along
    /// the cut's normal there. On curved cuts that holds while particles are small against the radius of curvature.
    pub fn eval(&self, p: DVec3, surface: &impl CutSurface, look: Look) -> Hit {
        self.eval_where(p, surface, look, |_| true)
    }

    /// What the plane through `p` with unit normal `n` shows there, for the half it points out of (Li 2022).
    pub fn eval_at(&self, p: DVec3, n: DVec3, look: Look) -> Hit {
        self.eval(p, &crate::section::Plane { normal: n, offset: n.dot(p) }, look)
    }

    /// The same without the particles that `keep` refuses; it is asked by a particle's centre, so that none is cut.
    pub fn eval_where(
        &self,
        p: DVec3,
        surface: &impl CutSurface,
        look: Look,
        keep: impl Fn(&Candidate) -> bool,
    ) -> Hit {
        let place = self.place(p);
        let n = self.to_lattice(surface.normal(p));
        let is_below = |cell, offset| surface.distance(self.model_point(cell, offset)) <= 0.0;
        let keep = |cell, offset, body: &Body| {
            keep(&Candidate {
                cell,
                id: self.source.id(cell),
                center: self.model_point(cell, offset),
                reach: body.reach() * self.spec.spacing,
            })
        };
        let outward = if look.side == Side::Below { n } else { -n };
        let raw = match (self.spec.profile, look.kind) {
            (Profile::Paper, kind) => self.eval_letter(place, outward, kind, keep),
            (_, SectionKind::Tear) => self.tear(place, n, look.side, is_below, keep),
            (_, SectionKind::Hollow) => self.hollow(place, outward, keep),
            (_, SectionKind::Solid) => self.solid(place, outward, keep),
        };
        Hit {
            height: raw.height * self.spec.spacing,
            normal: self.to_model(raw.normal),
            kind: raw.kind,
            particle: raw.particle,
            openness: raw.openness,
            leaf: 0,
            tone: 0.0,
        }
    }

    /// Calls `visit` with each particle that holds the point, in the lattice's order.
    pub(super) fn for_holders<'a>(
        &'a self,
        place: Place,
        keep: impl Fn([i32; 3], Vec3, &Body) -> bool,
        mut visit: impl FnMut(Holder<'a>),
    ) {
        for_cells(self.n_rings, |step| {
            let cell = add(place.cell, step);
            let offset = self.offset(cell);
            let m = place.local - (vec3(step[0] as f32, step[1] as f32, step[2] as f32) + offset);
            if m.dot(m) > self.reach * self.reach {
                return;
            }
            let free = self.free_body(cell);
            // Most points are outside even at the greatest size; only the others need the neighbours.
            if !self.grown(free).holds(m) {
                return;
            }
            let body = free.scaled(self.scale(cell, offset, &free));
            if body.holds(m) && keep(cell, offset, &body) {
                visit(Holder { cell, m, body });
            }
        });
    }

    /// The greatest size a particle may take.
    pub(super) fn grown<'a>(&self, free: Body<'a>) -> Body<'a> {
        match self.spec.contact {
            Contact::Apart { grow } if grow > 1.0 => free.scaled(grow),
            _ => free,
        }
    }

    /// Of the particles that hold the point and that `belongs` takes, the one that reaches farthest along `t`; where
    /// particles overlap, the way goes on through those it comes out in.
    fn farthest<'a>(
        &'a self,
        place: Place,
        t: Vec3,
        belongs: impl Fn([i32; 3], Vec3, &Body) -> bool,
    ) -> Option<(Holder<'a>, Exit)> {
        let mut best: Option<(Holder, Exit)> = None;
        self.for_holders(place, &belongs, |holder| {
            let exit = holder.body.exit(holder.m, t);
            if best.is_none_or(|(_, b)| exit.distance > b.distance) {
                best = Some((holder, exit));
            }
        });
        if self.spec.contact == Contact::Overlapping {
            // A chain of particles is short; what is left of a longer one is not seen as relief.
            for _ in 0..8 {
                let Some((first, exit)) = best else { break };
                let way = exit.distance + ON;
                let mut next = None;
                self.for_holders(place.moved(t * way), &belongs, |holder| {
                    let exit = holder.body.exit(holder.m, t);
                    if next.is_none_or(|(_, b): (Holder, Exit)| exit.distance > b.distance) {
                        next = Some((holder, exit));
                    }
                });
                let Some((holder, exit)) = next else { break };
                best = Some((Holder { m: first.m, ..holder }, Exit { distance: way + exit.distance, ..exit }));
            }
        }
        best
    }

    /// Where particles overlap, those below win: the other half is then the complement all the same.
    fn tear(
        &self,
        place: Place,
        n: Vec3,
        side: Side,
        is_below: impl Fn([i32; 3], Vec3) -> bool,
        keep: impl Fn([i32; 3], Vec3, &Body) -> bool,
    ) -> Raw {
        let below = |cell, offset, body: &Body| is_below(cell, offset) && keep(cell, offset, body);
        let above = |cell, offset, body: &Body| !is_below(cell, offset) && keep(cell, offset, body);
        let (owner, found) = match self.farthest(place, n, below) {
            Some(found) => (Side::Below, Some(found)),
            None => (Side::Above, self.farthest(place, -n, above)),
        };
        let outward = if side == Side::Below { n } else { -n };
        let Some((holder, exit)) = found else { return Raw::matrix(outward, 0.0) };
        if owner == side {
            Raw {
                height: exit.distance,
                normal: exit.normal,
                kind: HitKind::Bump,
                particle: self.source.id(holder.cell),
                openness: 0.5 + 0.5 * exit.normal.dot(outward),
            }
        } else {
            self.cavity(&holder, exit, outward)
        }
    }

    /// Always the cavity; overlapping ones are one.
    fn hollow(&self, place: Place, n: Vec3, keep: impl Fn([i32; 3], Vec3, &Body) -> bool) -> Raw {
        match self.farthest(place, -n, keep) {
            Some((holder, exit)) => self.cavity(&holder, exit, n),
            None => Raw::matrix(n, 0.0),
        }
    }

    fn cavity(&self, holder: &Holder, exit: Exit, n: Vec3) -> Raw {
        Raw {
            height: -exit.distance,
            normal: -exit.normal,
            kind: HitKind::Cavity,
            particle: self.source.id(holder.cell),
            openness: holder.body.cavity_openness(holder.m, n, &exit),
        }
    }

    /// Flat discs, and a bevel of 45 degrees down to the matrix.
    fn solid(&self, place: Place, n: Vec3, keep: impl Fn([i32; 3], Vec3, &Body) -> bool) -> Raw {
        let full = self.spec.bevel;
        // Deepest by what matters: the gap as a part of the bevel it may have.
        let mut best = Raw::matrix(n, -full);
        for_cells(self.n_rings_solid, |step| {
            let cell = add(place.cell, step);
            let offset = self.offset(cell);
            let m = place.local - (vec3(step[0] as f32, step[1] as f32, step[2] as f32) + offset);
            let wide = self.reach + full;
            if m.dot(m) > wide * wide {
                return;
            }
            let free = self.free_body(cell);
            let grown = self.grown(free);
            if !grown.meets(m, n) || grown.gap(m, n).distance >= full {
                return;
            }
            let body = free.scaled(self.scale(cell, offset, &free));
            if !body.meets(m, n) || !keep(cell, offset, &body) {
                return;
            }
            let gap = body.gap(m, n);
            let bevel = if self.spec.bevel_within_particle { full.min(body.reach() * 0.5) } else { full };
            // Where the bevel is narrower than the recess it is as much less deep.
            if gap.distance >= bevel || -gap.distance.max(0.0) <= best.height {
                return;
            }
            let id = self.source.id(cell);
            best = if gap.distance <= 0.0 {
                Raw { height: 0.0, normal: n, kind: HitKind::Disc, particle: id, openness: 1.0 }
            } else {
                let normal = (n + gap.away).normalize_or(n);
                let openness = 0.5 + 0.5 * normal.dot(n);
                Raw { height: -gap.distance, normal, kind: HitKind::Bevel, particle: id, openness }
            };
        });
        best
    }
}
