//! What is there? Evaluate a stack of layers at surface points: colour, opacity, normal, and what else a surface has.

pub mod color_table;
pub mod evaluate;
#[cfg(test)]
mod evaluate_tests;
mod footprint;
pub mod layer;
pub mod looks;
mod mip;
mod normal;
pub mod operator;
mod packed;
pub mod procedural;
pub mod read;
#[cfg(test)]
mod read_tests;
pub mod surface;
pub mod texture;
mod viridis;

pub use color_table::ColorTable;
pub use evaluate::{Points, Scratch, alpha_of, evaluate};
pub use layer::{Channel, Constants, Layer, Look, Target, Texture, TextureId};
pub use looks::Looks;
pub use operator::{Compare, Operator};
pub use procedural::{Pattern, Procedural};
pub use read::Reading;
pub use surface::{Shading, Surfaces};
pub use texture::{BaseFormat, ImageTexture, Prepare, Shape, Usage};
