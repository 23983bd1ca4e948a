//! Colours between colours: the spaces that tables are mixed in.
//!
//! OKLab after Björn Ottosson, "A perceptual color space for image processing", 2020; CIE Lab with a D65 white; Msh after
//! Moreland, "Diverging color maps for scientific visualization", 2009.

use crate::color::{LinearRgb, LinearRgba, linear_from_srgb, srgb_from_linear};
use crate::math::exact;

/// In which space two colours are mixed. Opacity is mixed as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mix {
    /// Even steps for the eye, without the grey that sRGB has between blue and yellow.
    OkLab,
    /// Between the numbers of the file, as most programs do it.
    Srgb,
    /// CIE Lab.
    Lab,
    /// Hue the short way round.
    Hsv,
    /// Moreland's Msh, over white where both colours are saturated and of different hue.
    Diverging,
    /// Not at all: each stop holds until the next.
    Step,
}

/// `n` colours at even steps from the first stop to the last; stops rise, and two at one place make an edge.
pub(super) fn sampled(stops: &[(f64, LinearRgba)], n: usize, mix: Mix) -> Vec<LinearRgba> {
    assert!(!stops.is_empty() && n > 0, "a colour table needs a colour");
    let (first, last) = (stops[0].0, stops[stops.len() - 1].0);
    let of = |i: usize| {
        let x = first + (last - first) * (i as f64 / (n - 1).max(1) as f64);
        let after = if i + 1 == n { stops.len() } else { stops.partition_point(|s| s.0 <= x) };
        let (a, b) = (stops[after.max(1) - 1], stops[after.min(stops.len() - 1)]);
        if b.0 > a.0 { between(a.1, b.1, ((x - a.0) / (b.0 - a.0)).clamp(0.0, 1.0), mix) } else { a.1 }
    };
    (0..n).map(of).collect()
}

fn between(a: LinearRgba, b: LinearRgba, t: f64, mix: Mix) -> LinearRgba {
    let [p, q] = [a, b].map(|c| [c[0], c[1], c[2]]);
    let even = |p: [f64; 3], q: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| p[c] + (q[c] - p[c]) * t) };
    let [r, g, b_] = match mix {
        _ if t == 0.0 => p,
        Mix::Step => p,
        Mix::OkLab => linear_from_oklab(even(oklab_from_linear(p), oklab_from_linear(q))),
        Mix::Srgb => from_srgb(even(to_srgb(p), to_srgb(q))),
        Mix::Lab => linear_from_lab(even(lab_from_linear(p), lab_from_linear(q))),
        Mix::Hsv => {
            let (mut u, mut v) = (hsv_from_srgb(to_srgb(p)), hsv_from_srgb(to_srgb(q)));
            // A grey has the other's hue; hues go the short way.
            if u[1] == 0.0 {
                u[0] = v[0]
            }
            if v[1] == 0.0 {
                v[0] = u[0]
            }
            v[0] += if v[0] - u[0] > 0.5 {
                -1.0
            } else if u[0] - v[0] > 0.5 {
                1.0
            } else {
                0.0
            };
            from_srgb(srgb_from_hsv(even(u, v)))
        }
        Mix::Diverging => linear_from_lab(diverging(lab_from_linear(p), lab_from_linear(q), t)),
    };
    [r, g, b_, a[3] + (b[3] - a[3]) * t as f32]
}

fn to_srgb(c: LinearRgb) -> [f64; 3] {
    c.map(|x| srgb_from_linear(x.clamp(0.0, 1.0) as f64))
}

fn from_srgb(c: [f64; 3]) -> LinearRgb {
    c.map(|x| linear_from_srgb(x.clamp(0.0, 1.0)) as f32)
}

/// Björn Ottosson's matrices: linear light to the cones' cubes, and their roots to lightness and two opponents.
const CONES: [[f64; 3]; 3] = [
    [0.4122214708, 0.5363325363, 0.0514459929],
    [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
];
const OPPONENTS: [[f64; 3]; 3] = [
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
];
const ROOTS: [[f64; 3]; 3] =
    [[1.0, 0.3963377774, 0.2158037573], [1.0, -0.1055613458, -0.0638541728], [1.0, -0.0894841775, -1.2914855480]];
const LIGHT: [[f64; 3]; 3] = [
    [4.0767416621, -3.3077115913, 0.2309699292],
    [-1.2684380046, 2.6097574011, -0.3413193965],
    [-0.0041960863, -0.7034186147, 1.7076147010],
];

pub(super) fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn oklab_from_linear(c: LinearRgb) -> [f64; 3] {
    times(&OPPONENTS, times(&CONES, c.map(f64::from)).map(exact::cbrt))
}

fn linear_from_oklab(lab: [f64; 3]) -> LinearRgb {
    times(&LIGHT, times(&ROOTS, lab).map(|x| x * x * x)).map(|x| x.clamp(0.0, 1.0) as f32)
}

/// Linear light to CIE Lab, D65.
pub(super) fn lab_from_linear(c: LinearRgb) -> [f64; 3] {
    const XYZ: [[f64; 3]; 3] =
        [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]];
    const WHITE: [f64; 3] = [0.95047, 1.0, 1.08883];
    let xyz = times(&XYZ, c.map(f64::from));
    let root = |t: f64| if t > 216.0 / 24389.0 { exact::cbrt(t) } else { t * (841.0 / 108.0) + 4.0 / 29.0 };
    let [x, y, z] = [0, 1, 2].map(|i| root(xyz[i] / WHITE[i]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The reverse of [`lab_from_linear`], within [0, 1].
fn linear_from_lab([l, a, b]: [f64; 3]) -> LinearRgb {
    const RGB: [[f64; 3]; 3] =
        [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]];
    let y = (l + 16.0) / 116.0;
    let cube = |f: f64| if f > 6.0 / 29.0 { f * f * f } else { (f - 4.0 / 29.0) * (108.0 / 841.0) };
    let xyz = [0.95047 * cube(y + a / 500.0), cube(y), 1.08883 * cube(y - b / 200.0)];
    times(&RGB, xyz).map(|x| x.clamp(0.0, 1.0) as f32)
}

fn hsv_from_srgb([r, g, b]: [f64; 3]) -> [f64; 3] {
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    let span = most - least;
    let hue = match () {
        _ if span == 0.0 => 0.0,
        _ if most == r => (g - b) / span,
        _ if most == g => 2.0 + (b - r) / span,
        _ => 4.0 + (r - g) / span,
    };
    [(hue / 6.0).rem_euclid(1.0), if most > 0.0 { span / most } else { 0.0 }, most]
}

fn srgb_from_hsv([h, s, v]: [f64; 3]) -> [f64; 3] {
    [5.0, 3.0, 1.0].map(|n: f64| {
        let k = (n + 6.0 * h).rem_euclid(6.0);
        v - v * s * k.min(4.0 - k).clamp(0.0, 1.0)
    })
}

/// Between two colours of CIE Lab by Moreland's rule.
fn diverging(p: [f64; 3], q: [f64; 3], t: f64) -> [f64; 3] {
    let (mut p, mut q, mut t) = (msh(p), msh(q), t);
    // Two saturated colours of different hue meet at white.
    if p[1] > 0.05 && q[1] > 0.05 && hue_distance(p[2], q[2]) > std::f64::consts::FRAC_PI_3 {
        let white = p[0].max(q[0]).max(88.0);
        if t < 0.5 {
            (q, t) = ([white, 0.0, 0.0], 2.0 * t);
        } else {
            (p, t) = ([white, 0.0, 0.0], 2.0 * t - 1.0);
        }
    }
    if p[1] < 0.05 && q[1] > 0.05 {
        p[2] = spun(q, p[0]);
    } else if q[1] < 0.05 && p[1] > 0.05 {
        q[2] = spun(p, q[0]);
    }
    let [m, s, h]: [f64; 3] = std::array::from_fn(|c| p[c] + (q[c] - p[c]) * t);
    [m * exact::cos(s), m * exact::sin(s) * exact::cos(h), m * exact::sin(s) * exact::sin(h)]
}

/// Lab in polar form: length, angle from the grey axis, hue.
fn msh([l, a, b]: [f64; 3]) -> [f64; 3] {
    let m = (l * l + a * a + b * b).sqrt();
    let s = if m > 0.001 { exact::acos((l / m).clamp(-1.0, 1.0)) } else { 0.0 };
    [m, s, if s > 0.001 { exact::atan2(b, a) } else { 0.0 }]
}

fn hue_distance(a: f64, b: f64) -> f64 {
    let d = (a - b).abs();
    d.min(2.0 * std::f64::consts::PI - d)
}

/// The hue a grey of length `m` takes beside a saturated colour, so that steps look equal.
fn spun([m_saturated, s, h]: [f64; 3], m: f64) -> f64 {
    if m_saturated >= m - 0.1 {
        return h;
    }
    let spin = s * (m * m - m_saturated * m_saturated).sqrt() / (m_saturated * exact::sin(s));
    if h > -std::f64::consts::FRAC_PI_3 { h + spin } else { h - spin }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{linear_from_bytes, srgb8_from_linear};
    use crate::lookup::ColorTable;

    fn of(bytes: [u8; 3]) -> LinearRgba {
        let [r, g, b] = linear_from_bytes(bytes);
        [r, g, b, 1.0]
    }

    fn bytes(c: LinearRgba) -> [u8; 3] {
        [0, 1, 2].map(|k| srgb8_from_linear(c[k]))
    }

    #[test]
    fn every_space_brings_a_colour_back() {
        for c in [[12, 200, 90], [255, 255, 255], [0, 0, 0], [255, 0, 0], [3, 4, 250]] {
            for mix in [Mix::OkLab, Mix::Srgb, Mix::Lab, Mix::Hsv, Mix::Diverging, Mix::Step] {
                assert_eq!(bytes(between(of(c), of(c), 0.5, mix)), c, "{mix:?}");
            }
        }
    }

    #[test]
    fn stops_are_met_and_edges_stay_sharp() {
        let (black, white, red) = (of([0; 3]), of([255; 3]), of([255, 0, 0]));
        let made = sampled(&[(0.0, black), (0.5, white), (0.5, red), (1.0, red)], 101, Mix::Srgb);
        assert_eq!(made.iter().map(|c| bytes(*c)).filter(|c| *c == [255, 0, 0]).count(), 51);
        assert_eq!((bytes(made[0]), bytes(made[25]), bytes(made[49])), ([0; 3], [128; 3], [250; 3]));
        assert_eq!(sampled(&[(3.0, red)], 2, Mix::OkLab), [red, red]);
        let steps = sampled(&[(0.0, black), (1.0, white), (2.0, red)], 5, Mix::Step);
        assert_eq!(steps, [black, black, white, white, red]);
    }

    #[test]
    fn mixing_over_white_gives_morelands_table() {
        let made = sampled(&[(0.0, of([59, 76, 192])), (1.0, of([180, 4, 38]))], 256, Mix::Diverging);
        let wanted = ColorTable::named("coolwarm").expect("known").colors;
        for (a, b) in made.iter().zip(&wanted) {
            let (a, b) = (bytes(*a), bytes(*b));
            assert!((0..3).all(|c| a[c].abs_diff(b[c]) <= 4), "{a:?} {b:?}");
        }
    }
}
