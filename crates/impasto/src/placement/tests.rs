//! Placement against slow, obvious oracles: central differences in f64, and closed forms.

use crate::assets::{Element, Field, Mesh, RawMesh, UvSet, Values};
use crate::math::{DVec3, Mat4, Vec3, exact, hash_cell, unit_float, unit_or, vec2, vec3, vec4};
use crate::placement::number::{Number, Vector};
use crate::placement::rules::{Point, Rule, Visitor, resolve};
use crate::placement::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Plain f64 in place of a dual number.
#[derive(Clone, Copy, Debug)]
struct Exact(f64);

impl Number for Exact {
    fn constant(x: f32) -> Self {
        Self(x as f64)
    }
    fn times(self, factor: f32) -> Self {
        Self(self.0 * factor as f64)
    }
    fn plus(self, offset: f32) -> Self {
        Self(self.0 + offset as f64)
    }
    fn sqrt(self) -> Self {
        Self(self.0.max(0.0).sqrt())
    }
    fn atan2(self, x: Self) -> Self {
        Self(exact::atan2(self.0, x.0))
    }
    fn is_below(self, other: Self) -> bool {
        self.0 < other.0
    }
}
impl Add for Exact {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self(self.0 + b.0)
    }
}
impl Sub for Exact {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self(self.0 - b.0)
    }
}
impl Mul for Exact {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self(self.0 * b.0)
    }
}
impl Div for Exact {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        Self(if b.0 != 0.0 { self.0 / b.0 } else { 0.0 })
    }
}
impl Neg for Exact {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

fn random(i: usize, salt: u32) -> f32 {
    unit_float(hash_cell(i as i32, 0, 0, salt)) * 2.0 - 1.0
}

/// A bumpy closed surface with smooth normals, a UV set, and fields of all kinds.
fn pebble() -> Mesh {
    let (columns, rows) = (24u32, 12u32);
    let mut raw = RawMesh::default();
    let mut uv = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (column as f32 / columns as f32, row as f32 / rows as f32);
            let (sin_u, cos_u) = crate::math::sin_cos(u * std::f32::consts::TAU);
            let (sin_v, cos_v) = crate::math::sin_cos(v * std::f32::consts::PI);
            let bump = 1.0 + 0.15 * crate::math::sin_cos(3.0 * u * std::f32::consts::TAU).0 * sin_v;
            raw.positions.push(vec3(1.4 * sin_u * sin_v, cos_v, 0.9 * cos_u * sin_v) * bump + vec3(0.3, -0.2, 0.1));
            uv.push(vec2(u, v));
        }
    }
    let at = |row: u32, column: u32| row * (columns + 1) + column;
    for row in 0..rows {
        for column in 0..columns {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(r, k)| at(row + r, column + k));
            raw.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    raw.triangles.retain(|t| {
        let [a, b, c] = t.map(|v| raw.positions[v as usize]);
        (b - a).cross(c - a).length() > 1e-4
    });
    let field = |name: &str, element, n_components, n: usize| Field {
        name: name.into(),
        unit: String::new(),
        element,
        n_components,
        values: Values::F64((0..n * n_components).map(|i| 1e6 + random(i, 77) as f64).collect()),
    };
    let (n_vertices, n_triangles) = (raw.positions.len(), raw.triangles.len());
    raw.fields = vec![
        field("vertex", Element::Vertex, 3, n_vertices),
        field("face", Element::Face, 1, n_triangles),
        field("corner", Element::Corner, 1, n_triangles * 3),
    ];
    raw.uv_sets = vec![UvSet { name: "uv0".into(), uv }];
    raw.mend().value
}

/// World to eye space of an eye that looks at a point, +Y up.
fn looking_from(eye: Vec3, at: Vec3) -> Mat4 {
    let z = (eye - at).normalize();
    let x = Vec3::Y.cross(z).normalize();
    let y = z.cross(x);
    let columns = [vec3(x.x, y.x, z.x), vec3(x.y, y.y, z.y), vec3(x.z, y.z, z.z)];
    let moved = vec4(-x.dot(eye), -y.dot(eye), -z.dot(eye), 1.0);
    Mat4::from_cols(columns[0].extend(0.0), columns[1].extend(0.0), columns[2].extend(0.0), moved)
}

/// Clip from eye space for lines of sight that meet in the eye: w is the distance in front of it.
fn lens() -> Mat4 {
    Mat4::from_cols(
        vec4(2.0, 0.0, 0.0, 0.0),
        vec4(0.0, 2.4, 0.0, 0.0),
        vec4(0.0, 0.0, -1.1, -1.0),
        vec4(0.0, 0.0, -0.2, 0.0),
    )
}

fn view() -> Viewpoint {
    let eye = vec3(1.5, 2.0, 5.0);
    Viewpoint { eye_from_world: looking_from(eye, vec3(0.2, -0.1, 0.0)), eye, parallel: None }
}

/// Random surfels on the mesh, as a rasterizer would fill them.
fn scattered(mesh: &Mesh, salt: u32) -> Box<Surfels> {
    let mut surfels = Surfels::new(mesh.uv_sets().len());
    surfels.n = 251;
    for i in 0..surfels.n {
        surfels.triangle[i] = hash_cell(i as i32, 1, 0, salt) % mesh.triangles().len() as u32;
        let (b, c) = (random(i, salt + 1).abs(), random(i, salt + 2).abs());
        let (b, c) = if b + c < 1.0 { (b, c) } else { (1.0 - b, 1.0 - c) };
        (surfels.barycentric[0][i], surfels.barycentric[1][i]) = (b, c);
        for axis in 0..2 {
            for k in 0..2 {
                surfels.d_barycentric[axis][k][i] = 0.05 * random(i, salt + 3 + axis as u32 * 2 + k as u32);
            }
        }
        surfels.side[i] = if i % 5 == 0 { -1.0 } else { 1.0 };
        let [p, n] = stand(mesh, &surfels, i, 0.0, 0.0);
        for k in 0..3 {
            surfels.position[k][i] = p[k] as f32;
            surfels.normal[k][i] = n[k] as f32;
        }
        let t = mesh.triangles()[surfels.triangle[i] as usize].map(|v| mesh.uv_sets()[0].uv[v as usize]);
        for k in 0..2 {
            let step = |w: [f32; 2]| w[0] * (t[1][k] - t[0][k]) + w[1] * (t[2][k] - t[0][k]);
            surfels.uv[0].st[k][i] = t[0][k] + step([b, c]);
            surfels.uv[0].d_dx[k][i] = step(surfels.d_barycentric[0].each_ref().map(|l| l[i]));
            surfels.uv[0].d_dy[k][i] = step(surfels.d_barycentric[1].each_ref().map(|l| l[i]));
        }
    }
    surfels
}

/// Position and normal a little to the side of cell `i`, in f64.
fn stand(mesh: &Mesh, surfels: &Surfels, i: usize, x: f64, y: f64) -> [DVec3; 2] {
    let [b, c] = [0, 1].map(|k| {
        let [dx, dy] = [0, 1].map(|axis| surfels.d_barycentric[axis][k][i] as f64);
        surfels.barycentric[k][i] as f64 + x * dx + y * dy
    });
    let t = mesh.triangles()[surfels.triangle[i] as usize].map(|v| v as usize);
    let blend = |of: &[Vec3]| {
        let [p, q, r] = t.map(|v| of[v].as_dvec3());
        p + (q - p) * b + (r - p) * c
    };
    [blend(mesh.positions()), blend(mesh.normals()).normalize()]
}

/// Evaluates a rule in f64 beside cell `i`.
struct Oracle<'a> {
    mesh: &'a Mesh,
    surfels: &'a Surfels,
    i: usize,
    x: f64,
    y: f64,
}

impl Visitor for Oracle<'_> {
    type Output = [f64; 3];
    fn visit(self, rule: &impl Rule) -> [f64; 3] {
        let [position, normal] = stand(self.mesh, self.surfels, self.i, self.x, self.y);
        let vector = |v: DVec3| -> Vector<Exact> { v.to_array().map(Exact) };
        let point = Point { position: vector(position), normal: vector(normal), side: self.surfels.side[self.i] };
        rule.at(&point).map(|x| x.0)
    }
}

fn projector() -> Projector {
    let bounds = pebble().bounds();
    Projector::facing(&bounds, vec3(0.3, 0.2, 1.0), vec3(0.1, 1.0, 0.0))
}

/// Every source that is a function of place and normal.
fn all_placements() -> Vec<Placement> {
    let planes = [vec4(0.5, 0.1, -0.3, 0.2), vec4(0.0, -0.7, 0.2, 0.5), vec4(1.0, 0.0, 0.0, -0.1)];
    let mut all = vec![
        Placement::ObjectLinear { planes, world_from_object: None },
        Placement::ObjectLinear {
            planes,
            world_from_object: Some(Mat4::from_rotation_y(0.5) * Mat4::from_scale(vec3(1.0, 2.0, 0.5))),
        },
        Placement::EyeLinear { planes },
        Placement::WorldLinear { planes },
        Placement::SphereMap,
        Placement::ViewNormal,
        Placement::Camera { clip_from_world: lens() * looking_from(vec3(-3.0, 1.0, 2.0), Vec3::ZERO) },
        Placement::Position { unit: PositionUnit::Model },
        Placement::Position { unit: PositionUnit::Bounds },
    ];
    for space in [Space::World, Space::Eye] {
        all.extend([Placement::ReflectionMap { space }, Placement::NormalMap { space }]);
        for direction in [Direction::Reflection, Direction::Normal, Direction::Position] {
            all.push(Placement::Equirectangular { direction, space });
        }
    }
    for projector in [None, Some(projector())] {
        all.extend([
            Placement::Planar { projector },
            Placement::Cylindrical { projector },
            Placement::Spherical { projector },
            Placement::Box { projector },
        ]);
        for surface in [Intermediate::Plane, Intermediate::Cylinder, Intermediate::Sphere, Intermediate::Box] {
            for ray in [ObjectRay::ReflectedRay, ObjectRay::ObjectNormal, ObjectRay::Centroid, ObjectRay::SurfaceNormal]
            {
                all.push(Placement::TwoPart(TwoPart { surface, ray, projector }));
            }
        }
    }
    all
}

fn coords_of(placement: &Placement, matrix: Mat4, view: &Viewpoint, mesh: &Mesh, surfels: &Surfels) -> TexCoords {
    let mut out = TexCoords::ZERO;
    place(placement, &matrix, view, mesh, surfels, &mut Measures::default(), &mut out);
    out
}

#[test]
fn footprints_are_the_derivatives_of_every_source() {
    let mesh = pebble();
    let surfels = scattered(&mesh, 1);
    let parallel = Viewpoint { parallel: Some(unit_or(vec3(0.3, 0.4, 1.0), Vec3::Z)), ..view() };
    for placement in all_placements() {
        for view in [view(), parallel] {
            let got = coords_of(&placement, Mat4::IDENTITY, &view, &mesh, &surfels);
            let mut n_compared = 0;
            for i in 0..surfels.n {
                let oracle = |x, y| {
                    resolve(&placement, &view, &mesh, Oracle { mesh: &mesh, surfels: &surfels, i, x, y }).unwrap()
                };
                let value = oracle(0.0, 0.0);
                let h = 1e-4;
                for (axis, (x, y)) in [(h, 0.0), (0.0, h)].into_iter().enumerate() {
                    let (before, after) = (oracle(-x, -y), oracle(x, y));
                    let truth: [f64; 3] = std::array::from_fn(|k| (after[k] - before[k]) / (2.0 * h));
                    // Where the coordinate jumps, or bends within the difference, there is nothing to compare with.
                    let bend = (0..3).map(|k| (after[k] - 2.0 * value[k] + before[k]).abs()).fold(0.0, f64::max);
                    if bend > 1e-5 {
                        continue;
                    }
                    n_compared += 1;
                    for k in 0..3 {
                        let lane = |d: &[crate::math::Lane; 2]| d[k.min(1)][i];
                        let slope = match (k, axis) {
                            (2, _) => got.r[1 + axis][i],
                            (_, 0) => lane(&got.d_dx),
                            _ => lane(&got.d_dy),
                        } as f64;
                        let scale = 1.0 + truth.iter().map(|t| t.abs()).fold(0.0, f64::max) + value[k].abs();
                        assert!(
                            (slope - truth[k]).abs() < 2e-3 * scale,
                            "{placement:?}: cell {i}, coordinate {k}, axis {axis}: {slope}, not {}",
                            truth[k]
                        );
                    }
                }
                let got = [got.st[0][i], got.st[1][i], got.r[0][i]];
                for k in 0..3 {
                    let difference = (got[k] as f64 - value[k]).abs();
                    let wrapped = (difference - 1.0).abs() < 1e-4;
                    assert!(
                        difference < 2e-4 * (1.0 + value[k].abs()) || wrapped,
                        "{placement:?}: cell {i}, coordinate {k}: {} not {}",
                        got[k],
                        value[k]
                    );
                }
            }
            assert!(n_compared > surfels.n, "{placement:?}: only {n_compared} cells could be compared");
        }
    }
}

/// s, t, r of one cell.
fn at(coords: &TexCoords, i: usize) -> [f32; 3] {
    [coords.st[0][i], coords.st[1][i], coords.r[0][i]]
}

#[track_caller]
fn assert_near(got: [f32; 3], truth: [f64; 3], what: &str) {
    let near = (0..3).all(|k| (got[k] as f64 - truth[k]).abs() < 1e-4 * (1.0 + truth[k].abs()));
    assert!(near, "{what}: {got:?} not {truth:?}");
}

/// A single surfel at a place, with a normal, that stands still.
fn lone(position: Vec3, normal: Vec3) -> (Mesh, Box<Surfels>) {
    let positions = vec![position, position + Vec3::X, position + Vec3::Y];
    let raw = RawMesh { positions, triangles: vec![[0, 1, 2]], normals: vec![normal; 3], ..RawMesh::default() };
    let mut surfels = Surfels::new(0);
    surfels.n = 1;
    for k in 0..3 {
        surfels.position[k][0] = position[k];
        surfels.normal[k][0] = normal[k];
    }
    (raw.trusted(), surfels)
}

/// The box from -1 to 1.
fn cube() -> Option<Projector> {
    Some(Projector { origin: Vec3::ZERO, axes: [Vec3::X, Vec3::Y, Vec3::Z], size: Vec3::splat(2.0) })
}

#[test]
fn pictures_stand_upright_and_face_the_onlooker() {
    let eye = vec3(0.0, 0.0, 100.0);
    let view = Viewpoint { eye_from_world: looking_from(eye, Vec3::ZERO), eye, parallel: Some(Vec3::Z) };
    let diagonal = unit_or(vec3(0.0, 1.0, 1.0), Vec3::Y);
    let environment = |direction| Placement::Equirectangular { direction, space: Space::World };
    let cases = [
        // What, where, facing where, (s, t).
        (Placement::Planar { projector: cube() }, vec3(-1.0, 1.0, 1.0), Vec3::Z, [0.0, 0.0]),
        (Placement::Planar { projector: cube() }, vec3(1.0, -1.0, 1.0), Vec3::Z, [1.0, 1.0]),
        (Placement::Cylindrical { projector: cube() }, vec3(0.0, 1.0, 1.0), Vec3::Z, [0.5, 0.0]),
        (Placement::Cylindrical { projector: cube() }, vec3(1.0, 0.0, 0.0), Vec3::X, [0.75, 0.5]),
        (Placement::Spherical { projector: cube() }, vec3(-1.0, 0.0, 0.0), Vec3::X, [0.25, 0.5]),
        (Placement::Spherical { projector: cube() }, vec3(0.0, -1.0, 1.0), Vec3::Z, [0.5, 0.75]),
        (Placement::Box { projector: cube() }, vec3(0.5, 0.5, 1.0), Vec3::Z, [0.75, 0.25]),
        (Placement::Box { projector: cube() }, vec3(1.0, 0.5, 0.5), Vec3::X, [0.25, 0.25]),
        (Placement::Box { projector: cube() }, vec3(-1.0, 0.5, 0.5), Vec3::NEG_X, [0.75, 0.25]),
        (Placement::Box { projector: cube() }, vec3(0.5, 0.5, -1.0), Vec3::NEG_Z, [0.25, 0.25]),
        (Placement::Box { projector: cube() }, vec3(0.5, 1.0, 0.5), Vec3::Y, [0.75, 0.75]),
        (Placement::Box { projector: cube() }, vec3(0.5, -1.0, 0.5), Vec3::NEG_Y, [0.75, 0.25]),
        (Placement::ViewNormal, Vec3::ZERO, Vec3::Z, [0.5, 0.5]),
        (Placement::ViewNormal, Vec3::ZERO, Vec3::Y, [0.5, 0.0]),
        (Placement::ViewNormal, Vec3::ZERO, Vec3::X, [1.0, 0.5]),
        (Placement::SphereMap, Vec3::ZERO, Vec3::Z, [0.5, 0.5]),
        // A mirror tilted by 45 degrees shows what is straight above: half way out on the mirror ball's picture.
        (Placement::SphereMap, Vec3::ZERO, diagonal, [0.5, 0.5 - 0.5f32.sqrt() / 2.0]),
        (environment(Direction::Normal), Vec3::ZERO, Vec3::NEG_Z, [0.5, 0.5]),
        (environment(Direction::Normal), Vec3::ZERO, Vec3::X, [0.75, 0.5]),
        (environment(Direction::Reflection), Vec3::ZERO, unit_or(vec3(1.0, 0.0, 1.0), Vec3::X), [0.75, 0.5]),
        (environment(Direction::Reflection), Vec3::ZERO, diagonal, [0.5, 0.0]),
    ];
    for (placement, position, normal, st) in cases {
        let (mesh, surfels) = lone(position, normal);
        let got = coords_of(&placement, Mat4::IDENTITY, &view, &mesh, &surfels);
        let got = [got.st[0][0], got.st[1][0]];
        // Straight above, the longitude is anything.
        let any_longitude = got[1].abs() < 1e-3 && matches!(placement, Placement::Equirectangular { .. });
        assert!(
            ((got[0] - st[0]).abs() < 1e-3 || any_longitude) && (got[1] - st[1]).abs() < 1e-3,
            "{placement:?} at {position}, facing {normal}: {got:?} not {st:?}"
        );
    }
}

#[test]
fn normals_of_back_faces_are_those_that_are_seen() {
    let (mesh, mut surfels) = lone(Vec3::ZERO, vec3(0.0, 0.6, -0.8));
    surfels.side[0] = -1.0;
    let view = Viewpoint { parallel: Some(Vec3::Z), eye_from_world: Mat4::IDENTITY, eye: Vec3::Z };
    let got = at(&coords_of(&Placement::ViewNormal, Mat4::IDENTITY, &view, &mesh, &surfels), 0);
    assert_near(got, [0.5, 0.8, 0.0], "ViewNormal");
    let normals = Placement::NormalMap { space: Space::World };
    assert_near(at(&coords_of(&normals, Mat4::IDENTITY, &view, &mesh, &surfels), 0), [0.0, -0.6, 0.8], "NormalMap");
}

#[test]
fn two_part_mappings_meet_the_intermediate_surface() {
    let mesh = pebble();
    let surfels = scattered(&mesh, 40);
    let (view, projector) = (view(), projector());
    let axes = projector.axes.map(|a| a.as_dvec3());
    let half = projector.size.as_dvec3() * 0.5;
    for i in 0..surfels.n {
        let [position, normal] = stand(&mesh, &surfels, i, 0.0, 0.0);
        let local = |v: DVec3| DVec3::from(axes.map(|a| a.dot(v)));
        let p = local(position - projector.origin.as_dvec3());
        let sight = (position - view.eye.as_dvec3()).normalize();
        for ray in [ObjectRay::ReflectedRay, ObjectRay::ObjectNormal, ObjectRay::Centroid] {
            let d = match ray {
                ObjectRay::ReflectedRay => local(sight.reflect(normal)),
                ObjectRay::ObjectNormal => local(normal),
                _ => p.normalize(),
            };
            for surface in [Intermediate::Plane, Intermediate::Cylinder, Intermediate::Sphere, Intermediate::Box] {
                // The obvious way: walk outward along the ray, then halve the interval in which it got out.
                let is_outside = |q: DVec3| match surface {
                    Intermediate::Plane => q.z > half.z,
                    Intermediate::Cylinder => q.x.hypot(q.z) > half.x.hypot(half.z),
                    Intermediate::Sphere => q.length() > half.length(),
                    Intermediate::Box => (q.abs() - half).max_element() > 0.0,
                };
                let (mut near, mut far) = (0.0, 100.0);
                let meets = is_outside(p + d * far);
                for _ in 0..60 {
                    let middle = 0.5 * (near + far);
                    if is_outside(p + d * middle) { far = middle } else { near = middle }
                }
                let q = p + d * near;
                let turn = |x: f64, z: f64| exact::atan2(x, z) / std::f64::consts::TAU + 0.5;
                let side = |right: f64, up: f64| [0.5 + right, 0.5 - up];
                let u = q / (2.0 * half);
                let st = match surface {
                    Intermediate::Plane => side(u.x, u.y),
                    Intermediate::Cylinder => [turn(q.x, q.z), 0.5 - u.y],
                    Intermediate::Sphere => [turn(q.x, q.z), exact::acos(q.y / q.length()) / std::f64::consts::PI],
                    Intermediate::Box => match u.abs().to_array() {
                        [x, y, z] if x > y && x > z => side(-u.z * u.x.signum(), u.y),
                        [_, y, z] if y > z => side(u.x, -u.z * u.y.signum()),
                        _ => side(u.x * u.z.signum(), u.y),
                    },
                };
                let placement = Placement::TwoPart(TwoPart { surface, ray, projector: Some(projector) });
                let got = at(&coords_of(&placement, Mat4::IDENTITY, &view, &mesh, &surfels), i);
                if surface == Intermediate::Plane && !meets {
                    // Beyond 100 units along a ray that hardly rises there is an answer, but a useless one.
                    assert!(d.z > 0.0 || got == [-1.0, -1.0, 0.0], "{placement:?}: {got:?}");
                } else if meets {
                    assert_near(got, [st[0], st[1], 0.0], &format!("{placement:?}, cell {i}, ray {d}"));
                }
            }
        }
    }
}

#[test]
fn the_pairs_that_are_said_to_be_the_same_are() {
    let mesh = pebble();
    let (surfels, view) = (scattered(&mesh, 50), view());
    let projector = Some(projector());
    let pair = |surface, ray| Placement::TwoPart(TwoPart { surface, ray, projector });
    let cases = [
        (pair(Intermediate::Plane, ObjectRay::SurfaceNormal), Placement::Planar { projector }),
        (pair(Intermediate::Cylinder, ObjectRay::SurfaceNormal), Placement::Cylindrical { projector }),
        (pair(Intermediate::Sphere, ObjectRay::SurfaceNormal), Placement::Spherical { projector }),
        (pair(Intermediate::Sphere, ObjectRay::Centroid), Placement::Spherical { projector }),
    ];
    for (two_part, simple) in cases {
        let Placement::TwoPart(named) = &two_part else { unreachable!() };
        assert!(named.remark().is_some_and(|remark| remark.starts_with("the same")));
        let a = coords_of(&two_part, Mat4::IDENTITY, &view, &mesh, &surfels);
        let b = coords_of(&simple, Mat4::IDENTITY, &view, &mesh, &surfels);
        for i in 0..surfels.n {
            let [x, y] = [at(&a, i), at(&b, i)];
            assert!((x[0] - y[0]).abs() < 1e-5 && (x[1] - y[1]).abs() < 1e-5, "{two_part:?}: {x:?} not {y:?}");
        }
    }
}

#[test]
fn footprints_stay_small_across_the_seam() {
    // A quad behind the axis that crosses x = 0: s jumps from 0 to 1 between neighbouring cells.
    let (mesh, mut surfels) = lone(vec3(-0.5, 0.0, -1.0), Vec3::NEG_Z);
    surfels.n = 2;
    for (i, x) in [-0.01f32, 0.01].into_iter().enumerate() {
        surfels.position.iter_mut().zip([x, 0.0, -1.0]).for_each(|(lane, v)| lane[i] = v);
        surfels.normal.iter_mut().zip([0.0, 0.0, -1.0]).for_each(|(lane, v)| lane[i] = v);
        surfels.d_barycentric[0][0][i] = 0.02;
    }
    for placement in [Placement::Cylindrical { projector: cube() }, Placement::Spherical { projector: cube() }] {
        let got = coords_of(&placement, Mat4::IDENTITY, &view(), &mesh, &surfels);
        assert!((got.st[0][0] - got.st[0][1]).abs() > 0.9);
        for i in 0..2 {
            assert!((got.d_dx[0][i].abs() - 0.02 / std::f32::consts::TAU).abs() < 1e-5);
        }
    }
}

#[test]
fn uv_sets_pass_through_and_take_a_matrix() {
    let mesh = pebble();
    let (surfels, view) = (scattered(&mesh, 60), view());
    let uv = Placement::Uv(0);
    let turned = Mat4::from_rotation_z(0.5);
    assert_eq!((uv.as_uv(&Mat4::IDENTITY), uv.as_uv(&turned), uv.needs().uv_sets), (Some(0), None, 1));
    let plain = coords_of(&uv, Mat4::IDENTITY, &view, &mesh, &surfels);
    let moved = coords_of(&uv, Mat4::from_scale(vec3(3.0, -2.0, 1.0)), &view, &mesh, &surfels);
    let mut wide = Mat4::IDENTITY;
    wide.x_axis.w = 0.25;
    let projected = coords_of(&uv, wide, &view, &mesh, &surfels);
    for i in 0..surfels.n {
        let [s, t] = [surfels.uv[0].st[0][i], surfels.uv[0].st[1][i]];
        assert_eq!(at(&plain, i), [s, t, 0.0]);
        assert_eq!(at(&moved, i), [3.0 * s, -2.0 * t, 0.0]);
        assert_eq!(moved.d_dx[0][i], 3.0 * surfels.uv[0].d_dx[0][i]);
        let q = 1.0 + 0.25 * s as f64;
        assert_near(at(&projected, i), [s as f64 / q, t as f64 / q, 0.0], "projective");
        // The quotient rule: d(t/q) = (dt - t/q dq) / q.
        let slope = (surfels.uv[0].d_dy[1][i] as f64 - t as f64 / q * 0.25 * surfels.uv[0].d_dy[0][i] as f64) / q;
        assert!((projected.d_dy[1][i] as f64 - slope).abs() < 1e-5);
    }
    let missing = coords_of(&Placement::Uv(7), Mat4::IDENTITY, &view, &mesh, &surfels);
    assert!(at(&missing, 0) == [0.0; 3] && !Placement::Uv(7).fits(&mesh) && uv.fits(&mesh));
}

#[test]
fn fields_are_read_per_vertex_face_and_corner_and_stay_missing() {
    let mesh = pebble();
    let (surfels, view) = (scattered(&mesh, 70), view());
    let axis = |field, component| {
        let property = Property::Field { field, component, missing: Missing::Nearest };
        Some(PropertyAxis::over(property, [1e6 - 1.0, 1e6 + 1.0]))
    };
    let placement = Placement::Property { axes: [axis(0, Some(2)), axis(1, Some(0)), axis(2, Some(0))] };
    let got = coords_of(&placement, Mat4::IDENTITY, &view, &mesh, &surfels);
    for i in 0..surfels.n {
        let t = surfels.triangle[i] as usize;
        let [b, c] = [0, 1].map(|k: usize| surfels.barycentric[k][i] as f64);
        let blend = |v: [f64; 3]| (v[0] * (1.0 - b - c) + v[1] * b + v[2] * c - (1e6 - 1.0)) / 2.0;
        let corner = |k| mesh.fields()[2].values.at(t * 3 + k);
        let truth = [
            blend(mesh.triangles()[t].map(|v| mesh.fields()[0].values.at(v as usize * 3 + 2))),
            blend([mesh.fields()[1].values.at(t); 3]),
            blend([corner(0), corner(1), corner(2)]),
        ];
        assert_near(at(&got, i), truth, "fields");
        assert_eq!(got.d_dx[1][i], 0.0);
        let d = [0, 1].map(|k: usize| surfels.d_barycentric[0][k][i] as f64);
        let slope = (d[0] * (corner(1) - corner(0)) + d[1] * (corner(2) - corner(0))) / 2.0;
        assert!((got.r[1][i] as f64 - slope).abs() < 1e-5);
    }

    let mut raw = mesh.into_raw();
    raw.fields[1].values = Values::F32(vec![f32::NAN; raw.triangles.len()]);
    let mesh = raw.mend().value;
    let placement = Placement::Property { axes: [axis(1, Some(0)), None, None] };
    for matrix in [Mat4::IDENTITY, Mat4::from_scale(vec3(2.0, 1.0, 1.0))] {
        let got = coords_of(&placement, matrix, &view, &mesh, &surfels);
        assert!(got.st[0][3].is_nan() && got.d_dx[0][3] == 0.0 && got.d_dy[0][3] == 0.0);
    }
    assert_eq!(at(&coords_of(&placement, Mat4::IDENTITY, &view, &mesh, &surfels), 3)[1], 0.5);
    let absent = Placement::Property { axes: [axis(1, Some(4)), axis(9, None), None] };
    assert!(placement.fits(&mesh) && !absent.fits(&mesh));
    assert!(coords_of(&absent, Mat4::IDENTITY, &view, &mesh, &surfels).st[0][0].is_nan());
}

#[test]
fn points_behind_a_slide_projector_get_no_picture() {
    let placement = Placement::Camera { clip_from_world: lens() * looking_from(vec3(0.0, 0.0, 5.0), Vec3::ZERO) };
    let (mesh, surfels) = lone(vec3(0.0, 0.0, 9.0), Vec3::Z);
    let got = coords_of(&placement, Mat4::IDENTITY, &view(), &mesh, &surfels);
    assert_eq!(at(&got, 0), [-1.0; 3]);
    let (mesh, surfels) = lone(vec3(1.0, 0.5, 0.0), Vec3::Z);
    let got = coords_of(&placement, Mat4::IDENTITY, &view(), &mesh, &surfels);
    assert_near(at(&got, 0), [0.5 + 0.2, 0.5 - 0.12, (5.0 * 1.1 - 0.2) / 5.0], "slide");
}

#[test]
fn numbers_stay_finite_at_poles_and_edges() {
    let view = view();
    let places = [Vec3::ZERO, Vec3::Y, Vec3::NEG_Y, Vec3::ONE, view.eye, Vec3::splat(1e17)];
    for placement in all_placements() {
        for position in places {
            for normal in [Vec3::Y, Vec3::NEG_Z, unit_or(view.eye, Vec3::Y)] {
                let (mesh, mut surfels) = lone(position, normal);
                surfels.d_barycentric = [[[0.1; crate::math::BATCH]; 2]; 2];
                let got = coords_of(&placement, Mat4::IDENTITY, &view, &mesh, &surfels);
                let all = [got.st[0][0], got.st[1][0], got.d_dx[0][0], got.d_dx[1][0], got.d_dy[0][0], got.d_dy[1][0]];
                let r = got.r.each_ref().map(|lane| lane[0]);
                assert!(all.iter().chain(&r).all(|x| x.is_finite()), "{placement:?} at {position}: {all:?} {r:?}");
            }
        }
    }
}

#[test]
fn per_vertex_coordinates_agree_where_the_source_is_linear() {
    let mesh = pebble();
    let (surfels, view) = (scattered(&mesh, 80), view());
    for placement in [Placement::Uv(0), Placement::Planar { projector: None }] {
        let exact = coords_of(&placement, Mat4::IDENTITY, &view, &mesh, &surfels);
        let mut got = TexCoords::ZERO;
        place_per_vertex(&placement, &Mat4::IDENTITY, &view, &mesh, &surfels, &mut got);
        for i in 0..surfels.n {
            for k in 0..2 {
                assert!((got.st[k][i] - exact.st[k][i]).abs() < 1e-5);
                assert!((got.d_dx[k][i] - exact.d_dx[k][i]).abs() < 1e-5);
                assert!((got.d_dy[k][i] - exact.d_dy[k][i]).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn triplanar_weights_share_out_the_whole_and_favour_the_facing_side() {
    let mesh = pebble();
    let surfels = scattered(&mesh, 90);
    let projector = projector();
    let mut coords = [TexCoords::ZERO, TexCoords::ZERO, TexCoords::ZERO];
    let mut weights = [[0.0; crate::math::BATCH]; 3];
    triplanar(&projector, 6, &mesh, &surfels, &mut coords, &mut weights);
    let boxed = coords_of(&Placement::Box { projector: Some(projector) }, Mat4::IDENTITY, &view(), &mesh, &surfels);
    for i in 0..surfels.n {
        let w = [0, 1, 2].map(|k: usize| weights[k][i]);
        assert!((w[0] + w[1] + w[2] - 1.0).abs() < 1e-5);
        let best = (0..3).max_by(|&a, &b| w[a].total_cmp(&w[b])).unwrap();
        assert_eq!(at(&coords[best], i), at(&boxed, i), "cell {i}: {w:?}");
    }
}
