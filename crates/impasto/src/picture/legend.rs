//! What colours stand for: a bar with ticks, a title and a unit, and swatches for values outside and for none.
//!
//! Sizes follow the picture's: text is a 45th of its height, the bar 60 % of it. Nothing is written over anything else.

use crate::color::{LinearRgb, LinearRgba, linear_from_bytes};
use crate::lookup::is_hatched;
use crate::math::{Size, Vec2, vec2};
use crate::picture::drawing::{Align, Direction, Drawing, Item, Rect, Text};
use crate::picture::font::{self, Weight};
use crate::picture::numbers::{self, Notation};
pub use crate::picture::ticks::LegendScale;
use crate::picture::ticks::{Room, Ticks, band_edges, ticks};

/// On what ground a legend stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Theme {
    /// Dark letters for a light ground.
    #[default]
    Light,
    /// Light letters for a dark ground.
    Dark,
}

impl Theme {
    /// The colour of letters and ticks.
    pub fn ink(self) -> LinearRgba {
        opaque(match self {
            Self::Light => [38, 38, 42],
            Self::Dark => [226, 226, 222],
        })
    }

    /// The colour of units and remarks.
    pub fn soft_ink(self) -> LinearRgba {
        opaque(match self {
            Self::Light => [92, 92, 98],
            Self::Dark => [168, 168, 166],
        })
    }

    /// The colour of what text is kept free from: its halo.
    pub fn paper(self) -> LinearRgba {
        opaque(match self {
            Self::Light => [255, 255, 255],
            Self::Dark => [16, 17, 20],
        })
    }
}

fn opaque(srgb: [u8; 3]) -> LinearRgba {
    let [r, g, b]: LinearRgb = linear_from_bytes(srgb);
    [r, g, b, 1.0]
}

/// An isoline's mark across the bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegendLine {
    /// Its level.
    pub value: f64,
    /// Whether it is drawn half as thick again.
    pub is_major: bool,
    /// Its colour.
    pub color: LinearRgba,
}

/// What a legend tells of one property.
#[derive(Clone, Debug, PartialEq)]
pub struct LegendSpec {
    /// The property's name.
    pub title: String,
    /// Its unit, or nothing.
    pub unit: String,
    /// How values lie along the bar.
    pub scale: LegendScale,
    /// The values at the first entry's outer edge and at the last one's; the first may be the greater.
    pub range: [f64; 2],
    /// The entries from first to last, equally wide; at least one.
    pub colors: Vec<LinearRgba>,
    /// Whether a value's colour lies between those of the nearest two entries' centres.
    pub is_smooth: bool,
    /// Into how many equal bands the bar is cut, each with the colour of its middle; numbers stand at their edges.
    pub bands: Option<u32>,
    /// Isolines.
    pub lines: Vec<LegendLine>,
    /// The colour below the range, if it has one of its own.
    pub below: Option<LinearRgba>,
    /// The colour above the range, if it has one of its own.
    pub above: Option<LinearRgba>,
    /// The colour of what has no value, if there is such.
    pub missing: Option<LinearRgba>,
    /// Of lines over it.
    pub hatch: Option<LinearRgba>,
    /// How much has no value, from 0 to 1.
    pub missing_share: f64,
    /// How large and small numbers are written.
    pub notation: Notation,
    /// On what ground it stands.
    pub theme: Theme,
    /// At which side of the picture.
    pub position: Position,
}

/// At which side of the picture a legend stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Position {
    /// Upright at the right.
    #[default]
    Right,
    /// Upright at the left.
    Left,
    /// Lying at the bottom.
    Bottom,
}

impl LegendSpec {
    /// A smooth linear bar on light ground at the right, without anything special.
    pub fn new(title: impl Into<String>, unit: impl Into<String>, range: [f64; 2], colors: Vec<LinearRgba>) -> Self {
        Self {
            title: title.into(),
            unit: unit.into(),
            scale: LegendScale::Linear,
            range,
            colors,
            is_smooth: true,
            bands: None,
            lines: Vec::new(),
            below: None,
            above: None,
            missing: None,
            hatch: None,
            missing_share: 0.0,
            notation: Notation::Auto,
            theme: Theme::Light,
            position: Position::Right,
        }
    }

    /// The colour so far along the bar, from 0 to 1.
    fn color(&self, position: f32) -> LinearRgba {
        let n = self.colors.len();
        if n == 0 {
            return [0.0; 4];
        }
        let place = position.clamp(0.0, 1.0) * n as f32;
        if !self.is_smooth {
            return self.colors[(place as usize).min(n - 1)];
        }
        let place = (place - 0.5).max(0.0);
        let i = (place as usize).min(n - 1);
        let (a, b) = (self.colors[i], self.colors[(i + 1).min(n - 1)]);
        std::array::from_fn(|c| a[c] + (b[c] - a[c]) * (place - i as f32))
    }

    /// The colours of a bar that is `n` pixels long.
    fn pixels(&self, n: usize) -> Vec<LinearRgba> {
        let at = |i: usize| (i as f32 + 0.5) / n as f32;
        let band = |t: f32| match self.bands {
            Some(b) if b > 0 => ((t * b as f32).floor() + 0.5) / b as f32,
            _ => t,
        };
        (0..n).map(|i| self.color(band(at(i)))).collect()
    }

    fn ticks(&self, room: Room) -> Ticks {
        match self.bands {
            Some(n) if n > 0 => band_edges(self.scale, self.range, n, self.notation, room),
            _ => ticks(self.scale, self.range, self.notation, room),
        }
    }
}

/// A legend beside a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct LegendLayout {
    /// To be painted over the whole picture.
    pub drawing: Drawing,
    /// How many pixels at the legend's side the picture keeps clear: columns, or rows at the bottom.
    pub width: u32,
    /// Its side.
    pub position: Position,
}

/// Where a legend stands in a picture, and how much room it takes there.
pub fn layout(spec: &LegendSpec, picture: Size) -> LegendLayout {
    let sizes = Sizes::of(picture);
    Block::new(spec, picture, &sizes).beside(picture, spec.position, &sizes)
}

/// A legend on a sheet of its own, as large as a picture of this size would have it, cut to what it needs.
pub fn legend_alone(spec: &LegendSpec, picture: Size) -> Drawing {
    let sizes = Sizes::of(picture);
    Block::new(spec, picture, &sizes).alone(&sizes)
}

/// Lengths that follow from a picture's size; whole pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    /// The em of all text.
    pub(super) text: f32,
    /// Around the legend.
    pub(super) margin: f32,
    /// Of frames and ticks.
    pub(super) hairline: f32,
    /// From the bar outwards.
    pub(super) tick: f32,
    /// Between things that belong together.
    pub(super) gap: f32,
}

impl Sizes {
    pub(super) fn of(picture: Size) -> Self {
        // Wide and low pictures have room for larger text than high and narrow ones.
        let text = (picture.height as f32 / 45.0).min(picture.width as f32 / 40.0).max(10.0).round();
        let part = |share: f32| (text * share).round();
        Self { text, margin: part(1.0), hairline: part(0.06).max(1.0), tick: part(0.32), gap: part(0.4) }
    }

    /// From baseline to baseline.
    pub(super) fn line(&self) -> f32 {
        (self.text * 1.25).round()
    }
}

/// A colour, and that of lines over it.
pub(super) type Fill = (LinearRgba, Option<LinearRgba>);

/// Items about an origin, and the room they take.
#[derive(Default)]
pub(super) struct Block {
    pub(super) items: Vec<Item>,
    pub(super) bounds: Rect,
}

impl Block {
    fn new(spec: &LegendSpec, picture: Size, sizes: &Sizes) -> Self {
        let mut block = Self::default();
        match spec.position {
            Position::Right | Position::Left => block.upright(spec, picture, sizes),
            Position::Bottom => block.lying(spec, picture, sizes),
        }
        block
    }

    /// Placed in a picture, half way along its side.
    pub(super) fn beside(self, picture: Size, position: Position, sizes: &Sizes) -> LegendLayout {
        let (extent, margin) = ((self.bounds.max - self.bounds.min).ceil(), sizes.margin);
        let (w, h) = (picture.width as f32, picture.height as f32);
        let middle = |whole: f32, part: f32| (0.5 * (whole - part)).floor().max(0.0);
        let (corner, width, side) = match position {
            Position::Right => (vec2(w - margin - extent.x, middle(h, extent.y)), extent.x, picture.width),
            Position::Left => (vec2(margin, middle(h, extent.y)), extent.x, picture.width),
            Position::Bottom => (vec2(middle(w, extent.x), h - margin - extent.y), extent.y, picture.height),
        };
        let width = ((width + 2.0 * margin) as u32).min(side);
        let by = (corner - self.bounds.min).floor();
        LegendLayout { drawing: Drawing { size: picture, items: self.moved(by) }, width, position }
    }

    /// Placed on a sheet of its own.
    pub(super) fn alone(self, sizes: &Sizes) -> Drawing {
        let extent = (self.bounds.max - self.bounds.min).ceil() + 2.0 * sizes.margin;
        let by = (Vec2::splat(sizes.margin) - self.bounds.min).floor();
        Drawing { size: Size::new(extent.x as u32, extent.y as u32), items: self.moved(by) }
    }

    fn moved(self, by: Vec2) -> Vec<Item> {
        self.items.into_iter().map(|item| item.moved(by)).collect()
    }

    /// The title, then the bar with its numbers on the right, then remarks.
    fn upright(&mut self, spec: &LegendSpec, picture: Size, sizes: &Sizes) {
        let Sizes { text, .. } = *sizes;
        let swatch = (text * 0.95).round();
        // Its remark keeps a line's distance from the number at the bar's end.
        let apart = (text * 0.65).round();
        let width = (0.025 * picture.width as f32).round().max(10.0);
        let has = |color: Option<LinearRgba>| if color.is_some() { 1.0 } else { 0.0 };
        let n_swatches = has(spec.below) + has(spec.above) + has(spec.missing);
        // The bar gives way where title and swatches need the height.
        let room_for_text = (0.24 * picture.width as f32 - 2.0 * sizes.margin).max(8.0 * text);
        let most_lines = if picture.height < 300 { 2 } else { 3 };
        let mut length = (0.6 * picture.height as f32).round();
        let free = picture.height as f32 - 2.0 * sizes.margin - n_swatches * (swatch + apart);
        length = length.min(free - (most_lines as f32 + 1.0) * sizes.line()).max(3.0 * text);
        let ticks = spec.ticks(Room { length, text_size: text, is_horizontal: false });

        let y = self.header(spec, &ticks, sizes, [room_for_text, most_lines as f32]);
        let mut y = if y > 0.0 { y + (0.5 * text).round() } else { y };
        if let Some(color) = spec.above {
            self.swatch(Rect::new(0.0, y, width, swatch), (color, None), &beyond(spec, true), spec.theme, sizes);
            y += swatch + apart;
        }
        let bar = Rect::new(0.0, y, width, length);
        self.bar(bar, Direction::Up, spec, sizes);
        self.marks_at_right(bar, &ticks, spec, sizes);
        y += length + apart;
        if let Some(color) = spec.below {
            self.swatch(Rect::new(0.0, y, width, swatch), (color, None), &beyond(spec, false), spec.theme, sizes);
            y += swatch + apart;
        }
        if let Some(color) = spec.missing {
            let label = no_value(spec.missing_share);
            self.swatch(Rect::new(0.0, y, width, swatch), (color, spec.hatch), &label, spec.theme, sizes);
        }
    }

    /// The title, then the bar with its numbers below and swatches at its ends.
    fn lying(&mut self, spec: &LegendSpec, picture: Size, sizes: &Sizes) {
        let Sizes { text, gap, .. } = *sizes;
        let height = (0.025 * picture.height as f32).round().max(10.0);
        let mut length = (0.6 * picture.width as f32).round();
        let label_width = |s: &str| font::width(s, text, Weight::Regular) + sizes.tick + gap;
        // Swatches with their remarks stand in a row on the right of the bar and its last number.
        let swatches: Vec<(Fill, String)> = [
            spec.below.map(|c| ((c, None), beyond(spec, false))),
            spec.above.map(|c| ((c, None), beyond(spec, true))),
            spec.missing.map(|c| ((c, spec.hatch), no_value(spec.missing_share))),
        ]
        .into_iter()
        .flatten()
        .collect();
        let needed: f32 = swatches.iter().map(|(_, s)| height + label_width(s) + 2.0 * gap).sum();
        let free = picture.width as f32 - 2.0 * sizes.margin;
        length = length.min(free).max(8.0 * text);
        let ticks = spec.ticks(Room { length, text_size: text, is_horizontal: true });
        let y = self.header(spec, &ticks, sizes, [length, 1.0]) + gap;
        let bar = Rect::new(0.0, y, length, height);
        self.bar(bar, Direction::Right, spec, sizes);
        self.marks_below(bar, &ticks, spec, sizes);
        let below_numbers = y + height + sizes.tick + gap + text + gap;
        let fits_beside = length + 2.0 * text + needed <= free;
        let (mut x, y) = if fits_beside { (length + 2.0 * text, y) } else { (0.0, below_numbers) };
        for (fill, label) in swatches {
            self.swatch(Rect::new(x, y, height, height), fill, &label, spec.theme, sizes);
            x += height + label_width(&label) + 2.0 * gap;
        }
    }

    /// Title, unit and offset from the origin down; where the next thing may stand.
    fn header(&mut self, spec: &LegendSpec, ticks: &Ticks, sizes: &Sizes, [room, n_lines]: [f32; 2]) -> f32 {
        let unit = numbers::unit_text(&spec.unit, ticks.exponent, spec.notation);
        let mut lines = title_lines(&spec.title, &unit, [room, n_lines], sizes.text);
        if ticks.offset != 0.0 {
            let offset = offset_text(ticks);
            lines.push([String::new(), font::shortened(&offset, room, sizes.text, Weight::Regular)]);
        }
        let mut baseline = (font::CAP_HEIGHT * sizes.text).round();
        for line in &lines {
            self.title_line(line, vec2(0.0, baseline), 0.0, spec.theme, sizes);
            baseline += sizes.line();
        }
        if lines.is_empty() { 0.0 } else { baseline - sizes.line() + (font::DESCENT * sizes.text).ceil() }
    }

    /// A line of a title with its unit, from a point of its baseline on.
    pub(super) fn title_line(&mut self, line: &[String; 2], at: Vec2, angle: f32, theme: Theme, sizes: &Sizes) {
        let mut title = Text { angle, ..Text::new(&line[0], at, sizes.text, theme.ink()) };
        title.weight = Weight::SemiBold;
        let space = if line[0].is_empty() { 0.0 } else { SPACE * sizes.text };
        let along = (title.width() + space).round();
        let at = if angle == 0.0 { at + vec2(along, 0.0) } else { at - vec2(0.0, along) };
        self.text(title);
        self.text(Text { angle, ..Text::new(&line[1], at, sizes.text, theme.soft_ink()) });
    }

    /// The colours with their frame and isolines.
    fn bar(&mut self, bar: Rect, direction: Direction, spec: &LegendSpec, sizes: &Sizes) {
        let length = if direction == Direction::Up { bar.height() } else { bar.width() };
        let colors = spec.pixels(length as usize);
        self.checkers(bar, &colors, sizes);
        self.items.push(Item::Strip { rect: bar, direction, colors });
        let at = |line: &LegendLine| spec.scale.position(line.value, spec.range) as f32 * length;
        let lines = spec.lines.iter().filter(|l| at(l) > sizes.hairline && at(l) < length - sizes.hairline);
        // Where lines crowd only the major ones are left.
        let n_lines = lines.clone().count() as f32;
        let is_crowded = n_lines * 4.0 * sizes.hairline > length;
        for line in lines.filter(|l| l.is_major || !is_crowded) {
            let width = if line.is_major { (sizes.hairline * 1.5).ceil() } else { sizes.hairline };
            let rect = match direction {
                Direction::Up => {
                    let (low, high) = tick_rows(bar.max.y - at(line), width);
                    Rect { min: vec2(bar.min.x, low), max: vec2(bar.max.x, high) }
                }
                Direction::Right => {
                    let (low, high) = tick_rows(bar.min.x + at(line), width);
                    Rect { min: vec2(low, bar.min.y), max: vec2(high, bar.max.y) }
                }
            };
            self.items.push(Item::Rect { rect, color: line.color });
        }
        self.frame(bar, spec.theme, sizes);
    }

    /// Squares behind colours that let through.
    pub(super) fn checkers(&mut self, rect: Rect, colors: &[LinearRgba], sizes: &Sizes) {
        if colors.iter().all(|c| c[3] > 0.999) {
            return;
        }
        let cell = (0.35 * sizes.text).max(3.0);
        let (n_columns, n_rows) = ((rect.width() / cell).ceil() as usize, (rect.height() / cell).ceil() as usize);
        let tone = |i: usize| if (i % n_columns + i / n_columns).is_multiple_of(2) { 0.95 } else { 0.6 };
        let colors = (0..n_columns * n_rows).map(|i| [tone(i), tone(i), tone(i), 1.0]).collect();
        self.items.push(Item::Block { rect, n_columns, colors });
    }

    pub(super) fn frame(&mut self, rect: Rect, theme: Theme, sizes: &Sizes) {
        self.items.push(Item::Frame { rect, width: sizes.hairline, color: theme.ink() });
        self.grow(rect.grown(sizes.hairline));
    }

    /// Ticks and numbers beside an upright bar.
    fn marks_at_right(&mut self, bar: Rect, ticks: &Ticks, spec: &LegendSpec, sizes: &Sizes) {
        let ink = spec.theme.ink();
        let x = bar.max.x + sizes.hairline;
        let mut mark = |position: f64, length: f32| {
            let (low, high) = tick_rows(bar.max.y - position as f32 * bar.height(), sizes.hairline);
            let rect = Rect { min: vec2(x, low), max: vec2(x + length, high) };
            self.items.push(Item::Rect { rect, color: ink });
            0.5 * (low + high)
        };
        ticks.minor.iter().for_each(|p| {
            mark(*p, (sizes.tick * 0.5).ceil());
        });
        let ys: Vec<f32> = ticks.major.iter().map(|t| mark(t.position, sizes.tick)).collect();
        let widths = ticks.major.iter().map(|t| font::width(&t.label, sizes.text, Weight::Regular));
        let column = widths.fold(0.0, f32::max).ceil();
        let left = x + sizes.tick + sizes.gap;
        for (tick, y) in ticks.major.iter().zip(ys) {
            let at = vec2(if ticks.is_column { left + column } else { left }, y);
            let mut text = Text::new(&tick.label, at, sizes.text, ink);
            text.align = if ticks.is_column { Align::End } else { Align::Start };
            text.is_centered = true;
            self.text(text);
        }
    }

    /// Ticks and numbers below a lying bar.
    fn marks_below(&mut self, bar: Rect, ticks: &Ticks, spec: &LegendSpec, sizes: &Sizes) {
        let ink = spec.theme.ink();
        let y = bar.max.y + sizes.hairline;
        let mut mark = |position: f64, length: f32| {
            let (low, high) = tick_rows(bar.min.x + position as f32 * bar.width(), sizes.hairline);
            let rect = Rect { min: vec2(low, y), max: vec2(high, y + length) };
            self.items.push(Item::Rect { rect, color: ink });
            0.5 * (low + high)
        };
        ticks.minor.iter().for_each(|p| {
            mark(*p, (sizes.tick * 0.5).ceil());
        });
        let xs: Vec<f32> = ticks.major.iter().map(|t| mark(t.position, sizes.tick)).collect();
        let baseline = y + sizes.tick + sizes.gap + (font::CAP_HEIGHT * sizes.text).round();
        for (tick, x) in ticks.major.iter().zip(xs) {
            let mut text = Text::new(&tick.label, vec2(x, baseline), sizes.text, ink);
            text.align = Align::Middle;
            self.text(text);
        }
    }

    /// A framed colour with a remark on its right.
    pub(super) fn swatch(&mut self, rect: Rect, (color, hatch): Fill, label: &str, theme: Theme, sizes: &Sizes) {
        self.checkers(rect, &[color], sizes);
        self.items.push(Item::Rect { rect, color });
        if let Some(line) = hatch {
            let [n_columns, n_rows] = [rect.width(), rect.height()].map(|x| x as u32);
            let clear = [line[0], line[1], line[2], 0.0];
            let color = |i: u32| if is_hatched(i % n_columns, i / n_columns) { line } else { clear };
            let colors = (0..n_columns * n_rows).map(color).collect();
            self.items.push(Item::Block { rect, n_columns: n_columns as usize, colors });
        }
        self.frame(rect, theme, sizes);
        let x = rect.max.x + sizes.hairline + sizes.tick + sizes.gap;
        let at = vec2(x, 0.5 * (rect.min.y + rect.max.y));
        let mut text = Text::new(label, at, sizes.text, theme.soft_ink());
        text.is_centered = true;
        self.text(text);
    }

    pub(super) fn text(&mut self, text: Text) {
        if !text.content.is_empty() {
            self.grow(text.bounds());
            self.items.push(Item::Text(text));
        }
    }

    pub(super) fn grow(&mut self, rect: Rect) {
        self.bounds = self.bounds.union(&rect);
    }
}

/// The rows, or columns, of a tick about a place: whole pixels, so that all ticks are equally sharp.
fn tick_rows(place: f32, width: f32) -> (f32, f32) {
    let low = (place - 0.5 * width + 0.5).floor();
    (low, low + width)
}

/// What stands beside the swatch for values that are off one end.
fn beyond(spec: &LegendSpec, is_last: bool) -> String {
    let value = spec.range[usize::from(is_last)];
    let is_greater = is_last == (spec.range[0] <= spec.range[1]);
    format!("{} {}", if is_greater { '>' } else { '<' }, numbers::single(value, 4, spec.notation))
}

pub(super) fn no_value(share: f64) -> String {
    match share * 100.0 {
        p if p.is_nan() || p <= 0.0 => "no value".to_owned(),
        p if p < 0.1 => "no value < 0.1 %".to_owned(),
        p => format!("no value {} %", numbers::single(p, if p < 10.0 { 2 } else { 3 }, Notation::Plain)),
    }
}

/// Between a title and its unit, in text sizes.
const SPACE: f32 = 0.35;

/// A title in lines, each with what of the unit stands behind it: the unit follows on the last line if it has room there.
pub(super) fn title_lines(title: &str, unit: &str, [room, n_lines]: [f32; 2], size: f32) -> Vec<[String; 2]> {
    let unit = if unit.is_empty() || unit.starts_with('×') { unit.to_owned() } else { format!("[{unit}]") };
    let unit = font::shortened(&unit, room, size, Weight::Regular);
    let unit_width = font::width(&unit, size, Weight::Regular);
    let mut lines: Vec<[String; 2]> =
        wrapped(title, room, size, n_lines as usize).into_iter().map(|l| [l, String::new()]).collect();
    match lines.last_mut() {
        _ if unit.is_empty() => {}
        Some([line, end]) if font::width(line, size, Weight::SemiBold) + SPACE * size + unit_width <= room => {
            *end = unit
        }
        _ => lines.push([String::new(), unit]),
    }
    lines
}

/// "+ 1 000 000", in the unit that labels have.
pub(super) fn offset_text(ticks: &Ticks) -> String {
    let sign = if ticks.offset < 0.0 { '−' } else { '+' };
    format!("{sign} {}", grouped(ticks.offset.abs() / numbers::power_of_ten(ticks.exponent)))
}

/// A large number in groups of three figures.
fn grouped(value: f64) -> String {
    let text = numbers::single(value, 17, Notation::Plain);
    let (whole, rest) = text.split_once('.').unwrap_or((&text, ""));
    if !whole.bytes().all(|b| b.is_ascii_digit()) {
        return text;
    }
    let n = whole.len();
    let parts = whole.chars().enumerate().flat_map(|(i, c)| {
        let space = (i > 0 && (n - i).is_multiple_of(3)).then_some('\u{2009}');
        space.into_iter().chain([c])
    });
    let point = if rest.is_empty() { "" } else { "." };
    parts.chain(point.chars()).chain(rest.chars()).collect()
}

/// Text in lines no wider than `room`, broken at spaces and after other signs between words; the last is shortened.
pub(super) fn wrapped(text: &str, room: f32, size: f32, n_lines: usize) -> Vec<String> {
    let fits = |s: &str| font::width(s.trim_end(), size, Weight::SemiBold) <= room;
    let mut lines: Vec<String> = Vec::new();
    let mut line = String::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let end = rest
            .char_indices()
            .find(|(_, c)| matches!(c, ' ' | '_' | '-' | '/' | '.' | ':'))
            .map(|(i, c)| i + c.len_utf8());
        let (word, after) = rest.split_at(end.unwrap_or(rest.len()));
        if !line.is_empty() && !fits(&format!("{line}{word}")) {
            if lines.len() + 1 == n_lines {
                // All that is left, to be cut.
                line.push_str(rest);
                break;
            }
            lines.push(std::mem::take(&mut line).trim_end().to_owned());
        }
        line.push_str(word);
        rest = after;
    }
    lines.push(line.trim_end().to_owned());
    let cut = |l: String| font::shortened(&l, room, size, Weight::SemiBold);
    lines.into_iter().map(cut).filter(|l| !l.is_empty()).collect()
}

impl Item {
    /// The same item elsewhere.
    pub(super) fn moved(mut self, by: Vec2) -> Self {
        let shift = |rect: &mut Rect| *rect = Rect { min: rect.min + by, max: rect.max + by };
        match &mut self {
            Self::Rect { rect, .. }
            | Self::Frame { rect, .. }
            | Self::Strip { rect, .. }
            | Self::Block { rect, .. }
            | Self::Hatch { rect, .. } => shift(rect),
            Self::Line { from, to, .. } => {
                *from += by;
                *to += by;
            }
            Self::Polyline { points, .. } | Self::Polygon { points, .. } => points.iter_mut().for_each(|p| *p += by),
            Self::Text(text) => text.at += by,
        }
        self
    }
}

#[cfg(test)]
#[path = "legend_tests.rs"]
mod tests;
