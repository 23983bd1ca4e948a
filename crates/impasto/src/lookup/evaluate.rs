//! A look's stack of layers at a batch of surface points, pass after pass.
//!
//! The one implementation for pictures, baked texels and the probe. A point's answer depends on nothing but the point: not
//! on its neighbours in the batch, its lane, or the width of the machine's vectors.

use crate::assets::{AlphaMode, Mesh};
use crate::color::{Encoding, linear_from_bytes};
use crate::lookup::layer::{Channel, Layer, Look, Target, Texture};
use crate::lookup::normal::{self, Bumps};
use crate::lookup::operator::{Gate, Operator, combine_alpha, combine_color, combine_number, rules};
use crate::lookup::read::ReadScratch;
use crate::lookup::{BaseFormat, Looks, Reading, Shading, Surfaces};
use crate::math::{BATCH, Lane};
use crate::placement::{self, Measures, Placement, Surfels, TexCoords, Viewpoint};
use fearless_simd::Simd;

/// The points a question is about.
#[derive(Clone, Copy)]
pub struct Points<'a> {
    /// Which mesh they lie on.
    pub mesh: &'a Mesh,
    /// From where they are seen.
    pub view: &'a Viewpoint,
    /// The points; all lanes that [`Look::needs`] asks for.
    pub surfels: &'a Surfels,
    /// What is asked.
    pub wanted: Wanted,
}

/// Which lanes of [`Surfaces`] somebody will read; the others stay stale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// All.
    All,
    /// Those that light reads: all but `height` and `info` under [`Shading::MetalRough`]; without light `color` and
    /// `alpha`, and otherwise `normal`, `occlusion` and `emission` too.
    Light(Shading),
    /// Only `alpha`.
    Alpha,
}

impl Wanted {
    /// Whether what a layer changes is read.
    fn reads(self, target: Target) -> bool {
        let is_lit = !matches!(self, Self::Light(Shading::Unlit) | Self::Alpha);
        let is_glossy = matches!(self, Self::All | Self::Light(Shading::MetalRough));
        match target {
            Target::Color => self != Self::Alpha,
            Target::Alpha => true,
            Target::Normal { .. } | Target::Bump { .. } | Target::Occlusion | Target::Emission => is_lit,
            Target::Roughness
            | Target::Metalness
            | Target::Coat
            | Target::CoatRoughness
            | Target::CoatNormal { .. } => is_glossy,
            Target::Height { .. } | Target::Info => self == Self::All,
        }
    }
}

/// Room for what passes hand to each other; one a thread.
pub struct Scratch {
    coords: TexCoords,
    read: ReadScratch,
    reading: Reading,
    /// The reading with its channels rearranged.
    rearranged: Reading,
    bumps: Bumps,
    /// What layers have measured at the batch's points.
    pub measures: Measures,
    /// 0 where an alpha test failed.
    kept: Lane,
    /// Answers of [`alpha_of`].
    surfaces: Option<Box<Surfaces>>,
}

impl Scratch {
    /// Empty room.
    pub fn new() -> Box<Self> {
        Box::new(Self {
            coords: TexCoords::ZERO,
            read: ReadScratch::ZERO,
            reading: Reading::ZERO,
            rearranged: Reading::ZERO,
            bumps: Bumps::ZERO,
            measures: Measures::default(),
            kept: [1.0; BATCH],
            surfaces: None,
        })
    }
}

/// What the surface is like at each point under `looks.looks[look]`.
#[inline(always)]
pub fn evaluate<S: Simd>(
    simd: S,
    (looks, look): (&Looks, usize),
    points: Points,
    scratch: &mut Scratch,
    out: &mut Surfaces,
) {
    scratch.measures.clear();
    evaluate_measured(simd, (looks, look), points, scratch, out);
}

/// The same when all that `scratch.measures` holds was measured at these very points: it is not measured again.
#[inline(always)]
pub fn evaluate_measured<S: Simd>(
    simd: S,
    (looks, look): (&Looks, usize),
    points: Points,
    scratch: &mut Scratch,
    out: &mut Surfaces,
) {
    let look = &looks.looks[look];
    start(simd, look, points, out);
    stack(simd, looks, look, points, scratch, out);
    let n = points.surfels.n;
    finish_alpha(look, n, &scratch.kept, &mut out.alpha);
    simd.vectorize(
        #[inline(always)]
        || normal::finish(look, points, &scratch.bumps, out),
    );
}

/// Only how opaque the surface is at each point: the same bits as [`evaluate`]'s `alpha`, for less work.
#[inline(always)]
pub fn alpha_of<S: Simd>(
    simd: S,
    (looks, look): (&Looks, usize),
    points: Points,
    scratch: &mut Scratch,
    out: &mut Lane,
) {
    let look = &looks.looks[look];
    let n = points.surfels.n;
    scratch.measures.clear();
    let mut surfaces = scratch.surfaces.take().unwrap_or_else(Surfaces::new);
    start_alpha(look, points, &mut surfaces.alpha);
    stack(simd, looks, look, Points { wanted: Wanted::Alpha, ..points }, scratch, &mut surfaces);
    finish_alpha(look, n, &scratch.kept, &mut surfaces.alpha);
    out[..n].copy_from_slice(&surfaces.alpha[..n]);
    scratch.surfaces = Some(surfaces);
}

/// The constants, and the mesh's own colours and normals: all of the lanes, so that the loops are of whole vectors.
#[inline(always)]
fn start<S: Simd>(simd: S, look: &Look, points: Points, out: &mut Surfaces) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (constants, wanted) = (&look.constants, points.wanted);
            out.n = points.surfels.n;
            for (c, lane) in out.color.iter_mut().enumerate() {
                *lane = [constants.color[c]; BATCH];
                if has_colors(look, points) {
                    (0..BATCH).for_each(|i| lane[i] *= points.surfels.color[c][i]);
                }
            }
            if wanted.reads(Target::Emission) {
                out.occlusion = [1.0; BATCH];
                out.emission.iter_mut().zip(constants.emission).for_each(|(lane, x)| *lane = [x; BATCH]);
                out.normal = points.surfels.normal;
            }
            if wanted.reads(Target::Roughness) {
                out.roughness = [constants.roughness; BATCH];
                out.metalness = [constants.metalness; BATCH];
                out.coat = [constants.coat; BATCH];
                out.coat_roughness = [constants.coat_roughness; BATCH];
                out.coat_normal = points.surfels.normal;
            }
            if wanted.reads(Target::Info) {
                out.height = [0.0; BATCH];
                out.info = [[0.0; BATCH]; 4];
            }
            start_alpha(look, points, &mut out.alpha);
        },
    );
}

fn has_colors(look: &Look, points: Points) -> bool {
    look.uses_vertex_colors && !points.mesh.colors().is_empty()
}

#[inline(always)]
fn start_alpha(look: &Look, points: Points, alpha: &mut Lane) {
    let n = points.surfels.n;
    fill(alpha, n, look.constants.color[3]);
    if has_colors(look, points) {
        (0..n).for_each(|i| alpha[i] *= points.surfels.color[3][i]);
    }
}

#[inline(always)]
fn fill(lane: &mut Lane, n: usize, x: f32) {
    lane[..n].fill(x);
}

/// What alpha means, decided last.
fn finish_alpha(look: &Look, n: usize, kept: &Lane, alpha: &mut Lane) {
    match look.alpha_mode {
        AlphaMode::Opaque => fill(alpha, n, 1.0),
        AlphaMode::Mask(cutoff) => (0..n).for_each(|i| alpha[i] = if alpha[i] >= cutoff { 1.0 } else { 0.0 }),
        AlphaMode::Blend => (0..n).for_each(|i| {
            let x = if alpha[i] > 0.0 { alpha[i] } else { 0.0 };
            alpha[i] = if x < 1.0 { x } else { 1.0 };
        }),
    }
    if look.has_alpha_test() {
        (0..n).for_each(|i| alpha[i] *= kept[i]);
    }
}

/// Layer after layer. Layers that stand together and read the same place of the same texture share one reading.
#[inline(always)]
fn stack<S: Simd>(simd: S, looks: &Looks, look: &Look, points: Points, scratch: &mut Scratch, out: &mut Surfaces) {
    let (n, wanted) = (points.surfels.n, points.wanted);
    if look.has_alpha_test() {
        fill(&mut scratch.kept, n, 1.0);
    }
    scratch.bumps.clear();
    let (mut placed, mut read): (Option<&Layer>, Option<&Layer>) = (None, None);
    for layer in &look.layers {
        let Some(texture) = looks.textures.get(layer.texture.0 as usize) else { continue };
        if !wanted.reads(layer.target) && !layer.touches_alpha(texture.format()) {
            continue;
        }
        let is_placed = placed.is_some_and(|p| p.placement == layer.placement && p.matrix == layer.matrix);
        if !is_placed && !place(layer, points, &mut scratch.measures, &mut scratch.coords) {
            continue;
        }
        placed = Some(layer);
        let coords = coords(layer, points, &scratch.coords);
        let is_read = is_placed && read.is_some_and(|r| r.texture == layer.texture);
        if !is_read {
            texture.read(simd, coords, (&points.surfels.cell, n), &mut scratch.read, &mut scratch.reading);
        }
        read = Some(layer);
        if let Target::Normal { .. } | Target::Bump { .. } | Target::CoatNormal { .. } = layer.target {
            let read_texture = &mut scratch.read;
            let slopes = &mut scratch.rearranged;
            let reading = &scratch.reading;
            if matches!(layer.target, Target::Bump { .. }) && !texture.holds_slopes() {
                let mut differences =
                    Differences { texture, read: read_texture, shifted: &mut TexCoords::ZERO.clone() };
                differences.slopes(simd, (coords, layer.channels[0]), (&points.surfels.cell, n), reading, slopes);
                normal::bump(simd, layer, (points, coords), slopes, &mut scratch.bumps, out);
            } else {
                normal::bump(simd, layer, (points, coords), reading, &mut scratch.bumps, out);
            }
            continue;
        }
        let reading = match layer.channels == Channel::RGBA {
            true => &scratch.reading,
            false => {
                rearrange(layer.channels, &scratch.reading, n, &mut scratch.rearranged);
                &scratch.rearranged
            }
        };
        simd.vectorize(
            #[inline(always)]
            || combine(layer, texture.format(), reading, wanted, n, &mut scratch.kept, out),
        );
    }
}

/// Fills coordinates unless the surfels hold them; false when the mesh lacks what they come from.
fn place(layer: &Layer, points: Points, measures: &mut Measures, coords: &mut TexCoords) -> bool {
    let n_sets = points.surfels.uv.len();
    if !layer.placement.fits(points.mesh) || matches!(layer.placement, Placement::Uv(set) if set >= n_sets) {
        return false;
    }
    if layer.placement.as_uv(&layer.matrix).is_none() {
        let Points { mesh, view, surfels, .. } = points;
        placement::place(&layer.placement, &layer.matrix, view, mesh, surfels, measures, coords);
    }
    true
}

fn coords<'a>(layer: &Layer, points: Points<'a>, placed: &'a TexCoords) -> &'a TexCoords {
    match layer.placement.as_uv(&layer.matrix) {
        Some(set) => &points.surfels.uv[set],
        None => placed,
    }
}

impl Texture {
    #[inline(always)]
    fn read<S: Simd>(
        &self,
        simd: S,
        at: &TexCoords,
        (cell, n): (&[[u32; BATCH]; 2], usize),
        scratch: &mut ReadScratch,
        out: &mut Reading,
    ) {
        match self {
            Self::Image(image) => image.read(simd, at, n, scratch, out),
            Self::Table(table) => simd.vectorize(
                #[inline(always)]
                || table.read(at, cell, n, out),
            ),
            Self::Isolines(isolines) => simd.vectorize(
                #[inline(always)]
                || isolines.read(at, n, out),
            ),
            Self::Filter(filter) => filter.read(at, n, out),
            Self::Procedural(procedural) => procedural.read(at, n, out),
            Self::Carried(encoding) => read_carried(*encoding, at, n, out),
        }
    }
}

/// The coordinates as colours; missing ones are black.
fn read_carried(encoding: Encoding, at: &TexCoords, n: usize, out: &mut Reading) {
    out.is_whole = true;
    let [r, ..] = &at.r;
    for (lane, coordinate) in out.rgba.iter_mut().zip([&at.st[0], &at.st[1], r]) {
        for i in 0..n {
            let x = if coordinate[i] > 0.0 { coordinate[i] } else { 0.0 };
            lane[i] = x;
        }
        if encoding == Encoding::Srgb {
            lane[..n].iter_mut().for_each(|x| [*x, ..] = linear_from_bytes([(*x * 255.0 + 0.5) as u8, 0, 0]));
        }
    }
    out.rgba[3][..n].fill(1.0);
}

/// Numbers of a texture that stand for heights, read three times to find their slopes.
struct Differences<'a> {
    texture: &'a Texture,
    read: &'a mut ReadScratch,
    shifted: &'a mut TexCoords,
}

impl Differences<'_> {
    #[inline(always)]
    fn slopes<S: Simd>(
        &mut self,
        simd: S,
        (at, channel): (&TexCoords, Channel),
        (cell, n): (&[[u32; BATCH]; 2], usize),
        here: &Reading,
        out: &mut Reading,
    ) {
        let mut there = Reading::ZERO;
        out.is_whole = here.is_whole;
        out.applied[..n].copy_from_slice(&here.applied[..n]);
        for axis in 0..2 {
            self.shifted.clone_from(at);
            let mut steps = [0.0; BATCH];
            for i in 0..n {
                // Half of what the cell covers, at least 1/1024: a smaller step would lose the difference's digits.
                let (x, y) = (at.d_dx[axis][i].abs(), at.d_dy[axis][i].abs());
                let step = 0.5 * if x > y { x } else { y };
                steps[i] = if step > 1.0 / 1024.0 && step < 1e6 { step } else { 1.0 / 1024.0 };
                self.shifted.st[axis][i] += steps[i];
            }
            self.texture.read(simd, self.shifted, (cell, n), self.read, &mut there);
            for i in 0..n {
                out.rgba[axis][i] = (chosen(channel, &there, i) - chosen(channel, here, i)) / steps[i];
            }
        }
        for i in 0..n {
            // No level hides a part of these slopes: the mean of the squares is the square of the mean.
            let [x, y] = [out.rgba[0][i], out.rgba[1][i]];
            out.rgba[2][i] = x * x + y * y;
        }
    }
}

#[inline(always)]
fn chosen(channel: Channel, reading: &Reading, i: usize) -> f32 {
    match channel {
        Channel::Red => reading.rgba[0][i],
        Channel::Green => reading.rgba[1][i],
        Channel::Blue => reading.rgba[2][i],
        Channel::Alpha => reading.rgba[3][i],
        Channel::Zero => 0.0,
        Channel::One => 1.0,
    }
}

fn rearrange(channels: [Channel; 4], reading: &Reading, n: usize, out: &mut Reading) {
    out.is_whole = reading.is_whole;
    out.applied[..n].copy_from_slice(&reading.applied[..n]);
    for (channel, lane) in channels.into_iter().zip(&mut out.rgba) {
        match channel {
            Channel::Red => lane[..n].copy_from_slice(&reading.rgba[0][..n]),
            Channel::Green => lane[..n].copy_from_slice(&reading.rgba[1][..n]),
            Channel::Blue => lane[..n].copy_from_slice(&reading.rgba[2][..n]),
            Channel::Alpha => lane[..n].copy_from_slice(&reading.rgba[3][..n]),
            Channel::Zero => fill(lane, n, 0.0),
            Channel::One => fill(lane, n, 1.0),
        }
    }
}

#[inline(always)]
fn combine(
    layer: &Layer,
    format: BaseFormat,
    reading: &Reading,
    wanted: Wanted,
    n: usize,
    kept: &mut Lane,
    out: &mut Surfaces,
) {
    let gate = Gate::new(layer.strength, reading);
    let operator = layer.operator;
    if let Operator::AlphaTest(compare, reference) = operator {
        for i in 0..n {
            let is_applied = reading.is_whole || reading.applied[i] != 0.0;
            if is_applied && !compare.passes(reading.rgba[3][i], reference) {
                kept[i] = 0.0;
            }
        }
        return;
    }
    let (color_rule, alpha_rule) = rules(operator, format);
    let rgba = &reading.rgba;
    let source = (&rgba[0], &rgba[3]);
    let number = |lane: &mut Lane| combine_number(operator, gate, n, source, lane);
    match layer.target {
        Target::Color => {
            if wanted != Wanted::Alpha {
                combine_color((color_rule, operator, 1.0), gate, n, rgba, &mut out.color);
            }
            combine_alpha((alpha_rule, operator), gate, n, &rgba[3], &mut out.alpha);
        }
        Target::Emission => {
            combine_color((color_rule, operator, f32::INFINITY), gate, n, rgba, &mut out.emission);
        }
        Target::Alpha => number(&mut out.alpha),
        Target::Roughness => number(&mut out.roughness),
        Target::Metalness => number(&mut out.metalness),
        Target::Occlusion => number(&mut out.occlusion),
        Target::Coat => number(&mut out.coat),
        Target::CoatRoughness => number(&mut out.coat_roughness),
        Target::Height { scale } => {
            let Surfaces { height, .. } = out;
            // The operator works on heights in model units.
            let mut scaled = [0.0; BATCH];
            (0..n).for_each(|i| scaled[i] = rgba[0][i] * scale);
            combine_number(operator, gate, n, (&scaled, &rgba[3]), height);
        }
        Target::Info => {
            for (c, lane) in out.info.iter_mut().enumerate() {
                combine_number(operator, gate, n, (&rgba[c], &rgba[3]), lane);
            }
        }
        Target::Normal { .. } | Target::Bump { .. } | Target::CoatNormal { .. } => {}
    }
}
