//! How deep below a model's skin is a point?
//!
//! Distance to the nearest triangle by a tree of boxes, each halved along its longest side. Layers of a filling and maps
//! of a cap ask it.

use super::Soup;
use crate::math::{DVec3, Vec3, exact};
use crate::par::Workers;
use crate::section::Plane;
use crate::section::grain::Window;

/// A surface that can be asked for distances.
#[derive(Clone, Debug)]
pub struct Skin {
    /// Boxes: the children of box `i` are `i + 1` and `boxes[i].right`; leaves hold triangles.
    boxes: Vec<Box3>,
    /// In the order of the leaves.
    triangles: Vec<[Vec3; 3]>,
}

#[derive(Clone, Copy, Debug)]
struct Box3 {
    min: Vec3,
    max: Vec3,
    /// Of an inner box its right child; of a leaf the end of its triangles.
    right: u32,
    /// Of a leaf its first triangle.
    first: u32,
    is_leaf: bool,
}

/// Triangles in a leaf at most.
const LEAF: usize = 4;

impl Skin {
    /// Of a valid mesh; takes about 60 bytes a triangle.
    pub fn of<'a>(mesh: impl Into<Soup<'a>>) -> Self {
        let soup = mesh.into();
        let mut triangles: Vec<[Vec3; 3]> =
            soup.triangles.iter().map(|t| t.map(|v| soup.positions[v as usize])).collect();
        let mut skin = Self { boxes: Vec::new(), triangles: Vec::new() };
        if !triangles.is_empty() {
            let n = triangles.len();
            skin.build(&mut triangles, 0, n);
        }
        skin.triangles = triangles;
        skin
    }

    fn build(&mut self, triangles: &mut [[Vec3; 3]], first: usize, end: usize) {
        let part = &mut triangles[first..end];
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        part.iter().flatten().for_each(|&p| (min, max) = (min.min(p), max.max(p)));
        let at = self.boxes.len();
        let is_leaf = part.len() <= LEAF;
        self.boxes.push(Box3 { min, max, right: end as u32, first: first as u32, is_leaf });
        if is_leaf {
            return;
        }
        let size = max - min;
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let middle = part.len() / 2;
        let key = |t: &[Vec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
        part.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
        self.build(triangles, first, first + middle);
        self.boxes[at].right = self.boxes.len() as u32;
        self.build(triangles, first + middle, end);
    }

    /// Distance from a point to the surface, model units; infinite if there is none.
    pub fn distance(&self, p: DVec3) -> f64 {
        let mut least = f64::INFINITY;
        let mut todo = vec![];
        if !self.boxes.is_empty() {
            todo.push(0usize);
        }
        while let Some(i) = todo.pop() {
            let b = self.boxes[i];
            if b.distance_squared(p) >= least {
                continue;
            }
            if b.is_leaf {
                for t in &self.triangles[b.first as usize..b.right as usize] {
                    least = least.min(to_triangle(t.map(|v| v.as_dvec3()), p));
                }
                continue;
            }
            // The nearer child is taken first.
            let (left, right) = (i + 1, b.right as usize);
            let near = self.boxes[left].distance_squared(p) <= self.boxes[right].distance_squared(p);
            todo.extend(if near { [right, left] } else { [left, right] });
        }
        least.sqrt()
    }
}

/// Depths near a plane, sampled once: between samples they are mixed linearly.
#[derive(Clone, Debug)]
pub struct Depths {
    /// Where the first sample lies, and the axes of the grid, unit vectors.
    origin: DVec3,
    axes: [DVec3; 3],
    pitch: f64,
    /// Samples along each axis.
    n: [usize; 3],
    values: Vec<f32>,
}

impl Skin {
    /// Depths of a part of a plane and of what lies up to `reach` off it, model units, sampled `pitch` apart.
    pub fn near_plane(&self, plane: &Plane, window: &Window, reach: f64, pitch: f64, workers: &Workers) -> Depths {
        let axes = [window.axes[0], window.axes[1], plane.normal];
        let (min, max) = (window.min.as_dvec2() - reach, window.max.as_dvec2() + reach);
        // At most a million samples, coarser if need be.
        const MOST: f64 = 1e6;
        let room = (max.x - min.x) * (max.y - min.y) * 2.0 * reach;
        let pitch = pitch.max(exact::pow((room / MOST).max(0.0), 1.0 / 3.0));
        let n = [max.x - min.x, max.y - min.y, 2.0 * reach].map(|length| (length / pitch).ceil().max(1.0) as usize + 1);
        let origin = window.origin + axes[0] * min.x + axes[1] * min.y - axes[2] * reach;
        let at = |i: usize| {
            let [x, y, z] = [i % n[0], i / n[0] % n[1], i / n[0] / n[1]].map(|k| k as f64 * pitch);
            origin + axes[0] * x + axes[1] * y + axes[2] * z
        };
        let rows = workers
            .map(n[1] * n[2], |row| (0..n[0]).map(|x| self.distance(at(row * n[0] + x)) as f32).collect::<Vec<_>>());
        Depths { origin, axes, pitch, n, values: rows.concat() }
    }
}

impl Depths {
    /// The depth of a point, model units; none outside of what was sampled.
    pub fn at(&self, p: DVec3) -> Option<f32> {
        let from = (p - self.origin) / self.pitch;
        let mut cell = [0; 3];
        let mut share = [0.0f32; 3];
        for k in 0..3 {
            let x = from.dot(self.axes[k]);
            if !(x >= 0.0 && x <= (self.n[k] - 1) as f64) {
                return None;
            }
            cell[k] = (x as usize).min(self.n[k] - 2);
            share[k] = (x - cell[k] as f64) as f32;
        }
        let value = |i: usize, j: usize, k: usize| {
            self.values[((cell[2] + k) * self.n[1] + cell[1] + j) * self.n[0] + cell[0] + i]
        };
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let along = |j, k| mix(value(0, j, k), value(1, j, k), share[0]);
        let across = |k| mix(along(0, k), along(1, k), share[1]);
        Some(mix(across(0), across(1), share[2]))
    }
}

impl Box3 {
    fn distance_squared(&self, p: DVec3) -> f64 {
        (p - p.clamp(self.min.as_dvec3(), self.max.as_dvec3())).length_squared()
    }
}

/// Squared distance to a triangle: to its inside if the foot is there, else to its edges.
fn to_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    let normal = (b - a).cross(c - a);
    let squared = normal.length_squared();
    let inside = |u: DVec3, v: DVec3| (v - u).cross(p - u).dot(normal) >= 0.0;
    if squared > 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
        let height = (p - a).dot(normal);
        return height * height / squared;
    }
    let edge = |u: DVec3, v: DVec3| {
        let squared = (v - u).length_squared();
        let t = if squared > 0.0 { ((p - u).dot(v - u) / squared).clamp(0.0, 1.0) } else { 0.0 };
        (p - u - (v - u) * t).length_squared()
    };
    edge(a, b).min(edge(b, c)).min(edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{hash_cell, unit_float};

    #[test]
    fn the_tree_finds_what_a_slow_search_finds() {
        let mesh = crate::samples::scene("knot", 12, 0).unwrap().mesh;
        let skin = Skin::of(&mesh);
        let p = mesh.positions();
        for i in 0..200 {
            let r = |k| unit_float(hash_cell(i, k, 0, 2)) as f64 * 4.0 - 2.0;
            let q = DVec3::new(r(0), r(1), r(2));
            let all = mesh.triangles().iter().map(|t| to_triangle(t.map(|v| p[v as usize].as_dvec3()), q));
            let slow = all.fold(f64::INFINITY, f64::min).sqrt();
            assert_eq!(skin.distance(q), slow);
        }
        let plane = Plane::through(crate::math::vec3(0.1, 0.2, 0.0), crate::math::vec3(1.0, 2.0, 3.0)).unwrap();
        let window = Window::around(&plane, DVec3::ZERO, crate::math::vec2(1.0, 1.0));
        let depths = skin.near_plane(&plane, &window, 0.2, 0.05, &Workers::new(2));
        for i in 0..200 {
            let r = |k| unit_float(hash_cell(i, k, 1, 2)) as f64 * 2.0 - 1.0;
            let p = window.origin + window.axes[0] * r(0) + window.axes[1] * r(1) + plane.normal * (0.2 * r(2));
            // Distances change no faster than the way.
            assert!((depths.at(p).unwrap() as f64 - skin.distance(p)).abs() < 0.05 * 0.87);
        }
        assert!(depths.at(DVec3::splat(9.0)).is_none());
        assert!(Skin::of(&crate::assets::Mesh::default()).distance(DVec3::ZERO).is_infinite());
    }
}
