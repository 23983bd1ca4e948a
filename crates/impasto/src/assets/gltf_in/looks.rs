//! Materials, textures, samplers and images of a glTF file.
//!
//! What is wrong in a material is left at glTF's default and noted; the surface is still shown.

use super::Notes;
use super::buffers::Buffers;
use super::json::{Fault, Json};
use crate::assets::image_files;
use crate::assets::material::Clearcoat;
use crate::assets::{AlphaMode, Filter, Material, MinFilter, Sampler, TextureImage, TextureRef, UvTransform, Wrap};
use crate::color::Encoding;
use crate::math::exact;
use std::path::Path;

/// Materials being read: collects the images that they use.
pub(super) struct Looks<'a> {
    pub(super) buffers: &'a Buffers<'a>,
    /// Images in the scene so far.
    pub(super) images: Vec<TextureImage>,
    /// For each image of the file: its index in the scene as sRGB and as linear; none: not decoded yet.
    known: Vec<[Option<Result<u32, Fault>>; 2]>,
}

impl<'a> Looks<'a> {
    pub(super) fn new(buffers: &'a Buffers<'a>) -> Self {
        let known = vec![[None, None]; buffers.root.n_items("images")];
        Self { buffers, images: Vec::new(), known }
    }

    /// Material `i` of the file.
    pub(super) fn material(&mut self, i: usize, notes: &mut Notes) -> Result<Material, Fault> {
        let json = self.buffers.root.item("materials", i)?;
        let mut m = gltf_default();
        m.name = json.name().map_or_else(|| format!("material{i}"), Into::into);

        if let Some(pbr) = notes.kept(json.object("pbrMetallicRoughness"), "materials") {
            m.base_color = notes.kept_or(pbr.numbers("baseColorFactor", [1.0; 4]), "materials", [1.0; 4]).map(clip);
            m.metalness = clip(self.factor(&pbr, "metallicFactor", 1.0, notes));
            m.roughness = clip(self.factor(&pbr, "roughnessFactor", 1.0, notes));
            m.base_color_texture = self.texture(&pbr, "baseColorTexture", Encoding::Srgb, notes).map(|t| t.0);
            m.metal_rough_texture =
                self.texture(&pbr, "metallicRoughnessTexture", Encoding::Linear, notes).map(|t| t.0);
        }
        if let Some((texture, info)) = self.texture(&json, "normalTexture", Encoding::Linear, notes) {
            m.normal_texture = Some(texture);
            m.normal_scale = self.factor(&info, "scale", 1.0, notes) as f32;
        }
        if let Some((texture, info)) = self.texture(&json, "occlusionTexture", Encoding::Linear, notes) {
            m.occlusion_texture = Some(texture);
            m.occlusion_strength = clip(self.factor(&info, "strength", 1.0, notes));
        }
        let emission = notes.kept_or(json.numbers("emissiveFactor", [0.0; 3]), "materials", [0.0; 3]);
        let strength = match notes.kept(json.extension("KHR_materials_emissive_strength"), "materials") {
            Some(extension) => self.factor(&extension, "emissiveStrength", 1.0, notes),
            None => 1.0,
        };
        m.emission = emission.map(|e| (e.max(0.0) * strength.max(0.0)) as f32);
        m.emission_texture = self.texture(&json, "emissiveTexture", Encoding::Srgb, notes).map(|t| t.0);

        m.alpha_mode = match notes.kept(json.text("alphaMode"), "materials").unwrap_or("OPAQUE") {
            "MASK" => AlphaMode::Mask(self.factor(&json, "alphaCutoff", 0.5, notes) as f32),
            "BLEND" => AlphaMode::Blend,
            "OPAQUE" => AlphaMode::Opaque,
            other => {
                notes.add("alpha modes that glTF does not have, taken as opaque", json.fault(other));
                AlphaMode::Opaque
            }
        };
        m.double_sided = notes.kept_or(json.flag("doubleSided"), "materials", false);
        m.unlit = notes.kept(json.extension("KHR_materials_unlit"), "materials").is_some();
        if let Some(coat) = notes.kept(json.extension("KHR_materials_clearcoat"), "materials") {
            m.clearcoat = self.clearcoat(&coat, notes);
        }
        self.note_unread(&json, notes);
        Ok(m)
    }

    fn clearcoat(&mut self, coat: &Json<'a>, notes: &mut Notes) -> Clearcoat {
        let normal = self.texture(coat, "clearcoatNormalTexture", Encoding::Linear, notes);
        Clearcoat {
            strength: clip(self.factor(coat, "clearcoatFactor", 0.0, notes)),
            strength_texture: self.texture(coat, "clearcoatTexture", Encoding::Linear, notes).map(|t| t.0),
            roughness: clip(self.factor(coat, "clearcoatRoughnessFactor", 0.0, notes)),
            roughness_texture: self.texture(coat, "clearcoatRoughnessTexture", Encoding::Linear, notes).map(|t| t.0),
            normal_scale: normal.as_ref().map_or(1.0, |(_, info)| self.factor(info, "scale", 1.0, notes) as f32),
            normal_texture: normal.map(|t| t.0),
        }
    }

    fn factor(&self, json: &Json, key: &str, default: f64, notes: &mut Notes) -> f64 {
        notes.kept_or(json.number(key, default), "materials", default)
    }

    /// Says which looks a material has that we do not know.
    fn note_unread(&self, json: &Json, notes: &mut Notes) {
        const READ: [&str; 3] = ["KHR_materials_unlit", "KHR_materials_clearcoat", "KHR_materials_emissive_strength"];
        let Some(all) = json.value.get("extensions").and_then(|e| e.as_object()) else { return };
        for name in all.keys().filter(|name| !READ.contains(&name.as_str())) {
            notes.add(&format!("materials with {name}, which is not read"), json.place.clone());
        }
    }

    /// A material's use of a texture, and the object that says so.
    fn texture(
        &mut self,
        json: &Json<'a>,
        key: &str,
        encoding: Encoding,
        notes: &mut Notes,
    ) -> Option<(TextureRef, Json<'a>)> {
        let info = notes.kept(json.object(key), "textures")?;
        match self.texture_ref(&info, encoding, notes) {
            Ok(texture) => Some((texture, info)),
            Err(fault) => {
                notes.add("textures left out", fault);
                None
            }
        }
    }

    fn texture_ref(&mut self, info: &Json<'a>, encoding: Encoding, notes: &mut Notes) -> Result<TextureRef, Fault> {
        let texture = self.buffers.root.item("textures", info.need("index")?.as_index()?)?;
        let image = self.image(source(&texture)?, encoding, notes)?;
        let sampler = match texture.index("sampler") {
            Ok(None) => Sampler::default(),
            Ok(Some(i)) => {
                let sampler = self.buffers.root.item("samplers", i).map(|json| sampler(&json, notes));
                notes.kept_or(sampler, "samplers", Sampler::default())
            }
            Err(fault) => notes.kept_or(Err(fault), "samplers", Sampler::default()),
        };
        let mut uv_set = notes.kept(info.index("texCoord"), "textures").unwrap_or(0);
        let mut transform = UvTransform::IDENTITY;
        if let Some(extension) = notes.kept(info.extension("KHR_texture_transform"), "texture transforms") {
            transform = notes.kept_or(uv_transform(&extension), "texture transforms", UvTransform::IDENTITY);
            uv_set = notes.kept(extension.index("texCoord"), "texture transforms").unwrap_or(uv_set);
        }
        let uv_set =
            u32::try_from(uv_set).ok().filter(|&s| s < 64).ok_or_else(|| info.fault("texCoord is out of range"))?;
        Ok(TextureRef { image, uv_set, sampler, transform })
    }

    /// The scene's index of the file's image `i`, its numbers understood as `encoding`.
    fn image(&mut self, i: usize, encoding: Encoding, notes: &mut Notes) -> Result<u32, Fault> {
        let slot = |encoding| if encoding == Encoding::Srgb { 0 } else { 1 };
        let other = if encoding == Encoding::Srgb { Encoding::Linear } else { Encoding::Srgb };
        let json = self.buffers.root.item("images", i)?;
        if let Some(known) = &self.known[i][slot(encoding)] {
            return known.clone();
        }
        // One image used in two ways is two images.
        let image = match &self.known[i][slot(other)] {
            Some(Ok(twin)) => Ok(self.images[*twin as usize].clone()),
            Some(Err(fault)) => Err(fault.clone()),
            None => self.decoded(i, &json, notes),
        };
        let index = image.map(|image| {
            self.images.push(TextureImage { encoding, ..image });
            self.images.len() as u32 - 1
        });
        self.known[i][slot(encoding)] = Some(index.clone());
        index
    }

    fn decoded(&self, i: usize, json: &Json, notes: &mut Notes) -> Result<TextureImage, Fault> {
        let uri = json.text("uri")?;
        let file = uri.filter(|u| !u.starts_with("data:"));
        let name = json.name().or(file).map_or_else(|| format!("image{i}"), Into::into);
        let report = match uri {
            Some(uri) => {
                let bytes = self.buffers.resource(uri).map_err(|e| json.fault(e))?;
                image_files::read(&bytes, Path::new(file.unwrap_or(&name)))
            }
            None => {
                let view = self.buffers.view(json.need("bufferView")?.as_index()?)?;
                image_files::read(view.bytes(), Path::new(&name))
            }
        };
        let report = report.map_err(|e| json.fault(e))?;
        for mended in report.mended {
            // glTF alone decides how an image's numbers are understood.
            if !mended.what.contains("taken as sRGB") {
                notes.add_many(&mended.what, mended.count, json.place.clone());
            }
        }
        Ok(TextureImage { name, ..report.value })
    }
}

/// Which image a texture shows: a WebP if it offers one, else a plain one.
fn source(texture: &Json) -> Result<usize, Fault> {
    if let Some(webp) = texture.extension("EXT_texture_webp")? {
        return webp.need("source")?.as_index();
    }
    if let Some(source) = texture.index("source")? {
        return Ok(source);
    }
    let other = texture.value.get("extensions").and_then(|e| e.as_object()).and_then(|e| e.keys().next());
    Err(match other {
        Some(name) => texture.fault(format_args!("{name} is not read and there is no other image")),
        None => texture.fault("it names no image"),
    })
}

fn sampler(json: &Json, notes: &mut Notes) -> Sampler {
    let mut code = |key| notes.kept(json.index(key), "samplers");
    let mut wrap = |key| match code(key) {
        Some(33071) => Wrap::ClampToEdge,
        Some(33648) => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    };
    let wrap = [wrap("wrapS"), wrap("wrapT"), Wrap::Repeat];
    let mag = if code("magFilter") == Some(9728) { Filter::Nearest } else { Filter::Linear };
    let min = match code("minFilter") {
        Some(9728) => MinFilter::Nearest,
        Some(9729) => MinFilter::Linear,
        Some(9984) => MinFilter::NearestMipmapNearest,
        Some(9985) => MinFilter::LinearMipmapNearest,
        Some(9986) => MinFilter::NearestMipmapLinear,
        _ => MinFilter::LinearMipmapLinear,
    };
    // Files that ask for a lesser filter mean it; more taps would hide it.
    let max_anisotropy = if min == MinFilter::LinearMipmapLinear { Sampler::default().max_anisotropy } else { 1 };
    Sampler { wrap, mag, min, max_anisotropy }
}

/// KHR_texture_transform: scaled, then turned, then moved. The angle is counter-clockwise as one sees it, v pointing down
/// (the GLSL in the extension's text turns the other way; its words and its test model do not).
fn uv_transform(json: &Json) -> Result<UvTransform, Fault> {
    let offset = json.numbers("offset", [0.0; 2])?;
    let [sx, sy] = json.numbers("scale", [1.0; 2])?;
    let angle = json.number("rotation", 0.0)?;
    let (sin, cos) = (exact::sin(angle), exact::cos(angle));
    let matrix = [[cos * sx, sin * sy], [-sin * sx, cos * sy]];
    Ok(UvTransform { matrix: matrix.map(|row| row.map(|x| x as f32)), offset: offset.map(|x| x as f32) })
}

/// The material of glTF: white, and a rough metal unless it says otherwise. Seen from the front only.
pub(super) fn gltf_default() -> Material {
    Material {
        name: String::new(),
        base_color: [1.0; 4],
        metalness: 1.0,
        roughness: 1.0,
        double_sided: false,
        ..Material::default()
    }
}

fn clip(x: f64) -> f32 {
    x.clamp(0.0, 1.0) as f32
}
