//! What tests ask of a mesh: closed, of which genus, how large.

use crate::assets::Mesh;
use std::collections::BTreeMap;

/// What is true of a surface once vertices at equal places are taken as one.
#[derive(Debug, PartialEq)]
pub(super) struct Solid {
    /// Each edge belongs to exactly two triangles that run through it in opposite directions.
    pub(super) is_closed: bool,
    /// Vertices - edges + triangles: 2 for a sphere, 0 for a ring.
    pub(super) euler: i64,
    /// Enclosed, model units cubed.
    pub(super) volume: f64,
    /// Triangles whose vertex normals all point to their front.
    pub(super) share_of_right_normals: f64,
}

/// Measures a mesh, or the triangles of it that `of` picks.
pub(super) fn measure(mesh: &Mesh) -> Solid {
    let mut ids = BTreeMap::new();
    let mut id = |i: u32| {
        let p = mesh.positions()[i as usize];
        // Adding zero makes -0 and 0 one.
        let n = ids.len();
        *ids.entry([p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f32::to_bits)).or_insert(n)
    };
    let mut edges: BTreeMap<(usize, usize), i64> = BTreeMap::new();
    let (mut volume, mut n_right) = (0.0, 0);
    for t in mesh.triangles() {
        let w = t.map(&mut id);
        for k in 0..3 {
            *edges.entry((w[k], w[(k + 1) % 3])).or_default() += 1;
        }
        let [a, b, c] = t.map(|i| mesh.positions()[i as usize].as_dvec3());
        volume += a.dot(b.cross(c)) / 6.0;
        let front = (b - a).cross(c - a);
        n_right += t.iter().all(|&i| mesh.normals()[i as usize].as_dvec3().dot(front) > 0.0) as usize;
    }
    let is_closed = edges.iter().all(|(&(a, b), &n)| n == 1 && edges.contains_key(&(b, a)));
    let n_edges = edges.keys().filter(|(a, b)| a < b || !edges.contains_key(&(*b, *a))).count();
    Solid {
        is_closed,
        euler: ids.len() as i64 - n_edges as i64 + mesh.triangles().len() as i64,
        volume,
        share_of_right_normals: n_right as f64 / mesh.triangles().len() as f64,
    }
}
