//! The fast way through an 8-bit linear plane: bilinear and trilinear in packed integers, eight points at a time.
//!
//! Three passes. *Address*: level, place and 8-bit weights, as vectors. *Fetch*: for each point two 8-byte loads a level, a
//! texel and its right neighbour; plain loads beat hardware gathers on every processor tried. *Filter*: two channels in
//! one 32-bit lane, `(a * (256 - w) + b * w + 128) >> 8`; across, down, then between levels, as software OpenGL does.

use crate::assets::{Filter, MinFilter, Wrap};
use crate::lookup::texture::{ImageTexture, Shape, Store};
use crate::math::{BATCH, Each, Lane};
use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdInt, SimdMask, f32x8, i32x8, u16x16, u32x8, u64x4};

/// What the passes hand to each other: for each of two levels, for each point.
pub(super) struct Packed {
    /// Index of the upper left texel.
    at: [[u32; BATCH]; 2],
    /// From a texel to the one below.
    row: [[u32; BATCH]; 2],
    weight: [[[u32; BATCH]; 2]; 2],
    /// Share of the second level, 0 to 255 of 256.
    mix: [u32; BATCH],
    /// Texel pairs: upper and lower row.
    pairs: [[[u64; BATCH]; 2]; 2],
}

impl Packed {
    pub(super) const ZERO: Self = Self {
        at: [[0; BATCH]; 2],
        row: [[0; BATCH]; 2],
        weight: [[[0; BATCH]; 2]; 2],
        mix: [0; BATCH],
        pairs: [[[0; BATCH]; 2]; 2],
    };
}

/// Levels of the largest texture that is read this way: 2^16 texels along a side have 17; a power of two.
const MAX_LEVELS: usize = 32;

/// Whether a texture can be read this way: 8-bit linear, flat, all filters bilinear, one tap a level.
pub(super) fn suits(texture: &ImageTexture) -> bool {
    let sampler = &texture.sampler;
    let is_linear = sampler.mag == Filter::Linear
        && matches!(sampler.min, MinFilter::Linear | MinFilter::LinearMipmapNearest | MinFilter::LinearMipmapLinear);
    let is_flat = matches!(texture.shape, Shape::Line | Shape::Plane);
    // Places have 8 bits of fraction, and f32 holds 24 bits.
    let is_small = texture.levels[0].size.iter().all(|&n| n <= 1 << 16);
    // Texels are counted in 32 bits here.
    let is_countable = matches!(&texture.store, Store::Unorm8(texels) if texels.len() < 1 << 31);
    is_countable && is_flat && is_linear && !texture.is_anisotropic() && is_small
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
        fetch(texels, n, l, scratch);
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
    let size = [texture.levels[0].size[0], texture.levels[0].size[1]].each(
        #[inline(always)]
        |n| f32x8::splat(simd, n as f32),
    );
    let repeats = [0, 1].each(
        #[inline(always)]
        |axis| texture.sampler.wrap[axis] == Wrap::Repeat,
    );
    let mut levels = [[0; MAX_LEVELS]; 2];
    for (i, level) in texture.levels.iter().enumerate().take(MAX_LEVELS) {
        levels[0][i] = level.offset as i32;
        levels[1][i] = level.row as i32;
    }
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
        for (l, level) in [fine, coarse].into_iter().enumerate() {
            let [offset, row] = of_level(simd, &levels, level);
            let mut places = [level; 2];
            // 2^-level as a float's bits.
            let bits: u32x8<S> = ((i32x8::splat(simd, 127) - level) << 23).bitcast();
            let shrink = f32x8::from_bits(bits);
            for axis in 0..2 {
                let n_texels: i32x8<S> = (size[axis] * shrink).to_int();
                let n_texels = n_texels.simd_gt(1).select(n_texels, i32x8::splat(simd, 1));
                let x = f32x8::from_slice(simd, &folded[axis][i..i + 8]);
                let x = x.simd_gt(zero).select(x, zero);
                let x = x.simd_lt(one).select(x, one);
                let fixed: i32x8<S> = (x * n_texels.to_float::<f32x8<S>>() * 256.0).to_int();
                let fixed = fixed - 128;
                let (place, weight) = if repeats[axis] {
                    let place = fixed >> 8;
                    (place.simd_lt(0).select(place + n_texels, place), fixed & 255)
                } else {
                    let end = (n_texels - 1) << 8;
                    let fixed = fixed.simd_gt(0).select(fixed, i32x8::splat(simd, 0));
                    let fixed = fixed.simd_lt(end).select(fixed, end);
                    (fixed >> 8, fixed & 255)
                };
                places[axis] = place;
                let weight: u32x8<S> = weight.bitcast();
                weight.store_slice(&mut out.weight[l][axis][i..i + 8]);
            }
            let at: u32x8<S> = (offset + places[1] * row + places[0]).bitcast();
            at.store_slice(&mut out.at[l][i..i + 8]);
            let row: u32x8<S> = row.bitcast();
            row.store_slice(&mut out.row[l][i..i + 8]);
        }
    }
    any.simd_gt(0).any_true()
}

/// Offset and row of eight points' levels; neighbours mostly share one.
#[inline(always)]
fn of_level<S: Simd>(simd: S, levels: &[[i32; MAX_LEVELS]; 2], level: i32x8<S>) -> [i32x8<S>; 2] {
    let first = level[0] as usize % MAX_LEVELS;
    if level.simd_eq(i32x8::splat(simd, first as i32)).all_true() {
        return [i32x8::splat(simd, levels[0][first]), i32x8::splat(simd, levels[1][first])];
    }
    let mut of = [[0; 8]; 2];
    for lane in 0..8 {
        let level = level[lane] as usize % MAX_LEVELS;
        of[0][lane] = levels[0][level];
        of[1][lane] = levels[1][level];
    }
    [i32x8::load_array(simd, of[0]), i32x8::load_array(simd, of[1])]
}

/// Little else than loads, so that many are under way at a time.
#[inline(always)]
fn fetch(texels: &[[u8; 4]], n: usize, l: usize, scratch: &mut Packed) {
    let (at, rows) = (&scratch.at[l][..n], &scratch.row[l][..n]);
    let [upper, lower] = &mut scratch.pairs[l];
    let (upper, lower) = (&mut upper[..n], &mut lower[..n]);
    for i in 0..n {
        upper[i] = pair(texels, at[i] as usize);
        lower[i] = pair(texels, at[i] as usize + rows[i] as usize);
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
        for (half, channels) in texel.0.into_iter().zip([[0, 2], [1, 3]]) {
            let bits: u32x8<S> = half.bitcast();
            for (channel, value) in channels.into_iter().zip([bits & 0xffff, bits >> 16]) {
                let value: i32x8<S> = value.bitcast();
                let value: f32x8<S> = value.to_float();
                (value * (1.0 / 255.0)).store_slice(&mut out[channel][i..i + 8]);
            }
        }
    }
}

#[inline(always)]
fn bilinear<S: Simd>(simd: S, scratch: &Packed, l: usize, i: usize) -> Halves<S> {
    let across = weights(simd, &scratch.weight[l][0], i);
    let down = weights(simd, &scratch.weight[l][1], i);
    let upper = row(simd, &scratch.pairs[l][0], i, across);
    let lower = row(simd, &scratch.pairs[l][1], i, across);
    lerp(upper, lower, down)
}

/// Pairs of texels of eight points, mixed across.
#[inline(always)]
fn row<S: Simd>(simd: S, pairs: &[u64; BATCH], i: usize, across: u16x16<S>) -> Halves<S> {
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
    Halves([(a.0[0] * rest + b.0[0] * weight + 128) >> 8, (a.0[1] * rest + b.0[1] * weight + 128) >> 8])
}
