//! Tangent frames that agree with the tools normal maps are baked in.
//!
//! Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008 (MikkTSpace), through crate `bevy_mikktspace`. Mikkelsen's
//! v runs up and his bitangent along +v; ours runs down, so he is shown 1 - v: the tangent is along +u, the bitangent
//! `cross(normal, tangent) * w` along -v, that is up in the picture, as glTF has it.

use crate::assets::Mesh;
use crate::error::{Report, note};
use crate::math::{Frame, Vec3, Vec4, exact, unit_or};
use crate::placement::split::split_corners;
use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};

/// A tangent frame a corner.
#[derive(Clone, Debug, PartialEq)]
pub struct CornerTangents {
    /// Three a triangle: xyz unit along +u, w the sign of the bitangent.
    pub tangents: Vec<Vec4>,
    /// Corners whose triangles have no area in the texture plane nor neighbours that have: they got some frame.
    pub n_arbitrary: usize,
}

/// The tangent frame of every corner by UV set `uv_set`.
///
/// # Panics
/// If the mesh has no such set.
pub fn tangents(mesh: &Mesh, uv_set: usize) -> CornerTangents {
    let n_corners = mesh.triangles().len() * 3;
    let mut corners = Corners { mesh, uv_set, tangents: vec![Vec4::ZERO; n_corners], n_arbitrary: 0 };
    // The error has no cases; a corner that is never set keeps its zero and gets a frame below.
    let _ = generate_tangents(&mut corners);
    CornerTangents { tangents: corners.tangents, n_arbitrary: corners.n_arbitrary }
}

/// The mesh with a tangent a vertex by UV set `uv_set`. Vertices whose corners disagree (where the texture is mirrored, or
/// its layout is cut) are split; everything else stays and keeps its order.
///
/// # Panics
/// If the mesh has no such set.
pub fn with_tangents(mesh: Mesh, uv_set: usize) -> Report<Mesh> {
    let CornerTangents { tangents, n_arbitrary } = tangents(&mesh, uv_set);
    let mut raw = mesh.into_raw();
    raw.tangents.clear();
    let (tangents, n_split) = split_corners(&mut raw, &tangents, Vec4::new(1.0, 0.0, 0.0, 1.0));
    raw.tangents = tangents;
    let mut report = raw.mend();
    note(&mut report.mended, n_split, "vertices split where the tangent frame jumps");
    note(&mut report.mended, n_arbitrary, "corners without extent in the texture plane got an arbitrary tangent");
    report
}

/// What the crate reads and writes.
struct Corners<'a> {
    mesh: &'a Mesh,
    uv_set: usize,
    tangents: Vec<Vec4>,
    n_arbitrary: usize,
}

/// The platform's acos may differ from machine to machine.
struct SameEverywhere;

impl Ops for SameEverywhere {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }
    fn acos(x: f32) -> f32 {
        exact::acos(x as f64) as f32
    }
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles()[face][corner] as usize
    }
}

impl Geometry<SameEverywhere> for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles().len()
    }
    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }
    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions()[self.vertex(face, corner)].to_array()
    }
    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals()[self.vertex(face, corner)].to_array()
    }
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.mesh.uv_sets()[self.uv_set].uv[self.vertex(face, corner)];
        [uv.x, 1.0 - uv.y]
    }
    fn set_tangent(&mut self, found: Option<TangentSpace>, face: usize, corner: usize) {
        let normal = self.mesh.normals()[self.vertex(face, corner)];
        let [x, y, z, w] = found.map_or([0.0; 4], |space| space.tangent_encoded());
        let along_u = unit_or(Vec3::new(x, y, z), Vec3::ZERO);
        self.tangents[face * 3 + corner] = match along_u == Vec3::ZERO {
            false => along_u.extend(if w < 0.0 { -1.0 } else { 1.0 }),
            true => {
                self.n_arbitrary += 1;
                Frame::about(normal).tangent.extend(1.0)
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::{RawMesh, UvSet};
    use crate::math::{Vec2, vec2, vec3};

    /// A unit square in the xy plane, facing +Z, with the picture upright (v down), or mirrored.
    fn square(mirrored: bool, degenerate: bool) -> Mesh {
        let positions = vec![vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(0.0, 1.0, 0.0)];
        let place = |p: &Vec3| {
            let u = if mirrored { 1.0 - p.x } else { p.x };
            if degenerate { Vec2::splat(0.5) } else { vec2(u, 1.0 - p.y) }
        };
        let uv = positions.iter().map(place).collect();
        let uv_sets = vec![UvSet { name: "uv0".into(), uv }];
        RawMesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], uv_sets, ..RawMesh::default() }.mend().value
    }

    #[test]
    fn the_bitangent_points_up_in_the_picture() {
        for (mirrored, u) in [(false, Vec3::X), (true, Vec3::NEG_X)] {
            let mesh = with_tangents(square(mirrored, false), 0).value;
            for (t, n) in mesh.tangents().iter().zip(mesh.normals()) {
                assert!((t.truncate() - u).length() < 1e-6);
                assert!((n.cross(t.truncate()) * t.w - Vec3::Y).length() < 1e-6, "mirrored: {mirrored}");
            }
        }
    }

    #[test]
    fn a_layout_without_area_gets_some_frame_and_says_so() {
        let report = with_tangents(square(false, true), 0);
        assert!(report.value.tangents().iter().all(|t| (t.truncate().length() - 1.0).abs() < 1e-6 && t.z.abs() < 1e-6));
        assert!(report.mended.iter().any(|m| m.what.contains("arbitrary")), "{:?}", report.mended);
    }

    #[test]
    fn a_mirrored_seam_splits_its_vertices() {
        // Two squares that share the edge x = 1; the right one shows the left one's picture mirrored.
        let positions: Vec<_> = [0.0, 1.0, 2.0].iter().flat_map(|&x| [vec3(x, 0.0, 0.0), vec3(x, 1.0, 0.0)]).collect();
        let uv = positions.iter().map(|p| vec2(1.0 - (p.x - 1.0).abs(), 1.0 - p.y)).collect();
        let triangles = vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]];
        let uv_sets = vec![UvSet { name: "uv0".into(), uv }];
        let report = with_tangents(RawMesh { positions, triangles, uv_sets, ..RawMesh::default() }.mend().value, 0);
        assert_eq!(report.value.positions().len(), 8);
        let signs = |range: std::ops::Range<usize>| -> Vec<f32> {
            report.value.triangles()[range].iter().flatten().map(|&v| report.value.tangents()[v as usize].w).collect()
        };
        assert_eq!((signs(0..2), signs(2..4)), (vec![1.0; 6], vec![-1.0; 6]));
    }

    #[test]
    fn tangents_agree_with_a_published_sphere() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/2_gltf/sphere_tangents");
        let (Ok(text), Ok(buffer)) =
            (std::fs::read(format!("{folder}/sphere.gltf")), std::fs::read(format!("{folder}/sphere_buffer0.bin")))
        else {
            eprintln!("skipped: {folder} is not there");
            return;
        };
        let document = gltf::Gltf::from_slice_without_validation(&text).unwrap().document;
        let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(&buffer));
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        let published: Vec<[f32; 4]> = reader.read_tangents().unwrap().collect();
        let raw = RawMesh {
            positions: reader.read_positions().unwrap().map(Vec3::from).collect(),
            normals: reader.read_normals().unwrap().map(Vec3::from).collect(),
            triangles: indices.as_chunks().0.to_vec(),
            uv_sets: vec![UvSet {
                name: "TEXCOORD_0".into(),
                uv: reader.read_tex_coords(0).unwrap().into_f32().map(Vec2::from).collect(),
            }],
            ..RawMesh::default()
        };
        let mesh = raw.mend().value;
        let found = tangents(&mesh, 0).tangents;
        let mut angles: Vec<f64> = Vec::new();
        for (&v, t) in mesh.triangles().iter().flatten().zip(&found) {
            let truth = Vec4::from(published[v as usize]);
            assert_eq!(t.w, truth.w, "vertex {v}");
            let cosine = t.truncate().dot(truth.truncate().normalize());
            angles.push(exact::acos(cosine.clamp(-1.0, 1.0) as f64).to_degrees());
        }
        angles.sort_by(f64::total_cmp);
        let (median, most) = (angles[angles.len() / 2], angles[angles.len() - 1]);
        println!(
            "tangents: median {median:.3}, 95 % {:.3}, most {most:.3} degrees off",
            angles[angles.len() * 95 / 100]
        );
        assert!(median < 1.0 && most < 10.0, "median {median}, most {most} degrees off");
    }
}
