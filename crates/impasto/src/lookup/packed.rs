//! The fast way through an 8-bit linear plane: bilinear and trilinear in packed integers, eight points at a time.
//!
//! Two passes. *Address*: footprint, level, place and 8-bit weights, as vectors. *Filter*: for each point two 8-byte loads
//! a level, a texel and its right neighbour - plain loads beat hardware gathers on every processor tried - and then two
//! channels in one 32-bit lane, `(a * (256 - w) + b * w + 128) >> 8`; across, down, then between levels, as software
//! OpenGL does.

use crate::assets::{Filter, MinFilter, Wrap};
use crate::lookup::footprint::{flat_level, squared_size};
use crate::lookup::read::fold_vector;
use crate::lookup::texture::{ImageTexture, Level, Shape, Store};
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
        for i in (0..n.min(BATCH)).step_by(N) {
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
    let size2 = squared_size(simd, texture);
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
            let grid = Grid::of(simd, &texture.levels, level);
            let mut places = [level; 2];
            for axis in 0..2 {
                let fixed: i32x8<S> = (st[axis] * grid.size[axis].to_float::<f32x8<S>>() * 256.0).to_int();
                let fixed = fixed - 128;
                let fixed = match wrap[axis] {
                    Wrap::Repeat => fixed.simd_lt(0).select(fixed + (grid.size[axis] << 8), fixed),
                    _ => {
                        let end = (grid.size[axis] - 1) << 8;
                        let fixed = fixed.simd_gt(0).select(fixed, i32x8::splat(simd, 0));
                        fixed.simd_lt(end).select(fixed, end)
                    }
                };
                places[axis] = fixed >> 8;
                store(twice(fixed & 255), &mut out.weight[l][axis], i);
            }
            let at = grid.offset + places[1] * grid.row + places[0];
            store(at.bitcast(), &mut out.at[l], i);
            store(grid.row.bitcast(), &mut out.row[l], i);
        }
    }
    any.simd_gt(0).any_true()
}

/// The levels of eight points.
struct Grid<S: Simd> {
    /// Index of the first texel.
    offset: i32x8<S>,
    /// From a texel to the one below.
    row: i32x8<S>,
    /// Texels across and down.
    size: [i32x8<S>; 2],
}

impl<S: Simd> Grid<S> {
    /// Neighbours mostly share a level: it is then looked at once.
    #[inline(always)]
    fn of(simd: S, levels: &[Level], level: i32x8<S>) -> Self {
        let numbers = kernel(
            #[inline(always)]
            |level: i32| {
                let Level { offset, row, size, .. } = levels[level as usize];
                [offset as i32, row as i32, size[0] as i32, size[1] as i32]
            },
        );
        let first = level[0];
        if level.simd_eq(i32x8::splat(simd, first)).all_true() {
            let [offset, row, width, height] = numbers(first).each(
                #[inline(always)]
                |n| i32x8::splat(simd, n),
            );
            return Self { offset, row, size: [width, height] };
        }
        let mut of = [[0; N]; 4];
        for lane in 0..N {
            let numbers = numbers(level.as_slice()[lane]);
            (0..4).for_each(|k| of[k][lane] = numbers[k]);
        }
        let [offset, row, width, height] = of.each(
            #[inline(always)]
            |lanes| i32x8::load_array(simd, lanes),
        );
        Self { offset, row, size: [width, height] }
    }
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
    let across = weights(simd, &scratch.weight[l][0], i);
    let down = weights(simd, &scratch.weight[l][1], i);
    let rows = squares(simd, texels, &scratch.at[l][i..i + N], &scratch.row[l][i..i + N]);
    let [upper, lower] = rows.each(
        #[inline(always)]
        |[first, second]| {
            let (left, right) = (first.unzip_low(second), first.unzip_high(second));
            lerp(halves(left), halves(right), across)
        },
    );
    lerp(upper, lower, down)
}

/// Of eight points the texels with their right neighbours, and those below: four points in each vector.
#[inline(always)]
fn squares<S: Simd>(simd: S, texels: &[[u8; 4]], at: &[u32], rows: &[u32]) -> [[u32x8<S>; 2]; 2] {
    let row = rows[0];
    if !u32x8::from_slice(simd, rows).simd_eq(row).all_true() {
        return scattered(texels, at, rows).each(
            #[inline(always)]
            |row| {
                row.each(
                    #[inline(always)]
                    |four| u64x4::load_array(simd, four).bitcast(),
                )
            },
        );
    }
    // In one level: what is below stands as far on for all. So one check of bounds serves both rows.
    let lower = &texels[row as usize..];
    [&texels[..lower.len()], lower].each(
        #[inline(always)]
        |texels| {
            [0, 4].each(
                #[inline(always)]
                |k: usize| {
                    let four = [at[k], at[k + 1], at[k + 2], at[k + 3]].each(
                        #[inline(always)]
                        |at| pair(texels, at as usize),
                    );
                    u64x4::load_array(simd, four).bitcast()
                },
            )
        },
    )
}

/// The same across levels. A call on purpose: what is rare shall not take registers from what is not.
#[inline(never)]
fn scattered(texels: &[[u8; 4]], at: &[u32], rows: &[u32]) -> [[[u64; 4]; 2]; 2] {
    let mut out = [[[0; 4]; 2]; 2];
    for k in 0..N {
        let at = at[k] as usize;
        out[0][k / 4][k % 4] = pair(texels, at);
        out[1][k / 4][k % 4] = pair(texels, at + rows[k] as usize);
    }
    out
}

/// A texel and its right neighbour.
#[inline(always)]
fn pair(texels: &[[u8; 4]], at: usize) -> u64 {
    let [[a, b, c, d], [e, f, g, h]]: [[u8; 4]; 2] = *texels[at..at + 2].as_array().expect("two texels");
    u64::from_le_bytes([a, b, c, d, e, f, g, h])
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
