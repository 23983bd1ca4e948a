//! Drawings as SVG: shapes with their colours, text as outlines so that it looks the same everywhere.

use crate::assets::image_write;
use crate::color::{Encoding, LinearRgba, srgb8_from_linear, unorm8};
use crate::math::{Size, Vec2};
use crate::picture::drawing::{Drawing, Item, Rect, Text, cells, hatch, stretch};
use crate::picture::font::Segment;
use std::fmt::Write;

impl Drawing {
    /// A file of its own. Text keeps its words in labels.
    pub fn svg(&self) -> String {
        let Size { width, height } = self.size;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\">\n"
        );
        for item in &self.items {
            write_item(&mut out, item);
        }
        out.push_str("</svg>\n");
        out
    }
}

fn write_item(out: &mut String, item: &Item) {
    match item {
        Item::Rect { rect, color } => write_rect(out, rect, *color),
        Item::Frame { rect, width, color } => {
            let r = rect.grown(width * 0.5);
            line(out, &format!("<rect {} fill=\"none\"{}/>", place(&r), stroke(*color, *width)));
        }
        Item::Line { from, to, width, color } => write_path(out, &[*from, *to], false, &stroke(*color, *width)),
        Item::Polyline { points, is_closed, width, color } => {
            write_path(out, points, *is_closed, &format!(" stroke-linejoin=\"miter\"{}", stroke(*color, *width)));
        }
        Item::Polygon { points, color } => line(out, &format!("<path d=\"{}Z\"{}/>", data(points), fill(*color))),
        Item::Strip { rect, direction, colors } => {
            out.push_str("<g shape-rendering=\"crispEdges\">\n");
            let n = colors.len() as f32;
            let mut start = 0;
            for run in colors.chunk_by(|a, b| fill(*a) == fill(*b)) {
                let end = start + run.len();
                write_rect(out, &stretch(rect, *direction, start as f32 / n, end as f32 / n), run[0]);
                start = end;
            }
            out.push_str("</g>\n");
        }
        Item::Block { rect, n_columns, colors } => write_block(out, rect, *n_columns, colors),
        Item::Hatch { rect, spacing, width, color } => {
            let stripes: String = hatch(rect, *spacing, *width).iter().map(|s| data(s) + "Z").collect();
            line(out, &format!("<path d=\"{stripes}\"{}/>", fill(*color)));
        }
        Item::Text(text) => write_text(out, text),
    }
}

/// Small blocks as rectangles, large ones as an embedded picture.
fn write_block(out: &mut String, rect: &Rect, n_columns: usize, colors: &[LinearRgba]) {
    const MOST_RECTS: usize = 1024;
    let n_rows = colors.len() / n_columns.max(1);
    if n_rows == 0 {
        return;
    }
    if colors.len() <= MOST_RECTS {
        out.push_str("<g shape-rendering=\"crispEdges\">\n");
        cells(rect, n_columns, colors).for_each(|(cell, color)| write_rect(out, &cell, color));
        out.push_str("</g>\n");
        return;
    }
    let bytes: Vec<u8> = colors[..n_rows * n_columns].iter().flat_map(|c| srgb8(*c)).collect();
    let size = Size::new(n_columns as u32, n_rows as u32);
    let png = base64(&image_write::png8(size, &bytes, Encoding::Srgb, &[]));
    line(
        out,
        &format!(
            "<image {} preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
             href=\"data:image/png;base64,{png}\"/>",
            place(rect)
        ),
    );
}

fn write_text(out: &mut String, text: &Text) {
    let mut d = String::new();
    for segment in text.outline(false) {
        match segment {
            Segment::Move(p) => write!(d, "M{} {}", number(p.x), number(p.y)),
            Segment::Line(p) => write!(d, "L{} {}", number(p.x), number(p.y)),
            Segment::Quad(c, p) => write!(d, "Q{} {} {} {}", number(c.x), number(c.y), number(p.x), number(p.y)),
            Segment::Close => write!(d, "Z"),
        }
        .expect("writing to memory does not fail");
    }
    let label = escaped(&text.content);
    let halo = text.halo.map_or(String::new(), |(color, radius)| {
        format!("<path d=\"{d}\" stroke-linejoin=\"round\"{}{}/>", fill(color), stroke(color, radius * 2.0))
    });
    line(out, &format!("<g role=\"img\" aria-label=\"{label}\">{halo}<path d=\"{d}\"{}/></g>", fill(text.color)));
}

fn write_rect(out: &mut String, rect: &Rect, color: LinearRgba) {
    line(out, &format!("<rect {}{}/>", place(rect), fill(color)));
}

fn write_path(out: &mut String, points: &[Vec2], is_closed: bool, style: &str) {
    let end = if is_closed { "Z" } else { "" };
    line(out, &format!("<path d=\"{}{end}\" fill=\"none\"{style}/>", data(points)));
}

fn line(out: &mut String, text: &str) {
    out.push_str(text);
    out.push('\n');
}

fn place(r: &Rect) -> String {
    let [x, y, w, h] = [r.min.x, r.min.y, r.width().max(0.0), r.height().max(0.0)].map(number);
    format!("x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"")
}

fn data(points: &[Vec2]) -> String {
    let mut d = String::new();
    for (i, p) in points.iter().enumerate() {
        let letter = if i == 0 { 'M' } else { 'L' };
        write!(d, "{letter}{} {}", number(p.x), number(p.y)).expect("writing to memory does not fail");
    }
    d
}

fn fill(color: LinearRgba) -> String {
    paint("fill", color)
}

fn stroke(color: LinearRgba, width: f32) -> String {
    format!("{} stroke-width=\"{}\"", paint("stroke", color), number(width))
}

fn paint(what: &str, color: LinearRgba) -> String {
    let [r, g, b, a] = srgb8(color);
    match a {
        255 => format!(" {what}=\"#{r:02x}{g:02x}{b:02x}\""),
        _ => format!(" {what}=\"#{r:02x}{g:02x}{b:02x}\" {what}-opacity=\"{}\"", number(a as f32 / 255.0)),
    }
}

fn srgb8(c: LinearRgba) -> [u8; 4] {
    [srgb8_from_linear(c[0]), srgb8_from_linear(c[1]), srgb8_from_linear(c[2]), unorm8(c[3])]
}

/// At most three decimals; what is no number is zero, so that the file stays valid.
fn number(x: f32) -> String {
    let x = if x.is_finite() { x } else { 0.0 };
    let text = format!("{x:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text for an attribute of XML 1.0.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Bytes as text (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let word = three.iter().fold(0u32, |w, b| w << 8 | *b as u32) << (8 * (3 - three.len()));
        for i in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * i) & 63) as usize] as char;
            out.push(if i <= three.len() { letter } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec2;
    use crate::picture::drawing::Direction;

    #[test]
    fn bytes_are_written_as_the_rfc_says() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (plain, coded) in cases {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn tags_are_closed_and_names_are_escaped() {
        let mut drawing = Drawing::new(Size::new(100, 50));
        let rect = Rect::new(1.0, 2.0, 30.0, 20.0);
        let color = [1.0, 0.5, 0.0, 0.5];
        drawing.items = vec![
            Item::Rect { rect, color },
            Item::Frame { rect, width: 1.0, color },
            Item::Line { from: rect.min, to: rect.max, width: 1.0, color },
            Item::Polyline { points: rect.corners(), is_closed: true, width: 1.0, color },
            Item::Polygon { points: rect.corners(), color },
            Item::Strip { rect, direction: Direction::Up, colors: vec![color, color, [0.0; 4]] },
            Item::Block { rect, n_columns: 2, colors: vec![color; 4] },
            Item::Block { rect, n_columns: 64, colors: vec![color; 64 * 64] },
            Item::Hatch { rect, spacing: 5.0, width: 1.0, color },
            Item::Text(Text {
                halo: Some((color, 2.0)),
                ..Text::new("a<b & \"c\"\u{1}", vec2(f32::NAN, 9.0), 12.0, color)
            }),
        ];
        let svg = drawing.svg();
        assert!(svg.starts_with("<svg xmlns=") && svg.ends_with("</svg>\n"));
        assert!(svg.contains("aria-label=\"a&lt;b &amp; &quot;c&quot; \""));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        // A strip's equal neighbours are one rectangle.
        let strip = svg.split("<g shape").nth(1).expect("a strip");
        assert_eq!(strip.split("</g>").next().expect("closed").matches("<rect").count(), 2);
        // Every tag is closed: a small parser of what is written here.
        let mut open = Vec::new();
        for tag in svg.split('<').skip(1) {
            let (tag, _) = tag.split_once('>').expect("a tag ends");
            assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
            let name = tag.trim_start_matches('/').split([' ', '/']).next().expect("a tag has a name");
            match (tag.starts_with('/'), tag.ends_with('/')) {
                (true, _) => assert_eq!(open.pop(), Some(name)),
                (false, false) => open.push(name),
                _ => {}
            }
        }
        assert!(open.is_empty());
    }
}
