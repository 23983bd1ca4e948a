//! Vertices to fixed-point cells, triangles to tiles.
//!
//! Positions snap to 1/256 of a cell; triangles that reach behind the eye or beyond the guard band are clipped first
//! (Blinn, Newell 1978), all others are taken as they are. What covers no sample is dropped here.

use super::tile::{Draw, Faces, Kind, Samples, TILE, n_tiles};
use super::{Domain, domain::Map};
use crate::math::{DVec4, Each, Vec4, kernel};
use crate::par::Workers;
use fearless_simd::{dispatch, i32x8, prelude::*};

/// Cells from the grid's origin within which triangles need no clipping; products of differences then fit 64 bits.
const GUARD: f32 = 16000.0;
/// Fixed-point steps a cell.
pub(super) const STEPS: i32 = 256;
/// Set in a record's id when its triangle must pass the alpha test.
pub(super) const TESTED: u32 = 1 << 31;

/// A triangle in a tile's list: 40 bytes with all that coverage and depth need.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Record {
    /// Corners in 1/256 of a cell; going round them keeps the inside on the right as y points down.
    pub(super) x: [i32; 3],
    pub(super) y: [i32; 3],
    /// Depth at the corners.
    pub(super) depth: [f32; 3],
    /// Index of the triangle, and [`TESTED`].
    pub(super) id: u32,
}

/// A vertex on the grid.
#[derive(Clone, Copy, Default)]
struct Snapped {
    /// In 1/256 of a cell, or `OUTSIDE` when the vertex must be clipped.
    x: i32,
    /// In 1/256 of a cell.
    y: i32,
    depth: f32,
}

const OUTSIDE: i32 = i32::MIN;

/// One worker's share: a run of triangles, and its lists.
#[derive(Default)]
struct Share {
    draws: Vec<Draw>,
    solid: Vec<Vec<Record>>,
    layered: Vec<Vec<Record>>,
}

/// Triangles sorted into tiles.
#[derive(Default)]
pub(super) struct Bins {
    vertices: Vec<Snapped>,
    shares: Vec<Share>,
}

impl Bins {
    pub(super) fn solid(&self, tile: usize) -> Vec<&[Record]> {
        self.shares.iter().map(|s| s.solid[tile].as_slice()).filter(|l| !l.is_empty()).collect()
    }

    pub(super) fn layered(&self, tile: usize) -> Vec<&[Record]> {
        self.shares
            .iter()
            .map(|s| s.layered.get(tile).map_or(&[][..], |l| l.as_slice()))
            .filter(|l| !l.is_empty())
            .collect()
    }

    /// Triangles to tiles; the vertices must have been snapped in the same domain.
    pub(super) fn sort(&mut self, domain: &Domain, draws: &[Draw], samples: Samples, workers: &Workers) {
        self.share_out(draws, workers);
        let [n_x, n_y] = n_tiles(domain.size);
        let layered = draws.iter().any(|d| d.kind == Kind::Layered);
        let vertices = &self.vertices;
        workers.for_each(&mut self.shares, |_, share| {
            let lists = |l: &mut Vec<Vec<Record>>, n: usize| {
                l.iter_mut().for_each(Vec::clear);
                l.resize_with(n, Vec::new);
            };
            lists(&mut share.solid, n_x * n_y);
            lists(&mut share.layered, if layered { n_x * n_y } else { 0 });
            let binner = Binner { domain, vertices, samples, n_tiles: [n_x as i32, n_y as i32] };
            for draw in &share.draws {
                let lists = if draw.kind == Kind::Layered { &mut share.layered } else { &mut share.solid };
                dispatch!(workers.level(), simd => binner.draw(simd, draw, lists));
            }
        });
    }

    /// Vertices to fixed-point cells.
    pub(super) fn snap(&mut self, domain: &Domain, workers: &Workers) {
        const CHUNK: usize = 4096;
        let n = domain.mesh.positions().len();
        self.vertices.resize(n, Snapped::default());
        let mut chunks: Vec<&mut [Snapped]> = self.vertices.chunks_mut(CHUNK).collect();
        workers.for_each(&mut chunks, |chunk, out| {
            let first = chunk * CHUNK;
            match &domain.map {
                Map::Camera { cells_from_world: m } => {
                    for (v, &p) in out.iter_mut().zip(&domain.mesh.positions()[first..]) {
                        let c = ((m.x_axis * p.x + m.y_axis * p.y) + m.z_axis * p.z) + m.w_axis;
                        *v = snap(c, domain.near);
                    }
                }
                Map::Atlas { .. } => {
                    for (i, v) in out.iter_mut().enumerate() {
                        *v = snap(domain.corner((first + i) as u32), domain.near);
                    }
                }
            }
        });
    }

    /// Cuts the draws into runs of about equal length, one share each, in order.
    fn share_out(&mut self, draws: &[Draw], workers: &Workers) {
        let total: usize = draws.iter().map(|d| d.triangles.len()).sum();
        let n_shares = if total < 2048 { 1 } else { workers.n_threads() * 4 };
        let mut shares: Vec<Share> = std::mem::take(&mut self.shares);
        shares.resize_with(n_shares, Share::default);
        shares.iter_mut().for_each(|s| s.draws.clear());
        let per_share = total.div_ceil(n_shares).max(1);
        let mut done = 0;
        for draw in draws {
            let mut start = draw.triangles.start;
            while start < draw.triangles.end {
                let share = done / per_share;
                let room = (share + 1) * per_share - done;
                let n = room.min((draw.triangles.end - start) as usize) as u32;
                shares[share].draws.push(Draw { triangles: start..start + n, ..draw.clone() });
                start += n;
                done += n as usize;
            }
        }
        self.shares = shares;
    }
}

/// To fixed point, rounded to nearest; vertices behind the near plane or beyond the guard band are marked.
#[inline(always)]
fn snap(c: Vec4, near: f32) -> Snapped {
    let limit = GUARD * c.w;
    // All comparisons are false for NaN, which then counts as outside.
    if c.w > near && c.x > -limit && c.x < limit && c.y > -limit && c.y < limit {
        let r = 1.0 / c.w;
        Snapped { x: fixed(c.x * r), y: fixed(c.y * r), depth: c.z * r }
    } else {
        Snapped { x: OUTSIDE, y: 0, depth: 0.0 }
    }
}

/// A point made by clipping to fixed point; rounding may have left it a trifle outside.
fn snap_cut(c: DVec4) -> Snapped {
    let at = |v: f64| ((v / c.w).clamp(-GUARD as f64, GUARD as f64) * STEPS as f64).round_ties_even() as i32;
    Snapped { x: at(c.x), y: at(c.y), depth: (c.z / c.w) as f32 }
}

/// Cells to 1/256 of a cell, for |cells| <= 16384.
#[inline(always)]
fn fixed(cells: f32) -> i32 {
    // Adding 1.5 * 2^23 rounds to the nearest integer, ties to even.
    ((cells * STEPS as f32 + 12_582_912.0) - 12_582_912.0) as i32
}

/// On which sides of the grid a point lies outside, one bit a side.
fn outcode(c: DVec4, near: f64, domain: &Domain) -> i32 {
    let (w, h) = (domain.size.width as f64 * c.w, domain.size.height as f64 * c.w);
    let outside = [c.x < 0.0, c.x > w, c.y < 0.0, c.y > h, c.w <= near];
    outside.iter().enumerate().map(|(bit, &o)| (o as i32) << bit).sum()
}

struct Binner<'a> {
    domain: &'a Domain<'a>,
    vertices: &'a [Snapped],
    samples: Samples,
    n_tiles: [i32; 2],
}

/// Triangles that are looked at together.
const GROUP: usize = 8;

impl Binner<'_> {
    #[inline(always)]
    fn draw<S: Simd>(&self, simd: S, draw: &Draw, lists: &mut [Vec<Record>]) {
        let flag = if draw.kind == Kind::Tested { TESTED } else { 0 };
        let range = draw.triangles.start as usize..draw.triangles.end as usize;
        for (g, group) in self.domain.mesh.triangles()[range].chunks(GROUP).enumerate() {
            let mut x = [[0; GROUP]; 3];
            let mut y = [[0; GROUP]; 3];
            for (lane, corners) in group.iter().enumerate() {
                for k in 0..3 {
                    let v = &self.vertices[corners[k] as usize];
                    x[k][lane] = v.x;
                    y[k][lane] = v.y;
                }
            }
            let mut todo = self.worth_a_look(simd, &x, &y, draw.faces) & ((1 << group.len()) - 1);
            while todo != 0 {
                let lane = todo.trailing_zeros() as usize;
                todo &= todo - 1;
                let id = (draw.triangles.start + (g * GROUP + lane) as u32) | flag;
                let v = group[lane].each(
                    #[inline(always)]
                    |i| self.vertices[i as usize],
                );
                if v.iter().any(|v| v.x == OUTSIDE) {
                    self.clipped(group[lane], v, id, draw.faces, lists);
                } else {
                    self.triangle(v, id, draw.faces, lists);
                }
            }
        }
    }

    /// Which of eight triangles may cover a sample: most small ones do not, or show their back. One bit each.
    #[inline(always)]
    fn worth_a_look<S: Simd>(&self, simd: S, x: &[[i32; GROUP]; 3], y: &[[i32; GROUP]; 3], faces: Faces) -> u32 {
        let load = kernel(
            #[inline(always)]
            |v: &[i32; GROUP]| i32x8::load_array_ref(simd, v),
        );
        let splat = kernel(
            #[inline(always)]
            |v: i32| i32x8::splat(simd, v),
        );
        let (x, y) = ([load(&x[0]), load(&x[1]), load(&x[2])], [load(&y[0]), load(&y[1]), load(&y[2])]);
        let (x0, x1) = (x[0].min(x[1]).min(x[2]), x[0].max(x[1]).max(x[2]));
        let (y0, y1) = (y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2]));
        let (spacing, first) = self.samples.spacing();
        let shift = spacing.trailing_zeros();
        let places = kernel(
            #[inline(always)]
            |lo: i32x8<S>, hi: i32x8<S>| {
                ((lo + splat(spacing - 1 - first)) >> shift).simd_le((hi - splat(first)) >> shift)
            },
        );
        let area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        let faces = match faces {
            Faces::Front => area.simd_lt(splat(0)),
            Faces::Both => !area.simd_eq(splat(0)),
        };
        // Within 64 cells areas fit 32 bits. All others, and those to be clipped, are looked at in any case.
        let limit = splat(64 * STEPS);
        let small = (x1 - x0).simd_lt(limit) & (y1 - y0).simd_lt(limit) & x0.simd_gt(splat(OUTSIDE));
        ((places(x0, x1) & places(y0, y1) & faces) | !small).to_bitmask() as u32
    }

    /// A triangle whose corners all lie within the guard band.
    #[inline(always)]
    fn triangle(&self, v: [Snapped; 3], id: u32, faces: Faces, lists: &mut [Vec<Record>]) {
        let min = |a: i32, b: i32| if a < b { a } else { b };
        let max = |a: i32, b: i32| if a > b { a } else { b };
        let x0 = min(min(v[0].x, v[1].x), v[2].x);
        let x1 = max(max(v[0].x, v[1].x), v[2].x);
        let y0 = min(min(v[0].y, v[1].y), v[2].y);
        let y1 = max(max(v[0].y, v[1].y), v[2].y);
        // Columns and rows of sample places within the box: none, then nothing is covered.
        let (spacing, first) = self.samples.spacing();
        let shift = spacing.trailing_zeros();
        let places = |lo: i32, hi: i32| (lo + spacing - 1 - first) >> shift <= (hi - first) >> shift;
        if !places(x0, x1) || !places(y0, y1) {
            return;
        }
        let area =
            (v[1].x - v[0].x) as i64 * (v[2].y - v[0].y) as i64 - (v[2].x - v[0].x) as i64 * (v[1].y - v[0].y) as i64;
        if area == 0 || (area > 0 && faces == Faces::Front) {
            return;
        }
        // Counter-clockwise with y up is clockwise with y down, where the area is negative: exchange two corners.
        let [a, b, c] = if area > 0 { v } else { [v[0], v[2], v[1]] };
        const SHIFT: u32 = (TILE as i32 * STEPS).trailing_zeros();
        let tx = max(x0 >> SHIFT, 0)..min(x1 >> SHIFT, self.n_tiles[0] - 1) + 1;
        let ty = max(y0 >> SHIFT, 0)..min(y1 >> SHIFT, self.n_tiles[1] - 1) + 1;
        let record = Record { x: [a.x, b.x, c.x], y: [a.y, b.y, c.y], depth: [a.depth, b.depth, c.depth], id };
        for y in ty {
            for x in tx.clone() {
                lists[(y * self.n_tiles[0] + x) as usize].push(record);
            }
        }
    }

    /// A triangle with a corner behind the eye or far outside: what remains of it within the guard band, as a fan.
    #[cold]
    fn clipped(&self, corners: [u32; 3], v: [Snapped; 3], id: u32, faces: Faces, lists: &mut [Vec<Record>]) {
        // In f64: between a corner far before and one far behind the eye little of an f32 would be left.
        let homogeneous = corners.map(|i| self.domain.corner_f64(i));
        if homogeneous.iter().any(|c| !c.is_finite()) {
            return;
        }
        let near = self.domain.near as f64;
        let codes = homogeneous.map(|c| outcode(c, near, self.domain));
        if codes[0] & codes[1] & codes[2] != 0 {
            return;
        }
        // Signed distances to the planes.
        let g = GUARD as f64;
        let nearest = if near > 0.0 { near } else { 1e-6 };
        let planes: [&dyn Fn(DVec4) -> f64; 5] =
            [&|c| c.w - nearest, &|c| g * c.w + c.x, &|c| g * c.w - c.x, &|c| g * c.w + c.y, &|c| g * c.w - c.y];
        // Each corner carries whether it is an original vertex, whose snapped place must be kept.
        let mut polygon: Vec<(DVec4, Option<Snapped>)> =
            (0..3).map(|k| (homogeneous[k], (v[k].x != OUTSIDE).then_some(v[k]))).collect();
        for plane in planes {
            let mut kept = Vec::with_capacity(8);
            for k in 0..polygon.len() {
                let (from, to) = (polygon[k], polygon[(k + 1) % polygon.len()]);
                let (d0, d1) = (plane(from.0), plane(to.0));
                if d0 >= 0.0 {
                    kept.push(from);
                }
                if (d0 >= 0.0) != (d1 >= 0.0) {
                    // Always from the inside to the outside, so that two triangles sharing an edge cut it at the same point.
                    let (inside, outside, di, d_o) =
                        if d0 >= 0.0 { (from.0, to.0, d0, d1) } else { (to.0, from.0, d1, d0) };
                    kept.push((inside + (outside - inside) * (di / (di - d_o)), None));
                }
            }
            polygon = kept;
        }
        let fan: Vec<Snapped> = polygon.iter().map(|(c, original)| original.unwrap_or_else(|| snap_cut(*c))).collect();
        for k in 2..fan.len() {
            self.triangle([fan[0], fan[k - 1], fan[k]], id, faces, lists);
        }
    }
}
