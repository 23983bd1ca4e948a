//! How tables look to readers who tell fewer colours apart, in numbers.
//!
//! Colour blindness after Machado, Oliveira, Fernandes, "A Physiologically-based Model for Simulation of Color Vision
//! Deficiency", 2009, severity 1, in linear light; differences by CIEDE2000 (Sharma, Wu, Dalal, "The CIEDE2000
//! Color-Difference Formula: Implementation Notes", 2005).

use crate::color::LinearRgb;
use crate::lookup::ColorTable;
use crate::lookup::mixing::{lab_from_linear, times};
use crate::lookup::tables::{self, Kind};
use crate::math::exact;

/// Whose eyes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vision {
    /// Three kinds of cones.
    Usual,
    /// Without the red-sensitive cones; about one man in a hundred.
    Protanopia,
    /// Without the green-sensitive cones; about one man in a hundred, and five in a milder form.
    Deuteranopia,
    /// Without the blue-sensitive cones; rare.
    Tritanopia,
}

/// More bands than a legend's reader can name.
pub const MOST_BANDS: usize = 12;

/// The CIEDE2000 difference that neighbouring bands should have at least.
pub const CLEARLY_APART: f64 = 5.0;

/// A colour as it looks to such eyes.
pub fn seen_by(vision: Vision, color: LinearRgb) -> LinearRgb {
    let matrix = match vision {
        Vision::Usual => return color,
        Vision::Protanopia => {
            [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
        }
        Vision::Deuteranopia => {
            [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
        }
        Vision::Tritanopia => {
            [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
        }
    };
    times(&matrix, color.map(f64::from)).map(|x| x.clamp(0.0, 1.0) as f32)
}

/// CIE lightness, 0 black to 100 white.
pub fn lightness(color: LinearRgb) -> f64 {
    lab_from_linear(color)[0]
}

/// How different two colours look (CIEDE2000): about 1 can just be seen side by side.
pub fn difference(a: LinearRgb, b: LinearRgb) -> f64 {
    ciede2000(lab_from_linear(a), lab_from_linear(b))
}

fn ciede2000(p: [f64; 3], q: [f64; 3]) -> f64 {
    let pow7 = |x: f64| x * x * x * x * x * x * x;
    const P25_7: f64 = 6_103_515_625.0;
    let chroma = |a: f64, b: f64| (a * a + b * b).sqrt();
    let degrees = |x: f64| x.to_degrees().rem_euclid(360.0);
    let (sin, cos) = (|deg: f64| exact::sin(deg.to_radians()), |deg: f64| exact::cos(deg.to_radians()));

    // Chroma and hue, with the a axis stretched near grey.
    let mean = (chroma(p[1], p[2]) + chroma(q[1], q[2])) * 0.5;
    let stretch = 1.5 - 0.5 * (pow7(mean) / (pow7(mean) + P25_7)).sqrt();
    let polar = |[_, a, b]: [f64; 3]| {
        let a = a * stretch;
        (chroma(a, b), if a == 0.0 && b == 0.0 { 0.0 } else { degrees(exact::atan2(b, a)) })
    };
    let ((c1, h1), (c2, h2)) = (polar(p), polar(q));

    // Differences, hue the short way round.
    let is_grey = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if is_grey => 0.0,
        d if d > 180.0 => d - 360.0,
        d if d < -180.0 => d + 360.0,
        d => d,
    };
    let (dl, dc, dh) = (q[0] - p[0], c2 - c1, 2.0 * (c1 * c2).sqrt() * sin(turn * 0.5));

    // Means, and how much each difference counts there.
    let (l, c) = ((p[0] + q[0]) * 0.5, (c1 + c2) * 0.5);
    let h = match h1 + h2 {
        sum if is_grey => sum,
        sum if (h1 - h2).abs() <= 180.0 => sum * 0.5,
        sum if sum < 360.0 => (sum + 360.0) * 0.5,
        sum => (sum - 360.0) * 0.5,
    };
    let t = 1.0 - 0.17 * cos(h - 30.0) + 0.24 * cos(2.0 * h) + 0.32 * cos(3.0 * h + 6.0) - 0.20 * cos(4.0 * h - 63.0);
    let off_middle = (l - 50.0) * (l - 50.0);
    let s_l = 1.0 + 0.015 * off_middle / (20.0 + off_middle).sqrt();
    let (s_c, s_h) = (1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let near_blue = (h - 275.0) / 25.0;
    let rotation = -sin(60.0 * exact::exp(-near_blue * near_blue)) * 2.0 * (pow7(c) / (pow7(c) + P25_7)).sqrt();
    let (l, c, h) = (dl / s_l, dc / s_c, dh / s_h);
    (l * l + c * c + h * h + rotation * c * h).max(0.0).sqrt()
}

/// What a reader of a picture with this table should be spared, in sentences; with `n_bands`, of the table cut into bands.
pub fn warnings(table: &ColorTable, n_bands: Option<usize>) -> Vec<String> {
    let mut out = Vec::new();
    let info = tables::info_of(table);
    let name = info.map_or("this table", |i| i.name);
    if info.is_some_and(|i| i.kind == Kind::Rainbow) {
        out.push(format!(
            "{name} is a rainbow: it shows edges where the data has none, and hides some that it has; try viridis or batlow"
        ));
    } else if info.is_none() && n_turns(table) > 2 {
        out.push(format!(
            "{name} gets lighter and darker {} times over; values are hard to read off it",
            n_turns(table)
        ));
    }
    let Some(n) = n_bands.filter(|n| *n > 0) else { return out };
    if n > MOST_BANDS {
        out.push(format!("{n} bands are more than a reader tells apart; {MOST_BANDS} are the most that can be named"));
    }
    let bands: Vec<LinearRgb> = (0..n).map(|i| band(table, i, n)).collect();
    for (vision, who) in [
        (Vision::Usual, "anyone"),
        (Vision::Protanopia, "a reader who sees no red (protanopia)"),
        (Vision::Deuteranopia, "a reader who sees no green (deuteranopia)"),
    ] {
        let apart = |w: &[LinearRgb]| difference(seen_by(vision, w[0]), seen_by(vision, w[1]));
        let alike = bands.windows(2).filter(|w| apart(w) < CLEARLY_APART).count();
        if alike > 0 {
            out.push(format!("{alike} of {} neighbouring bands of {name} look alike to {who}", n - 1));
            break;
        }
    }
    out
}

/// The colour in the middle of a band.
fn band(table: &ColorTable, i: usize, n: usize) -> LinearRgb {
    let [r, g, b, _] = table.colors[(2 * i + 1) * table.colors.len() / (2 * n)];
    [r, g, b]
}

/// How often lightness changes its way by more than the eye overlooks.
fn n_turns(table: &ColorTable) -> usize {
    const OVERLOOKED: f64 = 4.0;
    let (mut turns, mut rising, mut extreme) = (0, None, f64::NAN);
    for [r, g, b, _] in &table.colors {
        let l = lightness([*r, *g, *b]);
        if extreme.is_nan() {
            extreme = l;
        }
        let onward = match rising {
            None => (l - extreme).abs(),
            Some(true) => l - extreme,
            Some(false) => extreme - l,
        };
        match rising {
            None if onward > OVERLOOKED => (rising, extreme) = (Some(l > extreme), l),
            None => {}
            Some(_) if onward >= 0.0 => extreme = l,
            Some(way) if onward < -OVERLOOKED => (turns, rising, extreme) = (turns + 1, Some(!way), l),
            Some(_) => {}
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;

    const EYES: [Vision; 3] = [Vision::Usual, Vision::Protanopia, Vision::Deuteranopia];

    fn named(name: &str) -> ColorTable {
        ColorTable::named(name).expect("a known name")
    }

    fn colors(table: &ColorTable) -> Vec<LinearRgb> {
        table.colors.iter().map(|c| [c[0], c[1], c[2]]).collect()
    }

    /// Pairs of the authors' test data.
    #[test]
    fn differences_are_those_of_the_formulas_authors() {
        for (p, q, wanted) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0),
            ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
            ([90.8027, -2.0831, 1.4410], [91.1528, -1.6435, 0.0447], 1.4441),
            ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
        ] {
            let (got, back) = (ciede2000(p, q), ciede2000(q, p));
            assert!((got - wanted).abs() < 1e-4 && (got - back).abs() < 1e-9, "{p:?} {q:?}: {got}, not {wanted}");
        }
    }

    #[test]
    fn greys_look_the_same_to_all() {
        for vision in [Vision::Usual, Vision::Protanopia, Vision::Deuteranopia, Vision::Tritanopia] {
            let grey = seen_by(vision, [0.4; 3]);
            assert!(grey.iter().all(|c| (c - 0.4).abs() < 1e-5), "{vision:?}: {grey:?}");
        }
        let (red, green) = ([0.5, 0.1, 0.1], [0.25, 0.2, 0.1]);
        let apart = |v| difference(seen_by(v, red), seen_by(v, green));
        assert!(apart(Vision::Deuteranopia) < 0.5 * apart(Vision::Usual));
    }

    #[test]
    fn default_tables_can_be_read_by_all() {
        for name in ["viridis", "batlow", "vik", "cividis"] {
            let table = named(name);
            let is_diverging = tables::info(name).is_some_and(|i| i.kind == Kind::Diverging);
            let colors = colors(&table);
            for vision in EYES {
                // Lightness goes one way, or up to the middle and down again; bytes make it tremble a little.
                let lightness: Vec<f64> = colors.iter().map(|c| lightness(seen_by(vision, *c))).collect();
                let peak = if is_diverging { 128 } else { 256 };
                let falls = lightness[..peak].windows(2).map(|w| w[0] - w[1]).fold(0.0, f64::max);
                let rises = lightness[peak.min(255)..].windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
                assert!(falls < 0.35 && rises < 0.35, "{name} {vision:?}: {falls} {rises}");
                let bands: Vec<LinearRgb> = (0..8).map(|i| seen_by(vision, band(&table, i, 8))).collect();
                let least = bands.windows(2).map(|w| difference(w[0], w[1])).fold(f64::INFINITY, f64::min);
                assert!(least >= CLEARLY_APART, "{name} {vision:?}: {least}");
            }
            assert_eq!(warnings(&table, Some(8)), Vec::<String>::new(), "{name}");
        }
    }

    #[test]
    fn categories_are_told_apart_by_all() {
        for name in ["okabe-ito", "petroff10"] {
            let colors = colors(&named(name));
            for vision in EYES {
                let seen: Vec<LinearRgb> = colors.iter().map(|c| seen_by(vision, *c)).collect();
                for i in 0..seen.len() {
                    let least = seen[..i].iter().map(|c| difference(*c, seen[i])).fold(f64::INFINITY, f64::min);
                    assert!(least > CLEARLY_APART, "{name} {vision:?} entry {i}: {least}");
                }
            }
        }
    }

    #[test]
    fn tables_that_mislead_are_told() {
        let says = |table: &ColorTable, n, what: &str| {
            let said = warnings(table, n);
            assert!(said.iter().any(|s| s.contains(what)), "{said:?}");
        };
        for name in ["jet", "turbo", "cet-rainbow", "Jet_r"] {
            says(&named(name), None, "rainbow");
        }
        says(&named("viridis"), Some(20), "20 bands are more");
        says(&named("viridis"), Some(40), "look alike");
        let of = |x: f32| [x, x, x, 1.0];
        says(&ColorTable::over([0.0, 1.0], [0.0, 0.9, 0.1, 0.8, 0.0].map(of).into()), None, "3 times over");
        for name in ["viridis", "coolwarm", "twilight", "oslo", "okabe-ito"] {
            assert_eq!(warnings(&named(name), None), Vec::<String>::new(), "{name}");
        }
    }
}
