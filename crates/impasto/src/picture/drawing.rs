//! Flat drawings over pictures: rectangles, lines, colour bars, text. Blended in linear light, or written as SVG.
//!
//! All measures are pixels: origin top left, y down, the centre of the first pixel at (0.5, 0.5).

use crate::color::{LINEAR_FROM_SRGB8, LinearRgba, luminance, srgb8_from_linear, unorm8};
use crate::math::{Size, Vec2, sin_cos, vec2};
use crate::picture::coverage::{self, Coverage};
use crate::picture::font::{self, Segment, Weight};

/// Items in the order they are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// The sheet; what lies beyond it is not drawn.
    pub size: Size,
    /// The first lies at the bottom.
    pub items: Vec<Item>,
}

/// An upright rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Rect {
    /// Top left corner.
    pub min: Vec2,
    /// Bottom right corner.
    pub max: Vec2,
}

impl Rect {
    /// By its top left corner, width and height.
    pub fn new(x: f32, y: f32, width: f32, height: f32) -> Self {
        Self { min: vec2(x, y), max: vec2(x + width, y + height) }
    }

    /// Its width.
    pub fn width(&self) -> f32 {
        self.max.x - self.min.x
    }

    /// Its height.
    pub fn height(&self) -> f32 {
        self.max.y - self.min.y
    }

    /// The smallest one around both.
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether they share an area.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.x < other.max.x && other.min.x < self.max.x && self.min.y < other.max.y && other.min.y < self.max.y
    }

    /// With `margin` more on each side.
    pub fn grown(&self, margin: f32) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    pub(super) fn corners(&self) -> Vec<Vec2> {
        vec![self.min, vec2(self.max.x, self.min.y), self.max, vec2(self.min.x, self.max.y)]
    }
}

/// Where a strip of colours has its first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The first colour at the bottom.
    Up,
    /// The first colour on the left.
    Right,
}

/// One thing to draw. Colours are linear with straight alpha.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A filled rectangle.
    Rect {
        /// Its edges.
        rect: Rect,
        /// Its colour.
        color: LinearRgba,
    },
    /// A border just outside of a rectangle.
    Frame {
        /// What it encloses.
        rect: Rect,
        /// How thick it is.
        width: f32,
        /// Its colour.
        color: LinearRgba,
    },
    /// A line with square ends.
    Line {
        /// One end.
        from: Vec2,
        /// The other.
        to: Vec2,
        /// How thick it is.
        width: f32,
        /// Its colour.
        color: LinearRgba,
    },
    /// Lines through points with mitred corners.
    Polyline {
        /// At least two.
        points: Vec<Vec2>,
        /// Whether the last is joined to the first.
        is_closed: bool,
        /// How thick it is.
        width: f32,
        /// Its colour.
        color: LinearRgba,
    },
    /// A filled polygon.
    Polygon {
        /// At least three.
        points: Vec<Vec2>,
        /// Its colour.
        color: LinearRgba,
    },
    /// Equally wide stretches of colour, for bars. Give one for each pixel of a smooth bar.
    Strip {
        /// Its edges.
        rect: Rect,
        /// Which way the colours go.
        direction: Direction,
        /// At least one.
        colors: Vec<LinearRgba>,
    },
    /// A block of equal cells of colour.
    Block {
        /// Its edges.
        rect: Rect,
        /// Cells in a row.
        n_columns: usize,
        /// Rows from the top.
        colors: Vec<LinearRgba>,
    },
    /// Lines from bottom left to top right across a rectangle.
    Hatch {
        /// Its edges.
        rect: Rect,
        /// From line to line.
        spacing: f32,
        /// How thick they are.
        width: f32,
        /// Their colour.
        color: LinearRgba,
    },
    /// A line of text.
    Text(Text),
}

/// Which part of a line of text lies at its anchor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Align {
    /// Where it begins.
    #[default]
    Start,
    /// Half way.
    Middle,
    /// Where it ends.
    End,
}

/// A line of text.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    /// What it says.
    pub content: String,
    /// The anchor: a point on the baseline, or half a capital above it for `is_centered`.
    pub at: Vec2,
    /// What of the line is at the anchor.
    pub align: Align,
    /// Whether the anchor is at half the height of figures and capitals instead of on the baseline.
    pub is_centered: bool,
    /// The em in pixels.
    pub size: f32,
    /// How heavy it is.
    pub weight: Weight,
    /// Its colour.
    pub color: LinearRgba,
    /// A rim of this colour and width, so that it reads on busy ground.
    pub halo: Option<(LinearRgba, f32)>,
    /// Turns the line about its anchor, radians, from +x towards +y: clockwise as one sees it.
    pub angle: f32,
}

impl Text {
    /// Regular upright text that begins at a point of its baseline.
    pub fn new(content: impl Into<String>, at: Vec2, size: f32, color: LinearRgba) -> Self {
        Self {
            content: content.into(),
            at,
            align: Align::Start,
            is_centered: false,
            size,
            weight: Weight::Regular,
            color,
            halo: None,
            angle: 0.0,
        }
    }

    /// How long the line is, pixels.
    pub fn width(&self) -> f32 {
        font::width(&self.content, self.size, self.weight)
    }

    /// The upright box around it, rotated as it is, with its halo.
    pub fn bounds(&self) -> Rect {
        let start = self.start();
        let (top, bottom) = (start.y - font::ASCENT * self.size, start.y + font::DESCENT * self.size);
        let local = Rect { min: vec2(start.x, top), max: vec2(start.x + self.width(), bottom) };
        let corners = local.grown(self.halo.map_or(0.0, |h| h.1)).corners();
        let turn = self.turn();
        let corners = corners.into_iter().map(|p| self.at + turn(p));
        let empty = Rect { min: Vec2::INFINITY, max: Vec2::NEG_INFINITY };
        corners.fold(empty, |b, p| Rect { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Where the baseline begins, seen from the anchor before it is turned.
    fn start(&self) -> Vec2 {
        let x = match self.align {
            Align::Start => 0.0,
            Align::Middle => -0.5 * self.width(),
            Align::End => -self.width(),
        };
        vec2(x, if self.is_centered { 0.5 * font::CAP_HEIGHT * self.size } else { 0.0 })
    }

    fn turn(&self) -> impl Fn(Vec2) -> Vec2 + use<> {
        let (sin, cos) = if self.angle == 0.0 { (0.0, 1.0) } else { sin_cos(self.angle) };
        // Quarter turns keep whole pixels whole.
        let clean = |x: f32| if x.abs() < 1e-6 { 0.0 } else { x };
        let (sin, cos) = (clean(sin), clean(cos));
        move |p| vec2(cos * p.x - sin * p.y, sin * p.x + cos * p.y)
    }

    /// Its outlines on the sheet. Baselines of upright lines and of quarter turns lie between pixels, and with
    /// `is_fitted` so do the heights of their letters.
    pub(super) fn outline(&self, is_fitted: bool) -> Vec<Segment> {
        let turn = self.turn();
        let start = self.at + turn(self.start());
        let (along, up) = (turn(vec2(1.0, 0.0)), turn(vec2(0.0, 1.0)));
        let is_straight = along.x == 0.0 || along.y == 0.0;
        let start = if is_straight && is_fitted { (start + 0.5).floor() } else { start };
        let place = |p: Vec2| start + along * p.x + up * p.y;
        let is_small = self.size < 26.0;
        let segments = font::outline(&self.content, self.size, self.weight, is_fitted && is_straight && is_small);
        let placed = segments.into_iter().map(|segment| match segment {
            Segment::Move(p) => Segment::Move(place(p)),
            Segment::Line(p) => Segment::Line(place(p)),
            Segment::Quad(c, p) => Segment::Quad(place(c), place(p)),
            Segment::Close => Segment::Close,
        });
        placed.collect()
    }
}

impl Drawing {
    /// An empty sheet.
    pub fn new(size: Size) -> Self {
        Self { size, items: Vec::new() }
    }

    /// Draws over a picture: sRGB bytes with straight alpha, rows from the top. Blends in linear light by exact area.
    pub fn paint(&self, picture: &mut [[u8; 4]], size: Size) {
        assert_eq!(picture.len(), size.n_cells(), "a picture of {size} has that many pixels");
        let mut canvas = Canvas { pixels: picture, size };
        self.items.iter().for_each(|item| canvas.item(item));
    }

    /// The drawing alone on a transparent sheet, or on `ground`.
    pub fn picture(&self, ground: Option<[u8; 3]>) -> Vec<[u8; 4]> {
        let pixel = ground.map_or([0; 4], |[r, g, b]| [r, g, b, 255]);
        let mut picture = vec![pixel; self.size.n_cells()];
        self.paint(&mut picture, self.size);
        picture
    }
}

struct Canvas<'a> {
    pixels: &'a mut [[u8; 4]],
    size: Size,
}

impl Canvas<'_> {
    fn item(&mut self, item: &Item) {
        match item {
            Item::Rect { rect, color } => self.cover(&[rect.corners()], *color),
            Item::Frame { rect, width, color } => {
                let mut inside = rect.corners();
                inside.reverse();
                self.cover(&[rect.grown(*width).corners(), inside], *color);
            }
            Item::Line { from, to, width, color } => {
                self.cover(&coverage::stroke(&[*from, *to], *width, false), *color)
            }
            Item::Polyline { points, is_closed, width, color } => {
                self.cover(&coverage::stroke(points, *width, *is_closed), *color);
            }
            Item::Polygon { points, color } => self.cover(std::slice::from_ref(points), *color),
            Item::Strip { rect, direction, colors } => match direction {
                Direction::Up => self.grid(rect, [1, colors.len()], |_, row| colors[colors.len() - 1 - row]),
                Direction::Right => self.grid(rect, [colors.len(), 1], |column, _| colors[column]),
            },
            Item::Block { rect, n_columns, colors } => {
                let n_rows = colors.len().checked_div(*n_columns).unwrap_or(0);
                self.grid(rect, [*n_columns, n_rows], |column, row| colors[row * n_columns + column]);
            }
            Item::Hatch { rect, spacing, width, color } => self.cover(&hatch(rect, *spacing, *width), *color),
            Item::Text(text) => self.text(text),
        }
    }

    fn text(&mut self, text: &Text) {
        let contours = font::flatten(&text.outline(true));
        if let Some((color, radius)) = text.halo
            && let Some(covered) = coverage::fill(&contours, self.size, radius.clamp(0.0, 100.0) + 1.0)
        {
            self.blend(&widened(&covered, radius.clamp(0.0, 100.0)), color);
        }
        if let Some(mut covered) = coverage::fill(&contours, self.size, 0.0) {
            let darkness = 1.0 - luminance([text.color[0], text.color[1], text.color[2]]).clamp(0.0, 1.0);
            covered.shares.iter_mut().for_each(|s| *s += STEM_DARKENING * darkness * *s * (1.0 - *s));
            self.blend(&covered, text.color);
        }
    }

    /// Cells of colour that fill a rectangle. A pixel has the mean of those it lies over, so that no seam shows.
    fn grid(&mut self, rect: &Rect, [n_columns, n_rows]: [usize; 2], color: impl Fn(usize, usize) -> LinearRgba) {
        if !rect.min.is_finite() || !rect.max.is_finite() || n_columns == 0 || n_rows == 0 {
            return;
        }
        let columns = overlaps(rect.min.x, rect.max.x, n_columns, self.size.width);
        let rows = overlaps(rect.min.y, rect.max.y, n_rows, self.size.height);
        for (y, in_rows) in &rows {
            for (x, in_columns) in &columns {
                let (mut sum, mut whole) = ([0.0f32; 3], 0.0f32);
                for (row, high) in in_rows {
                    for (column, wide) in in_columns {
                        let [r, g, b, a] = color(*column, *row);
                        let share = high * wide * a.clamp(0.0, 1.0);
                        sum = [sum[0] + r * share, sum[1] + g * share, sum[2] + b * share];
                        whole += share;
                    }
                }
                if whole > 0.0 {
                    let pixel = &mut self.pixels[y * self.size.width as usize + x];
                    let color = [sum[0] / whole, sum[1] / whole, sum[2] / whole, 1.0];
                    *pixel = over(color, if whole > 0.9999 { 1.0 } else { whole }, *pixel);
                }
            }
        }
    }

    fn cover(&mut self, contours: &[Vec<Vec2>], color: LinearRgba) {
        if let Some(covered) = coverage::fill(contours, self.size, 0.0) {
            self.blend(&covered, color);
        }
    }

    /// Porter and Duff's *over* in linear light, onto straight alpha.
    fn blend(&mut self, covered: &Coverage, color: LinearRgba) {
        for (y, shares) in covered.rows() {
            let start = y * self.size.width as usize + covered.x;
            for (pixel, share) in self.pixels[start..start + shares.len()].iter_mut().zip(shares) {
                let alpha = color[3].clamp(0.0, 1.0) * share;
                if alpha > 0.0 {
                    *pixel = over(color, alpha, *pixel);
                }
            }
        }
    }
}

/// Dark letters on light ground lose weight when they are blended in linear light: half covered is three quarters as
/// bright to the eye. This much of what is lost is given back; more looks bold at large sizes.
const STEM_DARKENING: f32 = 0.7;

/// The pixels of a row or column from `a` to `b`, each with the cells of `n` that it lies over and how much of it they take.
fn overlaps(a: f32, b: f32, n: usize, n_pixels: u32) -> Vec<(usize, Vec<(usize, f32)>)> {
    let step = (b - a) / n as f32;
    let (first, end) = (a.max(0.0).floor() as usize, b.min(n_pixels as f32).ceil().max(0.0) as usize);
    let edge = |i: usize| if i == n { b } else { a + step * i as f32 };
    let of_pixel = |p: usize| {
        let (low, high) = ((p as f32).max(a), (p as f32 + 1.0).min(b));
        // One cell more on either side than division says: it is rounded.
        let from = (((low - a) / step) as usize).saturating_sub(1);
        let to = (((high - a) / step) as usize + 2).min(n);
        let shares = (from..to).map(|i| (i, edge(i + 1).min(high) - edge(i).max(low)));
        (p, shares.filter(|(_, share)| *share > 1e-5).collect())
    };
    (first..end).map(of_pixel).collect()
}

/// A colour laid over a pixel.
#[inline]
fn over(color: LinearRgba, alpha: f32, under: [u8; 4]) -> [u8; 4] {
    let behind = under[3] as f32 / 255.0 * (1.0 - alpha);
    let whole = alpha + behind;
    let channel = |c: usize| {
        let under = LINEAR_FROM_SRGB8[under[c] as usize];
        srgb8_from_linear((color[c] * alpha + under * behind) / whole)
    };
    [channel(0), channel(1), channel(2), unorm8(whole)]
}

/// A part of a strip, from `a` to `b` of its length.
pub(super) fn stretch(rect: &Rect, direction: Direction, a: f32, b: f32) -> Rect {
    match direction {
        Direction::Up => {
            let y = |t: f32| rect.max.y - rect.height() * t;
            Rect { min: vec2(rect.min.x, y(b)), max: vec2(rect.max.x, y(a)) }
        }
        Direction::Right => {
            let x = |t: f32| rect.min.x + rect.width() * t;
            Rect { min: vec2(x(a), rect.min.y), max: vec2(x(b), rect.max.y) }
        }
    }
}

/// A block's cells with their colours.
pub(super) fn cells(rect: &Rect, n_columns: usize, colors: &[LinearRgba]) -> impl Iterator<Item = (Rect, LinearRgba)> {
    let n_columns = n_columns.max(1);
    let n_rows = colors.len() / n_columns;
    let (w, h) = (rect.width() / n_columns as f32, rect.height() / n_rows.max(1) as f32);
    let (x, y) = (rect.min.x, rect.min.y);
    let at = move |column: usize, row: usize| vec2(x + column as f32 * w, y + row as f32 * h);
    colors.iter().take(n_rows * n_columns).enumerate().map(move |(i, color)| {
        let (column, row) = (i % n_columns, i / n_columns);
        (Rect { min: at(column, row), max: at(column + 1, row + 1) }, *color)
    })
}

/// Slanted stripes, cut to a rectangle.
pub(super) fn hatch(rect: &Rect, spacing: f32, width: f32) -> Vec<Vec<Vec2>> {
    let (w, h) = (rect.width(), rect.height());
    // Along the top edge a stripe is wider than across, by the square root of two.
    let (step, thick) = (spacing.max(0.5) * std::f32::consts::SQRT_2, width * std::f32::consts::SQRT_2);
    let n = (((w + h) / step).ceil()).clamp(0.0, 10_000.0) as usize;
    // x + y from `a` to `b`, within the rectangle.
    let stripe = |a: f32, b: f32| {
        let mut points = Vec::new();
        let mut edge = |s: f32, is_back: bool| {
            let s = s.clamp(0.0, w + h);
            let (top, left) = (vec2(s.min(w), (s - w).max(0.0)), vec2((s - h).max(0.0), s.min(h)));
            points.extend(if is_back { [left, top] } else { [top, left] });
        };
        edge(a, false);
        edge(b, true);
        // The two corners where a stripe turns round them.
        if a < w && b > w {
            points.push(vec2(w, 0.0));
        }
        if a < h && b > h {
            points.insert(2, vec2(0.0, h));
        }
        points.into_iter().map(|p| p + rect.min).collect()
    };
    (0..n).map(|i| (i as f32 + 0.5) * step).map(|s| stripe(s - thick * 0.5, s + thick * 0.5)).collect()
}

/// Coverage widened by a radius. Where a pixel is covered in part the edge lies within it.
fn widened(covered: &Coverage, radius: f32) -> Coverage {
    let (w, h) = (covered.width as i32, covered.shares.len() as i32 / covered.width.max(1) as i32);
    let reach = radius.ceil() as i32;
    let square = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)));
    let disk: Vec<(i32, i32, f32)> = square
        .map(|(dx, dy)| (dx, dy, radius - ((dx * dx + dy * dy) as f32).sqrt()))
        .filter(|(_, _, left)| *left > -1.0)
        .collect();
    let mut shares = vec![0.0f32; covered.shares.len()];
    for y in 0..h {
        for x in 0..w {
            let from = covered.shares[(y * w + x) as usize];
            if from == 0.0 {
                continue;
            }
            for &(dx, dy, left) in &disk {
                let (x, y) = (x + dx, y + dy);
                if x >= 0 && x < w && y >= 0 && y < h {
                    let to = &mut shares[(y * w + x) as usize];
                    *to = to.max((left + from).clamp(0.0, 1.0));
                }
            }
        }
    }
    Coverage { x: covered.x, y: covered.y, width: covered.width, shares }
}

#[cfg(test)]
#[path = "drawing_tests.rs"]
mod tests;
