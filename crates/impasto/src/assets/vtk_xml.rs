//! VTK's XML files (.vtp, .vtu, .vts, .vtr, .vti): the outer surface with all arrays, all pieces joined.
//!
//! Arrays stand in the text, as numbers or as base64, or behind the text in one block, as base64 or as raw bytes; either may
//! be packed with zlib. A raw block is no XML, so the text is cut off before it.

use crate::assets::cells::{Cells, POLY_LINE, POLY_VERTEX, POLYGON, POLYHEDRON, STRIP};
use crate::assets::dataset::{Array, Dataset, Form, Places, Role};
use crate::assets::files::Loose;
use crate::assets::join::Column;
use crate::assets::numbers::{Kind, index};
use crate::assets::packed::{self, MAX_UNPACKED};
use crate::assets::text::{self, Words, format_error, number, string};
use crate::assets::{Neighbours, Scene, Values};
use crate::error::{Error, Mended, Report, Result, note};
use crate::math::{DVec3, dvec3, vec3};
use roxmltree::{Document, Node, ParsingOptions};
use std::borrow::Cow;
use std::path::Path;

/// Reads a file of VTK's XML form.
pub fn read(bytes: &[u8], path: &Path, _neighbours: &Neighbours) -> Result<Report<Scene>> {
    Ok(read_loose(bytes, path)?.mend())
}

/// The same before mending.
pub(super) fn read_loose(bytes: &[u8], path: &Path) -> Result<Loose> {
    let mut all = read_pieces(bytes, path)?;
    if let [(dataset, mended)] = &mut all[..] {
        return std::mem::take(dataset).into_loose(path, bytes.len(), std::mem::take(mended));
    }
    joined(all, path, bytes.len())
}

/// What each piece of the file holds.
pub(super) fn read_pieces(bytes: &[u8], path: &Path) -> Result<Vec<(Dataset, Vec<Mended>)>> {
    let (text, block) = split(bytes, path)?;
    let text = text::utf8(text);
    let mut text = String::from_utf8_lossy(&text);
    if block.is_some() {
        text.to_mut().push_str("</VTKFile>");
    }
    let document = parse(&text, path)?;
    let root = document.root_element();
    if root.tag_name().name() != "VTKFile" {
        let name: String = root.tag_name().name().chars().take(40).collect();
        return Err(format_error(path, format!("not a VTK file: its root is <{name}>")));
    }
    let file = File::new(root, block, path)?;
    let kind = root.attribute("type").unwrap_or_default();
    const KINDS: [&str; 5] = ["PolyData", "UnstructuredGrid", "StructuredGrid", "RectilinearGrid", "ImageData"];
    if !KINDS.contains(&kind) {
        let hint = if kind.starts_with('P') { "; it names other files: give one of them" } else { "" };
        let fault = format!("data sets of type {kind:?} are not read, but {}{hint}", KINDS.join(", "));
        return Err(format_error(path, fault));
    }
    let grid = child(root, kind).ok_or_else(|| format_error(path, format!("no <{kind}> in it")))?;
    let pieces = children(grid, "Piece").map(|piece| file.piece(grid, piece, kind)).collect::<Result<Vec<_>>>()?;
    match pieces.is_empty() {
        true => Err(format_error(path, "no <Piece> in it")),
        false => Ok(pieces),
    }
}

/// Pieces of cells become one; arrays that a piece lacks are missing there.
fn joined(all: Vec<(Dataset, Vec<Mended>)>, path: &Path, n_bytes: usize) -> Result<Loose> {
    let (mut whole, mut mended) = (None::<Dataset>, Vec::new());
    for (piece, told) in all {
        mended.extend(told);
        match &mut whole {
            None => whole = Some(piece),
            Some(whole) => {
                let is_lattice = !whole.append(piece);
                note(&mut mended, is_lattice as usize, "piece of a lattice left out: only the first is shown");
            }
        }
    }
    whole.unwrap_or_default().into_loose(path, n_bytes, mended)
}

/// An XML document; one that has a document type is read, too.
pub(super) fn parse<'a>(text: &'a str, path: &Path) -> Result<Document<'a>> {
    let options = ParsingOptions { allow_dtd: true, nodes_limit: 1 << 22, ..Default::default() };
    Document::parse_with_options(text, options).map_err(|e| format_error(path, format!("not valid XML: {e}")))
}

pub(super) fn children<'a, 'i>(of: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    of.children().filter(move |n| n.is_element() && n.tag_name().name() == name)
}

pub(super) fn child<'a, 'i>(of: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    of.children().find(|n| n.is_element() && n.tag_name().name() == name)
}

/// The text directly inside a node.
pub(super) fn text_of<'a>(node: Node<'a, '_>) -> Cow<'a, str> {
    let mut texts = node.children().filter(|n| n.is_text()).filter_map(|n| n.text());
    match (texts.next(), texts.next()) {
        (None, _) => Cow::Borrowed(""),
        (Some(one), None) => Cow::Borrowed(one),
        (Some(one), Some(two)) => Cow::Owned([one, two].into_iter().chain(texts).collect()),
    }
}

/// The block of appended data.
#[derive(Clone, Copy)]
struct Block<'a> {
    bytes: &'a [u8],
    is_base64: bool,
}

/// The text, closed where appended data begins, and the data.
fn split<'a>(bytes: &'a [u8], path: &Path) -> Result<(&'a [u8], Option<Block<'a>>)> {
    let tag = b"<AppendedData";
    let Some(at) = bytes.windows(tag.len()).position(|w| w == tag) else { return Ok((bytes, None)) };
    let bad = || format_error(path, format!("byte {at}: the appended data does not begin with an underscore"));
    let rest = &bytes[at..];
    let end = rest.iter().position(|b| *b == b'>').ok_or_else(bad)?;
    let start = rest[end..].iter().position(|b| *b == b'_').ok_or_else(bad)?;
    let attributes = String::from_utf8_lossy(&rest[..end]);
    let is_base64 = attributes.contains("base64");
    Ok((&bytes[..at], Some(Block { bytes: &rest[end + start + 1..], is_base64 })))
}

/// What holds for the whole file.
struct File<'a> {
    is_little: bool,
    header: Kind,
    is_packed: bool,
    block: Option<Block<'a>>,
    path: &'a Path,
}

impl<'a> File<'a> {
    fn new(root: Node, block: Option<Block<'a>>, path: &'a Path) -> Result<Self> {
        let is_little = root.attribute("byte_order") != Some("BigEndian");
        let header = if root.attribute("header_type") == Some("UInt64") { Kind::U64 } else { Kind::U32 };
        let is_packed = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                let other: String = other.chars().take(40).collect();
                return Err(format_error(path, format!("{other} is not read; save it with zlib or unpacked")));
            }
        };
        Ok(Self { is_little, header, is_packed, block, path })
    }

    fn error(&self, node: Node, fault: impl std::fmt::Display) -> Error {
        let name: String = node.attribute("Name").unwrap_or("").chars().take(40).collect();
        format_error(self.path, format!("array {name:?}: {fault}"))
    }

    /// All numbers of an array.
    fn array(&self, node: Node) -> Result<(Kind, Values)> {
        let kind = node.attribute("type").unwrap_or_default();
        let kind =
            kind_of(kind).ok_or_else(|| self.error(node, format_args!("values of type {kind:?} are not read")))?;
        let values = match node.attribute("format").unwrap_or("ascii") {
            "ascii" => self.words(node, kind)?,
            "binary" => {
                let text = text_of(node);
                let bytes = self.bytes(Block { bytes: text.as_bytes(), is_base64: true });
                kind.values(&bytes.map_err(|e| self.error(node, e))?, self.is_little)
            }
            "appended" => {
                let block = self.block.ok_or_else(|| self.error(node, "no appended data in the file"))?;
                let offset = node.attribute("offset").and_then(|o| o.trim().parse::<usize>().ok());
                let bytes = offset.and_then(|o| block.bytes.get(o..));
                let bytes = bytes.ok_or_else(|| self.error(node, "its offset is not in the appended data"))?;
                let bytes = self.bytes(Block { bytes, ..block });
                kind.values(&bytes.map_err(|e| self.error(node, e))?, self.is_little)
            }
            other => {
                let other: String = other.chars().take(40).collect();
                return Err(self.error(node, format_args!("format {other:?} is not known")));
            }
        };
        Ok((kind, values))
    }

    fn words(&self, node: Node, kind: Kind) -> Result<Values> {
        let mut values = kind.no_values();
        for word in Words(text_of(node).as_bytes()) {
            let found = || string(&word[..word.len().min(40)]);
            let x = number(word).ok_or_else(|| self.error(node, format_args!("{:?} is no number", found())))?;
            values.push(x);
        }
        Ok(values)
    }

    /// The array's bytes: a head that tells how many, then the bytes, or zlib streams of a block each.
    fn bytes(&self, data: Block) -> std::result::Result<Vec<u8>, String> {
        let size = self.header.size();
        let ended = || "its data ends too soon".to_string();
        let word = |bytes: &[u8], i: usize| -> usize {
            let x = bytes.get(i * size..(i + 1) * size).map_or(0.0, |b| self.header.number(b, self.is_little));
            if x < 1e15 { x as usize } else { usize::MAX }
        };
        let head = data.first(if self.is_packed { 3 * size } else { size })?;
        if head.is_empty() {
            // Nothing at all is an array of nothing.
            return Ok(Vec::new());
        }
        if !self.is_packed {
            let n = word(&head, 0);
            let mut all = data.first(n.checked_add(size).ok_or_else(ended)?)?;
            // The rest of a broken array is missing, not invented.
            if all.len() < n + size {
                return Err(ended());
            }
            return Ok(all.split_off(size));
        }
        let n_blocks = word(&head, 0);
        let n_head = n_blocks.checked_add(3).and_then(|n| n.checked_mul(size)).ok_or_else(ended)?;
        if n_blocks == 0 {
            return Ok(Vec::new());
        }
        let head = data.first(n_head)?;
        if head.len() < n_head {
            return Err(ended());
        }
        let packed_sizes: Vec<usize> = (0..n_blocks).map(|i| word(&head, 3 + i)).collect();
        let n_packed = packed_sizes.iter().fold(n_head, |n, s| n.saturating_add(*s));
        let all = data.first(n_packed)?;
        let mut rest = all.get(n_head..).unwrap_or_default();
        let mut out = Vec::new();
        for n in packed_sizes {
            let block = rest.get(..n).ok_or_else(ended)?;
            rest = &rest[n..];
            let most = MAX_UNPACKED - out.len();
            out.extend(packed::inflate(block, most)?);
        }
        Ok(out)
    }

    /// One piece of the data set.
    fn piece(&self, grid: Node, piece: Node, kind: &str) -> Result<(Dataset, Vec<Mended>)> {
        let mut mended = Vec::new();
        let form = match kind {
            "PolyData" | "UnstructuredGrid" => {
                let points = self.points(piece)?;
                let cells = if kind == "PolyData" { self.polygons(piece)? } else { self.cells(piece)? };
                Form::Cells { points, cells, keeps_points: kind == "PolyData" }
            }
            _ => self.lattice(grid, piece, kind)?,
        };
        let mut dataset = Dataset { form, ..Default::default() };
        dataset.point_arrays = self.arrays(piece, "PointData", &mut mended);
        dataset.cell_arrays = self.arrays(piece, "CellData", &mut mended);
        Ok((dataset, mended))
    }

    fn points(&self, piece: Node) -> Result<Vec<crate::math::Vec3>> {
        let Some(node) = child(piece, "Points").and_then(|p| child(p, "DataArray")) else { return Ok(Vec::new()) };
        let (_, values) = self.array(node)?;
        let x = |i: usize| values.at(i) as f32;
        Ok((0..values.len() / 3).map(|i| vec3(x(3 * i), x(3 * i + 1), x(3 * i + 2))).collect())
    }

    /// The array of that name in a part of the file; nothing when it is not there.
    fn named(&self, part: Node, name: &str) -> Result<Option<Values>> {
        let mut arrays = children(part, "DataArray").filter(|n| n.attribute("Name") == Some(name));
        arrays.next().map(|node| self.array(node).map(|(_, values)| values)).transpose()
    }

    fn polygons(&self, piece: Node) -> Result<Cells> {
        let mut cells = Cells::default();
        // Arrays count the cells in this order, whatever the file's.
        for (name, kind) in [("Verts", POLY_VERTEX), ("Lines", POLY_LINE), ("Polys", POLYGON), ("Strips", STRIP)] {
            let Some(part) = child(piece, name) else { continue };
            let (points, ends) = (self.named(part, "connectivity")?, self.named(part, "offsets")?);
            let (Some(points), Some(ends)) = (points, ends) else { continue };
            each_list(&points, &ends, |_, points| cells.push(kind, points));
        }
        Ok(cells)
    }

    fn cells(&self, piece: Node) -> Result<Cells> {
        let mut cells = Cells::default();
        let Some(part) = child(piece, "Cells") else { return Ok(cells) };
        let need = |name: &str| {
            self.named(part, name)?.ok_or_else(|| format_error(self.path, format!("<Cells> has no array {name:?}")))
        };
        let (points, ends, kinds) = (need("connectivity")?, need("offsets")?, need("types")?);
        let (faces, face_ends) = (self.named(part, "faces")?, self.named(part, "faceoffsets")?);
        let mut face_start = 0;
        each_list(&points, &ends, |i, points| {
            let kind = if i < kinds.len() { kinds.at(i) as u8 } else { 0 };
            match (&faces, &face_ends) {
                (Some(faces), Some(face_ends)) if kind == POLYHEDRON => {
                    let end = if i < face_ends.len() { index(face_ends.at(i)) as usize } else { 0 };
                    let range = if face_start <= end && end <= faces.len() { face_start..end } else { 0..0 };
                    face_start = face_start.max(range.end);
                    cells.push(kind, range.map(|k| index(faces.at(k))));
                }
                _ => cells.push(kind, points),
            }
        });
        Ok(cells)
    }

    fn lattice(&self, grid: Node, piece: Node, kind: &str) -> Result<Form> {
        let extent = piece.attribute("Extent").or(grid.attribute("WholeExtent"));
        let extent = extent.and_then(numbers::<6>);
        let e = extent.ok_or_else(|| format_error(self.path, "the piece has no extent of six numbers"))?;
        let count = |axis: usize| (e[2 * axis + 1] - e[2 * axis] + 1.0).clamp(0.0, u32::MAX as f64) as u32;
        let n = [0, 1, 2].map(count);
        let places = match kind {
            "StructuredGrid" => Places::Each(self.points(piece)?),
            "RectilinearGrid" => {
                let mut axes = [Vec::new(), Vec::new(), Vec::new()];
                let part = child(piece, "Coordinates");
                for (axis, node) in axes.iter_mut().zip(part.iter().flat_map(|p| children(*p, "DataArray"))) {
                    *axis = self.array(node)?.1.numbers().collect();
                }
                Places::Axes(axes)
            }
            _ => {
                let three = |name: &str, absent| grid.attribute(name).and_then(numbers::<3>).unwrap_or(absent);
                let d = three("Spacing", [1.0; 3]);
                let turned = grid.attribute("Direction").and_then(numbers::<9>);
                let m = turned.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
                let steps = [0, 1, 2].map(|axis| dvec3(m[axis], m[3 + axis], m[6 + axis]) * d[axis]);
                let first = dvec3(e[0], e[2], e[4]);
                let origin = DVec3::from_array(three("Origin", [0.0; 3]))
                    + steps[0] * first.x
                    + steps[1] * first.y
                    + steps[2] * first.z;
                Places::Even { origin, steps }
            }
        };
        Ok(Form::Lattice { n, places })
    }

    /// The arrays of points or cells; those that cannot be read are told of.
    fn arrays(&self, piece: Node, part: &'static str, mended: &mut Vec<Mended>) -> Vec<Array> {
        let Some(part) = child(piece, part) else { return Vec::new() };
        let is_points = part.tag_name().name() == "PointData";
        let mut arrays: Vec<Array> = Vec::new();
        for node in children(part, "DataArray") {
            let name = node.attribute("Name").unwrap_or("unnamed").to_string();
            // Later ones of a name are other times, or as good as hidden.
            if arrays.iter().any(|a| a.column.name == name) {
                continue;
            }
            let (kind, values) = match self.array(node) {
                Ok(array) => array,
                Err(why) => {
                    note(mended, 1, format!("array not read: {why}"));
                    continue;
                }
            };
            let n_components = node.attribute("NumberOfComponents").and_then(|n| n.trim().parse().ok());
            let n_components = n_components.filter(|n| (1..=1000).contains(n)).unwrap_or(1);
            let is_named = |key: &str| part.attribute(key) == Some(&name);
            let role = match n_components {
                _ if !is_points => Role::Data,
                3 if is_named("Normals") => Role::Normals,
                4 if is_named("Tangents") => Role::Tangents,
                2 if is_named("TCoords") => Role::TextureCoordinates,
                n => Role::of(&name, kind, n),
            };
            let key = children(node, "InformationKey").find(|k| k.attribute("name") == Some("UNITS_LABEL"));
            let unit = key.map(|k| text_of(k).trim().to_string()).unwrap_or_default();
            arrays.push(Array { column: Column { n_components, unit, ..Column::of(name, values) }, role });
        }
        arrays
    }
}

impl Block<'_> {
    /// The first `n` bytes, or as many as there are.
    fn first(&self, n: usize) -> std::result::Result<Vec<u8>, String> {
        match self.is_base64 {
            true => packed::base64(self.bytes, n),
            false => Ok(self.bytes[..n.min(self.bytes.len())].to_vec()),
        }
    }
}

fn kind_of(name: &str) -> Option<Kind> {
    Some(match name {
        "Int8" => Kind::I8,
        "UInt8" => Kind::U8,
        "Int16" => Kind::I16,
        "UInt16" => Kind::U16,
        "Int32" => Kind::I32,
        "UInt32" => Kind::U32,
        "Int64" => Kind::I64,
        "UInt64" => Kind::U64,
        "Float32" => Kind::F32,
        "Float64" => Kind::F64,
        _ => return None,
    })
}

/// N numbers of an attribute.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = Words(text.as_bytes()).map(number).collect();
    numbers?.try_into().ok()
}

/// Gives each list of points and its number; a broken end gives a list of nothing.
fn each_list(points: &Values, ends: &Values, mut give: impl FnMut(usize, &mut dyn Iterator<Item = u32>)) {
    let mut start = 0;
    for i in 0..ends.len() {
        let end = index(ends.at(i)) as usize;
        let range = if start <= end && end <= points.len() { start..end } else { start..start };
        start = range.end;
        give(i, &mut range.map(|k| index(points.at(k))));
    }
}

#[cfg(test)]
#[path = "vtk_xml_tests.rs"]
mod tests;
