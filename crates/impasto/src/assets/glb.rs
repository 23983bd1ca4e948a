//! A scene to GLB (glTF 2.0, binary), textures inside.
//!
//! One mesh with a primitive for each part; all primitives share their vertices. Reading it back gives the same arrays.
//!
//! What glTF cannot say is put into the nearest thing it can: wrap mode ClampToBorder becomes ClampToEdge; a separate
//! alpha texture goes into the base colour's alpha; float images become 16 bits; fields of f64 become f32. Bump maps and
//! fields on faces or corners have no place in glTF and are left out. glTF forbids NaN, so missing values of a field are
//! written as one number that the accessor's `extras.missing` names.

mod pixels;

use crate::Result;
use crate::assets::{
    AlphaMode, Element, Field, Material, MinFilter, Sampler, Scene, SceneLightKind, TextureRef, UvTransform,
};
use crate::assets::{Filter, Wrap};
use crate::error::Error;
use crate::math::{DVec3, Mat4, Projection, Vec3, exact};
use pixels::Use;
use serde_json::{Map, Value, json};

const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The bytes of a GLB file.
///
/// # Errors
/// A texture transform with shear, which KHR_texture_transform cannot say; a scene of more than 4 GiB.
pub fn write(scene: &Scene) -> Result<Vec<u8>> {
    let mut out = Output::default();
    let primitives = primitives(scene, &mut out);
    let materials = scene.materials.iter().map(|m| out.material(m, scene)).collect::<Result<Vec<_>>>()?;
    let mut nodes = Vec::new();
    if !primitives.is_empty() {
        nodes.push(json!({"mesh": 0, "name": scene.name}));
    }
    let cameras: Vec<Value> = scene.cameras.iter().map(|c| camera(&c.projection)).collect();
    for (i, c) in scene.cameras.iter().enumerate() {
        nodes.push(json!({"camera": i, "name": c.name, "matrix": numbers(&c.world_from_camera.to_cols_array())}));
    }
    let lights: Vec<Value> = scene.lights.iter().map(|l| light(&l.name, l.color, &l.kind)).collect();
    for (i, l) in scene.lights.iter().enumerate() {
        let matrix = numbers(&light_matrix(&l.kind).to_cols_array());
        nodes.push(json!({"extensions": {"KHR_lights_punctual": {"light": i}}, "name": l.name, "matrix": matrix}));
    }

    let mut root = Map::new();
    root.insert("asset".into(), json!({"version": "2.0", "generator": "Impasto"}));
    // Empty arrays are against glTF's schema: what is empty is not written.
    let mut put = |key: &str, values: Vec<Value>| {
        if !values.is_empty() {
            root.insert(key.into(), Value::Array(values));
        }
    };
    if !nodes.is_empty() {
        put("scenes", vec![json!({"nodes": (0..nodes.len()).collect::<Vec<_>>()})]);
    }
    put("nodes", nodes);
    if !primitives.is_empty() {
        put("meshes", vec![json!({"name": scene.name, "primitives": primitives})]);
    }
    put("materials", materials);
    put("textures", out.textures);
    put("images", out.images);
    put("samplers", out.samplers.iter().map(sampler).collect());
    put("cameras", cameras);
    put("accessors", out.accessors);
    put("bufferViews", out.views);
    if !lights.is_empty() {
        out.extensions.push("KHR_lights_punctual");
    }
    out.extensions.sort_unstable();
    out.extensions.dedup();
    put("extensionsUsed", out.extensions.iter().map(|&e| json!(e)).collect());
    if !out.bytes.is_empty() {
        put("buffers", vec![json!({"byteLength": out.bytes.len()})]);
    }
    if !lights.is_empty() {
        root.insert("extensions".into(), json!({"KHR_lights_punctual": {"lights": lights}}));
    }
    if root.contains_key("scenes") {
        root.insert("scene".into(), json!(0));
    }
    container(&Value::Object(root).to_string(), out.bytes, scene)
}

/// Header, JSON chunk padded with spaces, binary chunk padded with zeros.
fn container(text: &str, mut bytes: Vec<u8>, scene: &Scene) -> Result<Vec<u8>> {
    let mut text = text.as_bytes().to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let length = 12 + 8 + text.len() + if bytes.is_empty() { 0 } else { 8 + bytes.len() };
    let length = u32::try_from(length).map_err(|_| Error::Format {
        path: scene.name.clone().into(),
        fault: "the scene needs more than the 4 GiB that a GLB can hold".into(),
    })?;
    let mut out = Vec::with_capacity(length as usize);
    let word = |out: &mut Vec<u8>, x: u32| out.extend_from_slice(&x.to_le_bytes());
    out.extend_from_slice(b"glTF");
    word(&mut out, 2);
    word(&mut out, length);
    word(&mut out, text.len() as u32);
    out.extend_from_slice(b"JSON");
    out.extend_from_slice(&text);
    if !bytes.is_empty() {
        word(&mut out, bytes.len() as u32);
        out.extend_from_slice(b"BIN\0");
        out.extend_from_slice(&bytes);
    }
    Ok(out)
}

/// What has been written so far.
#[derive(Default)]
struct Output {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<Sampler>,
    /// Which texture shows which images of the scene, used how, read by which sampler.
    known_textures: Vec<(Use, usize)>,
    /// Which image was made from which of the scene's.
    known_images: Vec<Use>,
    extensions: Vec<&'static str>,
}

impl Output {
    /// Bytes at a multiple of four.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// An attribute of N floats a vertex, with its range.
    fn floats(&mut self, values: &[f32], n: usize) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        let kind = match n {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            9 => "MAT3",
            _ => "MAT4",
        };
        let range = |pick: fn(f32, f32) -> f32, start: f32| {
            let mut range = vec![start; n];
            for v in values.chunks_exact(n) {
                range.iter_mut().zip(v).for_each(|(r, &x)| *r = pick(*r, x));
            }
            numbers(&range)
        };
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len() / n, "type": kind,
            "min": range(f32::min, f32::INFINITY), "max": range(f32::max, f32::NEG_INFINITY)
        }));
        self.accessors.len() - 1
    }

    /// Corners of triangles, in 16 bits where they fit: the largest index of a type is reserved.
    fn indices(&mut self, triangles: &[[u32; 3]], n_vertices: usize) -> usize {
        let corners = triangles.as_flattened();
        let (bytes, kind): (Vec<u8>, u32) = if n_vertices <= u16::MAX as usize {
            (corners.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect(), 5123)
        } else {
            (corners.iter().flat_map(|i| i.to_le_bytes()).collect(), 5125)
        };
        let view = self.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        let range = [corners.iter().min(), corners.iter().max()].map(|x| x.copied().unwrap_or(0));
        self.accessors.push(json!({
            "bufferView": view, "componentType": kind, "count": corners.len(), "type": "SCALAR",
            "min": [range[0]], "max": [range[1]]
        }));
        self.accessors.len() - 1
    }

    /// A field on vertices as attributes whose names start with an underscore.
    fn field(&mut self, field: &Field, attributes: &mut Map<String, Value>) {
        const MISSING: f32 = f32::MIN;
        let number = |i: usize| Some(field.values.at(i) as f32).filter(|x| x.is_finite()).unwrap_or(MISSING);
        let all: Vec<f32> = (0..field.values.len()).map(number).collect();
        let n = field.n_components;
        let whole = matches!(n, 1..=4 | 9 | 16);
        for k in 0..if whole { 1 } else { n } {
            let accessor = match whole {
                true => self.floats(&all, n),
                false => self.floats(&all.iter().skip(k).step_by(n).copied().collect::<Vec<_>>(), 1),
            };
            let base = if field.name.starts_with('_') { field.name.clone() } else { format!("_{}", field.name) };
            let base = if whole { base } else { format!("{base}_{k}") };
            let mut name = base.clone();
            for i in 2.. {
                if !attributes.contains_key(&name) {
                    break;
                }
                name = format!("{base}_{i}");
            }
            let mut extras = Map::new();
            if whole && name != field.name {
                extras.insert("field".into(), json!(field.name));
            }
            if !field.unit.is_empty() {
                extras.insert("unit".into(), json!(field.unit));
            }
            if all.contains(&MISSING) {
                extras.insert("missing".into(), json!(MISSING as f64));
            }
            if !extras.is_empty() {
                self.accessors[accessor]["extras"] = Value::Object(extras);
            }
            attributes.insert(name, json!(accessor));
        }
    }

    fn material(&mut self, m: &Material, scene: &Scene) -> Result<Value> {
        let mut pbr = json!({
            "baseColorFactor": numbers(&m.base_color.map(|c| c.clamp(0.0, 1.0))),
            "metallicFactor": m.metalness as f64,
            "roughnessFactor": m.roughness as f64
        });
        let base = self.color_texture(m.base_color_texture, m.alpha_texture, scene)?;
        put(&mut pbr, "baseColorTexture", base);
        put(&mut pbr, "metallicRoughnessTexture", self.texture(m.metal_rough_texture, scene)?);
        let mut json = json!({"name": m.name, "pbrMetallicRoughness": pbr, "doubleSided": m.double_sided});
        put(&mut json, "normalTexture", with(self.texture(m.normal_texture, scene)?, "scale", m.normal_scale));
        let occlusion = with(self.texture(m.occlusion_texture, scene)?, "strength", m.occlusion_strength);
        put(&mut json, "occlusionTexture", occlusion);
        let emission = self.color_texture(m.emission_texture, None, scene)?;
        put(&mut json, "emissiveTexture", emission);
        match m.alpha_mode {
            AlphaMode::Opaque => {}
            AlphaMode::Mask(cutoff) => {
                json["alphaMode"] = json!("MASK");
                json["alphaCutoff"] = json!(cutoff as f64);
            }
            AlphaMode::Blend => json["alphaMode"] = json!("BLEND"),
        }

        let mut extensions = Map::new();
        let strength = m.emission.iter().fold(1.0f32, |a, &b| if b > a { b } else { a });
        json["emissiveFactor"] = numbers(&m.emission.map(|e| (e / strength).clamp(0.0, 1.0)));
        if strength > 1.0 {
            let value = json!({"emissiveStrength": strength as f64});
            extensions.insert("KHR_materials_emissive_strength".into(), value);
            self.extensions.push("KHR_materials_emissive_strength");
        }
        if m.unlit {
            extensions.insert("KHR_materials_unlit".into(), json!({}));
            self.extensions.push("KHR_materials_unlit");
        }
        let coat = &m.clearcoat;
        if coat.strength > 0.0 {
            let mut value =
                json!({"clearcoatFactor": coat.strength as f64, "clearcoatRoughnessFactor": coat.roughness as f64});
            put(&mut value, "clearcoatTexture", self.texture(coat.strength_texture, scene)?);
            put(&mut value, "clearcoatRoughnessTexture", self.texture(coat.roughness_texture, scene)?);
            let normal = with(self.texture(coat.normal_texture, scene)?, "scale", coat.normal_scale);
            put(&mut value, "clearcoatNormalTexture", normal);
            extensions.insert("KHR_materials_clearcoat".into(), value);
            self.extensions.push("KHR_materials_clearcoat");
        }
        if !extensions.is_empty() {
            json["extensions"] = Value::Object(extensions);
        }
        Ok(json)
    }

    /// A texture whose numbers are data.
    fn texture(&mut self, texture: Option<TextureRef>, scene: &Scene) -> Result<Option<Value>> {
        texture.map(|t| self.texture_info(t, Use::Data(t.image), scene)).transpose()
    }

    /// A texture whose numbers are colour (and perhaps another's alpha).
    fn color_texture(
        &mut self,
        color: Option<TextureRef>,
        alpha: Option<TextureRef>,
        scene: &Scene,
    ) -> Result<Option<Value>> {
        let shown = match (color, alpha) {
            (None, None) => return Ok(None),
            (Some(c), None) => (c, Use::Color(c.image)),
            (None, Some(a)) => (a, Use::Alpha(a.image)),
            (Some(c), Some(a)) => (c, Use::ColorAndAlpha(c.image, a.image)),
        };
        self.texture_info(shown.0, shown.1, scene).map(Some)
    }

    fn texture_info(&mut self, t: TextureRef, shown: Use, scene: &Scene) -> Result<Value> {
        let sampler = Sampler { max_anisotropy: 1, ..t.sampler };
        let sampler = position_or_push(&mut self.samplers, sampler);
        let known = self.known_textures.iter().position(|k| *k == (shown, sampler));
        let index = known.unwrap_or_else(|| {
            let image = self.image(shown, scene);
            self.textures.push(json!({"source": image, "sampler": sampler}));
            self.known_textures.push((shown, sampler));
            self.textures.len() - 1
        });
        let mut info = json!({"index": index});
        if t.uv_set != 0 {
            info["texCoord"] = json!(t.uv_set);
        }
        if t.transform != UvTransform::IDENTITY {
            info["extensions"] = json!({"KHR_texture_transform": transform(&t.transform, scene)?});
            self.extensions.push("KHR_texture_transform");
        }
        Ok(info)
    }

    fn image(&mut self, shown: Use, scene: &Scene) -> usize {
        if let Some(known) = self.known_images.iter().position(|k| *k == shown) {
            return known;
        }
        let (name, png) = pixels::png_of(shown, &scene.images);
        let view = self.view(&png, None);
        self.images.push(json!({"name": name, "mimeType": "image/png", "bufferView": view}));
        self.known_images.push(shown);
        self.images.len() - 1
    }
}

/// The mesh's attributes, shared, and its parts.
fn primitives(scene: &Scene, out: &mut Output) -> Vec<Value> {
    let mesh = &scene.mesh;
    let n = mesh.positions().len();
    if mesh.triangles().is_empty() {
        return Vec::new();
    }
    let mut attributes = Map::new();
    let flat = |v: &[Vec3]| -> Vec<f32> { v.iter().flat_map(|v| v.to_array()).collect() };
    attributes.insert("POSITION".into(), json!(out.floats(&flat(mesh.positions()), 3)));
    attributes.insert("NORMAL".into(), json!(out.floats(&flat(mesh.normals()), 3)));
    let four = |v: &[crate::math::Vec4]| -> Vec<f32> { v.iter().flat_map(|v| v.to_array()).collect() };
    if !mesh.tangents().is_empty() {
        attributes.insert("TANGENT".into(), json!(out.floats(&four(mesh.tangents()), 4)));
    }
    if !mesh.colors().is_empty() {
        attributes.insert("COLOR_0".into(), json!(out.floats(&four(mesh.colors()), 4)));
    }
    for (k, set) in mesh.uv_sets().iter().enumerate() {
        let uv: Vec<f32> = set.uv.iter().flat_map(|v| v.to_array()).collect();
        attributes.insert(format!("TEXCOORD_{k}"), json!(out.floats(&uv, 2)));
    }
    for field in mesh.fields().iter().filter(|f| f.element == Element::Vertex && f.n_components > 0) {
        out.field(field, &mut attributes);
    }
    let primitive = |part: &crate::assets::Part| {
        let range = part.triangles.start as usize..part.triangles.end as usize;
        let indices = out.indices(&mesh.triangles()[range], n);
        let mut json = json!({"attributes": attributes, "indices": indices, "extras": {"name": part.name}});
        if let Some(material) = part.material {
            json["material"] = json!(material);
        }
        json
    };
    mesh.parts().iter().filter(|p| !p.triangles.is_empty()).map(primitive).collect()
}

fn put(json: &mut Value, key: &str, value: Option<Value>) {
    if let Some(value) = value {
        json[key] = value;
    }
}

fn with(info: Option<Value>, key: &str, x: f32) -> Option<Value> {
    info.map(|mut info| {
        info[key] = json!(x as f64);
        info
    })
}

/// f32 as JSON numbers that give the same f32 back.
fn numbers(values: &[f32]) -> Value {
    Value::Array(values.iter().map(|&x| json!(x as f64)).collect())
}

fn position_or_push<T: PartialEq>(all: &mut Vec<T>, one: T) -> usize {
    all.iter().position(|x| *x == one).unwrap_or_else(|| {
        all.push(one);
        all.len() - 1
    })
}

fn sampler(s: &Sampler) -> Value {
    let wrap = |w: Wrap| match w {
        Wrap::Repeat => 10497,
        Wrap::MirroredRepeat => 33648,
        Wrap::ClampToEdge | Wrap::ClampToBorder => 33071,
    };
    let mag = if s.mag == Filter::Nearest { 9728 } else { 9729 };
    let min = match s.min {
        MinFilter::Nearest => 9728,
        MinFilter::Linear => 9729,
        MinFilter::NearestMipmapNearest => 9984,
        MinFilter::LinearMipmapNearest => 9985,
        MinFilter::NearestMipmapLinear => 9986,
        MinFilter::LinearMipmapLinear => 9987,
    };
    json!({"magFilter": mag, "minFilter": min, "wrapS": wrap(s.wrap[0]), "wrapT": wrap(s.wrap[1])})
}

/// Scale, then a turn counter-clockwise (v pointing down), then an offset: see the reader.
fn transform(t: &UvTransform, scene: &Scene) -> Result<Value> {
    let [[a, b], [c, d]] = t.matrix.map(|row| row.map(|x| x as f64));
    // Columns are (cos, -sin) * sx and (sin, cos) * sy.
    let sx = (a * a + c * c).sqrt();
    let (cos, sin) = if sx > 0.0 { (a / sx, -c / sx) } else { (1.0, 0.0) };
    let sy = b * sin + d * cos;
    let shear = (b - sin * sy).abs() + (d - cos * sy).abs();
    if shear > 1e-4 * (sx + sy.abs() + 1e-9) {
        return Err(Error::Format {
            path: scene.name.clone().into(),
            fault: "a texture transform with shear cannot be written to glTF".into(),
        });
    }
    let rotation = exact::atan2(sin, cos);
    let mut json = json!({"offset": numbers(&t.offset), "scale": [sx, sy]});
    if rotation != 0.0 {
        json["rotation"] = json!(rotation);
    }
    Ok(json)
}

fn camera(projection: &Projection) -> Value {
    match projection {
        Projection::Perspective { fov_y } => {
            json!({"type": "perspective", "perspective": {"yfov": *fov_y as f64, "znear": 0.01}})
        }
        Projection::Orthographic { height } => {
            let half = *height as f64 / 2.0;
            let view = json!({"xmag": half, "ymag": half, "znear": 0.01, "zfar": 1e4});
            json!({"type": "orthographic", "orthographic": view})
        }
    }
}

fn light(name: &str, color: [f32; 3], kind: &SceneLightKind) -> Value {
    let intensity = color.iter().fold(0.0f32, |a, &b| if b > a { b } else { a });
    let unit = if intensity > 0.0 { color.map(|c| (c / intensity).clamp(0.0, 1.0)) } else { [1.0; 3] };
    let kind_name = match kind {
        SceneLightKind::Directional(_) => "directional",
        SceneLightKind::Point(_) => "point",
        SceneLightKind::Spot { .. } => "spot",
    };
    let mut json = json!({"name": name, "type": kind_name, "color": numbers(&unit), "intensity": intensity as f64});
    if let SceneLightKind::Spot { cone, .. } = kind {
        let [inner, outer] = cone.map(|c| exact::acos((c as f64).clamp(-1.0, 1.0)));
        let outer = outer.clamp(1e-6, std::f64::consts::FRAC_PI_2);
        json["spot"] = json!({"innerConeAngle": inner.min(outer * 0.999_999), "outerConeAngle": outer});
    }
    json
}

/// A node that looks along its -Z where the light shines.
fn light_matrix(kind: &SceneLightKind) -> Mat4 {
    let (position, towards) = match kind {
        SceneLightKind::Directional(towards) => (Vec3::ZERO, *towards),
        SceneLightKind::Point(position) => (*position, Vec3::Z),
        SceneLightKind::Spot { position, axis, .. } => (*position, -*axis),
    };
    let z = DVec3::new(towards.x as f64, towards.y as f64, towards.z as f64);
    let unit = |v: DVec3| v / (v.x * v.x + v.y * v.y + v.z * v.z).sqrt();
    let side = if z.y * z.y < 0.9 * z.dot(z) { DVec3::Y } else { DVec3::X };
    let z = if z.dot(z) > 0.0 { unit(z) } else { DVec3::Z };
    let x = unit(side.cross(z));
    let y = z.cross(x);
    let column = |v: DVec3| v.as_vec3().extend(0.0);
    Mat4::from_cols(column(x), column(y), column(z), position.extend(1.0))
}

#[cfg(test)]
mod tests;
