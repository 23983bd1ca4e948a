//! Reading against a slow, obvious version in f64: every wrap, filter and format at random coordinates.

use crate::assets::{Filter, Image, MinFilter, Sampler, Texels, TextureImage, Wrap};
use crate::color::{Encoding, linear_from_srgb};
use crate::lookup::read::{ReadScratch, Reading};
use crate::lookup::texture::{BaseFormat, ImageTexture, Prepare, Shape, Store, Usage, cube_axes, float_from_half};
use crate::math::{BATCH, Size, hash_cell, unit_float};
use crate::par::{LEVEL_NAMES, Level, level_by_name};
use crate::placement::TexCoords;
use fearless_simd::dispatch;

const WRAPS: [Wrap; 4] = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge, Wrap::ClampToBorder];
const MINS: [MinFilter; 6] = [
    MinFilter::Nearest,
    MinFilter::Linear,
    MinFilter::NearestMipmapNearest,
    MinFilter::LinearMipmapNearest,
    MinFilter::NearestMipmapLinear,
    MinFilter::LinearMipmapLinear,
];

fn random(i: usize, k: u32) -> f32 {
    unit_float(hash_cell(i as i32, k as i32, 17, 3))
}

/// Numbers for the kinds of texels: 0 sRGB bytes, 1 bytes, 2 16 bits, 3 floats, 4 halves.
const FORMATS: [u32; 5] = [0, 1, 2, 3, 4];

fn image(size: Size, format: u32, seed: u32) -> TextureImage {
    let bits = |x: u32, y: u32, c: u32| hash_cell(x as i32, y as i32, c as i32, seed);
    let texels = match format {
        0 | 1 => Texels::U8(Image::from_fn(size, |x, y| [0, 1, 2, 3].map(|c| bits(x, y, c) as u8))),
        2 => Texels::U16(Image::from_fn(size, |x, y| [0, 1, 2, 3].map(|c| bits(x, y, c) as u16))),
        _ => Texels::F32(Image::from_fn(size, |x, y| [0, 1, 2, 3].map(|c| unit_float(bits(x, y, c))))),
    };
    let encoding = if format == 0 { Encoding::Srgb } else { Encoding::Linear };
    TextureImage { name: "noise".into(), texels, encoding, n_channels: 4 }
}

fn prepare(format: u32, sampler: Sampler) -> Prepare {
    Prepare { half: format == 4, ..Prepare::new(Usage::Color, sampler) }
}

/// A level's texel as numbers, straight from the store.
fn texel(texture: &ImageTexture, level: usize, [x, y, z]: [i64; 3]) -> [f64; 4] {
    let level = &texture.levels[level];
    let at = level.offset as i64 + z * level.slice as i64 + y * level.row as i64 + x;
    let at = at as usize;
    match &texture.store {
        Store::Srgb8(t) => {
            let [r, g, b, a] = t[at].map(|x| x as f64 / 255.0);
            [linear_from_srgb(r), linear_from_srgb(g), linear_from_srgb(b), a]
        }
        Store::Unorm8(t) => t[at].map(|x| x as f64 / 255.0),
        Store::Unorm16(t) => t[at].map(|x| x as f64 / 65535.0),
        Store::Half(t) => t[at].map(|x| float_from_half(x) as f64),
        Store::Float(t) => t[at].map(|x| x as f64),
    }
}

fn wrapped(i: i64, n: i64, wrap: Wrap) -> i64 {
    match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::MirroredRepeat => {
            let m = i.rem_euclid(2 * n);
            if m < n { m } else { 2 * n - 1 - m }
        }
        _ => i.clamp(0, n - 1),
    }
}

/// One level, filtered, by definition: wrap every texel's index.
fn level_oracle(texture: &ImageTexture, level: usize, filter: Filter, str: [f64; 3]) -> [f64; 4] {
    let n = texture.levels[level].size.map(|n| n as i64);
    let wrap = texture.sampler.wrap;
    let clamped = |a: usize| match wrap[a] {
        Wrap::ClampToEdge | Wrap::ClampToBorder => str[a].clamp(0.0, 1.0),
        _ => str[a],
    };
    let place = [0, 1, 2].map(|a| clamped(a) * n[a] as f64);
    let at = |i: [i64; 3]| texel(texture, level, [0, 1, 2].map(|a| wrapped(i[a], n[a], wrap[a])));
    if filter == Filter::Nearest {
        return at(place.map(|x| x.floor() as i64));
    }
    let lower = place.map(|x| (x - 0.5).floor());
    let mut sum = [0.0; 4];
    for corner in 0..8 {
        let step = [0, 1, 2].map(|a| (corner >> a & 1) as f64);
        let weights = [0, 1, 2].map(|a| {
            let t = place[a] - 0.5 - lower[a];
            if step[a] == 1.0 { t } else { 1.0 - t }
        });
        let weight = match texture.shape {
            Shape::Volume => weights[0] * weights[1] * weights[2],
            _ if step[2] == 1.0 => 0.0,
            _ => weights[0] * weights[1],
        };
        if weight > 0.0 {
            let deep = if texture.shape == Shape::Volume { lower[2] + step[2] } else { 0.0 };
            let value = at([(lower[0] + step[0]) as i64, (lower[1] + step[1]) as i64, deep as i64]);
            (0..4).for_each(|c| sum[c] += weight * value[c]);
        }
    }
    sum
}

/// The whole look-up by definition.
fn oracle(texture: &ImageTexture, str: [f64; 3], level: f64) -> [f64; 4] {
    let last = (texture.levels.len() - 1) as f64;
    let read = |l: f64, filter| level_oracle(texture, l.clamp(0.0, last) as usize, filter, str);
    if level <= 0.0 {
        return read(0.0, texture.sampler.mag);
    }
    let nearest = (level + 0.5).ceil() - 1.0;
    let mixed = |filter| {
        let level = level.min(last);
        let (a, b, t) = (read(level.floor(), filter), read(level.floor() + 1.0, filter), level.fract());
        std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
    };
    match texture.sampler.min {
        MinFilter::Nearest => read(0.0, Filter::Nearest),
        MinFilter::Linear => read(0.0, Filter::Linear),
        MinFilter::NearestMipmapNearest => read(nearest, Filter::Nearest),
        MinFilter::LinearMipmapNearest => read(nearest, Filter::Linear),
        MinFilter::NearestMipmapLinear => mixed(Filter::Nearest),
        MinFilter::LinearMipmapLinear => mixed(Filter::Linear),
    }
}

/// Random coordinates in [-2, 3] with footprints from magnified to the last level.
fn coords(seed: u32) -> Box<TexCoords> {
    let mut at = Box::new(TexCoords::ZERO);
    for i in 0..BATCH {
        let spread = |k: u32| random(i, seed * 64 + k) * 5.0 - 2.0;
        at.st = at.st.map_lane(i, [spread(0), spread(1)]);
        let size = crate::math::exp2(random(i, seed * 64 + 2) * 10.0 - 9.0);
        let change = |k: u32| (random(i, seed * 64 + k) - 0.5) * size;
        at.d_dx = at.d_dx.map_lane(i, [change(3), change(4)]);
        at.d_dy = at.d_dy.map_lane(i, [change(5), change(6)]);
        at.r = at.r.map_lane(i, [spread(7), change(8), change(9)]);
    }
    at
}

trait MapLane<const N: usize> {
    fn map_lane(self, i: usize, values: [f32; N]) -> Self;
}
impl<const N: usize> MapLane<N> for [crate::math::Lane; N] {
    fn map_lane(mut self, i: usize, values: [f32; N]) -> Self {
        self.iter_mut().zip(values).for_each(|(lane, v)| lane[i] = v);
        self
    }
}

fn read(level: Level, texture: &ImageTexture, at: &TexCoords, n: usize) -> Box<Reading> {
    let (mut scratch, mut out) = (Box::new(ReadScratch::ZERO), Box::new(Reading::ZERO));
    dispatch!(level, simd => texture.read(simd, at, n, &mut scratch, &mut out));
    out
}

/// log2 of the longer edge in texels.
fn true_level(texture: &ImageTexture, at: &TexCoords, i: usize) -> f64 {
    let [w, h, d] = texture.levels[0].size.map(|n| n as f64);
    let deep = if texture.shape == Shape::Volume { d } else { 0.0 };
    let h = if texture.shape == Shape::Line { 0.0 } else { h };
    let length = |d: &[crate::math::Lane; 2], r: f32| {
        let (x, y, z) = (d[0][i] as f64 * w, d[1][i] as f64 * h, r as f64 * deep);
        (x * x + y * y + z * z).sqrt()
    };
    length(&at.d_dx, at.r[1][i]).max(length(&at.d_dy, at.r[2][i])).log2()
}

fn check(texture: &ImageTexture, at: &TexCoords, tolerance: f64, what: &str) {
    let got = read(Level::new(), texture, at, BATCH);
    let mut n_compared = 0;
    for i in 0..BATCH {
        let str = [at.st[0][i] as f64, at.st[1][i] as f64, at.r[0][i] as f64];
        let level = true_level(texture, at, i);
        // Where a nearest texel or level changes, rounding decides; elsewhere all must agree.
        let edge = |x: f64| (x - x.round()).abs() < 1e-3;
        let near_level = [level, level + 0.5].into_iter().any(edge);
        let near_texel =
            (0..texture.levels.len()).any(|l| (0..3).any(|a| edge(str[a] * texture.levels[l].size[a] as f64)));
        let has_nearest = texture.sampler.mag == Filter::Nearest
            || !matches!(texture.sampler.min, MinFilter::Linear | MinFilter::LinearMipmapLinear);
        if near_level || (near_texel && has_nearest) {
            continue;
        }
        n_compared += 1;
        let want = oracle(texture, str, level);
        for c in 0..4 {
            let error = (got.rgba[c][i] as f64 - want[c]).abs();
            assert!(error < tolerance, "{what}, point {i}, level {level}: {} not {}", got.rgba[c][i], want[c]);
        }
    }
    assert!(n_compared > BATCH / 2, "{what}: hardly a point compared");
}

#[test]
fn every_wrap_filter_and_format_agrees_with_the_definition() {
    for (w, &wrap) in WRAPS.iter().enumerate() {
        for &min in &MINS {
            for mag in [Filter::Nearest, Filter::Linear] {
                for format in FORMATS {
                    for size in [Size::new(16, 32), Size::new(13, 7), Size::new(11, 1)] {
                        let other = WRAPS[(w + format as usize) % 4];
                        let sampler = Sampler { wrap: [wrap, other, other], mag, min, max_anisotropy: 1 };
                        let texture = ImageTexture::new(&image(size, format, 5), &prepare(format, sampler));
                        // The packed way rounds to bytes after each of three steps and has 8-bit weights.
                        let tolerance = if format == 1 { 0.012 } else { 3e-4 };
                        let what = format!("{wrap:?}/{other:?} {min:?} {mag:?} format {format} {size}");
                        check(&texture, &coords(format), tolerance, &what);
                    }
                }
            }
        }
    }
}

#[test]
fn volumes_agree_with_the_definition() {
    for &wrap in &WRAPS {
        for &min in &MINS {
            for format in FORMATS {
                let sampler = Sampler { wrap: [wrap; 3], mag: Filter::Linear, min, max_anisotropy: 1 };
                let slices: Vec<_> = (0..5).map(|z| image(Size::new(6, 8), format, z)).collect();
                let texture = ImageTexture::volume(&slices, &prepare(format, sampler)).expect("equal slices");
                assert_eq!(texture.shape(), Shape::Volume);
                check(&texture, &coords(9), 3e-4, &format!("{wrap:?} {min:?} format {format}"));
            }
        }
    }
}

#[test]
fn cubes_are_continuous_across_their_edges() {
    // Each face shows the direction itself.
    let n = 32;
    let face = |f: usize| {
        let texel = |x: u32, y: u32| {
            let place = [x, y].map(|i| (i as f32 + 0.5) / n as f32);
            let d = crate::lookup::texture::cube_direction(f, place);
            let d = crate::math::vec3(d[0], d[1], d[2]).normalize();
            [d.x, d.y, d.z, 1.0]
        };
        let texels = Texels::F32(Image::from_fn(Size::new(n, n), texel));
        TextureImage { name: format!("face {f}"), texels, encoding: Encoding::Linear, n_channels: 4 }
    };
    let faces: Vec<_> = (0..6).map(face).collect();
    let sampler = Sampler { max_anisotropy: 1, ..Sampler::default() };
    let texture = ImageTexture::cube(&faces, &Prepare::new(Usage::Data, sampler)).expect("six squares");
    let mut at = coords(4);
    let mut n_near_edge = 0;
    for i in 0..BATCH {
        let d = [0, 1, 2].map(|k| random(i, k) * 2.0 - 1.0);
        // Every second point lies close to an edge between two faces.
        let d = if i % 2 == 0 { [d[0], d[0] * (1.0 + d[2] * 0.04), d[1] * d[0]] } else { d };
        at.st = at.st.map_lane(i, [d[0], d[1]]);
        at.r = at.r.map_lane(i, [d[2], 0.0, 0.0]);
        at.d_dx = at.d_dx.map_lane(i, [1e-4, 0.0]);
        at.d_dy = at.d_dy.map_lane(i, [0.0, 1e-4]);
        n_near_edge += (cube_axes(d).0 != cube_axes([d[0] * 0.95, d[1], d[2]]).0) as usize;
    }
    assert!(n_near_edge > 10);
    let got = read(Level::new(), &texture, &at, BATCH);
    for i in 0..BATCH {
        let want = crate::math::vec3(at.st[0][i], at.st[1][i], at.r[0][i]).normalize();
        let got = crate::math::vec3(got.rgba[0][i], got.rgba[1][i], got.rgba[2][i]);
        assert!((got - want).length() < 0.035, "{got} not {want}");
    }
}

#[test]
fn outside_of_a_border_texture_nothing_is_applied() {
    let wrap = [Wrap::ClampToBorder, Wrap::Repeat, Wrap::Repeat];
    let sampler = Sampler { wrap, max_anisotropy: 1, ..Sampler::default() };
    let texture = ImageTexture::new(&image(Size::new(8, 8), 1, 2), &prepare(1, sampler));
    let mut at = TexCoords::ZERO;
    at.st[0][..6].copy_from_slice(&[-0.01, 0.0, 0.5, 1.0, 1.01, f32::NAN]);
    at.st[1][..6].copy_from_slice(&[0.5, -3.0, 9.0, 0.5, 0.5, 0.5]);
    let got = read(Level::new(), &texture, &at, 6);
    assert!(!got.is_whole);
    assert_eq!(got.applied[..6], [0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
}

/// A long footprint keeps what lies across it and averages what lies along it.
#[test]
fn anisotropic_reading_is_sharp_across_the_axis() {
    // Stripes of 2 texels, seen under footprints of 16 texels by 1, along and across, upright and turned.
    let size = Size::new(64, 64);
    let stripes = |turned: bool| {
        let texel = |x: u32, y: u32| [if (if turned { x + y } else { x }) / 2 % 2 == 0 { 255 } else { 0 }; 4];
        let texels = Texels::U8(Image::from_fn(size, texel));
        TextureImage { name: "stripes".into(), texels, encoding: Encoding::Srgb, n_channels: 3 }
    };
    let contrast = |turned: bool, along: [f32; 2], across: [f32; 2], max_anisotropy: u8| {
        let sampler = Sampler { max_anisotropy, ..Sampler::default() };
        let texture = ImageTexture::new(&stripes(turned), &Prepare::new(Usage::Color, sampler));
        let mut at = TexCoords::ZERO;
        for i in 0..64 {
            at.st = at.st.map_lane(i, [(i as f32 + 0.5) / 64.0, 0.5 + 0.5 / 64.0]);
            // Not the axes themselves, but a sheared pair that spans the same ellipse.
            let [p, q] = [0.8, 0.6];
            let edge = |p: f32, q: f32| [(along[0] * p + across[0] * q) / 64.0, (along[1] * p + across[1] * q) / 64.0];
            at.d_dx = at.d_dx.map_lane(i, edge(p, q));
            at.d_dy = at.d_dy.map_lane(i, edge(-q, p));
        }
        let got = read(Level::new(), &texture, &at, 64);
        let values = &got.rgba[0][..64];
        values.iter().copied().fold(0.0, f32::max) - values.iter().copied().fold(1.0, f32::min)
    };
    let d = std::f32::consts::FRAC_1_SQRT_2;
    assert!(contrast(false, [0.0, 16.0], [1.0, 0.0], 16) > 0.9);
    assert!(contrast(false, [0.0, 16.0], [1.0, 0.0], 1) < 0.2);
    assert!(contrast(false, [16.0, 0.0], [0.0, 1.0], 16) < 0.1);
    assert!(contrast(true, [16.0 * d, -16.0 * d], [d, d], 16) > 0.5);
    assert!(contrast(true, [16.0 * d, 16.0 * d], [d, -d], 16) < 0.1);
}

/// All kinds of reading, for laws that hold for each.
fn all_kinds() -> Vec<ImageTexture> {
    let mut kinds = Vec::new();
    for format in FORMATS {
        for (max_anisotropy, wrap) in [(1, WRAPS), (9, [WRAPS[1], WRAPS[0], WRAPS[3], WRAPS[2]])] {
            let sampler = Sampler { wrap: [wrap[0], wrap[1], wrap[2]], max_anisotropy, ..Sampler::default() };
            kinds.push(ImageTexture::new(&image(Size::new(37, 20), format, 1), &prepare(format, sampler)));
        }
        let how = prepare(format, Sampler::default());
        let squares: Vec<_> = (0..6).map(|f| image(Size::new(8, 8), format, f)).collect();
        kinds.push(ImageTexture::cube(&squares, &how).expect("six squares"));
        kinds.push(ImageTexture::volume(&squares, &how).expect("equal slices"));
    }
    kinds
}

#[test]
fn every_simd_level_and_batch_size_gives_the_same_bits() {
    for (k, texture) in all_kinds().iter().enumerate() {
        let at = coords(k as u32);
        let want = read(level_by_name("scalar").expect("always there"), texture, &at, BATCH);
        for level in LEVEL_NAMES.into_iter().filter_map(level_by_name) {
            let got = read(level, texture, &at, BATCH);
            for c in 0..4 {
                assert_eq!(got.rgba[c].map(f32::to_bits), want.rgba[c].map(f32::to_bits), "texture {k} at {level:?}");
            }
        }
        for i in (0..BATCH).step_by(5) {
            let mut one = coords(99);
            one.st = one.st.map_lane(0, [at.st[0][i], at.st[1][i]]);
            one.d_dx = one.d_dx.map_lane(0, [at.d_dx[0][i], at.d_dx[1][i]]);
            one.d_dy = one.d_dy.map_lane(0, [at.d_dy[0][i], at.d_dy[1][i]]);
            one.r = one.r.map_lane(0, [at.r[0][i], at.r[1][i], at.r[2][i]]);
            let got = read(Level::new(), texture, &one, 1);
            let bits = |r: &Reading, i: usize| [0, 1, 2, 3].map(|c| r.rgba[c][i].to_bits());
            assert_eq!(bits(&got, 0), bits(&want, i), "texture {k} alone");
        }
    }
}

#[test]
fn strange_coordinates_never_leave_the_texture() {
    let odd =
        [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e9, -3e9, 1e-40, -1e-9, 0.0, 1.0, 16777215.5];
    let mut at = TexCoords::ZERO;
    for round in 0..8 {
        for i in 0..BATCH {
            let pick = |k: u32| odd[hash_cell(i as i32, k as i32, round, 1) as usize % odd.len()];
            at.st = at.st.map_lane(i, [pick(0), pick(1)]);
            at.d_dx = at.d_dx.map_lane(i, [pick(2), pick(3)]);
            at.d_dy = at.d_dy.map_lane(i, [pick(4), pick(5)]);
            at.r = at.r.map_lane(i, [pick(6), pick(7), pick(8)]);
        }
        for texture in all_kinds() {
            for level in LEVEL_NAMES.into_iter().filter_map(level_by_name) {
                let got = read(level, &texture, &at, BATCH);
                assert!(got.rgba.iter().flatten().all(|x| (0.0..=1.0001).contains(x)));
            }
        }
    }
}

#[test]
fn single_numbers_go_where_their_format_says() {
    let grey = TextureImage { n_channels: 1, ..image(Size::new(4, 4), 1, 1) };
    let Texels::U8(texels) = &grey.texels else { unreachable!() };
    let v = texels.at(0, 0)[0] as f32 / 255.0;
    let cases = [
        (None, BaseFormat::Luminance, [v, v, v, 1.0]),
        (Some(BaseFormat::Alpha), BaseFormat::Alpha, [0.0, 0.0, 0.0, v]),
        (Some(BaseFormat::Intensity), BaseFormat::Intensity, [v; 4]),
    ];
    for (format, want, rgba) in cases {
        let sampler = Sampler { mag: Filter::Nearest, max_anisotropy: 1, ..Sampler::default() };
        let texture = ImageTexture::new(&grey, &Prepare { format, ..prepare(1, sampler) });
        assert_eq!(texture.format(), want);
        let got = read(Level::new(), &texture, &TexCoords::ZERO, 1);
        (0..4).for_each(|c| assert!((got.rgba[c][0] - rgba[c]).abs() < 1e-6, "{want:?}"));
    }
}

#[test]
fn textures_that_cannot_be_are_refused_or_black() {
    let how = prepare(1, Sampler::default());
    assert!(ImageTexture::volume(&[], &how).is_err());
    let square = image(Size::new(4, 4), 1, 1);
    assert!(ImageTexture::cube(&vec![square.clone(); 5], &how).is_err());
    let mut six = vec![square; 6];
    six[3] = image(Size::new(8, 8), 1, 1);
    assert!(ImageTexture::cube(&six, &how).is_err());
    let empty = ImageTexture::new(&image(Size::new(0, 0), 1, 1), &how);
    assert_eq!(read(Level::new(), &empty, &coords(1), BATCH).rgba[0], [0.0; BATCH]);
}
