//! Documents made here, and the real ones in the shared data.

use super::*;
use crate::assets::{AlphaMode, Filter, SceneLightKind, Texels, Wrap};
use crate::color::Encoding;
use crate::math::{Projection, Vec3, vec2, vec3};
use serde_json::json;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

/// Reads a file of the shared data with its neighbours; none (and a line) when the data is missing.
fn load(file: &str) -> Option<Result<Report<Scene>>> {
    let path = Path::new(DATA).join(file);
    if !Path::new(DATA).exists() {
        println!("skipped: no {DATA}");
        return None;
    }
    let bytes = std::fs::read(&path).unwrap();
    let folder = path.parent().unwrap().to_owned();
    Some(read(&bytes, Path::new(file), &|name: &str| std::fs::read(folder.join(name))))
}

fn nothing(_: &str) -> std::io::Result<Vec<u8>> {
    Err(std::io::ErrorKind::NotFound.into())
}

fn parse(json: &Value) -> Result<Report<Scene>> {
    read(json.to_string().as_bytes(), Path::new("made.gltf"), &nothing)
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |bits: u32, k: usize| DIGITS[(bits >> (18 - 6 * k) & 63) as usize] as char;
    bytes
        .chunks(3)
        .flat_map(|c| {
            let bits = c.iter().fold(0, |b, &x| b << 8 | x as u32) << (8 * (3 - c.len()));
            (0..4).map(move |k| if k <= c.len() { digit(bits, k) } else { '=' })
        })
        .collect()
}

/// A document of one triangle in the plane z = 0 with normals +Z and tangents +X, under the given node.
fn triangle(node: Value) -> Value {
    let mut bytes: Vec<u8> = Vec::new();
    let mut put = |numbers: &[f32]| numbers.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    put(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    put(&[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    put(&[1., 0., 0., 1., 1., 0., 0., 1., 1., 0., 0., 1.]);
    let accessor = |offset: usize, kind: &str| json!({"bufferView": 0, "byteOffset": offset, "componentType": 5126, "count": 3, "type": kind});
    json!({
        "asset": {"version": "2.0"},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [node],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TANGENT": 2}}]}],
        "accessors": [accessor(0, "VEC3"), accessor(36, "VEC3"), accessor(72, "VEC4")],
        "bufferViews": [{"buffer": 0, "byteLength": bytes.len()}],
        "buffers": [{"byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{}", base64(&bytes))}]
    })
}

fn has_note(report: &Report<Scene>, part: &str) -> bool {
    report.mended.iter().any(|m| m.what.contains(part))
}

#[test]
fn every_shared_file_gives_a_scene_or_one_line() {
    if !Path::new(DATA).exists() {
        return println!("skipped: no {DATA}");
    }
    let mut files = Vec::new();
    for folder in ["2_gltf", "7_bad_input/assimp_gltf", "7_bad_input/draco_UnusedTexCoords"] {
        let mut folders = vec![Path::new(DATA).join(folder)];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
                if entry.is_dir() {
                    folders.push(entry);
                } else if entry.extension().is_some_and(|e| e == "gltf" || e == "glb") {
                    files.push(entry.strip_prefix(DATA).unwrap().to_str().unwrap().to_owned());
                }
            }
        }
    }
    files.sort();
    assert!(files.len() > 20);
    for file in files {
        match load(&file).unwrap() {
            Ok(report) => {
                let (s, m) = (&report.value, &report.value.mesh);
                println!(
                    "{file}: {} V {} T {} parts {} materials {} images; {} uv, colours {}, tangents {}, {} fields, {} cameras, {} lights; {:?}",
                    m.positions().len(),
                    m.triangles().len(),
                    m.parts().len(),
                    s.materials.len(),
                    s.images.len(),
                    m.uv_sets().len(),
                    !m.colors().is_empty(),
                    !m.tangents().is_empty(),
                    m.fields().len(),
                    s.cameras.len(),
                    s.lights.len(),
                    m.bounds()
                );
                report.mended.iter().for_each(|m| println!("    {m}"));
                // What is left of a box with infinite corners may be nothing.
                assert!(!m.triangles().is_empty() || !report.mended.is_empty());
                assert_eq!(m.parts().last().map_or(0, |p| p.triangles.end as usize), m.triangles().len());
            }
            Err(e) => {
                let line = e.to_string();
                println!("{file}: REFUSED {line}");
                assert!(!line.contains('\n') && line.len() < 600, "{line}");
                assert!(file.starts_with("7_"), "{line}");
            }
        }
    }
}

#[test]
fn catalogue_counts_are_met() {
    let cases = [
        ("2_gltf/Duck/Duck.gltf", 2399, 4212),
        ("2_gltf/BoxTextured/glTF/BoxTextured.gltf", 24, 12),
        ("2_gltf/BoxTextured/glTF-Embedded/BoxTextured.gltf", 24, 12),
        ("2_gltf/BoxTextured/glTF-Binary/BoxTextured.glb", 24, 12),
        ("2_gltf/TextureSettingsTest/TextureSettingsTest.gltf", 144, 72),
        ("2_gltf/TextureTransformTest/TextureTransformTest.gltf", 72, 24),
        ("2_gltf/AlphaBlendModeTest/AlphaBlendModeTest.glb", 137, 61),
        ("2_gltf/sphere_tangents/sphere.gltf", 231, 224),
    ];
    for (file, n_vertices, n_triangles) in cases {
        let Some(scene) = load(file) else { return };
        let mesh = scene.unwrap().value.mesh;
        assert_eq!((mesh.positions().len(), mesh.triangles().len()), (n_vertices, n_triangles), "{file}");
    }
}

#[test]
fn samplers_wrap_and_filter_as_the_file_says() {
    let Some(scene) = load("2_gltf/TextureSettingsTest/TextureSettingsTest.gltf") else { return };
    let materials = scene.unwrap().value.materials;
    let wraps: Vec<[Wrap; 2]> =
        materials.iter().filter_map(|m| m.base_color_texture).map(|t| [t.sampler.wrap[0], t.sampler.wrap[1]]).collect();
    for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
        assert!(wraps.iter().any(|w| w[0] == wrap) && wraps.iter().any(|w| w[1] == wrap), "{wraps:?}");
    }
    assert!(materials.iter().any(|m| m.double_sided) && materials.iter().any(|m| !m.double_sided));
}

#[test]
fn texture_rotation_points_the_arrow_at_the_green_marker() {
    let Some(scene) = load("2_gltf/TextureTransformTest/TextureTransformTest.gltf") else { return };
    let scene = scene.unwrap().value;
    let rotated: Vec<_> = scene
        .materials
        .iter()
        .filter_map(|m| m.base_color_texture)
        .filter(|t| t.transform.matrix[0][1] != 0.0)
        .collect();
    assert!(!rotated.is_empty());
    for t in rotated {
        // A picture turns clockwise when its coordinates turn counter-clockwise, v pointing down.
        assert!(t.transform.matrix[0][1] > 0.0 && t.transform.matrix[1][0] < 0.0, "{:?}", t.transform);
    }
}

#[test]
fn mirrored_nodes_turn_their_triangles() {
    let report = parse(&triangle(json!({"mesh": 0, "scale": [-2, 1, 1]}))).unwrap();
    let mesh = report.value.mesh;
    let [a, b, c] = mesh.triangles()[0].map(|i| mesh.positions()[i as usize]);
    assert_eq!((b - a).cross(c - a).normalize(), Vec3::Z, "seen from the side of the normals");
    assert_eq!(mesh.normals(), [Vec3::Z; 3]);
    // +u points to -X now; u to the left and v down leave a bitangent that is mirrored.
    assert_eq!(mesh.tangents()[0].to_array(), [-1.0, 0.0, 0.0, -1.0]);
}

#[test]
fn normals_stay_at_right_angles_under_uneven_scale() {
    let turned = json!({"mesh": 0, "matrix": [1, 0, 3, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]});
    let mesh = parse(&triangle(turned)).unwrap().value.mesh;
    let [a, b, c] = mesh.triangles()[0].map(|i| mesh.positions()[i as usize]);
    assert_eq!(a, vec3(5.0, 6.0, 7.0));
    for n in mesh.normals() {
        assert!(n.dot(b - a).abs() < 1e-6 && n.dot(c - a).abs() < 1e-6 && (n.length() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn nodes_that_contain_themselves_end() {
    let mut document = triangle(json!({"mesh": 0, "children": [1, 1]}));
    document["nodes"].as_array_mut().unwrap().push(json!({"mesh": 0, "children": [0]}));
    let report = parse(&document).unwrap();
    assert_eq!(report.value.mesh.triangles().len(), 2);
    assert!(has_note(&report, "second time"));
}

#[test]
fn strips_and_fans_become_triangles() {
    for (mode, want) in [(5, vec![[0, 1, 2], [1, 3, 2]]), (6, vec![[1, 2, 0], [2, 3, 0]])] {
        let mut bytes: Vec<u8> = Vec::new();
        for p in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]] {
            p.iter().chain(&[0.0, 0.0, 1.0]).for_each(|x| bytes.extend(x.to_le_bytes()));
        }
        let accessor = |offset: usize| json!({"bufferView": 0, "byteOffset": offset, "componentType": 5126, "count": 4, "type": "VEC3"});
        let mut document = triangle(json!({"mesh": 0}));
        document["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": 0, "NORMAL": 1}, "mode": mode});
        document["accessors"] = json!([accessor(0), accessor(12)]);
        document["bufferViews"] = json!([{"buffer": 0, "byteLength": 96, "byteStride": 24}]);
        document["buffers"] = json!([{"byteLength": 96, "uri": format!("data:;base64,{}", base64(&bytes))}]);
        assert_eq!(parse(&document).unwrap().value.mesh.triangles(), want);
    }
}

#[test]
fn missing_normals_become_flat_ones() {
    let mut document = triangle(json!({"mesh": 0}));
    document["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0, "_HEAT": 0});
    let report = parse(&document).unwrap();
    assert_eq!(report.value.mesh.normals(), [Vec3::Z; 3]);
    assert_eq!(report.value.mesh.fields()[0].name, "_HEAT");
    assert!(has_note(&report, "flat"));
}

#[test]
fn a_bare_material_is_white_metal_and_clear_coat_is_read_whole() {
    let mut document = triangle(json!({"mesh": 0}));
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
    document["materials"] = json!([{
        "alphaMode": "MASK",
        "emissiveFactor": [1, 0.5, 0],
        "extensions": {
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.25},
            "KHR_materials_emissive_strength": {"emissiveStrength": 4},
            "KHR_materials_unlit": {},
            "KHR_materials_sheen": {}
        }
    }]);
    let report = parse(&document).unwrap();
    let m = &report.value.materials[0];
    assert_eq!((m.base_color, m.metalness, m.roughness, m.double_sided), ([1.0; 4], 1.0, 1.0, false));
    assert_eq!((m.clearcoat.strength, m.clearcoat.roughness), (0.75, 0.25));
    assert_eq!((m.emission, m.alpha_mode, m.unlit), ([4.0, 2.0, 0.0], AlphaMode::Mask(0.5), true));
    assert!(has_note(&report, "KHR_materials_sheen"));
}

#[test]
fn cameras_and_lights_stand_where_their_nodes_stand() {
    let mut document = triangle(json!({"mesh": 0, "children": [1, 2]}));
    document["nodes"].as_array_mut().unwrap().extend([
        json!({"camera": 0, "translation": [0, 0, 9], "scale": [2, 2, 2]}),
        json!({"rotation": [1, 0, 0, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}}),
    ]);
    document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]);
    document["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "directional", "color": [1, 0, 0], "intensity": 3}]}});
    let scene = parse(&document).unwrap().value;
    assert_eq!(scene.cameras[0].projection, Projection::Perspective { fov_y: 0.5 });
    assert_eq!(scene.cameras[0].world_from_camera.transform_point3(vec3(0.0, 0.0, -1.0)), vec3(0.0, 0.0, 8.0));
    assert_eq!(scene.lights[0].color, [3.0, 0.0, 0.0]);
    assert_eq!(scene.lights[0].kind, SceneLightKind::Directional(vec3(0.0, 0.0, -1.0)));
}

#[test]
fn skins_stand_in_the_pose_of_their_joints() {
    let mut document = triangle(json!({"mesh": 0, "skin": 0, "translation": [100, 0, 0], "children": [1]}));
    document["nodes"].as_array_mut().unwrap().push(json!({"translation": [0, 0, 7]}));
    let weights: Vec<u8> = (0..3).flat_map(|_| [0, 0, 0, 0, 255, 0, 0, 0]).collect();
    document["buffers"]
        .as_array_mut()
        .unwrap()
        .push(json!({"byteLength": 24, "uri": format!("data:;base64,{}", base64(&weights))}));
    document["bufferViews"].as_array_mut().unwrap().push(json!({"buffer": 1, "byteLength": 24, "byteStride": 8}));
    let accessor = |offset: usize, whole: bool| json!({"bufferView": 1, "byteOffset": offset, "componentType": 5121, "count": 3, "type": "VEC4", "normalized": whole});
    document["accessors"].as_array_mut().unwrap().extend([accessor(0, false), accessor(4, true)]);
    document["skins"] = json!([{"joints": [1]}]);
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(3);
    attributes["WEIGHTS_0"] = json!(4);
    let mesh = parse(&document).unwrap().value.mesh;
    assert_eq!(mesh.positions()[0], vec3(100.0, 0.0, 7.0));
}

#[test]
fn morph_targets_have_the_weight_that_the_file_gives() {
    let mut document = triangle(json!({"mesh": 0}));
    document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 1}]);
    document["meshes"][0]["weights"] = json!([0.5]);
    let mesh = parse(&document).unwrap().value.mesh;
    assert_eq!(mesh.positions()[1], vec3(1.0, 0.0, 0.5));
}

#[test]
fn sparse_accessors_replace_elements() {
    let Some(scene) = load("2_gltf/SimpleSparseAccessor/SimpleSparseAccessor.gltf") else { return };
    let mesh = scene.unwrap().value.mesh;
    assert_eq!(mesh.triangles().len(), 12);
    assert!(mesh.positions().contains(&vec3(1.0, 2.0, 0.0)) && mesh.positions().contains(&vec3(5.0, 4.0, 0.0)));
}

#[test]
fn colour_textures_are_srgb_and_all_others_linear() {
    let Some(scene) = load("2_gltf/FlightHelmet/FlightHelmet.gltf") else { return };
    let scene = scene.unwrap().value;
    assert_eq!((scene.mesh.positions().len(), scene.mesh.triangles().len()), (55392, 94722));
    assert!(!scene.mesh.tangents().is_empty());
    for m in &scene.materials {
        let encoding = |t: Option<crate::assets::TextureRef>| t.map(|t| scene.images[t.image as usize].encoding);
        assert_eq!(encoding(m.base_color_texture), Some(Encoding::Srgb));
        assert_eq!(encoding(m.normal_texture), Some(Encoding::Linear));
        assert_eq!(encoding(m.metal_rough_texture), Some(Encoding::Linear));
        assert_eq!(encoding(m.occlusion_texture), Some(Encoding::Linear));
        // Occlusion and metal-roughness share one image.
        assert_eq!(m.occlusion_texture.unwrap().image, m.metal_rough_texture.unwrap().image);
    }
    assert!(scene.images.iter().all(|i| matches!(i.texels, Texels::U8(_))));
}

#[test]
fn both_uv_sets_are_kept() {
    let Some(scene) = load("2_gltf/MultiUVTest/MultiUVTest.gltf") else { return };
    let scene = scene.unwrap().value;
    assert_eq!(scene.mesh.uv_sets().len(), 2);
    let m = &scene.materials[0];
    assert_ne!(m.base_color_texture.unwrap().uv_set, m.emission_texture.unwrap().uv_set);
}

#[test]
fn wrong_documents_are_refused_with_their_reason() {
    let asset = json!({"version": "2.0"});
    let cases = [
        ("", "broken JSON"),
        ("[]", "no glTF"),
        ("{}", "\"asset\" is missing"),
        (r#"{"asset": {"version": "1.0"}}"#, "glTF 1.0 is not read"),
        (
            r#"{"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_draco_mesh_compression"]}"#,
            "KHR_draco_mesh_compression",
        ),
        (r#"{"asset": {"version": "2.0"}}"#, "no triangles"),
        ("glTF\u{2}\0\0\0\u{c}\0\0\0", "no JSON chunk"),
        ("glTF\u{1}\0\0\0\u{c}\0\0\0", "GLB version 1"),
        ("glTF\u{2}\0\0\0\u{c}\0\0\0\u{7f}\u{7f}\u{7f}\u{7f}JSON", "cut short"),
    ];
    for (text, reason) in cases {
        let line = read(text.as_bytes(), Path::new("x.glb"), &nothing).unwrap_err().to_string();
        assert!(line.contains(reason), "{line}");
    }
    let huge = json!({"asset": asset, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"componentType": 5126, "count": 4_000_000_000u32, "type": "VEC3"}]});
    assert!(parse(&huge).unwrap_err().to_string().contains("without any bytes"));
}

#[test]
fn instances_cannot_fill_the_memory() {
    let mut document = triangle(json!({"mesh": 0}));
    document["accessors"][0] = json!({"componentType": 5126, "count": 1_000_000, "type": "VEC3"});
    document["meshes"][0]["primitives"] = (0..500).map(|_| json!({"attributes": {"POSITION": 0}})).collect();
    let line = parse(&document).unwrap_err().to_string();
    assert!(line.contains("too large"), "{line}");
}

#[test]
fn broken_documents_never_panic() {
    let whole = triangle(json!({"mesh": 0, "camera": 0, "translation": [1, 2, 3]})).to_string();
    for n in 0..whole.len() {
        assert!(read(&whole.as_bytes()[..n], Path::new("x.gltf"), &nothing).is_err());
    }
    // Every value of the document in turn replaced by something it should not be.
    let places = pointers(&serde_json::from_str(&whole).unwrap());
    for wrong in [json!("x"), json!(-1), json!(1e300), json!({}), json!([]), json!(4294967295u32), json!(1.5)] {
        for place in &places {
            let mut document: Value = serde_json::from_str(&whole).unwrap();
            *document.pointer_mut(place).unwrap() = wrong.clone();
            match parse(&document) {
                Ok(report) => assert!(!report.value.mesh.triangles().is_empty() || !report.mended.is_empty()),
                Err(e) => assert!(!e.to_string().contains('\n')),
            }
        }
    }
}

fn pointers(value: &Value) -> Vec<String> {
    let children: Vec<(String, &Value)> = match value {
        Value::Object(o) => o.iter().map(|(k, v)| (k.replace('~', "~0").replace('/', "~1"), v)).collect(),
        Value::Array(a) => a.iter().enumerate().map(|(i, v)| (i.to_string(), v)).collect(),
        _ => Vec::new(),
    };
    children
        .into_iter()
        .flat_map(|(key, v)| {
            let below = pointers(v).into_iter().map(|p| format!("/{key}{p}")).collect::<Vec<_>>();
            std::iter::once(format!("/{key}")).chain(below)
        })
        .collect()
}

#[test]
fn uv_transform_and_filters_of_a_texture() {
    let Some(scene) = load("2_gltf/TextureTransformTest/TextureTransformTest.gltf") else { return };
    let scene = scene.unwrap().value;
    let texture =
        scene.materials.iter().filter_map(|m| m.base_color_texture).find(|t| t.transform.offset == [0.5, 0.5]);
    let t = texture.unwrap();
    assert_eq!(t.sampler.mag, Filter::Linear);
    assert_eq!(t.sampler.wrap[0], Wrap::ClampToEdge);
    assert!(scene.mesh.uv_sets()[0].uv.contains(&vec2(0.5, 0.5)));
}
