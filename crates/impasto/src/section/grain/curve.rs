//! Closed curves in a plane: what particles' outlines are made of.
//!
//! Circles, ellipses, and paths of straight lines and elliptical arcs; all counter-clockwise, +y up. Whoever cannot draw
//! an arc asks for a polygon.

use crate::math::{DVec2, exact};
use std::f64::consts::TAU;

/// A closed curve, counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// A circle.
    Circle {
        /// Its middle.
        middle: DVec2,
        /// Its radius.
        radius: f64,
    },
    /// An ellipse.
    Ellipse(Ellipse),
    /// A convex figure of lines and arcs.
    Path {
        /// Where it starts.
        start: DVec2,
        /// Its parts, each from the end of the one before. The curve closes with a straight line, if it has not.
        parts: Vec<Part>,
    },
}

/// The points `middle + semi[0] cos a + semi[1] sin a`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Its middle.
    pub middle: DVec2,
    /// Half axes: at right angles, the second counter-clockwise from the first.
    pub semi: [DVec2; 2],
}

/// A part of a [`Curve::Path`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// Straight to a point.
    Line(DVec2),
    /// Counter-clockwise along an ellipse on which both ends lie.
    Arc {
        /// Where it ends.
        to: DVec2,
        /// What it is an arc of.
        of: Ellipse,
    },
}

impl Ellipse {
    fn at(&self, angle: f64) -> DVec2 {
        self.middle + self.semi[0] * exact::cos(angle) + self.semi[1] * exact::sin(angle)
    }

    fn angle(&self, p: DVec2) -> f64 {
        let [x, y] = self.semi.map(|s| (p - self.middle).dot(s) / s.length_squared());
        exact::atan2(y, x)
    }

    /// The angle, above 0 and at most a full turn, that an arc between two of its points takes.
    pub fn sweep(&self, from: DVec2, to: DVec2) -> f64 {
        let sweep = self.angle(to) - self.angle(from);
        if sweep > 0.0 { sweep } else { sweep + TAU }
    }

    /// So many even steps keep the chords of an arc of this angle within a tolerance.
    fn n_steps(&self, sweep: f64, tolerance: f64) -> usize {
        let most = self.semi[0].length().max(self.semi[1].length());
        // The sagitta r (1 - cos(a / 2)) is below r a^2 / 8.
        let step = (8.0 * tolerance / most).sqrt().clamp(1e-3, 0.8);
        ((sweep / step).ceil() as usize).max(1)
    }

    fn moved(&self, by: DVec2, scale: f64) -> Self {
        Self { middle: self.middle * scale + by, semi: self.semi.map(|s| s * scale) }
    }
}

impl Curve {
    /// A polygon's border.
    pub fn polygon_of(corners: &[DVec2]) -> Option<Self> {
        let (&start, rest) = corners.split_first()?;
        (rest.len() >= 2).then(|| Self::Path { start, parts: rest.iter().map(|&p| Part::Line(p)).collect() })
    }

    /// Corners on the curve, so many that no chord is farther from it than `tolerance` (at least a millionth of its size
    /// counts).
    pub fn polygon(&self, tolerance: f64) -> Vec<DVec2> {
        let whole = |of: &Ellipse| {
            let n = of.n_steps(TAU, tolerance).max(8);
            (0..n).map(|k| of.at(TAU * k as f64 / n as f64)).collect()
        };
        match self {
            Self::Circle { middle, radius } => {
                whole(&Ellipse { middle: *middle, semi: [DVec2::X * *radius, DVec2::Y * *radius] })
            }
            Self::Ellipse(ellipse) => whole(ellipse),
            Self::Path { start, parts } => {
                let mut corners = vec![*start];
                for part in parts {
                    let from = corners[corners.len() - 1];
                    match *part {
                        Part::Line(to) => corners.push(to),
                        Part::Arc { to, of } => {
                            let (first, sweep) = (of.angle(from), of.sweep(from, to));
                            let n = of.n_steps(sweep, tolerance);
                            corners.extend((1..n).map(|k| of.at(first + sweep * k as f64 / n as f64)));
                            corners.push(to);
                        }
                    }
                }
                if corners.len() > 1 && corners[corners.len() - 1] == corners[0] {
                    corners.pop();
                }
                corners
            }
        }
    }

    /// The same curve scaled about the origin, then moved.
    pub(super) fn moved(self, by: DVec2, scale: f64) -> Self {
        let place = |p: DVec2| p * scale + by;
        match self {
            Self::Circle { middle, radius } => Self::Circle { middle: place(middle), radius: radius * scale },
            Self::Ellipse(ellipse) => Self::Ellipse(ellipse.moved(by, scale)),
            Self::Path { start, parts } => {
                let part = |part: Part| match part {
                    Part::Line(to) => Part::Line(place(to)),
                    Part::Arc { to, of } => Part::Arc { to: place(to), of: of.moved(by, scale) },
                };
                Self::Path { start: place(start), parts: parts.into_iter().map(part).collect() }
            }
        }
    }
}

/// Whether a polygon goes around a point an odd number of times.
pub fn is_inside(polygon: &[DVec2], p: DVec2) -> bool {
    (0..polygon.len()).fold(false, |inside, i| {
        let (a, b) = (polygon[i], polygon[if i + 1 < polygon.len() { i + 1 } else { 0 }]);
        let crosses = (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x);
        inside != crosses
    })
}

/// A convex polygon, counter-clockwise, without what lies where `above` is positive: a function that is linear in the
/// plane.
pub(super) fn clip(polygon: &mut Vec<DVec2>, room: &mut Vec<DVec2>, above: impl Fn(DVec2) -> f64) {
    if polygon.iter().all(|&p| above(p) <= 0.0) {
        return;
    }
    room.clear();
    for i in 0..polygon.len() {
        let (a, b) = (polygon[i], polygon[if i + 1 < polygon.len() { i + 1 } else { 0 }]);
        let (x, y) = (above(a), above(b));
        if x <= 0.0 {
            room.push(a);
        }
        if (x > 0.0) != (y > 0.0) {
            room.push(a + (b - a) * (x / (x - y)));
        }
    }
    std::mem::swap(polygon, room);
    if polygon.len() < 3 {
        polygon.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn area(polygon: &[DVec2]) -> f64 {
        let n = polygon.len();
        (0..n).map(|i| polygon[i].perp_dot(polygon[(i + 1) % n]) * 0.5).sum()
    }

    #[test]
    fn polygons_of_curves_keep_to_their_tolerance() {
        let ellipse =
            Ellipse { middle: DVec2::new(1.0, 2.0), semi: [DVec2::new(0.6, 0.8) * 3.0, DVec2::new(-0.8, 0.6)] };
        assert!((area(&Curve::Ellipse(ellipse).polygon(1e-5)) - 3.0 * PI).abs() < 1e-3);
        let circle = Curve::Circle { middle: DVec2::ZERO, radius: 2.0 };
        for tolerance in [0.1, 1e-3, 1e-5] {
            let polygon = circle.polygon(tolerance);
            let n = polygon.len();
            for i in 0..n {
                let chord = ((polygon[i] + polygon[(i + 1) % n]) * 0.5).length();
                assert!(2.0 - chord <= tolerance && chord <= 2.0);
            }
        }
        // A half disc, and the same scaled and moved.
        let of = Ellipse { middle: DVec2::ZERO, semi: [DVec2::X, DVec2::Y] };
        let half = Curve::Path { start: DVec2::X, parts: vec![Part::Arc { to: DVec2::NEG_X, of }] };
        assert!((area(&half.polygon(1e-6)) - PI * 0.5).abs() < 1e-4);
        let moved = half.moved(DVec2::new(5.0, 5.0), 2.0).polygon(1e-6);
        assert!((area(&moved) - PI * 2.0).abs() < 1e-4);
        assert!(is_inside(&moved, DVec2::new(5.0, 6.0)) && !is_inside(&moved, DVec2::new(5.0, 4.9)));
    }

    #[test]
    fn clipping_keeps_what_is_below_a_line() {
        let mut square = vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let mut room = Vec::new();
        clip(&mut square, &mut room, |p| p.x + p.y - 0.5);
        assert_eq!((square.len(), area(&square)), (3, 0.125));
        clip(&mut square, &mut room, |p| 1.0 - p.x);
        assert!(square.is_empty() && Curve::polygon_of(&square).is_none());
    }
}
