//! Small files and broken ones.

use super::*;
use crate::assets::{Element, Mesh, broken};

fn loose(bytes: &[u8]) -> Result<Loose> {
    read_loose(bytes, Path::new("a.vtk"))
}

fn mesh(bytes: &[u8]) -> (Mesh, String) {
    let report = loose(bytes).unwrap().mend();
    let told: Vec<String> = report.mended.iter().map(|m| m.to_string()).collect();
    (report.value.mesh, told.join("; "))
}

/// Two boxes, a quad on one of them, a line.
const BOXES: &str = "# vtk DataFile Version 3.0\nboxes\nASCII\nDATASET UNSTRUCTURED_GRID
FIELD FieldData 1\nTIME 1 1 double\n0.5
POINTS 12 float
0 0 0 1 0 0 2 0 0  0 1 0 1 1 0 2 1 0
0 0 1 1 0 1 2 0 1  0 1 1 1 1 1 2 1 1
CELLS 3 21
8 0 1 4 3 6 7 10 9
8 1 2 5 4 7 8 11 10
2 0 1
CELL_TYPES 3 12 12 3
CELL_DATA 3
SCALARS a%20b int 1
LOOKUP_TABLE t
4 5 6
LOOKUP_TABLE t 2
0 0 0 1 1 1 1 1
POINT_DATA 12
VECTORS v double
0 0 0 0 0 1 0 0 2 0 0 3 0 0 4 0 0 5 0 0 6 0 0 7 0 0 8 0 0 9 0 0 10 0 0 11
METADATA
INFORMATION 1
NAME UNITS_LABEL LOCATION vtkDataArray
DATA m/s

TEXTURE_COORDINATES uv 2 float
0 0 1 0 1 1 0 1 0 0 1 0 1 1 0 1 0 0 0.25 0.25 0 1 0 0
FIELD FieldData 3
one 1 12 float 1 2 3 4 5 6 7 8 9 10 11 nan
names 1 2 string
first one
second

other 1 2 float 0 0
";

#[test]
fn volumes_are_seen_from_outside() {
    let (mesh, told) = mesh(BOXES.as_bytes());
    assert_eq!(mesh.triangles().len(), 20);
    assert_eq!(told, "1 cells that are points or lines passed over");
    assert_eq!((mesh.n_source_points(), mesh.n_source_faces()), (12, 3));
    let names: Vec<_> = mesh.fields().iter().map(|f| (f.name.as_str(), f.element, f.n_components)).collect();
    let wanted = [("v", Element::Vertex, 3), ("one", Element::Vertex, 1), ("a b", Element::Face, 1)];
    assert_eq!(names, wanted);
    assert_eq!(mesh.fields()[0].unit, "m/s");
    assert_eq!(
        mesh.fields()[1].range(0).n_missing,
        mesh.positions().iter().filter(|p| **p == vec3(2.0, 1.0, 1.0)).count()
    );
    for (t, source) in mesh.source_faces().iter().enumerate() {
        assert_eq!(mesh.fields()[2].values.at(t), 4.0 + *source as f64);
    }
    assert!(mesh.uv_sets()[0].uv.iter().any(|uv| uv.to_array() == [0.25, 0.75]));
}

/// The numbers of a text as big-endian f32 or i32.
fn floats(text: &str) -> Vec<u8> {
    text.split_whitespace().flat_map(|w| w.parse::<f32>().unwrap().to_be_bytes()).collect()
}
fn ints(numbers: &[i32]) -> Vec<u8> {
    numbers.iter().flat_map(|i| i.to_be_bytes()).collect()
}
fn longs(numbers: &[i64]) -> Vec<u8> {
    numbers.iter().flat_map(|i| i.to_be_bytes()).collect()
}

/// A square of two triangles and a strip, binary, in either form of cell lists.
fn square(is_new: bool) -> Vec<u8> {
    let mut b = b"# vtk DataFile Version 5.1\n\nBINARY\nDATASET POLYDATA\nPOINTS 4 float\n".to_vec();
    b.extend(floats("0 0 0  1 0 0  0 1 0  1 1 0"));
    if is_new {
        b.extend(b"\nPOLYGONS 2 4\nOFFSETS vtktypeint64\n");
        b.extend(longs(&[0, 4]));
        b.extend(b"\nCONNECTIVITY vtktypeint64\n");
        b.extend(longs(&[0, 1, 3, 2]));
    } else {
        b.extend(b"\nPOLYGONS 1 5\n");
        b.extend(ints(&[4, 0, 1, 3, 2]));
    }
    b.extend(b"\nMETADATA\nINFORMATION 0\n\nCELL_DATA 1\nSCALARS s short\nLOOKUP_TABLE default\n");
    // The first byte is a line's end.
    b.extend([10, 1]);
    b.extend(b"\nPOINT_DATA 4\nCOLOR_SCALARS c 3\n");
    b.extend([255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255]);
    b.extend(b"\nFIELD FieldData 2\nt 1 2 string\n");
    b.extend([0xc1, b'x', 0xc0]);
    b.extend(b"\nq 1 4 float\n");
    b.extend(floats("1 2 3 4"));
    b.extend(b"\n");
    b
}

#[test]
fn binary_files_give_the_same_in_either_form() {
    for is_new in [false, true] {
        let (mesh, told) = mesh(&square(is_new));
        assert_eq!((mesh.triangles(), told.as_str()), (&[[0, 1, 3], [0, 3, 2]][..], ""));
        assert_eq!(mesh.fields()[1].values, Values::F32(vec![2561.0; 2]));
        assert_eq!(mesh.fields()[0].values, Values::F32(vec![1.0, 2.0, 3.0, 4.0]));
        assert_eq!(mesh.colors()[1].to_array(), [0.0, 1.0, 0.0, 1.0]);
    }
}

#[test]
fn lattices_are_seen_from_outside() {
    let head = "# vtk DataFile Version 2.0\nt\nASCII\nDATASET ";
    for (text, n, high) in [
        ("STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 1 0 0\nSPACING 2 1 1\n", 20, 5.0),
        (
            "RECTILINEAR_GRID\nDIMENSIONS 3 2 1\nX_COORDINATES 3 float 0 1 5\nY_COORDINATES 2 float 0 1\nZ_COORDINATES 1 int 0\n",
            4,
            5.0,
        ),
        ("STRUCTURED_GRID\nDIMENSIONS 2 2 1\nPOINTS 4 int 0 0 0 5 0 0 0 1 0 1 1 0\n", 2, 5.0),
    ] {
        let (mesh, told) = mesh(format!("{head}{text}").as_bytes());
        assert_eq!((mesh.triangles().len(), mesh.bounds().max.x, told.as_str()), (n, high, ""), "{text}");
    }
}

#[test]
fn faults_are_told_with_their_place() {
    for (from, to, wanted) in [
        ("# vtk", "# nothing", "does not begin with"),
        ("ASCII", "TEXT", "line 3: expected ASCII or BINARY, found \"TEXT\""),
        ("UNSTRUCTURED_GRID", "BLOB", "expected one of POLYDATA"),
        ("POINTS 12", "POINTS 1200000", "line 8: 3600000 values do not fit"),
        ("POINTS 12", "POINTS -1", "line 8: expected a number of points, found \"-1\""),
        ("2 1 1\nCELLS", "2 1 x\nCELLS", "line 10: expected a number, found \"x\""),
        ("CELL_TYPES 3 12 12 3\n", "", "no CELL_TYPES"),
    ] {
        let error = loose(BOXES.replace(from, to).as_bytes()).err().unwrap().to_string();
        assert!(error.contains(wanted), "{error}");
    }
    // With a surface, what is wrong with arrays is told, no more.
    let (with, told) = mesh(BOXES.replace("VECTORS v double\n0", "VECTORS v double\nx").as_bytes());
    assert!(with.triangles().len() == 20 && told.contains("array and all after it not read"), "{told}");
    let (with, told) = mesh(BOXES.replace("8 1 2 5 4 7 8 11 10", "8 1 2 5 4 7 8 11 99").as_bytes());
    assert!(!with.triangles().is_empty() && !told.is_empty());
}

#[test]
fn broken_files_give_an_error_or_a_mesh() {
    for bytes in [BOXES.as_bytes(), &square(false), &square(true)] {
        broken::check(bytes, 400, |b| Ok(loose(b)?.mend().map(|s| s.mesh)));
    }
}
