//! Smooth curves through given rows of numbers: the spines and profiles that samples are swept along.

use crate::math::DVec3;

/// A curve through rows of `K` numbers, the first three a place in space; runs by arc length.
pub(super) struct Curve<const K: usize> {
    /// Parameter of each row: distance along the chords.
    knots: Vec<f64>,
    rows: Vec<[f64; K]>,
    slopes: Vec<[f64; K]>,
    /// Parameter and distance along the curve, finely sampled.
    lengths: Vec<[f64; 2]>,
}

impl<const K: usize> Curve<K> {
    /// Through `rows` in order: the place as a natural cubic spline (no jump in curvature), the other numbers monotone
    /// between rows (Fritsch and Carlson 1980), so that a radius never swings below what was asked for.
    pub(super) fn through(rows: &[[f64; K]]) -> Self {
        let mut knots = vec![0.0];
        for w in rows.windows(2) {
            knots.push(knots[knots.len() - 1] + place(&w[0]).distance(place(&w[1])));
        }
        let mut slopes = vec![[0.0; K]; rows.len()];
        for k in 0..K {
            let y: Vec<f64> = rows.iter().map(|r| r[k]).collect();
            let m = if k < 3 { natural_slopes(&knots, &y) } else { monotone_slopes(&knots, &y) };
            (0..rows.len()).for_each(|i| slopes[i][k] = m[i]);
        }
        let mut curve = Self { knots, rows: rows.to_vec(), slopes, lengths: vec![[0.0; 2]] };
        let n = 16 * (rows.len() - 1);
        let end = curve.knots[rows.len() - 1];
        let (mut last, mut length) = (place(&curve.at_knot(0.0)), 0.0);
        for i in 1..=n {
            let t = end * i as f64 / n as f64;
            let p = place(&curve.at_knot(t));
            length += p.distance(last);
            last = p;
            curve.lengths.push([t, length]);
        }
        curve
    }

    /// From end to end.
    pub(super) fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1][1]
    }

    /// The row at a distance from the start, clamped to the ends.
    pub(super) fn at(&self, length: f64) -> [f64; K] {
        let i = self.lengths.partition_point(|l| l[1] < length).clamp(1, self.lengths.len() - 1);
        let ([t0, l0], [t1, l1]) = (self.lengths[i - 1], self.lengths[i]);
        let f = ((length - l0) / (l1 - l0).max(1e-12)).clamp(0.0, 1.0);
        self.at_knot(t0 + (t1 - t0) * f)
    }

    /// The direction at a distance from the start, unit.
    pub(super) fn direction(&self, length: f64) -> DVec3 {
        let h = 1e-4 * self.length();
        let l = length.clamp(h, self.length() - h);
        (place(&self.at(l + h)) - place(&self.at(l - h))).normalize()
    }

    fn at_knot(&self, t: f64) -> [f64; K] {
        let i = self.knots.partition_point(|k| *k <= t).clamp(1, self.knots.len() - 1);
        let h = self.knots[i] - self.knots[i - 1];
        let f = ((t - self.knots[i - 1]) / h).clamp(0.0, 1.0);
        let g = 1.0 - f;
        std::array::from_fn(|k| {
            let (a, b) = (self.rows[i - 1][k], self.rows[i][k]);
            let (da, db) = (self.slopes[i - 1][k] * h, self.slopes[i][k] * h);
            g * g * (1.0 + 2.0 * f) * a + f * f * (3.0 - 2.0 * f) * b + f * g * (g * da - f * db)
        })
    }
}

/// A row's place.
pub(super) fn place<const K: usize>(row: &[f64; K]) -> DVec3 {
    DVec3::new(row[0], row[1], row[2])
}

/// Slopes of the cubic spline with vanishing second derivative at both ends (tridiagonal, Thomas's algorithm).
fn natural_slopes(t: &[f64], y: &[f64]) -> Vec<f64> {
    let n = t.len();
    let (mut diagonal, mut right, mut upper) = (vec![2.0; n], vec![0.0; n], vec![1.0; n]);
    let mut lower = vec![1.0; n];
    let chord = |i: usize| (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
    right[0] = 3.0 * chord(0);
    right[n - 1] = 3.0 * chord(n - 2);
    for i in 1..n - 1 {
        let (a, b) = (1.0 / (t[i] - t[i - 1]), 1.0 / (t[i + 1] - t[i]));
        (lower[i], upper[i], diagonal[i]) = (a, b, 2.0 * (a + b));
        right[i] = 3.0 * (a * chord(i - 1) + b * chord(i));
    }
    for i in 1..n {
        let m = lower[i] / diagonal[i - 1];
        diagonal[i] -= m * upper[i - 1];
        right[i] -= m * right[i - 1];
    }
    let mut slopes = vec![right[n - 1] / diagonal[n - 1]; n];
    for i in (0..n - 1).rev() {
        slopes[i] = (right[i] - upper[i] * slopes[i + 1]) / diagonal[i];
    }
    slopes
}

/// Slopes that keep a cubic monotone wherever the rows are (harmonic means).
fn monotone_slopes(t: &[f64], y: &[f64]) -> Vec<f64> {
    let n = t.len();
    let chord = |i: usize| (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
    (0..n)
        .map(|i| match i {
            0 => chord(0),
            i if i == n - 1 => chord(n - 2),
            i => {
                let (a, b) = (chord(i - 1), chord(i));
                let (ha, hb) = (t[i] - t[i - 1], t[i + 1] - t[i]);
                let (wa, wb) = (2.0 * hb + ha, hb + 2.0 * ha);
                if a * b > 0.0 { (wa + wb) / (wa / a + wb / b) } else { 0.0 }
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_stays_straight_and_radii_do_not_overshoot() {
        let curve =
            Curve::through(&[[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0], [3.0, 0.0, 0.0, 0.2], [4.0, 0.0, 0.0, 0.2]]);
        assert!((curve.length() - 4.0).abs() < 1e-9);
        for i in 0..=100 {
            let l = 0.04 * i as f64;
            let [x, y, z, r] = curve.at(l);
            assert!((x - l).abs() < 1e-2 && y == 0.0 && z == 0.0 && (0.2..=1.0).contains(&r), "{l}: {x} {r}");
        }
    }
}
