//! Truths about cells, fibres, mixtures, and grain from afar.

use super::shape_tests::{direction, random};
use super::*;
use crate::math::{dvec3, vec3};
use crate::section::Plane;

const KINDS: [SectionKind; 3] = [SectionKind::Tear, SectionKind::Hollow, SectionKind::Solid];

fn on_plane(i: i32) -> (DVec3, Plane) {
    let plane = Plane::through(vec3(random(i / 97, 20), random(i / 97, 21), 0.3), direction(i / 97, 22)).unwrap();
    let [u, v] = plane.axes();
    let p = plane.normal * plane.offset + u * (random(i, 0) as f64 * 9.0) + v * (random(i, 1) as f64 * 9.0);
    (p, plane)
}

fn fillings() -> Vec<(&'static str, Filling)> {
    let cells = |spec| Filling::Cells(Box::new(Cells::new(spec).unwrap()));
    let stretched = CellsSpec { stretch: vec3(1.0, 3.0, 0.7), weight_spread: 0.3, ..CellsSpec::of(0.7, 0.0) };
    let fibres = Fibres::new(FibresSpec::of(0.5, 0.22, vec3(0.2, 1.0, 0.1))).unwrap();
    let grain = |spacing, radius| Size::Grain(Box::new(Grain::new(GrainSpec::spheres(spacing, radius)).unwrap()));
    let scales = |grains, mixing| Filling::Scales(Box::new(Scales::new(grains, mixing).unwrap()));
    vec![
        ("plain", Filling::Plain),
        ("voronoi", cells(CellsSpec::of(0.7, 0.0))),
        ("walls", cells(CellsSpec::of(0.7, 0.1))),
        ("laguerre", cells(stretched)),
        ("fibres", Filling::Fibres(Box::new(fibres))),
        ("two scales", scales(vec![grain(1.2, 0.5), grain(0.25, 0.1)], Mixing::Apart(0.02))),
    ]
}

fn eval(filling: &Filling, p: DVec3, plane: &Plane, kind: SectionKind, side: Side) -> Hit {
    filling.eval(p, plane, Look { kind, side }, &|p| p.y as f32)
}

#[test]
fn torn_sides_of_all_fillings_are_exact_negatives() {
    for (name, filling) in fillings() {
        let mut on_particles = 0;
        for i in 0..1_500 {
            let (p, plane) = on_plane(i);
            let a = eval(&filling, p, &plane, SectionKind::Tear, Side::Below);
            let b = eval(&filling, p, &plane, SectionKind::Tear, Side::Above);
            assert_eq!((a.height, a.normal, a.particle), (-b.height, -b.normal, b.particle), "{name} at {p}");
            on_particles += (a.kind != HitKind::Matrix) as i32;
        }
        assert!(name == "plain" || on_particles > 200, "{name}: {on_particles}");
    }
}

#[test]
fn normals_of_all_fillings_are_those_of_their_heights() {
    const STEP: f64 = 1e-4;
    for (name, filling) in fillings() {
        for kind in KINDS {
            let (mut n, mut good) = (0, 0);
            for i in 0..500 {
                let (p, plane) = on_plane(i);
                let at = |q| eval(&filling, q, &plane, kind, Side::Below);
                let hit = at(p);
                let [u, v] = plane.axes();
                let near = [u, -u, v, -v].map(|d| at(p + d * STEP));
                let is_smooth =
                    |h: &Hit| h.kind == hit.kind && h.particle == hit.particle && h.normal.dot(hit.normal) > 0.995;
                if hit.particle == Hit::MATRIX || !near.iter().all(is_smooth) {
                    continue;
                }
                if hit.normal.as_dvec3().dot(plane.normal) < 0.3 {
                    continue;
                }
                let slope = |a: Hit, b: Hit| (a.height - b.height) as f64 / (2.0 * STEP);
                let truth = plane.normal - u * slope(near[0], near[1]) - v * slope(near[2], near[3]);
                n += 1;
                good += (hit.normal.as_dvec3().dot(truth.normalize()) > 0.995) as i32;
            }
            assert!(name == "plain" || n > 20 && good as f64 > 0.96 * n as f64, "{name} {kind:?}: {good} of {n}");
        }
    }
}

#[test]
fn cells_own_the_places_that_are_nearest_to_their_seeds() {
    let spec = CellsSpec { jitter: 0.5, weight_spread: 0.5, ..CellsSpec::of(1.0, 0.0) };
    let cells = Cells::new(spec).unwrap();
    let look = Look { kind: SectionKind::Solid, side: Side::Below };
    for i in 0..300 {
        let (p, plane) = on_plane(i);
        let hit = cells.eval(p, &plane, look);
        assert_eq!((hit.kind, hit.height), (HitKind::Disc, 0.0));
        // All places of one name hang together: the way between two stays in the cell, which is convex.
        let q = p + plane.axes()[0] * 0.3;
        if cells.eval(q, &plane, look).particle == hit.particle {
            for k in 1..8 {
                assert_eq!(cells.eval(p + (q - p) * (k as f64 / 8.0), &plane, look).particle, hit.particle);
            }
        }
    }
}

#[test]
fn fibres_run_along_their_axis_and_never_overlap() {
    let axis = vec3(0.3, 0.9, -0.2).normalize();
    let fibres = Fibres::new(FibresSpec { jitter: 0.3, ..FibresSpec::of(0.5, 0.25, axis) }).unwrap();
    // Across the axis all discs are round: the mean of the bevels' directions does not lean.
    let plane = Plane::through(vec3(0.1, 0.2, 0.3), axis).unwrap();
    let look = Look { kind: SectionKind::Solid, side: Side::Below };
    let [u, v] = plane.axes();
    let mut covered = 0;
    for i in 0..4_000 {
        let p = plane.normal * plane.offset + u * (random(i, 0) as f64 * 20.0) + v * (random(i, 1) as f64 * 20.0);
        let hit = fibres.eval(p, &plane, look);
        covered += (hit.kind == HitKind::Disc) as i32;
        // The same fibre a little farther along, unless a break is there.
        let on = p + plane.normal * 0.01;
        let next = fibres.eval(on, &Plane { offset: plane.offset + 0.01, ..plane }, look);
        let same = next.particle == hit.particle;
        assert!(
            same || next.kind == HitKind::Matrix
                || hit.kind == HitKind::Matrix
                || hit.kind == HitKind::Bevel
                || next.kind == HitKind::Bevel
        );
    }
    assert!((0.35..0.75).contains(&(covered as f64 / 4_000.0)), "{covered} of 4000");
    assert!(Fibres::new(FibresSpec::of(0.5, 0.0, axis)).is_err());
    assert!(Fibres::new(FibresSpec::of(0.5, 0.2, Vec3::ZERO)).is_err());
}

#[test]
fn fine_particles_keep_away_from_coarse_ones() {
    let coarse = Grain::new(GrainSpec::of(Shape::Box { edges: vec3(0.4, 0.5, 0.8), rounding: 0.0 }, 1.0)).unwrap();
    let fine = Grain::new(GrainSpec::spheres(0.2, 0.08)).unwrap();
    let filling = Filling::Scales(Box::new(
        Scales::new([coarse.clone(), fine].map(|g| Size::Grain(Box::new(g))).to_vec(), Mixing::Apart(0.03)).unwrap(),
    ));
    let look = Look { kind: SectionKind::Tear, side: Side::Below };
    let (mut n_fine, mut n_coarse) = (0, 0);
    for i in 0..1_500 {
        let (p, plane) = on_plane(i);
        let hit = filling.eval(p, &plane, look, &|_| 1.0);
        let of_coarse = coarse.eval(p, &plane, look);
        if hit.kind == HitKind::Matrix {
            continue;
        }
        if of_coarse.kind == HitKind::Matrix {
            n_fine += 1;
            // Nothing coarse within the gap.
            for k in 0..6 {
                let q = p + direction(i * 7 + k, 90).as_dvec3() * 0.029;
                let near = coarse.eval(q, &Plane { offset: plane.normal.dot(q), ..plane }, look);
                assert_eq!(near.kind, HitKind::Matrix, "at {p}");
            }
        } else {
            assert_eq!(hit, of_coarse);
            n_coarse += 1;
        }
    }
    assert!(n_fine > 30 && n_coarse > 30, "{n_fine} {n_coarse}");
}

#[test]
fn layers_end_between_particles() {
    let grain = |spacing: f32, seed| {
        let spec = GrainSpec { seed, ..GrainSpec::spheres(spacing, spacing * 0.45) };
        Filling::Particles(Box::new(Grain::new(spec).unwrap()))
    };
    let layer = |until, filling| Layer { until, filling, strict: true };
    let filling =
        Filling::Layers(vec![layer(1.0, Filling::Plain), layer(3.0, grain(0.4, 1)), layer(9.0, grain(0.4, 2))]);
    let plane = Plane::through(Vec3::ZERO, vec3(0.1, 0.0, 1.0)).unwrap();
    let look = Look { kind: SectionKind::Solid, side: Side::Below };
    let mut found = [0; 3];
    for i in 0..6_000 {
        let y = 5.0 * random(i, 1).abs() as f64;
        let p = dvec3(random(i, 0) as f64 * 9.0, y, 0.0);
        let p = p - plane.normal * (plane.normal.dot(p) - plane.offset);
        let hit = filling.eval(p, &plane, look, &|p| p.y as f32);
        let band = if p.y < 1.0 {
            0
        } else if p.y < 3.0 {
            1
        } else {
            2
        };
        found[band] += (hit.kind == HitKind::Disc) as i32;
    }
    assert!(found[0] == 0 && found[1] > 100 && found[2] > 100, "{found:?}");
}

#[test]
fn the_far_model_is_what_many_samples_have_in_the_mean() {
    let grain = Grain::new(GrainSpec::spheres(1.0, 0.5)).unwrap();
    let plane = Plane::through(Vec3::ZERO, vec3(0.3, 0.2, 0.9)).unwrap();
    for kind in [SectionKind::Tear, SectionKind::Hollow] {
        let look = Look { kind, side: Side::Below };
        let far = Far::measured(1000.0, 20_000, &|p| grain.eval_at(p, plane.normal, look));
        let truth = Far::of_balls(far.covered);
        assert!((far.mean_length - truth.mean_length).abs() < 0.01, "{far:?} {truth:?}");
        assert!((far.covered - 0.243).abs() < 0.02, "{far:?}: the volume fraction of the weighted split");
        assert!(far.kappa() > 1.0 && far.roughness(0.3) > 0.3);
        // Errors of the mean brightness at a pixel per spacing: bare points, then the far model faded in.
        let light = (plane.normal + plane.axes()[0] * 0.8).normalize().as_vec3();
        let [u, v] = plane.axes();
        let (mut bare, mut filtered, mut n) = (0.0, 0.0, 0);
        for i in 0..120 {
            let p = u * (random(i, 0) as f64 * 50.0) + v * (random(i, 1) as f64 * 50.0);
            let brightness = |normal: Vec3| normal.dot(light);
            let mut truth = 0.0;
            for j in 0..16 {
                for k in 0..16 {
                    let q = p + u * ((k as f64 + 0.5) / 16.0 - 0.5) + v * ((j as f64 + 0.5) / 16.0 - 0.5);
                    truth += brightness(grain.eval(q, &plane, look).normal) / 256.0;
                }
            }
            let footprint = Footprint { middle: p, dx: u, dy: v, normal: plane.normal };
            let at = |p| grain.eval(p, &plane, look);
            let got = super::filtered(&footprint, (&far, 1.0), 3, &at);
            bare += (brightness(at(p).normal) - truth).powi(2);
            filtered += (brightness(got.normal) - truth).powi(2);
            n += 1;
        }
        let (bare, filtered) = ((bare / n as f32).sqrt(), (filtered / n as f32).sqrt());
        assert!(filtered < 0.5 * bare && filtered < 0.08, "{kind:?}: {bare} bare, {filtered} filtered");
    }
    assert!(fade(0.1, 1.0) == 0.0 && fade(3.0, 1.0) == 1.0 && (fade(1.25, 1.0) - 0.5).abs() < 1e-6);
}

#[test]
fn bad_cells_give_one_clear_line() {
    assert!(Cells::new(CellsSpec::of(-1.0, 0.0)).unwrap_err().to_string().starts_with("spacing \"-1\""));
    assert!(Cells::new(CellsSpec::of(1.0, 2.0)).unwrap_err().to_string().contains("wall"));
    let flat = CellsSpec { stretch: vec3(1.0, 0.0, 1.0), ..CellsSpec::of(1.0, 0.0) };
    assert!(Cells::new(flat).unwrap_err().to_string().contains("stretch"));
}

#[test]
fn openness_in_cells_agrees_with_shooting_rays_at_the_sky() {
    let cells = Cells::new(CellsSpec { stretch: vec3(1.0, 1.5, 0.8), ..CellsSpec::of(0.7, 0.12) }).unwrap();
    let mut n = 0;
    for i in 0..60 {
        let (p, plane) = on_plane(i * 53);
        let hit = cells.eval(p, &plane, Look { kind: SectionKind::Hollow, side: Side::Below });
        if hit.kind != HitKind::Cavity {
            continue;
        }
        n += 1;
        let q = p + plane.normal * hit.height as f64;
        let frame = crate::math::Frame::about(hit.normal);
        let (mut seen, n_rays) = (0, 4_000);
        for k in 0..n_rays {
            let (a, b) = ((k as f32 + 0.5) / n_rays as f32, (k as f32 * 0.618_034).fract());
            let (s, c) = crate::math::sin_cos(b * std::f32::consts::TAU);
            let t = (frame.tangent * c + frame.bitangent * s) * a.sqrt() + frame.normal * (1.0 - a).sqrt();
            let rise = t.as_dvec3().dot(plane.normal);
            if rise > 1e-4 {
                let x = q + t.as_dvec3() * (-hit.height as f64 / rise);
                let look = Look { kind: SectionKind::Solid, side: Side::Below };
                let top = cells.eval(x, &plane, look);
                seen += (top.kind == HitKind::Disc && top.particle == hit.particle) as i32;
            }
        }
        let truth = seen as f32 / n_rays as f32;
        assert!((hit.openness - truth).abs() < 0.06, "{} not {truth}", hit.openness);
    }
    assert!(n > 20, "{n}");
}
