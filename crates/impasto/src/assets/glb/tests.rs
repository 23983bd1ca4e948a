//! What is written is read back, by our reader and by crate `gltf`.

use super::*;
use crate::assets::{Image, Part, RawMesh, SceneCamera, SceneLight, Texels, TextureImage, UvSet, Values, gltf_in};
use crate::color::Encoding;
use crate::math::{Size, hash_cell, unit_float, unit_or, vec2, vec3, vec4};
use std::path::Path;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

fn again(scene: &Scene) -> Scene {
    let bytes = write(scene).unwrap();
    let report = gltf_in::read(&bytes, Path::new("again.glb"), &|_: &str| Err(std::io::ErrorKind::NotFound.into()));
    let report = report.unwrap();
    assert!(report.mended.is_empty(), "{:?}", report.mended);
    report.value
}

/// A scene that uses everything that a GLB can hold.
fn everything() -> Scene {
    let n = 40;
    let random = |i: u32, k: u32| unit_float(hash_cell(i as i32, k as i32, 0, 7)) * 2.0 - 1.0;
    let point = |i: u32, k: u32| vec3(random(i, k), random(i, k + 1), random(i, k + 2));
    let mut raw = RawMesh {
        positions: (0..n).map(|i| point(i, 0)).collect(),
        triangles: (0..n - 2).map(|i| [i, i + 1, i + 2]).collect(),
        normals: (0..n).map(|i| unit_or(point(i, 3), Vec3::Y)).collect(),
        tangents: (0..n).map(|i| unit_or(point(i, 6), Vec3::X).extend(if i % 2 == 0 { 1.0 } else { -1.0 })).collect(),
        colors: (0..n).map(|i| vec4(random(i, 9).abs(), random(i, 10).abs(), 0.5, 1.0)).collect(),
        ..RawMesh::default()
    };
    raw.uv_sets = (0..2)
        .map(|k| UvSet { name: format!("uv{k}"), uv: (0..n).map(|i| vec2(random(i, 11 + k), 0.25)).collect() })
        .collect();
    let mut heat: Vec<f32> = (0..n).map(|i| random(i, 13)).collect();
    heat[3] = f32::NAN;
    raw.fields = vec![
        Field {
            name: "heat".into(),
            unit: "K".into(),
            element: Element::Vertex,
            n_components: 1,
            values: Values::F32(heat),
        },
        Field {
            name: "_FLOW".into(),
            unit: String::new(),
            element: Element::Vertex,
            n_components: 3,
            values: Values::F32((0..3 * n).map(|i| random(i, 14)).collect()),
        },
    ];
    let part = |name: &str, triangles, material| Part { name: name.into(), triangles, material };
    raw.parts = vec![part("one", 0..10, Some(0)), part("two", 10..38, Some(1))];

    let size = Size::new(4, 4);
    let eight = Texels::U8(Image::from_fn(size, |x, y| [(x * 60) as u8, (y * 60) as u8, 7, (x * y * 20) as u8]));
    let sixteen = Texels::U16(Image::from_fn(size, |x, y| [(x * 16000) as u16, (y * 16001) as u16, 3, u16::MAX]));
    let image =
        |name: &str, texels, encoding, n_channels| TextureImage { name: name.into(), texels, encoding, n_channels };
    let transform = UvTransform { matrix: [[0.0, 2.0], [-3.0, 0.0]], offset: [0.25, -0.5] };
    let sampler = Sampler {
        wrap: [Wrap::MirroredRepeat, Wrap::ClampToEdge, Wrap::Repeat],
        mag: Filter::Nearest,
        min: MinFilter::Linear,
        max_anisotropy: 1,
    };
    let texture = |image, uv_set| Some(TextureRef { image, uv_set, sampler, transform });
    let plain =
        |image| Some(TextureRef { image, uv_set: 0, sampler: Sampler::default(), transform: UvTransform::IDENTITY });
    let first = Material {
        name: "first".into(),
        base_color: [0.5, 0.25, 1.0, 0.75],
        base_color_texture: texture(0, 1),
        normal_texture: texture(1, 0),
        normal_scale: 0.5,
        occlusion_texture: plain(1),
        occlusion_strength: 0.25,
        alpha_mode: AlphaMode::Mask(0.25),
        emission: [2.0, 1.0, 0.0],
        ..Material::default()
    };
    let second = Material {
        name: "second".into(),
        unlit: true,
        alpha_mode: AlphaMode::Blend,
        double_sided: false,
        clearcoat: crate::assets::material::Clearcoat {
            strength: 0.5,
            strength_texture: plain(1),
            roughness: 0.125,
            normal_texture: plain(1),
            normal_scale: 2.0,
            ..Default::default()
        },
        ..Material::default()
    };
    let mut scene = Scene::of("everything", raw.mend().value);
    scene.materials = vec![first, second];
    scene.images = vec![image("colour", eight, Encoding::Srgb, 4), image("data", sixteen, Encoding::Linear, 3)];
    scene.cameras = vec![SceneCamera {
        name: "eye".into(),
        world_from_camera: Mat4::from_translation(vec3(1.0, 2.0, 3.0)),
        projection: Projection::Perspective { fov_y: 0.75 },
    }];
    scene.lights = vec![
        SceneLight { name: "sun".into(), color: [4.0, 2.0, 1.0], kind: SceneLightKind::Directional(Vec3::Y) },
        SceneLight { name: "lamp".into(), color: [1.0; 3], kind: SceneLightKind::Point(vec3(1.0, 2.0, 3.0)) },
    ];
    scene
}

#[test]
fn what_is_written_is_read_back() {
    let wanted = everything();
    let got = again(&wanted);
    let (a, b) = (&wanted.mesh, &got.mesh);
    assert_eq!(a.positions(), b.positions());
    assert_eq!(a.triangles(), b.triangles());
    assert_eq!(a.normals(), b.normals());
    assert_eq!(a.tangents(), b.tangents());
    assert_eq!(a.colors(), b.colors());
    assert_eq!(a.uv_sets(), b.uv_sets());
    assert_eq!(a.parts(), b.parts());
    // The file knows attributes by their names, in the order of these.
    for field in a.fields() {
        let found = b.fields().iter().find(|f| f.name == field.name).unwrap();
        assert_eq!((&found.unit, found.n_components), (&field.unit, field.n_components));
        for i in 0..field.values.len() {
            let (x, y) = (field.values.at(i), found.values.at(i));
            assert!(x == y || x.is_nan() && y.is_nan(), "{} {i}", field.name);
        }
    }
    assert_eq!(wanted.images, got.images);
    assert_eq!(wanted.cameras, got.cameras);
    assert_eq!(wanted.lights, got.lights);
    for (m, mut n) in wanted.materials.iter().zip(got.materials) {
        // An angle's sine and cosine are not the matrix to the last bit.
        if let (Some(t), Some(u)) = (m.base_color_texture, &mut n.base_color_texture) {
            for (x, y) in t.transform.matrix.as_flattened().iter().zip(u.transform.matrix.as_flattened()) {
                assert!((x - y).abs() < 1e-6);
            }
            u.transform.matrix = t.transform.matrix;
        }
        if let (Some(t), Some(u)) = (m.normal_texture, &mut n.normal_texture) {
            u.transform.matrix = t.transform.matrix;
        }
        assert_eq!(*m, n);
    }
}

#[test]
fn another_reader_accepts_it() {
    let bytes = write(&everything()).unwrap();
    // It checks the schema, all references and the required ranges.
    let glb = gltf::Gltf::from_slice(&bytes).unwrap();
    assert_eq!(glb.meshes().count(), 1);
    assert_eq!(glb.meshes().next().unwrap().primitives().count(), 2);
    assert_eq!((glb.materials().count(), glb.images().count(), glb.cameras().count()), (2, 2, 1));
    let blob = glb.blob.as_deref().unwrap();
    for primitive in glb.meshes().next().unwrap().primitives() {
        let reader = primitive.reader(|_| Some(blob));
        assert_eq!(reader.read_positions().unwrap().count(), 40);
        let bounds = primitive.bounding_box();
        for p in reader.read_positions().unwrap() {
            assert!((0..3).all(|i| bounds.min[i] <= p[i] && p[i] <= bounds.max[i]));
        }
    }
    for view in glb.views() {
        assert_eq!(view.offset() % 4, 0);
    }
}

#[test]
fn shared_files_survive_the_way_out_and_back() {
    for file in [
        "2_gltf/FlightHelmet/FlightHelmet.gltf",
        "2_gltf/ClearCoatTest/ClearCoatTest.gltf",
        "2_gltf/AlphaBlendModeTest/AlphaBlendModeTest.glb",
    ] {
        let path = Path::new(DATA).join(file);
        let Ok(bytes) = std::fs::read(&path) else { return println!("skipped: no {path:?}") };
        let folder = path.parent().unwrap().to_owned();
        let scene = gltf_in::read(&bytes, &path, &|name: &str| std::fs::read(folder.join(name))).unwrap().value;
        let got = again(&scene);
        assert_eq!(scene.mesh.positions(), got.mesh.positions());
        assert_eq!(scene.mesh.normals(), got.mesh.normals());
        assert_eq!(scene.mesh.tangents(), got.mesh.tangents());
        assert_eq!(scene.mesh.triangles(), got.mesh.triangles());
        assert_eq!(scene.mesh.uv_sets(), got.mesh.uv_sets());
        assert_eq!(scene.materials.len(), got.materials.len());
        for (m, n) in scene.materials.iter().zip(&got.materials) {
            let pixels = |s: &Scene, t: Option<TextureRef>| {
                t.map(|t| (s.images[t.image as usize].texels.clone(), t.transform, t.uv_set))
            };
            assert_eq!(pixels(&scene, m.base_color_texture), pixels(&got, n.base_color_texture));
            assert_eq!(pixels(&scene, m.normal_texture), pixels(&got, n.normal_texture));
            assert_eq!(
                (m.base_color, m.roughness, m.metalness, m.alpha_mode),
                (n.base_color, n.roughness, n.metalness, n.alpha_mode)
            );
        }
    }
}

#[test]
fn linear_colours_are_made_srgb_and_alpha_maps_join_them() {
    let size = Size::new(2, 1);
    let image = |texels, encoding| TextureImage { name: "i".into(), texels, encoding, n_channels: 3 };
    let mut scene = Scene::of("s", everything().mesh);
    let mut raw = scene.mesh.clone().into_raw();
    raw.parts.iter_mut().for_each(|p| p.material = Some(0));
    scene.mesh = raw.mend().value;
    scene.images = vec![
        image(
            Texels::F32(Image { size, texels: vec![[0.5, 0.0, 1.0, 1.0], [2.0, f32::NAN, -1.0, 1.0]] }),
            Encoding::Linear,
        ),
        image(Texels::U8(Image { size, texels: vec![[10; 4], [20; 4]] }), Encoding::Linear),
    ];
    let plain =
        |image| Some(TextureRef { image, uv_set: 0, sampler: Sampler::default(), transform: UvTransform::IDENTITY });
    scene.materials = vec![Material { base_color_texture: plain(0), alpha_texture: plain(1), ..Material::default() }];
    let got = again(&scene);
    let Texels::U8(i) = &got.images[0].texels else { panic!("8 bits") };
    assert_eq!(i.texels, [[188, 0, 255, 10], [255, 0, 0, 20]]);
    assert_eq!(got.images[0].encoding, Encoding::Srgb);
}

#[test]
fn shear_is_refused_and_an_empty_scene_is_valid() {
    let mut scene = everything();
    if let Some(t) = &mut scene.materials[0].base_color_texture {
        t.transform.matrix = [[1.0, 1.0], [0.0, 1.0]];
    }
    assert!(write(&scene).unwrap_err().to_string().contains("shear"));
    let bytes = write(&Scene::of("empty", crate::assets::Mesh::default())).unwrap();
    assert!(gltf::Gltf::from_slice(&bytes).is_ok());
}
