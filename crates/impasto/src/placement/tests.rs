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
    place(placement, &matrix, view, mesh, surfels, &mut out);
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
