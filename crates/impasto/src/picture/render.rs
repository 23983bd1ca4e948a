//! The tile loop: from sorted triangles to finished rows, one tile at a time.
//!
//! Each tile is rasterized, its cells are gathered into batches of one look each, looked up, lit, and resolved in linear
//! light. Transparent layers go first, nearest first, and what they let through is kept for each sample. A surface is
//! shaded once for each cell it shows in, however many of its samples it covers.

use crate::assets::{AlphaMode, Mesh, Part};
use crate::color::LinearRgba;
use crate::lookup::{self, Looks, Points, Shading, Surfaces, Wanted};
use crate::math::{BATCH, Lane};
use crate::par::Workers;
use crate::picture::stretches::Stretches;
use crate::picture::{self, Develop, Lighting};
use crate::placement::{Needs, Surfels, TexCoords};
use crate::visibility::{
    self, AlphaTest, CENTER, Domain, Draw, Faces, InfoBuffer, Kind, Places, Samples, TILE, Tile, Tiles, tile::Layer,
};
use fearless_simd::{Simd, dispatch};
use gather::PartCursor;
use std::ops::{Deref, DerefMut};
use std::slice::ChunksMut;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

mod gather;
mod still;

pub use still::Still;

/// All that a picture depends on besides where surfaces are seen, which a [`Domain`] says.
pub struct Shot<'a> {
    /// What surfaces look like.
    pub looks: &'a Looks,
    /// What lights them.
    pub lighting: &'a Lighting,
    /// Show colours as they are, whatever the looks say.
    pub unlit: bool,
    /// Places looked at in each cell.
    pub samples: Samples,
    /// Develop what may be developed by itself at once ([`Cells::developed`]).
    pub develop: Option<Develop>,
}

/// What a run of cells sends towards the eye.
#[derive(Clone, Copy, Debug)]
pub struct Cells<'a> {
    /// Premultiplied linear light; none where the cell is developed.
    pub light: &'a [LinearRgba],
    /// There is no light at all.
    pub is_dark: bool,
    /// Pixels of opaque cells that one surface fills, their four bytes; 0 for all others. Empty where there are none, or
    /// none were asked for.
    pub developed: &'a [u32],
}

impl<'a> Cells<'a> {
    /// None developed.
    pub fn of_light(light: &'a [LinearRgba]) -> Self {
        Self { light, is_dark: false, developed: &[] }
    }
}

/// What a picture could not show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shortfall {
    /// Tiles with more transparent layers behind each other than [`visibility::tile::MAX_LAYERS`].
    pub n_truncated_tiles: usize,
}

/// How a mesh's triangles take part, from the looks of its parts.
pub fn draws(mesh: &Mesh, looks: &Looks) -> Vec<Draw> {
    let draw = |(i, part): (usize, &Part)| {
        let look = looks.look_of_part(i);
        let kind = match look.alpha_mode {
            AlphaMode::Blend => Kind::Layered,
            _ if look.is_opaque() => Kind::Solid,
            _ => Kind::Tested,
        };
        let faces = if look.is_double_sided { Faces::Both } else { Faces::Front };
        Draw { triangles: part.triangles.clone(), faces, kind }
    };
    mesh.parts().iter().enumerate().map(draw).collect()
}

/// Sorts, rasterizes and shades views; keeps its buffers from one to the next.
#[derive(Default)]
pub struct Renderer {
    /// The last view's triangles by tile.
    pub tiles: Tiles,
    rooms: Mutex<Vec<Room>>,
}

impl Renderer {
    /// Sorts a view's triangles into tiles for [`shade`](Self::shade).
    pub fn sort(&mut self, domain: &Domain, shot: &Shot, workers: &Workers) {
        self.tiles.bin(domain, &draws(domain.mesh, shot.looks), shot.samples, workers);
    }

    /// Rasterizes and shades what [`sort`](Self::sort) prepared. `finish` gets the column and row of the first of a run of
    /// cells, what they send to the eye, and their place in `picture`, which has one entry a cell.
    pub fn shade<T: Copy + Send>(
        &self,
        domain: &Domain,
        shot: &Shot,
        workers: &Workers,
        picture: &mut [T],
        finish: impl Fn([u32; 2], Cells, &mut [T]) + Sync,
    ) -> Shortfall {
        self.each_tile(domain, shot, workers, picture, finish, |index, shader| self.shade_tile(index, shader))
    }

    fn shade_tile(&self, index: usize, shader: &mut Shader) {
        let (domain, shot, workers) = (shader.domain, shader.shot, shader.workers);
        let Room { tile, alpha, .. } = &mut *shader.room;
        let mut test = |id, places: &Places| alpha_test((domain, shot, workers), alpha, id, places);
        self.tiles.rasterize(index, Some(&mut test as &mut AlphaTest), workers, tile);
        let tile = std::mem::take(tile);
        shader.shade(&tile);
        shader.room.tile = tile;
    }

    /// Shades an information buffer again, for other textures, lights or layers: only triangles that are seen are looked at.
    pub fn shade_buffer<T: Copy + Send>(
        &self,
        buffer: &InfoBuffer,
        domain: &Domain,
        shot: &Shot,
        workers: &Workers,
        picture: &mut [T],
        finish: impl Fn([u32; 2], Cells, &mut [T]) + Sync,
    ) -> Shortfall {
        assert_eq!((buffer.size, buffer.samples), (domain.size, shot.samples), "the buffer belongs to another view");
        self.each_tile(domain, shot, workers, picture, finish, |index, shader| shader.shade(&buffer.tiles[index]))
    }

    fn each_tile<T: Copy + Send>(
        &self,
        domain: &Domain,
        shot: &Shot,
        workers: &Workers,
        picture: &mut [T],
        finish: impl Fn([u32; 2], Cells, &mut [T]) + Sync,
        shade: impl Fn(usize, &mut Shader) + Sync,
    ) -> Shortfall {
        assert_eq!(picture.len(), domain.size.n_cells(), "the picture has one entry a cell");
        let [n_x, _] = visibility::tile::n_tiles(domain.size);
        let n_truncated_tiles = AtomicUsize::new(0);
        workers.consume(
            TileRows::new(picture, domain.size.width),
            || Shader::new(domain, shot, workers, &self.rooms),
            |shader, index, mut rows| {
                shade(index, shader);
                n_truncated_tiles.fetch_add(shader.truncated as usize, Ordering::Relaxed);
                let (x, y) = ((index % n_x * TILE) as u32, (index / n_x * TILE) as u32);
                let Room { light, is_dark, developed, is_blank, .. } = &*shader.room;
                for (i, row) in rows.iter_mut().enumerate() {
                    let light = &light[i * TILE..][..row.len()];
                    let developed = if *is_blank { &[] } else { &developed[i * TILE..][..row.len()] };
                    finish([x, y + i as u32], Cells { light, is_dark: *is_dark, developed }, row);
                }
            },
        );
        Shortfall { n_truncated_tiles: n_truncated_tiles.into_inner() }
    }
}

/// A picture cut into the rows of its tiles, tile after tile.
struct TileRows<'a, T> {
    /// Bands as high as a tile.
    bands: ChunksMut<'a, T>,
    width: usize,
    /// What is left of a band's rows.
    rows: Vec<&'a mut [T]>,
}

impl<'a, T> TileRows<'a, T> {
    fn new(picture: &'a mut [T], width: u32) -> Self {
        let width = (width as usize).max(1);
        Self { bands: picture.chunks_mut(width * TILE), width, rows: Vec::new() }
    }
}

impl<'a, T> Iterator for TileRows<'a, T> {
    type Item = Vec<&'a mut [T]>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rows.first().is_none_or(|row| row.is_empty()) {
            self.rows.clear();
            self.rows.extend(self.bands.next()?.chunks_mut(self.width));
        }
        let cut = |row: &mut &'a mut [T]| {
            let n = row.len().min(TILE);
            let (run, rest) = std::mem::take(row).split_at_mut(n);
            *row = rest;
            run
        };
        Some(self.rows.iter_mut().map(cut).collect())
    }
}

/// The information buffer of a shot, alpha tests included.
pub fn info_buffer(domain: &Domain, shot: &Shot, workers: &Workers) -> InfoBuffer {
    let test = || -> Box<AlphaTest> {
        let mut room = None;
        Box::new(move |id, places| alpha_test((domain, shot, workers), &mut room, id, places))
    };
    InfoBuffer::build(domain, &draws(domain.mesh, shot.looks), shot.samples, Some(&test), workers)
}

/// Surfaces of one look that wait for a full batch: in which cell of the tile they show, in which of its samples (bits).
struct Waiting {
    n: usize,
    cell: [u32; BATCH],
    triangle: [u32; BATCH],
    samples: [u32; BATCH],
    /// Each fills its cell.
    is_whole: bool,
}

impl Waiting {
    const EMPTY: Self = Self { n: 0, cell: [0; BATCH], triangle: [0; BATCH], samples: [0; BATCH], is_whole: true };

    #[inline(always)]
    fn push(&mut self, cell: u32, triangle: u32, samples: u32) {
        self.cell[self.n] = cell;
        self.triangle[self.n] = triangle;
        self.samples[self.n] = samples;
        self.is_whole = false;
        self.n += 1;
    }
}

/// Room that a thread works in, kept from picture to picture.
#[derive(Default)]
struct Room {
    tile: Tile,
    batch: Batch,
    alpha: Option<Box<Batch>>,
    stretches: Option<Box<Stretches>>,
    /// By look.
    waiting: Vec<Waiting>,
    /// Premultiplied linear light of the tile's cells.
    light: Vec<LinearRgba>,
    /// Nothing but zeros is in `light`.
    is_dark: bool,
    /// Pixels of the tile's cells that were developed as soon as they were lit.
    developed: Vec<u32>,
    /// Nothing but zeros is in `developed`.
    is_blank: bool,
    /// What gets through to the next layer, for each sample of each cell; empty when nothing transparent was met.
    through: Vec<f32>,
}

/// One batch's way from surfels to light.
struct Batch {
    surfels: Box<Surfels>,
    surfaces: Box<Surfaces>,
    scratch: Box<lookup::Scratch>,
    light: Box<[Lane; 3]>,
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            surfels: Surfels::new(0),
            surfaces: Surfaces::new(),
            scratch: lookup::Scratch::new(),
            light: Box::new([[0.0; BATCH]; 3]),
        }
    }
}

/// What a thread needs to shade tiles.
struct Shader<'a> {
    domain: &'a Domain<'a>,
    shot: &'a Shot<'a>,
    workers: &'a Workers,
    /// For each look, what its passes read.
    needs: Vec<Needs>,
    room: Loan<'a>,
    truncated: bool,
    /// The batches of the tile, for a picture that stands still.
    recorded: Option<Vec<still::Patch>>,
}

/// How light meets a look.
fn shading(shot: &Shot, look: usize) -> Shading {
    if shot.unlit { Shading::Unlit } else { shot.looks.looks[look].shading }
}

/// What a look and its light read of surfels.
pub fn needs(shot: &Shot, look: usize) -> Needs {
    shot.looks.looks[look].needs().or(picture::needs(shading(shot, look), shot.lighting))
}

impl<'a> Shader<'a> {
    fn new(domain: &'a Domain<'a>, shot: &'a Shot<'a>, workers: &'a Workers, rooms: &'a Mutex<Vec<Room>>) -> Self {
        let room = rooms.lock().ok().and_then(|mut rooms| rooms.pop()).unwrap_or_default();
        let mut room = Loan { room: Some(room), home: rooms };
        let n_looks = shot.looks.looks.len();
        room.batch.surfels.uv.resize(domain.mesh.uv_sets().len(), TexCoords::ZERO);
        room.waiting.resize_with(n_looks, || Waiting::EMPTY);
        room.light.resize(TILE * TILE, [0.0; 4]);
        room.developed.resize(TILE * TILE, 0);
        let needs = (0..n_looks).map(|look| needs(shot, look)).collect();
        Self { domain, shot, workers, needs, room, truncated: false, recorded: None }
    }

    /// Fills `light` with what the tile's cells send towards the eye.
    fn shade(&mut self, tile: &Tile) {
        self.truncated = tile.truncated;
        self.start(tile.n_layers > 0);
        if !tile.touched {
            return;
        }
        for layer in &tile.layers[..tile.n_layers] {
            self.layer(tile, layer);
        }
        self.layer(tile, &tile.solid);
    }

    /// A dark tile, and nothing in the way of its light.
    fn start(&mut self, has_layers: bool) {
        let room = &mut *self.room;
        if !std::mem::replace(&mut room.is_dark, true) {
            room.light.as_flattened_mut().fill(0.0);
        }
        if !std::mem::replace(&mut room.is_blank, true) {
            room.developed.fill(0);
        }
        room.through.clear();
        if has_layers {
            room.through.resize(TILE * TILE * self.shot.samples.n(), 1.0);
        }
    }

    fn layer(&mut self, tile: &Tile, layer: &Layer) {
        dispatch!(self.workers.level(), simd => match self.shot.samples {
            Samples::One => self.gather::<_, 1>(simd, tile, layer),
            Samples::Four => self.gather::<_, 4>(simd, tile, layer),
            Samples::Sixteen => self.gather::<_, 16>(simd, tile, layer),
        });
        for look in 0..self.room.waiting.len() {
            self.flush(tile, look);
        }
    }

    /// Looks up and lights what waits, and adds it to the cells.
    fn flush(&mut self, tile: &Tile, look: usize) {
        let room = &mut *self.room;
        let (waiting, batch) = (&room.waiting[look], &mut room.batch);
        if waiting.n == 0 {
            return;
        }
        let (domain, shot, needs) = (self.domain, self.shot, self.needs[look]);
        dispatch!(self.workers.level(), simd => {
            place(tile.origin, waiting, &mut batch.surfels);
            look_and_light(simd, domain, shot, look, needs, batch);
        });
        self.keep(look);
        self.add(look);
    }

    /// Develops a batch where it may be developed by itself, or adds its light to its cells; then nothing waits.
    fn add(&mut self, look: usize) {
        let (shot, room) = (self.shot, &mut *self.room);
        let waiting = &room.waiting[look];
        let is_opaque = shot.looks.looks[look].alpha_mode != AlphaMode::Blend;
        match &shot.develop {
            Some(develop) if waiting.is_whole && is_opaque && room.through.is_empty() => {
                let Room { developed, is_blank, batch, .. } = room;
                let developed = developed.as_mut_slice().try_into().expect("a tile of pixels");
                let (light, cells) = (&*batch.light, (&waiting.cell, waiting.n));
                dispatch!(self.workers.level(), simd => develop.opaque8(simd, light, cells, developed));
                *is_blank = false;
            }
            _ => self.composite(look),
        }
        let waiting = &mut self.room.waiting[look];
        (waiting.n, waiting.is_whole) = (0, true);
    }

    /// Adds a batch's light to its cells, weighted by the samples covered and by what nearer layers let through.
    fn composite(&mut self, look: usize) {
        let n_samples = self.shot.samples.n();
        let Room { waiting, batch, light, is_dark, through, .. } = &mut *self.room;
        *is_dark = false;
        let waiting = &waiting[look];
        let light: &mut [LinearRgba; TILE * TILE] = light.as_mut_slice().try_into().expect("a tile of light");
        let [r, g, b] = &*batch.light;
        if n_samples == 1 && through.is_empty() {
            for i in 0..waiting.n.min(BATCH) {
                light[waiting.cell[i] as usize % (TILE * TILE)] = [r[i], g[i], b[i], 1.0];
            }
            return;
        }
        let share = 1.0 / n_samples as f32;
        let blend = self.shot.looks.looks[look].alpha_mode == AlphaMode::Blend;
        for i in 0..waiting.n {
            let alpha = if blend { batch.surfaces.alpha[i] } else { 1.0 };
            let (index, samples) = (waiting.cell[i] as usize, waiting.samples[i]);
            let weight = if through.is_empty() {
                samples.count_ones() as f32 * share
            } else {
                let mut weight = 0.0;
                for s in (0..n_samples).filter(|s| samples >> s & 1 == 1) {
                    let through = &mut through[index * n_samples + s];
                    weight += *through * alpha;
                    *through *= 1.0 - alpha;
                }
                weight * share
            };
            let cell = &mut light[index % (TILE * TILE)];
            *cell = [cell[0] + weight * r[i], cell[1] + weight * g[i], cell[2] + weight * b[i], cell[3] + weight];
        }
    }
}

/// A room on loan: it goes back when the picture is done.
struct Loan<'a> {
    room: Option<Room>,
    home: &'a Mutex<Vec<Room>>,
}

impl Deref for Loan<'_> {
    type Target = Room;
    fn deref(&self) -> &Room {
        self.room.as_ref().expect("a room until it is given back")
    }
}

impl DerefMut for Loan<'_> {
    fn deref_mut(&mut self) -> &mut Room {
        self.room.as_mut().expect("a room until it is given back")
    }
}

impl Drop for Loan<'_> {
    fn drop(&mut self) {
        if let (Some(room), Ok(mut home)) = (self.room.take(), self.home.lock()) {
            home.push(room);
        }
    }
}

/// Columns, rows and triangles of what waits.
#[inline(always)]
fn place(origin: [u32; 2], waiting: &Waiting, surfels: &mut Surfels) {
    surfels.n = waiting.n;
    let [x, y] = &mut surfels.cell;
    // All of the batch, so that the loop is one of whole vectors.
    for i in 0..BATCH {
        x[i] = origin[0] + waiting.cell[i] % TILE as u32;
        y[i] = origin[1] + waiting.cell[i] / TILE as u32;
        surfels.triangle[i] = waiting.triangle[i];
    }
}

/// Surface points, what is there, and what light makes of it.
#[inline(always)]
fn look_and_light<S: Simd>(simd: S, domain: &Domain, shot: &Shot, look: usize, needs: Needs, batch: &mut Batch) {
    let Batch { surfels, surfaces, scratch, light } = batch;
    visibility::fill(simd, domain, needs, &CENTER, surfels);
    let points = Points { mesh: domain.mesh, view: &domain.view, surfels, wanted: Wanted::Light(shading(shot, look)) };
    lookup::evaluate(simd, (shot.looks, look), points, scratch, surfaces);
    picture::shade(simd, shading(shot, look), shot.lighting, surfels, surfaces, light);
}

/// At which of up to eight places of a row (bits) a triangle is there.
fn alpha_test(
    (domain, shot, workers): (&Domain, &Shot, &Workers),
    room: &mut Option<Box<Batch>>,
    triangle: u32,
    places: &Places,
) -> u32 {
    let look = PartCursor::new(domain.mesh, shot.looks).look(triangle);
    let cutoff = match shot.looks.looks[look].alpha_mode {
        AlphaMode::Mask(cutoff) => cutoff,
        // What an alpha test among the layers refuses has no alpha left.
        _ => f32::MIN_POSITIVE,
    };
    let Batch { surfels, surfaces, scratch, .. } = &mut **room.get_or_insert_default();
    surfels.uv.resize(domain.mesh.uv_sets().len(), TexCoords::ZERO);
    surfels.n = 0;
    let lanes = || (0..8).filter(|lane| places.bits >> lane & 1 == 1);
    let mut within = CENTER;
    for lane in lanes() {
        surfels.cell[0][surfels.n] = places.column[lane];
        surfels.cell[1][surfels.n] = places.row;
        surfels.triangle[surfels.n] = triangle;
        (0..2).for_each(|axis| within[axis][surfels.n] = places.within[lane][axis] as f32 * (1.0 / 256.0));
        surfels.n += 1;
    }
    let needs = shot.looks.looks[look].needs();
    let alpha = &mut surfaces.alpha;
    dispatch!(workers.level(), simd => {
        visibility::fill(simd, domain, needs, &within, surfels);
        let points = Points { mesh: domain.mesh, view: &domain.view, surfels, wanted: Wanted::Alpha };
        lookup::alpha_of(simd, (shot.looks, look), points, scratch, alpha);
    });
    lanes().enumerate().filter(|(i, _)| alpha[*i] >= cutoff).fold(0, |kept, (_, lane)| kept | 1 << lane)
}
