//! `impasto run`: a recipe to what it asks for.

use crate::{render, report, turntable};
use anyhow::{Context, Result, bail};
use impasto::par::Workers;
use impasto::recipe::{output, text};
use std::path::{Path, PathBuf};

/// Draw a recipe: a picture, written down.
///
/// File names in a recipe count from the recipe's own folder.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  impasto render model.glb -o a.png --camera top --save-recipe a.toml
  impasto run a.toml
  impasto run a.toml -o larger.png --size 3840x2160
  impasto run a.toml --print           the recipe as it is understood")]
pub(crate) struct Args {
    /// The recipe.
    recipe: PathBuf,
    /// The picture, in place of the one that the recipe names.
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// Pixels across and down, in place of the recipe's.
    #[arg(long, value_name = "WxH", value_parser = crate::options::size)]
    size: Option<impasto::math::Size>,
    /// Samples a pixel, in place of the recipe's.
    #[arg(long, value_name = "N")]
    samples: Option<u32>,
    /// Print the recipe as it is understood, and draw nothing.
    #[arg(long)]
    print: bool,
    /// Say as JSON what was done.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args, workers: &Workers) -> Result<()> {
    let path = &args.recipe;
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {path:?}"))?;
    let mut recipe = text::parse(&text, path)?;
    if args.print {
        return report::out(&text::to_toml(&recipe));
    }
    let base = path.parent().unwrap_or(Path::new(""));
    if let Some(out) = &args.output {
        // What the user types counts from where the user is.
        let out = if out.as_os_str() == output::STDOUT { out.clone() } else { std::path::absolute(out)? };
        recipe.output.picture = Some(out.to_string_lossy().into_owned());
    } else if recipe.output == Default::default() {
        let Some(name) = path.file_stem() else { bail!("{path:?} names no file") };
        let kind = if recipe.turntable == Default::default() { "png" } else { "gif" };
        recipe.output.picture = Some(format!("{}.{kind}", name.to_string_lossy()));
    }
    recipe.picture.size = args.size.map(|s| [s.width, s.height]).or(recipe.picture.size);
    recipe.picture.samples = args.samples.or(recipe.picture.samples);
    match recipe.turntable == Default::default() {
        true => render::draw(&recipe, base, args.json, workers),
        false => turntable::draw(&recipe, base, args.json, workers),
    }
}
