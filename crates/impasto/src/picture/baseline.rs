//! The scenes that speed is measured on, lit and looked up as the OpenGL baseline does: one trilinear texture in its own
//! numbers, one light, `texture * (0.15 + 0.85 n.l) + 0.35 (n.h)^48`, no curve, no sRGB.

use crate::assets::{Filter, Mesh, MinFilter, Sampler, Wrap};
use crate::color::Encoding;
use crate::lookup::{ImageTexture, Layer, Look, Looks, Operator, Prepare, Shading, Target, Texture, Usage};
use crate::math::{Projection, Vec3};
use crate::picture::render::Shot;
use crate::picture::{Ambient, Background, Curve, Develop, Light, LightKind, Lighting, Reflection, Surroundings};
use crate::samples::bench;
use crate::visibility::{Camera, Samples};

/// A baseline scene, ready to be seen from any of its frames.
pub struct Baseline {
    name: &'static str,
    /// The scene's surfaces.
    pub mesh: Mesh,
    looks: Looks,
    lighting: Lighting,
}

impl Baseline {
    /// The scene by its name in [`bench::NAMES`].
    pub fn new(name: &str) -> Option<Self> {
        let name = bench::NAMES.into_iter().find(|n| *n == name)?;
        let mesh = bench::mesh(name)?.trusted();
        let sampler = Sampler {
            wrap: [Wrap::Repeat; 3],
            mag: Filter::Linear,
            min: MinFilter::LinearMipmapLinear,
            max_anisotropy: 1,
        };
        let image = bench::texture(bench::texture_size(name));
        let mut looks = Looks::default();
        let texture = looks.add(Texture::Image(ImageTexture::new(&image, &Prepare::new(Usage::Data, sampler))));
        let mut look = Look::plain(name, Default::default());
        look.layers.push(Layer::new(texture, Operator::Modulate, Target::Color));
        look.shading = Shading::BlinnPhong { specular: 0.35 / 0.85, exponent: bench::EXPONENT };
        look.is_double_sided = false;
        looks.looks.push(look);
        looks.look_of_part = vec![0];
        let light = Light { intensity: 0.85, ..Light::new(LightKind::Directional(bench::to_light())) };
        let lighting = Lighting {
            lights: vec![light],
            ambient: Ambient::constant([0.15; 3]),
            reflection: Reflection::Surroundings(Surroundings::even([0.15; 3])),
        };
        Some(Self { name, mesh, looks, lighting })
    }

    /// Where the camera stands in a frame.
    pub fn camera(&self, frame: u32) -> Camera {
        let view = bench::camera(self.name, frame, 1.0).expect("a baseline scene has a camera");
        let projection = Projection::Perspective { fov_y: view.fov_y as f32 };
        Camera::looking(view.eye.as_vec3(), view.target.as_vec3(), Vec3::Y, projection, view.near as f32)
    }

    /// How it is looked up and lit.
    pub fn shot(&self, samples: Samples) -> Shot<'_> {
        let develop = Some(Self::DEVELOP);
        Shot { looks: &self.looks, lighting: &self.lighting, unlit: false, samples, develop }
    }

    /// What is behind it.
    pub const BACKGROUND: Background = Background::Plain(bench::BACKGROUND);

    /// Numbers to bytes without a curve.
    pub const DEVELOP: Develop =
        Develop { curve: Curve::Plain, exposure: 0.0, encoding: Encoding::Linear, dither: false };
}
