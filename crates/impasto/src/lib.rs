//! Impasto: textures as information.
//!
//! Paint a surface, grow its skin, cut it open, read data off it - with no GPU, display or driver, and with the same
//! bytes on every machine. The modules below stand in the order of the data's way; each uses only those above it.

pub mod math;
pub mod color;
pub mod par;
pub mod error;

pub mod noise;

pub mod assets;

pub mod samples;

pub mod section;

pub mod placement;
pub mod visibility;
pub mod lookup;
pub mod picture;
pub mod inspect;
pub mod recipe;

pub use error::{Error, Report, Result};
