//! How far is a place of the section from the model's skin?
//!
//! Distance to the nearest outline, found ring by ring in a grid of squares. Particles whose disc is nearer than their
//! radius would stick out of the model; caps get the distance as a map.

use super::Section;
use crate::math::{DVec2, Vec2};
use crate::section::grain::Window;

/// The outlines of a section, sorted into squares.
#[derive(Clone, Debug)]
pub struct Rim {
    edges: Vec<[DVec2; 2]>,
    min: DVec2,
    pitch: f64,
    n_squares: [i64; 2],
    /// Where each square's edges start in `order`.
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl Rim {
    /// Of all outlines, those that do not close included.
    pub fn of(section: &Section) -> Self {
        Self::of_outlines(&section.contours, &section.open_contours)
    }

    pub(super) fn of_outlines(closed: &[Vec<DVec2>], open: &[Vec<DVec2>]) -> Self {
        let closed = closed.iter().flat_map(|c| (0..c.len()).map(|i| [c[i], c[(i + 1) % c.len()]]));
        let open = open.iter().flat_map(|c| c.windows(2).map(|w| [w[0], w[1]]));
        let edges: Vec<[DVec2; 2]> = closed.chain(open).collect();
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in edges.iter().flatten() {
            (min, max) = (min.min(*p), max.max(*p));
        }
        if edges.is_empty() {
            (min, max) = (DVec2::ZERO, DVec2::ZERO);
        }
        // About one edge a square along the outline.
        let side = (edges.len() as f64 * 0.5).sqrt().clamp(1.0, 1024.0);
        let pitch = ((max - min).max_element() / side).max(f64::MIN_POSITIVE);
        let n_squares = [0, 1].map(|k| (((max - min)[k] / pitch).ceil() as i64).clamp(1, 1025));
        let mut rim = Self { edges, min, pitch, n_squares, starts: Vec::new(), order: Vec::new() };
        rim.sort();
        rim
    }

    /// Puts each edge into all squares of its box.
    fn sort(&mut self) {
        let n = (self.n_squares[0] * self.n_squares[1]) as usize;
        let mut starts = vec![0u32; n + 1];
        let visit = |rim: &Self, mut f: Box<dyn FnMut(usize, u32) + '_>| {
            for (i, [a, b]) in rim.edges.iter().enumerate() {
                let (low, high) = (rim.square(a.min(*b)), rim.square(a.max(*b)));
                for y in low[1]..=high[1] {
                    for x in low[0]..=high[0] {
                        f((y * rim.n_squares[0] + x) as usize, i as u32);
                    }
                }
            }
        };
        visit(self, Box::new(|square, _| starts[square + 1] += 1));
        for s in 1..starts.len() {
            starts[s] += starts[s - 1];
        }
        let mut next = starts.clone();
        let mut order = vec![0; starts[n] as usize];
        visit(
            self,
            Box::new(|square, edge| {
                order[next[square] as usize] = edge;
                next[square] += 1;
            }),
        );
        (self.starts, self.order) = (starts, order);
    }

    fn square(&self, p: DVec2) -> [i64; 2] {
        let at = (p - self.min) / self.pitch;
        [0, 1].map(|k| (at[k].floor() as i64).clamp(0, self.n_squares[k] - 1))
    }

    /// Distance to the nearest outline, model units; infinite if there is none.
    pub fn distance(&self, p: DVec2) -> f64 {
        let [x, y] = self.square(p);
        let inside =
            p.clamp(self.min, self.min + DVec2::new(self.n_squares[0] as f64, self.n_squares[1] as f64) * self.pitch);
        let outside = (p - inside).length();
        let mut least = f64::INFINITY;
        let most = self.n_squares[0].max(self.n_squares[1]);
        for ring in 0..=most {
            // What is in this ring is at least so far away.
            if outside.max((ring - 1).max(0) as f64 * self.pitch) > least {
                break;
            }
            for row in (y - ring).max(0)..=(y + ring).min(self.n_squares[1] - 1) {
                let is_end = row == y - ring || row == y + ring;
                let step = if is_end || ring == 0 { 1 } else { 2 * ring };
                let mut column = x - ring;
                while column <= x + ring {
                    if (0..self.n_squares[0]).contains(&column) {
                        least = least.min(self.nearest_in(row * self.n_squares[0] + column, p));
                    }
                    column += step;
                }
            }
        }
        least
    }

    fn nearest_in(&self, square: i64, p: DVec2) -> f64 {
        let range = self.starts[square as usize] as usize..self.starts[square as usize + 1] as usize;
        self.order[range].iter().map(|&i| to_edge(self.edges[i as usize], p)).fold(f64::INFINITY, f64::min)
    }
}

fn to_edge([a, b]: [DVec2; 2], p: DVec2) -> f64 {
    let squared = (b - a).length_squared();
    let t = if squared > 0.0 { ((p - a).dot(b - a) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (p - a - (b - a) * t).length()
}

impl Section {
    /// The part of the plane that the outlines take, for lists of particles and maps of the cap; grown by `margin`, model
    /// units.
    pub fn window(&self, margin: f32) -> Window {
        let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for p in self.contours.iter().chain(&self.open_contours).flatten() {
            (min, max) = (min.min(p.as_vec2()), max.max(p.as_vec2()));
        }
        if min.x > max.x {
            (min, max) = (Vec2::ZERO, Vec2::ZERO);
        }
        Window { origin: self.origin, axes: self.axes, min: min - margin, max: max + margin }
    }

    /// Area of the cap, model units squared.
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|[a, b, c]| (*b - *a).perp_dot(*c - *a) * 0.5).sum()
    }
}
