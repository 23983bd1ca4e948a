//! All looks of a scene with their textures, and how materials become stacks of layers.

use crate::assets::{Element, Field, Material, Mesh, Sampler, Scene, TextureImage, TextureRef, UvTransform};
use crate::color::Encoding;
use crate::lookup::layer::{Channel, Constants, Layer, Look, Target, Texture, TextureId};
use crate::lookup::operator::Operator;
use crate::lookup::{ImageTexture, Prepare, Shading, Usage};
use crate::math::{Mat4, vec4};
use crate::placement::{Missing, Needs, Placement, Property, PropertyAxis};

/// Textures, the looks that read them, and which part of the mesh has which look.
#[derive(Clone, Debug, Default)]
pub struct Looks {
    /// What layers refer to.
    pub textures: Vec<Texture>,
    /// One for each material of the scene, and last the default, for parts without one.
    pub looks: Vec<Look>,
    /// For each part of the mesh, an index into `looks`.
    pub look_of_part: Vec<u32>,
}

impl Looks {
    /// The looks of a scene's materials.
    pub fn from_scene(scene: &Scene) -> Self {
        let mut made = Self::default();
        let mut known = Vec::new();
        let has_colors = !scene.mesh.colors().is_empty();
        let n_uv_sets = scene.mesh.uv_sets().len();
        for material in &scene.materials {
            let mut stack =
                Stack { images: &scene.images, n_uv_sets, made: &mut made, known: &mut known, layers: vec![] };
            stack.push_material(material);
            let layers = stack.layers;
            made.looks.push(look(material, layers, has_colors));
        }
        let last = made.looks.len();
        let clay = Material { name: "clay".into(), ..Material::default() };
        let mut clay = look(&clay, Vec::new(), has_colors);
        if has_colors {
            // Painted scans show their own colours.
            clay.constants.color = [1.0; 4];
        }
        made.looks.push(clay);
        let of_part = |material: Option<u32>| material.map_or(last, |m| (m as usize).min(last)) as u32;
        if let Some(layer) = made.carried(&scene.mesh) {
            for look in &mut made.looks {
                look.layers.insert(0, layer.clone());
                look.uses_vertex_colors = false;
            }
        }
        made.look_of_part = scene.mesh.parts().iter().map(|part| of_part(part.material)).collect();
        made
    }

    /// Colours of faces as PLY files have them - fields red, green and blue, 0 to 255 - where vertices have none of their own,
    /// or all the same.
    fn carried(&mut self, mesh: &Mesh) -> Option<Layer> {
        if mesh.colors().windows(2).any(|pair| pair[0] != pair[1]) {
            return None;
        }
        let fields = mesh.fields();
        let axis = |name: &str| {
            let is_meant = |f: &Field| f.element == Element::Face && f.n_components == 1 && f.name == name;
            let field = fields.iter().position(is_meant)?;
            let property = Property::Field { field, component: Some(0), missing: Missing::Nearest };
            Some(PropertyAxis::over(property, [0.0, 255.0]))
        };
        let axes = [Some(axis("red")?), Some(axis("green")?), Some(axis("blue")?)];
        let texture = self.add(Texture::Carried(Encoding::Srgb));
        let placement = Placement::Property { axes };
        Some(Layer { placement, ..Layer::new(texture, Operator::Replace, Target::Color) })
    }

    /// Adds a texture.
    pub fn add(&mut self, texture: Texture) -> TextureId {
        self.textures.push(texture);
        TextureId(self.textures.len() as u32 - 1)
    }

    /// Gives all parts one look.
    pub fn wear(&mut self, look: Look) {
        self.looks = vec![look];
        self.look_of_part.iter_mut().for_each(|l| *l = 0);
    }

    /// The look of a part of the mesh.
    pub fn look_of_part(&self, part: usize) -> &Look {
        &self.looks[self.look_of_part.get(part).map_or(self.looks.len() - 1, |&l| l as usize)]
    }

    /// Which lanes of the surfels any look reads.
    pub fn needs(&self) -> Needs {
        self.looks.iter().fold(Needs::default(), |needs, look| needs.or(look.needs()))
    }

    /// Whether every point of every look is there.
    pub fn is_opaque(&self) -> bool {
        self.looks.iter().all(Look::is_opaque)
    }
}

fn look(material: &Material, layers: Vec<Layer>, uses_vertex_colors: bool) -> Look {
    let constants = Constants {
        color: material.base_color,
        roughness: material.roughness,
        metalness: material.metalness,
        emission: material.emission,
        coat: material.clearcoat.strength,
        coat_roughness: material.clearcoat.roughness,
    };
    Look {
        name: material.name.clone(),
        constants,
        uses_vertex_colors,
        layers,
        shading: if material.unlit { Shading::Unlit } else { Shading::MetalRough },
        alpha_mode: material.alpha_mode,
        is_double_sided: material.double_sided,
    }
}

/// A material's layers while they are made.
struct Stack<'a> {
    images: &'a [TextureImage],
    n_uv_sets: usize,
    made: &'a mut Looks,
    /// Images prepared so far: image, usage and sampler of each texture.
    known: &'a mut Vec<(u32, Usage, Sampler)>,
    layers: Vec<Layer>,
}

impl Stack<'_> {
    /// Layers that share a texture stand together, so that it is read once.
    fn push_material(&mut self, material: &Material) {
        let coat = &material.clearcoat;
        let modulate = Operator::Modulate;
        self.push(material.base_color_texture, Usage::Color, modulate, Target::Color, None);
        self.push(material.alpha_texture, Usage::Data, modulate, Target::Alpha, Some(Channel::Red));
        if material.occlusion_strength != 0.0 {
            self.push(material.occlusion_texture, Usage::Data, modulate, Target::Occlusion, Some(Channel::Red));
            self.strengthen(material.occlusion_texture, material.occlusion_strength);
        }
        self.push(material.metal_rough_texture, Usage::Data, modulate, Target::Roughness, Some(Channel::Green));
        self.push(material.metal_rough_texture, Usage::Data, modulate, Target::Metalness, Some(Channel::Blue));
        let bump = Target::Bump { scale: material.bump_scale };
        self.push(material.bump_texture, Usage::Slope, Operator::Replace, bump, None);
        let normal = Target::Normal { scale: material.normal_scale };
        self.push(material.normal_texture, Usage::Normal, Operator::Replace, normal, None);
        self.push(material.emission_texture, Usage::Color, modulate, Target::Emission, None);
        if coat.strength > 0.0 {
            self.push(coat.strength_texture, Usage::Data, modulate, Target::Coat, Some(Channel::Red));
            self.push(coat.roughness_texture, Usage::Data, modulate, Target::CoatRoughness, Some(Channel::Green));
            let normal = Target::CoatNormal { scale: coat.normal_scale };
            self.push(coat.normal_texture, Usage::Normal, Operator::Replace, normal, None);
        }
    }

    /// References to images or UV sets that are not there are left out.
    fn push(
        &mut self,
        texture: Option<TextureRef>,
        usage: Usage,
        operator: Operator,
        target: Target,
        channel: Option<Channel>,
    ) {
        let Some(texture) = texture.filter(|t| self.is_there(t)) else { return };
        let mut layer = Layer::new(self.texture(&texture, usage), operator, target);
        layer.placement = Placement::Uv(texture.uv_set as usize);
        layer.matrix = matrix(&texture.transform);
        if let Some(channel) = channel {
            layer.channels[0] = channel;
        }
        self.layers.push(layer);
    }

    fn is_there(&self, texture: &TextureRef) -> bool {
        (texture.image as usize) < self.images.len() && (texture.uv_set as usize) < self.n_uv_sets
    }

    fn strengthen(&mut self, texture: Option<TextureRef>, strength: f32) {
        if let (Some(_), Some(layer)) = (texture.filter(|t| self.is_there(t)), self.layers.last_mut()) {
            layer.strength = strength;
        }
    }

    fn texture(&mut self, texture: &TextureRef, usage: Usage) -> TextureId {
        let key = (texture.image, usage, texture.sampler);
        if let Some(i) = self.known.iter().position(|k| *k == key) {
            return TextureId(i as u32);
        }
        self.known.push(key);
        let image = &self.images[texture.image as usize];
        self.made.add(Texture::Image(ImageTexture::new(image, &Prepare::new(usage, texture.sampler))))
    }
}

/// The same map of (s, t) as a matrix of (s, t, r, q).
pub fn matrix(transform: &UvTransform) -> Mat4 {
    let [[a, b], [c, d]] = transform.matrix;
    let [x, y] = transform.offset;
    Mat4::from_cols(vec4(a, c, 0.0, 0.0), vec4(b, d, 0.0, 0.0), vec4(0.0, 0.0, 1.0, 0.0), vec4(x, y, 0.0, 1.0))
}
