//! The cells that a plane goes through near a window of it: each a convex polygon.
//!
//! A cell is what is left of space when the bisectors with its neighbours have cut off theirs; in the plane, lines cut a
//! square. A neighbour whose bisector is farther than the polygon's farthest corner cuts nothing (the security radius of
//! Voronoi codes), and beyond a radius that follows from the lattice no cell reaches.

use super::curve::{Curve, clip};
use super::discs::MAX_CELLS;
use super::eval::{Candidate, Look, SectionKind, Side};
use super::particle::{add, for_cells};
use super::slices::on_plane;
use super::{Cells, Window, place_of};
use crate::math::{DVec2, DVec3, vec2};
use crate::section::{CutSurface, Plane};

/// A cell that the plane goes through.
#[derive(Clone, Debug)]
pub(super) struct CellSlice {
    pub(super) particle: Candidate,
    /// Where its seed is, lattice coordinates, and its weight.
    pub(super) seed: (DVec3, f64),
    /// Whether its seed is below the plane or on it.
    pub(super) is_below: bool,
    /// Its section, walls included: plane coordinates, model units.
    pub(super) polygon: Vec<DVec2>,
    /// The cells whose borders, and their walls, cut it there.
    pub(super) neighbours: Vec<[i32; 3]>,
}

/// All seeds of a slab of columns, so that none is drawn twice.
struct Slab<'a> {
    cells: &'a Cells,
    /// The axis of the columns, and the two others.
    axes: [usize; 3],
    low: [i32; 2],
    n: [usize; 2],
    /// Lowest cell of each column, and how many there are.
    bottoms: Vec<i32>,
    depth: i32,
    seeds: Vec<(DVec3, f64)>,
}

impl Cells {
    fn seed(&self, cell: [i32; 3]) -> (DVec3, f64) {
        let node = DVec3::new(cell[0] as f64, cell[1] as f64, cell[2] as f64);
        let off = self.source.center(cell) * self.spec.jitter;
        (node + off.as_dvec3(), (self.source.sizes(cell)[0] * self.spec.weight_spread) as f64)
    }

    /// No point of a cell is farther from its seed, in the lattice: the seed of the point's own node is no farther than
    /// this without weights.
    fn radius(&self) -> f64 {
        let own = 0.5 + self.spec.jitter as f64;
        (3.0 * own * own + 2.0 * self.spec.weight_spread as f64).sqrt()
    }

    /// The plane along the lattice: its unit normal, and the distance of the origin.
    fn plane_in_lattice(&self, plane: &Plane) -> (DVec3, f64) {
        let n = self.model_from_lattice.transpose() * plane.normal;
        let length = n.length();
        (n / length, plane.offset / length)
    }

    /// The cells that a plane goes through in a window of it, and some beyond, in the lattice's order. None if there are
    /// millions.
    pub(super) fn slices(
        &self,
        plane: &Plane,
        window: &Window,
        keep: &dyn Fn(&Candidate) -> bool,
    ) -> Option<Vec<CellSlice>> {
        let slab = Slab::of(self, plane, window)?;
        let (n, offset) = self.plane_in_lattice(plane);
        let radius = self.radius();
        let rings = (2.0 * radius + 2.0 * self.spec.jitter as f64).floor() as i32;
        let mut steps = Vec::new();
        for_cells(rings, |step| steps.push(step));
        steps.retain(|s| *s != [0; 3]);
        steps.sort_by_key(|s| s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
        let mut slices = Vec::new();
        let mut room = Vec::new();
        slab.for_cells(|cell| {
            let seed = slab.seed(cell);
            if (seed.0.dot(n) - offset).abs() > radius {
                return;
            }
            if let Some(slice) = self.slice(cell, (plane, window), (&slab, &steps), &mut room)
                && keep(&slice.particle)
            {
                slices.push(slice);
            }
        });
        slices.sort_by_key(|s| s.particle.cell);
        Some(slices)
    }

    fn slice(
        &self,
        cell: [i32; 3],
        (plane, window): (&Plane, &Window),
        (slab, steps): (&Slab, &[[i32; 3]]),
        room: &mut Vec<DVec2>,
    ) -> Option<CellSlice> {
        let (at, weight) = slab.seed(cell);
        let center = self.model_from_lattice * at;
        let size = self.spec.spacing as f64 * self.spec.stretch.max_element() as f64;
        let far = self.radius() * size * 1.01;
        let middle = on_plane(window, center);
        if middle.cmplt(window.min.as_dvec2() - far).any() || middle.cmpgt(window.max.as_dvec2() + far).any() {
            return None;
        }
        let mut polygon =
            [(-far, -far), (far, -far), (far, far), (-far, far)].map(|(x, y)| middle + DVec2::new(x, y)).to_vec();
        // Lattice coordinates of a place of the plane are linear in it.
        let origin = self.lattice_from_model * window.origin - at;
        let [u, v] = window.axes.map(|a| self.lattice_from_model * a);
        let seen = |p: DVec2| origin + u * p.x + v * p.y;
        let farthest = |polygon: &[DVec2]| polygon.iter().map(|&p| seen(p).length_squared()).fold(0.0, f64::max);
        let mut reach = farthest(&polygon);
        for &step in steps {
            let (other, w) = slab.seed(add(cell, step));
            let to = other - at;
            let squared = to.length_squared();
            // The bisector: to . x = level.
            let level = 0.5 * (squared + weight - w);
            if level > 0.0 && level * level >= squared * reach {
                continue;
            }
            let above = |p: DVec2| to.dot(seen(p)) - level;
            if polygon.iter().any(|&p| above(p) > 0.0) {
                clip(&mut polygon, room, above);
                if polygon.is_empty() {
                    return None;
                }
                reach = farthest(&polygon);
            }
        }
        // No border is steeper in the model than this makes it: how far a wall reaches in the lattice.
        let half_wall =
            self.spec.wall as f64 * 0.5 / (self.spec.spacing * self.spec.stretch.min_element()) as f64 + 1e-4;
        let cuts = |step: &[i32; 3]| {
            let (other, w) = slab.seed(add(cell, *step));
            let to = other - at;
            let level = 0.5 * (to.length_squared() + weight - w) - half_wall * to.length();
            polygon.iter().any(|&p| to.dot(seen(p)) > level)
        };
        let neighbours = steps.iter().filter(|s| cuts(s)).map(|&step| add(cell, step)).collect();
        let reach = 2.0 * self.spec.spacing * self.spec.stretch.max_element();
        let particle = Candidate { cell, id: self.source.id(cell), center, reach };
        let is_below = plane.distance(center) <= 0.0;
        Some(CellSlice { particle, seed: (at, weight), is_below, polygon, neighbours })
    }

    /// The outline of a cell's section without its share of the walls.
    pub(super) fn outline(&self, slice: &CellSlice, window: &Window) -> Option<Curve> {
        let half_wall = self.spec.wall as f64 * 0.5;
        let (at, weight) = slice.seed;
        let (mut polygon, mut room) = (slice.polygon.clone(), Vec::new());
        let origin = self.lattice_from_model * window.origin - at;
        let [u, v] = window.axes.map(|a| self.lattice_from_model * a);
        for &neighbour in &slice.neighbours {
            let (other, w) = self.seed(neighbour);
            let to = other - at;
            // Distance in the model: the border's gradient there tells how far a step in the lattice is.
            let steep = (self.lattice_from_model.transpose() * to).length();
            let level = 0.5 * (to.length_squared() + weight - w) - half_wall * steep;
            clip(&mut polygon, &mut room, |p| to.dot(origin + u * p.x + v * p.y) - level);
        }
        Curve::polygon_of(&polygon)
    }
}

/// Which cells matter in a part of a plane: those that the part itself is in, and those that ways out of the plane along
/// its normal go through.
///
/// The owner's neighbours by whom a way ends own the points beyond. Where walls part the cells, a wall is that of the
/// owner of some point within half a wall.
pub(super) struct Tubes<'a> {
    slab: Slab<'a>,
    plane: Plane,
    window: Window,
    look: Look,
    /// Steps to the nodes of all cells that may own a place, from the nearest node's.
    steps: Vec<[i32; 3]>,
    /// What cuts the cells' sections, where it matters: the sky is seen through all of a cell's opening.
    openings: Vec<([i32; 3], Vec<[i32; 3]>)>,
}

/// Between the balls that make a tube, lattice units.
const STEP: f64 = 0.5;

impl Cells {
    /// None for a window of millions of cells.
    pub(super) fn tubes(&self, plane: &Plane, window: &Window, look: Look) -> Option<Tubes<'_>> {
        let slab = Slab::of(self, plane, window)?;
        let rings = (self.radius() + self.spec.jitter as f64 + 1.0).floor() as i32;
        let mut steps = Vec::new();
        for_cells(rings, |step| steps.push(step));
        let is_open = self.spec.wall > 0.0 && look.kind != SectionKind::Solid;
        let slices = if is_open { self.slices(plane, window, &|_| true)? } else { Vec::new() };
        let openings = slices.into_iter().map(|s| (s.particle.cell, s.neighbours)).collect();
        Some(Tubes { slab, plane: *plane, window: *window, look, steps, openings })
    }

    /// A seed in model space.
    pub(super) fn center(&self, cell: [i32; 3]) -> DVec3 {
        self.model_from_lattice * self.seed(cell).0
    }
}

impl Tubes<'_> {
    /// The cells that matter within a rectangle of the plane, in the lattice's order.
    pub(super) fn cells_of(&self, [low, high]: [DVec2; 2], out: &mut Vec<[i32; 3]>) {
        let cells = self.slab.cells;
        let point = |p: DVec2| {
            let [u, v] = self.window.axes;
            cells.lattice_from_model * (self.window.origin + u * p.x + v * p.y)
        };
        let middle = point((low + high) * 0.5);
        let corners = [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)].map(point);
        let radius = corners.iter().map(|c| c.distance(middle)).fold(0.0, f64::max);
        let wall = cells.spec.wall as f64 * 0.51;
        let dilation = wall / (cells.spec.spacing * cells.spec.stretch.min_element()) as f64 + 1e-4;
        out.clear();
        self.owners(middle, radius + 2.0 * dilation, out);
        if self.look.kind == SectionKind::Solid {
            return;
        }
        // Ways go on while they are in a cell of the side that is followed.
        let along = cells.lattice_from_model * self.plane.normal;
        let along = along / along.length();
        let round = (radius * radius + 0.25 * STEP * STEP).sqrt() + dilation;
        let own = out.clone();
        for sign in [1.0, -1.0] {
            let follows = |cell: &[i32; 3]| {
                let is_below = self.plane.distance(cells.model_from_lattice * self.slab.seed(*cell).0) <= 0.0;
                match self.look.kind {
                    SectionKind::Tear => is_below == (sign > 0.0),
                    _ => (self.look.side == Side::Above) == (sign > 0.0) && own.contains(cell),
                }
            };
            let mut ball = own.clone();
            let mut k = 0;
            while ball.iter().any(follows) && k < 64 {
                k += 1;
                ball.clear();
                self.owners(middle + along * (sign * STEP * (k as f64 - 0.5)), round, &mut ball);
                out.extend_from_slice(&ball);
            }
        }
        for cell in own {
            if let Ok(i) = self.openings.binary_search_by_key(&cell, |o| o.0) {
                out.extend_from_slice(&self.openings[i].1);
            }
        }
        out.sort_unstable();
        out.dedup();
    }

    /// The cells that own some point of a ball, and perhaps some more.
    fn owners(&self, middle: DVec3, radius: f64, out: &mut Vec<[i32; 3]>) {
        let node = place_of(middle).0;
        let far = self.slab.cells.radius() + radius;
        let mut best = (f64::INFINITY, DVec3::ZERO);
        let start = out.len();
        for &step in &self.steps {
            let cell = add(node, step);
            let (at, weight) = self.slab.seed(cell);
            let squared = (middle - at).length_squared();
            if squared <= far * far {
                out.push(cell);
                if squared - weight < best.0 {
                    best = (squared - weight, at);
                }
            }
        }
        // On the bisector with the middle's owner both are as near; across the ball that difference is linear.
        let (least, own) = best;
        let mut kept = start;
        for i in start..out.len() {
            let (at, weight) = self.slab.seed(out[i]);
            let power = (middle - at).length_squared() - weight;
            if power - least <= 2.0 * radius * (at - own).length() {
                out[kept] = out[i];
                kept += 1;
            }
        }
        out.truncate(kept);
    }
}

impl<'a> Slab<'a> {
    fn of(cells: &'a Cells, plane: &Plane, window: &Window) -> Option<Self> {
        let (n, offset) = cells.plane_in_lattice(plane);
        let reach = cells.radius() + cells.spec.jitter as f64 + 1.0;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (x, y) in [
            (window.min.x, window.min.y),
            (window.max.x, window.min.y),
            (window.min.x, window.max.y),
            (window.max.x, window.max.y),
        ] {
            let corner = cells.lattice_from_model * window.point(vec2(x, y));
            (low, high) = (low.min(corner), high.max(corner));
        }
        let (low, high) = (low - reach, high + reach);
        let a = n.abs();
        let k = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let sides = [high[i] - low[i], high[j] - low[j]];
        if (sides[0] * sides[1]).is_nan() || sides[0] * sides[1] > MAX_CELLS || !low.is_finite() {
            return None;
        }
        let thick = reach / a[k];
        let mut slab = Self {
            cells,
            axes: [i, j, k],
            low: [low[i].floor() as i32, low[j].floor() as i32],
            n: sides.map(|s| s.ceil() as usize + 2),
            bottoms: Vec::new(),
            depth: (2.0 * thick).ceil() as i32 + 1,
            seeds: Vec::new(),
        };
        for y in 0..slab.n[1] {
            for x in 0..slab.n[0] {
                let at = [slab.low[0] as f64 + x as f64, slab.low[1] as f64 + y as f64];
                let middle = (offset - n[i] * at[0] - n[j] * at[1]) / n[k];
                slab.bottoms.push((middle - thick).floor() as i32);
            }
        }
        let mut seeds = Vec::new();
        slab.for_cells(|cell| seeds.push(cells.seed(cell)));
        slab.seeds = seeds;
        Some(slab)
    }

    /// Calls `visit` with all cells of the slab, in the order of `seeds`.
    fn for_cells(&self, mut visit: impl FnMut([i32; 3])) {
        let [i, j, k] = self.axes;
        for (column, &bottom) in self.bottoms.iter().enumerate() {
            for z in 0..self.depth {
                let mut cell = [0; 3];
                cell[i] = self.low[0].wrapping_add((column % self.n[0]) as i32);
                cell[j] = self.low[1].wrapping_add((column / self.n[0]) as i32);
                cell[k] = bottom.wrapping_add(z);
                visit(cell);
            }
        }
    }

    /// A cell's seed in the lattice, and its weight.
    fn seed(&self, cell: [i32; 3]) -> (DVec3, f64) {
        let [i, j, k] = self.axes;
        let (x, y) = (cell[i].wrapping_sub(self.low[0]), cell[j].wrapping_sub(self.low[1]));
        if (0..self.n[0] as i32).contains(&x) && (0..self.n[1] as i32).contains(&y) {
            let column = y as usize * self.n[0] + x as usize;
            let z = cell[k].wrapping_sub(self.bottoms[column]);
            if (0..self.depth).contains(&z) {
                return self.seeds[column * self.depth as usize + z as usize];
            }
        }
        self.cells.seed(cell)
    }
}
