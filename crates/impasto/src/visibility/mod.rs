//! Which surface point does each cell of a grid see: through a camera, or over an atlas?
//!
//! Both directions share everything after the first step: a [`Domain`] takes vertices to homogeneous cells, `bin` sorts
//! triangles into tiles, `raster` writes ids and depths, and `hits` derives surface points from them.

mod bin;
pub mod atlas;
pub mod camera;
mod depth;
pub mod domain;
mod hits;
pub mod info_buffer;
mod raster;
pub mod tile;

pub use atlas::Atlas;
pub use camera::{Camera, Direction};
pub use domain::Domain;
pub use hits::{BATCH_FILL, CENTER, Place, fill};
pub use info_buffer::{Hit, InfoBuffer};
pub use tile::{AlphaTest, Draw, Faces, Kind, Places, Samples, TILE, Tile, Tiles};

#[cfg(test)]
mod tests;
