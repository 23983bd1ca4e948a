//! What colours a grain has.

use crate::color::LinearRgb;
use crate::error::Result;
use crate::math::{Vec3, Vec4};
use crate::recipe::words::{color, impossible};
use crate::section::grain::{Hit, HitKind, with_interreflection};

/// Colours of one leaf of a filling.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// Between particles: one colour, or a ramp along [`Hit::tone`]; linear light.
    pub matrix: Vec<Vec3>,
    /// Of particles: each has one of these, by its name, or a place on the ramp where `by_tone` says so.
    pub particles: Vec<Vec3>,
    /// Whether `particles` is a ramp along the tone.
    pub by_tone: bool,
    /// How much lighter or darker than these a particle may be: 0.15 is between 85 % and 115 %.
    pub vary: f32,
    /// Of the matrix, and of the particles.
    pub roughness: [f32; 2],
}

/// What stands between the particles, and what they are, of whom nothing is known.
const MATRIX: &str = "#ead9b8";
const PARTICLES: [&str; 6] = ["#c4573a", "#d9a441", "#7d9b6a", "#5b83a6", "#95627f", "#b98a62"];

impl Leaf {
    /// From colours as people write them; absent ones are the usual.
    ///
    /// # Errors
    /// What is no colour.
    pub fn new(matrix: &[String], particles: &[String]) -> Result<Self> {
        let all = |what: &str, given: &[String], usual: &[&str]| -> Result<Vec<Vec3>> {
            let linear = |c: &str| color(what, c).map(|c| Vec4::from(c).truncate());
            match given {
                [] => usual.iter().map(|c| linear(c)).collect(),
                given => given.iter().map(|c| linear(c)).collect(),
            }
        };
        Ok(Self {
            matrix: all("matrix", matrix, &[MATRIX])?,
            particles: all("particles", particles, &PARTICLES)?,
            by_tone: false,
            vary: 0.15,
            roughness: [0.7, 0.55],
        })
    }

    /// The same with another roughness of matrix and particles.
    ///
    /// # Errors
    /// What is not between 0 and 1.
    pub fn with_roughness(self, roughness: Option<[f32; 2]>) -> Result<Self> {
        let Some(roughness) = roughness else { return Ok(self) };
        match roughness.iter().find(|r| !(0.0..=1.0).contains(*r)) {
            Some(r) => Err(impossible("roughness", r, "0 to 1")),
            None => Ok(Self { roughness, ..self }),
        }
    }

    /// What a hit looks like: colour in linear light, and roughness.
    pub fn dress(&self, hit: &Hit) -> (LinearRgb, f32) {
        match hit.kind {
            HitKind::Matrix | HitKind::Bevel => (ramp(&self.matrix, hit.tone).to_array(), self.roughness[0]),
            HitKind::Bump | HitKind::Cavity | HitKind::Disc => {
                let name = hit.particle.wrapping_mul(0x9e37_79b1);
                let base = match self.by_tone {
                    true => ramp(&self.particles, hit.tone),
                    false => self.particles[(name >> 8) as usize % self.particles.len()],
                };
                // No two of a kind are quite alike.
                let light = 1.0 + self.vary * (2.0 * (name & 0xff) as f32 / 255.0 - 1.0);
                ((base * light).min(Vec3::ONE).to_array(), self.roughness[1])
            }
        }
    }
}

/// A place on a row of colours, 0 the first and 1 the last.
fn ramp(colors: &[Vec3], at: f32) -> Vec3 {
    let last = colors.len() - 1;
    let at = at.clamp(0.0, 1.0) * last as f32;
    let i = (at as usize).min(last.saturating_sub(1));
    let (a, b) = (colors[i], colors[(i + 1).min(last)]);
    a + (b - a) * (at - i as f32)
}

/// A colour as it looks where this much of the sky is seen, in light that casts no shadows.
pub(in crate::recipe) fn darkened(color: LinearRgb, openness: f32) -> LinearRgb {
    color.map(|albedo| albedo * with_interreflection(openness, albedo))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_pass_through_their_colours_and_particles_keep_theirs() {
        let leaf = Leaf::new(&["black".into(), "#f00".into(), "white".into()], &["#00f".into()]).unwrap();
        let hit = |kind, particle, tone| Hit { kind, particle, tone, ..Hit::matrix(Vec3::Z, 0.0) };
        for (tone, wanted) in [(0.0, [0.0; 3]), (0.5, [1.0, 0.0, 0.0]), (1.0, [1.0; 3]), (0.25, [0.5, 0.0, 0.0])] {
            assert_eq!(leaf.dress(&hit(HitKind::Matrix, 0, tone)).0, wanted, "{tone}");
        }
        let colors: Vec<LinearRgb> = (1..50).map(|p| leaf.dress(&hit(HitKind::Disc, p, 0.0)).0).collect();
        assert!(colors.iter().all(|c| c[0] == 0.0 && (0.84..=1.0).contains(&c[2])));
        assert!(colors.iter().any(|c| *c != colors[0]));
        assert!(Leaf::new(&["mud".into()], &[]).is_err());
        assert!(leaf.with_roughness(Some([0.2, 1.5])).is_err());
    }

    #[test]
    fn deep_places_are_darker_and_white_ones_stay_lit_by_themselves() {
        assert_eq!(darkened([0.5; 3], 1.0), [0.5; 3]);
        let [dark, ..] = darkened([0.5; 3], 0.3);
        assert!(dark < 0.3 && dark > 0.15);
        assert!(darkened([1.0; 3], 0.3)[0] > 0.99);
    }
}
