//! Lights, and the ready-made rooms of them.
//!
//! Brightness is counted so that light of colour 1 that falls straight onto white paper makes it 1.0: what physics calls
//! irradiance, divided by pi.

use crate::assets::{SceneLight, SceneLightKind};
use crate::color::LinearRgb;
use crate::math::{Mat3, Vec3, exact, unit_or, vec3};
use crate::picture::{Ambient, Environment, Panel, Reflection, Surroundings};
use crate::placement::Viewpoint;
use std::sync::Arc;

/// All light that falls on a scene.
#[derive(Clone, Debug)]
pub struct Lighting {
    /// Lights with a direction.
    pub lights: Vec<Light>,
    /// Light from everywhere, as matte surfaces see it.
    pub ambient: Ambient,
    /// The same surroundings as glossy surfaces mirror them. Only metal-roughness shading looks there.
    pub reflection: Reflection,
}

/// A source of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where from.
    pub kind: LightKind,
    /// Linear colour.
    pub color: LinearRgb,
    /// Multiplies the colour. For lights with a place: brightness at one model unit's distance.
    pub intensity: f32,
    /// How large the source looks from the surface: the sine of its angular radius, 0 a point to 1 half the sky.
    /// Blurs the terminator and the highlight.
    pub size: f32,
    /// The surroundings already show this light, so metal-roughness shading takes its highlight from there.
    pub in_reflection: bool,
}

/// Where a light's light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light; world space, unit vector towards the light.
    Directional(Vec3),
    /// From a point in world space, falling off with the square of the distance.
    Point(Vec3),
    /// From a point into a cone; full inside the inner angle, nothing outside the outer one.
    Spot {
        /// World space.
        position: Vec3,
        /// World space, unit vector away from the light.
        axis: Vec3,
        /// Cosines of the inner and the outer half angle.
        cone: [f32; 2],
    },
    /// From the eye, without falling off.
    Headlight,
}

impl Light {
    /// A white light of intensity 1 with sharp edges.
    pub fn new(kind: LightKind) -> Self {
        Self { kind, color: [1.0; 3], intensity: 1.0, size: 0.0, in_reflection: false }
    }

    /// Parallel light from a world-space direction of any length.
    pub fn directional(toward: Vec3, intensity: f32) -> Self {
        Self { intensity, ..Self::new(LightKind::Directional(unit_or(toward, Vec3::Y))) }
    }

    /// A light of a file, in KHR_lights_punctual's units (lux, candela): a matte surface reflects 1/pi of them.
    pub fn of_scene(light: &SceneLight) -> Self {
        let kind = match light.kind {
            SceneLightKind::Directional(toward) => LightKind::Directional(unit_or(toward, Vec3::Y)),
            SceneLightKind::Point(position) => LightKind::Point(position),
            SceneLightKind::Spot { position, axis, cone } => {
                LightKind::Spot { position, axis: unit_or(axis, Vec3::NEG_Y), cone }
            }
        };
        Self { color: light.color, intensity: std::f32::consts::FRAC_1_PI, ..Self::new(kind) }
    }

    /// Colour times intensity.
    #[inline(always)]
    pub fn strength(&self) -> LinearRgb {
        let [r, g, b] = self.color;
        [r * self.intensity, g * self.intensity, b * self.intensity]
    }
}

/// The direction that is `up_deg` above and `right_deg` to the right of the line towards the eye; world space.
fn from_eye(world_from_eye: Mat3, right_deg: f64, up_deg: f64) -> Vec3 {
    let (azimuth, elevation) = (right_deg.to_radians(), up_deg.to_radians());
    let flat = exact::cos(elevation);
    let d = [exact::sin(azimuth) * flat, exact::sin(elevation), exact::cos(azimuth) * flat];
    unit_or(world_from_eye * vec3(d[0] as f32, d[1] as f32, d[2] as f32), Vec3::Y)
}

/// The turn from eye space to the world's.
fn world_from_eye(viewpoint: &Viewpoint) -> Mat3 {
    Mat3::from_mat4(viewpoint.eye_from_world).transpose()
}

impl Lighting {
    /// Only light from everywhere, the same from each side: brightness 1 shows a matte colour as it is.
    pub fn flat(brightness: f32) -> Self {
        Self {
            lights: Vec::new(),
            ambient: Ambient::constant([brightness; 3]),
            reflection: Reflection::Surroundings(Surroundings::even([brightness; 3])),
        }
    }

    /// One light at the eye, and a little from everywhere.
    pub fn headlight() -> Self {
        let surroundings = Surroundings { horizon: [0.30; 3], ..Surroundings::even([0.16; 3]) };
        Self {
            lights: vec![Light { intensity: 0.85, size: 0.2, ..Light::new(LightKind::Headlight) }],
            ambient: Ambient::of_surroundings(&surroundings),
            reflection: Reflection::Surroundings(surroundings),
        }
    }

    /// A photographer's room that turns with the camera: a large soft key from upper left front, a weak cool fill from
    /// the right, a rim from behind, and the soft light of a bright ceiling and a warm floor. Made so that the form
    /// of an untextured scan reads everywhere and no side is black.
    pub fn studio(viewpoint: &Viewpoint) -> Self {
        let turn = world_from_eye(viewpoint);
        let key = from_eye(turn, -35.0, 45.0);
        let fill = from_eye(turn, 62.0, 12.0);
        let rim = from_eye(turn, 150.0, 38.0);
        let up = turn * Vec3::Y;
        let light = |toward, color: LinearRgb, intensity, size| Light {
            kind: LightKind::Directional(toward),
            color,
            intensity,
            size,
            in_reflection: true,
        };
        let surroundings = Surroundings {
            up,
            zenith: [0.46, 0.47, 0.49],
            horizon: [0.54, 0.54, 0.54],
            floor: [0.34, 0.325, 0.30],
            nadir: [0.15, 0.14, 0.125],
            horizon_width: 0.22,
            panels: vec![
                Panel::new(key, up, [0.55, 0.45], [3.1, 3.0, 2.85]),
                Panel::new(fill, up, [0.22, 0.75], [0.9, 0.95, 1.05]),
                Panel::new(rim, up, [0.20, 0.80], [3.2, 3.3, 3.5]),
            ],
        };
        Self {
            lights: vec![
                light(key, [1.0, 0.97, 0.93], 0.98, 0.5),
                light(fill, [0.84, 0.92, 1.0], 0.10, 0.6),
                light(rim, [0.95, 0.98, 1.0], 0.50, 0.25),
            ],
            // The sweep of paper around an object is brighter to look at than what reaches the object from it.
            ambient: Ambient::of_surroundings(&surroundings.clone().dimmed(0.52)),
            reflection: Reflection::Surroundings(surroundings),
        }
    }

    /// The light of a panorama, and nothing else.
    pub fn environment(environment: Arc<Environment>) -> Self {
        Self { lights: Vec::new(), ambient: environment.ambient, reflection: Reflection::Environment(environment) }
    }

    /// A clear day: the sun from a world-space direction, blue sky, sunlit ground. World space, +Y up.
    pub fn outdoor(toward_sun: Vec3) -> Self {
        let sun = unit_or(toward_sun, vec3(-0.4, 0.7, 0.6));
        let surroundings = Surroundings {
            up: Vec3::Y,
            zenith: [0.16, 0.27, 0.52],
            horizon: [0.55, 0.63, 0.74],
            floor: [0.26, 0.24, 0.20],
            nadir: [0.20, 0.18, 0.15],
            horizon_width: 0.03,
            panels: Vec::new(),
        };
        Self {
            lights: vec![Light {
                color: [1.0, 0.95, 0.86],
                intensity: 0.95,
                // Half a degree in the sky; a little more keeps its edge from flickering on bumps.
                size: 0.02,
                ..Light::new(LightKind::Directional(sun))
            }],
            ambient: Ambient::of_surroundings(&surroundings),
            reflection: Reflection::Surroundings(surroundings),
        }
    }
}
