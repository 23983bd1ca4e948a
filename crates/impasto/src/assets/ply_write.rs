//! A mesh to binary PLY: every attribute and every field, so that reading gives the same numbers back.

use crate::assets::{Element, Field, Mesh, Values};
use crate::color::{LINEAR_FROM_SRGB8, srgb_from_linear, srgb8_from_linear};
use crate::math::{Vec2, Vec4};

/// One property: its header's words, and how a row's bytes are made.
struct Column<'a> {
    header: String,
    put: Put<'a>,
}

/// Appends a row's bytes.
type Put<'a> = Box<dyn Fn(usize, &mut Vec<u8>) + 'a>;

/// The bytes of a PLY file, little-endian.
///
/// Texture coordinates and colours take the least type that gives exactly the same numbers back. A field with components is
/// parted into `name[0]`, `name[1]` ...; blanks in its name become `_`. Units are kept in comments.
pub fn write(mesh: &Mesh) -> Vec<u8> {
    let (n_vertices, n_triangles) = (mesh.positions().len(), mesh.triangles().len());
    let vertex = vertex_columns(mesh);
    let mut face = vec![Column {
        header: "list uchar uint vertex_indices".into(),
        put: Box::new(|i, out| {
            out.push(3);
            mesh.triangles()[i].iter().for_each(|v| out.extend(v.to_le_bytes()));
        }),
    }];
    face.extend(mesh.fields().iter().filter(|f| f.element == Element::Face).flat_map(field_columns));
    face.extend(mesh.fields().iter().filter(|f| f.element == Element::Corner).map(corner_column));

    let mut out = String::from("ply\nformat binary_little_endian 1.0\ncomment written by Impasto\n");
    for field in mesh.fields().iter().filter(|f| !f.unit.is_empty()) {
        out += &format!("comment unit {} {}\n", name_of(field), one_line(&field.unit));
    }
    for (name, n, columns) in [("vertex", n_vertices, &vertex), ("face", n_triangles, &face)] {
        out += &format!("element {name} {n}\n");
        columns.iter().for_each(|c| out += &format!("property {}\n", c.header));
    }
    out += "end_header\n";
    let mut out = out.into_bytes();
    for (n, columns) in [(n_vertices, vertex), (n_triangles, face)] {
        for i in 0..n {
            columns.iter().for_each(|c| (c.put)(i, &mut out));
        }
    }
    out
}

fn vertex_columns(mesh: &Mesh) -> Vec<Column<'_>> {
    let mut columns = Vec::new();
    for k in 0..3 {
        let name = ["x", "y", "z"][k];
        columns.push(float(name, move |i| mesh.positions()[i][k]));
    }
    for k in 0..3 {
        let name = ["nx", "ny", "nz"][k];
        columns.push(float(name, move |i| mesh.normals()[i][k]));
    }
    if !mesh.tangents().is_empty() {
        for k in 0..4 {
            let name = ["tx", "ty", "tz", "tw"][k];
            columns.push(float(name, move |i| mesh.tangents()[i][k]));
        }
    }
    for (set, uv) in mesh.uv_sets().iter().enumerate() {
        let suffix = if set == 0 { String::new() } else { set.to_string() };
        columns.push(float(&format!("s{suffix}"), |i| uv.uv[i].x));
        // v counts upwards in the file.
        let survives = |uv: &Vec2| 1.0 - (1.0 - uv.y) == uv.y;
        let name = format!("t{suffix}");
        columns.push(if uv.uv.iter().all(survives) {
            float(&name, |i| 1.0 - uv.uv[i].y)
        } else {
            double(&name, |i| 1.0 - uv.uv[i].y as f64)
        });
    }
    columns.extend(color_columns(mesh.colors()));
    columns.extend(mesh.fields().iter().filter(|f| f.element == Element::Vertex).flat_map(field_columns));
    columns
}

fn color_columns(colors: &[Vec4]) -> Vec<Column<'_>> {
    const NAMES: [&str; 4] = ["red", "green", "blue", "alpha"];
    let byte = |x: f32, k: usize| if k < 3 { srgb8_from_linear(x) } else { (x * 255.0).round() as u8 };
    let value = |b: u8, k: usize| if k < 3 { LINEAR_FROM_SRGB8[b as usize] } else { b as f32 / 255.0 };
    let survives = |c: &Vec4| (0..4).all(|k| value(byte(c[k], k), k) == c[k]);
    let are_bytes = colors.iter().all(survives);
    let n = if colors.is_empty() { 0 } else { 4 };
    (0..n)
        .map(|k| {
            if are_bytes {
                let put = move |i: usize, out: &mut Vec<u8>| out.push(byte(colors[i][k], k));
                Column { header: format!("uchar {}", NAMES[k]), put: Box::new(put) }
            } else {
                double(NAMES[k], move |i| {
                    let x = colors[i][k] as f64;
                    if k < 3 { srgb_from_linear(x) } else { x }
                })
            }
        })
        .collect()
}

fn float<'a>(name: &str, value: impl Fn(usize) -> f32 + 'a) -> Column<'a> {
    Column { header: format!("float {name}"), put: Box::new(move |i, out| out.extend(value(i).to_le_bytes())) }
}

fn double<'a>(name: &str, value: impl Fn(usize) -> f64 + 'a) -> Column<'a> {
    Column { header: format!("double {name}"), put: Box::new(move |i, out| out.extend(value(i).to_le_bytes())) }
}

fn name_of(field: &Field) -> String {
    let name: String = field.name.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect();
    if name.is_empty() { "unnamed".into() } else { name }
}

fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn field_columns(field: &Field) -> Vec<Column<'_>> {
    let n = field.n_components;
    (0..n)
        .map(|k| {
            let name = if n == 1 { name_of(field) } else { format!("{}[{k}]", name_of(field)) };
            match &field.values {
                Values::F32(v) => float(&name, move |i| v[i * n + k]),
                Values::F64(v) => double(&name, move |i| v[i * n + k]),
            }
        })
        .collect()
}

/// Values at corners are a list on the face.
fn corner_column(field: &Field) -> Column<'_> {
    let n = field.n_components * 3;
    let kind = match field.values {
        Values::F32(_) => "float",
        Values::F64(_) => "double",
    };
    let put = move |i: usize, out: &mut Vec<u8>| {
        out.extend((n as u32).to_le_bytes());
        match &field.values {
            Values::F32(v) => v[i * n..][..n].iter().for_each(|x| out.extend(x.to_le_bytes())),
            Values::F64(v) => v[i * n..][..n].iter().for_each(|x| out.extend(x.to_le_bytes())),
        }
    };
    Column { header: format!("list uint {kind} {}", name_of(field)), put: Box::new(put) }
}
