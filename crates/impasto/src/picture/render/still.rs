//! A view that stands still: what is seen in its cells is found once, what it looks like can change.
//!
//! The surface points of all batches are kept, with the values that data layers measured there. Another table, range,
//! isoline or light then costs the look-up alone: no triangle is touched, however many there are. This goes for opaque
//! surfaces: where a look can let something through, what is seen depends on it.

use super::{Batch, Cells, Renderer, Room, Shader, Shortfall, Shot, Waiting, draws, place, shading};
use crate::lookup::{self, Look, Points, Wanted};
use crate::math::{BATCH, Lane, Size};
use crate::par::Workers;
use crate::picture;
use crate::placement::{Measures, Needs, Placement, Property, Surfels, Viewpoint};
use crate::visibility::{Domain, Draw, Kind, Samples, TILE};
use fearless_simd::{Simd, dispatch};
use std::sync::Mutex;

/// What a shot sees in each cell.
pub struct Still {
    size: Size,
    view: Viewpoint,
    samples: Samples,
    draws: Vec<Draw>,
    /// For each look, what is kept of its surface points.
    kept: Vec<Kept>,
    tiles: Vec<Mutex<StillTile>>,
}

/// What is kept of a look's surface points.
#[derive(Clone, Default, PartialEq)]
struct Kept {
    needs: Needs,
    properties: Vec<Property>,
}

/// One tile's batches, in the order in which they are added to the picture.
#[derive(Default)]
struct StillTile {
    /// Column and row of its first cell.
    origin: [u32; 2],
    patches: Vec<Patch>,
}

/// One batch.
pub(super) struct Patch {
    look: usize,
    /// Each fills its cell.
    is_whole: bool,
    cell: Box<[u16]>,
    samples: Box<[u16]>,
    triangle: Box<[u32]>,
    /// The lanes that the look needs, one after the other.
    lanes: Vec<f32>,
    /// Of each property: values, and their changes to the right and down.
    measured: Vec<f64>,
}

impl Kept {
    fn of(shot: &Shot, look: usize) -> Self {
        let mut kept = Self { needs: shot.looks.looks[look].needs_when_measured(), properties: Vec::new() };
        kept.needs = kept.needs.or(picture::needs(shading(shot, look), shot.lighting));
        let layers = &shot.looks.looks[look].layers;
        for property in layers.iter().flat_map(|l| l.placement.properties()) {
            if !kept.properties.contains(property) {
                kept.properties.push(property.clone());
            }
        }
        kept
    }

    fn holds(&self, other: &Self) -> bool {
        self.needs.or(other.needs) == self.needs && other.properties.iter().all(|p| self.properties.contains(p))
    }
}

impl Look {
    /// Which lanes of the surfels it reads when the values of its properties are known.
    fn needs_when_measured(&self) -> Needs {
        let is_data = |p: &Placement| matches!(p, Placement::Property { .. } | Placement::PropertyInLight { .. });
        if !self.layers.iter().any(|l| is_data(&l.placement)) {
            return self.needs();
        }
        let mut rest = self.clone();
        rest.layers.retain(|l| !is_data(&l.placement));
        let is_lit = self.layers.iter().any(|l| matches!(l.placement, Placement::PropertyInLight { .. }));
        rest.needs().or(Needs { normal: is_lit, view: is_lit, ..Needs::default() })
    }
}

impl Still {
    /// Whether a shot sees the same surface points, and asks nothing about them that is not known.
    pub fn serves(&self, domain: &Domain, shot: &Shot) -> bool {
        (self.size, self.view, self.samples) == (domain.size, domain.view, shot.samples)
            && self.draws == draws(domain.mesh, shot.looks)
            && self.draws.iter().all(|d| d.kind == Kind::Solid)
            && self.kept.len() == shot.looks.looks.len()
            && self.kept.iter().enumerate().all(|(look, kept)| kept.holds(&Kept::of(shot, look)))
    }
}

impl Renderer {
    /// [`shade`](Self::shade), keeping what is seen.
    pub fn record<T: Copy + Send>(
        &self,
        domain: &Domain,
        shot: &Shot,
        workers: &Workers,
        picture: &mut [T],
        finish: impl Fn([u32; 2], Cells, &mut [T]) + Sync,
    ) -> (Still, Shortfall) {
        let [n_x, n_y] = self.tiles.n_tiles();
        let still = Still {
            size: domain.size,
            view: domain.view,
            samples: shot.samples,
            draws: draws(domain.mesh, shot.looks),
            kept: (0..shot.looks.looks.len()).map(|look| Kept::of(shot, look)).collect(),
            tiles: (0..n_x * n_y).map(|_| Mutex::default()).collect(),
        };
        let shortfall = self.each_tile(domain, shot, workers, picture, finish, |index, shader| {
            shader.recorded = Some(Vec::new());
            self.shade_tile(index, shader);
            if let Ok(mut tile) = still.tiles[index].lock() {
                tile.patches = shader.recorded.take().unwrap_or_default();
                tile.origin = [index % n_x, index / n_x].map(|i| (i * TILE) as u32);
            }
        });
        (still, shortfall)
    }

    /// What [`record`](Self::record) has seen, looked up and lit again. `still` must [serve](Still::serves) the shot; the
    /// picture is then the one that [`shade`](Self::shade) makes, bit by bit.
    pub fn shade_still<T: Copy + Send>(
        &self,
        still: &Still,
        domain: &Domain,
        shot: &Shot,
        workers: &Workers,
        picture: &mut [T],
        finish: impl Fn([u32; 2], Cells, &mut [T]) + Sync,
    ) -> Shortfall {
        self.each_tile(domain, shot, workers, picture, finish, |index, shader| {
            if let Ok(tile) = still.tiles[index].lock() {
                shader.replay(&tile, &still.kept);
            }
        })
    }
}

impl Shader<'_> {
    fn replay(&mut self, tile: &StillTile, kept: &[Kept]) {
        self.truncated = false;
        self.start(false);
        for patch in &tile.patches {
            let Room { waiting, batch, .. } = &mut *self.room;
            patch.unpack(&kept[patch.look], &mut waiting[patch.look], batch);
            let (domain, shot, waiting) = (self.domain, self.shot, &waiting[patch.look]);
            dispatch!(self.workers.level(), simd => {
                place(tile.origin, waiting, &mut batch.surfels);
                look_and_light_again(simd, domain, shot, patch.look, batch);
            });
            self.add(patch.look);
        }
    }

    /// Keeps the batch that has just been looked up.
    pub(super) fn keep(&mut self, look: usize) {
        let Some(patches) = &mut self.recorded else { return };
        let Room { waiting, batch, .. } = &mut *self.room;
        patches.push(Patch::of(look, &Kept::of(self.shot, look), &waiting[look], batch));
    }
}

impl Patch {
    fn of(look: usize, kept: &Kept, waiting: &Waiting, batch: &mut Batch) -> Self {
        let n = waiting.n;
        let mut lanes = Vec::new();
        each_lane(&mut batch.surfels, kept.needs, |lane| lanes.extend_from_slice(&lane[..n]));
        let mut measured = Vec::with_capacity(kept.properties.len() * 3 * n);
        for property in &kept.properties {
            let held = batch.scratch.measures.held().iter().find(|(p, _)| p == property);
            match held {
                Some((_, m)) => [&m.value, &m.d[0], &m.d[1]].iter().for_each(|v| measured.extend_from_slice(&v[..n])),
                // A layer that the mesh has no property for is passed over.
                None => measured.resize(measured.len() + 3 * n, 0.0),
            }
        }
        let narrow = |wide: &[u32; BATCH]| wide[..n].iter().map(|x| *x as u16).collect();
        let triangle = waiting.triangle[..n].into();
        let is_whole = waiting.is_whole;
        Self {
            look,
            is_whole,
            cell: narrow(&waiting.cell),
            samples: narrow(&waiting.samples),
            triangle,
            lanes,
            measured,
        }
    }

    fn unpack(&self, kept: &Kept, waiting: &mut Waiting, batch: &mut Batch) {
        let n = self.cell.len();
        (waiting.n, waiting.is_whole) = (n, self.is_whole);
        waiting.cell.iter_mut().zip(&self.cell).for_each(|(wide, x)| *wide = (*x).into());
        waiting.samples.iter_mut().zip(&self.samples).for_each(|(wide, x)| *wide = (*x).into());
        waiting.triangle[..n].copy_from_slice(&self.triangle);
        let mut lanes = self.lanes.chunks_exact(n);
        each_lane(&mut batch.surfels, kept.needs, |lane| {
            if let Some(packed) = lanes.next() {
                lane[..n].copy_from_slice(packed);
            }
        });
        let measures: &mut Measures = &mut batch.scratch.measures;
        measures.clear();
        for (property, packed) in kept.properties.iter().zip(self.measured.chunks_exact(3 * n)) {
            let measure = measures.push(property.clone());
            measure.value[..n].copy_from_slice(&packed[..n]);
            measure.d[0][..n].copy_from_slice(&packed[n..2 * n]);
            measure.d[1][..n].copy_from_slice(&packed[2 * n..]);
        }
    }
}

/// The lanes that a look needs, in one order for all that visit them.
fn each_lane(surfels: &mut Surfels, needs: Needs, mut visit: impl FnMut(&mut Lane)) {
    let Surfels { barycentric, d_barycentric, side, position, normal, tangent, color, view, uv, .. } = surfels;
    visit(side);
    if needs.derivatives {
        barycentric.iter_mut().chain(d_barycentric.as_flattened_mut()).for_each(&mut visit);
    }
    let triples = [(needs.position, position), (needs.normal, normal), (needs.view, view)];
    triples.into_iter().filter(|(is_needed, _)| *is_needed).flat_map(|(_, lanes)| lanes).for_each(&mut visit);
    let fours = [(needs.tangent, tangent), (needs.color, color)];
    fours.into_iter().filter(|(is_needed, _)| *is_needed).flat_map(|(_, lanes)| lanes).for_each(&mut visit);
    for (_, uv) in
        uv.iter_mut().enumerate().filter(|(set, _)| needs.uv_sets.checked_shr(*set as u32).unwrap_or(0) & 1 == 1)
    {
        uv.st.iter_mut().chain(&mut uv.d_dx).chain(&mut uv.d_dy).for_each(&mut visit);
    }
}

/// What light makes of surface points whose properties are known.
#[inline(always)]
fn look_and_light_again<S: Simd>(simd: S, domain: &Domain, shot: &Shot, look: usize, batch: &mut Batch) {
    let Batch { surfels, surfaces, scratch, light } = batch;
    let points = Points { mesh: domain.mesh, view: &domain.view, surfels, wanted: Wanted::Light(shading(shot, look)) };
    lookup::evaluate_measured(simd, (shot.looks, look), points, scratch, surfaces);
    picture::shade(simd, shading(shot, look), shot.lighting, surfels, surfaces, light);
}
