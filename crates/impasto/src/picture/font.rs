//! Text to outlines: one embedded font in two weights, kerned, with tabular figures.
//!
//! The font is a part of Source Sans 3 under the SIL Open Font Licence (`font/README.md`).

use crate::math::{Vec2, vec2};
use std::sync::LazyLock;
use ttf_parser::gpos::{PairAdjustment, PositioningSubtable};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// How heavy the strokes are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Weight {
    /// For numbers and running text.
    #[default]
    Regular,
    /// For titles.
    SemiBold,
}

/// Height of capitals and figures, in text sizes.
pub const CAP_HEIGHT: f32 = 0.65;
/// Height of an x, in text sizes.
pub const X_HEIGHT: f32 = 0.486;
/// How far letters without accents reach above the baseline, in text sizes.
pub const ASCENT: f32 = 0.73;
/// How far letters reach below the baseline, in text sizes.
pub const DESCENT: f32 = 0.21;

/// A piece of an outline. Pixels, y down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// Begins a contour.
    Move(Vec2),
    /// A straight line to a point.
    Line(Vec2),
    /// A quadratic curve: control point and end.
    Quad(Vec2, Vec2),
    /// Ends a contour where it began.
    Close,
}

struct Font {
    face: Face<'static>,
    units_per_em: f32,
}

static REGULAR: LazyLock<Font> = LazyLock::new(|| Font::new(include_bytes!("font/ImpastoSans-Regular.ttf")));
static SEMI_BOLD: LazyLock<Font> = LazyLock::new(|| Font::new(include_bytes!("font/ImpastoSans-SemiBold.ttf")));

fn font(weight: Weight) -> &'static Font {
    match weight {
        Weight::Regular => &REGULAR,
        Weight::SemiBold => &SEMI_BOLD,
    }
}

impl Font {
    fn new(bytes: &'static [u8]) -> Self {
        let face = Face::parse(bytes, 0).expect("the embedded font is a font");
        let units_per_em = face.units_per_em() as f32;
        Self { face, units_per_em }
    }

    /// Glyphs and where they begin, and where the next one would; font units.
    fn place(&self, text: &str) -> (Vec<(GlyphId, f32)>, f32) {
        let mut glyphs = Vec::with_capacity(text.len());
        let mut x = 0.0;
        let mut before: Option<(char, GlyphId)> = None;
        for c in text.chars() {
            let c = if c.is_control() { ' ' } else { c };
            // Glyph 0 is an empty box: a letter that the font lacks stays visible.
            let glyph = self.face.glyph_index(c).unwrap_or_default();
            if let Some((b, left)) = before {
                // Columns of figures stay columns.
                let are_figures = b.is_ascii_digit() && c.is_ascii_digit();
                x += if are_figures { 0.0 } else { self.kerning(left, glyph) };
            }
            glyphs.push((glyph, x));
            x += self.face.glyph_hor_advance(glyph).unwrap_or(0) as f32;
            before = Some((c, glyph));
        }
        (glyphs, x)
    }

    /// What to add between two glyphs, font units. All positioning that the file has is kerning of pairs.
    fn kerning(&self, left: GlyphId, right: GlyphId) -> f32 {
        let Some(gpos) = self.face.tables().gpos else { return 0.0 };
        let lookups = gpos.lookups.into_iter();
        lookups.map(|lookup| lookup.subtables.into_iter().find_map(|t| pair(t, left, right)).unwrap_or(0.0)).sum()
    }
}

/// A subtable's adjustment of a pair, if it speaks of it.
fn pair(subtable: PositioningSubtable, left: GlyphId, right: GlyphId) -> Option<f32> {
    let PositioningSubtable::Pair(pairs) = subtable else { return None };
    let i = pairs.coverage().get(left)?;
    let (first, _) = match pairs {
        PairAdjustment::Format1 { sets, .. } => sets.get(i)?.get(right)?,
        PairAdjustment::Format2 { classes, matrix, .. } => matrix.get((classes.0.get(left), classes.1.get(right)))?,
    };
    Some(first.x_advance as f32)
}

/// How wide a line of text is, pixels; `size` is the em in pixels.
pub fn width(text: &str, size: f32, weight: Weight) -> f32 {
    let font = font(weight);
    font.place(text).1 * (size / font.units_per_em)
}

/// `text` cut to `room` pixels: whole if it fits, else with an ellipsis at its end.
pub fn shortened(text: &str, room: f32, size: f32, weight: Weight) -> String {
    if width(text, size, weight) <= room {
        return text.to_owned();
    }
    let ends: Vec<usize> = text.char_indices().map(|(i, _)| i).collect();
    let cut = |i: usize| format!("{}…", text[..i].trim_end());
    ends.into_iter().rev().map(cut).find(|s| width(s, size, weight) <= room).unwrap_or_default()
}

/// The outlines of a line of text, filled by the nonzero rule. Its baseline begins at the origin; pixels, y down.
///
/// With `is_fitted` the heights of letters come to lie on whole pixels, which keeps small upright text crisp.
pub fn outline(text: &str, size: f32, weight: Weight, is_fitted: bool) -> Vec<Segment> {
    let font = font(weight);
    let scale = size / font.units_per_em;
    let heights = if is_fitted { Heights::fitted(size) } else { Heights::plain() };
    let mut pen = Pen { segments: Vec::new(), x: 0.0, scale, size, heights };
    for (glyph, x) in font.place(text).0 {
        pen.x = x * scale;
        font.face.outline_glyph(glyph, &mut pen);
    }
    pen.segments
}

/// Where heights above the baseline go: straight between knots, in text sizes and pixels.
struct Heights(Vec<[f32; 2]>);

impl Heights {
    /// Bottoms and tops of letters, those of flat and round ones together, in text sizes.
    const ZONES: [[f32; 2]; 3] = [[-0.012, 0.0], [X_HEIGHT, 0.499], [0.638, 0.668]];

    fn plain() -> Self {
        Self(Vec::new())
    }

    /// Each zone on a whole pixel: at these sizes what round letters reach beyond flat ones is less than one.
    fn fitted(size: f32) -> Self {
        // A tall x is easier to read than a low one.
        let nearest = |low: f32, high: f32| (0.5 * (low + high) * size + 0.6).floor();
        let knots = Self::ZONES.map(|[low, high]| {
            let y = if low < 0.0 { 0.0 } else { nearest(low, high) };
            [[low, y], [high, y]]
        });
        Self(knots.as_flattened().to_vec())
    }

    /// Pixels above the baseline.
    fn at(&self, height: f32, size: f32) -> f32 {
        let Some(last) = self.0.last() else { return height * size };
        if height < self.0[0][0] {
            return self.0[0][1] + (height - self.0[0][0]) * size;
        }
        let span = self.0.windows(2).find(|k| height <= k[1][0]);
        let Some(&[[h0, y0], [h1, y1]]) = span.and_then(|k| k.as_array()) else {
            return last[1] + (height - last[0]) * size;
        };
        y0 + (y1 - y0) * ((height - h0) / (h1 - h0))
    }
}

/// Takes a glyph's outline in font units, y up.
struct Pen {
    segments: Vec<Segment>,
    x: f32,
    scale: f32,
    size: f32,
    heights: Heights,
}

impl Pen {
    fn point(&self, x: f32, y: f32) -> Vec2 {
        vec2(self.x + x * self.scale, -self.heights.at(y * self.scale / self.size, self.size))
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.segments.push(Segment::Move(self.point(x, y)));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.segments.push(Segment::Line(self.point(x, y)));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.segments.push(Segment::Quad(self.point(x1, y1), self.point(x, y)));
    }

    /// The font has quadratic curves only.
    fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, x: f32, y: f32) {
        self.line_to(x, y);
    }

    fn close(&mut self) {
        self.segments.push(Segment::Close);
    }
}

/// Outlines as closed polygons, no further than a 20th of a pixel from the curves.
pub fn flatten(segments: &[Segment]) -> Vec<Vec<Vec2>> {
    let mut contours: Vec<Vec<Vec2>> = Vec::new();
    for segment in segments {
        match *segment {
            Segment::Move(p) => contours.push(vec![p]),
            Segment::Line(p) => contours.last_mut().into_iter().for_each(|c| c.push(p)),
            Segment::Quad(control, end) => {
                let Some(contour) = contours.last_mut() else { continue };
                let start = *contour.last().expect("a contour begins with a point");
                // A parabola's distance from its chord is a quarter of its second difference.
                let bend = (start - control * 2.0 + end).length() * 0.25;
                let n = (bend / 0.05).sqrt().ceil().clamp(1.0, 64.0) as u32;
                for i in 1..=n {
                    let t = i as f32 / n as f32;
                    let (a, b) = (start + (control - start) * t, control + (end - control) * t);
                    contour.push(if i == n { end } else { a + (b - a) * t });
                }
            }
            Segment::Close => {}
        }
    }
    contours
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_and_signs_share_a_width() {
        for weight in [Weight::Regular, Weight::SemiBold] {
            let zero = width("0", 100.0, weight);
            for c in "123456789−+×".chars() {
                assert_eq!(width(&c.to_string(), 100.0, weight), zero, "{c}");
            }
            assert_eq!(width("1174", 10.0, weight), width("8888", 10.0, weight));
        }
    }

    #[test]
    fn every_promised_letter_is_there() {
        let text = "AZaz09~ÄéßÿαωΑΩ⁰¹²³⁴⁵⁶⁷⁸⁹⁻µ°·×−–—…∞≤≥√Å‰";
        for weight in [Weight::Regular, Weight::SemiBold] {
            for c in text.chars() {
                assert!(font(weight).face.glyph_index(c).is_some(), "{c}");
                assert!(!outline(&c.to_string(), 10.0, weight, false).is_empty(), "{c}");
            }
        }
        // A letter that is not there is a box, not nothing.
        assert!(!outline("漢", 10.0, Weight::Regular, false).is_empty());
    }

    #[test]
    fn pairs_are_kerned() {
        let w = |s| width(s, 1000.0, Weight::Regular);
        assert!(w("AV") < w("A") + w("V") - 10.0);
        assert!(w("To") < w("T") + w("o") - 10.0);
        assert_eq!(w("HH"), w("H") * 2.0);
    }

    #[test]
    fn fitted_letters_end_on_whole_pixels() {
        for size in [9.0, 10.0, 11.0, 13.5, 16.0, 24.0] {
            for (text, height) in [("x", X_HEIGHT), ("H", CAP_HEIGHT), ("E", CAP_HEIGHT)] {
                let top = flatten(&outline(text, size, Weight::Regular, true))
                    .concat()
                    .iter()
                    .fold(0.0f32, |top, p| top.max(-p.y));
                let off = (top - top.round()).abs();
                assert!(off < 1e-3 && (top - height * size).abs() < 0.8, "{text} at {size}: {top}");
            }
        }
    }

    #[test]
    fn long_text_ends_in_an_ellipsis() {
        let short = |room| shortened("wall shear stress", room, 10.0, Weight::Regular);
        assert_eq!(short(1000.0), "wall shear stress");
        let cut = short(40.0);
        assert!(cut.ends_with('…') && width(&cut, 10.0, Weight::Regular) <= 40.0, "{cut}");
        assert_eq!(short(1.0), "");
    }
}
