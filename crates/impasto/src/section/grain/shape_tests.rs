//! Each shape against slow, obvious versions of its own formulas.

use super::block::{Block, Facets};
use super::ellipsoid::{Ball, Ellipsoid};
use super::openness::form_factor;
use super::rod::{Capsule, Rod};
use super::shape::{Body, Convex};
use super::spec::Polyhedron;
use super::superquadric::Superquadric;
use crate::math::{DVec3, Frame, Mat3, Vec3, exact, hash_cell, unit_float, vec3};

pub(super) fn random(i: i32, k: i32) -> f32 {
    unit_float(hash_cell(i, k, 3, 5)) * 2.0 - 1.0
}

pub(super) fn direction(i: i32, k: i32) -> Vec3 {
    vec3(random(i, k), random(i, k + 1), random(i, k + 2) + 1e-3).normalize()
}

fn frame() -> Mat3 {
    let f = Frame::about(vec3(0.36, -0.48, 0.8));
    Mat3::from_cols(f.tangent, f.bitangent, f.normal)
}

/// One of each, with a name.
fn bodies(dodecahedron: &Polyhedron) -> Vec<(&'static str, Body<'_>)> {
    let (frame, axis) = (frame(), frame().z_axis);
    let rod = |rounding| Body::Rod(Rod { axis, radius: 0.4, half: 0.5, rounding, domed: false });
    let half = vec3(0.3, 0.4, 0.5);
    let facets = Facets {
        frame,
        scale: 1.2,
        faces: &dodecahedron.faces,
        corners: &dodecahedron.corners,
        reach: dodecahedron.corners.iter().map(|c| c.length()).fold(0.0, f32::max),
    };
    let superquadric = |power| Body::Superquadric(Superquadric { frame, semi: half, power });
    vec![
        ("ball", Body::Ball(Ball { radius: 0.5 })),
        ("ellipsoid", Body::Ellipsoid(Ellipsoid { frame, semi: vec3(0.2, 0.3, 0.6) })),
        ("rod", rod(0.0)),
        ("rounded rod", rod(0.08)),
        ("capsule", Body::Capsule(Capsule { axis, radius: 0.3, half: 0.35 })),
        ("box", Body::Block(Block { frame, half, rounding: 0.0 })),
        ("rounded box", Body::Block(Block { frame, half, rounding: 0.1 })),
        ("dodecahedron", Body::Facets(facets)),
        ("superquadric 1.5", superquadric(1.5)),
        ("superquadric 4", superquadric(4.0)),
    ]
}

#[test]
fn balls_agree_with_equations_5_to_7() {
    let ball = Ball { radius: 0.7 };
    for i in 0..10_000 {
        let (m, t) = (direction(i, 0) * (0.7 * random(i, 9).abs()), direction(i, 4));
        let (p, d) = (m.as_dvec3(), t.as_dvec3());
        let (a, b, c) = (d.dot(d), 2.0 * d.dot(p), p.dot(p) - 0.7f32 as f64 * 0.7f32 as f64);
        let u = (-b + (b * b - 4.0 * a * c).max(0.0).sqrt()) / (2.0 * a);
        let exit = ball.exit(m, t);
        assert!((exit.distance as f64 - u).abs() < 1e-6 + 3e-4 * (1.0 - p.length() / 0.7).abs().min(1e-3));
        let normal: DVec3 = (p + d * u) / 0.7f32 as f64;
        assert!((exit.normal.as_dvec3() - normal).length() < 2e-3, "{} {normal}", exit.normal);
    }
}

#[test]
fn exits_agree_with_bisection() {
    let polyhedron = Polyhedron::regular(12, 0.35).unwrap();
    for (name, body) in bodies(&polyhedron) {
        let mut n = 0;
        for i in 0..4_000 {
            let m = vec3(random(i, 0), random(i, 1), random(i, 2)) * body.reach();
            if !body.holds(m) {
                continue;
            }
            n += 1;
            let t = direction(i, 4);
            let exit = body.exit(m, t);
            let (mut inside, mut outside) = (0.0f32, 2.5 * body.reach());
            for _ in 0..40 {
                let middle = 0.5 * (inside + outside);
                if body.holds(m + t * middle) { inside = middle } else { outside = middle }
            }
            assert!((exit.distance - inside).abs() < 2e-4, "{name}: {} not {inside}", exit.distance);
            assert!((exit.normal.length() - 1.0).abs() < 1e-4 && exit.normal.dot(t) >= -1e-3, "{name}");
        }
        assert!(n > 300, "{name}: {n} points inside");
    }
}

#[test]
fn support_points_are_of_the_body_and_none_is_farther() {
    let polyhedron = Polyhedron::regular(12, 0.35).unwrap();
    for (name, body) in bodies(&polyhedron) {
        for i in 0..400 {
            let n = direction(i, 0);
            let tip = body.support(n);
            assert!(tip.length() <= body.reach() * 1.000_01, "{name}");
            assert!(body.holds(tip * 0.9999) && !body.holds(tip + n * 2e-3), "{name}");
            for k in 0..20 {
                let m = vec3(random(i, k), random(k, i), random(i + k, 3)) * body.reach();
                assert!(!body.holds(m) || m.dot(n) <= tip.dot(n) + 1e-5, "{name}");
            }
        }
    }
}

#[test]
fn gaps_are_distances_to_the_outline() {
    let polyhedron = Polyhedron::regular(12, 0.35).unwrap();
    const T: f32 = 0.07;
    for (name, body) in bodies(&polyhedron) {
        let (mut n, mut worst, mut sum) = (0, 0f32, 0.0);
        for i in 0..60 {
            let normal = direction(i, 0);
            let offset = 0.6 * random(i, 3) * body.support(normal).dot(normal);
            let middle = body.section_point(offset, normal);
            assert!((middle.dot(normal) - offset).abs() < 1e-5 && body.meets(middle, normal), "{name}");
            let f = Frame::about(normal);
            let at = |a: f32| f.tangent * exact::cos(a as f64) as f32 + f.bitangent * exact::sin(a as f64) as f32;
            let outline: Vec<Vec3> = (0..720)
                .map(|k| at(k as f32 * (std::f32::consts::TAU / 720.0)))
                .map(|t| middle + t * body.exit(middle, t).distance)
                .collect();
            for k in 0..40 {
                // Just outside the outline.
                let corner = outline[(k * 17) % 720];
                let m = corner + (corner - middle).normalize_or_zero() * (T * (0.1 + 0.4 * random(i, k as i32).abs()));
                let truth = distance(&outline, m);
                let gap = body.gap(m, normal);
                assert!((gap.away.length() - 1.0).abs() < 1e-4 && gap.away.dot(normal).abs() < 1e-4, "{name}");
                // Mitred corners are nearer to the faces' lines than to the corner.
                let error = (gap.distance - truth).abs() / T;
                (n, worst, sum) = (n + 1, worst.max(error), sum + error);
            }
        }
        let mean = sum / n as f32;
        let is_mitred = matches!(name, "box" | "dodecahedron" | "rod");
        assert!(
            if is_mitred { mean < 0.05 } else { worst < 0.12 && mean < 0.01 },
            "{name}: worst {worst}, mean {mean} of t"
        );
    }
}

/// From a point to a polygon's border.
fn distance(polygon: &[Vec3], p: Vec3) -> f32 {
    let mut least = f32::INFINITY;
    for k in 0..polygon.len() {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        let t = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-20)).clamp(0.0, 1.0);
        least = least.min(p.distance(a + (b - a) * t));
    }
    least
}

#[test]
fn openness_agrees_with_shooting_rays_at_the_sky() {
    let polyhedron = Polyhedron::regular(12, 0.35).unwrap();
    for (name, body) in bodies(&polyhedron) {
        for i in 0..12 {
            let n = direction(i, 0);
            let offset = 0.5 * random(i, 3) * body.support(n).dot(n);
            let m = body.section_point(offset, n) + body.section_point(offset, n).cross(n) * 0.2;
            if !body.holds(m) {
                continue;
            }
            let exit = body.exit(m, -n);
            let q = m - n * exit.distance;
            let inward = Frame::about(-exit.normal);
            let (mut seen, n_rays) = (0, 20_000);
            for k in 0..n_rays {
                // Cosine weighted; whoever crosses the section's plane within the body sees the sky.
                let (a, b) = ((k as f32 + 0.5) / n_rays as f32, (k as f32 * 0.618_034).fract());
                let (s, c) = crate::math::sin_cos(b * std::f32::consts::TAU);
                let flat = a.sqrt();
                let t = inward.tangent * (flat * c) + inward.bitangent * (flat * s) + inward.normal * (1.0 - a).sqrt();
                if t.dot(n) > 1e-5 {
                    let way = (offset - q.dot(n)) / t.dot(n);
                    seen += body.holds((q + t * way) * 0.9999) as u32;
                }
            }
            let truth = seen as f32 / n_rays as f32;
            let got = body.cavity_openness(m, n, &exit);
            assert!((got - truth).abs() < 0.03, "{name}: {got} not {truth}");
        }
    }
}

#[test]
fn form_factors_of_a_square_are_right() {
    // From the middle of one unit square's side: a square of half side 1 at distance 1 (Siegel and Howell, "Thermal
    // Radiation Heat Transfer": four times the corner's).
    let square = [vec3(1.0, 1.0, 1.0), vec3(-1.0, 1.0, 1.0), vec3(-1.0, -1.0, 1.0), vec3(1.0, -1.0, 1.0)];
    let root = 2f64.sqrt();
    let quarter = (2.0 / root * exact::atan(1.0 / root)) / std::f64::consts::TAU;
    assert!((form_factor(&square, Vec3::ZERO, Vec3::Z) as f64 - 4.0 * quarter).abs() < 1e-5);
}

#[test]
fn regular_polyhedra_have_their_corners_and_open_ones_are_refused() {
    for (n_faces, n_corners) in [(4, 4), (6, 8), (8, 6), (12, 20), (20, 12)] {
        let p = Polyhedron::regular(n_faces, 1.0).unwrap();
        assert_eq!(p.faces.len() as u32, n_faces);
        let mut corners = p.corners.to_vec();
        corners.dedup_by(|a, b| a.distance(*b) < 1e-4);
        corners.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap());
        let mut distinct: Vec<Vec3> = Vec::new();
        for c in corners {
            if distinct.iter().all(|d| d.distance(c) > 1e-4) {
                distinct.push(c);
            }
        }
        assert_eq!(distinct.len(), n_corners, "{n_faces} faces");
    }
    assert!(Polyhedron::regular(7, 1.0).is_err());
    assert!(Polyhedron::new(&[(Vec3::X, 1.0), (Vec3::Y, 1.0), (Vec3::Z, 1.0)]).is_err());
    assert!(Polyhedron::new(&[(Vec3::X, f32::NAN); 5]).is_err());
}
