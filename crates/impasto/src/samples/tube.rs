//! Closed tubes along a spine, with a texture chart that is as wide as the tube is round.
//!
//! A chart has the distance along the tube's sides as its length and the distance from the back line around the section as
//! its width, seam on the belly: a spindle rather than a rectangle, which keeps lengths nearly true wherever the tube swells.

use crate::assets::RawMesh;
use crate::math::exact::{cos, sin};
use crate::math::{DVec2, DVec3};
use crate::samples::curve::{Curve, place};
use crate::samples::sheet::{self, Point};
use std::f64::consts::{FRAC_PI_2, PI};

/// How far towards the back and towards the right the skin is: from the spine's row, the distance along it and the angle
/// from the back, -pi to pi.
pub(super) type Section<'a, const K: usize> = dyn Fn(&[f64; K], f64, f64) -> [f64; 2] + 'a;

/// A tube's points, still without a place in the texture.
pub(super) struct Tube {
    n_around: usize,
    /// Distance of each station along the spine.
    pub(super) stations: Vec<f64>,
    /// Station after station, `n_around` points each; the first station and the last are one point each, repeated.
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// Distance of each station along the tube's side.
    along: Vec<f64>,
    /// Station after station, `n_around + 1` signed distances from the back line.
    around: Vec<f64>,
    /// The greatest of these distances: half the chart's width.
    half_width: f64,
}

/// What a tube is made of.
pub(super) struct Sweep<'a, const K: usize> {
    /// The spine; further numbers are for the section.
    pub(super) spine: &'a Curve<K>,
    /// Length of the rounded ends.
    pub(super) caps: [f64; 2],
    /// The back's direction, need not be exactly across the spine: it is made so.
    pub(super) back: &'a dyn Fn(f64) -> DVec3,
    /// The cross-section.
    pub(super) section: &'a Section<'a, K>,
    /// Length of the triangles' edges along the spine.
    pub(super) edge: f64,
    /// How many points there are around.
    pub(super) n_around: usize,
}

impl Tube {
    /// Sweeps the section along the spine.
    pub(super) fn sweep<const K: usize>(sweep: &Sweep<K>) -> Self {
        let length = sweep.spine.length();
        let n_around = sweep.n_around.max(6);
        let cap_steps = sweep.caps.map(|c| ((c * FRAC_PI_2 / sweep.edge).ceil() as usize).max(4));
        let middle = length - sweep.caps[0] - sweep.caps[1];
        let n_middle = ((middle / sweep.edge).ceil() as usize).max(4);
        let n = cap_steps[0] + n_middle + cap_steps[1];
        // From a station, whole or between, to the distance along the spine and the cap's narrowing there.
        let station = |x: f64| -> (f64, f64) {
            let (first, last) = (cap_steps[0] as f64, cap_steps[1] as f64);
            let from_end = n as f64 - x;
            if x < first {
                let angle = FRAC_PI_2 * x / first;
                (sweep.caps[0] * (1.0 - cos(angle)), sin(angle))
            } else if from_end < last {
                let angle = FRAC_PI_2 * from_end / last;
                (length - sweep.caps[1] * (1.0 - cos(angle)), sin(angle))
            } else {
                (sweep.caps[0] + middle * (x - first) / n_middle as f64, 1.0)
            }
        };
        let skin = |x: f64, angle: f64| {
            let (s, narrowing) = station(x);
            let (row, direction) = (sweep.spine.at(s), sweep.spine.direction(s));
            let back = (sweep.back)(s);
            let back = (back - direction * direction.dot(back)).normalize();
            let [up, side] = (sweep.section)(&row, s, angle);
            place(&row) + (back * up + direction.cross(back) * side) * narrowing
        };
        let angle = |i: usize| 2.0 * PI * i as f64 / n_around as f64 - PI;
        let mut tube = Self {
            n_around,
            stations: (0..=n).map(|j| station(j as f64).0).collect(),
            points: Vec::new(),
            normals: Vec::new(),
            along: vec![0.0],
            around: Vec::new(),
            half_width: 0.0,
        };
        for j in 0..=n {
            for i in 0..n_around {
                const H: f64 = 1e-3;
                let x = j as f64;
                let (low, high) = ((x - H).max(0.0), (x + H).min(n as f64));
                tube.points.push(skin(x, angle(i)));
                tube.normals.push(match j {
                    0 => -sweep.spine.direction(0.0),
                    j if j == n => sweep.spine.direction(length),
                    _ => (skin(x, angle(i) + H) - skin(x, angle(i) - H))
                        .cross(skin(high, angle(i)) - skin(low, angle(i)))
                        .normalize_or(DVec3::Y),
                });
            }
        }
        tube.measure();
        tube
    }

    /// Lays out the chart.
    fn measure(&mut self) {
        let n = self.n_around;
        let side = |j: usize, i: usize| self.points[j * n + i % n];
        let (left, right) = (n / 4, n - n / 4);
        for j in 0..self.stations.len() {
            if j > 0 {
                let step = side(j, left).distance(side(j - 1, left)) + side(j, right).distance(side(j - 1, right));
                self.along.push(self.along[j - 1] + 0.5 * step);
            }
            // From the back line (in the middle) outwards.
            let mut row = vec![0.0; n + 1];
            let middle = n / 2;
            for i in middle + 1..=n {
                row[i] = row[i - 1] + side(j, i).distance(side(j, i - 1));
            }
            for i in (0..middle).rev() {
                row[i] = row[i + 1] - side(j, i).distance(side(j, i + 1));
            }
            self.around.extend(row);
        }
        self.half_width = self.around.iter().fold(0.0, |m, b| m.max(b.abs()));
    }

    /// The tube's pieces between these distances along the spine: charts of their own, the surface is the same.
    pub(super) fn cut_at(&self, places: &[f64]) -> Vec<Self> {
        let n = self.n_around;
        let mut cuts = vec![0];
        cuts.extend(places.iter().map(|s| self.stations.partition_point(|t| t < s)));
        cuts.push(self.stations.len() - 1);
        let piece = |w: &[usize]| {
            let (first, last) = (w[0], w[1]);
            let around = self.around[first * (n + 1)..(last + 1) * (n + 1)].to_vec();
            Self {
                n_around: n,
                stations: self.stations[first..=last].to_vec(),
                points: self.points[first * n..(last + 1) * n].to_vec(),
                normals: self.normals[first * n..(last + 1) * n].to_vec(),
                along: self.along[first..=last].iter().map(|a| a - self.along[first]).collect(),
                half_width: around.iter().fold(0.0, |m, b| m.max(b.abs())),
                around,
            }
        };
        cuts.windows(2).map(piece).collect()
    }

    /// Length and width of the chart, model units.
    pub(super) fn chart_size(&self) -> DVec2 {
        DVec2::new(self.along[self.along.len() - 1], 2.0 * self.half_width)
    }

    /// Adds the tube's triangles; `uv` maps chart places (along from the start, around from the chart's upper edge).
    pub(super) fn add_to(&self, raw: &mut RawMesh, uv: impl Fn(DVec2) -> DVec2) {
        let (n, half) = (self.n_around, self.half_width);
        let last = self.stations.len() - 1;
        sheet::grid(raw, [n as u32, last as u32], |i, j| {
            let (i, j) = (i as usize, j as usize);
            let at = j * n + i % n;
            let around = half + self.around[j * (n + 1) + i];
            Point { position: self.points[at], normal: self.normals[at], uv: uv(DVec2::new(self.along[j], around)) }
        });
    }

    /// The surface place of a chart place: distance along the spine, and the angle from the back. Places beside the
    /// chart get the nearest on its edge.
    pub(super) fn locate(&self, chart: DVec2) -> (f64, f64) {
        let n = self.n_around;
        let j = self.along.partition_point(|a| *a < chart.x).clamp(1, self.along.len() - 1);
        let f = ((chart.x - self.along[j - 1]) / (self.along[j] - self.along[j - 1]).max(1e-12)).clamp(0.0, 1.0);
        let row = |i: usize| self.around[(j - 1) * (n + 1) + i] * (1.0 - f) + self.around[j * (n + 1) + i] * f;
        let b = chart.y - self.half_width;
        // Bisection: distances grow with the angle.
        let (mut low, mut high) = (0, n);
        while high - low > 1 {
            let middle = (low + high) / 2;
            if row(middle) <= b { low = middle } else { high = middle }
        }
        let g = ((b - row(low)) / (row(high) - row(low)).max(1e-12)).clamp(0.0, 1.0);
        let s = self.stations[j - 1] * (1.0 - f) + self.stations[j] * f;
        (s, 2.0 * PI * (low as f64 + g) / n as f64 - PI)
    }
}
