//! Time of a batch of 256 points through one-layer looks; divide by 256 for a point's.
//!
//! Points lie along rows that are turned against a 1024 x 1024 texture, about one texel apart unless the name says otherwise.

use criterion::{Criterion, criterion_group, criterion_main};
use fearless_simd::dispatch;
use impasto::assets::{Image, Mesh, RawMesh, Sampler, Texels, TextureImage, UvSet};
use impasto::color::Encoding;
use impasto::lookup::*;
use impasto::math::{BATCH, Mat4, Size, Vec2, Vec3, hash_cell, vec2};
use impasto::par::{Level, level_by_name};
use impasto::placement::{Surfels, Viewpoint};
use std::hint::black_box;

const VIEW: Viewpoint = Viewpoint { eye_from_world: Mat4::IDENTITY, eye: Vec3::Z, parallel: None };

fn mesh() -> Mesh {
    RawMesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        uv_sets: vec![UvSet { name: "uv0".into(), uv: vec![Vec2::ZERO, Vec2::X, Vec2::Y] }],
        ..RawMesh::default()
    }
    .mend()
    .value
}

/// Batches that walk over the texture; a step right is `dx`, a step down `dy`, in texels.
fn batches(dx: Vec2, dy: Vec2) -> Vec<Box<Surfels>> {
    let batch = |b: usize| {
        let mut surfels = Surfels::new(1);
        surfels.n = BATCH;
        for i in 0..BATCH {
            let st = (dx * ((b % 5 * 64 + i % 64) as f32) + dy * ((b / 5 * 4 + i / 64) as f32)) / 1024.0;
            let uv = &mut surfels.uv[0];
            (uv.st[0][i], uv.st[1][i]) = (st.x, st.y);
            (uv.d_dx[0][i], uv.d_dx[1][i]) = (dx.x / 1024.0, dx.y / 1024.0);
            (uv.d_dy[0][i], uv.d_dy[1][i]) = (dy.x / 1024.0, dy.y / 1024.0);
            surfels.normal[2][i] = 1.0;
        }
        surfels
    };
    (0..400).map(batch).collect()
}

fn looks(encoding: Encoding, is_wide: bool, max_anisotropy: u8) -> Looks {
    let size = Size::new(1024, 1024);
    let bits = |x: u32, y: u32| hash_cell(x as i32, y as i32, 0, 1);
    let texels = match is_wide {
        false => Texels::U8(Image::from_fn(size, |x, y| bits(x, y).to_le_bytes())),
        true => Texels::U16(Image::from_fn(size, |x, y| bits(x, y).to_le_bytes().map(|b| b as u16 * 257))),
    };
    let image = TextureImage { name: "noise".into(), texels, encoding, n_channels: 4 };
    let sampler = Sampler { max_anisotropy, ..Sampler::default() };
    let mut looks = Looks::default();
    let id = looks.add(Texture::Image(ImageTexture::new(&image, &Prepare::new(Usage::Color, sampler))));
    let mut look = Look::plain("bench", Constants::default());
    look.layers.push(Layer::new(id, Operator::Modulate, Target::Color));
    looks.looks.push(look);
    looks
}

fn bench(criterion: &mut Criterion) {
    let turned = batches(vec2(0.9, 0.45), vec2(-0.45, 0.9) * 1.2);
    let grazing = batches(vec2(0.9, 0.3), vec2(-1.4, 4.2));
    let mesh = mesh();
    let (mut scratch, mut out) = (Scratch::new(), Surfaces::new());
    let mut plain = looks(Encoding::Linear, false, 1);
    plain.looks[0].layers.clear();
    let cases = [
        ("no layer", plain, &turned),
        ("rgba8 linear, trilinear", looks(Encoding::Linear, false, 1), &turned),
        ("srgb8, trilinear", looks(Encoding::Srgb, false, 1), &turned),
        ("rgba16, trilinear", looks(Encoding::Linear, true, 1), &turned),
        ("srgb8, anisotropic 8, facing", looks(Encoding::Srgb, false, 8), &turned),
        ("srgb8, anisotropic 8, grazing 5:1", looks(Encoding::Srgb, false, 8), &grazing),
    ];
    for (name, looks, batches) in &cases {
        for level in ["sse2", "avx2", "avx512"] {
            let Some(level_token): Option<Level> = level_by_name(level) else { continue };
            let mut b = 0;
            criterion.bench_function(&format!("{name} ({level})"), |bencher| {
                bencher.iter(|| {
                    b = (b + 1) % batches.len();
                    let points = Points { mesh: &mesh, view: &VIEW, surfels: &batches[b], wanted: Wanted::All };
                    dispatch!(level_token, simd => evaluate(simd, (looks, 0), points, &mut scratch, &mut out));
                    black_box(&mut out);
                });
            });
        }
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
