//! Linear light to bytes.
//!
//! The filmic curve follows the plan of Khronos' PBR Neutral tone mapper (2024): up to a knee light stays what it is, so
//! that a material's colour in even light is the colour that was asked for. Above, the largest channel is bent and the
//! others keep their ratio to it, so hues do not turn as they do when each channel is bent alone; what was bent away
//! draws the colour towards white, as film does. The bend is Reinhard's extended curve (2002), which reaches white.

use crate::color::{Encoding, LinearRgb, LinearRgba, Srgb8Encoder};
use crate::math::{BATCH, Each, Lane, exact, kernel};
use crate::picture::lanes::{
    V, V3, at_least, at_most, clamp01, exp2, larger, load3, log2, mix, registers, splat, splat3, width,
};
use crate::visibility::TILE;
use fearless_simd::{Simd, prelude::*};

/// How linear light becomes the numbers of a picture file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Develop {
    /// What happens to bright light.
    pub curve: Curve,
    /// Stops: each doubles the light before the curve.
    pub exposure: f32,
    /// How the file's numbers stand for light.
    pub encoding: Encoding,
    /// Spreads the rounding of 8 bits in an 8x8 pattern, so that slow gradients show no steps. Off where bytes must be
    /// explainable.
    pub dither: bool,
}

/// What happens to bright light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Curve {
    /// Nothing; above 1 it is cut off. For unlit and data pictures, where the pixel is the table's entry.
    Plain,
    /// A gentle shoulder above [`KNEE`] that reaches white at [`WHITE`].
    #[default]
    Filmic,
}

/// Light up to here passes the filmic curve unchanged.
pub const KNEE: f32 = 0.55;

/// Light that the filmic curve takes to full white.
pub const WHITE: f32 = 6.0;

/// Cells in the widest register there is.
const WIDEST: usize = 16;

/// How fast bent colours fade to white.
const FADE: f32 = 0.2;

impl Default for Develop {
    /// Filmic, as exposed, sRGB.
    fn default() -> Self {
        Self { curve: Curve::Filmic, ..Self::PLAIN }
    }
}

impl Develop {
    /// What is 1.0 is white, nothing else: for data.
    pub const PLAIN: Self = Self { curve: Curve::Plain, exposure: 0.0, encoding: Encoding::Srgb, dither: false };

    /// A row of premultiplied linear light to 8-bit pixels.
    ///
    /// `under` is the background's linear colour behind this row, laid under after the curve so that its bytes are the
    /// ones asked for; the pixels are then opaque. Without one alpha stays, straight, so that edges have no dark fringe.
    /// `y` is the row's number, for the dither pattern.
    #[inline(always)]
    pub fn rgba8<S: Simd>(&self, simd: S, cells: &[LinearRgba], under: Option<LinearRgb>, y: u32, out: &mut [[u8; 4]]) {
        let encoder = Srgb8Encoder::new();
        self.each_group(
            simd,
            (cells, under),
            out,
            #[inline(always)]
            |at, color, alpha, out| {
                let threshold = kernel(
                    #[inline(always)]
                    |i: usize| threshold((at + i) as u32, y),
                );
                self.store8(simd, &encoder, (color, alpha), threshold, out);
            },
        );
    }

    /// The same for opaque cells anywhere in a tile of `TILE` x `TILE` cells: a batch's light to pixels of the tile, as
    /// their four bytes.
    #[inline(always)]
    pub(super) fn opaque8<S: Simd>(
        &self,
        simd: S,
        light: &[Lane; 3],
        (cells, n): (&[u32; BATCH], usize),
        tile: &mut [u32; TILE * TILE],
    ) {
        let encoder = Srgb8Encoder::new();
        let gain = self.gain();
        for at in registers::<S>(n) {
            let color = self.bent(simd, load3(simd, light, at), gain);
            let cells = &cells[at..at + width::<S>()];
            let threshold = kernel(
                #[inline(always)]
                |i: usize| threshold(cells[i] % TILE as u32, cells[i] / TILE as u32),
            );
            let mut pixels = [[0; 4]; WIDEST];
            self.store8(simd, &encoder, (color, splat(simd, 1.0)), threshold, &mut pixels[..width::<S>()]);
            let n = n - at;
            let put = kernel(
                #[inline(always)]
                |i: usize| tile[cells[i] as usize % (TILE * TILE)] = u32::from_le_bytes(pixels[i]),
            );
            // Whole registers without a question for each cell.
            match n < width::<S>() {
                true => (0..n).for_each(put),
                false => (0..width::<S>()).for_each(put),
            }
        }
    }

    /// Pixels from developed colours; `threshold` is the dither pattern's.
    #[inline(always)]
    fn store8<S: Simd>(
        &self,
        simd: S,
        encoder: &Srgb8Encoder,
        (color, alpha): (V3<S>, V<S>),
        threshold: impl Fn(usize) -> f32,
        out: &mut [[u8; 4]],
    ) {
        match (self.dither, self.encoding) {
            (false, Encoding::Srgb) => store_srgb8::<S>(encoder, color, alpha, out),
            (false, Encoding::Linear) => store_linear8(simd, color, alpha, [0.5; WIDEST], out),
            (true, encoding) => {
                let color = if encoding == Encoding::Srgb { srgb(simd, color) } else { color };
                let mut pattern = [0.0; WIDEST];
                (0..out.len()).for_each(|i| pattern[i] = threshold(i));
                store_linear8(simd, color, alpha, pattern, out);
            }
        }
    }

    /// The same to 16-bit pixels; sRGB values are within one step of the exact curve.
    #[inline(always)]
    pub fn rgba16<S: Simd>(&self, simd: S, cells: &[LinearRgba], under: Option<LinearRgb>, out: &mut [[u16; 4]]) {
        self.each_group(
            simd,
            (cells, under),
            out,
            #[inline(always)]
            |_, color, alpha, out| {
                let color = if self.encoding == Encoding::Srgb { srgb(simd, color) } else { color };
                let [r, g, b, a]: [S::u32s; 4] = [color[0], color[1], color[2], alpha].each(
                    #[inline(always)]
                    |v| (v * 65535.0 + 0.5).to_int(),
                );
                for (i, out) in out.iter_mut().enumerate() {
                    *out = [r[i] as u16, g[i] as u16, b[i] as u16, a[i] as u16];
                }
            },
        );
    }

    /// One colour through exposure and curve; linear, within [0, 1].
    pub fn color(&self, color: LinearRgb) -> LinearRgb {
        let level = fearless_simd::Level::baseline();
        fearless_simd::dispatch!(level, simd => {
            let bent = self.bent(simd, splat3(simd, color), self.gain());
            [bent[0][0], bent[1][0], bent[2][0]]
        })
    }

    /// What exposure multiplies light by.
    fn gain(&self) -> f32 {
        if self.exposure == 0.0 { 1.0 } else { exact::exp2(self.exposure as f64) as f32 }
    }

    /// Calls `store(first, color, alpha, pixels)` for each register of developed cells.
    #[inline(always)]
    fn each_group<S: Simd, P: Copy>(
        &self,
        simd: S,
        (cells, under): (&[LinearRgba], Option<LinearRgb>),
        out: &mut [P],
        mut store: impl FnMut(usize, V3<S>, V<S>, &mut [P]),
    ) {
        assert_eq!(cells.len(), out.len(), "a row has as many pixels as cells");
        let gain = self.gain();
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        // Where nothing is, one pixel serves a whole row, but for the dither pattern.
        let mut nothing = None;
        let numbers: &[f32] = bytemuck::cast_slice(cells);
        for first in (0..cells.len()).step_by(width::<S>()) {
            let n = (cells.len() - first).min(width::<S>());
            let (numbers, out) = (&numbers[4 * first..4 * (first + n)], &mut out[first..first + n]);
            let four = match n == width::<S>() {
                true => four_registers(simd, numbers),
                false => {
                    let mut padded = [0.0; 4 * WIDEST];
                    padded[..4 * n].copy_from_slice(numbers);
                    four_registers(simd, &padded)
                }
            };
            if let Some(nothing) = nothing
                && is_zero::<S>(four)
            {
                fill(out, width::<S>(), nothing);
                continue;
            }
            let [r, g, b, a] = separated::<S>(four);
            let empty = a.simd_eq(zero);
            let full = a.simd_ge(one);
            let (color, alpha) = if full.all_true() {
                (self.bent(simd, [r, g, b], gain), one)
            } else {
                let alpha = clamp01(simd, a);
                // Straight colour; where nothing is, alpha's floor only avoids a division by zero.
                let inverse = one / at_least(simd, alpha, 1e-6);
                let straight = [r, g, b].each(
                    #[inline(always)]
                    |c| empty.select(zero, full.select(c, c * inverse)),
                );
                over(simd, self.bent(simd, straight, gain), alpha, under)
            };
            store(first, color, alpha, out);
            if empty.all_true() && !self.dither {
                nothing = Some(out[0]);
            }
        }
    }

    /// Exposure and curve for a register of straight colours; within [0, 1], NaN is 0.
    #[inline(always)]
    fn bent<S: Simd>(&self, simd: S, color: V3<S>, gain: f32) -> V3<S> {
        let most = if self.curve == Curve::Plain { 1.0 } else { 1e6 };
        let color = color.each(
            #[inline(always)]
            |c| at_most(simd, at_least(simd, c * gain, 0.0), most),
        );
        match self.curve {
            Curve::Plain => color,
            Curve::Filmic => {
                let peak = larger::<S>(color[0], larger::<S>(color[1], color[2]));
                let over = peak.simd_gt(splat(simd, KNEE));
                let new_peak = shoulder(simd, peak);
                let ratio = new_peak / at_least(simd, peak, KNEE);
                let bent_away = peak - new_peak;
                let fade = splat(simd, 1.0) - splat(simd, 1.0) / (bent_away * FADE + 1.0);
                color.each(
                    #[inline(always)]
                    |c| at_most(simd, over.select(mix::<S>(c * ratio, new_peak, fade), c), 1.0),
                )
            }
        }
    }
}

/// Above the knee: Reinhard's `t (1 + t / T^2) / (1 + t)`, scaled to leave the knee with slope 1 and to reach 1 at `WHITE`.
#[inline(always)]
fn shoulder<S: Simd>(simd: S, peak: V<S>) -> V<S> {
    const SPAN: f32 = 1.0 - KNEE;
    const T: f32 = (WHITE - KNEE) / SPAN;
    let t = at_most(simd, (peak - KNEE) * (1.0 / SPAN), T);
    (t * (t * (1.0 / (T * T)) + 1.0)) / (t + 1.0) * SPAN + KNEE
}

/// Developed colours over the background, if there is one.
#[inline(always)]
fn over<S: Simd>(simd: S, color: V3<S>, alpha: V<S>, under: Option<LinearRgb>) -> (V3<S>, V<S>) {
    let Some(under) = under else { return (color, alpha) };
    let one = splat(simd, 1.0);
    let full = alpha.simd_ge(one);
    let under = splat3(simd, under);
    let over: V3<S> = [0, 1, 2].each(
        #[inline(always)]
        |c| {
            let mixed = mix::<S>(under[c], color[c], alpha);
            clamp01(simd, full.select(color[c], mixed))
        },
    );
    (over, one)
}

/// A register's width of cells as they stand in memory.
#[inline(always)]
fn four_registers<S: Simd>(simd: S, numbers: &[f32]) -> [V<S>; 4] {
    let numbers = &numbers[..4 * width::<S>()];
    [0, 1, 2, 3].each(
        #[inline(always)]
        |k: usize| V::<S>::from_slice(simd, &numbers[k * width::<S>()..(k + 1) * width::<S>()]),
    )
}

/// Whether no bit is set.
#[inline(always)]
fn is_zero<S: Simd>(four: [V<S>; 4]) -> bool {
    let [a, b, c, d]: [S::u32s; 4] = four.each(
        #[inline(always)]
        |v| v.bitcast(),
    );
    (a | b | c | d).simd_eq(0).all_true()
}

/// Cells to a register for each channel.
#[inline(always)]
fn separated<S: Simd>([a, b, c, d]: [V<S>; 4]) -> [V<S>; 4] {
    // Red and blue, green and alpha, of one half of the cells and the other.
    let (rb, ga) = ((a.unzip_low(b), c.unzip_low(d)), (a.unzip_high(b), c.unzip_high(d)));
    [rb.0.unzip_low(rb.1), ga.0.unzip_low(ga.1), rb.0.unzip_high(rb.1), ga.0.unzip_high(ga.1)]
}

/// `out` filled with one pixel; quick where it is a register's width.
#[inline(always)]
fn fill<P: Copy>(out: &mut [P], width: usize, pixel: P) {
    match out.len() == width {
        true => (0..width).for_each(|i| out[i] = pixel),
        false => out.fill(pixel),
    }
}

/// The sRGB curve for numbers within [0, 1], to about 1e-6.
#[inline(always)]
fn srgb<S: Simd>(simd: S, color: V3<S>) -> V3<S> {
    color.each(
        #[inline(always)]
        |x| {
            let power = exp2(simd, log2(simd, x) * (1.0 / 2.4)) * 1.055 - 0.055;
            clamp01(simd, x.simd_gt(splat(simd, 0.0031308)).select(power, x * 12.92))
        },
    )
}

/// Pixels from colours within [0, 1]; each byte exactly rounded.
#[inline(always)]
fn store_srgb8<S: Simd>(encoder: &Srgb8Encoder, color: V3<S>, alpha: V<S>, out: &mut [[u8; 4]]) {
    let a: S::i32s = (alpha * 255.0 + 0.5).to_int();
    for (i, out) in out.iter_mut().enumerate() {
        *out = [encoder.encode(color[0][i]), encoder.encode(color[1][i]), encoder.encode(color[2][i]), a[i] as u8];
    }
}

/// Pixels from numbers within [0, 1], rounded up where they reach a threshold of the next step.
#[inline(always)]
fn store_linear8<S: Simd>(simd: S, color: V3<S>, alpha: V<S>, pattern: [f32; WIDEST], out: &mut [[u8; 4]]) {
    let pattern = V::<S>::from_slice(simd, &pattern[..width::<S>()]);
    let [r, g, b]: [S::i32s; 3] = color.each(
        #[inline(always)]
        |c| at_most(simd, c * 255.0 + pattern, 255.0).to_int(),
    );
    let a: S::i32s = (alpha * 255.0 + 0.5).to_int();
    let pixels = r | (g << 8) | (b << 16) | (a << 24);
    let pixels = pixels.as_slice();
    match out.len() == width::<S>() {
        // So many that the loop becomes one store.
        true => (0..width::<S>()).for_each(|i| out[i] = pixels[i].to_le_bytes()),
        false => (0..out.len()).for_each(|i| out[i] = pixels[i].to_le_bytes()),
    }
}

/// Bayer's ordered pattern, 8x8 ("An Optimum Method for Two-Level Rendition", 1973): between 0 and 1, mean one half.
fn threshold(x: u32, y: u32) -> f32 {
    let bit = |v: u32, n: u32| v >> n & 1;
    let rank = (0..3).fold(0, |rank, n| rank << 2 | (bit(x ^ y, n) << 1 | bit(y, n)));
    (rank as f32 + 0.5) / 64.0
}

#[cfg(test)]
#[path = "develop_tests.rs"]
mod tests;
