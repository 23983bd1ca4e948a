//! OFF, the Object File Format of Geomview, as text: OFF, COFF, NOFF, STOFF and their combinations.
//!
//! Colours are display values (sRGB), 0..255 or 0..1: the first if any is above 1. Colours of faces become the field
//! `color`, linear red, green, blue and alpha. Texture coordinates count v upwards in the file.

use crate::assets::files::{self, Loose};
use crate::assets::mend::MendOptions;
use crate::assets::ply;
use crate::assets::polygon::Triangulator;
use crate::assets::text::{self, Line, Lines, Words, format_error, integer, number, parse_error, string};
use crate::assets::{Element, Field, Neighbours, RawMesh, Scene, UvSet, Values};
use crate::error::{Error, Mended, Report, Result, note};
use crate::math::{Vec3, Vec4, vec2, vec3, vec4};
use std::path::Path;

/// Reads an OFF file.
pub fn read(bytes: &[u8], path: &Path, _neighbours: &Neighbours) -> Result<Report<Scene>> {
    Ok(read_loose(bytes, path)?.mend())
}

/// The same before mending.
pub(super) fn read_loose(bytes: &[u8], path: &Path) -> Result<Loose> {
    let text = text::utf8(bytes);
    let mut source = Source { lines: Lines::new(&text), path, last: 0 };
    let mut mended = Vec::new();
    let head = Head::read(&mut source)?;
    let room = text.len() as u64 / 6 + 1;
    if head.n_vertices > room {
        let fault = format!("the header claims {} vertices, the file has room for at most {room}", head.n_vertices);
        return Err(format_error(path, fault));
    }
    let mut mesh = RawMesh::default();
    read_vertices(&mut source, &head, &mut mesh)?;
    read_faces(&mut source, &head, &mut mesh, &mut mended)?;
    Ok(Loose::new(files::name_of(path), mesh, mended, MendOptions::default()))
}

/// Lines that say something.
struct Source<'a> {
    lines: Lines<'a>,
    path: &'a Path,
    last: usize,
}

impl<'a> Source<'a> {
    /// The next line with a word in it, comments cut off.
    fn next(&mut self) -> Option<Line<'a>> {
        loop {
            let (number, line) = self.lines.next()?;
            self.last = number;
            let end = line.iter().position(|b| *b == b'#').unwrap_or(line.len());
            let line: std::borrow::Cow<[u8]> = match line {
                std::borrow::Cow::Borrowed(l) => l[..end].into(),
                std::borrow::Cow::Owned(l) => l[..end].to_vec().into(),
            };
            if Words(&line).next().is_some() {
                return Some((number, line));
            }
        }
    }

    fn ended(&self, in_what: &str) -> Error {
        format_error(self.path, format!("the file ends at line {} in {in_what}", self.last))
    }
}

/// What the first lines say.
struct Head {
    has_normals: bool,
    has_colors: bool,
    has_uv: bool,
    n_vertices: u64,
    n_faces: u64,
}

impl Head {
    fn read(source: &mut Source) -> Result<Self> {
        let Some((number, first)) = source.next() else {
            return Err(format_error(source.path, "the file is empty"));
        };
        let mut head = Self { has_normals: false, has_colors: false, has_uv: false, n_vertices: 0, n_faces: 0 };
        let mut words = Words(&first);
        let word = string(words.clone().next().unwrap_or_default());
        let mut counts = Vec::new();
        if let Some(prefix) = word.strip_suffix("OFF") {
            words.next();
            let prefix = match prefix.strip_prefix("ST") {
                Some(rest) => {
                    head.has_uv = true;
                    rest
                }
                None => prefix,
            };
            for c in prefix.chars() {
                match c {
                    'C' => head.has_colors = true,
                    'N' => head.has_normals = true,
                    _ => {
                        return Err(parse_error(source.path, number, "OFF with prefixes ST, C and N", word.as_bytes()));
                    }
                }
            }
            if words.clone().next() == Some(b"BINARY") {
                return Err(format_error(source.path, "binary OFF is not read; save it as text, PLY or STL"));
            }
        } else if integer(word.as_bytes()).is_none() {
            return Err(parse_error(source.path, number, "OFF", word.as_bytes()));
        }
        take_counts(words, number, source.path, &mut counts)?;
        // The number of edges, which nobody uses, is sometimes left out.
        while counts.len() < 2 {
            let Some((number, line)) = source.next() else { return Err(source.ended("its counts")) };
            take_counts(Words(&line), number, source.path, &mut counts)?;
        }
        (head.n_vertices, head.n_faces) = (counts[0], counts[1]);
        Ok(head)
    }

    /// Numbers a vertex has at least, before its colour.
    fn n_least(&self) -> usize {
        3 + if self.has_normals { 3 } else { 0 }
    }
}

fn take_counts(words: Words, line: usize, path: &Path, counts: &mut Vec<u64>) -> Result<()> {
    for word in words.take(3 - counts.len().min(3)) {
        let n = integer(word).and_then(|n| u64::try_from(n).ok());
        counts.push(n.ok_or_else(|| parse_error(path, line, "a number of vertices and of faces", word))?);
    }
    Ok(())
}

fn take_numbers(line: &Line, path: &Path, numbers: &mut Vec<f64>) -> Result<()> {
    for word in Words(&line.1) {
        numbers.push(number(word).ok_or_else(|| parse_error(path, line.0, "a number", word))?);
    }
    Ok(())
}

fn read_vertices(source: &mut Source, head: &Head, mesh: &mut RawMesh) -> Result<()> {
    let n = head.n_vertices as usize;
    let n_uv = if head.has_uv { 2 } else { 0 };
    let mut numbers = Vec::new();
    mesh.positions.reserve_exact(n);
    let mut uv = Vec::new();
    for i in 0..n {
        numbers.clear();
        // A vertex may be broken over lines; colours have three or four numbers, which the line's end tells.
        while numbers.len() < head.n_least() + n_uv {
            let Some(line) = source.next() else { return Err(source.ended(&format!("vertex {i} of {n}"))) };
            take_numbers(&line, source.path, &mut numbers)?;
        }
        let x = |k: usize| numbers[k] as f32;
        mesh.positions.push(vec3(x(0), x(1), x(2)));
        if head.has_normals {
            mesh.normals.push(vec3(x(3), x(4), x(5)));
        }
        let rest = &numbers[head.n_least()..];
        let (color, st) = rest.split_at(rest.len() - n_uv);
        if color.len() >= 3 {
            // Some files have colours without saying so; those before had none.
            mesh.colors.resize(i, Vec4::NAN);
            mesh.colors.push(color_of(color));
        }
        if head.has_uv {
            uv.push(vec2(st[0] as f32, (1.0 - st[1]) as f32));
        }
    }
    if !mesh.colors.is_empty() {
        mesh.colors.resize(n, Vec4::NAN);
        colors_to_linear(&mut mesh.colors);
    }
    if head.has_uv {
        mesh.uv_sets.push(UvSet { name: "uv0".into(), uv });
    }
    Ok(())
}

/// Three or four numbers as the file has them; absent alpha is marked by a negative number.
fn color_of(numbers: &[f64]) -> Vec4 {
    let alpha = numbers.get(3).map_or(-1.0, |a| *a as f32);
    vec4(numbers[0] as f32, numbers[1] as f32, numbers[2] as f32, alpha)
}

fn colors_to_linear(colors: &mut [Vec4]) {
    let scale = if colors.iter().any(|c| c.max_element() > 1.0) { 255.0 } else { 1.0 };
    for c in colors {
        let light = |x| ply::linear(x, scale);
        *c = vec4(light(c.x), light(c.y), light(c.z), if c.w < 0.0 { 1.0 } else { c.w / scale });
    }
}

fn read_faces(source: &mut Source, head: &Head, mesh: &mut RawMesh, mended: &mut Vec<Mended>) -> Result<()> {
    let (mut cut, mut corners, mut numbers) = (Triangulator::default(), Vec::new(), Vec::new());
    let (mut colors, mut has_colors) = (Vec::new(), false);
    let (mut n_small, mut n_read) = (0, 0);
    while n_read < head.n_faces {
        let Some(line) = source.next() else { break };
        let mut words = Words(&line.1);
        let n = words.next().and_then(integer).and_then(|n| usize::try_from(n).ok());
        let n = n.ok_or_else(|| parse_error(source.path, line.0, "the number of a face's corners", &line.1))?;
        corners.clear();
        numbers.clear();
        let mut line_number = line.0;
        let mut rest = words;
        let mut next_line;
        let is_cut_short = loop {
            for word in rest {
                if corners.len() < n {
                    let expected = "the index of a face's corner";
                    let i = integer(word).ok_or_else(|| parse_error(source.path, line_number, expected, word))?;
                    corners.push(u32::try_from(i).unwrap_or(u32::MAX));
                } else {
                    numbers.extend(number(word));
                }
            }
            if corners.len() >= n {
                break false;
            }
            let Some(more) = source.next() else { break true };
            (line_number, next_line) = more;
            rest = Words(&next_line);
        };
        if is_cut_short {
            break;
        }
        let before = mesh.triangles.len();
        let positions = &mesh.positions;
        cut.cut(
            n,
            |i| positions.get(corners[i] as usize).copied().unwrap_or(Vec3::NAN),
            |t| mesh.triangles.push(t.map(|i| corners[i as usize])),
        );
        let n_new = mesh.triangles.len() - before;
        n_small += (n_new == 0) as usize;
        mesh.source_faces.extend(std::iter::repeat_n(n_read as u32, n_new));
        let color = if numbers.len() >= 3 { color_of(&numbers) } else { Vec4::NAN };
        has_colors |= numbers.len() >= 3;
        colors.extend(std::iter::repeat_n(color, n_new));
        n_read += 1;
    }
    note(mended, n_small, "faces with fewer than three corners dropped");
    let n_missing = usize::try_from(head.n_faces - n_read).unwrap_or(usize::MAX);
    note(mended, n_missing, "faces that the header claims are not in the file");
    if mesh.triangles.is_empty() {
        note(mended, mesh.positions.len(), "points without any face: there is no surface");
    }
    if has_colors {
        colors_to_linear(&mut colors);
        let values = Values::F32(colors.iter().flat_map(|c| c.to_array()).collect());
        let name = "color".to_string();
        mesh.fields.push(Field { name, unit: String::new(), element: Element::Face, n_components: 4, values });
    }
    if mesh.source_faces.len() as u64 == n_read && n_small == 0 {
        mesh.source_faces = Vec::new();
    }
    Ok(())
}
