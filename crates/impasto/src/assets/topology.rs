//! Questions about a mesh's shape as a surface: is it closed, in how many pieces, with how many handles?
//!
//! Vertices at one place count as one, so that a seam of texture coordinates or a crease of normals is no border.

use crate::assets::Mesh;
use crate::assets::edges::Edges;
use crate::assets::pieces::Pieces;
use crate::assets::weld::Weld;
use crate::math::Vec3;

/// Counts that tell what kind of surface a mesh is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topology {
    /// Places at which triangles have corners.
    pub n_places: usize,
    /// Edges between them.
    pub n_edges: usize,
    /// Triangles.
    pub n_triangles: usize,
    /// Edges of one triangle only.
    pub n_border_edges: usize,
    /// Edges at which more than two triangles meet.
    pub n_non_manifold_edges: usize,
    /// Edges whose two triangles are wound against each other.
    pub n_inconsistent_edges: usize,
    /// Pieces that hang together, at a corner at least.
    pub n_pieces: usize,
}

impl Topology {
    /// Of a valid mesh. Linear in time; takes about 20 bytes a triangle while it counts.
    pub fn of(mesh: &Mesh) -> Self {
        Self::of_triangles(mesh.positions(), mesh.triangles())
    }

    /// Of finite positions and triangles whose corners are in range.
    pub fn of_triangles(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let weld = Weld::of(positions);
        let edges = Edges::of(positions.len(), triangles, &weld);
        let mut pieces = Pieces::new(triangles.len());
        let mut topology = Self {
            n_places: 0,
            n_edges: 0,
            n_triangles: triangles.len(),
            n_border_edges: 0,
            n_non_manifold_edges: 0,
            n_inconsistent_edges: 0,
            n_pieces: 0,
        };
        edges.for_each(triangles, &weld, |_, sides| {
            topology.n_edges += 1;
            match sides {
                [_] => topology.n_border_edges += 1,
                [a, b] => topology.n_inconsistent_edges += (a.forward == b.forward) as usize,
                _ => topology.n_non_manifold_edges += 1,
            }
        });
        let mut first_at = vec![u32::MAX; positions.len()];
        for (t, corners) in triangles.iter().enumerate() {
            for place in weld.corners(*corners) {
                match &mut first_at[place as usize] {
                    free @ &mut u32::MAX => *free = t as u32,
                    first => _ = pieces.join(*first as usize, t, false),
                }
            }
        }
        topology.n_places = first_at.iter().filter(|f| **f != u32::MAX).count();
        topology.n_pieces = pieces.numbered().n;
        topology
    }

    /// Whether every edge has exactly two triangles: the surface bounds a solid (or several).
    pub fn is_closed(&self) -> bool {
        self.n_triangles > 0 && self.n_border_edges == 0 && self.n_non_manifold_edges == 0
    }

    /// Whether a solid's inside is well told from its outside: closed, and wound one way.
    pub fn is_solid(&self) -> bool {
        self.is_closed() && self.n_inconsistent_edges == 0
    }

    /// Places - edges + triangles: 2 for a sphere, 0 for a torus.
    pub fn euler(&self) -> i64 {
        self.n_places as i64 - self.n_edges as i64 + self.n_triangles as i64
    }

    /// The number of handles, all pieces together; none unless the mesh is closed.
    pub fn genus(&self) -> Option<i64> {
        self.is_closed().then(|| self.n_pieces as i64 - self.euler() / 2)
    }
}
