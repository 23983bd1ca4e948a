//! Rectangles into a square, at the largest common scale at which they fit.
//!
//! Shelves of falling height ("next fit decreasing height": Coffman et al., "Performance Bounds for Level-Oriented
//! Two-Dimensional Packing Algorithms", 1980): simple, never fails, wastes about a fifth.

use crate::math::{DVec2, Vec2};

/// Where the rectangles went.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Packing {
    /// Texels a unit of the rectangles' sizes.
    pub(super) scale: f64,
    /// The gap to each rectangle's own edge, texels: what was asked for, or less when there are too many rectangles.
    pub(super) gutter: f64,
    /// Corner of each rectangle with the smallest coordinates, texels, gutter excluded.
    pub(super) corners: Vec<DVec2>,
}

/// Packs rectangles of `sizes` into `edge` x `edge` texels with `gutter` texels around each.
pub(super) fn pack(sizes: &[Vec2], edge: f64, gutter: f64) -> Packing {
    let mut order: Vec<u32> = (0..sizes.len() as u32).collect();
    order.sort_by(|&a, &b| sizes[b as usize].y.total_cmp(&sizes[a as usize].y).then(a.cmp(&b)));
    let largest_scale = |gutter: f64| {
        let side = sizes.iter().fold(0.0, |m: f64, s| m.max(s.x.max(s.y) as f64));
        let (mut low, mut high) = (0.0, if side > 0.0 { (edge - 2.0 * gutter) / side } else { 1.0 });
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if shelves(sizes, &order, edge, gutter, middle).is_some() { low = middle } else { high = middle }
        }
        low
    };
    // Too many charts for the gutter: rather a narrower gutter than charts without texels.
    let without = largest_scale(0.0);
    let mut gutter = gutter;
    let mut scale = largest_scale(gutter);
    while scale < 0.25 * without && gutter > 0.0 {
        gutter = if gutter > 0.25 { 0.5 * gutter } else { 0.0 };
        scale = largest_scale(gutter);
    }
    let corners = shelves(sizes, &order, edge, gutter, scale).unwrap_or_else(|| vec![DVec2::ZERO; sizes.len()]);
    Packing { scale, gutter, corners }
}

/// The corners, if all fits.
fn shelves(sizes: &[Vec2], order: &[u32], edge: f64, gutter: f64, scale: f64) -> Option<Vec<DVec2>> {
    let mut corners = vec![DVec2::ZERO; sizes.len()];
    let (mut x, mut y, mut shelf) = (0.0, 0.0, 0.0);
    for &i in order {
        let size = sizes[i as usize].as_dvec2() * scale + DVec2::splat(2.0 * gutter);
        if x + size.x > edge {
            (x, y, shelf) = (0.0, y + shelf, 0.0);
        }
        if x + size.x > edge || y + size.y > edge {
            return None;
        }
        corners[i as usize] = DVec2::new(x + gutter, y + gutter);
        x += size.x;
        shelf = if size.y > shelf { size.y } else { shelf };
    }
    Some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{hash_cell, unit_float, vec2};

    #[test]
    fn rectangles_keep_their_distance_and_stay_inside() {
        for (n, gutter) in [(1, 2.0), (7, 3.0), (300, 2.0), (5000, 4.0)] {
            let random = |i: usize, salt| unit_float(hash_cell(i as i32, n as i32, 0, salt)) + 0.01;
            let sizes: Vec<Vec2> = (0..n).map(|i| vec2(random(i, 1), random(i, 2) * 0.5)).collect();
            let packing = pack(&sizes, 512.0, gutter);
            assert!(packing.scale > 0.0 && packing.gutter <= gutter);
            let boxes: Vec<_> = (0..n)
                .map(|i| (packing.corners[i], packing.corners[i] + sizes[i].as_dvec2() * packing.scale))
                .collect();
            let g = packing.gutter - 1e-9;
            for (i, (low, high)) in boxes.iter().enumerate() {
                assert!(low.min_element() >= g && high.max_element() <= 512.0 - g);
                for (other_low, other_high) in boxes[i + 1..].iter().take(200) {
                    let apart = (*other_low - *high).max(*low - *other_high).max_element();
                    assert!(apart >= 2.0 * g, "{n} rectangles: {apart}");
                }
            }
            if n == 300 {
                let area: f64 = boxes.iter().map(|(low, high)| (*high - *low).element_product()).sum();
                assert!(area > 0.5 * 512.0 * 512.0, "used {area}");
            }
        }
    }
}
