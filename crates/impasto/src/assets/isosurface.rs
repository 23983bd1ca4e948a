//! The surface on which a grid has one value.
//!
//! Marching cubes (Lorensen and Cline, "Marching Cubes: A High Resolution 3D Surface Construction Algorithm", 1987)
//! without its table: on each face of a cell the crossed edges are joined by segments, and the segments of a cell close
//! to loops. Faces of four crossings are decided by the bilinear saddle (Nielson and Hamann, "The Asymptotic Decider",
//! 1991), from the face's own four values, so both of its cells agree and the surface has no holes. Each crossed edge
//! gives one vertex; loops of five and more edges get one in their middle, so that no triangle lies in a cell's face.

use crate::assets::grid::Grid;
use crate::assets::mesh::{Mesh, RawMesh};
use crate::assets::normals;
use crate::math::{DVec3, Vec3, unit_or};

/// On which side of an isosurface the solid lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// Values at the level and above it are inside.
    #[default]
    Above,
    /// Values at the level and below it are inside.
    Below,
}

/// Which isosurface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The value on the surface, in the grid's unit.
    pub level: f64,
    /// What is inside; the front faces the other side.
    pub side: Side,
    /// Whether the solid is closed by flat caps where it meets the grid's border. Beside missing values it stays open.
    pub closed: bool,
}

/// The isosurface of a grid: vertices shared, normals along the gradient. Two runs of caps and surface meet in vertices at
/// equal places, so that the rim is sharp.
///
/// Deterministic; linear in the number of points. Cells with a missing corner have no surface.
pub fn of(grid: &Grid, options: &Options) -> Mesh {
    let mut work = Work {
        grid,
        level: options.level,
        sign: if options.side == Side::Above { 1.0 } else { -1.0 },
        is_left_handed: grid.lattice().cell_volume() < 0.0,
        mesh: RawMesh::default(),
    };
    work.march();
    if options.closed {
        for face in 0..6 {
            work.cap(face);
        }
    }
    work.finish()
}

/// Vertices keep this share of an edge away from its ends, so that they never coincide at a point that has the level's
/// value. Trades as much of a step in accuracy there.
const MARGIN: f64 = 1.0 / 128.0;

/// No vertex yet.
const FREE: u32 = u32::MAX;

/// The corners of a cell's faces, counter-clockwise from outside. Bit 0 of a corner is x, bit 1 y, bit 2 z; faces 0, 2, 4
/// lie at the low ends of x, y, z, the next ones at the high ends.
const FACES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

struct Work<'a> {
    grid: &'a Grid,
    level: f64,
    sign: f64,
    is_left_handed: bool,
    mesh: RawMesh,
}

/// Vertices on the edges of one slab of cells, by the edge's lower point: along x and y in the lower and upper layer of
/// points, along z between them.
struct Slab {
    row: usize,
    x: [Vec<u32>; 2],
    y: [Vec<u32>; 2],
    z: Vec<u32>,
}

impl Slab {
    /// The vertex of an edge of the cell at (i, j), given its two corners.
    fn slot(&mut self, [i, j]: [usize; 2], a: usize, b: usize) -> &mut u32 {
        let low = a.min(b);
        let at = (j + (low >> 1 & 1)) * self.row + i + (low & 1);
        match a ^ b {
            1 => &mut self.x[low >> 2][at],
            2 => &mut self.y[low >> 2][at],
            _ => &mut self.z[at],
        }
    }

    /// The upper layer becomes the lower.
    fn rise(&mut self) {
        self.x.swap(0, 1);
        self.y.swap(0, 1);
        for free in [&mut self.x[1], &mut self.y[1], &mut self.z] {
            free.fill(FREE);
        }
    }
}

/// The corner of a cell as an offset.
fn corner_offset(corner: usize) -> [usize; 3] {
    [corner & 1, corner >> 1 & 1, corner >> 2 & 1]
}

fn corner_of([i, j, k]: [usize; 3], corner: usize) -> [usize; 3] {
    let [x, y, z] = corner_offset(corner);
    [i + x, j + y, k + z]
}

impl Work<'_> {
    /// How far inside a point is; inside from 0 on, NaN where there is no value.
    fn depth(&self, [i, j, k]: [usize; 3]) -> f64 {
        (self.grid.at(i, j, k) as f64 - self.level) * self.sign
    }

    /// The surface within the grid.
    fn march(&mut self) {
        let [nx, ny, nz] = self.grid.size().map(|n| n as usize);
        if nx < 2 || ny < 2 || nz < 2 {
            return;
        }
        let free = || vec![FREE; nx * ny];
        let mut slab = Slab { row: nx, x: [free(), free()], y: [free(), free()], z: free() };
        for k in 0..nz - 1 {
            for j in 0..ny - 1 {
                for i in 0..nx - 1 {
                    self.cell([i, j, k], &mut slab);
                }
            }
            slab.rise();
        }
    }

    /// The surface within a cell.
    fn cell(&mut self, cell: [usize; 3], slab: &mut Slab) {
        let mut depth = [0.0; 8];
        let (mut n_inside, mut is_missing) = (0, false);
        for (c, d) in depth.iter_mut().enumerate() {
            *d = self.depth(corner_of(cell, c));
            n_inside += (*d >= 0.0) as usize;
            is_missing |= d.is_nan();
        }
        if n_inside == 0 || n_inside == 8 || is_missing {
            return;
        }
        // From each crossed edge to the next: each edge is entered on one face and left on the other.
        let mut next: [Option<[usize; 2]>; 64] = [None; 64];
        for corners in &FACES {
            for [from, to] in segments(corners.map(|c| depth[c])).into_iter().flatten() {
                let edge = |e: usize| [corners[e], corners[(e + 1) % 4]];
                next[edge_key(edge(from))] = Some(edge(to));
            }
        }
        let mut corners = [0; 12];
        for start in 0..64 {
            let (mut at, mut n) = (start, 0);
            while let Some(edge) = next[at].take() {
                corners[n] = self.edge_vertex(cell, edge, slab);
                n += 1;
                at = edge_key(edge);
            }
            if n >= 3 {
                self.polygon(&corners[..n]);
            }
        }
    }

    /// The vertex on an edge of a cell.
    fn edge_vertex(&mut self, cell: [usize; 3], [a, b]: [usize; 2], slab: &mut Slab) -> u32 {
        let slot = slab.slot([cell[0], cell[1]], a, b);
        if *slot == FREE {
            *slot = self.mesh.positions.len() as u32;
            let (low, high) = (corner_of(cell, a.min(b)), corner_of(cell, a.max(b)));
            let (t, place) = self.crossing(low, high);
            let slope = [0, 1, 2].map(|axis| {
                let [d, e] = [low, high].map(|p| self.grid.difference(p, axis));
                d + (e - d) * t as f32
            });
            let normal = self.outward(self.grid.world_slope(slope));
            self.push(place, normal);
            return self.mesh.positions.len() as u32 - 1;
        }
        *slot
    }

    /// Where between two neighbouring points the level is: as a share of the way, and as a place. The same bits whenever
    /// it is asked.
    fn crossing(&self, low: [usize; 3], high: [usize; 3]) -> (f64, DVec3) {
        let (d, e) = (self.depth(low), self.depth(high));
        let t = (d / (d - e)).clamp(MARGIN, 1.0 - MARGIN);
        let [p, q] = [low, high].map(|p| DVec3::from(p.map(|i| i as f64)));
        (t, self.grid.lattice().place(p + (q - p) * t))
    }

    /// From inside to outside, given the gradient; zero where there is none.
    fn outward(&self, gradient: Vec3) -> Vec3 {
        let down = gradient.as_dvec3() * -self.sign;
        down.normalize_or_zero().as_vec3()
    }

    fn push(&mut self, place: DVec3, normal: Vec3) {
        self.mesh.positions.push(place.as_vec3());
        self.mesh.normals.push(normal);
    }

    /// Adds a loop of vertices, counter-clockwise in a right-handed grid.
    fn polygon(&mut self, corners: &[u32]) {
        let p = |i: usize| self.mesh.positions[corners[i] as usize];
        match *corners {
            [a, b, c] => self.triangle([a, b, c]),
            [a, b, c, d] => {
                if p(0).distance_squared(p(2)) <= p(1).distance_squared(p(3)) {
                    self.triangle([a, b, c]);
                    self.triangle([a, c, d]);
                } else {
                    self.triangle([a, b, d]);
                    self.triangle([b, c, d]);
                }
            }
            _ => {
                let n = corners.len();
                let middle = (0..n).map(|i| p(i).as_dvec3()).sum::<DVec3>() / n as f64;
                let around = corners.iter().map(|c| self.mesh.normals[*c as usize]).sum::<Vec3>();
                let normal = self.outward(self.grid.gradient(middle.as_vec3()));
                let center = self.mesh.positions.len() as u32;
                self.push(middle, if normal.dot(around) > 0.0 { normal } else { unit_or(around, Vec3::ZERO) });
                for i in 0..n {
                    self.triangle([center, corners[i], corners[(i + 1) % n]]);
                }
            }
        }
    }

    fn triangle(&mut self, [a, b, c]: [u32; 3]) {
        self.mesh.triangles.push(if self.is_left_handed { [a, c, b] } else { [a, b, c] });
    }

    /// The part of the grid's border that is inside.
    fn cap(&mut self, face: usize) {
        let size = self.grid.size().map(|n| n as usize);
        if size.iter().any(|n| *n < 2) {
            return;
        }
        let axis = face / 2;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let is_low = face & 1 == 0;
        let cell_layer = if is_low { 0 } else { size[axis] - 2 };
        let mut slots = vec![FREE; size[u] * size[v] * 3];
        let out = self.grid.world_slope([0, 1, 2].map(|a| if a == axis { 1.0 } else { 0.0 }));
        let normal = unit_or(if is_low { -out } else { out }, Vec3::Y);
        let mut polygon = Vec::new();
        for j in 0..size[v] - 1 {
            for i in 0..size[u] - 1 {
                let mut cell = [0; 3];
                (cell[axis], cell[u], cell[v]) = (cell_layer, i, j);
                let points = FACES[face].map(|c| corner_of(cell, c));
                let depth = points.map(|p| self.depth(p));
                if depth.iter().any(|d| d.is_nan()) || depth.iter().all(|d| *d < 0.0) {
                    continue;
                }
                let is_inside = depth.map(|d| d >= 0.0);
                // Two corners that are not joined have a triangle each; all else is one polygon.
                let is_apart = matches!(segments(depth), [Some([from, to]), Some(_)] if (from + 1) % 4 == to);
                for corner in 0..4 {
                    let next = (corner + 1) % 4;
                    if is_inside[corner] {
                        polygon.push(self.cap_vertex([points[corner], points[corner]], normal, &mut slots, [u, v]));
                    }
                    if is_inside[corner] != is_inside[next] {
                        polygon.push(self.cap_vertex([points[corner], points[next]], normal, &mut slots, [u, v]));
                    }
                }
                if is_apart {
                    // Corners and crossings alternate: crossing, corner, crossing for each of the two.
                    let n = polygon.len();
                    let first = if is_inside[0] { n - 1 } else { 0 };
                    for s in [first, first + 3] {
                        self.triangle([0, 1, 2].map(|i| polygon[(s + i) % n]));
                    }
                } else {
                    for i in 2..polygon.len() {
                        self.triangle([polygon[0], polygon[i - 1], polygon[i]]);
                    }
                }
                polygon.clear();
            }
        }
    }

    /// A vertex of a cap: at a point (given twice), or on the edge between two.
    fn cap_vertex(&mut self, ends: [[usize; 3]; 2], normal: Vec3, slots: &mut [u32], [u, v]: [usize; 2]) -> u32 {
        let [low, high] = if ends[0] <= ends[1] { ends } else { [ends[1], ends[0]] };
        let kind = if low == high { 0 } else { 1 + (low[v] != high[v]) as usize };
        let row = self.grid.size()[u] as usize;
        let slot = &mut slots[(low[v] * row + low[u]) * 3 + kind];
        if *slot == FREE {
            *slot = self.mesh.positions.len() as u32;
            let place = match kind {
                0 => self.grid.lattice().place(DVec3::from(low.map(|i| i as f64))),
                _ => self.crossing(low, high).1,
            };
            self.mesh.positions.push(place.as_vec3());
            self.mesh.normals.push(normal);
        }
        *slot
    }

    /// The mesh; triangles that rounding left without area are dropped, normals that the gradient left open made.
    fn finish(self) -> Mesh {
        let mut mesh = self.mesh;
        let p = std::mem::take(&mut mesh.positions);
        mesh.triangles.retain(|t| {
            let [a, b, c] = t.map(|v| p[v as usize].as_dvec3());
            (b - a).cross(c - a) != DVec3::ZERO
        });
        mesh.positions = p;
        if mesh.normals.contains(&Vec3::ZERO) {
            let smooth = normals::smooth(&mesh.positions, &mesh.triangles);
            for (n, s) in mesh.normals.iter_mut().zip(smooth).filter(|(n, _)| **n == Vec3::ZERO) {
                *n = unit_or(s, Vec3::Y);
            }
        }
        mesh.trusted()
    }
}

/// An edge of a cell, given its two corners, as a number below 64.
fn edge_key([a, b]: [usize; 2]) -> usize {
    a.min(b) * 8 + a.max(b)
}

/// How the surface crosses a face, given how far inside its corners are, counter-clockwise: up to two segments from edge to
/// edge (edge i runs from corner i to the next), the inside on their right.
fn segments(depth: [f64; 4]) -> [Option<[usize; 2]>; 2] {
    let is_inside = depth.map(|d| d >= 0.0);
    // An edge is entered where it leads inside, left where it leads outside.
    let enters = |e: usize| !is_inside[e] && is_inside[(e + 1) % 4];
    let leaves = |e: usize| is_inside[e] && !is_inside[(e + 1) % 4];
    match (0..4).filter(|e| enters(*e)).count() {
        1 => [(0..4).find(|e| enters(*e)).zip((0..4).find(|e| leaves(*e))).map(|(a, b)| [a, b]), None],
        2 => {
            let first = if is_inside[0] { 0 } else { 1 };
            let inside = depth[first] * depth[first + 2];
            let outside = depth[first + 1] * depth[(first + 3) % 4];
            // Around each inside corner, or, when these are joined through the middle, around each outside corner.
            let around = if inside >= outside { [first + 1, (first + 3) % 4] } else { [first, first + 2] };
            around.map(|corner| {
                let (before, after) = ((corner + 3) % 4, corner);
                Some(if enters(before) { [before, after] } else { [after, before] })
            })
        }
        _ => [None, None],
    }
}

#[cfg(test)]
#[path = "isosurface_tests.rs"]
mod tests;
