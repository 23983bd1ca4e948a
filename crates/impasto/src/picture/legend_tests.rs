//! Truths about legends: nothing overprints, all is inside, colours are the table's.

use super::*;
use crate::color::srgb8_from_linear;
use crate::math::Size;
use crate::picture::swatch::{AxisSpec, SwatchSpec, swatch_alone, swatch_layout};

const SIZES: [Size; 7] = [
    Size::new(320, 200),
    Size::new(320, 240),
    Size::new(640, 480),
    Size::new(1280, 720),
    Size::new(720, 1280),
    Size::new(3840, 2160),
    Size::new(500, 300),
];

fn ramp(n: usize) -> Vec<LinearRgba> {
    (0..n).map(|i| [(i as f32 + 0.5) / n as f32, 0.2, 0.1, 1.0]).collect()
}

/// Every feature, on its own and together.
fn specs() -> Vec<LegendSpec> {
    let black = [0.0, 0.0, 0.0, 1.0];
    let titles =
        ["T", "", "Temperature at the wall", "a_very_long_name_of_a_property_with_many_words", "Wärmestromdichte"];
    let mut specs = Vec::new();
    for (i, range) in
        [[0.0, 1.0], [-4e-7, 9e-7], [1e6, 1e6 + 1.0], [5.0, -5.0], [1e-9, 1e7], [2.0, 2.0]].into_iter().enumerate()
    {
        for (k, title) in titles.into_iter().enumerate() {
            let mut spec = LegendSpec::new(title, ["", "°C", "kg m⁻² s⁻¹"][(i + k) % 3], range, ramp(256));
            spec.scale = match (i + k) % 4 {
                0 => LegendScale::Log,
                1 => LegendScale::SymLog { linear_up_to: 1e-8 },
                _ => LegendScale::Linear,
            };
            spec.bands = [None, Some(7), None, Some(20)][(i + 2 * k) % 4];
            spec.below = (k % 2 == 0).then_some(black);
            spec.above = (i % 2 == 0).then_some(black);
            spec.missing = ((i + k) % 2 == 0).then_some([0.5, 0.5, 0.5, 0.4]);
            spec.missing_share = 0.0321;
            spec.lines = (0..10)
                .map(|j| LegendLine {
                    value: range[0] + (range[1] - range[0]) * j as f64 / 9.0,
                    is_major: j % 2 == 0,
                    color: black,
                })
                .collect();
            spec.notation = [Notation::Auto, Notation::Si, Notation::Engineering, Notation::Plain][(i * k) % 4];
            specs.push(spec);
        }
    }
    specs
}

/// The box of a text's ink.
fn letters(text: &Text) -> Rect {
    let points = font::flatten(&text.outline(true)).concat();
    let min = points.iter().fold(Vec2::INFINITY, |m, p| m.min(*p));
    Rect { min, max: points.iter().fold(Vec2::NEG_INFINITY, |m, p| m.max(*p)) }
}

/// Boxes of texts, and of solid things.
fn boxes(drawing: &Drawing) -> (Vec<(&Text, Rect)>, Vec<Rect>) {
    let mut texts = Vec::new();
    let mut solids = Vec::new();
    for item in &drawing.items {
        match item {
            Item::Text(text) => texts.push((text, letters(text))),
            Item::Frame { rect, width, .. } => solids.push(rect.grown(*width)),
            _ => {}
        }
    }
    (texts, solids)
}

fn check(drawing: &Drawing, columns: [f32; 2], rows: [f32; 2], what: &str) {
    let (texts, solids) = boxes(drawing);
    for (i, (text, a)) in texts.iter().enumerate() {
        let inside = a.min.x >= columns[0] && a.max.x <= columns[1] && a.min.y >= rows[0] && a.max.y <= rows[1];
        assert!(inside, "{what}: {:?} at {a:?} is outside of {columns:?} {rows:?}", text.content);
        for (other, b) in &texts[..i] {
            assert!(!a.overlaps(b), "{what}: {:?} {a:?} over {:?} {b:?}", text.content, other.content);
        }
        assert!(solids.iter().all(|s| !s.overlaps(a)), "{what}: {:?} {a:?} over a frame", text.content);
    }
    for (i, a) in solids.iter().enumerate() {
        assert!(
            a.min.x >= columns[0] && a.max.x <= columns[1] && a.min.y >= rows[0] && a.max.y <= rows[1],
            "{what}: frame {a:?}"
        );
        assert!(solids[..i].iter().all(|b| !a.overlaps(b)), "{what}: frames");
    }
}

#[test]
fn nothing_overprints_and_all_is_inside() {
    for size in SIZES {
        let (w, h) = (size.width as f32, size.height as f32);
        for (i, spec) in specs().into_iter().enumerate() {
            for position in [Position::Right, Position::Left, Position::Bottom] {
                let spec = LegendSpec { position, ..spec.clone() };
                let out = layout(&spec, size);
                let width = out.width as f32;
                let (columns, rows) = match position {
                    Position::Right => ([w - width, w], [0.0, h]),
                    Position::Left => ([0.0, width], [0.0, h]),
                    Position::Bottom => ([0.0, w], [h - width, h]),
                };
                let what = format!("{i} {:?} {:?} {position:?} {size}", spec.title, spec.range);
                check(&out.drawing, columns, rows, &what);
                let share = width / if position == Position::Bottom { h } else { w };
                assert!(share <= 0.46, "{what}: {share} of the picture");
                let alone = legend_alone(&spec, size);
                let (w, h) = (alone.size.width as f32, alone.size.height as f32);
                check(&alone, [0.0, w], [0.0, h], &what);
            }
        }
    }
}

#[test]
fn swatches_overprint_nothing_either() {
    let axis = |title: &str, unit: &str, range| AxisSpec {
        title: title.into(),
        unit: unit.into(),
        range,
        ..AxisSpec::default()
    };
    for size in SIZES {
        let (w, h) = (size.width as f32, size.height as f32);
        for range in [[0.0, 1.0], [-300.0, 1200.0], [1e-6, 2e-6], [5.0, 5.0]] {
            let axes = [axis("Potential", "mV", range), axis("a rather long name of the field", "kV/m", [0.0, 10.0])];
            let mut spec = SwatchSpec::from_fn(axes, 16, |x, y| [x, y, 0.5, 1.0]);
            spec.missing = Some([0.2; 4]);
            let out = swatch_layout(&spec, size);
            check(&out.drawing, [w - out.width as f32, w], [0.0, h], &format!("{size} {range:?}"));
            let alone = swatch_alone(&spec, size);
            check(&alone, [0.0, alone.size.width as f32], [0.0, alone.size.height as f32], "alone");
        }
    }
}

#[test]
fn a_swatch_has_its_first_colour_at_the_bottom_left() {
    let spec = SwatchSpec::from_fn([AxisSpec::default(), AxisSpec::default()], 4, |x, y| [x, y, 0.0, 1.0]);
    let drawing = swatch_alone(&spec, Size::new(640, 480));
    let block = drawing.items.iter().find_map(|i| if let Item::Block { colors, .. } = i { Some(colors) } else { None });
    let colors = block.expect("a block");
    assert_eq!((colors[12], colors[3]), ([0.125, 0.125, 0.0, 1.0], [0.875, 0.875, 0.0, 1.0]));
}

#[test]
fn a_bar_has_the_colours_of_its_table() {
    let size = Size::new(640, 480);
    let mut spec = LegendSpec::new("T", "", [0.0, 1.0], ramp(5));
    spec.is_smooth = false;
    let drawing = layout(&spec, size).drawing;
    let bar = drawing.items.iter().find_map(|i| if let Item::Strip { rect, .. } = i { Some(*rect) } else { None });
    let bar = bar.expect("a bar");
    assert_eq!(bar.height(), (0.6f32 * 480.0).round());
    assert_eq!(bar.width(), 16.0);
    let picture = drawing.picture(Some([255; 3]));
    let x = bar.min.x as usize + 5;
    for i in 0..5 {
        let y = (bar.max.y - bar.height() * (i as f32 + 0.5) / 5.0) as usize;
        assert_eq!(picture[y * 640 + x][0], srgb8_from_linear((i as f32 + 0.5) / 5.0));
    }
    // Smooth: between the centres of entries, and even beyond the outermost.
    spec.is_smooth = true;
    assert_eq!([0.05f32, 0.2, 0.95].map(|t| (spec.color(t)[0] * 100.0).round()), [10.0, 20.0, 90.0]);
    spec.bands = Some(2);
    let pixels = spec.pixels(10);
    assert!(pixels[..5].iter().all(|p| *p == pixels[0]) && pixels[5..].iter().all(|p| *p == pixels[9]));
    assert_eq!(pixels[0], spec.color(0.25));
}

#[test]
fn what_is_outside_or_missing_is_said() {
    let mut spec = LegendSpec::new("T", "K", [10.0, 30.0], ramp(9));
    (spec.below, spec.above, spec.missing) = (Some([0.0; 4]), Some([0.5; 4]), Some([1.0; 4]));
    spec.missing_share = 0.032;
    let words = |spec: &LegendSpec| -> Vec<String> {
        let drawing = layout(spec, Size::new(640, 480)).drawing;
        boxes(&drawing).0.iter().map(|(t, _)| t.content.clone()).collect()
    };
    let said = words(&spec);
    for text in ["T", "[K]", "< 10", "> 30", "no value 3.2 %"] {
        assert!(said.iter().any(|s| s == text), "{text} in {said:?}");
    }
    spec.range = [30.0, 10.0];
    let said = words(&spec);
    assert!(said.iter().any(|s| s == "> 30") && said.iter().any(|s| s == "< 10"));
    for (share, text) in
        [(0.0, "no value"), (0.0004, "no value < 0.1 %"), (0.5, "no value 50 %"), (f64::NAN, "no value")]
    {
        assert_eq!(no_value(share), text);
    }
    assert_eq!(grouped(1_234_567.0), "1\u{2009}234\u{2009}567");
}

#[test]
fn titles_break_between_words() {
    assert_eq!(wrapped("wall shear stress", 1000.0, 10.0, 2), ["wall shear stress"]);
    assert_eq!(wrapped("wall shear stress", 60.0, 10.0, 2), ["wall shear", "stress"]);
    assert_eq!(wrapped("temperature_gradient", 70.0, 10.0, 2), ["temperature_", "gradient"]);
    let cut = wrapped("one two three four five six seven", 40.0, 10.0, 2);
    assert!(cut.len() == 2 && cut[1].ends_with('…'), "{cut:?}");
    assert!(wrapped("", 40.0, 10.0, 2).is_empty());
}
