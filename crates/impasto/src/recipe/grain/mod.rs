//! Grains that files describe: what fills a model, and what colours it has.
//!
//! A grain file is TOML, like a recipe. Its lengths are in spacings of the grain, so that one number makes all of it finer
//! or coarser, and the spacing itself is a share of the model's largest extent: the same file fills any model.

pub mod library;
mod make;
pub mod matter;
mod paint;

pub use matter::{AxisRecipe, Matter};
pub use paint::Leaf;
pub(super) use paint::darkened;

use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::recipe::text;
use crate::recipe::words::{choose, impossible};
use crate::section::grain::{Filling, Grain, GrainSpec, Hit, Layer, SectionKind, Shape};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A grain, written down.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GrainRecipe {
    /// Its name, as a person says it.
    pub title: String,
    /// One sentence about it.
    pub about: String,
    /// Kinds of sections that suit it, the best first: `tear`, `hollow`, `solid`.
    pub kinds: Vec<String>,
    /// Between particles, as a share of the model's largest extent.
    pub spacing: f32,
    /// From the skin inward; most grains have one.
    pub layers: Vec<Matter>,
}

/// What a grain may ask of the model that it fills.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Its middle, model space.
    pub center: Vec3,
    /// Its size along the model's axes.
    pub extent: Vec3,
}

/// A grain in a model, ready to be cut.
#[derive(Clone, Debug)]
pub struct Substance {
    /// What is where.
    pub filling: Filling,
    /// Colours of the filling's leaves.
    pub leaves: Vec<Leaf>,
    /// Half of the least extent of its particles, model units: what relief and maps must be able to show.
    pub finest: f32,
    /// The grain's spacing, model units.
    pub spacing: f32,
}

/// The names of the kinds of sections.
pub(super) const KINDS: [(&str, SectionKind); 3] =
    [("tear", SectionKind::Tear), ("hollow", SectionKind::Hollow), ("solid", SectionKind::Solid)];

impl GrainRecipe {
    /// Reads a grain file. `path` is only for messages.
    ///
    /// # Errors
    /// `Format` with line and column, or with what is missing.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let grain: Self = text::parse_as(text, path)?;
        let fault = |fault: &str| Err(Error::Format { path: path.into(), fault: fault.into() });
        if grain.layers.is_empty() {
            return fault("it has no [[layers]]");
        }
        if !(grain.spacing > 0.0 && grain.spacing <= 1.0) {
            return fault("`spacing` is a share of the model's size: above 0, at most 1");
        }
        Ok(grain)
    }

    /// The kinds of sections that suit it, the best first.
    ///
    /// # Errors
    /// A kind that is not known.
    pub fn kinds(&self) -> Result<Vec<SectionKind>> {
        self.kinds.iter().map(|k| choose("kind", k, &KINDS)).collect()
    }

    /// The grain in a model. `spacing` is in model units; without it the grain has the one it prefers.
    ///
    /// # Errors
    /// `Parameter` for names and numbers that cannot be.
    pub fn fill(&self, body: Body, spacing: Option<f32>, seed: u32) -> Result<Substance> {
        let spacing = spacing.unwrap_or(self.spacing * body.extent.max_element());
        if !(spacing > 0.0 && spacing.is_finite()) {
            return Err(impossible("spacing", spacing, "it is a length above zero"));
        }
        let scale = make::Scale { unit: spacing, body, seed };
        let (mut leaves, mut finest) = (Vec::new(), f32::INFINITY);
        let mut layers = Vec::new();
        for matter in &self.layers {
            let made = matter.make(&scale)?;
            finest = finest.min(made.finest);
            leaves.extend(made.leaves);
            let until = matter.until.map_or(f32::INFINITY, |u| u * spacing);
            if matter.until.is_some_and(|u| !(u > 0.0 && u.is_finite())) {
                return Err(impossible("until", until, "a depth in spacings, above zero"));
            }
            layers.push(Layer { until, filling: made.filling, strict: matter.strict.unwrap_or(false) });
        }
        let filling = match layers.len() {
            1 if layers[0].until.is_infinite() => layers.swap_remove(0).filling,
            _ => Filling::Layers(layers),
        };
        // What has no particles is shown as finely as if it had some.
        let finest = if finest.is_finite() { finest } else { 0.5 * spacing };
        Ok(Substance { filling, leaves, finest, spacing })
    }
}

impl Substance {
    /// Of particles that are given in full.
    ///
    /// # Errors
    /// Numbers that cannot be.
    pub fn of_spec(spec: GrainSpec, leaf: Leaf) -> Result<Self> {
        let spacing = spec.spacing;
        let finest = make::least_half_extent(&spec.shape).min(0.5 * spacing);
        let filling = Filling::Particles(Box::new(Grain::new(spec)?));
        Ok(Self { filling, leaves: vec![leaf], finest, spacing })
    }

    /// The colours of what a hit shows.
    pub fn leaf(&self, hit: &Hit) -> &Leaf {
        &self.leaves[(hit.leaf as usize).min(self.leaves.len() - 1)]
    }

    /// Whether it asks how deep below the skin a place is.
    pub fn asks_depth(&self) -> bool {
        self.filling.asks_depth()
    }
}

/// A shape that many particles have, scaled.
pub(super) fn scaled(shape: Shape, by: f32) -> Shape {
    match shape {
        Shape::Sphere { radius } => Shape::Sphere { radius: radius * by },
        Shape::Cylinder { radius, height, ends } => Shape::Cylinder { radius: radius * by, height: height * by, ends },
        other => other,
    }
}
