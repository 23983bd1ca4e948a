//! How deep below a model's skin is a point?
//!
//! Distance to the nearest triangle by a tree of boxes, each halved along its longest side. Layers of a filling and maps
//! of a cap ask it.

use super::Soup;
use crate::math::{DVec3, Vec3};

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
        assert!(Skin::of(&crate::assets::Mesh::default()).distance(DVec3::ZERO).is_infinite());
    }
}
