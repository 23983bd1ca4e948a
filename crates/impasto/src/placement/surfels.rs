//! The currency between stages: a batch of surface points in structure-of-arrays form.
//!
//! `visibility` fills [`Surfels`] from triangle ids and cell centres, `placement` derives [`TexCoords`] from them,
//! `lookup` reads textures there. Nothing of this is stored longer than a batch lives.

use crate::math::{BATCH, Lane, Mat4, Vec3};

/// Which lanes of [`Surfels`] a look needs; the others are not filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// `position`.
    pub position: bool,
    /// `normal`.
    pub normal: bool,
    /// `tangent`.
    pub tangent: bool,
    /// `color`.
    pub color: bool,
    /// `view`.
    pub view: bool,
    /// `d_barycentric`: for footprints of anything but UV sets.
    pub derivatives: bool,
    /// Bit n: `uv[n]` with its footprint.
    pub uv_sets: u32,
}

impl Needs {
    /// What either needs.
    pub fn or(self, other: Self) -> Self {
        Self {
            position: self.position | other.position,
            normal: self.normal | other.normal,
            tangent: self.tangent | other.tangent,
            color: self.color | other.color,
            view: self.view | other.view,
            derivatives: self.derivatives | other.derivatives,
            uv_sets: self.uv_sets | other.uv_sets,
        }
    }
}

/// Up to [`BATCH`] surface points. Lanes that were not asked for are stale.
#[derive(Clone)]
pub struct Surfels {
    /// How many are valid.
    pub n: usize,
    /// Column and row of the cell.
    pub cell: [[u32; BATCH]; 2],
    /// Index into the mesh's triangles.
    pub triangle: [u32; BATCH],
    /// Weights of the triangle's second and third corner, perspective-correct, within the triangle; the first has the rest.
    pub barycentric: [Lane; 2],
    /// How these weights change for one cell to the right, and for one cell down: `[x|y][second|third]`.
    pub d_barycentric: [[Lane; 2]; 2],
    /// 1 where the triangle's front is seen, -1 where its back is.
    pub side: Lane,
    /// World space.
    pub position: [Lane; 3],
    /// World space, interpolated and made unit, as the mesh has it: away from the front side.
    pub normal: [Lane; 3],
    /// World space, xyz unit along +u, w the sign of the bitangent.
    pub tangent: [Lane; 4],
    /// Vertex colour, linear, and alpha.
    pub color: [Lane; 4],
    /// Unit vector towards the eye.
    pub view: [Lane; 3],
    /// The UV sets that were asked for, by their index in the mesh.
    pub uv: Vec<TexCoords>,
}

/// Texture coordinates of a batch, with their footprint.
#[derive(Clone)]
pub struct TexCoords {
    /// s and t in texture widths and heights.
    pub st: [Lane; 2],
    /// Change of s and t for one cell to the right.
    pub d_dx: [Lane; 2],
    /// Change of s and t for one cell down.
    pub d_dy: [Lane; 2],
    /// Third coordinate and its change right and down; only filled by sources that have one (3-D and cube textures).
    pub r: [Lane; 3],
}

/// Who looks: what eye-dependent coordinates need to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// World to eye space: +X right, +Y up, looking along -Z.
    pub eye_from_world: Mat4,
    /// Where the eye is; for parallel projections a point far back on the line of sight.
    pub eye: Vec3,
    /// Parallel lines of sight: the unit vector towards the eye, the same everywhere.
    pub parallel: Option<Vec3>,
}

impl TexCoords {
    /// All zero.
    pub const ZERO: Self =
        Self { st: [[0.0; BATCH]; 2], d_dx: [[0.0; BATCH]; 2], d_dy: [[0.0; BATCH]; 2], r: [[0.0; BATCH]; 3] };
}

impl Surfels {
    /// An empty batch with room for `n_uv_sets`.
    pub fn new(n_uv_sets: usize) -> Box<Self> {
        Box::new(Self {
            n: 0,
            cell: [[0; BATCH]; 2],
            triangle: [0; BATCH],
            barycentric: [[0.0; BATCH]; 2],
            d_barycentric: [[[0.0; BATCH]; 2]; 2],
            side: [1.0; BATCH],
            position: [[0.0; BATCH]; 3],
            normal: [[0.0; BATCH]; 3],
            tangent: [[0.0; BATCH]; 4],
            color: [[0.0; BATCH]; 4],
            view: [[0.0; BATCH]; 3],
            uv: vec![TexCoords::ZERO; n_uv_sets],
        })
    }
}
