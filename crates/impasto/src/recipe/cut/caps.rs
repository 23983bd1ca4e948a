//! What caps look like: maps in their own layout, or colours at their corners.

use super::blade::Ground;
use crate::assets::{Material, RawMesh, Sampler, Scene, TextureRef, UvTransform, Wrap};
use crate::error::Result;
use crate::math::{DVec3, Vec2, Vec3, Vec4, vec2};
use crate::par::Workers;
use crate::recipe::grain::{Leaf, Substance, darkened};
use crate::section::cut::CAP_NAME;
use crate::section::grain::{Hit, Look, SectionKind, Sections, Side, Window};
use crate::section::maps::{CapMaps, Layout, in_section};

/// How caps hold what they show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dress {
    /// Colours at corners: for formats without textures.
    Corners,
    /// Textures of so many texels along the longer side, for other programs.
    Maps(u32),
    /// Textures for a picture: darker where less of the sky is seen, as its light casts no shadows, and with the shading of
    /// the grain itself in place of that of the cap's triangles.
    Picture(u32),
}

/// One side of one cut.
pub(super) struct Cap<'a> {
    pub(super) ground: Ground<'a>,
    pub(super) look: Look,
    pub(super) substance: Option<&'a Substance>,
    /// Depth below the skin.
    pub(super) depth: &'a (dyn Fn(DVec3) -> f32 + Sync),
    /// How far a place may be lifted.
    pub(super) room: &'a (dyn Fn(DVec3) -> f32 + Sync),
}

impl Cap<'_> {
    /// What the section shows at a point of it, model space.
    pub(super) fn hit(&self, p: DVec3) -> Option<Hit> {
        self.substance.map(|s| s.filling.eval(p, self.ground.blade, self.look, &self.depth))
    }

    /// The same with no more relief than there is room for.
    pub(super) fn within_skin(&self, p: DVec3, hit: Hit) -> Hit {
        if hit.height == 0.0 {
            return hit;
        }
        let most = (self.room)(p);
        Hit { height: hit.height.clamp(-most, most), ..hit }
    }

    fn outward(&self) -> f64 {
        if self.look.side == Side::Below { 1.0 } else { -1.0 }
    }

    /// Colour at corners.
    pub(super) fn color(&self, leaf: &Leaf, p: DVec3) -> Vec4 {
        let hit = self.hit(p).unwrap_or(Hit::matrix(Vec3::Z, 0.0));
        let leaf = self.substance.map_or(leaf, |s| s.leaf(&hit));
        Vec3::from_array(leaf.dress(&hit).0).extend(1.0)
    }

    /// Maps around these coordinates. `plain` is the look of a cap without a grain.
    pub(super) fn maps(&self, plain: &Leaf, dress: Dress, at: &[Vec2], workers: &Workers) -> Result<CapMaps> {
        let (n_longer, is_picture) = match dress {
            Dress::Maps(n) => (n, false),
            Dress::Picture(n) => (n, true),
            Dress::Corners => (4, false),
        };
        let (min, max) = at.iter().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(a, b), &p| (a.min(p), b.max(p)));
        let layout = Layout::around(min, max, if self.substance.is_some() { n_longer } else { 4 })?;
        let listed = self.sections(&layout);
        let row = |xs: &[f32], y: f32| -> Vec<Hit> {
            let mut hits = vec![Hit::matrix(Vec3::Z, 0.0); xs.len()];
            if let Some(listed) = &listed {
                listed.row(workers.level(), y, xs, &mut hits);
            }
            for (&x, hit) in xs.iter().zip(&mut hits) {
                let at = vec2(x, y);
                let p = self.ground.point(at);
                let [u, v, n] = self.ground.frame(at, p);
                let outward = n * self.outward();
                if listed.is_none() {
                    *hit = self.hit(p).unwrap_or(Hit::matrix(outward.as_vec3(), 0.0));
                }
                if !is_picture {
                    *hit = self.within_skin(p, *hit);
                }
                hit.normal = in_section(hit.normal, [u, v, outward].map(|a| a.as_vec3()));
            }
            hits
        };
        let look = |hit: &Hit| {
            let leaf = self.substance.map_or(plain, |s| s.leaf(hit));
            let (color, roughness) = leaf.dress(hit);
            (if is_picture { darkened(color, hit.openness) } else { color }, roughness)
        };
        // Particles that are hardly wider than a texel would come and go.
        let texel = (layout.max.x - layout.min.x) / layout.size.width as f32;
        let n_places = match self.substance.map_or(f32::INFINITY, |s| s.finest) / texel {
            r if r < 1.0 => 4,
            r if r < 2.5 => 2,
            _ => 1,
        };
        Ok(CapMaps::bake(layout, n_places, workers, &row, &look))
    }

    /// What a plane meets, found once for all texels.
    fn sections(&self, layout: &Layout) -> Option<Sections<'_>> {
        let (substance, plane) = (self.substance?, self.ground.blade.plane()?);
        let window = Window { origin: self.ground.origin, axes: self.ground.axes, min: layout.min, max: layout.max };
        Some(Sections::new(&substance.filling, plane, window, self.look, self.depth))
    }

    /// Normals of the section itself, and tangents along +u, at the cap's corners: what the maps' normals are relative to.
    pub(super) fn flatten(&self, raw: &mut RawMesh, vertices: &[(usize, Vec2)]) {
        for &(v, at) in vertices {
            let [u, _, n] = self.ground.frame(at, self.ground.point(at));
            raw.normals[v] = (n * self.outward()).as_vec3();
            // Seen from its own half, +v is on the left of +u for the half below, on the right for the one above.
            raw.tangents[v] = u.as_vec3().extend(self.outward() as f32);
        }
    }
}

/// What a cap's material needs maps for, beside colour and roughness.
pub(super) struct Has {
    pub(super) normals: bool,
    /// Else the colours are dark already where little of the sky is seen.
    pub(super) openness: bool,
}

/// Adds a material with a cap's maps to a scene, and its images.
pub(super) fn add_material(scene: &mut Scene, maps: &CapMaps, name: &str, uv_set: u32, has: Has) {
    let clamp = Sampler { wrap: [Wrap::ClampToEdge; 3], ..Sampler::default() };
    let mut add = |image| {
        scene.images.push(image);
        let image = scene.images.len() as u32 - 1;
        Some(TextureRef { image, uv_set, sampler: clamp, transform: UvTransform::IDENTITY })
    };
    let base_color_texture = add(maps.color(&format!("{name}-color")));
    let both = add(maps.openness_and_roughness(&format!("{name}-openness-roughness")));
    let normal_texture = if has.normals { add(maps.normals(&format!("{name}-normal"))) } else { None };
    scene.materials.push(Material {
        name: CAP_NAME.into(),
        base_color_texture,
        metal_rough_texture: both,
        roughness: 1.0,
        occlusion_texture: both.filter(|_| has.openness),
        base_color: [1.0; 4],
        normal_texture,
        ..Material::default()
    });
}

/// What kind of section a cap shows.
pub(super) fn look(kind: SectionKind, side: Side) -> Look {
    Look { kind, side }
}
