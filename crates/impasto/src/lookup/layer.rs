//! A surface's look: constants, and a stack of layers that change them, the first layer first.

use crate::assets::AlphaMode;
use crate::color::{Encoding, LinearRgb, LinearRgba};
use crate::lookup::operator::{AlphaRule, Operator, rules};
use crate::lookup::{BaseFormat, ColorTable, Filter, ImageTexture, Isolines, Procedural, Shading};
use crate::math::Mat4;
use crate::placement::{self, Needs, Placement};

/// How a surface looks. Any number of layers.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// For messages.
    pub name: String,
    /// What is there under the first layer.
    pub constants: Constants,
    /// The mesh's vertex colours multiply the constant colour and alpha.
    pub uses_vertex_colors: bool,
    /// Applied in order.
    pub layers: Vec<Layer>,
    /// How light and surface meet.
    pub shading: Shading,
    /// What alpha means.
    pub alpha_mode: AlphaMode,
    /// Back faces are seen, their normals turned over.
    pub is_double_sided: bool,
}

/// What a surface is like before any layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// Linear colour and alpha.
    pub color: LinearRgba,
    /// Perceptual roughness.
    pub roughness: f32,
    /// 0 dielectric to 1 metal.
    pub metalness: f32,
    /// Linear light given off.
    pub emission: LinearRgb,
    /// Clear coat strength.
    pub coat: f32,
    /// Clear coat roughness.
    pub coat_roughness: f32,
}

impl Default for Constants {
    /// White, opaque, matt, no coat.
    fn default() -> Self {
        Self { color: [1.0; 4], roughness: 1.0, metalness: 0.0, emission: [0.0; 3], coat: 0.0, coat_roughness: 0.0 }
    }
}

/// Where a coordinate comes from, which texture it reads, and what the answer does.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Where the coordinate comes from.
    pub placement: Placement,
    /// Transforms it.
    pub matrix: Mat4,
    /// Which texture it reads.
    pub texture: TextureId,
    /// What the answer does.
    pub operator: Operator,
    /// To what.
    pub target: Target,
    /// Which of the texture's channels count as red, green, blue, alpha; single numbers take the first.
    pub channels: [Channel; 4],
    /// 0: no effect, 1: the whole.
    pub strength: f32,
}

impl Layer {
    /// A layer over UV set 0 in full strength, channels as they are.
    pub fn new(texture: TextureId, operator: Operator, target: Target) -> Self {
        Self {
            placement: Placement::Uv(0),
            matrix: Mat4::IDENTITY,
            texture,
            operator,
            target,
            channels: Channel::RGBA,
            strength: 1.0,
        }
    }

    /// Whether it can change alpha.
    pub(super) fn touches_alpha(&self, format: BaseFormat) -> bool {
        match self.target {
            _ if matches!(self.operator, Operator::AlphaTest(..)) => true,
            Target::Alpha => true,
            Target::Color => rules(self.operator, format).1 != AlphaRule::Keep,
            _ => false,
        }
    }
}

/// Index into the textures of [`Looks`](crate::lookup::Looks).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

/// What a layer reads.
#[derive(Clone, Debug)]
pub enum Texture {
    /// An image of any shape.
    Image(ImageTexture),
    /// Colours of values; s is the value.
    Table(ColorTable),
    /// Lines of equal value; s is the value.
    Isolines(Isolines),
    /// Hides by value; s is the value.
    Filter(Filter),
    /// A formula.
    Procedural(Procedural),
    /// Colours that the surface carries as data: red, green and blue are s, t and r, linear or sRGB in steps of 1/255.
    Carried(Encoding),
}

impl Texture {
    /// Which components it means to have.
    pub fn format(&self) -> BaseFormat {
        match self {
            Self::Image(image) => image.format(),
            Self::Table(_) | Self::Isolines(_) | Self::Filter(_) | Self::Procedural(_) => BaseFormat::Rgba,
            Self::Carried(_) => BaseFormat::Rgb,
        }
    }
}

/// What a layer changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// Colour, and alpha as the operator's table says.
    Color,
    /// Alpha alone, by the first channel.
    Alpha,
    /// The normal, by a tangent-space map (texture usage `Normal`); x and y are scaled.
    Normal {
        /// 1: as the map says.
        scale: f32,
    },
    /// The normal, by heights (Blinn, "Simulation of wrinkled surfaces", 1978): an image of usage `Slope`, or differences
    /// of any other texture.
    Bump {
        /// Height of 1.0 in texture widths.
        scale: f32,
    },
    /// Roughness.
    Roughness,
    /// Metalness.
    Metalness,
    /// How open to ambient light.
    Occlusion,
    /// Light given off.
    Emission,
    /// Clear coat strength.
    Coat,
    /// Clear coat roughness.
    CoatRoughness,
    /// The clear coat's normal, by a tangent-space map.
    CoatNormal {
        /// 1: as the map says.
        scale: f32,
    },
    /// Height above the surface.
    Height {
        /// Model units for 1.0.
        scale: f32,
    },
    /// The information channels: the numbers as they are, under no light.
    Info,
}

/// Where a channel's numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Of the texture.
    Red,
    /// Of the texture.
    Green,
    /// Of the texture.
    Blue,
    /// Of the texture.
    Alpha,
    /// All 0.
    Zero,
    /// All 1.
    One,
}

impl Channel {
    /// As they are.
    pub const RGBA: [Self; 4] = [Self::Red, Self::Green, Self::Blue, Self::Alpha];
}

impl Look {
    /// Constants alone.
    pub fn plain(name: impl Into<String>, constants: Constants) -> Self {
        Self {
            name: name.into(),
            constants,
            uses_vertex_colors: false,
            layers: Vec::new(),
            shading: Shading::default(),
            alpha_mode: AlphaMode::Opaque,
            is_double_sided: true,
        }
    }

    /// Which lanes of the surfels it reads.
    pub fn needs(&self) -> Needs {
        let own = Needs { normal: true, color: self.uses_vertex_colors, ..Needs::default() };
        self.layers.iter().fold(own, |needs, layer| {
            let is_bump =
                matches!(layer.target, Target::Normal { .. } | Target::Bump { .. } | Target::CoatNormal { .. });
            // A mesh without tangents gets frames from the coordinates' derivatives.
            let frame = Needs { tangent: is_bump, derivatives: is_bump, ..Needs::default() };
            needs.or(placement::needs(&layer.placement)).or(frame)
        })
    }

    /// Whether a layer may leave nothing at a point, whatever `alpha_mode` says.
    pub fn has_alpha_test(&self) -> bool {
        self.layers.iter().any(|l| matches!(l.operator, Operator::AlphaTest(..)))
    }

    /// Whether every point of it is there, so that alpha need not be asked for.
    pub fn is_opaque(&self) -> bool {
        self.alpha_mode == AlphaMode::Opaque && !self.has_alpha_test()
    }
}
