//! What a recipe names: files beside it, and samples made by formula.

use crate::assets::{Scene, TextureImage, files};
use crate::error::{Mended, Report, Result};
use crate::recipe::text::guess;
use crate::recipe::words::{choose_or, impossible};
use crate::recipe::{Input, Recipe};
use crate::samples;
use std::path::{Path, PathBuf};

/// What stands before the name of a sample.
pub const SAMPLE: &str = "sample:";

/// The scene a recipe shows.
pub(super) fn scene(input: &Input, base: &Path) -> Result<Report<Scene>> {
    let file = input.file.as_deref().ok_or_else(|| impossible("input", "", "a file, or sample:NAME"))?;
    if let Some(name) = file.strip_prefix(SAMPLE) {
        return sample_scene(name, input).map(Report::clean);
    }
    use files::{LoadOptions, Up};
    let up = choose_or("up", &input.up, &[("auto", Up::Auto), ("y", Up::Y), ("z", Up::Z)], Up::Auto)?;
    files::load(&place(base, file), &LoadOptions { up, ..LoadOptions::default() })
}

fn sample_scene(name: &str, input: &Input) -> Result<Scene> {
    let resolution = input.resolution.unwrap_or(0);
    if resolution > MOST_RESOLVED {
        return Err(impossible("resolution", resolution, format!("at most {MOST_RESOLVED}")));
    }
    samples::scene(name, resolution, input.seed.unwrap_or(1)).ok_or_else(|| {
        let names: Vec<&str> = samples::NAMES.iter().map(|(name, _)| *name).collect();
        impossible("sample", name, guess(name, &names))
    })
}

/// Beyond this a sample would not fit the memory of a usual machine.
const MOST_RESOLVED: u32 = 4096;

/// An image a recipe names; samples are `size` texels wide.
pub(super) fn image(given: &str, base: &Path, seed: u32, mended: &mut Vec<Mended>) -> Result<TextureImage> {
    if let Some(name) = given.strip_prefix(SAMPLE) {
        return sample_image(name, seed);
    }
    let report = files::load_image(&place(base, given))?;
    mended.extend(report.mended);
    Ok(report.value)
}

/// A list of images; `sample:NAME` may stand for all of them.
pub(super) fn images(given: &[String], base: &Path, seed: u32, mended: &mut Vec<Mended>) -> Result<Vec<TextureImage>> {
    if let [one] = given
        && let Some(name) = one.strip_prefix(SAMPLE)
    {
        return sample_images(name, seed);
    }
    given.iter().map(|g| image(g, base, seed, mended)).collect()
}

fn sample_image(name: &str, seed: u32) -> Result<TextureImage> {
    samples::texture(name, TEXTURE_SIZE, seed).ok_or_else(|| unknown_texture(name))
}

fn sample_images(name: &str, seed: u32) -> Result<Vec<TextureImage>> {
    samples::texture_stack(name, STACK_SIZE, seed).ok_or_else(|| unknown_texture(name))
}

fn unknown_texture(name: &str) -> crate::Error {
    let names: Vec<&str> = samples::TEXTURE_NAMES.iter().map(|(name, _)| *name).collect();
    impossible("sample texture", name, guess(name, &names))
}

/// Texels across a sample texture.
const TEXTURE_SIZE: u32 = 1024;
/// Texels along an edge of a sample volume or cube.
const STACK_SIZE: u32 = 64;

/// A path in a recipe counts from the recipe's folder.
pub(super) fn place(base: &Path, given: &str) -> PathBuf {
    base.join(given)
}

impl Recipe {
    /// What is shown, for messages: the file's name as written.
    pub fn subject(&self) -> &str {
        self.input.file.as_deref().unwrap_or("nothing")
    }
}
