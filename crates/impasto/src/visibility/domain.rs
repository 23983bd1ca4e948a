//! The two directions: from a mesh's vertices to a grid of cells, through a camera or over an atlas.

use crate::assets::Mesh;
use crate::math::{DVec4, Mat4, Size, Vec2, Vec3, Vec4, vec4};
use crate::placement::Viewpoint;
use crate::visibility::Camera;

/// How a mesh's vertices map to a grid of cells.
pub struct Domain<'a> {
    /// The surface.
    pub mesh: &'a Mesh,
    /// Cells across and down.
    pub size: Size,
    /// Who looks. Over an atlas: somebody far in front of +Z, so that view-dependent looks have an answer.
    pub view: Viewpoint,
    /// Line of sight at the grid's top left corner, and its change per cell right and down.
    pub(crate) sight: [Vec3; 3],
    /// Vertices with smaller w are cut away.
    pub(crate) near: f32,
    pub(crate) map: Map<'a>,
}

pub(crate) enum Map<'a> {
    Camera { cells_from_world: Mat4 },
    Atlas { uv: &'a [Vec2] },
}

impl<'a> Domain<'a> {
    /// What a camera sees: cells are pixels.
    pub fn through_camera(mesh: &'a Mesh, camera: &Camera, size: Size) -> Self {
        let cells_from_world = camera.cells_from_world(size, mesh.bounds());
        let perspective = matches!(camera.projection, crate::math::Projection::Perspective { .. });
        let map = Map::Camera { cells_from_world };
        let near = if perspective { camera.near } else { 0.0 };
        Self { mesh, size, view: camera.viewpoint(), sight: camera.sight(size), near, map }
    }

    /// The same with all that is seen `columns` cells further right.
    pub fn moved_right(mut self, columns: u32) -> Self {
        let by = columns as f32;
        self.sight[0] -= self.sight[1] * by;
        if let Map::Camera { cells_from_world: m } = &mut self.map {
            for axis in [&mut m.x_axis, &mut m.y_axis, &mut m.z_axis, &mut m.w_axis] {
                axis.x += by * axis.w;
            }
        }
        self
    }

    /// The surface laid flat by a UV set: cells are texels. `uv_set` must exist.
    pub fn over_atlas(mesh: &'a Mesh, uv_set: usize, size: Size) -> Self {
        let uv = &mesh.uv_sets()[uv_set].uv;
        let view = Viewpoint { eye_from_world: Mat4::IDENTITY, eye: vec3_far(mesh), parallel: Some(Vec3::Z) };
        Self { mesh, size, view, sight: [-Vec3::Z, Vec3::ZERO, Vec3::ZERO], near: 0.0, map: Map::Atlas { uv } }
    }

    /// Homogeneous cell coordinates of a vertex: `x/w`, `y/w` in cells from the top left corner, `z/w` the depth.
    #[inline(always)]
    pub(crate) fn corner(&self, vertex: u32) -> Vec4 {
        match &self.map {
            Map::Camera { cells_from_world: m } => {
                let p = self.mesh.positions()[vertex as usize];
                ((m.x_axis * p.x + m.y_axis * p.y) + m.z_axis * p.z) + m.w_axis
            }
            Map::Atlas { uv } => {
                let t = uv[vertex as usize];
                vec4(t.x * self.size.width as f32, t.y * self.size.height as f32, 1.0, 1.0)
            }
        }
    }

    /// World space to homogeneous cells, through a camera; none over an atlas.
    pub(crate) fn cells_from_world(&self) -> Option<Mat4> {
        match self.map {
            Map::Camera { cells_from_world } => Some(cells_from_world),
            Map::Atlas { .. } => None,
        }
    }

    /// [`corner`](Self::corner) in f64, for clipping.
    pub(crate) fn corner_f64(&self, vertex: u32) -> DVec4 {
        match &self.map {
            Map::Camera { cells_from_world } => {
                let p = self.mesh.positions()[vertex as usize].as_dvec3();
                let m = cells_from_world.as_dmat4();
                ((m.x_axis * p.x + m.y_axis * p.y) + m.z_axis * p.z) + m.w_axis
            }
            Map::Atlas { .. } => self.corner(vertex).as_dvec4(),
        }
    }
}

fn vec3_far(mesh: &Mesh) -> Vec3 {
    mesh.bounds().center() + Vec3::Z * (mesh.bounds().radius() * 1e3)
}
