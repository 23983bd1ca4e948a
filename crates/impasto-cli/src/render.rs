//! `impasto render`: a file to a picture.

use crate::inputs::{self, Words};
use crate::options::{self, Look};
use crate::report;
use anyhow::{Result, bail};
use impasto::lookup::{Texture, vision};
use impasto::math::Size;
use impasto::par::Workers;
use impasto::picture::render::Shortfall;
use impasto::recipe::output::{self, STDOUT};
use impasto::recipe::{self, Prepared, Recipe, source, text};
use impasto::{Report, assets::Scene};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Draw a picture of a mesh, a scene, a height map or a sample.
///
/// Without further options: the materials of the file (clay where it has none), studio light, a three-quarter view that
/// frames the object, 1280x720, 4 samples a pixel.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  impasto render model.glb -o model.png
  impasto render scan.ply -o scan.png --camera 120,10 --size 1920x1080 --samples 16 --ground
  impasto render part.stl -o part.png --background transparent
  impasto render cow.obj -o cow.png --texture cow.jpg
  impasto render femur.ply -o stress.png --color-by stress --table vik --center 0 --isolines auto
  impasto render brain.gii -o brain.png --field thickness.csv --color-by thickness --range 2%,98% --bands 10
  impasto render mol.ply -o mol.png --color-by potential --filter \"lipophilicity<0~0.02\" --legend-out bar.svg
  impasto render sample:knot -o knot.png --layer \"sample:bricks scale=16,4\" \\
      --layer \"noise coordinate=position frequency=3 operator=modulate strength=0.4\"
  impasto render sample:chameleon -o ball.png --matcap sample:matcap
  impasto render model.glb -o atlas.png --camera atlas --unlit
  impasto render 'scans/*.ply' -o 'out/{name}.png' --camera front
  impasto render part.vtu -o 'part-{field}.png' --each-field
  impasto render model.glb --info-buffer buffer.npz --info-texture texels.png --coding rgb12

A layer is SOURCE key=value ...: the source is an image file, sample:NAME, table:NAME (with field=NAME), or one of stripes,
checker, noise, cells, wood, marble. Keys: coordinate (uv, planar, cylindrical, spherical, box, two-part, sphere-map, ...),
scale, rotate, offset, wrap, min, mag, anisotropy, operator (replace, modulate, decal, blend, add, over, alpha-test), target
(color, normal, bump, roughness, ...), strength, part, and more: docs/recipes.md.")]
pub(crate) struct Args {
    #[command(flatten)]
    look: Look,
    /// The picture: .png (8 bits), .exr (linear light with alpha), or - for a PNG on standard output. Of several files:
    /// {name} stands for the file's name, {n} for its number, {field} for the field.
    #[arg(short, long, value_name = "OUT")]
    output: Option<String>,
    /// The legend alone: .png or .svg.
    #[arg(long, value_name = "OUT")]
    legend_out: Option<String>,
    /// A picture for each field of the file, coloured by it.
    #[arg(long, group = "coloring", help_heading = "Data")]
    each_field: bool,
    /// All that is known of each pixel: .exr (named channels), .npz (one array a quantity), .npy (triangle ids).
    #[arg(long, value_name = "OUT")]
    info_buffer: Option<String>,
    /// Each pixel's texel address, coded as colour: .png.
    #[arg(long, value_name = "OUT")]
    info_texture: Option<String>,
    /// How addresses are coded: paper10, rgb12 or wide.
    #[arg(long, value_name = "NAME", requires = "info_texture")]
    coding: Option<String>,
    /// Texels that addresses count; absent: those of the colour texture.
    #[arg(long, value_name = "WxH", value_parser = options::size, requires = "info_texture")]
    info_size: Option<Size>,
    /// Write all of this down, to be drawn again by `impasto run`.
    #[arg(long, value_name = "FILE.toml")]
    save_recipe: Option<PathBuf>,
    /// Say as JSON what was done.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args, workers: &Workers) -> Result<()> {
    let files = inputs::expand(&args.look.files)?;
    let (n, is_one) = (files.len(), files.len() == 1);
    for name in args.names() {
        let is_told_apart = is_one || name.contains("{name}") || name.contains("{n}");
        if !is_told_apart {
            bail!("{n} files would all become {name:?}: write {{name}} or {{n}} where their names differ");
        }
        if args.each_field && !name.contains("{field}") {
            bail!("all fields would become {name:?}: write {{field}} where their names differ");
        }
    }
    let words: Vec<Words> = files.iter().enumerate().map(|(i, f)| Words::of(f, i, n)).collect();
    for name in args.names() {
        let mut filled: Vec<String> = words.iter().map(|w| w.fill(name)).collect();
        filled.sort();
        if let Some(twice) = filled.windows(2).find(|pair| pair[0] == pair[1]) {
            bail!("two files would become {:?}: write {{n}} where their names differ", twice[0]);
        }
    }
    let mut is_well = true;
    for (file, words) in files.iter().zip(&words) {
        let drawn = match args.each_field {
            false => args.picture(file, words, workers),
            true => args.fields(file, words, workers),
        };
        match drawn {
            Err(error) if is_one => return Err(error),
            Err(error) if error.is::<report::Told>() => is_well = false,
            Err(error) => {
                let names_it = format!("{error:#}").contains(file.as_str());
                report::failed(&if names_it { error } else { error.context(format!("{file:?}")) });
                is_well = false;
            }
            Ok(()) => {}
        }
    }
    if is_well { Ok(()) } else { Err(report::Told.into()) }
}

impl Args {
    /// The names of all that is written.
    fn names(&self) -> impl Iterator<Item = &str> {
        let recipe = self.save_recipe.as_deref().and_then(Path::to_str);
        [
            self.output.as_deref(),
            self.legend_out.as_deref(),
            self.info_buffer.as_deref(),
            self.info_texture.as_deref(),
            recipe,
        ]
        .into_iter()
        .flatten()
    }

    fn recipe(&self, file: &str, color_by: Option<&str>, words: &Words) -> Result<Recipe> {
        let mut recipe = self.look.recipe_of(file, color_by)?;
        let name = |given: &Option<String>| given.as_deref().map(|name| words.fill(name));
        recipe.output.picture = name(&self.output);
        recipe.output.legend = name(&self.legend_out);
        recipe.output.info_buffer = name(&self.info_buffer);
        recipe.output.info_texture = name(&self.info_texture);
        recipe.output.coding.clone_from(&self.coding);
        recipe.output.info_size = self.info_size.map(|s| [s.width, s.height]);
        Ok(recipe)
    }

    /// One file's picture.
    fn picture(&self, file: &str, words: &Words, workers: &Workers) -> Result<()> {
        let recipe = self.recipe(file, self.look.color_by.as_deref(), words)?;
        draw_with(&recipe, None, Path::new(""), self.json, workers)?;
        self.save(&recipe, words)
    }

    /// One file's pictures, one a field.
    fn fields(&self, file: &str, words: &Words, workers: &Workers) -> Result<()> {
        let base = Path::new("");
        let scene = source::scene(&self.recipe(file, None, words)?.input, base)?;
        let names = field_names(&scene.value);
        if names.is_empty() {
            bail!("{file:?} carries no data");
        }
        let mut is_well = true;
        for name in names {
            let words = words.with_field(&name);
            let recipe = self.recipe(file, Some(&name), &words)?;
            let own = Report { value: scene.value.clone(), mended: scene.mended.clone() };
            let drawn = draw_with(&recipe, Some(own), base, self.json, workers);
            if let Err(error) = drawn.and_then(|()| self.save(&recipe, &words)) {
                report::failed(&error.context(format!("{file:?}, field {name:?}")));
                is_well = false;
            }
        }
        if is_well { Ok(()) } else { Err(report::Told.into()) }
    }

    fn save(&self, recipe: &Recipe, words: &Words) -> Result<()> {
        let Some(path) = &self.save_recipe else { return Ok(()) };
        let path = path.to_str().map_or(path.clone(), |name| words.fill(name).into());
        Ok(impasto::assets::files::write_atomically(&path, |w| w.write_all(text::to_toml(recipe).as_bytes()))?)
    }
}

/// What each field of a scene is called, with its element where two share a name.
fn field_names(scene: &Scene) -> Vec<String> {
    use impasto::assets::Element;
    let fields = scene.mesh.fields();
    let name = |f: &impasto::assets::Field| {
        let is_shared = fields.iter().filter(|other| other.name == f.name).count() > 1;
        match f.element {
            _ if !is_shared => f.name.clone(),
            Element::Vertex => format!("{}@vertices", f.name),
            Element::Face => format!("{}@faces", f.name),
            Element::Corner => format!("{}@corners", f.name),
        }
    };
    let mut names: Vec<String> = fields.iter().map(name).collect();
    names.dedup();
    names
}

/// Draws a recipe whose file names count from `base`, writes what it asks for, and says so.
pub(crate) fn draw(recipe: &Recipe, base: &Path, as_json: bool, workers: &Workers) -> Result<()> {
    draw_with(recipe, None, base, as_json, workers)
}

/// The same of a scene that is loaded already, if there is one.
fn draw_with(
    recipe: &Recipe,
    scene: Option<Report<Scene>>,
    base: &Path,
    as_json: bool,
    workers: &Workers,
) -> Result<()> {
    let start = Instant::now();
    output::check(recipe, base)?;
    let prepared = match scene {
        Some(scene) => recipe::prepare_scene(recipe, scene, base, workers),
        None => recipe::prepare(recipe, base, workers),
    }?;
    let bar = report::bar(recipe.subject(), 1000);
    let about = [("Command", command_line())];
    let progress = |share: f32| bar.set_position((share * 1000.0) as u64);
    let (made, shortfall) = output::make(recipe, &prepared.value, (base, &about), workers, &progress)?;
    bar.finish_and_clear();
    let (piped, files): (Vec<_>, Vec<_>) = made.into_iter().partition(|m| m.path == base.join(STDOUT));
    output::write(&files)?;
    piped.iter().try_for_each(|m| report::out_bytes(&m.bytes))?;

    let time = start.elapsed();
    let mesh = &prepared.value.scene.mesh;
    if as_json {
        let written: Vec<_> =
            files.iter().map(|m| json!({"what": m.what, "path": m.path, "bytes": m.bytes.len()})).collect();
        let mended: Vec<_> = prepared.mended.iter().map(|m| json!({"count": m.count, "what": m.what})).collect();
        let size = prepared.value.size;
        let report = json!({
            "input": recipe.subject(),
            "written": written,
            "size": [size.width, size.height],
            "samples": prepared.value.samples.n(),
            "triangles": mesh.triangles().len(),
            "camera": prepared.value.view.to_string(),
            "truncated_tiles": shortfall.n_truncated_tiles,
            "mended": mended,
            "seconds": time.as_secs_f64(),
        });
        return report::out(&report.to_string());
    }
    report::mended(&prepared.mended);
    notes(&prepared.value, shortfall);
    if piped.is_empty() {
        let size = prepared.value.size;
        let names: Vec<String> = files.iter().map(|m| m.path.display().to_string()).collect();
        report::out(&format!(
            "{}: {} triangles at {size} in {}",
            names.join(", "),
            info_count(mesh.triangles().len()),
            report::seconds(time)
        ))?;
    }
    Ok(())
}

/// What a reader of the picture should know.
pub(crate) fn notes(prepared: &Prepared, shortfall: Shortfall) {
    for texture in &prepared.looks.textures {
        if let Texture::Table(table) = texture {
            vision::warnings(table, None).iter().for_each(|warning| eprintln!("note: {warning}"));
        }
    }
    if shortfall.n_truncated_tiles > 0 {
        let n = shortfall.n_truncated_tiles;
        eprintln!("note: {n} tiles have more transparent layers than are told apart; the farthest are missing");
    }
}

/// A number with its thousands apart.
pub(crate) fn info_count(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(c);
    }
    out
}

/// As typed, for a picture's metadata; the program's own path is of no interest.
pub(crate) fn command_line() -> String {
    let words = std::env::args().skip(1).map(|w| match w.contains(char::is_whitespace) || w.is_empty() {
        true => format!("\"{w}\""),
        false => w,
    });
    std::iter::once("impasto".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}
