//! `impasto cut`: a file to two halves with grain, as meshes, as a picture or as outlines.

use crate::cut_out;
use crate::options::{Look, two};
use crate::report;
use crate::{render, turntable};
use anyhow::{Context, Result, bail};
use impasto::assets::files::MESH_FORMATS;
use impasto::par::Workers;
use impasto::recipe::CutRecipe;
use impasto::recipe::grain::library;
use std::path::Path;

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
  impasto cut stone.ply --grain granite --kind tear -o stone.png
  impasto cut fruit.ply --grain citrus --relief none --maps 2048 -o fruit.glb
  impasto cut bunny.ply --normal 1,0,0 --then 0,0,1 --half a --grain pumice -o corner.png
  impasto cut bunny.ply --rough 0.02,0.3 --grain concrete -o broken.png
  impasto cut bunny.ply --normal 0,0,1 --figure 6 -o section.svg
  impasto cut bunny.ply --grain sphere --spacing 0.01 --shader wgsl -o grain.wgsl
  impasto cut bunny.ply --normal 0,0,1 --sweep 0.1..0.9 --frames 48 -o through.gif
half.stl stands for half-a.stl, the half that the normal points out of, and half-b.stl.")]
pub(crate) struct Args {
    #[command(flatten)]
    look: Look,
    /// What is written: both halves as .stl, .ply, .glb, .obj or .vtp; or a picture of them, .png or .exr; or the
    /// outlines of the section and its particles, .svg; with --sweep or
    /// --turn a .gif, an animated .png or a folder/ of frames.
    #[arg(short, long, value_name = "OUT", required = true)]
    output: Option<String>,
    /// Name the built-in grains, and stop.
    #[arg(long, exclusive = true)]
    list_grains: bool,
    /// Write a built-in grain's file to standard output, to start one's own from, and stop.
    #[arg(long, value_name = "NAME", exclusive = true)]
    print_grain: Option<String>,
    /// Normal of the cut, out of half a; any length.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, help_heading = "Cut")]
    normal: Option<[f32; 3]>,
    /// Where along the normal: 0 to 1 of the way through; absent: half-way.
    #[arg(long, value_name = "FRACTION", allow_hyphen_values = true, help_heading = "Cut")]
    at: Option<f32>,
    /// A point that the cut goes through.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, help_heading = "Cut")]
    through: Option<[f32; 3]>,
    /// More cuts, each through all pieces so far; can be given again.
    #[arg(long, value_name = "X,Y,Z[@FRACTION]", allow_hyphen_values = true, help_heading = "Cut")]
    then: Vec<String>,
    /// The first cut rough: height and width of its hills, as shares of the model's size. Its caps are flat.
    #[arg(long, value_name = "HEIGHT,WIDTH", allow_hyphen_values = true, help_heading = "Cut")]
    rough: Option<String>,
    /// The first cut along a line drawn square to the normal, pushed through along it: corners as shares of the model's
    /// size from its middle, such as "-1,0 0,0.1 1,0". Its caps are flat.
    #[arg(long, value_name = "CORNERS", allow_hyphen_values = true, help_heading = "Cut")]
    stroke: Option<String>,
    /// Where the surface is open: winding (fill what is more inside than outside), strict (refuse), bridge:LENGTH, open.
    #[arg(long, value_name = "POLICY", help_heading = "Cut")]
    policy: Option<String>,
    /// Which half: a, b or both; after several cuts, the pieces on that side of the first.
    #[arg(long, value_name = "HALF", help_heading = "Cut")]
    half: Option<String>,
    /// footprint (caps in true relief) or none (flat, only shaded).
    #[arg(long, value_name = "RELIEF", help_heading = "Cut")]
    relief: Option<String>,
    /// In a picture: open (side by side) or apart (drawn apart where they were).
    #[arg(long, value_name = "LAYOUT", help_heading = "Cut")]
    layout: Option<String>,
    /// How far apart, as a share of the model's size.
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, help_heading = "Cut")]
    apart: Option<f32>,
    /// Write maps of each cap, so many texels long: with .glb and .obj as its textures, and beside any mesh as PNGs of
    /// colour, height (16 bits), normal, openness and particles.
    #[arg(long, value_name = "TEXELS", help_heading = "Cut")]
    maps: Option<u32>,
    /// Write the grain as the source of a function for shaders: wgsl, or glsl (ES 3.00 and 4.50).
    #[arg(long, value_name = "LANGUAGE", value_parser = ["wgsl", "glsl"], conflicts_with_all = ["sweep", "turn", "maps"], help_heading = "Grain")]
    shader: Option<String>,
    /// Of a drawing: millimetres of a model unit; absent: the drawing is 160 mm long.
    #[arg(long, value_name = "MM", allow_hyphen_values = true, help_heading = "Cut")]
    unit_mm: Option<f64>,
    /// Move the cut through the model: a moving picture of half a.
    #[arg(long, value_name = "A..B", allow_hyphen_values = true, help_heading = "Motion")]
    sweep: Option<String>,
    /// Walk around the pieces.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, help_heading = "Motion")]
    turn: Option<f32>,
    /// How many pictures.
    #[arg(long, value_name = "N", help_heading = "Motion")]
    frames: Option<u32>,
    /// Pictures a second.
    #[arg(long, value_name = "N", help_heading = "Motion")]
    fps: Option<f32>,
    /// tear, hollow or solid; each for a picture of all three. Absent: what suits the grain.
    #[arg(long, value_name = "KIND", help_heading = "Grain")]
    kind: Option<String>,
    /// A grain by name (--list-grains), a grain file .toml, a shape of particles (sphere, ellipsoid, cylinder, capsule, box,
    /// superquadric, tetrahedron, cube, octahedron, dodecahedron, icosahedron), cells, fibres; none for a plain cut.
    #[arg(long, value_name = "GRAIN", help_heading = "Grain")]
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
    if args.list_grains {
        return list_grains();
    }
    if let Some(name) = &args.print_grain {
        return report::out(
            library::text(name).with_context(|| format!("there is no grain {name:?}: see --list-grains"))?,
        );
    }
    let output = args.output.as_deref().context("name what to write: -o cut.png")?;
    let mut recipe = args.look.recipe()?;
    recipe.cut = Some(args.cut()?);
    let path = Path::new(output);
    if let Some(language) = &args.shader {
        return cut_out::shader(&recipe, path, language);
    }
    let kind = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if args.sweep.is_some() || args.turn.is_some() {
        recipe.turntable.turn = args.turn;
        (recipe.turntable.frames, recipe.turntable.fps) = (args.frames, args.fps);
        if let Some(given) = &args.sweep {
            let why = || format!("sweep {given:?} is not possible: two places of the cut, like 0.1..0.9");
            recipe.turntable.watch_cut = Some(two(given, "..").with_context(why)?);
        }
        recipe.output.picture = Some(output.to_owned());
        return turntable::draw(&recipe, Path::new(""), args.json, workers);
    }
    if matches!(kind.as_str(), "png" | "exr") || output == "-" {
        recipe.output.picture = Some(output.to_owned());
        return render::draw(&recipe, Path::new(""), args.json, workers);
    }
    if kind == "svg" {
        return cut_out::drawing(&recipe, path, args.unit_mm);
    }
    if MESH_FORMATS.split(", ").any(|known| known == kind) {
        return cut_out::write(&recipe, path, (args.maps, args.json), workers);
    }
    bail!(
        "{path:?} is nothing that a cut can become: name a picture (png, exr), a mesh ({MESH_FORMATS}) or a drawing (svg)"
    );
}

fn list_grains() -> Result<()> {
    let mut text = String::new();
    for (name, grain) in library::grains() {
        text += &format!("{name:<13}{:<18}{}\n", grain.kinds.join(", "), grain.about);
    }
    report::out(&text)
}

impl Args {
    fn cut(&self) -> Result<CutRecipe> {
        let rough = self.rough.as_deref().map(|given| {
            let why = || format!("rough {given:?} is not possible: height and width, like 0.02,0.3");
            two(given, ",").with_context(why).map(|hills| hills.map(|x| x as f32))
        });
        let stroke = self.stroke.as_deref().map(|given| {
            let why = || format!("stroke {given:?} is not possible: corners, like \"-1,0 0,0.1 1,0\"");
            let corner = |c: &str| two(c, ",").with_context(why).map(|c| c.map(|x| x as f32));
            given.split_whitespace().map(corner).collect::<Result<Vec<_>>>()
        });
        Ok(CutRecipe {
            normal: self.normal,
            at: self.at,
            through: self.through,
            rough: rough.transpose()?,
            stroke: stroke.transpose()?,
            then: self.then.clone(),
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
            layout: self.layout.clone(),
            apart: self.apart,
            matrix: self.matrix.clone(),
            particles: self.particles.clone(),
        })
    }
}
