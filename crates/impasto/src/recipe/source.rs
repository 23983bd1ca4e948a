//! What a recipe names: files beside it, and samples made by formula.

use crate::assets::cube_layout::{self, Faces};
use crate::assets::{CubeLayout, Scene, TextureImage, files};
use crate::error::{Error, Mended, Report, Result};
use crate::lookup::{ColorTable, tables};
use crate::math::Size;
use crate::recipe::layer::Words;
use crate::recipe::outside;
use crate::recipe::text::guess;
use crate::recipe::words::{choose, choose_or, impossible};
use crate::recipe::{Input, Recipe};
use crate::samples::{self, texture};
use std::path::{Path, PathBuf};

/// What stands before the name of a sample.
pub const SAMPLE: &str = "sample:";

/// The scene a recipe shows.
///
/// # Errors
/// What the reader says; `Parameter` for names that are not known.
pub fn scene(input: &Input, base: &Path) -> Result<Report<Scene>> {
    let mut report = bare_scene(input, base)?;
    outside::join(&input.fields, base, &mut report.value, &mut report.mended)?;
    Ok(report)
}

/// The same before values from outside are joined to it.
fn bare_scene(input: &Input, base: &Path) -> Result<Report<Scene>> {
    let file = input.file.as_deref().ok_or_else(|| impossible("input", "", "a file, or sample:NAME"))?;
    if let Some(name) = file.strip_prefix(SAMPLE) {
        return sample_scene(name, input).map(Report::clean);
    }
    use files::{LoadOptions, Up};
    let up = choose_or("up", &input.up, &[("auto", Up::Auto), ("y", Up::Y), ("z", Up::Z)], Up::Auto)?;
    let isolevel = match input.isolevel {
        Some(level) if !level.is_finite() => return Err(impossible("isolevel", level, "a finite number")),
        level => level,
    };
    files::load(&place(base, file), &LoadOptions { up, isolevel, ..LoadOptions::default() })
}

fn sample_scene(name: &str, input: &Input) -> Result<Scene> {
    let resolution = input.resolution.unwrap_or(RESOLUTION);
    if resolution > MOST_RESOLVED {
        return Err(impossible("resolution", resolution, format!("at most {MOST_RESOLVED}")));
    }
    samples::scene(name, resolution, input.seed.unwrap_or(1)).ok_or_else(|| {
        let names: Vec<&str> = samples::NAMES.iter().map(|(name, _)| *name).collect();
        impossible("sample", name, guess(name, &names))
    })
}

/// Edges along a sample's longest side, unless the recipe says otherwise.
const RESOLUTION: u32 = 128;

/// Beyond this a sample would not fit the memory of a usual machine.
const MOST_RESOLVED: u32 = 4096;

/// How a sample texture is made: texels along an edge (none: its default), and its seed.
pub(super) type Making = (Option<u32>, u32);

fn checked(texels: Option<u32>, absent: u32) -> Result<u32> {
    match texels {
        None => Ok(absent),
        Some(n) if (1..=8192).contains(&n) => Ok(n),
        Some(n) => Err(impossible("texels", n, "1 to 8192")),
    }
}

/// An image a recipe names; samples are `size` texels wide.
pub(super) fn image(
    given: &str,
    base: &Path,
    (texels, seed): Making,
    mended: &mut Vec<Mended>,
) -> Result<TextureImage> {
    if let Some(name) = given.strip_prefix(SAMPLE) {
        return sample_image(name, checked(texels, TEXTURE_SIZE)?, seed);
    }
    let report = files::load_image(&place(base, given))?;
    mended.extend(report.mended);
    Ok(report.value)
}

/// A list of images; `sample:NAME` may stand for all of them.
pub(super) fn images(
    given: &[String],
    base: &Path,
    (texels, seed): Making,
    mended: &mut Vec<Mended>,
) -> Result<Vec<TextureImage>> {
    if let [one] = given
        && let Some(name) = one.strip_prefix(SAMPLE)
    {
        return sample_images(name, checked(texels, STACK_SIZE)?, seed);
    }
    given.iter().map(|g| image(g, base, (texels, seed), mended)).collect()
}

/// A colour table a recipe names: one of [`ColorTable::NAMES`], or a file (a name with a dot or a slash).
pub(super) fn table(given: &str, base: &Path) -> Result<ColorTable> {
    if let Some(table) = ColorTable::named(given) {
        return Ok(table);
    }
    if !given.contains(['.', '/', '\\']) {
        return Err(impossible("table", given, guess(given, &ColorTable::NAMES)));
    }
    let path = place(base, given);
    let bytes = std::fs::read(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
    tables::parse(&bytes, &path.to_string_lossy())
}

/// What is all around a scene.
pub(super) enum Surroundings {
    Panorama(TextureImage),
    Cube(Box<Faces>),
}

/// The surroundings a recipe names; cubes of files are turned into our world.
pub(super) fn surroundings(
    given: &Words,
    layout: Option<&str>,
    base: &Path,
    seed: u32,
    mended: &mut Vec<Mended>,
) -> Result<Surroundings> {
    let names = given.list();
    let [name] = names else {
        return cube(names, layout, base, (None, seed), mended).map(|faces| Surroundings::Cube(Box::new(faces)));
    };
    if STACKS.iter().any(|s| name.strip_prefix(SAMPLE) == Some(s)) {
        // As fine as a panorama.
        return cube(names, layout, base, (Some(TEXTURE_SIZE / 4), seed), mended)
            .map(|f| Surroundings::Cube(Box::new(f)));
    }
    let image = image(name, base, (None, seed), mended)?;
    Ok(match cube_layout(layout, &image)? {
        CubeLayout::Panorama => Surroundings::Panorama(image),
        layout => Surroundings::Cube(Box::new(cube_layout::in_our_world(layout.cut(&image)?))),
    })
}

/// Six faces a recipe names: six files, one picture of all, or a sample.
pub(super) fn cube(
    names: &[String],
    layout: Option<&str>,
    base: &Path,
    making: Making,
    mended: &mut Vec<Mended>,
) -> Result<Faces> {
    let images = images(names, base, making, mended)?;
    if names.len() == 1 && names[0].starts_with(SAMPLE) {
        return cube_layout::check(images);
    }
    let faces = match &images[..] {
        [one] => cube_layout(layout, one)?.cut(one)?,
        _ => cube_layout::check(images)?,
    };
    Ok(cube_layout::in_our_world(faces))
}

/// How a picture holds its cube: as the recipe says, else by its proportions.
pub(super) fn cube_layout(given: Option<&str>, image: &TextureImage) -> Result<CubeLayout> {
    let absent = CubeLayout::of(image.texels.size());
    given.map_or(Ok(absent), |given| choose("layout", given, &CubeLayout::NAMES))
}

/// Sample textures of one image.
pub const TEXTURES: [&str; 15] = [
    "uv-grid",
    "checker",
    "stripes",
    "letter-f",
    "alpha-dots",
    "bricks",
    "brick-heights",
    "brick-normals",
    "wood",
    "marble",
    "scales",
    "scale-heights",
    "leaf",
    "sky",
    "matcap",
];

/// Sample textures of several images: cubes, and a volume.
pub const STACKS: [&str; 3] = ["sky-cube", "labelled-cube", "marble-volume"];

/// The sample texture of that name, `n` texels wide.
pub fn sample_image(name: &str, n: u32, seed: u32) -> Result<TextureImage> {
    use texture::{charts, environment, materials, normal_map};
    let size = Size::new(n, n);
    Ok(match name.replace('_', "-").as_str() {
        "uv-grid" => charts::uv_grid(size),
        "checker" => charts::checker(size, 8),
        "stripes" => charts::stripes(size, 8),
        "letter-f" => charts::letter_f(size),
        "alpha-dots" => charts::alpha_dots(size, 8),
        "bricks" => materials::bricks(size, seed),
        "brick-heights" => materials::brick_heights(size, seed),
        "brick-normals" => normal_map(&materials::brick_heights(size, seed), 0.02),
        "wood" => materials::wood(size, seed),
        "marble" => materials::marble(size, seed),
        "scales" => materials::scales(size, seed),
        "scale-heights" => materials::scale_heights(size, seed),
        "leaf" => materials::leaf(size),
        "sky" => environment::sky_map(Size::new(n, n / 2)),
        "matcap" => environment::matcap(size),
        _ => return Err(impossible("sample texture", name, guess(name, &TEXTURES))),
    })
}

/// The sample of several images of that name, `n` texels along an edge.
fn sample_images(name: &str, n: u32, seed: u32) -> Result<Vec<TextureImage>> {
    use texture::{environment, materials};
    Ok(match name.replace('_', "-").as_str() {
        "sky-cube" => environment::sky_cube(n).into(),
        "labelled-cube" => environment::labelled_cube(n).into(),
        "marble-volume" => materials::marble_volume(n, seed),
        _ => return Err(impossible("sample texture", name, guess(name, &STACKS))),
    })
}

/// Texels across a sample texture, unless the recipe says otherwise.
const TEXTURE_SIZE: u32 = 1024;
/// Texels along an edge of a sample volume or cube.
const STACK_SIZE: u32 = 96;

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
