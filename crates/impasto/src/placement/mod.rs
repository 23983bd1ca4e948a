//! Where on the texture is this surface point, and how fast does that change from cell to cell?

pub mod surfels;

pub use surfels::{Needs, Surfels, TexCoords, Viewpoint};
