//! How true a lit ball's texture is: the picture beside the one that is lit at each pixel.

use crate::error::Result;
use crate::par::Workers;
use crate::picture::sphere_texture::{Difference, difference};
use crate::recipe::stack::LIGHTS;
use crate::recipe::{Recipe, prepare};
use std::path::Path;

/// Draws a recipe and, for truth, the same with Blinn-Phong shading at each pixel in place of layers of `lights` and of
/// Gouraud's shading; compares them where the surface is.
///
/// # Errors
/// As [`prepare()`].
pub fn ball_error(recipe: &Recipe, base: &Path, workers: &Workers) -> Result<Difference> {
    let mut truth = recipe.clone();
    truth.layers.retain(|l| l.image.as_deref() != Some(LIGHTS));
    truth.surface.shading = Some("blinn-phong".into());
    let given = prepare(recipe, base, workers)?.value;
    let mut truth = prepare(&truth, base, workers)?.value;
    truth.develop = given.develop;
    let is_surface: Vec<bool> = truth.light(workers, &|_| ()).light.iter().map(|c| c[3] > 0.0).collect();
    let [given, truth] = [given, truth].map(|p| p.render(workers, &|_| ()).pixels);
    Ok(difference(&truth, &given, Some(&is_surface)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::text;

    /// A coarse ball in the light of one lamp.
    fn error(camera: &str, surface: &str) -> Difference {
        let text = format!(
            "[input]\nfile = 'sample:icosphere'\nresolution = 16\n[camera]\n{camera}\n[picture]\nsize = [120, 120]\n\
             ambient = 0.12\ndevelop = 'filmic'\n[[lights]]\ndirection = [-0.2, 0.7, 0.75]\n[surface]\nplain = true\n\
             color = '#c7632f'\nspecular = 0.6\nexponent = 60.0\n{surface}"
        );
        let recipe = text::parse(&text, Path::new("a.toml")).expect("a recipe");
        ball_error(&recipe, Path::new(""), &Workers::new(1)).expect("pictures")
    }

    #[test]
    fn a_ball_by_pixel_is_nearly_true_by_vertex_less_and_gouraud_least() {
        let far = "orthographic = true";
        let lights = "shading = 'unlit'\n[[layers]]\nimage = 'lights'\n";
        let pixel = error(far, lights);
        let vertex = error(far, &format!("{lights}per_vertex = true"));
        let gouraud = error(far, "shading = 'gouraud'");
        assert!(pixel.n_pixels > 3000 && pixel.mean < 0.1 && pixel.max <= 6, "{pixel:?}");
        assert!(vertex.mean < 1.5 && vertex.mean > 2.0 * pixel.mean, "{vertex:?}");
        assert!(gouraud.mean > 1.5 * vertex.mean && gouraud.max > 20, "{gouraud:?}");
        // Near by, lines of sight are not parallel: the ball's light is that of another direction.
        let near = error("fov = 60.0", lights);
        assert!(near.mean > 3.0 * pixel.mean, "{near:?}");
    }

    #[test]
    fn truth_differs_from_itself_by_nothing() {
        let same = error("", "shading = 'blinn-phong'");
        assert_eq!((same.mean, same.max), (0.0, 0));
    }
}
