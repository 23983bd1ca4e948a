//! The fast way through an 8-bit linear plane: bilinear and trilinear in packed integers, eight points at a time.
//!
//! Three passes. *Address*: level, place and 8-bit weights, as vectors. *Fetch*: for each point two 8-byte loads a level, a
//! texel and its right neighbour; plain loads beat hardware gathers on every processor tried. *Filter*: two channels in
//! one 32-bit lane, `(a * (256 - w) + b * w + 128) >> 8`; across, down, then between levels, as software OpenGL does.

use crate::assets::{Filter, MinFilter, Wrap};
use crate::lookup::texture::{ImageTexture, Shape, Store};
use crate::math::{BATCH, Lane};
use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdInt, SimdMask, f32x8, i32x8, u16x16, u32x8, u64x4};

/// What the passes hand to each other: for each of two levels, for each point.
pub(super) struct Packed {
    level: [[i32; BATCH]; 2],
    place: [[[i32; BATCH]; 2]; 2],
    weight: [[[u32; BATCH]; 2]; 2],
    /// Share of the second level, 0 to 255 of 256.
    mix: [u32; BATCH],
    /// Texel pairs: upper and lower row.
    pairs: [[[u64; BATCH]; 2]; 2],
}

impl Packed {
    pub(super) const ZERO: Self = Self {
        level: [[0; BATCH]; 2],
        place: [[[0; BATCH]; 2]; 2],
        weight: [[[0; BATCH]; 2]; 2],
        mix: [0; BATCH],
        pairs: [[[0; BATCH]; 2]; 2],
    };
}

/// Whether a texture can be read this way: 8-bit linear, flat, all filters bilinear, one tap a level.
pub(super) fn suits(texture: &ImageTexture) -> bool {
    let sampler = &texture.sampler;
    let is_linear = sampler.mag == Filter::Linear
        && matches!(sampler.min, MinFilter::Linear | MinFilter::LinearMipmapNearest | MinFilter::LinearMipmapLinear);
    let is_flat = matches!(texture.shape, Shape::Line | Shape::Plane);
    // Places have 8 bits of fraction, and f32 holds 24 bits.
    let is_small = texture.levels[0].size.iter().all(|&n| n <= 1 << 16);
    matches!(texture.store, Store::Unorm8(_)) && is_flat && is_linear && !texture.is_anisotropic() && is_small
}

/// Reads `n` points at folded coordinates.
#[inline(always)]
pub(super) fn read<S: Simd>(
    simd: S,
    (texture, texels): (&ImageTexture, &[[u8; 4]]),
    (folded, level): (&[Lane; 3], &Lane),
    n: usize,
    (scratch, out): (&mut Packed, &mut [Lane; 4]),
) {
    let blends = address(simd, texture, (folded, level), n, scratch);
    let n_levels = if blends { 2 } else { 1 };
    for l in 0..n_levels {
        fetch(texture, texels, n, l, scratch);
    }
    match blends {
        true => filter::<S, true>(simd, n, scratch, out),
        false => filter::<S, false>(simd, n, scratch, out),
    }
}

/// Fills levels, places and weights; whether any point needs a second level.
#[inline(always)]
fn address<S: Simd>(
    simd: S,
    texture: &ImageTexture,
    (folded, level): (&[Lane; 3], &Lane),
    n: usize,
    out: &mut Packed,
) -> bool {
    let last = f32x8::splat(simd, (texture.levels.len() - 1) as f32);
    let (zero, half, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 0.5), f32x8::splat(simd, 1.0));
    let rounds = texture.sampler.min == MinFilter::LinearMipmapNearest;
    let size = [texture.levels[0].size[0] as f32, texture.levels[0].size[1] as f32];
    let repeats = [0, 1].map(|axis| texture.sampler.wrap[axis] == Wrap::Repeat);
    let mut any = u32x8::splat(simd, 0);
    for i in (0..n).step_by(8) {
        let level = f32x8::from_slice(simd, &level[i..i + 8]);
        let level = level.simd_gt(zero).select(level, zero);
        let level = level.simd_lt(last).select(level, last);
        let mut fine: i32x8<S> = level.to_int();
        let mut mix = level - fine.to_float::<f32x8<S>>();
        if rounds {
            // Halfway the lower level wins.
            fine += mix.simd_gt(half).select(one, zero).to_int::<i32x8<S>>();
            mix = zero;
        }
        let mix: i32x8<S> = (mix * 256.0).to_int();
        let mix: u32x8<S> = mix.bitcast();
        any |= mix;
        mix.store_slice(&mut out.mix[i..i + 8]);
        let last: i32x8<S> = last.to_int();
        let coarse = (fine + 1).simd_lt(last).select(fine + 1, last);
        let at = Address { simd, size, repeats, i };
        at.place(fine, folded, (&mut out.level[0], &mut out.place[0], &mut out.weight[0]));
        at.place(coarse, folded, (&mut out.level[1], &mut out.place[1], &mut out.weight[1]));
    }
    any.simd_gt(0).any_true()
}

/// Eight points' way to their texels.
#[derive(Clone, Copy)]
struct Address<S: Simd> {
    simd: S,
    /// Texels across and down of the full image.
    size: [f32; 2],
    repeats: [bool; 2],
    /// The first of the points.
    i: usize,
}

impl<S: Simd> Address<S> {
    #[inline(always)]
    fn place(
        self,
        level: i32x8<S>,
        folded: &[Lane; 3],
        (levels, places, weights): (&mut [i32; BATCH], &mut [[i32; BATCH]; 2], &mut [[u32; BATCH]; 2]),
    ) {
        level.store_slice(&mut levels[self.i..self.i + 8]);
        // 2^-level as a float's bits.
        let bits: u32x8<S> = ((i32x8::splat(self.simd, 127) - level) << 23).bitcast();
        let shrink = f32x8::from_bits(bits);
        self.along(0, shrink, &folded[0], (&mut places[0], &mut weights[0]));
        self.along(1, shrink, &folded[1], (&mut places[1], &mut weights[1]));
    }

    #[inline(always)]
    fn along(
        self,
        axis: usize,
        shrink: f32x8<S>,
        folded: &Lane,
        (places, weights): (&mut [i32; BATCH], &mut [u32; BATCH]),
    ) {
        let (simd, i) = (self.simd, self.i);
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let n_texels: i32x8<S> = (f32x8::splat(simd, self.size[axis]) * shrink).to_int();
        let n_texels = n_texels.simd_gt(1).select(n_texels, i32x8::splat(simd, 1));
        let x = f32x8::from_slice(simd, &folded[i..i + 8]);
        // Lanes past the batch's end hold anything.
        let x = x.simd_gt(zero).select(x, zero);
        let x = x.simd_lt(one).select(x, one);
        let fixed: i32x8<S> = (x * n_texels.to_float::<f32x8<S>>() * 256.0).to_int();
        let fixed = fixed - 128;
        let fixed = if self.repeats[axis] {
            fixed.simd_lt(0).select(fixed + (n_texels << 8), fixed)
        } else {
            let end = (n_texels - 1) << 8;
            let fixed = fixed.simd_gt(0).select(fixed, i32x8::splat(simd, 0));
            fixed.simd_lt(end).select(fixed, end)
        };
        (fixed >> 8).store_slice(&mut places[i..i + 8]);
        let weight: u32x8<S> = (fixed & 255).bitcast();
        weight.store_slice(&mut weights[i..i + 8]);
    }
}

#[inline(always)]
fn fetch(texture: &ImageTexture, texels: &[[u8; 4]], n: usize, l: usize, scratch: &mut Packed) {
    let (levels, [xs, ys]) = (&scratch.level[l], &scratch.place[l]);
    let [upper, lower] = &mut scratch.pairs[l];
    for i in 0..n.min(BATCH) {
        let level = &texture.levels[levels[i] as usize];
        let at = level.offset + ys[i] as usize * level.row + xs[i] as usize;
        upper[i] = pair(texels, at);
        lower[i] = pair(texels, at + level.row);
    }
}

#[inline(always)]
fn pair(texels: &[[u8; 4]], at: usize) -> u64 {
    u64::from_le_bytes(*texels[at..at + 2].as_flattened().as_array().expect("two texels of four bytes"))
}

/// Two of four channels of eight points, 16 bits each.
#[derive(Clone, Copy)]
struct Halves<S: Simd>([u16x16<S>; 2]);

#[inline(always)]
fn filter<S: Simd, const BLENDS: bool>(simd: S, n: usize, scratch: &Packed, out: &mut [Lane; 4]) {
    for i in (0..n).step_by(8) {
        let mut texel = bilinear(simd, scratch, 0, i);
        if BLENDS {
            texel = lerp(texel, bilinear(simd, scratch, 1, i), weights(simd, &scratch.mix, i));
        }
        let red_blue: u32x8<S> = texel.0[0].bitcast();
        let green_alpha: u32x8<S> = texel.0[1].bitcast();
        store(simd, red_blue & 0xffff, &mut out[0], i);
        store(simd, green_alpha & 0xffff, &mut out[1], i);
        store(simd, red_blue >> 16, &mut out[2], i);
        store(simd, green_alpha >> 16, &mut out[3], i);
    }
}

/// Eight bytes as numbers in [0, 1].
#[inline(always)]
fn store<S: Simd>(simd: S, bytes: u32x8<S>, lane: &mut Lane, i: usize) {
    let bytes: i32x8<S> = bytes.bitcast();
    let value: f32x8<S> = bytes.to_float();
    (value * f32x8::splat(simd, 1.0 / 255.0)).store_slice(&mut lane[i..i + 8]);
}

#[inline(always)]
fn bilinear<S: Simd>(simd: S, scratch: &Packed, l: usize, i: usize) -> Halves<S> {
    let across = weights(simd, &scratch.weight[l][0], i);
    let down = weights(simd, &scratch.weight[l][1], i);
    let upper = row(simd, &scratch.pairs[l][0], across, i);
    lerp(upper, row(simd, &scratch.pairs[l][1], across, i), down)
}

/// Eight texels and their right neighbours, mixed.
#[inline(always)]
fn row<S: Simd>(simd: S, pairs: &[u64; BATCH], across: u16x16<S>, i: usize) -> Halves<S> {
    let first: u32x8<S> = u64x4::from_slice(simd, &pairs[i..i + 4]).bitcast();
    let second: u32x8<S> = u64x4::from_slice(simd, &pairs[i + 4..i + 8]).bitcast();
    lerp(halves(first.unzip_low(second)), halves(first.unzip_high(second)), across)
}

#[inline(always)]
fn halves<S: Simd>(texel: u32x8<S>) -> Halves<S> {
    Halves([(texel & 0x00ff_00ff).bitcast(), ((texel >> 8) & 0x00ff_00ff).bitcast()])
}

/// Weights of eight points, each for two channels.
#[inline(always)]
fn weights<S: Simd>(simd: S, lane: &[u32; BATCH], i: usize) -> u16x16<S> {
    let w = u32x8::from_slice(simd, &lane[i..i + 8]);
    (w | (w << 16)).bitcast()
}

/// At most 255 * 256 + 128: 16 bits hold it.
#[inline(always)]
fn lerp<S: Simd>(a: Halves<S>, b: Halves<S>, weight: u16x16<S>) -> Halves<S> {
    let rest = 256 - weight;
    Halves([lerp16(a.0[0], b.0[0], rest, weight), lerp16(a.0[1], b.0[1], rest, weight)])
}

#[inline(always)]
fn lerp16<S: Simd>(a: u16x16<S>, b: u16x16<S>, rest: u16x16<S>, weight: u16x16<S>) -> u16x16<S> {
    (a * rest + b * weight + 128) >> 8
}
