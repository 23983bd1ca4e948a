//! Linear light to bytes.
//!
//! The filmic curve follows the plan of Khronos' PBR Neutral tone mapper (2024): up to a knee light stays what it is, so
//! that a material's colour in even light is the colour that was asked for. Above, the largest channel is bent and the
//! others keep their ratio to it, so hues do not turn as they do when each channel is bent alone; what was bent away
//! draws the colour towards white, as film does. The bend is Reinhard's extended curve (2002), which reaches white.

use crate::color::{Encoding, LinearRgb, LinearRgba, Srgb8Encoder};
use crate::math::exact;
use crate::picture::lanes::{
    V, V3, at_least, at_most, clamp01, exp2, larger, log2, mix, per_channel, splat, splat3, width,
};
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
    pub fn rgba8<S: Simd>(&self, simd: S, cells: &[LinearRgba], under: Option<LinearRgb>, y: u32, out: &mut [[u8; 4]]) {
        assert_eq!(cells.len(), out.len(), "a row has as many pixels as cells");
        simd.vectorize(
            #[inline(always)]
            || {
                let encoder = Srgb8Encoder::new();
                self.each_group(
                    simd,
                    cells,
                    under,
                    #[inline(always)]
                    |at, n, color, alpha| {
                        let out = &mut out[at..at + n];
                        match (self.dither, self.encoding) {
                            (false, Encoding::Srgb) => store_srgb8(simd, &encoder, color, alpha, out),
                            (false, Encoding::Linear) => store_linear8(simd, color, alpha, [0.5; WIDEST], out),
                            (true, encoding) => {
                                let color = if encoding == Encoding::Srgb { srgb(simd, color) } else { color };
                                let pattern = std::array::from_fn(|i| threshold(at as u32 + i as u32, y));
                                store_linear8(simd, color, alpha, pattern, out);
                            }
                        }
                    },
                );
            },
        );
    }

    /// The same to 16-bit pixels; sRGB values are within one step of the exact curve.
    pub fn rgba16<S: Simd>(&self, simd: S, cells: &[LinearRgba], under: Option<LinearRgb>, out: &mut [[u16; 4]]) {
        assert_eq!(cells.len(), out.len(), "a row has as many pixels as cells");
        simd.vectorize(
            #[inline(always)]
            || {
                self.each_group(
                    simd,
                    cells,
                    under,
                    #[inline(always)]
                    |at, n, color, alpha| {
                        let color = if self.encoding == Encoding::Srgb { srgb(simd, color) } else { color };
                        let [r, g, b]: [S::u32s; 3] = per_channel!(c => (color[c] * 65535.0 + 0.5).to_int());
                        let a: S::u32s = (alpha * 65535.0 + 0.5).to_int();
                        for (i, out) in out[at..at + n].iter_mut().enumerate() {
                            *out = [r[i] as u16, g[i] as u16, b[i] as u16, a[i] as u16];
                        }
                    },
                );
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

    /// Calls `store(first, count, color, alpha)` for each register of developed cells.
    #[inline(always)]
    fn each_group<S: Simd>(
        &self,
        simd: S,
        cells: &[LinearRgba],
        under: Option<LinearRgb>,
        mut store: impl FnMut(usize, usize, V3<S>, V<S>),
    ) {
        let gain = self.gain();
        for (group, chunk) in cells.chunks(width::<S>()).enumerate() {
            let (premultiplied, alpha) = load_cells(simd, chunk);
            let alpha = clamp01(simd, alpha);
            // Straight colour; where nothing is, alpha's floor only avoids a division by zero.
            let inverse = splat(simd, 1.0) / at_least(simd, alpha, 1e-6);
            let full = alpha.simd_ge(splat(simd, 1.0));
            let straight = per_channel!(c => full.select(premultiplied[c], premultiplied[c] * inverse));
            let color = self.bent(simd, straight, gain);
            let (color, alpha) = match under {
                None => (color, alpha),
                Some(under) => {
                    let under = splat3(simd, under);
                    let over: V3<S> = per_channel!(c => {
                        let mixed = mix::<S>(under[c], color[c], alpha);
                        clamp01(simd, full.select(color[c], mixed))
                    });
                    (over, splat(simd, 1.0))
                }
            };
            store(group * width::<S>(), chunk.len(), color, alpha);
        }
    }

    /// Exposure and curve for a register of straight colours; within [0, 1], NaN is 0.
    #[inline(always)]
    fn bent<S: Simd>(&self, simd: S, color: V3<S>, gain: f32) -> V3<S> {
        let color: V3<S> = per_channel!(c => at_most(simd, at_least(simd, color[c] * gain, 0.0), 1e6));
        match self.curve {
            Curve::Plain => per_channel!(c => at_most(simd, color[c], 1.0)),
            Curve::Filmic => {
                let peak = larger::<S>(color[0], larger::<S>(color[1], color[2]));
                let over = peak.simd_gt(splat(simd, KNEE));
                let new_peak = shoulder(simd, peak);
                let ratio = new_peak / at_least(simd, peak, KNEE);
                let bent_away = peak - new_peak;
                let fade = splat(simd, 1.0) - splat(simd, 1.0) / (bent_away * FADE + 1.0);
                per_channel!(c => {
                    let bent = mix::<S>(color[c] * ratio, new_peak, fade);
                    at_most(simd, over.select(bent, color[c]), 1.0)
                })
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

/// Colour and alpha of up to a register of cells; missing cells are zero.
#[inline(always)]
fn load_cells<S: Simd>(simd: S, cells: &[LinearRgba]) -> (V3<S>, V<S>) {
    let n = width::<S>();
    if cells.len() == n {
        let flat = cells.as_flattened();
        // r b r b ... and g a g a ..., twice; then each of them apart.
        let (rb_low, ga_low) =
            V::<S>::from_slice(simd, &flat[..n]).deinterleave(V::<S>::from_slice(simd, &flat[n..][..n]));
        let (rb_high, ga_high) =
            V::<S>::from_slice(simd, &flat[2 * n..][..n]).deinterleave(V::<S>::from_slice(simd, &flat[3 * n..][..n]));
        let (r, b) = rb_low.deinterleave(rb_high);
        let (g, a) = ga_low.deinterleave(ga_high);
        return ([r, g, b], a);
    }
    let mut lanes = [[0.0; WIDEST]; 4];
    for (i, [r, g, b, a]) in cells.iter().enumerate() {
        lanes[0][i] = *r;
        lanes[1][i] = *g;
        lanes[2][i] = *b;
        lanes[3][i] = *a;
    }
    let color = per_channel!(c => V::<S>::from_slice(simd, &lanes[c][..n]));
    (color, V::<S>::from_slice(simd, &lanes[3][..n]))
}

/// The sRGB curve for numbers within [0, 1], to about 1e-6.
#[inline(always)]
fn srgb<S: Simd>(simd: S, color: V3<S>) -> V3<S> {
    per_channel!(c => {
        let x = color[c];
        let power = exp2(simd, log2(simd, x) * (1.0 / 2.4)) * 1.055 - 0.055;
        clamp01(simd, x.simd_gt(splat(simd, 0.0031308)).select(power, x * 12.92))
    })
}

/// Pixels from colours within [0, 1]; each byte exactly rounded.
#[inline(always)]
fn store_srgb8<S: Simd>(simd: S, encoder: &Srgb8Encoder, color: V3<S>, alpha: V<S>, out: &mut [[u8; 4]]) {
    let [r, g, b]: [S::u32s; 3] = per_channel!(c => {
        let bits: S::u32s = at_least(simd, color[c], Srgb8Encoder::LOW).bitcast();
        let mut entries = [0; WIDEST];
        bits.store_slice(&mut entries[..width::<S>()]);
        for entry in &mut entries[..width::<S>()] {
            *entry = encoder.entry(*entry);
        }
        let entries = S::u32s::from_slice(simd, &entries[..width::<S>()]);
        (entries + (bits & Srgb8Encoder::LOWER_HALF)) >> 16
    });
    let a: S::u32s = (alpha * 255.0 + 0.5).to_int();
    let mut words = [0u32; WIDEST];
    (r | (g << 8) | (b << 16) | (a << 24)).store_slice(&mut words[..width::<S>()]);
    for (out, word) in out.iter_mut().zip(words) {
        *out = word.to_le_bytes();
    }
}

/// Pixels from numbers within [0, 1], rounded up where they reach a threshold of the next step.
#[inline(always)]
fn store_linear8<S: Simd>(simd: S, color: V3<S>, alpha: V<S>, pattern: [f32; WIDEST], out: &mut [[u8; 4]]) {
    let pattern = V::<S>::from_slice(simd, &pattern[..width::<S>()]);
    let [r, g, b]: [S::u32s; 3] = per_channel!(c => at_most(simd, color[c] * 255.0 + pattern, 255.0).to_int());
    let a: S::u32s = (alpha * 255.0 + 0.5).to_int();
    for (i, out) in out.iter_mut().enumerate() {
        *out = [r[i] as u8, g[i] as u8, b[i] as u8, a[i] as u8];
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
