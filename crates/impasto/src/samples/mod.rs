//! Surfaces and textures made by formula, at any size, so that everything runs with no file.

mod atlas;
pub mod bench;
pub mod chameleon;
mod curve;
mod sheet;
mod tube;

use crate::assets::Scene;

/// The sample of that name.
pub fn scene(name: &str, resolution: u32, seed: u32) -> Option<Scene> {
    match name {
        "chameleon" => Some(chameleon::scene(resolution, 1024, seed)),
        _ => None,
    }
}
