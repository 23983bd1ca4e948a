//! Wavefront OBJ: polygons, groups, materials, any line ending, UTF-8 or UTF-16.
//!
//! Each combination of a corner's `v/vt/vn` becomes one vertex; the first of a point keeps the point's index. Objects and
//! groups become parts. Texture coordinates count v upwards in the file. Colours after a position (`v x y z r g b`) are
//! display values (sRGB). Smoothing groups (`s`) decide on creases where a file has any and brings no normals.

use crate::assets::files::{self, Loose};
use crate::assets::mend::MendOptions;
use crate::assets::mtl::{self, Library};
use crate::assets::ply;
use crate::assets::polygon::Triangulator;
use crate::assets::split::Splitter;
use crate::assets::text::{self, Lines, Words, format_error, number_prefix, parse_error, string, trimmed};
use crate::assets::{Neighbours, Part, RawMesh, Scene, UvSet};
use crate::error::{Mended, Report, Result, note};
use crate::math::{Vec2, Vec3, Vec4, vec2, vec3};
use std::collections::HashMap;
use std::path::Path;

/// Reads an OBJ file and the material libraries it names.
pub fn read(bytes: &[u8], path: &Path, neighbours: &Neighbours) -> Result<Report<Scene>> {
    Ok(read_loose(bytes, path, neighbours)?.mend())
}

/// The same before mending.
pub(super) fn read_loose(bytes: &[u8], path: &Path, neighbours: &Neighbours) -> Result<Loose> {
    let text = text::utf8(bytes);
    let mut reader = Reader::default();
    for (number, line) in Lines::joined(&text) {
        reader.line(&line, number, path)?;
    }
    if reader.n_statements == 0 {
        let is_blank = text.iter().all(|b| *b <= b' ');
        return Err(format_error(path, if is_blank { "the file is empty" } else { "no OBJ statement in it" }));
    }
    Ok(reader.finish(path, neighbours))
}

/// Material libraries that are read for one file, at most.
const MAX_LIBRARIES: usize = 64;

/// No texture coordinate, or no normal.
const NONE: u32 = u32::MAX;

#[derive(Default)]
struct Reader {
    points: Vec<Vec3>,
    /// Display values as in the file; empty until a point has some.
    colors: Vec<Vec3>,
    uv: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// Point, texture coordinate and normal of each corner of each triangle.
    corners: Vec<[u32; 3]>,
    source_faces: Vec<u32>,
    groups: Vec<u32>,
    parts: Vec<Part>,
    /// The names that `usemtl` gave, by `Part::material`.
    material_names: Vec<String>,
    /// Where in `material_names` a name is. Never enumerated.
    material_by_name: HashMap<String, u32>,
    libraries: Vec<String>,
    name: String,
    material: Option<u32>,
    group: u32,
    has_groups: bool,
    polygon: Vec<[u32; 3]>,
    triangulator: Triangulator,
    n_faces: u32,
    n_statements: usize,
    n_odd_numbers: usize,
    n_lines_and_points: usize,
    n_small: usize,
    n_bad_corners: usize,
    first_bad_line: usize,
    n_unknown: usize,
}

impl Reader {
    fn line(&mut self, line: &[u8], number: usize, path: &Path) -> Result<()> {
        let mut words = Words(line);
        let Some(keyword) = words.next() else { return Ok(()) };
        self.n_statements += 1;
        match keyword {
            b"v" => {
                let x = self.numbers::<8>(words, 3, line, number, path)?;
                self.points.push(vec3(x.at[0], x.at[1], x.at[2]));
                if x.n >= 6 {
                    self.colors.resize(self.points.len() - 1, Vec3::ONE);
                    self.colors.push(vec3(x.at[3], x.at[4], x.at[5]));
                }
            }
            b"vt" => {
                let x = self.numbers::<3>(words, 1, line, number, path)?;
                self.uv.push(vec2(x.at[0], 1.0 - x.at[1]));
            }
            b"vn" => {
                let x = self.numbers::<3>(words, 3, line, number, path)?;
                self.normals.push(vec3(x.at[0], x.at[1], x.at[2]));
            }
            b"f" | b"fo" => self.face(words, number, path)?,
            b"l" | b"p" => self.n_lines_and_points += 1,
            b"o" | b"g" => self.name = string(trimmed(words.0)),
            b"usemtl" => {
                let name = string(trimmed(words.0));
                let new = self.material_names.len() as u32;
                let i = *self.material_by_name.entry(name.clone()).or_insert(new);
                if i == new {
                    self.material_names.push(name);
                }
                self.material = Some(i);
            }
            // Some exporters name the library again for each object.
            b"mtllib" => {
                let name = string(trimmed(words.0));
                if self.libraries.len() < MAX_LIBRARIES && !self.libraries.contains(&name) {
                    self.libraries.push(name);
                }
            }
            b"s" => {
                self.group = words.next().and_then(text::integer).and_then(|g| u32::try_from(g).ok()).unwrap_or(0);
                self.has_groups = true;
            }
            _ if keyword[0] == b'#' => self.n_statements -= 1,
            b"vp" | b"mg" | b"lod" | b"bevel" | b"c_interp" | b"d_interp" | b"shadow_obj" | b"trace_obj" => {}
            _ => self.n_unknown += 1,
        }
        Ok(())
    }

    /// Up to N numbers; at least `n_needed`. A number with a tail that is none is taken as far as it goes.
    fn numbers<const N: usize>(
        &mut self,
        words: Words,
        n_needed: usize,
        line: &[u8],
        number: usize,
        path: &Path,
    ) -> Result<Numbers<N>> {
        let mut x = Numbers { at: [0.0; N], n: 0 };
        for word in words.take(N) {
            match number_prefix(word) {
                Some((value, whole)) => {
                    self.n_odd_numbers += !whole as usize;
                    x.at[x.n] = value;
                    x.n += 1;
                }
                None => break,
            }
        }
        if x.n < n_needed {
            return Err(parse_error(path, number, &format!("{n_needed} numbers"), trimmed(line)));
        }
        Ok(x)
    }

    fn face(&mut self, words: Words, number: usize, path: &Path) -> Result<()> {
        self.polygon.clear();
        let mut is_bad = false;
        for word in words {
            let Some(corner) = self.corner(word) else {
                return Err(parse_error(path, number, "corners like 1, 1/2, 1//3 or 1/2/3", word));
            };
            is_bad |= corner[0] as usize >= self.points.len();
            self.polygon.push(corner);
        }
        let face = self.n_faces;
        self.n_faces += 1;
        if is_bad {
            self.n_bad_corners += 1;
            if self.first_bad_line == 0 {
                self.first_bad_line = number;
            }
            return Ok(());
        }
        if self.polygon.len() < 3 {
            self.n_small += 1;
            return Ok(());
        }
        self.open_part();
        let (points, polygon) = (&self.points, &self.polygon);
        self.triangulator.cut(
            polygon.len(),
            |i| points[polygon[i][0] as usize],
            |t| {
                self.corners.extend(t.map(|i| polygon[i as usize]));
                self.source_faces.push(face);
                self.groups.push(self.group);
            },
        );
        let end = self.source_faces.len() as u32;
        self.parts.last_mut().into_iter().for_each(|p| p.triangles.end = end);
        Ok(())
    }

    /// Begins a part unless the last has the same name and material.
    fn open_part(&mut self) {
        if self.parts.last().is_none_or(|p| p.material != self.material || p.name != self.name) {
            let start = self.source_faces.len() as u32;
            self.parts.push(Part { name: self.name.clone(), triangles: start..start, material: self.material });
        }
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`. A point out of range is left so; an attribute out of range is none.
    fn corner(&self, word: &[u8]) -> Option<[u32; 3]> {
        let lens = [self.points.len(), self.uv.len(), self.normals.len()];
        let mut corner = [NONE; 3];
        for (i, part) in word.split(|b| *b == b'/').enumerate() {
            if part.is_empty() && i > 0 {
                continue;
            }
            let given = text::integer(part)?;
            // Counted from 1, or backwards from the last so far. 0 is nothing.
            let index = if given < 0 { lens.get(i).map_or(-1, |n| *n as i64) + given } else { given - 1 };
            if i < 3 && (0..lens[i] as i64).contains(&index) {
                corner[i] = index as u32;
            }
        }
        Some(corner)
    }

    fn finish(self, path: &Path, neighbours: &Neighbours) -> Loose {
        let mut mended = Vec::new();
        note(&mut mended, self.n_odd_numbers, "numbers with a tail that is none read up to there");
        note(&mut mended, self.n_unknown, "unknown statements passed over");
        note(&mut mended, self.n_lines_and_points, "lines and points passed over");
        note(&mut mended, self.n_small, "faces with fewer than three corners dropped");
        let first = self.first_bad_line;
        note(
            &mut mended,
            self.n_bad_corners,
            format!("faces with points that do not exist dropped (first in line {first})"),
        );
        if self.corners.is_empty() {
            note(&mut mended, self.points.len(), "points without any face: there is no surface");
        }
        let (materials, images, material_of) = self.materials(neighbours, &mut mended);
        let is_triangles = self.source_faces.iter().enumerate().all(|(i, f)| i as u32 == *f);
        let has_groups = self.has_groups && self.normals.is_empty();
        let options =
            MendOptions { smooth_groups: if has_groups { self.groups } else { Vec::new() }, ..MendOptions::default() };
        let mut mesh = RawMesh {
            positions: self.points,
            source_faces: if is_triangles { Vec::new() } else { self.source_faces },
            parts: self.parts,
            colors: linear_colors(self.colors),
            ..Default::default()
        };
        for part in &mut mesh.parts {
            part.material = part.material.and_then(|m| material_of[m as usize]);
        }
        split(&mut mesh, self.corners, &self.uv, &self.normals);
        Loose { name: files::name_of(path), mesh, materials, images, mended, options }
    }

    /// Reads the libraries; for each name that `usemtl` gave, the index of its material.
    fn materials(
        &self,
        neighbours: &Neighbours,
        mended: &mut Vec<Mended>,
    ) -> (Vec<crate::assets::Material>, Vec<crate::assets::TextureImage>, Vec<Option<u32>>) {
        let mut library = Library::default();
        for names in &self.libraries {
            // One name with blanks, or several names: whichever exists.
            let mut found = neighbours(names).map(|b| vec![b]);
            if found.is_err() && names.contains(char::is_whitespace) {
                found = names.split_whitespace().map(neighbours).collect();
            }
            match found {
                Ok(files) => files.iter().for_each(|bytes| mtl::read(bytes, neighbours, &mut library, mended)),
                Err(why) => note(mended, 1, format!("material library {names:?} not read: {why}")),
            }
        }
        let by_name: HashMap<&str, u32> =
            library.materials.iter().enumerate().map(|(i, m)| (m.name.as_str(), i as u32)).collect();
        let material_of: Vec<Option<u32>> =
            self.material_names.iter().map(|name| by_name.get(name.as_str()).copied()).collect();
        let n_unknown = material_of.iter().filter(|m| m.is_none()).count();
        note(mended, n_unknown, "materials in use that no library holds; they get the default");
        (library.materials, library.images, material_of)
    }
}

/// Numbers of a statement.
struct Numbers<const N: usize> {
    at: [f32; N],
    n: usize,
}

fn linear_colors(colors: Vec<Vec3>) -> Vec<Vec4> {
    let scale = if colors.iter().any(|c| c.max_element() > 1.0) { 255.0 } else { 1.0 };
    colors.into_iter().map(|c| Vec3::from_array(c.to_array().map(|x| ply::linear(x, scale))).extend(1.0)).collect()
}

/// Makes vertices of corners.
fn split(mesh: &mut RawMesh, corners: Vec<[u32; 3]>, uv: &[Vec2], normals: &[Vec3]) {
    let n_points = mesh.positions.len();
    if !mesh.colors.is_empty() {
        mesh.colors.resize(n_points, Vec4::ONE);
    }
    let mut splitter = Splitter::new(n_points);
    let mut triangles = Vec::with_capacity(corners.len() / 3);
    triangles.extend(corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|[v, t, n]| splitter.vertex(v, [t, n]))));
    drop(corners);
    mesh.triangles = triangles;
    mesh.copy_vertices(&splitter.copies());
    let at = |i: u32| i as usize;
    if splitter.attributes().any(|a| a.is_some_and(|[t, _]| t != NONE)) {
        let uv = splitter.attributes().map(|a| a.and_then(|[t, _]| uv.get(at(t)).copied()).unwrap_or_default());
        mesh.uv_sets.push(UvSet { name: "uv0".into(), uv: uv.collect() });
    }
    if splitter.attributes().any(|a| a.is_some_and(|[_, n]| n != NONE)) {
        // Corners without a normal among others with one are mended.
        let n = splitter.attributes().map(|a| a.and_then(|[_, n]| normals.get(at(n)).copied()).unwrap_or_default());
        mesh.normals = n.collect();
    }
}

#[cfg(test)]
#[path = "obj_tests.rs"]
mod tests;
