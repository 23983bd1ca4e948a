//! GIfTI (.gii), geometry and data of cortical surfaces (Harwell, Bremen, Coulon et al., version 1.0, 2011).
//!
//! A point set with its triangles is a mesh; every other array is a column: shape, labels, time series, vectors. Points are
//! in the array's own space (x right, y forward, z up), in millimetres; matrices to other spaces are not applied.

use crate::assets::files::{self, Loose};
use crate::assets::join::{Column, Columns, Label};
use crate::assets::mend::MendOptions;
use crate::assets::numbers::{Kind, index};
use crate::assets::packed::{self, MAX_UNPACKED};
use crate::assets::text::{self, Words, format_error, number};
use crate::assets::vtk_xml::{child, children, parse, text_of};
use crate::assets::{Element, Field, Neighbours, RawMesh, Scene, Values};
use crate::color;
use crate::error::{Error, Mended, Report, Result, note};
use crate::math::vec3;
use roxmltree::Node;
use std::path::Path;

/// Reads the surface of a GIfTI file, with the data that it holds.
pub fn read(bytes: &[u8], path: &Path, _neighbours: &Neighbours) -> Result<Report<Scene>> {
    Ok(read_loose(bytes, path)?.mend())
}

/// The same before mending.
pub(super) fn read_loose(bytes: &[u8], path: &Path) -> Result<Loose> {
    let Content { points, triangles, columns, mended } = content(bytes, path)?;
    let (Some(points), Some(triangles)) = (points, triangles) else {
        let names: Vec<String> = columns.iter().take(8).map(|c| format!("{:?}", c.name)).collect();
        let fault = match names.is_empty() {
            true => "there is no surface in it".to_string(),
            false => format!("there is no surface in it, but data for one: {}; join it to a surface", names.join(", ")),
        };
        return Err(format_error(path, fault));
    };
    let mut mesh = RawMesh::default();
    let x = |i: usize| points.at(i) as f32;
    mesh.positions = (0..points.len() / 3).map(|i| vec3(x(3 * i), x(3 * i + 1), x(3 * i + 2))).collect();
    let corner = |i: usize| index(triangles.at(i));
    mesh.triangles = (0..triangles.len() / 3).map(|i| [corner(3 * i), corner(3 * i + 1), corner(3 * i + 2)]).collect();
    for c in columns {
        let element = match c.n_rows() {
            n if n == mesh.positions.len() => Element::Vertex,
            n if n == mesh.triangles.len() => Element::Face,
            // What has another length is dropped and told of with the rest.
            _ => Element::Vertex,
        };
        let (name, unit, n_components, values) = (c.name, c.unit, c.n_components, c.values);
        mesh.fields.push(Field { name, unit, element, n_components, values });
    }
    Ok(Loose::new(files::name_of(path), mesh, mended, MendOptions::default()))
}

/// Reads the data of a GIfTI file: shapes, labels, time series.
pub(super) fn read_columns(bytes: &[u8], path: &Path) -> Result<Report<Columns>> {
    let Content { columns, mended, .. } = content(bytes, path)?;
    Ok(Report { value: Columns { path: path.into(), columns, has_names: true }, mended })
}

/// What is in a file.
#[derive(Default)]
struct Content {
    points: Option<Values>,
    triangles: Option<Values>,
    columns: Vec<Column>,
    mended: Vec<Mended>,
}

fn content(bytes: &[u8], path: &Path) -> Result<Content> {
    let text = text::utf8(bytes);
    let text = String::from_utf8_lossy(&text);
    let document = parse(&text, path)?;
    let root = document.root_element();
    if root.tag_name().name() != "GIFTI" {
        return Err(format_error(path, "not a GIfTI file: its root is not <GIFTI>"));
    }
    let labels = child(root, "LabelTable").map(labels).unwrap_or_default();
    let mut out = Content::default();
    for (i, node) in children(root, "DataArray").enumerate() {
        let intent = node.attribute("Intent").unwrap_or_default();
        let intent = intent.strip_prefix("NIFTI_INTENT_").unwrap_or(intent);
        let array = DataArray { node, path, number: i + 1 };
        let geometry = matches!(intent, "POINTSET" | "TRIANGLE");
        let (n_components, values) = match array.values() {
            Ok(array) => array,
            Err(why) if !geometry => {
                note(&mut out.mended, 1, format!("array not read: {why}"));
                continue;
            }
            Err(why) => return Err(why),
        };
        match intent {
            _ if geometry && n_components != 3 => {
                return Err(array.error(format_args!("{n_components} numbers in a row, where three are needed")));
            }
            "POINTSET" if out.points.is_none() => out.points = Some(values),
            "TRIANGLE" if out.triangles.is_none() => out.triangles = Some(values),
            "POINTSET" | "TRIANGLE" => note(&mut out.mended, 1, "surface after the first passed over"),
            _ => {
                let name = array.name(intent, &out.columns);
                let labels = if intent == "LABEL" { labels.clone() } else { Vec::new() };
                out.columns.push(Column { n_components, labels, ..Column::of(name, values) });
            }
        }
    }
    Ok(out)
}

/// Keys, names, colours; display values in the file.
fn labels(table: Node) -> Vec<Label> {
    let label = |node: Node| {
        let key = node.attribute("Key").or(node.attribute("Index"))?.trim().parse().ok()?;
        let part = |name: &str, absent: f64| {
            node.attribute(name).and_then(|x| number(x.trim().as_bytes())).filter(|x| x.is_finite()).unwrap_or(absent)
        };
        let light = |name: &str| color::linear_from_srgb(part(name, 0.0)) as f32;
        let color = [light("Red"), light("Green"), light("Blue"), part("Alpha", 1.0) as f32];
        Some(Label { key, name: text_of(node).trim().to_string(), color })
    };
    children(table, "Label").filter_map(label).collect()
}

/// One array in the file.
struct DataArray<'a, 'i> {
    node: Node<'a, 'i>,
    path: &'a Path,
    /// Counted from 1.
    number: usize,
}

impl DataArray<'_, '_> {
    fn error(&self, fault: impl std::fmt::Display) -> Error {
        format_error(self.path, format!("array {}: {fault}", self.number))
    }

    fn attribute(&self, name: &str) -> &str {
        self.node.attribute(name).unwrap_or_default()
    }

    /// What the array's own data call it, or what it is for; a second of a name gets a number.
    fn name(&self, intent: &str, others: &[Column]) -> String {
        let own = child(self.node, "MetaData").and_then(|meta| {
            let named = |md: &Node| child(*md, "Name").is_some_and(|n| text_of(n).trim() == "Name");
            let value = children(meta, "MD").find(named).and_then(|md| child(md, "Value"))?;
            Some(text_of(value).trim().to_string()).filter(|n| !n.is_empty())
        });
        let stem = || {
            let name = files::name_of(self.path);
            name.split('.').next().unwrap_or_default().to_string()
        };
        let base = own.unwrap_or_else(|| match intent {
            "" | "NONE" => stem(),
            intent => intent.to_lowercase().replace('_', " "),
        });
        let is_free = |name: &str| others.iter().all(|c| c.name != name);
        match is_free(&base) {
            true => base,
            false => format!("{base} {}", self.number),
        }
    }

    /// Numbers a row, and all of them, row after row.
    fn values(&self) -> Result<(usize, Values)> {
        let kind = match self.attribute("DataType") {
            "NIFTI_TYPE_UINT8" => Kind::U8,
            "NIFTI_TYPE_INT8" => Kind::I8,
            "NIFTI_TYPE_INT16" => Kind::I16,
            "NIFTI_TYPE_UINT16" => Kind::U16,
            "NIFTI_TYPE_INT32" => Kind::I32,
            "NIFTI_TYPE_UINT32" => Kind::U32,
            "NIFTI_TYPE_INT64" => Kind::I64,
            "NIFTI_TYPE_UINT64" => Kind::U64,
            "NIFTI_TYPE_FLOAT32" => Kind::F32,
            "NIFTI_TYPE_FLOAT64" => Kind::F64,
            other => {
                let other: String = other.chars().take(40).collect();
                return Err(self.error(format_args!("numbers of type {other:?} are not read")));
            }
        };
        let n_axes: usize = self.attribute("Dimensionality").trim().parse().unwrap_or(1);
        let axis = |i: usize| self.attribute(&format!("Dim{i}")).trim().parse::<usize>().ok();
        let lengths: Option<Vec<usize>> = (0..n_axes.clamp(1, 6)).map(axis).collect();
        let lengths = lengths.ok_or_else(|| self.error("its dimensions are no numbers"))?;
        let n = lengths.iter().try_fold(1usize, |n, l| n.checked_mul(*l));
        let n = n.filter(|n| n.checked_mul(8).is_some_and(|size| size <= MAX_UNPACKED));
        let n = n.ok_or_else(|| self.error(format_args!("dimensions {lengths:?} are too large")))?;
        let values = self.data(kind, n)?;
        if values.len() < n {
            return Err(self.error(format_args!("{n} numbers are claimed, {} are there", values.len())));
        }
        let rows = lengths[0];
        let n_components = n.checked_div(rows).unwrap_or(1).max(1);
        let is_by_columns = self.attribute("ArrayIndexingOrder") == "ColumnMajorOrder";
        match is_by_columns && n_components > 1 {
            true => Ok((n_components, transposed(&values, rows, n_components))),
            false => Ok((n_components, values)),
        }
    }

    /// The first `n` numbers of the data.
    fn data(&self, kind: Kind, n: usize) -> Result<Values> {
        let data = child(self.node, "Data").map(text_of).unwrap_or_default();
        let size = n * kind.size();
        let encoding = self.attribute("Encoding");
        let unpacked = match encoding {
            "ASCII" => {
                let mut values = kind.no_values();
                for word in Words(data.as_bytes()).take(n) {
                    values.push(number(word).ok_or_else(|| self.error("a word is no number"))?);
                }
                return Ok(values);
            }
            "Base64Binary" => packed::base64(data.as_bytes(), size),
            // Its name notwithstanding, it is a zlib stream.
            "GZipBase64Binary" => {
                packed::base64(data.as_bytes(), usize::MAX).and_then(|packed| match packed.get(..2) {
                    Some([0x1f, 0x8b]) => packed::gunzip(&packed, size),
                    _ => packed::inflate(&packed, size),
                })
            }
            "ExternalFileBinary" => {
                let name: String = self.attribute("ExternalFileName").chars().take(80).collect();
                return Err(self.error(format_args!("its numbers are in another file, {name:?}, which is not read")));
            }
            other => {
                let other: String = other.chars().take(40).collect();
                return Err(self.error(format_args!("encoding {other:?} is not known")));
            }
        };
        let bytes = unpacked.map_err(|e| self.error(e))?;
        Ok(kind.values(&bytes, self.attribute("Endian") != "BigEndian"))
    }
}

/// Numbers column after column, put row after row.
fn transposed(values: &Values, rows: usize, columns: usize) -> Values {
    let at = |i: usize| values.at(i % columns * rows + i / columns);
    match values {
        Values::F32(_) => Values::F32((0..rows * columns).map(|i| at(i) as f32).collect()),
        Values::F64(_) => Values::F64((0..rows * columns).map(at).collect()),
    }
}

#[cfg(test)]
#[path = "gifti_tests.rs"]
mod tests;
