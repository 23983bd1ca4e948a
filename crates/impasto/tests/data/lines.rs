//! Isolines are as wide as asked for, whatever the slope, and never flood.

use crate::oracle::{Seen, cone, front, plain, prepare, seen, sheet, value, with_values};
use impasto::math::{DVec3, Vec3};
use impasto::recipe::Prepared;
use std::collections::HashMap;

/// White lines on black, so that a channel is the line's share of the pixel.
fn lines(keys: &str) -> String {
    format!("surface = {{ color = '#000000' }}\n[[layers]]\ncolor = '#ffffff'\nmajor = 0\nfield = 'v'\n{keys}")
}

/// Widths of lines, measured along rows and columns where they cross them steeply, and turned by the value's own slope.
fn widths(prepared: &Prepared, value: impl Fn(&Seen) -> f64) -> Vec<f64> {
    let pixels = seen(prepared);
    let of_cell: HashMap<[u32; 2], (f64, f64)> =
        pixels.iter().map(|s| (s.cell, (value(s), s.light[0] as f64))).collect();
    let mut widths = Vec::new();
    for axis in 0..2 {
        let step = |cell: [u32; 2], by: i64, along: usize| {
            let mut cell = cell;
            cell[along] = (cell[along] as i64 + by) as u32;
            of_cell.get(&cell).copied()
        };
        let starts = pixels.iter().filter(|s| {
            let before = step(s.cell, -1, axis);
            s.light[0] > 0.0 && before.is_some_and(|(_, light)| light == 0.0)
        });
        for start in starts {
            // Along the line's cross section until it is dark again; a section that leaves the surface says nothing.
            let section: Vec<f64> =
                (0..).map_while(|k| step(start.cell, k, axis)).map(|(_, l)| l).take_while(|l| *l > 0.0).collect();
            if section.len() > 40 || step(start.cell, section.len() as i64, axis).is_none() {
                continue;
            }
            let brightest = (0..section.len()).max_by(|a, b| section[*a].total_cmp(&section[*b])).unwrap_or(0);
            let mut middle = start.cell;
            middle[axis] += brightest as u32;
            let slope = |along: usize| Some(step(middle, 1, along)?.0 - step(middle, -1, along)?.0);
            let (Some(x), Some(y)) = (slope(0), slope(1)) else { continue };
            let steepness = [x, y][axis].abs() / x.hypot(y);
            if steepness > 0.7 {
                widths.push(section.iter().sum::<f64>() * steepness);
            }
        }
    }
    widths
}

fn check(prepared: &Prepared, what: &str, width: f64, at_least: usize) {
    check_widths(prepared, what, (width, at_least, 0.25), |s| value(&prepared.scene.mesh, "v", Some(0), s));
}

/// At least so many cross sections of lines, all of that width.
pub(crate) fn check_widths(
    prepared: &Prepared,
    what: &str,
    (width, at_least, most_off): (f64, usize, f64),
    value: impl Fn(&Seen) -> f64,
) {
    let widths = widths(prepared, value);
    assert!(widths.len() >= at_least, "{what}: {} cross sections", widths.len());
    let worst = widths.iter().map(|w| (w - width).abs()).fold(0.0, f64::max);
    assert!(worst <= most_off, "{what}: widths are up to {worst} from {width}");
}

#[test]
fn widths_do_not_depend_on_the_slope() {
    for scale in [1e-12, 1e-6, 0.03, 1.0, 250.0, 1e9] {
        let raw = with_values(sheet(3, |_, _| 0.0), "v", |p| (p.x + 0.31 * p.y) * scale);
        for width in [1.0, 1.25, 2.5, 6.0] {
            let keys = format!("isolines = {:e}\nwidth = {width:?}", 0.15 * scale);
            let prepared = prepare(&raw, &format!("{}{}", front(200), lines(&keys)));
            check(&prepared, &format!("slope {scale}"), width, 1000);
        }
    }
}

#[test]
fn curved_lines_are_as_wide_as_straight_ones() {
    let rings = with_values(sheet(96, |_, _| 0.0), "v", |p| p.x.hypot(p.y));
    let prepared = prepare(
        &rings,
        &format!("{}{}", front(240), lines("isolines = 0.0\nlevels = [0.35, 0.5, 0.62, 0.85]\nwidth = 2.0")),
    );
    check(&prepared, "rings", 2.0, 800);
    let heights = with_values(cone(48), "v", |p| p.y * 3.0);
    let view = format!("camera = {{ azimuth = 20.0, elevation = 75.0 }}\n{}", plain(300));
    let prepared = prepare(
        &heights,
        &format!("{view}{}", lines("isolines = 0.0\nlevels = [0.2, 0.5, 0.8, 1.3, 1.6]\nwidth = 1.5")),
    );
    check(&prepared, "cone", 1.5, 500);
}

/// Strips across the sheet, each with a slope of its own along y; x carries the lines over all of them.
fn strips(slopes: &[f64], along_x: f64) -> impl Fn(DVec3) -> f64 {
    let slopes = slopes.to_vec();
    move |p: DVec3| {
        let (mut v, mut y) = (0.0, -1.0);
        let each = 2.0 / slopes.len() as f64;
        for slope in &slopes {
            let here = (p.y - y).clamp(0.0, each);
            v += slope * here;
            y += each;
        }
        v + along_x * p.x
    }
}

#[test]
fn lines_go_on_across_edges_of_different_slope() {
    // Eight strips whose slopes differ by up to four hundred, of both signs.
    let slopes = [0.0, 2.0, -40.0, 0.1, 3.0, -0.5, 20.0, -1.0];
    let truth = strips(&slopes, 3.0);
    let raw = with_values(sheet(8, |_, _| 0.0), "v", &truth);
    let prepared = prepare(&raw, &format!("{}{}", front(320), lines("isolines = 1.0\nwidth = 2.0")));
    let pixels = seen(&prepared);
    // Between two neighbours on either side of a level one of the two shows the line.
    let (mut n_crossed, mut n_gaps) = (0, 0);
    for i in 0..pixels.len() {
        let beside = [1, 320]
            .map(|k| pixels.get(i + k).filter(|b| i % 320 + k != 320 || k == 320 && b.cell[0] == pixels[i].cell[0]));
        for b in beside.into_iter().flatten() {
            let (v, w) = (truth(pixels[i].place), truth(b.place));
            if v.floor() != w.floor() {
                n_crossed += 1;
                n_gaps += (pixels[i].light[0].max(b.light[0]) < 0.4) as usize;
            }
        }
    }
    assert!(n_crossed > 2000 && n_gaps == 0, "{n_gaps} gaps among {n_crossed} crossings");
}

#[test]
fn plateaus_are_not_flooded() {
    // A hill with a flat top exactly on a level, and flat ground on another.
    let raw = with_values(sheet(10, |_, _| 0.0), "v", |p| {
        ((1.2 - p.x.abs().max(p.y.abs()) * 1.5).clamp(0.0, 0.6) * 10.0).round()
    });
    let prepared = prepare(&raw, &format!("{}{}", front(200), lines("isolines = 1.0\nwidth = 1.25")));
    let is_flat = |s: &Seen| {
        let mesh = &prepared.scene.mesh;
        let [a, b, c] = mesh.triangles()[s.triangle].map(|v| mesh.fields()[0].values.at(v as usize));
        a == b && b == c
    };
    let pixels = seen(&prepared);
    let flat: Vec<&Seen> = pixels.iter().filter(|s| is_flat(s)).collect();
    assert!(flat.len() > 5000 && flat.iter().all(|s| s.light[0] == 0.0), "flat faces have no line");
    let covered: f64 = pixels.iter().map(|s| s.light[0] as f64).sum();
    assert!(covered > 500.0 && covered < 0.2 * pixels.len() as f64, "{covered} pixels of line");
    // Constant for each face: no slope, no line.
    let mut raw = sheet(10, |_, _| 0.0);
    let values = (0..raw.triangles.len()).map(|i| i as f64 * 0.5).collect();
    raw.fields.push(crate::oracle::field("v", impasto::assets::Element::Face, 1, impasto::assets::Values::F64(values)));
    let prepared = prepare(&raw, &format!("{}{}", front(100), lines("isolines = 1.0")));
    assert!(seen(&prepared).iter().all(|s| s.light[0] == 0.0));
}

#[test]
fn lines_run_where_the_level_is() {
    let raw = with_values(sheet(1, |_, _| 0.0), "v", |p| p.x);
    for (keys, levels) in
        [("isolines = 0.5", vec![-0.5, 0.0, 0.5]), ("isolines = 0.0\nlevels = [-0.3, 0.77]", vec![-0.3, 0.77])]
    {
        let prepared = prepare(&raw, &format!("{}{}", front(200), lines(&format!("{keys}\nwidth = 1.0"))));
        for level in levels {
            let near = seen(&prepared).into_iter().filter(|s| s.cell[1] == 7 && (s.place.x - level).abs() < 0.05);
            let (sum, weighted) =
                near.fold((0.0, 0.0), |(a, b), s| (a + s.light[0] as f64, b + s.light[0] as f64 * s.place.x));
            assert!((weighted / sum - level).abs() < 0.1 / 100.0, "{keys}: {} for {level}", weighted / sum);
        }
    }
    // What faces away, or lies in the picture's plane, does no harm.
    let mut raw = raw;
    raw.positions.iter_mut().for_each(|p: &mut Vec3| p.z = p.x * 1e3);
    seen(&prepare(&raw, &format!("{}{}", front(50), lines("isolines = 0.5"))));
}
