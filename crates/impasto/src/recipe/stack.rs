//! Layers of a recipe to layers of looks: textures prepared, coordinates placed, operators named.

use crate::assets::cube_layout::{self, Faces};
use crate::assets::{CubeLayout, Filter, Mesh, MinFilter, Sampler, Scene, Wrap};
use crate::color::Encoding;
use crate::error::{Error, Mended, Result};
use crate::lookup::{
    BaseFormat, Channel, Compare, ImageTexture, Layer, Operator, Pattern, Prepare, Procedural, Target, Texture,
    TextureId, Usage,
};
use crate::math::{Mat4, Projection, Size, Vec3, exact, vec3};
use crate::picture::sphere_texture::Material;
use crate::picture::{Lighting, sphere_texture};
use crate::placement::{
    self, CubeFaces, Direction, Intermediate, ObjectRay, Placement, PositionUnit, Projector, Space, TwoPart, Viewpoint,
    cube_faces,
};
use crate::recipe::layer::{LayerRecipe, Numbers, Words};
use crate::recipe::view::finite;
use crate::recipe::words::{choose, choose_or, color, impossible};
use crate::recipe::{data, source};
use crate::visibility::Camera;
use std::path::Path;

/// What layers are made for.
pub(super) struct Ground<'a> {
    pub(super) scene: &'a Scene,
    pub(super) base: &'a Path,
    pub(super) seed: u32,
    /// UV set of layers that name none.
    pub(super) uv_set: usize,
    /// Those that layers name.
    pub(super) grids: &'a [data::Sampled],
    /// From where the surface is seen.
    pub(super) view: Viewpoint,
    pub(super) lighting: &'a Lighting,
    /// What the ball of `lights` is made of.
    pub(super) ball: Material,
    /// Tables that are worked out already.
    pub(super) known: &'a [data::Key],
}

/// The image that is a ball in the picture's own light.
pub(super) const LIGHTS: &str = "lights";
/// Texels across that ball.
const N_LIGHTS: u32 = 512;

/// A layer and the texture it reads.
///
/// `uv_set` holds its coordinates already if they were worked out at the vertices.
pub(super) fn layer(
    recipe: &LayerRecipe,
    uv_set: Option<usize>,
    on: &Ground,
    mended: &mut Vec<Mended>,
) -> Result<(Layer, Texture)> {
    let recipe = &completed(recipe);
    let target = target(recipe)?;
    let operator = operator(recipe, target)?;
    let placement = uv_set.map_or_else(|| placement(recipe, on), |set| Ok(Placement::Uv(set)))?;
    let texture = texture(recipe, on, target, mended)?;
    let strength = recipe.strength.unwrap_or(1.0);
    if !(0.0..=1.0).contains(&strength) {
        return Err(impossible("strength", strength, "0 (no effect) to 1 (the whole)"));
    }
    let matrix = if uv_set.is_some() { Mat4::IDENTITY } else { matrix(recipe)? };
    let channels = channels(recipe)?;
    Ok((Layer { placement, matrix, texture: TextureId(0), operator, target, channels, strength }, texture))
}

/// What the image `lights` goes without saying.
fn completed(recipe: &LayerRecipe) -> LayerRecipe {
    let mut recipe = recipe.clone();
    if recipe.image.as_deref() == Some(LIGHTS) {
        recipe.coordinate.get_or_insert_with(|| "view-normal".into());
        recipe.operator.get_or_insert_with(|| "replace".into());
        recipe.wrap.get_or_insert_with(|| Words::One("clamp-to-edge".into()));
    }
    recipe
}

/// Works the coordinates of a layer out at the vertices, as another UV set of the mesh.
pub(super) fn at_vertices(recipe: &LayerRecipe, on: &Ground, mended: &mut Vec<Mended>) -> Result<Mesh> {
    let recipe = &completed(recipe);
    let placement = placement(recipe, on)?;
    let mesh = on.scene.mesh.clone();
    if mesh.uv_sets().len() >= 32 {
        return Err(impossible("per_vertex", true, "the surface has 32 UV sets already"));
    }
    if let Some(faces) = cube(recipe, on, mended)? {
        let how = CubeFaces { n_texels: faces[0].texels.size().width, ..CubeFaces::default() };
        return Ok(cube_faces(&placement, &on.view, mesh, how).mesh);
    }
    let set = placement::at_vertices(&placement, &matrix(recipe)?, &on.view, &mesh);
    Ok(mesh.with_uv_set(set))
}

/// The six faces a layer reads, if it reads a cube.
fn cube(recipe: &LayerRecipe, on: &Ground, mended: &mut Vec<Mended>) -> Result<Option<Faces>> {
    let making = (recipe.texels, recipe.seed.unwrap_or(on.seed));
    let layout = recipe.layout.as_deref();
    if let Some(names) = &recipe.images {
        let shape = recipe.shape.as_deref().unwrap_or("cube");
        return match choose("shape", shape, &[("cube", true), ("volume", false)])? {
            true => source::cube(names, layout, on.base, making, mended).map(Some),
            false => Ok(None),
        };
    }
    // Where a direction is the coordinate, one picture may hold the six faces it picks from.
    let is_direction = matches!(recipe.coordinate.as_deref(), Some("reflection-map" | "normal-map"));
    let Some(name) = recipe.image.as_ref().filter(|_| is_direction || layout.is_some()) else { return Ok(None) };
    let is_stack = source::STACKS.iter().any(|s| name.strip_prefix(source::SAMPLE) == Some(s));
    if layout.is_none() && !is_stack {
        let image = source::image(name, on.base, making, &mut Vec::new())?;
        if source::cube_layout(None, &image)? == CubeLayout::Panorama {
            return Ok(None);
        }
    }
    source::cube(std::slice::from_ref(name), layout, on.base, making, mended).map(Some)
}

fn target(recipe: &LayerRecipe) -> Result<Target> {
    let amount = recipe.amount.unwrap_or(1.0);
    if !amount.is_finite() {
        return Err(impossible("amount", amount, "it must be finite"));
    }
    choose_or(
        "target",
        &recipe.target,
        &[
            ("color", Target::Color),
            ("alpha", Target::Alpha),
            ("normal", Target::Normal { scale: amount }),
            ("bump", Target::Bump { scale: amount }),
            ("roughness", Target::Roughness),
            ("metalness", Target::Metalness),
            ("occlusion", Target::Occlusion),
            ("emission", Target::Emission),
            ("coat", Target::Coat),
            ("coat-roughness", Target::CoatRoughness),
            ("coat-normal", Target::CoatNormal { scale: amount }),
            ("height", Target::Height { scale: amount }),
            ("info", Target::Info),
        ],
        Target::Color,
    )
}

fn operator(recipe: &LayerRecipe, target: Target) -> Result<Operator> {
    use Compare as C;
    let constant = recipe.color.as_deref().map_or(Ok([0.0, 0.0, 0.0, 1.0]), |c| color("layer color", c))?;
    let compare = choose_or(
        "compare",
        &recipe.compare,
        &[
            ("never", C::Never),
            ("less", C::Less),
            ("equal", C::Equal),
            ("less-or-equal", C::LessOrEqual),
            ("greater", C::Greater),
            ("not-equal", C::NotEqual),
            ("greater-or-equal", C::GreaterOrEqual),
            ("always", C::Always),
        ],
        C::GreaterOrEqual,
    )?;
    let reference = recipe.reference.unwrap_or(0.5);
    // Numbers that are data replace; a picture tints what is there.
    let is_picture = matches!(target, Target::Color | Target::Alpha | Target::Occlusion);
    let absent = match () {
        _ if !is_picture || recipe.table.is_some() => Operator::Replace,
        // What a filter hides of alpha is gone, whatever was there.
        _ if recipe.filter.is_some() && target == Target::Alpha => Operator::Modulate,
        _ if recipe.is_data() => Operator::Over,
        _ => Operator::Modulate,
    };
    choose_or(
        "operator",
        &recipe.operator,
        &[
            ("replace", Operator::Replace),
            ("modulate", Operator::Modulate),
            ("decal", Operator::Decal),
            ("blend", Operator::Blend(constant)),
            ("add", Operator::Add),
            ("over", Operator::Over),
            ("alpha-test", Operator::AlphaTest(compare, reference)),
        ],
        absent,
    )
}

// Where the coordinate comes from.

fn placement(recipe: &LayerRecipe, on: &Ground) -> Result<Placement> {
    if let Some(name) = &recipe.carried {
        return data::colors(name, on);
    }
    let absent = if recipe.is_data() { "field" } else { "uv" };
    let given = recipe.coordinate.as_deref().unwrap_or(absent);
    const NAMES: [&str; 17] = [
        "uv",
        "object-linear",
        "eye-linear",
        "world-linear",
        "sphere-map",
        "reflection-map",
        "normal-map",
        "view-normal",
        "panorama",
        "planar",
        "cylindrical",
        "spherical",
        "box",
        "camera",
        "two-part",
        "field",
        "position",
    ];
    let space = choose_or("space", &recipe.space, &[("world", Space::World), ("eye", Space::Eye)], Space::World)?;
    Ok(match choose("coordinate", given, &NAMES.map(|n| (n, n)))? {
        "uv" => Placement::Uv(uv_set(recipe, on)?),
        "object-linear" => Placement::ObjectLinear { planes: planes(recipe)?, world_from_object: None },
        "eye-linear" => Placement::EyeLinear { planes: planes(recipe)? },
        "world-linear" => Placement::WorldLinear { planes: planes(recipe)? },
        "sphere-map" => Placement::SphereMap,
        "reflection-map" => Placement::ReflectionMap { space },
        "normal-map" => Placement::NormalMap { space },
        "view-normal" => Placement::ViewNormal,
        "panorama" => Placement::Equirectangular {
            direction: choose_or(
                "direction",
                &recipe.direction,
                &[
                    ("reflection", Direction::Reflection),
                    ("normal", Direction::Normal),
                    ("position", Direction::Position),
                ],
                Direction::Reflection,
            )?,
            space,
        },
        "planar" => Placement::Planar { projector: projector(recipe, on)? },
        "cylindrical" => Placement::Cylindrical { projector: projector(recipe, on)? },
        "spherical" => Placement::Spherical { projector: projector(recipe, on)? },
        "box" => Placement::Box { projector: projector(recipe, on)? },
        "camera" => Placement::Camera { clip_from_world: slide_projector(recipe, on)? },
        "two-part" => Placement::TwoPart(TwoPart {
            surface: choose_or(
                "surface",
                &recipe.surface,
                &[
                    ("plane", Intermediate::Plane),
                    ("cylinder", Intermediate::Cylinder),
                    ("sphere", Intermediate::Sphere),
                    ("box", Intermediate::Box),
                ],
                Intermediate::Cylinder,
            )?,
            ray: choose_or(
                "ray",
                &recipe.ray,
                &[
                    ("reflected-ray", ObjectRay::ReflectedRay),
                    ("object-normal", ObjectRay::ObjectNormal),
                    ("centroid", ObjectRay::Centroid),
                    ("surface-normal", ObjectRay::SurfaceNormal),
                ],
                ObjectRay::SurfaceNormal,
            )?,
            projector: projector(recipe, on)?,
        }),
        "field" => data::placement(recipe, on)?,
        _ => Placement::Position {
            unit: choose_or(
                "unit",
                &recipe.unit,
                &[("model", PositionUnit::Model), ("bounds", PositionUnit::Bounds)],
                PositionUnit::Bounds,
            )?,
        },
    })
}

fn uv_set(recipe: &LayerRecipe, on: &Ground) -> Result<usize> {
    let sets = on.scene.mesh.uv_sets();
    if sets.is_empty() {
        return Err(Error::NoUv {
            path: on.scene.name.clone().into(),
            task: "lay an image over it (--unwrap does so), or choose another coordinate, like coordinate=box,",
        });
    }
    let Some(given) = recipe.uv_set.as_deref() else { return Ok(on.uv_set) };
    let found = sets.iter().position(|s| s.name == given).or_else(|| given.parse().ok().filter(|i| *i < sets.len()));
    found.ok_or_else(|| {
        let names: Vec<&str> = sets.iter().map(|s| s.name.as_str()).collect();
        impossible("UV set", given, format!("there are {}", names.join(", ")))
    })
}

fn planes(recipe: &LayerRecipe) -> Result<[crate::math::Vec4; 3]> {
    // Without planes: x, and y downward, as images have it.
    let absent = vec![[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let given = recipe.planes.as_ref().unwrap_or(&absent);
    if given.len() > 3 || given.iter().flatten().any(|x| !x.is_finite()) {
        return Err(impossible("planes", format!("{given:?}"), "up to three planes [a, b, c, d] of finite numbers"));
    }
    Ok(std::array::from_fn(|i| given.get(i).copied().unwrap_or([0.0; 4]).into()))
}

fn projector(recipe: &LayerRecipe, on: &Ground) -> Result<Option<Projector>> {
    if recipe.front.is_none() && recipe.up.is_none() && recipe.origin.is_none() && recipe.extent.is_none() {
        return Ok(None);
    }
    let front = recipe.front.map_or(Ok(Vec3::Z), |v| finite("front", v))?;
    let up = recipe.up.map_or(Ok(Vec3::Y), |v| finite("up", v))?;
    let mut projector = Projector::facing(&on.scene.mesh.bounds(), front, up);
    if let Some(origin) = recipe.origin {
        projector.origin = finite("origin", origin)?;
    }
    if let Some(extent) = recipe.extent {
        projector.size = finite("extent", extent)?;
    }
    Ok(Some(projector))
}

fn slide_projector(recipe: &LayerRecipe, on: &Ground) -> Result<Mat4> {
    let bounds = on.scene.mesh.bounds();
    let radius = bounds.radius().max(1e-20);
    let target = recipe.target_or(bounds.center())?;
    let eye = recipe.eye.map_or(Ok(target + vec3(0.0, 0.0, 3.0 * radius)), |v| finite("eye", v))?;
    let up = recipe.up.map_or(Ok(Vec3::Y), |v| finite("up", v))?;
    let fov = recipe.fov.unwrap_or(35.0);
    if !(fov > 0.0 && fov < 179.0) {
        return Err(impossible("fov", fov, "above 0 and below 179 degrees"));
    }
    let camera = Camera::looking(eye, target, up, Projection::Perspective { fov_y: fov.to_radians() }, radius * 1e-3);
    let focal = 1.0 / exact::tan(fov.to_radians() as f64 * 0.5) as f32;
    // w = -z; depth from 0 near to 1 far is of no use here: z/w is the distance's inverse.
    let clip_from_camera = Mat4::from_cols_array_2d(&[
        [focal, 0.0, 0.0, 0.0],
        [0.0, focal, 0.0, 0.0],
        [0.0, 0.0, 0.0, -1.0],
        [0.0, 0.0, 1.0, 0.0],
    ]);
    Ok(clip_from_camera * camera.camera_from_world())
}

impl LayerRecipe {
    fn target_or(&self, center: Vec3) -> Result<Vec3> {
        self.aim.map_or(Ok(center), |v| finite("aim", v))
    }
}

// Which texture is read.

fn texture(recipe: &LayerRecipe, on: &Ground, target: Target, mended: &mut Vec<Mended>) -> Result<Texture> {
    let seed = recipe.seed.unwrap_or(on.seed);
    let words = [&recipe.image, &recipe.procedural, &recipe.table, &recipe.carried, &recipe.filter];
    let n_sources = words.iter().filter(|s| s.is_some()).count()
        + recipe.images.is_some() as usize
        + recipe.isolines.is_some() as usize;
    if n_sources != 1 {
        let why = "a layer reads one of image, images, procedural, table, carried, isolines or filter";
        return Err(impossible("layer", n_sources, why));
    }
    if recipe.is_data() {
        return data::texture(recipe, on, target, mended);
    }
    if recipe.carried.is_some() {
        return Ok(Texture::Carried(Encoding::Linear));
    }
    if let Some(name) = &recipe.procedural {
        return Ok(Texture::Procedural(procedural(name, recipe, seed)?));
    }
    let how = how(recipe, target)?;
    if recipe.image.as_deref() == Some(LIGHTS) {
        let image = sphere_texture(on.lighting, &on.view, &on.ball, Size::new(N_LIGHTS, N_LIGHTS));
        return Ok(Texture::Image(ImageTexture::new(&image, &how)));
    }
    if let Some(faces) = cube(recipe, on, mended)? {
        if recipe.per_vertex == Some(true) {
            // A column of pictures: coarser levels would mix neighbours.
            let min = if recipe.min.is_some() { how.sampler.min } else { MinFilter::Linear };
            let sampler = Sampler { wrap: [Wrap::ClampToEdge; 3], min, max_anisotropy: 1, ..how.sampler };
            return Ok(Texture::Image(ImageTexture::new(&cube_layout::strip(&faces), &Prepare { sampler, ..how })));
        }
        return Ok(Texture::Image(ImageTexture::cube(&faces, &how)?));
    }
    if let Some(names) = &recipe.images {
        let slices = source::images(names, on.base, (recipe.texels, seed), mended)?;
        return Ok(Texture::Image(ImageTexture::volume(&slices, &how)?));
    }
    let image = source::image(recipe.image.as_deref().unwrap_or_default(), on.base, (recipe.texels, seed), mended)?;
    Ok(Texture::Image(ImageTexture::new(&image, &how)))
}

pub(super) const FILTERS: [(&str, Filter); 2] = [("nearest", Filter::Nearest), ("linear", Filter::Linear)];

/// How an image is prepared.
fn how(recipe: &LayerRecipe, target: Target) -> Result<Prepare> {
    let absent = match target {
        Target::Color | Target::Emission => Usage::Color,
        Target::Normal { .. } | Target::CoatNormal { .. } => Usage::Normal,
        Target::Bump { .. } => Usage::Slope,
        _ => Usage::Data,
    };
    let usage = choose_or(
        "usage",
        &recipe.usage,
        &[
            ("color", Usage::Color),
            ("data", Usage::Data),
            ("normal", Usage::Normal),
            ("slope", Usage::Slope),
            ("label", Usage::Label),
        ],
        absent,
    )?;
    let format = match &recipe.format {
        None => None,
        Some(given) => Some(choose(
            "format",
            given,
            &[
                ("alpha", BaseFormat::Alpha),
                ("luminance", BaseFormat::Luminance),
                ("luminance-alpha", BaseFormat::LuminanceAlpha),
                ("intensity", BaseFormat::Intensity),
                ("rgb", BaseFormat::Rgb),
                ("rgba", BaseFormat::Rgba),
            ],
        )?),
    };
    Ok(Prepare { format, ..Prepare::new(usage, sampler(recipe)?) })
}

/// How an image is read.
pub(super) fn sampler(recipe: &LayerRecipe) -> Result<Sampler> {
    const WRAPS: [(&str, Wrap); 4] = [
        ("repeat", Wrap::Repeat),
        ("mirrored-repeat", Wrap::MirroredRepeat),
        ("clamp-to-edge", Wrap::ClampToEdge),
        ("clamp-to-border", Wrap::ClampToBorder),
    ];
    let default = Sampler::default();
    let wrap = match &recipe.wrap {
        None => default.wrap,
        Some(Words::One(word)) => [choose("wrap", word, &WRAPS)?; 3],
        Some(Words::Each(words)) => {
            let mut wrap = default.wrap;
            if words.is_empty() || words.len() > 3 {
                return Err(impossible("wrap", words.len(), "one word, or one each for s, t and r"));
            }
            for (slot, word) in wrap.iter_mut().zip(words) {
                *slot = choose("wrap", word, &WRAPS)?;
            }
            wrap
        }
    };
    let min = choose_or(
        "min",
        &recipe.min,
        &[
            ("nearest", MinFilter::Nearest),
            ("linear", MinFilter::Linear),
            ("nearest-mipmap-nearest", MinFilter::NearestMipmapNearest),
            ("linear-mipmap-nearest", MinFilter::LinearMipmapNearest),
            ("nearest-mipmap-linear", MinFilter::NearestMipmapLinear),
            ("linear-mipmap-linear", MinFilter::LinearMipmapLinear),
        ],
        default.min,
    )?;
    // Who names a filter wants that filter, not more taps of it.
    let anisotropy = recipe.anisotropy.unwrap_or(if recipe.min.is_some() { 1 } else { default.max_anisotropy });
    if !(1..=16).contains(&anisotropy) {
        return Err(impossible("anisotropy", anisotropy, "1 to 16"));
    }
    Ok(Sampler { wrap, mag: choose_or("mag", &recipe.mag, &FILTERS, default.mag)?, min, max_anisotropy: anisotropy })
}

fn procedural(name: &str, recipe: &LayerRecipe, seed: u32) -> Result<Procedural> {
    let factor = recipe.shape_factor;
    if factor.is_some_and(|f| !f.is_finite()) {
        return Err(impossible("shape_factor", f32::NAN, "it must be finite"));
    }
    let octaves = factor.unwrap_or(5.0).clamp(1.0, 16.0) as u32;
    let pattern = choose(
        "procedural",
        name,
        &[
            ("stripes", Pattern::Stripes { share: factor.unwrap_or(0.5) }),
            ("checker", Pattern::Checker),
            ("noise", Pattern::Noise { octaves, gain: 0.5 }),
            ("cells", Pattern::Cells),
            ("wood", Pattern::Wood { bend: factor.unwrap_or(0.5) }),
            ("marble", Pattern::Marble { bend: factor.unwrap_or(2.0) }),
        ],
    )?;
    let [dark, bright] = match &recipe.colors {
        None => [[0.0, 0.0, 0.0, 1.0], [1.0; 4]],
        Some([a, b]) => [color("layer colors", a)?, color("layer colors", b)?],
    };
    let frequency = recipe.frequency.unwrap_or(8.0);
    if frequency.is_nan() || frequency.abs() >= 1e6 {
        return Err(impossible("frequency", frequency, "features in one unit of the coordinate"));
    }
    Ok(Procedural { pattern, frequency: [frequency; 3], colors: [dark, bright], seed })
}

fn channels(recipe: &LayerRecipe) -> Result<[Channel; 4]> {
    let Some(given) = recipe.channels.as_deref() else { return Ok(Channel::RGBA) };
    let letters: Option<Vec<Channel>> = given
        .chars()
        .map(|c| {
            Some(match c {
                'r' => Channel::Red,
                'g' => Channel::Green,
                'b' => Channel::Blue,
                'a' => Channel::Alpha,
                '0' => Channel::Zero,
                '1' => Channel::One,
                _ => return None,
            })
        })
        .collect();
    match letters.as_deref() {
        Some(&[one]) => Ok([one; 4]),
        Some(&[r, g, b, a]) => Ok([r, g, b, a]),
        _ => Err(impossible("channels", given, "one or four letters of rgba01")),
    }
}

/// Coordinates are scaled about the origin, turned about the middle of the image, and moved.
fn matrix(recipe: &LayerRecipe) -> Result<Mat4> {
    let finite = |m: Mat4| if m.is_finite() { Ok(m) } else { Err(impossible("matrix", "", "numbers must be finite")) };
    if let Some(rows) = recipe.matrix {
        return finite(Mat4::from_cols_array_2d(&rows).transpose());
    }
    let scale = recipe.scale.as_ref().map_or([1.0; 3], |s: &Numbers| s.three(1.0));
    let offset = recipe.offset.as_ref().map_or([0.0; 3], |o: &Numbers| o.three(0.0));
    let mut matrix = Mat4::from_scale(scale.into());
    if let Some(degrees) = recipe.rotate {
        let angle = degrees as f64 * (std::f64::consts::PI / 180.0);
        let (s, c) = (exact::sin(angle) as f32, exact::cos(angle) as f32);
        // t runs down: this turns the picture counter-clockwise as it is seen on the surface.
        let turn = Mat4::from_cols_array_2d(&[
            [c, s, 0.0, 0.0],
            [-s, c, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]);
        let middle = Vec3::new(0.5, 0.5, 0.0);
        matrix = Mat4::from_translation(middle) * turn * Mat4::from_translation(-middle) * matrix;
    }
    finite(Mat4::from_translation(offset.into()) * matrix)
}
