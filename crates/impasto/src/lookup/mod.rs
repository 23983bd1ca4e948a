//! What is there? Evaluate a stack of layers at surface points: colour, opacity, normal, and what else a surface has.

mod footprint;
mod mip;
mod packed;
pub mod read;
pub mod surface;
pub mod texture;

pub use read::Reading;
pub use surface::{Shading, Surfaces};
pub use texture::{BaseFormat, ImageTexture, Prepare, Shape, Usage};
