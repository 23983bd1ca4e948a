//! Coordinates worked out once at each vertex, and interpolated after: how machines did it that could do no more.

use crate::assets::{Mesh, UvSet};
use crate::math::{BATCH, Mat4, Vec2};
use crate::placement::{Measures, Placement, Surfels, TexCoords, Viewpoint, place};

/// Any placement, evaluated at the vertices: a UV set. Coordinates that jump within a triangle smear there; [`place`]
/// has no such fault. Vertices without a triangle get (0, 0), as do coordinates that are missing.
pub fn at_vertices(placement: &Placement, matrix: &Mat4, view: &Viewpoint, mesh: &Mesh) -> UvSet {
    let number = |x: f32| if x.is_finite() { x } else { 0.0 };
    let coordinates = coordinates(placement, matrix, view, mesh);
    UvSet {
        name: "at vertices".into(),
        uv: coordinates.iter().map(|c| Vec2::new(number(c[0]), number(c[1]))).collect(),
    }
}

/// (s, t, r) at each vertex, as its front is seen.
pub(super) fn coordinates(placement: &Placement, matrix: &Mat4, view: &Viewpoint, mesh: &Mesh) -> Vec<[f32; 3]> {
    const NONE: u32 = u32::MAX;
    // Each vertex stands on a corner of one of its triangles.
    let mut stand: Vec<[u32; 2]> = vec![[NONE, 0]; mesh.positions().len()];
    for (t, corners) in mesh.triangles().iter().enumerate() {
        for (c, &v) in corners.iter().enumerate() {
            let stand = &mut stand[v as usize];
            if stand[0] == NONE {
                *stand = [t as u32, c as u32];
            }
        }
    }
    let mut out = vec![[0.0; 3]; stand.len()];
    let mut surfels = Surfels::new(mesh.uv_sets().len());
    let mut coords = TexCoords::ZERO;
    let used: Vec<usize> = (0..stand.len()).filter(|v| stand[*v][0] != NONE).collect();
    for batch in used.chunks(BATCH) {
        surfels.n = batch.len();
        for (i, &v) in batch.iter().enumerate() {
            let [triangle, corner] = stand[v];
            surfels.triangle[i] = triangle;
            surfels.barycentric[0][i] = (corner == 1) as u32 as f32;
            surfels.barycentric[1][i] = (corner == 2) as u32 as f32;
            for k in 0..3 {
                surfels.position[k][i] = mesh.positions()[v][k];
                surfels.normal[k][i] = mesh.normals()[v][k];
            }
            for (set, uv) in mesh.uv_sets().iter().enumerate() {
                (surfels.uv[set].st[0][i], surfels.uv[set].st[1][i]) = (uv.uv[v].x, uv.uv[v].y);
            }
        }
        place(placement, matrix, view, mesh, &surfels, &mut Measures::default(), &mut coords);
        for (i, &v) in batch.iter().enumerate() {
            out[v] = [coords.st[0][i], coords.st[1][i], coords.r[0][i]];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Vec3, Vec4, vec3};
    use crate::placement::Space;
    use crate::samples;

    const VIEW: Viewpoint = Viewpoint { eye_from_world: Mat4::IDENTITY, eye: Vec3::ZERO, parallel: Some(Vec3::Z) };

    #[test]
    fn linear_coordinates_lose_nothing() {
        let mesh = samples::scene("knot", 16, 1).expect("a sample").mesh;
        let planes = [Vec4::new(2.0, 0.0, 0.0, 0.5), Vec4::new(0.0, 0.0, -1.0, 0.0), Vec4::ZERO];
        let set = at_vertices(&Placement::WorldLinear { planes }, &Mat4::IDENTITY, &VIEW, &mesh);
        assert_eq!(set.uv.len(), mesh.positions().len());
        for (uv, p) in set.uv.iter().zip(mesh.positions()) {
            assert!((uv.x - 2.0 * p.x - 0.5).abs() < 1e-5 && (uv.y + p.z).abs() < 1e-6);
        }
        let own = at_vertices(&Placement::Uv(0), &Mat4::from_scale(vec3(3.0, 1.0, 1.0)), &VIEW, &mesh);
        let scaled = |(a, b): (&Vec2, &Vec2)| (a.x - 3.0 * b.x).abs() < 1e-5 && a.y == b.y;
        assert!(own.uv.iter().zip(&mesh.uv_sets()[0].uv).all(scaled));
    }

    #[test]
    fn reflections_are_those_of_the_vertices_normals() {
        let mesh = samples::scene("icosphere", 8, 1).expect("a sample").mesh;
        let placement = Placement::ReflectionMap { space: Space::World };
        for (r, n) in coordinates(&placement, &Mat4::IDENTITY, &VIEW, &mesh).iter().zip(mesh.normals()) {
            let wanted = *n * (2.0 * n.z) - Vec3::Z;
            assert!((Vec3::from(*r) - wanted).length() < 1e-5, "{r:?} {wanted}");
        }
    }
}
