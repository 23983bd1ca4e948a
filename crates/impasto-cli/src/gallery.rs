//! `impasto gallery`: every picture of the gallery, and a page to look at.

use crate::gallery_page::{self, Panel};
use crate::report;
use anyhow::{Context, Result};
use impasto::assets::files;
use impasto::par::Workers;
use impasto::recipe::{self, Input, Recipe, output, text};
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
  impasto gallery --only section --models ~/scans
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
    /// Where models of the community lie, in any folder of it: pictures after papers then show the papers' own, such as
    /// bun_zipper.ply, in place of built-in solids.
    #[arg(long, value_name = "DIR")]
    models: Option<PathBuf>,
}

/// How much larger than its test picture a recipe is shown, unless it says so itself.
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
        let enlarged = match recipe.gallery.pixels {
            Some(true) => 1,
            _ => recipe.gallery.enlarge.unwrap_or(ENLARGED).clamp(1, 8),
        };
        if let (Some(name), Some(folder)) = (&recipe.gallery.model, &args.models)
            && let Some(model) = find(folder, name)
        {
            recipe.input = Input { file: Some(std::path::absolute(model)?.display().to_string()), ..Input::default() };
        }
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

/// A file of this name in a folder or those within it, the first by their names.
fn find(folder: &Path, name: &str) -> Option<PathBuf> {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).ok()?.flatten().map(|e| e.path()).collect();
    entries.sort();
    let here = entries.iter().find(|p| p.is_file() && p.file_name().is_some_and(|n| n == name));
    here.cloned().or_else(|| entries.iter().filter(|p| p.is_dir()).find_map(|p| find(p, name)))
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
