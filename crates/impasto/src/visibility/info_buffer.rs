//! The information buffer: which surface point does each cell see? Triangle id and depth are stored, all else is derived.

use super::tile::{AlphaTest, Draw, Samples, Tile, Tiles, n_tiles};
use super::{Domain, TILE};
use crate::math::Size;
use crate::par::Workers;

/// Where on a surface a cell looks. Derived from the buffer's triangle id and the cell's centre; never stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Weights of the triangle's second and third corner; the first has the rest.
    /// Perspective-correct: they weigh points in space, not on the screen.
    pub barycentric: [f32; 2],
    /// 1/w: larger is nearer, 0 is nothing. Over an atlas always 1; for parallel projections 1 (back) to 2 (front).
    pub depth: f32,
    /// Index into `Mesh::triangles`, or [`Hit::NOTHING`].
    pub triangle: u32,
}

impl Hit {
    /// The triangle id of cells that see nothing.
    pub const NOTHING: u32 = u32::MAX;
}

/// What every cell of a grid sees: ids and depths, tile by tile.
///
/// Built once a view; textures, lights and layers may change without building it again.
#[derive(Clone)]
pub struct InfoBuffer {
    /// Cells across and down.
    pub size: Size,
    /// Places looked at in each cell.
    pub samples: Samples,
    /// The tiles in rows.
    pub tiles: Vec<Tile>,
}

impl InfoBuffer {
    /// Sorts and rasterizes a view's triangles.
    ///
    /// `test` makes an alpha test for each thread; draws of [`Kind::Tested`](super::Kind::Tested) are solid without one.
    pub fn build<'t>(
        domain: &Domain,
        draws: &[Draw],
        samples: Samples,
        test: Option<&(dyn Fn() -> Box<AlphaTest<'t>> + Sync)>,
        workers: &Workers,
    ) -> Self {
        let mut sorted = Tiles::default();
        sorted.bin(domain, draws, samples, workers);
        let [n_x, n_y] = n_tiles(domain.size);
        let mut tiles = vec![Tile::default(); n_x * n_y];
        workers.for_each_with(
            &mut tiles,
            || test.map(|make| make()),
            |test, i, tile| sorted.rasterize(i, test.as_deref_mut(), workers, tile),
        );
        Self { size: domain.size, samples, tiles }
    }

    /// Triangle id and depth at a cell's first sample (its centre when there is one sample).
    pub fn at(&self, column: u32, row: u32) -> (u32, f32) {
        let [n_x, _] = n_tiles(self.size);
        let tile = &self.tiles[row as usize / TILE * n_x + column as usize / TILE];
        let at = (row as usize % TILE * TILE + column as usize % TILE) * self.samples.n();
        (tile.solid.ids[at], tile.solid.depths[at])
    }

    /// One number a cell of the first sample, in rows from the top: triangle ids.
    pub fn ids(&self) -> Vec<u32> {
        (0..self.size.height)
            .flat_map(|y| (0..self.size.width).map(move |x| (x, y)))
            .map(|(x, y)| self.at(x, y).0)
            .collect()
    }
}
