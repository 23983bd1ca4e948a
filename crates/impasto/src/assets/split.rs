//! Corners that share a point but not its attributes: the point is split.

use crate::assets::weld::{Seen, hash3};
use crate::assets::{RawMesh, UvSet};
use crate::math::Vec2;

/// Texture coordinates of each triangle's corners.
pub(super) struct CornerUv {
    /// Three a triangle.
    pub(super) uv: Vec<Vec2>,
}

/// Numbers the different combinations of a point and its attributes.
///
/// The first combination of a point keeps the point's index, so that meshes without seams keep their order and points
/// that no face uses stay; others follow after all points, in the order of their first use.
pub(super) struct Splitter {
    /// For each point, its first combination's attributes.
    first: Vec<Option<[u32; 2]>>,
    /// Point and attributes of the other combinations.
    others: Vec<[u32; 3]>,
    seen: Seen,
}

impl Splitter {
    /// For this many points.
    pub(super) fn new(n_points: usize) -> Self {
        Self { first: vec![None; n_points], others: Vec::new(), seen: Seen::with_capacity(0) }
    }

    /// The vertex for a point with two attributes. The point must be in range.
    #[inline]
    pub(super) fn vertex(&mut self, point: u32, attributes: [u32; 2]) -> u32 {
        match &mut self.first[point as usize] {
            Some(first) if *first == attributes => return point,
            Some(_) => {}
            free => {
                *free = Some(attributes);
                return point;
            }
        }
        let key = [point, attributes[0], attributes[1]];
        let (others, new) = (&self.others, self.others.len() as u32);
        let hash = |[a, b, c]: [u32; 3]| hash3(a, b, c);
        let found =
            self.seen.find_or_insert(hash(key), new, |i| others[i as usize] == key, |i| hash(others[i as usize]));
        let i = found.unwrap_or_else(|| {
            self.others.push(key);
            new
        });
        self.first.len() as u32 + i
    }

    /// For each added vertex: the point it was split from.
    pub(super) fn copies(&self) -> Vec<u32> {
        self.others.iter().map(|o| o[0]).collect()
    }

    /// The attributes of all vertices, in order; none for points that no face uses.
    pub(super) fn attributes(&self) -> impl Iterator<Item = Option<[u32; 2]>> {
        self.first.iter().copied().chain(self.others.iter().map(|o| Some([o[1], o[2]])))
    }
}

/// Makes a UV set of corner data, splitting vertices where corners disagree. Leaves corners out of range alone.
pub(super) fn split_by_corner_uv(mesh: &mut RawMesh, corners: &CornerUv) {
    let mut splitter = Splitter::new(mesh.positions.len());
    for (t, uv) in mesh.triangles.iter_mut().zip(corners.uv.chunks_exact(3)) {
        for (v, uv) in t.iter_mut().zip(uv).filter(|(v, _)| (**v as usize) < mesh.positions.len()) {
            *v = splitter.vertex(*v, uv.to_array().map(|x| (x + 0.0).to_bits()));
        }
    }
    mesh.copy_vertices(&splitter.copies());
    let uv = splitter.attributes().map(|a| a.map_or(Vec2::ZERO, |bits| Vec2::from_array(bits.map(f32::from_bits))));
    mesh.uv_sets.insert(0, UvSet { name: "uv0".into(), uv: uv.collect() });
}
