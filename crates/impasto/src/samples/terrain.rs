//! Mountains: a height field with ridges and valleys that look worn by water, its colours, and its elevation as data.
//!
//! Octaves of gradient noise, each weakened where those before are steep (Quilez, "Value Noise Derivatives", 2008), so that
//! slopes stay smooth and ridges rough, as erosion leaves them; ridges after Musgrave's multifractals (1993).

use crate::assets::{
    Element, Field, Image, Material, Mesh, Scene, Texels, TextureImage, TextureRef, UvTransform, Values,
};
use crate::assets::{Sampler, Wrap};
use crate::color::{Encoding, unorm8};
use crate::math::{DVec2, DVec3, Size, Vec2, vec2};
use crate::noise::{Lattice, fbm_2d, gradient_2d};
use crate::samples::sheet::{self, Point};
use crate::samples::texture::{Rgb, mix, rgb};

/// Edge length of the terrain: a unit is a kilometre.
pub const WIDTH: f64 = 10.0;

/// Height in kilometres at a place, both coordinates in [0, 1], x east and y south. About 0 to 2.
pub fn height(place: Vec2, seed: u32) -> f32 {
    let p = place * 3.2;
    // Where there are mountains at all, and a warp that bends their ridges.
    let relief = fbm_2d(p * 0.55 + vec2(3.7, 1.3), 2, 0.5, Lattice::seeded(seed ^ 0x51));
    let warp = vec2(
        fbm_2d(p * 0.9, 2, 0.5, Lattice::seeded(seed ^ 0xa1)).value,
        fbm_2d(p * 0.9, 2, 0.5, Lattice::seeded(seed ^ 0xb2)).value,
    );
    let p = p + warp * 0.55;
    let mut lattice = Lattice::seeded(seed);
    let (mut sum, mut strength, mut scale, mut slope) = (0.0f32, 1.0f32, 1.0f32, Vec2::ZERO);
    let mut crest = 1.0f32;
    for octave in 0..10 {
        let n = gradient_2d(p * scale, lattice);
        if octave < 4 {
            // Ridges: folded noise, finer ones only on coarser ones.
            let fold = 1.0 - (n.value * n.value + 0.004).sqrt();
            let ridge = fold * fold * crest;
            crest = (ridge * 1.6).clamp(0.0, 1.0);
            sum += strength * ridge;
            slope += n.gradient * (strength * 0.8 * crest);
        } else {
            slope += n.gradient * strength * 2.0;
            sum += strength * 0.9 * n.value / (1.0 + slope.length_squared() * 0.35);
        }
        (strength, scale, lattice) = (strength * 0.46, scale * 2.03, lattice.octave());
    }
    let high = smooth(-0.45, 0.55, relief.value);
    // Valleys are filled: low ground is flatter than the noise.
    let h = sum * (0.25 + 0.75 * high);
    let floor = 0.22;
    let h = if h < floor + 0.2 { floor + (h - floor) * smooth_ramp((h - floor) / 0.2) } else { h };
    (h - floor) * 1.55
}

/// A square of `n` x `n` cells, its middle at the origin, +Y up, u east and v south, with fields `elevation` in metres and
/// `slope` in degrees.
pub fn mesh(n: u32, seed: u32) -> Mesh {
    let n = n.max(2);
    // One more ring around gives the border its normals.
    let wide = n + 3;
    let at = |i: u32, j: u32| vec2((i as f32 - 1.0) / n as f32, (j as f32 - 1.0) / n as f32);
    let grid: Vec<f32> = (0..wide * wide).map(|k| height(at(k % wide, k / wide), seed)).collect();
    let h = |i: u32, j: u32| grid[(j * wide + i) as usize] as f64;
    let step = WIDTH / n as f64;
    let mut raw = sheet::empty();
    let (mut elevation, mut slope) = (Vec::new(), Vec::new());
    // Rows from the south, so that they run up on the map.
    sheet::grid(&mut raw, [n, n], |i, j| {
        let (x, y) = (i + 1, n - j + 1);
        let normal = DVec3::new(h(x - 1, y) - h(x + 1, y), 2.0 * step, h(x, y - 1) - h(x, y + 1));
        let uv = DVec2::new(i as f64 / n as f64, 1.0 - j as f64 / n as f64);
        Point { position: DVec3::new((uv.x - 0.5) * WIDTH, h(x, y), (uv.y - 0.5) * WIDTH), normal, uv }
    });
    for (p, normal) in raw.positions.iter().zip(&raw.normals) {
        elevation.push(p.y * 1000.0);
        let steepness = crate::math::exact::acos((normal.y as f64).clamp(-1.0, 1.0));
        slope.push(steepness.to_degrees() as f32);
    }
    raw.fields = vec![field("elevation", "m", elevation), field("slope", "°", slope)];
    sheet::part(&mut raw, "terrain", Some(0));
    sheet::finish(raw)
}

fn field(name: &str, unit: &str, values: Vec<f32>) -> Field {
    Field {
        name: name.into(),
        unit: unit.into(),
        element: Element::Vertex,
        n_components: 1,
        values: Values::F32(values),
    }
}

/// Meadow, forest, scree, rock and snow by height and steepness, for the whole square.
pub fn colors(size: u32, seed: u32) -> TextureImage {
    let size = size.max(2);
    let wide = size + 2;
    let grid: Vec<f32> = (0..wide * wide)
        .map(|k| height(vec2((k % wide) as f32 - 0.5, (k / wide) as f32 - 0.5) / size as f32, seed))
        .collect();
    let step = WIDTH as f32 / size as f32;
    let image = Image::from_fn(Size::new(size, size), |x, y| {
        let h = |dx: u32, dy: u32| grid[((y + dy) * wide + x + dx) as usize];
        let slope = vec2(h(2, 1) - h(0, 1), h(1, 2) - h(1, 0)) / (2.0 * step);
        let place = vec2(x as f32 + 0.5, y as f32 + 0.5) / size as f32;
        let [r, g, b] = ground(place, h(1, 1), slope, seed).map(unorm8);
        [r, g, b, 255]
    });
    TextureImage { name: "terrain".into(), texels: Texels::U8(image), encoding: Encoding::Srgb, n_channels: 3 }
}

fn ground(place: Vec2, h: f32, slope: Vec2, seed: u32) -> Rgb {
    let steep = slope.length();
    let rough = fbm_2d(place * 60.0, 4, 0.6, Lattice::seeded(seed ^ 0x77)).value;
    let patch = fbm_2d(place * 14.0, 3, 0.5, Lattice::seeded(seed ^ 0x78)).value;
    let mut c = mix(rgb(0xa7b56a), rgb(0x7f9a4f), smooth(0.0, 0.25, h + 0.1 * patch));
    c = mix(c, rgb(0x4f7445), smooth(0.18, 0.42, h + 0.22 * patch) * smooth(0.75, 0.45, steep));
    c = mix(c, rgb(0xa39a75), smooth(0.62, 0.85, h + 0.12 * patch));
    // Rock in layers wherever it is steep.
    let layer = 0.5 + 0.5 * crate::math::exact::sin((h * 95.0 + 4.0 * rough) as f64) as f32;
    let rock = mix(rgb(0x857b70), rgb(0xa89c8c), 0.35 * layer + 0.35 * (0.5 + rough));
    c = mix(c, rock, smooth(0.55, 0.85, steep + 0.22 * rough).max(0.85 * smooth(0.95, 1.15, h + 0.1 * rough)));
    // Snow lies high, on what is not too steep, deeper on the north side.
    let lies = smooth(0.98, 1.22, h + 0.16 * patch + 0.10 * rough + 0.08 * slope.y) * smooth(1.35, 0.85, steep);
    c = mix(c, rgb(0xf6f8fb), lies);
    c.map(|x| x * (1.0 + 0.09 * rough * (1.0 - lies)))
}

/// The mesh with its colours as texture.
pub fn scene(n: u32, texture_size: u32, seed: u32) -> Scene {
    let texture = TextureRef {
        image: 0,
        uv_set: 0,
        sampler: Sampler { wrap: [Wrap::ClampToEdge; 3], ..Sampler::default() },
        transform: UvTransform::IDENTITY,
    };
    let material = Material {
        name: "ground".into(),
        base_color: [1.0; 4],
        base_color_texture: Some(texture),
        roughness: 0.95,
        ..Material::default()
    };
    Scene { materials: vec![material], images: vec![colors(texture_size, seed)], ..Scene::of("terrain", mesh(n, seed)) }
}

fn smooth(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// 0.25 below 0, 1 above 1.
fn smooth_ramp(x: f32) -> f32 {
    0.25 + 0.75 * smooth(0.0, 1.0, x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resolutions_agree_on_heights_and_seeds_do_not() {
        let (coarse, fine) = (mesh(16, 1), mesh(32, 1));
        for j in 0..=16 {
            for i in 0..=16 {
                assert_eq!(coarse.positions()[j * 17 + i], fine.positions()[2 * j * 33 + 2 * i]);
            }
        }
        assert_ne!(coarse.positions(), mesh(16, 2).positions());
        let range = fine.fields()[0].range(0);
        assert!(range.min > -400.0 && range.max < 3500.0 && range.max - range.min > 300.0, "{range:?}");
    }

    #[test]
    fn it_is_one_sheet_with_its_front_up() {
        let mesh = mesh(20, 3);
        assert_eq!(mesh.triangles().len(), 800);
        for t in mesh.triangles() {
            let [a, b, c] = t.map(|i| mesh.positions()[i as usize]);
            assert!((b - a).cross(c - a).y > 0.0);
        }
    }
}
