//! Where on the texture is this surface point, and how fast does that change from cell to cell?
//!
//! [`Placement`] is the closed set of coordinate sources, [`place`] evaluates one over a batch with exact footprints.
//! [`with_tangents`] and [`unwrap()`] make what a mesh lacks: tangent frames, and a layout in the texture plane.

pub mod at_vertices;
mod box_charts;
pub mod cube_faces;
mod evaluate;
pub mod footprint;
mod number;
mod pack;
pub mod property;
mod rules;
pub mod source;
mod split;
pub mod stretch;
pub mod surfels;
pub mod tangents;
#[cfg(test)]
mod tests;
pub mod two_part;
pub mod unwrap;

pub use at_vertices::at_vertices;
pub use cube_faces::{CubeFaces, cube_faces};
pub use evaluate::{place, place_per_vertex, triplanar};
pub use footprint::Footprint;
pub use property::{Measures, Missing, Property, PropertyAxis, mixed};
pub use source::{Direction, Placement, PositionUnit, Projector, Space, as_uv, needs};
pub use stretch::{Stretch, stretch};
pub use surfels::{Needs, Surfels, TexCoords, Viewpoint};
pub use tangents::{CornerTangents, tangents, with_tangents};
pub use two_part::{Intermediate, ObjectRay, TwoPart};
pub use unwrap::{UNWRAPPED, UnwrapMethod, UnwrapOptions, Unwrapped, unwrap};
