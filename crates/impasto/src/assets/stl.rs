//! STL, text and binary: loose triangles, welded exactly.
//!
//! Which of the two a file is, its size tells: binary files have 50 bytes a triangle after 84. Many binary files begin
//! with the word `solid`, so the word is asked only where the size does not fit. Normals in the file are not used; they
//! are those of the triangles, if they are right.

use crate::assets::files::{self, Loose};
use crate::assets::mend::MendOptions;
use crate::assets::polygon::Triangulator;
use crate::assets::text::{self, Lines, Words, format_error, number, parse_error};
use crate::assets::weld::{Seen, hash_position};
use crate::assets::{Element, Field, Mesh, Neighbours, Part, RawMesh, Scene, Values};
use crate::error::{Mended, Report, Result, note};
use crate::math::{Vec3, vec3};
use std::path::Path;

/// Reads an STL file.
pub fn read(bytes: &[u8], path: &Path, _neighbours: &Neighbours) -> Result<Report<Scene>> {
    Ok(read_loose(bytes, path)?.mend())
}

/// The same before mending.
pub(super) fn read_loose(bytes: &[u8], path: &Path) -> Result<Loose> {
    let mut mended = Vec::new();
    let mesh = if is_binary(bytes) { read_binary(bytes, &mut mended) } else { read_text(bytes, path, &mut mended)? };
    Ok(Loose::new(files::name_of(path), mesh, mended, MendOptions::default()))
}

const HEAD: usize = 84;
const FACET: usize = 50;

fn claimed(bytes: &[u8]) -> Option<usize> {
    let n = bytes.get(80..HEAD)?;
    Some(u32::from_le_bytes([n[0], n[1], n[2], n[3]]) as usize)
}

fn is_binary(bytes: &[u8]) -> bool {
    let Some(n) = claimed(bytes) else { return false };
    let is_text = || {
        let start = text::utf8(&bytes[..bytes.len().min(2048)]).to_ascii_lowercase();
        let has = |word: &[u8]| start.windows(word.len()).any(|w| w == word);
        text::trimmed(&start).starts_with(b"solid") && (has(b"facet") || has(b"endsolid") || !start.contains(&0))
    };
    n.checked_mul(FACET).is_some_and(|size| size + HEAD == bytes.len()) || !is_text()
}

/// Numbers smaller than this part of a file's largest are zeros that sines and cosines of CAD programs left behind.
const NOISE: f32 = 1.0 / (1u64 << 40) as f32;

/// Gives equal corners one index; three corners a triangle.
fn weld(mesh: &mut RawMesh, mut corners: Vec<Vec3>, mended: &mut Vec<Mended>) {
    let numbers: &mut [f32] = bytemuck::cast_slice_mut(&mut corners);
    let largest = numbers.iter().map(|x| x.abs()).filter(|x| x.is_finite()).fold(0.0, f32::max);
    let mut n_noise = 0;
    for x in numbers.iter_mut() {
        if x.abs() <= largest * NOISE {
            n_noise += (*x != 0.0) as usize;
            *x = 0.0;
        }
    }
    note(mended, n_noise, "coordinates below 2^-40 of the largest set to zero");
    // A closed surface has half as many points as triangles.
    let n = corners.len() / 6 + 4;
    let mut seen = Seen::with_capacity(n);
    mesh.positions.reserve_exact(n);
    mesh.triangles.reserve_exact(corners.len() / 3);
    let positions = &mut mesh.positions;
    let mut vertex = |p: Vec3| {
        let new = positions.len() as u32;
        let at = |i: u32| positions[i as usize];
        let found = seen.find_or_insert(hash_position(p), new, |i| at(i) == p, |i| hash_position(at(i)));
        found.unwrap_or_else(|| {
            positions.push(p);
            new
        })
    };
    mesh.triangles.extend(corners.chunks_exact(3).map(|c| [vertex(c[0]), vertex(c[1]), vertex(c[2])]));
}

fn read_binary(bytes: &[u8], mended: &mut Vec<Mended>) -> RawMesh {
    let n_claimed = claimed(bytes).unwrap_or(0);
    let facets = &bytes[HEAD.min(bytes.len())..];
    let n = n_claimed.min(facets.len() / FACET);
    let mut corners = Vec::with_capacity(3 * n);
    let mut attributes = Vec::new();
    for (i, facet) in facets.chunks_exact(FACET).take(n).enumerate() {
        let float = |at: usize| f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]);
        let corner = |k: usize| vec3(float(k), float(k + 4), float(k + 8));
        corners.extend([12, 24, 36].map(corner));
        let attribute = u16::from_le_bytes([facet[48], facet[49]]);
        if attribute != 0 && attributes.is_empty() {
            attributes = vec![0.0; n];
        }
        if attribute != 0 {
            attributes[i] = attribute as f32;
        }
    }
    note(mended, n_claimed - n, "triangles that the header claims are not in the file");
    let mut mesh = RawMesh::default();
    weld(&mut mesh, corners, mended);
    if !attributes.is_empty() {
        let values = Values::F32(attributes);
        let name = "attribute".to_string();
        mesh.fields.push(Field { name, unit: String::new(), element: Element::Face, n_components: 1, values });
    }
    mesh
}

fn read_text(bytes: &[u8], path: &Path, mended: &mut Vec<Mended>) -> Result<RawMesh> {
    let text = text::utf8(bytes);
    let mut parts: Vec<Part> = Vec::new();
    let mut welded = Vec::new();
    let (mut corners, mut cut) = (Vec::new(), Triangulator::default());
    let (mut n_odd, mut n_words) = (0, 0);
    let mut is_stl = false;
    let mut facet_done = |corners: &mut Vec<Vec3>, welded: &mut Vec<Vec3>| {
        n_odd += (!corners.is_empty() && corners.len() != 3) as usize;
        cut.cut(corners.len(), |i| corners[i], |t| welded.extend(t.map(|i| corners[i as usize])));
        corners.clear();
    };
    for (line_number, line) in Lines::new(&text) {
        // Some files have everything in one line, so words count, not lines.
        let mut words = Words(&line);
        while let Some(word) = words.next() {
            n_words += 1;
            match word.to_ascii_lowercase().as_slice() {
                b"vertex" => {
                    let mut p = [0.0; 3];
                    for x in &mut p {
                        let word = words.next().unwrap_or_default();
                        *x = number(word).ok_or_else(|| parse_error(path, line_number, "three coordinates", &line))?
                            as f32;
                    }
                    corners.push(Vec3::from_array(p));
                }
                b"solid" => {
                    is_stl = true;
                    end_part(&mut parts, welded.len());
                    let name = text::string(text::trimmed(words.0));
                    let start = (welded.len() / 3) as u32;
                    parts.push(Part { name, triangles: start..start, material: None });
                    break;
                }
                b"facet" | b"endfacet" | b"endloop" => {
                    is_stl = true;
                    facet_done(&mut corners, &mut welded);
                }
                b"endsolid" => break,
                _ => {}
            }
        }
    }
    facet_done(&mut corners, &mut welded);
    if !is_stl {
        let fault = if n_words == 0 { "the file is empty" } else { "neither text nor binary STL" };
        return Err(format_error(path, fault));
    }
    note(mended, n_odd, "facets that do not have three corners cut into triangles or dropped");
    end_part(&mut parts, welded.len());
    if parts.first().is_some_and(|p| p.triangles.start > 0) {
        parts.clear();
    }
    parts.retain(|p| !p.triangles.is_empty());
    let mut mesh = RawMesh { parts, ..Default::default() };
    weld(&mut mesh, welded, mended);
    Ok(mesh)
}

/// The last part ends where the triangles do.
fn end_part(parts: &mut [Part], n_corners: usize) {
    if let Some(last) = parts.last_mut() {
        last.triangles.end = (n_corners / 3) as u32;
    }
}

/// The bytes of a binary STL file.
pub fn write(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD + FACET * mesh.triangles().len());
    // Must not begin with `solid`.
    bytes.extend_from_slice(b"binary STL by Impasto");
    bytes.resize(80, b' ');
    bytes.extend((mesh.triangles().len() as u32).to_le_bytes());
    let attribute = mesh.fields().iter().find(|f| f.name == "attribute" && f.element == Element::Face);
    for (t, triangle) in mesh.triangles().iter().enumerate() {
        let p = triangle.map(|v| mesh.positions()[v as usize]);
        let normal = super::normals::face_normal(p);
        for v in [normal, p[0], p[1], p[2]] {
            v.to_array().iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        }
        let attribute = attribute.map_or(0, |f| f.values.at(t * f.n_components) as u16);
        bytes.extend(attribute.to_le_bytes());
    }
    bytes
}
