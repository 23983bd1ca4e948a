//! PLY, the Stanford polygon format (Turk 1994): ASCII and both binary orders, every property kept.
//!
//! Properties with customary names become the mesh's own: `x y z`, `nx ny nz`, `tx ty tz tw`, `s t` or `u v` (v up in the
//! file), `red green blue alpha` and their variants. Colours are display values (sRGB) whether they are integers or floats
//! in 0..1. All others become fields under their own names. A face's list properties with one entry (or two, ...) a corner
//! become corner data; `texcoord` lists become a UV set. `comment TextureFile NAME` gives a base colour texture.
//!
//! Binary elements without lists are copied column by column, lists of three straight into triangles: nothing is
//! dispatched per value, and memory is taken for what the file holds, not for what its header claims.

use crate::assets::files::{self, Loose};
use crate::assets::mend::MendOptions;
use crate::assets::numbers::{Kind, index};
use crate::assets::ply_header::{ElementHeader, Encoding, Header, Property};
use crate::assets::polygon::Triangulator;
use crate::assets::split::{self, CornerUv};
use crate::assets::text::{Words, format_error, number, parse_error};
use crate::assets::{Element, Field, Neighbours, RawMesh, Scene, UvSet, Values};
use crate::color::{self, LINEAR_FROM_SRGB8};
use crate::error::{Error, Mended, Report, Result, note};
use crate::math::{Vec2, Vec3, Vec4, vec2, vec4};
use std::path::Path;

/// Reads a PLY file.
pub fn read(bytes: &[u8], path: &Path, neighbours: &Neighbours) -> Result<Report<Scene>> {
    Ok(read_loose(bytes, path, neighbours)?.mend())
}

/// The same before mending, so that the bytes can be given back first.
pub(super) fn read_loose(bytes: &[u8], path: &Path, neighbours: &Neighbours) -> Result<Loose> {
    let header = Header::read(bytes, path)?;
    let mut mended = Vec::new();
    let mut body = Body { bytes, at: header.len, encoding: header.encoding, path };
    let mut vertices = Vertices::default();
    let mut faces = Faces::default();
    let mut has_vertices = false;
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" if !has_vertices => {
                vertices = Vertices::read(&mut body, element, &mut mended)?;
                has_vertices = true;
            }
            "face" | "tristrips" if faces.is_empty() && has_vertices => {
                faces = Faces::read(&mut body, element, &vertices, &mut mended)?;
            }
            // Whatever else there is stands between us and the elements that follow; a file may end in it.
            _ if body.skip(element).is_err() => break,
            _ => {}
        }
    }
    if !has_vertices {
        return Err(format_error(path, "the header names no vertex element"));
    }
    let mut mesh = vertices.mesh;
    mesh.triangles = faces.triangles;
    mesh.source_faces = faces.source_faces;
    mesh.fields.extend(faces.fields);
    if mesh.triangles.is_empty() {
        note(&mut mended, mesh.positions.len(), "points without any face: there is no surface");
    }
    if let Some(uv) = faces.corner_uv {
        split::split_by_corner_uv(&mut mesh, &uv);
    }
    merge_components(&mut mesh.fields);
    for field in &mut mesh.fields {
        if let Some((_, unit)) = header.units.iter().find(|(name, _)| *name == field.name) {
            field.unit = unit.clone();
        }
    }
    let (materials, images) = files::texture_named_in_comment(&header.textures, neighbours, &mut mended);
    if !materials.is_empty() {
        let triangles = 0..mesh.triangles.len() as u32;
        mesh.parts = vec![crate::assets::Part { name: String::new(), triangles, material: Some(0) }];
    }
    Ok(Loose { name: files::name_of(path), mesh, materials, images, mended, options: MendOptions::default() })
}

/// Where reading stands in the file after its header.
struct Body<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
    path: &'a Path,
}

impl<'a> Body<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The number of rows that the bytes left may hold, at most the number claimed.
    fn n_rows(&self, element: &ElementHeader) -> usize {
        let most = match self.encoding {
            // A digit and a blank a property; the last blank may be missing.
            Encoding::Ascii => (self.rest().len() + 1) / (element.properties.len() * 2).max(1),
            _ => self.rest().len() / element.least_size().max(1),
        };
        if element.properties.is_empty() { 0 } else { element.n.min(most as u64) as usize }
    }

    fn error(&self, element: &ElementHeader, row: usize) -> Error {
        let fault = format!("the file ends in {} {row} of {}", element.name, element.n);
        format_error(self.path, fault)
    }

    /// One number of a kind.
    #[inline]
    fn number(&mut self, kind: Kind) -> Result<Option<f64>> {
        let size = kind.size();
        let little = match self.encoding {
            Encoding::Ascii => return self.word(),
            encoding => encoding == Encoding::Little,
        };
        let Some(bytes) = self.rest().get(..size) else { return Ok(None) };
        self.at += size;
        Ok(Some(kind.number(bytes, little)))
    }

    /// One number of a text; none at its end.
    #[inline]
    fn word(&mut self) -> Result<Option<f64>> {
        let mut words = Words(self.rest());
        let Some(word) = words.next() else { return Ok(None) };
        let end = self.bytes.len() - words.0.len();
        let Some(x) = number(word) else {
            let start = end - word.len();
            return Err(parse_error(self.path, line_number(self.bytes, start), "a number", word));
        };
        self.at = end;
        Ok(Some(x))
    }

    /// Reads one row's numbers: `scalar(property, value)` for each, `list` for lists. False at the file's end.
    fn row(&mut self, element: &ElementHeader, row: &mut Row) -> Result<bool> {
        row.scalars.clear();
        row.entries.clear();
        row.lists.clear();
        for property in &element.properties {
            match property.list {
                None => {
                    let Some(x) = self.number(property.kind)? else { return Ok(false) };
                    row.scalars.push(x);
                }
                Some(count) => {
                    let Some(n) = self.number(count)? else { return Ok(false) };
                    // A negative or broken count is a list of nothing.
                    let n = if n > 0.0 { n as usize } else { 0 };
                    let start = row.entries.len();
                    for _ in 0..n {
                        let Some(x) = self.number(property.kind)? else { return Ok(false) };
                        row.entries.push(x);
                    }
                    row.lists.push(start..row.entries.len());
                    row.scalars.push(f64::NAN);
                }
            }
        }
        Ok(true)
    }

    fn skip(&mut self, element: &ElementHeader) -> Result<()> {
        if let (Some(size), true) = (element.fixed_size(), self.encoding != Encoding::Ascii) {
            let end = (size as u64).checked_mul(element.n).and_then(|n| n.checked_add(self.at as u64));
            match end {
                Some(end) if end <= self.bytes.len() as u64 => self.at = end as usize,
                _ => return Err(self.error(element, 0)),
            }
            return Ok(());
        }
        if element.properties.is_empty() {
            return Ok(());
        }
        let mut row = Row::default();
        for i in 0..element.n {
            if !self.row(element, &mut row)? {
                return Err(self.error(element, i as usize));
            }
        }
        Ok(())
    }
}

/// The numbers of one row: scalars (NaN where a list stands) in order of properties, and all lists' entries.
#[derive(Default)]
struct Row {
    scalars: Vec<f64>,
    entries: Vec<f64>,
    lists: Vec<std::ops::Range<usize>>,
}

fn line_number(bytes: &[u8], at: usize) -> usize {
    let before = &bytes[..at];
    let n_unix = before.iter().filter(|b| **b == b'\n').count();
    // Old Macintosh files have carriage returns only.
    1 + if n_unix > 0 { n_unix } else { before.iter().filter(|b| **b == b'\r').count() }
}

/// Where a property's numbers go.
enum Target {
    /// Component of one of the mesh's own attributes.
    Own(Own, usize),
    /// Component of a colour in f64: made linear at once, so that nothing is lost.
    Light(usize),
    /// Index of a field.
    Field(usize),
    /// A list where none is expected.
    Nowhere,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Own {
    Position,
    Normal,
    Tangent,
    Color,
    Uv(usize),
}

/// The mesh's own attributes by their customary names.
fn own(name: &str) -> Option<(Own, usize)> {
    const NAMES: [(Own, &[&[&str]]); 6] = [
        (Own::Position, &[&["x"], &["y"], &["z"]]),
        (Own::Normal, &[&["nx", "normal_x"], &["ny", "normal_y"], &["nz", "normal_z"]]),
        (Own::Tangent, &[&["tx"], &["ty"], &["tz"], &["tw"]]),
        (
            Own::Color,
            &[
                &["red", "r", "diffuse_red"],
                &["green", "g", "diffuse_green"],
                &["blue", "b", "diffuse_blue"],
                &["alpha", "a", "diffuse_alpha"],
            ],
        ),
        (
            Own::Uv(0),
            &[&["s", "u", "texture_u", "texture_s", "s0", "u0"], &["t", "v", "texture_v", "texture_t", "t0", "v0"]],
        ),
        (Own::Uv(1), &[&["s1", "u1", "texture_u1"], &["t1", "v1", "texture_v1"]]),
    ];
    let name = name.to_ascii_lowercase();
    if let Some((k, set)) = name.strip_prefix(['s', 't']).and_then(|n| n.parse().ok()).map(|n| (&name[..1], n)) {
        return (0..16).contains(&set).then_some((Own::Uv(set), (k == "t") as usize));
    }
    NAMES.iter().find_map(|(own, components)| {
        components.iter().position(|names| names.contains(&name.as_str())).map(|component| (*own, component))
    })
}

impl Own {
    /// Components without which it is none.
    fn n_needed(self) -> usize {
        match self {
            Own::Position | Own::Normal | Own::Color => 3,
            Own::Tangent => 4,
            Own::Uv(_) => 2,
        }
    }
}

/// The vertex element.
#[derive(Default)]
struct Vertices {
    mesh: RawMesh,
}

impl Vertices {
    fn read(body: &mut Body, element: &ElementHeader, mended: &mut Vec<Mended>) -> Result<Self> {
        let n = body.n_rows(element);
        if (n as u64) < element.n {
            return Err(format_error(
                body.path,
                format!("the header claims {} vertices, the file has bytes for at most {n}", element.n),
            ));
        }
        let mut mesh = RawMesh::default();
        let targets = targets(element, n, &mut mesh);
        match element.fixed_size().filter(|_| body.encoding != Encoding::Ascii) {
            Some(size) => {
                let little = body.encoding == Encoding::Little;
                let rows = &body.rest()[..size * n];
                let mut offset = 0;
                for (property, target) in element.properties.iter().zip(&targets) {
                    Column { rows, size, offset, kind: property.kind, little }.copy_to(target, &mut mesh);
                    offset += property.kind.size();
                }
                body.at += size * n;
            }
            None => {
                let mut row = Row::default();
                for i in 0..n {
                    if !body.row(element, &mut row)? {
                        return Err(body.error(element, i));
                    }
                    for (x, target) in row.scalars.iter().zip(&targets) {
                        put(&mut mesh, target, i, *x);
                    }
                }
            }
        }
        let n_lists = element.properties.iter().filter(|p| p.list.is_some()).count();
        note(mended, n_lists, "vertex list properties passed over");
        finish(&mut mesh, element, &targets);
        Ok(Self { mesh })
    }
}

/// Decides where each property goes, and makes room for it.
fn targets(element: &ElementHeader, n: usize, mesh: &mut RawMesh) -> Vec<Target> {
    let is_scalar = |p: &Property| p.list.is_none();
    let named = |own_wanted: Own| {
        let found = element.properties.iter().filter(|p| is_scalar(p)).filter_map(|p| own(&p.name));
        found.filter(|(o, c)| *o == own_wanted && *c < own_wanted.n_needed()).count() >= own_wanted.n_needed()
    };
    let mut taken: Vec<(Own, usize)> = Vec::new();
    let targets: Vec<Target> = element
        .properties
        .iter()
        .map(|p| match own(&p.name) {
            _ if !is_scalar(p) => Target::Nowhere,
            // Positions that lack a coordinate lie in the plane where it is zero.
            Some((o, c)) if (o == Own::Position || named(o)) && !taken.contains(&(o, c)) => {
                taken.push((o, c));
                if o == Own::Color && c < 3 && p.kind == Kind::F64 { Target::Light(c) } else { Target::Own(o, c) }
            }
            _ => {
                mesh.fields.push(field(p, Element::Vertex, n));
                Target::Field(mesh.fields.len() - 1)
            }
        })
        .collect();
    mesh.positions = vec![Vec3::ZERO; n];
    if named(Own::Normal) {
        mesh.normals = vec![Vec3::ZERO; n];
    }
    if named(Own::Tangent) {
        mesh.tangents = vec![Vec4::ZERO; n];
    }
    if named(Own::Color) {
        mesh.colors = vec![Vec4::ONE; n];
    }
    let n_sets = (0..16).take_while(|&i| named(Own::Uv(i))).count();
    mesh.uv_sets = (0..n_sets).map(|i| UvSet { name: format!("uv{i}"), uv: vec![Vec2::ZERO; n] }).collect();
    targets
        .into_iter()
        .zip(&element.properties)
        .map(|(target, p)| match target {
            // A UV set whose predecessor is missing is data like any other.
            Target::Own(Own::Uv(i), _) if i >= n_sets => {
                mesh.fields.push(field(p, Element::Vertex, n));
                Target::Field(mesh.fields.len() - 1)
            }
            target => target,
        })
        .collect()
}

fn field(property: &Property, element: Element, n: usize) -> Field {
    let values = if property.kind.fits_f32() { Values::F32(vec![0.0; n]) } else { Values::F64(vec![0.0; n]) };
    Field { name: property.name.clone(), unit: String::new(), element, n_components: 1, values }
}

/// The numbers of one attribute, all components in a row, and how many components there are.
fn numbers(mesh: &mut RawMesh, own: Own) -> (&mut [f32], usize) {
    match own {
        Own::Position => (bytemuck::cast_slice_mut(&mut mesh.positions), 3),
        Own::Normal => (bytemuck::cast_slice_mut(&mut mesh.normals), 3),
        Own::Tangent => (bytemuck::cast_slice_mut(&mut mesh.tangents), 4),
        Own::Color => (bytemuck::cast_slice_mut(&mut mesh.colors), 4),
        Own::Uv(i) => (bytemuck::cast_slice_mut(&mut mesh.uv_sets[i].uv), 2),
    }
}

#[inline]
fn put(mesh: &mut RawMesh, target: &Target, row: usize, x: f64) {
    match *target {
        Target::Own(own, component) => {
            let x = if own.is_v(component) { 1.0 - x } else { x };
            let (numbers, n) = numbers(mesh, own);
            numbers[row * n + component] = x as f32;
        }
        Target::Light(component) => mesh.colors[row][component] = color::linear_from_srgb(x) as f32,
        Target::Field(i) => match &mut mesh.fields[i].values {
            Values::F32(v) => v[row] = x as f32,
            Values::F64(v) => v[row] = x,
        },
        Target::Nowhere => {}
    }
}

impl Own {
    /// Whether it is the texture coordinate that files count upwards.
    fn is_v(self, component: usize) -> bool {
        matches!(self, Own::Uv(_)) && component == 1
    }
}

/// One property of a binary element whose rows all have the same size.
struct Column<'a> {
    rows: &'a [u8],
    size: usize,
    offset: usize,
    kind: Kind,
    little: bool,
}

impl Column<'_> {
    fn copy_to(&self, target: &Target, mesh: &mut RawMesh) {
        match *target {
            Target::Own(own, component) => {
                let is_v = own.is_v(component);
                let (numbers, n) = numbers(mesh, own);
                let out = numbers.iter_mut().skip(component).step_by(n);
                // In f64, so that v of a double property loses nothing before it is flipped.
                if is_v { self.copy(out, |x| (1.0 - x) as f32) } else { self.copy(out, |x| x as f32) }
            }
            Target::Light(component) => {
                let out = mesh.colors.iter_mut().map(|c| &mut c[component]);
                self.copy(out, |x| color::linear_from_srgb(x) as f32);
            }
            Target::Field(i) => match &mut mesh.fields[i].values {
                Values::F32(v) => self.copy(v.iter_mut(), |x| x as f32),
                Values::F64(v) => self.copy(v.iter_mut(), |x| x),
            },
            Target::Nowhere => {}
        }
    }

    fn copy<'a, T: 'a>(&self, out: impl Iterator<Item = &'a mut T>, convert: impl Fn(f64) -> T) {
        fn go<'a, T: 'a, const N: usize>(
            column: &Column,
            out: impl Iterator<Item = &'a mut T>,
            number: impl Fn([u8; N]) -> T,
        ) {
            for (row, out) in column.rows.chunks_exact(column.size).zip(out) {
                let mut bytes = [0; N];
                bytes.copy_from_slice(&row[column.offset..column.offset + N]);
                *out = number(bytes);
            }
        }
        match (self.kind, self.little) {
            (Kind::F32, true) => go(self, out, |b| convert(f32::from_le_bytes(b) as f64)),
            (Kind::F32, false) => go(self, out, |b| convert(f32::from_be_bytes(b) as f64)),
            (Kind::F64, true) => go(self, out, |b| convert(f64::from_le_bytes(b))),
            (Kind::F64, false) => go(self, out, |b| convert(f64::from_be_bytes(b))),
            (Kind::U8, _) => go(self, out, |[b]| convert(b as f64)),
            (kind, little) => {
                let n = kind.size();
                for (row, out) in self.rows.chunks_exact(self.size).zip(out) {
                    *out = convert(kind.number(&row[self.offset..self.offset + n], little));
                }
            }
        }
    }
}

/// Colours to linear light; a mesh without alpha is opaque.
fn finish(mesh: &mut RawMesh, element: &ElementHeader, targets: &[Target]) {
    let of = |component: usize| {
        let is_it = |t: &Target| {
            matches!(t, Target::Own(Own::Color, c) if *c == component)
                || matches!(t, Target::Light(c) if *c == component)
        };
        element.properties.iter().zip(targets).find(|(_, t)| is_it(t))
    };
    let kind = |component| of(component).map(|(p, _)| p.kind);
    let Some((red_property, red_target)) = of(0) else { return };
    let red = red_property.kind;
    let is_light = matches!(red_target, Target::Light(_));
    let alpha = kind(3);
    let whole = |kind: Option<Kind>, colors: &[Vec4], of: fn(&Vec4) -> f32| match kind {
        Some(Kind::U8 | Kind::I8) => 255.0,
        Some(Kind::U16 | Kind::I16) => 65535.0,
        // Some write bytes as floats or ints.
        Some(_) if colors.iter().any(|c| of(c) > 1.0) => 255.0,
        _ => 1.0,
    };
    let scale = whole(Some(red), &mesh.colors, |c| c.truncate().max_element());
    let alpha_scale = whole(alpha, &mesh.colors, |c| c.w);
    for c in &mut mesh.colors {
        let light = |x: f32| match (is_light, scale == 1.0) {
            (true, true) => x,
            // It was bytes in doubles after all.
            (true, false) => linear(color::srgb_from_linear(x as f64) as f32, scale),
            (false, _) => linear(x, scale),
        };
        *c = vec4(light(c.x), light(c.y), light(c.z), if alpha.is_some() { c.w / alpha_scale } else { 1.0 });
    }
}

/// A display value of 0..`scale` to linear light.
pub(super) fn linear(x: f32, scale: f32) -> f32 {
    if scale == 255.0 && (0.0..=255.0).contains(&x) && x.trunc() == x {
        LINEAR_FROM_SRGB8[x as usize]
    } else if x.is_finite() {
        color::linear_from_srgb((x / scale) as f64) as f32
    } else {
        x
    }
}

/// The face element.
#[derive(Default)]
struct Faces {
    triangles: Vec<[u32; 3]>,
    source_faces: Vec<u32>,
    fields: Vec<Field>,
    corner_uv: Option<CornerUv>,
}

/// How a face's lists of numbers are used.
struct CornerList {
    /// Among the face's lists.
    list: usize,
    name: String,
    /// Numbers a corner, as the first face has them; none until then.
    n_components: Option<usize>,
    values: Vec<f32>,
    is_broken: bool,
}

impl Faces {
    fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    fn read(body: &mut Body, element: &ElementHeader, vertices: &Vertices, mended: &mut Vec<Mended>) -> Result<Self> {
        let is_strip = element.name == "tristrips";
        let Some(corners) = corner_property(element) else {
            body.skip(element)?;
            note(mended, element.n as usize, "faces without a list of corners passed over");
            return Ok(Self::default());
        };
        if !is_strip
            && only_triangles(element, body.encoding)
            && let Some(triangles) = read_triangles(body, element)
        {
            return Ok(Self { triangles, ..Default::default() });
        }
        read_faces(body, element, corners, is_strip, vertices, mended)
    }
}

/// Index of the list property with the face's corners, among all properties.
fn corner_property(element: &ElementHeader) -> Option<usize> {
    let named = |p: &Property| ["vertex_indices", "vertex_index"].contains(&p.name.as_str());
    let lists = || element.properties.iter().enumerate().filter(|(_, p)| p.list.is_some());
    lists().find(|(_, p)| named(p)).or_else(|| lists().find(|(_, p)| !p.kind.is_float())).map(|(i, _)| i)
}

/// Whether faces are nothing but a byte-counted list of 4-byte indices in little-endian order.
fn only_triangles(element: &ElementHeader, encoding: Encoding) -> bool {
    let is_index = |p: &Property| p.list == Some(Kind::U8) && matches!(p.kind, Kind::I32 | Kind::U32);
    encoding == Encoding::Little && matches!(&element.properties[..], [p] if is_index(p))
}

/// The fast way: all faces are triangles, thirteen bytes each. None (and nothing read) if one is not.
fn read_triangles(body: &mut Body, element: &ElementHeader) -> Option<Vec<[u32; 3]>> {
    let rows = body.rest();
    let n = usize::try_from(element.n).ok().filter(|n| n.checked_mul(13).is_some_and(|size| size <= rows.len()))?;
    let rows = &rows[..n * 13];
    let mut triangles = Vec::with_capacity(n);
    for row in rows.chunks_exact(13) {
        if row[0] != 3 {
            return None;
        }
        let index = |i: usize| u32::from_le_bytes([row[i], row[i + 1], row[i + 2], row[i + 3]]);
        triangles.push([index(1), index(5), index(9)]);
    }
    body.at += n * 13;
    Some(triangles)
}

fn read_faces(
    body: &mut Body,
    element: &ElementHeader,
    corners: usize,
    is_strip: bool,
    vertices: &Vertices,
    mended: &mut Vec<Mended>,
) -> Result<Faces> {
    let mut faces = Faces::default();
    let positions = &vertices.mesh.positions;
    let is_list = |i: &usize| element.properties[*i].list.is_some();
    let which_list = (0..corners).filter(is_list).count();
    let scalars: Vec<usize> = (0..element.properties.len()).filter(|i| !is_list(i)).collect();
    faces.fields = scalars.iter().map(|&i| field(&element.properties[i], Element::Face, 0)).collect();
    let mut lists: Vec<CornerList> = (0..element.properties.len())
        .filter(is_list)
        .enumerate()
        .filter(|(list, _)| *list != which_list)
        .map(|(list, i)| CornerList {
            list,
            name: element.properties[i].name.clone(),
            n_components: None,
            values: Vec::new(),
            is_broken: is_strip,
        })
        .collect();
    let n = body.n_rows(element);
    let (mut row, mut triangulator) = (Row::default(), Triangulator::default());
    let (mut n_small, mut n_read, mut all_triangles) = (0, 0, true);
    // Exact for the usual file of triangles, and never much more than the file.
    faces.triangles.reserve_exact(n.min(body.rest().len() / 7));
    for face in 0..n {
        if !body.row(element, &mut row)? {
            break;
        }
        n_read += 1;
        let list = row.lists[which_list].clone();
        let index = |i: usize| index(row.entries[list.start + i]);
        let before = faces.triangles.len();
        let n_corners = list.len();
        if is_strip {
            strip(n_corners, index, &mut faces.triangles);
        } else {
            let at = |i: usize| positions.get(index(i) as usize).copied().unwrap_or(Vec3::NAN);
            triangulator.cut(n_corners, at, |t| {
                faces.triangles.push(t.map(|i| index(i as usize)));
                lists.iter_mut().for_each(|l| l.add(t, n_corners, &row));
            });
        }
        let n_new = faces.triangles.len() - before;
        n_small += (n_new == 0) as usize;
        if all_triangles && n_new != 1 {
            all_triangles = false;
            faces.source_faces = (0..before as u32).collect();
        }
        if !all_triangles {
            faces.source_faces.extend(std::iter::repeat_n(face as u32, n_new));
        }
        for (field, &i) in faces.fields.iter_mut().zip(&scalars) {
            match &mut field.values {
                Values::F32(v) => v.extend(std::iter::repeat_n(row.scalars[i] as f32, n_new)),
                Values::F64(v) => v.extend(std::iter::repeat_n(row.scalars[i], n_new)),
            }
        }
    }
    note(mended, n_small, "faces with fewer than three corners dropped");
    let n_missing = usize::try_from(element.n).unwrap_or(usize::MAX) - n_read;
    note(mended, n_missing, "faces that the header claims are not in the file");
    let is_whole = |l: &CornerList| !l.is_broken && l.n_components.is_some_and(|n| n > 0);
    note(
        mended,
        lists.iter().filter(|l| !is_whole(l)).count(),
        "face list properties without values for each corner dropped",
    );
    for list in lists.into_iter().filter(is_whole) {
        let n_components = list.n_components.unwrap_or(1);
        if n_components == 2 && list.name.starts_with("texcoord") && faces.corner_uv.is_none() {
            let uv = list.values.chunks_exact(2).map(|c| vec2(c[0], 1.0 - c[1])).collect();
            faces.corner_uv = Some(CornerUv { uv });
        } else {
            let values = Values::F32(list.values);
            let field = Field { name: list.name, unit: String::new(), element: Element::Corner, n_components, values };
            faces.fields.push(field);
        }
    }
    Ok(faces)
}

impl CornerList {
    /// Takes a triangle's share of a polygon's list.
    fn add(&mut self, triangle: [u32; 3], n_corners: usize, row: &Row) {
        let entries = &row.entries[row.lists[self.list].clone()];
        let n = *self.n_components.get_or_insert(entries.len() / n_corners);
        // A face without the list has no values; any other length means that it is not a list for corners.
        if self.is_broken || !entries.is_empty() && entries.len() != n * n_corners || n == 0 {
            self.is_broken = true;
            return;
        }
        for i in triangle {
            match entries.get(i as usize * n..(i as usize + 1) * n) {
                Some(values) => self.values.extend(values.iter().map(|x| *x as f32)),
                None => self.values.extend(std::iter::repeat_n(f32::NAN, n)),
            }
        }
    }
}

/// Triangles of strips in one list, each ended by -1.
fn strip(n: usize, index: impl Fn(usize) -> u32, triangles: &mut Vec<[u32; 3]>) {
    let (mut start, mut i) = (0, 0);
    while i < n {
        if index(i) == u32::MAX {
            start = i + 1;
        } else if i >= start + 2 {
            let (a, b, c) = (index(i - 2), index(i - 1), index(i));
            triangles.push(if (i - start) % 2 == 0 { [a, b, c] } else { [b, a, c] });
        }
        i += 1;
    }
}

/// Fields named `name[0]`, `name[1]` ... in a row become one field with components, as our writer parted it.
fn merge_components(fields: &mut Vec<Field>) {
    fn component(name: &str) -> Option<(&str, usize)> {
        let (stem, i) = name.strip_suffix(']')?.rsplit_once('[')?;
        Some((stem, i.parse().ok()?))
    }
    let mut merged: Vec<Field> = Vec::with_capacity(fields.len());
    let mut rest = std::mem::take(fields).into_iter().peekable();
    while let Some(first) = rest.next() {
        let Some((stem, 0)) = component(&first.name) else {
            merged.push(first);
            continue;
        };
        let stem = stem.to_string();
        let mut parts = vec![first];
        while let Some(next) = rest.next_if(|f| {
            f.element == parts[0].element
                && f.n_components == 1
                && component(&f.name) == Some((&stem, parts.len()))
                && matches!(
                    (&f.values, &parts[0].values),
                    (Values::F32(_), Values::F32(_)) | (Values::F64(_), Values::F64(_))
                )
        }) {
            parts.push(next);
        }
        merged.push(interleaved(stem, parts));
    }
    *fields = merged;
}

fn interleaved(name: String, parts: Vec<Field>) -> Field {
    let n_components = parts.len();
    let n = parts[0].values.len();
    let each = || (0..n).flat_map(|i| parts.iter().map(move |p| p.values.at(i)));
    let values = match parts[0].values {
        Values::F32(_) => Values::F32(each().map(|x| x as f32).collect()),
        Values::F64(_) => Values::F64(each().collect()),
    };
    Field { name, unit: parts[0].unit.clone(), element: parts[0].element, n_components, values }
}

#[cfg(test)]
#[path = "ply_tests.rs"]
mod tests;
