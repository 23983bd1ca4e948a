//! Colour words: linear light with Rec. 709 primaries inside, sRGB bytes at the edges (IEC 61966-2-1).

use crate::math::exact;
use std::sync::LazyLock;

/// Linear light, Rec. 709 primaries; 1.0 is white paper.
pub type LinearRgb = [f32; 3];

/// Linear light and straight (not premultiplied) opacity.
pub type LinearRgba = [f32; 4];

/// How stored numbers stand for light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// The sRGB transfer curve: photographs, colour textures.
    Srgb,
    /// Numbers are proportional to what they mean: data, normals, roughness, float images.
    Linear,
}

/// sRGB value in [0, 1] to linear light, exact to f64 before rounding.
pub fn linear_from_srgb(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { exact::pow((x + 0.055) / 1.055, 2.4) }
}

/// Linear light in [0, 1] to an sRGB value, exact to f64 before rounding.
pub fn srgb_from_linear(x: f64) -> f64 {
    if x <= 0.0031308 { x * 12.92 } else { 1.055 * exact::pow(x, 1.0 / 2.4) - 0.055 }
}

/// CIE Lab (D65) to linear light; outside of [0, 1] where no screen shows the colour.
pub fn lab_to_linear([l, a, b]: [f64; 3]) -> [f64; 3] {
    let fy = (l + 16.0) / 116.0;
    let inverse = |f: f64| if f > 6.0 / 29.0 { f * f * f } else { (f - 4.0 / 29.0) * (108.0 / 841.0) };
    let (x, y, z) = (0.9505 * inverse(fy + a / 500.0), inverse(fy), 1.089 * inverse(fy - b / 200.0));
    [3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z, 0.0557 * x - 0.2040 * y + 1.0570 * z]
}

/// Linear light to CIE Lab (D65).
pub fn lab_from_linear([r, g, b]: [f64; 3]) -> [f64; 3] {
    let f = |t: f64| if t > 216.0 / 24389.0 { exact::cbrt(t) } else { t * (841.0 / 108.0) + 4.0 / 29.0 };
    let x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505);
    let y = f(0.2126 * r + 0.7152 * g + 0.0722 * b);
    let z = f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Linear light of every sRGB byte.
pub static LINEAR_FROM_SRGB8: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| linear_from_srgb(i as f64 / 255.0) as f32));

/// For each sRGB byte but the first: the least linear value that rounds to it.
static SRGB8_THRESHOLDS: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| if i == 0 { f32::NEG_INFINITY } else { linear_from_srgb((i as f64 - 0.5) / 255.0) as f32 })
});

/// For every bucket of floats that share their upper half: the byte of its lower end in the upper half, and 2^16 minus
/// the lower half from which the next byte begins. Adding a float's lower half carries exactly when it reaches that.
static SRGB8_BUCKETS: LazyLock<[u32; N_BUCKETS]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let b = (i as u32 + FIRST_BUCKET).min(LAST_BUCKET);
        let low = f32::from_bits(b << BUCKET_SHIFT);
        let byte = SRGB8_THRESHOLDS.partition_point(|t| *t <= low) as u32 - 1;
        let next = SRGB8_THRESHOLDS.get(byte as usize + 1).map_or(0, |t| t.to_bits());
        let carry = if next >> BUCKET_SHIFT == b { (1 << BUCKET_SHIFT) - (next & LOWER_HALF) } else { 0 };
        (byte << BUCKET_SHIFT) + carry
    })
});
const BUCKET_SHIFT: u32 = 16;
const LOWER_HALF: u32 = (1 << BUCKET_SHIFT) - 1;
const FIRST_BUCKET: u32 = 0x3900_0000 >> BUCKET_SHIFT; // 2^-13, below half the first threshold
const LAST_BUCKET: u32 = 0x3f80_0000 >> BUCKET_SHIFT; // 1.0
/// A power of two, so that a mask keeps any index within.
const N_BUCKETS: usize = 2048;

/// Linear light to the nearest sRGB byte, exactly rounded; NaN and negatives give 0.
///
/// A float's upper bits pick a bucket narrower than any step of the code, so that at most one comparison decides.
#[inline]
pub fn srgb8_from_linear(x: f32) -> u8 {
    Srgb8Encoder::new().encode(x)
}

/// The table of [`srgb8_from_linear`], borrowed once for many values.
///
/// A vector kernel does the steps of [`encode`](Self::encode) itself: clamp to [[`LOW`](Self::LOW), 1], look the bits up,
/// add their lower half, and keep what carries into the upper half.
#[derive(Clone, Copy)]
pub struct Srgb8Encoder {
    buckets: &'static [u32; N_BUCKETS],
}

impl Srgb8Encoder {
    /// Below this all is 0; the table begins here.
    pub const LOW: f32 = 1.0 / 8192.0;

    /// Bits of a float that do not choose its entry.
    pub const LOWER_HALF: u32 = LOWER_HALF;

    /// Borrows the table, making it on first use.
    #[expect(clippy::new_without_default, reason = "not a value with a neutral state, a borrow")]
    pub fn new() -> Self {
        Self { buckets: &SRGB8_BUCKETS }
    }

    /// The nearest sRGB byte.
    #[inline(always)]
    pub fn encode(&self, x: f32) -> u8 {
        let x = if x > Self::LOW { x } else { Self::LOW };
        let x = if x < 1.0 { x } else { 1.0 };
        let bits = x.to_bits();
        ((self.entry(bits) + (bits & LOWER_HALF)) >> BUCKET_SHIFT) as u8
    }

    /// What to add a float's lower half to, for the bits of a float within [[`LOW`](Self::LOW), 1].
    #[inline(always)]
    pub fn entry(&self, bits: u32) -> u32 {
        self.buckets[((bits >> BUCKET_SHIFT).wrapping_sub(FIRST_BUCKET)) as usize % N_BUCKETS]
    }
}

/// A number in [0, 1] to the nearest of 256 steps; NaN gives 0.
#[inline(always)]
pub fn unorm8(x: f32) -> u8 {
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < 1.0 { x } else { 1.0 };
    (x * 255.0 + 0.5) as u8
}

/// How bright a linear colour is (Rec. 709 luminance).
#[inline(always)]
pub fn luminance(c: LinearRgb) -> f32 {
    0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]
}

/// A linear colour from sRGB bytes.
pub fn linear_from_bytes(srgb: [u8; 3]) -> LinearRgb {
    srgb.map(|b| LINEAR_FROM_SRGB8[b as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_srgb_byte_survives_the_round_trip() {
        for b in 0..=255u8 {
            assert_eq!(srgb8_from_linear(LINEAR_FROM_SRGB8[b as usize]), b);
        }
    }

    #[test]
    fn encoding_rounds_exactly() {
        for i in 0..200_000 {
            let x = i as f32 / 199_999.0;
            let truth = (srgb_from_linear(x as f64) * 255.0 + 0.5).floor() as u8;
            let got = srgb8_from_linear(x);
            // At a threshold's own rounding either neighbour is right.
            let nearest = (srgb_from_linear(x as f64) * 255.0 - got as f64).abs();
            assert!(got == truth || nearest < 0.50001, "{x}: {got} not {truth}");
        }
        assert_eq!(srgb8_from_linear(f32::NAN), 0);
        assert_eq!(srgb8_from_linear(-1.0), 0);
        assert_eq!(srgb8_from_linear(7.0), 255);
    }
}
