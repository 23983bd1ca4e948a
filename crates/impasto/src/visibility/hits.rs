//! Triangle ids to surface points: everything that is derived and never stored.
//!
//! Barycentrics come from the corners' homogeneous cell coordinates (Olano, Greer, "Triangle Scan Conversion using 2D
//! Homogeneous Coordinates", 1997), so clipped triangles need no special care, and their derivatives are exact at every
//! cell, also where a triangle covers only one.

use super::Domain;
use super::tile::TILE;
use crate::math::{BATCH, Lane, Vec2, Vec3};
use crate::placement::{Needs, Surfels};
use fearless_simd::{f32x8, prelude::*};

/// How many surface points a batch may hold when it is filled here: runs are written eight lanes at a time.
pub const BATCH_FILL: usize = BATCH - 8;

/// Lanes of a vector.
const N: usize = 8;

/// A stretch of the batch in one triangle, and what its barycentrics come from.
#[derive(Clone, Copy)]
struct Run {
    start: usize,
    end: usize,
    triangle: u32,
    /// Coefficients of column for the second and third corner's edge function, and for the sum of all three.
    a: [f32; 3],
    /// The same for row.
    b: [f32; 3],
}

/// Derives the lanes that `needs` asks for from `cell`, `triangle` and `n`. `place` is where in their cells they look, in
/// 1/256 of a cell. `n` is at most [`BATCH_FILL`].
///
/// An answer depends on its own cell and triangle only, not on its neighbours in the batch.
#[inline(always)]
pub fn fill<S: Simd>(simd: S, domain: &Domain, needs: Needs, place: [i32; 2], surfels: &mut Surfels) {
    let mut runs = [Run { start: 0, end: 0, triangle: 0, a: [0.0; 3], b: [0.0; 3] }; BATCH];
    let mut sum = [0.0; BATCH];
    let n_runs = edges(simd, domain, place, surfels, &mut sum, &mut runs);
    let runs = &runs[..n_runs];
    weights(simd, surfels, &mut sum);
    if needs.derivatives {
        for run in runs {
            derivatives(simd, run, surfels, &sum);
        }
    }
    let mesh = domain.mesh;
    let corner = |t: u32| mesh.triangles()[t as usize];
    for run in runs {
        let c = corner(run.triangle);
        if needs.normal {
            interpolate(
                simd,
                run,
                &surfels.barycentric,
                c.map(|i| mesh.normals()[i as usize].to_array()),
                &mut surfels.normal,
            );
        }
        if needs.position {
            let p = c.map(|i| mesh.positions()[i as usize].to_array());
            interpolate(simd, run, &surfels.barycentric, p, &mut surfels.position);
        }
        let mut sets = needs.uv_sets;
        while sets != 0 {
            let set = sets.trailing_zeros() as usize;
            sets &= sets - 1;
            uv(simd, run, set, c.map(|i| mesh.uv_sets()[set].uv[i as usize]), surfels, &sum);
        }
        if needs.tangent {
            let t = c.map(|i| mesh.tangents()[i as usize].to_array());
            interpolate(simd, run, &surfels.barycentric, t, &mut surfels.tangent);
            // The sign is a corner's, not a mixture: all three agree where the layout is not mirrored.
            surfels.tangent[3][run.start..run.end].fill(if t[0][3] < 0.0 { -1.0 } else { 1.0 });
        }
        if needs.color {
            let v = c.map(|i| mesh.colors()[i as usize].to_array());
            interpolate(simd, run, &surfels.barycentric, v, &mut surfels.color);
        }
    }
    if needs.normal {
        unit(simd, surfels.n, &mut surfels.normal);
    }
    if needs.tangent {
        let [x, y, z, _] = &mut surfels.tangent;
        unit3(simd, surfels.n, x, y, z);
    }
    if needs.view {
        view(simd, domain, place, surfels);
    }
}

/// Finds the runs and evaluates edge functions: the second and third corner's into `barycentric`, the sum into `sum`.
#[inline(always)]
fn edges<S: Simd>(
    simd: S,
    domain: &Domain,
    place: [i32; 2],
    surfels: &mut Surfels,
    sum: &mut Lane,
    runs: &mut [Run; BATCH],
) -> usize {
    let n = surfels.n;
    assert!(n <= BATCH_FILL, "a batch is filled with at most {BATCH_FILL} points");
    let mut n_runs = 0;
    let mut start = 0;
    while start < n {
        let triangle = surfels.triangle[start];
        // All cells of a run are measured from one origin: the corner of the tile they lie in. It must not depend on
        // the batch, hence a change of tile ends a run.
        let tile = [surfels.cell[0][start] / TILE as u32, surfels.cell[1][start] / TILE as u32];
        let mut end = start + 1;
        while end < n
            && surfels.triangle[end] == triangle
            && surfels.cell[0][end] / TILE as u32 == tile[0]
            && surfels.cell[1][end] / TILE as u32 == tile[1]
        {
            end += 1;
        }
        let origin = tile.map(|t| t * TILE as u32);
        let set_up = SetUp::new(domain, triangle, origin);
        let front = if set_up.area < 0.0 { 1.0 } else { -1.0 };
        let offset = [0, 1].map(|k| place[k] as f32 * (1.0 / 256.0));
        for i in (start..end).step_by(N) {
            // Whole cells from the origin plus the place: exact in f32.
            let coordinate = |k: usize| {
                let cells: &[u32; N] = surfels.cell[k][i..i + N].try_into().expect("a vector of cells");
                f32x8::from_fn(simd, |l| cells[l].wrapping_sub(origin[k]) as i32 as f32) + f32x8::splat(simd, offset[k])
            };
            let (x, y) = (coordinate(0), coordinate(1));
            let edge = |k: usize| {
                let row = f32x8::splat(simd, set_up.c[k]) + f32x8::splat(simd, set_up.b[k]) * y;
                row + f32x8::splat(simd, set_up.a[k]) * x
            };
            store(edge(0), &mut surfels.barycentric[0], i);
            store(edge(1), &mut surfels.barycentric[1], i);
            store(edge(2), sum, i);
            store(f32x8::splat(simd, front), &mut surfels.side, i);
        }
        runs[n_runs] = Run { start, end, triangle, a: set_up.a, b: set_up.b };
        n_runs += 1;
        start = end;
    }
    n_runs
}

/// A triangle's edge functions of the second and third corner, and the sum of all three: `a * x + b * y + c`.
struct SetUp {
    a: [f32; 3],
    b: [f32; 3],
    c: [f32; 3],
    /// Sign of the triangle's area with y down: negative is counter-clockwise with y up, the front.
    area: f64,
}

impl SetUp {
    #[inline(always)]
    fn new(domain: &Domain, triangle: u32, origin: [u32; 2]) -> Self {
        let v = domain.mesh.triangles()[triangle as usize].map(|i| {
            let c = domain.corner(i);
            let w = c.w as f64;
            // Relative to the origin, where little is lost by cancellation.
            [c.x as f64 - origin[0] as f64 * w, c.y as f64 - origin[1] as f64 * w, w]
        });
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let (e0, e1, e2) = (cross(v[1], v[2]), cross(v[2], v[0]), cross(v[0], v[1]));
        let s = [e0[0] + e1[0] + e2[0], e0[1] + e1[1] + e2[1], e0[2] + e1[2] + e2[2]];
        let area = v[0][0] * e0[0] + v[0][1] * e0[1] + v[0][2] * e0[2];
        // Any common factor is allowed: this one keeps f32 far from its limits whatever the model's unit.
        let largest = s[2].abs().max(e1[2].abs()).max(e2[2].abs()).max(s[0].abs()).max(s[1].abs());
        let k = if largest > 0.0 { 1.0 / largest } else { 0.0 };
        let pick = |i: usize| [(e1[i] * k) as f32, (e2[i] * k) as f32, (s[i] * k) as f32];
        Self { a: pick(0), b: pick(1), c: pick(2), area }
    }
}

/// Edge functions to barycentrics within the triangle; the sum's inverse replaces the sum.
#[inline(always)]
fn weights<S: Simd>(simd: S, surfels: &mut Surfels, sum: &mut Lane) {
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    for i in (0..surfels.n).step_by(N) {
        let s = load(simd, sum, i);
        // A triangle without area (only possible for ids that no raster made) gives its first corner.
        let r = one / s;
        let r = s.simd_eq(zero).select(zero, r);
        // At silhouettes a cell's centre may lie just outside of the triangle: the nearest weights inside stand for it.
        let clamp = |e: f32x8<S>, most: f32x8<S>| {
            let b = e * r;
            let b = b.simd_gt(zero).select(b, zero);
            b.simd_lt(most).select(b, most)
        };
        let b1 = clamp(load(simd, &surfels.barycentric[0], i), one);
        let b2 = clamp(load(simd, &surfels.barycentric[1], i), one - b1);
        store(b1, &mut surfels.barycentric[0], i);
        store(b2, &mut surfels.barycentric[1], i);
        store(r, sum, i);
    }
}

/// How barycentrics change per cell: the quotient rule on edge function over sum.
#[inline(always)]
fn derivatives<S: Simd>(simd: S, run: &Run, surfels: &mut Surfels, inverse: &Lane) {
    for i in (run.start..run.end).step_by(N) {
        let r = load(simd, inverse, i);
        for (axis, k) in [run.a, run.b].into_iter().enumerate() {
            for weight in 0..2 {
                let b = load(simd, &surfels.barycentric[weight], i);
                let d = (f32x8::splat(simd, k[weight]) - b * f32x8::splat(simd, k[2])) * r;
                store(d, &mut surfels.d_barycentric[axis][weight], i);
            }
        }
    }
}

/// `v0 + b1 * (v1 - v0) + b2 * (v2 - v0)` for each component.
#[inline(always)]
fn interpolate<S: Simd, const K: usize>(simd: S, run: &Run, b: &[Lane; 2], v: [[f32; K]; 3], out: &mut [Lane; K]) {
    for i in (run.start..run.end).step_by(N) {
        let (b1, b2) = (load(simd, &b[0], i), load(simd, &b[1], i));
        for k in 0..K {
            let (d1, d2) = (v[1][k] - v[0][k], v[2][k] - v[0][k]);
            let value = (f32x8::splat(simd, v[0][k]) + b1 * f32x8::splat(simd, d1)) + b2 * f32x8::splat(simd, d2);
            store(value, &mut out[k], i);
        }
    }
}

/// Texture coordinates and their footprint.
#[inline(always)]
fn uv<S: Simd>(simd: S, run: &Run, set: usize, t: [Vec2; 3], surfels: &mut Surfels, inverse: &Lane) {
    let out = &mut surfels.uv[set];
    let splat = |x: f32| f32x8::splat(simd, x);
    for k in 0..2 {
        let (d1, d2) = (t[1][k] - t[0][k], t[2][k] - t[0][k]);
        // Change of the numerator per column and per row.
        let gx = run.a[0] * d1 + run.a[1] * d2;
        let gy = run.b[0] * d1 + run.b[1] * d2;
        for i in (run.start..run.end).step_by(N) {
            let (b1, b2) = (load(simd, &surfels.barycentric[0], i), load(simd, &surfels.barycentric[1], i));
            let r = load(simd, inverse, i);
            let along = b1 * splat(d1) + b2 * splat(d2);
            store(splat(t[0][k]) + along, &mut out.st[k], i);
            store((splat(gx) - along * splat(run.a[2])) * r, &mut out.d_dx[k], i);
            store((splat(gy) - along * splat(run.b[2])) * r, &mut out.d_dy[k], i);
        }
    }
}

/// Unit vectors towards the eye.
#[inline(always)]
fn view<S: Simd>(simd: S, domain: &Domain, place: [i32; 2], surfels: &mut Surfels) {
    let [d, dx, dy]: [Vec3; 3] = domain.sight;
    let offset = [0, 1].map(|k| place[k] as f32 * (1.0 / 256.0));
    for i in (0..surfels.n).step_by(N) {
        let coordinate = |k: usize| {
            let cells: &[u32; N] = surfels.cell[k][i..i + N].try_into().expect("a vector of cells");
            f32x8::from_fn(simd, |l| cells[l] as i32 as f32) + f32x8::splat(simd, offset[k])
        };
        let (x, y) = (coordinate(0), coordinate(1));
        for k in 0..3 {
            // Against the line of sight.
            let splat = |v: Vec3| f32x8::splat(simd, -v[k]);
            store((splat(d) + splat(dx) * x) + splat(dy) * y, &mut surfels.view[k], i);
        }
    }
    unit(simd, surfels.n, &mut surfels.view);
}

#[inline(always)]
fn unit<S: Simd>(simd: S, n: usize, v: &mut [Lane; 3]) {
    let [x, y, z] = v;
    unit3(simd, n, x, y, z);
}

/// Makes vectors unit; those without length become +Z.
#[inline(always)]
fn unit3<S: Simd>(simd: S, n: usize, x: &mut Lane, y: &mut Lane, z: &mut Lane) {
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    for i in (0..n).step_by(N) {
        let v = [load(simd, x, i), load(simd, y, i), load(simd, z, i)];
        let squared = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let ok = squared.simd_gt(f32x8::splat(simd, 1e-30));
        let k = one / squared.sqrt();
        store(ok.select(v[0] * k, zero), x, i);
        store(ok.select(v[1] * k, zero), y, i);
        store(ok.select(v[2] * k, one), z, i);
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, lane: &Lane, i: usize) -> f32x8<S> {
    f32x8::load_array_ref(simd, lane[i..i + N].try_into().expect("a vector of a lane"))
}

#[inline(always)]
fn store<S: Simd>(v: f32x8<S>, lane: &mut Lane, i: usize) {
    v.store_array((&mut lane[i..i + N]).try_into().expect("a vector of a lane"));
}
