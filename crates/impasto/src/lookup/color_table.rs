//! Colour tables: a number's colour, with colours of their own below, above and for missing values.

use crate::assets::Filter;
use crate::color::{LinearRgba, lab_to_linear, linear_from_bytes, linear_from_srgb};
use crate::lookup::Reading;
use crate::lookup::mixing::{self, Mix};
use crate::lookup::safe::Shades;
use crate::lookup::tables;
use crate::math::{self, BATCH, exact};
use crate::placement::TexCoords;

/// A one-dimensional texture of data: the coordinate s is the value itself.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorTable {
    /// At least one entry, in the order of the values; straight alpha.
    pub colors: Vec<LinearRgba>,
    /// The values at the first entry's outer edge and the last one's; the first may be the greater. All entries are
    /// equally wide.
    pub range: [f32; 2],
    /// How values spread over the entries: taken after interpolation, so that a value has one colour wherever it stands.
    pub scale: Scale,
    /// Whether a value has its entry's colour, or one between those of the nearest two centres (in linear light).
    pub filter: Filter,
    /// For values before the range; none: the first entry.
    pub below: Option<LinearRgba>,
    /// For values beyond the range; none: the last entry.
    pub above: Option<LinearRgba>,
    /// For NaN.
    pub missing: LinearRgba,
    /// For missing values, too: lines over `missing`, so that it is taken for no value.
    pub hatch: Option<LinearRgba>,
    /// The same colours in shadow and in light, for the second coordinate from 0 to 1; 1/2 is the table's own.
    pub shades: Option<Shades>,
}

/// How values spread over a colour table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm; what is not positive lies before every range.
    Log,
    /// By `sign(x) log(1 + |x| / linear)`: a logarithm on both sides of zero that passes it smoothly.
    SymLog {
        /// Up to about here it is linear.
        linear: f32,
    },
}

impl Scale {
    /// Where a value stands, in any unit.
    #[inline(always)]
    pub fn place(self, value: f32) -> f32 {
        match self {
            Self::Linear => value,
            Self::Log if value > 0.0 => math::log2(value),
            Self::Log if value.is_nan() => value,
            Self::Log => f32::NEG_INFINITY,
            Self::SymLog { linear } => {
                let size = math::log2(1.0 + value.abs() / linear);
                if value < 0.0 { -size } else { size }
            }
        }
    }

    /// The value at a share of a range: [`place`](Self::place) undone, for ticks and legends.
    pub fn value_at(self, share: f64, [first, last]: [f64; 2]) -> f64 {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        match self {
            Self::Linear => mix(first, last),
            Self::Log => exact::exp2(mix(exact::log2(first), exact::log2(last))),
            Self::SymLog { linear } => {
                let linear = linear as f64;
                let place = |x: f64| exact::log2(1.0 + x.abs() / linear).copysign(x);
                let p = mix(place(first), place(last));
                ((exact::exp2(p.abs()) - 1.0) * linear).copysign(p)
            }
        }
    }
}

impl ColorTable {
    /// The names of [`ColorTable::named`], as people write them; [`tables::TABLES`] tells more of each.
    pub const NAMES: [&str; tables::TABLES.len()] = tables::NAMES;

    /// A table by its name in any case, over [0, 1], nearest; `_r` or `-r` behind the name turns it round. Among them
    /// `grey` is even steps of sRGB and `coolwarm` follows Moreland, "Diverging color maps for scientific visualization",
    /// 2009.
    pub fn named(name: &str) -> Option<Self> {
        let Some(info) = tables::info(name) else {
            let forward = name.strip_suffix(['r', 'R'])?.strip_suffix(['_', '-'])?;
            return tables::info(forward).and_then(|info| Self::named(info.name)).map(|table| table.reversed());
        };
        let opaque = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
        let colors = tables::colors(info).unwrap_or_else(|| match info.name {
            "coolwarm" => (0..256).map(|i| opaque(cool_warm(i as f64 / 255.0))).collect(),
            _ => (0..=255).map(|i| opaque(linear_from_bytes([i; 3]))).collect(),
        });
        Some(Self::over([0.0, 1.0], colors))
    }

    /// `n` entries through colours at rising values, mixed in OKLab: the first entry has the first stop's colour, the last
    /// the last one's, and the range goes from the first value to the last. Two stops at one value make an edge.
    pub fn from_stops(stops: &[(f64, LinearRgba)], n: usize) -> Self {
        assert!(stops.is_sorted_by(|a, b| a.0 <= b.0), "the stops of a colour table rise");
        let colors = mixing::sampled(stops, n, Mix::OkLab);
        Self::over([stops[0].0 as f32, stops[stops.len() - 1].0 as f32], colors)
    }

    /// The colours from the other end, over the same range.
    pub fn reversed(&self) -> Self {
        let mut table = self.clone();
        table.colors.reverse();
        std::mem::swap(&mut table.below, &mut table.above);
        table
    }

    /// These colours over a range, nearest, magenta for missing values.
    pub fn over(range: [f32; 2], colors: Vec<LinearRgba>) -> Self {
        assert!(!colors.is_empty(), "a colour table needs a colour");
        let missing = [linear_from_srgb(0.9) as f32, 0.0, linear_from_srgb(0.9) as f32, 1.0];
        let (scale, filter) = (Scale::Linear, Filter::Nearest);
        Self { colors, range, scale, filter, below: None, above: None, missing, hatch: None, shades: None }
    }

    /// The table in `n` entries, from the first colour to the last: bands.
    pub fn banded(&self, n: usize) -> Self {
        let last = (self.colors.len() - 1) as f64;
        let entry = |i: usize| {
            let place = if n > 1 { last * i as f64 / (n - 1) as f64 } else { 0.5 * last };
            self.colors[(place + 0.5) as usize]
        };
        Self { colors: (0..n.max(1)).map(entry).collect(), filter: Filter::Nearest, ..self.clone() }
    }

    /// A value's colour.
    pub fn color(&self, value: f32) -> LinearRgba {
        self.in_light(self.spread(), value, 0.5)
    }

    /// What [`in_light`](Self::in_light) wants to know of the range: where it begins, and how far it goes.
    #[inline(always)]
    fn spread(&self) -> [f32; 2] {
        let [first, last] = self.range.map(|x| self.scale.place(x));
        [first, last - first]
    }

    /// A value's colour in some light.
    #[inline(always)]
    fn in_light(&self, [first, extent]: [f32; 2], value: f32, light: f32) -> LinearRgba {
        let place = self.scale.place(value) - first;
        // A range without extent: what is not below is at its end.
        let x = if extent != 0.0 { place / extent } else { place * f32::MAX };
        let n = self.colors.len();
        if x.is_nan() {
            return if value.is_nan() { self.missing } else { self.colors[0] };
        }
        if x < 0.0 {
            return self.below.unwrap_or_else(|| self.shaded(0, light));
        }
        if x > 1.0 {
            return self.above.unwrap_or_else(|| self.shaded(n - 1, light));
        }
        match self.filter {
            Filter::Nearest => self.shaded(((x * n as f32) as usize).min(n - 1), light),
            Filter::Linear => {
                let place = x * n as f32 - 0.5;
                let place = if place > 0.0 { place } else { 0.0 };
                let i = (place as usize).min(n - 1);
                let (a, b) = (self.shaded(i, light), self.shaded((i + 1).min(n - 1), light));
                std::array::from_fn(|c| a[c] + (b[c] - a[c]) * (place - i as f32))
            }
        }
    }

    #[inline(always)]
    fn shaded(&self, entry: usize, light: f32) -> LinearRgba {
        match &self.shades {
            Some(shades) => shades.color(entry, self.colors[entry], light),
            None => self.colors[entry],
        }
    }

    #[inline(always)]
    pub(super) fn read(&self, at: &TexCoords, [columns, rows]: &[[u32; BATCH]; 2], n: usize, out: &mut Reading) {
        out.is_whole = true;
        let spread = self.spread();
        for i in 0..n.min(BATCH) {
            let color = self.in_light(spread, at.st[0][i], at.st[1][i]);
            (0..4).for_each(|c| out.rgba[c][i] = color[c]);
        }
        let Some(line) = self.hatch else { return };
        for i in 0..n.min(BATCH) {
            if at.st[0][i].is_nan() && is_hatched(columns[i], rows[i]) {
                (0..4).for_each(|c| out.rgba[c][i] = line[c]);
            }
        }
    }
}

/// Where lines run that fill a shape: two cells of eight, rising to the right.
#[inline(always)]
pub fn is_hatched(column: u32, row: u32) -> bool {
    column.wrapping_add(row) % 8 < 2
}

/// Moreland's blue - light grey - red, interpolated in his polar form of CIE Lab (Msh).
fn cool_warm(x: f64) -> [f32; 3] {
    // Saturation and hue of the two ends: sRGB (59, 76, 192) and (180, 4, 38); white in the middle has M = 88.
    const BLUE: [f64; 3] = [80.0, 1.08, -1.1];
    const RED: [f64; 3] = [80.0, 1.08, 0.5];
    const WHITE: f64 = 88.0;
    // Towards white the hue turns, so that steps look equal.
    let spin = BLUE[1] * exact::pow(WHITE * WHITE - BLUE[0] * BLUE[0], 0.5) / (BLUE[0] * exact::sin(BLUE[1]));
    let (end, hue_at_white, t) = match x < 0.5 {
        true => (BLUE, BLUE[2] - spin, 2.0 * x),
        false => (RED, RED[2] + spin, 2.0 - 2.0 * x),
    };
    let mix = |a: f64, b: f64| a + (b - a) * t;
    let (m, s, h) = (mix(end[0], WHITE), mix(end[1], 0.0), mix(end[2], hue_at_white));
    let lab = [m * exact::cos(s), m * exact::sin(s) * exact::cos(h), m * exact::sin(s) * exact::sin(h)];
    linear_from_lab(lab)
}

/// CIE Lab (D65) to linear light within [0, 1].
fn linear_from_lab(lab: [f64; 3]) -> [f32; 3] {
    lab_to_linear(lab).map(|c| c.clamp(0.0, 1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::srgb8_from_linear;

    fn bytes(c: LinearRgba) -> [u8; 3] {
        [0, 1, 2].map(|k| srgb8_from_linear(c[k]))
    }

    #[test]
    fn named_tables_have_their_authors_ends() {
        let ends = |name: &str| {
            let table = ColorTable::named(name).expect("a known name");
            [0.0, 1.0].map(|x| bytes(table.color(x)))
        };
        assert_eq!(ends("viridis"), [[68, 1, 84], [253, 231, 37]]);
        assert_eq!(ends("grey"), [[0; 3], [255; 3]]);
        let [cool, warm] = ends("coolwarm");
        let close = |a: [u8; 3], b: [u8; 3]| (0..3).all(|k| a[k].abs_diff(b[k]) <= 3);
        assert!(close(cool, [59, 76, 192]) && close(warm, [180, 4, 38]), "{cool:?} {warm:?}");
        let middle = bytes(ColorTable::named("coolwarm").expect("known").color(0.5));
        assert!(close(middle, [221, 221, 221]), "{middle:?}");
        assert!(ColorTable::named("jets").is_none());
    }

    #[test]
    fn stops_are_mixed_evenly_for_the_eye() {
        let (blue, yellow) = ([0.0, 0.0, 1.0, 1.0], [1.0, 1.0, 0.0, 0.5]);
        let table = ColorTable::from_stops(&[(-1.0, blue), (3.0, yellow)], 9);
        assert_eq!((table.range, table.colors.len()), ([-1.0, 3.0], 9));
        assert_eq!((table.colors[0], table.colors[8]), (blue, yellow));
        // The mean of OKLab (0.452, -0.032, -0.312) and (0.968, -0.071, 0.199) is a bluish grey-green.
        assert!((bytes(table.colors[4]).map(i32::from)).iter().zip([108, 171, 199]).all(|(a, b)| (a - b).abs() < 6));
        assert_eq!(table.colors[4][3], 0.75);
        assert_eq!(table.reversed().colors[0], yellow);
        assert_eq!(table.reversed().reversed(), table);
    }

    #[test]
    fn values_outside_and_missing_have_their_own_colours() {
        let grey = |x: f32| [x, x, x, 1.0];
        let mut table = ColorTable::over([10.0, 30.0], vec![grey(0.25), grey(0.5), grey(1.0), grey(0.75)]);
        let of = |table: &ColorTable, value: f32| table.color(value)[0];
        assert_eq!([9.0, 10.0, 14.99, 15.0, 30.0, 31.0].map(|v| of(&table, v)), [0.25, 0.25, 0.25, 0.5, 0.75, 0.75]);
        table.below = Some(grey(7.0));
        table.above = Some(grey(8.0));
        table.missing = grey(9.0);
        assert_eq!([9.0, 10.0, 30.0, 31.0, f32::NAN].map(|v| of(&table, v)), [7.0, 0.25, 0.75, 8.0, 9.0]);
        assert_eq!(of(&table, f32::INFINITY), 8.0);
        table.filter = Filter::Linear;
        assert_eq!([12.5, 15.0, 17.5, 30.0].map(|v| of(&table, v)), [0.25, 0.375, 0.5, 0.75]);
        table.range = [30.0, 10.0];
        assert_eq!([30.0, 10.0, 31.0].map(|v| of(&table, v)), [0.25, 0.75, 7.0]);
        table.range = [5.0, 5.0];
        assert_eq!([4.0, 5.0, 6.0].map(|v| of(&table, v)), [7.0, 0.25, 8.0]);
    }
}
