//! Odd and broken PLY files, and files written and read back.

use super::*;
use crate::assets::{Mesh, ply_write};
use crate::math::{hash_cell, unit_float, vec3};

fn no_neighbours(_: &str) -> std::io::Result<Vec<u8>> {
    Err(std::io::ErrorKind::NotFound.into())
}

fn parse(bytes: &[u8]) -> Result<Report<Scene>> {
    read(bytes, Path::new("test.ply"), &no_neighbours)
}

fn told(report: &Report<Scene>) -> String {
    report.mended.iter().map(|m| m.to_string()).collect::<Vec<_>>().join("; ")
}

const SQUARE: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int id\nelement extra 2\nproperty list uchar \
    float v\nelement face 1\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty short \
    region\nend_header\n0 0 0 255 0 128 7\n1 0 0 0 0 0 16777217\n1 1 0 0 0 0 9\n0 1 0 255 255 255 10\n2 5 6\n0\n\
    4 0 1 2 3 8 0 0 1 0 1 1 0 1 -5\n";

#[test]
fn every_property_is_kept_under_its_name() {
    let report = parse(SQUARE.as_bytes()).unwrap();
    assert_eq!(told(&report), "");
    let mesh = &report.value.mesh;
    assert_eq!((mesh.positions().len(), mesh.triangles().len()), (4, 2));
    assert_eq!(mesh.colors()[0], vec4(1.0, 0.0, LINEAR_FROM_SRGB8[128], 1.0));
    assert_eq!(mesh.uv_sets()[0].uv[2], vec2(1.0, 0.0));
    let names: Vec<_> = mesh.fields().iter().map(|f| (f.name.as_str(), f.element)).collect();
    assert_eq!(names, [("id", Element::Vertex), ("region", Element::Face)]);
    assert_eq!(mesh.fields()[0].values.at(1), 16777217.0);
    assert_eq!(mesh.fields()[1].values, Values::F32(vec![-5.0; 2]));
    assert_eq!(mesh.source_faces(), [0, 0]);
}

#[test]
fn binary_files_of_both_orders_equal_the_text() {
    let header = |format: &str| SQUARE.split("end_header").next().unwrap().replace("ascii", format) + "end_header\n";
    let body = |little: bool| {
        let mut out = Vec::new();
        let mut put = |bytes: &[u8]| {
            if little { out.extend(bytes) } else { out.extend(bytes.iter().rev()) }
        };
        let vertices = [([0.0, 0.0], [255, 0, 128], 7), ([1.0, 0.0], [0; 3], 16777217), ([1.0, 1.0], [0; 3], 9)];
        for (p, c, id) in vertices.into_iter().chain([([0.0, 1.0], [255; 3], 10)]) {
            [p[0], p[1], 0.0f32].iter().for_each(|x| put(&x.to_le_bytes()));
            c.iter().for_each(|x: &u8| put(&[*x]));
            put(&i32::to_le_bytes(id));
        }
        put(&[2]);
        [5.0f32, 6.0].iter().for_each(|x| put(&x.to_le_bytes()));
        put(&[0]);
        put(&[4]);
        [0i32, 1, 2, 3].iter().for_each(|x| put(&x.to_le_bytes()));
        put(&[8]);
        [0f32, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0].iter().for_each(|x| put(&x.to_le_bytes()));
        put(&(-5i16).to_le_bytes());
        out
    };
    let text = parse(SQUARE.as_bytes()).unwrap().value.mesh.into_raw();
    for (format, little) in [("binary_little_endian", true), ("binary_big_endian", false)] {
        let bytes = [header(format).into_bytes(), body(little)].concat();
        let raw = parse(&bytes).unwrap().value.mesh.into_raw();
        assert_eq!(format!("{raw:?}"), format!("{text:?}"), "{format}");
    }
}

#[test]
fn odd_files_are_read_or_refused_in_one_line() {
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let square = "0 0 0\n1 0 0\n1 1 0\n";
    let faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let check = |text: String, wanted: &str| {
        let got = match parse(text.as_bytes()) {
            Ok(report) => format!("{} triangles; {}", report.value.mesh.triangles().len(), told(&report)),
            Err(error) => error.to_string(),
        };
        assert!(got.contains(wanted) && !got.contains('\n'), "{text}\n{got}\n{wanted}");
    };
    check(format!("{head}{faces}{square}3 0 1 2"), "1 triangles; ");
    check(format!("{head}{faces}{square}3 0 1 7"), "0 triangles; 1 triangles with vertices that do not exist dropped");
    check(format!("{head}{faces}{square}3 0 1 -1"), "0 triangles; 1 triangles with vertices that do not exist");
    check(format!("{head}{faces}{square}2 0 1"), "1 faces with fewer than three corners dropped");
    check(format!("{head}{faces}{square}"), "1 faces that the header claims are not in the file");
    check(format!("{head}{faces}0 0 0\n1 0 x\n1 1 0\n3 0 1 2"), "line 11: expected a number, found \"x\"");
    check(format!("{head}end_header\n{square}"), "3 points without any face");
    check(format!("{head}element vertex 3"), "the header does not end");
    check("ply\nelement vertex x".into(), "line 2: expected an element's name and number");
    check(
        "ply\nformat ascii 1.0\nelement vertex 2147483648\nproperty float x\nend_header\n0".into(),
        "claims 2147483648",
    );
    check("ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\nend_header\n0".into(), "claims 9");
    check("ply\nformat ascii 1.0\nelement vertex 0\nend_header\n".into(), "0 triangles; ");
    check("plyformat".into(), "not a PLY file");
    let strips = "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let head4 = head.replace("vertex 3", "vertex 4");
    check(format!("{head4}{strips}{square}0 1 0\n6 0 1 3 2 -1 0"), "2 triangles; ");
}

/// A mesh with everything that PLY can hold, in odd numbers.
fn rich_mesh() -> Mesh {
    let random = |i: usize, k: i32| unit_float(hash_cell(i as i32, k, 0, 9));
    let n = 30;
    let field = |name: &str, unit: &str, element, n_components, values| Field {
        name: name.into(),
        unit: unit.into(),
        element,
        n_components,
        values,
    };
    let raw = RawMesh {
        positions: (0..n).map(|i| vec3(random(i, 0), random(i, 1), random(i, 2))).collect(),
        triangles: (0..n as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        normals: (0..n).map(|i| vec3(random(i, 3) - 0.5, 1.0, random(i, 4)).normalize()).collect(),
        colors: (0..n).map(|i| vec4(random(i, 5), random(i, 6), random(i, 7), 0.5)).collect(),
        uv_sets: (0..2)
            .map(|s| UvSet {
                name: format!("uv{s}"),
                uv: (0..n).map(|i| vec2(random(i, 8 + s), random(i, 10 + s))).collect(),
            })
            .collect(),
        fields: vec![
            field("heat", "K", Element::Vertex, 1, Values::F32((0..n).map(|i| random(i, 12)).collect())),
            field("flow", "m/s", Element::Vertex, 3, Values::F64((0..3 * n).map(|i| 1.0 / (i as f64 + 1.0)).collect())),
            field("region", "", Element::Face, 1, Values::F32((0..n / 3).map(|i| i as f32).collect())),
            field("corner", "", Element::Corner, 2, Values::F32((0..2 * n).map(|i| random(i, 13)).collect())),
        ],
        ..Default::default()
    };
    raw.mend().value
}

#[test]
fn what_is_written_is_read_back_the_same() {
    let mesh = rich_mesh();
    let bytes = ply_write::write(&mesh);
    let report = parse(&bytes).unwrap();
    assert_eq!(told(&report), "");
    let again = report.value.mesh;
    assert_eq!(again.positions(), mesh.positions());
    assert_eq!(again.triangles(), mesh.triangles());
    assert_eq!(again.normals(), mesh.normals());
    assert_eq!(again.uv_sets(), mesh.uv_sets());
    assert_eq!(again.fields(), mesh.fields());
    assert_eq!(again.colors(), mesh.colors());
    assert_eq!(ply_write::write(&again), bytes);
}

#[test]
fn a_file_cut_anywhere_is_no_panic() {
    let binary = ply_write::write(&rich_mesh());
    for bytes in [SQUARE.as_bytes(), &binary] {
        for end in 0..bytes.len() {
            // Whether it is an error or a part is its own business.
            _ = parse(&bytes[..end]).map(|r| assert!(r.value.mesh.triangles().len() <= 10));
        }
    }
}
