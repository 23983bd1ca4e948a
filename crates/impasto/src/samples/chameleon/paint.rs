//! The chameleon's dress, painted in sRGB numbers from the place on the body: greens that run into teal, warm saddles
//! across the back, pale dots along the flanks, a light belly, a smile.

use crate::math::{DVec2, vec2};
use crate::noise::{Lattice, cellular_2d, fbm_2d};
use crate::samples::chameleon::shape::{Kind, Piece, PieceShape, landmark, smooth, sq};
use std::f64::consts::PI;

type Rgb = [f32; 3];

/// The sRGB colour of a chart place. `texel` is a texel's width in model units: no edge is sharper.
pub(super) fn color(piece: &Piece, chart: DVec2, texel: f64, seed: u32) -> Rgb {
    match &piece.shape {
        PieceShape::Tube(tube) => {
            let (s, angle) = tube.locate(chart);
            let across = chart.y - 0.5 * tube.chart_size().y;
            let at = Skin { s, angle, across, texel, seed };
            match piece.kind {
                Kind::Body => body(&at),
                Kind::Leg => leg(&at, piece.root),
                Kind::Foot => foot(&at, tube.chart_size().x),
                Kind::Twig => twig(&at, *tube.stations.last().unwrap_or(&1.0)),
                _ => leaf(&at, tube.chart_size().x),
            }
        }
        PieceShape::Dome(dome) => {
            let (radius, turn) = dome.locate(chart);
            match piece.kind {
                Kind::Lid => lid(radius, turn, chart, texel, seed),
                Kind::Iris => iris(radius, turn, texel),
                _ => pupil(radius, turn, texel),
            }
        }
    }
}

/// A place on a tube.
struct Skin {
    /// Distance along the spine.
    s: f64,
    /// From the back, -pi to pi.
    angle: f64,
    /// Distance from the back line around the body.
    across: f64,
    texel: f64,
    seed: u32,
}

fn body(at: &Skin) -> Rgb {
    let Skin { s, angle, .. } = *at;
    let around = angle.abs();
    let wander = wave(at, 1.3, 1) as f64;
    let mut c = scales(along(&BACK, s), at);
    // The light belly, with a soft edge that wanders.
    let belly_edge = 1.95 + 0.14 * wander + 0.35 * smooth(3.2, 5.0, s) - 0.12 * smooth(1.2, 0.0, s);
    c = mix(c, scales(along(&BELLY, s), at), smooth(belly_edge - 0.22, belly_edge + 0.30, around));
    // A darker ridge along the back.
    c = mix(
        c,
        shade(along(&BACK, s), 0.78),
        0.55 * (1.0 - smooth(0.0, 0.42 + 0.1 * wander, around)) * smooth(0.5, 1.2, s),
    );
    c = saddles(c, at, wander);
    c = dots(c, at);
    face(c, at)
}

/// Colours along the back and along the belly, at distances from the nose.
const BACK: [(f64, u32); 7] = [
    (0.0, 0xb5d94c),
    (0.8, 0x8fcf4b),
    (1.8, 0x58bd5c),
    (2.9, 0x27a87a),
    (4.2, 0x12949a),
    (6.5, 0x1a80a8),
    (9.0, 0x3a6fb0),
];
const BELLY: [(f64, u32); 5] = [(0.0, 0xf3f2b4), (1.5, 0xeef3bd), (3.0, 0xd2efc6), (4.5, 0x8fdcca), (8.0, 0x6fc3d8)];

/// Warm bands that hang from the back like saddles and close to rings on the tail.
fn saddles(c: Rgb, at: &Skin, wander: f64) -> Rgb {
    const PERIOD: f64 = 0.44;
    let first = landmark::NECK + 0.22;
    let s = at.s + 0.035 * wander;
    let k = ((s - first) / PERIOD).round().max(0.0);
    let d = (s - first - k * PERIOD).abs();
    let on_tail = smooth(landmark::TAIL - 0.5, landmark::TAIL + 0.6, at.s);
    let around = at.angle.abs();
    let reach = 1.72 + 0.12 * if k as i64 % 2 == 0 { 1.0 } else { -1.0 };
    let taper = (1.0 - (around / reach) * (around / reach)).max(0.0) * (1.0 - on_tail) + on_tail * 0.85;
    let half = (0.118 - 0.055 * smooth(4.0, 9.0, at.s)) * taper.sqrt();
    let warm = along(&[(1.8, 0xffc247), (2.8, 0xfb9b3d), (3.8, 0xf47b4a), (5.5, 0xf06a5c), (8.0, 0xf58f6e)], at.s);
    let fade = smooth(landmark::NECK - 0.05, landmark::NECK + 0.2, at.s);
    // A dark rim, then the band, then a light heart.
    let rim = edge(half + 0.028 - d, at.texel) * smooth(0.01, 0.05, half) * fade;
    let c = mix(c, shade(along(&BACK, at.s), 0.58), 0.8 * rim);
    let c = mix(c, scales(warm, at), edge(half - d, at.texel) * fade);
    mix(c, rgb(0xfff0b8), 0.75 * edge(half * 0.32 - d, at.texel) * fade * (1.0 - on_tail) * smooth(1.3, 0.5, around))
}

/// Two rows of pale dots on each flank, between the saddles.
fn dots(c: Rgb, at: &Skin) -> Rgb {
    const PERIOD: f64 = 0.44;
    let first = landmark::NECK;
    let k = ((at.s - first) / PERIOD).round();
    let fade = 1.0 - smooth(landmark::TAIL - 0.2, landmark::TAIL + 0.8, at.s);
    let mut c = c;
    for (row_angle, shift, radius) in [(1.12, 0.0, 0.058), (1.62, 0.5, 0.040), (0.62, 0.0, 0.034)] {
        let k = if shift == 0.0 { k } else { ((at.s - first) / PERIOD - shift).round() + shift };
        let ds = at.s - first - k * PERIOD;
        // Arc length from the row: angle difference times the local radius.
        let local = if at.angle.abs() > 1e-3 { at.across / at.angle } else { 0.5 };
        let da = (at.angle.abs() - row_angle) * local;
        let d = (ds * ds + da * da).sqrt();
        let here = k >= 0.0 && at.s > first - 0.2;
        let r = if here { radius * fade } else { 0.0 };
        c = mix(c, shade(along(&BACK, at.s), 0.6), 0.7 * edge(r + 0.016 - d, at.texel) * smooth(0.0, 0.01, r));
        c = mix(c, rgb(0xfff4bf), edge(r - d, at.texel));
    }
    c
}

/// Smile, nostrils, cheeks, and the stripes of the helmet.
fn face(c: Rgb, at: &Skin) -> Rgb {
    let Skin { s, angle, texel, .. } = *at;
    let around = angle.abs();
    if s > 2.3 {
        return c;
    }
    let local = (at.across / if angle.abs() > 1e-3 { angle } else { 1.0 }).max(0.05);
    let mut c = c;
    // Three warm stripes run down the helmet behind the eye.
    for (k, reach) in [(0.0, 0.95), (1.0, 0.80), (2.0, 0.62)] {
        let d = (s - 1.12 - 0.2 * k - 0.16 * around).abs();
        let half = 0.042 * (1.0 - sq(around / reach)).max(0.0).sqrt();
        c = mix(c, rgb(0xffb443), 0.9 * edge(half - d, texel));
    }
    // Cheeks.
    let d = (sq(s - 0.99) + sq((around - 1.98) * local)).sqrt();
    c = mix(c, rgb(0xf98a68), 0.62 * (1.0 - smooth(0.05, 0.20, d)));
    // The mouth: lips a little lighter below, the line itself dark, its corner turned up.
    let t = s / landmark::MOUTH_CORNER;
    let mouth = 1.76 + 0.30 * smooth(0.0, 0.55, t) - 0.42 * smooth(0.55, 1.04, t);
    let d = (around - mouth) * local;
    let on = 1.0 - smooth(landmark::MOUTH_CORNER - 0.01, landmark::MOUTH_CORNER + 0.015, s);
    c = mix(c, rgb(0xf7f5c6), 0.5 * on * smooth(-0.005, 0.01, d) * (1.0 - smooth(0.02, 0.10, d)));
    let width = 0.017 * (1.0 - 0.35 * t);
    c = mix(c, rgb(0x1c4a35), on * edge(width - d.abs(), texel));
    let corner = (sq(s - landmark::MOUTH_CORNER) + sq(d)).sqrt();
    c = mix(c, rgb(0x1c4a35), edge(0.024 - corner, texel));
    // Nostrils.
    let d = (sq((s - 0.17) / 1.3) + sq((around - 0.75) * local)).sqrt();
    mix(c, rgb(0x2c5a34), 0.9 * edge(0.024 - d, texel))
}

fn leg(at: &Skin, root: f64) -> Rgb {
    // Legs go on from the flank's colour and end a little lighter and bluer.
    let mut c = along(&BACK, root - 0.1 + 0.9 * at.s);
    c = mix(c, rgb(0x35b5a0), 0.5 * smooth(0.3, 1.1, at.s));
    c = scales(c, at);
    for k in 0..3 {
        let d = (at.s - 0.42 - 0.25 * k as f64 + 0.03 * wave(at, 2.0, 5) as f64).abs();
        let half = 0.052 * (1.0 - sq(at.angle / 1.9)).max(0.0).sqrt();
        c = mix(c, shade(c, 0.62), 0.7 * edge(half + 0.02 - d, at.texel) * smooth(0.0, 0.02, half));
        c = mix(c, rgb(0xfba043), edge(half - d, at.texel));
    }
    c
}

fn foot(at: &Skin, length: f64) -> Rgb {
    let from_tip = at.s.min(length - at.s);
    let c = scales(mix(rgb(0x2fae9d), rgb(0x57c7a2), smooth(0.35, 0.1, from_tip)), at);
    // Finger line and two pale nails at each tip.
    let c = mix(c, rgb(0x14736f), 0.8 * edge(0.010 - at.across.abs(), at.texel) * smooth(0.27, 0.22, from_tip));
    let nail = (sq(from_tip - 0.035) + sq((at.across.abs() - 0.055) * 1.2)).sqrt();
    mix(c, rgb(0xfff1cf), edge(0.036 - nail, at.texel))
}

fn lid(radius: f64, turn: f64, chart: DVec2, texel: f64, seed: u32) -> Rgb {
    let at = Skin { s: chart.x, angle: 0.0, across: chart.y, texel, seed };
    let base = mix(rgb(0xc9e35c), rgb(0x74c653), smooth(0.30, 0.75, radius));
    let mut c = scales(base, &at);
    // Rays of warm colour around the opening, then its dark edge.
    let ray = 0.5 + 0.5 * crate::math::exact::cos(12.0 * turn);
    c = mix(c, rgb(0xff9a3c), 0.85 * smooth(0.35, 0.65, ray) * smooth(0.31, 0.34, radius) * smooth(0.56, 0.40, radius));
    mix(c, rgb(0x1d3b30), 1.0 - smooth(0.285, 0.30, radius))
}

fn iris(radius: f64, turn: f64, texel: f64) -> Rgb {
    use crate::math::exact::cos;
    let spoke = 0.5 + 0.3 * cos(17.0 * turn) + 0.2 * cos(31.0 * turn + 1.0);
    let c = mix(rgb(0xffd75e), rgb(0xf08a24), smooth(0.10, 0.25, radius));
    let c = mix(c, rgb(0xb9561a), 0.35 * spoke * smooth(0.12, 0.2, radius));
    mix(c, rgb(0x3a1d10), edge(radius - 0.232, texel.max(0.012)))
}

fn pupil(radius: f64, turn: f64, texel: f64) -> Rgb {
    use crate::math::exact::{cos, sin};
    let c = mix(rgb(0x14161c), rgb(0x2b1a14), smooth(0.05, 0.2, radius));
    // A painted sparkle: a big one above left, a small one below right.
    let (x, y) = (radius * cos(turn), radius * sin(turn));
    let big = (sq(x + 0.045) + sq(y + 0.055)).sqrt();
    let small = (sq(x - 0.05) + sq(y - 0.055)).sqrt();
    let c = mix(c, rgb(0xffffff), edge(0.038 - big, texel));
    mix(c, rgb(0xd8efff), 0.8 * edge(0.017 - small, texel))
}

fn twig(at: &Skin, length: f64) -> Rgb {
    let l = Lattice::seeded(at.seed.wrapping_add(9));
    // Long fibres: noise stretched along the twig.
    let fibre = fbm_2d(vec2(at.s as f32 * 2.2, at.across as f32 * 17.0), 4, 0.6, l).value as f64;
    let c = mix(rgb(0x8a5a3b), rgb(0x5d3a26), smooth(-0.25, 0.35, fibre));
    let c = mix(c, rgb(0xb98556), 0.6 * smooth(0.15, 0.45, -fibre));
    let moss = fbm_2d(vec2(at.s as f32 * 1.7, at.across as f32 * 2.5), 3, 0.5, l.octave()).value as f64;
    let c = mix(c, rgb(0x8fae4e), 0.55 * smooth(0.12, 0.4, moss - 0.12 * at.angle.abs() + 0.05));
    // The cut ends show the wood.
    let from_end = at.s.min(length - at.s);
    mix(c, rgb(0xe2bd84), smooth(0.035, 0.02, from_end))
}

fn leaf(at: &Skin, length: f64) -> Rgb {
    let t = at.s / length;
    let mut c = mix(rgb(0x6fb53c), rgb(0xa9d455), smooth(0.0, 1.0, t));
    c = mix(c, rgb(0xf2b84b), 0.55 * smooth(0.75, 1.0, t));
    // Across the leaf, from the midrib: the upper side is around the back line, the lower side around the seam.
    let under = at.angle.abs() > PI / 2.0;
    let out = crate::math::exact::sin(at.angle).abs();
    let vein = ((at.s - 0.14 * out) * 11.0).fract() - 0.5;
    c = mix(c, rgb(0xd9eb93), 0.5 * edge(0.07 - vein.abs(), 0.12) * smooth(0.03, 0.12, out) * smooth(0.95, 0.6, out));
    c = mix(c, rgb(0xe4f2a4), edge(0.10 * (1.0 - 0.6 * t) - out, 0.08));
    if under { mix(c, rgb(0xd6e8b0), 0.4) } else { c }
}

/// A fine net of scales: each a little lighter or darker than its neighbour, with a darker seam.
fn scales(c: Rgb, at: &Skin) -> Rgb {
    const PER_UNIT: f64 = 17.0;
    let l = Lattice::seeded(at.seed.wrapping_add(77));
    let p = vec2((at.s * PER_UNIT) as f32, (at.across * PER_UNIT) as f32);
    let cell = cellular_2d(p, 0.75, l);
    let own = crate::math::unit_float(crate::math::hash(cell.id)) as f64 - 0.5;
    let seam = smooth(0.30, 0.02, (cell.second - cell.nearest) as f64);
    shade(c, 1.0 + 0.09 * own - 0.10 * seam)
}

/// Slow noise on the skin, -1 to 1.
fn wave(at: &Skin, per_unit: f64, salt: u32) -> f32 {
    let p = vec2((at.s * per_unit) as f32, (at.across * per_unit) as f32);
    fbm_2d(p, 2, 0.5, Lattice::seeded(at.seed.wrapping_add(salt))).value
}

/// The colour at a distance along a row of stops, smoothly mixed.
fn along(stops: &[(f64, u32)], s: f64) -> Rgb {
    let i = stops.partition_point(|stop| stop.0 <= s).clamp(1, stops.len() - 1);
    let ((s0, c0), (s1, c1)) = (stops[i - 1], stops[i]);
    mix(rgb(c0), rgb(c1), ((s - s0) / (s1 - s0)).clamp(0.0, 1.0))
}

/// 0 outside, 1 inside, one and a half texels between; `inside` is a signed distance.
fn edge(inside: f64, texel: f64) -> f64 {
    (0.5 + inside / (1.5 * texel)).clamp(0.0, 1.0)
}

fn mix(a: Rgb, b: Rgb, t: f64) -> Rgb {
    let t = t as f32;
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
}

fn shade(c: Rgb, by: f64) -> Rgb {
    c.map(|x| x * by as f32)
}

fn rgb(hex: u32) -> Rgb {
    [hex >> 16 & 255, hex >> 8 & 255, hex & 255].map(|b| b as f32 / 255.0)
}
