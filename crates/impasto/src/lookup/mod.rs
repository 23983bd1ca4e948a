//! What is there? Evaluate a stack of layers at surface points: colour, opacity, normal, and what else a surface has.

pub mod color_table;
pub mod evaluate;
#[cfg(test)]
mod evaluate_tests;
pub mod filter;
mod footprint;
pub mod isolines;
pub mod layer;
pub mod looks;
mod mip;
mod mixing;
mod normal;
pub mod operator;
mod packed;
pub mod procedural;
pub mod read;
#[cfg(test)]
mod read_tests;
pub mod safe;
pub mod surface;
pub mod tables;
pub mod texture;
pub mod vision;

pub use color_table::{ColorTable, Scale, is_hatched};
pub use evaluate::{Points, Scratch, Wanted, alpha_of, evaluate, evaluate_measured};
pub use filter::{Filter, Keep};
pub use isolines::{Isolines, Levels, Line};
pub use layer::{Channel, Constants, Layer, Look, Target, Texture, TextureId};
pub use looks::Looks;
pub use operator::{Compare, Operator};
pub use procedural::{Pattern, Procedural};
pub use read::Reading;
pub use safe::Shades;
pub use surface::{Shading, Surfaces};
pub use texture::{BaseFormat, ImageTexture, Prepare, Shape, Usage};
