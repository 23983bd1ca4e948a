//! What a recipe writes: pictures, information buffers, information textures; made whole before anything is written.

use crate::assets::files;
use crate::assets::image_write::{self, Numbers};
use crate::color::Encoding;
use crate::error::{Error, Result};
use crate::inspect::{self, Coding, Quantity, Values, address};
use crate::math::Size;
use crate::par::Workers;
use crate::picture::render::{self, Shortfall};
use crate::recipe::words::{choose_or, impossible};
use crate::recipe::{Prepared, Recipe, View, text};
use crate::visibility::Samples;
use std::path::{Path, PathBuf};

/// A file's content, and where it goes.
pub struct Made {
    /// Where to.
    pub path: PathBuf,
    /// The whole file.
    pub bytes: Vec<u8>,
    /// `picture`, `legend`, `information buffer` or `information texture`.
    pub what: &'static str,
}

/// The formats of a picture.
const PICTURES: &str = "png, exr";
/// The formats of an information buffer.
const BUFFERS: &str = "exr, npz, npy";

/// Whether a recipe's outputs can be written at all; to be asked before long work.
///
/// # Errors
/// `UnknownFormat` by a name's extension; `Parameter` when there is nothing to write or its folder does not exist.
pub fn check(recipe: &Recipe, base: &Path) -> Result<()> {
    let out = &recipe.output;
    for (name, known) in
        [(&out.picture, PICTURES), (&out.info_buffer, BUFFERS), (&out.info_texture, "png"), (&out.legend, "png, svg")]
    {
        let Some(name) = name else { continue };
        let path = base.join(name);
        let kind = extension(&path);
        if name != STDOUT && !known.split(", ").any(|k| k == kind) {
            let kind = if kind.is_empty() { "a name without extension".into() } else { format!(".{kind}") };
            return Err(Error::UnknownFormat { path, kind, verb: "writes", known });
        }
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if name != STDOUT && !folder.is_dir() {
            return Err(impossible("output", name, format!("there is no folder {folder:?}")));
        }
    }
    match [&out.picture, &out.info_buffer, &out.info_texture, &out.legend].iter().all(|o| o.is_none()) {
        true => Err(impossible("output", "", "name a picture to write: -o picture.png")),
        false => coding(recipe).map(|_| ()),
    }
}

/// The name that stands for standard output.
pub const STDOUT: &str = "-";

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

fn coding(recipe: &Recipe) -> Result<(Coding, Option<Size>)> {
    let known = [("paper10", Coding::Paper10), ("rgb12", Coding::Rgb12), ("wide", Coding::Wide)];
    let coding = choose_or("coding", &recipe.output.coding, &known, Coding::default())?;
    let size = match recipe.output.info_size {
        Some([w, h]) if w == 0 || h == 0 || w.max(h) > Coding::Wide.n_texels() => {
            return Err(impossible("info_size", format!("{w}x{h}"), "1 to 16777216 texels a side"));
        }
        size => size.map(|[w, h]| Size::new(w, h)),
    };
    Ok((coding, size))
}

/// What a file says about itself.
pub(super) fn metadata<'a>(recipe: &Recipe, view: &View, about: &[(&'a str, String)]) -> Vec<(&'a str, String)> {
    let mut metadata: Vec<(&str, String)> = vec![("Software", format!("Impasto {}", env!("CARGO_PKG_VERSION")))];
    metadata.extend(about.iter().map(|(k, v)| (*k, v.clone())));
    metadata.push(("Scene", recipe.subject().into()));
    metadata.push(("Camera", view.to_string()));
    // What draws it again; where this one was written is nobody's business.
    let again = Recipe { output: Default::default(), ..recipe.clone() };
    metadata.push(("Recipe", text::to_toml(&again)));
    metadata
}

/// Makes all files that a recipe asks for. `about` is written into them, beside the recipe itself.
///
/// # Errors
/// `Parameter` when an information texture's coding cannot hold the addresses seen.
pub fn make(
    recipe: &Recipe,
    prepared: &Prepared,
    (base, about): (&Path, &[(&str, String)]),
    workers: &Workers,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<(Vec<Made>, Shortfall)> {
    let mut metadata = metadata(recipe, &prepared.view, about);
    metadata.extend(prepared.keys.first().map(|key| ("Data", key.to_json())));
    let out = &recipe.output;
    let mut made = Vec::new();
    let mut shortfall = Shortfall::default();
    if let Some(name) = &out.picture {
        let path = base.join(name);
        let bytes = if extension(&path) == "exr" {
            let picture = prepared.light(workers, progress);
            shortfall = picture.shortfall;
            picture.exr(&metadata)
        } else {
            let picture = prepared.render(workers, progress);
            shortfall = picture.shortfall;
            picture.png(&metadata)
        };
        made.push(Made { path, bytes, what: "picture" });
    }
    if let Some(name) = &out.legend {
        let Some((spec, _)) = &prepared.legend else {
            return Err(impossible("legend", name, "the picture has none: no layer has a colour table"));
        };
        let path = base.join(name);
        let drawing = spec.alone(prepared.size);
        let bytes = match extension(&path).as_str() {
            "svg" => drawing.svg().into_bytes(),
            _ => image_write::png8(drawing.size, drawing.picture(None).as_flattened(), Encoding::Srgb, &metadata),
        };
        made.push(Made { path, bytes, what: "legend" });
    }
    if out.info_buffer.is_none() && out.info_texture.is_none() {
        return Ok((made, shortfall));
    }
    let (domain, shot) = (prepared.domain(), prepared.shot(Samples::One));
    let buffer = render::info_buffer(&domain, &shot, workers);
    if let Some(name) = &out.info_buffer {
        let path = base.join(name);
        let bytes = match extension(&path).as_str() {
            "npy" => image_write::npy(&shape(buffer.size), Numbers::U32(&buffer.ids())),
            kind => {
                let quantities = inspect::quantities(&buffer, &domain, &shot, workers);
                if kind == "npz" { npz(&quantities, buffer.size) } else { exr(&quantities, buffer.size, &metadata) }
            }
        };
        made.push(Made { path, bytes, what: "information buffer" });
    }
    if let Some(name) = &out.info_texture {
        let how = coding(recipe)?;
        let coded = address::addresses(&buffer, &domain, &shot, how, workers)?;
        metadata.push(("Coding", format!("{:?}", how.0).to_lowercase()));
        let bytes = match how.0 {
            Coding::Wide => image_write::png16(buffer.size, coded.as_flattened(), Encoding::Linear, &metadata),
            _ => {
                let bytes: Vec<u8> = coded.as_flattened().iter().map(|x| *x as u8).collect();
                image_write::png8(buffer.size, &bytes, Encoding::Srgb, &metadata)
            }
        };
        made.push(Made { path: base.join(name), bytes, what: "information texture" });
    }
    Ok((made, shortfall))
}

/// Writes files; when one cannot be written, those written before it that are new are taken away again.
///
/// # Errors
/// `Write`.
pub fn write(made: &[Made]) -> Result<()> {
    let mut new: Vec<&Path> = Vec::new();
    for file in made {
        let is_new = !file.path.exists();
        if let Err(error) = files::write_atomically(&file.path, |w| w.write_all(&file.bytes)) {
            new.iter().for_each(|path| drop(std::fs::remove_file(path)));
            return Err(error);
        }
        if is_new {
            new.push(&file.path);
        }
    }
    Ok(())
}

fn shape(size: Size) -> [usize; 2] {
    [size.height as usize, size.width as usize]
}

/// One array a quantity: rows, columns, components.
fn npz(quantities: &[Quantity], size: Size) -> Vec<u8> {
    let shapes: Vec<Vec<usize>> = quantities
        .iter()
        .map(|q| shape(size).into_iter().chain((!q.components.is_empty()).then_some(q.components.len())).collect())
        .collect();
    let arrays: Vec<(&str, &[usize], Numbers)> =
        quantities.iter().zip(&shapes).map(|(q, s)| (q.name.as_str(), s.as_slice(), numbers(&q.values))).collect();
    image_write::npz(&arrays)
}

fn numbers(values: &Values) -> Numbers<'_> {
    match values {
        Values::U32(v) => Numbers::U32(v),
        Values::F32(v) => Numbers::F32(v),
    }
}

/// One channel a component, `quantity.component`.
fn exr(quantities: &[Quantity], size: Size, metadata: &[(&str, String)]) -> Vec<u8> {
    let planes: Vec<(String, Values)> = quantities
        .iter()
        .flat_map(|q| {
            let n = q.components.len().max(1);
            (0..n).map(move |c| {
                let name = q.components.get(c).map_or(q.name.clone(), |k| format!("{}.{k}", q.name));
                let plane = match &q.values {
                    Values::U32(v) => Values::U32(v.iter().skip(c).step_by(n).copied().collect()),
                    Values::F32(v) => Values::F32(v.iter().skip(c).step_by(n).copied().collect()),
                };
                (name, plane)
            })
        })
        .collect();
    let channels: Vec<(&str, Numbers)> = planes.iter().map(|(name, v)| (name.as_str(), numbers(v))).collect();
    image_write::exr(size, &channels, metadata)
}
