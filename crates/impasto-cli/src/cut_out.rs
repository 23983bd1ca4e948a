//! Pieces of a cut as files: meshes, and maps of their caps.

use crate::render::info_count;
use crate::report;
use anyhow::{Context, Result, bail};
use impasto::assets::files;
use impasto::error::Mended;
use impasto::par::Workers;
use impasto::recipe::cut::{self, Dress, Piece, Pieces};
use impasto::recipe::{Recipe, source};
use impasto::section::grain::Side;
use impasto::section::{self, cut::volume, shader::Language};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A file to be written, and how.
type ToWrite<'a> = (PathBuf, Box<dyn Fn(&Path) -> impasto::Result<Vec<Mended>> + 'a>);

/// Writes the pieces that the recipe asks for, all or none, and tells of each.
pub(crate) fn write(
    recipe: &Recipe,
    path: &Path,
    (maps, as_json): (Option<u32>, bool),
    workers: &Workers,
) -> Result<()> {
    let start = Instant::now();
    let cut = recipe.cut.as_ref().context("nothing to cut")?;
    if cut.kind.as_deref() == Some("each") {
        bail!("kind \"each\" is for pictures: a mesh has one of tear, hollow and solid");
    }
    let shown = cut::shown(cut)?;
    let scene = source::scene(&recipe.input, Path::new(""))?;
    let seed = recipe.input.seed.unwrap_or(1);
    let dress = maps.map_or(Dress::Corners, Dress::Maps);
    let Pieces { pieces, gaps, mended: remarks, .. } =
        cut::pieces(cut, &scene.value, (Path::new(""), seed), dress, workers)?;
    let pieces: Vec<&Piece> =
        pieces.iter().filter(|p| shown[(p.sides.first() == Some(&Side::Above)) as usize]).collect();
    let mut mended = scene.mended;
    mended.extend(remarks);

    let mut all: Vec<ToWrite> = Vec::new();
    let mut told = Vec::new();
    for piece in &pieces {
        let own = named(path, &piece.letters());
        let n_triangles = piece.scene.mesh.triangles().len();
        let volume = volume(piece.scene.mesh.positions(), piece.scene.mesh.triangles());
        let mut heights = Vec::new();
        all.push((own.clone(), Box::new(|path| files::save_mesh(path, &piece.scene))));
        for (k, (_, maps)) in piece.maps.iter().enumerate() {
            let cap = if piece.maps.len() > 1 { format!("-{}", k + 1) } else { String::new() };
            let beside = |what: &str| {
                let stem = own.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                own.with_file_name(format!("{stem}{cap}-{what}.png"))
            };
            heights.push(json!({ "file": beside("height"), "range": maps.heights().1 }));
            for (what, bytes) in maps.files() {
                all.push((beside(what), Box::new(move |path| save(path, &bytes))));
            }
        }
        told.push((own, n_triangles, volume, heights));
    }
    let mut written: Vec<&Path> = Vec::new();
    for (path, save) in &all {
        let lost = save(path).inspect_err(|_| {
            // A part of it all is nothing to leave behind.
            written.iter().for_each(|p| drop(std::fs::remove_file(p)));
        })?;
        mended.extend(lost.into_iter().filter(|m| !mended.contains(m)).collect::<Vec<_>>());
        written.push(path);
    }

    let n_open = gaps.iter().filter(|g| !g.bridged).count();
    if as_json {
        let half = |(path, n, volume, heights): &(PathBuf, usize, f64, Vec<Value>)| json!({"path": path, "triangles": n, "volume": volume, "heights": heights});
        let gap = |g: &impasto::section::cut::Gap| json!({"from": g.from.to_array(), "to": g.to.to_array(), "length": g.length, "bridged": g.bridged});
        let mended: Vec<_> = mended.iter().map(|m| json!({"count": m.count, "what": m.what})).collect();
        let report = json!({
            "input": recipe.subject(),
            "halves": told.iter().map(half).collect::<Vec<_>>(),
            "gaps": gaps.iter().map(gap).collect::<Vec<_>>(),
            "mended": mended,
            "seconds": start.elapsed().as_secs_f64(),
        });
        return report::out(&report.to_string());
    }
    report::mended(&mended);
    let gaps = match (n_open, gaps.len() - n_open) {
        (0, 0) => "no gaps".to_owned(),
        (open, 0) => format!("gaps: {open}"),
        (open, bridged) => format!("gaps: {open}, and {bridged} bridged"),
    };
    for (path, n, volume, heights) in &told {
        report::out(&format!("{}: {} triangles, volume {volume:.6}, {gaps}", path.display(), info_count(*n)))?;
        for height in heights {
            let (file, range) = (&height["file"], &height["range"]);
            report::out(&format!("{}: heights from {} to {}", file.as_str().unwrap_or(""), range[0], range[1]))?;
        }
    }
    Ok(())
}

/// Writes the section as SVG.
pub(crate) fn drawing(recipe: &Recipe, path: &Path, unit_mm: Option<f64>) -> Result<()> {
    let cut = recipe.cut.as_ref().context("nothing to cut")?;
    let scene = source::scene(&recipe.input, Path::new(""))?;
    let on = (Path::new(""), recipe.input.seed.unwrap_or(1));
    let drawing = cut::drawing(cut, &scene.value, on, unit_mm)?;
    save(path, drawing.value.as_bytes())?;
    report::mended(&scene.mended.into_iter().chain(drawing.mended).collect::<Vec<_>>());
    let n = drawing.value.matches("data-particle").count();
    report::out(&format!("{}: {} particles", path.display(), info_count(n)))
}

/// Writes the grain as shader source.
pub(crate) fn shader(recipe: &Recipe, path: &Path, language: &str) -> Result<()> {
    let cut = recipe.cut.as_ref().context("nothing to cut")?;
    let scene = source::scene(&recipe.input, Path::new(""))?.value;
    let on = (Path::new(""), recipe.input.seed.unwrap_or(1));
    let (substance, kind) = cut::substance(cut, &scene, on)?;
    let substance = substance.context("grain \"none\" has no shader")?;
    let language = if language == "wgsl" { Language::Wgsl } else { Language::Glsl };
    let text = section::shader::source(&substance.filling, kind, language)?;
    if path == Path::new("-") {
        return report::out(&text);
    }
    save(path, text.as_bytes())?;
    report::out(&format!("{}: {} lines", path.display(), text.lines().count()))
}

/// A file with these bytes.
fn save(path: &Path, bytes: &[u8]) -> impasto::Result<Vec<Mended>> {
    files::write_atomically(path, |w| w.write_all(bytes)).map(|()| Vec::new())
}

/// `half.stl` becomes `half-a.stl`.
fn named(path: &Path, letters: &str) -> PathBuf {
    let stem = path.file_stem().map_or_else(|| "half".into(), |s| s.to_string_lossy());
    let extension = path.extension().map_or_else(String::new, |e| format!(".{}", e.to_string_lossy()));
    path.with_file_name(format!("{stem}-{letters}{extension}"))
}
