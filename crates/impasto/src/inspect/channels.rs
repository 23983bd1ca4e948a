//! The information buffer as named channels: for every cell what it sees, number by number.

use crate::assets::Mesh;
use crate::inspect::address::{TexelAddress, texel};
use crate::inspect::probe::{field_at, part_of};
use crate::lookup::{Layer, Looks, Target, Texture};
use crate::math::Size;
use crate::par::Workers;
use crate::picture::render::Shot;
use crate::placement::{self, Measures, Needs, Property, Surfels, TexCoords};
use crate::visibility::{self, BATCH_FILL, Domain, Hit, InfoBuffer};
use fearless_simd::Fallback;

/// One quantity of every cell, rows from the top, components together.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// `triangle`, `position`, a field's name after `field.` ...
    pub name: String,
    /// Names of its components: none for a single number.
    pub components: Vec<String>,
    /// As many numbers a cell as there are components (one if there are none).
    pub values: Values,
}

/// Numbers of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Ids; `u32::MAX` where nothing is.
    U32(Vec<u32>),
    /// Measures; NaN where nothing is.
    F32(Vec<f32>),
}

/// Everything a buffer of one sample a cell knows: triangle, face of the file, part, depth, barycentrics, position,
/// normal, UV sets, the texel shown, and all fields.
pub fn quantities(buffer: &InfoBuffer, domain: &Domain, shot: &Shot, workers: &Workers) -> Vec<Quantity> {
    let mesh = domain.mesh;
    let ids = buffer.ids();
    let cells: Vec<Option<u32>> = ids.iter().map(|&t| (t != Hit::NOTHING).then_some(t)).collect();
    let of_ids = |name: &str, f: &dyn Fn(u32) -> u32| Quantity {
        name: name.into(),
        components: Vec::new(),
        values: Values::U32(cells.iter().map(|t| t.map_or(u32::MAX, f)).collect()),
    };
    let face = |t: u32| mesh.source_faces().get(t as usize).copied().unwrap_or(t);
    let mut made =
        vec![of_ids("triangle", &|t| t), of_ids("face", &face), of_ids("part", &|t| part_of(mesh, t) as u32)];
    let size = buffer.size;
    let depth = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    let depth = depth.map(|(x, y)| buffer.at(x, y)).map(|(t, d)| if t == Hit::NOTHING { f32::NAN } else { d });
    made.push(Quantity { name: "depth".into(), components: vec![], values: Values::F32(depth.collect()) });

    let texels = texels_of(buffer, domain, shot, None, workers);
    let texels = texels.iter().flat_map(|t| t.map_or([u32::MAX; 2], |t| [t.u, t.v])).collect();
    made.push(Quantity { name: "texel".into(), components: words(&["u", "v"]), values: Values::U32(texels) });

    let plan = plan(mesh);
    let n: usize = plan.iter().map(|(_, c)| c.len().max(1)).sum();
    let rows = each_row(buffer, domain, everything(mesh), workers, |surfels, out: &mut Vec<f32>| {
        for i in 0..surfels.n {
            numbers(mesh, surfels, i, out);
        }
    });
    let mut first = 0;
    for (name, components) in plan {
        let k = components.len().max(1);
        let mut values = vec![f32::NAN; size.n_cells() * k];
        for (y, (columns, numbers)) in rows.iter().enumerate() {
            for (i, x) in columns.iter().enumerate() {
                let cell = y * size.width as usize + *x as usize;
                values[cell * k..][..k].copy_from_slice(&numbers[i * n + first..][..k]);
            }
        }
        first += k;
        made.push(Quantity { name, components, values: Values::F32(values) });
    }
    made
}

/// A property's value in every cell of a buffer of one sample a cell, NaN where there is none.
pub fn measured(property: &Property, buffer: &InfoBuffer, domain: &Domain, workers: &Workers) -> Vec<f32> {
    let rows = each_row(buffer, domain, property.needs(), workers, |surfels, out: &mut Vec<f32>| {
        let mut measures = Measures::default();
        let measure = measures.of(property, domain.mesh, surfels);
        out.extend(measure.value[..surfels.n].iter().map(|x| *x as f32));
    });
    let width = buffer.size.width as usize;
    let mut values = vec![f32::NAN; buffer.size.n_cells()];
    for (row, (columns, found)) in values.chunks_mut(width.max(1)).zip(rows) {
        columns.into_iter().zip(found).for_each(|(x, value)| row[x as usize] = value);
    }
    values
}

/// Names of what [`numbers`] writes.
fn plan(mesh: &Mesh) -> Vec<(String, Vec<String>)> {
    let mut plan = vec![
        ("barycentric".into(), words(&["a", "b", "c"])),
        ("position".into(), words(&["x", "y", "z"])),
        ("normal".into(), words(&["x", "y", "z"])),
    ];
    plan.extend((0..mesh.uv_sets().len()).map(|i| (format!("uv{i}"), words(&["u", "v"]))));
    for field in mesh.fields() {
        let components = if field.n_components == 1 { 0 } else { field.n_components };
        plan.push((format!("field.{}", field.name), (0..components).map(|c| c.to_string()).collect()));
    }
    plan
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|w| w.to_string()).collect()
}

fn everything(mesh: &Mesh) -> Needs {
    let uv_sets = ((1u64 << mesh.uv_sets().len().min(32)) - 1) as u32;
    Needs { position: true, normal: true, uv_sets, ..Needs::default() }
}

fn numbers(mesh: &Mesh, surfels: &Surfels, i: usize, out: &mut Vec<f32>) {
    let [b, c] = [surfels.barycentric[0][i], surfels.barycentric[1][i]];
    out.extend([1.0 - b - c, b, c]);
    out.extend(surfels.position.iter().chain(&surfels.normal).map(|lane| lane[i]));
    out.extend(surfels.uv.iter().flat_map(|uv| [uv.st[0][i], uv.st[1][i]]));
    for field in mesh.fields() {
        out.extend(field_at(field, mesh, surfels.triangle[i], [b, c]).into_iter().map(|x| x as f32));
    }
}

/// Fills surfels for each row's cells, batch by batch; answers with the columns seen and what `take` made of them.
fn each_row<T: Send>(
    buffer: &InfoBuffer,
    domain: &Domain,
    needs: Needs,
    workers: &Workers,
    take: impl Fn(&Surfels, &mut Vec<T>) + Sync + Send,
) -> Vec<(Vec<u32>, Vec<T>)> {
    workers.map(buffer.size.height as usize, |y| {
        let row = (0..buffer.size.width).map(|x| (x, buffer.at(x, y as u32).0));
        let seen: Vec<(u32, u32)> = row.filter(|(_, t)| *t != Hit::NOTHING).collect();
        let mut surfels = Surfels::new(domain.mesh.uv_sets().len());
        let mut out = Vec::new();
        for batch in seen.chunks(BATCH_FILL) {
            surfels.n = batch.len();
            for (i, (x, triangle)) in batch.iter().enumerate() {
                (surfels.cell[0][i], surfels.cell[1][i]) = (*x, y as u32);
                surfels.triangle[i] = *triangle;
            }
            // Any level gives the same bits, and this is no hot path.
            visibility::fill(Fallback::new(), domain, needs, &visibility::CENTER, &mut surfels);
            take(&surfels, &mut out);
        }
        (seen.iter().map(|(x, _)| *x).collect(), out)
    })
}

/// The layer whose image gives a look its colour.
fn addressed(looks: &Looks, look: usize) -> Option<(&Layer, &crate::lookup::ImageTexture)> {
    looks.looks[look].layers.iter().filter(|l| l.target == Target::Color).find_map(|layer| {
        match looks.textures.get(layer.texture.0 as usize) {
            Some(Texture::Image(image)) => Some((layer, image)),
            _ => None,
        }
    })
}

/// Which texel each cell shows: of the image that gives its look colour, or of a picture of `size` laid over the same
/// coordinates.
pub(super) fn texels_of(
    buffer: &InfoBuffer,
    domain: &Domain,
    shot: &Shot,
    size: Option<Size>,
    workers: &Workers,
) -> Vec<Option<TexelAddress>> {
    let mesh = domain.mesh;
    let needs = shot.looks.needs().or(everything(mesh));
    let uv = Layer::new(crate::lookup::TextureId(0), crate::lookup::Operator::Replace, Target::Color);
    let rows = each_row(buffer, domain, needs, workers, |surfels, out| {
        let mut coords = TexCoords::ZERO;
        let mut placed: Option<usize> = None;
        for i in 0..surfels.n {
            let look = shot.looks.look_of_part[part_of(mesh, surfels.triangle[i])] as usize;
            let found = addressed(shot.looks, look).map(|(l, image)| (l, image.size(), image.sampler().wrap));
            let found = match (found, size) {
                (Some((layer, _, wrap)), Some(size)) => Some((layer, size, wrap)),
                (None, Some(size)) if !mesh.uv_sets().is_empty() => Some((&uv, size, [crate::assets::Wrap::Repeat; 3])),
                (found, _) => found,
            };
            let Some((layer, size, wrap)) = found else {
                out.push(None);
                continue;
            };
            if placed != Some(look) {
                let measures = &mut Measures::default();
                placement::place(&layer.placement, &layer.matrix, &domain.view, mesh, surfels, measures, &mut coords);
                placed = Some(look);
            }
            let at = (texel(coords.st[0][i], wrap[0], size.width), texel(coords.st[1][i], wrap[1], size.height));
            out.push(if let (Some(u), Some(v)) = at { Some(TexelAddress { u, v }) } else { None });
        }
    });
    let width = buffer.size.width as usize;
    let mut texels = vec![None; buffer.size.n_cells()];
    for (y, (columns, found)) in rows.into_iter().enumerate() {
        for (x, texel) in columns.into_iter().zip(found) {
            texels[y * width + x as usize] = texel;
        }
    }
    texels
}
