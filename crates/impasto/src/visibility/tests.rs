//! Coverage one can read, and slow obvious versions of what the rasterizer does fast.

use super::*;
use crate::assets::{Mesh, RawMesh, UvSet};
use crate::math::{Projection, Size, Vec2, Vec3, hash_cell, unit_float, vec2, vec3};
use crate::par::{LEVEL_NAMES, Level, Workers, level_by_name};
use crate::placement::{Needs, Surfels};
use fearless_simd::dispatch;

/// A flat mesh whose UV set holds the given triangles in cells of a grid, for looking over the atlas.
fn flat(triangles: &[[Vec2; 3]], size: Size) -> Mesh {
    let corners: Vec<Vec2> =
        triangles.iter().flatten().map(|p| *p / vec2(size.width as f32, size.height as f32)).collect();
    let raw = RawMesh {
        positions: corners.iter().map(|c| vec3(c.x, -c.y, 0.0)).collect(),
        triangles: (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        normals: vec![Vec3::Z; corners.len()],
        uv_sets: vec![UvSet { name: "uv0".into(), uv: corners }],
        ..Default::default()
    };
    // Not mended: broken shapes are wanted here.
    raw.trusted()
}

fn all(mesh: &Mesh) -> Vec<Draw> {
    vec![Draw { triangles: 0..mesh.triangles().len() as u32, faces: Faces::Both, kind: Kind::Solid }]
}

fn p(x: i32, y: i32) -> Vec2 {
    vec2(x as f32, y as f32)
}

fn check_coverage(triangles: &[[Vec2; 3]], wanted: &str) {
    let rows: Vec<&str> = wanted.split_whitespace().collect();
    let size = Size::new(rows[0].len() as u32, rows.len() as u32);
    let mesh = flat(triangles, size);
    let domain = Domain::over_atlas(&mesh, 0, size);
    let buffer = InfoBuffer::build(&domain, &all(&mesh), Samples::One, None, &Workers::new(1));
    let digit = |id: u32| if id == Hit::NOTHING { '.' } else { char::from_digit(id + 1, 36).unwrap() };
    let ids = buffer.ids();
    let got: Vec<String> = ids.chunks(rows[0].len()).map(|row| row.iter().map(|&id| digit(id)).collect()).collect();
    assert_eq!(got, rows, "{}", got.join("\n"));
}

#[test]
fn neighbours_share_their_edge_without_gap_or_overlap() {
    let (a, b) = ([p(0, 0), p(6, 0), p(0, 4)], [p(6, 0), p(6, 4), p(0, 4)]);
    check_coverage(
        &[a, b],
        "
        111112
        111122
        112222
        122222
        ",
    );
}

#[test]
fn an_edge_through_centres_belongs_to_the_triangle_right_of_or_below_it() {
    let h = |x: i32, y: i32| vec2(x as f32 + 0.5, y as f32 + 0.5);
    check_coverage(
        &[[h(0, 0), h(3, 0), h(0, 3)], [h(3, 0), h(3, 3), h(0, 3)]],
        "
        1112
        1122
        1222
        ....
        "
        .replace("1112", "111.")
        .replace("1122", "112.")
        .replace("1222", "122.")
        .as_str(),
    );
}

#[test]
fn both_windings_and_degenerate_shapes_are_drawn_right() {
    check_coverage(&[[p(0, 0), p(0, 2), p(2, 0)]], "1. ..");
    check_coverage(&[[p(0, 0), p(2, 2), p(1, 1)], [p(1, 1), p(1, 1), p(1, 1)]], ".. ..");
    check_coverage(&[[vec2(0.6, 0.6), vec2(0.9, 0.6), vec2(0.6, 0.9)]], ". ");
}

fn random(i: u32, seed: u32) -> f32 {
    unit_float(hash_cell(i as i32, 7, 0, seed))
}

/// Coverage by the definition: every place against every triangle, in 128-bit integers.
fn oracle(mesh: &Mesh, size: Size, place: [i32; 2]) -> Vec<u32> {
    let uv = &mesh.uv_sets()[0].uv;
    let snapped = |i: u32| {
        let t = uv[i as usize];
        let f = |x: f32| (x * 256.0).round_ties_even() as i128;
        [f(t.x * size.width as f32), f(t.y * size.height as f32)]
    };
    let mut ids = vec![Hit::NOTHING; size.n_cells()];
    for (t, corners) in mesh.triangles().iter().enumerate() {
        let mut v = corners.map(snapped);
        let area =
            |v: &[[i128; 2]; 3]| (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[2][0] - v[0][0]) * (v[1][1] - v[0][1]);
        if area(&v) < 0 {
            v.swap(1, 2);
        }
        if area(&v) == 0 {
            continue;
        }
        for (cell, id) in ids.iter_mut().enumerate() {
            let x = (cell as i128 % size.width as i128) * 256 + place[0] as i128;
            let y = (cell as i128 / size.width as i128) * 256 + place[1] as i128;
            let inside = (0..3).all(|i| {
                let (a, b) = (v[i], v[(i + 1) % 3]);
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                let e = dx * (y - a[1]) - dy * (x - a[0]);
                e > 0 || (e == 0 && (dy < 0 || (dy == 0 && dx > 0)))
            });
            if inside && *id == Hit::NOTHING {
                *id = t as u32;
            }
        }
    }
    ids
}

#[test]
fn coverage_equals_the_definition_on_random_triangles_of_all_sizes() {
    for (seed, extent) in [(1, 1.5), (2, 6.0), (3, 20.0), (4, 90.0), (5, 400.0), (6, 20000.0)] {
        let size = Size::new(150, 97);
        let triangles: Vec<[Vec2; 3]> = (0..24)
            .map(|i| {
                let center = vec2(random(i, seed) * 150.0, random(i, seed + 100) * 97.0);
                [0, 1, 2].map(|k| {
                    let j = i * 3 + k;
                    let at = center + (vec2(random(j, seed + 200), random(j, seed + 300)) - 0.5) * extent;
                    // Half of the corners on a coarse lattice: edges through centres, shared corners, flat tops.
                    if j % 2 == 0 { (at * 2.0).round() * 0.5 } else { at }
                })
            })
            .collect();
        let mesh = flat(&triangles, size);
        let domain = Domain::over_atlas(&mesh, 0, size);
        // Vertices that need clipping get new places along the edges: only the unclipped are bound by the definition.
        if extent > 10000.0 {
            continue;
        }
        for samples in [Samples::One, Samples::Four, Samples::Sixteen] {
            let buffer = InfoBuffer::build(&domain, &all(&mesh), samples, None, &Workers::new(2));
            for (s, place) in samples.offsets().iter().enumerate() {
                let wanted = oracle(&mesh, size, *place);
                for (cell, wanted) in wanted.iter().enumerate() {
                    let (x, y) = (cell % 150, cell / 150);
                    let tile = &buffer.tiles[y / TILE * 3 + x / TILE];
                    let got = tile.solid.ids[(y % TILE * TILE + x % TILE) * samples.n() + s];
                    assert_eq!(got, *wanted, "extent {extent}, sample {s} of {samples:?}, cell {x} {y}");
                }
            }
        }
    }
}

/// A bumpy sphere around the origin, and a sheet through it.
fn solid() -> Mesh {
    let (n_lat, n_lon) = (24, 40);
    let mut raw = RawMesh::default();
    for j in 0..=n_lat {
        for i in 0..=n_lon {
            let (th, ph) =
                (std::f64::consts::PI * j as f64 / n_lat as f64, std::f64::consts::TAU * i as f64 / n_lon as f64);
            use crate::math::exact::{cos, sin};
            let r = 1.0 + 0.2 * sin(5.0 * ph) * sin(3.0 * th);
            raw.positions.push(vec3(
                (r * sin(th) * cos(ph)) as f32,
                (r * cos(th)) as f32,
                (r * sin(th) * sin(ph)) as f32,
            ));
        }
    }
    for j in 0..n_lat {
        for i in 0..n_lon {
            let a = j * (n_lon + 1) + i;
            let (b, c, d) = (a + 1, a + n_lon + 1, a + n_lon + 2);
            raw.triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    let k = raw.positions.len() as u32;
    raw.positions.extend([vec3(-40.0, -0.3, -40.0), vec3(40.0, 0.2, -40.0), vec3(0.0, -0.1, 60.0)]);
    raw.triangles.push([k, k + 1, k + 2]);
    raw.normals = raw.positions.iter().map(|p| p.normalize()).collect();
    raw.uv_sets.push(UvSet { name: "uv0".into(), uv: raw.positions.iter().map(|p| vec2(p.x, p.y)).collect() });
    raw.trusted()
}

fn camera() -> Camera {
    Camera::looking(vec3(0.4, 0.5, 2.4), Vec3::ZERO, Vec3::Y, Projection::Perspective { fov_y: 0.9 }, 0.05)
}

#[test]
fn hits_lie_on_the_line_of_sight_and_nothing_is_before_them() {
    let mesh = solid();
    let size = Size::new(97, 71);
    for camera in [camera(), Camera { projection: Projection::Orthographic { height: 2.6 }, ..camera() }] {
        let domain = Domain::through_camera(&mesh, &camera, size);
        let buffer = InfoBuffer::build(&domain, &all(&mesh), Samples::One, None, &Workers::new(1));
        let parallel = domain.view.parallel.is_some();
        let m = camera.cells_from_world(size, mesh.bounds());
        let mut n_compared = 0;
        for y in 0..size.height {
            for x in 0..size.width {
                // The nearest triangle by ray casting in f64, with its distance to edges in cells.
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let mut best = (0.0, Hit::NOTHING);
                let mut close = false;
                for (t, c) in mesh.triangles().iter().enumerate() {
                    let v = c.map(|i| (m * mesh.positions()[i as usize].extend(1.0)).as_dvec4());
                    let row = |v: glam::DVec4| [v.x - px * v.w, v.y - py * v.w, v.w];
                    let v3 = v.map(row);
                    let cross2 = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
                    let e = [cross2(v3[1], v3[2]), cross2(v3[2], v3[0]), cross2(v3[0], v3[1])];
                    let sum = e[0] + e[1] + e[2];
                    let b = e.map(|e| e / sum);
                    let w = b[0] * v[0].w + b[1] * v[1].w + b[2] * v[2].w;
                    let depth = (b[0] * v[0].z + b[1] * v[1].z + b[2] * v[2].z) / w;
                    if !parallel && w < 0.05 {
                        continue;
                    }
                    if b.iter().all(|b| *b > -0.02) && b.iter().any(|b| *b < 0.02) {
                        close |= depth > best.0 - 0.05;
                    }
                    if b.iter().all(|b| *b >= 0.0) && depth > best.0 {
                        close |= depth < best.0 * 1.001;
                        best = (depth, t as u32);
                    }
                }
                if !close {
                    let (id, depth) = buffer.at(x, y);
                    assert_eq!(id, best.1, "cell {x} {y}");
                    assert!((depth as f64 - best.0).abs() < 1e-3 * best.0.max(1.0), "cell {x} {y}: {depth} {}", best.0);
                    n_compared += 1;
                }
            }
        }
        assert!(n_compared > 2500, "{n_compared}");
    }
}

fn filled(domain: &Domain, buffer: &InfoBuffer, level: Level, cells: &[(u32, u32)]) -> Box<Surfels> {
    let needs =
        Needs { position: true, normal: true, tangent: false, color: false, view: true, derivatives: true, uv_sets: 1 };
    let mut surfels = Surfels::new(1);
    for &(x, y) in cells {
        surfels.cell[0][surfels.n] = x;
        surfels.cell[1][surfels.n] = y;
        surfels.triangle[surfels.n] = buffer.at(x, y).0;
        surfels.n += 1;
    }
    dispatch!(level, simd => fill(simd, domain, needs, &CENTER, &mut surfels));
    surfels
}

#[test]
fn surfels_agree_with_their_cells_and_do_not_depend_on_their_neighbours() {
    let mesh = solid();
    let size = Size::new(200, 150);
    let camera = camera();
    let domain = Domain::through_camera(&mesh, &camera, size);
    let buffer = InfoBuffer::build(&domain, &all(&mesh), Samples::One, None, &Workers::new(1));
    let cells: Vec<(u32, u32)> = (0..size.width * size.height)
        .map(|c| (c % size.width, c / size.width))
        .filter(|&(x, y)| buffer.at(x, y).0 != Hit::NOTHING)
        .collect();
    let m = camera.cells_from_world(size, mesh.bounds());
    let best = Level::new();
    for batch in cells.chunks(BATCH_FILL) {
        let s = filled(&domain, &buffer, best, batch);
        for (i, &(x, y)) in batch.iter().enumerate() {
            let at = |lanes: &[crate::math::Lane; 3]| vec3(lanes[0][i], lanes[1][i], lanes[2][i]);
            let position = at(&s.position);
            let c = m * position.extend(1.0);
            let miss = (vec2(c.x, c.y) / c.w - vec2(x as f32 + 0.5, y as f32 + 0.5)).abs().max_element();
            // Half a fixed-point step: the raster snaps corners, the surface point does not.
            assert!(miss < 0.01, "cell {x} {y} is missed by {miss}");
            assert!((at(&s.view) - (camera.eye() - position).normalize()).length() < 1e-4);
            assert!((s.uv[0].st[0][i] - position.x).abs() < 1e-4);
            // Footprint against the neighbouring cell, where that lies in the same triangle's plane well inside.
            if let Some(j) = batch.iter().position(|&c| c == (x + 1, y))
                && s.triangle[i] == s.triangle[j]
            {
                let difference = s.uv[0].st[0][j] - s.uv[0].st[0][i];
                let mean = (s.uv[0].d_dx[0][j] + s.uv[0].d_dx[0][i]) * 0.5;
                assert!((difference - mean).abs() < 1e-4 + 0.02 * mean.abs(), "{difference} {mean} at {x} {y}");
            }
        }
    }
    // One at a time, in reverse order, at every level: the same bits.
    let sample: Vec<(u32, u32)> = cells.iter().copied().step_by(7).take(240).collect();
    let together = filled(&domain, &buffer, best, &sample);
    let reversed: Vec<(u32, u32)> = sample.iter().rev().copied().collect();
    for level in LEVEL_NAMES.iter().filter_map(|n| level_by_name(n)) {
        let other = filled(&domain, &buffer, level, &reversed);
        for (i, &cell) in sample.iter().enumerate() {
            let j = sample.len() - 1 - i;
            let alone = filled(&domain, &buffer, level, &[cell]);
            let bits = |s: &Surfels, i: usize| {
                let lanes = s.position.iter().chain(&s.normal).chain(&s.view).chain(&s.uv[0].st).chain(&s.uv[0].d_dx);
                let lanes = lanes.chain(&s.barycentric).chain(s.d_barycentric.iter().flatten());
                lanes.map(|l| l[i].to_bits()).collect::<Vec<_>>()
            };
            assert_eq!(bits(&together, i), bits(&other, j));
            assert_eq!(bits(&together, i), bits(&alone, 0));
        }
    }
}

#[test]
fn every_thread_count_and_simd_level_gives_the_same_buffer() {
    let mesh = solid();
    let domain = Domain::through_camera(&mesh, &camera(), Size::new(333, 217));
    let draws = [
        Draw { triangles: 0..1000, faces: Faces::Front, kind: Kind::Solid },
        Draw { triangles: 1000..1400, faces: Faces::Both, kind: Kind::Tested },
        Draw { triangles: 1400..mesh.triangles().len() as u32, faces: Faces::Both, kind: Kind::Layered },
    ];
    for samples in [Samples::One, Samples::Four, Samples::Sixteen] {
        // A triangle with holes: every third cell.
        let test = || -> Box<AlphaTest> {
            Box::new(|_, places| {
                let kept = (0..8).filter(|&b| !places.column[b].is_multiple_of(3));
                kept.fold(0, |bits, b| bits | 1 << b) & places.bits
            })
        };
        let build = |n_threads, level| {
            InfoBuffer::build(&domain, &draws, samples, Some(&test), &Workers::with_level(n_threads, level))
        };
        let wanted = build(1, Level::new());
        assert!(wanted.tiles.iter().any(|t| t.n_layers >= 2), "no layers in the test scene");
        for level in LEVEL_NAMES.iter().filter_map(|n| level_by_name(n)) {
            for n_threads in [1, 2, 5] {
                let got = build(n_threads, level);
                for (a, b) in wanted.tiles.iter().zip(&got.tiles) {
                    assert!(a.solid.ids == b.solid.ids && a.solid.depths == b.solid.depths, "{level:?} {n_threads}");
                    assert_eq!(a.n_layers, b.n_layers);
                    for (a, b) in a.layers[..a.n_layers].iter().zip(&b.layers) {
                        assert!(a.ids == b.ids && a.depths == b.depths, "{level:?} {n_threads}");
                    }
                }
            }
        }
    }
}

#[test]
fn peeling_finds_every_layer_in_order_coplanar_ones_too() {
    let size = Size::new(8, 8);
    let sheet = [p(0, 0), p(16, 0), p(0, 16)];
    let mesh = flat(&[sheet; 5], size);
    let domain = Domain::over_atlas(&mesh, 0, size);
    let draws = [Draw { triangles: 0..5, faces: Faces::Both, kind: Kind::Layered }];
    let buffer = InfoBuffer::build(&domain, &draws, Samples::One, None, &Workers::new(1));
    let tile = &buffer.tiles[0];
    assert_eq!(tile.n_layers, 5);
    assert_eq!((0..5).map(|l| tile.layers[l].ids[0]).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
    assert_eq!(tile.solid.ids[0], Hit::NOTHING);
}

#[test]
fn triangles_behind_the_eye_or_out_of_all_bounds_leave_no_crack() {
    // A floor from far behind the eye to the horizon, of two triangles that share a long diagonal.
    let raw = RawMesh {
        positions: vec![vec3(-1e6, -1.0, -1e6), vec3(1e6, -1.0, -1e6), vec3(1e6, -1.0, 1e6), vec3(-1e6, -1.0, 1e6)],
        triangles: vec![[0, 3, 2], [0, 2, 1]],
        ..Default::default()
    };
    let mesh = raw.trusted();
    let camera =
        Camera::looking(Vec3::ZERO, vec3(-1.0, -0.5, -1.0), Vec3::Y, Projection::Perspective { fov_y: 0.8 }, 0.1);
    let size = Size::new(320, 200);
    let domain = Domain::through_camera(&mesh, &camera, size);
    let buffer = InfoBuffer::build(&domain, &all(&mesh), Samples::One, None, &Workers::new(1));
    let ids = buffer.ids();
    let below: Vec<u32> = ids[size.width as usize * 30..].to_vec();
    assert!(below.iter().all(|&id| id != Hit::NOTHING), "holes in the floor");
    assert!(below.contains(&0) && below.contains(&1));
}

#[test]
fn an_atlas_loses_no_triangle_and_its_gutter_is_as_wide_as_asked() {
    let size = Size::new(40, 20);
    // A needle between texel centres, and a square in the middle.
    let needle = [vec2(2.1, 3.6), vec2(30.2, 3.7), vec2(30.2, 3.8)];
    let (a, b) = ([p(10, 10), p(20, 10), p(10, 15)], [p(20, 10), p(20, 15), p(10, 15)]);
    let mesh = flat(&[needle, a, b], size);
    let count = |atlas: Atlas| {
        let ids = InfoBuffer::over_atlas(&mesh, 0, size, atlas, &Workers::new(2)).ids();
        [ids.iter().filter(|id| **id == 0).count(), ids.iter().filter(|id| [1, 2].contains(*id)).count()]
    };
    assert_eq!(count(Atlas::default()), [0, 50]);
    assert_eq!(count(Atlas { conservative: true, gutter: 0 }), [29, 50]);
    // Corners are filled too: a square widened by two is 14 x 9.
    assert_eq!(count(Atlas { conservative: false, gutter: 2 }), [0, 14 * 9]);
}
