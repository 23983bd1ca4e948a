//! Grain without gaps: Voronoi and Laguerre cells, for metal, granite, tissue and foam.
//!
//! A place belongs to the seed with the least |x - x_i|^2 - w_i; seeds stand on a perturbed lattice, in a space that may be
//! stretched. Walls part the cells: with a width, cells are convex particles that never touch; without, a tear runs along
//! the borders of whole cells, which is how crystals part between their grains. Each cell goes with the half that holds
//! its seed.

use super::chance::Source;
use super::check::{positive, within};
use super::eval::{Candidate, Hit, HitKind, Look, SectionKind, Side};
use super::openness::form_factor;
use super::particle::{add, for_cells};
use super::shape::{Gap, N_OPENING};
use super::soft::Soft;
use super::spec::{Chance, LatticeAxes};
use super::{lattice_rotation, place_of};
use crate::Result;
use crate::math::{DMat3, DVec3, Frame, Vec3, exact, hash_cell, vec3};
use crate::section::CutSurface;
use std::cell::RefCell;
use std::sync::atomic::{AtomicU64, Ordering};

/// Cells as a person describes them.
#[derive(Clone, Debug, PartialEq)]
pub struct CellsSpec {
    /// Mean distance of neighbouring seeds, model units, before stretching.
    pub spacing: f32,
    /// How far seeds move off the lattice's nodes along each axis, in spacings: 0 (cubes) to 0.5.
    pub jitter: f32,
    /// How much the cells' sizes differ: 0 is Voronoi's, up to 0.5 Laguerre's.
    pub weight_spread: f32,
    /// Width of the walls between cells, model units; 0 for none.
    pub wall: f32,
    /// How much longer cells are along the model's axes.
    pub stretch: Vec3,
    /// How the lattice lies.
    pub lattice: LatticeAxes,
    /// Depth and width of a solid cut's bevel, in spacings; at most half a wall.
    pub bevel: f32,
    /// Radius of the cells' rounded edges and corners, model units; 0 is sharp. Rounded cells without walls are torn one by
    /// one, not along the borders of whole heaps.
    pub rounding: f32,
    /// Which part of the cells is there; the others are matrix.
    pub share: f32,
    /// A ball in each cell, smaller than most.
    pub nucleus: Option<Nucleus>,
    /// Another seed, other cells.
    pub seed: u32,
}

/// The nucleus of a cell. Hollow, cells show the nuclei whose centre they hold, lying in them; solid, they are cut; torn,
/// they stay in their cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nucleus {
    /// Its radius, model units.
    pub radius: f32,
    /// How far it may be from the cell's seed, model units.
    pub offset: f32,
}

impl CellsSpec {
    /// Voronoi cells.
    pub fn of(spacing: f32, wall: f32) -> Self {
        let lattice = LatticeAxes::Turned;
        Self {
            spacing,
            jitter: 0.4,
            weight_spread: 0.0,
            wall,
            stretch: Vec3::ONE,
            lattice,
            bevel: 0.07,
            rounding: 0.0,
            share: 1.0,
            nucleus: None,
            seed: 0,
        }
    }
}

/// Checked cells, ready to be asked.
#[derive(Clone, Debug)]
pub struct Cells {
    /// No other cells have it, but copies of these.
    number: u64,
    pub(super) spec: CellsSpec,
    pub(super) source: Source,
    /// From model space to spacings, stretched back.
    pub(super) lattice_from_model: DMat3,
    pub(super) model_from_lattice: DMat3,
}

/// A cell's seed, seen from the lattice's node nearest to the place asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seed {
    pub(super) cell: [i32; 3],
    pub(super) at: Vec3,
    pub(super) weight: f32,
}

/// Where a ray leaves a cell.
#[derive(Clone, Copy)]
struct Way {
    /// In model units.
    length: f32,
    /// The seed of the cell it comes into.
    to: Seed,
}

impl Cells {
    /// Cells from their description.
    ///
    /// # Errors
    /// A number that makes no sense.
    pub fn new(spec: CellsSpec) -> Result<Self> {
        positive("spacing", spec.spacing)?;
        within("jitter", spec.jitter, 0.0..=0.5, "from 0 to 0.5 spacings")?;
        within("weight spread", spec.weight_spread, 0.0..=0.5, "from 0 to 0.5")?;
        within("wall", spec.wall, 0.0..=spec.spacing, "from 0 to a spacing")?;
        within("bevel", spec.bevel, 0.0..=0.5, "from 0 to 0.5 spacings")?;
        super::mottle::stretch(spec.stretch)?;
        within("rounding", spec.rounding, 0.0..=spec.spacing, "from 0 to a spacing")?;
        within("share", spec.share, 0.0..=1.0, "from 0 to 1")?;
        if let Some(nucleus) = spec.nucleus {
            positive("nucleus radius", nucleus.radius)?;
            within("nucleus radius", nucleus.radius, 0.0..=spec.spacing, "at most a spacing")?;
            within("nucleus offset", nucleus.offset, 0.0..=spec.spacing, "from 0 to a spacing")?;
        }
        let rotation = lattice_rotation(spec.lattice);
        let stretch = spec.stretch.as_dvec3();
        let size = spec.spacing as f64;
        static NUMBERS: AtomicU64 = AtomicU64::new(1);
        Ok(Self {
            number: NUMBERS.fetch_add(1, Ordering::Relaxed),
            source: Source { chance: Chance::Hash, seed: spec.seed },
            lattice_from_model: rotation.transpose() * DMat3::from_diagonal(1.0 / (stretch * size)),
            model_from_lattice: DMat3::from_diagonal(stretch * size) * rotation,
            spec,
        })
    }

    /// The description they were made from.
    pub fn spec(&self) -> &CellsSpec {
        &self.spec
    }

    /// Whether all cells are there, with sharp edges and nothing in them.
    pub(super) fn is_sharp(&self) -> bool {
        self.spec.rounding == 0.0 && self.spec.share >= 1.0 && self.spec.nucleus.is_none()
    }

    /// The name of the cell that a point is in, and how far the point is from its wall: model units, negative in it.
    pub(super) fn room(&self, p: DVec3) -> (u32, f32) {
        let (node, local) = place_of(self.lattice_from_model * p);
        self.with_near(node, |near| {
            let asked = Asked { cells: self, node, local, near, is_all: false };
            let seed = asked.owner(local);
            (self.source.id(seed.cell), asked.wall_distance(seed) - self.spec.wall * 0.5)
        })
    }

    /// What a cut shows at a point of it, in model space; see [`Grain::eval`](super::Grain::eval). Where cells have no walls,
    /// a cavity's openness is only that of its slope.
    pub fn eval(&self, p: DVec3, surface: &impl CutSurface, look: Look) -> Hit {
        self.eval_where(p, surface, look, |_| true)
    }

    /// The same without the cells that `keep` refuses; they count as matrix.
    pub fn eval_where(
        &self,
        p: DVec3,
        surface: &impl CutSurface,
        look: Look,
        keep: impl Fn(&Candidate) -> bool,
    ) -> Hit {
        let (node, local) = place_of(self.lattice_from_model * p);
        self.with_near(node, |near| self.eval_among((p, node, local), surface, look, keep, (near, false)))
    }

    /// The same from a list of seeds, with the place on the lattice; `is_all` if no others matter.
    pub(super) fn eval_among(
        &self,
        (p, node, local): (DVec3, [i32; 3], Vec3),
        surface: &impl CutSurface,
        look: Look,
        keep: impl Fn(&Candidate) -> bool,
        (near, is_all): (&[Seed], bool),
    ) -> Hit {
        let n = surface.normal(p);
        let outward = if look.side == Side::Below { n } else { -n };
        let asked = Asked { cells: self, node, local, near, is_all };
        let seed = asked.owner(local);
        let matrix = |height| Hit::matrix(outward.as_vec3(), height);
        let center = asked.model(seed);
        let reach = 2.0 * self.spec.spacing * self.spec.stretch.max_element();
        let id = self.source.id(seed.cell);
        let rest = if look.kind == SectionKind::Solid { -self.bevel() } else { 0.0 };
        if !self.is_there(seed) || !keep(&Candidate { cell: seed.cell, id, center, reach }) {
            return matrix(rest);
        }
        let half_wall = self.spec.wall * 0.5;
        let is_below = |s: Seed| surface.distance(asked.model(s)) <= 0.0;
        let soft = match self.spec.rounding > 0.0 {
            true => Soft::of(&asked, seed, self.spec.wall, self.spec.rounding),
            false => None,
        };
        if self.spec.rounding > 0.0 && soft.as_ref().is_none_or(|s| !s.holds()) && look.kind != SectionKind::Solid {
            return matrix(0.0);
        }
        if look.kind == SectionKind::Solid {
            let hit = match &soft {
                Some(soft) => self.beveled(soft.gap(outward.as_vec3()), outward, id),
                None if self.spec.rounding > 0.0 => matrix(rest),
                None => self.solid(&asked, seed, outward, id),
            };
            let is_cut =
                hit.kind == HitKind::Disc && self.nucleus(seed, &asked).is_some_and(|(c, r)| p.distance(c) < r);
            return Hit { leaf: is_cut as u16, ..hit };
        }
        if soft.is_none() && asked.wall_distance(seed) < half_wall {
            return matrix(0.0);
        }
        // Out of the half that holds the cell, or into the half that has its cavity.
        let below = is_below(seed);
        let t = match look.kind {
            SectionKind::Tear => {
                if below {
                    n
                } else {
                    -n
                }
            }
            _ => -outward,
        };
        let goes_on = |s: Seed| self.spec.wall == 0.0 && look.kind == SectionKind::Tear && is_below(s) == below;
        let (length, normal) = match &soft {
            Some(soft) => soft.exit(t.as_vec3()),
            None => asked.walk(seed, t, goes_on),
        };
        if look.kind == SectionKind::Hollow
            && let Some((height, normal)) = self.nucleus(seed, &asked).and_then(|n| lying(n, p, outward, length))
        {
            let openness = (0.5 + 0.5 * normal.dot(outward.as_vec3())) * 0.8;
            return Hit { height, normal, kind: HitKind::Bump, particle: id, openness, leaf: 1, tone: 0.0 };
        }
        let is_bump = look.kind == SectionKind::Tear && below == (look.side == Side::Below);
        let sign = if is_bump { 1.0 } else { -1.0 };
        let normal = normal * sign;
        Hit {
            height: length * sign,
            normal,
            kind: if is_bump { HitKind::Bump } else { HitKind::Cavity },
            particle: id,
            openness: match (is_bump || self.spec.wall == 0.0, &soft) {
                (false, Some(soft)) => soft.openness(length, normal, outward),
                (true, _) => 0.5 + 0.5 * normal.dot(outward.as_vec3()).clamp(-1.0, 1.0),
                (false, None) => asked.openness(seed, length, normal, outward),
            },
            leaf: 0,
            tone: 0.0,
        }
    }

    fn is_there(&self, seed: Seed) -> bool {
        self.spec.share >= 1.0 || self.source.even(seed.cell)[0] < self.spec.share
    }

    /// How far a point is from all cells that are there, model units; zero in one.
    pub(super) fn clearance(&self, p: DVec3) -> f32 {
        let (node, local) = place_of(self.lattice_from_model * p);
        self.with_near(node, |near| self.clearance_of(&Asked { cells: self, node, local, near, is_all: false }))
    }

    fn clearance_of(&self, asked: &Asked) -> f32 {
        let local = asked.local;
        let seed = asked.owner(local);
        if self.is_there(seed) {
            return (self.spec.wall * 0.5 - asked.wall_distance(seed)).max(0.0);
        }
        let mut least = f32::INFINITY;
        asked.for_seeds(local, |s| {
            if s.cell != seed.cell && self.is_there(s) {
                let (value, gradient) = asked.border(seed, s, local);
                least = least.min(value / gradient.length() + self.spec.wall * 0.5);
            }
        });
        least
    }

    /// Where a cell's nucleus is, and its radius; model space.
    fn nucleus(&self, seed: Seed, asked: &Asked) -> Option<(DVec3, f64)> {
        let nucleus = self.spec.nucleus?;
        let off = self.source.tilt(seed.cell).as_dvec3() * (nucleus.offset as f64 / 3f64.sqrt());
        Some((asked.model(seed) + off, nucleus.radius as f64))
    }

    /// At most half a wall, so that neighbours' bevels do not meet; model units.
    fn bevel(&self) -> f32 {
        (self.spec.bevel * self.spec.spacing).min(self.spec.wall * 0.5)
    }

    /// Flat cells with bevels down to the walls.
    fn solid(&self, asked: &Asked, seed: Seed, outward: DVec3, id: u32) -> Hit {
        let (distance, away) = asked.gap(seed, outward.as_vec3());
        self.beveled(Gap { distance, away }, outward, id)
    }

    fn beveled(&self, Gap { distance: gap, away }: Gap, outward: DVec3, id: u32) -> Hit {
        let normal = outward.as_vec3();
        let t = self.bevel();
        if gap <= 0.0 {
            Hit { kind: HitKind::Disc, particle: id, ..Hit::matrix(normal, 0.0) }
        } else if gap < t {
            let normal = (normal + away).normalize_or(normal);
            Hit {
                height: -gap,
                normal,
                kind: HitKind::Bevel,
                particle: id,
                openness: 0.5 + 0.5 * normal.dot(outward.as_vec3()),
                leaf: 0,
                tone: 0.0,
            }
        } else {
            Hit::matrix(normal, -t)
        }
    }
}

/// The upper side of a ball that lies in a hollow so deep below a place, if a half has it: height and normal.
fn lying((center, radius): (DVec3, f64), p: DVec3, outward: DVec3, depth: f32) -> Option<(f32, Vec3)> {
    let m = p - center;
    let above = m.dot(outward);
    let across = m - outward * above;
    let squared = radius * radius - across.length_squared();
    // Its centre is in the other half, or it is beside the ray.
    if above < 0.0 || squared <= 0.0 {
        return None;
    }
    let rise = squared.sqrt();
    let height = (rise - above) as f32;
    (height > -depth).then(|| (height, ((across + outward * rise) / radius).as_vec3()))
}

/// The seeds around a node of some cells.
#[derive(Default)]
struct Near {
    /// The cells' number; 0 for none.
    cells: u64,
    node: [i32; 3],
    seeds: Vec<Seed>,
}

/// How many nodes a thread remembers.
const N_NEAR: usize = 64;

thread_local! {
    /// The seeds around nodes that were asked for lately: places are asked for beside each other, and to draw their seeds
    /// anew takes most of the time.
    static NEAR: RefCell<Vec<Near>> = const { RefCell::new(Vec::new()) };
}

impl Cells {
    /// Calls `ask` with the seeds around a node. What it asks may ask for others.
    fn with_near<R>(&self, node: [i32; 3], ask: impl FnOnce(&[Seed]) -> R) -> R {
        let slot = hash_cell(node[0], node[1], node[2], self.number as u32) as usize % N_NEAR;
        let mut near = NEAR.with_borrow_mut(|all| {
            all.resize_with(N_NEAR, Near::default);
            std::mem::take(&mut all[slot])
        });
        if near.cells != self.number || near.node != node {
            (near.cells, near.node) = (self.number, node);
            near.seeds.clear();
            seeds(self, node, [0; 3], |s| near.seeds.push(s));
        }
        let answer = ask(&near.seeds);
        NEAR.with_borrow_mut(|all| all[slot] = near);
        answer
    }
}

/// A place that is asked about, with its nearest node.
pub(super) struct Asked<'a> {
    cells: &'a Cells,
    node: [i32; 3],
    pub(super) local: Vec3,
    /// The seeds around it.
    near: &'a [Seed],
    /// Whether no other seeds matter, wherever a way from the place leads.
    is_all: bool,
}

/// Rings of nodes around a place among which its nearest seeds are: one at a third ring is farther than two spacings, the
/// own is nearer than sqrt 3.
const RINGS: i32 = 2;

impl Cells {
    /// A cell's seed, seen from a node.
    pub(super) fn seed_from(&self, node: [i32; 3], cell: [i32; 3]) -> Seed {
        let from: [i32; 3] = std::array::from_fn(|k| cell[k].wrapping_sub(node[k]));
        let at = vec3(from[0] as f32, from[1] as f32, from[2] as f32) + self.source.center(cell) * self.spec.jitter;
        Seed { cell, at, weight: self.source.sizes(cell)[0] * self.spec.weight_spread }
    }
}

/// Calls `visit` with the seeds of the nodes around `middle`, a step from `node`.
fn seeds(cells: &Cells, node: [i32; 3], middle: [i32; 3], mut visit: impl FnMut(Seed)) {
    for_cells(RINGS, |ring| {
        let from = add(middle, ring);
        let cell = add(node, from);
        let at = vec3(from[0] as f32, from[1] as f32, from[2] as f32) + cells.source.center(cell) * cells.spec.jitter;
        // Most cells have no weights: two draws less for each seed.
        let spread = cells.spec.weight_spread;
        let weight = if spread > 0.0 { cells.source.sizes(cell)[0] * spread } else { 0.0 };
        visit(Seed { cell, at, weight });
    });
}

impl Asked<'_> {
    /// Calls `visit` with the seeds around a place.
    pub(super) fn for_seeds(&self, around: Vec3, mut visit: impl FnMut(Seed)) {
        let step = (around + Vec3::splat(0.5)).floor();
        match [step.x as i32, step.y as i32, step.z as i32] {
            _ if self.is_all => self.near.iter().for_each(|s| visit(*s)),
            [0, 0, 0] => self.near.iter().for_each(|s| visit(*s)),
            middle => seeds(self.cells, self.node, middle, visit),
        }
    }

    /// The seed whose cell a place is in.
    fn owner(&self, x: Vec3) -> Seed {
        let mut best = (f32::INFINITY, Seed { cell: self.node, at: Vec3::ZERO, weight: 0.0 });
        self.for_seeds(x, |s| {
            let power = (x - s.at).length_squared() - s.weight;
            if power < best.0 {
                best = (power, s);
            }
        });
        best.1
    }

    fn model(&self, s: Seed) -> DVec3 {
        let node = DVec3::new(self.node[0] as f64, self.node[1] as f64, self.node[2] as f64);
        self.cells.model_from_lattice * (node + s.at.as_dvec3())
    }

    /// How much of the sky a cavity's wall sees, this deep below the place, through the cell's section: all the opening there
    /// is, as a wall parts it from the next.
    fn openness(&self, seed: Seed, depth: f32, normal: Vec3, outward: DVec3) -> f32 {
        let n = outward.as_vec3();
        let frame = Frame::about(n);
        let size = self.cells.spec.spacing * self.cells.spec.stretch.max_element();
        let step = std::f64::consts::TAU / N_OPENING as f64;
        let opening: [Vec3; N_OPENING] = std::array::from_fn(|k| {
            let (sin, cos) = (exact::sin(k as f64 * step) as f32, exact::cos(k as f64 * step) as f32);
            let t = frame.tangent * cos + frame.bitangent * sin;
            let along = (self.cells.lattice_from_model * t.as_dvec3()).as_vec3();
            t * self.way_out(seed, along, t, 0.0).map_or(size, |way| way.length)
        });
        form_factor(&opening, n * -depth, normal)
    }

    /// The border between two cells as a function that is positive in the first, and its gradient in model space.
    pub(super) fn border(&self, i: Seed, j: Seed, x: Vec3) -> (f32, Vec3) {
        let value = ((x - j.at).length_squared() - j.weight) - ((x - i.at).length_squared() - i.weight);
        let gradient = self.cells.lattice_from_model.transpose() * ((i.at - j.at) * 2.0).as_dvec3();
        (value, gradient.as_vec3())
    }

    /// From the place to the nearest border of its cell, model units.
    fn wall_distance(&self, seed: Seed) -> f32 {
        let mut least = f32::INFINITY;
        self.for_seeds(self.local, |s| {
            if s.cell != seed.cell {
                let (value, gradient) = self.border(seed, s, self.local);
                least = least.min(value / gradient.length());
            }
        });
        least
    }

    /// How far in the section, and which way, the place is outside of its cell without its share of the walls.
    fn gap(&self, seed: Seed, n: Vec3) -> (f32, Vec3) {
        let mut gap = (f32::NEG_INFINITY, Vec3::ZERO);
        self.for_seeds(self.local, |s| {
            if s.cell != seed.cell {
                let (value, gradient) = self.border(seed, s, self.local);
                let length = gradient.length();
                let face = -gradient / length;
                let slope = face - n * face.dot(n);
                let steep = slope.length();
                let outside = (self.cells.spec.wall * 0.5 - value / length) / steep;
                if steep > 1e-6 && outside > gap.0 {
                    gap = (outside, slope / steep);
                }
            }
        });
        gap
    }

    /// From the place along a unit vector of the model to the end of its cell, or of the last that it goes on through:
    /// length and outward unit normal.
    fn walk(&self, seed: Seed, t: DVec3, goes_on: impl Fn(Seed) -> bool) -> (f32, Vec3) {
        let along = (self.cells.lattice_from_model * t).as_vec3();
        let (mut seed, mut done) = (seed, 0.0);
        // A run of cells of one side is short; a longer one ends here.
        const MANY: usize = 32;
        for step in 0..MANY {
            let Some(way) = self.way_out(seed, along, t.as_vec3(), done) else { break };
            done = way.length;
            if step + 1 == MANY || !goes_on(way.to) {
                let x = self.local + along * done;
                let (_, gradient) = self.border(seed, way.to, x);
                return (done, (-gradient).normalize_or(t.as_vec3()));
            }
            seed = way.to;
        }
        (done, t.as_vec3())
    }

    /// The end of a cell along a ray, no nearer than `from`. Asked first of the seeds around the ray's start, then of those
    /// around the end found, until no other is nearer.
    fn way_out(&self, seed: Seed, along: Vec3, t: Vec3, from: f32) -> Option<Way> {
        let mut best: Option<Way> = None;
        let mut around = self.local + along * from;
        for _ in 0..8 {
            let before = best.map(|w| w.length);
            self.for_seeds(around, |s| {
                if s.cell == seed.cell {
                    return;
                }
                let (value, gradient) = self.border(seed, s, self.local);
                let fall = -gradient.dot(t);
                let half_wall = self.cells.spec.wall * 0.5;
                let wall = if half_wall > 0.0 { half_wall * gradient.length() } else { 0.0 };
                if fall > 0.0 {
                    let length = ((value - wall) / fall).max(from);
                    if best.is_none_or(|b| length < b.length) {
                        best = Some(Way { length, to: s });
                    }
                }
            });
            let found = best?.length;
            if self.is_all || before == Some(found) {
                break;
            }
            around = self.local + along * found;
        }
        best
    }
}
