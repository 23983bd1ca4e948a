//! Finer triangles where a curved cut comes through.
//!
//! An edge is halved if it is too long and the cut may cross it; that depends on its ends only, so neighbours agree and no
//! crack opens. A triangle with halved edges becomes two, three or four.

use super::crossing::Map;
use super::soup::Soup;
use crate::assets::{Element, Field, Part, RawMesh, UvSet, Values};
use crate::math::{DVec3, Vec3};

/// A mesh whose edges near the cut are no longer than `edge`. `distance` must grow no faster than the way.
pub(super) fn refine(soup: Soup, distance: &dyn Fn(DVec3) -> f64, edge: f32) -> RawMesh {
    let mut raw = RawMesh {
        positions: soup.positions.to_vec(),
        triangles: soup.triangles.to_vec(),
        normals: soup.normals.to_vec(),
        tangents: soup.tangents.to_vec(),
        colors: soup.colors.to_vec(),
        uv_sets: soup.uv_sets.to_vec(),
        fields: soup.fields.to_vec(),
        parts: soup.parts.to_vec(),
        source_points: soup.source_points.to_vec(),
        source_faces: soup.source_faces.to_vec(),
        n_source_points: soup.n_source_points,
        n_source_faces: soup.n_source_faces,
    };
    if raw.source_points.is_empty() {
        raw.source_points = (0..raw.positions.len() as u32).collect();
    }
    if raw.source_faces.is_empty() {
        raw.source_faces = (0..raw.triangles.len() as u32).collect();
    }
    let at = |p: Vec3| distance(p.as_dvec3()).abs();
    let mut distances: Vec<f64> = raw.positions.iter().map(|&p| at(p)).collect();
    // Halving twelve times makes 4096 edges of one.
    for _ in 0..12 {
        if !halve(&mut raw, &mut distances, &at, edge as f64) {
            break;
        }
    }
    raw
}

/// Halves all edges that need it, once; whether there were any.
fn halve(raw: &mut RawMesh, distances: &mut Vec<f64>, distance: &dyn Fn(Vec3) -> f64, edge: f64) -> bool {
    let mut middles: Map<(u32, u32), u32> = Map::default();
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    let n_old = raw.positions.len() as u32;
    for t in &raw.triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let [pa, pb] = [a, b].map(|v| raw.positions[v as usize].as_dvec3());
            let length = (pb - pa).length();
            let is_near = distances[a as usize] + distances[b as usize] <= 1.5 * length;
            // Not finer than the coordinates are.
            let middle = ((pa + pb) * 0.5).as_vec3();
            let is_point = middle == raw.positions[a as usize] || middle == raw.positions[b as usize];
            if length > edge && is_near && !is_point {
                middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    pairs.push([a.min(b), a.max(b)]);
                    n_old + pairs.len() as u32 - 1
                });
            }
        }
    }
    if pairs.is_empty() {
        return false;
    }
    add_vertices(raw, &pairs);
    distances.extend(raw.positions[n_old as usize..].iter().map(|&p| distance(p)));
    split_triangles(raw, &middles);
    true
}

fn add_vertices(raw: &mut RawMesh, pairs: &[[u32; 2]]) {
    fn extend<T: Copy>(v: &mut Vec<T>, pairs: &[[u32; 2]], mean: impl Fn(T, T) -> T) {
        if !v.is_empty() {
            let new: Vec<T> = pairs.iter().map(|&[a, b]| mean(v[a as usize], v[b as usize])).collect();
            v.extend(new);
        }
    }
    extend(&mut raw.positions, pairs, |a, b| ((a.as_dvec3() + b.as_dvec3()) * 0.5).as_vec3());
    extend(&mut raw.normals, pairs, |a, b| (a + b).normalize_or(a));
    extend(&mut raw.tangents, pairs, |a, b| (a.truncate() + b.truncate()).normalize_or(a.truncate()).extend(a.w));
    extend(&mut raw.colors, pairs, |a, b| (a + b) * 0.5);
    extend(&mut raw.source_points, pairs, |a, _| a);
    for UvSet { uv, .. } in &mut raw.uv_sets {
        extend(uv, pairs, |a, b| (a + b) * 0.5);
    }
    for field in raw.fields.iter_mut().filter(|f| f.element == Element::Vertex) {
        let n = field.n_components;
        let mean = |values: &Values, k: usize, [a, b]: [u32; 2]| {
            (values.at(a as usize * n + k) + values.at(b as usize * n + k)) * 0.5
        };
        let new: Vec<f64> =
            pairs.iter().flat_map(|&p| (0..n).map(move |k| (k, p))).map(|(k, p)| mean(&field.values, k, p)).collect();
        match &mut field.values {
            Values::F32(v) => v.extend(new.iter().map(|&x| x as f32)),
            Values::F64(v) => v.extend(new),
        }
    }
}

/// Corners of a triangle's parts: 0 to 2 are its own, 3 to 5 the middles of the edges from these to the next.
pub(super) fn parts(halved: [bool; 3]) -> &'static [[usize; 3]] {
    match halved {
        [false, false, false] => &[[0, 1, 2]],
        [true, false, false] => &[[0, 3, 2], [3, 1, 2]],
        [false, true, false] => &[[1, 4, 0], [4, 2, 0]],
        [false, false, true] => &[[2, 5, 1], [5, 0, 1]],
        [true, true, false] => &[[3, 1, 4], [0, 3, 4], [0, 4, 2]],
        [false, true, true] => &[[4, 2, 5], [1, 4, 5], [1, 5, 0]],
        [true, false, true] => &[[5, 0, 3], [2, 5, 3], [2, 3, 1]],
        [true, true, true] => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    }
}

fn split_triangles(raw: &mut RawMesh, middles: &Map<(u32, u32), u32>) {
    let old = std::mem::take(&mut raw.triangles);
    let old_faces = std::mem::take(&mut raw.source_faces);
    // For each new triangle, which old one, and its corners there.
    let mut from: Vec<(u32, [usize; 3])> = Vec::with_capacity(old.len());
    let mut starts = Vec::with_capacity(old.len() + 1);
    for (t, corners) in old.iter().enumerate() {
        starts.push(from.len() as u32);
        let middle = [0, 1, 2].map(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            middles.get(&(a.min(b), a.max(b))).copied()
        });
        let all = |k: usize| if k < 3 { corners[k] } else { middle[k - 3].unwrap_or(corners[k - 3]) };
        for part in parts(middle.map(|m| m.is_some())) {
            raw.triangles.push(part.map(all));
            raw.source_faces.push(old_faces[t]);
            from.push((t as u32, *part));
        }
    }
    starts.push(from.len() as u32);
    for Part { triangles, .. } in &mut raw.parts {
        *triangles = starts[triangles.start as usize]..starts[triangles.end as usize];
    }
    for field in &mut raw.fields {
        spread(field, &from);
    }
}

/// A face's or corner's field to the new triangles.
fn spread(field: &mut Field, from: &[(u32, [usize; 3])]) {
    let n = field.n_components;
    match field.element {
        Element::Vertex => {}
        Element::Face => {
            let source: Vec<u32> = from.iter().map(|f| f.0).collect();
            field.values = field.values.gathered(&source, n);
        }
        Element::Corner => {
            let old = field.values.clone();
            let at = |t: u32, c: usize, k: usize| old.at((t as usize * 3 + c) * n + k);
            let value = |t: u32, c: usize, k: usize| match c {
                0..3 => at(t, c, k),
                _ => (at(t, c - 3, k) + at(t, (c - 2) % 3, k)) * 0.5,
            };
            let all = from.iter().flat_map(|&(t, part)| part.map(|c| (t, c)));
            let new = all.flat_map(|(t, c)| (0..n).map(move |k| (t, c, k))).map(|(t, c, k)| value(t, c, k));
            field.values = match field.values {
                Values::F32(_) => Values::F32(new.map(|x| x as f32).collect()),
                Values::F64(_) => Values::F64(new.collect()),
            };
        }
    }
}
