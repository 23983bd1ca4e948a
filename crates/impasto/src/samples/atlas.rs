//! Rectangles of surface laid side by side in the unit square, with a gutter between them.

use crate::math::{DVec2, exact};

/// Where charts lie in the texture.
pub(super) struct Atlas {
    /// Texture widths a model unit; the same for all charts.
    pub(super) scale: f64,
    /// Upper left corner of each chart, texture widths.
    pub(super) corners: Vec<DVec2>,
}

/// Lays charts of these sizes (model units) on shelves, high ones first, as large as fits, `gutter` texture widths apart
/// and away from the edge.
pub(super) fn shelves(sizes: &[DVec2], gutter: f64) -> Atlas {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by(|&a, &b| sizes[b].y.total_cmp(&sizes[a].y).then(a.cmp(&b)));
    let area: f64 = sizes.iter().map(|s| s.x * s.y).sum();
    // The area is an upper bound of the scale; go down in steps of half a percent.
    let bound = 1.0 / area.max(1e-12).sqrt();
    (0..2000)
        .map(|step| bound * exact::pow(0.995, step as f64))
        .find_map(|scale| {
            let corners = fit(sizes, &order, scale, gutter)?;
            Some(Atlas { scale, corners })
        })
        .expect("a small enough scale always fits")
}

fn fit(sizes: &[DVec2], order: &[usize], scale: f64, gutter: f64) -> Option<Vec<DVec2>> {
    let mut corners = vec![DVec2::ZERO; sizes.len()];
    // Free strips: left, top, width, height; a chart is put into the first that is wide and high enough, and the room
    // right of it and below it become new strips.
    let mut strips = vec![[gutter, gutter, 1.0 - gutter, 1.0 - gutter]];
    for &i in order {
        let size = sizes[i] * scale + DVec2::splat(gutter);
        let k = strips.iter().position(|s| s[2] >= size.x && s[3] >= size.y)?;
        let [x, y, w, h] = strips.remove(k);
        corners[i] = DVec2::new(x, y);
        strips.push([x, y + size.y, w, h - size.y]);
        strips.push([x + size.x, y, w - size.x, size.y]);
        strips.sort_by(|a, b| (a[2] * a[3]).total_cmp(&(b[2] * b[3])));
    }
    Some(corners)
}
