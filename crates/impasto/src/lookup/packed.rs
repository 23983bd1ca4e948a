//! The fast way through an 8-bit linear plane: bilinear and trilinear in packed integers, eight points at a time.
//!
//! Two passes. *Address*: footprint, level, place and 8-bit weights, as vectors. *Filter*: for each point two 8-byte loads
//! a level, a texel and its right neighbour - plain loads beat hardware gathers on every processor tried - and then two
//! channels in one 32-bit lane, `(a * (256 - w) + b * w + 128) >> 8`; across, down, then between levels, as software
//! OpenGL does.

use crate::assets::{Filter, MinFilter, Wrap};
use crate::lookup::footprint::{flat_level, squared_size};
use crate::lookup::read::fold_vector;
use crate::lookup::texture::{ImageTexture, Shape, Store};
use crate::math::{BATCH, Each, Lane, kernel};
use crate::placement::TexCoords;
use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdInt, SimdMask, f32x8, i32x8, u16x16, u32x8, u64x4};

/// Points that are read together.
const N: usize = 8;

/// What the passes hand to each other: for each of two levels, for each point.
pub(super) struct Packed {
    /// Index of the upper left texel.
    at: [[u32; BATCH]; 2],
    /// From a texel to the one below.
    row: [[u32; BATCH]; 2],
    /// Across and down, 0 to 255 of 256, twice in each number.
    weight: [[[u32; BATCH]; 2]; 2],
    /// Share of the second level, likewise.
    mix: [u32; BATCH],
}

impl Packed {
    pub(super) const ZERO: Self =
        Self { at: [[0; BATCH]; 2], row: [[0; BATCH]; 2], weight: [[[0; BATCH]; 2]; 2], mix: [0; BATCH] };
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

/// Reads `n` points.
#[inline(always)]
pub(super) fn read<S: Simd>(
    simd: S,
    (texture, texels): (&ImageTexture, &[[u8; 4]]),
    at: &TexCoords,
    n: usize,
    (scratch, out): (&mut Packed, &mut [Lane; 4]),
) {
    let blends = address(simd, texture, at, n, scratch);
    touch(texels, n, &scratch.at[..1 + blends as usize]);
    match blends {
        true => filter::<S, true>(simd, texels, n, scratch, out),
        false => filter::<S, false>(simd, texels, n, scratch, out),
    }
}

/// Loads some texels for nothing: those that are not in the cache are then on their way, many at a time, before
/// [`filter`] waits for the first.
#[inline(always)]
fn touch(texels: &[[u8; 4]], n: usize, levels: &[[u32; BATCH]]) {
    let mut sum = 0;
    for at in levels {
        for i in (0..n.min(BATCH)).step_by(N / 2) {
            sum += texels[at[i] as usize][0] as u32;
        }
    }
    std::hint::black_box(sum);
}

/// Fills levels, places and weights; whether any point needs a second level.
#[inline(always)]
fn address<S: Simd>(simd: S, texture: &ImageTexture, at: &TexCoords, n: usize, out: &mut Packed) -> bool {
    let last = (texture.levels.len() - 1) as i32;
    let (zero, half, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 0.5), f32x8::splat(simd, 1.0));
    let rounds = texture.sampler.min == MinFilter::LinearMipmapNearest;
    let wrap = [texture.sampler.wrap[0], texture.sampler.wrap[1]];
    let size = [texture.levels[0].size[0], texture.levels[0].size[1]].each(
        #[inline(always)]
        |n| f32x8::splat(simd, n as f32),
    );
    let size2 = squared_size(simd, texture);
    let mut offsets = [0; MAX_LEVELS];
    for (offset, level) in offsets.iter_mut().zip(&texture.levels) {
        *offset = level.offset as i32;
    }
    let mut any = u32x8::splat(simd, 0);
    for i in (0..n).step_by(N) {
        let level = flat_level(simd, size2, at, i);
        let level = level.simd_gt(zero).select(level, zero);
        let level = level.simd_lt(last as f32).select(level, f32x8::splat(simd, last as f32));
        let mut fine: i32x8<S> = level.to_int();
        let mut mix = level - fine.to_float::<f32x8<S>>();
        if rounds {
            // Halfway the lower level wins.
            fine += mix.simd_gt(half).select(one, zero).to_int::<i32x8<S>>();
            mix = zero;
        }
        let mix: i32x8<S> = (mix * 256.0).to_int();
        any |= mix.bitcast::<u32x8<S>>();
        store(twice(mix), &mut out.mix, i);
        let coarse = (fine + 1).simd_lt(last).select(fine + 1, i32x8::splat(simd, last));
        let st = [0, 1].each(
            #[inline(always)]
            |axis| fold_vector(simd, f32x8::from_slice(simd, &at.st[axis][i..i + N]), wrap[axis]),
        );
        for (l, level) in [fine, coarse].into_iter().enumerate() {
            // 2^-level as a float's bits.
            let bits: u32x8<S> = ((i32x8::splat(simd, 127) - level) << 23).bitcast();
            let shrink = f32x8::from_bits(bits);
            let n_texels = size.each(
                #[inline(always)]
                |size| {
                    let n: i32x8<S> = (size * shrink).to_int();
                    n.simd_gt(1).select(n, i32x8::splat(simd, 1))
                },
            );
            let mut places = [level; 2];
            for axis in 0..2 {
                let fixed: i32x8<S> = (st[axis] * n_texels[axis].to_float::<f32x8<S>>() * 256.0).to_int();
                let fixed = fixed - 128;
                let fixed = match wrap[axis] {
                    Wrap::Repeat => fixed.simd_lt(0).select(fixed + (n_texels[axis] << 8), fixed),
                    _ => {
                        let end = (n_texels[axis] - 1) << 8;
                        let fixed = fixed.simd_gt(0).select(fixed, i32x8::splat(simd, 0));
                        fixed.simd_lt(end).select(fixed, end)
                    }
                };
                places[axis] = fixed >> 8;
                store(twice(fixed & 255), &mut out.weight[l][axis], i);
            }
            // Rows are padded by a texel.
            let row = n_texels[0] + 1;
            store((of_level(simd, &offsets, level) + places[1] * row + places[0]).bitcast(), &mut out.at[l], i);
            store(row.bitcast(), &mut out.row[l], i);
        }
    }
    any.simd_gt(0).any_true()
}

/// Offsets of eight points' levels; neighbours mostly share one.
#[inline(always)]
fn of_level<S: Simd>(simd: S, offsets: &[i32; MAX_LEVELS], level: i32x8<S>) -> i32x8<S> {
    let first = level[0] as usize % MAX_LEVELS;
    if level.simd_eq(i32x8::splat(simd, first as i32)).all_true() {
        return i32x8::splat(simd, offsets[first]);
    }
    let level = level.as_slice();
    let mut of = [0; N];
    (0..N).for_each(|lane| of[lane] = offsets[level[lane] as usize % MAX_LEVELS]);
    i32x8::load_array(simd, of)
}

/// A weight for each of a lane's two channels.
#[inline(always)]
fn twice<S: Simd>(weight: i32x8<S>) -> u32x8<S> {
    (weight | (weight << 16)).bitcast()
}

#[inline(always)]
fn store<S: Simd>(v: u32x8<S>, lane: &mut [u32; BATCH], i: usize) {
    v.store_slice(&mut lane[i..i + N]);
}

/// Two of four channels of eight points, 16 bits each.
#[derive(Clone, Copy)]
struct Halves<S: Simd>([u16x16<S>; 2]);

/// Fetches and mixes. The last group may hold points past the last: whatever their coordinates were, [`address`] found them
/// a texel.
#[inline(always)]
fn filter<S: Simd, const BLENDS: bool>(simd: S, texels: &[[u8; 4]], n: usize, scratch: &Packed, out: &mut [Lane; 4]) {
    for i in (0..n).step_by(N) {
        let mut texel = bilinear(simd, texels, scratch, 0, i);
        if BLENDS {
            texel = lerp(texel, bilinear(simd, texels, scratch, 1, i), weights(simd, &scratch.mix, i));
        }
        for (half, channels) in texel.0.into_iter().zip([[0, 2], [1, 3]]) {
            let bits: u32x8<S> = half.bitcast();
            for (channel, value) in channels.into_iter().zip([bits & 0xffff, bits >> 16]) {
                let value: i32x8<S> = value.bitcast();
                let value: f32x8<S> = value.to_float();
                (value * (1.0 / 255.0)).store_slice(&mut out[channel][i..i + N]);
            }
        }
    }
}

#[inline(always)]
fn bilinear<S: Simd>(simd: S, texels: &[[u8; 4]], scratch: &Packed, l: usize, i: usize) -> Halves<S> {
    let (at, rows) = (&scratch.at[l][i..i + N], &scratch.row[l][i..i + N]);
    let across = weights(simd, &scratch.weight[l][0], i);
    let down = weights(simd, &scratch.weight[l][1], i);
    let four = kernel(
        #[inline(always)]
        |k: usize| -> [u32x8<S>; 2] {
            let square = kernel(
                #[inline(always)]
                |k: usize| square(texels, at[k] as usize, rows[k] as usize),
            );
            let (a, b, c, d) = (square(k), square(k + 1), square(k + 2), square(k + 3));
            [0, 1].each(
                #[inline(always)]
                |row: usize| u64x4::load_array(simd, [a[row], b[row], c[row], d[row]]).bitcast(),
            )
        },
    );
    let (first, second) = (four(0), four(4));
    let [upper, lower] = [0, 1].each(
        #[inline(always)]
        |row: usize| {
            let (left, right) = (first[row].unzip_low(second[row]), first[row].unzip_high(second[row]));
            lerp(halves(left), halves(right), across)
        },
    );
    lerp(upper, lower, down)
}

/// A texel with its right neighbour, and the pair below.
#[inline(always)]
fn square(texels: &[[u8; 4]], at: usize, row: usize) -> [u64; 2] {
    let rows = &texels[at..at + row + 2];
    [0, row].each(
        #[inline(always)]
        |at| {
            let [[a, b, c, d], [e, f, g, h]]: [[u8; 4]; 2] = *rows[at..at + 2].as_array().expect("two texels");
            u64::from_le_bytes([a, b, c, d, e, f, g, h])
        },
    )
}

#[inline(always)]
fn halves<S: Simd>(texel: u32x8<S>) -> Halves<S> {
    Halves([(texel & 0x00ff_00ff).bitcast(), ((texel >> 8) & 0x00ff_00ff).bitcast()])
}

#[inline(always)]
fn weights<S: Simd>(simd: S, lane: &[u32; BATCH], i: usize) -> u16x16<S> {
    u32x8::from_slice(simd, &lane[i..i + N]).bitcast()
}

/// At most 255 * 256 + 128: 16 bits hold it.
#[inline(always)]
fn lerp<S: Simd>(a: Halves<S>, b: Halves<S>, weight: u16x16<S>) -> Halves<S> {
    let rest = 256 - weight;
    Halves([(a.0[0] * rest + b.0[0] * weight + 128) >> 8, (a.0[1] * rest + b.0[1] * weight + 128) >> 8])
}
