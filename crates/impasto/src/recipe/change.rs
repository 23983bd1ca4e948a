//! A picture shown another way: tables, ranges, isolines, filters and lights change, all else stays.

use crate::assets::Scene;
use crate::error::{Mended, Result};
use crate::lookup::TextureId;
use crate::picture::sphere_texture::Material;
use crate::picture::{Lighting, Reflection};
use crate::placement::Viewpoint;
use crate::recipe::data::{Key, Sampled};
use crate::recipe::stack::Ground;
use crate::recipe::words::impossible;
use crate::recipe::{Prepared, Recipe, legend, stack, view};
use std::path::PathBuf;

/// What a recipe's layers were made from.
pub(super) struct Making {
    pub(super) base: PathBuf,
    pub(super) seed: u32,
    pub(super) uv_set: usize,
    pub(super) grids: Vec<Sampled>,
    pub(super) ball: Material,
    /// Of each layer of the recipe; none: it is in the mesh's colours.
    pub(super) textures: Vec<Option<TextureId>>,
}

impl Making {
    /// What layers are made for: a scene, seen from somewhere in some light. Tables that are in `known` are taken from there.
    pub(super) fn on<'a>(
        &'a self,
        scene: &'a Scene,
        view: Viewpoint,
        lighting: &'a Lighting,
        known: &'a [Key],
    ) -> Ground<'a> {
        let Self { base, seed, uv_set, grids, ball, .. } = self;
        Ground { scene, base, seed: *seed, uv_set: *uv_set, grids, view, lighting, ball: *ball, known }
    }
}

impl Prepared {
    /// Shows the data layers as `recipe` has them now, in its light. The rest of it - scene, view, size, other layers - must be
    /// what this was prepared from, and stays as it is; so does the room that the legend has.
    ///
    /// On a stage that [stands still](crate::recipe::render::Stage::standing_still) such a picture costs its look-up alone.
    ///
    /// # Errors
    /// `Parameter` for names and numbers that cannot be; then nothing is changed.
    pub fn change(&mut self, recipe: &Recipe) -> Result<Vec<Mended>> {
        if recipe.layers.len() != self.making.textures.len() || recipe.is_made_for_one_view() {
            return Err(impossible("change", recipe.subject(), "only what data layers say can change"));
        }
        let mut mended = Vec::new();
        let lighting = self.lighting_by(recipe)?;
        let on = self.making.on(&self.scene, self.domain().view, &lighting, &self.keys);
        let (keys, legend, labelled) = legend::told(recipe, &on, (self.size, self.background), &mut mended)?;
        let on = Ground { known: &keys, ..on };
        let mut made = Vec::new();
        for (layer, texture) in recipe.layers.iter().zip(&self.making.textures).filter(|(l, _)| l.is_data()) {
            if let Some(id) = texture {
                made.push((*id, stack::layer(layer, None, &on, &mut mended)?));
            }
        }
        for (id, (mut layer, texture)) in made {
            layer.texture = id;
            self.looks.textures[id.0 as usize] = texture;
            let worn = self.looks.looks.iter_mut().flat_map(|look| &mut look.layers).filter(|l| l.texture == id);
            worn.for_each(|worn| worn.clone_from(&layer));
        }
        (self.keys, self.legend, self.labelled, self.lighting) = (keys, legend, labelled, lighting);
        Ok(mended)
    }

    /// The lights that `recipe` asks for, for the view as it is now: some stand by the camera.
    pub(super) fn lighting_by(&self, recipe: &Recipe) -> Result<Lighting> {
        let environment = match &self.lighting.reflection {
            Reflection::Environment(environment) => Some(environment.clone()),
            Reflection::Surroundings(_) => None,
        };
        view::lighting(recipe, &self.scene, &self.domain().view, environment)
    }
}

#[cfg(test)]
mod tests {
    use crate::par::Workers;
    use crate::recipe::render::Stage;
    use crate::recipe::{Prepared, Recipe, prepare, text};
    use std::path::Path;

    /// A data picture of the flange's stress, with isolines over it.
    fn recipe(layer: &str, step: f32, more: &str) -> Recipe {
        let text = format!(
            "[input]\nfile = \"sample:flange\"\nresolution = 40\n[picture]\nsize = [160, 120]\n{more}\n\
             [surface]\nshading = \"unlit\"\n[[layers]]\nfield = \"stress\"\nshades = true\noperator = \"replace\"\n{layer}\n\
             [[layers]]\nisolines = {step:?}\nfield = \"stress\"\noperator = \"decal\"\n"
        );
        text::parse(&text, Path::new("a.toml")).expect("a recipe")
    }

    fn fresh(recipe: &Recipe) -> Prepared {
        prepare(recipe, Path::new(""), &Workers::new(1)).expect("a picture").value
    }

    #[test]
    fn a_changed_picture_is_the_picture_made_anew() {
        let ways = [
            recipe("table = \"viridis\"\nrange = [0, 100]", 20.0, "samples = 4"),
            recipe("table = \"viridis\"\nrange = [30, 70]", 20.0, "samples = 4"),
            recipe("table = \"vik\"\nrange = [0, 100]\nbands = 7", 20.0, "samples = 4"),
            recipe("table = \"viridis\"\nrange = [1, 100]\nvalue_scale = \"log\"", 7.5, "samples = 4"),
            recipe("table = \"viridis\"\nrange = [0, 100]", 20.0, "samples = 4\nlight = \"headlight\""),
        ];
        let workers = Workers::new(2);
        let mut prepared = fresh(&ways[0]);
        let mut stage = Stage::standing_still();
        for (i, way) in ways.iter().chain(&ways).enumerate() {
            prepared.change(way).expect("a change");
            let got = prepared.render_on(&mut stage, &workers, &|_| ());
            let mut wanted = fresh(way);
            wanted.frame = prepared.frame;
            wanted.view = prepared.view;
            let wanted = wanted.render(&workers, &|_| ());
            assert!(got == wanted, "way {i}");
        }
    }

    #[test]
    fn what_cannot_change_is_refused_and_nothing_lost() {
        let first = recipe("table = \"viridis\"", 20.0, "");
        let mut prepared = fresh(&first);
        let before = prepared.keys.clone();
        assert!(prepared.change(&recipe("table = \"viridis\"\nrange = [1, 1]", 20.0, "")).is_err());
        assert!(prepared.change(&Recipe { layers: Vec::new(), ..first }).is_err());
        assert!(prepared.keys == before);
    }
}
