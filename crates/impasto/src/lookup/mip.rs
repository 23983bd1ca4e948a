//! Mip levels (Williams, "Pyramidal parametrics", 1983): each texel of a level is the mean of what it covers in the level below.
//!
//! Levels have floor(n / 2) texels, as in OpenGL. Along an odd axis a texel covers two texels and a part of a third, and
//! every texel below counts for the same share in all (Guthe, Heckbert, "Non-power-of-two mipmap creation", 2005).
//! What a mean is depends on what the numbers mean; see `Usage`.

use crate::color::{LINEAR_FROM_SRGB8, Srgb8Encoder};
use crate::lookup::texture::{float_from_half, half_from_float};
use crate::math::{Vec3, vec3};

/// Texels without padding: rows from the top, slices from the front.
#[derive(Clone, Debug)]
pub(super) struct Grid<T> {
    pub(super) size: [usize; 3],
    pub(super) texels: Vec<T>,
}

impl<T: Copy> Grid<T> {
    pub(super) fn map<U>(self, f: impl FnMut(T) -> U) -> Grid<U> {
        Grid { size: self.size, texels: self.texels.into_iter().map(f).collect() }
    }
}

/// How texels are averaged: four of equal weight, and any number with weights that add up to 1.
pub(super) struct Means<T> {
    pub(super) of_four: fn([T; 4]) -> T,
    pub(super) weighted: fn(&[T], &[f32]) -> T,
}

impl<T> Clone for Means<T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Means<T> {}

/// The next level. Depth is halved as well if `halves_depth`.
pub(super) fn halved<T: Copy>(grid: &Grid<T>, halves_depth: bool, means: Means<T>) -> Grid<T> {
    let [w, h, d] = grid.size;
    let half = |n: usize| (n / 2).max(1);
    let size = [half(w), half(h), if halves_depth { half(d) } else { d }];
    let mut texels = Vec::with_capacity(size[0] * size[1] * size[2]);
    let is_plain = w % 2 == 0 && h % 2 == 0 && (!halves_depth || d == 1);
    for z in 0..size[2] {
        for y in 0..size[1] {
            if is_plain {
                let rows = [2 * y, 2 * y + 1].map(|y| &grid.texels[(z * h + y) * w..][..w]);
                let pairs = rows[0].chunks_exact(2).zip(rows[1].chunks_exact(2));
                texels.extend(pairs.map(|(a, b)| (means.of_four)([a[0], a[1], b[0], b[1]])));
            } else {
                texels.extend((0..size[0]).map(|x| covered_mean(grid, [x, y, z], halves_depth, means)));
            }
        }
    }
    Grid { size, texels }
}

fn covered_mean<T: Copy>(grid: &Grid<T>, at: [usize; 3], halves_depth: bool, means: Means<T>) -> T {
    let [w, h, d] = grid.size;
    let along =
        [covered(at[0], w), covered(at[1], h), if halves_depth { covered(at[2], d) } else { (at[2], vec![1.0]) }];
    let (mut taps, mut weights) = (Vec::with_capacity(27), Vec::with_capacity(27));
    for (k, wz) in along[2].1.iter().enumerate() {
        for (j, wy) in along[1].1.iter().enumerate() {
            for (i, wx) in along[0].1.iter().enumerate() {
                taps.push(grid.texels[((along[2].0 + k) * h + along[1].0 + j) * w + along[0].0 + i]);
                weights.push(wx * wy * wz);
            }
        }
    }
    (means.weighted)(&taps, &weights)
}

/// The first texel below texel `i`, and the shares of it and the next ones.
fn covered(i: usize, n: usize) -> (usize, Vec<f32>) {
    match n {
        1 => (0, vec![1.0]),
        n if n % 2 == 0 => (2 * i, vec![0.5; 2]),
        n => {
            let m = n / 2;
            (2 * i, [m - i, m, i + 1].iter().map(|&share| share as f32 / n as f32).collect())
        }
    }
}

pub(super) const UNORM8: Means<[u8; 4]> = Means {
    of_four: |t| {
        std::array::from_fn(|c| ((t[0][c] as u32 + t[1][c] as u32 + t[2][c] as u32 + t[3][c] as u32 + 2) >> 2) as u8)
    },
    weighted: |t, w| weighted_floats(t, w, |x| x.map(f32::from)).map(|x| (x + 0.5) as u8),
};

pub(super) const UNORM16: Means<[u16; 4]> = Means {
    of_four: |t| {
        std::array::from_fn(|c| ((t[0][c] as u32 + t[1][c] as u32 + t[2][c] as u32 + t[3][c] as u32 + 2) >> 2) as u16)
    },
    weighted: |t, w| weighted_floats(t, w, |x| x.map(f32::from)).map(|x| (x + 0.5) as u16),
};

pub(super) const FLOAT: Means<[f32; 4]> =
    Means { of_four: |t| weighted_floats(&t, &[0.25; 4], |x| x), weighted: |t, w| weighted_floats(t, w, |x| x) };

pub(super) const HALF: Means<[u16; 4]> = Means {
    of_four: |t| weighted_floats(&t, &[0.25; 4], |x| x.map(float_from_half)).map(half_from_float),
    weighted: |t, w| weighted_floats(t, w, |x| x.map(float_from_half)).map(half_from_float),
};

pub(super) const SRGB8: Means<[u8; 4]> =
    Means { of_four: |t| srgb8_mean(&t, &[0.25; 4], false), weighted: |t, w| srgb8_mean(t, w, false) };

pub(super) const SRGB8_ALPHA: Means<[u8; 4]> =
    Means { of_four: |t| srgb8_mean(&t, &[0.25; 4], true), weighted: |t, w| srgb8_mean(t, w, true) };

pub(super) const NORMAL: Means<[u16; 4]> = Means { of_four: |t| normal_mean(&t, &[0.25; 4]), weighted: normal_mean };

pub(super) const LABEL8: Means<[u8; 4]> =
    Means { of_four: |t| mode(&t, &[0.25; 4], |a, b| a == b), weighted: |t, w| mode(t, w, |a, b| a == b) };

pub(super) const LABEL16: Means<[u16; 4]> =
    Means { of_four: |t| mode(&t, &[0.25; 4], |a, b| a == b), weighted: |t, w| mode(t, w, |a, b| a == b) };

/// Floats by their bits, so that a missing value (NaN) is a label as well.
pub(super) const LABEL32: Means<[f32; 4]> = Means {
    of_four: |t| mode(&t, &[0.25; 4], |a, b| a.map(f32::to_bits) == b.map(f32::to_bits)),
    weighted: |t, w| mode(t, w, |a, b| a.map(f32::to_bits) == b.map(f32::to_bits)),
};

/// A normal of any length as 16-bit texel, its length as alpha.
pub(super) fn normal_texel(n: Vec3, length: f32) -> [u16; 4] {
    let unorm = |x: f32| (x.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16;
    [unorm(n.x * 0.5 + 0.5), unorm(n.y * 0.5 + 0.5), unorm(n.z * 0.5 + 0.5), unorm(length)]
}

fn normal_mean(texels: &[[u16; 4]], weights: &[f32]) -> [u16; 4] {
    let mean = weighted_floats(texels, weights, |t| t.map(|x| x as f32 / 65535.0));
    let n = vec3(mean[0], mean[1], mean[2]) * 2.0 - 1.0;
    normal_texel(n, n.length())
}

#[inline]
fn weighted_floats<T: Copy>(texels: &[T], weights: &[f32], value: impl Fn(T) -> [f32; 4]) -> [f32; 4] {
    let mut sum = [0.0; 4];
    for (texel, weight) in texels.iter().zip(weights) {
        let v = value(*texel);
        (0..4).for_each(|c| sum[c] += v[c] * weight);
    }
    sum
}

/// The mean in linear light; by alpha as well if asked for, unless nothing is opaque at all.
fn srgb8_mean(texels: &[[u8; 4]], weights: &[f32], by_alpha: bool) -> [u8; 4] {
    let table = &*LINEAR_FROM_SRGB8;
    let total_alpha: f32 = texels.iter().zip(weights).map(|(t, w)| t[3] as f32 * w).sum();
    let by_alpha = by_alpha && total_alpha > 0.0;
    let mut sum = [0.0; 3];
    for (t, w) in texels.iter().zip(weights) {
        let share = if by_alpha { w * t[3] as f32 } else { *w };
        (0..3).for_each(|c| sum[c] += table[t[c] as usize] * share);
    }
    let total = if by_alpha { total_alpha } else { 1.0 };
    let encoder = Srgb8Encoder::new();
    let [r, g, b] = sum.map(|x| encoder.encode(x / total));
    [r, g, b, (total_alpha + 0.5) as u8]
}

/// The texel with the greatest share, the first among equals.
fn mode<T: Copy>(texels: &[T], weights: &[f32], equal: impl Fn(&T, &T) -> bool) -> T {
    let mut best = (texels[0], 0.0);
    for t in texels {
        let share: f32 = texels.iter().zip(weights).filter(|(u, _)| equal(u, t)).map(|(_, w)| w).sum();
        // Sums of the same shares in another order may differ in the last bit; a tie is a tie.
        if share > best.1 + 1e-6 {
            best = (*t, share);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{hash_cell, unit_float};

    fn noise(size: [usize; 3], seed: u32) -> Grid<[f32; 4]> {
        let texel = |i: usize| std::array::from_fn(|c| unit_float(hash_cell(i as i32, c as i32, 0, seed)));
        Grid { size, texels: (0..size.iter().product()).map(texel).collect() }
    }

    fn mean(grid: &Grid<[f32; 4]>) -> [f64; 4] {
        let n = grid.texels.len() as f64;
        std::array::from_fn(|c| grid.texels.iter().map(|t| t[c] as f64).sum::<f64>() / n)
    }

    #[test]
    fn levels_keep_the_mean_at_every_size() {
        for size in [[8, 8, 1], [7, 5, 1], [1, 9, 1], [13, 4, 3], [6, 1, 1], [3, 3, 3], [1023, 2, 1]] {
            let mut grid = noise(size, 5);
            let truth = mean(&grid);
            while grid.size != [1, 1, 1] {
                grid = halved(&grid, true, FLOAT);
                let got = mean(&grid);
                assert!((0..4).all(|c| (got[c] - truth[c]).abs() < 1e-5), "{size:?} at {:?}", grid.size);
            }
        }
    }

    #[test]
    fn linear_bytes_round_half_up_and_srgb_averages_light() {
        let four = [[0, 1, 2, 255], [1, 1, 255, 255], [0, 0, 3, 255], [1, 0, 255, 254]];
        assert_eq!((UNORM8.of_four)(four), [1, 1, 129, 255]);
        // Half black, half white is half the light: sRGB 188, not 128.
        let (black, white) = ([0, 0, 0, 255], [255, 255, 255, 255]);
        assert_eq!((SRGB8.of_four)([black, white, white, black]), [188, 188, 188, 255]);
    }

    #[test]
    fn hidden_colour_of_transparent_texels_does_not_bleed() {
        let (leaf, hole) = ([40, 200, 30, 255], [255, 0, 255, 0]);
        assert_eq!((SRGB8_ALPHA.of_four)([leaf, hole, hole, leaf]), [40, 200, 30, 128]);
        assert_eq!((SRGB8_ALPHA.of_four)([hole; 4]), hole);
    }

    #[test]
    fn normals_lose_length_and_labels_elect() {
        let tilt = |x: f32| normal_texel(vec3(x, 0.0, (1.0 - x * x).sqrt()), 1.0);
        let flat = (NORMAL.of_four)([tilt(0.0); 4]);
        assert_eq!(flat[3], 65535);
        let ridge = (NORMAL.of_four)([tilt(0.6), tilt(-0.6), tilt(0.6), tilt(-0.6)]);
        assert!((ridge[3] as f32 / 65535.0 - 0.8).abs() < 1e-4);
        let label = |i: u8| [i, 0, 0, 255];
        assert_eq!((LABEL8.of_four)([label(1), label(2), label(2), label(3)]), label(2));
        assert_eq!((LABEL8.of_four)([label(3), label(1), label(1), label(3)]), label(3));
    }
}
