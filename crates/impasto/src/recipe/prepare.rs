//! A recipe to the engine's nouns: scene, looks, view, light.

use crate::assets::{AlphaMode, Mesh, Scene, TextureImage};
use crate::color::LinearRgba;
use crate::error::{Error, Mended, Report, Result, note};
use crate::lookup::{ImageTexture, Layer, Look, Looks, Operator, Prepare, Shading, Target, Texture, TextureId, Usage};
use crate::math::{Mat4, Size, Vec3, exact};
use crate::par::Workers;
use crate::picture::legend::LegendLayout;
use crate::picture::sphere_texture::Material;
use crate::picture::{Backdrop, Background, Develop, Environment, Lighting, gouraud};
use crate::placement::{self, Placement, UnwrapOptions, Viewpoint};
use crate::recipe::change::Making;
use crate::recipe::data::{self, Key};
use crate::recipe::layer::LayerRecipe;
use crate::recipe::legend::{Labelled, Legend};
use crate::recipe::source::Surroundings;
use crate::recipe::view::Frame;
use crate::recipe::words::{choose, color, impossible};
use crate::recipe::{CameraRecipe, Recipe, SurfaceRecipe, View, cut, legend, source, stack, view};
use crate::section::cut::CAP_NAME;
use crate::visibility::{Camera, Samples};
use std::path::Path;
use std::sync::Arc;

/// All that a picture depends on, loaded and checked.
pub struct Prepared {
    /// What is shown.
    pub scene: Scene,
    /// What its surfaces look like.
    pub looks: Looks,
    /// From where.
    pub view: View,
    /// Pixels across and down.
    pub size: Size,
    /// The part of the picture that the object is framed in.
    pub frame: Frame,
    /// Places looked at in each pixel.
    pub samples: Samples,
    /// What lights it.
    pub lighting: Lighting,
    /// Colours as they are, whatever the light.
    pub unlit: bool,
    /// What is seen where no surface is.
    pub background: Background,
    /// Of the background `environment`: what is seen along each line of sight.
    pub backdrop: Option<Backdrop>,
    /// How light becomes bytes.
    pub develop: Develop,
    /// A contact shadow on a floor.
    pub ground: bool,
    /// What colours stand for, one for each table layer.
    pub keys: Vec<Key>,
    /// What says so, drawn over the picture.
    pub legend: Option<(Legend, LegendLayout)>,
    /// Isolines that have their values written on them.
    pub labelled: Vec<Labelled>,
    /// What the layers were made from, for another go at them.
    pub(super) making: Making,
}

/// The size of a picture that says nothing about it.
pub const SIZE: [u32; 2] = [1280, 720];

/// Pictures above this many pixels are refused: they would not fit the memory of a usual machine.
const MOST_PIXELS: u64 = 1 << 28;

/// Loads what a recipe names, from files beside `base`.
///
/// # Errors
/// What the files' readers say; `Parameter` for names and numbers that cannot be.
pub fn prepare(recipe: &Recipe, base: &Path, workers: &Workers) -> Result<Report<Prepared>> {
    check(recipe)?;
    prepare_from(recipe, base, None, workers)
}

/// What can be told to be wrong before anything is loaded.
fn check(recipe: &Recipe) -> Result<()> {
    size(recipe)?;
    samples(recipe)?;
    view::background(&recipe.picture).map(|_| ())
}

fn samples(recipe: &Recipe) -> Result<Samples> {
    let n = recipe.picture.samples.unwrap_or(4);
    Samples::from_n(n).ok_or_else(|| impossible("samples", n, "1, 4 or 16"))
}

/// The same for a scene that is loaded already, in place of the one that the recipe names.
///
/// # Errors
/// As those of [`prepare()`].
pub fn prepare_scene(
    recipe: &Recipe,
    scene: Report<Scene>,
    base: &Path,
    workers: &Workers,
) -> Result<Report<Prepared>> {
    prepare_seen(recipe, scene, (base, None), workers)
}

/// What a recipe names, seen by `camera` instead of the recipe's.
pub(super) fn prepare_from(
    recipe: &Recipe,
    base: &Path,
    camera: Option<Camera>,
    workers: &Workers,
) -> Result<Report<Prepared>> {
    prepare_seen(recipe, source::scene(&recipe.input, base)?, (base, camera), workers)
}

fn prepare_seen(
    recipe: &Recipe,
    scene: Report<Scene>,
    (base, camera): (&Path, Option<Camera>),
    workers: &Workers,
) -> Result<Report<Prepared>> {
    let size = size(recipe)?;
    let samples = samples(recipe)?;
    let background = view::background(&recipe.picture)?;

    let scene = match &recipe.cut {
        Some(cut) => cut::open(cut, scene, (base, on_seed(recipe)), size.width.max(size.height), workers)?,
        None => scene,
    };
    let Report { value: mut scene, mut mended } = scene;
    let mut uv_set = 0;
    if recipe.input.unwrap == Some(true) {
        let mesh = std::mem::take(&mut scene.mesh);
        let unwrapped = placement::unwrap(mesh, UnwrapOptions::default())?;
        mended.extend(unwrapped.mended);
        scene.mesh = unwrapped.value.mesh;
        uv_set = unwrapped.value.uv_set;
    }
    if scene.mesh.triangles().is_empty() {
        return Err(Error::Format { path: recipe.subject().into(), fault: "it has no surface to show".into() });
    }
    let seed = on_seed(recipe);
    let grids = data::grids(&recipe.layers, base, &scene, &mut mended)?;
    let ball = Material { shading: Shading::Unlit, color: [1.0; 3], roughness: 1.0, metalness: 0.0 };
    let mut making = Making { base: base.into(), seed, uv_set, grids, ball, textures: Vec::new() };
    // The legend takes its room from the view, so it comes before there is one: data need none.
    let nowhere = Viewpoint { eye_from_world: Mat4::IDENTITY, eye: Vec3::ZERO, parallel: Some(Vec3::Z) };
    let dark = Lighting::flat(0.0);
    let on = making.on(&scene, nowhere, &dark, &[]);
    let (keys, legend, labelled) = legend::told(recipe, &on, (size, background), &mut mended)?;
    let on = stack::Ground { known: &keys, ..on };
    let table_colors = match recipe.layers.iter().find(|l| l.gouraud == Some(true)) {
        Some(layer) => Some(data::vertex_colors(layer, &on)?),
        None => None,
    };
    let frame = Frame::beside(legend.as_ref().map(|(_, layout)| layout), size);
    let view = match camera {
        Some(camera) => View::Camera(camera),
        None => view::view(&recipe.seen_from(), &scene, frame.size)?,
    };
    let around = match &recipe.picture.environment {
        None => None,
        Some(names) => {
            let layout = recipe.picture.environment_layout.as_deref();
            Some(source::surroundings(names, layout, base, on_seed(recipe), &mut mended)?)
        }
    };
    let viewpoint = view.domain(&scene, frame, size).view;
    let backdrop = backdrop(background, around.as_ref(), &view, workers)?;
    let environment = around.map(|around| match around {
        Surroundings::Panorama(image) => Environment::of_panorama(&image, 0.0, workers),
        Surroundings::Cube(faces) => Environment::of_cube(&faces, workers),
    });
    let environment = environment.map(Arc::new);
    let lighting = view::lighting(recipe, &scene, &viewpoint, environment)?;

    let mut uv_sets = Vec::new();
    for layer in &recipe.layers {
        let is_per_vertex = layer.per_vertex == Some(true);
        if is_per_vertex {
            let on = making.on(&scene, viewpoint, &lighting, &keys);
            scene.mesh = stack::at_vertices(layer, &on, &mut mended)?;
        }
        uv_sets.push(is_per_vertex.then(|| scene.mesh.uv_sets().len() - 1));
    }
    let on = making.on(&scene, viewpoint, &lighting, &keys);
    let (mut looks, textures, ball) = looks(recipe, &uv_sets, &on, &mut mended)?;
    if let Some(colors) = table_colors {
        scene.mesh = colored(std::mem::take(&mut scene.mesh), colors);
        looks.looks.iter_mut().for_each(|l| l.uses_vertex_colors = true);
    }
    if is_gouraud(recipe) {
        let colors = gouraud(&scene.mesh, &lighting, &viewpoint, &ball);
        scene.mesh = std::mem::take(&mut scene.mesh).with_colors(colors);
        for look in &mut looks.looks {
            look.uses_vertex_colors = true;
            look.constants.color = [1.0, 1.0, 1.0, look.constants.color[3]];
        }
    }
    tangents(&mut scene, &looks, &mut mended);
    let unlit = recipe.picture.unlit.unwrap_or(false);
    let is_lit = !unlit && looks.looks.iter().any(|l| l.shading != Shading::Unlit);
    let develop = view::develop(recipe, is_lit && !recipe.shows_data(), background)?;
    let ground = recipe.picture.ground.unwrap_or(false);
    (making.textures, making.ball) = (textures, ball);
    let value = Prepared {
        scene,
        looks,
        view,
        size,
        frame,
        samples,
        lighting,
        unlit,
        background,
        backdrop,
        develop,
        ground,
        keys,
        legend,
        labelled,
        making,
    };
    Ok(Report { value, mended })
}

/// What is seen behind the surface, where that is what lights it.
fn backdrop(
    background: Background,
    around: Option<&Surroundings>,
    view: &View,
    workers: &Workers,
) -> Result<Option<Backdrop>> {
    let (Background::Environment { blur }, Some(around)) = (background, around) else { return Ok(None) };
    if matches!(view, View::Atlas(_)) {
        return Err(impossible("background", "environment", "over an atlas nothing is seen behind the surface"));
    }
    Ok(Some(match around {
        Surroundings::Panorama(image) => Backdrop::of_panorama(image, blur, workers),
        Surroundings::Cube(faces) => Backdrop::of_cube(faces, blur, workers),
    }))
}

fn on_seed(recipe: &Recipe) -> u32 {
    recipe.input.seed.unwrap_or(1)
}

fn size(recipe: &Recipe) -> Result<Size> {
    let [width, height] = recipe.picture.size.unwrap_or(match recipe.camera.view.as_deref() {
        Some("atlas") => [1024, 1024],
        _ => SIZE,
    });
    let n = width as u64 * height as u64;
    if n == 0 || n > MOST_PIXELS || width > 1 << 15 || height > 1 << 15 {
        return Err(impossible("size", format!("{width}x{height}"), "1x1 to 32768 a side, at most 268 million pixels"));
    }
    Ok(Size::new(width, height))
}

impl Recipe {
    /// The camera; what is cut open it looks into.
    pub(super) fn seen_from(&self) -> CameraRecipe {
        let mut camera = self.camera.clone();
        let (Some(cut), None, None) = (&self.cut, &camera.view, &camera.eye) else { return camera };
        if cut.is_laid_open() {
            camera.view = Some("front".into());
            camera.elevation = camera.elevation.or(Some(14.0));
            return camera;
        }
        // Beside the way in which the pieces come apart, so that both their sections and what is between them are seen.
        let [x, y, z] = cut.direction();
        let off = if cut.half.as_deref().is_none_or(|h| h == "both") { 50.0 } else { 32.0 };
        let is_upright = y.abs() > 0.9 * (x * x + z * z).sqrt();
        let facing = if cut.half.as_deref() == Some("b") { -1.0 } else { 1.0 };
        let azimuth =
            if is_upright { 0.0 } else { exact::atan2((facing * x) as f64, (facing * z) as f64).to_degrees() };
        camera.azimuth = camera.azimuth.or(Some(azimuth as f32 - off));
        camera.elevation = camera.elevation.or(Some(if is_upright && facing * y > 0.0 { 35.0 } else { 18.0 }));
        camera
    }

    /// Whether colours stand for numbers, so that light must not change them more than needed.
    pub fn shows_data(&self) -> bool {
        self.layers.iter().any(|l| l.table.is_some())
    }
}

/// Whether light is worked out at the vertices.
fn is_gouraud(recipe: &Recipe) -> bool {
    recipe.surface.shading.as_deref().is_some_and(|s| s.eq_ignore_ascii_case("gouraud"))
}

impl Recipe {
    /// Whether more than light and camera change from view to view: then each needs a [`prepare()`] of its own.
    pub fn is_made_for_one_view(&self) -> bool {
        let is_bound = |l: &LayerRecipe| l.per_vertex == Some(true) || l.image.as_deref() == Some(stack::LIGHTS);
        is_gouraud(self) || self.layers.iter().any(is_bound)
    }
}

/// What a ball is made of that is lit in the surface's place: its colour, with a highlight by Blinn and Phong.
fn ball(recipe: &SurfaceRecipe, looks: &Looks) -> Material {
    let [specular, exponent] = highlight(recipe);
    let constants = looks.looks.first().map(|l| l.constants).unwrap_or_default();
    let [r, g, b, _] = constants.color;
    let shading = Shading::BlinnPhong { specular, exponent };
    Material { shading, color: [r, g, b], roughness: constants.roughness, metalness: constants.metalness }
}

/// Strength and exponent of a highlight.
fn highlight(recipe: &SurfaceRecipe) -> [f32; 2] {
    [recipe.specular.unwrap_or(0.35), recipe.exponent.unwrap_or(48.0)]
}

/// The file's looks, changed as the recipe says; the texture of each of its layers; and the ball of [`stack::LIGHTS`].
fn looks(
    recipe: &Recipe,
    uv_sets: &[Option<usize>],
    on: &stack::Ground,
    mended: &mut Vec<Mended>,
) -> Result<(Looks, Vec<Option<TextureId>>, Material)> {
    let mut looks = match recipe.surface.plain {
        Some(true) => {
            let mut bare = on.scene.clone_without_materials();
            bare.name.clone_from(&on.scene.name);
            Looks::from_scene(&bare)
        }
        _ => Looks::from_scene(on.scene),
    };
    // What a cut lays bare has colours of its own.
    let is_cap = |part: &crate::assets::Part| recipe.cut.is_some() && part.name == CAP_NAME;
    let caps: Vec<usize> = (on.scene.mesh.parts().iter().zip(&looks.look_of_part))
        .filter(|(part, _)| is_cap(part))
        .map(|(_, look)| *look as usize)
        .collect();
    surface(&recipe.surface, &mut looks, &caps)?;
    let on = &stack::Ground { ball: ball(&recipe.surface, &looks), ..*on };
    if let Some(name) = &recipe.input.texture {
        let image = source::image(name, on.base, (None, on.seed), mended)?;
        dress(&mut looks, &image, on)?;
    }
    if recipe.layers.is_empty() {
        return Ok((looks, Vec::new(), on.ball));
    }
    let (mut layers, mut textures) = (Vec::new(), Vec::new());
    for (layer, uv_set) in recipe.layers.iter().zip(uv_sets) {
        if layer.gouraud == Some(true) {
            textures.push(None);
            continue;
        }
        let (mut made, texture) = stack::layer(layer, *uv_set, on, mended)?;
        made.texture = looks.add(texture);
        textures.push(Some(made.texture));
        layers.push(Worn { layer: made, parts: parts_named(layer, on.scene)?, alpha_mode: alpha_mode(layer) });
    }
    Ok((lay(looks, &layers), textures, on.ball))
}

/// Constants that the recipe sets, in every look; in those of `caps` only how they are shaded.
fn surface(recipe: &SurfaceRecipe, looks: &mut Looks, caps: &[usize]) -> Result<()> {
    let rgba = recipe.color.as_deref().map(|c| color("surface color", c)).transpose()?;
    let unit = |what: &str, x: Option<f32>| match x {
        Some(x) if !(0.0..=1.0).contains(&x) => Err(impossible(what, x, "0 to 1")),
        x => Ok(x),
    };
    let (alpha, roughness, metalness) =
        (unit("alpha", recipe.alpha)?, unit("roughness", recipe.roughness)?, unit("metalness", recipe.metalness)?);
    let shading = shading(recipe)?;
    let mode = match &recipe.alpha_mode {
        None if alpha.is_some_and(|a| a < 1.0) => Some(AlphaMode::Blend),
        None => None,
        Some(given) => {
            let cutoff = unit("cutoff", recipe.cutoff)?.unwrap_or(0.5);
            let modes = [("opaque", AlphaMode::Opaque), ("blend", AlphaMode::Blend), ("mask", AlphaMode::Mask(cutoff))];
            Some(choose("alpha_mode", given, &modes)?)
        }
    };
    for (i, look) in looks.looks.iter_mut().enumerate() {
        look.shading = shading.unwrap_or(look.shading);
        if caps.contains(&i) {
            continue;
        }
        if let Some(rgba) = rgba {
            look.layers.retain(|l| l.target != Target::Color);
            look.constants.color = rgba;
            look.uses_vertex_colors = false;
        }
        if let Some(alpha) = alpha {
            look.constants.color[3] = alpha;
        }
        if let Some(roughness) = roughness {
            look.layers.retain(|l| l.target != Target::Roughness);
            look.constants.roughness = roughness;
        }
        if let Some(metalness) = metalness {
            look.layers.retain(|l| l.target != Target::Metalness);
            look.constants.metalness = metalness;
        }
        look.alpha_mode = mode.unwrap_or(look.alpha_mode);
        look.is_double_sided = recipe.double_sided.unwrap_or(look.is_double_sided);
        look.uses_vertex_colors = recipe.vertex_colors.unwrap_or(look.uses_vertex_colors);
    }
    Ok(())
}

fn shading(recipe: &SurfaceRecipe) -> Result<Option<Shading>> {
    let [specular, exponent] = highlight(recipe);
    if !((0.0..1e6).contains(&specular) && (0.0..=1e6).contains(&exponent)) {
        return Err(impossible("highlight", format!("{specular}, {exponent}"), "strength and exponent are 0 or more"));
    }
    let known = [
        ("metal-rough", Shading::MetalRough),
        ("blinn-phong", Shading::BlinnPhong { specular, exponent }),
        ("lambert", Shading::Lambert),
        ("unlit", Shading::Unlit),
        // Lit before it is looked up.
        ("gouraud", Shading::Unlit),
    ];
    recipe.shading.as_deref().map(|given| choose("shading", given, &known)).transpose()
}

/// An image in place of the base colour.
fn dress(looks: &mut Looks, image: &TextureImage, on: &stack::Ground) -> Result<()> {
    if on.scene.mesh.uv_sets().is_empty() {
        return Err(Error::NoUv { path: on.scene.name.clone().into(), task: "lay a texture over it (--unwrap)" });
    }
    let how = Prepare::new(Usage::Color, stack::sampler(&LayerRecipe::default())?);
    let texture = looks.add(Texture::Image(ImageTexture::new(image, &how)));
    for look in &mut looks.looks {
        look.layers.retain(|l| l.target != Target::Color);
        let [.., alpha] = look.constants.color;
        look.constants.color = [1.0, 1.0, 1.0, alpha];
        look.uses_vertex_colors = false;
        let layer =
            Layer { placement: Placement::Uv(on.uv_set), ..Layer::new(texture, Operator::Modulate, Target::Color) };
        look.layers.insert(0, layer);
    }
    Ok(())
}

/// Which parts of the mesh a layer is for; none: all.
fn parts_named(layer: &LayerRecipe, scene: &Scene) -> Result<Option<Vec<bool>>> {
    let Some(wanted) = &layer.part else { return Ok(None) };
    let names = |part: &crate::assets::Part| {
        let material = part.material.and_then(|m| scene.materials.get(m as usize)).map_or("", |m| m.name.as_str());
        [part.name.clone(), material.to_owned()]
    };
    let parts = scene.mesh.parts();
    let is_meant: Vec<bool> = parts.iter().map(|p| names(p).iter().any(|n| n.contains(wanted.as_str()))).collect();
    if is_meant.contains(&true) {
        return Ok(Some(is_meant));
    }
    let mut known: Vec<String> = parts.iter().flat_map(names).filter(|n| !n.is_empty()).collect();
    known.dedup();
    Err(impossible("part", wanted, format!("the surface has {}", known.join(", "))))
}

/// What alpha means under a layer that makes some from data: a sharp cut, or something to look through.
fn alpha_mode(layer: &LayerRecipe) -> Option<AlphaMode> {
    let is_alpha = layer.is_data() && layer.target.as_deref() == Some("alpha");
    is_alpha.then_some(match (&layer.filter, layer.softness) {
        (Some(_), None | Some(0.0)) => AlphaMode::Mask(0.5),
        _ => AlphaMode::Blend,
    })
}

/// The mesh with vertex colours.
fn colored(mesh: Mesh, colors: Vec<LinearRgba>) -> Mesh {
    let mut raw = mesh.into_raw();
    raw.colors = colors.into_iter().map(Into::into).collect();
    raw.trusted()
}

/// A layer that a recipe adds.
struct Worn {
    layer: Layer,
    /// Which parts wear it; none: all.
    parts: Option<Vec<bool>>,
    /// What alpha means under it, if it says so.
    alpha_mode: Option<AlphaMode>,
}

/// Adds layers to the looks of the parts they are for; a look that only some of its parts keep is doubled.
fn lay(looks: Looks, layers: &[Worn]) -> Looks {
    let mut made: Vec<(u32, Vec<bool>)> = Vec::new();
    let mut out = Looks { textures: looks.textures, looks: Vec::new(), look_of_part: Vec::new() };
    for (part, &old) in looks.look_of_part.iter().enumerate() {
        let wears: Vec<bool> = layers.iter().map(|worn| worn.parts.as_ref().is_none_or(|p| p[part])).collect();
        let key = (old, wears);
        let index = made.iter().position(|m| *m == key).unwrap_or_else(|| {
            let mut look: Look = looks.looks[old as usize].clone();
            for Worn { layer, alpha_mode, .. } in layers.iter().zip(&key.1).filter(|(_, worn)| **worn).map(|(l, _)| l) {
                look.layers.push(layer.clone());
                if look.alpha_mode == AlphaMode::Opaque {
                    look.alpha_mode = alpha_mode.unwrap_or(AlphaMode::Opaque);
                }
            }
            out.looks.push(look);
            made.push(key.clone());
            made.len() - 1
        });
        out.look_of_part.push(index as u32);
    }
    out
}

/// Bumps need tangent frames along the coordinates of their map.
fn tangents(scene: &mut Scene, looks: &Looks, mended: &mut Vec<Mended>) {
    if !scene.mesh.tangents().is_empty() {
        return;
    }
    let bumps = looks.looks.iter().flat_map(|l| &l.layers).find_map(|l| match (l.target, &l.placement) {
        (Target::Normal { .. } | Target::CoatNormal { .. } | Target::Bump { .. }, Placement::Uv(set)) => Some(*set),
        _ => None,
    });
    let Some(set) = bumps.filter(|set| *set < scene.mesh.uv_sets().len()) else { return };
    let report = placement::with_tangents(std::mem::take(&mut scene.mesh), set);
    scene.mesh = report.value;
    note(mended, report.mended.iter().map(|m| m.count).sum(), "corners got a tangent frame of no particular direction");
}

impl Scene {
    /// The mesh and its cameras, without materials and images.
    fn clone_without_materials(&self) -> Self {
        let mut raw = self.mesh.clone().into_raw();
        raw.parts.iter_mut().for_each(|p| p.material = None);
        Self { mesh: raw.trusted(), materials: Vec::new(), images: Vec::new(), ..self.clone() }
    }
}
