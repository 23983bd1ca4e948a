//! Legends of many kinds on one sheet: `cargo run --example legends OUT.png [WIDTH HEIGHT [light|dark|clear]]`.

use impasto::assets::image_write;
use impasto::color::Encoding;
use impasto::lookup::ColorTable;
use impasto::math::Size;
use impasto::picture::contour::{LabelStyle, labels, level_texts, trace};
use impasto::picture::drawing::{Drawing, Item};
use impasto::picture::legend::{LegendLine, LegendScale, LegendSpec, Position, Theme, layout};
use impasto::picture::numbers::Notation;
use impasto::picture::swatch::{AxisSpec, SwatchSpec, swatch_layout};

fn specs() -> Vec<LegendSpec> {
    let colors = |name| ColorTable::named(name).expect("a known table").colors;
    let (viridis, cool_warm) = (colors("viridis"), colors("coolwarm"));
    let new = |title: &str, unit: &str, range| LegendSpec::new(title, unit, range, viridis.clone());
    let grey = Some([0.4, 0.4, 0.4, 1.0]);
    let mut specs = vec![
        new("Temperature", "°C", [18.2, 74.9]),
        LegendSpec {
            colors: cool_warm,
            missing: grey,
            missing_share: 0.032,
            ..new("Surface charge", "e/Å²", [-0.5, 0.5])
        },
        LegendSpec {
            scale: LegendScale::Log,
            below: Some([0.0, 0.0, 0.0, 1.0]),
            ..new("Permeability", "m²", [1e-9, 1e-3])
        },
        LegendSpec { bands: Some(8), above: Some([1.0, 0.2, 0.2, 1.0]), ..new("Wall shear stress", "Pa", [0.0, 4.0]) },
        LegendSpec { notation: Notation::Si, ..new("von Mises stress in the flange", "Pa", [0.0, 2.4e8]) },
        LegendSpec { scale: LegendScale::SymLog { linear_up_to: 1.0 }, ..new("Vorticity", "1/s", [-1000.0, 1000.0]) },
        new("depth_below_datum_of_the_lower_boundary", "m", [1_000_000.0, 1_000_001.0]),
        LegendSpec { position: Position::Bottom, missing: grey, ..new("Elevation", "m", [-120.0, 3400.0]) },
    ];
    let line = |i: i32| LegendLine { value: i as f64 * 5.0, is_major: i % 2 == 0, color: [0.0, 0.0, 0.0, 1.0] };
    specs[0].lines = (4..15).map(line).collect();
    specs
}

/// Two properties in one square.
fn swatch(theme: Theme, size: Size) -> Drawing {
    let axis = |title: &str, unit: &str, range| AxisSpec {
        title: title.into(),
        unit: unit.into(),
        range,
        ..AxisSpec::default()
    };
    let axes = [axis("Potential", "mV", [-50.0, 50.0]), axis("Field strength", "kV/m", [0.0, 12.0])];
    let table = ColorTable::named("coolwarm").expect("a known table");
    let faded = |x, y| table.color(x).map(|c| c * y + (1.0 - y));
    let spec = SwatchSpec { theme, ..SwatchSpec::from_fn(axes, 64, faded) };
    swatch_layout(&spec, size).drawing
}

/// Lines of a hilly field, and their labels.
fn isolines(theme: Theme, size: Size) -> Drawing {
    let (w, h) = (size.width as f32, size.height as f32);
    let hill = |x: f32, y: f32, r: f32| 1.0 / (1.0 + (x * x + y * y) / (r * r));
    let at = |i: usize| ((i as u32 % size.width) as f32 / h, (i as u32 / size.width) as f32 / h);
    let value =
        |(x, y): (f32, f32)| 900.0 * hill(x - 0.4 * w / h, y - 0.4, 0.3) + 700.0 * hill(x - 0.75 * w / h, y - 0.7, 0.2);
    let values: Vec<f32> = (0..size.n_cells()).map(|i| value(at(i))).collect();
    let levels: Vec<f32> = (0..20).map(|i| i as f32 * 100.0).collect();
    let contours = trace(&values, size, &levels);
    let style = LabelStyle::new((h / 45.0).max(10.0), theme.ink(), theme.paper());
    let mut items: Vec<Item> = contours
        .iter()
        .map(|c| Item::Polyline {
            points: c.points.clone(),
            is_closed: c.is_closed,
            width: h / 600.0,
            color: theme.ink(),
        })
        .collect();
    items.extend(labels(&contours, &level_texts(&levels, Notation::Auto), (&values, size), &style, &[]));
    Drawing { size, items }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, or: u32| words.get(i).and_then(|w| w.parse().ok()).unwrap_or(or);
    let size = Size::new(number(1, 640), number(2, 480));
    let (theme, ground) = match words.get(3).map_or("light", |w| w) {
        "dark" => (Theme::Dark, [24, 25, 28, 255]),
        "clear" => (Theme::Light, [0; 4]),
        _ => (Theme::Light, [244, 243, 240, 255]),
    };
    let mut drawings: Vec<Drawing> =
        specs().into_iter().map(|s| layout(&LegendSpec { theme, ..s }, size).drawing).collect();
    drawings.extend([swatch(theme, size), isolines(theme, size)]);
    let n_columns = 5;
    let sheet = Size::new(size.width * n_columns as u32, size.height * drawings.len().div_ceil(n_columns) as u32);
    let mut pixels = vec![[0; 4]; sheet.n_cells()];
    for (i, drawing) in drawings.iter().enumerate() {
        let mut picture = vec![ground; size.n_cells()];
        drawing.paint(&mut picture, size);
        let (left, top) = (i % n_columns * size.width as usize, i / n_columns * size.height as usize);
        for (y, row) in picture.chunks(size.width as usize).enumerate() {
            let start = (top + y) * sheet.width as usize + left;
            pixels[start..start + row.len()].copy_from_slice(row);
        }
    }
    let path = words.first().map_or("legends.png", |w| w);
    let png = image_write::png8(sheet, pixels.as_flattened(), Encoding::Srgb, &[]);
    std::fs::write(path, png).expect("the sheet can be written");
    let svg = path.replace(".png", ".svg");
    std::fs::write(svg, drawings[0].svg()).expect("the drawing can be written");
}
