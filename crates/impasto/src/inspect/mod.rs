//! Back from pixels to surface points: what is at this cell, as numbers, as channels of a grid, as coded colours.
//!
//! The information buffer holds ids and depths; everything here is derived from it by the same calls that make pictures,
//! so that what is read here is what was drawn there, bit by bit.

pub mod address;
pub mod channels;
pub mod probe;

pub use address::{Coding, TexelAddress};
pub use channels::{Quantity, Values, measured, quantities};
pub use probe::{Found, Probe, Texel, probe};
