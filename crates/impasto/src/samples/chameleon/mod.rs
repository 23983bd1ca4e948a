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
