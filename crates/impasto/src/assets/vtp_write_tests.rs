//! Small files and broken ones.

use super::*;
use crate::assets::{RawMesh, Scene, UvSet, glb, gltf_in, ply, ply_write, vtk_xml};
use crate::math::{Vec4, vec2, vec3, vec4};
use std::path::Path;

fn field(name: &str, unit: &str, element: Element, n_components: usize, values: Values) -> Field {
    Field { name: name.into(), unit: unit.into(), element, n_components, values }
}

/// A square with all that a mesh can have.
fn square() -> Mesh {
    let f32s = |n: usize| Values::F32((0..n).map(|i| i as f32 * 0.1).collect());
    let raw = RawMesh {
        positions: vec![vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(0.0, 1.0, 0.1)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        tangents: vec![vec4(1.0, 0.0, 0.0, -1.0); 4],
        colors: vec![Vec4::ONE, vec4(0.3, 0.2, 0.1, 0.5), Vec4::ONE, Vec4::ONE],
        uv_sets: vec![
            UvSet { name: "uv0".into(), uv: [0.0f32, 0.1, 0.7, 1.0].map(|x| vec2(x, x)).to_vec() },
            UvSet { name: "uv1".into(), uv: vec![vec2(0.25, 0.5); 4] },
        ],
        fields: vec![
            field("a & <b>", "µm", Element::Vertex, 1, Values::F64(vec![0.1, f64::NAN, 1e300, -2.0])),
            field("v", "", Element::Vertex, 3, f32s(12)),
            field("face", "", Element::Face, 2, f32s(4)),
            field("corner", "", Element::Corner, 1, f32s(6)),
        ],
        ..Default::default()
    };
    raw.mend().value
}

/// Equal, with NaN equal to NaN.
fn same(a: &Values, b: &Values) -> bool {
    a.len() == b.len() && a.numbers().zip(b.numbers()).all(|(a, b)| a == b || a.is_nan() && b.is_nan())
}

#[test]
fn vtp_gives_the_same_back() {
    let mesh = square();
    let written = write(&mesh);
    assert_eq!(written.mended.len(), 1);
    assert!(written.mended[0].to_string().contains("\"corner\""));
    let again = vtk_xml::read_loose(&written.value, Path::new("a.vtp")).unwrap().mend();
    assert!(again.mended.is_empty(), "{:?}", again.mended);
    let again = again.value.mesh;
    assert_eq!((again.positions(), again.triangles()), (mesh.positions(), mesh.triangles()));
    assert_eq!((again.normals(), again.tangents()), (mesh.normals(), mesh.tangents()));
    assert_eq!(again.uv_sets(), mesh.uv_sets());
    let near = |a: &Vec4, b: &Vec4| (*a - *b).abs().max_element() < 1e-6;
    assert!(again.colors().iter().zip(mesh.colors()).all(|(a, b)| near(a, b)));
    assert_eq!(again.fields().len(), 3);
    for (a, b) in again.fields().iter().zip(mesh.fields()) {
        assert_eq!((&a.name, &a.unit, a.element, a.n_components), (&b.name, &b.unit, b.element, b.n_components));
        assert!(same(&a.values, &b.values), "{a:?}");
    }
}

#[test]
fn ply_keeps_every_field_and_glb_those_of_vertices() {
    let mesh = square();
    let none = |_: &str| Err(std::io::Error::from(std::io::ErrorKind::NotFound));
    let ply = ply::read_loose(&ply_write::write(&mesh), Path::new("a.ply"), &none).unwrap().mend().value.mesh;
    for b in mesh.fields() {
        let name = b.name.replace(' ', "_");
        let a = ply.fields().iter().find(|f| f.name == name).unwrap();
        assert_eq!((a.element, &a.unit), (b.element, &b.unit));
        assert!(same(&a.values, &b.values), "{a:?}");
    }
    let scene = Scene::of("a", mesh);
    let glb = gltf_in::read(&glb::write(&scene).unwrap(), Path::new("a.glb"), &none).unwrap().value.mesh;
    for b in scene.mesh.fields().iter().filter(|f| f.element == Element::Vertex && f.name == "v") {
        let a = glb.fields().iter().find(|f| f.name == b.name).unwrap();
        assert!(same(&a.values, &b.values));
    }
    assert_eq!(glb.fields().len(), 2);
}
