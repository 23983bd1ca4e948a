//! Isolines traced through a picture of values, and places for their labels.
//!
//! Lines by marching squares (Lorensen and Cline, "Marching Cubes", 1987, in the plane): crossings lie on the lines between
//! pixel centres; where a cell has two diagonals of equal sides, the mean of its corners tells them apart.

use crate::color::LinearRgba;
use crate::math::{Size, Vec2, atan2, vec2};
use crate::picture::drawing::{Align, Item, Rect, Text};
use crate::picture::font::{self, Weight};
use crate::picture::numbers::{self, Notation};
use std::collections::HashMap;

/// A line of equal values.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// Which of the levels it has.
    pub level_idx: usize,
    /// Its points in pixels, at least two; greater values lie on the right of their way, as one sees it.
    pub points: Vec<Vec2>,
    /// Whether the last point is joined to the first.
    pub is_closed: bool,
}

impl Contour {
    /// For each point its way along the line; for a closed one also that of the first when it is reached again.
    fn lengths(&self) -> Vec<f32> {
        let mut length = 0.0;
        let mut lengths = vec![0.0];
        let ends = self.points.iter().skip(1).chain(self.is_closed.then_some(&self.points[0]));
        for (a, b) in self.points.iter().zip(ends) {
            length += (*b - *a).length();
            lengths.push(length);
        }
        lengths
    }
}

/// The lines of all levels through values at pixel centres, rows from the top. They end where a value is NaN.
///
/// Put NaN between surfaces that only meet in the picture, or lines run along their border. Values that equal a level
/// count as greater. Lines come by level, then in the order of their topmost cell.
pub fn trace(values: &[f32], size: Size, levels: &[f32]) -> Vec<Contour> {
    assert_eq!(values.len(), size.n_cells(), "a grid of {size} has that many values");
    let mut segments: Vec<Vec<[u64; 2]>> = vec![Vec::new(); levels.len()];
    // Levels by value, so that a cell finds those between its corners.
    let mut order: Vec<usize> = (0..levels.len()).filter(|i| !levels[*i].is_nan()).collect();
    order.sort_by(|a, b| levels[*a].total_cmp(&levels[*b]));
    let width = size.width as usize;
    for y in 0..(size.height as usize).saturating_sub(1) {
        for x in 0..width.saturating_sub(1) {
            let i = y * width + x;
            // Clockwise from the top left.
            let corners = [values[i], values[i + 1], values[i + width + 1], values[i + width]];
            let low = corners.iter().fold(f32::INFINITY, |m, v| m.min(*v));
            let high = corners.iter().fold(f32::NEG_INFINITY, |m, v| m.max(*v));
            if low.is_nan() || high.is_nan() || low >= high || corners.iter().any(|v| !v.is_finite()) {
                continue;
            }
            let first = order.partition_point(|k| levels[*k] <= low);
            for &k in order[first..].iter().take_while(|k| levels[**k] <= high) {
                cross(corners, levels[k], i, width, &mut segments[k]);
            }
        }
    }
    let at = |edge: u64, level: f32| {
        let (i, is_down) = ((edge / 2) as usize, edge % 2 == 1);
        let (a, b) = (values[i], values[if is_down { i + width } else { i + 1 }]);
        let t = ((level - a) / (b - a)).clamp(0.0, 1.0);
        let start = vec2((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        start + if is_down { vec2(0.0, t) } else { vec2(t, 0.0) }
    };
    let lines = |(k, segments): (usize, Vec<[u64; 2]>)| {
        let joined = join(&segments).into_iter().map(move |chain| (k, chain));
        joined.collect::<Vec<_>>()
    };
    let all = segments.into_iter().enumerate().flat_map(lines);
    all.filter_map(|(k, (edges, is_closed))| {
        let mut points: Vec<Vec2> = edges.iter().map(|e| at(*e, levels[k])).collect();
        points.dedup();
        (points.len() > 1).then_some(Contour { level_idx: k, points, is_closed })
    })
    .collect()
}

/// Adds a cell's one or two segments. An edge has the number of its left or upper pixel twice, plus one if it goes down.
fn cross(corners: [f32; 4], level: f32, i: usize, width: usize, segments: &mut Vec<[u64; 2]>) {
    let top = i as u64 * 2;
    let [right, bottom, left] = [(i as u64 + 1) * 2 + 1, (i + width) as u64 * 2, top + 1];
    let edges = [top, right, bottom, left];
    let is_in: [bool; 4] = corners.map(|v| v >= level);
    // Edge e joins corners e and e + 1: where the line enters the greater side clockwise, and where it leaves it.
    let entries: Vec<usize> = (0..4).filter(|e| !is_in[*e] && is_in[(e + 1) % 4]).collect();
    let leave_after = |entry: usize| (1..4).map(|d| (entry + d) % 4).find(|e| is_in[*e] && !is_in[(e + 1) % 4]);
    let is_joined = entries.len() == 2 && corners.iter().sum::<f32>() * 0.25 >= level;
    for &entry in &entries {
        // Where the middle is greater, the two greater corners are joined and each line cuts off a lesser one.
        let leave = if is_joined { Some((entry + 3) % 4) } else { leave_after(entry) };
        segments.extend(leave.map(|leave| [edges[leave], edges[entry]]));
    }
}

/// Segments to chains of edges; a chain whose ends meet is closed.
fn join(segments: &[[u64; 2]]) -> Vec<(Vec<u64>, bool)> {
    // Lines keep their greater side, so that no two begin, nor two end, at one edge.
    let next: HashMap<u64, usize> = segments.iter().enumerate().map(|(i, s)| (s[0], i)).collect();
    let before: HashMap<u64, usize> = segments.iter().enumerate().map(|(i, s)| (s[1], i)).collect();
    let mut is_used = vec![false; segments.len()];
    let mut chains = Vec::new();
    for i in 0..segments.len() {
        if is_used[i] {
            continue;
        }
        // Back to where the line begins, or round to here.
        let mut first = i;
        while let Some(&b) = before.get(&segments[first][0]) {
            first = b;
            if b == i {
                break;
            }
        }
        let mut chain = vec![segments[first][0]];
        let mut at = Some(first);
        while let Some(k) = at.filter(|k| !is_used[*k]) {
            is_used[k] = true;
            chain.push(segments[k][1]);
            at = next.get(&segments[k][1]).copied();
        }
        let is_closed = chain.len() > 3 && chain.first() == chain.last();
        if is_closed {
            chain.pop();
        }
        chains.push((chain, is_closed));
    }
    chains
}

/// How labels look and how dense they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabelStyle {
    /// The em, pixels.
    pub size: f32,
    /// Of the letters.
    pub color: LinearRgba,
    /// Colour and width of the rim that keeps the line off the letters.
    pub halo: Option<(LinearRgba, f32)>,
    /// How far labels of a line are apart along it, pixels.
    pub spacing: f32,
}

impl LabelStyle {
    /// Letters of a size with a rim, a label every 30 sizes.
    pub fn new(size: f32, color: LinearRgba, halo: LinearRgba) -> Self {
        Self { size, color, halo: Some((halo, (size * 0.16).max(1.5))), spacing: size * 30.0 }
    }
}

/// What stands on the lines of some levels: as few digits as tell them apart.
pub fn level_texts(levels: &[f32], notation: Notation) -> Vec<String> {
    let values: Vec<f64> = levels.iter().map(|v| *v as f64).collect();
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    let least = sorted.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
    let greatest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    // An f32 has seven digits; levels are round to a hundredth of their distance.
    let tolerance = if least.is_finite() { least * 0.01 } else { greatest * 1e-3 };
    let column = numbers::column(&values, tolerance.max(greatest * 2e-7), notation);
    if column.exponent == 0 && column.offset == 0.0 {
        return column.labels;
    }
    let are_apart = |n: usize| {
        let differ =
            |w: &[f64]| w[0] == w[1] || numbers::single(w[0], n, notation) != numbers::single(w[1], n, notation);
        sorted.windows(2).all(differ)
    };
    let n_digits = (2..7).find(|n| are_apart(*n));
    values.iter().map(|v| numbers::single(*v, n_digits.unwrap_or(7), notation)).collect()
}

/// Labels on lines, one text for each level; an empty text leaves its level alone. Longest lines first.
///
/// A label lies where its line is straight, away from its ends, upright, wholly over finite `values`, on no other label
/// and on none of `taken`.
pub fn labels(
    contours: &[Contour],
    texts: &[String],
    (values, size): (&[f32], Size),
    style: &LabelStyle,
    taken: &[Rect],
) -> Vec<Item> {
    let mut lines: Vec<(&Contour, Vec<f32>)> = contours.iter().map(|c| (c, c.lengths())).collect();
    let whole = |lengths: &Vec<f32>| lengths.last().copied().unwrap_or(0.0);
    lines.sort_by(|a, b| whole(&b.1).total_cmp(&whole(&a.1)));
    let mut boxes: Vec<Tilted> = taken.iter().map(Tilted::of).collect();
    let mut items = Vec::new();
    for (contour, lengths) in &lines {
        let Some(text) = texts.get(contour.level_idx).filter(|t| !t.is_empty()) else { continue };
        let length = font::width(text, style.size, Weight::Regular) + style.size * 0.5;
        let mut places = places(contour, lengths, length, style.size);
        places.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let mut chosen: Vec<f32> = Vec::new();
        for place in places {
            let around = whole(lengths);
            let apart = |s: &f32| {
                let d = (s - place.along).abs();
                if contour.is_closed { d.min(around - d) } else { d }
            };
            if chosen.iter().any(|s| apart(s) < style.spacing) {
                continue;
            }
            let half = vec2(0.5 * length, 0.5 * style.size * (font::CAP_HEIGHT + 0.5));
            let own = Tilted { center: place.at, along: place.direction, half };
            if !own.is_over_values(values, size) || boxes.iter().any(|b| b.overlaps(&own)) {
                continue;
            }
            chosen.push(place.along);
            boxes.push(own);
            let mut item = Text::new(text, place.at, style.size, style.color);
            (item.align, item.is_centered, item.halo) = (Align::Middle, true, style.halo);
            item.angle = atan2(place.direction.y, place.direction.x);
            items.push(Item::Text(item));
        }
    }
    items
}

/// Where a label could lie.
struct Place {
    /// Its middle, on the line.
    at: Vec2,
    /// The way along the line.
    along: f32,
    /// Its baseline's direction, to the right.
    direction: Vec2,
    /// The lesser the better.
    cost: f32,
}

/// All places on a line where it is straight enough for a label of a length.
fn places(contour: &Contour, lengths: &[f32], length: f32, size: f32) -> Vec<Place> {
    let whole = *lengths.last().expect("a line has points");
    let margin = if contour.is_closed { 0.0 } else { 0.5 * length + size };
    // Round a circle of that length a label would look like a lid.
    if whole < 2.0 * margin || (contour.is_closed && whole < 2.5 * length) {
        return Vec::new();
    }
    let point = |s: f32| point_at(contour, lengths, s);
    let step = (0.3 * size).max(1.0);
    let n = (((whole - 2.0 * margin) / step) as usize).min(20_000);
    let place = |i: usize| {
        let along = margin + i as f32 * step;
        let (at, from, to) = (point(along), point(along - 0.5 * length), point(along + 0.5 * length));
        let chord = to - from;
        if chord.length() < 0.9 * length {
            return None;
        }
        let direction = chord / chord.length();
        // How far the line leaves the label's own line.
        let bend = (0..=8).map(|k| point(along + length * (k as f32 / 8.0 - 0.5)) - at);
        let bend = bend.fold(0.0f32, |m, p| m.max((p.x * direction.y - p.y * direction.x).abs()));
        if bend > 0.3 * size {
            return None;
        }
        let direction =
            if direction.x < -1e-4 || (direction.x <= 1e-4 && direction.y > 0.0) { -direction } else { direction };
        // Level labels are easier to read; the middle of a line is where one looks for it.
        let off_middle = if contour.is_closed { 0.0 } else { (along / whole - 0.5).abs() };
        let cost = bend / size + 0.35 * direction.y.abs() + 0.3 * off_middle;
        Some(Place { at, along, direction, cost })
    };
    (0..=n).filter_map(place).collect()
}

/// The point that is so far along; closed lines go on.
fn point_at(contour: &Contour, lengths: &[f32], s: f32) -> Vec2 {
    let whole = lengths[lengths.len() - 1];
    let s = match contour.is_closed {
        true if s < 0.0 => s + whole,
        true if s > whole => s - whole,
        _ => s,
    };
    let s = s.clamp(0.0, whole);
    let i = lengths.partition_point(|l| *l < s).clamp(1, lengths.len() - 1) - 1;
    let (a, b) = (contour.points[i], contour.points[(i + 1) % contour.points.len()]);
    let part = lengths[i + 1] - lengths[i];
    if part > 0.0 { a + (b - a) * ((s - lengths[i]) / part) } else { a }
}

/// A rectangle that is turned.
#[derive(Clone, Copy)]
struct Tilted {
    center: Vec2,
    along: Vec2,
    half: Vec2,
}

impl Tilted {
    fn of(rect: &Rect) -> Self {
        let half = 0.5 * (rect.max - rect.min);
        Self { center: rect.min + half, along: vec2(1.0, 0.0), half }
    }

    fn axes(&self) -> [Vec2; 2] {
        [self.along, vec2(-self.along.y, self.along.x)]
    }

    /// Half its extent along an axis.
    fn reach(&self, axis: Vec2) -> f32 {
        let [u, v] = self.axes();
        self.half.x * u.dot(axis).abs() + self.half.y * v.dot(axis).abs()
    }

    /// Whether they share an area: no side of either parts them.
    fn overlaps(&self, other: &Self) -> bool {
        let between = other.center - self.center;
        let is_parted = |axis: &Vec2| between.dot(*axis).abs() >= self.reach(*axis) + other.reach(*axis);
        !self.axes().iter().chain(&other.axes()).any(is_parted)
    }

    /// Whether all pixels below it have values. It is sampled finer than pixels are.
    fn is_over_values(&self, values: &[f32], size: Size) -> bool {
        let [u, v] = self.axes();
        let n = (self.half / 0.4).ceil();
        let share = |i: i32, n: f32| i as f32 / n.max(1.0);
        (-n.y as i32..=n.y as i32).all(|j| {
            (-n.x as i32..=n.x as i32).all(|i| {
                let p = self.center + u * (self.half.x * share(i, n.x)) + v * (self.half.y * share(j, n.y));
                let is_inside = p.x >= 0.0 && p.y >= 0.0 && p.x < size.width as f32 && p.y < size.height as f32;
                is_inside && values[p.y as usize * size.width as usize + p.x as usize].is_finite()
            })
        })
    }
}

#[cfg(test)]
#[path = "contour_tests.rs"]
mod tests;
