//! All edges of a triangle mesh, each with the triangles that meet there. Vertices at one place count as one.

use crate::assets::weld::Weld;

/// One side of a triangle, as an edge sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct HalfEdge {
    /// The edge's other end: the one with the greater index.
    pub(super) other: u32,
    /// Three times the triangle plus the corner at which the side starts.
    pub(super) corner: u32,
    /// Whether the side goes from the edge's lesser to its greater index.
    pub(super) forward: bool,
}

impl HalfEdge {
    /// Index of its triangle.
    pub(super) fn triangle(self) -> usize {
        self.corner as usize / 3
    }
}

/// The sides of all triangles in buckets by the lesser end of their edge.
pub(super) struct Edges {
    /// Where each vertex' bucket starts; one more entry than vertices.
    start: Vec<u32>,
    /// `HalfEdge::corner`.
    corners: Vec<u32>,
}

impl Edges {
    /// Counting sort of all sides. Sides of no length are left out. Takes 4 bytes a vertex and 12 a triangle.
    pub(super) fn of(n_vertices: usize, triangles: &[[u32; 3]], weld: &Weld) -> Self {
        let mut start = vec![0u32; n_vertices + 1];
        each_side(triangles, weld, |a, b, _| start[a.min(b) as usize] += 1);
        // Buckets are filled from their ends, so that afterwards each entry is where its bucket starts.
        let mut sum = 0;
        for s in &mut start {
            sum += *s;
            *s = sum;
        }
        let mut corners = vec![0u32; sum as usize];
        each_side(triangles, weld, |a, b, corner| {
            let s = &mut start[a.min(b) as usize];
            *s -= 1;
            corners[*s as usize] = corner;
        });
        Self { start, corners }
    }

    /// Calls `visit` with all sides of each edge, in order of the edges' ends; sides in order of their corners.
    pub(super) fn for_each(&self, triangles: &[[u32; 3]], weld: &Weld, mut visit: impl FnMut(u32, &[HalfEdge])) {
        let mut bucket: Vec<HalfEdge> = Vec::new();
        for (vertex, ends) in self.start.windows(2).enumerate() {
            bucket.clear();
            // Filled from the end, a bucket holds its corners in falling order.
            bucket.extend(self.corners[ends[0] as usize..ends[1] as usize].iter().rev().map(|&corner| {
                let [t, k] = [corner as usize / 3, corner as usize % 3];
                let (from, to) = (weld.at(triangles[t][k]), weld.at(triangles[t][(k + 1) % 3]));
                HalfEdge { other: from.max(to), corner, forward: from == vertex as u32 }
            }));
            sort_by_other(&mut bucket);
            let mut rest = &bucket[..];
            while let Some(first) = rest.first() {
                let n = rest.iter().take_while(|h| h.other == first.other).count();
                visit(vertex as u32, &rest[..n]);
                rest = &rest[n..];
            }
        }
    }
}

#[inline(always)]
fn each_side(triangles: &[[u32; 3]], weld: &Weld, mut side: impl FnMut(u32, u32, u32)) {
    for (t, &triangle) in triangles.iter().enumerate() {
        let [a, b, c] = weld.corners(triangle);
        let corner = 3 * t as u32;
        for (from, to, k) in [(a, b, 0), (b, c, 1), (c, a, 2)] {
            if from != to {
                side(from, to, corner + k);
            }
        }
    }
}

/// Stable; by insertion for the handful of sides that most vertices have.
fn sort_by_other(bucket: &mut [HalfEdge]) {
    if bucket.len() > 24 {
        return bucket.sort_by_key(|h| h.other);
    }
    for i in 1..bucket.len() {
        let h = bucket[i];
        let mut j = i;
        while j > 0 && bucket[j - 1].other > h.other {
            bucket[j] = bucket[j - 1];
            j -= 1;
        }
        bucket[j] = h;
    }
}
