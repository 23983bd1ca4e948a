//! Triangle ids to surface points: everything that is derived and never stored.
//!
//! Barycentrics come from the corners' homogeneous cell coordinates (Olano, Greer, "Triangle Scan Conversion using 2D
//! Homogeneous Coordinates", 1997), so clipped triangles need no special care, and their derivatives are exact at every
//! cell, also where a triangle covers only one.

use super::Domain;
use super::tile::TILE;
use crate::math::{BATCH, Each, Lane, Vec2, Vec3, kernel};
use crate::placement::{Needs, Surfels, TexCoords};
use fearless_simd::{f32x8, i32x8, prelude::*, u32x8};

/// How many surface points a batch may hold when it is filled here: runs are written eight lanes at a time.
pub const BATCH_FILL: usize = BATCH - 8;

/// Lanes of a vector.
const N: usize = 8;

/// What is the same all over a triangle, for eight triangles: edge functions `a * x + b * y + c` from their tile's corner,
/// of the second corner, of the third, and the sum of all three.
struct Eight {
    corners: [[u32; 3]; N],
    a: [[f32; N]; 3],
    b: [[f32; N]; 3],
    c: [[f32; N]; 3],
    /// 1 where the front is seen, -1 where the back is.
    side: [f32; N],
}

impl Eight {
    const ZERO: Self =
        Self { corners: [[0; 3]; N], a: [[0.0; N]; 3], b: [[0.0; N]; 3], c: [[0.0; N]; 3], side: [0.0; N] };
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
    let mesh = domain.mesh;
    // What the mesh does not have stays stale; looks ask the mesh, too.
    let has = |lane: bool, n: usize| lane && n > 0;
    let (tangent, color) = (has(needs.tangent, mesh.tangents().len()), has(needs.color, mesh.colors().len()));
    let needs = Needs { tangent, color, ..needs };
    let mut cuts = [0; BATCH + 1];
    let n_runs = find_runs(simd, surfels, &mut cuts);
    let mut eight = Eight::ZERO;
    // One over the edge functions' sum.
    let mut inverse = [0.0; BATCH];
    if n_runs * SHORT <= surfels.n {
        for first in (0..n_runs).step_by(N) {
            let runs = &cuts[first..=(first + N).min(n_runs)];
            let cell = kernel(
                #[inline(always)]
                |lane: usize| runs[lane.min(runs.len() - 2)] as usize,
            );
            set_up(domain, cell, surfels, &mut eight);
            derive::<S, true>(simd, domain, needs, place, (&eight, runs), (surfels, &mut inverse));
        }
    } else {
        for first in (0..surfels.n).step_by(N) {
            let last = surfels.n - 1;
            let cell = kernel(
                #[inline(always)]
                |lane: usize| (first + lane).min(last),
            );
            set_up(domain, cell, surfels, &mut eight);
            derive::<S, false>(simd, domain, needs, place, (&eight, &[first as u16]), (surfels, &mut inverse));
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

/// Runs of fewer cells than this, on average, are not worth being told apart: each cell is its own.
const SHORT: usize = 2;

/// Cuts the batch into runs, stretches in one triangle of one tile: all their cells are measured from one origin, the
/// tile's corner, whatever the batch. Run k goes from cut k to the next.
#[inline(always)]
fn find_runs<S: Simd>(simd: S, surfels: &Surfels, cuts: &mut [u16; BATCH + 1]) -> usize {
    let load = kernel(
        #[inline(always)]
        |lane: &[u32; BATCH], i: usize| u32x8::from_slice(simd, &lane[i..i + N]),
    );
    let mut n_runs = 0;
    for i in (1..surfels.n).step_by(N) {
        // Where a lane differs from the one before in its triangle, or in its tile.
        let [x, y] = &surfels.cell;
        let moved = (load(x, i) ^ load(x, i - 1)) | (load(y, i) ^ load(y, i - 1));
        let same = load(&surfels.triangle, i).simd_eq(load(&surfels.triangle, i - 1))
            & moved.simd_lt(u32x8::splat(simd, TILE as u32));
        let mut cut = !(same.to_bitmask() as u32) & 0xff;
        while cut != 0 {
            let at = i + cut.trailing_zeros() as usize;
            cut &= cut - 1;
            if at < surfels.n {
                n_runs += 1;
                cuts[n_runs] = at as u16;
            }
        }
    }
    n_runs += (surfels.n > 0) as usize;
    cuts[n_runs] = surfels.n as u16;
    n_runs
}

/// The edge functions at eight of the batch's cells, in f64: relative to the tile's corner little is lost by cancellation.
#[inline(always)]
fn set_up(domain: &Domain, cell_of: impl Fn(usize) -> usize, surfels: &Surfels, out: &mut Eight) {
    type Numbers = [f64; N];
    // Homogeneous corners, x y w each, relative to the origin.
    let mut v = [[[0.0_f32; N]; 3]; 3];
    let mut origin = [[0.0_f32; N]; 2];
    for lane in 0..N {
        let cell = cell_of(lane) % BATCH;
        for k in 0..2 {
            origin[k][lane] = (surfels.cell[k][cell] & !(TILE as u32 - 1)) as i32 as f32;
        }
        out.corners[lane] = domain.mesh.triangles()[surfels.triangle[cell] as usize];
        for k in 0..3 {
            let c = domain.corner(out.corners[lane][k]);
            v[k][0][lane] = c.x;
            v[k][1][lane] = c.y;
            v[k][2][lane] = c.w;
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
    let cross = |p: &[Numbers; 3], q: &[Numbers; 3]| -> [Numbers; 3] {
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
                out[lane] = (e[lane] * scale[lane]) as f32;
            }
        }
    }
    for lane in 0..N {
        // With y down the front, counter-clockwise with y up, has a negative area.
        out.side[lane] = if area[lane] < 0.0 { 1.0 } else { -1.0 };
    }
}

/// Derives what differs from cell to cell for eight triangles, pass by pass: for their runs between `cuts`, or, unless
/// they are `LONG`, for one cell of each, from the cut on.
#[inline(always)]
fn derive<S: Simd, const LONG: bool>(
    simd: S,
    domain: &Domain,
    needs: Needs,
    place: &Place,
    (eight, cuts): (&Eight, &[u16]),
    (surfels, inverse): (&mut Surfels, &mut Lane),
) {
    let mesh = domain.mesh;
    let of = Of { simd, eight, cuts };
    weights::<S, LONG>(&of, place, surfels, inverse);
    if needs.derivatives {
        derivatives::<S, LONG>(&of, surfels, inverse);
    }
    if needs.normal {
        let normals = mesh.normals();
        let at = kernel(
            #[inline(always)]
            |v: usize| normals[v].to_array(),
        );
        interpolate::<S, LONG, 3>(&of, at, &surfels.barycentric, &mut surfels.normal);
    }
    if needs.position {
        let positions = mesh.positions();
        let at = kernel(
            #[inline(always)]
            |v: usize| positions[v].to_array(),
        );
        interpolate::<S, LONG, 3>(&of, at, &surfels.barycentric, &mut surfels.position);
    }
    let mut sets = needs.uv_sets;
    while sets != 0 {
        let set = sets.trailing_zeros() as usize;
        sets &= sets - 1;
        uv::<S, LONG>(&of, &mesh.uv_sets()[set].uv, &surfels.barycentric, inverse, &mut surfels.uv[set]);
    }
    if needs.tangent {
        let tangents = mesh.tangents();
        let at = kernel(
            #[inline(always)]
            |v: usize| tangents[v].to_array(),
        );
        interpolate::<S, LONG, 4>(&of, at, &surfels.barycentric, &mut surfels.tangent);
        // The sign is a corner's, not a mixture: all three agree where the layout is not mirrored.
        let mut sign = [0.0; N];
        (0..N).for_each(|k| sign[k] = if at(eight.corners[k][0] as usize)[3] < 0.0 { -1.0 } else { 1.0 });
        of.each_vector::<LONG>(
            #[inline(always)]
            |k, at| store(of.constant::<LONG>(&sign, k), &mut surfels.tangent[3], at),
        );
    }
    if needs.color {
        let colors = mesh.colors();
        let at = kernel(
            #[inline(always)]
            |v: usize| colors[v].to_array(),
        );
        interpolate::<S, LONG, 4>(&of, at, &surfels.barycentric, &mut surfels.color);
    }
}

/// Eight triangles and where their cells are in the batch.
struct Of<'a, S> {
    simd: S,
    eight: &'a Eight,
    cuts: &'a [u16],
}

impl<S: Simd> Of<'_, S> {
    /// Calls `f` with a triangle and where a vector of its cells begins. The last of a run may reach into the next run,
    /// which then overwrites it.
    #[inline(always)]
    fn each_vector<const LONG: bool>(&self, mut f: impl FnMut(usize, usize)) {
        if !LONG {
            return f(0, self.cuts[0] as usize % (BATCH - N + 1));
        }
        for (k, run) in self.cuts.windows(2).enumerate().take(N) {
            let (mut at, end) = (run[0] as usize, (run[1] as usize).min(BATCH_FILL));
            while at < end {
                f(k, at);
                at += N;
            }
        }
    }

    /// A number of triangle `k` for all of a vector's cells, or each cell's own.
    #[inline(always)]
    fn constant<const LONG: bool>(&self, eight: &[f32; N], k: usize) -> f32x8<S> {
        if LONG { f32x8::splat(self.simd, eight[k]) } else { f32x8::load_array_ref(self.simd, eight) }
    }
}

/// Evaluates edge functions and makes barycentrics of them.
#[inline(always)]
fn weights<S: Simd, const LONG: bool>(of: &Of<S>, place: &Place, surfels: &mut Surfels, inverse: &mut Lane) {
    let simd = of.simd;
    let Eight { a, b, c, side, .. } = of.eight;
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    of.each_vector::<LONG>(
        #[inline(always)]
        |t, at| {
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
                |k: usize| {
                    (of.constant::<LONG>(&c[k], t) + of.constant::<LONG>(&b[k], t) * y)
                        + of.constant::<LONG>(&a[k], t) * x
                },
            );
            // A triangle without area (only possible for ids that no raster made) gives its first corner.
            let sum = edge(2);
            let r = sum.simd_eq(zero).select(zero, one / sum);
            // At silhouettes a cell's centre may lie just outside of the triangle: the nearest weights inside stand for it.
            let clamp = kernel(
                #[inline(always)]
                |e: f32x8<S>, most: f32x8<S>| {
                    let b = e * r;
                    let b = b.simd_gt(zero).select(b, zero);
                    b.simd_lt(most).select(b, most)
                },
            );
            let b1 = clamp(edge(0), one);
            store(b1, &mut surfels.barycentric[0], at);
            store(clamp(edge(1), one - b1), &mut surfels.barycentric[1], at);
            store(r, inverse, at);
            store(of.constant::<LONG>(side, t), &mut surfels.side, at);
        },
    );
}

/// Whole cells plus a place within them, a multiple of 1/256: exact in f32.
#[inline(always)]
fn cells_to_float<S: Simd>(simd: S, cells: u32x8<S>, place: &[f32; N]) -> f32x8<S> {
    let cells: i32x8<S> = cells.bitcast();
    cells.to_float::<f32x8<S>>() + f32x8::load_array_ref(simd, place)
}

/// How barycentrics change per cell: the quotient rule on edge function over sum.
#[inline(always)]
fn derivatives<S: Simd, const LONG: bool>(of: &Of<S>, surfels: &mut Surfels, inverse: &Lane) {
    for (axis, slopes) in [&of.eight.a, &of.eight.b].into_iter().enumerate() {
        for weight in 0..2 {
            of.each_vector::<LONG>(
                #[inline(always)]
                |t, at| {
                    let [slope, of_sum] = [weight, 2].each(
                        #[inline(always)]
                        |k: usize| of.constant::<LONG>(&slopes[k], t),
                    );
                    let b = load(of.simd, &surfels.barycentric[weight], at);
                    let r = load(of.simd, inverse, at);
                    store((slope - b * of_sum) * r, &mut surfels.d_barycentric[axis][weight], at);
                },
            );
        }
    }
}

/// What eight triangles' corners have: the first corner's numbers, and from there to the second's and the third's.
#[inline(always)]
fn at_corners<const K: usize>(eight: &Eight, value: impl Fn(usize) -> [f32; K]) -> [[[f32; N]; K]; 3] {
    let mut out = [[[0.0; N]; K]; 3];
    for lane in 0..N {
        for corner in 0..3 {
            let value = value(eight.corners[lane][corner] as usize);
            for k in 0..K {
                out[corner][k][lane] = value[k];
            }
        }
    }
    let [first, second, third] = &mut out;
    for k in 0..K {
        for lane in 0..N {
            second[k][lane] -= first[k][lane];
            third[k][lane] -= first[k][lane];
        }
    }
    out
}

/// `v0 + b1 * (v1 - v0) + b2 * (v2 - v0)` for each component.
#[inline(always)]
fn interpolate<S: Simd, const LONG: bool, const K: usize>(
    of: &Of<S>,
    value: impl Fn(usize) -> [f32; K],
    b: &[Lane; 2],
    out: &mut [Lane; K],
) {
    let [v0, d1, d2] = at_corners(of.eight, value);
    of.each_vector::<LONG>(
        #[inline(always)]
        |t, at| {
            let (b1, b2) = (load(of.simd, &b[0], at), load(of.simd, &b[1], at));
            for k in 0..K {
                let [v0, d1, d2] = [&v0, &d1, &d2].each(
                    #[inline(always)]
                    |v| of.constant::<LONG>(&v[k], t),
                );
                store((v0 + b1 * d1) + b2 * d2, &mut out[k], at);
            }
        },
    );
}

/// Texture coordinates and their footprint.
#[inline(always)]
fn uv<S: Simd, const LONG: bool>(of: &Of<S>, uv: &[Vec2], b: &[Lane; 2], inverse: &Lane, out: &mut TexCoords) {
    let Eight { a: slopes_x, b: slopes_y, .. } = of.eight;
    let [t0, d1, d2] = at_corners(
        of.eight,
        #[inline(always)]
        |v| uv[v].to_array(),
    );
    // Change of the numerator per column and per row.
    let mut change = [[[0.0; N]; 2]; 2];
    for (change, slopes) in change.iter_mut().zip([slopes_x, slopes_y]) {
        for k in 0..2 {
            for t in 0..N {
                change[k][t] = slopes[0][t] * d1[k][t] + slopes[1][t] * d2[k][t];
            }
        }
    }
    of.each_vector::<LONG>(
        #[inline(always)]
        |t, at| {
            let constant = kernel(
                #[inline(always)]
                |eight: &[f32; N]| of.constant::<LONG>(eight, t),
            );
            let (b1, b2) = (load(of.simd, &b[0], at), load(of.simd, &b[1], at));
            let r = load(of.simd, inverse, at);
            for k in 0..2 {
                let along = b1 * constant(&d1[k]) + b2 * constant(&d2[k]);
                store(constant(&t0[k]) + along, &mut out.st[k], at);
                store((constant(&change[0][k]) - along * constant(&slopes_x[2])) * r, &mut out.d_dx[k], at);
                store((constant(&change[1][k]) - along * constant(&slopes_y[2])) * r, &mut out.d_dy[k], at);
            }
        },
    );
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
