//! Light it; develop it for the eye: lights, shading, backgrounds, the curve from light to bytes.
//!
//! [`shade()`] turns a batch of surfaces into linear light, [`Develop`] turns rows of linear light into bytes.

pub mod ambient;
pub mod background;
pub mod develop;
pub mod environment;
mod lanes;
pub mod light;
mod metal_rough;
pub mod shade;
pub mod surroundings;

pub use ambient::Ambient;
pub use background::Background;
pub use develop::{Curve, Develop};
pub use environment::Environment;
pub use light::{Light, LightKind, Lighting};
pub use shade::{needs, shade};
pub use surroundings::{Panel, Reflection, Surroundings};
