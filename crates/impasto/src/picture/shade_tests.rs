//! Truths about shading: energy, reciprocity, and the same bits at every level.

use super::*;
use crate::math::{BATCH, exact, hash, unit_float, vec3};
use crate::picture::ambient::spiral;
use crate::picture::lanes::tests::at_every_level;
use crate::placement::Viewpoint;
use fearless_simd::{Level, dispatch};

const VIEWPOINT: Viewpoint =
    Viewpoint { eye_from_world: crate::math::Mat4::IDENTITY, eye: Vec3::ZERO, parallel: Some(Vec3::Z) };

/// A full batch of random but valid points and surfaces.
fn random_batch(seed: u32) -> (Box<Surfels>, Box<Surfaces>) {
    let (mut surfels, mut surfaces) = (Surfels::new(0), Surfaces::new());
    (surfels.n, surfaces.n) = (BATCH, BATCH);
    let mut k = hash(seed);
    let mut next = || {
        k = hash(k.wrapping_add(1));
        unit_float(k)
    };
    for i in 0..BATCH {
        let mut direction = || unit_or(vec3(next() - 0.5, next() - 0.5, next() - 0.5), Vec3::Z);
        let (view, normal) = (direction(), direction());
        let normal = if normal.dot(view) < 0.0 { -normal } else { normal };
        for c in 0..3 {
            surfels.view[c][i] = view[c];
            surfaces.normal[c][i] = normal[c];
            surfaces.coat_normal[c][i] = normal[c];
            surfels.position[c][i] = next() * 2.0 - 1.0;
            surfaces.color[c][i] = next();
            surfaces.emission[c][i] = if i % 7 == 0 { next() } else { 0.0 };
        }
        surfaces.roughness[i] = next();
        surfaces.metalness[i] = if i % 2 == 0 { 0.0 } else { next() };
        surfaces.occlusion[i] = 1.0 - 0.5 * next();
        surfaces.coat[i] = if i / 16 % 2 == 0 { next() } else { 0.0 };
        surfaces.coat_roughness[i] = next();
    }
    (surfels, surfaces)
}

fn shaded(level: Level, shading: Shading, lighting: &Lighting, surfels: &Surfels, surfaces: &Surfaces) -> [Lane; 3] {
    let mut out = [[0.0; BATCH]; 3];
    dispatch!(level, simd => shade(simd, shading, lighting, surfels, surfaces, &mut out));
    out
}

/// One directional light and even ambient light.
fn one_light(toward: Vec3, intensity: f32, ambient: f32) -> Lighting {
    Lighting { lights: vec![Light::directional(toward, intensity)], ..Lighting::flat(ambient) }
}

#[test]
fn every_level_and_any_grouping_give_the_same_bits() {
    let mut every_kind = Lighting::studio(&VIEWPOINT);
    every_kind.lights.extend([
        Light { size: 0.1, ..Light::new(LightKind::Headlight) },
        Light::new(LightKind::Point(vec3(1.0, 2.0, 3.0))),
        Light::new(LightKind::Spot { position: vec3(0.0, 3.0, 0.0), axis: Vec3::NEG_Y, cone: [0.95, 0.6] }),
    ]);
    let blinn = Shading::BlinnPhong { specular: 0.4, exponent: 48.0 };
    for shading in [Shading::Unlit, Shading::Lambert, blinn, Shading::MetalRough] {
        let (surfels, surfaces) = random_batch(1);
        let mut wanted = None;
        at_every_level(|name, level| {
            let got = shaded(level, shading, &every_kind, &surfels, &surfaces).map(|lane| lane.map(f32::to_bits));
            assert_eq!(*wanted.get_or_insert(got), got, "{name}: {shading:?}");
            let (mut one_surfel, mut one_surface) = (surfels.clone(), surfaces.clone());
            (one_surfel.n, one_surface.n) = (1, 1);
            let alone = shaded(level, shading, &every_kind, &one_surfel, &one_surface);
            assert!((0..3).all(|c| alone[c][0].to_bits() == got[c][0]), "{name}: {shading:?} alone");
            assert!(got.iter().flatten().all(|b| f32::from_bits(*b).is_finite()), "{name}: {shading:?} is finite");
        });
    }
}

#[test]
fn blinn_phong_is_the_textbook_formula() {
    let light = unit_or(vec3(-0.4, 0.6, 0.7), Vec3::Z);
    let lighting = one_light(light, 0.85, 0.15);
    let shading = Shading::BlinnPhong { specular: 0.35 / 0.85, exponent: 48.0 };
    let (surfels, mut surfaces) = random_batch(2);
    surfaces.occlusion = [1.0; BATCH];
    surfaces.emission = [[0.0; BATCH]; 3];
    let got = shaded(Level::new(), shading, &lighting, &surfels, &surfaces);
    for i in 0..BATCH {
        let vector = |lanes: &[Lane; 3]| [0, 1, 2].map(|c| lanes[c][i] as f64);
        let (n, v, l) = (vector(&surfaces.normal), vector(&surfels.view), light.to_array().map(|x| x as f64));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let h = [0, 1, 2].map(|c| l[c] + v[c]);
        let n_dot_h = (dot(n, h) / dot(h, h).sqrt()).max(0.0);
        for c in 0..3 {
            let color = surfaces.color[c][i] as f64;
            let wanted = color * (0.15 + 0.85 * dot(n, l).max(0.0)) + 0.35 * exact::pow(n_dot_h, 48.0);
            assert!((got[c][i] as f64 - wanted).abs() < 2e-5, "cell {i}: {} not {wanted}", got[c][i]);
        }
    }
}

#[test]
fn soft_light_is_continuous_and_keeps_what_faces_it() {
    let lit =
        |cosine: f32, size: f32| dispatch!(Level::new(), simd => softened(simd, splat_test(simd, cosine), size)[0]);
    for size in [0.0, 0.1, 0.55, 1.0] {
        assert!((lit(1.0, size) - 1.0).abs() < 1e-6 && lit(-1.0, size).abs() < 1e-6);
        let mut last = 0.0;
        for i in -1000..=1000 {
            let now = lit(i as f32 * 1e-3, size);
            assert!(now >= last && now - last < 1.01e-3, "size {size}, cosine {i}");
            last = now;
        }
    }
}

fn splat_test<S: Simd>(simd: S, x: f32) -> V<S> {
    crate::picture::lanes::splat(simd, x)
}

/// One material for all cells, seen straight from `view`; the normal is +Z.
fn uniform(view: Vec3, color: f32, roughness: f32, metalness: f32) -> (Box<Surfels>, Box<Surfaces>) {
    let (mut surfels, mut surfaces) = random_batch(3);
    for c in 0..3 {
        surfels.view[c] = [view[c]; BATCH];
        surfaces.normal[c] = [Vec3::Z[c]; BATCH];
        surfaces.coat_normal[c] = [Vec3::Z[c]; BATCH];
        surfaces.color[c] = [color; BATCH];
        surfaces.emission[c] = [0.0; BATCH];
    }
    surfaces.roughness = [roughness; BATCH];
    surfaces.metalness = [metalness; BATCH];
    surfaces.occlusion = [1.0; BATCH];
    surfaces.coat = [0.0; BATCH];
    (surfels, surfaces)
}

/// Reflected share of a light that comes from `toward`, cosine included, divided by pi as all light here is.
fn reflected(view: Vec3, toward: Vec3, roughness: f32, metalness: f32) -> f32 {
    let (surfels, surfaces) = uniform(view, 1.0, roughness, metalness);
    shaded(Level::new(), Shading::MetalRough, &one_light(toward, 1.0, 0.0), &surfels, &surfaces)[0][0]
}

#[test]
fn directional_light_from_everywhere_is_never_more_than_white() {
    // White furnace by numeric integration over lights. A single bounce loses what facets catch again: at roughness 1
    // up to seven tenths, which is known and belongs to the model.
    for (roughness, least) in [(0.3, 0.90), (0.6, 0.75), (1.0, 0.31)] {
        for n_dot_v in [0.2f32, 0.6, 0.95] {
            let view = vec3((1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v);
            const N: usize = 8000;
            let share = |metalness| {
                let sum: f32 = spiral(N).filter(|d| d.z > 0.0).map(|d| reflected(view, d, roughness, metalness)).sum();
                sum * 4.0 / N as f32
            };
            let metal = share(1.0);
            assert!(metal <= 1.01 && metal > least, "metal {roughness} {n_dot_v}: {metal}");
            if roughness == 1.0 {
                // There the distribution is even and the integral has a closed form.
                let truth = 1.0 - n_dot_v * exact::log((1.0 + 1.0 / n_dot_v) as f64) as f32;
                assert!((metal - truth).abs() < 0.005, "metal {n_dot_v}: {metal} not {truth}");
            }
            // Appendix B weighs the matte part by the half vector's Fresnel term alone, which at grazing views leaves
            // a white dielectric up to a fifth too bright. Files are made against that formula, so it stays.
            let most = if n_dot_v < 0.5 { 1.22 } else { 1.05 };
            let dielectric = share(0.0);
            assert!(dielectric <= most && dielectric > 0.85, "dielectric {roughness} {n_dot_v}: {dielectric}");
        }
    }
}

#[test]
fn even_surroundings_vanish_on_a_white_surface() {
    // With the bounces between facets counted, a white metal in even light is white at any roughness.
    for metalness in [0.0, 1.0] {
        for roughness in [0.0, 0.3, 0.7, 1.0] {
            for n_dot_v in [0.1f32, 0.5, 1.0] {
                let view = vec3((1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v);
                let (surfels, surfaces) = uniform(view, 1.0, roughness, metalness);
                let got = shaded(Level::new(), Shading::MetalRough, &Lighting::flat(1.0), &surfels, &surfaces)[0][0];
                assert!((got - 1.0).abs() < 2e-3, "metal {metalness} rough {roughness} at {n_dot_v}: {got}");
            }
        }
    }
}

#[test]
fn light_and_eye_can_change_places() {
    for i in 0..200 {
        let f = |s: u32| unit_float(hash(i * 7 + s)) * 0.98;
        let up = |a: f32, b: f32| unit_or(vec3(a - 0.5, b - 0.5, 0.25), Vec3::Z);
        let (view, toward) = (up(f(1), f(2)), up(f(3), f(4)));
        for metalness in [0.0, 1.0] {
            let roughness = 0.2 + 0.8 * f(5);
            let there = reflected(view, toward, roughness, metalness) / toward.z;
            let back = reflected(toward, view, roughness, metalness) / view.z;
            assert!((there - back).abs() < 1e-3 * there.max(0.1), "{view} {toward} {roughness}: {there} {back}");
        }
    }
}

#[test]
fn lights_fall_off_as_they_should() {
    let (mut surfels, mut surfaces) = uniform(Vec3::Z, 1.0, 1.0, 0.0);
    (surfels.position, surfaces.occlusion) = ([[0.0; BATCH]; 3], [0.0; BATCH]);
    let spot = |x| LightKind::Spot { position: vec3(x, 0.0, 2.0), axis: Vec3::NEG_Z, cone: [0.95, 0.8] };
    for (kind, wanted) in [
        (LightKind::Directional(Vec3::Z), 1.0),
        (LightKind::Directional(Vec3::NEG_Z), 0.0),
        (LightKind::Headlight, 1.0),
        (LightKind::Point(vec3(0.0, 0.0, 2.0)), 0.25),
        (spot(0.0), 0.25),
        (spot(2.0), 0.0),
    ] {
        let lighting = Lighting { lights: vec![Light::new(kind)], ..Lighting::flat(0.0) };
        let got = shaded(Level::new(), Shading::Lambert, &lighting, &surfels, &surfaces)[1][0];
        assert!((got - wanted).abs() < 1e-6, "{kind:?}: {got} not {wanted}");
    }
}

#[test]
fn only_what_light_reads_is_asked_for() {
    let studio = Lighting::studio(&VIEWPOINT);
    let lamp = Lighting { lights: vec![Light::new(LightKind::Point(Vec3::ZERO))], ..Lighting::flat(0.1) };
    assert_eq!(needs(Shading::Unlit, &lamp), Needs::default());
    assert_eq!(needs(Shading::Lambert, &studio), Needs::default());
    assert!(needs(Shading::MetalRough, &studio).view && !needs(Shading::MetalRough, &studio).position);
    assert!(needs(Shading::Lambert, &lamp).position && needs(Shading::Lambert, &Lighting::headlight()).view);
}
