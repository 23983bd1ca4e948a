//! Where on the texture is this surface point, and how fast does that change from cell to cell?

pub mod surfels;

pub use surfels::{Needs, Surfels, TexCoords, Viewpoint};

use crate::assets::Mesh;
use crate::math::Mat4;

/// Where a layer's coordinates come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Placement {
    /// A UV set of the mesh.
    Uv(u32),
}

/// The UV set whose lanes are the coordinates themselves, if that is so.
pub fn as_uv(placement: &Placement, matrix: &Mat4) -> Option<usize> {
    let Placement::Uv(set) = placement;
    (*matrix == Mat4::IDENTITY).then_some(*set as usize)
}

/// What `place` reads.
pub fn needs(placement: &Placement) -> Needs {
    let Placement::Uv(set) = placement;
    Needs { uv_sets: 1 << set, ..Needs::default() }
}

/// Fills coordinates and footprints.
pub fn place(
    placement: &Placement,
    matrix: &Mat4,
    _view: &Viewpoint,
    _mesh: &Mesh,
    surfels: &Surfels,
    out: &mut TexCoords,
) {
    let Placement::Uv(set) = placement;
    let uv = &surfels.uv[*set as usize];
    let (x, y, w) = (matrix.x_axis, matrix.y_axis, matrix.w_axis);
    for i in 0..surfels.n {
        let map = |[s, t]: [f32; 2], row: usize| x[row] * s + y[row] * t;
        let at = |lanes: &[crate::math::Lane; 2]| [lanes[0][i], lanes[1][i]];
        for row in 0..2 {
            out.st[row][i] = map(at(&uv.st), row) + w[row];
            out.d_dx[row][i] = map(at(&uv.d_dx), row);
            out.d_dy[row][i] = map(at(&uv.d_dy), row);
        }
    }
}
