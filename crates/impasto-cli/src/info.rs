//! `impasto info`: what is in a file.

use crate::render::info_count;
use crate::report;
use anyhow::Result;
use impasto::assets::{Element, MinFilter, Sampler, Scene, Texels, TextureRef, Topology, Wrap};
use impasto::color::Encoding;
use impasto::error::{Mended, Report};
use impasto::math::Projection;
use impasto::recipe::{self, Input};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// Tell what is in a file: counts, bounds, shape, parts, materials, textures, data, cameras, lights, defects mended.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  impasto info model.glb
  impasto info scan.ply --json | jq .fields
  impasto info part.stl --up y
  impasto info cortex.surf.gii --field thickness.csv
  impasto info sample:chameleon")]
pub(crate) struct Args {
    /// A mesh, a scene, a height map, a grid, a molecule, or sample:NAME.
    file: String,
    /// The file's axis that points up: auto, y or z.
    #[arg(long, value_name = "AXIS")]
    up: Option<String>,
    /// Of grids: the value whose isosurface is shown; without it one that suits the values.
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    isolevel: Option<f64>,
    /// Of samples: how fine the surface is.
    #[arg(long, value_name = "N")]
    resolution: Option<u32>,
    /// Of samples: another seed is another one of the same kind.
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    /// Values of another file as fields, as `impasto render --field` takes them. May be repeated.
    #[arg(long = "field", value_name = "FILE[:COLUMN]")]
    fields: Vec<String>,
    /// As JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let input = Input {
        file: Some(args.file.clone()),
        up: args.up.clone(),
        isolevel: args.isolevel,
        resolution: args.resolution,
        seed: args.seed,
        fields: args.fields.clone(),
        ..Input::default()
    };
    let Report { value: scene, mended } = recipe::source::scene(&input, Path::new(""))?;
    match args.json {
        true => report::out(&serde_json::to_string_pretty(&to_json(&scene, &mended))?),
        false => report::out(&to_text(&scene, &mended)?),
    }
}

/// A sheet of keys and values, keys aligned, later lines of a value under the first.
struct Sheet {
    text: String,
}

impl Sheet {
    fn line(&mut self, key: &str, value: impl AsRef<str>) -> std::fmt::Result {
        writeln!(self.text, "{key:<12}  {}", value.as_ref())
    }

    /// Rows of a table, columns as wide as their widest entry; columns that `right` names stand to the right.
    fn table(&mut self, key: &str, rows: &[Vec<String>], right: &[usize]) -> std::fmt::Result {
        let n = rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..n).map(width).collect();
        for (i, row) in rows.iter().enumerate() {
            let mut line = String::new();
            for (c, entry) in row.iter().enumerate() {
                let space = " ".repeat(widths[c] - entry.chars().count());
                let (before, after) = if right.contains(&c) { (space.as_str(), "") } else { ("", space.as_str()) };
                write!(line, "{before}{entry}{after}  ")?;
            }
            self.line(if i == 0 { key } else { "" }, line.trim_end())?;
        }
        Ok(())
    }
}

fn to_text(scene: &Scene, mended: &[Mended]) -> Result<String> {
    let mesh = &scene.mesh;
    let mut sheet = Sheet { text: String::new() };
    sheet.line("file", &scene.name)?;
    let up = if scene.up_note.is_empty() { "+Y, as the file has it" } else { &scene.up_note };
    let counts =
        format!("{} triangles, {} vertices", info_count(mesh.triangles().len()), info_count(mesh.positions().len()));
    sheet.line("surface", counts)?;
    let topology = Topology::of(mesh);
    sheet.line("shape", shape(&topology))?;
    let b = mesh.bounds();
    if !b.is_empty() {
        let rows: Vec<Vec<String>> = (0..3)
            .map(|k| {
                let axis = ["x", "y", "z"][k].to_owned();
                vec![
                    axis,
                    short(b.min[k] as f64),
                    "to".into(),
                    short(b.max[k] as f64),
                    format!("({})", short(b.extent()[k] as f64)),
                ]
            })
            .collect();
        sheet.table("bounds", &rows, &[1, 3])?;
    }
    sheet.line("up", up)?;
    let attributes = [
        (!mesh.normals().is_empty(), "normals"),
        (!mesh.tangents().is_empty(), "tangents"),
        (!mesh.colors().is_empty(), "colours"),
    ];
    let there: Vec<&str> = attributes.iter().filter(|(is, _)| *is).map(|(_, n)| *n).collect();
    sheet.line(
        "vertices",
        if there.is_empty() { "positions only".into() } else { format!("with {}", there.join(", ")) },
    )?;
    match mesh.uv_sets().len() {
        0 => sheet.line("uv sets", "none; --unwrap makes one")?,
        _ => sheet.table("uv sets", &uv_rows(scene), &[2, 4, 7, 9])?,
    }
    if mesh.parts().len() > 1 || mesh.parts().iter().any(|p| !p.name.is_empty() || p.material.is_some()) {
        sheet.table("parts", &part_rows(scene), &[1])?;
    }
    if !scene.materials.is_empty() {
        sheet.table("materials", &material_rows(scene), &[])?;
    }
    if !scene.images.is_empty() {
        sheet.table("images", &image_rows(scene), &[])?;
    }
    if !mesh.fields().is_empty() {
        sheet.table("fields", &field_rows(scene), &[2, 4])?;
    }
    if !scene.cameras.is_empty() {
        let rows: Vec<Vec<String>> = scene.cameras.iter().enumerate().map(|(i, c)| camera_row(i, c)).collect();
        sheet.table("cameras", &rows, &[])?;
    }
    if !scene.lights.is_empty() {
        let rows: Vec<Vec<String>> = scene.lights.iter().map(|l| vec![name(&l.name), light_kind(l).into()]).collect();
        sheet.table("lights", &rows, &[])?;
    }
    match mended {
        [] => sheet.line("mended", "nothing")?,
        _ => {
            let rows: Vec<Vec<String>> = mended.iter().map(|m| vec![info_count(m.count), m.what.clone()]).collect();
            sheet.table("mended", &rows, &[0])?;
        }
    }
    Ok(sheet.text)
}

/// A few significant digits, enough to compare.
fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        a if (1e-4..1e7).contains(&a) => {
            let decimals = (5 - a.log10().floor() as i32).clamp(0, 8) as usize;
            let text = format!("{x:.decimals$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
        }
        _ => format!("{x:.4e}"),
    }
}

fn shape(t: &Topology) -> String {
    let bodies = format!("{} {}", info_count(t.n_pieces), if t.n_pieces == 1 { "body" } else { "bodies" });
    let mut text = match t.genus() {
        Some(genus) => format!("closed, {bodies}, genus {genus}"),
        None => format!("open, {bodies}, {} border edges", info_count(t.n_border_edges)),
    };
    if t.n_non_manifold_edges > 0 {
        let _ = write!(text, ", {} edges with more than two triangles", info_count(t.n_non_manifold_edges));
    }
    if t.n_inconsistent_edges > 0 {
        let _ = write!(text, ", {} edges wound against each other", info_count(t.n_inconsistent_edges));
    }
    text
}

fn name(name: &str) -> String {
    if name.is_empty() { "(no name)".into() } else { name.into() }
}

fn uv_rows(scene: &Scene) -> Vec<Vec<String>> {
    let rows = scene.mesh.uv_sets().iter().map(|set| {
        let mut range = [[f32::INFINITY; 2], [f32::NEG_INFINITY; 2]];
        for uv in &set.uv {
            for k in 0..2 {
                range[0][k] = range[0][k].min(uv[k]);
                range[1][k] = range[1][k].max(uv[k]);
            }
        }
        let [lo, hi] = range;
        let words = |k: usize| [short(lo[k] as f64), "to".into(), short(hi[k] as f64)];
        let mut row = vec![name(&set.name), "u".into()];
        row.extend(words(0));
        row.extend([" ".into(), "v".into()]);
        row.extend(words(1));
        row
    });
    rows.collect()
}

fn part_rows(scene: &Scene) -> Vec<Vec<String>> {
    let material =
        |m: Option<u32>| m.and_then(|m| scene.materials.get(m as usize)).map_or("clay".into(), |m| name(&m.name));
    let row = |p: &impasto::assets::Part| {
        vec![name(&p.name), format!("{} triangles", info_count(p.triangles.len())), material(p.material)]
    };
    scene.mesh.parts().iter().map(row).collect()
}

fn material_rows(scene: &Scene) -> Vec<Vec<String>> {
    let texture = |what: &str, t: &Option<TextureRef>| {
        t.as_ref().map(|t| {
            let image = scene.images.get(t.image as usize).map_or("?", |i| i.name.as_str());
            format!("{what} {image:?} {}", sampler(&t.sampler))
        })
    };
    let mut rows = Vec::new();
    for m in &scene.materials {
        let [r, g, b, a] = m.base_color.map(short_f32);
        let mut traits = vec![format!("color {r} {g} {b}")];
        if m.base_color[3] != 1.0 {
            traits.push(format!("alpha {a}"));
        }
        traits.push(if m.unlit {
            "unlit".into()
        } else {
            format!("metalness {} roughness {}", short_f32(m.metalness), short_f32(m.roughness))
        });
        match m.alpha_mode {
            impasto::assets::AlphaMode::Opaque => {}
            impasto::assets::AlphaMode::Mask(cutoff) => traits.push(format!("mask {}", short_f32(cutoff))),
            impasto::assets::AlphaMode::Blend => traits.push("blend".into()),
        }
        if m.double_sided {
            traits.push("two-sided".into());
        }
        if m.clearcoat.strength > 0.0 {
            traits.push(format!("clear coat {}", short_f32(m.clearcoat.strength)));
        }
        rows.push(vec![name(&m.name), traits.join(", ")]);
        let textures = [
            ("color", &m.base_color_texture),
            ("metal-rough", &m.metal_rough_texture),
            ("normal", &m.normal_texture),
            ("bump", &m.bump_texture),
            ("occlusion", &m.occlusion_texture),
            ("emission", &m.emission_texture),
            ("alpha", &m.alpha_texture),
            ("coat", &m.clearcoat.strength_texture),
            ("coat roughness", &m.clearcoat.roughness_texture),
            ("coat normal", &m.clearcoat.normal_texture),
        ];
        rows.extend(textures.iter().filter_map(|(what, t)| texture(what, t)).map(|t| vec![String::new(), t]));
    }
    rows
}

fn short_f32(x: f32) -> String {
    short((x as f64 * 1e4).round() / 1e4)
}

fn wrap(w: Wrap) -> &'static str {
    match w {
        Wrap::Repeat => "repeat",
        Wrap::MirroredRepeat => "mirrored-repeat",
        Wrap::ClampToEdge => "clamp-to-edge",
        Wrap::ClampToBorder => "clamp-to-border",
    }
}

fn min(m: MinFilter) -> &'static str {
    match m {
        MinFilter::Nearest => "nearest",
        MinFilter::Linear => "linear",
        MinFilter::NearestMipmapNearest => "nearest-mipmap-nearest",
        MinFilter::LinearMipmapNearest => "linear-mipmap-nearest",
        MinFilter::NearestMipmapLinear => "nearest-mipmap-linear",
        MinFilter::LinearMipmapLinear => "linear-mipmap-linear",
    }
}

fn sampler(s: &Sampler) -> String {
    let [a, b, _] = s.wrap.map(wrap);
    let wraps = if a == b { a.to_owned() } else { format!("{a}/{b}") };
    let mag = if s.mag == impasto::assets::Filter::Nearest { "nearest" } else { "linear" };
    format!("{wraps}, {mag}, {}", min(s.min))
}

fn texels(t: &Texels) -> &'static str {
    match t {
        Texels::U8(_) => "8 bits",
        Texels::U16(_) => "16 bits",
        Texels::F32(_) => "float",
    }
}

fn encoding(e: Encoding) -> &'static str {
    if e == Encoding::Srgb { "sRGB" } else { "linear" }
}

fn image_rows(scene: &Scene) -> Vec<Vec<String>> {
    let channels = |n: u8| ["grey", "grey + alpha", "RGB", "RGBA"][(n.clamp(1, 4) - 1) as usize].to_owned();
    let row = |i: &impasto::assets::TextureImage| {
        vec![
            name(&i.name),
            i.texels.size().to_string(),
            channels(i.n_channels),
            texels(&i.texels).into(),
            encoding(i.encoding).into(),
        ]
    };
    scene.images.iter().map(row).collect()
}

fn element(e: Element) -> &'static str {
    match e {
        Element::Vertex => "vertex",
        Element::Face => "face",
        Element::Corner => "corner",
    }
}

fn field_rows(scene: &Scene) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for f in scene.mesh.fields() {
        for c in 0..f.n_components {
            let range = f.range(c);
            let label = match (c, f.n_components) {
                (_, 1) => f.name.clone(),
                _ => format!("{}.{c}", f.name),
            };
            let mut row = vec![label, format!("per {}", element(f.element))];
            match range.min <= range.max {
                true => row.extend([short(range.min), "to".into(), short(range.max)]),
                false => row.extend(["".into(), "".into(), "".into()]),
            }
            row.push(f.unit.clone());
            row.push(if range.n_missing > 0 {
                format!("{} missing", info_count(range.n_missing))
            } else {
                String::new()
            });
            rows.push(row);
        }
    }
    rows
}

fn camera_row(i: usize, c: &impasto::assets::SceneCamera) -> Vec<String> {
    let lens = match c.projection {
        Projection::Perspective { fov_y } => format!("{:.1} degrees", fov_y.to_degrees()),
        Projection::Orthographic { height } => format!("parallel, {} high", short(height as f64)),
    };
    vec![i.to_string(), name(&c.name), lens]
}

fn light_kind(l: &impasto::assets::SceneLight) -> &'static str {
    match l.kind {
        impasto::assets::SceneLightKind::Directional(_) => "directional",
        impasto::assets::SceneLightKind::Point(_) => "point",
        impasto::assets::SceneLightKind::Spot { .. } => "spot",
    }
}

fn to_json(scene: &Scene, mended: &[Mended]) -> Value {
    let mesh = &scene.mesh;
    let b = mesh.bounds();
    let bounds = (!b.is_empty()).then(|| json!({"min": b.min.to_array(), "max": b.max.to_array()}));
    let t = Topology::of(mesh);
    let texture = |r: &Option<TextureRef>| {
        r.map(|r| json!({"image": r.image, "uv_set": r.uv_set, "wrap": r.sampler.wrap.map(wrap), "min": min(r.sampler.min)}))
    };
    let fields: Vec<Value> = mesh
        .fields()
        .iter()
        .map(|f| {
            let ranges: Vec<Value> = (0..f.n_components)
                .map(|c| f.range(c))
                .map(|r| match r.min <= r.max {
                    true => json!({"min": r.min, "max": r.max, "missing": r.n_missing}),
                    false => json!({"missing": r.n_missing}),
                })
                .collect();
            json!({"name": f.name, "unit": f.unit, "element": element(f.element), "components": f.n_components, "ranges": ranges})
        })
        .collect();
    let materials: Vec<Value> = scene
        .materials
        .iter()
        .map(|m| {
            json!({
                "name": m.name, "base_color": m.base_color, "metalness": m.metalness, "roughness": m.roughness,
                "unlit": m.unlit, "double_sided": m.double_sided, "alpha_mode": format!("{:?}", m.alpha_mode),
                "base_color_texture": texture(&m.base_color_texture), "normal_texture": texture(&m.normal_texture),
                "metal_rough_texture": texture(&m.metal_rough_texture), "occlusion_texture": texture(&m.occlusion_texture),
                "emission_texture": texture(&m.emission_texture),
            })
        })
        .collect();
    json!({
        "file": scene.name,
        "up": scene.up_note,
        "vertices": mesh.positions().len(),
        "triangles": mesh.triangles().len(),
        "bounds": bounds,
        "topology": {
            "closed": t.is_closed(), "bodies": t.n_pieces, "genus": t.genus(), "euler": t.euler(), "border_edges": t.n_border_edges,
            "non_manifold_edges": t.n_non_manifold_edges, "inconsistent_edges": t.n_inconsistent_edges, "edges": t.n_edges,
            "places": t.n_places,
        },
        "uv_sets": mesh.uv_sets().iter().map(|s| s.name.clone()).collect::<Vec<_>>(),
        "has_tangents": !mesh.tangents().is_empty(),
        "has_colors": !mesh.colors().is_empty(),
        "parts": mesh.parts().iter().map(|p| json!({"name": p.name, "triangles": p.triangles.len(), "material": p.material})).collect::<Vec<_>>(),
        "materials": materials,
        "images": scene.images.iter().map(|i| json!({
            "name": i.name, "size": [i.texels.size().width, i.texels.size().height], "channels": i.n_channels,
            "texels": texels(&i.texels), "encoding": encoding(i.encoding),
        })).collect::<Vec<_>>(),
        "fields": fields,
        "cameras": scene.cameras.iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
        "lights": scene.lights.iter().map(|l| json!({"name": l.name, "kind": light_kind(l)})).collect::<Vec<_>>(),
        "mended": mended.iter().map(|m| json!({"count": m.count, "what": m.what})).collect::<Vec<_>>(),
    })
}
