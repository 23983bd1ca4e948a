//! `impasto turntable`: a file to a moving picture.

use crate::options::{Look, two};
use crate::render::{command_line, info_count, notes};
use crate::report;
use anyhow::{Context, Result, bail};
use impasto::assets::animation::Format;
use impasto::par::Workers;
use impasto::recipe::Recipe;
use impasto::recipe::turntable::Turntable;
use serde_json::json;
use std::path::Path;
use std::time::Instant;

/// Walk around a mesh, a scene or a sample: a GIF, an animated PNG, or a folder of frames.
///
/// All options of `render` hold. The camera keeps its distance and height; nothing is cropped on the way.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  impasto turntable model.glb -o model.gif
  impasto turntable scan.ply -o scan.png --frames 72 --fps 24 --size 800x800 --ground
  impasto turntable femur.ply -o stress.gif --color-by stress --table vik --elevation 10
  impasto turntable femur.ply -o range.gif --color-by stress --watch-range 0:10..0:200
  impasto turntable dem.asc -o tide.gif --isolines 50 --isolines-of height --watch-level 0..50
  impasto turntable sample:chameleon -o frames/ --turn 90 --frames 30")]
pub(crate) struct Args {
    #[command(flatten)]
    look: Look,
    /// What is written: .gif (256 colours a frame), .png (animated, all colours), or a folder/ of numbered PNGs.
    #[arg(short, long, value_name = "OUT")]
    output: String,
    /// How many pictures.
    #[arg(long, value_name = "N", default_value_t = impasto::recipe::turntable::FRAMES)]
    frames: u32,
    /// Pictures a second.
    #[arg(long, value_name = "N", default_value_t = impasto::recipe::turntable::FPS)]
    fps: f32,
    /// How far the camera walks; below zero the other way. Absent: once around, or not at all when something else moves.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    turn: Option<f32>,
    /// Move the range of --color-by from the one to the other.
    #[arg(long, value_name = "A:B..C:D", requires = "coloring", allow_hyphen_values = true)]
    watch_range: Option<String>,
    /// Move all --isolines: a line at the first value wanders to the second.
    #[arg(long, value_name = "A..B", requires = "isolines", allow_hyphen_values = true)]
    watch_level: Option<String>,
    /// How high the camera stands, -90 to 90.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    elevation: Option<f32>,
    /// Say as JSON what was done.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args, workers: &Workers) -> Result<()> {
    let mut recipe = args.look.recipe()?;
    recipe.camera.elevation = args.elevation.or(recipe.camera.elevation);
    recipe.turntable.frames = Some(args.frames);
    recipe.turntable.fps = Some(args.fps);
    recipe.turntable.turn = args.turn;
    if let Some(given) = &args.watch_range {
        let why = || format!("watch-range {given:?} is not possible: two ranges, like 0:10..0:200");
        let (from, to) = given.split_once("..").with_context(why)?;
        recipe.turntable.watch_range = Some([two(from, ":").with_context(why)?, two(to, ":").with_context(why)?]);
    }
    if let Some(given) = &args.watch_level {
        let why = || format!("watch-level {given:?} is not possible: two values, like 0..50");
        recipe.turntable.watch_level = Some(two(given, "..").with_context(why)?);
    }
    recipe.output.picture = Some(args.output.clone());
    draw(&recipe, Path::new(""), args.json, workers)
}

/// Draws a recipe's walk; its file names count from `base`.
pub(crate) fn draw(recipe: &Recipe, base: &Path, as_json: bool, workers: &Workers) -> Result<()> {
    let start = Instant::now();
    let Some(name) = &recipe.output.picture else { bail!("name what to write: -o walk.gif") };
    let path = base.join(name);
    Format::of(&path)?;
    let (mut table, mended) = Turntable::new(recipe, base, workers)?;
    let bar = report::bar(recipe.subject(), 1000);
    let about = [("Command", command_line())];
    let progress = |share: f32| bar.set_position((share * 1000.0) as u64);
    let shortfall = table.write(recipe, (&path, &about), workers, &progress)?;
    bar.finish_and_clear();
    let (prepared, time) = (&table.prepared, start.elapsed());
    if as_json {
        let mended: Vec<_> = mended.iter().map(|m| json!({"count": m.count, "what": m.what})).collect();
        let report = json!({
            "input": recipe.subject(),
            "written": path,
            "size": [prepared.size.width, prepared.size.height],
            "frames": table.timing.n_frames,
            "fps": table.timing.fps,
            "triangles": prepared.scene.mesh.triangles().len(),
            "truncated_tiles": shortfall.n_truncated_tiles,
            "mended": mended,
            "seconds": time.as_secs_f64(),
        });
        return report::out(&report.to_string());
    }
    report::mended(&mended);
    notes(prepared, shortfall);
    report::out(&format!(
        "{}: {} frames of {} triangles at {} in {}",
        path.display(),
        table.timing.n_frames,
        info_count(prepared.scene.mesh.triangles().len()),
        prepared.size,
        report::seconds(time)
    ))
}
