//! Triangles to ids and depths of a tile's cells.
//!
//! Edge functions after Pineda, "A Parallel Algorithm for Polygon Rasterization", 1988, in exact integers: a place that
//! lies on an edge belongs to the triangle for which it is a top or a left edge, so neighbours share an edge without gap
//! or overlap. Depth is a plane through the corners, rounded the same way in all paths. Ties go to the first triangle.

use super::Hit;
use super::bin::{Record, STEPS, TESTED};
use super::tile::{AlphaTest, Layer, TILE, TILE_CELLS};
use crate::math::{Each, kernel};
use fearless_simd::{f32x8, i32x8, mask32x8, prelude::*, u32x8};

/// Cells along the side of a block, and lanes of a vector.
const BLOCK: i32 = 8;
const SIDE: i32 = TILE as i32;
/// Triangles whose box is at most this wide and high take the path without blocks.
const SMALL: i32 = 16;

/// Writes the nearest of `lists`' triangles into every sample.
#[inline(always)]
pub(super) fn nearest<S: Simd>(
    simd: S,
    lists: &[&[Record]],
    places: &[[i32; 2]],
    origin: [u32; 2],
    mut test: Option<&mut AlphaTest>,
    layer: &mut Layer,
) {
    for (sample, &place) in places.iter().enumerate() {
        let mut pass = Pass::<'_, '_, S, false>::new(simd, place, origin, test.as_deref_mut(), layer, sample, None);
        lists.iter().for_each(|list| pass.draw(list));
    }
}

/// Writes the nearest triangles behind `before` (all, if there is none) and before what `layer`'s depths hold already.
/// Returns whether there was any. Coplanar triangles follow each other by their ids.
#[inline(always)]
pub(super) fn next_layer<S: Simd>(
    simd: S,
    lists: &[&[Record]],
    places: &[[i32; 2]],
    origin: [u32; 2],
    mut test: Option<&mut AlphaTest>,
    before: Option<&Layer>,
    layer: &mut Layer,
) -> bool {
    for (sample, &place) in places.iter().enumerate() {
        match before {
            None => {
                let mut pass =
                    Pass::<'_, '_, S, false>::new(simd, place, origin, test.as_deref_mut(), layer, sample, None);
                lists.iter().for_each(|list| pass.draw(list));
            }
            Some(before) => {
                let mut pass =
                    Pass::<'_, '_, S, true>::new(simd, place, origin, test.as_deref_mut(), layer, sample, Some(before));
                lists.iter().for_each(|list| pass.draw(list));
            }
        }
    }
    layer.ids.iter().any(|&id| id != Hit::NOTHING)
}

/// One sample place of a tile while triangles are drawn into it.
struct Pass<'a, 'f, S: Simd, const PEEL: bool> {
    simd: S,
    place: [i32; 2],
    origin: [u32; 2],
    test: Option<&'a mut AlphaTest<'f>>,
    ids: &'a mut [u32; TILE_CELLS],
    depths: &'a mut [f32; TILE_CELLS],
    /// The layer before this one.
    before: Option<(&'a [u32; TILE_CELLS], &'a [f32; TILE_CELLS])>,
    /// A lower bound of the depths in each 8 x 8 block.
    farthest: [f32; TILE_CELLS / 64],
    /// 0..8 as floats.
    lanes: f32x8<S>,
    lanes_i: i32x8<S>,
}

/// Depth over a triangle: `depth0 + gy * dy + gx * dx` from its first corner, within the corners' range.
#[derive(Clone, Copy)]
struct Plane {
    x0: i32,
    y0: i32,
    depth0: f32,
    gx: f32,
    gy: f32,
    min: f32,
    max: f32,
}

impl Plane {
    #[inline(always)]
    fn new(r: &Record, area: i64) -> Self {
        let (dx1, dy1) = ((r.x[1] - r.x[0]) as f64, (r.y[1] - r.y[0]) as f64);
        let (dx2, dy2) = ((r.x[2] - r.x[0]) as f64, (r.y[2] - r.y[0]) as f64);
        let (d1, d2) = ((r.depth[1] - r.depth[0]) as f64, (r.depth[2] - r.depth[0]) as f64);
        let scale = STEPS as f64 / area as f64;
        let [a, b, c] = r.depth;
        let min = |a: f32, b: f32| if a < b { a } else { b };
        let max = |a: f32, b: f32| if a > b { a } else { b };
        Self {
            x0: r.x[0],
            y0: r.y[0],
            depth0: a,
            gx: ((d1 * dy2 - d2 * dy1) * scale) as f32,
            gy: ((d2 * dx1 - d1 * dx2) * scale) as f32,
            min: min(min(a, b), c),
            max: max(max(a, b), c),
        }
    }

    /// The part of a row, at a place's y in 1/256 of a cell.
    #[inline(always)]
    fn row(&self, y: i32) -> f32 {
        self.depth0 + self.gy * ((y - self.y0) as f32 * (1.0 / STEPS as f32))
    }

    /// The distance of a place's x from the first corner, cells.
    #[inline(always)]
    fn dx(&self, x: i32) -> f32 {
        (x - self.x0) as f32 * (1.0 / STEPS as f32)
    }

    /// The nearest depth at the corners of a block of places: an exact bound, since rounding is monotonic.
    #[inline(always)]
    fn nearest(&self, x: i32, y: i32) -> f32 {
        let far = (BLOCK - 1) * STEPS;
        let (px, py) = (if self.gx > 0.0 { x + far } else { x }, if self.gy > 0.0 { y + far } else { y });
        let z = self.row(py) + self.gx * self.dx(px);
        let z = if z > self.min { z } else { self.min };
        if z < self.max { z } else { self.max }
    }
}

/// The edge function of corner `i` to the next: `e + a * column + b * row` at a tile's cells, in 1/256 of a square cell,
/// rounded down after the bias of the fill rule: inside where not negative.
#[derive(Clone, Copy)]
struct Edge {
    a: i32,
    b: i32,
    e: i64,
}

impl Edge {
    /// At the sample place of the cell at (`x`, `y`), given in 1/256 of a cell.
    #[inline(always)]
    fn new(r: &Record, i: usize, x: i32, y: i32) -> Self {
        let j = if i == 2 { 0 } else { i + 1 };
        let (dx, dy) = (r.x[j] - r.x[i], r.y[j] - r.y[i]);
        // The inside is on the right of the edge as y points down: dx * py - dy * px > 0.
        let e = dx as i64 * (y - r.y[i]) as i64 - dy as i64 * (x - r.x[i]) as i64;
        // A left edge goes up, a top edge goes right.
        let owns = dy < 0 || (dy == 0 && dx > 0);
        Self { a: -dy, b: dx, e: e - !owns as i64 }
    }
}

impl<'a, 'f, S: Simd, const PEEL: bool> Pass<'a, 'f, S, PEEL> {
    #[inline(always)]
    fn new(
        simd: S,
        place: [i32; 2],
        origin: [u32; 2],
        test: Option<&'a mut AlphaTest<'f>>,
        layer: &'a mut Layer,
        sample: usize,
        before: Option<&'a Layer>,
    ) -> Self {
        let range = sample * TILE_CELLS..(sample + 1) * TILE_CELLS;
        let ids: &mut [u32; TILE_CELLS] = (&mut layer.ids[range.clone()]).try_into().expect("a sample's ids");
        let depths: &mut [f32; TILE_CELLS] = (&mut layer.depths[range.clone()]).try_into().expect("a sample's depths");
        let before = before.map(|b| {
            let ids: &[u32; TILE_CELLS] = b.ids[range.clone()].try_into().expect("a sample's ids");
            let depths: &[f32; TILE_CELLS] = b.depths[range.clone()].try_into().expect("a sample's depths");
            (ids, depths)
        });
        let lanes = f32x8::from_fn(simd, |i| i as f32);
        let lanes_i = i32x8::from_fn(simd, |i| i as i32);
        Self { simd, place, origin, test, ids, depths, before, farthest: [0.0; TILE_CELLS / 64], lanes, lanes_i }
    }

    #[inline(always)]
    fn draw(&mut self, list: &[Record]) {
        // Coordinates of the sample place of the tile's first cell.
        let ox = self.origin[0] as i32 * STEPS + self.place[0];
        let oy = self.origin[1] as i32 * STEPS + self.place[1];
        for r in list {
            let min = |v: [i32; 3]| v[0].min(v[1]).min(v[2]);
            let max = |v: [i32; 3]| v[0].max(v[1]).max(v[2]);
            // Columns and rows of cells whose places lie in the box, relative to the tile.
            let x0 = (min(r.x) - ox + STEPS - 1) >> 8;
            let x1 = (max(r.x) - ox) >> 8;
            let y0 = (min(r.y) - oy + STEPS - 1) >> 8;
            let y1 = (max(r.y) - oy) >> 8;
            let (cx0, cx1) = (x0.max(0), x1.min(SIDE - 1));
            let (cy0, cy1) = (y0.max(0), y1.min(SIDE - 1));
            if cx0 > cx1 || cy0 > cy1 {
                continue;
            }
            if x1 - x0 < SMALL && y1 - y0 < SMALL {
                self.small(r, [cx0, cx1], [cy0, cy1], ox, oy);
            } else {
                self.large(r, [cx0, cx1], [cy0, cy1], ox, oy);
            }
        }
    }

    /// A triangle whose box is small enough for 32 bits: rows of eight cells.
    #[inline(always)]
    fn small(&mut self, r: &Record, [x0, x1]: [i32; 2], [y0, y1]: [i32; 2], ox: i32, oy: i32) {
        let simd = self.simd;
        // Groups of eight cells that never leave the tile's row.
        let first = x0.min(SIDE - BLOCK);
        let (px, py) = (ox + first * STEPS, oy + y0 * STEPS);
        let edge = kernel(
            #[inline(always)]
            |i: usize, j: usize| {
                let (dx, dy) = (r.x[j] - r.x[i], r.y[j] - r.y[i]);
                let owns = dy < 0 || (dy == 0 && dx > 0);
                let e = dx * (py - r.y[i]) - dy * (px - r.x[i]) - !owns as i32;
                (e, -dy * STEPS, dx * STEPS)
            },
        );
        let edges = [edge(0, 1), edge(1, 2), edge(2, 0)];
        let slope = edges.each(
            #[inline(always)]
            |(_, a, _)| self.lanes_i * i32x8::splat(simd, a),
        );
        let mut plane = None;
        let mut e_row = edges.each(
            #[inline(always)]
            |(e, _, _)| e,
        );
        for y in y0..=y1 {
            let mut x = first;
            loop {
                let step = x - first;
                let at = kernel(
                    #[inline(always)]
                    |k: usize| slope[k] + i32x8::splat(simd, e_row[k] + edges[k].1 * step),
                );
                let inside = (at(0) | at(1) | at(2)).simd_ge(i32x8::splat(simd, 0));
                if inside.any_true() {
                    let plane = plane.get_or_insert_with(|| {
                        let area = (r.x[1] - r.x[0]) as i64 * (r.y[2] - r.y[0]) as i64
                            - (r.x[2] - r.x[0]) as i64 * (r.y[1] - r.y[0]) as i64;
                        Plane::new(r, area)
                    });
                    self.write(r.id, plane, x, y, ox, oy, inside);
                }
                x += BLOCK;
                if x > x1 {
                    break;
                }
                // The last group may overlap the one before: what is drawn twice does not pass the depth test again.
                x = x.min(SIDE - BLOCK);
            }
            for k in 0..3 {
                e_row[k] = e_row[k].wrapping_add(edges[k].2);
            }
        }
    }

    /// Depth-tests and writes the cells `inside` of eight in a row. Returns the depths now there.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the innermost step of both paths, inlined into them")]
    fn write(&mut self, id: u32, plane: &Plane, x: i32, y: i32, ox: i32, oy: i32, inside: mask32x8<S>) -> f32x8<S> {
        let simd = self.simd;
        let cell = (y * SIDE + x) as usize;
        let z = self.depth(plane, x, y, ox, oy);
        let depths: &mut [f32; 8] = (&mut self.depths[cell..cell + 8]).try_into().expect("eight cells");
        let old = f32x8::load_array_ref(simd, depths);
        let mut pass = inside & z.simd_gt(old);
        if PEEL && let Some((ids, depths)) = self.before {
            // Behind the layer before, or at the same depth and later in order.
            let (ids, depths) = (&ids[cell..cell + 8], &depths[cell..cell + 8]);
            let (b_id, b_z) = (u32x8::from_slice(simd, ids), f32x8::from_slice(simd, depths));
            let none = b_id.simd_eq(u32x8::splat(simd, Hit::NOTHING));
            let later = z.simd_eq(b_z) & u32x8::splat(simd, id & !TESTED).simd_gt(b_id);
            pass = pass & (z.simd_lt(b_z) | later) & !none;
        }
        if id & TESTED != 0
            && let Some(test) = &mut self.test
            && pass.any_true()
        {
            let column = (self.origin[0] as i32 + x) as u32;
            let row = self.origin[1] + y as u32;
            let bits = test(id & !TESTED, column, row, pass.to_bitmask() as u32, self.place);
            pass &= mask32x8::from_bitmask(simd, bits as u64);
        }
        let new = pass.select(z, old);
        new.store_array(depths);
        let ids: &mut [u32; 8] = (&mut self.ids[cell..cell + 8]).try_into().expect("eight cells");
        let old_ids = u32x8::load_array_ref(simd, ids);
        pass.select(u32x8::splat(simd, id & !TESTED), old_ids).store_array(ids);
        new
    }

    /// Depths of eight cells in a row; the one expression that all bounds rely on.
    #[inline(always)]
    fn depth(&self, plane: &Plane, x: i32, y: i32, ox: i32, oy: i32) -> f32x8<S> {
        let simd = self.simd;
        let row = plane.row(oy + y * STEPS);
        // Distances are exact in f32: at most 24 bits.
        let dx = self.lanes + f32x8::splat(simd, plane.dx(ox + x * STEPS));
        let z = f32x8::splat(simd, row) + f32x8::splat(simd, plane.gx) * dx;
        let (lo, hi) = (f32x8::splat(simd, plane.min), f32x8::splat(simd, plane.max));
        let z = z.simd_gt(lo).select(z, lo);
        z.simd_lt(hi).select(z, hi)
    }

    /// A triangle of any size: blocks of 8 x 8 cells, refused or accepted whole where possible.
    #[inline(always)]
    fn large(&mut self, r: &Record, [x0, x1]: [i32; 2], [y0, y1]: [i32; 2], ox: i32, oy: i32) {
        let simd = self.simd;
        let area =
            (r.x[1] - r.x[0]) as i64 * (r.y[2] - r.y[0]) as i64 - (r.x[2] - r.x[0]) as i64 * (r.y[1] - r.y[0]) as i64;
        let mut edges = [(0, 0, 0); 3];
        for (i, edge) in edges.iter_mut().enumerate() {
            let Edge { a, b, e } = Edge::new(r, i, ox, oy);
            // Extremes over the tile's cells; 256 divides all steps, so shifting keeps every sign exactly.
            let (e, reach) = (e >> 8, (SIDE - 1) as i64);
            let most = e + (a.max(0) as i64 + b.max(0) as i64) * reach;
            let least = e + (a.min(0) as i64 + b.min(0) as i64) * reach;
            if most < 0 {
                return;
            }
            // An edge that crosses the tile fits 32 bits; one that accepts the tile whole does not matter any more.
            *edge = if least >= 0 { (0, 0, 0) } else { (e as i32, a, b) };
        }
        let plane = Plane::new(r, area);
        let reach = BLOCK - 1;
        let lane = edges.each(
            #[inline(always)]
            |(_, a, _)| self.lanes_i * i32x8::splat(simd, a),
        );
        let blocks = edges.each(
            #[inline(always)]
            |(_, a, _)| self.lanes_i * i32x8::splat(simd, a * BLOCK),
        );
        for by in (y0 & !(BLOCK - 1)..=y1).step_by(BLOCK as usize) {
            // Eight blocks at a time: which may hold a cell, which are inside whole?
            let mut most = i32x8::splat(simd, 0);
            let mut least = i32x8::splat(simd, 0);
            for k in 0..3 {
                let (e, a, b) = edges[k];
                let at = blocks[k] + i32x8::splat(simd, e + b * by);
                most |= at + i32x8::splat(simd, (a.max(0) + b.max(0)) * reach);
                least |= at + i32x8::splat(simd, (a.min(0) + b.min(0)) * reach);
            }
            let zero = i32x8::splat(simd, 0);
            let whole = least.simd_ge(zero).to_bitmask() as u32;
            let columns = (0xff_u32 << (x0 / BLOCK)) & (0xff_u32 >> (7 - x1 / BLOCK));
            let mut todo = most.simd_ge(zero).to_bitmask() as u32 & columns;
            while todo != 0 {
                let column = todo.trailing_zeros();
                todo &= todo - 1;
                let bx = column as i32 * BLOCK;
                let block = (by / BLOCK * (SIDE / BLOCK)) as usize + column as usize;
                if plane.nearest(ox + bx * STEPS, oy + by * STEPS) <= self.farthest[block] {
                    continue;
                }
                let mut farthest = f32x8::splat(simd, f32::INFINITY);
                if whole >> column & 1 == 1 {
                    let all = mask32x8::splat(simd, true);
                    for y in by..by + BLOCK {
                        let now = self.write(r.id, &plane, bx, y, ox, oy, all);
                        farthest = now.simd_lt(farthest).select(now, farthest);
                    }
                } else {
                    for y in by..by + BLOCK {
                        let at = kernel(
                            #[inline(always)]
                            |k: usize| {
                                let (e, a, b) = edges[k];
                                lane[k] + i32x8::splat(simd, e + a * bx + b * y)
                            },
                        );
                        let inside = (at(0) | at(1) | at(2)).simd_ge(zero);
                        let now = self.write(r.id, &plane, bx, y, ox, oy, inside);
                        farthest = now.simd_lt(farthest).select(now, farthest);
                    }
                }
                self.farthest[block] = farthest.reduce_min_precise();
            }
        }
    }
}
