//! Triangles to ids and depths of a tile's cells.
//!
//! Edge functions after Pineda, "A Parallel Algorithm for Polygon Rasterization", 1988, in exact integers: a place that
//! lies on an edge belongs to the triangle for which it is a top or a left edge, so neighbours share an edge without gap
//! or overlap. Depth is a plane through the corners, rounded the same way in all paths. Ties go to the first triangle.
//!
//! Samples of a cell stand side by side, so a vector of eight holds a row of cells at one sample, two cells at four, half a
//! cell at sixteen: a triangle is set up once, however many places are looked at.

use super::Hit;
use super::bin::{Record, STEPS, TESTED};
use super::depth::{Order, Plane};
use super::tile::{AlphaTest, Layer, Places, Samples, TILE, TILE_CELLS};
use crate::math::{Each, kernel};
use fearless_simd::{f32x8, i32x8, mask32x8, prelude::*, u32x8};

/// Cells along the side of a block.
const BLOCK: i32 = 8;
const SIDE: i32 = TILE as i32;
/// Lanes of a vector.
const LANES: usize = 8;

/// Writes the nearest of `lists`' triangles into every sample: those behind the layer `before`, if there is one, and before
/// what `layer`'s depths hold already. Coplanar triangles follow each other by their ids.
#[inline(always)]
pub(super) fn nearest<S: Simd>(
    simd: S,
    lists: &[&[Record]],
    samples: Samples,
    origin: [u32; 2],
    test: Option<&mut AlphaTest>,
    (order, before): (Order, Option<&Layer>),
    layer: &mut Layer,
) {
    // Each in a function of its own: together they are more than compilers digest.
    match samples {
        Samples::One => simd.vectorize(
            #[inline(always)]
            || Pass::<'_, '_, S, 1>::new(simd, samples, origin, test, (order, before), layer).draw(lists),
        ),
        Samples::Four => simd.vectorize(
            #[inline(always)]
            || Pass::<'_, '_, S, 4>::new(simd, samples, origin, test, (order, before), layer).draw(lists),
        ),
        Samples::Sixteen => simd.vectorize(
            #[inline(always)]
            || Pass::<'_, '_, S, 16>::new(simd, samples, origin, test, (order, before), layer).draw(lists),
        ),
    }
}

/// A tile with `N` samples a cell while triangles are drawn into it.
struct Pass<'a, 'f, S: Simd, const N: usize> {
    simd: S,
    origin: [u32; 2],
    /// The tile's corner, 1/256 of a cell.
    corner: [i32; 2],
    test: Option<&'a mut AlphaTest<'f>>,
    ids: &'a mut [u32],
    depths: &'a mut [f32],
    order: Order,
    /// The layer before this one.
    before: Option<&'a Layer>,
    /// A lower bound of the depths in each 8 x 8 block.
    farthest: [f32; TILE_CELLS / 64],
    /// Triangles drawn into parts of each block since.
    n_drawn: [u32; TILE_CELLS / 64],
    /// Where in a cell the samples are, 1/256.
    offsets: &'static [[i32; 2]],
    /// The least and the greatest of them, across and down.
    reach: [[i32; 2]; 2],
    /// Lanes' places from the first cell of their group, 1/256 of a cell; for each vector of a group.
    places: [[i32x8<S>; 2]; 2],
    /// The same in cells.
    distances: [[f32x8<S>; 2]; 2],
    /// Lanes' cells within their group.
    cells: i32x8<S>,
    /// 0..8.
    lanes: i32x8<S>,
}

/// The edge function of corner `i` to the next: `e + a * column + b * row` at a tile's cells, in 1/256 of a square cell,
/// inside where not negative.
#[derive(Clone, Copy)]
struct Edge {
    a: i32,
    b: i32,
    e: i64,
}

impl Edge {
    /// At a place in 1/256 of a cell, after the bias of the fill rule.
    #[inline(always)]
    fn new(r: &Record, i: usize, [x, y]: [i32; 2]) -> Self {
        let j = if i == 2 { 0 } else { i + 1 };
        let (dx, dy) = (r.x[j] - r.x[i], r.y[j] - r.y[i]);
        // The inside is on the right of the edge as y points down: dx * py - dy * px > 0.
        let e = dx as i64 * (y - r.y[i]) as i64 - dy as i64 * (x - r.x[i]) as i64;
        Self { a: -dy, b: dx, e: e - !owns(dx, dy) as i64 }
    }

    /// At another place, rounded down: all steps of whole cells are multiples of 256, so every sign stays exact.
    #[inline(always)]
    fn at(&self, [x, y]: [i32; 2]) -> i64 {
        (self.e + self.a as i64 * x as i64 + self.b as i64 * y as i64) >> 8
    }
}

/// Whether a triangle owns the places on an edge: a left edge goes up, a top edge goes right.
#[inline(always)]
fn owns(dx: i32, dy: i32) -> bool {
    dy < 0 || (dy == 0 && dx > 0)
}

impl<'a, 'f, S: Simd, const N: usize> Pass<'a, 'f, S, N> {
    /// Cells of a group: what its vectors hold.
    const GROUP: i32 = if N < LANES { (LANES / N) as i32 } else { 1 };
    /// Groups across a block, and rows of a block that eight groups fill.
    const ACROSS: i32 = BLOCK / Self::GROUP;
    const ROWS: i32 = LANES as i32 / Self::ACROSS;
    /// Triangles whose box is smaller than this, across and down, take the path without blocks: those it tests vector by
    /// vector, which more samples make shorter.
    const SMALL: i32 = if N == 1 { 32 } else { 16 };
    /// Vectors of a group.
    const VECTORS: usize = if N < LANES { 1 } else { N / LANES };

    #[inline(always)]
    fn new(
        simd: S,
        samples: Samples,
        origin: [u32; 2],
        test: Option<&'a mut AlphaTest<'f>>,
        (order, before): (Order, Option<&'a Layer>),
        layer: &'a mut Layer,
    ) -> Self {
        let offsets = samples.offsets();
        let reach = kernel(|k: usize| {
            let of = |pick: fn(i32, i32) -> i32| offsets.iter().map(|o| o[k]).reduce(pick).expect("a sample");
            [of(i32::min), of(i32::max)]
        });
        let places = kernel(|v: usize| {
            [0, 1].each(|k| {
                i32x8::from_fn(simd, |lane| {
                    let across = if k == 0 { (lane / N) as i32 * STEPS } else { 0 };
                    across + offsets[(v * LANES + lane) % N][k]
                })
            })
        });
        let places = [places(0), places(Self::VECTORS - 1)];
        let distances = places.each(|p| p.each(|p| p.to_float::<f32x8<S>>() * (1.0 / STEPS as f32)));
        let n = TILE_CELLS * N;
        Self {
            simd,
            origin,
            corner: origin.each(|o| o as i32 * STEPS),
            test,
            ids: &mut layer.ids[..n],
            depths: &mut layer.depths[..n],
            order,
            before,
            farthest: [0.0; TILE_CELLS / 64],
            n_drawn: [0; TILE_CELLS / 64],
            offsets,
            reach: [reach(0), reach(1)],
            places,
            distances,
            cells: i32x8::from_fn(simd, |lane| (lane / N) as i32),
            lanes: i32x8::from_fn(simd, |lane| lane as i32),
        }
    }

    #[inline(always)]
    fn draw(&mut self, lists: &[&[Record]]) {
        let [ox, oy] = self.corner;
        let [[x_least, x_most], [y_least, y_most]] = self.reach;
        let order = self.order;
        let nth = move |k: usize, n: usize| if order == Order::Forward { k } else { n - 1 - k };
        let records = (0..lists.len()).map(|l| lists[nth(l, lists.len())]);
        for r in records.flat_map(move |list| (0..list.len()).map(move |k| &list[nth(k, list.len())])) {
            let min = |v: [i32; 3]| v[0].min(v[1]).min(v[2]);
            let max = |v: [i32; 3]| v[0].max(v[1]).max(v[2]);
            // Columns and rows of cells with places in the box, relative to the tile.
            let x0 = (min(r.x) - ox - x_most + STEPS - 1) >> 8;
            let x1 = (max(r.x) - ox - x_least) >> 8;
            let y0 = (min(r.y) - oy - y_most + STEPS - 1) >> 8;
            let y1 = (max(r.y) - oy - y_least) >> 8;
            let columns = [x0.max(0), x1.min(SIDE - 1)];
            let rows = [y0.max(0), y1.min(SIDE - 1)];
            if columns[0] > columns[1] || rows[0] > rows[1] {
                continue;
            }
            if x1 - x0 < Self::SMALL && y1 - y0 < Self::SMALL {
                self.small(r, columns, rows);
            } else {
                self.large(r, columns, rows);
            }
        }
    }

    /// A triangle whose box is small enough for 32 bits: column of vectors by column of vectors, row by row.
    #[inline(always)]
    fn small(&mut self, r: &Record, [x0, x1]: [i32; 2], [y0, y1]: [i32; 2]) {
        let simd = self.simd;
        if x1 - x0 >= BLOCK || y1 - y0 >= BLOCK {
            let max = |a: f32, b: f32| if a > b { a } else { b };
            let nearest = max(max(r.depth[0], r.depth[1]), r.depth[2]);
            if self.each_block([x0, x1], [y0, y1], |pass, block, x, y| {
                pass.order.hides(nearest, pass.farthest(block, x, y))
            }) {
                return;
            }
            self.each_block([x0, x1], [y0, y1], |pass, block, _, _| {
                pass.n_drawn[block] += 1;
                true
            });
        }
        // Groups that never leave the tile's row.
        let first = if N == 1 { x0.min(SIDE - Self::GROUP) } else { x0 & -Self::GROUP };
        let (px, py) = (self.corner[0] + first * STEPS, self.corner[1] + y0 * STEPS);
        let edge = kernel(
            #[inline(always)]
            |i: usize, j: usize| {
                let (dx, dy) = (r.x[j] - r.x[i], r.y[j] - r.y[i]);
                (dx * (py - r.y[i]) - dy * (px - r.x[i]) - !owns(dx, dy) as i32, -dy, dx)
            },
        );
        let edges = [edge(0, 1), edge(1, 2), edge(2, 0)];
        let down = edges.each(
            #[inline(always)]
            |(_, _, b)| i32x8::splat(simd, b * STEPS),
        );
        let inside = kernel(
            #[inline(always)]
            |at: &[i32x8<S>; 3]| (at[0] | at[1] | at[2]).simd_ge(i32x8::splat(simd, 0)),
        );
        let mut plane = None;
        let mut x = first;
        loop {
            for vector in 0..Self::VECTORS {
                let mut at = edges.each(
                    #[inline(always)]
                    |(e, a, b)| {
                        let [across, along] = self.places[vector];
                        let e = e + a * ((x - first) * STEPS);
                        (across * i32x8::splat(simd, a) + along * i32x8::splat(simd, b)) + i32x8::splat(simd, e)
                    },
                );
                let step = kernel(
                    #[inline(always)]
                    |at: &mut [i32x8<S>; 3]| (0..3).for_each(|k| at[k] += down[k]),
                );
                let mut y = y0;
                while y <= y1 && !inside(&at).any_true() {
                    step(&mut at);
                    y += 1;
                }
                if y > y1 {
                    continue;
                }
                let plane = plane.get_or_insert_with(
                    #[inline(always)]
                    || Plane::new(r),
                );
                let across = self.across(plane, x, vector);
                while y <= y1 {
                    let inside = inside(&at);
                    if inside.any_true() {
                        let z = self.down(plane, across, y, vector);
                        self.write(r.id, z, [x, y], vector, inside);
                    }
                    step(&mut at);
                    y += 1;
                }
            }
            x += Self::GROUP;
            if x > x1 {
                break;
            }
            // The last group may overlap the one before: what is drawn twice does not pass the depth test again.
            x = x.min(SIDE - Self::GROUP);
        }
    }

    /// Depth-tests and writes the samples `inside` of a vector, at depths `z`. Returns the depths now there.
    #[inline(always)]
    fn write(&mut self, id: u32, z: f32x8<S>, [x, y]: [i32; 2], vector: usize, inside: mask32x8<S>) -> f32x8<S> {
        let simd = self.simd;
        let at = (y * SIDE + x) as usize * N + vector * LANES;
        let old = f32x8::from_slice(simd, &self.depths[at..at + LANES]);
        let (bits, old_bits): (i32x8<S>, i32x8<S>) = (z.bitcast(), old.bitcast());
        let mut pass = inside & (bits + self.order.bias()).simd_gt(old_bits);
        if let Some(before) = self.before {
            // Behind the layer before, or at the same depth and later in order.
            let (ids, depths) = (&before.ids[at..at + LANES], &before.depths[at..at + LANES]);
            let (b_id, b_z) = (u32x8::from_slice(simd, ids), f32x8::from_slice(simd, depths));
            let none = b_id.simd_eq(u32x8::splat(simd, Hit::NOTHING));
            let later = z.simd_eq(b_z) & u32x8::splat(simd, id & !TESTED).simd_gt(b_id);
            pass = pass & (z.simd_lt(b_z) | later) & !none;
        }
        if id & TESTED != 0 && pass.any_true() {
            let bits = self.tested(id & !TESTED, [x, y], vector, pass.to_bitmask() as u32);
            pass &= mask32x8::from_bitmask(simd, bits as u64);
        }
        let depths: &mut [f32; LANES] = (&mut self.depths[at..at + LANES]).try_into().expect("eight samples");
        let new = pass.select(z, old);
        new.store_array(depths);
        let ids: &mut [u32; LANES] = (&mut self.ids[at..at + LANES]).try_into().expect("eight samples");
        let old_ids = u32x8::load_array_ref(simd, ids);
        pass.select(u32x8::splat(simd, id & !TESTED), old_ids).store_array(ids);
        new
    }

    /// Which of a vector's samples (bits) pass the alpha test. A call on purpose: what is rare shall not slow what is not.
    #[cold]
    #[inline(never)]
    fn tested(&mut self, id: u32, [x, y]: [i32; 2], vector: usize, bits: u32) -> u32 {
        let Some(test) = &mut self.test else { return bits };
        let (column, row) = (self.origin[0] + x as u32, self.origin[1] + y as u32);
        let places = Places {
            row,
            column: std::array::from_fn(|lane| column + (lane / N) as u32),
            within: std::array::from_fn(|lane| self.offsets[(vector * LANES + lane) % N]),
            bits,
        };
        test(id, &places)
    }

    /// Depths of a vector of samples; the one expression that all bounds rely on, in two steps: what a column of vectors
    /// shares comes first.
    #[inline(always)]
    fn depth(&self, plane: &Plane, x: i32, y: i32, vector: usize) -> f32x8<S> {
        self.down(plane, self.across(plane, x, vector), y, vector)
    }

    /// How far depths differ from the first corner's, across.
    #[inline(always)]
    fn across(&self, plane: &Plane, x: i32, vector: usize) -> f32x8<S> {
        let dx = f32x8::splat(self.simd, plane.distance_x(self.corner[0] + x * STEPS));
        (self.distances[vector][0] + dx) * f32x8::splat(self.simd, plane.gx)
    }

    /// Depths from there on, down.
    #[inline(always)]
    fn down(&self, plane: &Plane, across: f32x8<S>, y: i32, vector: usize) -> f32x8<S> {
        let simd = self.simd;
        let dy = self.distances[vector][1] + f32x8::splat(simd, plane.distance_y(self.corner[1] + y * STEPS));
        let z = (f32x8::splat(simd, plane.depth0) + f32x8::splat(simd, plane.gy) * dy) + across;
        let (lo, hi) = (f32x8::splat(simd, plane.min), f32x8::splat(simd, plane.max));
        let z = z.simd_gt(lo).select(z, lo);
        z.simd_lt(hi).select(z, hi)
    }

    /// A triangle of any size: blocks of 8 x 8 cells, refused or accepted whole where possible.
    #[inline(always)]
    fn large(&mut self, r: &Record, [x0, x1]: [i32; 2], [y0, y1]: [i32; 2]) {
        let simd = self.simd;
        let mut edges = [(0, 0); 3];
        // The edge functions' least and greatest value in the tile's first cell, and their values there by sample.
        let mut bounds = [[0; 2]; 3];
        let mut values = [[0; 16]; 3];
        for i in 0..3 {
            let edge = Edge::new(r, i, self.corner);
            let mut at = [0; 16];
            for s in 0..N {
                at[s] = edge.at(self.offsets[s]);
            }
            let (lo, hi) = at[1..N].iter().fold((at[0], at[0]), |(lo, hi), &e| (lo.min(e), hi.max(e)));
            let reach = (SIDE - 1) as i64;
            let (a, b) = (edge.a as i64, edge.b as i64);
            if hi + (a.max(0) + b.max(0)) * reach < 0 {
                return;
            }
            // An edge that crosses the tile fits 32 bits; one that accepts the tile whole does not matter any more.
            if lo + (a.min(0) + b.min(0)) * reach < 0 {
                edges[i] = (edge.a, edge.b);
                bounds[i] = [lo as i32, hi as i32];
                for s in 0..N {
                    values[i][s] = at[s] as i32;
                }
            }
        }
        let plane = Plane::new(r);
        let lanes = kernel(
            #[inline(always)]
            |vector: usize| {
                [0, 1, 2].each(
                    #[inline(always)]
                    |k: usize| {
                        let mut lanes = [0; LANES];
                        (0..LANES).for_each(|lane| lanes[lane] = values[k][(vector * LANES + lane) % N]);
                        i32x8::load_array_ref(simd, &lanes) + self.cells * i32x8::splat(simd, edges[k].0)
                    },
                )
            },
        );
        let lanes = [lanes(0), if Self::VECTORS > 1 { lanes(1) } else { lanes(0) }];
        let blocks = edges.each(
            #[inline(always)]
            |(a, _)| self.lanes * i32x8::splat(simd, a * BLOCK),
        );
        let groups = edges.each(
            #[inline(always)]
            |(a, b)| {
                let mut groups = [0; LANES];
                for (i, group) in (0..).zip(&mut groups) {
                    *group = a * (i % Self::ACROSS * Self::GROUP) + b * (i / Self::ACROSS);
                }
                i32x8::load_array_ref(simd, &groups)
            },
        );
        let reach = BLOCK - 1;
        // From an edge function in a block's or group's first cell to its bounds within.
        let rise = kernel(
            #[inline(always)]
            |k: usize| bounds[k][1] + edges[k].0.max(0) * (Self::GROUP - 1),
        );
        let rises = [rise(0), rise(1), rise(2)];
        let bound = kernel(
            #[inline(always)]
            |k: usize| {
                let (a, b) = edges[k];
                [bounds[k][0] + (a.min(0) + b.min(0)) * reach, bounds[k][1] + (a.max(0) + b.max(0)) * reach]
            },
        );
        let block_bounds = [bound(0), bound(1), bound(2)];
        let (corner, sample_reach) = (self.corner, self.reach);
        let places = kernel(
            #[inline(always)]
            |axis: usize, cell: i32| {
                let first = corner[axis] + cell * STEPS;
                [first + sample_reach[axis][0], first + reach * STEPS + sample_reach[axis][1]]
            },
        );
        let mut by = (y0 & !(BLOCK - 1)) - BLOCK;
        while by + BLOCK <= y1 {
            by += BLOCK;
            // Eight blocks at a time: which may hold a place, which are inside whole?
            let mut most = i32x8::splat(simd, 0);
            let mut least = i32x8::splat(simd, 0);
            for k in 0..3 {
                let at = blocks[k] + i32x8::splat(simd, edges[k].1 * by);
                least |= at + i32x8::splat(simd, block_bounds[k][0]);
                most |= at + i32x8::splat(simd, block_bounds[k][1]);
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
                if self.order.hides(plane.nearest(places(0, bx), places(1, by)), self.farthest(block, bx, by)) {
                    continue;
                }
                if whole >> column & 1 == 1 {
                    let mut farthest = f32x8::splat(simd, f32::INFINITY);
                    let all = mask32x8::splat(simd, true);
                    for y in by..by + BLOCK {
                        for x in (bx..bx + BLOCK).step_by(Self::GROUP as usize) {
                            for vector in 0..Self::VECTORS {
                                let z = self.depth(&plane, x, y, vector);
                                let now = self.write(r.id, z, [x, y], vector, all);
                                farthest = now.simd_lt(farthest).select(now, farthest);
                            }
                        }
                    }
                    self.farthest[block] = farthest.reduce_min_precise();
                    continue;
                }
                self.n_drawn[block] += 1;
                // Eight groups at a time: which may hold a place? The bound stays low, until somebody looks.
                for top in (by..by + BLOCK).step_by(Self::ROWS as usize) {
                    let mut most = i32x8::splat(simd, 0);
                    let mut at = [[0; LANES]; 3];
                    for k in 0..3 {
                        let (a, b) = edges[k];
                        let group = groups[k] + i32x8::splat(simd, a * bx + b * top);
                        group.store_array(&mut at[k]);
                        most |= group + i32x8::splat(simd, rises[k]);
                    }
                    let mut some = most.simd_ge(zero).to_bitmask() as u32;
                    while some != 0 {
                        let group = some.trailing_zeros() as usize % LANES;
                        some &= some - 1;
                        let (x, y) = (group as i32 % Self::ACROSS * Self::GROUP, group as i32 / Self::ACROSS);
                        let (x, y) = (bx + x, top + y);
                        for vector in 0..Self::VECTORS {
                            let edge = kernel(
                                #[inline(always)]
                                |k: usize| lanes[vector][k] + i32x8::splat(simd, at[k][group]),
                            );
                            let inside = (edge(0) | edge(1) | edge(2)).simd_ge(zero);
                            let z = self.depth(&plane, x, y, vector);
                            self.write(r.id, z, [x, y], vector, inside);
                        }
                    }
                }
            }
        }
    }

    /// Whether `test(pass, block, column, row)` holds for all blocks that touch a box of cells; stops when it does not.
    #[inline(always)]
    fn each_block(
        &mut self,
        [x0, x1]: [i32; 2],
        [y0, y1]: [i32; 2],
        test: impl Fn(&mut Self, usize, i32, i32) -> bool,
    ) -> bool {
        for y in y0 / BLOCK..=y1 / BLOCK {
            for x in x0 / BLOCK..=x1 / BLOCK {
                if !test(self, (y * (SIDE / BLOCK) + x) as usize, x * BLOCK, y * BLOCK) {
                    return false;
                }
            }
        }
        true
    }

    /// A lower bound of a block's depths: looked for anew when some triangles were drawn since it was.
    #[inline(always)]
    fn farthest(&mut self, block: usize, bx: i32, by: i32) -> f32 {
        if self.n_drawn[block] >= 2 {
            self.n_drawn[block] = 0;
            let mut farthest = f32x8::splat(self.simd, f32::INFINITY);
            for y in by..by + BLOCK {
                let row = (y * SIDE + bx) as usize * N;
                for depths in self.depths[row..row + BLOCK as usize * N].as_chunks::<LANES>().0 {
                    let depths = f32x8::load_array_ref(self.simd, depths);
                    farthest = depths.simd_lt(farthest).select(depths, farthest);
                }
            }
            self.farthest[block] = farthest.reduce_min_precise();
        }
        self.farthest[block]
    }
}
