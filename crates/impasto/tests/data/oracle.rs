//! A slow, plain second opinion in f64: which point of which triangle a pixel sees, and the value there.

use impasto::assets::{Element, Field, Mesh, RawMesh, Values, ply_write};
use impasto::color::LinearRgba;
use impasto::inspect;
use impasto::lookup::{ColorTable, Texture};
use impasto::math::{DVec3, Projection, Vec3};
use impasto::par::Workers;
use impasto::recipe::{self, Prepared, View, text};
use impasto::visibility::{Camera, Hit, Samples};
use std::f64::consts::TAU;
use std::path::Path;

/// Flat grids of `n` x `n` quads over [-1, 1] in x and y.
pub(crate) fn sheet(n: u32, height: impl Fn(f64, f64) -> f64) -> RawMesh {
    let at = |i: u32| i as f64 / n as f64 * 2.0 - 1.0;
    let mut raw = RawMesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (at(i), at(j));
            raw.positions.push(Vec3::new(x as f32, y as f32, height(x, y) as f32));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
            raw.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    raw
}

/// A cone around +Y with its tip at height 1 and a rim of radius 1 at height 0, open below.
pub(crate) fn cone(n: u32) -> RawMesh {
    let rim = (0..n).map(|i| TAU * i as f64 / n as f64).map(|a| Vec3::new(a.cos() as f32, 0.0, a.sin() as f32));
    let positions = std::iter::once(Vec3::Y).chain(rim).collect();
    let triangles = (0..n).map(|i| [0, 1 + (i + 1) % n, 1 + i]).collect();
    RawMesh { positions, triangles, ..RawMesh::default() }
}

/// A sphere of 600 triangles: 20 around, 16 from pole to pole.
pub(crate) fn sphere() -> RawMesh {
    const AROUND: u32 = 20;
    const DOWN: u32 = 16;
    let mut raw = RawMesh::default();
    let point = |i: u32, j: u32| {
        let (a, b) = (TAU * i as f64 / AROUND as f64, TAU * 0.5 * j as f64 / DOWN as f64);
        Vec3::new((b.sin() * a.sin()) as f32, b.cos() as f32, (b.sin() * a.cos()) as f32)
    };
    raw.positions.push(Vec3::Y);
    raw.positions.extend((1..DOWN).flat_map(|j| (0..AROUND).map(move |i| point(i, j))));
    raw.positions.push(Vec3::NEG_Y);
    let last = raw.positions.len() as u32 - 1;
    let at = |i: u32, j: u32| 1 + (j - 1) * AROUND + i % AROUND;
    for i in 0..AROUND {
        raw.triangles.push([0, at(i, 1), at(i + 1, 1)]);
        for j in 1..DOWN - 1 {
            let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
            raw.triangles.extend([[a, b, c], [a, c, d]]);
        }
        raw.triangles.push([at(i, DOWN - 1), last, at(i + 1, DOWN - 1)]);
    }
    raw.normals.clone_from(&raw.positions);
    assert_eq!(raw.triangles.len(), 600);
    raw
}

/// The mesh with a field of one number a vertex, by place.
pub(crate) fn with_values(mut raw: RawMesh, name: &str, value: impl Fn(DVec3) -> f64) -> RawMesh {
    let values = Values::F64(raw.positions.iter().map(|p| value(p.as_dvec3())).collect());
    raw.fields.push(field(name, Element::Vertex, 1, values));
    raw
}

pub(crate) fn field(name: &str, element: Element, n_components: usize, values: Values) -> Field {
    Field { name: name.into(), unit: String::new(), element, n_components, values }
}

/// The mesh as a file, and a recipe over it: all that a user's picture goes through.
pub(crate) fn prepare(raw: &RawMesh, recipe: &str) -> Prepared {
    prepare_with(raw, recipe, &[])
}

/// The same with further files beside it.
pub(crate) fn prepare_with(raw: &RawMesh, recipe: &str, files: &[(&str, String)]) -> Prepared {
    let folder = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
    std::fs::write(folder.path().join("a.ply"), ply_write::write(&raw.clone().mend().value)).unwrap();
    let toml = format!("input.file = 'a.ply'\n{recipe}");
    let mut recipe = text::parse(&toml, Path::new("inline")).unwrap();
    // The whole picture is the object's.
    recipe.legend.place = Some("none".into());
    recipe::prepare(&recipe, folder.path(), &Workers::new(1)).unwrap_or_else(|e| panic!("{e}: {toml}")).value
}

/// Looking straight at the sheet, which fills the square picture; parallel lines of sight, no light.
pub(crate) fn front(n: u32) -> String {
    format!("camera = {{ view = 'front', orthographic = true, fill = 1.0 }}\n{}", plain(n))
}

/// A square picture of one sample a pixel under no light.
pub(crate) fn plain(n: u32) -> String {
    format!("picture = {{ size = [{n}, {n}], samples = 1, unlit = true, background = 'transparent' }}\n")
}

/// So far, in pixels, f32 may move a corner in the picture.
const BESIDE: f64 = 1e-4;

/// A covered pixel.
pub(crate) struct Seen {
    pub(crate) cell: [u32; 2],
    pub(crate) triangle: usize,
    /// Of the three corners, in space; worked out here, not by the engine.
    pub(crate) weights: [f64; 3],
    /// What they are [`BESIDE`] pixels to the right, and down.
    pub(crate) beside: [[f64; 3]; 2],
    /// In space, by the same.
    pub(crate) place: DVec3,
    /// What the picture has there: linear, premultiplied.
    pub(crate) light: LinearRgba,
}

/// All covered pixels.
pub(crate) fn seen(prepared: &Prepared) -> Vec<Seen> {
    let workers = Workers::new(1);
    let picture = prepared.light(&workers, &|_| ());
    let (domain, shot) = (prepared.domain(), prepared.shot(Samples::One));
    let ids = inspect::probe::buffer(&domain, &shot, &workers).ids();
    let View::Camera(camera) = prepared.view else { panic!("these tests look through cameras") };
    let size = prepared.size;
    let covered = ids.iter().enumerate().filter(|(_, id)| **id != Hit::NOTHING);
    covered
        .map(|(i, &id)| {
            let cell = [i as u32 % size.width, i as u32 / size.width];
            let [x, y] = cell.map(|c| c as f64 + 0.5);
            let at = |at: [f64; 2]| {
                let (eye, way) = line_of_sight(&camera, at, [size.width as f64, size.height as f64]);
                meet(&prepared.scene.mesh, id as usize, eye, way)
            };
            let (weights, place) = at([x, y]);
            let beside = [[x + BESIDE, y], [x, y + BESIDE]].map(|place| at(place).0);
            Seen { cell, triangle: id as usize, weights, beside, place, light: picture.light[i] }
        })
        .collect()
}

/// Through a place of the picture.
fn line_of_sight(camera: &Camera, [x, y]: [f64; 2], [w, h]: [f64; 2]) -> (DVec3, DVec3) {
    let [right, up, back] = camera.axes().map(|a| a.as_dvec3());
    let (x, y) = (x / w * 2.0 - 1.0, 1.0 - y / h * 2.0);
    let eye = camera.eye().as_dvec3();
    match camera.projection {
        Projection::Orthographic { height } => {
            let half = height as f64 * 0.5;
            (eye + right * (x * half * w / h) + up * (y * half), -back)
        }
        Projection::Perspective { fov_y } => {
            let tan = (fov_y as f64 * 0.5).tan();
            (eye, right * (x * tan * w / h) + up * (y * tan) - back)
        }
    }
}

/// Where a line meets a triangle's plane (Moeller and Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997).
fn meet(mesh: &Mesh, triangle: usize, eye: DVec3, way: DVec3) -> ([f64; 3], DVec3) {
    let [a, b, c] = mesh.triangles()[triangle].map(|v| mesh.positions()[v as usize].as_dvec3());
    let (e1, e2) = (b - a, c - a);
    let p = way.cross(e2);
    let per_volume = 1.0 / e1.dot(p);
    let s = eye - a;
    let b1 = s.dot(p) * per_volume;
    let q = s.cross(e1);
    let b2 = way.dot(q) * per_volume;
    ([1.0 - b1 - b2, b1, b2], eye + way * (e2.dot(q) * per_volume))
}

/// A field's number at a pixel, interpolated in f64.
pub(crate) fn value(mesh: &Mesh, name: &str, component: Option<usize>, seen: &Seen) -> f64 {
    let field = mesh.fields().iter().find(|f| f.name == name).expect("the mesh has the field");
    let n = field.n_components;
    let at = |element: usize| match component {
        Some(c) => field.values.at(element * n + c),
        None => (0..n).map(|c| field.values.at(element * n + c).powi(2)).sum::<f64>().sqrt(),
    };
    if field.element == Element::Face {
        return at(seen.triangle);
    }
    let corners = mesh.triangles()[seen.triangle];
    (0..3).map(|k| seen.weights[k] * at(corners[k] as usize)).sum()
}

/// The picture's only table.
pub(crate) fn table(prepared: &Prepared) -> &ColorTable {
    let mut tables = prepared.looks.textures.iter().filter_map(|t| match t {
        Texture::Table(table) => Some(table),
        _ => None,
    });
    tables.next_back().expect("a layer has a table")
}

/// The entry of a table of `n` that a share of the range, 0 to 1, falls into; none within `tolerance` of a border.
pub(crate) fn entry(share: f64, n: usize, tolerance: f64) -> Option<usize> {
    let place = share * n as f64;
    let is_near = (place - place.round()).abs() < tolerance * n as f64;
    let is_inner = place > 0.5 && place < n as f64 - 0.5;
    (!(is_near && is_inner)).then(|| (place.max(0.0) as usize).min(n - 1))
}
