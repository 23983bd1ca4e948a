//! glTF 2.0 and GLB to a scene: the node tree flattened to world space, one mesh, its materials, cameras and lights.
//!
//! The JSON is walked value by value instead of through a schema: what is wrong is left out with a note that says where,
//! and the rest is shown. A file is refused when it is no glTF 2.0, when it requires an extension that is not read, or
//! when no triangle of it can be used.
//!
//! Beyond the core: KHR_materials_{unlit, clearcoat, emissive_strength}, KHR_texture_transform, KHR_mesh_quantization,
//! KHR_lights_punctual, EXT_texture_webp. Skins and morph targets are shown as the nodes stand; nothing moves.

mod buffers;
mod json;
mod looks;
mod nodes;
mod primitives;

use crate::Result;
use crate::assets::{Neighbours, Scene};
use crate::error::{Error, Mended, Report};
use buffers::Buffers;
use json::{Fault, Json};
use looks::Looks;
use serde_json::Value;
use std::path::Path;

/// Extensions that a file may require.
const READ: [&str; 7] = [
    "KHR_materials_unlit",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_lights_punctual",
    "EXT_texture_webp",
];

/// Reads a .gltf or .glb file.
pub fn read(bytes: &[u8], path: &Path, neighbours: &Neighbours) -> Result<Report<Scene>> {
    let refused = |fault: Fault| Error::Format { path: path.into(), fault };
    let (text, chunk) = container(bytes).map_err(refused)?;
    let value: Value = serde_json::from_slice(text).map_err(|e| refused(format!("broken JSON: {e}")))?;
    let root = Json::root(&value);
    check_version(&root).map_err(refused)?;

    let mut notes = Notes::default();
    let buffers = Buffers::new(root.clone(), chunk, neighbours);
    let world = nodes::flattened(&root, &mut notes);
    let mut shape = primitives::Shape::new(&buffers);
    for instance in &world.meshes {
        shape.add(instance, &mut notes).map_err(refused)?;
    }
    if shape.is_empty() {
        return Err(refused(notes.why_nothing()));
    }
    let mut looks = Looks::new(&buffers);
    let (raw, materials) = shape.finish(&mut looks, &mut notes);
    let images = looks.images;
    let mut mended = notes.into_mended();
    let report = raw.mend();
    mended.extend(report.mended);

    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let (cameras, lights) = (world.cameras, world.lights);
    let value = Scene { name, mesh: report.value, materials, images, cameras, lights, up_note: String::new() };
    Ok(Report { value, mended })
}

/// The JSON text and the binary chunk: a GLB's parts, or a whole text.
fn container(bytes: &[u8]) -> std::result::Result<(&[u8], Option<&[u8]>), Fault> {
    const JSON: u32 = 0x4e4f_534a;
    const BIN: u32 = 0x004e_4942;
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if !bytes.starts_with(b"glTF") {
        // A byte order mark is against the rules, and common.
        return Ok((bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None));
    }
    match word(4) {
        Some(2) => {}
        Some(version) => return Err(format!("GLB version {version} is not read, only version 2")),
        None => return Err("the GLB is cut short".into()),
    }
    let (mut text, mut chunk) = (None, None);
    let mut at = 12;
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let end = (at + 8).checked_add(length as usize).filter(|&end| end <= bytes.len());
        let end = end.ok_or_else(|| format!("the GLB is cut short: a chunk of {length} bytes at {at}"))?;
        match kind {
            JSON if text.is_none() => text = Some(&bytes[at + 8..end]),
            BIN if chunk.is_none() => chunk = Some(&bytes[at + 8..end]),
            _ => {}
        }
        at = end;
    }
    Ok((text.ok_or("the GLB has no JSON chunk")?, chunk))
}

fn check_version(root: &Json) -> std::result::Result<(), Fault> {
    if !root.value.is_object() {
        return Err("the JSON is no object, so it is no glTF".into());
    }
    let asset = root.object("asset")?.ok_or("\"asset\" is missing, so it is no glTF")?;
    let version = asset.text("version")?.ok_or("asset.version is missing")?;
    if !(version == "2" || version.starts_with("2.")) {
        return Err(format!("glTF {version} is not read, only 2.0"));
    }
    let unread: Vec<&str> = root
        .items("extensionsRequired")?
        .iter()
        .filter_map(|name| name.value.as_str())
        .filter(|name| !READ.contains(name))
        .collect();
    match unread.as_slice() {
        [] => Ok(()),
        names => Err(format!("it requires {}, which Impasto does not read", names.join(", "))),
    }
}

/// What was wrong: one line a kind, with the first place where it was found.
#[derive(Default)]
struct Notes {
    kinds: Vec<(String, usize, String)>,
}

impl Notes {
    fn add(&mut self, kind: &str, place: impl Into<String>) {
        self.add_many(kind, 1, place);
    }

    fn add_many(&mut self, kind: &str, count: usize, place: impl Into<String>) {
        match self.kinds.iter_mut().find(|(known, ..)| known == kind) {
            Some((_, n, _)) => *n += count,
            None if count > 0 => self.kinds.push((kind.into(), count, place.into())),
            None => {}
        }
    }

    /// The value, or a note about values of `subject` that are left at their default.
    fn kept_or<T>(&mut self, value: std::result::Result<T, Fault>, subject: &str, default: T) -> T {
        value.unwrap_or_else(|fault| {
            self.add(&format!("wrong values in {subject} left at their default"), fault);
            default
        })
    }

    fn kept<T>(&mut self, value: std::result::Result<Option<T>, Fault>, subject: &str) -> Option<T> {
        self.kept_or(value, subject, None)
    }

    fn into_mended(self) -> Vec<Mended> {
        let line = |(kind, count, place): (String, usize, String)| {
            let first = if place.is_empty() { String::new() } else { format!(" (first: {place})") };
            Mended { count, what: kind + &first }
        };
        self.kinds.into_iter().map(line).collect()
    }

    /// Why a file gave no triangle, in one line.
    fn why_nothing(self) -> String {
        match self.into_mended().as_slice() {
            [] => "there are no triangles in it".into(),
            notes => {
                let notes: Vec<String> = notes.iter().map(ToString::to_string).collect();
                format!("no triangle of it can be used: {}", notes.join("; "))
            }
        }
    }
}

#[cfg(test)]
mod tests;
