//! A file's whole content: one flattened mesh, its materials and images, cameras and lights.

use crate::assets::{Material, Mesh, TextureImage};
use crate::color::LinearRgb;
use crate::math::{Mat4, Projection, Vec3};

/// Everything that came out of a file, in one space: +Y up, right-handed, model units.
#[derive(Clone, Debug)]
pub struct Scene {
    /// For messages: the file's name.
    pub name: String,
    /// All surfaces, the scene graph flattened.
    pub mesh: Mesh,
    /// What the mesh's parts refer to.
    pub materials: Vec<Material>,
    /// What the materials refer to.
    pub images: Vec<TextureImage>,
    /// Cameras that the file holds.
    pub cameras: Vec<SceneCamera>,
    /// Lights that the file holds.
    pub lights: Vec<SceneLight>,
    /// How the file's up axis was found and turned to +Y, one line for `info`; empty when it was +Y already.
    pub up_note: String,
}

impl Scene {
    /// A mesh alone.
    pub fn of(name: impl Into<String>, mesh: Mesh) -> Self {
        Self {
            name: name.into(),
            mesh,
            materials: Vec::new(),
            images: Vec::new(),
            cameras: Vec::new(),
            lights: Vec::new(),
            up_note: String::new(),
        }
    }
}

/// A camera in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// As the file names it.
    pub name: String,
    /// Where it stands; it looks along its -Z.
    pub world_from_camera: Mat4,
    /// Shape of the view volume.
    pub projection: Projection,
}

/// A light in a file (KHR_lights_punctual).
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    /// As the file names it.
    pub name: String,
    /// Linear colour times intensity.
    pub color: LinearRgb,
    /// Where from.
    pub kind: SceneLightKind,
}

/// Where a light's light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SceneLightKind {
    /// Parallel light; unit vector towards the light.
    Directional(Vec3),
    /// From a point, falling off with the square of the distance.
    Point(Vec3),
    /// From a point into a cone.
    Spot {
        /// Where it stands.
        position: Vec3,
        /// Unit vector of its axis, away from the light.
        axis: Vec3,
        /// Cosines of the inner and the outer half angle.
        cone: [f32; 2],
    },
}
