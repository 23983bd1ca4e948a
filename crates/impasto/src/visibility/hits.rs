//! Triangle ids to surface points: everything that is derived and never stored.
//!
//! Barycentrics come from the corners' homogeneous cell coordinates (Olano, Greer, "Triangle Scan Conversion using 2D
//! Homogeneous Coordinates", 1997), so clipped triangles need no special care, and their derivatives are exact at every
//! cell, also where a triangle covers only one.

use super::Domain;
use super::tile::TILE;
use crate::math::{BATCH, Each, Lane, Vec2, Vec3, kernel};
use crate::placement::{Needs, Surfels};
use fearless_simd::{f32x8, i32x8, prelude::*, u32x8};

/// How many surface points a batch may hold when it is filled here: runs are written eight lanes at a time.
pub const BATCH_FILL: usize = BATCH - 8;

/// Lanes of a vector.
const N: usize = 8;

/// A stretch of the batch in one triangle of one tile.
#[derive(Clone, Copy)]
struct Run {
    start: u16,
    end: u16,
    /// Which set-up: runs of the same triangle and tile share one.
    set_up: u16,
    triangle: u32,
}

impl Run {
    /// Where vectors of lanes begin; the last may reach into the next run, which then overwrites it.
    #[inline(always)]
    fn vectors(&self) -> impl Iterator<Item = usize> + use<> {
        (self.start as usize..self.end as usize).step_by(N)
    }
}

/// Edge functions of the runs' triangles, `a * x + b * y + c` from their tile's corner: of the second corner, of the third,
/// and the sum of all three.
struct SetUps {
    a: [Lane; 3],
    b: [Lane; 3],
    c: [Lane; 3],
    /// 1 where the front is seen, -1 where the back is.
    side: Lane,
}

/// Where in their cells points look: across and down, cells, by lane. A batch of more than eight repeats them.
pub type Place = [[f32; N]; 2];

/// In the middle.
pub const CENTER: Place = [[0.5; N]; 2];

/// Derives the lanes that `needs` asks for from `cell`, `triangle` and `n`, where points look at a `place` in their cells
/// ([`CENTER`], or for a batch of one triangle and up to eight cells of a row: anywhere). `n` is at most [`BATCH_FILL`].
///
/// An answer depends on its own cell and triangle only, not on its neighbours in the batch.
#[inline(always)]
pub fn fill<S: Simd>(simd: S, domain: &Domain, needs: Needs, place: &Place, surfels: &mut Surfels) {
    assert!(surfels.n <= BATCH_FILL, "a batch is filled with at most {BATCH_FILL} points");
    let mut runs = [Run { start: 0, end: 0, set_up: 0, triangle: 0 }; BATCH];
    let n_runs = find_runs(simd, surfels, &mut runs);
    let runs = &mut runs[..n_runs];
    let mut firsts = [0; BATCH];
    let n_firsts = share_set_ups(surfels, runs, &mut firsts);
    const ZERO: Lane = [0.0; BATCH];
    let mut set_ups = SetUps { a: [ZERO; 3], b: [ZERO; 3], c: [ZERO; 3], side: ZERO };
    set_up(domain, &firsts[..n_firsts], surfels, &mut set_ups);
    let mut sum = ZERO;
    edges(simd, place, runs, &set_ups, surfels, &mut sum);
    weights(simd, surfels, &mut sum);
    let mesh = domain.mesh;
    // What the mesh does not have stays stale; looks ask the mesh, too.
    let has = |lane: bool, n: usize| lane && n > 0;
    let (tangent, color) = (has(needs.tangent, mesh.tangents().len()), has(needs.color, mesh.colors().len()));
    let needs = Needs { tangent, color, ..needs };
    for run in runs.iter() {
        let pick = |lanes: &[Lane; 3]| {
            lanes.each_ref().each(
                #[inline(always)]
                |l| l[run.set_up as usize],
            )
        };
        let slopes = [pick(&set_ups.a), pick(&set_ups.b)];
        let c = mesh.triangles()[run.triangle as usize];
        if needs.derivatives {
            derivatives(simd, run, slopes, surfels, &sum);
        }
        if needs.normal {
            let n = c.each(
                #[inline(always)]
                |i| mesh.normals()[i as usize].to_array(),
            );
            interpolate(simd, run, &surfels.barycentric, n, &mut surfels.normal);
        }
        if needs.position {
            let p = c.each(
                #[inline(always)]
                |i| mesh.positions()[i as usize].to_array(),
            );
            interpolate(simd, run, &surfels.barycentric, p, &mut surfels.position);
        }
        let mut sets = needs.uv_sets;
        while sets != 0 {
            let set = sets.trailing_zeros() as usize;
            sets &= sets - 1;
            uv(
                simd,
                run,
                set,
                c.each(
                    #[inline(always)]
                    |i| mesh.uv_sets()[set].uv[i as usize],
                ),
                slopes,
                surfels,
                &sum,
            );
        }
        if needs.tangent {
            let t = c.each(
                #[inline(always)]
                |i| mesh.tangents()[i as usize].to_array(),
            );
            interpolate(simd, run, &surfels.barycentric, t, &mut surfels.tangent);
            // The sign is a corner's, not a mixture: all three agree where the layout is not mirrored.
            surfels.tangent[3][run.start as usize..run.end as usize].fill(if t[0][3] < 0.0 { -1.0 } else { 1.0 });
        }
        if needs.color {
            let v = c.each(
                #[inline(always)]
                |i| mesh.colors()[i as usize].to_array(),
            );
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

/// Cuts the batch into runs. All cells of a run are measured from one origin, their tile's corner, whatever the batch.
#[inline(always)]
fn find_runs<S: Simd>(simd: S, surfels: &Surfels, runs: &mut [Run; BATCH]) -> usize {
    let load = kernel(
        #[inline(always)]
        |lane: &[u32; BATCH], i: usize| u32x8::from_slice(simd, &lane[i..i + N]),
    );
    let mut n_runs = 0;
    let mut start = 0;
    for i in (1..surfels.n).step_by(N) {
        // Where a lane differs from the one before in its triangle, or in its tile.
        let [x, y] = &surfels.cell;
        let moved = (load(x, i) ^ load(x, i - 1)) | (load(y, i) ^ load(y, i - 1));
        let same = load(&surfels.triangle, i).simd_eq(load(&surfels.triangle, i - 1))
            & moved.simd_lt(u32x8::splat(simd, TILE as u32));
        let mut cuts = !(same.to_bitmask() as u32) & 0xff;
        while cuts != 0 {
            let end = i + cuts.trailing_zeros() as usize;
            cuts &= cuts - 1;
            if end < surfels.n {
                runs[n_runs] =
                    Run { start: start as u16, end: end as u16, set_up: 0, triangle: surfels.triangle[start] };
                n_runs += 1;
                start = end;
            }
        }
    }
    if surfels.n > 0 {
        runs[n_runs] = Run { start: start as u16, end: surfels.n as u16, set_up: 0, triangle: surfels.triangle[start] };
        n_runs += 1;
    }
    n_runs
}

/// Gives runs of the same triangle and tile one set-up: a triangle comes back in every row that it covers. Writes the first
/// cell of each set-up, and returns how many there are.
#[inline(always)]
fn share_set_ups(surfels: &Surfels, runs: &mut [Run], firsts: &mut [u16; BATCH]) -> usize {
    // Which set-up, plus one, a triangle with these last bits had. Another one's makes for a second set-up, nothing worse.
    let mut seen = [0_u16; 64];
    let mut n = 0;
    for run in runs {
        let place = &mut seen[run.triangle as usize % 64];
        let start = run.start as usize;
        let is_seen = *place != 0 && {
            let first = firsts[*place as usize - 1] as usize;
            let same_tile = |k: usize| (surfels.cell[k][first] ^ surfels.cell[k][start]) < TILE as u32;
            surfels.triangle[first] == run.triangle && same_tile(0) && same_tile(1)
        };
        if !is_seen {
            firsts[n] = run.start;
            n += 1;
            *place = n as u16;
        }
        run.set_up = *place - 1;
    }
    n
}

/// The edge functions at the given cells of the batch, eight at a time, in f64: relative to the tile's corner little is lost
/// by cancellation.
#[inline(always)]
fn set_up(domain: &Domain, cells: &[u16], surfels: &Surfels, out: &mut SetUps) {
    type Eight = [f64; N];
    for first in (0..cells.len()).step_by(N) {
        // Homogeneous corners, x y w each, relative to the origin.
        let mut v = [[[0.0_f32; N]; 3]; 3];
        let mut origin = [[0.0_f32; N]; 2];
        for lane in 0..N {
            let cell = cells[(first + lane).min(cells.len() - 1)] as usize;
            for k in 0..2 {
                origin[k][lane] = (surfels.cell[k][cell] & !(TILE as u32 - 1)) as i32 as f32;
            }
            for (corner, &vertex) in v.iter_mut().zip(&domain.mesh.triangles()[surfels.triangle[cell] as usize]) {
                let c = domain.corner(vertex);
                corner[0][lane] = c.x;
                corner[1][lane] = c.y;
                corner[2][lane] = c.w;
            }
        }
        let mut q = [[[0.0_f64; N]; 3]; 3];
        for corner in 0..3 {
            for lane in 0..N {
                let w = v[corner][2][lane] as f64;
                q[corner][0][lane] = v[corner][0][lane] as f64 - origin[0][lane] as f64 * w;
                q[corner][1][lane] = v[corner][1][lane] as f64 - origin[1][lane] as f64 * w;
                q[corner][2][lane] = w;
            }
        }
        let cross = |p: &[Eight; 3], q: &[Eight; 3]| -> [Eight; 3] {
            let mut r = [[0.0; N]; 3];
            for k in 0..3 {
                let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                for lane in 0..N {
                    r[k][lane] = p[a][lane] * q[b][lane] - p[b][lane] * q[a][lane];
                }
            }
            r
        };
        let (e0, e1, e2) = (cross(&q[1], &q[2]), cross(&q[2], &q[0]), cross(&q[0], &q[1]));
        let mut sum = [[0.0; N]; 3];
        let (mut area, mut scale) = ([0.0; N], [0.0; N]);
        for lane in 0..N {
            for k in 0..3 {
                sum[k][lane] = e0[k][lane] + e1[k][lane] + e2[k][lane];
            }
            area[lane] = q[0][0][lane] * e0[0][lane] + q[0][1][lane] * e0[1][lane] + q[0][2][lane] * e0[2][lane];
            // Any common factor is allowed: this one keeps f32 far from its limits whatever the model's unit.
            let larger = |a: f64, b: f64| if a > b { a } else { b };
            let (s, t, u) = (sum[2][lane].abs(), e1[2][lane].abs(), e2[2][lane].abs());
            let largest = larger(larger(larger(s, t), u), larger(sum[0][lane].abs(), sum[1][lane].abs()));
            scale[lane] = if largest > 0.0 { 1.0 / largest } else { 0.0 };
        }
        for (k, e) in [&e1, &e2, &sum].into_iter().enumerate() {
            for (out, e) in [&mut out.a[k], &mut out.b[k], &mut out.c[k]].into_iter().zip(e) {
                for lane in 0..N {
                    out[first + lane] = (e[lane] * scale[lane]) as f32;
                }
            }
        }
        for lane in 0..N {
            // With y down the front, counter-clockwise with y up, has a negative area.
            out.side[first + lane] = if area[lane] < 0.0 { 1.0 } else { -1.0 };
        }
    }
}

/// Evaluates edge functions: the second and third corner's into `barycentric`, the sum into `sum`.
#[inline(always)]
fn edges<S: Simd>(simd: S, place: &Place, runs: &[Run], set_ups: &SetUps, surfels: &mut Surfels, sum: &mut Lane) {
    for run in runs {
        let splat = |lane: &Lane| f32x8::splat(simd, lane[run.set_up as usize]);
        let (a, b, c) =
            (set_ups.a.each_ref().each(splat), set_ups.b.each_ref().each(splat), set_ups.c.each_ref().each(splat));
        for at in run.vectors() {
            let local = kernel(
                #[inline(always)]
                |k: usize| {
                    let cell =
                        u32x8::from_slice(simd, &surfels.cell[k][at..at + N]) & u32x8::splat(simd, TILE as u32 - 1);
                    cells_to_float(simd, cell, &place[k])
                },
            );
            let (x, y) = (local(0), local(1));
            let edge = kernel(
                #[inline(always)]
                |k: usize| (c[k] + b[k] * y) + a[k] * x,
            );
            store(edge(0), &mut surfels.barycentric[0], at);
            store(edge(1), &mut surfels.barycentric[1], at);
            store(edge(2), sum, at);
            store(splat(&set_ups.side), &mut surfels.side, at);
        }
    }
}

/// Whole cells plus a place within them, a multiple of 1/256: exact in f32.
#[inline(always)]
fn cells_to_float<S: Simd>(simd: S, cells: u32x8<S>, place: &[f32; N]) -> f32x8<S> {
    let cells: i32x8<S> = cells.bitcast();
    cells.to_float::<f32x8<S>>() + f32x8::load_array_ref(simd, place)
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
        let clamp = kernel(
            #[inline(always)]
            |e: f32x8<S>, most: f32x8<S>| {
                let b = e * r;
                let b = b.simd_gt(zero).select(b, zero);
                b.simd_lt(most).select(b, most)
            },
        );
        let b1 = clamp(load(simd, &surfels.barycentric[0], i), one);
        let b2 = clamp(load(simd, &surfels.barycentric[1], i), one - b1);
        store(b1, &mut surfels.barycentric[0], i);
        store(b2, &mut surfels.barycentric[1], i);
        store(r, sum, i);
    }
}

/// How barycentrics change per cell: the quotient rule on edge function over sum.
#[inline(always)]
fn derivatives<S: Simd>(simd: S, run: &Run, slopes: [[f32; 3]; 2], surfels: &mut Surfels, inverse: &Lane) {
    for i in run.vectors() {
        let r = load(simd, inverse, i);
        for (axis, k) in slopes.into_iter().enumerate() {
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
    for i in run.vectors() {
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
fn uv<S: Simd>(
    simd: S,
    run: &Run,
    set: usize,
    t: [Vec2; 3],
    [a, b]: [[f32; 3]; 2],
    surfels: &mut Surfels,
    inverse: &Lane,
) {
    let out = &mut surfels.uv[set];
    let splat = |x: f32| f32x8::splat(simd, x);
    for k in 0..2 {
        let (d1, d2) = (t[1][k] - t[0][k], t[2][k] - t[0][k]);
        // Change of the numerator per column and per row.
        let gx = a[0] * d1 + a[1] * d2;
        let gy = b[0] * d1 + b[1] * d2;
        for i in run.vectors() {
            let (b1, b2) = (load(simd, &surfels.barycentric[0], i), load(simd, &surfels.barycentric[1], i));
            let r = load(simd, inverse, i);
            let along = b1 * splat(d1) + b2 * splat(d2);
            store(splat(t[0][k]) + along, &mut out.st[k], i);
            store((splat(gx) - along * splat(a[2])) * r, &mut out.d_dx[k], i);
            store((splat(gy) - along * splat(b[2])) * r, &mut out.d_dy[k], i);
        }
    }
}

/// Unit vectors towards the eye.
#[inline(always)]
fn view<S: Simd>(simd: S, domain: &Domain, place: &Place, surfels: &mut Surfels) {
    let [d, dx, dy]: [Vec3; 3] = domain.sight;
    for i in (0..surfels.n).step_by(N) {
        let coordinate = kernel(
            #[inline(always)]
            |k: usize| cells_to_float(simd, u32x8::from_slice(simd, &surfels.cell[k][i..i + N]), &place[k]),
        );
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
