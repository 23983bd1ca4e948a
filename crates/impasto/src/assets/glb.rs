//! A scene to GLB.

use crate::Result;
use crate::assets::Scene;
use crate::error::Error;

/// The bytes of a GLB file.
pub fn write(scene: &Scene) -> Result<Vec<u8>> {
    Err(Error::Format { path: scene.name.clone().into(), fault: "no GLB writer yet".into() })
}
