//! Particles of several sizes: gravel and sand that keep apart, or bubbles that join.

use super::eval::{Candidate, Hit, HitKind, SectionKind};
use super::particle::{add, for_cells};
use super::question::Question;
use super::shape::Convex;
use super::spec::parameter;
use super::{Cells, Grain};
use crate::Result;
use crate::math::{DVec3, Vec3, vec3};

/// How particles of different sizes share the room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mixing {
    /// A particle nearer than this to a larger one is left out, whole; model units.
    Apart(f32),
    /// They stay where they are: hollows run into each other. Torn, those of an earlier grain win.
    Joined,
}

/// Particles of one size.
#[derive(Clone, Debug)]
pub enum Size {
    /// Of a grain.
    Grain(Box<Grain>),
    /// Cells, best with wide walls or not all of them there: broken stone.
    Cells(Box<Cells>),
}

impl Size {
    fn spacing(&self) -> f32 {
        match self {
            Self::Grain(grain) => grain.spec().spacing,
            Self::Cells(cells) => cells.spec().spacing,
        }
    }

    fn eval_where(&self, p: DVec3, question: &Question, keep: &dyn Fn(&Candidate) -> bool) -> Hit {
        match self {
            Self::Grain(grain) => grain.eval_where(p, &question.surface, question.look, keep),
            Self::Cells(cells) => {
                // Its mean radius: a cell's corners may come nearer to coarser particles.
                let reach = 0.5 * (cells.spec().spacing - cells.spec().wall);
                let keep = |c: &Candidate| keep(&Candidate { reach, ..*c });
                cells.eval_where(p, &question.surface, question.look, keep)
            }
        }
    }

    /// Whether a ball is at least `gap` away from all particles.
    fn is_free(&self, center: DVec3, reach: f32, gap: f32) -> bool {
        match self {
            Self::Grain(grain) => grain.clearance(center, reach) >= reach + gap,
            Self::Cells(cells) => cells.clearance(center) >= reach + gap,
        }
    }
}

/// Particles of several sizes, from the coarsest to the finest, the first with the matrix.
#[derive(Clone, Debug)]
pub struct Scales {
    sizes: Vec<Size>,
    mixing: Mixing,
}

/// Hollows in a row that one ray goes through at most: what is deeper is dark.
const MOST_JOINED: usize = 4;

impl Scales {
    /// Of several sizes, the coarsest first.
    ///
    /// # Errors
    /// No size or more than eight; a gap below zero.
    pub fn new(sizes: Vec<Size>, mixing: Mixing) -> Result<Self> {
        if sizes.is_empty() || sizes.len() > 8 {
            return Err(parameter("sizes", sizes.len(), "one to eight"));
        }
        match mixing {
            Mixing::Apart(gap) if !(gap >= 0.0 && gap.is_finite()) => {
                Err(parameter("gap", gap, "it is a length, zero or above"))
            }
            _ => Ok(Self { sizes, mixing }),
        }
    }

    /// The sizes.
    pub fn sizes(&self) -> &[Size] {
        &self.sizes
    }

    /// How they share the room.
    pub fn mixing(&self) -> Mixing {
        self.mixing
    }

    pub(super) fn answer(&self, p: DVec3, question: &Question) -> Hit {
        match (self.mixing, question.look.kind) {
            (Mixing::Joined, SectionKind::Hollow) => self.joined(p, question),
            _ => self.first(p, question),
        }
    }

    /// Whether a particle of the `k`th size has room beside all larger ones.
    pub(super) fn has_room(&self, k: usize, c: &Candidate) -> bool {
        match self.mixing {
            Mixing::Joined => true,
            Mixing::Apart(gap) => self.sizes[..k].iter().all(|s| s.is_free(c.center, c.reach, gap)),
        }
    }

    /// The grain's answer without the particles that a coarser one has no room for.
    fn of(&self, k: usize, p: DVec3, question: &Question) -> Hit {
        let keep = |c: &Candidate| (question.keep)(c) && self.has_room(k, c);
        let hit = self.sizes[k].eval_where(p, question, &keep);
        let leaf = if hit.kind == HitKind::Matrix { 0 } else { k as u16 };
        Hit { leaf, ..hit }
    }

    /// The first that has a particle there, or what is higher.
    fn first(&self, p: DVec3, question: &Question) -> Hit {
        let mut best = self.of(0, p, question);
        for k in 1..self.sizes.len() {
            if !Self::is_open(&best, question.look.kind) {
                break;
            }
            best = Self::higher(best, self.of(k, p, question), question.look.kind);
        }
        best
    }

    /// Whether smaller particles may be seen there.
    fn is_open(best: &Hit, kind: SectionKind) -> bool {
        match best.kind {
            HitKind::Matrix => true,
            HitKind::Bevel => kind == SectionKind::Solid,
            _ => false,
        }
    }

    /// Of what larger particles show and what smaller ones do: between hard particles the highest, as the bevels of one may
    /// run over those of another, and the matrix lies as deep as the coarsest have it.
    pub(super) fn higher(best: Hit, hit: Hit, kind: SectionKind) -> Hit {
        let is_better = hit.kind != HitKind::Matrix && (best.kind == HitKind::Matrix || hit.height > best.height);
        if Self::is_open(&best, kind) && is_better { hit } else { best }
    }

    /// The way down through hollows that run into each other.
    fn joined(&self, p: DVec3, question: &Question) -> Hit {
        let outward = question.outward(p);
        let mut best = question.plain(p);
        for _ in 0..MOST_JOINED {
            // A little on, so that the ray is in the next hollow and not on the rim of the last; nothing at the section.
            let on = if best.height < 0.0 { 1e-5 * self.sizes[0].spacing() } else { 0.0 };
            let way = (on - best.height) as f64;
            let from = p - outward * way;
            let mut next: Option<Hit> = None;
            for k in 0..self.sizes.len() {
                let hit = self.of(k, from, question);
                if hit.kind == HitKind::Cavity && next.is_none_or(|n| hit.height < n.height) {
                    next = Some(hit);
                }
            }
            let Some(hit) = next else { break };
            // Sky reaches the next hollow through the last.
            let openness = if best.kind == HitKind::Cavity { hit.openness * best.openness } else { hit.openness };
            best = Hit { height: hit.height - way as f32, openness, ..hit };
        }
        best
    }
}

impl Grain {
    /// At least how far a point is from all particles, as far as that is less than twice `far`; model units.
    ///
    /// By separating planes across the line of centres: never too much, a little too small beside long particles.
    pub fn clearance(&self, p: DVec3, far: f32) -> f32 {
        let spacing = self.spec.spacing;
        let place = self.place(p);
        let most = 2.0 * far / spacing;
        let rings = (self.reach + most + self.spec.jitter - 0.5).ceil().max(0.0) as i32;
        let mut least = most;
        for_cells(rings, |step| {
            let cell = add(place.cell, step);
            let offset = self.offset(cell);
            let m: Vec3 = place.local - (vec3(step[0] as f32, step[1] as f32, step[2] as f32) + offset);
            let length = m.length();
            if length - self.reach >= least {
                return;
            }
            let free = self.free_body(cell);
            let body = free.scaled(self.scale(cell, offset, &free));
            let n = m.normalize_or(Vec3::Z);
            least = least.min(length - body.support(n).dot(n));
        });
        least * spacing
    }
}
