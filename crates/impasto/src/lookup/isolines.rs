//! Lines of equal value, drawn per point: as wide as asked for whatever the slope, and smooth at their edges.
//!
//! After the isoline textures of Teschner and Henn (1994): there a texel of the line's colour, as wide on the surface as the
//! value is flat; here the distance to the nearest level is measured in cells, by the value's own slope.

use crate::color::LinearRgba;
use crate::lookup::Reading;
use crate::math::{BATCH, floor};
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

/// The level of a list that is nearest to a value, the lower one of two, and its number.
fn nearest(levels: &[f32], value: f32) -> Option<(f32, usize)> {
    let after = levels.partition_point(|l| *l < value);
    let far = |i: usize| (levels[i] - value).abs();
    let i = match after.checked_sub(1) {
        Some(before) if after == levels.len() || far(before) <= far(after) => before,
        _ => after,
    };
    levels.get(i).map(|level| (*level, i))
}

impl Isolines {
    #[inline(always)]
    pub(super) fn read(&self, at: &TexCoords, n: usize, out: &mut Reading) {
        out.is_whole = true;
        let n = n.min(BATCH);
        let (every, major) = self.major.map_or((1, self.minor), |(every, line)| (every.max(1), line));
        let lines = [self.minor, major];
        match &self.levels {
            Levels::Steps { step, offset } => {
                for i in 0..n {
                    let number = floor((at.st[0][i] - offset) / step + 0.5);
                    let is_major = number - floor(number / every as f32) * every as f32 == 0.0;
                    draw(&lines, is_major, number * step + offset, (at, i), out);
                }
            }
            Levels::List(levels) => {
                for i in 0..n {
                    // Of no levels at all, none is near.
                    let (level, number) = nearest(levels, at.st[0][i]).unwrap_or((f32::NAN, 0));
                    draw(&lines, number.is_multiple_of(every as usize), level, (at, i), out);
                }
            }
        }
    }
}

/// The line at a level, where it covers a part of cell `i`. Without branches: it is many cells' way at once.
#[inline(always)]
fn draw([minor, major]: &[Line; 2], is_major: bool, level: f32, (at, i): (&TexCoords, usize), out: &mut Reading) {
    let width = if is_major { major.width } else { minor.width };
    let (dx, dy) = (at.d_dx[0][i], at.d_dy[0][i]);
    let slope = (dx * dx + dy * dy).sqrt();
    let distance = (at.st[0][i] - level).abs() / slope;
    let cover = 0.5 * width + 0.5 - distance;
    let cover = if cover < width { cover } else { width };
    let cover = if cover < 1.0 { cover } else { 1.0 };
    // Where the value does not change there is no line, whatever it is: a plateau is no flood. What is missing has none.
    let is_there = (slope > 0.0) & (distance < f32::INFINITY) & (cover > 0.0);
    for c in 0..4 {
        let color = if is_major { major.color[c] } else { minor.color[c] };
        let color = if c == 3 { color * cover } else { color };
        out.rgba[c][i] = if is_there { color } else { 0.0 };
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
        let Levels::List(list) = &levels else { panic!("a list") };
        let near = [0.0, 1.4, 1.6, 3.1, 9.0].map(|v| nearest(list, v));
        assert_eq!(near, [(1.0, 0), (1.0, 0), (2.0, 1), (4.0, 2), (4.0, 2)].map(Some));
        assert_eq!(levels.within([1.5, 5.0], 9), [2.0, 4.0]);
        assert_eq!(Levels::Steps { step: 0.5, offset: 0.25 }.within([1.0, -0.3], 9), [-0.25, 0.25, 0.75]);
        assert!(nearest(&[], 1.0).is_none());
        assert_eq!(along(&lines(Levels::List(Vec::new())), 1.0, 9), [0.0; 9]);
    }
}
