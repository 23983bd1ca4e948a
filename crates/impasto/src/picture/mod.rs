//! Light it; develop it for the eye: lights, shading, backgrounds, the curve from light to bytes.
//!
//! [`shade()`] turns a batch of surfaces into linear light, [`Develop`] turns rows of linear light into bytes.

pub mod ambient;
pub mod backdrop;
pub mod background;
pub mod baseline;
pub mod contour;
mod coverage;
pub mod develop;
pub mod drawing;
pub mod environment;
pub mod film;
pub mod font;
pub mod ground;
mod lanes;
pub mod legend;
pub mod light;
pub mod numbers;
mod metal_rough;
pub mod render;
pub mod shade;
pub mod sphere_texture;
mod stretches;
pub mod surroundings;
mod svg;
pub mod swatch;
pub mod ticks;

pub use ambient::Ambient;
pub use backdrop::Backdrop;
pub use background::Background;
pub use develop::{Curve, Develop};
pub use drawing::Drawing;
pub use environment::Environment;
pub use film::Film;
pub use ground::Ground;
pub use light::{Light, LightKind, Lighting};
pub use shade::{needs, shade};
pub use sphere_texture::{gouraud, sphere_texture};
pub use surroundings::{Panel, Reflection, Surroundings};

use crate::color::{LinearRgb, LinearRgba};
use crate::par::Workers;

/// [`Develop::rgba8`] at the workers' SIMD level.
pub fn develop_row(
    develop: &Develop,
    workers: &Workers,
    light: &[LinearRgba],
    under: Option<LinearRgb>,
    y: u32,
    row: &mut [[u8; 4]],
) {
    fearless_simd::dispatch!(workers.level(), simd => develop.rgba8(simd, light, under, y, row));
}
