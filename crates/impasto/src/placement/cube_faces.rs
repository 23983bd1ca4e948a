//! Reflections from a cube by vertex: each triangle on one of six pictures.
//!
//! After Teschner and Henn, "Texture Mapping in Technical, Scientific and Engineering Visualization", 1994: the
//! reflection vector of each vertex picks one of six pictures and a place in it; triangles whose corners fall on different
//! pictures are subdivided. Inexact, since vectors belong to vertices, and convincing where triangles are small; the
//! exact way is [`Placement::ReflectionMap`] with a cube texture.

use crate::assets::{Element, Mesh, RawMesh, UvSet, Values};
use crate::math::{Mat4, Vec2, Vec3, unit_or};
use crate::placement::at_vertices::coordinates;
use crate::placement::split::split_corners;
use crate::placement::{Placement, Viewpoint};
use std::collections::{HashMap, HashSet};

/// How a mesh is laid on the six pictures of a cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CubeFaces {
    /// Texels along an edge of a picture: half of one is kept clear at its edges, so that no picture bleeds into another.
    pub n_texels: u32,
    /// How often a triangle that falls on several pictures is cut in halves.
    pub depth: u32,
}

/// A mesh laid on a column of six pictures, +X on top, then -X, +Y, -Y, +Z, -Z.
pub struct Laid {
    /// Subdivided where needed; everything that belongs to vertices and triangles went along.
    pub mesh: Mesh,
    /// Its last UV set, into the column.
    pub uv_set: usize,
    /// Triangles that still touch several pictures; they show the one of their middle.
    pub n_mixed: usize,
}

impl Default for CubeFaces {
    /// Pictures of 256 texels, six halvings.
    fn default() -> Self {
        Self { n_texels: 256, depth: 6 }
    }
}

/// Beyond this many triangles nothing is subdivided any more.
const MOST_TRIANGLES: usize = 1 << 23;

/// Lays a mesh on the six pictures of a cube by the directions that `placement` gives its vertices:
/// [`Placement::ReflectionMap`] or [`Placement::NormalMap`].
pub fn cube_faces(placement: &Placement, view: &Viewpoint, mesh: Mesh, how: CubeFaces) -> Laid {
    let mut mesh = mesh;
    for _ in 0..how.depth {
        let faces = vertex_faces(placement, view, &mesh);
        let edges = mixed_edges(&mesh, &faces);
        if edges.is_empty() || mesh.triangles().len() > MOST_TRIANGLES {
            break;
        }
        mesh = subdivided(mesh.into_raw(), &edges).trusted();
    }
    let directions = coordinates(placement, &Mat4::IDENTITY, view, &mesh);
    let mut n_mixed = 0;
    let mut corners = Vec::with_capacity(mesh.triangles().len() * 3);
    for triangle in mesh.triangles() {
        let three = triangle.map(|v| Vec3::from(directions[v as usize]));
        let faces = three.map(face_of);
        let is_mixed = faces[0] != faces[1] || faces[0] != faces[2];
        n_mixed += is_mixed as usize;
        let face = if is_mixed { face_of(three[0] + three[1] + three[2]) } else { faces[0] };
        corners.extend(three.map(|d| place_on(face, d, how.n_texels)));
    }
    let mut raw = mesh.into_raw();
    let (uv, _) = split_corners(&mut raw, &corners, Vec2::ZERO);
    raw.uv_sets.push(UvSet { name: "cube faces".into(), uv });
    let uv_set = raw.uv_sets.len() - 1;
    Laid { mesh: raw.trusted(), uv_set, n_mixed }
}

fn vertex_faces(placement: &Placement, view: &Viewpoint, mesh: &Mesh) -> Vec<u8> {
    coordinates(placement, &Mat4::IDENTITY, view, mesh).into_iter().map(|d| face_of(d.into())).collect()
}

/// Which of +X -X +Y -Y +Z -Z a direction falls on.
fn face_of(d: Vec3) -> u8 {
    let a = d.abs();
    let (axis, negative) = if a.x >= a.y && a.x >= a.z {
        (0, d.x < 0.0)
    } else if a.y >= a.z {
        (1, d.y < 0.0)
    } else {
        (2, d.z < 0.0)
    };
    axis * 2 + negative as u8
}

/// Where a direction falls on a face, in the column of six. Directions that belong to another face stay at the edge.
fn place_on(face: u8, d: Vec3, n_texels: u32) -> Vec2 {
    let (s, t, along) = match face {
        0 => (-d.z, -d.y, d.x),
        1 => (d.z, -d.y, -d.x),
        2 => (d.x, d.z, d.y),
        3 => (d.x, -d.z, -d.y),
        4 => (d.x, -d.y, d.z),
        _ => (-d.x, -d.y, -d.z),
    };
    let margin = 0.5 / n_texels.max(1) as f32;
    let along = along.max(1e-6);
    let [u, v] = [s, t].map(|x| (x / along * 0.5 + 0.5).clamp(margin, 1.0 - margin));
    Vec2::new(u, (face as f32 + v) / 6.0)
}

/// The point of each vertex: those at one place are one point, so that seams do not open.
fn points(mesh: &Mesh) -> Vec<u32> {
    let mut seen: HashMap<[u32; 3], u32> = HashMap::new();
    let key = |p: &Vec3| p.to_array().map(|x| (x + 0.0).to_bits());
    mesh.positions().iter().enumerate().map(|(i, p)| *seen.entry(key(p)).or_insert(i as u32)).collect()
}

/// Edges between points whose ends fall on different faces, wherever one of their triangles says so.
fn mixed_edges(mesh: &Mesh, faces: &[u8]) -> HashSet<[u32; 2]> {
    let points = points(mesh);
    let mut edges = HashSet::new();
    for t in mesh.triangles() {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            if faces[a as usize] != faces[b as usize] {
                edges.insert(ordered(points[a as usize], points[b as usize]));
            }
        }
    }
    edges
}

fn ordered(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Cuts these edges (of points) in halves, and the triangles beside them into two, three or four.
fn subdivided(raw: RawMesh, edges: &HashSet<[u32; 2]>) -> RawMesh {
    let mesh = raw.trusted();
    let points = points(&mesh);
    let mut raw = mesh.into_raw();
    let n_before = raw.positions.len() as u32;
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let mut ends: Vec<[u32; 2]> = Vec::new();
    let mut triangles = Vec::with_capacity(raw.triangles.len());
    // For each new triangle the old one, and for each of its corners the two old corners it lies between.
    let mut source: Vec<u32> = Vec::new();
    let mut corners: Vec<[u8; 2]> = Vec::new();
    let mut starts: Vec<u32> = Vec::with_capacity(raw.triangles.len() + 1);
    for (i, t) in raw.triangles.iter().enumerate() {
        starts.push(triangles.len() as u32);
        let mut middle = |k: usize| -> Option<(u32, [u8; 2])> {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            edges.contains(&ordered(points[a as usize], points[b as usize])).then(|| {
                let vertex = *middles.entry(ordered(a, b)).or_insert_with(|| {
                    ends.push(ordered(a, b));
                    n_before + ends.len() as u32 - 1
                });
                (vertex, [k as u8, ((k + 1) % 3) as u8])
            })
        };
        let corner = |k: usize| (t[k], [k as u8; 2]);
        let mut add = |three: [(u32, [u8; 2]); 3]| {
            triangles.push(three.map(|c| c.0));
            corners.extend(three.map(|c| c.1));
            source.push(i as u32);
        };
        let cut = [middle(0), middle(1), middle(2)];
        match cut.iter().flatten().count() {
            0 => add([corner(0), corner(1), corner(2)]),
            3 => {
                let [m, n, o] = cut.map(|c| c.expect("three are cut"));
                for three in [[corner(0), m, o], [m, corner(1), n], [o, n, corner(2)], [m, n, o]] {
                    add(three);
                }
            }
            1 => {
                let k = cut.iter().position(Option::is_some).expect("one is cut");
                let m = cut[k].expect("this one");
                let (a, b, c) = (corner(k), corner((k + 1) % 3), corner((k + 2) % 3));
                add([a, m, c]);
                add([m, b, c]);
            }
            _ => {
                // The edge that stays whole is from `a` to `b`.
                let k = cut.iter().position(Option::is_none).expect("one is whole");
                let (a, b, c) = (corner(k), corner((k + 1) % 3), corner((k + 2) % 3));
                let (m, n) = (cut[(k + 1) % 3].expect("cut"), cut[(k + 2) % 3].expect("cut"));
                add([m, c, n]);
                add([a, b, m]);
                add([a, m, n]);
            }
        }
    }
    starts.push(triangles.len() as u32);
    raw.triangles = triangles;
    for part in &mut raw.parts {
        part.triangles = starts[part.triangles.start as usize]..starts[part.triangles.end as usize];
    }
    grow(&mut raw, &ends, &source, &corners, n_before as usize);
    raw
}

/// Attributes of the new vertices, between those of their two ends; of the new triangles, those of the old.
fn grow(raw: &mut RawMesh, ends: &[[u32; 2]], source: &[u32], corners: &[[u8; 2]], n_before: usize) {
    let pairs = || ends.iter().map(|e| e.map(|v| v as usize));
    if raw.source_points.is_empty() {
        raw.source_points = (0..n_before as u32).collect();
    }
    raw.source_points.extend(ends.iter().map(|e| e[0]));
    raw.positions.extend(pairs().map(|[a, b]| (raw.positions[a] + raw.positions[b]) * 0.5).collect::<Vec<_>>());
    let normals: Vec<Vec3> = pairs().map(|[a, b]| unit_or(raw.normals[a] + raw.normals[b], raw.normals[a])).collect();
    raw.normals.extend(normals);
    if !raw.tangents.is_empty() {
        let between = |[a, b]: [usize; 2]| {
            let (p, q) = (raw.tangents[a], raw.tangents[b]);
            unit_or((p + q).truncate(), p.truncate()).extend(p.w)
        };
        raw.tangents.extend(pairs().map(between).collect::<Vec<_>>());
    }
    if !raw.colors.is_empty() {
        raw.colors.extend(pairs().map(|[a, b]| (raw.colors[a] + raw.colors[b]) * 0.5).collect::<Vec<_>>());
    }
    for set in &mut raw.uv_sets {
        set.uv.extend(pairs().map(|[a, b]| (set.uv[a] + set.uv[b]) * 0.5).collect::<Vec<_>>());
    }
    for field in &mut raw.fields {
        let n = field.n_components;
        let half = |values: &Values, a: usize, b: usize, k: usize| {
            let (x, y) = (values.at(a * n + k), values.at(b * n + k));
            if x == y { x } else { (x + y) * 0.5 }
        };
        let old = field.values.clone();
        let pairs: Vec<[usize; 2]> = match field.element {
            Element::Vertex => pairs().collect(),
            Element::Face => {
                field.values = old.gathered(source, n);
                continue;
            }
            Element::Corner => {
                corners.iter().enumerate().map(|(i, c)| c.map(|c| source[i / 3] as usize * 3 + c as usize)).collect()
            }
        };
        let new = pairs.iter().flat_map(|&[a, b]| (0..n).map(move |k| (a, b, k))).map(|(a, b, k)| half(&old, a, b, k));
        match &mut field.values {
            Values::F32(v) => {
                let new: Vec<f32> = new.map(|x| x as f32).collect();
                if field.element == Element::Corner { *v = new } else { v.extend(new) }
            }
            Values::F64(v) => {
                let new: Vec<f64> = new.collect();
                if field.element == Element::Corner { *v = new } else { v.extend(new) }
            }
        }
    }
    if !raw.source_faces.is_empty() {
        raw.source_faces = source.iter().map(|&t| raw.source_faces[t as usize]).collect();
    } else {
        raw.source_faces = source.to_vec();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::{Field, Topology};
    use crate::placement::Space;
    use crate::samples;

    const VIEW: Viewpoint = Viewpoint { eye_from_world: Mat4::IDENTITY, eye: Vec3::ZERO, parallel: Some(Vec3::Z) };
    const BY_NORMAL: Placement = Placement::NormalMap { space: Space::World };

    fn area(mesh: &Mesh) -> f64 {
        let p = |v: u32| mesh.positions()[v as usize].as_dvec3();
        mesh.triangles().iter().map(|t| (p(t[1]) - p(t[0])).cross(p(t[2]) - p(t[0])).length() * 0.5).sum()
    }

    #[test]
    fn every_triangle_lies_on_one_picture_and_none_is_lost() {
        let mesh = samples::scene("icosphere", 6, 1).expect("a sample").mesh;
        let (before, n_before) = (area(&mesh), mesh.triangles().len());
        let laid = cube_faces(&BY_NORMAL, &VIEW, mesh, CubeFaces::default());
        assert!((area(&laid.mesh) - before).abs() < 1e-4 * before, "flat triangles stay flat");
        assert!(laid.mesh.triangles().len() > 2 * n_before, "{}", laid.mesh.triangles().len());
        let uv = &laid.mesh.uv_sets()[laid.uv_set].uv;
        assert_eq!(uv.len(), laid.mesh.positions().len());
        for t in laid.mesh.triangles() {
            let rows = t.map(|v| (uv[v as usize].y * 6.0) as u32);
            assert!(rows[0] == rows[1] && rows[0] == rows[2], "{rows:?}");
        }
        assert!(Topology::of(&laid.mesh).is_closed(), "no crack where triangles were cut");
        let share = laid.n_mixed as f64 / laid.mesh.triangles().len() as f64;
        assert!(share < 0.5, "{share}");
    }

    #[test]
    fn places_are_those_of_the_direction() {
        // The normal +Z is the middle of the fifth picture, (1, 0, 1) its right edge.
        assert_eq!(place_on(4, Vec3::Z, 256), Vec2::new(0.5, 4.5 / 6.0));
        let edge = place_on(4, Vec3::new(1.0, 0.0, 1.0), 256);
        assert!((edge.x - (1.0 - 0.5 / 256.0)).abs() < 1e-6 && (edge.y - 0.75).abs() < 1e-6);
        let up = place_on(2, Vec3::Y, 256);
        assert_eq!(up, Vec2::new(0.5, 2.5 / 6.0));
        for (d, face) in
            [(Vec3::X, 0), (Vec3::NEG_X, 1), (Vec3::Y, 2), (Vec3::NEG_Y, 3), (Vec3::Z, 4), (Vec3::NEG_Z, 5)]
        {
            assert_eq!(face_of(d), face);
        }
    }

    #[test]
    fn attributes_go_along() {
        let mut raw = samples::scene("cube", 1, 1).expect("a sample").mesh.into_raw();
        let (n, n_triangles) = (raw.positions.len(), raw.triangles.len());
        let field = |name: &str, element, n: usize| Field {
            name: name.into(),
            unit: String::new(),
            element,
            n_components: 1,
            values: Values::F32((0..n).map(|i| i as f32).collect()),
        };
        raw.fields = vec![
            field("v", Element::Vertex, n),
            field("f", Element::Face, n_triangles),
            field("c", Element::Corner, 3 * n_triangles),
        ];
        let mesh = raw.trusted();
        let view = Viewpoint { parallel: Some(unit_or(Vec3::new(0.5, 0.4, 0.8), Vec3::Z)), ..VIEW };
        // The reflections of a flat side are all the same; from the middle, a position's direction is not.
        let placement = Placement::ReflectionMap { space: Space::World };
        let near = Viewpoint { eye: Vec3::new(0.1, 0.2, 1.2), parallel: None, ..view };
        let laid = cube_faces(&placement, &near, mesh, CubeFaces { n_texels: 16, depth: 3 });
        let mesh = laid.mesh;
        assert!(mesh.triangles().len() > n_triangles);
        for (element, field) in [Element::Vertex, Element::Face, Element::Corner].into_iter().zip(mesh.fields()) {
            assert_eq!(field.values.len(), mesh.n_elements(element), "{element:?}");
        }
        let last = mesh.parts().last().expect("a part").triangles.end;
        assert_eq!(last as usize, mesh.triangles().len());
        assert_eq!(mesh.source_faces().len(), mesh.triangles().len());
        assert_eq!(mesh.normals().len(), mesh.positions().len());
    }
}
