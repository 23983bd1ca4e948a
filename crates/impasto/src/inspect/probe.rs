//! What is at this cell? All that is known of the surface points behind one pixel or texel, nearest first.

use crate::assets::{Element, Field, Mesh};
use crate::color::{LinearRgb, LinearRgba};
use crate::inspect::address::{TexelAddress, texel};
use crate::lookup::{self, Look, Points, Surfaces, Texture, Wanted};
use crate::math::{Size, Vec3};
use crate::par::Workers;
use crate::picture::render::{self, Shot};
use crate::placement::{self, Measures, Missing, Needs, Surfels, TexCoords, mixed};
use crate::visibility::{self, Domain, Hit, InfoBuffer, Samples, TILE};
use fearless_simd::Fallback;

/// What is seen at the centre of a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Column and row.
    pub cell: [u32; 2],
    /// Surfaces there, nearest first; all but the last let light through. Empty: nothing is there.
    pub found: Vec<Found>,
    /// Their colours laid over each other, premultiplied, linear, under no light: what an unlit picture of one sample has
    /// at this pixel before its background.
    pub unlit: LinearRgba,
}

/// A surface point and what is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Index into the mesh's triangles.
    pub triangle: u32,
    /// The file's polygon.
    pub source_face: u32,
    /// The triangle's vertices.
    pub vertices: [u32; 3],
    /// Index into the mesh's parts.
    pub part: usize,
    /// Index into the looks.
    pub look: usize,
    /// Weights of the three corners, in space.
    pub barycentric: [f32; 3],
    /// 1/w: larger is nearer (perspective); 1 to 2 for parallel lines of sight; 1 over an atlas.
    pub depth: f32,
    /// From the eye, model units.
    pub distance: f32,
    /// Whether the triangle's front is seen.
    pub is_front: bool,
    /// World space.
    pub position: Vec3,
    /// World space, unit, as the mesh has it.
    pub normal: Vec3,
    /// World space, unit, towards the side that is seen, bumps applied.
    pub shading_normal: Vec3,
    /// One pair for each of the mesh's UV sets.
    pub uv: Vec<[f32; 2]>,
    /// For each image layer of the look, where it is read.
    pub texels: Vec<Texel>,
    /// For each of the mesh's fields, its numbers here; NaN is missing.
    pub fields: Vec<Vec<f64>>,
    /// Linear, under no light.
    pub color: LinearRgb,
    /// Opacity.
    pub alpha: f32,
    /// Perceptual.
    pub roughness: f32,
    /// 0 dielectric to 1 metal.
    pub metalness: f32,
    /// What layers wrote as information.
    pub info: [f32; 4],
}

/// Where a layer reads its image.
#[derive(Clone, Debug, PartialEq)]
pub struct Texel {
    /// Index into the look's layers.
    pub layer: usize,
    /// The image's name.
    pub image: String,
    /// Texels across and down.
    pub size: Size,
    /// Texture coordinates, after the layer's matrix.
    pub st: [f32; 2],
    /// Column and row; none where the texture is not applied.
    pub texel: Option<TexelAddress>,
}

/// What is at a cell of a view of one sample a cell; `cell` lies in the grid.
pub fn probe(domain: &Domain, shot: &Shot, cell: [u32; 2], workers: &Workers) -> Probe {
    let shot = &Shot { samples: Samples::One, ..*shot };
    let buffer = render::info_buffer(domain, shot, workers);
    let [n_x, _] = visibility::tile::n_tiles(buffer.size);
    let tile = &buffer.tiles[cell[1] as usize / TILE * n_x + cell[0] as usize / TILE];
    let at = cell[1] as usize % TILE * TILE + cell[0] as usize % TILE;
    let layers = if tile.touched { &tile.layers[..tile.n_layers] } else { &[] };
    let hits = layers.iter().chain(std::iter::once(&tile.solid)).filter_map(|l| {
        let triangle = l.ids.get(at).copied().unwrap_or(Hit::NOTHING);
        (triangle != Hit::NOTHING).then(|| (triangle, l.depths[at]))
    });
    let found: Vec<Found> = hits.map(|(triangle, depth)| find(domain, shot, cell, (triangle, depth))).collect();
    Probe { cell, unlit: laid_over(&found, shot), found }
}

/// As the tile loop lays layers over each other.
fn laid_over(found: &[Found], shot: &Shot) -> LinearRgba {
    let (mut light, mut through) = ([0.0f32; 4], 1.0f32);
    for f in found {
        let blends = shot.looks.looks[f.look].alpha_mode == crate::assets::AlphaMode::Blend;
        let alpha = if blends { f.alpha } else { 1.0 };
        let weight = through * alpha;
        through *= 1.0 - alpha;
        (0..3).for_each(|c| light[c] += weight * f.color[c]);
        light[3] += weight;
    }
    light
}

/// The part a triangle belongs to.
pub(super) fn part_of(mesh: &Mesh, triangle: u32) -> usize {
    mesh.parts().partition_point(|p| p.triangles.end <= triangle)
}

fn find(domain: &Domain, shot: &Shot, cell: [u32; 2], (triangle, depth): (u32, f32)) -> Found {
    let mesh = domain.mesh;
    let part = part_of(mesh, triangle);
    let look_index = shot.looks.look_of_part[part] as usize;
    let look = &shot.looks.looks[look_index];

    // The same calls as the picture's, for a batch of one.
    let mut surfels = Surfels::new(mesh.uv_sets().len());
    surfels.n = 1;
    surfels.cell[0][0] = cell[0];
    surfels.cell[1][0] = cell[1];
    surfels.triangle[0] = triangle;
    let everything = Needs {
        position: true,
        normal: true,
        tangent: !mesh.tangents().is_empty(),
        color: !mesh.colors().is_empty(),
        view: true,
        derivatives: true,
        uv_sets: ((1u64 << mesh.uv_sets().len().min(32)) - 1) as u32,
    };
    let mut scratch = lookup::Scratch::new();
    let mut surfaces = Surfaces::new();
    // Any level gives the same bits; for one point the scalar one does.
    let simd = Fallback::new();
    visibility::fill(simd, domain, everything, &visibility::CENTER, &mut surfels);
    let points = Points { mesh, view: &domain.view, surfels: &surfels, wanted: Wanted::All };
    lookup::evaluate(simd, (shot.looks, look_index), points, &mut scratch, &mut surfaces);

    let lane3 = |l: &[crate::math::Lane; 3]| Vec3::new(l[0][0], l[1][0], l[2][0]);
    let [b1, b2] = [surfels.barycentric[0][0], surfels.barycentric[1][0]];
    let position = lane3(&surfels.position);
    let barycentric = [1.0 - b1 - b2, b1, b2];
    Found {
        triangle,
        source_face: mesh.source_faces().get(triangle as usize).copied().unwrap_or(triangle),
        vertices: mesh.triangles()[triangle as usize],
        part,
        look: look_index,
        barycentric,
        depth,
        distance: (position - domain.view.eye).length(),
        is_front: surfels.side[0] > 0.0,
        position,
        normal: lane3(&surfels.normal),
        shading_normal: lane3(&surfaces.normal),
        uv: surfels.uv.iter().map(|c| [c.st[0][0], c.st[1][0]]).collect(),
        texels: texels(look, domain, shot, &surfels),
        fields: mesh.fields().iter().map(|f| field_at(f, mesh, triangle, [b1, b2])).collect(),
        color: [0, 1, 2].map(|c| surfaces.color[c][0]),
        alpha: surfaces.alpha[0],
        roughness: surfaces.roughness[0],
        metalness: surfaces.metalness[0],
        info: [0, 1, 2, 3].map(|c| surfaces.info[c][0]),
    }
}

fn texels(look: &Look, domain: &Domain, shot: &Shot, surfels: &Surfels) -> Vec<Texel> {
    let mut coords = TexCoords::ZERO;
    let images = look.layers.iter().enumerate().filter_map(|(i, layer)| {
        let Some(Texture::Image(image)) = shot.looks.textures.get(layer.texture.0 as usize) else { return None };
        Some((i, layer, image))
    });
    images
        .map(|(layer, l, image)| {
            let measures = &mut Measures::default();
            placement::place(&l.placement, &l.matrix, &domain.view, domain.mesh, surfels, measures, &mut coords);
            let st = [coords.st[0][0], coords.st[1][0]];
            let size = image.size();
            let wrap = image.sampler().wrap;
            let at = (texel(st[0], wrap[0], size.width), texel(st[1], wrap[1], size.height));
            let address = if let (Some(u), Some(v)) = at { Some(TexelAddress { u, v }) } else { None };
            Texel { layer, image: image.name.clone(), size, st, texel: address }
        })
        .collect()
}

/// A field's numbers at a point of a triangle, missing where the nearest corner's are.
pub(super) fn field_at(field: &Field, mesh: &Mesh, triangle: u32, [b1, b2]: [f32; 2]) -> Vec<f64> {
    let n = field.n_components;
    let value =
        |element: usize, c: usize| Some(field.values.at(element * n + c)).filter(|x| x.is_finite()).unwrap_or(f64::NAN);
    let mix = |at: [usize; 3], c: usize| mixed(at.map(|e| value(e, c)), [b1 as f64, b2 as f64], Missing::Nearest)[0];
    let t = triangle as usize;
    (0..n)
        .map(|c| match field.element {
            Element::Vertex => mix(mesh.triangles()[t].map(|v| v as usize), c),
            Element::Face => value(t, c),
            Element::Corner => mix([t * 3, t * 3 + 1, t * 3 + 2], c),
        })
        .collect()
}

/// A buffer of one sample a cell, for everything in this module.
pub fn buffer(domain: &Domain, shot: &Shot, workers: &Workers) -> InfoBuffer {
    render::info_buffer(domain, &Shot { samples: Samples::One, ..*shot }, workers)
}
