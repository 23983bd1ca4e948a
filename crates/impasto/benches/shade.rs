//! How long light and develop take, one thread, by shading model and SIMD level.
//!
//! `cargo bench --bench shade`; throughput is in cells (pixels).

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fearless_simd::dispatch;
use impasto::lookup::{Shading, Surfaces};
use impasto::math::{BATCH, Mat4, Vec3, hash, unit_float, unit_or, vec3};
use impasto::par;
use impasto::picture::{Develop, Light, Lighting, shade};
use impasto::placement::{Surfels, Viewpoint};

fn batch() -> (Box<Surfels>, Box<Surfaces>) {
    let (mut surfels, mut surfaces) = (Surfels::new(0), Surfaces::new());
    (surfels.n, surfaces.n) = (BATCH, BATCH);
    for i in 0..BATCH {
        let f = |s: u32| unit_float(hash(i as u32 * 16 + s));
        let normal = unit_or(vec3(f(1) - 0.5, f(2) - 0.5, f(3)), Vec3::Z);
        for c in 0..3 {
            surfels.view[c][i] = Vec3::Z[c];
            surfaces.normal[c][i] = normal[c];
            surfaces.coat_normal[c][i] = normal[c];
            surfaces.color[c][i] = f(4 + c as u32);
        }
        surfaces.roughness[i] = f(8);
        surfaces.metalness[i] = f(9);
        surfaces.occlusion[i] = 1.0;
    }
    (surfels, surfaces)
}

fn shading(c: &mut Criterion) {
    let (surfels, surfaces) = batch();
    let viewpoint = Viewpoint { eye_from_world: Mat4::IDENTITY, eye: Vec3::Z, parallel: Some(Vec3::Z) };
    let one = Lighting { lights: vec![Light::directional(vec3(-0.4, 0.6, 0.7), 0.85)], ..Lighting::flat(0.15) };
    let studio = Lighting::studio(&viewpoint);
    let blinn = Shading::BlinnPhong { specular: 0.35 / 0.85, exponent: 48.0 };
    let mut group = c.benchmark_group("shade");
    group.throughput(Throughput::Elements(BATCH as u64));
    for (name, shading, lighting) in [
        ("blinn_phong_one_light", blinn, &one),
        ("lambert_studio", Shading::Lambert, &studio),
        ("metal_rough_one_light", Shading::MetalRough, &one),
        ("metal_rough_studio", Shading::MetalRough, &studio),
    ] {
        for level_name in par::LEVEL_NAMES {
            let Some(level) = par::level_by_name(level_name) else { continue };
            let mut out = [[0.0; BATCH]; 3];
            group.bench_function(BenchmarkId::new(name, level_name), |b| {
                b.iter(|| dispatch!(level, simd => shade(simd, shading, lighting, &surfels, &surfaces, &mut out)));
            });
        }
    }
}

fn develop(c: &mut Criterion) {
    let f = |i: u32, s: u32| unit_float(hash(i ^ hash(s)));
    let cells: Vec<[f32; 4]> = (0..1280).map(|i| [f(i, 1), f(i, 2), f(i, 3) * 2.0, 1.0]).collect();
    let mut out = vec![[0; 4]; cells.len()];
    let mut group = c.benchmark_group("develop_rgba8");
    group.throughput(Throughput::Elements(cells.len() as u64));
    for (name, develop) in [("plain", Develop::PLAIN), ("filmic", Develop::default())] {
        for level_name in par::LEVEL_NAMES {
            let Some(level) = par::level_by_name(level_name) else { continue };
            group.bench_function(BenchmarkId::new(name, level_name), |b| {
                b.iter(|| dispatch!(level, simd => develop.rgba8(simd, &cells, Some([0.9; 3]), 0, &mut out)));
            });
        }
    }
}

criterion_group!(benches, shading, develop);
criterion_main!(benches);
