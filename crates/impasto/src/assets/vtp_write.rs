//! A mesh to VTK's XML form of surfaces (.vtp), for ParaView and its kin: every attribute, every field of vertices and faces.
//!
//! Numbers stand in one raw block behind the text, little-endian. Fields at corners have no place in the format.

use crate::assets::{Element, Field, Mesh, Values};
use crate::color::{srgb_from_linear, srgb8_from_linear};
use crate::error::{Mended, Report, note};
use std::fmt::Write;

/// The bytes of a VTP file, and what could not be kept.
///
/// The first UV set is VTK's texture coordinates. Colours become display values: bytes where those give the same back, else
/// doubles. Units are kept where VTK keeps them (`UNITS_LABEL`).
pub fn write(mesh: &Mesh) -> Report<Vec<u8>> {
    let mut out = Output { text: String::new(), block: Vec::new() };
    let (n_points, n_faces) = (mesh.positions().len(), mesh.triangles().len());
    let _ = write!(
        out.text,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"{n_points}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"{n_faces}\">\n"
    );
    let uv_names: Vec<String> = (0..mesh.uv_sets().len()).map(|i| format!("uv{i}")).collect();
    let tcoords = if uv_names.is_empty() { "" } else { " TCoords=\"uv0\"" };
    let tangents = if mesh.tangents().is_empty() { "" } else { " Tangents=\"Tangents\"" };
    let _ = writeln!(out.text, "<PointData Normals=\"Normals\"{tcoords}{tangents}>");
    out.floats("Normals", 3, bytemuck::cast_slice(mesh.normals()));
    if !mesh.tangents().is_empty() {
        out.floats("Tangents", 4, bytemuck::cast_slice(mesh.tangents()));
    }
    for (name, set) in uv_names.iter().zip(mesh.uv_sets()) {
        // v counts upwards in the file.
        match set.uv.iter().all(|uv| 1.0 - (1.0 - uv.y) == uv.y) {
            true => {
                out.floats(name, 2, &set.uv.iter().flat_map(|uv| [uv.x, 1.0 - uv.y]).collect::<Vec<_>>());
            }
            false => {
                let all: Vec<f64> = set.uv.iter().flat_map(|uv| [uv.x as f64, 1.0 - uv.y as f64]).collect();
                out.doubles(name, 2, "", &all);
            }
        }
    }
    out.colors(mesh);
    for field in mesh.fields().iter().filter(|f| f.element == Element::Vertex) {
        out.field(field);
    }
    out.text += "</PointData>\n<CellData>\n";
    for field in mesh.fields().iter().filter(|f| f.element == Element::Face) {
        out.field(field);
    }
    out.text += "</CellData>\n<Points>\n";
    out.floats("Points", 3, bytemuck::cast_slice(mesh.positions()));
    out.text += "</Points>\n<Polys>\n";
    let corners = mesh.triangles().as_flattened();
    out.array("Int64", "connectivity", 1, "", corners.len() * 8, corners.iter().map(|i| (*i as i64).to_le_bytes()));
    out.array("Int64", "offsets", 1, "", n_faces * 8, (1..=n_faces as i64).map(|i| (3 * i).to_le_bytes()));
    out.text += "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
    let mut bytes = out.text.into_bytes();
    bytes.append(&mut out.block);
    bytes.extend_from_slice(b"\n</AppendedData>\n</VTKFile>\n");

    let mut lost = Vec::new();
    note_lost(mesh, &[Element::Corner], &mut lost);
    Report { value: bytes, mended: lost }
}

/// Tells which fields a format has no place for.
pub(super) fn note_lost(mesh: &Mesh, elements: &[Element], lost: &mut Vec<Mended>) {
    let names: Vec<String> =
        mesh.fields().iter().filter(|f| elements.contains(&f.element)).map(|f| format!("{:?}", f.name)).collect();
    note(lost, names.len(), format!("fields that the format has no place for left out: {}", names.join(", ")));
}

struct Output {
    text: String,
    block: Vec<u8>,
}

impl Output {
    /// One array: its line in the text, its bytes in the block, their number before them.
    fn array<const N: usize>(
        &mut self,
        kind: &str,
        name: &str,
        n_components: usize,
        unit: &str,
        size: usize,
        numbers: impl Iterator<Item = [u8; N]>,
    ) {
        let name = escaped(name);
        let _ = write!(
            self.text,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{n_components}\" format=\"appended\" \
             offset=\"{}\"",
            self.block.len()
        );
        match unit.is_empty() {
            true => self.text += "/>\n",
            false => {
                let unit = escaped(unit);
                let _ = writeln!(
                    self.text,
                    "><InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{unit}</InformationKey></DataArray>"
                );
            }
        }
        self.block.extend_from_slice(&(size as u64).to_le_bytes());
        self.block.reserve(size);
        numbers.for_each(|b| self.block.extend_from_slice(&b));
    }

    fn floats(&mut self, name: &str, n_components: usize, values: &[f32]) {
        self.array("Float32", name, n_components, "", values.len() * 4, values.iter().map(|x| x.to_le_bytes()));
    }

    fn doubles(&mut self, name: &str, n_components: usize, unit: &str, values: &[f64]) {
        self.array("Float64", name, n_components, unit, values.len() * 8, values.iter().map(|x| x.to_le_bytes()));
    }

    fn field(&mut self, field: &Field) {
        let (name, n) = (&field.name, field.n_components);
        match &field.values {
            Values::F32(v) => {
                self.array("Float32", name, n, &field.unit, v.len() * 4, v.iter().map(|x| x.to_le_bytes()));
            }
            Values::F64(v) => self.doubles(name, n, &field.unit, v),
        }
    }

    fn colors(&mut self, mesh: &Mesh) {
        let colors: &[f32] = bytemuck::cast_slice(mesh.colors());
        if colors.is_empty() {
            return;
        }
        let byte = |i: usize| match i % 4 {
            3 => (colors[i] * 255.0).round() as u8,
            _ => srgb8_from_linear(colors[i]),
        };
        let value = |i: usize| match i % 4 {
            3 => byte(i) as f32 / 255.0,
            _ => crate::color::LINEAR_FROM_SRGB8[byte(i) as usize],
        };
        if (0..colors.len()).all(|i| value(i) == colors[i]) {
            self.array("UInt8", "RGBA", 4, "", colors.len(), (0..colors.len()).map(|i| [byte(i)]));
        } else {
            let display = |(i, x): (usize, &f32)| if i % 4 == 3 { *x as f64 } else { srgb_from_linear(*x as f64) };
            let all: Vec<f64> = colors.iter().enumerate().map(display).collect();
            self.doubles("RGBA", 4, "", &all);
        }
    }
}

/// Text for XML; what XML cannot hold becomes a blank.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
#[path = "vtp_write_tests.rs"]
mod tests;
