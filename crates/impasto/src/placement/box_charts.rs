//! A layout that always works: pieces of the surface that face the same way, laid flat along the axes.
//!
//! For meshes that nothing better can be said about (and as the fallback of [`super::unwrap()`]): no solver, any topology.
//! A piece that would cover itself, like the turns of a screw, is cut until it does not.

use crate::math::{DVec2, DVec3, Vec2, Vec3, vec2};
use crate::placement::pack::pack;

/// After this many cuts of one piece its triangles go singly: bounds the work on surfaces folded over and over.
const MAX_ROUNDS: usize = 64;

/// A layout: a texture coordinate a corner.
pub(super) struct Layout {
    /// Three a triangle, v down.
    pub(super) uv: Vec<Vec2>,
    /// How many pieces.
    pub(super) n_charts: usize,
    /// Texels kept free around each.
    pub(super) gutter_texels: f64,
}

/// A piece: triangles and the box around them on their plane.
struct Chart {
    triangles: Vec<u32>,
    low: DVec2,
    high: DVec2,
}

/// Lays out all triangles in a square of `edge_texels` with a gutter. Triangles without area get a point of a neighbour.
pub(super) fn box_charts(positions: &[Vec3], triangles: &[[u32; 3]], edge_texels: u32, gutter: u32) -> Layout {
    let facing: Vec<Option<u8>> = triangles.iter().map(|t| facing(t.map(|v| positions[v as usize]))).collect();
    let flat: Vec<[DVec2; 3]> = triangles
        .iter()
        .zip(&facing)
        .map(|(t, side)| t.map(|v| side.map_or(DVec2::ZERO, |side| on_side(positions[v as usize], side))))
        .collect();
    let neighbours = neighbours(&points(positions), triangles);

    let mut charts = Vec::new();
    let mut waiting: Vec<bool> = facing.iter().map(Option::is_some).collect();
    for round in 0..=MAX_ROUNDS {
        // Each round lays pieces as far as they do not cover themselves; what would goes to the next round.
        let laid = grow(&facing, &flat, &neighbours, &waiting, round == MAX_ROUNDS);
        for chart in &laid {
            chart.triangles.iter().for_each(|&t| waiting[t as usize] = false);
        }
        charts.extend(laid);
        if !waiting.contains(&true) {
            break;
        }
    }
    place_charts(&charts, &flat, triangles, positions.len(), edge_texels as f64, gutter as f64)
}

/// How many pieces of surface there are that share no edge, over all places that coincide.
pub(super) fn n_pieces(positions: &[Vec3], triangles: &[[u32; 3]]) -> usize {
    let neighbours = neighbours(&points(positions), triangles);
    let mut seen = vec![false; triangles.len()];
    let mut waiting = Vec::new();
    let mut n = 0;
    for seed in 0..triangles.len() as u32 {
        n += !seen[seed as usize] as usize;
        waiting.push(seed);
        while let Some(t) = waiting.pop() {
            if !std::mem::replace(&mut seen[t as usize], true) {
                waiting.extend(neighbours.of(t).iter().filter(|&&other| !seen[other as usize]));
            }
        }
    }
    n
}

/// Which way a triangle faces: axis * 2, + 1 for the negative direction. None without area.
fn facing([a, b, c]: [Vec3; 3]) -> Option<u8> {
    let n = (b.as_dvec3() - a.as_dvec3()).cross(c.as_dvec3() - a.as_dvec3());
    let axis = if n.z.abs() >= n.x.abs() && n.z.abs() >= n.y.abs() {
        2
    } else if n.x.abs() >= n.y.abs() {
        0
    } else {
        1
    };
    let along = n.to_array()[axis];
    (along != 0.0).then_some(axis as u8 * 2 + (along < 0.0) as u8)
}

/// A point seen from outside that side, y up: triangles that face it run counter-clockwise.
fn on_side(p: Vec3, side: u8) -> DVec2 {
    let p: DVec3 = p.as_dvec3();
    match side {
        0 => DVec2::new(-p.z, p.y),
        1 => DVec2::new(p.z, p.y),
        2 => DVec2::new(p.x, -p.z),
        3 => DVec2::new(p.x, p.z),
        4 => DVec2::new(p.x, p.y),
        _ => DVec2::new(-p.x, p.y),
    }
}

/// For each vertex, the first vertex at the same place.
fn points(positions: &[Vec3]) -> Vec<u32> {
    // Adding 0 makes one zero of the two.
    let key = |v: u32| positions[v as usize].to_array().map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_by_key(|&v| (key(v), v));
    let mut points = vec![0; positions.len()];
    let mut first = 0;
    for (i, &v) in order.iter().enumerate() {
        if i == 0 || key(order[i - 1]) != key(v) {
            first = v;
        }
        points[v as usize] = first;
    }
    points
}

/// For each triangle, the triangles across its edges, in order: `list[start[t]..start[t + 1]]`.
struct Neighbours {
    start: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    fn of(&self, t: u32) -> &[u32] {
        &self.list[self.start[t as usize] as usize..self.start[t as usize + 1] as usize]
    }
}

fn neighbours(points: &[u32], triangles: &[[u32; 3]]) -> Neighbours {
    let mut edges: Vec<[u32; 3]> = Vec::with_capacity(triangles.len() * 3);
    for (t, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (points[corners[k] as usize], points[corners[(k + 1) % 3] as usize]);
            edges.push([a.min(b), a.max(b), t as u32]);
        }
    }
    edges.sort_unstable();
    // Where many triangles meet at one edge, each is linked to the next only: connected all the same.
    let mut pairs: Vec<[u32; 2]> = edges
        .windows(2)
        .filter(|w| w[0][..2] == w[1][..2] && w[0][2] != w[1][2])
        .flat_map(|w| [[w[0][2], w[1][2]], [w[1][2], w[0][2]]])
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let mut start = vec![0u32; triangles.len() + 1];
    pairs.iter().for_each(|pair| start[pair[0] as usize + 1] += 1);
    for t in 0..triangles.len() {
        start[t + 1] += start[t];
    }
    Neighbours { start, list: pairs.iter().map(|pair| pair[1]).collect() }
}

/// Pieces of waiting triangles that face the same way, each as far as it does not cover itself.
fn grow(
    facing: &[Option<u8>],
    flat: &[[DVec2; 3]],
    neighbours: &Neighbours,
    waiting: &[bool],
    singly: bool,
) -> Vec<Chart> {
    let mut charts = Vec::new();
    let mut seen: Vec<bool> = waiting.iter().map(|w| !w).collect();
    for seed in 0..facing.len() as u32 {
        if seen[seed as usize] {
            continue;
        }
        seen[seed as usize] = true;
        let mut piece = vec![seed];
        let mut at = 0;
        while at < piece.len() && !singly {
            for &t in neighbours.of(piece[at]) {
                if !seen[t as usize] && facing[t as usize] == facing[seed as usize] {
                    seen[t as usize] = true;
                    piece.push(t);
                }
            }
            at += 1;
        }
        charts.push(chart(piece, flat));
    }
    charts
}

/// The triangles of a piece, in order, that do not cover one before them.
fn chart(piece: Vec<u32>, flat: &[[DVec2; 3]]) -> Chart {
    let mut grid = Grid::over(&piece, flat);
    let triangles: Vec<u32> = piece.into_iter().filter(|&t| grid.take(t, flat)).collect();
    let corners = triangles.iter().flat_map(|&t| flat[t as usize]);
    let (low, high) = corners.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    Chart { triangles, low, high }
}

/// The triangles laid so far, by the cells of a grid that they touch.
struct Grid {
    low: DVec2,
    per_cell: DVec2,
    width: usize,
    height: usize,
    cells: Vec<Vec<u32>>,
}

impl Grid {
    /// Cells about as large as a triangle.
    fn over(piece: &[u32], flat: &[[DVec2; 3]]) -> Self {
        let (mut low, mut high, mut sum) = (DVec2::INFINITY, DVec2::NEG_INFINITY, DVec2::ZERO);
        for &t in piece {
            let (l, h) = bounds(&flat[t as usize]);
            (low, high, sum) = (low.min(l), high.max(h), sum + (h - l));
        }
        let most = (piece.len() as f64).sqrt() * 2.0 + 1.0;
        let cells = |extent: f64, mean: f64| {
            let n = if mean > 0.0 { extent / mean } else { 1.0 };
            (if n < most { n } else { most }) as usize + 1
        };
        let (extent, mean) = (high - low, sum / piece.len() as f64);
        let (width, height) = (cells(extent.x, mean.x), cells(extent.y, mean.y));
        let per = |n: usize, extent: f64| if extent > 0.0 { n as f64 / extent } else { 0.0 };
        let per_cell = DVec2::new(per(width, extent.x), per(height, extent.y));
        Self { low, per_cell, width, height, cells: vec![Vec::new(); width * height] }
    }

    /// Lays a triangle down unless it covers one that lies there.
    fn take(&mut self, t: u32, flat: &[[DVec2; 3]]) -> bool {
        let triangle = &flat[t as usize];
        let (low, high) = bounds(triangle);
        let cell = |p: DVec2| {
            let at = (p - self.low) * self.per_cell;
            [(at.x as usize).min(self.width - 1), (at.y as usize).min(self.height - 1)]
        };
        let ([x0, y0], [x1, y1]) = (cell(low), cell(high));
        let touched = (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| (x, y)));
        let width = self.width;
        if touched.clone().any(|(x, y)| self.cells[y * width + x].iter().any(|&o| overlap(triangle, &flat[o as usize])))
        {
            return false;
        }
        touched.for_each(|(x, y)| self.cells[y * width + x].push(t));
        true
    }
}

fn bounds(triangle: &[DVec2; 3]) -> (DVec2, DVec2) {
    let [a, b, c] = triangle;
    (a.min(*b).min(*c), a.max(*b).max(*c))
}

/// Whether two counter-clockwise triangles share more than an edge: no edge of either has the other all on its outside.
/// Exact at shared corners, whose differences are exactly zero.
fn overlap(a: &[DVec2; 3], b: &[DVec2; 3]) -> bool {
    let separates = |t: &[DVec2; 3], other: &[DVec2; 3]| {
        (0..3).any(|k| {
            let (from, edge) = (t[k], t[(k + 1) % 3] - t[k]);
            other.iter().all(|&p| edge.perp_dot(p - from) <= 0.0)
        })
    };
    !separates(a, b) && !separates(b, a)
}

/// Packs the charts and reads off the corners' coordinates.
fn place_charts(
    charts: &[Chart],
    flat: &[[DVec2; 3]],
    triangles: &[[u32; 3]],
    n_vertices: usize,
    edge: f64,
    gutter: f64,
) -> Layout {
    // Lying pieces pack better: turn the upright ones by a quarter.
    let upright = |chart: &Chart| chart.high.y - chart.low.y > chart.high.x - chart.low.x;
    let sizes: Vec<Vec2> = charts
        .iter()
        .map(|chart| {
            let size = (chart.high - chart.low).as_vec2();
            if upright(chart) { vec2(size.y, size.x) } else { size }
        })
        .collect();
    let packing = pack(&sizes, edge, gutter);
    let mut uv = vec![Vec2::NAN; triangles.len() * 3];
    let mut of_vertex = vec![Vec2::splat(0.5); n_vertices];
    for (chart, corner) in charts.iter().zip(&packing.corners) {
        for &t in &chart.triangles {
            for k in 0..3 {
                let p = flat[t as usize][k];
                let p = if upright(chart) {
                    DVec2::new(chart.high.y - p.y, p.x - chart.low.x)
                } else {
                    DVec2::new(p.x - chart.low.x, p.y - chart.low.y)
                };
                let texel = (*corner + p * packing.scale) / edge;
                let place = vec2(texel.x as f32, (1.0 - texel.y) as f32).clamp(Vec2::ZERO, Vec2::ONE);
                uv[t as usize * 3 + k] = place;
                of_vertex[triangles[t as usize][k] as usize] = place;
            }
        }
    }
    for (corners, t) in uv.as_chunks_mut::<3>().0.iter_mut().zip(triangles) {
        if corners[0].is_nan() {
            *corners = [of_vertex[t[0] as usize]; 3];
        }
    }
    Layout { uv, n_charts: charts.len(), gutter_texels: packing.gutter }
}
