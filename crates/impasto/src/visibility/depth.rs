//! Depth over a triangle: a plane through its corners, rounded the same way wherever it is asked; and the order in which
//! depths meet.

use super::bin::{Record, STEPS};

/// Depth over a triangle: `depth0 + gy * dy + gx * dx` from its first corner, within the corners' range.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub(super) x0: i32,
    pub(super) y0: i32,
    pub(super) depth0: f32,
    pub(super) gx: f32,
    pub(super) gy: f32,
    pub(super) min: f32,
    pub(super) max: f32,
}

impl Plane {
    #[inline(always)]
    pub(super) fn new(r: &Record) -> Self {
        let (dx1, dy1) = ((r.x[1] - r.x[0]) as i64, (r.y[1] - r.y[0]) as i64);
        let (dx2, dy2) = ((r.x[2] - r.x[0]) as i64, (r.y[2] - r.y[0]) as i64);
        let area = dx1 * dy2 - dx2 * dy1;
        let (dx1, dy1, dx2, dy2) = (dx1 as f64, dy1 as f64, dx2 as f64, dy2 as f64);
        let (d1, d2) = ((r.depth[1] - r.depth[0]) as f64, (r.depth[2] - r.depth[0]) as f64);
        let scale = STEPS as f64 / area as f64;
        let [a, b, c] = r.depth;
        let min = |a: f32, b: f32| if a < b { a } else { b };
        let max = |a: f32, b: f32| if a > b { a } else { b };
        Self {
            x0: r.x[0],
            y0: r.y[0],
            depth0: a,
            gx: ((d1 * dy2 - d2 * dy1) * scale) as f32,
            gy: ((d2 * dx1 - d1 * dx2) * scale) as f32,
            min: min(min(a, b), c),
            max: max(max(a, b), c),
        }
    }

    /// Columns from the first corner to a place in 1/256 of a cell: exact in f32, at most 24 bits.
    #[inline(always)]
    pub(super) fn distance_x(&self, x: i32) -> f32 {
        (x - self.x0) as f32 * (1.0 / STEPS as f32)
    }

    /// The same for rows.
    #[inline(always)]
    pub(super) fn distance_y(&self, y: i32) -> f32 {
        (y - self.y0) as f32 * (1.0 / STEPS as f32)
    }

    /// The nearest depth in a box of places: an exact bound, since rounding is monotonic.
    #[inline(always)]
    pub(super) fn nearest(&self, x: [i32; 2], y: [i32; 2]) -> f32 {
        let dx = self.distance_x(x[(self.gx > 0.0) as usize]);
        let dy = self.distance_y(y[(self.gy > 0.0) as usize]);
        let z = self.depth0 + self.gy * dy + self.gx * dx;
        let z = if z > self.min { z } else { self.min };
        if z < self.max { z } else { self.max }
    }
}

/// In which order triangles are drawn. The picture is the same; nearest first hides more, sooner.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Order {
    /// As submitted: at equal depths the first one drawn stays.
    Forward,
    /// From the last to the first, into a layer that is empty: at equal depths the last one drawn takes over.
    Backward,
}

impl Order {
    /// The order that seems to begin nearer to the eye.
    pub(super) fn nearer_first(lists: &[&[Record]]) -> Self {
        const SOME: usize = 8;
        let nearest = |records: &mut dyn Iterator<Item = &Record>| {
            records.take(SOME).flat_map(|r| r.depth).fold(0.0, |a: f32, b| if a > b { a } else { b })
        };
        let first = nearest(&mut lists.iter().copied().flatten());
        let last = nearest(&mut lists.iter().rev().flat_map(|l| l.iter().rev()));
        if last > first { Self::Backward } else { Self::Forward }
    }

    /// Added to the bits of a depth before they are compared for greater: depths are not negative, so their bits are
    /// ordered as they are.
    #[inline(always)]
    pub(super) fn bias(self) -> i32 {
        (self == Self::Backward) as i32
    }

    /// Whether what reaches at most this depth is hidden where at least the other one is.
    #[inline(always)]
    pub(super) fn hides(self, nearest: f32, farthest: f32) -> bool {
        nearest.to_bits() as i32 + self.bias() <= farthest.to_bits() as i32
    }
}
