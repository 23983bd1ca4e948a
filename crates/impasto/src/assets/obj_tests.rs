//! Odd and broken OBJ files, and files written and read back.

use super::*;
use crate::assets::obj_write;

fn no_neighbours(_: &str) -> std::io::Result<Vec<u8>> {
    Err(std::io::ErrorKind::NotFound.into())
}

fn parse(text: &[u8]) -> Result<Report<Scene>> {
    read(text, Path::new("test.obj"), &no_neighbours)
}

fn told(report: &Report<Scene>) -> String {
    report.mended.iter().map(|m| m.to_string()).collect::<Vec<_>>().join("; ")
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n";

#[test]
fn odd_files_are_read_or_refused_in_one_line() {
    let check = |text: &str, wanted: &str| {
        let got = match parse(text.as_bytes()) {
            Ok(report) => format!("{} triangles; {}", report.value.mesh.triangles().len(), told(&report)),
            Err(error) => error.to_string(),
        };
        assert!(got.contains(wanted) && !got.contains('\n'), "{text}\n{got}\n{wanted}");
    };
    check(&format!("{SQUARE}f 1 2 3 4"), "2 triangles; ");
    check(&format!("{SQUARE}f -4/-4/-1 -3/-3/-1 -2/-2/-1"), "1 triangles; ");
    check(&format!("{SQUARE}f 1 \\\n2 \\\r\n3"), "1 triangles; ");
    check(&format!("{SQUARE}f 1 2 3").replace('\n', "\r"), "1 triangles; ");
    check(&format!("{SQUARE}f 1 2 9"), "1 faces with points that do not exist dropped (first in line 10)");
    check(&format!("{SQUARE}f 0 1 2"), "1 faces with points that do not exist");
    check(&format!("{SQUARE}f 1 2"), "1 faces with fewer than three corners");
    check(&format!("{SQUARE}f 1 2 x"), "line 10: expected corners like 1, 1/2, 1//3 or 1/2/3, found \"x\"");
    check(&format!("{SQUARE}f 1/9/9 2//7 3\nl 1 2\n"), "1 triangles; 1 lines and points passed over");
    check("v 1 2\n", "line 1: expected 3 numbers, found \"v 1 2\"");
    check("v 1 2 3.1+e2\n", "1 numbers with a tail that is none");
    check("mtllib a.mtl\nusemtl x\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "1 material library \"a.mtl\" not read");
    check(" \n", "the file is empty");
    check("# only words\n", "no OBJ statement");
}

#[test]
fn corners_become_vertices_and_groups_parts() {
    let text = format!("{SQUARE}g a\nf 1/1/1 2/2/1 3/3/1\ng b\nf 1/2/1 3/3/1 4/4/1");
    let mesh = parse(text.as_bytes()).unwrap().value.mesh;
    // The first point has two texture coordinates.
    assert_eq!(mesh.positions().len(), 5);
    assert_eq!(mesh.source_points(), [0, 1, 2, 3, 0]);
    assert_eq!(mesh.uv_sets()[0].uv[4], vec2(1.0, 1.0));
    let parts: Vec<_> = mesh.parts().iter().map(|p| (p.name.as_str(), p.triangles.clone())).collect();
    assert_eq!(parts, [("a", 0..1), ("b", 1..2)]);
}

#[test]
fn colours_after_positions_are_display_values() {
    let mesh = parse(b"v 0 0 0 1 0.5 0\nv 1 0 0 0 0 0\nv 0 1 0 1 1 1\nf 1 2 3").unwrap().value.mesh;
    assert_eq!(mesh.colors()[0], Vec4::new(1.0, crate::color::linear_from_srgb(0.5) as f32, 0.0, 1.0));
}

#[test]
fn smoothing_groups_decide_on_creases() {
    let roof = "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 1\nv 1 0 2\nv 0 0 2\n";
    let n = |groups: [&str; 2]| {
        let text = format!("{roof}{}\nf 1 2 3 4\n{}\nf 4 3 5 6", groups[0], groups[1]);
        parse(text.as_bytes()).unwrap().value.mesh.positions().len()
    };
    assert_eq!(n(["", ""]), 8, "a right angle is a crease");
    assert_eq!(n(["s 1", "s 1"]), 6);
    assert_eq!(n(["s 1", "s 2"]), 8);
    assert_eq!(n(["s off", ""]), 12, "flat: each of four triangles has its own corners");
}

#[test]
fn what_is_written_is_read_back_the_same() {
    let text = format!("{SQUARE}g part one\nf 1/1/1 2/2/1 3/3/1\ng b\nf 1/2/1 3/3/1 4/4/1").replace("0 0 0", "0 0 0.1");
    let scene = parse(text.as_bytes()).unwrap().value;
    let written = obj_write::mesh(&scene.mesh, &[], None);
    let again = parse(written.as_bytes()).unwrap().value.mesh;
    assert_eq!(again.positions(), scene.mesh.positions());
    assert_eq!(again.triangles(), scene.mesh.triangles());
    assert_eq!(again.normals(), scene.mesh.normals());
    assert_eq!(again.uv_sets(), scene.mesh.uv_sets());
    assert_eq!(again.parts(), scene.mesh.parts());
}

#[test]
fn a_file_cut_anywhere_is_no_panic() {
    let text = format!("{SQUARE}mtllib a b.mtl\nusemtl c\ns 1\nf 1/1/1 2/2/1 3/3/1 4/4\n");
    for end in 0..text.len() {
        _ = parse(&text.as_bytes()[..end]).map(|r| assert!(r.value.mesh.triangles().len() <= 2));
    }
}
