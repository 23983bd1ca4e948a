//! The plain answer of a look-up: what a surface is like at each point of a batch, before any light.

use crate::math::{BATCH, Lane};

/// How light and surface meet.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Shading {
    /// The colour as it is.
    Unlit,
    /// Matte (Lambert 1760).
    Lambert,
    /// Matte with a highlight (Blinn 1977).
    BlinnPhong {
        /// Linear strength of the highlight.
        specular: f32,
        /// Its sharpness.
        exponent: f32,
    },
    /// Metal-roughness: GGX distribution, Smith visibility, Schlick Fresnel (glTF 2.0, appendix B).
    #[default]
    MetalRough,
}

/// What up to [`BATCH`] surface points are like.
#[derive(Clone)]
pub struct Surfaces {
    /// How many are valid.
    pub n: usize,
    /// Linear light reflected (or shown, when unlit).
    pub color: [Lane; 3],
    /// Opacity, 0 to 1.
    pub alpha: Lane,
    /// World space, unit, towards the side that is seen, bumps applied.
    pub normal: [Lane; 3],
    /// Perceptual roughness, 0 mirror to 1 chalk.
    pub roughness: Lane,
    /// 0 dielectric to 1 metal.
    pub metalness: Lane,
    /// How open to ambient light, 0 to 1.
    pub occlusion: Lane,
    /// Linear light given off.
    pub emission: [Lane; 3],
    /// Clear coat strength.
    pub coat: Lane,
    /// Clear coat roughness.
    pub coat_roughness: Lane,
    /// The coat's own normal.
    pub coat_normal: [Lane; 3],
    /// Height above the surface, model units (relief).
    pub height: Lane,
    /// Numbers that layers wrote as information; 0 where none did.
    pub info: [Lane; 4],
}

impl Surfaces {
    /// An empty batch.
    pub fn new() -> Box<Self> {
        const ZERO: Lane = [0.0; BATCH];
        Box::new(Self {
            n: 0,
            color: [ZERO; 3],
            alpha: ZERO,
            normal: [ZERO; 3],
            roughness: ZERO,
            metalness: ZERO,
            occlusion: ZERO,
            emission: [ZERO; 3],
            coat: ZERO,
            coat_roughness: ZERO,
            coat_normal: [ZERO; 3],
            height: ZERO,
            info: [ZERO; 4],
        })
    }
}
