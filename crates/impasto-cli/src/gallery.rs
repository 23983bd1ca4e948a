//! `impasto gallery`: every picture of the gallery, and a page to look at.

use crate::gallery_page::{self, Panel};
use crate::report;
use anyhow::{Context, Result};
use impasto::assets::files;
use impasto::par::Workers;
use impasto::recipe::{self, Recipe, output, text};
use std::path::{Path, PathBuf};
use std::time::Instant;

include!(concat!(env!("OUT_DIR"), "/gallery_recipes.rs"));

/// Make every picture of the gallery from built-in samples, and a page (index.html) to look at.
///
/// Nothing is read: recipes are part of the program. Each picture on the page tells the recipe that made it.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  impasto gallery
  impasto gallery --out pictures --size 1600x1200
  impasto gallery --only filters")]
pub(crate) struct Args {
    /// Where to.
    #[arg(long, value_name = "DIR", default_value = "out/gallery")]
    out: PathBuf,
    /// Pixels across and down; absent: three times each recipe's own size.
    #[arg(long, value_name = "WxH", value_parser = crate::options::size)]
    size: Option<impasto::math::Size>,
    /// Only recipes whose path contains this.
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
}

/// How much larger than its test picture a recipe is shown.
const ENLARGED: u32 = 3;

pub(crate) fn run(args: &Args, workers: &Workers) -> Result<()> {
    let start = Instant::now();
    let chosen: Vec<(&str, &str)> = RECIPES.iter().copied().filter(|(path, _)| path.contains(&args.only)).collect();
    std::fs::create_dir_all(&args.out).with_context(|| format!("cannot make the folder {:?}", args.out))?;
    let bar = report::bar("gallery", chosen.len() as u64);
    let mut panels = Vec::new();
    for (path, source) in chosen {
        bar.set_message(path.to_owned());
        let mut recipe = text::parse(source, Path::new(path))?;
        let [w, h] = recipe.picture.size.unwrap_or([320, 240]);
        let enlarged = if recipe.gallery.pixels == Some(true) { 1 } else { ENLARGED };
        recipe.picture.size = Some(args.size.map_or([w * enlarged, h * enlarged], |s| [s.width, s.height]));
        let picture = picture(&mut recipe, path, &args.out, workers).with_context(|| path.to_owned())?;
        panels.push(Panel { path, recipe, source, picture });
        bar.inc(1);
    }
    bar.finish_and_clear();
    let index = args.out.join("index.html");
    let page = gallery_page::page(&panels);
    files::write_atomically(&index, |w| w.write_all(page.as_bytes()))?;
    let (n, time) = (panels.len(), report::seconds(start.elapsed()));
    report::out(&format!("{n} pictures in {time}; open {}", index.display()))
}

/// Makes a recipe's picture in the folder; answers with its file name.
fn picture(recipe: &mut Recipe, path: &str, out: &Path, workers: &Workers) -> Result<String> {
    let name = format!("{}.png", path.trim_end_matches(".toml").replace('/', "-"));
    let command = format!("impasto run gallery/{path}");
    match recipe.gallery.show.as_deref() {
        Some("info-texture") => recipe.output.info_texture = Some(name.clone()),
        _ => recipe.output.picture = Some(name.clone()),
    }
    let prepared = recipe::prepare(recipe, out, workers)?;
    let (made, _) = output::make(recipe, &prepared.value, (out, &[("Command", command)]), workers, &|_| ())?;
    output::write(&made)?;
    Ok(name)
}
