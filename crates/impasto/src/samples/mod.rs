//! Surfaces and textures made by formula, at any size, so that everything runs with no file.

mod atlas;
pub mod bench;
pub mod chameleon;
mod curve;
pub mod plain;
mod sheet;
#[cfg(test)]
mod solid;
pub mod terrain;
pub mod texture;
mod tube;

use crate::assets::Scene;

/// The sample of that name.
pub fn scene(name: &str, resolution: u32, seed: u32) -> Option<Scene> {
    match name {
        "terrain" => Some(terrain::scene(resolution, 1024, seed)),
        "chameleon" => Some(chameleon::scene(resolution, 1024, seed)),
        _ => None,
    }
}
