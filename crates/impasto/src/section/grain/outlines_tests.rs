//! Outlines against what the grain itself says is inside.

use super::curve::is_inside;
use super::shape_tests::{direction, random};
use super::*;
use crate::math::{DVec2, Vec2, vec2, vec3};
use crate::section::Plane;

pub(super) fn fillings() -> Vec<(&'static str, Filling)> {
    let grain = |spec| Filling::Particles(Box::new(Grain::new(spec).unwrap()));
    let of = |shape| grain(GrainSpec::of(shape, 0.6));
    let rod = |ends, axis| {
        grain(GrainSpec { axis, ..GrainSpec::of(Shape::Cylinder { radius: 0.25, height: 0.5, ends }, 0.6) })
    };
    let polyhedron = |n| Shape::Polyhedron(Polyhedron::regular(n, 0.2).unwrap());
    let superquadric = |power| of(Shape::Superquadric { radii: vec3(0.25, 0.25, 0.35), power });
    let cells = |spec| Filling::Cells(Box::new(Cells::new(spec).unwrap()));
    let stretched = CellsSpec { stretch: vec3(1.0, 2.0, 0.7), weight_spread: 0.3, ..CellsSpec::of(0.7, 0.05) };
    let fibres = |rounding, axis| {
        let spec = FibresSpec { rounding, length: 2.0, ..FibresSpec::of(0.5, 0.22, axis) };
        Filling::Fibres(Box::new(Fibres::new(spec).unwrap()))
    };
    let ball = |spacing: f32, radius| Size::Grain(Box::new(Grain::new(GrainSpec::spheres(spacing, radius)).unwrap()));
    let layer = |until, filling| Layer { until, filling, strict: true };
    vec![
        ("spheres", grain(GrainSpec::spheres(0.6, 0.3))),
        ("rods", rod(Ends::Flat, Axis::Isotropic)),
        ("soft rods", rod(Ends::Soft, Axis::Isotropic)),
        ("round rods", rod(Ends::Rounded(1.0), Axis::Isotropic)),
        ("ellipsoids", of(Shape::Ellipsoid { radii: vec3(0.15, 0.2, 0.5) })),
        ("capsules", of(Shape::Capsule { radius: 0.15, height: 0.8 })),
        ("boxes", of(Shape::Box { edges: vec3(0.3, 0.4, 0.6), rounding: 0.0 })),
        ("soft boxes", of(Shape::Box { edges: vec3(0.3, 0.4, 0.6), rounding: 0.05 })),
        ("dodecahedra", of(polyhedron(12))),
        ("tetrahedra", of(polyhedron(4))),
        ("superquadrics 1.5", superquadric(1.5)),
        ("superquadrics 8", superquadric(8.0)),
        ("voronoi", cells(CellsSpec::of(0.7, 0.0))),
        ("walls", cells(CellsSpec::of(0.7, 0.1))),
        ("laguerre", cells(stretched)),
        ("fibres", fibres(0.3, vec3(0.2, 1.0, 0.1))),
        ("sharp fibres", fibres(0.0, vec3(0.2, 0.1, 1.0))),
        (
            "two scales",
            Filling::Scales(Box::new(Scales::new(vec![ball(1.2, 0.5), ball(0.25, 0.1)], Mixing::Apart(0.02)).unwrap())),
        ),
        (
            "layers",
            Filling::Layers(vec![
                layer(0.5, rod(Ends::Flat, Axis::Isotropic)),
                layer(9.0, grain(GrainSpec::spheres(0.6, 0.3))),
            ]),
        ),
    ]
}

/// Planes at random, and along and across the axes that fibres and upright rods have.
fn planes() -> Vec<Plane> {
    let through = |normal| Plane::through(vec3(0.3, 0.2, 0.7), normal).unwrap();
    let mut planes: Vec<Plane> = (0..3).map(|i| through(direction(i, 70))).collect();
    planes.extend([Vec3::X, Vec3::Y, Vec3::Z].map(through));
    planes
}

fn depth(p: DVec3) -> f32 {
    p.length() as f32 * 0.3
}

/// Points where an outline and the hollow section do not agree, beyond a little of the border.
#[track_caller]
fn check(name: &str, filling: &Filling, plane: &Plane) -> usize {
    let window = Window::around(plane, DVec3::new(0.4, 0.1, -0.2), vec2(2.0, 1.5));
    let list = outlines(filling, plane, &window, &depth).unwrap();
    let polygons: Vec<Vec<DVec2>> = list.iter().map(|o| o.curve.polygon(1e-5)).collect();
    for (outline, polygon) in list.iter().zip(&polygons) {
        assert!(
            polygon.iter().all(|p| p.distance(outline.middle) <= outline.reach * 1.001 + 1e-4),
            "{name}: {outline:?}"
        );
        let area: f64 = (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum();
        assert!(area > 0.0, "{name}: clockwise or empty");
    }
    let look = Look { kind: SectionKind::Hollow, side: Side::Below };
    let mut on_particles = 0;
    for i in 0..200 {
        let at = vec2(random(i, 0) * 2.0, random(i, 1) * 1.5);
        let hit = filling.eval(window.point(at), plane, look, &depth);
        let holders = |p: DVec2| -> Vec<u32> {
            let is_near = |o: &Outline| p.distance(o.middle) <= o.reach + 1e-3;
            let near = list.iter().zip(&polygons).filter(|(o, polygon)| is_near(o) && is_inside(polygon, p));
            near.map(|(o, _)| o.particle).collect()
        };
        let expected = if hit.kind == HitKind::Cavity { vec![hit.particle] } else { Vec::new() };
        on_particles += expected.len();
        // A thousandth of a particle beside, both answers may be right.
        let p = at.as_dvec2();
        let beside = [DVec2::ZERO, DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|d| p + d * 3e-4);
        let found = beside.map(holders);
        assert!(found.contains(&expected), "{name} at {at}: {expected:?}, outlines {:?}", found[0]);
    }
    on_particles
}

#[test]
fn outlines_hold_the_points_that_sections_show_as_particles() {
    for (name, filling) in fillings() {
        let n: usize = planes().iter().map(|plane| check(name, &filling, plane)).sum();
        assert!(n > 15, "{name}: {n} points on particles");
    }
}

#[test]
fn upright_rods_have_circles_rectangles_and_cut_ellipses() {
    let spec = GrainSpec {
        axis: Axis::Along(Vec3::Z),
        ..GrainSpec::of(Shape::Cylinder { radius: 0.25, height: 0.5, ends: Ends::Flat }, 0.6)
    };
    let filling = Filling::Particles(Box::new(Grain::new(spec).unwrap()));
    let curves = |normal: Vec3| {
        let plane = Plane::through(vec3(0.3, 0.2, 0.7), normal).unwrap();
        assert!(check("upright rods", &filling, &plane) > 15);
        outlines(&filling, &plane, &Window::around(&plane, DVec3::ZERO, Vec2::splat(5.0)), &depth).unwrap()
    };
    let across = curves(Vec3::Z);
    assert!(across.len() > 50 && across.iter().all(|o| matches!(o.curve, curve::Curve::Circle { .. })));
    assert!(curves(Vec3::Y).iter().all(|o| o.curve.polygon(1.0).len() == 4 && o.class == "rod"));
    let oblique = curves(vec3(1.0, 1.0, 1.0));
    // Two arcs, and one straight end or two: drums.
    let is_drum = |o: &&Outline| match &o.curve {
        curve::Curve::Path { parts, .. } => parts.iter().filter(|p| matches!(p, curve::Part::Arc { .. })).count() == 2,
        _ => false,
    };
    assert!(oblique.iter().filter(is_drum).count() > 30);
}

#[test]
fn the_papers_overlapping_particles_have_outlines_too() {
    for spec in [GrainSpec::spheres(0.6, 0.3), GrainSpec::cylinders(1.0, 0.5, 0.8, Vec3::Z)] {
        let grain = Grain::new(spec.to_the_letter()).unwrap();
        let filling = Filling::Particles(Box::new(grain.clone()));
        for plane in planes() {
            let window = Window::around(&plane, DVec3::ZERO, vec2(2.0, 1.5));
            let list = outlines(&filling, &plane, &window, &depth).unwrap();
            for i in 0..150 {
                let at = vec2(random(i, 0) * 2.0, random(i, 1) * 1.5);
                let hit = grain.eval(window.point(at), &plane, Look { kind: SectionKind::Solid, side: Side::Below });
                let holders = list.iter().filter(|o| is_inside(&o.curve.polygon(1e-5), at.as_dvec2()));
                if hit.kind == HitKind::Disc {
                    assert!(holders.clone().any(|o| o.particle == hit.particle), "at {at}: {hit:?}");
                } else {
                    assert_eq!(holders.count(), 0, "at {at}");
                }
            }
        }
    }
}
