//! Data on surfaces against analytic truth: colours, lines, missing values and shades, at every covered pixel.

mod colors;
mod grids;
mod lines;
mod missing;
mod oracle;
mod shades;
