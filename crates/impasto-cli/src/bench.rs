//! `impasto bench`: draws a baseline scene again and again and says how long it took.

use anyhow::{Context, Result, bail};
use impasto::math::Size;
use impasto::par::Workers;
use impasto::picture::Film;
use impasto::picture::baseline::Baseline;
use impasto::picture::render::{self, Renderer};
use impasto::samples::bench::NAMES;
use impasto::visibility::{Domain, Samples, Tiles};
use std::time::Instant;

/// Draw a benchmark scene repeatedly and print median times.
///
/// The scenes have the geometry, textures and cameras of an OpenGL baseline, so that both programs can be run in turn.
/// One line: scene, size, triangles, milliseconds a frame (median and least), CPU milliseconds, stages, picture hash.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  impasto bench --scene sphere100k --size 1280x720 --frames 30
  impasto bench --scene terrain --samples 4 --dump frame.rgba --dump-frame 3")]
pub(crate) struct Args {
    /// sphere10k, sphere100k, sphere1m, layers_btf, layers_ftb or terrain.
    #[arg(long, default_value = "sphere100k")]
    scene: String,
    /// Pixels across and down.
    #[arg(long, default_value = "1280x720", value_parser = crate::options::size)]
    size: Size,
    /// Frames to measure; the camera moves on with each.
    #[arg(long, default_value_t = 30)]
    frames: u32,
    /// Frames drawn before.
    #[arg(long, default_value_t = 8)]
    warm: u32,
    /// Samples a pixel: 1, 4 or 16.
    #[arg(long, default_value_t = 1)]
    samples: u32,
    /// Write a frame as raw RGBA bytes, bottom row first.
    #[arg(long)]
    dump: Option<std::path::PathBuf>,
    /// Which frame to write.
    #[arg(long, default_value_t = 0)]
    dump_frame: u32,
    /// Print a JSON object instead of a line.
    #[arg(long)]
    json: bool,
}

/// Times of one frame, milliseconds.
#[derive(Clone, Copy, Default)]
struct Times {
    frame: f64,
    vertex: f64,
    bin: f64,
    tiles: f64,
}

/// Runs the command.
pub(crate) fn run(args: &Args, workers: &Workers) -> Result<()> {
    let baseline = Baseline::new(&args.scene)
        .with_context(|| format!("no scene {:?}; there are {}", args.scene, NAMES.join(", ")))?;
    let Some(samples) = Samples::from_n(args.samples) else { bail!("{} samples: choose 1, 4 or 16", args.samples) };
    let shot = baseline.shot(samples);
    let mut renderer = Renderer::default();
    let mut picture = vec![[0u8; 4]; args.size.n_cells()];
    let draws = render::draws(&baseline.mesh, shot.looks);
    let mut times = Vec::new();
    let mut dumped = None;
    for frame in 0..args.warm + args.frames {
        let number = frame.saturating_sub(args.warm);
        let start = Instant::now();
        let mut lap = start;
        let mut stage = || {
            let now = Instant::now();
            let ms = (now - lap).as_secs_f64() * 1e3;
            lap = now;
            ms
        };
        let camera = baseline.camera(number);
        let domain = Domain::through_camera(&baseline.mesh, &camera, args.size);
        renderer.tiles.snap(&domain, workers);
        let vertex = stage();
        renderer.tiles.sort(&domain, &draws, samples, workers);
        let bin = stage();
        draw(&renderer, &domain, &shot, workers, args.size, &mut picture);
        let tiles_ms = stage();
        let frame_ms = start.elapsed().as_secs_f64() * 1e3;
        if frame >= args.warm {
            times.push(Times { frame: frame_ms, vertex, bin, tiles: tiles_ms });
        }
        if frame >= args.warm && number == args.dump_frame {
            dumped = Some(picture.clone());
        }
    }
    let raster = raster_alone(&baseline, &mut renderer.tiles, samples, args.size, workers);
    report(args, &baseline, &times, raster, dumped.as_deref().unwrap_or(&picture))?;
    if let (Some(path), Some(picture)) = (&args.dump, &dumped) {
        let rows = picture.chunks(args.size.width as usize).rev();
        let bytes: Vec<u8> = rows.flatten().flatten().copied().collect();
        std::fs::write(path, bytes).with_context(|| format!("cannot write {path:?}"))?;
    }
    Ok(())
}

fn draw(
    renderer: &Renderer,
    domain: &Domain,
    shot: &render::Shot,
    workers: &Workers,
    size: Size,
    picture: &mut [[u8; 4]],
) {
    let film = Film::new(&Baseline::DEVELOP, &Baseline::BACKGROUND, size, workers);
    renderer.shade(domain, shot, workers, picture, |[_, y], cells, row| film.row(y, cells, row));
}

/// Median time of rasterizing the first frame without shading it.
fn raster_alone(baseline: &Baseline, tiles: &mut Tiles, samples: Samples, size: Size, workers: &Workers) -> f64 {
    let camera = baseline.camera(0);
    let domain = Domain::through_camera(&baseline.mesh, &camera, size);
    let shot = baseline.shot(samples);
    tiles.bin(&domain, &render::draws(&baseline.mesh, shot.looks), samples, workers);
    let [n_x, n_y] = tiles.n_tiles();
    let mut times: Vec<f64> = (0..9)
        .map(|_| {
            let start = Instant::now();
            let mut jobs = vec![(); n_x * n_y];
            workers.for_each_with(&mut jobs, Default::default, |tile, i, ()| tiles.rasterize(i, None, workers, tile));
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn report(args: &Args, baseline: &Baseline, times: &[Times], raster: f64, picture: &[[u8; 4]]) -> Result<()> {
    let median = |of: fn(&Times) -> f64| {
        let mut values: Vec<f64> = times.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let least = times.iter().map(|t| t.frame).fold(f64::INFINITY, f64::min);
    // FNV-1a, 64 bits: enough to tell one picture from another.
    let hash =
        picture.iter().flatten().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ *b as u64).wrapping_mul(0x100_0000_01b3));
    let (frame, vertex, bin, tiles) =
        (median(|t| t.frame), median(|t| t.vertex), median(|t| t.bin), median(|t| t.tiles));
    let n_triangles = baseline.mesh.triangles().len();
    if args.json {
        let value = serde_json::json!({
            "scene": args.scene, "width": args.size.width, "height": args.size.height, "triangles": n_triangles,
            "samples": args.samples, "frames": times.len(), "median_ms": frame, "least_ms": least,
            "vertex_ms": vertex, "bin_ms": bin, "tiles_ms": tiles, "raster_ms": raster, "hash": format!("{hash:016x}"),
        });
        println!("{value}");
    } else {
        println!(
            "{:<12} {} tris={n_triangles} samples={}  frame: med {frame:.2} min {least:.2} | vertex {vertex:.2} bin {bin:.2} \
             raster+shade {tiles:.2} (raster alone {raster:.2}) ms | picture {hash:016x}",
            args.scene, args.size, args.samples
        );
    }
    Ok(())
}
