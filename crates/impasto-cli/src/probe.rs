//! `impasto probe`: what is at a pixel.

use crate::options::Look;
use crate::report;
use anyhow::{Result, bail};
use impasto::color::srgb8_from_linear;
use impasto::inspect::{self, Found, Probe};
use impasto::par::Workers;
use impasto::recipe::{self, Prepared};
use impasto::visibility::Samples;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// Tell all that is known of the surface behind a pixel: triangle, texels, position, normal, every field.
///
/// The view options are those of `impasto render`, so that the pixel is the one of that picture. Over `--camera atlas`
/// the pixel is a texel.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  impasto probe model.glb --at 640,360
  impasto probe scan.ply --at 100,200 --camera front --size 800x600 --json
  impasto probe sample:chameleon --at 512,512 --camera atlas")]
pub(crate) struct Args {
    #[command(flatten)]
    look: Look,
    /// Column and row of the pixel, from the top left, counted from 0.
    #[arg(long, value_name = "X,Y", value_parser = cell)]
    at: [u32; 2],
    /// As JSON.
    #[arg(long)]
    json: bool,
}

fn cell(text: &str) -> Result<[u32; 2], String> {
    let numbers: Vec<u32> = text.split(',').filter_map(|s| s.trim().parse().ok()).collect();
    numbers.try_into().map_err(|_| "write column and row, such as 640,360".into())
}

pub(crate) fn run(args: &Args, workers: &Workers) -> Result<()> {
    let report = recipe::prepare(&args.look.recipe()?, Path::new(""), workers)?;
    let prepared = &report.value;
    let [x, y] = args.at;
    if x >= prepared.size.width || y >= prepared.size.height {
        bail!("pixel {x},{y} is outside of the picture of {}", prepared.size);
    }
    let probe = inspect::probe(&prepared.domain(), &prepared.shot(Samples::One), args.at, workers);
    if args.json {
        return report::out(&to_json(&probe, prepared).to_string());
    }
    report::mended(&report.mended);
    report::out(&to_text(&probe, prepared)?)
}

fn names(found: &Found, prepared: &Prepared) -> (String, String) {
    let part = &prepared.scene.mesh.parts()[found.part];
    let material = part.material.and_then(|m| prepared.scene.materials.get(m as usize));
    (part.name.clone(), material.map_or_else(|| prepared.looks.looks[found.look].name.clone(), |m| m.name.clone()))
}

fn to_json(probe: &Probe, prepared: &Prepared) -> Value {
    let found: Vec<Value> = probe.found.iter().map(|f| found_json(f, prepared)).collect();
    json!({"pixel": probe.cell, "surfaces": found, "unlit": probe.unlit, "unlit_srgb": srgb(probe)})
}

fn srgb(probe: &Probe) -> [u8; 3] {
    let [r, g, b, a] = probe.unlit;
    let k = if a > 0.0 { 1.0 / a } else { 0.0 };
    [r, g, b].map(|x| srgb8_from_linear(x * k))
}

/// A number that JSON can hold: missing values are null.
fn number(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { Value::Null }
}

fn found_json(f: &Found, prepared: &Prepared) -> Value {
    let mesh = &prepared.scene.mesh;
    let (part, material) = names(f, prepared);
    let uv: serde_json::Map<String, Value> =
        mesh.uv_sets().iter().zip(&f.uv).map(|(set, uv)| (set.name.clone(), json!(uv))).collect();
    let fields: serde_json::Map<String, Value> = mesh
        .fields()
        .iter()
        .zip(&f.fields)
        .map(|(field, v)| {
            let numbers: Vec<Value> = v.iter().map(|x| number(*x)).collect();
            let value = if let [one] = &numbers[..] { one.clone() } else { json!(numbers) };
            (field.name.clone(), json!({"value": value, "unit": field.unit}))
        })
        .collect();
    let texels: Vec<Value> = f
        .texels
        .iter()
        .map(|t| {
            let at = t.texel.map(|a| json!([a.u, a.v]));
            json!({"layer": t.layer, "image": t.image, "size": [t.size.width, t.size.height], "st": t.st, "texel": at})
        })
        .collect();
    json!({
        "triangle": f.triangle, "face": f.source_face, "vertices": f.vertices, "part": part, "material": material,
        "barycentric": f.barycentric, "depth": f.depth, "distance": f.distance, "front": f.is_front,
        "position": f.position.to_array(), "normal": f.normal.to_array(), "shading_normal": f.shading_normal.to_array(),
        "uv": uv, "texels": texels, "fields": fields,
        "color": f.color, "alpha": f.alpha, "roughness": f.roughness, "metalness": f.metalness, "info": f.info,
    })
}

fn to_text(probe: &Probe, prepared: &Prepared) -> Result<String> {
    let mut text = String::new();
    let [x, y] = probe.cell;
    if probe.found.is_empty() {
        writeln!(text, "pixel {x},{y}: nothing is there")?;
        return Ok(text);
    }
    let [r, g, b] = srgb(probe);
    writeln!(text, "pixel {x},{y}: #{r:02x}{g:02x}{b:02x} under no light")?;
    for (i, f) in probe.found.iter().enumerate() {
        if probe.found.len() > 1 {
            writeln!(text, "surface {} of {}", i + 1, probe.found.len())?;
        }
        found_text(&mut text, f, prepared)?;
    }
    Ok(text)
}

fn found_text(text: &mut String, f: &Found, prepared: &Prepared) -> Result<()> {
    let mesh = &prepared.scene.mesh;
    let list = |v: &[f32]| v.iter().map(|x| format!("{x:.6}")).collect::<Vec<_>>().join("  ");
    let mut line = |key: &str, value: String| writeln!(text, "  {key:<16}{value}");
    let (part, material) = names(f, prepared);
    let side = if f.is_front { "front" } else { "back" };
    line(
        "triangle",
        format!("{} ({side}), face {} of the file, vertices {:?}", f.triangle, f.source_face, f.vertices),
    )?;
    line("part", if part.is_empty() { format!("{}", f.part) } else { format!("{} {part:?}", f.part) })?;
    line("material", material)?;
    line("barycentric", list(&f.barycentric))?;
    line("depth", format!("{} (1/w), {} from the eye", f.depth, f.distance))?;
    line("position", list(&f.position.to_array()))?;
    line("normal", list(&f.normal.to_array()))?;
    if f.shading_normal != f.normal {
        line("shading normal", list(&f.shading_normal.to_array()))?;
    }
    for (set, uv) in mesh.uv_sets().iter().zip(&f.uv) {
        line(&format!("uv {}", set.name), list(uv))?;
    }
    for (i, t) in f.texels.iter().enumerate() {
        // Layers that share a reading are told once.
        if i > 0 && (&f.texels[i - 1].image, f.texels[i - 1].st) == (&t.image, t.st) {
            continue;
        }
        let at = t.texel.map_or("not applied here".into(), |a| format!("texel {}, {} of {}", a.u, a.v, t.size));
        line("texture", format!("{:?}: {at}, st {}", t.image, list(&t.st)))?;
    }
    for (field, values) in mesh.fields().iter().zip(&f.fields) {
        let values: Vec<String> =
            values.iter().map(|x| if x.is_finite() { format!("{x}") } else { "missing".into() }).collect();
        line(&field.name, format!("{} {}", values.join("  "), field.unit).trim_end().to_owned())?;
    }
    line("color", format!("{}  (linear), alpha {}", list(&f.color), f.alpha))?;
    line("roughness", format!("{}, metalness {}", f.roughness, f.metalness))?;
    Ok(())
}
