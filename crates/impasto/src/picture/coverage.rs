//! How much of each pixel a shape covers: exact areas, in plain f32.
//!
//! Signed areas are summed along rows, after Levien's font-rs (2016): each edge adds what it covers to its own pixels, and
//! to all on its right. Where contours of one direction overlap the sum passes one and is cut there.

use crate::math::{Size, Vec2, vec2};

/// Shares of a block of pixels, rows from the top.
pub(super) struct Coverage {
    /// Column of the block's left pixels.
    pub(super) x: usize,
    /// Row of its top pixels.
    pub(super) y: usize,
    /// Columns.
    pub(super) width: usize,
    /// For each pixel a share from 0 to 1.
    pub(super) shares: Vec<f32>,
}

impl Coverage {
    /// The rows with the y of each.
    pub(super) fn rows(&self) -> impl Iterator<Item = (usize, &[f32])> {
        self.shares.chunks_exact(self.width.max(1)).enumerate().map(|(i, row)| (self.y + i, row))
    }
}

/// What polygons cover together of a picture; nothing if they miss it or are not finite. `rim` empty pixels are kept
/// around them.
pub(super) fn fill(contours: &[Vec<Vec2>], size: Size, rim: f32) -> Option<Coverage> {
    let points = || contours.iter().flatten();
    if size.n_cells() == 0
        || points().next().is_none()
        || !points().all(|p| p.is_finite() && p.abs().max_element() < 1e6)
    {
        return None;
    }
    let low = points().fold(Vec2::INFINITY, |a, p| a.min(*p)) - rim;
    let high = points().fold(Vec2::NEG_INFINITY, |a, p| a.max(*p)) + rim;
    let (w, h) = (size.width as f32, size.height as f32);
    let (low, high) = (low.floor().max(Vec2::ZERO), high.ceil().min(vec2(w, h)));
    if high.x <= low.x || high.y <= low.y {
        return None;
    }
    let mut sums = Sums::new((high.x - low.x) as usize, (high.y - low.y) as usize);
    for contour in contours {
        let mut before = *contour.last()? - low;
        for p in contour {
            let p = *p - low;
            sums.edge(before, p);
            before = p;
        }
    }
    let (x, y) = (low.x as usize, low.y as usize);
    Some(Coverage { x, y, width: sums.width, shares: sums.shares() })
}

/// Changes of coverage from pixel to pixel.
struct Sums {
    width: usize,
    height: usize,
    /// Rows of `width + 2`.
    changes: Vec<f32>,
}

impl Sums {
    fn new(width: usize, height: usize) -> Self {
        Self { width, height, changes: vec![0.0; (width + 2) * height] }
    }

    /// Adds what lies on the right of an edge.
    fn edge(&mut self, p: Vec2, q: Vec2) {
        if p.y == q.y {
            return;
        }
        let (sign, p, q) = if p.y < q.y { (1.0, p, q) } else { (-1.0, q, p) };
        let slope = (q.x - p.x) / (q.y - p.y);
        let (left, right) = (p.x.min(q.x), p.x.max(q.x));
        let x_at = |y: f32| (p.x + (y - p.y) * slope).clamp(left, right);
        let (top, bottom) = (p.y.max(0.0), q.y.min(self.height as f32));
        if top >= bottom {
            return;
        }
        for row in top as usize..(bottom.ceil() as usize).min(self.height) {
            let (y0, y1) = (top.max(row as f32), bottom.min(row as f32 + 1.0));
            let (x0, x1) = (x_at(y0), x_at(y1));
            self.cut(row, x0.min(x1), x0.max(x1), (y1 - y0) * sign);
        }
    }

    /// A piece of an edge within one row, from `left` to `right`, `dy` high; what lies beside the block is cut off.
    fn cut(&mut self, row: usize, left: f32, right: f32, dy: f32) {
        let w = self.width as f32;
        if right <= 0.0 {
            return self.piece(row, 0.0, 0.0, dy);
        }
        if left >= w {
            return;
        }
        // An upright piece inside is not cut, so that no width of zero is divided by.
        let before = if left < 0.0 { -left / (right - left) } else { 0.0 };
        let beyond = if right > w { (right - w) / (right - left) } else { 0.0 };
        if before > 0.0 {
            self.piece(row, 0.0, 0.0, dy * before);
        }
        self.piece(row, left.max(0.0), right.min(w), dy * (1.0 - before - beyond));
    }

    fn piece(&mut self, row: usize, left: f32, right: f32, dy: f32) {
        let start = row * (self.width + 2);
        let changes = &mut self.changes[start..start + self.width + 2];
        let first = left as usize;
        let end = (right.ceil() as usize).max(first + 1);
        if end == first + 1 {
            // Within one column: a trapezoid.
            let outside = 0.5 * (left + right) - first as f32;
            changes[first] += dy * (1.0 - outside);
            changes[first + 1] += dy * outside;
            return;
        }
        // Across columns: what is covered grows by a triangle, then by even steps, then by the rest.
        let per_column = 1.0 / (right - left);
        let mut covered = 0.0;
        for column in first..end {
            let (x0, x1) = (left.max(column as f32), right.min(column as f32 + 1.0));
            // Of this pixel: to the right of the edge where it is crossed already, in full; where it is crossed here, half.
            let crossed = (x0 - left) * per_column;
            let here = (x1 - x0) * per_column;
            let area = crossed + here * (column as f32 + 1.0 - 0.5 * (x0 + x1));
            changes[column] += dy * (area - covered);
            covered = area;
        }
        changes[end] += dy * (1.0 - covered);
    }

    fn shares(&self) -> Vec<f32> {
        let mut shares = Vec::with_capacity(self.width * self.height);
        for row in self.changes.chunks_exact(self.width + 2) {
            let mut sum = 0.0;
            shares.extend(row[..self.width].iter().map(|change| {
                sum += change;
                whole(sum.abs().min(1.0))
            }));
        }
        shares
    }
}

/// What rounding left of an empty or a full pixel is taken away: neither may be seen.
fn whole(share: f32) -> f32 {
    match share {
        s if s < 1e-4 => 0.0,
        s if s > 0.9999 => 1.0,
        s => s,
    }
}

/// The outline of a line of a width through points, its ends cut square.
///
/// Corners are mitred; beyond two half widths they are cut off.
pub(super) fn stroke(points: &[Vec2], width: f32, is_closed: bool) -> Vec<Vec<Vec2>> {
    let mut points: Vec<Vec2> = points.to_vec();
    points.dedup();
    if is_closed && points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    let n = points.len();
    if n < 2 {
        return Vec::new();
    }
    let half = width * 0.5;
    let normal = |i: usize| {
        let along = points[(i + 1) % n] - points[i % n];
        vec2(-along.y, along.x) / along.length()
    };
    let is_closed = is_closed && n > 2;
    let (mut left, mut right) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for (i, &p) in points.iter().enumerate() {
        let is_first = i == 0 && !is_closed;
        let is_last = i + 1 == n && !is_closed;
        let (before, after) = match (is_first, is_last) {
            (true, _) => (normal(i), normal(i)),
            (_, true) => (normal(i - 1), normal(i - 1)),
            _ => (normal((i + n - 1) % n), normal(i)),
        };
        let sum = before + after;
        // |sum|^2 = 4 cos^2 of half the turn, and a mitre reaches half a width over that cosine.
        let squared = sum.length_squared();
        let offsets = if squared > 1.0 { [sum * (2.0 * half / squared); 2] } else { [before * half, after * half] };
        for offset in offsets {
            left.push(p + offset);
            right.push(p - offset);
        }
    }
    right.reverse();
    if is_closed { vec![left, right] } else { vec![left.into_iter().chain(right).collect()] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::exact;

    fn area(contours: &[Vec<Vec2>], size: Size) -> f64 {
        fill(contours, size, 0.0).map_or(0.0, |c| c.shares.iter().map(|s| *s as f64).sum())
    }

    fn rectangle(x0: f32, y0: f32, x1: f32, y1: f32) -> Vec<Vec2> {
        vec![vec2(x0, y0), vec2(x1, y0), vec2(x1, y1), vec2(x0, y1)]
    }

    #[test]
    fn a_shape_covers_its_area() {
        let size = Size::new(40, 30);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 2e-3, "{a} not {b}");
        near(area(&[rectangle(1.25, 2.5, 7.75, 9.25)], size), 6.5 * 6.75);
        near(area(&[vec![vec2(1.3, 2.1), vec2(37.2, 5.7), vec2(11.9, 28.4)]], size), 453.005);
        // Cut by the picture on all sides: what is inside stays exact.
        near(area(&[rectangle(-5.0, -5.0, 100.0, 100.0)], size), 1200.0);
        near(area(&[vec![vec2(-40.0, 15.0), vec2(20.0, -45.0), vec2(80.0, 15.0), vec2(20.0, 75.0)]], size), 1200.0);
        near(area(&[vec![vec2(-10.0, 0.0), vec2(10.0, 0.0), vec2(-10.0, 20.0)]], size), 50.0);
        near(area(&[vec![vec2(30.0, 0.0), vec2(50.0, 0.0), vec2(50.0, 20.0)]], size), 50.0);
    }

    #[test]
    fn each_pixel_has_its_share() {
        // Below the diagonal of a 2 x 1 block.
        let c = fill(&[vec![vec2(0.0, 0.0), vec2(2.0, 1.0), vec2(0.0, 1.0)]], Size::new(3, 3), 0.0).expect("inside");
        assert_eq!((c.x, c.y, c.width), (0, 0, 2));
        assert!((c.shares[0] - 0.75).abs() < 1e-6 && (c.shares[1] - 0.25).abs() < 1e-6, "{:?}", c.shares);
    }

    #[test]
    fn holes_are_empty_and_overlaps_are_full() {
        let size = Size::new(20, 20);
        let mut hole = rectangle(5.0, 5.0, 10.0, 10.0);
        hole.reverse();
        assert_eq!(area(&[rectangle(2.0, 2.0, 12.0, 12.0), hole], size), 75.0);
        assert_eq!(area(&[rectangle(2.0, 2.0, 12.0, 12.0), rectangle(5.0, 5.0, 10.0, 10.0)], size), 100.0);
    }

    #[test]
    fn nothing_comes_of_nothing() {
        let size = Size::new(20, 20);
        assert!(fill(&[], size, 0.0).is_none());
        assert!(fill(&[vec![vec2(f32::NAN, 0.0), vec2(1.0, 1.0), vec2(0.0, 1.0)]], size, 0.0).is_none());
        assert!(fill(&[rectangle(30.0, 0.0, 40.0, 10.0)], size, 0.0).is_none());
        assert!(fill(&[rectangle(0.0, 0.0, 4.0, 4.0)], Size::new(0, 0), 0.0).is_none());
        assert_eq!(area(&[vec![vec2(3.0, 3.0)]], size), 0.0);
        assert!(stroke(&[vec2(1.0, 1.0); 3], 2.0, false).is_empty());
    }

    #[test]
    fn a_line_covers_length_times_width() {
        let size = Size::new(60, 60);
        let line = stroke(&[vec2(10.0, 10.0), vec2(40.0, 50.0)], 3.0, false);
        assert!((area(&line, size) - 150.0).abs() < 0.01);
        // A square's outline with mitred corners.
        let frame = stroke(&rectangle(10.0, 10.0, 30.0, 30.0), 2.0, true);
        assert!((area(&frame, size) - 160.0).abs() < 0.01);
        let circle: Vec<Vec2> = (0..200)
            .map(|i| i as f64 * std::f64::consts::TAU / 200.0)
            .map(|a| vec2(30.0 + 20.0 * exact::cos(a) as f32, 30.0 + 20.0 * exact::sin(a) as f32))
            .collect();
        assert!((area(&stroke(&circle, 1.5, true), size) - std::f64::consts::TAU * 20.0 * 1.5).abs() < 0.2);
    }
}
