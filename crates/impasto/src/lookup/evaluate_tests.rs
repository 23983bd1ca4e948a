//! Stacks of layers: laws, closed forms, and materials of scenes.

use crate::assets::{
    AlphaMode, Image, Material, Mesh, RawMesh, Sampler, Scene, Texels, TextureImage, TextureRef, UvSet,
};
use crate::assets::{Filter, Part, UvTransform};
use crate::color::Encoding;
use crate::lookup::*;
use crate::math::{BATCH, Lane, Mat4, Size, Vec2, Vec3, Vec4, hash_cell, unit_float, vec2, vec3, vec4};
use crate::par::{LEVEL_NAMES, Level, level_by_name};
use crate::placement::{Placement, Surfels, Viewpoint};
use fearless_simd::dispatch;

const VIEW: Viewpoint = Viewpoint { eye_from_world: Mat4::IDENTITY, eye: vec3(0.0, 0.0, 5.0), parallel: None };

fn random(i: usize, k: u32) -> f32 {
    unit_float(hash_cell(i as i32, k as i32, 5, 11))
}

/// A unit square in the xy plane, u to the right, v down.
fn square(has_tangents: bool) -> Mesh {
    let positions = vec![vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(0.0, 1.0, 0.0)];
    let uv = positions.iter().map(|p| vec2(p.x, 1.0 - p.y)).collect::<Vec<Vec2>>();
    RawMesh {
        normals: vec![Vec3::Z; 4],
        tangents: if has_tangents { vec![vec4(1.0, 0.0, 0.0, 1.0); 4] } else { Vec::new() },
        colors: vec![Vec4::splat(0.5); 4],
        positions,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uv_sets: vec![UvSet { name: "uv0".into(), uv }],
        ..RawMesh::default()
    }
    .mend()
    .value
}

/// Random points of the square with small footprints, half of them seen from behind.
fn points_on_square(n: usize) -> Box<Surfels> {
    let mut surfels = Surfels::new(1);
    surfels.n = n;
    for i in 0..n {
        let (x, y, step) = (random(i, 0), random(i, 1), 0.002 + 0.02 * random(i, 2));
        surfels.triangle[i] = (y > x) as u32;
        surfels.position[0][i] = x;
        surfels.position[1][i] = y;
        surfels.position[2][i] = 0.0;
        surfels.side[i] = if i % 2 == 0 { 1.0 } else { -1.0 };
        // Barycentrics of corners 1, 2 (triangle 0) and 2, 3 (triangle 1), and their change for a step in x and -y.
        let (b, d) = match y > x {
            false => ([x - y, y], [[step, 0.0], [step, -step]]),
            true => ([x, y - x], [[step, -step], [0.0, -step]]),
        };
        for k in 0..2 {
            surfels.barycentric[k][i] = b[k];
            (0..2).for_each(|axis| surfels.d_barycentric[axis][k][i] = d[axis][k]);
        }
        let set = |lanes: &mut [Lane], values: &[f32]| lanes.iter_mut().zip(values).for_each(|(l, v)| l[i] = *v);
        set(&mut surfels.normal, &[0.0, 0.0, 1.0]);
        set(&mut surfels.tangent, &[1.0, 0.0, 0.0, 1.0]);
        set(&mut surfels.color, &[0.5; 4]);
        set(&mut surfels.view, &[0.0, 0.0, 1.0]);
        let uv = &mut surfels.uv[0];
        set(&mut uv.st, &[x, 1.0 - y]);
        set(&mut uv.d_dx, &[step, 0.0]);
        set(&mut uv.d_dy, &[0.0, step]);
    }
    surfels
}

fn image(size: Size, n_channels: u8, encoding: Encoding, texel: impl Fn(u32, u32) -> [u8; 4]) -> TextureImage {
    TextureImage { name: "test".into(), texels: Texels::U8(Image::from_fn(size, texel)), encoding, n_channels }
}

fn noise(n_channels: u8, seed: i32) -> TextureImage {
    image(Size::new(32, 32), n_channels, Encoding::Linear, |x, y| {
        let hash = hash_cell(x as i32, y as i32, 0, seed as u32).to_le_bytes();
        let alpha = if matches!(n_channels, 2 | 4) { hash[3] } else { 255 };
        if n_channels < 3 { [hash[0], hash[0], hash[0], alpha] } else { [hash[0], hash[1], hash[2], alpha] }
    })
}

fn flat(texel: [u8; 4], n_channels: u8) -> TextureImage {
    image(Size::new(2, 2), n_channels, Encoding::Linear, |_, _| texel)
}

fn texture(image: &TextureImage, usage: Usage) -> Texture {
    Texture::Image(ImageTexture::new(image, &Prepare::new(usage, Sampler::default())))
}

fn evaluated(level: Level, looks: &Looks, mesh: &Mesh, surfels: &Surfels) -> Box<Surfaces> {
    let (mut scratch, mut out) = (Scratch::new(), Surfaces::new());
    let points = Points { mesh, view: &VIEW, surfels, wanted: Wanted::All };
    dispatch!(level, simd => evaluate(simd, (looks, 0), points, &mut scratch, &mut out));
    out
}

fn wearing(textures: Vec<Texture>, look: Look) -> Looks {
    Looks { textures, looks: vec![look], look_of_part: vec![0] }
}

/// Twelve layers that use every kind of texture, operator and target.
fn rich_look() -> Looks {
    let textures = vec![
        texture(&noise(4, 1), Usage::Color),
        texture(&noise(3, 2), Usage::Normal),
        texture(&noise(1, 3), Usage::Slope),
        texture(&noise(2, 4), Usage::Data),
        Texture::Table(ColorTable::named("viridis").expect("known")),
        Texture::Procedural(Procedural {
            pattern: Pattern::Marble { bend: 1.0 },
            frequency: [5.0; 3],
            colors: [[0.1, 0.2, 0.3, 0.5], [0.9, 0.8, 0.7, 1.0]],
            seed: 4,
        }),
    ];
    let layer = |texture, operator, target| Layer::new(TextureId(texture), operator, target);
    let mut look = Look::plain("rich", Constants { roughness: 0.4, coat: 0.5, ..Constants::default() });
    look.alpha_mode = AlphaMode::Blend;
    look.uses_vertex_colors = true;
    look.layers = vec![
        layer(0, Operator::Modulate, Target::Color),
        Layer {
            channels: [Channel::Green, Channel::One, Channel::Zero, Channel::Red],
            ..layer(3, Operator::Replace, Target::Roughness)
        },
        layer(3, Operator::Modulate, Target::Metalness),
        Layer { strength: 0.5, ..layer(3, Operator::Modulate, Target::Occlusion) },
        Layer {
            placement: Placement::Position { unit: crate::placement::PositionUnit::Model },
            ..layer(4, Operator::Over, Target::Color)
        },
        layer(5, Operator::Blend([0.2, 0.4, 0.6, 0.8]), Target::Color),
        layer(5, Operator::Add, Target::Emission),
        layer(1, Operator::Replace, Target::Normal { scale: 0.7 }),
        layer(2, Operator::Replace, Target::Bump { scale: 0.01 }),
        layer(5, Operator::Replace, Target::Bump { scale: 0.05 }),
        layer(1, Operator::Replace, Target::CoatNormal { scale: 0.3 }),
        layer(0, Operator::AlphaTest(Compare::Greater, 0.3), Target::Color),
        layer(3, Operator::Replace, Target::Height { scale: 2.0 }),
        layer(0, Operator::Replace, Target::Info),
    ];
    wearing(textures, look)
}

fn lanes(s: &Surfaces) -> Vec<&Lane> {
    let numbers = [&s.alpha, &s.roughness, &s.metalness, &s.occlusion, &s.coat, &s.coat_roughness, &s.height];
    let vectors = [&s.color, &s.normal, &s.emission, &s.coat_normal];
    numbers.into_iter().chain(vectors.into_iter().flatten()).chain(&s.info).collect()
}

#[test]
fn a_points_answer_depends_on_nothing_but_the_point() {
    let looks = rich_look();
    for mesh in [square(true), square(false)] {
        let surfels = points_on_square(251);
        let want = evaluated(level_by_name("scalar").expect("always there"), &looks, &mesh, &surfels);
        assert!(lanes(&want).iter().all(|lane| lane[..251].iter().all(|x| x.is_finite())));
        for level in LEVEL_NAMES.into_iter().filter_map(level_by_name) {
            let got = evaluated(level, &looks, &mesh, &surfels);
            for (k, (a, b)) in lanes(&got).into_iter().zip(lanes(&want)).enumerate() {
                assert!((0..251).all(|i| a[i].to_bits() == b[i].to_bits()), "lane {k} at {level:?}");
            }
        }
        // One at a time, as the probe asks; the other lanes hold what was there before.
        let mut one = points_on_square(64);
        one.n = 1;
        for i in (0..251).step_by(9) {
            let all = points_on_square(251);
            let copy = |to: &mut [Lane], from: &[Lane]| to.iter_mut().zip(from).for_each(|(t, f)| t[0] = f[i]);
            one.triangle[0] = all.triangle[i];
            one.side[0] = all.side[i];
            copy(&mut one.position, &all.position);
            copy(&mut one.barycentric, &all.barycentric);
            (0..2).for_each(|k| copy(&mut one.d_barycentric[k], &all.d_barycentric[k]));
            copy(&mut one.uv[0].st, &all.uv[0].st);
            copy(&mut one.uv[0].d_dx, &all.uv[0].d_dx);
            copy(&mut one.uv[0].d_dy, &all.uv[0].d_dy);
            let got = evaluated(Level::new(), &looks, &mesh, &one);
            for (k, (a, b)) in lanes(&got).into_iter().zip(lanes(&want)).enumerate() {
                assert_eq!(a[0].to_bits(), b[i].to_bits(), "lane {k}, point {i} alone");
            }
        }
    }
}

#[test]
fn alpha_alone_is_the_same_alpha() {
    let mut looks = rich_look();
    let (mesh, surfels) = (square(true), points_on_square(200));
    for mode in [AlphaMode::Opaque, AlphaMode::Mask(0.4), AlphaMode::Blend] {
        looks.looks[0].alpha_mode = mode;
        let want = evaluated(Level::new(), &looks, &mesh, &surfels);
        let mut got = [7.0; BATCH];
        let points = Points { mesh: &mesh, view: &VIEW, surfels: &surfels, wanted: Wanted::All };
        dispatch!(Level::new(), simd => alpha_of(simd, (&looks, 0), points, &mut Scratch::new(), &mut got));
        assert_eq!(got[..200], want.alpha[..200], "{mode:?}");
        let n_gone = want.alpha[..200].iter().filter(|&&a| a == 0.0).count();
        assert!(n_gone > 20 && n_gone < 180, "the alpha test should hit some points, not {n_gone}");
        assert_eq!(got[200..], [7.0; BATCH - 200]);
    }
}

/// A map that is tilted the same way everywhere bends normals along the tangent frame, and the other way from behind.
#[test]
fn tilted_maps_bend_normals_along_the_frame() {
    let tilted = flat([204, 153, 230, 255], 3);
    let want = (vec3(204.0, 153.0, 230.0) / 255.0 * 2.0 - 1.0).normalize();
    for has_tangents in [true, false] {
        let layer = Layer::new(TextureId(0), Operator::Replace, Target::Normal { scale: 1.0 });
        let look = Look { layers: vec![layer], ..Look::plain("tilted", Constants::default()) };
        let looks = wearing(vec![texture(&tilted, Usage::Normal)], look);
        let out = evaluated(Level::new(), &looks, &square(has_tangents), &points_on_square(50));
        for i in 0..50 {
            let got = vec3(out.normal[0][i], out.normal[1][i], out.normal[2][i]);
            let want = if i % 2 == 0 { want } else { -want };
            assert!((got - want).length() < 1e-3, "tangents {has_tangents}: {got} not {want}");
            assert_eq!(out.roughness[i], 1.0);
        }
    }
}

/// Heights that grow to the right tilt the normal to the left; those that grow downwards, up.
#[test]
fn slopes_tilt_the_normal_against_the_rise() {
    let size = Size::new(64, 64);
    for (to_right, normal_xy) in [(true, vec2(-1.0, 0.0)), (false, vec2(0.0, 1.0))] {
        let ramp = image(size, 1, Encoding::Linear, |x, y| [if to_right { x as u8 } else { y as u8 } * 2; 4]);
        let sampler = Sampler { wrap: [crate::assets::Wrap::ClampToEdge; 3], ..Sampler::default() };
        for usage in [Usage::Slope, Usage::Data] {
            let texture = Texture::Image(ImageTexture::new(&ramp, &Prepare::new(usage, sampler)));
            let layer = Layer::new(TextureId(0), Operator::Replace, Target::Bump { scale: 1.0 });
            let look = Look { layers: vec![layer], ..Look::plain("ramp", Constants::default()) };
            let mut surfels = points_on_square(40);
            // Away from the edge, where the ramp ends.
            surfels.uv[0].st.iter_mut().flatten().for_each(|x| *x = 0.1 + 0.8 * *x);
            let out = evaluated(Level::new(), &wearing(vec![texture], look), &square(true), &surfels);
            // 2/255 a texel, 64 texels a width.
            let slope = 128.0 / 255.0;
            let want = vec3(normal_xy.x * slope, normal_xy.y * slope, 1.0).normalize();
            for i in (0..40).step_by(2) {
                let got = vec3(out.normal[0][i], out.normal[1][i], out.normal[2][i]);
                assert!((got - want).length() < 0.02, "{usage:?} {to_right}: {got} not {want}");
            }
        }
    }
}

#[test]
fn rough_maps_seen_from_afar_widen_roughness() {
    let ridges =
        image(Size::new(64, 64), 3, Encoding::Linear, |x, _| [if x % 2 == 0 { 200 } else { 55 }, 128, 230, 255]);
    let layer = Layer::new(TextureId(0), Operator::Replace, Target::Normal { scale: 1.0 });
    let constants = Constants { roughness: 0.2, ..Constants::default() };
    let looks =
        wearing(vec![texture(&ridges, Usage::Normal)], Look { layers: vec![layer], ..Look::plain("", constants) });
    let mut surfels = points_on_square(10);
    let roughness = |surfels: &Surfels| evaluated(Level::new(), &looks, &square(true), surfels).roughness[0];
    let uv = &mut surfels.uv[0];
    [&mut uv.d_dx[0], &mut uv.d_dy[1]].into_iter().for_each(|lane| lane.fill(1e-4));
    assert_eq!(roughness(&surfels), 0.2);
    surfels.uv[0].d_dx[0].fill(0.1);
    surfels.uv[0].d_dy[1].fill(0.1);
    assert!(roughness(&surfels) > 0.5);
}

#[test]
fn borders_leave_what_was_there() {
    let sampler = Sampler { wrap: [crate::assets::Wrap::ClampToBorder; 3], ..Sampler::default() };
    let red = flat([255, 0, 0, 255], 3);
    let red = Texture::Image(ImageTexture::new(&red, &Prepare::new(Usage::Color, sampler)));
    let layer = Layer {
        matrix: Mat4::from_scale(vec3(2.0, 2.0, 1.0)),
        ..Layer::new(TextureId(0), Operator::Replace, Target::Color)
    };
    let look = Look { layers: vec![layer], ..Look::plain("label", Constants::default()) };
    let surfels = points_on_square(100);
    let out = evaluated(Level::new(), &wearing(vec![red], look), &square(true), &surfels);
    for i in 0..100 {
        let is_inside = surfels.uv[0].st[0][i] <= 0.5 && surfels.uv[0].st[1][i] <= 0.5;
        assert_eq!([out.color[0][i], out.color[1][i]], if is_inside { [1.0, 0.0] } else { [1.0, 1.0] });
    }
}

#[test]
fn materials_become_stacks() {
    let reference =
        |image: u32| TextureRef { image, uv_set: 0, sampler: Sampler::default(), transform: UvTransform::IDENTITY };
    let material = Material {
        base_color: [1.0, 0.5, 1.0, 1.0],
        base_color_texture: Some(reference(0)),
        metalness: 0.5,
        roughness: 0.8,
        metal_rough_texture: Some(reference(1)),
        occlusion_texture: Some(reference(1)),
        occlusion_strength: 0.5,
        emission: [2.0, 0.0, 0.0],
        emission_texture: Some(reference(0)),
        normal_texture: Some(TextureRef { uv_set: 3, ..reference(2) }),
        alpha_mode: AlphaMode::Blend,
        ..Material::default()
    };
    let mut mesh = square(true).into_raw();
    mesh.colors = Vec::new();
    let part = |triangles, material| Part { name: String::new(), triangles, material };
    mesh.parts = vec![part(0..1, Some(0)), part(1..2, None)];
    let mut scene = Scene::of("test", mesh.mend().value);
    scene.materials = vec![material];
    let color = TextureImage { encoding: Encoding::Srgb, ..flat([255, 188, 0, 51], 4) };
    scene.images = vec![color, flat([102, 51, 204, 255], 3)];
    let looks = Looks::from_scene(&scene);
    assert_eq!(looks.look_of_part, [0, 1]);
    // The texture of two targets is prepared once, and the image and UV set that are not there are left out.
    assert_eq!((looks.textures.len(), looks.looks[0].layers.len()), (2, 5));
    let out = evaluated(Level::new(), &looks, &scene.mesh, &points_on_square(3));
    let close = |got: f32, want: f32| assert!((got - want).abs() < 2e-3, "{got} not {want}");
    [1.0, 0.25, 0.0].into_iter().enumerate().for_each(|(c, want)| close(out.color[c][1], want));
    close(out.alpha[1], 0.2);
    close(out.roughness[1], 0.8 * 0.2);
    close(out.metalness[1], 0.5 * 0.8);
    close(out.occlusion[1], 1.0 + 0.5 * (0.4 - 1.0));
    close(out.emission[0][1], 2.0);
    let needs = looks.needs();
    assert!(needs.normal && needs.uv_sets == 1 && !needs.tangent && !needs.color);
    assert!(!looks.is_opaque() && looks.look_of_part(1).is_opaque());
}

#[test]
fn vertex_colours_multiply_and_constants_stand_alone() {
    let mut look = Look::plain("plain", Constants { color: [0.5, 1.0, 0.25, 0.5], ..Constants::default() });
    look.alpha_mode = AlphaMode::Blend;
    let of = |look: &Look| {
        let out = evaluated(Level::new(), &wearing(vec![], look.clone()), &square(true), &points_on_square(2));
        [out.color[0][1], out.color[1][1], out.color[2][1], out.alpha[1]]
    };
    assert_eq!(of(&look), [0.5, 1.0, 0.25, 0.5]);
    look.uses_vertex_colors = true;
    assert_eq!(of(&look), [0.25, 0.5, 0.125, 0.25]);
    // A layer whose texture or UV set is not there is left out.
    look.layers = vec![Layer::new(TextureId(9), Operator::Replace, Target::Color)];
    assert_eq!(of(&look), [0.25, 0.5, 0.125, 0.25]);
    let sampler = Sampler { mag: Filter::Nearest, ..Sampler::default() };
    let texture = Texture::Image(ImageTexture::new(&flat([0; 4], 4), &Prepare::new(Usage::Color, sampler)));
    look.layers =
        vec![Layer { placement: Placement::Uv(5), ..Layer::new(TextureId(0), Operator::Replace, Target::Color) }];
    let out = evaluated(Level::new(), &wearing(vec![texture], look), &square(true), &points_on_square(2));
    assert_eq!(out.color[0][1], 0.25);
}
