//! What a file says about a surface's look, in one vocabulary for all formats (that of glTF 2.0's metal-roughness model).

use crate::color::{LinearRgb, LinearRgba};

/// What happens outside of [0, 1], for one coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Wrap {
    /// The fractional part counts.
    #[default]
    Repeat,
    /// Every second repetition is mirrored.
    MirroredRepeat,
    /// The nearest texel of the edge counts.
    ClampToEdge,
    /// The texture is not applied outside: once only (the founding article's CLAMP).
    ClampToBorder,
}

/// How a texel grid is read between texel centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Four texels (eight in 3-D), weighted by distance.
    #[default]
    Linear,
}

/// How a texture is read where a pixel covers more than a texel. The six classic filters by their classic names: first
/// word, how a level is read; last word, how levels combine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum MinFilter {
    /// The nearest texel of the full image.
    Nearest,
    /// Four texels of the full image.
    Linear,
    /// The nearest texel of the nearest level.
    NearestMipmapNearest,
    /// Four texels of the nearest level.
    LinearMipmapNearest,
    /// The nearest texels of two levels, mixed.
    NearestMipmapLinear,
    /// Four texels of two levels each, mixed (trilinear).
    #[default]
    LinearMipmapLinear,
}

/// How a texture is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// Wrap for s (across), t (down) and r (depth).
    pub wrap: [Wrap; 3],
    /// Where a texel covers more than a pixel.
    pub mag: Filter,
    /// Where a pixel covers more than a texel.
    pub min: MinFilter,
    /// Most taps along the footprint's longer axis, 1 (isotropic) to 16.
    pub max_anisotropy: u8,
}

impl Default for Sampler {
    /// Repeat, trilinear, up to 8 taps along the longer axis: what a picture wants that is looked at once.
    fn default() -> Self {
        Self { wrap: [Wrap::Repeat; 3], mag: Filter::Linear, min: MinFilter::LinearMipmapLinear, max_anisotropy: 8 }
    }
}

/// An affine map of texture coordinates: `uv' = matrix * uv + offset` (KHR_texture_transform, OBJ's -s and -o).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Rows of the 2x2 matrix.
    pub matrix: [[f32; 2]; 2],
    /// Added after it.
    pub offset: [f32; 2],
}

impl UvTransform {
    /// Leaves coordinates as they are.
    pub const IDENTITY: Self = Self { matrix: [[1.0, 0.0], [0.0, 1.0]], offset: [0.0, 0.0] };
}

/// A use of an image by a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into the scene's images.
    pub image: u32,
    /// Index into the mesh's UV sets.
    pub uv_set: u32,
    /// How it is read.
    pub sampler: Sampler,
    /// Applied to the UV set first.
    pub transform: UvTransform,
}

/// What alpha means.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum AlphaMode {
    /// Nothing: the surface is opaque.
    #[default]
    Opaque,
    /// There where alpha is at least this, not there elsewhere.
    Mask(f32),
    /// Coverage to be blended.
    Blend,
}

/// A surface's look as a file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// As the file names it.
    pub name: String,
    /// Linear colour and alpha; multiplies the texture and vertex colours.
    pub base_color: LinearRgba,
    /// sRGB colour, straight alpha.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric to 1 metal.
    pub metalness: f32,
    /// 0 mirror to 1 chalk (perceptual; its square is GGX alpha).
    pub roughness: f32,
    /// Green: roughness, blue: metalness; linear; multiplies the factors.
    pub metal_rough_texture: Option<TextureRef>,
    /// Tangent-space normals, linear, +Y up (OpenGL).
    pub normal_texture: Option<TextureRef>,
    /// Scales the map's x and y.
    pub normal_scale: f32,
    /// A grey height map instead of a normal map (OBJ `map_bump`), height 1.0 = this many model units... of texture width.
    pub bump_texture: Option<TextureRef>,
    /// OBJ's `-bm`.
    pub bump_scale: f32,
    /// Red: ambient occlusion.
    pub occlusion_texture: Option<TextureRef>,
    /// 0 ignores the occlusion texture, 1 takes it whole.
    pub occlusion_strength: f32,
    /// Linear light given off; multiplies the texture.
    pub emission: LinearRgb,
    /// sRGB colour.
    pub emission_texture: Option<TextureRef>,
    /// What alpha means.
    pub alpha_mode: AlphaMode,
    /// An alpha texture of its own (OBJ `map_d`): red channel.
    pub alpha_texture: Option<TextureRef>,
    /// Whether back faces are seen.
    pub double_sided: bool,
    /// The colour is shown as it is, without light (KHR_materials_unlit).
    pub unlit: bool,
    /// Clear coat strength, 0 none (KHR_materials_clearcoat), and its roughness.
    pub clearcoat: Clearcoat,
}

impl Material {
    /// Every place where it may name a texture.
    pub fn texture_slots_mut(&mut self) -> [&mut Option<TextureRef>; 10] {
        [
            &mut self.base_color_texture,
            &mut self.metal_rough_texture,
            &mut self.normal_texture,
            &mut self.bump_texture,
            &mut self.occlusion_texture,
            &mut self.emission_texture,
            &mut self.alpha_texture,
            &mut self.clearcoat.strength_texture,
            &mut self.clearcoat.roughness_texture,
            &mut self.clearcoat.normal_texture,
        ]
    }
}

/// A thin transparent layer over a material (KHR_materials_clearcoat).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Clearcoat {
    /// 0 none to 1.
    pub strength: f32,
    /// Red multiplies the strength.
    pub strength_texture: Option<TextureRef>,
    /// Of the coat.
    pub roughness: f32,
    /// Green multiplies the roughness.
    pub roughness_texture: Option<TextureRef>,
    /// The coat's own normal map; without one it has the geometry's normals.
    pub normal_texture: Option<TextureRef>,
    /// Scales that map's x and y.
    pub normal_scale: f32,
}

impl Default for Material {
    /// Warm light grey clay: what an untextured scan gets.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [0.60, 0.585, 0.56, 1.0],
            base_color_texture: None,
            metalness: 0.0,
            roughness: 0.75,
            metal_rough_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            bump_texture: None,
            bump_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emission: [0.0; 3],
            emission_texture: None,
            alpha_mode: AlphaMode::Opaque,
            alpha_texture: None,
            double_sided: true,
            unlit: false,
            clearcoat: Clearcoat::default(),
        }
    }
}
