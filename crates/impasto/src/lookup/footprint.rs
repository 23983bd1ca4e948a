//! How much of a texture a cell covers: the level to read, and the taps along the footprint's longer axis.
//!
//! Derivatives are exact and a cell's own, so nothing depends on neighbours. Isotropic reading takes the longer of the two
//! edges of the footprint, as OpenGL does. Anisotropic reading takes the axes of the ellipse that the footprint's
//! parallelogram stands for (Heckbert, "Fundamentals of texture mapping and image warping", 1989), so that a texture
//! turned by 45 degrees is as sharp as an upright one.

use crate::lookup::texture::{ImageTexture, Shape, cube_axes};
use crate::math::{BATCH, Lane};
use crate::placement::TexCoords;
use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdInt, f32x8, i32x8, u32x8};

/// Levels and taps of a batch.
pub(super) struct Footprints {
    /// Base-2 logarithm of the footprint's width in texels of the full image; at or below 0 a texel covers the cell.
    pub(super) level: Lane,
    /// How many taps, 1 to 16.
    pub(super) n_taps: Lane,
    /// The longer axis from end to end, in texture widths and heights.
    pub(super) axis: [Lane; 2],
}

impl Footprints {
    pub(super) const ZERO: Self = Self { level: [0.0; BATCH], n_taps: [1.0; BATCH], axis: [[0.0; BATCH]; 2] };
}

/// Fills `level` alone: the longer edge of the footprint.
#[inline(always)]
pub(super) fn isotropic<S: Simd>(simd: S, texture: &ImageTexture, at: &TexCoords, n: usize, out: &mut Footprints) {
    match texture.shape {
        Shape::Line | Shape::Plane => flat(simd, texture, at, n, out),
        Shape::Volume => deep(texture, at, n, out),
        Shape::Cube => around(texture, at, n, out),
    }
}

#[inline(always)]
fn flat<S: Simd>(simd: S, texture: &ImageTexture, at: &TexCoords, n: usize, out: &mut Footprints) {
    let size2 = squared_size(simd, texture);
    for i in (0..n).step_by(8) {
        flat_level(simd, size2, at, i).store_slice(&mut out.level[i..i + 8]);
    }
}

/// Squares of how many texels a line or plane has across and down.
#[inline(always)]
pub(super) fn squared_size<S: Simd>(simd: S, texture: &ImageTexture) -> [f32x8<S>; 2] {
    let [w, h] = texel_counts(texture);
    [splat(simd, w * w), splat(simd, h * h)]
}

/// The level of eight points on a line or plane.
#[inline(always)]
pub(super) fn flat_level<S: Simd>(simd: S, [w2, h2]: [f32x8<S>; 2], at: &TexCoords, i: usize) -> f32x8<S> {
    let dx = squared(simd, &at.d_dx[0], i) * w2 + squared(simd, &at.d_dx[1], i) * h2;
    let dy = squared(simd, &at.d_dy[0], i) * w2 + squared(simd, &at.d_dy[1], i) * h2;
    half_log2(simd, dx.simd_gt(dy).select(dx, dy))
}

#[inline(always)]
fn squared<S: Simd>(simd: S, lane: &Lane, i: usize) -> f32x8<S> {
    let d = f32x8::from_slice(simd, &lane[i..i + 8]);
    d * d
}

/// Texels across and down; a line has no extent down, so changes of t do not count.
fn texel_counts(texture: &ImageTexture) -> [f32; 2] {
    let [w, h, _] = texture.levels[0].size;
    [w as f32, if texture.shape == Shape::Line { 0.0 } else { h as f32 }]
}

fn deep(texture: &ImageTexture, at: &TexCoords, n: usize, out: &mut Footprints) {
    let [w, h, d] = texture.levels[0].size.map(|n| n as f32);
    for i in 0..n {
        let squared = |ds: f32, dt: f32, dr: f32| {
            let (x, y, z) = (ds * w, dt * h, dr * d);
            x * x + y * y + z * z
        };
        let dx = squared(at.d_dx[0][i], at.d_dx[1][i], at.r[1][i]);
        let dy = squared(at.d_dy[0][i], at.d_dy[1][i], at.r[2][i]);
        out.level[i] = half_log2_of(if dx > dy { dx } else { dy });
    }
}

fn around(texture: &ImageTexture, at: &TexCoords, n: usize, out: &mut Footprints) {
    let size = texture.levels[0].size[0] as f32;
    for i in 0..n {
        let direction = [at.st[0][i], at.st[1][i], at.r[0][i]];
        let (face, sc, tc, ma) = cube_axes(direction);
        let inverse = if ma > 1e-30 { 1.0 / ma } else { 0.0 };
        // On the face, place = 0.5 * c / ma; the change of ma counts as well.
        let along = |d: [f32; 3]| {
            let [x, y, z] = d;
            let (dsc, dtc, dma) = match face {
                0 => (-z, -y, x),
                1 => (z, -y, -x),
                2 => (x, z, y),
                3 => (x, -z, -y),
                4 => (x, -y, z),
                _ => (-x, -y, -z),
            };
            let place = |c: f32, dc: f32| 0.5 * size * (dc - c * inverse * dma) * inverse;
            let (a, b) = (place(sc, dsc), place(tc, dtc));
            a * a + b * b
        };
        let dx = along([at.d_dx[0][i], at.d_dx[1][i], at.r[1][i]]);
        let dy = along([at.d_dy[0][i], at.d_dy[1][i], at.r[2][i]]);
        out.level[i] = half_log2_of(if dx > dy { dx } else { dy });
    }
}

/// Fills everything for up to `max_taps` taps on a line or plane.
#[inline(always)]
pub(super) fn anisotropic<S: Simd>(simd: S, texture: &ImageTexture, at: &TexCoords, n: usize, out: &mut Footprints) {
    let [w, h] = texel_counts(texture);
    let max_taps = texture.sampler.max_anisotropy.clamp(1, 16) as f32;
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let h_inverse = if h > 0.0 { 1.0 / h } else { 0.0 };
    for i in (0..n).step_by(8) {
        let (sx, tx) = (texels(simd, &at.d_dx[0], i, w), texels(simd, &at.d_dx[1], i, h));
        let (sy, ty) = (texels(simd, &at.d_dy[0], i, w), texels(simd, &at.d_dy[1], i, h));
        // The ellipse's matrix J * J^T and its eigenvalues: the squared half axes.
        let (a, b, c) = (sx * sx + sy * sy, sx * tx + sy * ty, tx * tx + ty * ty);
        let difference = (a - c) * splat(simd, 0.5);
        let root = (difference * difference + b * b).sqrt();
        let mean = (a + c) * splat(simd, 0.5);
        let major2 = mean + root;
        let minor2 = mean - root;
        let minor2 = minor2.simd_gt(zero).select(minor2, zero);
        // As many taps as the axes' ratio, rounded up; a footprint within a texel needs one.
        let at_least = minor2.simd_gt(one).select(minor2, one);
        let ratio = (major2 / at_least).sqrt();
        let ratio = ratio.simd_lt(splat(simd, max_taps)).select(ratio, splat(simd, max_taps));
        let down: f32x8<S> = ratio.to_int::<i32x8<S>>().to_float();
        let up = down.simd_lt(ratio).select(down + one, down);
        let n_taps = up.simd_gt(one).select(up, one);
        half_log2(simd, major2 / (n_taps * n_taps)).store_slice(&mut out.level[i..i + 8]);
        n_taps.store_slice(&mut out.n_taps[i..i + 8]);
        // The eigenvector of the larger eigenvalue, from the row that is farther from zero, with the axis' length.
        let is_wide = a.simd_gt(c);
        let (ex, ey) = (is_wide.select(root + difference, b), is_wide.select(b, root - difference));
        let length2 = ex * ex + ey * ey;
        let scale = (major2 / length2.simd_gt(splat(simd, 1e-30)).select(length2, one)).sqrt();
        (ex * scale * splat(simd, 1.0 / w)).store_slice(&mut out.axis[0][i..i + 8]);
        (ey * scale * splat(simd, h_inverse)).store_slice(&mut out.axis[1][i..i + 8]);
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, x: f32) -> f32x8<S> {
    f32x8::splat(simd, x)
}

/// Eight changes in texels. Beyond 1e15 (or NaN) the footprint is cut off, so that squares stay finite.
#[inline(always)]
fn texels<S: Simd>(simd: S, lane: &Lane, i: usize, n_texels: f32) -> f32x8<S> {
    let (zero, huge) = (splat(simd, 0.0), splat(simd, 1e15));
    let d = f32x8::from_slice(simd, &lane[i..i + 8]) * splat(simd, n_texels);
    let d = d.simd_lt(huge).select(d, zero);
    d.simd_gt(zero - huge).select(d, zero)
}

/// Half the base-2 logarithm, absolute error below 1e-5; the range of normal floats is kept, NaN counts as tiny.
#[inline(always)]
fn half_log2<S: Simd>(simd: S, x: f32x8<S>) -> f32x8<S> {
    let x = x.simd_gt(splat(simd, f32::MIN_POSITIVE)).select(x, splat(simd, f32::MIN_POSITIVE));
    let x = x.simd_lt(splat(simd, f32::MAX)).select(x, splat(simd, f32::MAX));
    let bits: u32x8<S> = x.to_bits();
    let exponent: i32x8<S> = (bits >> 23).bitcast();
    let exponent: f32x8<S> = exponent.to_float();
    let m = f32x8::from_bits((bits & 0x007f_ffff) | 0x3f80_0000) - splat(simd, 1.0);
    // m + m (1 - m) q(m), exact at powers of two.
    let q = m * splat(simd, LOG2[3]) + splat(simd, LOG2[2]);
    let q = q * m + splat(simd, LOG2[1]);
    let q = q * m + splat(simd, LOG2[0]);
    let log2 = (exponent - splat(simd, 127.0)) + (m + (m - m * m) * q);
    log2 * splat(simd, 0.5)
}
const LOG2: [f32; 4] = [0.441_917_01, -0.267_179_14, 0.148_426_07, -0.045_148_67];

/// The same for one number, operation by operation.
#[inline(always)]
fn half_log2_of(x: f32) -> f32 {
    let x = if x > f32::MIN_POSITIVE { x } else { f32::MIN_POSITIVE };
    let x = if x < f32::MAX { x } else { f32::MAX };
    let bits = x.to_bits();
    let m = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000) - 1.0;
    let q = m * LOG2[3] + LOG2[2];
    let q = q * m + LOG2[1];
    let q = q * m + LOG2[0];
    (((bits >> 23) as f32 - 127.0) + (m + (m - m * m) * q)) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::exact;

    #[test]
    fn levels_follow_the_logarithm() {
        for i in -400..400 {
            let x = exact::exp2(i as f64 * 0.13) as f32;
            assert!((half_log2_of(x) as f64 - 0.5 * exact::log2(x as f64)).abs() < 2e-5, "{x}");
        }
        for x in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
            assert!(half_log2_of(x).is_finite());
        }
    }
}
