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
use super::shape::N_OPENING;
use super::spec::{Chance, LatticeAxes, parameter};
use super::{lattice_rotation, place_of};
use crate::Result;
use crate::math::{DMat3, DVec3, Frame, Vec3, exact, vec3};
use crate::section::CutSurface;

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
    /// Another seed, other cells.
    pub seed: u32,
}

impl CellsSpec {
    /// Voronoi cells.
    pub fn of(spacing: f32, wall: f32) -> Self {
        let lattice = LatticeAxes::Turned;
        Self { spacing, jitter: 0.4, weight_spread: 0.0, wall, stretch: Vec3::ONE, lattice, bevel: 0.07, seed: 0 }
    }
}

/// Checked cells, ready to be asked.
#[derive(Clone, Debug)]
pub struct Cells {
    spec: CellsSpec,
    source: Source,
    /// From model space to spacings, stretched back.
    lattice_from_model: DMat3,
    model_from_lattice: DMat3,
}

/// A cell's seed, seen from the lattice's node nearest to the place asked for.
#[derive(Clone, Copy, Debug)]
struct Seed {
    cell: [i32; 3],
    at: Vec3,
    weight: f32,
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
        if !(spec.stretch.is_finite() && spec.stretch.min_element() >= 0.05 && spec.stretch.max_element() <= 20.0) {
            let given = format!("{},{},{}", spec.stretch.x, spec.stretch.y, spec.stretch.z);
            return Err(parameter("stretch", given, "three numbers from 0.05 to 20"));
        }
        let rotation = lattice_rotation(spec.lattice);
        let stretch = spec.stretch.as_dvec3();
        let size = spec.spacing as f64;
        Ok(Self {
            source: Source { chance: Chance::Hash, seed: spec.seed },
            lattice_from_model: rotation.transpose() * DMat3::from_diagonal(1.0 / (stretch * size)),
            model_from_lattice: DMat3::from_diagonal(stretch * size) * rotation,
            spec,
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
        self.eval_cached(p, surface, look, keep, &mut CellsCache::default())
    }

    /// The same with the seeds of the last place asked for at hand: several times faster where places are neighbours.
    pub fn eval_cached(
        &self,
        p: DVec3,
        surface: &impl CutSurface,
        look: Look,
        keep: impl Fn(&Candidate) -> bool,
        cache: &mut CellsCache,
    ) -> Hit {
        let (node, local) = place_of(self.lattice_from_model * p);
        let n = surface.normal(p);
        let outward = if look.side == Side::Below { n } else { -n };
        cache.move_to(self, node);
        let asked = Asked { cells: self, node, local, near: &cache.seeds };
        let seed = asked.owner(local);
        let matrix = |height| {
            let normal = outward.as_vec3();
            Hit { height, normal, kind: HitKind::Matrix, particle: Hit::MATRIX, openness: 1.0 }
        };
        let center = asked.model(seed);
        let reach = 2.0 * self.spec.spacing * self.spec.stretch.max_element();
        let id = self.source.id(seed.cell);
        let rest = if look.kind == SectionKind::Solid { -self.bevel() } else { 0.0 };
        if !keep(&Candidate { cell: seed.cell, id, center, reach }) {
            return matrix(rest);
        }
        let half_wall = self.spec.wall * 0.5;
        let is_below = |s: Seed| surface.distance(asked.model(s)) <= 0.0;
        if look.kind == SectionKind::Solid {
            return self.solid(&asked, seed, outward, id);
        }
        if asked.wall_distance(seed) < half_wall {
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
        let (length, normal) = asked.walk(seed, t, goes_on);
        let is_bump = look.kind == SectionKind::Tear && below == (look.side == Side::Below);
        let sign = if is_bump { 1.0 } else { -1.0 };
        let normal = normal * sign;
        Hit {
            height: length * sign,
            normal,
            kind: if is_bump { HitKind::Bump } else { HitKind::Cavity },
            particle: id,
            openness: match is_bump || self.spec.wall == 0.0 {
                true => 0.5 + 0.5 * normal.dot(outward.as_vec3()).clamp(-1.0, 1.0),
                false => asked.openness(seed, length, normal, outward),
            },
        }
    }

    /// At most half a wall, so that neighbours' bevels do not meet; model units.
    fn bevel(&self) -> f32 {
        (self.spec.bevel * self.spec.spacing).min(self.spec.wall * 0.5)
    }

    /// Flat cells with bevels down to the walls.
    fn solid(&self, asked: &Asked, seed: Seed, outward: DVec3, id: u32) -> Hit {
        let normal = outward.as_vec3();
        let t = self.bevel();
        let (gap, away) = asked.gap(seed, normal);
        if gap <= 0.0 {
            Hit { height: 0.0, normal, kind: HitKind::Disc, particle: id, openness: 1.0 }
        } else if gap < t {
            let normal = (normal + away).normalize_or(normal);
            Hit {
                height: -gap,
                normal,
                kind: HitKind::Bevel,
                particle: id,
                openness: 0.5 + 0.5 * normal.dot(outward.as_vec3()),
            }
        } else {
            Hit { height: -t, normal, kind: HitKind::Matrix, particle: Hit::MATRIX, openness: 1.0 }
        }
    }
}

/// The seeds around a node, kept from one place to the next. It belongs to one [`Cells`].
#[derive(Clone, Debug, Default)]
pub struct CellsCache {
    node: Option<[i32; 3]>,
    seeds: Vec<Seed>,
}

impl CellsCache {
    fn move_to(&mut self, cells: &Cells, node: [i32; 3]) {
        if self.node != Some(node) {
            self.node = Some(node);
            self.seeds.clear();
            seeds(cells, node, [0; 3], |s| self.seeds.push(s));
        }
    }
}

/// A place that is asked about, with its nearest node.
struct Asked<'a> {
    cells: &'a Cells,
    node: [i32; 3],
    local: Vec3,
    /// The seeds around it.
    near: &'a [Seed],
}

/// Rings of nodes around a place among which its nearest seeds are: one at a third ring is farther than two spacings, the
/// own is nearer than sqrt 3.
const RINGS: i32 = 2;

/// Calls `visit` with the seeds of the nodes around `middle`, a step from `node`.
fn seeds(cells: &Cells, node: [i32; 3], middle: [i32; 3], mut visit: impl FnMut(Seed)) {
    for_cells(RINGS, |ring| {
        let from = add(middle, ring);
        let cell = add(node, from);
        let at = vec3(from[0] as f32, from[1] as f32, from[2] as f32) + cells.source.center(cell) * cells.spec.jitter;
        visit(Seed { cell, at, weight: cells.source.sizes(cell)[0] * cells.spec.weight_spread });
    });
}

impl Asked<'_> {
    /// Calls `visit` with the seeds around a place.
    fn for_seeds(&self, around: Vec3, mut visit: impl FnMut(Seed)) {
        let step = (around + Vec3::splat(0.5)).floor();
        match [step.x as i32, step.y as i32, step.z as i32] {
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
    fn border(&self, i: Seed, j: Seed, x: Vec3) -> (f32, Vec3) {
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
                let wall = self.cells.spec.wall * 0.5 * gradient.length();
                if fall > 0.0 {
                    let length = ((value - wall) / fall).max(from);
                    if best.is_none_or(|b| length < b.length) {
                        best = Some(Way { length, to: s });
                    }
                }
            });
            let found = best?.length;
            if before == Some(found) {
                break;
            }
            around = self.local + along * found;
        }
        best
    }
}
