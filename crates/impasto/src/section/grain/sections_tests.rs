//! Rows against the function that they stand for.

use super::shape_tests::direction;
use super::*;
use crate::math::{vec2, vec3};
use crate::section::Plane;

const KINDS: [SectionKind; 3] = [SectionKind::Tear, SectionKind::Hollow, SectionKind::Solid];

fn depth(p: DVec3) -> f32 {
    p.length() as f32 * 0.3
}

#[track_caller]
fn check(name: &str, filling: &Filling, plane: &Plane, look: Look) -> usize {
    let window = Window::around(plane, DVec3::new(4.0, 1.0, -2.0), vec2(2.0, 1.5));
    let sections = Sections::new(filling, plane, window, look, &depth);
    assert!(sections.is_listed(), "{name}");
    let xs: Vec<f32> = (0..41).map(|i| -2.0 + i as f32 * (4.0 / 40.0)).collect();
    let mut hits = vec![filling.eval(window.origin, plane, look, &depth); xs.len()];
    let mut n = 0;
    for j in 0..4 {
        let y = -1.5 + j as f32;
        sections.row(crate::par::Level::new(), y, &xs, &mut hits);
        for (&x, got) in xs.iter().zip(&hits) {
            let truth = filling.eval(window.point(vec2(x, y)), plane, look, &depth);
            let bits = |h: &Hit| (h.height.to_bits(), h.normal.to_array().map(f32::to_bits), h.openness.to_bits());
            let is_same = bits(got) == bits(&truth) && (got.kind, got.particle) == (truth.kind, truth.particle);
            assert!(is_same, "{name} {look:?} at {x},{y}: {got:?} not {truth:?}");
            n += (truth.particle != Hit::MATRIX) as usize;
        }
    }
    n
}

#[test]
fn rows_have_the_bits_of_single_places() {
    for (name, filling) in super::outlines_tests::fillings() {
        let mut n = 0;
        for (i, normal) in [direction(3, 70), direction(4, 70), Vec3::Y].into_iter().enumerate() {
            let plane = Plane::through(vec3(0.3, 0.2, 0.7), normal).unwrap();
            for kind in KINDS {
                let side = if i % 2 == 0 { Side::Below } else { Side::Above };
                n += check(name, &filling, &plane, Look { kind, side });
            }
        }
        assert!(n > 60, "{name}: {n} places on particles");
    }
}

#[test]
fn grown_and_narrowly_bevelled_particles_have_the_same_bits_too() {
    let block = Shape::Box { edges: vec3(0.3, 0.4, 0.6), rounding: 0.0 };
    let of = |shape| GrainSpec { contact: Contact::Apart { grow: 1.5 }, bevel: 0.2, ..GrainSpec::of(shape, 0.6) };
    let narrow = |spec| GrainSpec { bevel_within_particle: true, ..spec };
    let soft = Shape::Cylinder { radius: 0.2, height: 0.5, ends: Ends::Soft };
    for spec in [of(block.clone()), narrow(of(block)), of(soft), narrow(GrainSpec::spheres(0.6, 0.3))] {
        let filling = Filling::Particles(Box::new(Grain::new(spec).unwrap()));
        let plane = Plane::through(vec3(0.3, 0.2, 0.7), vec3(0.3, -0.5, 0.8)).unwrap();
        for kind in KINDS {
            assert!(check("special", &filling, &plane, Look { kind, side: Side::Below }) > 10);
        }
    }
}

#[test]
fn what_has_no_list_and_what_is_outside_is_asked_place_by_place() {
    let filling = Filling::Particles(Box::new(Grain::new(GrainSpec::spheres(0.6, 0.3).to_the_letter()).unwrap()));
    let plane = Plane::through(Vec3::ZERO, Vec3::Y).unwrap();
    let window = Window::around(&plane, DVec3::ZERO, vec2(1.0, 1.0));
    let look = Look { kind: SectionKind::Tear, side: Side::Below };
    let sections = Sections::new(&filling, &plane, window, look, &depth);
    assert!(!sections.is_listed());
    let listed = Filling::Particles(Box::new(Grain::new(GrainSpec::spheres(0.6, 0.3)).unwrap()));
    let outside = Sections::new(&listed, &plane, window, look, &depth);
    for (filling, sections) in [(&filling, &sections), (&listed, &outside)] {
        let xs = [-3.0, 0.5, 2.0, f32::NAN];
        let mut hits = [filling.eval(DVec3::ZERO, &plane, look, &depth); 4];
        sections.row(crate::par::Level::new(), 0.25, &xs, &mut hits);
        for (&x, got) in xs.iter().zip(&hits).take(3) {
            assert_eq!(*got, filling.eval(window.point(vec2(x, 0.25)), &plane, look, &depth));
        }
    }
}
