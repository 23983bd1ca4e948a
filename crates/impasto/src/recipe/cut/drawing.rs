//! A section as a drawing.

use super::blade::{self, Blade, Ground};
use super::{leaf, remarks, substance};
use crate::assets::Scene;
use crate::color::srgb8_from_linear;
use crate::error::{Error, Report, Result};
use crate::math::{DVec3, Vec3};
use crate::recipe::CutRecipe;
use crate::recipe::grain::Substance;
use crate::recipe::words::impossible;
use crate::section::cut::skin::Skin;
use crate::section::cut::{self, Policy};
use crate::section::grain::{Hit, HitKind, Outline, outlines};
use crate::section::svg::{Drawing, svg};
use std::path::Path;

/// The first section of a recipe as SVG: the outline of the model, and those of the particles in it. A model unit is drawn
/// as `unit_mm` millimetres; without it the drawing is 160 mm long.
///
/// # Errors
/// As [`pieces`](super::pieces); curved cuts, which have no flat drawing, and particles too small to be drawn.
pub fn drawing(recipe: &CutRecipe, scene: &Scene, on: (&Path, u32), unit_mm: Option<f64>) -> Result<Report<String>> {
    let mesh = &scene.mesh;
    let normal = super::normal(recipe)?;
    let blades = blade::blades(recipe, normal, scene)?;
    let Blade::Plane(plane) = &blades[0] else {
        return Err(impossible("drawing", "curved cut", "only plane sections have one"));
    };
    let (substance, _) = substance(recipe, scene, on)?;
    let policy = match blade::policy(recipe)? {
        // An area has no outline of its own: one needs lines over the gaps.
        Policy::Winding => Policy::Bridge(f32::MAX),
        policy => policy,
    };
    let cut = cut::cut(mesh, plane, policy)
        .map_err(|e| Error::Format { path: scene.name.clone().into(), fault: e.to_string() })?;
    let mut mended = Vec::new();
    remarks(&cut, policy, &mut mended);

    let ground = Ground::of(&blades[0], &mesh.clone().into_raw());
    let window = ground.window(mesh.positions());
    let skin = Skin::of(mesh);
    let depth = |p: DVec3| skin.distance(p) as f32;
    let found = match &substance {
        None => Vec::new(),
        Some(Substance { filling, spacing, .. }) => outlines(filling, plane, &window, &depth)
            .ok_or_else(|| impossible("spacing", spacing, "the particles are too small to be drawn: millions"))?,
    };
    let extent = (window.max - window.min).max_element() as f64;
    let plain = leaf(recipe)?;
    let matrix = substance.as_ref().map_or(&plain, |s| &s.leaves[0]).matrix[0];
    let byte = |c: Vec3| c.to_array().map(srgb8_from_linear);
    let color = |outline: &Outline| {
        let (kind, particle, leaf) = (HitKind::Disc, outline.particle, outline.leaf);
        let hit = Hit { kind, particle, leaf, ..Hit::matrix(Vec3::Z, 0.0) };
        byte(Vec3::from(substance.as_ref().map_or(&plain, |s| s.leaf(&hit)).dress(&hit).0))
    };
    let unit_mm = unit_mm.unwrap_or(160.0 / extent);
    if !(unit_mm > 0.0 && unit_mm.is_finite()) {
        return Err(impossible("unit-mm", unit_mm, "millimetres of a model unit, above zero"));
    }
    let drawing = Drawing { unit_mm, margin: 0.02 * extent, matrix: byte(matrix), color: &color, ..Drawing::default() };
    Ok(Report { value: svg(&cut.section, &found, &drawing), mended })
}
