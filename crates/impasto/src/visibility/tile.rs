//! From triangles to tiles of cells: the drive of the rasterizer, and what a tile holds.

use super::bin::{Bins, Record};
use super::depth::Order;
use super::{Domain, raster};
use crate::math::Size;
use crate::par::Workers;
use fearless_simd::dispatch;
use std::ops::Range;

/// Cells along a tile's side: ids and depths of a tile (32 KiB) fit the first-level cache.
pub const TILE: usize = 64;
/// Cells of a tile.
pub(crate) const TILE_CELLS: usize = TILE * TILE;

/// Which sides of a triangle are seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Faces {
    /// Both.
    #[default]
    Both,
    /// Counter-clockwise ones only.
    Front,
}

/// How a triangle takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Kind {
    /// Hides what is behind it.
    #[default]
    Solid,
    /// Hides what is behind it where the alpha test says that it is there.
    Tested,
    /// Lets what is behind shine through: peeled into layers.
    Layered,
}

/// A run of triangles drawn alike.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draw {
    /// Which of the mesh's triangles.
    pub triangles: Range<u32>,
    /// Which sides are seen.
    pub faces: Faces,
    /// How they take part.
    pub kind: Kind,
}

/// How many places of a cell are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Samples {
    /// The centre.
    One,
    /// Four on a rotated grid.
    #[default]
    Four,
    /// Sixteen, one in each of 16 columns and rows.
    Sixteen,
}

impl Samples {
    /// Places in 1/256 of a cell from its top left corner. No two share a column or a row, so that near-vertical and
    /// near-horizontal edges show all shades.
    pub const fn offsets(self) -> &'static [[i32; 2]] {
        match self {
            Self::One => &[[128, 128]],
            Self::Four => &[[96, 32], [224, 96], [32, 160], [160, 224]],
            Self::Sixteen => &[
                [8, 120],
                [24, 216],
                [40, 56],
                [56, 152],
                [72, 248],
                [88, 24],
                [104, 88],
                [120, 184],
                [136, 8],
                [152, 136],
                [168, 232],
                [184, 72],
                [200, 40],
                [216, 168],
                [232, 104],
                [248, 200],
            ],
        }
    }

    /// How many.
    pub const fn n(self) -> usize {
        self.offsets().len()
    }

    /// Distance between neighbouring columns (and rows) of places, and the first, in 1/256 of a cell.
    pub(crate) const fn spacing(self) -> (i32, i32) {
        match self {
            Self::One => (256, 128),
            Self::Four => (64, 32),
            Self::Sixteen => (16, 8),
        }
    }

    /// By number.
    pub fn from_n(n: u32) -> Option<Self> {
        match n {
            1 => Some(Self::One),
            4 => Some(Self::Four),
            16 => Some(Self::Sixteen),
            _ => None,
        }
    }
}

/// Up to eight places in a row of cells.
pub struct Places {
    /// The cells' row.
    pub row: u32,
    /// The cells' columns.
    pub column: [u32; 8],
    /// Where in their cells the places are, 1/256 across and down.
    pub within: [[i32; 2]; 8],
    /// Which of the eight are asked about.
    pub bits: u32,
}

/// Says at which of the places (bits) a triangle is there: `test(triangle, places) -> bits`.
pub type AlphaTest<'a> = dyn FnMut(u32, &Places) -> u32 + 'a;

/// One layer of a tile: an id and a depth for each sample of 64 x 64 cells in rows, a cell's samples side by side.
#[derive(Clone, Default)]
pub struct Layer {
    /// Triangle ids, `TILE * TILE * samples`; [`super::Hit::NOTHING`] where nothing is.
    pub ids: Vec<u32>,
    /// Depths, likewise; 0 where nothing is, larger is nearer.
    pub depths: Vec<f32>,
    /// How many samples a cell has if nothing was drawn since the last reset.
    clear_of: Option<usize>,
}

/// What the cells of a tile see.
#[derive(Clone, Default)]
pub struct Tile {
    /// Column and row of the first cell.
    pub origin: [u32; 2],
    /// Cells within the grid, across and down; at most [`TILE`].
    pub extent: [u32; 2],
    /// The first layer: the nearest solid surface.
    pub solid: Layer,
    /// Layered surfaces before it, nearest first; only the first `n_layers` are valid.
    pub layers: Vec<Layer>,
    /// How many layers are valid.
    pub n_layers: usize,
    /// Whether more layers lay behind the last one than were asked for.
    pub truncated: bool,
    /// Whether anything is in the tile at all.
    pub touched: bool,
}

/// Most layers of transparent surfaces that are told apart.
pub const MAX_LAYERS: usize = 32;

/// All triangles of a view sorted into tiles, ready to be rasterized tile by tile. Keeps its buffers between views.
#[derive(Default)]
pub struct Tiles {
    pub(super) bins: Bins,
    size: Size,
    samples: Samples,
}

impl Tiles {
    /// Sorts a view's triangles. `draws` say which and how; all else is not seen.
    pub fn bin(&mut self, domain: &Domain, draws: &[Draw], samples: Samples, workers: &Workers) {
        self.snap(domain, workers);
        self.sort(domain, draws, samples, workers);
    }

    /// The first half of [`bin`](Self::bin): vertices to fixed-point cells.
    pub fn snap(&mut self, domain: &Domain, workers: &Workers) {
        self.bins.snap(domain, workers);
    }

    /// The second half of [`bin`](Self::bin): triangles to tiles, in the domain that was snapped last.
    pub fn sort(&mut self, domain: &Domain, draws: &[Draw], samples: Samples, workers: &Workers) {
        self.size = domain.size;
        self.samples = samples;
        self.bins.sort(domain, draws, samples, workers);
    }

    /// Tiles across and down.
    pub fn n_tiles(&self) -> [usize; 2] {
        n_tiles(self.size)
    }

    /// Fills `tile` with what its cells see.
    pub fn rasterize(&self, index: usize, mut test: Option<&mut AlphaTest>, workers: &Workers, tile: &mut Tile) {
        let [n_x, _] = self.n_tiles();
        tile.origin = [(index % n_x * TILE) as u32, (index / n_x * TILE) as u32];
        tile.extent =
            [(self.size.width - tile.origin[0]).min(TILE as u32), (self.size.height - tile.origin[1]).min(TILE as u32)];
        let samples = self.samples;
        let solid: Vec<&[Record]> = self.bins.solid(index);
        let layered: Vec<&[Record]> = self.bins.layered(index);
        tile.touched = solid.iter().chain(&layered).any(|l| !l.is_empty());
        tile.n_layers = 0;
        tile.truncated = false;
        tile.solid.reset(samples.n());
        if !tile.touched {
            return;
        }
        tile.solid.clear_of = None;
        let origin = tile.origin;
        let mut draw = |lists: &[&[Record]], how: (Order, Option<&Layer>), layer: &mut Layer| {
            let test = test.as_deref_mut();
            dispatch!(workers.level(), simd => raster::nearest(simd, lists, samples, origin, test, how, layer));
        };
        draw(&solid, (Order::nearer_first(&solid), None), &mut tile.solid);
        while !layered.is_empty() && layered.iter().any(|l| !l.is_empty()) {
            if tile.n_layers == MAX_LAYERS {
                tile.truncated = true;
                break;
            }
            if tile.layers.len() == tile.n_layers {
                tile.layers.push(Layer::default());
            }
            let (before, rest) = tile.layers.split_at_mut(tile.n_layers);
            let layer = &mut rest[0];
            layer.reset(samples.n());
            layer.clear_of = None;
            layer.depths.copy_from_slice(&tile.solid.depths);
            draw(&layered, (Order::Forward, before.last()), layer);
            if layer.ids.iter().all(|&id| id == super::Hit::NOTHING) {
                break;
            }
            tile.n_layers += 1;
        }
    }
}

const _: () = assert!(super::Hit::NOTHING == u32::MAX);

impl Layer {
    fn reset(&mut self, n_samples: usize) {
        if self.clear_of.replace(n_samples) == Some(n_samples) {
            return;
        }
        let n = n_samples * TILE_CELLS;
        self.ids.resize(n, 0);
        // All bits set: the quickest way to write it.
        bytemuck::cast_slice_mut::<u32, u8>(&mut self.ids).fill(0xff);
        self.depths.resize(n, 0.0);
        self.depths.fill(0.0);
    }
}

/// Tiles across and down a grid.
pub fn n_tiles(size: Size) -> [usize; 2] {
    [(size.width as usize).div_ceil(TILE), (size.height as usize).div_ceil(TILE)]
}
