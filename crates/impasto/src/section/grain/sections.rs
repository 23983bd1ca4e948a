//! What a filling shows over a window of a plane, row by row: as [`Filling::eval`] has it, to the bit, but many times
//! faster, as all that the plane meets is found first.

use super::blocks::Blocks;
use super::bodies::Bodies;
use super::cells::Seed;
use super::eval::{Candidate, Hit, HitKind, Look, SectionKind};
use super::fibres::PieceList;
use super::filling::{Layer, layer_at};
use super::scales::{Mixing, Scales, Size};
use super::shape::{Body, Convex};
use super::slices::Breaks;
use super::{Cells, Fibres, Filling, Window, place_of};
use crate::math::{DMat3, DVec2, DVec3, vec2};
use crate::par::Level;
use crate::section::Plane;

/// A filling over a window of a plane.
pub struct Sections<'a> {
    filling: &'a Filling,
    plane: Plane,
    window: Window,
    look: Look,
    depth: &'a (dyn Fn(DVec3) -> f32 + Sync),
    /// None where there is nothing better than to ask place by place.
    part: Option<Part<'a>>,
}

/// What there is of each kind of filling.
enum Part<'a> {
    Plain,
    Bodies(Box<Bodies<'a>>),
    Cells(CellLists<'a>),
    Fibres(PieceLists<'a>),
    /// The coarsest first.
    Scales(Vec<Part<'a>>),
    Layers(&'a [Layer], Vec<Part<'a>>),
}

/// The cells that may matter in each block.
struct CellLists<'a> {
    cells: &'a Cells,
    blocks: Blocks,
    /// Where each block's begin.
    starts: Vec<u32>,
    list: Vec<[i32; 3]>,
    /// Cells that are refused.
    refused: Vec<[i32; 3]>,
}

/// The pieces of fibres that the plane goes through.
struct PieceLists<'a> {
    fibres: &'a Fibres,
    blocks: Blocks,
    pieces: Vec<([i32; 3], Breaks)>,
}

impl<'a> Sections<'a> {
    /// Finds what the plane meets in the window. `depth` tells how deep below the skin any point near the cut lies, model
    /// units.
    pub fn new(
        filling: &'a Filling,
        plane: &Plane,
        window: Window,
        look: Look,
        depth: &'a (dyn Fn(DVec3) -> f32 + Sync),
    ) -> Self {
        let part = Asked { plane, window: &window, look, depth }.part(filling, &|_| true);
        Self { filling, plane: *plane, window, look, depth, part }
    }

    /// What the section shows at places of a row: plane coordinates in the window's axes, model units. Those within the
    /// window are fast; `out` has as many entries as `xs`.
    pub fn row(&self, level: Level, y: f32, xs: &[f32], out: &mut [Hit]) {
        assert_eq!(xs.len(), out.len(), "a hit for each place");
        let is_in = |x: f32| {
            let (min, max) = (self.window.min, self.window.max);
            x >= min.x && x <= max.x && y >= min.y && y <= max.y
        };
        match &self.part {
            Some(part) if xs.iter().all(|&x| is_in(x)) => self.part_row(part, level, y, xs, out),
            _ => xs.iter().zip(out).for_each(|(&x, out)| *out = self.eval(x, y)),
        }
    }

    /// Whether there is a list, so that rows are fast.
    pub fn is_listed(&self) -> bool {
        self.part.is_some()
    }

    fn eval(&self, x: f32, y: f32) -> Hit {
        self.filling.eval(self.window.point(vec2(x, y)), &self.plane, self.look, &self.depth)
    }

    fn part_row(&self, part: &Part, level: Level, y: f32, xs: &[f32], out: &mut [Hit]) {
        match part {
            Part::Plain => out.fill(self.plain()),
            Part::Bodies(bodies) => bodies.row(level, y, xs, out),
            Part::Cells(cells) => cells.row(self, y, xs, out),
            Part::Fibres(fibres) => fibres.row(self, y, xs, out),
            Part::Scales(parts) => {
                let mut rows = vec![self.plain(); xs.len()];
                for (k, part) in parts.iter().enumerate() {
                    self.part_row(part, level, y, xs, &mut rows);
                    for (best, &hit) in out.iter_mut().zip(&rows) {
                        let hit = Hit { leaf: if hit.kind == HitKind::Matrix { 0 } else { k as u16 }, ..hit };
                        *best = if k == 0 { hit } else { Scales::higher(*best, hit, self.look.kind) };
                    }
                }
            }
            Part::Layers(layers, parts) => {
                let places: Vec<usize> = xs
                    .iter()
                    .map(|&x| layer_at(layers, (self.depth)(self.window.point(vec2(x, y)))).map_or(usize::MAX, |l| l.0))
                    .collect();
                let mut start = 0;
                while start < xs.len() {
                    let run = places[start..].iter().take_while(|&&k| k == places[start]).count();
                    let end = start + run;
                    match parts.get(places[start]) {
                        Some(part) => {
                            self.part_row(part, level, y, &xs[start..end], &mut out[start..end]);
                            let first = Layer::first_leaf(layers, places[start]);
                            out[start..end].iter_mut().for_each(|hit| hit.leaf += first);
                        }
                        None => out[start..end].fill(self.plain()),
                    }
                    start = end;
                }
            }
        }
    }

    fn plain(&self) -> Hit {
        Filling::Plain.eval(DVec3::ZERO, &self.plane, self.look, &|_| 0.0)
    }
}

/// What lists are made for.
struct Asked<'a, 'b> {
    plane: &'b Plane,
    window: &'b Window,
    look: Look,
    depth: &'a (dyn Fn(DVec3) -> f32 + Sync),
}

impl<'a> Asked<'a, '_> {
    fn part(&self, filling: &'a Filling, keep: &dyn Fn(&Candidate) -> bool) -> Option<Part<'a>> {
        let bodies = |grain, keep: &dyn Fn(&Candidate) -> bool| {
            Bodies::of(grain, (self.plane, self.window), self.look, keep).map(|b| Part::Bodies(Box::new(b)))
        };
        match filling {
            Filling::Particles(grain) => bodies(grain, keep),
            Filling::Cells(cells) if cells.is_sharp() => CellLists::of(cells, self, keep).map(Part::Cells),
            Filling::Fibres(fibres) => PieceLists::of(fibres, self, keep).map(Part::Fibres),
            Filling::Scales(scales) => {
                if scales.mixing() == Mixing::Joined && self.look.kind == SectionKind::Hollow {
                    // Rays go on through hollows that join.
                    return None;
                }
                let part = |k: usize| match &scales.sizes()[k] {
                    Size::Grain(grain) => bodies(grain, &|c: &Candidate| keep(c) && scales.has_room(k, c)),
                    Size::Cells(_) => None,
                };
                (0..scales.sizes().len()).map(part).collect::<Option<Vec<_>>>().map(Part::Scales)
            }
            Filling::Layers(layers) => {
                let part = |(k, layer): (usize, &'a Layer)| {
                    let is_in = |c: &Candidate| Layer::holds(layers, k, c, &self.depth) && keep(c);
                    self.part(&layer.filling, &is_in)
                };
                let parts = layers.iter().enumerate().map(part).collect::<Option<Vec<_>>>()?;
                Some(Part::Layers(layers, parts))
            }
            // What has no list of its own yet is asked place by place.
            _ => matches!(filling, Filling::Plain).then_some(Part::Plain),
        }
    }
}

impl<'a> PieceLists<'a> {
    fn of(fibres: &'a Fibres, asked: &Asked, keep: &dyn Fn(&Candidate) -> bool) -> Option<Self> {
        let turn = fibres.model_from_fibres.transpose();
        let axes = asked.window.axes.map(|a| (turn * a).as_vec3());
        let spacing = fibres.spec.spacing as f64;
        let bevel = if asked.look.kind == SectionKind::Solid { fibres.spec.bevel } else { 0.0 };
        let (mut pieces, mut boxes) = (Vec::new(), Vec::new());
        for (slice, breaks) in fibres.slices(asked.plane, asked.window, keep)? {
            // No gap is below the distance to the rod, so nothing farther than a bevel from it in both directions counts.
            let reach = |a| (slice.body.support(a).dot(a) + 2.0 * bevel) as f64 + 1e-4;
            let low = DVec2::new(reach(-axes[0]), reach(-axes[1]));
            let high = DVec2::new(reach(axes[0]), reach(axes[1]));
            let tight = tight_box(&slice.body, asked, (slice.at, slice.height / spacing, spacing), turn, bevel);
            let (low, high) = (slice.at - low * spacing, slice.at + high * spacing);
            boxes.push([low.max(tight[0]), high.min(tight[1])]);
            pieces.push((slice.particle.cell, breaks));
        }
        Some(Self { fibres, blocks: Blocks::of(asked.window, fibres.spec.spacing * 0.25, &boxes), pieces })
    }

    fn row(&self, sections: &Sections, y: f32, xs: &[f32], out: &mut [Hit]) {
        for (&x, out) in xs.iter().zip(out) {
            let at = vec2(x, y);
            let indices = self.blocks.index(at).map_or(&[][..], |b| self.blocks.list(b));
            let list = PieceList { pieces: &self.pieces, indices };
            let p = sections.window.point(at);
            *out = self.fibres.eval_among(p, &sections.plane, sections.look, |_| true, Some(list));
        }
    }
}

/// The box of an endless round bar's section about a fibre, with a bevel; plane coordinates, model units.
fn tight_box(
    body: &Body,
    asked: &Asked,
    (at, height, spacing): (DVec2, f64, f64),
    turn: DMat3,
    bevel: f32,
) -> [DVec2; 2] {
    let everywhere = [DVec2::splat(f64::NEG_INFINITY), DVec2::splat(f64::INFINITY)];
    let Body::Rod(rod) = body else { return everywhere };
    let n = turn * asked.plane.normal;
    let c = n.z.abs();
    if c < 1e-3 {
        return everywhere;
    }
    // The axis goes through the plane here; the ellipse around it is at most 1 / c long.
    let flat = DVec2::new((turn * asked.window.axes[0]).z, (turn * asked.window.axes[1]).z);
    let s = flat.length();
    let middle = if s > 1e-9 { at - flat / s * (height * s / n.z * spacing) } else { at };
    let radius = (rod.radius + 2.0 * bevel) as f64 * 1.001 + 1e-4;
    let along = if s > 1e-9 { flat / s } else { DVec2::X };
    let across = along.perp();
    let half = |k: usize| {
        let (a, b) = (along[k] / c, across[k]);
        radius * (a * a + b * b).sqrt() * spacing
    };
    let half = DVec2::new(half(0), half(1));
    [middle - half, middle + half]
}

impl<'a> CellLists<'a> {
    fn of(cells: &'a Cells, asked: &Asked, keep: &dyn Fn(&Candidate) -> bool) -> Option<Self> {
        let tubes = cells.tubes(asked.plane, asked.window, asked.look)?;
        let pitch = cells.spec.spacing * cells.spec.stretch.min_element() * 0.4;
        let blocks = Blocks::of(asked.window, pitch, &[]);
        let mut lists = Self { cells, blocks, starts: vec![0], list: Vec::new(), refused: Vec::new() };
        let mut near = Vec::new();
        for block in 0..lists.blocks.len() {
            tubes.cells_of(lists.blocks.bounds(block), &mut near);
            lists.list.extend_from_slice(&near);
            lists.starts.push(lists.list.len() as u32);
        }
        let mut all = lists.list.clone();
        all.sort_unstable();
        all.dedup();
        let reach = 2.0 * cells.spec.spacing * cells.spec.stretch.max_element();
        let candidate = |cell| Candidate { cell, id: cells.source.id(cell), center: cells.center(cell), reach };
        lists.refused = all.into_iter().filter(|&cell| !keep(&candidate(cell))).collect();
        Some(lists)
    }

    fn row(&self, sections: &Sections, y: f32, xs: &[f32], out: &mut [Hit]) {
        let mut seeds: Vec<Seed> = Vec::new();
        let mut known = None;
        for (&x, out) in xs.iter().zip(out) {
            let at = vec2(x, y);
            let p = sections.window.point(at);
            let (node, local) = place_of(self.cells.lattice_from_model * p);
            let Some(block) = self.blocks.index(at) else { continue };
            if known != Some((block, node)) {
                known = Some((block, node));
                seeds.clear();
                let range = self.starts[block] as usize..self.starts[block + 1] as usize;
                seeds.extend(self.list[range].iter().map(|&cell| self.cells.seed_from(node, cell)));
            }
            let keep = |c: &Candidate| self.refused.binary_search(&c.cell).is_err();
            let place = (p, node, local);
            *out = self.cells.eval_among(place, &sections.plane, sections.look, keep, (&seeds, true));
        }
    }
}
