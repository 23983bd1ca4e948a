//! Triangle meshes, valid by construction.
//!
//! Readers fill a [`RawMesh`] with whatever the file says; [`RawMesh::mend`] turns it into a [`Mesh`] that every later
//! stage can trust: indices in range, all positions finite, attribute lengths agree, normals are there.

use crate::assets::{Element, Field};
use crate::math::{Bounds, Vec2, Vec3, Vec4};
use std::ops::Range;

/// One layout of the surface in the texture plane.
#[derive(Clone, Debug, PartialEq)]
pub struct UvSet {
    /// As the file names it, or `uv0`, `uv1` ...
    pub name: String,
    /// One a vertex; v down (the first row of the image is at v = 0).
    pub uv: Vec<Vec2>,
}

/// A run of triangles with one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// As the file names it.
    pub name: String,
    /// Which of the mesh's triangles.
    pub triangles: Range<u32>,
    /// Index into the scene's materials; none gets the default.
    pub material: Option<u32>,
}

/// A mesh as a file describes it, possibly broken. All attribute vectors are empty or one entry a vertex.
#[derive(Clone, Debug, Default)]
pub struct RawMesh {
    /// Model units.
    pub positions: Vec<Vec3>,
    /// Corners, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Empty, or one a vertex; any length.
    pub normals: Vec<Vec3>,
    /// xyz: along +u; w: sign of the bitangent (MikkTSpace). Empty, or one a vertex.
    pub tangents: Vec<Vec4>,
    /// Linear colour and alpha. Empty, or one a vertex.
    pub colors: Vec<Vec4>,
    /// Any number of layouts.
    pub uv_sets: Vec<UvSet>,
    /// Data.
    pub fields: Vec<Field>,
    /// Runs that cover all triangles in order; empty: one run without a material.
    pub parts: Vec<Part>,
    /// For each vertex, which of the file's points it came from (readers split points at seams); empty: itself.
    pub source_points: Vec<u32>,
    /// For each triangle, which of the file's polygons it came from; empty: itself.
    pub source_faces: Vec<u32>,
    /// How many points the file has; 0: as many as `source_points` tells of.
    pub n_source_points: usize,
    /// How many polygons the file has; 0: as many as `source_faces` tells of.
    pub n_source_faces: usize,
}

/// A triangle mesh that later stages can trust. Immutable; made by [`RawMesh::mend`].
///
/// Every index is in range, every position and normal finite, every normal a unit vector, every attribute has one entry
/// a vertex (fields: one an element), no triangle repeats a corner, parts cover the triangles in order.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub(super) raw: RawMesh,
    pub(super) bounds: Option<Bounds>,
}

impl RawMesh {
    /// A mesh made by our own code, taken as it is: the caller answers for every promise of [`Mesh`].
    pub(crate) fn trusted(mut self) -> Mesh {
        if self.parts.is_empty() {
            self.parts = vec![Part { name: String::new(), triangles: 0..self.triangles.len() as u32, material: None }];
        }
        let bounds = Some(Bounds::of(self.positions.iter().copied()));
        Mesh { raw: self, bounds }
    }
}

impl Mesh {
    /// One a vertex, model units.
    pub fn positions(&self) -> &[Vec3] {
        &self.raw.positions
    }
    /// Corners, counter-clockwise seen from the front.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.raw.triangles
    }
    /// Unit vectors, one a vertex.
    pub fn normals(&self) -> &[Vec3] {
        &self.raw.normals
    }
    /// One a vertex, or empty: xyz unit along +u, w the bitangent's sign.
    pub fn tangents(&self) -> &[Vec4] {
        &self.raw.tangents
    }
    /// Linear colour and alpha, one a vertex, or empty.
    pub fn colors(&self) -> &[Vec4] {
        &self.raw.colors
    }
    /// Layouts in the texture plane.
    pub fn uv_sets(&self) -> &[UvSet] {
        &self.raw.uv_sets
    }
    /// Data on the surface.
    pub fn fields(&self) -> &[Field] {
        &self.raw.fields
    }
    /// Runs of triangles by material; they cover all triangles in order.
    pub fn parts(&self) -> &[Part] {
        &self.raw.parts
    }
    /// For each vertex, which of the file's points it came from; empty: itself.
    pub fn source_points(&self) -> &[u32] {
        &self.raw.source_points
    }
    /// For each triangle, which of the file's polygons it came from; empty: itself.
    pub fn source_faces(&self) -> &[u32] {
        &self.raw.source_faces
    }
    /// How many points the file has, those included that are not part of the mesh.
    pub fn n_source_points(&self) -> usize {
        n_sources(self.raw.n_source_points, &self.raw.source_points, self.raw.positions.len())
    }
    /// How many polygons the file has, those included that are not part of the mesh.
    pub fn n_source_faces(&self) -> usize {
        n_sources(self.raw.n_source_faces, &self.raw.source_faces, self.raw.triangles.len())
    }
    /// The box around all positions.
    pub fn bounds(&self) -> Bounds {
        self.bounds.unwrap_or(Bounds::EMPTY)
    }
    /// The same with another layout, of one place a vertex; places that are not numbers become (0, 0).
    pub fn with_uv_set(mut self, mut set: UvSet) -> Self {
        set.uv.resize(self.raw.positions.len(), Vec2::ZERO);
        set.uv.iter_mut().filter(|uv| !uv.is_finite()).for_each(|uv| *uv = Vec2::ZERO);
        self.raw.uv_sets.push(set);
        self
    }
    /// The same with a linear colour and alpha for each vertex.
    pub fn with_colors(mut self, mut colors: Vec<Vec4>) -> Self {
        colors.resize(self.raw.positions.len(), Vec4::ONE);
        self.raw.colors = colors;
        self
    }
    /// The raw form, for a change and another [`RawMesh::mend`].
    pub fn into_raw(self) -> RawMesh {
        self.raw
    }
    /// How many elements of a kind there are.
    pub fn n_elements(&self, element: Element) -> usize {
        match element {
            Element::Vertex => self.raw.positions.len(),
            Element::Face => self.raw.triangles.len(),
            Element::Corner => self.raw.triangles.len() * 3,
        }
    }
}

/// How many points or polygons a file has, as far as is known.
pub(super) fn n_sources(known: usize, sources: &[u32], n_elements: usize) -> usize {
    match sources.iter().max() {
        None => known.max(n_elements),
        Some(last) => known.max(*last as usize + 1),
    }
}
