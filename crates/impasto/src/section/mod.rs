//! Cut it open: sections with grain, after Li 2022.
//!
//! [`grain`] is a solid texture: what a cut shows at a point. [`cut`] makes two capped halves of a mesh. Both know the cut
//! itself only as a [`CutSurface`]: a signed distance whose negative side is kept by the half *below*.

pub mod surface;
pub mod curved;
pub mod grain;
pub mod cut;
pub mod maps;
pub mod shader;
pub mod svg;

pub use curved::{Rough, Stroke};
pub use surface::{CutSurface, Plane, Sheet};
