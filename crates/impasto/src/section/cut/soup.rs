//! The mesh to be cut, borrowed: what a mesh and its raw form have in common.

use crate::assets::{Field, Mesh, Part, RawMesh, UvSet};
use crate::math::{Vec3, Vec4};

/// A valid mesh's arrays.
#[derive(Clone, Copy)]
pub struct Soup<'a> {
    pub(super) positions: &'a [Vec3],
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) normals: &'a [Vec3],
    pub(super) tangents: &'a [Vec4],
    pub(super) colors: &'a [Vec4],
    pub(super) uv_sets: &'a [UvSet],
    pub(super) fields: &'a [Field],
    pub(super) parts: &'a [Part],
    pub(super) source_points: &'a [u32],
    pub(super) source_faces: &'a [u32],
    pub(super) n_source_points: usize,
    pub(super) n_source_faces: usize,
}

impl<'a> From<&'a Mesh> for Soup<'a> {
    fn from(mesh: &'a Mesh) -> Self {
        Self {
            positions: mesh.positions(),
            triangles: mesh.triangles(),
            normals: mesh.normals(),
            tangents: mesh.tangents(),
            colors: mesh.colors(),
            uv_sets: mesh.uv_sets(),
            fields: mesh.fields(),
            parts: mesh.parts(),
            source_points: mesh.source_points(),
            source_faces: mesh.source_faces(),
            n_source_points: mesh.n_source_points(),
            n_source_faces: mesh.n_source_faces(),
        }
    }
}

/// A half that was made by a cut, for the next cut.
impl<'a> From<&'a RawMesh> for Soup<'a> {
    fn from(raw: &'a RawMesh) -> Self {
        Self {
            positions: &raw.positions,
            triangles: &raw.triangles,
            normals: &raw.normals,
            tangents: &raw.tangents,
            colors: &raw.colors,
            uv_sets: &raw.uv_sets,
            fields: &raw.fields,
            parts: &raw.parts,
            source_points: &raw.source_points,
            source_faces: &raw.source_faces,
            n_source_points: raw.n_source_points.max(raw.positions.len()),
            n_source_faces: raw.n_source_faces.max(raw.triangles.len()),
        }
    }
}

impl Soup<'_> {
    /// The volume that the triangles enclose, as far as they do; model units cubed.
    pub fn volume(&self) -> f64 {
        volume(self.positions, self.triangles)
    }
}

/// The signed volume inside triangles, seen from the first corner so that places far from the origin lose nothing.
pub fn volume(positions: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let Some(first) = triangles.first() else { return 0.0 };
    let origin = positions[first[0] as usize].as_dvec3();
    let six: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| positions[v as usize].as_dvec3() - origin);
            a.dot(b.cross(c))
        })
        .sum();
    six / 6.0
}
