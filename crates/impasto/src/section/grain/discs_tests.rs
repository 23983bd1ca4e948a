//! The list of discs against the function it stands for.

use super::shape_tests::{direction, random};
use super::*;
use crate::math::{BATCH, Vec2, vec2, vec3};
use crate::section::{CutSurface, Plane};

const KINDS: [SectionKind; 3] = [SectionKind::Tear, SectionKind::Hollow, SectionKind::Solid];

#[test]
fn lists_agree_with_the_pure_function() {
    let of = |shape| GrainSpec::of(shape, 0.6);
    let specs = [
        GrainSpec::spheres(0.6, 0.3),
        GrainSpec { bevel_within_particle: true, ..GrainSpec::spheres(0.6, 0.3) },
        GrainSpec::cylinders(1.0, 0.5, 0.8, Vec3::Z),
        of(Shape::Capsule { radius: 0.15, height: 1.0 }),
        of(Shape::Box { edges: vec3(0.3, 0.4, 0.6), rounding: 0.0 }),
    ];
    for (s, spec) in specs.into_iter().enumerate() {
        let grain = Grain::new(spec).unwrap();
        for round in 0..3 {
            let plane = Plane::through(vec3(3.0, 2.0, 7.0), direction(round, 50)).unwrap();
            let window = Window::around(&plane, DVec3::new(4.0, 1.0, -2.0), vec2(3.0, 2.0));
            assert!(plane.distance(window.origin).abs() < 1e-12);
            let discs = grain.discs(&plane, window).unwrap();
            let (mut hits, mut near) = (Hits::new(), Vec::new());
            let (mut n, mut wrong) = (0, 0);
            for batch in 0..4 {
                let lane = |k: i32, size: f32| std::array::from_fn(|i| random(i as i32 + batch * 256, k) * size);
                let (xs, ys) = (lane(0, 3.0), lane(1, 2.0));
                for kind in KINDS {
                    for side in [Side::Below, Side::Above] {
                        let look = Look { kind, side };
                        discs.eval_batch(crate::par::Level::new(), [&xs, &ys], BATCH, look, (&mut near, &mut hits));
                        for i in 0..BATCH {
                            let at = vec2(xs[i], ys[i]);
                            let truth = grain.eval(window.point(at), &plane, look);
                            let got = hits.hit(i);
                            let same = got.kind == truth.kind
                                && got.particle == truth.particle
                                && (got.height - truth.height).abs() < 1e-3
                                && got.normal.dot(truth.normal) > 0.999
                                && (got.openness - truth.openness).abs() < 0.01;
                            (n, wrong) = (n + 1, wrong + !same as i32);
                            if i % 32 == 0 {
                                assert_eq!(discs.eval(at, look), got, "a batch of one");
                            }
                        }
                    }
                }
            }
            // Rims may fall to either side by rounding.
            assert!(wrong as f64 <= 2e-3 * n as f64, "grain {s}: {wrong} of {n} differ");
        }
    }
}

#[test]
fn lists_hold_circles_with_the_mean_radius_of_wicksell() {
    let grain = Grain::new(GrainSpec { size_spread: 0.0, jitter: 0.2, ..GrainSpec::spheres(1.0, 0.3) }).unwrap();
    let plane = Plane::through(Vec3::ZERO, vec3(0.3, 0.5, 0.8)).unwrap();
    let discs = grain.discs(&plane, Window::around(&plane, DVec3::ZERO, Vec2::splat(60.0))).unwrap();
    let radii: Vec<f32> = discs.iter().map(|d| discs.circle(d).unwrap()).collect();
    let mean = radii.iter().sum::<f32>() / radii.len() as f32;
    let truth = std::f32::consts::FRAC_PI_4 * 0.3;
    assert!((mean - truth).abs() < 0.01 * truth, "{mean} not {truth} of {}", radii.len());
    for disc in discs.iter().take(50) {
        for corner in discs.outline(disc, 24) {
            let distance = corner.as_vec2().distance(disc.at);
            assert!((distance - disc.radius).abs() < 1e-4);
        }
    }
    let n = radii.len();
    assert!(discs.clone().retain(|d| d.radius > truth).iter().count() < n);
}

#[test]
fn huge_windows_and_overlaps_have_no_list() {
    let grain = Grain::new(GrainSpec::spheres(1.0, 0.3)).unwrap();
    let plane = Plane::through(Vec3::ZERO, Vec3::Z).unwrap();
    assert!(grain.discs(&plane, Window::around(&plane, DVec3::ZERO, Vec2::splat(1e6))).is_none());
    let overlapping = Grain::new(GrainSpec::spheres(1.0, 0.3).to_the_letter()).unwrap();
    assert!(overlapping.discs(&plane, Window::around(&plane, DVec3::ZERO, Vec2::ONE)).is_none());
}

#[test]
fn scalar_and_simd_give_the_same_bits() {
    let grain = Grain::new(GrainSpec::spheres(0.6, 0.3)).unwrap();
    let plane = Plane::through(Vec3::ZERO, vec3(1.0, 0.0, 1.0)).unwrap();
    let discs = grain.discs(&plane, Window::around(&plane, DVec3::ZERO, vec2(4.0, 4.0))).unwrap();
    let (xs, ys) =
        (std::array::from_fn(|i| random(i as i32, 0) * 4.0), std::array::from_fn(|i| random(i as i32, 1) * 4.0));
    let scalar = crate::par::level_by_name("scalar").unwrap();
    for kind in KINDS {
        let look = Look { kind, side: Side::Above };
        let mut near = Vec::new();
        let [mut a, mut b] = [Hits::new(), Hits::new()];
        discs.eval_batch(scalar, [&xs, &ys], BATCH, look, (&mut near, &mut a));
        discs.eval_batch(crate::par::Level::new(), [&xs, &ys], BATCH, look, (&mut near, &mut b));
        for i in 0..BATCH {
            let bits = |h: Hit| {
                (h.height.to_bits(), h.normal.to_array().map(f32::to_bits), h.kind, h.particle, h.openness.to_bits())
            };
            assert_eq!(bits(a.hit(i)), bits(b.hit(i)), "{kind:?} lane {i}");
        }
    }
}
