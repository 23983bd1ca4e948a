//! The plain bodies: plane, cube, cylinder, cone, and three spheres.

use crate::assets::{Mesh, RawMesh};
use crate::math::exact::{cos, sin};
use crate::math::{DVec2, DVec3};
use crate::samples::sheet::{self, Point};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// The square from (-1, 0, -1) to (1, 0, 1), seen from above, in `n` x `n` cells; the texture's top lies at the back.
pub fn plane(n: u32) -> Mesh {
    let mut raw = sheet::empty();
    face(&mut raw, n, [DVec3::ZERO, DVec3::X, -DVec3::Z], |uv| uv);
    sheet::finish(raw)
}

/// The square from (-1, -1, 0) to (1, 1, 0) facing +Z: a picture on a wall.
pub fn quad() -> Mesh {
    let mut raw = sheet::empty();
    face(&mut raw, 1, [DVec3::ZERO, DVec3::X, DVec3::Y], |uv| uv);
    sheet::finish(raw)
}

/// The cube from -1 to 1, `n` x `n` cells a side, closed, sharp edges; each side shows the whole texture upright.
pub fn cube(n: u32) -> Mesh {
    let mut raw = sheet::empty();
    for out in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z] {
        let up = if out.y > 0.0 {
            -DVec3::Z
        } else if out.y < 0.0 {
            DVec3::Z
        } else {
            DVec3::Y
        };
        face(&mut raw, n, [out, up.cross(out), up], |uv| uv);
    }
    sheet::finish(raw)
}

/// A square of edge 2 about a centre, given its right and up.
fn face(raw: &mut RawMesh, n: u32, [center, right, up]: [DVec3; 3], uv: impl Fn(DVec2) -> DVec2) {
    let n = n.max(1);
    sheet::grid(raw, [n, n], |i, j| {
        let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
        Point {
            position: center + right * (2.0 * s - 1.0) + up * (2.0 * t - 1.0),
            normal: right.cross(up),
            uv: uv(DVec2::new(s, 1.0 - t)),
        }
    });
}

/// Radius 1, from y = -1 to 1, closed, with sharp rims: a soup tin. The side takes the texture's upper part once around,
/// the lids lie below it.
pub fn cylinder(n_around: u32, n_up: u32) -> Mesh {
    turned(n_around, n_up, 1.0)
}

/// Radius 1 at y = -1, apex at y = 1, closed, with a sharp rim.
pub fn cone(n_around: u32, n_up: u32) -> Mesh {
    turned(n_around, n_up, 0.0)
}

/// A frustum between y = -1 and 1 with base radius 1. The side is a 2 pi by 2 strip, lids are discs; all at one scale.
fn turned(n_around: u32, n_up: u32, top: f64) -> Mesh {
    let (n, n_up) = (n_around.max(3), n_up.max(1));
    let mut raw = sheet::empty();
    let slant = (4.0 + (1.0 - top) * (1.0 - top)).sqrt();
    // One texture width is the way around and a little, so that charts do not touch.
    let scale = 0.98 / (2.0 * PI);
    let turn = |i: f64| 2.0 * PI * i / n as f64;
    let ring = |i: u32, radius: f64, y: f64| {
        DVec3::new(radius * sin(turn((i % n) as f64)), y, radius * cos(turn((i % n) as f64)))
    };
    sheet::grid(&mut raw, [n, n_up], |i, j| {
        let t = j as f64 / n_up as f64;
        let is_apex = j == n_up && top == 0.0;
        // At an apex each triangle has a corner and a normal of its own: `sheet` keeps the one on its right.
        let at = if is_apex { i as f64 - 0.5 } else { i as f64 };
        let angle = turn(if is_apex { at } else { (i % n) as f64 });
        Point {
            position: ring(i, 1.0 + (top - 1.0) * t, 2.0 * t - 1.0),
            normal: DVec3::new(2.0 * sin(angle), 1.0 - top, 2.0 * cos(angle)),
            uv: DVec2::new(0.01 + 0.98 * at / n as f64, 0.01 + slant * (1.0 - t) * scale),
        }
    });
    for (y, radius, corner) in [(-1.0, 1.0, 0.25), (1.0, top, 0.75)] {
        if radius == 0.0 {
            continue;
        }
        let center = DVec2::new(corner, 0.03 + (slant + 1.0) * scale);
        let rows = (n / 8).clamp(1, 64);
        sheet::grid(&mut raw, [n, rows], |i, j| {
            // Rows run outwards below and inwards above, so that both lids face away from the body.
            let share = if y < 0.0 { j } else { rows - j } as f64 / rows as f64;
            let flat = DVec2::new(sin(turn(i as f64)), cos(turn(i as f64)) * -y) * (share * scale);
            Point {
                position: ring(i, radius * share, y),
                normal: DVec3::Y * y,
                uv: center - DVec2::new(-flat.x, flat.y),
            }
        });
    }
    sheet::finish(raw)
}

/// A gently waved sphere of about unit radius, smooth everywhere, poles included; u once around, v from pole to pole.
pub fn displaced_sphere(n_lat: u32, n_lon: u32) -> Mesh {
    latitudes(n_lat, n_lon, &|d| {
        const K: f64 = 4.3;
        let (s, c) = (d.to_array().map(|x| sin(K * x)), d.to_array().map(|x| cos(K * x)));
        let wave = s[0] * c[1] + s[1] * c[2] + s[2] * c[0];
        let slope = [c[0] * c[1] - s[2] * s[0], c[1] * c[2] - s[0] * s[1], c[2] * c[0] - s[1] * s[2]];
        (1.0 + 0.085 * wave, DVec3::from(slope.map(|x| 0.085 * K * x)))
    })
}

/// The unit sphere by circles of latitude; u once around, v from pole to pole.
pub fn sphere(n_lat: u32, n_lon: u32) -> Mesh {
    latitudes(n_lat, n_lon, &|_| (1.0, DVec3::ZERO))
}

/// A star-shaped surface: `radius` gives the distance from the centre in a unit direction, and its gradient there.
fn latitudes(n_lat: u32, n_lon: u32, radius: &dyn Fn(DVec3) -> (f64, DVec3)) -> Mesh {
    let (n_lat, n_lon) = (n_lat.max(2), n_lon.max(3));
    let mut raw = sheet::empty();
    sheet::grid(&mut raw, [n_lon, n_lat], |i, j| {
        let (theta, phi) = (PI * j as f64 / n_lat as f64, 2.0 * PI * (i % n_lon) as f64 / n_lon as f64);
        let is_pole = j == 0 || j == n_lat;
        let out = if is_pole { 0.0 } else { sin(theta) };
        let up = if is_pole { if j == 0 { -1.0 } else { 1.0 } } else { -cos(theta) };
        let d = DVec3::new(out * sin(phi), up, out * cos(phi));
        let (r, slope) = radius(d);
        // At a pole each triangle has a corner of its own, in its middle; `sheet` keeps one of the two beside it.
        let u = i as f64
            + if j == 0 {
                0.5
            } else if j == n_lat {
                -0.5
            } else {
                0.0
            };
        Point {
            position: d * r,
            normal: d * r - (slope - d * d.dot(slope)),
            uv: DVec2::new(u / n_lon as f64, 1.0 - j as f64 / n_lat as f64),
        }
    });
    sheet::finish(raw)
}

/// The unit sphere as an icosahedron with each edge cut in `n`: 20 n^2 triangles of nearly one size. The texture is the
/// icosahedron's net, five strips of four triangles, without overlap.
pub fn icosphere(n: u32) -> Mesh {
    let n = n.max(1);
    let corners = icosahedron();
    let mut raw = sheet::empty();
    let mut known: BTreeMap<[u32; 5], u32> = BTreeMap::new();
    for strip in 0..5 {
        for (face, net) in strip_of(strip) {
            // Points of equal place and texture place are one vertex; edge points come out equal from both sides because
            // corners are added in the order of their numbers.
            let mut at = |a: u32, b: u32| {
                let weights = [n - a - b, a, b];
                let mut order = [0, 1, 2];
                order.sort_by_key(|&k| face[k]);
                let sum = order.iter().fold(DVec3::ZERO, |s, &k| s + corners[face[k]] * weights[k] as f64);
                let uv = (0..3).fold(DVec2::ZERO, |s, k| s + net[k] * weights[k] as f64) / n as f64;
                let position = sum.normalize();
                let (p, t) = (position.as_vec3(), uv.as_vec2());
                let key = [p.x, p.y, p.z, t.x, t.y].map(f32::to_bits);
                *known.entry(key).or_insert_with(|| sheet::push(&mut raw, Point { position, normal: position, uv }))
            };
            let mut triangles = Vec::new();
            for a in 0..n {
                for b in 0..n - a {
                    triangles.push([at(a, b), at(a + 1, b), at(a, b + 1)]);
                    if a + b + 1 < n {
                        triangles.push([at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)]);
                    }
                }
            }
            raw.triangles.extend(triangles);
        }
    }
    sheet::finish(raw)
}

/// North pole, upper ring, lower ring, south pole.
fn icosahedron() -> Vec<DVec3> {
    let (high, wide) = (1.0 / 5f64.sqrt(), 2.0 / 5f64.sqrt());
    let ring = |k: u32, shift: f64, y: f64| {
        let turn = 2.0 * PI * (k as f64 + shift) / 5.0;
        DVec3::new(wide * sin(turn), y, wide * cos(turn))
    };
    let upper = (0..5).map(|k| ring(k, 0.0, high));
    let lower = (0..5).map(|k| ring(k, 0.5, -high));
    std::iter::once(DVec3::Y).chain(upper).chain(lower).chain(std::iter::once(-DVec3::Y)).collect()
}

/// The four triangles of a strip from pole to pole: corners counter-clockwise, and where they lie in the net.
fn strip_of(k: usize) -> [([usize; 3], [DVec2; 3]); 4] {
    let next = (k + 1) % 5;
    let (north, u0, u1, l0, l1, south) = (0, 1 + k, 1 + next, 6 + k, 6 + next, 11);
    // Edges of one length: five and a half of them across, rows as high as an equilateral triangle, a margin around.
    let side = 0.98 / 5.5;
    let row = side * 0.75f64.sqrt();
    let at = |x: f64, y: f64| DVec2::new(0.01 + side * (x + k as f64), 0.01 + row * y);
    [
        ([north, u0, u1], [at(0.5, 0.0), at(0.0, 1.0), at(1.0, 1.0)]),
        ([u0, l0, u1], [at(0.0, 1.0), at(0.5, 2.0), at(1.0, 1.0)]),
        ([u1, l0, l1], [at(1.0, 1.0), at(0.5, 2.0), at(1.5, 2.0)]),
        ([l0, south, l1], [at(0.5, 2.0), at(1.0, 3.0), at(1.5, 2.0)]),
    ]
}

/// A (p, q) torus knot: p times around the axis, q times through the hole, p and q without a common divisor. One closed
/// tube of radius `tube` on a torus of radii 1 and 0.45, without a jump in twist; u runs once along it, v once around.
pub fn torus_knot(p: u32, q: u32, tube: f64, [n_along, n_around]: [u32; 2]) -> Mesh {
    let (n, m) = (n_along.max(8), n_around.max(3));
    const MINOR: f64 = 0.45;
    let (p, q) = (p as f64, q as f64);
    let spine = |t: f64| {
        let r = 1.0 + MINOR * cos(q * t);
        DVec3::new(r * cos(p * t), r * sin(p * t), MINOR * sin(q * t))
    };
    let mut raw = sheet::empty();
    // One ring after the other: its centre, and two axes from the torus's own normal, which comes back to itself.
    let ring = |i: u32| {
        let t = 2.0 * PI * (i % n) as f64 / n as f64;
        let r = 1.0 + MINOR * cos(q * t);
        let along = DVec3::new(
            -MINOR * q * sin(q * t) * cos(p * t) - r * p * sin(p * t),
            -MINOR * q * sin(q * t) * sin(p * t) + r * p * cos(p * t),
            MINOR * q * cos(q * t),
        )
        .normalize();
        let out = DVec3::new(cos(q * t) * cos(p * t), cos(q * t) * sin(p * t), sin(q * t));
        (spine(t), out, along.cross(out))
    };
    let rings: Vec<_> = (0..=n).map(ring).collect();
    sheet::grid(&mut raw, [m, n], |i, j| {
        let (center, out, side) = rings[j as usize];
        let turn = 2.0 * PI * (i % m) as f64 / m as f64;
        let normal = out * cos(turn) + side * sin(turn);
        let uv = DVec2::new(j as f64 / n as f64, i as f64 / m as f64);
        Point { position: center + normal * tube, normal, uv }
    });
    sheet::finish(raw)
}

/// Length of a torus knot's spine over its tube's circumference: how often a square texture fits along, at one around.
pub fn torus_knot_repeats(p: u32, q: u32, tube: f64) -> f64 {
    let (p, q) = (p as f64, q as f64);
    const N: u32 = 2000;
    let at = |i: u32| {
        let t = 2.0 * PI * i as f64 / N as f64;
        let r = 1.0 + 0.45 * cos(q * t);
        DVec3::new(r * cos(p * t), r * sin(p * t), 0.45 * sin(q * t))
    };
    (0..N).map(|i| at(i).distance(at(i + 1))).sum::<f64>() / (2.0 * PI * tube)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::solid::measure;

    #[test]
    fn bodies_are_closed_of_the_right_genus_and_volume() {
        let pi = PI;
        let cases = [
            ("cube", cube(4), 2, 8.0, 1e-6),
            ("cylinder", cylinder(200, 3), 2, 2.0 * pi, 1e-3),
            ("cone", cone(200, 5), 2, 2.0 / 3.0 * pi, 1e-3),
            ("sphere", sphere(100, 200), 2, 4.0 / 3.0 * pi, 1e-3),
            ("coarsest sphere", sphere(2, 3), 2, 3f64.sqrt() / 2.0, 1e-6),
            ("displaced sphere", displaced_sphere(100, 200), 2, 4.0 / 3.0 * pi, 0.05),
            ("icosahedron", icosphere(1), 2, 2.536_150_7, 1e-6),
            ("icosphere", icosphere(20), 2, 4.0 / 3.0 * pi, 4e-3),
            ("knot", torus_knot(2, 3, 0.18, [600, 48]), 0, torus_knot_volume(2, 3, 0.18), 4e-3),
            ("other knot", torus_knot(3, 7, 0.08, [2000, 24]), 0, torus_knot_volume(3, 7, 0.08), 0.02),
        ];
        for (name, mesh, euler, volume, tolerance) in cases {
            let solid = measure(&mesh);
            assert!(solid.is_closed && solid.euler == euler, "{name}: {solid:?}");
            assert!((solid.volume / volume - 1.0).abs() < tolerance, "{name}: {solid:?}, not {volume}");
            assert!(solid.share_of_right_normals > 0.999, "{name}: {solid:?}");
        }
    }

    /// Pappus: the section's area times the length of its centre's way.
    fn torus_knot_volume(p: u32, q: u32, tube: f64) -> f64 {
        PI * tube * tube * torus_knot_repeats(p, q, tube) * 2.0 * PI * tube
    }

    #[test]
    fn texture_places_are_not_mirrored_and_stay_in_the_square() {
        for (name, mesh) in [
            ("plane", plane(3)),
            ("quad", quad()),
            ("cube", cube(2)),
            ("cylinder", cylinder(24, 2)),
            ("cone", cone(24, 2)),
            ("sphere", sphere(12, 24)),
            ("icosphere", icosphere(4)),
            ("knot", torus_knot(2, 3, 0.18, [200, 16])),
        ] {
            let uv = &mesh.uv_sets()[0].uv;
            for t in mesh.triangles() {
                let [a, b, c] = t.map(|i| uv[i as usize]);
                // v runs down, so a triangle that is not mirrored runs clockwise in (u, v).
                assert!((b - a).perp_dot(c - a) < 0.0, "{name}: {a} {b} {c}");
                assert!([a, b, c].iter().all(|p| p.min_element() >= 0.0 && p.max_element() <= 1.0), "{name}");
            }
        }
    }
}
