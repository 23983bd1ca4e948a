//! One property filters another (Teschner and Henn, 1994): what does not reach a threshold is laid over, made transparent,
//! or cut away; at once, or gently.

use crate::color::LinearRgba;
use crate::lookup::Reading;
use crate::placement::TexCoords;

/// A texture that hides by value: s is the value. Its colour, with how much of it hides as alpha; as numbers, the share that
/// is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    /// Which values are kept.
    pub keep: Keep,
    /// How far from there values fade away; 0: a sharp edge, smooth within a cell.
    pub softness: f32,
    /// What hides.
    pub color: LinearRgba,
    /// The second coordinate is light, 0 to 1: what hides still shows the form.
    pub is_lit: bool,
    /// All four channels are the share kept, for targets that are numbers.
    pub is_number: bool,
}

/// Which values are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Keep {
    /// These and greater ones.
    Above(f32),
    /// These and lesser ones.
    Below(f32),
    /// From the first to the second.
    Within(f32, f32),
}

/// How dark the shadow side of what hides is.
const LEAST_LIGHT: f32 = 0.45;

impl Filter {
    pub(super) fn read(&self, at: &TexCoords, n: usize, out: &mut Reading) {
        out.is_whole = true;
        for i in 0..n {
            let value = at.st[0][i];
            let (dx, dy) = (at.d_dx[0][i], at.d_dy[0][i]);
            let kept = self.kept(value, (dx * dx + dy * dy).sqrt());
            let [r, g, b, a] = self.color;
            let light = if self.is_lit { LEAST_LIGHT + (1.0 - LEAST_LIGHT) * at.st[1][i] } else { 1.0 };
            let color = match self.is_number {
                true => [kept; 4],
                false => [r * light, g * light, b * light, a * (1.0 - kept)],
            };
            (0..4).for_each(|c| out.rgba[c][i] = color[c]);
        }
    }

    /// How much is kept, for a value that changes by `slope` within a cell. Missing values are.
    #[inline(always)]
    pub fn kept(&self, value: f32, slope: f32) -> f32 {
        if value.is_nan() {
            return 1.0;
        }
        // How far the value is on the kept side.
        let inside = match self.keep {
            Keep::Above(least) => value - least,
            Keep::Below(most) => most - value,
            Keep::Within(least, most) => {
                let (a, b) = (value - least, most - value);
                if a < b { a } else { b }
            }
        };
        let kept = match () {
            _ if self.softness > 0.0 => 1.0 + inside / self.softness,
            _ if slope > 0.0 => 0.5 + inside / slope,
            _ => {
                if inside >= 0.0 {
                    1.0
                } else {
                    0.0
                }
            }
        };
        let kept = if kept > 0.0 { kept } else { 0.0 };
        if kept < 1.0 { kept } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_keep_what_they_are_told_to() {
        let filter = |keep, softness| Filter { keep, softness, color: [1.0; 4], is_lit: false, is_number: false };
        let kept = |f: Filter, values: [f32; 3]| values.map(|v| f.kept(v, 0.0));
        assert_eq!(kept(filter(Keep::Above(2.0), 0.0), [1.9, 2.0, 3.0]), [0.0, 1.0, 1.0]);
        assert_eq!(kept(filter(Keep::Below(2.0), 0.0), [1.9, 2.0, 2.1]), [1.0, 1.0, 0.0]);
        assert_eq!(kept(filter(Keep::Within(1.0, 2.0), 0.0), [0.9, 1.5, 2.1]), [0.0, 1.0, 0.0]);
        assert_eq!(kept(filter(Keep::Above(2.0), 4.0), [2.0, 0.0, -3.0]), [1.0, 0.5, 0.0]);
        assert_eq!(kept(filter(Keep::Above(2.0), 0.0), [f32::NAN, f32::INFINITY, f32::NEG_INFINITY]), [1.0, 1.0, 0.0]);
        // Within a cell that the edge crosses: the share on the kept side.
        assert!((filter(Keep::Above(2.0), 0.0).kept(2.1, 0.4) - 0.75).abs() < 1e-6);
    }
}
