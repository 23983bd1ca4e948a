//! `impasto cut`: a file to two halves with grain, as meshes or as a picture.

use crate::options::Look;
use crate::render::{self, info_count};
use crate::report;
use anyhow::{Context, Result, bail};
use impasto::assets::files::{self, MESH_FORMATS};
use impasto::par::Workers;
use impasto::recipe::cut::{self, Halves};
use impasto::recipe::{CutRecipe, Recipe, source};
use impasto::section::cut::volume;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Cut a mesh open: two closed halves whose sections show a grain of particles.
///
/// Torn, particles stay whole and go with one half, and the other has their cavities; hollow, both halves have cavities;
/// solid, both show flat discs, and what is between them is recessed. Halves come as meshes in true relief, or side by side
/// as a picture, for which all options of `render` hold.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  impasto cut bunny.ply -o cut.png
  impasto cut bunny.ply --normal 1,0,1 --at 0.4 --kind hollow --spacing 0.6 --radius 0.3 -o cut.png
  impasto cut bunny.ply --figure 9 --kind solid -o cut.png
  impasto cut sample:flange --grain cylinder --radius 0.02 --spacing 0.05 --axis 0,1,0 -o half.stl
  impasto cut scan.ply --through 0,10,0 --normal 0,1,0 --policy bridge:0.5 -o half.glb
  impasto cut part.stl --grain none --normal 0,0,1 -o half.obj
half.stl stands for half-a.stl, the half that the normal points out of, and half-b.stl.")]
pub(crate) struct Args {
    #[command(flatten)]
    look: Look,
    /// What is written: both halves as .stl, .ply, .glb, .obj or .vtp; or a picture of them, .png or .exr.
    #[arg(short, long, value_name = "OUT")]
    output: String,
    /// Normal of the cut, out of half a; any length.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, help_heading = "Cut")]
    normal: Option<[f32; 3]>,
    /// Where along the normal: 0 to 1 of the way through; absent: half-way.
    #[arg(long, value_name = "FRACTION", allow_hyphen_values = true, help_heading = "Cut")]
    at: Option<f32>,
    /// A point that the cut goes through.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, help_heading = "Cut")]
    through: Option<[f32; 3]>,
    /// Where the surface is open: winding (fill what is more inside than outside), strict (refuse), bridge:LENGTH, open.
    #[arg(long, value_name = "POLICY", help_heading = "Cut")]
    policy: Option<String>,
    /// Which half: a, b or both.
    #[arg(long, value_name = "HALF", help_heading = "Cut")]
    half: Option<String>,
    /// footprint (caps in true relief) or none (flat, only shaded).
    #[arg(long, value_name = "RELIEF", help_heading = "Cut")]
    relief: Option<String>,
    /// tear, hollow or solid.
    #[arg(long, value_name = "KIND", help_heading = "Grain")]
    kind: Option<String>,
    /// sphere, ellipsoid, cylinder, capsule, box, superquadric, tetrahedron, cube, octahedron, dodecahedron, icosahedron; none
    /// for a plain cut.
    #[arg(long, value_name = "SHAPE", help_heading = "Grain")]
    grain: Option<String>,
    /// Between particles, model units; absent: 3 % of the mesh.
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, help_heading = "Grain")]
    spacing: Option<f32>,
    /// Of particles; absent: half the spacing.
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, help_heading = "Grain")]
    radius: Option<f32>,
    /// Of particles that are longer than wide, or shorter.
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, help_heading = "Grain")]
    height: Option<f32>,
    /// Where they point; absent: anywhere.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, help_heading = "Grain")]
    axis: Option<[f32; 3]>,
    /// They point up to so far away from the axis.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, help_heading = "Grain")]
    cone: Option<f32>,
    /// How far they stand off their lattice, 0 to 0.5 spacings.
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, help_heading = "Grain")]
    jitter: Option<f32>,
    /// How much their sizes differ: 0.35 is between 65 % and 135 %.
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, help_heading = "Grain")]
    size_spread: Option<f32>,
    /// Particles and normal of Li 2022, Fig. 6 to 12, scaled to the height of the mesh.
    #[arg(long, value_name = "N", conflicts_with_all = ["grain", "spacing", "radius", "height"], help_heading = "Grain")]
    figure: Option<u32>,
    /// fixed, or paper: the formulas of Li 2022 with their slips.
    #[arg(long, value_name = "NAME", help_heading = "Grain")]
    profile: Option<String>,
    /// Colour between the particles.
    #[arg(long, value_name = "COLOR", help_heading = "Grain")]
    matrix: Option<String>,
    /// Colour of the particles; absent: some colours, by particle.
    #[arg(long, value_name = "COLOR", help_heading = "Grain")]
    particles: Option<String>,
    /// Say as JSON what was done.
    #[arg(long)]
    json: bool,
}

/// X,Y,Z; whether they make sense is for the engine to say.
fn triple(text: &str) -> Result<[f32; 3], String> {
    let numbers: Vec<f32> = text.split(',').filter_map(|s| s.trim().parse().ok()).collect();
    numbers.try_into().map_err(|_| "write three numbers, such as 1,2.5,-3".into())
}

pub(crate) fn run(args: &Args, workers: &Workers) -> Result<()> {
    let mut recipe = args.look.recipe()?;
    recipe.cut = Some(args.cut());
    let path = Path::new(&args.output);
    let kind = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if matches!(kind.as_str(), "png" | "exr") || args.output == "-" {
        recipe.output.picture = Some(args.output.clone());
        return render::draw(&recipe, Path::new(""), args.json, workers);
    }
    if !MESH_FORMATS.split(", ").any(|known| known == kind) {
        bail!("{path:?} is nothing that a cut can become: name a picture (png, exr) or a mesh ({MESH_FORMATS})");
    }
    write(&recipe, path, args.json)
}

impl Args {
    fn cut(&self) -> CutRecipe {
        CutRecipe {
            normal: self.normal,
            at: self.at,
            through: self.through,
            kind: self.kind.clone(),
            grain: self.grain.clone(),
            spacing: self.spacing,
            radius: self.radius,
            height: self.height,
            axis: self.axis,
            cone: self.cone,
            jitter: self.jitter,
            size_spread: self.size_spread,
            seed: None,
            figure: self.figure,
            profile: self.profile.clone(),
            policy: self.policy.clone(),
            relief: self.relief.clone(),
            half: self.half.clone(),
            matrix: self.matrix.clone(),
            particles: self.particles.clone(),
        }
    }
}

/// Writes the halves that the recipe asks for, both or none, and tells of each.
fn write(recipe: &Recipe, path: &Path, as_json: bool) -> Result<()> {
    let start = Instant::now();
    let cut = recipe.cut.as_ref().context("nothing to cut")?;
    let shown = cut::shown(cut)?;
    let scene = source::scene(&recipe.input, Path::new(""))?;
    let seed = recipe.input.seed.unwrap_or(1);
    let Halves { scenes, gaps, mended: remarks, .. } = cut::halves(cut, &scene.value, seed)?;
    let mut mended = scene.mended;
    mended.extend(remarks);
    let mut written: Vec<PathBuf> = Vec::new();
    let mut told = Vec::new();
    for (scene, (_, letter)) in scenes.iter().zip(shown.iter().zip(["a", "b"])).filter(|(_, (shown, _))| **shown) {
        let path = half_path(path, letter);
        let lost = files::save_mesh(&path, scene).inspect_err(|_| {
            // One half alone is nothing to leave behind.
            written.iter().for_each(|p| drop(std::fs::remove_file(p)));
        })?;
        mended.extend(lost.into_iter().filter(|m| !mended.contains(m)).collect::<Vec<_>>());
        let n_triangles = scene.mesh.triangles().len();
        told.push((path.clone(), n_triangles, volume(scene.mesh.positions(), scene.mesh.triangles())));
        written.push(path);
    }
    let n_open = gaps.iter().filter(|g| !g.bridged).count();
    if as_json {
        let half = |(path, n, volume): &(PathBuf, usize, f64)| json!({"path": path, "triangles": n, "volume": volume});
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
    for (path, n, volume) in &told {
        report::out(&format!("{}: {} triangles, volume {volume:.6}, {gaps}", path.display(), info_count(*n)))?;
    }
    Ok(())
}

/// `half.stl` becomes `half-a.stl`.
fn half_path(path: &Path, letter: &str) -> PathBuf {
    let stem = path.file_stem().map_or_else(|| "half".into(), |s| s.to_string_lossy());
    let extension = path.extension().map_or_else(String::new, |e| format!(".{}", e.to_string_lossy()));
    path.with_file_name(format!("{stem}-{letter}{extension}"))
}
