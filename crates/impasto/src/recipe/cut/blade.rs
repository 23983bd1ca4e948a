//! Where the knife goes.

use crate::assets::Scene;
use crate::error::Result;
use crate::math::{DVec2, DVec3, Vec2, Vec3, vec2};
use crate::recipe::CutRecipe;
use crate::recipe::words::{choose, impossible};
use crate::section::cut::{Policy, section_frame};
use crate::section::grain::Window;
use crate::section::{CutSurface, Plane, Rough, Sheet, Stroke};

/// What cuts: a plane, or a surface laid along one.
#[derive(Clone, Debug)]
pub enum Blade {
    /// Straight.
    Plane(Plane),
    /// A plane with hills and dales.
    Rough(Rough),
    /// A line pushed through the model.
    Stroke(Stroke),
}

impl Blade {
    /// The plane, if it is one.
    pub fn plane(&self) -> Option<&Plane> {
        match self {
            Self::Plane(plane) => Some(plane),
            _ => None,
        }
    }

    /// The surface with its coordinates, if it is curved.
    pub fn sheet(&self) -> Option<&dyn Sheet> {
        match self {
            Self::Plane(_) => None,
            Self::Rough(rough) => Some(rough),
            Self::Stroke(stroke) => Some(stroke),
        }
    }

    /// The direction in which the halves come apart: out of the half below.
    pub fn direction(&self, middle: DVec3) -> DVec3 {
        match self {
            Self::Plane(plane) => plane.normal,
            Self::Rough(rough) => rough.plane.normal,
            Self::Stroke(stroke) => stroke.normal(middle),
        }
    }
}

impl CutSurface for Blade {
    fn distance(&self, p: DVec3) -> f64 {
        match self {
            Self::Plane(plane) => plane.distance(p),
            Self::Rough(rough) => rough.distance(p),
            Self::Stroke(stroke) => stroke.distance(p),
        }
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        match self {
            Self::Plane(plane) => plane.normal,
            Self::Rough(rough) => rough.normal(p),
            Self::Stroke(stroke) => stroke.normal(p),
        }
    }
}

/// The coordinates of a section: a plane's own, or those of a sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground<'a> {
    pub(super) blade: &'a Blade,
    pub(super) origin: DVec3,
    pub(super) axes: [DVec3; 2],
}

impl<'a> Ground<'a> {
    /// As the cut of this surface will have them.
    pub(super) fn of(blade: &'a Blade, mesh: &crate::assets::RawMesh) -> Self {
        let (origin, axes) = match blade.plane() {
            Some(plane) => section_frame(mesh, plane),
            None => (DVec3::ZERO, [DVec3::ZERO; 2]),
        };
        Self { blade, origin, axes }
    }

    /// The point of the model at coordinates of the section.
    pub(super) fn point(&self, at: Vec2) -> DVec3 {
        match self.blade.sheet() {
            Some(sheet) => sheet.point(DVec2::new(at.x as f64, at.y as f64)),
            None => self.origin + self.axes[0] * at.x as f64 + self.axes[1] * at.y as f64,
        }
    }

    /// +u, +v and the normal at a point of the section, orthonormal.
    pub(super) fn frame(&self, at: Vec2, p: DVec3) -> [DVec3; 3] {
        let n = self.blade.normal(p);
        let along = match self.blade.sheet() {
            None => return [self.axes[0], self.axes[1], n],
            Some(sheet) => {
                let at = at.as_dvec2();
                let step = 1e-4 * (1.0 + at.x.abs());
                sheet.point(at + DVec2::X * step) - sheet.point(at - DVec2::X * step)
            }
        };
        let u = along - n * along.dot(n);
        let u = if u.length() > 0.0 { u.normalize() } else { n.any_orthonormal_vector() };
        [u, n.cross(u), n]
    }

    /// Around the shadow of points on a plane's section.
    pub(super) fn window(&self, points: &[Vec3]) -> Window {
        let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for p in points {
            let from = p.as_dvec3() - self.origin;
            let at = vec2(from.dot(self.axes[0]) as f32, from.dot(self.axes[1]) as f32);
            (min, max) = (min.min(at), max.max(at));
        }
        Window { origin: self.origin, axes: self.axes, min, max }
    }
}

/// What becomes of outlines that do not close.
///
/// # Errors
/// A policy that is not known, or a length that is none.
pub(super) fn policy(recipe: &CutRecipe) -> Result<Policy> {
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

/// All cuts of a recipe, in order. `normal` is the first one's.
///
/// # Errors
/// `Parameter` for what cannot be, among it a plane that misses the scene.
pub(super) fn blades(recipe: &CutRecipe, normal: Vec3, scene: &Scene) -> Result<Vec<Blade>> {
    let first = plane(scene, normal, recipe.at, recipe.through.map(Vec3::from))?;
    let size = scene.mesh.bounds().extent().max_element() as f64;
    let origin = section_frame(&scene.mesh, &first).0;
    let first = match (recipe.rough, &recipe.stroke) {
        (Some(_), Some(_)) => {
            return Err(impossible("stroke", "both", "a cut is rough or follows a stroke: leave one of them out"));
        }
        (Some(given), None) => {
            let [amplitude, width] = given.map(f64::from);
            let seed = recipe.seed.unwrap_or(1);
            if !(amplitude > 0.0 && amplitude <= 1.0 && width > 0.0 && width <= 10.0) {
                let why = "height and width of hills, as shares of the model's size: above 0, at most 1 and 10";
                return Err(impossible("rough", format!("{amplitude},{width}"), why));
            }
            Blade::Rough(Rough { plane: first, origin, amplitude: amplitude * size, size: width * size, seed })
        }
        (None, Some(corners)) => {
            let corners: Vec<DVec2> = corners.iter().map(|c| DVec2::new(c[0] as f64, c[1] as f64) * size).collect();
            Blade::Stroke(Stroke::through(&first, origin, &corners)?)
        }
        (None, None) => Blade::Plane(first),
    };
    let mut blades = vec![first];
    for given in &recipe.then {
        let (normal, at) = given.split_once('@').map_or((given.as_str(), None), |(n, at)| (n, Some(at)));
        let why = "a normal and, if wanted, a place along it: X,Y,Z or X,Y,Z@FRACTION";
        let fault = || impossible("then", given, why);
        let at = at.map(|at| at.trim().parse::<f32>().map_err(|_| fault())).transpose()?;
        let numbers: Vec<f32> = normal.split(',').filter_map(|s| s.trim().parse().ok()).collect();
        let normal: [f32; 3] = numbers.try_into().map_err(|_| fault())?;
        blades.push(Blade::Plane(plane(scene, normal.into(), at, None)?));
    }
    if blades.len() > 6 {
        return Err(impossible("then", blades.len(), "at most 6 cuts: each may double the pieces"));
    }
    Ok(blades)
}

/// A plane that has part of the scene on either side.
fn plane(scene: &Scene, normal: Vec3, at: Option<f32>, through: Option<Vec3>) -> Result<Plane> {
    let mesh = &scene.mesh;
    let point = through.unwrap_or(mesh.bounds().center());
    let plane = Plane::through(point, normal)?;
    let used = mesh.triangles().iter().flatten().map(|&v| plane.distance(mesh.positions()[v as usize].as_dvec3()));
    let (low, high) = used.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), d| (a.min(d), b.max(d)));
    match (at, through) {
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
                let why = "a share of the way through: between 0 and 1, or the plane misses the mesh";
                return Err(impossible("at", at, why));
            }
            Ok(Plane { offset: plane.offset + low + (high - low) * at as f64, ..plane })
        }
    }
}
