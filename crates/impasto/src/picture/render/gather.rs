//! A layer's cells to batches: by look, and by triangle where a triangle fills the cell.

use super::Shader;
use crate::assets::Mesh;
use crate::lookup::Looks;
use crate::visibility::{BATCH_FILL, Hit, TILE, Tile, tile::Layer};
use fearless_simd::{mask32x8, prelude::*, u32x8};

/// Cells that are gathered together.
const LANES: usize = 8;

impl Shader<'_> {
    /// Sorts a layer's cells by look, those that show one triangle in all samples also by triangle.
    #[inline(always)]
    pub(super) fn gather<S: Simd, const N: usize>(&mut self, simd: S, tile: &Tile, layer: &Layer) {
        let mut parts = PartCursor::new(self.domain.mesh, self.shot.looks);
        // Where several looks meet in a cell, the order in which they are added shows in the last bits: it stays.
        let sorts = N == 1 || parts.has_one_look();
        let mut stretches = self.room.stretches.take().unwrap_or_default();
        stretches.clear();
        let columns = u32x8::from_fn(simd, |i| i as u32);
        let nothing = u32x8::splat(simd, Hit::NOTHING);
        let extent = tile.extent.map(|e| e as usize);
        for row in (0..extent[1]).map(|y| y * TILE) {
            let mut before = nothing;
            let mut open = (row, Hit::NOTHING);
            for x in (0..extent[0]).step_by(LANES) {
                let cell = row + x;
                let within = columns.simd_lt(u32x8::splat(simd, (extent[0] - x) as u32));
                let ids = &layer.ids[cell * N..][..LANES * N];
                let mut shown = nothing;
                if N == 1 {
                    shown = within.select(u32x8::from_slice(simd, ids), nothing);
                } else if !is_nothing(simd, ids) {
                    let within = within.to_bitmask() as u32;
                    let (first, same) = alike::<N>(ids);
                    let whole = if sorts { same & within } else { 0 };
                    shown =
                        mask32x8::from_bitmask(simd, whole as u64).select(u32x8::load_array_ref(simd, &first), nothing);
                    let mut rest = within & !whole;
                    while rest != 0 {
                        self.split(tile, layer, cell + rest.trailing_zeros() as usize, &mut parts);
                        rest &= rest - 1;
                    }
                }
                let mut cuts = !(shown.simd_eq(before.slide::<{ LANES - 1 }>(shown)).to_bitmask() as u32) & 0xff;
                before = shown;
                while cuts != 0 {
                    let lane = cuts.trailing_zeros() as usize % LANES;
                    cuts &= cuts - 1;
                    if open.1 != Hit::NOTHING {
                        stretches.push(open.1, open.0, cell + lane - open.0);
                    }
                    open = (cell + lane, shown.as_slice()[lane]);
                }
            }
            if open.1 != Hit::NOTHING {
                stretches.push(open.1, open.0, row + extent[0] - open.0);
            }
        }
        if N > 1 {
            // Cells that several surfaces share do not go with whole ones.
            (0..self.room.waiting.len()).for_each(|look| self.flush(tile, look));
        }
        for (triangle, of) in stretches.triangles() {
            let look = parts.look(triangle);
            stretches.each(
                of,
                #[inline(always)]
                |cell, n| {
                    if self.room.waiting[look].n + n > BATCH_FILL {
                        self.flush(tile, look);
                    }
                    let waiting = &mut self.room.waiting[look];
                    let (mut at, end) = (waiting.n, waiting.n + n);
                    let mut cells = columns + u32x8::splat(simd, cell as u32);
                    while at < end {
                        let lanes = at..at + LANES;
                        cells.store_slice(&mut waiting.cell[lanes.clone()]);
                        u32x8::splat(simd, triangle).store_slice(&mut waiting.triangle[lanes.clone()]);
                        u32x8::splat(simd, (1 << N) - 1).store_slice(&mut waiting.samples[lanes]);
                        cells += LANES as u32;
                        at += LANES;
                    }
                    waiting.n = end;
                },
            );
        }
        self.room.stretches = Some(stretches);
    }

    /// The distinct triangles among one cell's samples.
    fn split(&mut self, tile: &Tile, layer: &Layer, cell: usize, parts: &mut PartCursor) {
        let n_samples = self.shot.samples.n();
        let ids = &layer.ids[cell * n_samples..][..n_samples];
        let mut left: u32 = (1 << n_samples) - 1;
        while left != 0 {
            let triangle = ids[left.trailing_zeros() as usize];
            let samples = ids.iter().rev().fold(0, |bits, &id| bits << 1 | (id == triangle) as u32);
            left &= !samples;
            if triangle != Hit::NOTHING {
                let look = parts.look(triangle);
                if self.room.waiting[look].n == BATCH_FILL {
                    self.flush(tile, look);
                }
                self.room.waiting[look].push(cell as u32, triangle, samples);
            }
        }
    }
}

/// Which look a triangle has; remembers the last part, for triangles come in runs.
pub(super) struct PartCursor<'a> {
    mesh: &'a Mesh,
    looks: &'a Looks,
    range: std::ops::Range<u32>,
    look: usize,
}

impl<'a> PartCursor<'a> {
    pub(super) fn new(mesh: &'a Mesh, looks: &'a Looks) -> Self {
        Self { mesh, looks, range: 0..0, look: 0 }
    }

    fn has_one_look(&self) -> bool {
        self.looks.look_of_part.windows(2).all(|l| l[0] == l[1])
    }

    #[inline(always)]
    pub(super) fn look(&mut self, triangle: u32) -> usize {
        if !self.range.contains(&triangle) {
            let parts = self.mesh.parts();
            let part = parts.partition_point(|p| p.triangles.end <= triangle);
            self.range = parts[part].triangles.clone();
            self.look = self.looks.look_of_part[part] as usize;
        }
        self.look
    }
}

/// For eight cells the triangle in their first sample, and in which of them (bits) all samples show the same.
#[inline(always)]
fn alike<const N: usize>(ids: &[u32]) -> ([u32; LANES], u32) {
    let mut first = [0; LANES];
    let mut same = 0;
    for (lane, ids) in ids.as_chunks::<N>().0.iter().enumerate().take(LANES) {
        first[lane] = ids[0];
        let differences = ids.iter().fold(0, |bits, id| bits | (id ^ ids[0]));
        same |= ((differences == 0) as u32) << lane;
    }
    (first, same)
}

/// Whether ids of whole vectors are [`Hit::NOTHING`] all.
#[inline(always)]
fn is_nothing<S: Simd>(simd: S, ids: &[u32]) -> bool {
    let all = u32x8::splat(simd, Hit::NOTHING);
    ids.as_chunks::<LANES>()
        .0
        .iter()
        .fold(all, |all, ids| all & u32x8::load_array_ref(simd, ids))
        .simd_eq(all)
        .all_true()
}
