//! The chameleon's anatomy: spines, sections, and where everything sits.

use crate::assets::RawMesh;
use crate::math::exact::{cos, exp, sin};
use crate::math::{DVec2, DVec3, Vec3};
use crate::samples::curve::Curve;
use crate::samples::sheet::{self, Point};
use crate::samples::tube::{Sweep, Tube};
use std::f64::consts::PI;

/// One closed surface with one chart.
pub(super) struct Piece {
    pub(super) kind: Kind,
    /// Index of the part it belongs to.
    pub(super) part: usize,
    pub(super) shape: PieceShape,
    /// Distance along the body's spine where it sits; added to that along the piece.
    pub(super) root: f64,
}

/// What a piece is painted as.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Body,
    Leg,
    Foot,
    Lid,
    Iris,
    Pupil,
    Twig,
    Leaf,
}

pub(super) enum PieceShape {
    Tube(Tube),
    Dome(Dome),
}

impl Piece {
    pub(super) fn chart_size(&self) -> DVec2 {
        match &self.shape {
            PieceShape::Tube(tube) => tube.chart_size(),
            PieceShape::Dome(dome) => DVec2::splat(2.0 * dome.reach()),
        }
    }
}

/// All pieces, with triangle edges of about this length.
pub(super) fn pieces(edge: f64) -> Vec<Piece> {
    let mut pieces = vec![tube_piece(Kind::Body, 0, 0.0, body(edge))];
    for side in [1.0, -1.0] {
        for leg in &LEGS {
            // The right legs stand a little further back: it walks.
            let shift = if side > 0.0 { leg.shift } else { -leg.shift };
            pieces.push(tube_piece(Kind::Leg, 0, leg.root, limb(leg, side, shift, edge)));
            pieces.push(tube_piece(Kind::Foot, 0, leg.root + 0.9, foot(leg, side, shift, edge)));
        }
        let gaze = if side > 0.0 { DVec3::new(0.50, 0.10, 0.86) } else { DVec3::new(0.62, 0.34, -0.70) }.normalize();
        let center = DVec3::new(EYE[0], EYE[1], EYE[2] * side);
        let dome = |kind, part, profile: &dyn Fn(f64) -> f64, offset: f64| {
            let shape = PieceShape::Dome(Dome::new(center + gaze * offset, gaze, profile, edge));
            pieces_of_eye(kind, part, shape)
        };
        pieces.push(dome(Kind::Lid, 0, &lid, 0.0));
        pieces.push(dome(Kind::Iris, 1, &|_| 0.315, 0.045));
        pieces.push(dome(Kind::Pupil, 2, &|_| 0.205, 0.172));
    }
    pieces.push(tube_piece(Kind::Twig, 3, 0.0, twig(edge)));
    pieces.push(tube_piece(Kind::Twig, 3, 0.0, shoot(edge)));
    for leaf_rows in &LEAVES {
        pieces.push(tube_piece(Kind::Leaf, 4, 0.0, leaf(leaf_rows, edge)));
    }
    pieces
}

fn tube_piece(kind: Kind, part: usize, root: f64, tube: Tube) -> Piece {
    Piece { kind, part, root, shape: PieceShape::Tube(tube) }
}

fn pieces_of_eye(kind: Kind, part: usize, shape: PieceShape) -> Piece {
    Piece { kind, part, root: 0.8, shape }
}

/// Places of landmarks along the body's spine, model units from the nose.
pub(super) mod landmark {
    pub(in crate::samples) const MOUTH_CORNER: f64 = 1.02;
    pub(in crate::samples) const NECK: f64 = 1.75;
    pub(in crate::samples) const TAIL: f64 = 3.55;
}

/// The eyeball's centre on the left side.
const EYE: [f64; 3] = [1.56, 1.70, 0.37];

/// Nose to tail's root: x, y, z, height above the spine, depth below, half width, helmet and crest.
const TRUNK: [[f64; 7]; 12] = [
    [2.30, 1.40, 0.0, 0.22, 0.20, 0.26, 0.00],
    [2.08, 1.42, 0.0, 0.30, 0.27, 0.36, 0.00],
    [1.80, 1.46, 0.0, 0.42, 0.36, 0.46, 0.03],
    [1.45, 1.50, 0.0, 0.54, 0.43, 0.54, 0.12],
    [1.10, 1.52, 0.0, 0.56, 0.46, 0.55, 0.38],
    [0.85, 1.50, 0.0, 0.52, 0.46, 0.50, 0.46],
    [0.58, 1.46, 0.0, 0.47, 0.45, 0.45, 0.16],
    [0.20, 1.38, 0.0, 0.56, 0.53, 0.51, 0.04],
    [-0.25, 1.30, 0.0, 0.66, 0.60, 0.57, 0.04],
    [-0.70, 1.22, 0.0, 0.60, 0.53, 0.52, 0.04],
    [-1.10, 1.16, 0.0, 0.42, 0.37, 0.38, 0.03],
    [-1.50, 1.14, 0.0, 0.30, 0.27, 0.28, 0.02],
];
/// Centre of the tail's spiral, its outer radius, how much closer each turn is, and how many turns there are.
const SPIRAL: ([f64; 2], f64, f64, f64) = ([-2.12, 0.22], 0.92, 0.38, 2.1);

fn body(edge: f64) -> Tube {
    let mut rows = TRUNK.to_vec();
    let ([cx, cy], radius, pitch, n_turns) = SPIRAL;
    const STEPS: usize = 14;
    let n = (n_turns * STEPS as f64) as usize;
    for i in 0..=n {
        let turn = i as f64 / STEPS as f64;
        let angle = PI / 2.0 + 2.0 * PI * turn;
        // The last part of the spiral closes up gently.
        let r = radius - pitch * turn * (1.0 - 0.06 * turn);
        let thick = 0.235 * (1.0 - turn / n_turns * 0.66);
        rows.push([
            cx + r * cos(angle),
            cy + r * sin(angle),
            0.0,
            thick,
            thick,
            thick * 0.95,
            0.02 * (1.0 - turn / n_turns),
        ]);
    }
    let spine = Curve::through(&rows);
    let is_fine = edge < 0.07;
    Tube::sweep(&Sweep {
        spine: &spine,
        caps: [0.30, 0.09],
        back: &|s| {
            let d = spine.direction(s);
            DVec3::new(d.y, -d.x, 0.0)
        },
        section: &|row, s, angle| {
            let (c, side) = (cos(angle), sin(angle));
            let up = if c > 0.0 { row[3] } else { row[4] };
            // The helmet and the crest stand on the back line and fall off to both sides.
            let lobe = exp(-(angle * angle) / 0.30);
            let teeth = if is_fine { 0.5 + 0.5 * cos(2.0 * PI * s / 0.19) } else { 0.5 };
            let on_back = smooth(1.9, 2.3, s) * (1.0 - smooth(5.0, 8.5, s));
            let crest = 0.055 * teeth * on_back * exp(-(angle * angle) / 0.02);
            [up * c + row[6] * lobe + crest, row[5] * side]
        },
        edge,
        n_around: (4.0 / edge) as usize / 4 * 4,
    })
}

struct Leg {
    /// Where it begins along the body's spine.
    root: f64,
    /// How far the left one stands before the right one, halved.
    shift: f64,
    /// Hip, knee, ankle, sole for the left side: x, y, z, radius.
    rows: [[f64; 4]; 5],
}

const LEGS: [Leg; 2] = [
    Leg {
        root: 2.1,
        shift: 0.13,
        rows: [
            [0.42, 1.22, 0.30, 0.25],
            [0.42, 1.02, 0.50, 0.23],
            [0.40, 0.72, 0.60, 0.165],
            [0.56, 0.42, 0.44, 0.125],
            [0.62, 0.20, 0.16, 0.115],
        ],
    },
    Leg {
        root: 3.0,
        shift: 0.12,
        rows: [
            [-0.62, 1.10, 0.28, 0.28],
            [-0.56, 0.92, 0.52, 0.26],
            [-0.50, 0.68, 0.62, 0.18],
            [-0.68, 0.42, 0.45, 0.13],
            [-0.70, 0.20, 0.16, 0.115],
        ],
    },
];

fn limb(leg: &Leg, side: f64, shift: f64, edge: f64) -> Tube {
    let mut i = 0.0;
    let rows = leg.rows.map(|[x, y, z, r]| {
        // Only the foot is shifted wholly; the hip stays in the body.
        let x = x + shift * i / 4.0;
        i += 1.0;
        [x, y, z * side, r]
    });
    let spine = Curve::through(&rows);
    Tube::sweep(&Sweep {
        spine: &spine,
        caps: [0.12, 0.08],
        back: &|_| DVec3::new(1.0, 0.35, 0.6 * side),
        section: &|row, _, angle| [row[3] * cos(angle), row[3] * sin(angle)],
        edge: edge * 0.8,
        n_around: (1.25 / edge) as usize / 4 * 4,
    })
}

/// A mitten: one tube clasped around the twig, thumb inside, fingers outside.
fn foot(leg: &Leg, side: f64, shift: f64, edge: f64) -> Tube {
    let x = leg.rows[4][0] + shift;
    let rows: Vec<[f64; 4]> = (0..=12)
        .map(|i| {
            let t = i as f64 / 12.0;
            let angle = (-62.0 + 205.0 * t) / 180.0 * PI;
            let out = TWIG_RADIUS + 0.055;
            let tip = 1.0 - 0.25 * (2.0 * t - 1.0) * (2.0 * t - 1.0);
            [x + 0.03 * cos(PI * t), twig_y(x) + out * cos(angle), out * sin(angle) * side, 0.105 * tip]
        })
        .collect();
    let spine = Curve::through(&rows);
    Tube::sweep(&Sweep {
        spine: &spine,
        caps: [0.09, 0.09],
        back: &|s| {
            let at = spine.at(s);
            DVec3::new(0.0, at[1] - twig_y(x), at[2])
        },
        // Wider than thick, with a shallow furrow between the fingers towards both tips.
        section: &|row, s, angle| {
            let t = (2.0 * s / spine.length() - 1.0).abs();
            let furrow = 0.028 * smooth(0.35, 0.7, t) * exp(-(angle * angle) / 0.06);
            [row[3] * 0.85 * cos(angle) - furrow, row[3] * 1.35 * sin(angle)]
        },
        edge: edge * 0.6,
        n_around: (1.1 / edge) as usize / 4 * 4,
    })
}

const TWIG_RADIUS: f64 = 0.165;

fn twig_y(x: f64) -> f64 {
    -0.02 + 0.035 * sin(1.3 * x + 0.4) + 0.012 * x * x
}

fn twig(edge: f64) -> Tube {
    let rows: Vec<[f64; 4]> = (0..=16)
        .map(|i| {
            let x = -1.32 + 4.25 * i as f64 / 16.0;
            [x, twig_y(x), 0.0, TWIG_RADIUS - 0.012 * (x + 1.32)]
        })
        .collect();
    bark(&rows, edge)
}

/// A side shoot that carries the leaves.
fn shoot(edge: f64) -> Tube {
    let rows = [
        [1.55, twig_y(1.55), 0.02, 0.085],
        [1.85, twig_y(1.85) + 0.10, 0.16, 0.07],
        [2.20, 0.34, 0.36, 0.055],
        [2.50, 0.50, 0.50, 0.045],
    ];
    bark(&rows, edge)
}

fn bark(rows: &[[f64; 4]], edge: f64) -> Tube {
    let spine = Curve::through(rows);
    Tube::sweep(&Sweep {
        spine: &spine,
        caps: [0.04, 0.04],
        back: &|_| DVec3::Y,
        section: &|row, s, angle| {
            // Knots: slight swellings, and ridges that wander around.
            let knot = exp(-sq((s - 0.55) / 0.10)) + exp(-sq((s - 2.9) / 0.12));
            let r = row[3] * (1.0 + 0.14 * knot + 0.03 * sin(5.0 * angle + 2.0 * sin(1.7 * s)));
            [r * cos(angle), r * sin(angle)]
        },
        edge: edge * 1.2,
        n_around: (1.1 / edge) as usize / 4 * 4,
    })
}

/// Leaves along their midribs: x, y, z, half width.
const LEAVES: [[[f64; 4]; 6]; 3] = [
    [
        [2.46, 0.48, 0.48, 0.02],
        [2.60, 0.62, 0.54, 0.11],
        [2.78, 0.78, 0.58, 0.20],
        [3.00, 0.89, 0.58, 0.20],
        [3.24, 0.92, 0.54, 0.11],
        [3.46, 0.88, 0.48, 0.01],
    ],
    [
        [2.20, 0.34, 0.36, 0.02],
        [2.34, 0.32, 0.52, 0.09],
        [2.50, 0.28, 0.68, 0.16],
        [2.68, 0.19, 0.84, 0.16],
        [2.86, 0.06, 0.98, 0.09],
        [3.02, -0.10, 1.08, 0.01],
    ],
    [
        [2.90, 0.10, 0.00, 0.02],
        [3.04, 0.18, -0.06, 0.09],
        [3.20, 0.25, -0.14, 0.16],
        [3.40, 0.28, -0.23, 0.16],
        [3.60, 0.25, -0.32, 0.09],
        [3.78, 0.18, -0.40, 0.01],
    ],
];

fn leaf(rows: &[[f64; 4]], edge: f64) -> Tube {
    let spine = Curve::through(rows);
    Tube::sweep(&Sweep {
        spine: &spine,
        caps: [0.02, 0.02],
        back: &|_| DVec3::Y,
        // A thin lens, folded up a little along the midrib.
        section: &|row, _, angle| {
            let across = sin(angle);
            [0.016 * cos(angle) + 0.45 * row[3] * across * across, row[3] * across]
        },
        edge: edge * 0.8,
        n_around: (1.2 / edge) as usize / 4 * 4,
    })
}

/// The eyelid: a turret with a round opening that looks along the gaze.
fn lid(angle: f64) -> f64 {
    let turret = 0.375 + 0.035 * exp(-sq((angle - 0.80) / 0.20));
    let dish = 0.27;
    dish + (turret - dish) * smooth(0.60, 0.76, angle)
}

/// A surface of revolution about the direction it looks in, closed behind.
pub(super) struct Dome {
    /// From the front pole to the hidden back pole: distance from the axis, along the axis, and along the profile.
    rings: Vec<[f64; 3]>,
    normals: Vec<[f64; 2]>,
    center: DVec3,
    axes: [DVec3; 3],
    n_around: u32,
}

impl Dome {
    fn new(center: DVec3, gaze: DVec3, radius: &dyn Fn(f64) -> f64, edge: f64) -> Self {
        // What is more than this far from the gaze lies inside the head.
        const LAST: f64 = 2.0;
        let size = radius(1.2);
        let n = ((2.0 * LAST * size / edge).ceil() as u32).max(10);
        let at = |t: f64| [radius(t) * sin(t), radius(t) * cos(t)];
        let mut rings: Vec<[f64; 3]> = Vec::new();
        let mut normals = Vec::new();
        for i in 0..=n {
            let t = LAST * i as f64 / n as f64;
            let [out, ahead] = if i == 0 { [0.0, radius(0.0)] } else { at(t) };
            let length = rings.last().map_or(0.0, |l| {
                let (dx, dy) = (out - l[0], ahead - l[1]);
                l[2] + (dx * dx + dy * dy).sqrt()
            });
            rings.push([out, ahead, length]);
            const H: f64 = 1e-4;
            let (a, b) = (at(t - H), at(t + H));
            normals.push(if i == 0 { [0.0, 1.0] } else { [a[1] - b[1], b[0] - a[0]] });
        }
        let last = rings[n as usize];
        // The back is a flat cone that nobody sees; it gets little room in the texture.
        rings.push([0.0, last[1], last[2] + 0.2 * last[0]]);
        normals.push([0.0, -1.0]);
        let right = DVec3::Y.cross(gaze).normalize();
        let n_around = ((2.0 * PI * size / edge) as u32 / 4 * 4).max(16);
        Self { rings, normals, center, axes: [right, gaze.cross(right), gaze], n_around }
    }

    /// Radius of the chart, a disc.
    fn reach(&self) -> f64 {
        self.rings[self.rings.len() - 1][2]
    }

    /// Adds the dome's triangles; `uv` maps chart places.
    pub(super) fn add_to(&self, raw: &mut RawMesh, uv: impl Fn(DVec2) -> DVec2) {
        let n = self.n_around;
        let [right, up, gaze] = self.axes;
        let last = self.rings.len() as u32 - 1;
        // Rings go backwards while the grid's rows go up: the front faces outwards when columns run clockwise.
        sheet::grid(raw, [n, last], |i, j| {
            let turn = 2.0 * PI * (i % n) as f64 / n as f64;
            let out = right * cos(turn) - up * sin(turn);
            let [radius, ahead, length] = self.rings[j as usize];
            let [n_out, n_ahead] = self.normals[j as usize];
            // At the back pole each triangle has a corner of its own, in its middle.
            let shift = if j == last { -0.5 } else { 0.0 };
            let chart_turn = 2.0 * PI * (i as f64 + shift) / n as f64;
            let chart = DVec2::new(cos(chart_turn), sin(chart_turn)) * length + DVec2::splat(self.reach());
            Point {
                position: self.center + out * radius + gaze * ahead,
                normal: out * n_out + gaze * n_ahead,
                uv: uv(chart),
            }
        });
    }

    /// Distance from the front pole and the angle around it (0 to the right, clockwise) of a chart place.
    pub(super) fn locate(&self, chart: DVec2) -> (f64, f64) {
        let d = chart - DVec2::splat(self.reach());
        (d.length(), crate::math::exact::atan2(d.y, d.x))
    }
}

/// Distance along the spine from the nose in centimetres (a unit is 3 cm), and the temperature in degrees Celsius: warm
/// where the blood is, the tail and the feet nearly as cool as the air.
pub(super) fn fields(piece: &Piece, chart: DVec2, at: Vec3) -> [f32; 2] {
    let sun = 1.4 * at.y as f64;
    let along = match &piece.shape {
        PieceShape::Tube(tube) => tube.locate(chart).0,
        PieceShape::Dome(_) => 0.0,
    };
    let s = piece.root + along;
    let [cool, warm] = [21.5 + 0.4 * sun, 31.5];
    let heat = match piece.kind {
        Kind::Twig | Kind::Leaf => return [f32::NAN, cool as f32],
        Kind::Leg => exp(-along / 0.75),
        Kind::Foot => 0.28,
        _ => exp(-sq((s - 2.5) / 1.5)).max(exp(-s / 2.5) * 0.75),
    };
    [(s * 3.0) as f32, (cool + (warm - cool) * heat) as f32]
}

/// 0 up to `a`, 1 from `b`, smooth between.
pub(super) fn smooth(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The square.
pub(super) fn sq(x: f64) -> f64 {
    x * x
}
