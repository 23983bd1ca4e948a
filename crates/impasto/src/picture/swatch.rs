//! What colours stand for where two properties choose them: a square of colours between two axes.

use crate::color::LinearRgba;
use crate::math::{Size, vec2};
use crate::picture::drawing::{Align, Drawing, Item, Rect, Text};
use crate::picture::font::{self, Weight};
use crate::picture::legend::{Block, LegendLayout, Position, Sizes, Theme, no_value, offset_text, title_lines};
use crate::picture::numbers::{self, Notation};
use crate::picture::ticks::{LegendScale, Room, Ticks, ticks};

/// One of the two properties.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct AxisSpec {
    /// Its name.
    pub title: String,
    /// Its unit, or nothing.
    pub unit: String,
    /// How its values lie along the square's side.
    pub scale: LegendScale,
    /// The values at the square's two edges; the first may be the greater.
    pub range: [f64; 2],
    /// How large and small numbers are written.
    pub notation: Notation,
}

/// What a legend tells of two properties.
#[derive(Clone, Debug, PartialEq)]
pub struct SwatchSpec {
    /// The property from left to right, and the one from bottom to top.
    pub axes: [AxisSpec; 2],
    /// How many colours there are in a row.
    pub n_columns: usize,
    /// Rows of colours; the first is that of the second property's first values.
    pub colors: Vec<LinearRgba>,
    /// The colour of what has no value, if there is such.
    pub missing: Option<LinearRgba>,
    /// Of lines over it.
    pub hatch: Option<LinearRgba>,
    /// How much has no value, from 0 to 1.
    pub missing_share: f64,
    /// On what ground it stands.
    pub theme: Theme,
    /// At which side of the picture.
    pub position: Position,
}

impl SwatchSpec {
    /// `n` x `n` colours by their places along both axes, from 0 to 1, each taken at its middle.
    pub fn from_fn(axes: [AxisSpec; 2], n: usize, color: impl Fn(f32, f32) -> LinearRgba) -> Self {
        let at = |i: usize| (i as f32 + 0.5) / n as f32;
        let colors = (0..n * n).map(|i| color(at(i % n), at(i / n))).collect();
        let (theme, position) = (Theme::Light, Position::Right);
        Self { axes, n_columns: n, colors, missing: None, hatch: None, missing_share: 0.0, theme, position }
    }
}

/// Where a swatch stands in a picture, and how much room it takes there.
pub fn swatch_layout(spec: &SwatchSpec, picture: Size) -> LegendLayout {
    let sizes = Sizes::of(picture);
    block(spec, picture, &sizes).beside(picture, spec.position, &sizes)
}

/// A swatch on a sheet of its own, as large as a picture of this size would have it.
pub fn swatch_alone(spec: &SwatchSpec, picture: Size) -> Drawing {
    let sizes = Sizes::of(picture);
    block(spec, picture, &sizes).alone(&sizes)
}

/// The square has its top left corner at the origin.
fn block(spec: &SwatchSpec, picture: Size, sizes: &Sizes) -> Block {
    let (w, h) = (picture.width as f32, picture.height as f32);
    let side = (0.22 * w).min(0.4 * h).max(6.0 * sizes.text).round();
    let square = Rect::new(0.0, 0.0, side, side);
    let mut block = Block::default();
    let n_columns = spec.n_columns.max(1);
    let colors: Vec<LinearRgba> = spec.colors.chunks_exact(n_columns).rev().flatten().copied().collect();
    block.checkers(square, &colors, sizes);
    block.items.push(Item::Block { rect: square, n_columns, colors });
    block.frame(square, spec.theme, sizes);
    let [across, up] = [true, false].map(|is_horizontal| {
        let axis = &spec.axes[usize::from(!is_horizontal)];
        ticks(axis.scale, axis.range, axis.notation, Room { length: side, text_size: sizes.text, is_horizontal })
    });
    let bottom = marks_below(&mut block, square, &across, spec.theme, sizes);
    let left = marks_at_left(&mut block, square, &up, spec.theme, sizes);

    // The titles, along their axes.
    let mut baseline = bottom + sizes.gap + (font::CAP_HEIGHT * sizes.text).round();
    for line in axis_title(&spec.axes[0], &across, side, sizes) {
        block.title_line(&line, vec2(0.0, baseline), 0.0, spec.theme, sizes);
        baseline += sizes.line();
    }
    let lines = axis_title(&spec.axes[1], &up, side, sizes);
    let n = lines.len() as f32;
    for (i, line) in lines.iter().enumerate() {
        let x = left - sizes.gap - (n - 1.0 - i as f32) * sizes.line();
        let x = x - (font::DESCENT * sizes.text * 0.5).round();
        block.title_line(line, vec2(x, side), -std::f32::consts::FRAC_PI_2, spec.theme, sizes);
    }
    if let Some(color) = spec.missing {
        let y = baseline - (font::CAP_HEIGHT * sizes.text).round() + sizes.gap;
        let rect = Rect::new(0.0, y, (sizes.text * 1.2).round(), (sizes.text * 0.95).round());
        block.swatch(rect, (color, spec.hatch), &no_value(spec.missing_share), spec.theme, sizes);
    }
    block
}

fn axis_title(axis: &AxisSpec, ticks: &Ticks, room: f32, sizes: &Sizes) -> Vec<[String; 2]> {
    let unit = numbers::unit_text(&axis.unit, ticks.exponent, axis.notation);
    let mut lines = title_lines(&axis.title, &unit, [room, 2.0], sizes.text);
    if ticks.offset != 0.0 {
        lines.push([String::new(), font::shortened(&offset_text(ticks), room, sizes.text, Weight::Regular)]);
    }
    lines
}

/// Ticks and numbers below the square; where the next thing may stand.
fn marks_below(block: &mut Block, square: Rect, ticks: &Ticks, theme: Theme, sizes: &Sizes) -> f32 {
    let y = square.max.y + sizes.hairline;
    let end = y + sizes.tick + sizes.gap + (font::CAP_HEIGHT * sizes.text).round();
    for tick in &ticks.major {
        let x = (tick.position as f32 * square.width() - 0.5 * sizes.hairline + 0.5).floor();
        block.items.push(Item::Rect { rect: Rect::new(x, y, sizes.hairline, sizes.tick), color: theme.ink() });
        let at = vec2(x + 0.5 * sizes.hairline, end);
        block.text(Text { align: Align::Middle, ..Text::new(&tick.label, at, sizes.text, theme.ink()) });
    }
    end + (font::DESCENT * sizes.text).round()
}

/// Ticks and numbers at the square's left; where the next thing may stand.
fn marks_at_left(block: &mut Block, square: Rect, ticks: &Ticks, theme: Theme, sizes: &Sizes) -> f32 {
    let x = -sizes.hairline - sizes.tick;
    let mut left = x;
    for tick in &ticks.major {
        let y = (square.max.y - tick.position as f32 * square.height() - 0.5 * sizes.hairline + 0.5).floor();
        block.items.push(Item::Rect { rect: Rect::new(x, y, sizes.tick, sizes.hairline), color: theme.ink() });
        let mut text = Text::new(&tick.label, vec2(x - sizes.gap, y + 0.5 * sizes.hairline), sizes.text, theme.ink());
        (text.align, text.is_centered) = (Align::End, true);
        left = left.min(text.at.x - text.width());
        block.text(text);
    }
    left.floor()
}
