//! Small files and broken ones.

use super::*;
use crate::assets::broken;
use crate::math::vec3;

/// Three of a file's five points, one of its two faces.
fn mesh() -> Mesh {
    let values = Values::F32(vec![10.0, 30.0, 40.0]);
    let raw = RawMesh {
        positions: vec![vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)],
        triangles: vec![[0, 1, 2]],
        fields: vec![Field {
            name: "no".into(),
            unit: String::new(),
            element: Element::Vertex,
            n_components: 1,
            values,
        }],
        source_points: vec![0, 2, 4],
        source_faces: vec![1],
        n_source_points: 5,
        n_source_faces: 2,
        ..Default::default()
    };
    raw.mend().value
}

fn table(text: &str) -> Columns {
    read_bytes(text.as_bytes(), Path::new("t.csv"), Path::new("t.csv")).unwrap().value
}

/// The numbers of a field of the mesh after joining.
fn joined(text: &str, options: JoinOptions, name: &str) -> (Vec<f64>, String) {
    let mut mesh = mesh();
    let mended = table(text).join(&mut mesh, &options).unwrap();
    let told: Vec<String> = mended.iter().map(|m| m.to_string()).collect();
    let field = mesh.fields().iter().find(|f| f.name == name).unwrap();
    (field.values.numbers().collect(), told.join("; "))
}

fn column(name: &str) -> JoinOptions {
    JoinOptions { column: Some(name.into()), ..Default::default() }
}

#[test]
fn rows_are_those_of_the_file() {
    assert_eq!(joined("x\n1\n2\n3\n4\n5", column("X"), "x").0, [1.0, 3.0, 5.0]);
    assert_eq!(joined("x,y\n1,7\n2,8", JoinOptions::default(), "y").0, [8.0]);
    let half = JoinOptions { rows: Some(5..10), ..column("own name") };
    assert_eq!(joined("0\n1\n2\n3\n4\n5\n6\n7\n8\n9", half, "own name").0, [5.0, 7.0, 9.0]);
    let (values, told) = joined("no\n1\n2\n3\n4\n5", JoinOptions::default(), "no");
    assert_eq!((values, told.as_str()), (vec![1.0, 3.0, 5.0], "1 field \"no\" of the mesh replaced"));
}

#[test]
fn ids_are_points_or_the_values_of_a_field() {
    let by = |id: &str| JoinOptions { id: Some(id.into()), ..column("x") };
    let (values, told) = joined("id,x\n4,1\n0,2\n9,3\n0,4", by("id"), "x");
    assert!(values[1].is_nan() && [values[0], values[2]] == [2.0, 1.0]);
    assert_eq!(told.matches("1 ").count(), 3, "{told}");
    assert_eq!(joined("no,x\n40,1\n30,2\n10,3", by("no"), "x").0, [3.0, 2.0, 1.0]);
    let faces = JoinOptions { element: Some(Element::Face), ..by("id") };
    assert_eq!(joined("id,x\n1,6\n0,5", faces, "x").0, [6.0]);
}

#[test]
fn what_does_not_fit_is_told_with_what_there_is() {
    let fault = |text: &str, options: JoinOptions| table(text).join(&mut mesh(), &options).unwrap_err().to_string();
    let rows = |n: usize| (0..n).map(|i| i.to_string()).collect::<Vec<_>>().join("\n");
    for (error, wanted) in [
        (fault(&rows(10), column("x")), "10 rows, but the mesh's file has 5 points and 2 faces; if it is one table"),
        (fault(&rows(10), column("x")), "rows=0..5 or rows=5..10"),
        (fault("a,b\n1,2", column("x")), "no column \"x\" in it; it has 2 columns \"a\", \"b\""),
        (fault(&rows(3), JoinOptions { rows: Some(1..9), ..column("x") }), "rows 1..9 are not in"),
        (
            fault("id,x\n7,1", JoinOptions { id: Some("id".into()), ..column("x") }),
            "is that of one of the mesh's vertices",
        ),
    ] {
        assert!(error.contains(wanted) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn arrays_and_meshes_are_columns() {
    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    let head = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
    npy.extend((head.len() as u16).to_le_bytes());
    npy.extend(head.bytes());
    npy.extend((0..6).flat_map(|i| (i as f32).to_le_bytes()));
    let of = |bytes: &[u8], name: &str| read_bytes(bytes, Path::new(name), Path::new(name)).unwrap().value;
    let columns = of(&npy, "a.npy");
    assert_eq!((columns.columns[0].n_rows(), columns.columns[0].n_components), (2, 3));
    assert_eq!(columns.columns[0].name, "a");
    let ply =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float q\nelement face 1
property list uchar int vertex_indices\nproperty float f\nend_header\n0 0 1\n1 0 2\n0 1 3\n3 0 1 2 9\n";
    let names: Vec<(String, usize)> =
        of(ply.as_bytes(), "a.ply").columns.iter().map(|c| (c.name.clone(), c.n_rows())).collect();
    assert_eq!(names, [("q".to_string(), 3), ("f".to_string(), 1)]);
    assert!(read_bytes(b"what", Path::new("a.xyz"), Path::new("a.xyz")).is_err());
}

#[test]
fn labels_bring_their_colours() {
    let label = |key, color| Label { key, name: String::new(), color };
    let labels = vec![label(1, [1.0, 0.0, 0.0, 1.0])];
    let column = Column { labels, ..Column::of("l", Values::F32(vec![1.0, 0.0])) };
    let columns = Columns { path: "a".into(), columns: vec![column], has_names: true };
    let mut mesh = mesh();
    columns.join(&mut mesh, &JoinOptions { rows: None, ..Default::default() }).unwrap();
    let color = mesh.fields().iter().find(|f| f.name == "l.color").unwrap();
    assert!(color.n_components == 4 && color.values.at(0).is_nan());
}

#[test]
fn broken_tables_give_an_error_or_columns() {
    let text = "id,x,\"y z\"\n0,1,2\n1,3,NA\n2,4,5\n3,6,7\n4,8,9\n";
    broken::check(text.as_bytes(), 500, |b| {
        let columns = read_bytes(b, Path::new("t.csv"), Path::new("t.csv"))?;
        let mut mesh = mesh();
        let mended = columns.value.join(&mut mesh, &JoinOptions::default())?;
        Ok(Report { value: mesh, mended })
    });
}
