//! Lines of equal value, drawn per point: as wide as asked for whatever the slope, and smooth at their edges.
//!
//! After the isoline textures of Teschner and Henn (1994): there a texel of the line's colour, as wide on the surface as the
//! value is flat; here the distance to the nearest level is measured in cells, by the value's own slope.

use crate::color::LinearRgba;
use crate::lookup::Reading;
use crate::placement::TexCoords;

/// A texture of lines: s is the value. Colour of the line, and how much of the cell it covers as alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct Isolines {
    /// Where lines run.
    pub levels: Levels,
    /// Of all lines.
    pub minor: Line,
    /// Of every n-th line, counted from the level 0 (even steps) or the first one (a list).
    pub major: Option<(u32, Line)>,
}

/// What a line is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// In cells.
    pub width: f32,
    /// Straight alpha.
    pub color: LinearRgba,
}

/// Where lines run.
#[derive(Clone, Debug, PartialEq)]
pub enum Levels {
    /// At `offset + k * step` for whole k; the step is above 0.
    Steps {
        /// From line to line.
        step: f32,
        /// One of the levels.
        offset: f32,
    },
    /// At these values, in ascending order.
    List(Vec<f32>),
}

impl Levels {
    /// The level nearest to a value, and its number.
    #[inline(always)]
    fn nearest(&self, value: f32) -> Option<(f32, i64)> {
        match self {
            Self::Steps { step, offset } => {
                let k = crate::math::floor((value - offset) / step + 0.5);
                Some((k * step + offset, k as i64))
            }
            Self::List(levels) => {
                let after = levels.partition_point(|l| *l < value);
                let far = |i: usize| (levels[i] - value).abs();
                let i = match (after.checked_sub(1), after < levels.len()) {
                    (Some(before), true) => {
                        if far(before) <= far(after) {
                            before
                        } else {
                            after
                        }
                    }
                    (Some(before), false) => before,
                    (None, true) => after,
                    (None, false) => return None,
                };
                Some((levels[i], i as i64))
            }
        }
    }

    /// All levels within a range, at most `limit`, for legends and labels.
    pub fn within(&self, [a, b]: [f64; 2], limit: usize) -> Vec<f64> {
        let (low, high) = (a.min(b), a.max(b));
        match self {
            Self::Steps { step, offset } => {
                let (step, offset) = (*step as f64, *offset as f64);
                let first = ((low - offset) / step - 1e-6).ceil();
                let count = (((high - offset) / step + 1e-6).floor() - first + 1.0).max(0.0);
                if count > limit as f64 {
                    return Vec::new();
                }
                (0..count as usize).map(|i| (first + i as f64) * step + offset).collect()
            }
            Self::List(levels) => {
                levels.iter().map(|l| *l as f64).filter(|l| (low..=high).contains(l)).take(limit).collect()
            }
        }
    }
}

impl Isolines {
    /// The line that stands for a level's number.
    #[inline(always)]
    fn line(&self, number: i64) -> &Line {
        match &self.major {
            Some((every, line)) if number.rem_euclid((*every).max(1) as i64) == 0 => line,
            _ => &self.minor,
        }
    }

    pub(super) fn read(&self, at: &TexCoords, n: usize, out: &mut Reading) {
        out.is_whole = true;
        for i in 0..n {
            let value = at.st[0][i];
            let (dx, dy) = (at.d_dx[0][i], at.d_dy[0][i]);
            let slope = (dx * dx + dy * dy).sqrt();
            let mut color = [0.0; 4];
            // Where the value does not change there is no line, whatever it is: a plateau is no flood.
            if slope > 0.0
                && value.is_finite()
                && let Some((level, number)) = self.levels.nearest(value)
            {
                let line = self.line(number);
                let distance = (value - level).abs() / slope;
                let cover = 0.5 * line.width + 0.5 - distance;
                let cover = if cover < line.width { cover } else { line.width };
                let cover = if cover < 1.0 { cover } else { 1.0 };
                if cover > 0.0 {
                    color = line.color;
                    color[3] *= cover;
                }
            }
            (0..4).for_each(|c| out.rgba[c][i] = color[c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(levels: Levels) -> Isolines {
        let line = |width| Line { width, color: [0.0, 0.0, 0.0, 1.0] };
        Isolines { levels, minor: line(1.5), major: Some((5, line(3.0))) }
    }

    /// Alpha along a ramp of `slope` a cell.
    fn along(isolines: &Isolines, slope: f32, n: usize) -> Vec<f32> {
        let mut at = TexCoords::ZERO;
        for i in 0..n {
            at.st[0][i] = (i as f32 + 0.5) * slope;
            (at.d_dx[0][i], at.d_dy[0][i]) = (0.6 * slope, 0.8 * slope);
        }
        let mut reading = Reading::ZERO;
        isolines.read(&at, n, &mut reading);
        reading.rgba[3][..n].to_vec()
    }

    #[test]
    fn lines_are_as_wide_as_asked_for_whatever_the_slope() {
        for slope in [1e-6_f32, 0.013, 1.0, 770.0] {
            // Four levels within 200 cells; number 0 is at the left edge, so half of it is seen.
            let isolines = lines(Levels::Steps { step: slope * 50.3, offset: 0.0 });
            let covered: f32 = along(&isolines, slope, 200).iter().sum();
            assert!((covered - (1.5 + 3.0 * 1.5)).abs() < 0.25, "{slope}: {covered}");
        }
    }

    #[test]
    fn plateaus_and_missing_values_have_no_lines() {
        let isolines = lines(Levels::Steps { step: 1.0, offset: 0.0 });
        let mut at = TexCoords::ZERO;
        at.st[0][0] = 2.0;
        at.st[0][1] = f32::NAN;
        (at.d_dx[0][1], at.d_dx[0][2]) = (1.0, 1.0);
        at.st[0][2] = 3.0;
        let mut reading = Reading::ZERO;
        isolines.read(&at, 3, &mut reading);
        assert_eq!(reading.rgba[3][..3], [0.0, 0.0, 1.0]);
    }

    #[test]
    fn levels_may_be_listed() {
        let levels = Levels::List(vec![1.0, 2.0, 4.0]);
        assert_eq!(
            [0.0, 1.4, 1.6, 3.1, 9.0].map(|v| levels.nearest(v).map(|l| l.0)),
            [1.0, 1.0, 2.0, 4.0, 4.0].map(Some)
        );
        assert_eq!(levels.within([1.5, 5.0], 9), [2.0, 4.0]);
        assert_eq!(Levels::Steps { step: 0.5, offset: 0.25 }.within([1.0, -0.3], 9), [-0.25, 0.25, 0.75]);
        assert!(Levels::List(Vec::new()).nearest(1.0).is_none());
    }
}
