//! three.js' BufferGeometry as JSON, as its own exporter writes it: position, normal, uv, color, and any other attribute
//! as a field.

use crate::assets::files::{self, Loose};
use crate::assets::mend::MendOptions;
use crate::assets::numbers::index;
use crate::assets::text::{self, format_error};
use crate::assets::{Element, Field, Neighbours, RawMesh, Scene, UvSet, Values};
use crate::error::{Mended, Report, Result, note};
use crate::math::{vec2, vec3, vec4};
use serde_json::Value;
use std::path::Path;

/// Reads a BufferGeometry, or the first one of an object that holds geometries.
pub fn read(bytes: &[u8], path: &Path, _neighbours: &Neighbours) -> Result<Report<Scene>> {
    Ok(read_loose(bytes, path)?.mend())
}

/// The same before mending.
pub(super) fn read_loose(bytes: &[u8], path: &Path) -> Result<Loose> {
    let text = text::utf8(bytes);
    let root: Value = serde_json::from_slice(&text).map_err(|e| format_error(path, format!("not valid JSON: {e}")))?;
    let is_geometry = |v: &&Value| v.pointer("/data/attributes").is_some_and(Value::is_object);
    let geometries = root.get("geometries").and_then(Value::as_array);
    let mut all = std::iter::once(&root).chain(geometries.into_iter().flatten()).filter(is_geometry);
    let geometry = all.next().ok_or_else(|| {
        format_error(path, "no BufferGeometry in it (\"data.attributes\"); other kinds of JSON are not read")
    })?;
    let mut mended = Vec::new();
    note(&mut mended, all.count(), "geometries after the first passed over");
    let mesh = mesh(&geometry["data"], path, &mut mended)?;
    Ok(Loose::new(files::name_of(path), mesh, mended, MendOptions::default()))
}

/// Numbers a vertex, and all of them; a whole number that stands for 0..1 is divided.
fn attribute(name: &str, value: &Value, path: &Path) -> Result<(usize, Values)> {
    let bad = |what: &str| format_error(path, format!("data.attributes.{name}: {what}"));
    let array = value.get("array").and_then(Value::as_array).ok_or_else(|| bad("no array of numbers"))?;
    let n = value.get("itemSize").and_then(Value::as_u64).unwrap_or(1);
    let n =
        usize::try_from(n).ok().filter(|n| (1..=1000).contains(n)).ok_or_else(|| bad("itemSize is not possible"))?;
    let kind = value.get("type").and_then(Value::as_str).unwrap_or("Float32Array");
    let scale = match (value.get("normalized").and_then(Value::as_bool), kind) {
        (Some(true), "Uint8Array" | "Uint8ClampedArray") => 255.0,
        (Some(true), "Int8Array") => 127.0,
        (Some(true), "Uint16Array") => 65535.0,
        (Some(true), "Int16Array") => 32767.0,
        _ => 1.0,
    };
    // What is no number is missing: JSON has no NaN, so exporters write null.
    let numbers = array.iter().map(|x| x.as_f64().unwrap_or(f64::NAN) / scale);
    Ok((
        n,
        match kind {
            "Float64Array" | "Int32Array" | "Uint32Array" => Values::F64(numbers.collect()),
            _ => Values::F32(numbers.map(|x| x as f32).collect()),
        },
    ))
}

fn mesh(data: &Value, path: &Path, mended: &mut Vec<Mended>) -> Result<RawMesh> {
    let mut mesh = RawMesh::default();
    let none = serde_json::Map::new();
    let attributes = data["attributes"].as_object().unwrap_or(&none);
    for (name, value) in attributes {
        let (n, values) = match attribute(name, value, path) {
            Ok(attribute) => attribute,
            Err(why) if name != "position" => {
                note(mended, 1, format!("attribute not read: {why}"));
                continue;
            }
            Err(why) => return Err(why),
        };
        let x = |i: usize| values.at(i) as f32;
        let rows = || (0..values.len() / n).map(|i| i * n);
        match (name.as_str(), n) {
            ("position", 3) => mesh.positions = rows().map(|i| vec3(x(i), x(i + 1), x(i + 2))).collect(),
            ("position", _) => return Err(format_error(path, "data.attributes.position: itemSize must be 3")),
            ("normal", 3) => mesh.normals = rows().map(|i| vec3(x(i), x(i + 1), x(i + 2))).collect(),
            ("tangent", 4) => mesh.tangents = rows().map(|i| vec4(x(i), x(i + 1), x(i + 2), x(i + 3))).collect(),
            ("color", 3) => mesh.colors = rows().map(|i| vec4(x(i), x(i + 1), x(i + 2), 1.0)).collect(),
            ("color", 4) => mesh.colors = rows().map(|i| vec4(x(i), x(i + 1), x(i + 2), x(i + 3))).collect(),
            // v counts upwards there.
            ("uv" | "uv1" | "uv2" | "uv3", 2) => {
                let uv = rows().map(|i| vec2(x(i), (1.0 - values.at(i + 1)) as f32)).collect();
                mesh.uv_sets.push(UvSet { name: name.clone(), uv });
            }
            _ => mesh.fields.push(Field {
                name: name.clone(),
                unit: String::new(),
                element: Element::Vertex,
                n_components: n,
                values,
            }),
        }
    }
    if mesh.positions.is_empty() {
        return Err(format_error(path, "data.attributes.position is missing or empty"));
    }
    mesh.triangles = match data.get("index").filter(|i| !i.is_null()) {
        Some(indices) => {
            let array = indices.get("array").and_then(Value::as_array);
            let array = array.ok_or_else(|| format_error(path, "data.index.array: no array of numbers"))?;
            let corner = |x: &Value| index(x.as_f64().unwrap_or(f64::NAN));
            note(mended, array.len() % 3, "indices after the last triangle left out");
            array.chunks_exact(3).map(|t| [corner(&t[0]), corner(&t[1]), corner(&t[2])]).collect()
        }
        None => {
            note(mended, mesh.positions.len() % 3, "points after the last triangle without a face");
            (0..mesh.positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()
        }
    };
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loose(text: &str) -> Result<Loose> {
        read_loose(text.as_bytes(), Path::new("a.json"))
    }

    #[test]
    fn every_attribute_is_kept() {
        let text = r#"{"type": "BufferGeometry", "data": {"attributes": {
            "position": {"itemSize": 3, "type": "Float32Array", "array": [0,0,0, 1,0,0, 0,1,0, 1,1,0]},
            "uv": {"itemSize": 2, "type": "Float32Array", "array": [0,0, 1,0, 0,1, 1,1]},
            "color": {"itemSize": 3, "type": "Uint8Array", "normalized": true, "array": [255,0,0, 0,0,0, 0,0,0, 0,0,0]},
            "pressure": {"itemSize": 1, "type": "Float32Array", "array": [1, null, 3, 4]},
            "bad": {"itemSize": 0, "array": []}
        }, "index": {"type": "Uint16Array", "array": [0,1,2, 2,1,3, 0]}}}"#;
        let Loose { mesh, mended, .. } = loose(text).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
        assert_eq!((mesh.uv_sets[0].uv[2].y, mesh.colors[0].x), (0.0, 1.0));
        assert_eq!((mesh.fields[0].name.as_str(), mesh.fields[0].range(0).n_missing), ("pressure", 1));
        assert_eq!(mended.len(), 2);
        let text = text.replace("\"index\"", "\"other\"");
        assert_eq!(loose(&text).unwrap().mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn other_json_is_refused() {
        for text in ["", "{", "[]", "{\"asset\": {}}", r#"{"data": {"attributes": {}}}"#] {
            assert!(!loose(text).err().unwrap().to_string().contains('\n'), "{text}");
        }
    }
}
