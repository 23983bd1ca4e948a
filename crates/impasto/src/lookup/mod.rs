//! What is there? Evaluate a stack of layers at surface points: colour, opacity, normal, and what else a surface has.

pub mod surface;

pub use surface::{Shading, Surfaces};
