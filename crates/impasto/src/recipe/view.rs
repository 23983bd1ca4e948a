//! From where, in which light, before what: cameras, lights and backgrounds of a recipe.

use crate::assets::Scene;
use crate::color::LinearRgb;
use crate::error::{Error, Result};
use crate::math::{Projection, Size, Vec3, unit_or};
use crate::picture::legend::{LegendLayout, Position};
use crate::picture::{Background, Curve, Develop, Environment, Light, LightKind, Lighting, Reflection};
use crate::placement::Viewpoint;
use crate::recipe::words::{choose, choose_or, color, impossible};
use crate::recipe::{CameraRecipe, LightRecipe, PictureRecipe, Recipe};
use crate::visibility::camera::FOV_Y;
use crate::visibility::{Camera, Direction, Domain};
use std::sync::Arc;

/// Which of the two directions the surface is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// Cells are pixels.
    Camera(Camera),
    /// Cells are texels of the layout by this UV set.
    Atlas(usize),
}

/// The views with a name.
const VIEWS: [&str; 9] = ["three-quarter", "front", "back", "left", "right", "top", "bottom", "atlas", "file"];

/// What share of the shorter side an object fills.
const FILL: f32 = 0.8;

/// The part of a picture that the object is framed in, from its upper edge; the rest is the legend's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Columns to the left of it.
    pub left: u32,
    /// Pixels across and down.
    pub size: Size,
}

impl Frame {
    /// What a legend leaves of a picture of `size`.
    pub(super) fn beside(legend: Option<&LegendLayout>, size: Size) -> Self {
        let Some(LegendLayout { width: room, position, .. }) = legend else { return Self { left: 0, size } };
        let (left, across, down) = match position {
            Position::Right => (0, *room, 0),
            Position::Left => (*room, *room, 0),
            Position::Bottom => (0, 0, *room),
        };
        Self { left, size: Size::new(size.width - across, size.height - down) }
    }

    /// What lies in both.
    pub(super) fn and(self, other: Self) -> Self {
        let left = self.left.max(other.left);
        let right = (self.left + self.size.width).min(other.left + other.size.width);
        Self { left, size: Size::new(right - left, self.size.height.min(other.size.height)) }
    }
}

impl View {
    /// How the scene's surface maps to cells: the view fills `frame`, a part of a picture of `size`, and goes on beside it.
    pub fn domain<'a>(&self, scene: &'a Scene, frame: Frame, size: Size) -> Domain<'a> {
        match self {
            Self::Camera(camera) => {
                let seen = Domain::through_camera(&scene.mesh, camera, frame.size).moved_right(frame.left);
                Domain { size, ..seen }
            }
            Self::Atlas(set) => Domain::over_atlas(&scene.mesh, *set, size),
        }
    }
}

/// The view a recipe asks for.
pub(super) fn view(recipe: &CameraRecipe, scene: &Scene, size: Size) -> Result<View> {
    view_of(recipe, scene, size, || seen_points(scene))
}

/// The first view of a turn about the vertical line through the object's middle (or the camera's target), and that
/// middle. Where the recipe leaves the framing to us, it holds for the whole turn.
pub(super) fn turning_view(recipe: &CameraRecipe, scene: &Scene, size: Size) -> Result<(Camera, Vec3)> {
    let middle = recipe.target.map_or(Ok(scene.mesh.bounds().center()), |t| finite("target", t))?;
    match view_of(recipe, scene, size, || swept(&seen_points(scene), scene.mesh.bounds().center()))? {
        View::Camera(camera) => Ok((camera, middle)),
        View::Atlas(_) => Err(impossible("camera", "atlas", "an atlas cannot be walked around")),
    }
}

/// What points sweep when they turn about the vertical line through `middle`: rings around it, one above the other.
fn swept(points: &[Vec3], middle: Vec3) -> Vec<Vec3> {
    const N_SLICES: usize = 256;
    const N_AROUND: usize = 128;
    let (least, most) = points.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), p| (a.min(p.y), b.max(p.y)));
    // Of each slice: lowest and highest point, and the greatest distance from the line.
    let mut slices = [(f32::INFINITY, f32::NEG_INFINITY, 0.0f32); N_SLICES];
    for p in points {
        let share = (p.y - least) / (most - least).max(f32::MIN_POSITIVE);
        let slice = &mut slices[((share * N_SLICES as f32) as usize).min(N_SLICES - 1)];
        let [x, z] = [p.x - middle.x, p.z - middle.z];
        *slice = (slice.0.min(p.y), slice.1.max(p.y), slice.2.max((x * x + z * z).sqrt()));
    }
    let around: Vec<[f32; 2]> = (0..N_AROUND)
        .map(|i| i as f64 * (2.0 * std::f64::consts::PI / N_AROUND as f64))
        .map(|a| [crate::math::exact::cos(a) as f32, crate::math::exact::sin(a) as f32])
        .collect();
    let ring = |y: f32, r: f32| around.iter().map(move |[c, s]| Vec3::new(middle.x + r * c, y, middle.z + r * s));
    let used = slices.iter().filter(|s| s.0 <= s.1);
    used.flat_map(|(low, high, r)| ring(*low, *r).chain(ring(*high, *r))).collect()
}

fn view_of(recipe: &CameraRecipe, scene: &Scene, size: Size, points: impl Fn() -> Vec<Vec3>) -> Result<View> {
    let name = recipe.view.as_deref().unwrap_or("three-quarter");
    if name == "atlas" {
        let set = recipe.uv_set.unwrap_or(0) as usize;
        let n_sets = scene.mesh.uv_sets().len();
        return match n_sets {
            0 => Err(Error::NoUv { path: scene.name.clone().into(), task: "look at its atlas" }),
            n if set < n => Ok(View::Atlas(set)),
            n => Err(impossible("UV set", set, format!("there are {n}, counted from 0"))),
        };
    }
    let fov_y = recipe.fov.map_or(Ok(FOV_Y), fov)?;
    let perspective = Projection::Perspective { fov_y };
    let is_parallel = recipe.orthographic.unwrap_or(false);
    if let Some(eye) = recipe.eye {
        let eye = finite("eye", eye)?;
        let bounds = scene.mesh.bounds();
        let target = recipe.target.map_or(Ok(bounds.center()), |t| finite("target", t))?;
        let up = recipe.up.map_or(Ok(Vec3::Y), |u| finite("up", u))?;
        let distance = (eye - target).length().max(1e-20);
        let near = (distance * 1e-3).max(1e-30);
        let height = 2.0 * distance * crate::math::exact::tan(fov_y as f64 * 0.5) as f32;
        let projection = if is_parallel { Projection::Orthographic { height } } else { perspective };
        return Ok(View::Camera(Camera::looking(eye, target, up, projection, near)));
    }
    if let Some(camera) = of_file(name, scene)? {
        return Ok(View::Camera(camera));
    }
    let named = Direction::named(name)
        .ok_or_else(|| impossible("camera", name, crate::recipe::text::guess(name, &known_views(scene))))?;
    let direction = match (recipe.azimuth, recipe.elevation) {
        (None, None) => named,
        (azimuth, elevation) => {
            let (a, e) =
                (azimuth.unwrap_or(named.azimuth.to_degrees()), elevation.unwrap_or(named.elevation.to_degrees()));
            if !(a.abs() <= 3600.0 && e.abs() <= 90.0) {
                return Err(impossible("camera", format!("{a},{e}"), "elevation is -90 to 90 degrees"));
            }
            Direction::degrees(a, e)
        }
    };
    let fill = recipe.fill.unwrap_or(FILL);
    if !(fill > 0.0 && fill <= 100.0) {
        return Err(impossible("fill", fill, "above 0, and 1 for the whole shorter side"));
    }
    let projection = if is_parallel { Projection::Orthographic { height: 1.0 } } else { perspective };
    let camera = match recipe.target {
        None => Camera::framing(&points(), direction, projection, size, fill),
        // Looking at one place: as large as the whole object would be.
        Some(target) => {
            let framed = Camera::framing(&points(), direction, projection, size, fill);
            let shift = finite("target", target)? - scene.mesh.bounds().center();
            let mut world_from_camera = framed.world_from_camera;
            world_from_camera.w_axis += shift.extend(0.0);
            Camera { world_from_camera, near: framed.near.min(scene.mesh.bounds().radius() * 1e-3), ..framed }
        }
    };
    Ok(View::Camera(camera))
}

/// Positions that triangles use: stray vertices must not push the object out of the middle.
fn seen_points(scene: &Scene) -> Vec<Vec3> {
    let mesh = &scene.mesh;
    let mut is_used = vec![false; mesh.positions().len()];
    mesh.triangles().iter().flatten().for_each(|&v| is_used[v as usize] = true);
    mesh.positions().iter().zip(is_used).filter(|(_, used)| *used).map(|(p, _)| *p).collect()
}

fn known_views(scene: &Scene) -> Vec<&str> {
    VIEWS.into_iter().chain(scene.cameras.iter().map(|c| c.name.as_str())).collect()
}

/// A camera of the file: by name, by number, or the first for `file`.
fn of_file(name: &str, scene: &Scene) -> Result<Option<Camera>> {
    let by_name = scene.cameras.iter().find(|c| !c.name.is_empty() && c.name == name);
    let number = if name == "file" { Some(0) } else { name.parse::<usize>().ok() };
    let found = match (by_name, number) {
        (Some(camera), _) => camera,
        (None, None) => return Ok(None),
        (None, Some(i)) => scene.cameras.get(i).ok_or_else(|| match scene.cameras.len() {
            0 => impossible("camera", name, "the file has no cameras"),
            n => impossible("camera", name, format!("the file has {n}, counted from 0")),
        })?,
    };
    let radius = scene.mesh.bounds().radius();
    Ok(Some(Camera {
        world_from_camera: found.world_from_camera,
        projection: found.projection,
        near: (radius * 1e-3).max(1e-30),
    }))
}

fn fov(degrees: f32) -> Result<f32> {
    match degrees {
        d if d > 0.0 && d < 179.0 => Ok(d.to_radians()),
        d => Err(impossible("fov", d, "above 0 and below 179 degrees")),
    }
}

pub(super) fn finite(what: &str, v: [f32; 3]) -> Result<Vec3> {
    let v3 = Vec3::from(v);
    if v3.is_finite() { Ok(v3) } else { Err(impossible(what, format!("{v:?}"), "numbers must be finite")) }
}

/// All light of a recipe.
pub(super) fn lighting(
    recipe: &Recipe,
    scene: &Scene,
    viewpoint: &Viewpoint,
    environment: Option<Arc<Environment>>,
) -> Result<Lighting> {
    let kinds = ["studio", "headlight", "outdoor", "flat", "file"];
    let kind = recipe.picture.light.as_deref().unwrap_or("studio");
    let index = choose("light", kind, &std::array::from_fn::<_, 5, _>(|i| (kinds[i], i)))?;
    let mut lighting = match kinds[index] {
        "studio" => Lighting::studio(viewpoint),
        "headlight" => Lighting::headlight(),
        "outdoor" => Lighting::outdoor(Vec3::new(-0.4, 0.7, 0.6)),
        "flat" => Lighting::flat(1.0),
        _ => {
            if scene.lights.is_empty() {
                return Err(impossible("light", "file", "the file has no lights"));
            }
            let mut lighting = Lighting::studio(viewpoint);
            lighting.lights = scene.lights.iter().map(Light::of_scene).collect();
            lighting
        }
    };
    let is_surrounded = environment.is_some();
    if let Some(environment) = environment {
        lighting.lights.clear();
        lighting.ambient = environment.ambient;
        lighting.reflection = Reflection::Environment(environment);
    }
    if !recipe.lights.is_empty() || recipe.picture.ambient.is_some() {
        lighting.lights = recipe.lights.iter().map(light).collect::<Result<_>>()?;
        let ambient = recipe.picture.ambient.unwrap_or(0.15);
        if !is_surrounded {
            let flat = Lighting::flat(ambient);
            (lighting.ambient, lighting.reflection) = (flat.ambient, flat.reflection);
        }
    }
    Ok(lighting)
}

fn light(recipe: &LightRecipe) -> Result<Light> {
    let direction = recipe.direction.map_or(Ok(Vec3::new(-0.5, 0.7, 0.5)), |d| finite("light direction", d))?;
    let position = || recipe.position.ok_or_else(|| impossible("light", "point", "it needs a position"));
    let kind = recipe.kind.as_deref().unwrap_or("directional");
    let kind = match choose("light kind", kind, &[("directional", 0), ("point", 1), ("spot", 2), ("headlight", 3)])? {
        0 => LightKind::Directional(unit_or(direction, Vec3::Y)),
        1 => LightKind::Point(finite("light position", position()?)?),
        2 => {
            let cone = recipe.cone.unwrap_or([20.0, 30.0]);
            if !(cone[0] >= 0.0 && cone[1] >= cone[0] && cone[1] <= 90.0) {
                return Err(impossible("cone", format!("{cone:?}"), "inner and outer half angle, 0 to 90 degrees"));
            }
            let cosine = |deg: f32| crate::math::exact::cos(deg.to_radians() as f64) as f32;
            LightKind::Spot {
                position: finite("light position", position()?)?,
                axis: unit_or(direction, Vec3::NEG_Y),
                cone: cone.map(cosine),
            }
        }
        _ => LightKind::Headlight,
    };
    let rgb = recipe.color.as_deref().map_or(Ok([1.0; 4]), |c| color("light color", c))?;
    let positive = |what: &str, x: f32| match x {
        x if x >= 0.0 && x.is_finite() => Ok(x),
        x => Err(impossible(what, x, "zero or more")),
    };
    Ok(Light {
        color: [rgb[0], rgb[1], rgb[2]],
        intensity: positive("intensity", recipe.intensity.unwrap_or(1.0))?,
        size: positive("light size", recipe.size.unwrap_or(0.0))?.min(1.0),
        ..Light::new(kind)
    })
}

/// What is seen where no surface is.
pub(super) fn background(recipe: &PictureRecipe) -> Result<Background> {
    let given = recipe.background.as_deref().unwrap_or("light");
    if let Some(background) = Background::by_name(given) {
        let Background::Environment { .. } = background else { return Ok(background) };
        if recipe.environment.is_none() {
            return Err(impossible("background", given, "it needs an environment: --environment IMAGE"));
        }
        let blur = recipe.environment_blur.unwrap_or(0.0);
        if !(0.0..=1.0).contains(&blur) {
            return Err(impossible("environment blur", blur, "0 (sharp) to 1 (a wash of light)"));
        }
        return Ok(Background::Environment { blur });
    }
    let plain = |c: [f32; 4]| Background::Plain([c[0], c[1], c[2]] as LinearRgb);
    color("background", given).map(plain).map_err(|_| {
        let guess = crate::recipe::text::guess(given, &crate::picture::background::NAMES);
        impossible("background", given, format!("{guess}; or a colour like #f4f3f0"))
    })
}

/// How light becomes bytes: filmic for what is lit, plain for what is not.
pub(super) fn develop(recipe: &Recipe, is_lit: bool, background: Background) -> Result<Develop> {
    let absent = if is_lit { Curve::Filmic } else { Curve::Plain };
    let curve =
        choose_or("develop", &recipe.picture.develop, &[("filmic", Curve::Filmic), ("plain", Curve::Plain)], absent)?;
    let exposure = recipe.picture.exposure.unwrap_or(0.0);
    if exposure.is_nan() || exposure.abs() > 30.0 {
        return Err(impossible("exposure", exposure, "-30 to 30 stops"));
    }
    // Slow gradients would show their steps.
    let is_slow = matches!(background, Background::Gradient { .. }) || recipe.picture.ground == Some(true);
    let dither = is_slow && curve == Curve::Filmic;
    Ok(Develop { curve, exposure, dither, ..Develop::PLAIN })
}

impl std::fmt::Display for View {
    /// Enough to set the same camera again.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let camera = match self {
            Self::Camera(camera) => camera,
            Self::Atlas(set) => return write!(f, "atlas of UV set {set}"),
        };
        let v = |v: Vec3| format!("{},{},{}", v.x, v.y, v.z);
        let [_, up, back] = camera.axes();
        write!(f, "eye {} toward {} up {}", v(camera.eye()), v(-back), v(up))?;
        match camera.projection {
            Projection::Perspective { fov_y } => write!(f, " fov {} degrees", fov_y.to_degrees()),
            Projection::Orthographic { height } => write!(f, " parallel, height {height}"),
        }
    }
}
