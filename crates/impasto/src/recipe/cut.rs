//! A scene cut open: where the knife goes, what the grain is, and the two halves with their caps.

use crate::assets::{Material, Scene};
use crate::error::{Error, Mended, Report, Result, note};
use crate::math::{DVec3, Vec2, Vec3, Vec4, vec2, vec3};
use crate::recipe::CutRecipe;
use crate::recipe::laid_open::laid_open;
use crate::recipe::words::{choose, choose_or, color, impossible};
use crate::section::cut::skin::Skin;
use crate::section::cut::{self, CAP_NAME, Cut, Gap, Half, Policy, Relief, UV_NAME};
use crate::section::grain::figures::{Figure, figures};
use crate::section::grain::{
    Axis, Grain, GrainSpec, Hit, HitKind, Look, Polyhedron, SectionKind, Shape, Side, Window, with_interreflection,
};
use crate::section::{CutSurface, Plane};

/// A scene in two halves.
#[derive(Clone, Debug)]
pub struct Halves {
    /// What is below the plane, whose cap looks along its normal; and what is above. Closed where the scene was.
    pub scenes: [Scene; 2],
    /// Where the knife went.
    pub plane: Plane,
    /// The middle of the section: on the plane, model space.
    pub origin: DVec3,
    /// Where the outline of the section does not close.
    pub gaps: Vec<Gap>,
    /// What became of the gaps, and other things to know.
    pub mended: Vec<Mended>,
}

/// Cuts a scene as a recipe says. `seed` is the grain's where the recipe has none.
///
/// # Errors
/// `Parameter` for numbers and names that cannot be, among them a plane that misses the scene; `Format` for a section that
/// does not close under the policy `strict`.
pub fn halves(recipe: &CutRecipe, scene: &Scene, seed: u32) -> Result<Halves> {
    halves_lit(recipe, scene, seed, false)
}

/// The halves that a recipe asks for, laid open side by side: their sections look along +Z.
///
/// # Errors
/// As [`halves`].
pub(super) fn open(recipe: &CutRecipe, scene: Report<Scene>, seed: u32) -> Result<Report<Scene>> {
    let shown = shown(recipe)?;
    let mut halves = halves_lit(recipe, &scene.value, seed, true)?;
    let mut mended = scene.mended;
    mended.append(&mut halves.mended);
    Ok(Report { value: laid_open(halves, shown), mended })
}

/// Which halves a recipe asks for.
///
/// # Errors
/// A name that is not known.
pub fn shown(recipe: &CutRecipe) -> Result<[bool; 2]> {
    let known = [("both", [true, true]), ("a", [true, false]), ("b", [false, true])];
    choose_or("half", &recipe.half, &known, [true, true])
}

/// What stands between the particles, and what they are, of whom nothing is known.
const MATRIX: &str = "#ead9b8";
const PARTICLES: [&str; 6] = ["#c4573a", "#d9a441", "#7d9b6a", "#5b83a6", "#95627f", "#b98a62"];

/// `is_lit`: colours are darker where a point sees less of the sky, for pictures, whose light casts no shadows.
fn halves_lit(recipe: &CutRecipe, scene: &Scene, seed: u32, is_lit: bool) -> Result<Halves> {
    let mesh = &scene.mesh;
    if mesh.triangles().is_empty() {
        return Err(Error::Format { path: scene.name.clone().into(), fault: "it has no surface to cut".into() });
    }
    let kinds = [("tear", SectionKind::Tear), ("hollow", SectionKind::Hollow), ("solid", SectionKind::Solid)];
    let kind = choose_or("kind", &recipe.kind, &kinds, SectionKind::Tear)?;
    let is_flat = choose_or("relief", &recipe.relief, &[("footprint", false), ("none", true)], false)?;
    let paint = Paint::of(recipe, is_lit)?;
    let policy = policy(recipe)?;
    let figure = figure(recipe)?;
    let normal = recipe.normal.map(Vec3::from).or(figure.as_ref().map(|f| f.normal)).unwrap_or(Vec3::X);
    let plane = plane(recipe, normal, scene)?;
    let fill = fill(recipe, figure, scene, seed)?;

    let (origin, axes) = cut::section_frame(mesh, &plane);
    let cut = match &fill {
        None => cut::cut(mesh, &plane, policy),
        Some(Fill { grain, finest }) => {
            let window = window(scene, origin, axes);
            let pitch = finest * PITCH;
            let size = (window.max - window.min) / pitch;
            let n_corners = size.x * size.y;
            if n_corners > MOST_CORNERS {
                let why = format!(
                    "the particles are too small for this section: at most 4 million corners, not {n_corners:.1e}"
                );
                return Err(impossible("spacing", grain.spec().spacing, why));
            }
            let edges = grain.discs(&plane, window).map_or(Vec::new(), |discs| discs.edges(EDGE_CORNERS));
            let skin = Skin::of(mesh);
            let shows = |p: DVec3, side: Side| {
                let hit = grain.eval(p, &plane, Look { kind, side });
                if is_flat || hit.height == 0.0 {
                    return Hit { height: 0.0, ..hit };
                }
                // Within this distance there is no skin that a cavity could pierce.
                let most = WITHIN_SKIN * skin.distance(p) as f32;
                Hit { height: hit.height.clamp(-most, most), ..hit }
            };
            cut::cut_with_relief(mesh, &plane, policy, &Relief { pitch, points: &edges, shows: &shows })
        }
    };
    let cut = cut.map_err(|e| Error::Format { path: scene.name.clone().into(), fault: e.to_string() })?;
    let mended = remarks(&cut, policy);
    let Cut { below, above, gaps, .. } = cut;
    let scenes = [(below, Side::Below), (above, Side::Above)].map(|(half, side)| {
        let hit = |at: Vec2| {
            let p = origin + axes[0] * at.x as f64 + axes[1] * at.y as f64;
            fill.as_ref().map(|f| f.grain.eval(p, &plane, Look { kind, side }))
        };
        finish(half, scene, &paint, hit)
    });
    Ok(Halves { scenes, plane, origin, gaps, mended })
}

/// Relief goes so far of the way to the skin: something is left between them.
const WITHIN_SKIN: f32 = 0.9;

/// Distance of a cap's corners, in radii of the smallest particle.
const PITCH: f32 = 0.2;

/// Corners along the outline of each particle.
const EDGE_CORNERS: usize = 32;

/// More corners of a cap would not fit the memory of a usual machine.
const MOST_CORNERS: f32 = 4e6;

/// What has to be known of a cut that did not go smoothly.
fn remarks(cut: &Cut, policy: Policy) -> Vec<Mended> {
    let mut mended = Vec::new();
    let (bridged, open): (Vec<&Gap>, Vec<&Gap>) = cut.gaps.iter().partition(|g| g.bridged);
    let widest = |gaps: &[&Gap]| gaps.iter().map(|g| g.length).fold(0.0, f32::max);
    note(&mut mended, bridged.len(), format!("gaps of the outline bridged, the widest {} long", widest(&bridged)));
    let treated = match policy {
        Policy::Winding => "filled where more is inside than outside",
        _ => "left open",
    };
    note(&mut mended, open.len(), format!("gaps of the outline, the widest {} long, {treated}", widest(&open)));
    note(&mut mended, cut.overlaps as usize, "section in which bodies overlap, and their caps with them");
    note(&mut mended, cut.n_lost, "pieces of the outline without a cap");
    mended
}

/// A grain, and half of its particles' least extent, model units.
struct Fill {
    grain: Grain,
    finest: f32,
}

fn figure(recipe: &CutRecipe) -> Result<Option<Figure>> {
    let Some(number) = recipe.figure else { return Ok(None) };
    let found = figures().into_iter().find(|f| f.number == number);
    let numbers: Vec<String> = figures().iter().map(|f| f.number.to_string()).collect();
    found.map(Some).ok_or_else(|| impossible("figure", number, format!("one of {}", numbers.join(", "))))
}

/// The names of grains.
const GRAINS: [&str; 12] = [
    "sphere",
    "ellipsoid",
    "cylinder",
    "capsule",
    "box",
    "superquadric",
    "tetrahedron",
    "cube",
    "octahedron",
    "dodecahedron",
    "icosahedron",
    "none",
];

/// The grain a recipe asks for; none for a plain cut.
fn fill(recipe: &CutRecipe, figure: Option<Figure>, scene: &Scene, seed: u32) -> Result<Option<Fill>> {
    let extent = scene.mesh.bounds().extent();
    let (mut spec, finest) = match figure {
        Some(figure) => {
            let scale = extent.y / figure.height_cm;
            let spec = GrainSpec { spacing: figure.grain.spacing * scale, ..figure.grain };
            let (shape, finest) = match spec.shape {
                Shape::Cylinder { radius, height, ends } => {
                    let (radius, height) = (radius * scale, height * scale);
                    (Shape::Cylinder { radius, height, ends }, radius.min(0.5 * height))
                }
                Shape::Sphere { radius } => (Shape::Sphere { radius: radius * scale }, radius * scale),
                other => (other, spec.spacing * 0.5),
            };
            (GrainSpec { shape, ..spec }, finest)
        }
        None => {
            // As many particles as the bunny of Fig. 6 has.
            let spacing = recipe.spacing.unwrap_or(extent.max_element() * 0.03);
            let Some((shape, finest)) = shape(recipe, spacing)? else { return Ok(None) };
            (GrainSpec::of(shape, spacing), finest)
        }
    };
    if let Some(axis) = recipe.axis {
        spec.axis = Axis::Along(axis.into());
    }
    if let Some(cone) = recipe.cone {
        spec.axis = Axis::Cone(recipe.axis.map_or(Vec3::Y, Vec3::from), cone.to_radians());
    }
    spec.jitter = recipe.jitter.unwrap_or(spec.jitter);
    spec.size_spread = recipe.size_spread.unwrap_or(spec.size_spread);
    spec.seed = recipe.seed.unwrap_or(seed);
    if choose_or("profile", &recipe.profile, &[("fixed", false), ("paper", true)], false)? {
        spec = spec.to_the_letter();
    }
    Ok(Some(Fill { grain: Grain::new(spec)?, finest }))
}

/// The shape a recipe names, and half of its least extent.
fn shape(recipe: &CutRecipe, spacing: f32) -> Result<Option<(Shape, f32)>> {
    let name = recipe.grain.as_deref().unwrap_or("sphere");
    let known = GRAINS.map(|name| (name, name));
    let name = choose("grain", name, &known)?;
    let radius = recipe.radius.unwrap_or(0.5 * spacing);
    // Too short for a capsule would be a stump; too long for a cylinder has no room.
    let height = recipe.height.unwrap_or(radius * if name == "capsule" { 2.8 } else { 1.6 });
    let n_faces = |n| Polyhedron::regular(n, radius).map(Shape::Polyhedron);
    let positive = |what: &str, x: f32| match x > 0.0 && x.is_finite() {
        true => Ok(()),
        false => Err(impossible(what, x, "it is a length above zero")),
    };
    positive("spacing", spacing)?;
    positive("radius", radius)?;
    positive("height", height)?;
    let shape = match name {
        "none" => return Ok(None),
        "ellipsoid" => Shape::Ellipsoid { radii: vec3(radius, radius, 0.5 * height) },
        "cylinder" => Shape::Cylinder { radius, height, ends: Default::default() },
        "capsule" => Shape::Capsule { radius, height },
        "box" => Shape::Box { edges: vec3(2.0 * radius, 2.0 * radius, height), rounding: 0.0 },
        "superquadric" => Shape::Superquadric { radii: vec3(radius, radius, 0.5 * height), power: 4.0 },
        "tetrahedron" => n_faces(4)?,
        "cube" => n_faces(6)?,
        "octahedron" => n_faces(8)?,
        "dodecahedron" => n_faces(12)?,
        "icosahedron" => n_faces(20)?,
        _ => Shape::Sphere { radius },
    };
    let is_long = matches!(name, "ellipsoid" | "cylinder" | "capsule" | "box" | "superquadric");
    Ok(Some((shape, if is_long { radius.min(0.5 * height) } else { radius })))
}

fn policy(recipe: &CutRecipe) -> Result<Policy> {
    let Some(given) = recipe.policy.as_deref() else { return Ok(Policy::Winding) };
    match given.split_once(':') {
        Some(("bridge", length)) => match length.trim().parse::<f32>() {
            Ok(length) if length > 0.0 && length.is_finite() => Ok(Policy::Bridge(length)),
            _ => Err(impossible("policy", given, "bridge:LENGTH takes a length above zero")),
        },
        _ if given == "bridge" => Err(impossible("policy", given, "say up to which length: bridge:LENGTH")),
        _ => {
            let known = [("strict", Policy::Strict), ("winding", Policy::Winding), ("open", Policy::Open)];
            choose("policy", given, &known)
        }
    }
}

/// Where the knife goes: it has part of the scene on either side.
fn plane(recipe: &CutRecipe, normal: Vec3, scene: &Scene) -> Result<Plane> {
    let mesh = &scene.mesh;
    let point = recipe.through.map_or(mesh.bounds().center(), Vec3::from);
    let plane = Plane::through(point, normal)?;
    let used = mesh.triangles().iter().flatten().map(|&v| plane.distance(mesh.positions()[v as usize].as_dvec3()));
    let (low, high) = used.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), d| (a.min(d), b.max(d)));
    match (recipe.at, recipe.through) {
        (Some(at), Some(_)) => {
            Err(impossible("at", at, "the plane goes through a point already: leave one of them out"))
        }
        (None, Some(_)) if low < 0.0 && high > 0.0 => Ok(plane),
        (None, Some(_)) => {
            let given = format!("{},{},{}", point.x, point.y, point.z);
            let why = format!("the plane misses the mesh, which lies {low:.4} to {high:.4} from it");
            Err(impossible("point of the cut", given, why))
        }
        (at, None) => {
            let at = at.unwrap_or(0.5);
            if !(at > 0.0 && at < 1.0) {
                return Err(impossible(
                    "at",
                    at,
                    "a share of the way through: between 0 and 1, or the plane misses the mesh",
                ));
            }
            Ok(Plane { offset: plane.offset + low + (high - low) * at as f64, ..plane })
        }
    }
}

/// Around the scene's shadow on the plane.
fn window(scene: &Scene, origin: DVec3, axes: [DVec3; 2]) -> Window {
    let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for p in scene.mesh.positions() {
        let from = p.as_dvec3() - origin;
        let at = vec2(from.dot(axes[0]) as f32, from.dot(axes[1]) as f32);
        (min, max) = (min.min(at), max.max(at));
    }
    Window { origin, axes, min, max }
}

/// Colours of a cap.
struct Paint {
    matrix: Vec4,
    particles: Vec<Vec4>,
    is_lit: bool,
}

impl Paint {
    fn of(recipe: &CutRecipe, is_lit: bool) -> Result<Self> {
        let matrix = color("matrix", recipe.matrix.as_deref().unwrap_or(MATRIX))?.into();
        let particles = match &recipe.particles {
            Some(given) => vec![color("particles", given)?.into()],
            None => PARTICLES.iter().map(|c| color("particles", c).map(Vec4::from)).collect::<Result<_>>()?,
        };
        Ok(Self { matrix, particles, is_lit })
    }

    /// What a hit looks like.
    fn color(&self, hit: &Hit) -> Vec4 {
        let base = match hit.kind {
            HitKind::Matrix | HitKind::Bevel => self.matrix,
            HitKind::Bump | HitKind::Cavity | HitKind::Disc => {
                let name = hit.particle.wrapping_mul(0x9e37_79b1);
                let color = self.particles[(name >> 8) as usize % self.particles.len()];
                // No two of a kind are quite alike.
                let light = 0.85 + 0.3 * (name & 0xff) as f32 / 255.0;
                (color.truncate() * light).min(Vec3::ONE).extend(color.w)
            }
        };
        if !self.is_lit {
            return base;
        }
        let lit = |albedo: f32| albedo * with_interreflection(hit.openness, albedo);
        Vec4::new(lit(base.x), lit(base.y), lit(base.z), base.w)
    }
}

/// A half as a scene of its own; the cap is its last part. `hit` tells what a place of the section shows, if it has a grain.
fn finish(half: Half, scene: &Scene, paint: &Paint, hit: impl Fn(Vec2) -> Option<Hit>) -> Scene {
    let Half { mut raw, cap, cap_vertices } = half;
    let mut materials = scene.materials.clone();
    let (first, last) = (cap_vertices.start as usize, cap_vertices.end as usize);
    let flat = raw.uv_sets.iter().find(|s| s.name == UV_NAME).map_or(&[][..], |s| &s.uv[first..last]);
    let seen: Option<Vec<Vec4>> = flat.iter().map(|&at| hit(at).map(|h| paint.color(&h))).collect();
    let mut cap_color = Vec4::ONE;
    match seen.filter(|s| !s.is_empty()) {
        None => cap_color = paint.matrix,
        Some(seen) => {
            if raw.colors.is_empty() {
                raw.colors = vec![Vec4::ONE; raw.positions.len()];
                // Colours must not turn clay white.
                let clay = materials.len() as u32;
                materials.push(Material { name: "clay".into(), ..Material::default() });
                raw.parts.iter_mut().for_each(|p| p.material = p.material.or(Some(clay)));
            }
            raw.colors[first..last].copy_from_slice(&seen);
        }
    }
    if let Some(part) = raw.parts.last_mut().filter(|_| !cap.is_empty()) {
        part.material = Some(materials.len() as u32);
        let base_color = cap_color.to_array();
        materials.push(Material { name: CAP_NAME.into(), base_color, roughness: 0.6, ..Material::default() });
    }
    Scene { mesh: raw.trusted(), materials, ..scene.clone_without_mesh() }
}

impl Scene {
    /// All but the surface.
    fn clone_without_mesh(&self) -> Self {
        Self {
            images: self.images.clone(),
            cameras: self.cameras.clone(),
            lights: self.lights.clone(),
            up_note: self.up_note.clone(),
            ..Self::of(self.name.clone(), Default::default())
        }
    }
}
