//! Points sorted into cubes, to find those near a place.

use crate::math::DVec3;

/// Indices of points by the cube they lie in.
pub(super) struct Cells {
    low: DVec3,
    per_edge: f64,
    n: [usize; 3],
    start: Vec<u32>,
    points: Vec<u32>,
}

/// Cubes hold some tens of atoms of any real matter; of more only the first count, so that no file can make work without
/// end.
const MOST_IN_A_CELL: usize = 512;

impl Cells {
    /// For finite points and searches within `reach`. Linear in time and memory.
    pub(super) fn of(points: impl Iterator<Item = DVec3> + Clone, reach: f64) -> Self {
        let n_points = points.clone().count();
        let low = points.clone().fold(DVec3::INFINITY, DVec3::min);
        let high = points.clone().fold(DVec3::NEG_INFINITY, DVec3::max);
        let extent = if n_points == 0 { DVec3::ZERO } else { high - low };
        // Cubes grow until there are about as many as points.
        let mut edge = reach.max(extent.max_element() * 1e-6).max(1e-6);
        let counts = |edge: f64| extent.to_array().map(|e| (e / edge) as usize + 1);
        while counts(edge).iter().map(|n| *n as f64).product::<f64>() > 4.0 * n_points as f64 + 64.0 {
            edge *= 1.25;
        }
        let n = counts(edge);
        let mut cells =
            Self { low, per_edge: 1.0 / edge, n, start: vec![0; n[0] * n[1] * n[2] + 1], points: Vec::new() };
        for p in points.clone() {
            let c = cells.cell(p);
            cells.start[c + 1] += 1;
        }
        for c in 1..cells.start.len() {
            cells.start[c] += cells.start[c - 1];
        }
        let mut next = cells.start.clone();
        cells.points = vec![0; n_points];
        for (i, p) in points.enumerate() {
            let c = cells.cell(p);
            cells.points[next[c] as usize] = i as u32;
            next[c] += 1;
        }
        cells
    }

    /// Along an axis, the cube a coordinate lies in; those outside count as in the first or last.
    fn along(&self, p: DVec3, axis: usize) -> usize {
        (((p - self.low)[axis] * self.per_edge) as usize).min(self.n[axis] - 1)
    }

    fn cell(&self, p: DVec3) -> usize {
        (self.along(p, 2) * self.n[1] + self.along(p, 1)) * self.n[0] + self.along(p, 0)
    }

    /// Every point within the reach of a place, and others; always in the same order.
    pub(super) fn near(&self, p: DVec3, mut visit: impl FnMut(u32)) {
        if self.points.is_empty() {
            return;
        }
        let around = |axis: usize| {
            let at = self.along(p, axis);
            at.saturating_sub(1)..(at + 2).min(self.n[axis])
        };
        for k in around(2) {
            for j in around(1) {
                for i in around(0) {
                    let c = (k * self.n[1] + j) * self.n[0] + i;
                    let here = &self.points[self.start[c] as usize..self.start[c + 1] as usize];
                    here.iter().take(MOST_IN_A_CELL).for_each(|&point| visit(point));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{hash_cell, unit_float};

    #[test]
    fn all_that_is_near_is_found_once() {
        let f = |i: i32, axis: i32| unit_float(hash_cell(i, axis, 0, 5)) as f64;
        let points: Vec<DVec3> = (0..300).map(|i| DVec3::new(f(i, 0) * 20.0, f(i, 1) * 9.0, f(i, 2))).collect();
        let cells = Cells::of(points.iter().copied(), 1.5);
        for i in 300..360 {
            let p = DVec3::new(f(i, 0) * 24.0 - 2.0, f(i, 1) * 9.0, f(i, 2) * 4.0 - 2.0);
            let mut found = Vec::new();
            cells.near(p, |q| found.push(q));
            found.retain(|q| points[*q as usize].distance(p) <= 1.5);
            found.sort_unstable();
            let wanted: Vec<u32> = (0..300).filter(|q| points[*q as usize].distance(p) <= 1.5).collect();
            assert_eq!(found, wanted);
        }
        Cells::of(std::iter::empty(), 1.0).near(DVec3::ZERO, |_| unreachable!());
        Cells::of([DVec3::ZERO, DVec3::splat(1e30)].into_iter(), 1.0).near(DVec3::ZERO, |i| assert_eq!(i, 0));
    }
}
