//! Grids of surface points to triangles: the one way in which samples become meshes.

use crate::assets::{Mesh, Part, RawMesh, UvSet};
use crate::math::{DVec2, DVec3};

/// A surface point.
#[derive(Clone, Copy)]
pub(super) struct Point {
    /// Model units.
    pub(super) position: DVec3,
    /// Any length, away from the front.
    pub(super) normal: DVec3,
    /// v down.
    pub(super) uv: DVec2,
}

/// No triangles, one empty UV set.
pub(super) fn empty() -> RawMesh {
    RawMesh { uv_sets: vec![UvSet { name: "uv0".into(), uv: Vec::new() }], ..RawMesh::default() }
}

/// Adds a vertex; its index.
pub(super) fn push(raw: &mut RawMesh, p: Point) -> u32 {
    raw.positions.push(p.position.as_vec3());
    raw.normals.push(p.normal.normalize_or(DVec3::Y).as_vec3());
    raw.uv_sets[0].uv.push(p.uv.as_vec2());
    raw.positions.len() as u32 - 1
}

/// Adds n[0] x n[1] cells over points (i, j); the front is where i runs right and j up. A cell is split along its shorter
/// diagonal. Points that coincide (poles) leave no triangle behind.
pub(super) fn grid(raw: &mut RawMesh, n: [u32; 2], point: impl Fn(u32, u32) -> Point) {
    let base = raw.positions.len() as u32;
    for j in 0..=n[1] {
        for i in 0..=n[0] {
            push(raw, point(i, j));
        }
    }
    for j in 0..n[1] {
        for i in 0..n[0] {
            let a = base + j * (n[0] + 1) + i;
            let (b, c) = (a + 1, a + n[0] + 1);
            quad(raw, [a, b, c + 1, c]);
        }
    }
}

/// Adds the two triangles of a quad with its corners in counter-clockwise order, without those that have no area.
pub(super) fn quad(raw: &mut RawMesh, [a, b, c, d]: [u32; 4]) {
    let p = |i: u32| raw.positions[i as usize];
    // A clear preference only, so that a symmetric grid keeps one direction.
    let halves = if p(b).distance_squared(p(d)) < 0.999 * p(a).distance_squared(p(c)) {
        [[a, b, d], [b, c, d]]
    } else {
        [[a, b, c], [a, c, d]]
    };
    for [i, j, k] in halves {
        if p(i) != p(j) && p(j) != p(k) && p(k) != p(i) {
            raw.triangles.push([i, j, k]);
        }
    }
}

/// Names all triangles since the last part.
pub(super) fn part(raw: &mut RawMesh, name: &str, material: Option<u32>) {
    let start = raw.parts.last().map_or(0, |p| p.triangles.end);
    let triangles = start..raw.triangles.len() as u32;
    raw.parts.push(Part { name: name.into(), triangles, material });
}

/// The finished mesh, without vertices that no triangle uses.
pub(super) fn finish(mut raw: RawMesh) -> Mesh {
    let mut is_used = vec![false; raw.positions.len()];
    raw.triangles.iter().flatten().for_each(|&i| is_used[i as usize] = true);
    let mut new_of_old = vec![0u32; is_used.len()];
    let mut n = 0;
    for (i, used) in is_used.iter().enumerate() {
        new_of_old[i] = n;
        n += *used as u32;
    }
    fn keep<T>(v: &mut Vec<T>, is_used: &[bool]) {
        let mut flags = is_used.iter();
        v.retain(|_| *flags.next().expect("one entry a vertex"));
    }
    keep(&mut raw.positions, &is_used);
    keep(&mut raw.normals, &is_used);
    raw.uv_sets.iter_mut().for_each(|set| keep(&mut set.uv, &is_used));
    if !raw.colors.is_empty() {
        keep(&mut raw.colors, &is_used);
    }
    let kept: Vec<u32> = (0..is_used.len() as u32).filter(|&i| is_used[i as usize]).collect();
    raw.fields.iter_mut().for_each(|f| f.values = f.values.gathered(&kept, f.n_components));
    raw.triangles.iter_mut().flatten().for_each(|i| *i = new_of_old[*i as usize]);
    let report = raw.mend();
    debug_assert!(report.mended.is_empty(), "samples need no mending: {:?}", report.mended);
    report.value
}
