//! Truths about grain: what Li's paper claims, and what we claim beyond it.

use super::shape::Convex;
use super::shape_tests::{direction, random};
use super::*;
use crate::math::{dvec3, vec3};
use crate::section::Plane;

/// One of each shape at a spacing of 0.6, jittered and turned at random.
fn shapes() -> Vec<(&'static str, GrainSpec)> {
    let of = |shape| GrainSpec::of(shape, 0.6);
    let rod = |ends| of(Shape::Cylinder { radius: 0.25, height: 0.5, ends });
    vec![
        ("spheres", GrainSpec::spheres(0.6, 0.3)),
        ("rods", rod(Ends::Flat)),
        ("soft rods", rod(Ends::Soft)),
        ("ellipsoids", of(Shape::Ellipsoid { radii: vec3(0.15, 0.2, 0.5) })),
        ("capsules", of(Shape::Capsule { radius: 0.15, height: 0.8 })),
        ("boxes", of(Shape::Box { edges: vec3(0.3, 0.4, 0.6), rounding: 0.0 })),
        ("soft boxes", of(Shape::Box { edges: vec3(0.3, 0.4, 0.6), rounding: 0.05 })),
        ("dodecahedra", of(Shape::Polyhedron(Polyhedron::regular(12, 0.25).unwrap()))),
        ("superquadrics", of(Shape::Superquadric { radii: vec3(0.25, 0.25, 0.35), power: 4.0 })),
        ("overlapping", GrainSpec { contact: Contact::Overlapping, jitter: 0.45, ..GrainSpec::spheres(0.6, 0.3) }),
    ]
}

/// A point of a plane, and the plane.
fn on_plane(i: i32) -> (DVec3, Plane) {
    let plane = Plane::through(vec3(random(i / 997, 20), random(i / 997, 21), 0.3), direction(i / 997, 22)).unwrap();
    let [u, v] = plane.axes();
    let p = plane.normal * plane.offset + u * (random(i, 0) as f64 * 20.0) + v * (random(i, 1) as f64 * 20.0);
    (p, plane)
}

fn look(kind: SectionKind, side: Side) -> Look {
    Look { kind, side }
}

const KINDS: [SectionKind; 3] = [SectionKind::Tear, SectionKind::Hollow, SectionKind::Solid];

/// The two sides of a tear at a point are exact negatives.
#[track_caller]
fn check_complement(grain: &Grain, p: DVec3, plane: &Plane) -> bool {
    let a = grain.eval(p, plane, look(SectionKind::Tear, Side::Below));
    let b = grain.eval(p, plane, look(SectionKind::Tear, Side::Above));
    assert_eq!((a.height, a.normal, a.particle), (-b.height, -b.normal, b.particle), "at {p}");
    let kinds = (a.kind, b.kind);
    assert!(matches!(
        kinds,
        (HitKind::Matrix, HitKind::Matrix) | (HitKind::Bump, HitKind::Cavity) | (HitKind::Cavity, HitKind::Bump)
    ));
    a.kind != HitKind::Matrix
}

#[test]
fn torn_sides_are_exact_negatives_at_a_million_points() {
    let grain = Grain::new(GrainSpec::spheres(0.6, 0.3)).unwrap();
    let n_parts = 100;
    let hits = crate::par::Workers::new(0).map(n_parts, |part| {
        let points = (0..1_000_000 / n_parts).map(|i| on_plane((i * n_parts + part) as i32));
        points.filter(|(p, plane)| check_complement(&grain, *p, plane)).count()
    });
    assert!(hits.iter().sum::<usize>() > 100_000, "{hits:?} points on particles");
}

#[test]
fn torn_sides_are_exact_negatives_for_all_shapes() {
    for (name, spec) in shapes() {
        let grain = Grain::new(spec).unwrap();
        let hits = (0..2_000).filter(|&i| {
            let (p, plane) = on_plane(i);
            check_complement(&grain, p, &plane)
        });
        assert!(hits.count() > 20, "{name}");
    }
}

#[test]
fn a_centre_on_the_cut_belongs_to_one_half_only() {
    // Without jitter the plane x = 0 runs through the centres of a whole layer.
    let upright = GrainSpec { jitter: 0.0, lattice: LatticeAxes::Model, ..GrainSpec::spheres(1.0, 0.4) };
    let grain = Grain::new(upright).unwrap();
    for normal in [Vec3::X, Vec3::NEG_X] {
        let plane = Plane::through(Vec3::ZERO, normal).unwrap();
        let mut bumps = 0;
        for i in 0..2_000 {
            let p = dvec3(0.0, random(i, 0) as f64 * 5.0, random(i, 1) as f64 * 5.0);
            check_complement(&grain, p, &plane);
            let hit = grain.eval(p, &plane, look(SectionKind::Tear, Side::Below));
            assert_ne!(hit.kind, HitKind::Cavity);
            bumps += (hit.kind == HitKind::Bump) as u32;
        }
        assert!(bumps > 300);
    }
    // Off the ties, a plane turned over gives the same bits.
    let grain = Grain::new(GrainSpec::spheres(0.6, 0.3)).unwrap();
    for i in 0..5_000 {
        let (p, plane) = on_plane(i);
        for kind in KINDS {
            let turned = grain.eval(p, &plane.flipped(), look(kind, Side::Above));
            assert_eq!(grain.eval(p, &plane, look(kind, Side::Below)), turned);
        }
    }
}

#[test]
fn normals_are_those_of_the_height_field() {
    const STEP: f64 = 1e-4;
    for (name, spec) in shapes() {
        let grain = Grain::new(GrainSpec { size_spread: 0.1, ..spec }).unwrap();
        for kind in KINDS {
            let (mut n, mut good) = (0, 0);
            for i in 0..1_500 {
                let (p, plane) = on_plane(i);
                let at = |q| grain.eval(q, &plane, look(kind, Side::Below));
                let hit = at(p);
                let [u, v] = plane.axes();
                let near = [u, -u, v, -v].map(|d| at(p + d * STEP));
                // Away from rims and edges, where the field is smooth.
                if hit.particle == Hit::MATRIX || near.iter().any(|h| h.kind != hit.kind || h.particle != hit.particle)
                {
                    continue;
                }
                if hit.normal.as_dvec3().dot(plane.normal) < 0.3 || near.iter().any(|h| h.normal.dot(hit.normal) < 0.99)
                {
                    continue;
                }
                let slope = |a: Hit, b: Hit| (a.height - b.height) as f64 / (2.0 * STEP);
                let truth = plane.normal - u * slope(near[0], near[1]) - v * slope(near[2], near[3]);
                n += 1;
                good += (hit.normal.as_dvec3().dot(truth.normalize()) > 0.995) as i32;
            }
            assert!(n > 10 && good as f64 > 0.97 * n as f64, "{name} {kind:?}: {good} of {n}");
        }
    }
}

#[test]
fn bevels_slope_by_45_degrees_down_to_the_matrix() {
    for (name, spec) in shapes() {
        let grain = Grain::new(spec).unwrap();
        let t = grain.spec().bevel * grain.spec().spacing;
        let mut n = 0;
        for i in 0..3_000 {
            let (p, plane) = on_plane(i);
            let hit = grain.eval(p, &plane, look(SectionKind::Solid, Side::Below));
            let cos = hit.normal.as_dvec3().dot(plane.normal) as f32;
            match hit.kind {
                HitKind::Bevel => {
                    assert!((cos - 0.5f32.sqrt()).abs() < 1e-4 && hit.height < 0.0 && hit.height > -t, "{name}");
                    n += 1;
                }
                HitKind::Disc => assert!(cos > 0.9999 && hit.height == 0.0, "{name}"),
                _ => assert!(hit.kind == HitKind::Matrix && (hit.height + t).abs() < 1e-6, "{name}"),
            }
        }
        assert!(n > 30, "{name}: {n} on bevels");
    }
}

#[test]
fn more_rings_of_cells_change_nothing() {
    for (name, spec) in shapes() {
        let grain = Grain::new(spec).unwrap();
        let mut wide = grain.clone();
        wide.n_rings += 1;
        wide.n_rings_solid += 1;
        wide.n_rings_contact += (grain.n_rings_contact > 0) as i32;
        for i in 0..150 {
            let (p, plane) = on_plane(i * 31);
            for kind in KINDS {
                let look = look(kind, Side::Below);
                assert_eq!(grain.eval(p, &plane, look), wide.eval(p, &plane, look), "{name} at {p}");
            }
        }
    }
}

#[test]
fn particles_are_apart_by_their_supports_and_by_points() {
    for (name, spec) in shapes().into_iter().filter(|(_, s)| s.contact != Contact::Overlapping) {
        let grain = Grain::new(GrainSpec { jitter: 0.45, ..spec }).unwrap();
        let settled = |cell: [i32; 3]| {
            let free = grain.free_body(cell);
            free.scaled(grain.scale(cell, grain.offset(cell), &free))
        };
        for i in 0..40 {
            let cell = [i, i * 7 % 13, -i];
            let body = settled(cell);
            particle::for_cells(2, |step| {
                if step != [0; 3] {
                    let other = particle::add(cell, step);
                    let node = vec3(step[0] as f32, step[1] as f32, step[2] as f32);
                    let to = node + (grain.offset(other) - grain.offset(cell));
                    let n = to.normalize();
                    let sum = body.support(n).dot(n) - settled(other).support(-n).dot(n);
                    assert!(sum <= to.length(), "{name}: {sum} of {}", to.length());
                }
            });
        }
        for i in 0..3_000 {
            let place = grain.place(dvec3(random(i, 0) as f64, random(i, 1) as f64, random(i, 2) as f64) * 9.0);
            let mut holders = 0;
            grain.for_holders(place, |_, _, _| true, |_| holders += 1);
            assert!(holders <= 1, "{name}: {holders} particles at one point");
        }
    }
}

#[test]
fn statistics_of_balls_are_as_stereology_has_them() {
    let grain = Grain::new(GrainSpec { size_spread: 0.0, jitter: 0.2, ..GrainSpec::spheres(1.0, 0.3) }).unwrap();
    let n = 40_000;
    // Of points in space, and of points on sections; of the normals on particles.
    let (mut in_space, mut on_section, mut cosines, mut count) = (0, 0, 0.0, 0);
    for i in 0..n {
        let p = dvec3(random(i, 0) as f64, random(i, 1) as f64, random(i, 2) as f64) * 30.0;
        let mut holders = 0;
        grain.for_holders(grain.place(p), |_, _, _| true, |_| holders += 1);
        in_space += holders;
        let (p, plane) = on_plane(i);
        let hit = grain.eval(p, &plane, look(SectionKind::Tear, Side::Below));
        if hit.kind != HitKind::Matrix {
            on_section += 1;
            cosines += hit.normal.as_dvec3().dot(plane.normal);
            count += 1;
        }
    }
    let (volume, area) = (in_space as f64 / n as f64, on_section as f64 / n as f64);
    assert!((volume - area).abs() < 0.01, "Delesse: {volume} of the volume, {area} of the area");
    assert!((cosines / count as f64 - 0.75).abs() < 0.01, "mean cosine {}", cosines / count as f64);
}

#[test]
fn the_same_point_in_the_neighbours_coordinates_has_the_same_owner() {
    for (name, spec) in shapes() {
        let grain = Grain::new(spec).unwrap();
        let wide = {
            let mut wide = grain.clone();
            wide.n_rings += 1;
            wide
        };
        for i in 0..300 {
            let (p, _) = on_plane(i);
            let place = grain.place(p);
            let step = [1, 0, -1];
            let moved = Place { cell: particle::add(place.cell, step), local: place.local - vec3(1.0, 0.0, -1.0) };
            let owner = |grain: &Grain, place| {
                let mut owner = None;
                grain.for_holders(place, |_, _, _| true, |h| owner = Some(h.id(grain)));
                owner
            };
            let (a, b) = (owner(&grain, place), owner(&wide, moved));
            // A point within rounding of a rim may be on either side of it.
            let near = [-1e-5f32, 1e-5].iter().any(|d| owner(&wide, moved.moved(Vec3::splat(*d))) == a);
            assert!(a == b || near, "{name}: {a:?} and {b:?}");
        }
    }
}

#[test]
fn to_the_letter_cylinders_look_away_and_spheres_do_not() {
    let facing = |spec: GrainSpec, kind| {
        let grain = Grain::new(spec).unwrap();
        let (mut n, mut away) = (0, 0);
        for i in 0..4_000 {
            let (p, plane) = on_plane(i);
            let hit = grain.eval(p, &plane, look(kind, Side::Below));
            if hit.kind != HitKind::Matrix {
                n += 1;
                away += (hit.normal.as_dvec3().dot(plane.normal) < 0.0) as i32;
            }
        }
        away as f64 / n as f64
    };
    let rods = GrainSpec::cylinders(1.0, 0.5, 0.8, Vec3::Z);
    assert!(facing(rods.clone().to_the_letter(), SectionKind::Tear) > 0.9);
    assert!(facing(rods.clone().to_the_letter(), SectionKind::Hollow) > 0.9);
    assert_eq!(facing(rods, SectionKind::Tear), 0.0);
    let letter = GrainSpec::spheres(0.6, 0.3).to_the_letter();
    assert_eq!(facing(letter.clone(), SectionKind::Tear), 0.0);
    assert_eq!(facing(letter, SectionKind::Hollow), 0.0);
}

#[test]
fn to_the_letter_sections_of_cylinders_have_the_captions_outlines() {
    // Fig. 9-11: along the axis circles, across it rectangles; there the paper's bevel lies along two sides only.
    let grain = Grain::new(GrainSpec::cylinders(1.0, 0.5, 0.8, Vec3::Z).to_the_letter()).unwrap();
    let bevels = |normal: Vec3| {
        let plane = Plane::through(vec3(0.1, 0.2, 0.15), normal).unwrap();
        let [u, v] = plane.axes();
        let mut axial: f64 = 0.0;
        for i in 0..20_000 {
            let p = plane.normal * plane.offset + u * (random(i, 0) as f64 * 20.0) + v * (random(i, 1) as f64 * 20.0);
            let hit = grain.eval(p, &plane, look(SectionKind::Solid, Side::Below));
            if hit.kind == HitKind::Bevel {
                axial = axial.max((hit.normal.z as f64 - plane.normal.z * 0.5f64.sqrt()).abs());
            }
        }
        axial
    };
    assert!(bevels(Vec3::Z) < 1e-3, "around circles");
    assert!(bevels(Vec3::Y) < 1e-3, "no bevel faces along the axis");
}

#[test]
fn all_looks_are_sane_on_extreme_grains() {
    let mut specs = shapes();
    let axis = Axis::Cone(Vec3::Y, 0.3);
    specs.push(("tiny", GrainSpec::spheres(1e-6, 5e-7)));
    specs.push(("huge", GrainSpec::spheres(1e9, 5e8)));
    specs.push((
        "crowded",
        GrainSpec { jitter: 0.5, contact: Contact::Apart { grow: 4.0 }, ..GrainSpec::spheres(1.0, 0.5) },
    ));
    specs.push(("long", GrainSpec { axis, ..GrainSpec::of(Shape::Capsule { radius: 0.1, height: 3.0 }, 1.0) }));
    specs.push(("radial", GrainSpec { axis: Axis::Radial(Vec3::ZERO), ..shapes()[3].1.clone() }));
    specs.push(("noise", GrainSpec { chance: Chance::Noise { frequency: 0.1 }, ..GrainSpec::spheres(1.0, 0.5) }));
    for (name, spec) in specs {
        let grain = Grain::new(spec).unwrap();
        for i in 0..20 {
            let (p, plane) = on_plane(i * 3001);
            for kind in KINDS {
                for side in [Side::Below, Side::Above] {
                    for p in [p, p * 1e5, p * 1e-5] {
                        let plane = Plane { offset: plane.normal.dot(p), ..plane };
                        let hit = grain.eval(p, &plane, look(kind, side));
                        assert!((hit.normal.length() - 1.0).abs() < 1e-3, "{name} {kind:?}: {hit:?}");
                        // Overlapping particles make chains.
                        let links = if grain.spec().contact == Contact::Overlapping { 9.0 } else { 1.0 };
                        assert!(hit.height.abs() <= links * 2.0 * grain.reach(), "{name}: {hit:?}");
                        assert!((0.0..=1.0).contains(&hit.openness), "{name}: {hit:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn bad_numbers_give_one_clear_line() {
    let line = |spec: GrainSpec| Grain::new(spec).unwrap_err().to_string();
    let good = GrainSpec::spheres(1.0, 0.3);
    let not = "is not possible: it is a length above zero";
    assert_eq!(line(GrainSpec { spacing: -1.0, ..good.clone() }), format!("spacing \"-1\" {not}"));
    assert_eq!(line(GrainSpec::spheres(1.0, 0.0)), format!("radius \"0\" {not}"));
    assert_eq!(line(GrainSpec::spheres(1.0, f32::NAN)), format!("radius \"NaN\" {not}"));
    assert!(line(GrainSpec { jitter: 0.6, ..good.clone() }).contains("from 0 to 0.5 spacings"));
    assert!(line(GrainSpec { axis: Axis::Along(Vec3::ZERO), ..good.clone() }).contains("axis"));
    assert!(line(GrainSpec::spheres(0.1, 1.0)).contains("at most 4 spacings"));
    let boxes = GrainSpec::of(Shape::Box { edges: Vec3::ONE, rounding: 0.0 }, 1.0);
    assert!(line(boxes.to_the_letter()).contains("spheres and cylinders only"));
}
