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

/// Height in kilometres at a place, both coordinates in [0, 1], x east and y south. About 0 to 1.5.
pub fn height(place: Vec2, seed: u32) -> f32 {
    let p = place * 2.6;
    // Where there are mountains at all, and a warp that bends their ridges.
    let relief = fbm_2d(p * 0.7 + vec2(3.7, 1.3), 2, 0.5, Lattice::seeded(seed ^ 0x51)).value;
    let bend = |salt: u32| fbm_2d(p * 1.1, 3, 0.5, Lattice::seeded(seed ^ salt)).value;
    let p = p + vec2(bend(0xa1), bend(0xb2)) * 0.35;
    let mut lattice = Lattice::seeded(seed);
    let (mut sum, mut strength, mut scale, mut slope) = (0.0f32, 1.0f32, 1.0f32, Vec2::ZERO);
    let mut crest = 1.0f32;
    for _ in 0..10 {
        let n = gradient_2d(p * scale, lattice);
        // Ridges: folded noise, rounded a little, finer ones only on coarser ones.
        let root = (n.value * n.value + 0.0012).sqrt();
        let fold = 1.0 - root;
        let ridge = fold * fold * crest;
        let worn = 1.0 / (1.0 + 0.05 * slope.length_squared());
        sum += strength * worn * ridge;
        slope += n.gradient * (-2.0 * fold * n.value / root * crest * strength * scale);
        crest = (ridge * 1.7).clamp(0.0, 1.0);
        (strength, scale, lattice) = (strength * 0.5, scale * 2.03, lattice.octave());
    }
    // Low ground is filled and flat; mountains rise where the relief wants them.
    let h = (sum - 0.45) * (0.30 + 0.70 * smooth(-0.40, 0.35, relief));
    let plain = 0.10;
    let over = h - plain;
    let filled = 0.5 * (over + (over * over + 0.02).sqrt());
    1.35 * filled + 0.03 * relief + 0.012 * fbm_2d(place * 22.0, 3, 0.5, Lattice::seeded(seed ^ 0xc3)).value
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
    let mut c = mix(rgb(0x8f9a5c), rgb(0x6f8548), smooth(0.0, 0.25, h + 0.1 * patch));
    c = mix(c, rgb(0x41603a), smooth(0.10, 0.24, h + 0.16 * patch) * smooth(1.0, 0.6, steep));
    c = mix(c, rgb(0x938a68), smooth(0.48, 0.66, h + 0.12 * patch));
    // Rock in layers wherever it is steep.
    let layer = 0.5 + 0.5 * crate::math::exact::sin((h * 34.0 + 5.0 * rough + 6.0 * patch) as f64) as f32;
    let rock = mix(rgb(0x857b70), rgb(0xa89c8c), 0.3 * layer + 0.5 * (0.5 + rough));
    c = mix(c, rock, smooth(0.75, 1.05, steep + 0.25 * rough).max(0.85 * smooth(0.70, 0.85, h + 0.1 * rough)));
    // Snow lies high, on what is not too steep, deeper on the north side.
    let lies = smooth(0.74, 0.92, h + 0.12 * patch + 0.08 * rough + 0.06 * slope.y) * smooth(1.7, 1.0, steep);
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
