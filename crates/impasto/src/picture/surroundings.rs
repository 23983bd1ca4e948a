//! What glossy surfaces mirror: sky, floor and soft boxes by formula, blurred by roughness without any set-up.
//!
//! A rough surface sees its surroundings through a lobe. A slab of light seen through a lobe that falls off like
//! `(1 + x^2)^-1.5` is a difference of two `x / sqrt(1 + x^2)`, and a panel is the product of two slabs: a lobe with
//! long tails like GGX's, of the right width, which keeps the energy and never shows an edge where there is none.

use crate::color::LinearRgb;
use crate::math::{Vec3, unit_or};
use crate::picture::Environment;
use crate::picture::lanes::{V, V3, at_least, clamp01, dot, larger, mix, per_channel, smaller, smooth, splat, splat3};
use fearless_simd::{Simd, prelude::*};
use std::sync::Arc;

/// What glossy surfaces mirror.
#[derive(Clone, Debug)]
pub enum Reflection {
    /// By formula.
    Surroundings(Surroundings),
    /// A photographed or painted panorama.
    Environment(Arc<Environment>),
}

/// A sky, a floor, and bright panels before them.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    /// World space, unit: where the sky is.
    pub up: Vec3,
    /// Linear brightness straight up.
    pub zenith: LinearRgb,
    /// Just above the horizon.
    pub horizon: LinearRgb,
    /// Just below the horizon.
    pub floor: LinearRgb,
    /// Straight down.
    pub nadir: LinearRgb,
    /// Half the height of the passage from floor to sky, as a sine.
    pub horizon_width: f32,
    /// Soft boxes; they add to what is behind them.
    pub panels: Vec<Panel>,
}

/// A bright rectangle with soft edges, at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    /// World space, unit: across, up and towards the panel.
    pub frame: [Vec3; 3],
    /// Half its width and height: twice the tangent of half the angle.
    pub half_size: [f32; 2],
    /// Linear brightness.
    pub color: LinearRgb,
}

/// Width of a perfect mirror's lobe, so that a panel's edge is never a staircase.
const LEAST_BLUR: f32 = 0.02;

impl Panel {
    /// A panel in the direction `toward`, upright with respect to `up`.
    pub fn new(toward: Vec3, up: Vec3, half_size: [f32; 2], color: LinearRgb) -> Self {
        let toward = unit_or(toward, Vec3::Y);
        let across = unit_or(up.cross(toward), unit_or(Vec3::Z.cross(toward), Vec3::X));
        Self { frame: [across, toward.cross(across), toward], half_size, color }
    }
}

impl Surroundings {
    /// The same brightness everywhere.
    pub fn even(color: LinearRgb) -> Self {
        Self {
            up: Vec3::Y,
            zenith: color,
            horizon: color,
            floor: color,
            nadir: color,
            horizon_width: 0.1,
            panels: Vec::new(),
        }
    }

    /// Sky and floor at another brightness, panels as they are.
    pub fn dimmed(mut self, gain: f32) -> Self {
        for color in [&mut self.zenith, &mut self.horizon, &mut self.floor, &mut self.nadir] {
            *color = color.map(|c| c * gain);
        }
        self
    }

    /// Sky and floor in a direction, sharp, without panels.
    pub fn gradient(&self, toward: Vec3) -> LinearRgb {
        let height = toward.dot(self.up);
        let t = (0.5 + 0.5 * height / self.horizon_width).clamp(0.0, 1.0);
        let sky = t * t * (3.0 - 2.0 * t);
        let h = height.abs();
        std::array::from_fn(|c| {
            let above = self.horizon[c] + (self.zenith[c] - self.horizon[c]) * h;
            let below = self.floor[c] + (self.nadir[c] - self.floor[c]) * h;
            below + (above - below) * sky
        })
    }
}

/// Brightness of the surroundings in unit directions `toward`, through the lobe of a surface with this GGX alpha.
#[inline(always)]
pub(super) fn mirrored<S: Simd>(simd: S, around: &Surroundings, toward: V3<S>, alpha: V<S>) -> V3<S> {
    // Reflected directions spread twice as far as half vectors; 0.65 fits the half width of GGX's core.
    let blur = alpha * 1.3 + LEAST_BLUR;
    let inverse_blur = splat(simd, 1.0) / blur;

    // Sky and floor. A lobe that covers both sees their mean before it is level.
    let height = dot::<S>(toward, splat3(simd, around.up.to_array()));
    let sky = clamp01(simd, height * (splat(simd, 0.5) / (blur + around.horizon_width)) + 0.5);
    let sky = smooth::<S>(sky);
    let h = larger::<S>(height, -height);
    let mut color: V3<S> = per_channel!(c => {
        let above = mix::<S>(splat(simd, around.horizon[c]), splat(simd, around.zenith[c]), h);
        let below = mix::<S>(splat(simd, around.floor[c]), splat(simd, around.nadir[c]), h);
        mix::<S>(below, above, sky)
    });

    for panel in &around.panels {
        let [x, y, z]: V3<S> = per_channel!(c => dot::<S>(toward, splat3(simd, panel.frame[c].to_array())));
        // Stereographic: smooth all over the sphere but right behind, where a panel's share is too small to be missed.
        let flat = splat(simd, 2.0) / (at_least(simd, z, -0.9) + 1.0);
        let [a, b] = panel.half_size;
        let share = slab(simd, x * flat, a, inverse_blur) * slab(simd, y * flat, b, inverse_blur);
        let share = z.simd_gt(splat(simd, -0.9)).select(share, splat(simd, 0.0));
        for c in 0..3 {
            color[c] += share * panel.color[c];
        }
    }
    color
}

/// How much of a slab of half width `a` a lobe sees that is centred at `x`.
#[inline(always)]
fn slab<S: Simd>(simd: S, x: V<S>, a: f32, inverse_blur: V<S>) -> V<S> {
    (sigmoid(simd, (x + a) * inverse_blur) - sigmoid(simd, (x - a) * inverse_blur)) * 0.5
}

#[inline(always)]
fn sigmoid<S: Simd>(simd: S, x: V<S>) -> V<S> {
    x / (x * x + splat(simd, 1.0)).sqrt()
}

/// Which way a rough surface mostly mirrors: between reflection and normal (Lagarde, de Rousiers, "Moving Frostbite to
/// Physically Based Rendering", 2014). Not unit for rough surfaces, which only makes panels wider.
#[inline(always)]
pub(super) fn dominant<S: Simd>(simd: S, normal: V3<S>, reflected: V3<S>, alpha: V<S>) -> V3<S> {
    let smoothness = splat(simd, 1.0) - smaller::<S>(alpha, splat(simd, 1.0));
    let t = smoothness * (smoothness.sqrt() + alpha);
    per_channel!(c => mix::<S>(normal[c], reflected[c], t))
}
