//! Matrix that is not of one colour, and skins with waves: noise that goes through a whole filling.

use super::check::{positive, within};
use super::eval::{Hit, HitKind};
use super::filling::Filling;
use super::question::Question;
use super::spec::parameter;
use crate::Result;
use crate::math::{DVec3, Vec3};
use crate::noise::{Lattice, Smooth, fbm_3d};

/// What noise draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pattern {
    /// Spots and clouds.
    #[default]
    Clouds,
    /// Thin veins: where the noise is zero.
    Veins,
    /// From 0 at the skin to 1 at a depth of `scale`: a crust.
    Depth,
}

/// A tone by noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mottle {
    /// Width of the largest features, model units.
    pub scale: f32,
    /// How much longer features are along the model's axes.
    pub stretch: Vec3,
    /// Each octave adds features of half the width.
    pub n_octaves: u32,
    /// How far tones go: at 1 the noise's extremes are the ends of the ramp; above, more of the area is.
    pub contrast: f32,
    /// The mean tone of clouds; of veins, how wide they are.
    pub level: f32,
    /// What it draws.
    pub pattern: Pattern,
    /// Particles get it, too.
    pub is_everywhere: bool,
    /// Another seed, other spots.
    pub seed: u32,
}

impl Mottle {
    /// Clouds in the matrix.
    pub fn of(scale: f32) -> Self {
        Self {
            scale,
            stretch: Vec3::ONE,
            n_octaves: 4,
            contrast: 1.0,
            level: 0.5,
            pattern: Pattern::Clouds,
            is_everywhere: false,
            seed: 0,
        }
    }

    /// The tone at a point so deep, 0 to 1.
    fn tone(&self, p: DVec3, depth: &dyn Fn(DVec3) -> f32) -> f32 {
        let noise = || sampled(p, self.scale, self.stretch, self.n_octaves, self.seed).value;
        let tone = match self.pattern {
            Pattern::Clouds => self.level + self.contrast * noise(),
            Pattern::Depth => depth(p) / self.scale,
            Pattern::Veins => 1.0 - self.contrast * (noise().abs() / self.level.max(1e-6) - 0.5),
        };
        clamp01(tone)
    }
}

fn sampled(p: DVec3, scale: f32, stretch: Vec3, n_octaves: u32, seed: u32) -> Smooth<Vec3> {
    // Off the lattice of the other noises, where all are zero.
    let at = p / (stretch.as_dvec3() * scale as f64) + DVec3::new(0.137, 0.731, 0.419);
    fbm_3d(at.as_vec3(), n_octaves, 0.5, Lattice::seeded(seed))
}

pub(super) fn clamp01(x: f32) -> f32 {
    if x > 0.0 { if x < 1.0 { x } else { 1.0 } } else { 0.0 }
}

/// A filling whose matrix has tones.
#[derive(Clone, Debug)]
pub struct Mottled {
    mottle: Mottle,
    pub(super) filling: Filling,
}

impl Mottled {
    /// A filling with tones by noise in place of its own.
    ///
    /// # Errors
    /// A number that makes no sense.
    pub fn new(mottle: Mottle, filling: Filling) -> Result<Self> {
        positive("mottle scale", mottle.scale)?;
        octaves(mottle.n_octaves)?;
        stretch(mottle.stretch)?;
        within("mottle contrast", mottle.contrast, 0.0..=100.0, "from 0 to 100")?;
        within("mottle level", mottle.level, 0.0..=1.0, "from 0 to 1")?;
        Ok(Self { mottle, filling })
    }

    /// What has the tones.
    pub fn filling(&self) -> &Filling {
        &self.filling
    }

    pub(super) fn asks_depth(&self) -> bool {
        self.mottle.pattern == Pattern::Depth
    }

    pub(super) fn answer(&self, p: DVec3, question: &Question) -> Hit {
        let hit = self.filling.answer(p, question);
        let is_matrix = matches!(hit.kind, HitKind::Matrix | HitKind::Bevel);
        if !is_matrix && !self.mottle.is_everywhere {
            return hit;
        }
        // At the point that is seen, so that both halves of a tear agree.
        let at = p + question.outward(p) * hit.height as f64;
        Hit { tone: self.mottle.tone(at, question.depth), ..hit }
    }
}

fn octaves(n: u32) -> Result<()> {
    if (1..=8).contains(&n) { Ok(()) } else { Err(parameter("octaves", n, "from 1 to 8")) }
}

pub(super) fn stretch(stretch: Vec3) -> Result<()> {
    if stretch.is_finite() && stretch.min_element() >= 0.05 && stretch.max_element() <= 20.0 {
        return Ok(());
    }
    let given = format!("{},{},{}", stretch.x, stretch.y, stretch.z);
    Err(parameter("stretch", given, "three numbers from 0.05 to 20"))
}

/// Waves of the skin as what is below sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waves {
    /// How far depths are changed at most, model units. Less near the skin, which stays.
    pub height: f32,
    /// Width of the largest waves, model units; at least the height.
    pub length: f32,
    /// Each octave adds waves of half the width and height.
    pub n_octaves: u32,
    /// Another seed, other waves.
    pub seed: u32,
}

/// A filling under a wavy skin.
#[derive(Clone, Debug)]
pub struct Wavy {
    waves: Waves,
    pub(super) filling: Filling,
}

impl Wavy {
    /// A filling for which depths have waves.
    ///
    /// # Errors
    /// A number that makes no sense.
    pub fn new(waves: Waves, filling: Filling) -> Result<Self> {
        positive("wave length", waves.length)?;
        within("wave height", waves.height, 0.0..=waves.length, "from 0 to the waves' length")?;
        octaves(waves.n_octaves)?;
        Ok(Self { waves, filling })
    }

    /// What is under the waves.
    pub fn filling(&self) -> &Filling {
        &self.filling
    }

    /// The depth that the filling is told.
    pub(super) fn depth(&self, p: DVec3, depth: f32) -> f32 {
        let Waves { height, length, n_octaves, seed } = self.waves;
        if height <= 0.0 || depth <= 0.0 {
            return depth;
        }
        let noise = sampled(p, length, Vec3::ONE, n_octaves, seed).value;
        // Full from a depth of twice the height on: there is no depth below zero, and none twice.
        let share = clamp01(depth / (2.0 * height));
        depth + height * noise * share
    }

    pub(super) fn answer(&self, p: DVec3, question: &Question) -> Hit {
        let depth = |x: DVec3| self.depth(x, (question.depth)(x));
        self.filling.answer(p, &Question { depth: &depth, ..*question })
    }
}
