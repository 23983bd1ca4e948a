//! Surfaces and textures made by formula, at any size, so that everything runs with no file.
//!
//! Each generator is a plain function; [`scene`] reaches them by name, dressed in textures that show them well. Closed
//! bodies are closed to the last bit: where a texture is cut open, both sides have vertices at equal places.

mod atlas;
pub mod bench;
pub mod body;
pub mod chameleon;
pub mod cortex;
mod curve;
pub mod ethanol;
pub mod flange;
pub mod plain;
mod sheet;
#[cfg(test)]
mod solid;
pub mod terrain;
pub mod texture;
mod tube;

use crate::assets::{Material, Mesh, Scene, TextureImage, TextureRef, UvTransform};
use crate::color::linear_from_bytes;
use crate::math::Size;
use texture::{charts, materials, normal_map};

/// What [`scene`] can make: name, and one sentence.
pub const NAMES: [(&str, &str); 25] = [
    ("chameleon", "Impasto's mascot on its twig: painted skin, five parts, two data fields."),
    ("knot", "A torus knot in relief scales, one closed tube without a twist in its texture."),
    ("terrain", "Ten kilometres of mountains with snow and meadows, elevation and slope as data."),
    ("flange", "A machine part with four bolt holes, a bore with keyway, fillets, and a stress field."),
    ("ethanol", "A molecule's smooth surface, its electrostatic and its lipophilic potential."),
    ("cortex", "A folded surface like half of a brain; its thickness is missing where the halves are joined."),
    ("displaced", "A gently waved sphere of marble."),
    ("icosphere", "A sphere of nearly equal triangles; its texture is the icosahedron's net."),
    ("plane", "A square on the ground with the chart for texture coordinates."),
    ("quad", "A picture on a wall: an F that looks different from every side."),
    ("cube", "A cube of bricks with relief."),
    ("cylinder", "A closed cylinder of wood."),
    ("cone", "A closed striped cone."),
    ("loaf", "Tin bread, to be cut."),
    ("log", "A length of trunk in its bark, to be cut."),
    ("fruit", "A citrus fruit, to be cut."),
    ("pomegranate", "A pomegranate with its crown, to be cut."),
    ("bone", "A long bone with two heads, to be cut."),
    ("nodule", "A rounded stone, to be cut."),
    ("block", "A block with rounded edges, to be cut."),
    ("sphere10k", "Speed test A: a waved sphere of ten thousand triangles."),
    ("sphere100k", "Speed test A: a waved sphere of a hundred thousand triangles."),
    ("sphere1m", "Speed test A: a waved sphere of a million triangles."),
    ("layers_btf", "Speed test B: eight waved sheets, drawn back to front; layers_ftb draws them front to back."),
    ("hills", "Speed test C: a hilly ground seen at grazing angles under a 4096 x 4096 texture."),
];

/// The sample of that name. `resolution` is about the number of edges along its longest side (the scenes of the speed
/// tests have their own); textures grow with it, 8 texels an edge, 256 to 2048. None when there is no such name.
pub fn scene(name: &str, resolution: u32, seed: u32) -> Option<Scene> {
    // 4096 edges a side are 33 million triangles: more is a slip of the finger.
    let n = resolution.clamp(8, 4096);
    let texels = (8 * n).next_power_of_two().clamp(256, 2048);
    let size = Size::new(texels, texels);
    Some(match name {
        "chameleon" => chameleon::scene(n, texels, seed),
        "terrain" => terrain::scene(n, texels, seed),
        "flange" => flange::scene(n),
        "ethanol" => ethanol::scene(n),
        "cortex" => cortex::scene(n, seed),
        "knot" => {
            let mesh = plain::torus_knot(2, 3, 0.2, [4 * n, (n / 3).max(12)]);
            let around = 2.0;
            let along = (plain::torus_knot_repeats(2, 3, 0.2) as f32 * around + 0.5).floor();
            let relief = normal_map(&materials::scale_heights(size, seed), 0.02);
            dressed(
                name,
                mesh,
                Dress { color: materials::scales(size, seed), relief: Some(relief), repeat: [along, around] },
            )
        }
        "displaced" => {
            let color = materials::marble(size, seed);
            dressed(name, plain::displaced_sphere(n / 2, n), Dress { color, relief: None, repeat: [2.0, 1.0] })
        }
        "icosphere" => dressed(name, plain::icosphere(n / 4), Dress::once(charts::uv_grid(size))),
        "plane" => dressed(name, plain::plane(n), Dress::once(charts::uv_grid(size))),
        "quad" => dressed(name, plain::quad(), Dress::once(charts::letter_f(size))),
        "cube" => {
            let relief = normal_map(&materials::brick_heights(size, seed), 0.012);
            dressed(
                name,
                plain::cube(n),
                Dress { color: materials::bricks(size, seed), relief: Some(relief), repeat: [1.0; 2] },
            )
        }
        "cylinder" => {
            let color = materials::wood(size, seed);
            dressed(name, plain::cylinder(n, n / 4), Dress { color, relief: None, repeat: [2.0; 2] })
        }
        "cone" => dressed(name, plain::cone(n, n / 4), Dress::once(charts::stripes(size, 32))),
        "loaf" => plain_body(name, body::loaf(n), "#8a4a16", 0.75),
        "log" => plain_body(name, body::log(n), "#5b4430", 0.95),
        "fruit" => plain_body(name, body::fruit(n), "#ef8a1a", 0.5),
        "pomegranate" => plain_body(name, body::pomegranate(n), "#a3202f", 0.45),
        "bone" => plain_body(name, body::bone(n), "#eee4cd", 0.6),
        "nodule" => plain_body(name, body::nodule(n, seed), "#9b958c", 0.9),
        "block" => plain_body(name, body::block(n / 4), "#b3b0aa", 0.85),
        // The speed tests call it terrain, too.
        "hills" => bench_scene("terrain")?,
        name => bench_scene(name)?,
    })
}

/// A speed test with its texture.
fn bench_scene(name: &str) -> Option<Scene> {
    let mesh = bench::mesh(name)?.mend().value;
    Some(dressed(name, mesh, Dress::once(bench::texture(bench::texture_size(name)))))
}

/// What a surface wears.
struct Dress {
    color: TextureImage,
    /// Tangent-space normals.
    relief: Option<TextureImage>,
    /// How often along u and v.
    repeat: [f32; 2],
}

impl Dress {
    fn once(color: TextureImage) -> Self {
        Self { color, relief: None, repeat: [1.0; 2] }
    }
}

/// A mesh of one colour, written as sRGB.
fn plain_body(name: &str, mesh: Mesh, color: &str, roughness: f32) -> Scene {
    let byte = |k: usize| u8::from_str_radix(&color[k..k + 2], 16).expect("a colour is #rrggbb");
    let [r, g, b] = linear_from_bytes([byte(1), byte(3), byte(5)]);
    let material = Material { name: name.into(), base_color: [r, g, b, 1.0], roughness, ..Material::default() };
    let mut raw = mesh.into_raw();
    raw.parts.clear();
    sheet::part(&mut raw, name, Some(0));
    Scene { materials: vec![material], ..Scene::of(name, raw.mend().value) }
}

/// A mesh of one material.
fn dressed(name: &str, mesh: Mesh, dress: Dress) -> Scene {
    let [u, v] = dress.repeat;
    let transform = UvTransform { matrix: [[u, 0.0], [0.0, v]], offset: [0.0; 2] };
    let texture = |image| TextureRef { image, uv_set: 0, sampler: Default::default(), transform };
    let material = Material {
        name: dress.color.name.clone(),
        base_color: [1.0; 4],
        base_color_texture: Some(texture(0)),
        normal_texture: dress.relief.is_some().then(|| texture(1)),
        roughness: 0.55,
        ..Material::default()
    };
    let mut raw = mesh.into_raw();
    raw.parts.clear();
    sheet::part(&mut raw, name, Some(0));
    let images = std::iter::once(dress.color).chain(dress.relief).collect();
    Scene { materials: vec![material], images, ..Scene::of(name, raw.mend().value) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_gives_a_scene_whose_references_exist() {
        for (name, sentence) in NAMES {
            // The largest speed tests have the smaller ones' code.
            if ["sphere100k", "sphere1m", "hills"].contains(&name) {
                continue;
            }
            let scene = scene(name, 8, 1).unwrap_or_else(|| panic!("no sample {name}"));
            assert!(sentence.ends_with('.') && !scene.mesh.triangles().is_empty());
            let n = scene.mesh.positions().len();
            assert!(scene.mesh.normals().len() == n && scene.mesh.uv_sets().iter().all(|s| s.uv.len() == n), "{name}");
            for part in scene.mesh.parts() {
                let material = &scene.materials[part.material.expect("samples have materials") as usize];
                for texture in [material.base_color_texture, material.normal_texture].into_iter().flatten() {
                    assert!((texture.image as usize) < scene.images.len(), "{name}");
                }
            }
        }
        assert!(scene("nothing", 8, 1).is_none());
    }
}
