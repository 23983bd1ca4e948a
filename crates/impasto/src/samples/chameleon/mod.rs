//! The mascot: a little chameleon on a twig, which wears textures. Made by formula like everything here.
//!
//! Body with tail, legs, eyelids, twig and leaves are tubes and domes, each closed, with charts side by side in one
//! texture. The skin is painted texel by texel from the place on the body that a texel belongs to.

mod paint;
mod shape;

use crate::assets::material::Clearcoat;
use crate::assets::{
    AlphaMode, Element, Field, Image, Material, RawMesh, Sampler, Scene, Texels, TextureImage, TextureRef, UvTransform,
    Values, Wrap,
};
use crate::color::Encoding;
use crate::math::{DVec2, Size};
use crate::samples::atlas::{self, Atlas};
use crate::samples::sheet;
use shape::{Piece, PieceShape};

/// The whole figure, about 6 units long, looking along +X: parts `body`, `eyes`, `pupils`, `twig`, `leaves`, one UV set
/// whose charts do not overlap, a painted texture of `texture_size` texels square, and two fields: `distance along spine`
/// (missing on what is not chameleon) and `temperature`. `resolution` is the number of edges along the figure.
pub fn scene(resolution: u32, texture_size: u32, seed: u32) -> Scene {
    let pieces = shape::pieces(6.0 / resolution.max(8) as f64);
    let atlas = layout(&pieces);
    let mut raw = sheet::empty();
    let (mut distance, mut temperature) = (Vec::new(), Vec::new());
    for (part, name) in PARTS.iter().enumerate() {
        for (piece, corner) in pieces.iter().zip(&atlas.corners).filter(|(p, _)| p.part == part) {
            let start = raw.positions.len();
            let uv = |chart: DVec2| *corner + chart * atlas.scale;
            add(piece, &mut raw, uv);
            for i in start..raw.positions.len() {
                let chart = (raw.uv_sets[0].uv[i].as_dvec2() - *corner) / atlas.scale;
                let [d, t] = shape::fields(piece, chart, raw.positions[i]);
                distance.push(d);
                temperature.push(t);
            }
        }
        sheet::part(&mut raw, name, Some(part as u32));
    }
    raw.fields = vec![field("distance along spine", "cm", distance), field("temperature", "°C", temperature)];
    let image = paint_atlas(&pieces, &atlas, texture_size, seed);
    Scene { materials: materials(), images: vec![image], ..Scene::of("chameleon", sheet::finish(raw)) }
}

const PARTS: [&str; 5] = ["body", "eyes", "pupils", "twig", "leaves"];

/// Between charts, and from the edge, in texture widths: five texels of 1024.
const GUTTER: f64 = 5.0 / 1024.0;

fn layout(pieces: &[Piece]) -> Atlas {
    let sizes: Vec<DVec2> = pieces.iter().map(Piece::chart_size).collect();
    atlas::shelves(&sizes, GUTTER)
}

fn add(piece: &Piece, raw: &mut RawMesh, uv: impl Fn(DVec2) -> DVec2) {
    match &piece.shape {
        PieceShape::Tube(tube) => tube.add_to(raw, uv),
        PieceShape::Dome(dome) => dome.add_to(raw, uv),
    }
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

/// Every texel takes the colour of the chart whose rectangle it is in or next to; what is beside the surface continues
/// it, so that no filter finds a foreign colour in the gutter.
fn paint_atlas(pieces: &[Piece], atlas: &Atlas, size: u32, seed: u32) -> TextureImage {
    let size = size.max(16);
    let texel = 1.0 / size as f64;
    let mut image = Image::filled(Size::new(size, size), [64, 110, 80, 255]);
    for (piece, corner) in pieces.iter().zip(&atlas.corners) {
        let extent = piece.chart_size() * atlas.scale;
        let (low, high) = (*corner - DVec2::splat(GUTTER / 2.0), *corner + extent + DVec2::splat(GUTTER / 2.0));
        let range =
            |a: f64, b: f64| (a * size as f64).floor().max(0.0) as u32..((b * size as f64).ceil() as u32).min(size);
        for y in range(low.y, high.y) {
            for x in range(low.x, high.x) {
                let uv = DVec2::new((x as f64 + 0.5) * texel, (y as f64 + 0.5) * texel);
                let chart = (uv - *corner) / atlas.scale;
                let rgb = paint::color(piece, chart, texel / atlas.scale, seed);
                let [r, g, b] = rgb.map(crate::color::unorm8);
                image.texels[(y * size + x) as usize] = [r, g, b, 255];
            }
        }
    }
    TextureImage { name: "chameleon".into(), texels: Texels::U8(image), encoding: Encoding::Srgb, n_channels: 3 }
}

fn materials() -> Vec<Material> {
    let skin = TextureRef {
        image: 0,
        uv_set: 0,
        sampler: Sampler { wrap: [Wrap::ClampToEdge; 3], ..Sampler::default() },
        transform: UvTransform::IDENTITY,
    };
    let looks =
        [("skin", 0.42, 0.0), ("iris", 0.25, 1.0), ("pupil", 0.08, 1.0), ("bark", 0.85, 0.0), ("leaf", 0.5, 0.0)];
    looks
        .map(|(name, roughness, coat)| Material {
            name: name.into(),
            base_color: [1.0; 4],
            base_color_texture: Some(skin),
            roughness,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            clearcoat: Clearcoat { strength: coat, roughness: 0.05, ..Clearcoat::default() },
            ..Material::default()
        })
        .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::solid::measure;

    #[test]
    fn every_piece_is_closed_at_any_resolution() {
        for resolution in [8, 33, 64, 128] {
            let scene = scene(resolution, 16, 1);
            let solid = measure(&scene.mesh);
            // Body, 4 legs, 4 feet, 2 lids, 2 eyeballs, 2 pupils, twig, shoot, 3 leaves: 20 spheres.
            assert!(solid.is_closed && solid.euler == 40, "{resolution}: {solid:?}");
            assert!(solid.share_of_right_normals > 0.985, "{resolution}: {solid:?}");
            assert_eq!(scene.mesh.parts().len(), PARTS.len());
            assert_eq!(scene.mesh.parts().last().unwrap().triangles.end as usize, scene.mesh.triangles().len());
        }
    }

    /// Draws all charts into a grid of 1024 x 1024 cells, each with its number; no cell belongs to two, and around each
    /// there are four cells that belong to none but its own.
    #[test]
    fn charts_do_not_overlap_and_keep_their_distance() {
        const N: i32 = 1024;
        let pieces = shape::pieces(6.0 / 64.0);
        let atlas = layout(&pieces);
        let mut owner = vec![0u8; (N * N) as usize];
        let mut n_covered = 0;
        for (k, (piece, corner)) in pieces.iter().zip(&atlas.corners).enumerate() {
            let mut raw = sheet::empty();
            add(piece, &mut raw, |chart| (*corner + chart * atlas.scale) * N as f64);
            for t in &raw.triangles {
                let [a, b, c] = t.map(|i| raw.uv_sets[0].uv[i as usize].as_dvec2());
                let area = (b - a).perp_dot(c - a);
                assert!(area <= 1e-6, "piece {k} is mirrored or folded at {a}: {area}");
                let (low, high) = (a.min(b).min(c).floor(), a.max(b).max(c).ceil());
                assert!(
                    low.min_element() >= 4.0 && high.max_element() <= (N - 4) as f64,
                    "piece {k} leaves the square"
                );
                for y in low.y as i32..high.y as i32 {
                    for x in low.x as i32..high.x as i32 {
                        let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                        let is_in = |a: DVec2, b: DVec2| (b - a).perp_dot(p - a) < 0.0;
                        if is_in(a, b) && is_in(b, c) && is_in(c, a) {
                            let cell = &mut owner[(y * N + x) as usize];
                            assert!(*cell == 0, "piece {k} covers texel {x},{y} of piece {}", *cell - 1);
                            *cell = k as u8 + 1;
                            n_covered += 1;
                        }
                    }
                }
            }
        }
        for y in 4..N - 4 {
            for x in 4..N - 4 {
                let own = owner[(y * N + x) as usize];
                let is_alone = |o: u8| own == 0 || o == 0 || o == own;
                for (dx, dy) in [(4, 0), (0, 4), (3, 3), (3, -3), (2, 0), (0, 2), (1, 0), (0, 1)] {
                    assert!(is_alone(owner[((y + dy) * N + x + dx) as usize]), "two charts meet at {x},{y}");
                }
            }
        }
        let share = n_covered as f64 / (N * N) as f64;
        assert!(share > 0.4, "only {share} of the texture is used");
    }

    /// Singular values of the map from surface to texture, relative to the atlas's scale.
    #[test]
    fn lengths_on_the_surface_are_nearly_those_in_the_texture() {
        let scene = scene(96, 16, 1);
        let scale = layout(&shape::pieces(6.0 / 96.0)).scale;
        let (mut stretches, mut total) = (Vec::new(), 0.0);
        for t in scene.mesh.triangles() {
            let [a, b, c] = t.map(|i| scene.mesh.positions()[i as usize].as_dvec3());
            let [p, q, r] = t.map(|i| scene.mesh.uv_sets()[0].uv[i as usize].as_dvec2() / scale);
            let (e, f) = (b - a, c - a);
            let area = e.cross(f).length();
            let x = e.normalize();
            let y = (f - x * x.dot(f)).normalize();
            // Columns: texture change for a unit step along x and y.
            let along = (q - p) / e.length();
            let across = ((r - p) - along * f.dot(x)) / f.dot(y);
            let (trace, det) = (along.length_squared() + across.length_squared(), along.perp_dot(across).abs());
            let root = (trace * trace - 4.0 * det * det).max(0.0).sqrt();
            let (high, low) = (((trace + root) / 2.0).sqrt(), ((trace - root) / 2.0).max(0.0).sqrt());
            stretches.push((high.max(1.0 / low.max(1e-3)), area));
            total += area;
        }
        stretches.sort_by(|a, b| a.0.total_cmp(&b.0));
        let quantile = |q: f64| {
            let mut sum = 0.0;
            stretches
                .iter()
                .find(|s| {
                    sum += s.1;
                    sum >= q * total
                })
                .unwrap()
                .0
        };
        println!("stretch: median {:.3}, 90 % {:.3}, 95 % {:.3}", quantile(0.5), quantile(0.9), quantile(0.95));
        assert!(quantile(0.5) < 1.3 && quantile(0.9) < 2.0, "{} {}", quantile(0.5), quantile(0.9));
    }

    #[test]
    fn the_same_seed_gives_the_same_bytes() {
        let (a, b, c) = (scene(16, 64, 5), scene(16, 64, 5), scene(16, 64, 6));
        assert!(a.mesh.positions() == b.mesh.positions() && a.images == b.images && a.images != c.images);
    }
}
