//! Bands that follow the skin, of uneven widths: agate.

use super::check::{positive, within};
use super::eval::Hit;
use super::mottle::clamp01;
use super::question::Question;
use crate::Result;
use crate::math::{DVec3, floor, hash, sin_cos, unit_float, vec2};
use crate::noise::{Lattice, gradient_2d};

/// Bands as a person describes them. Their waves come from [`Wavy`](super::Wavy) around them.
#[derive(Clone, Debug, PartialEq)]
pub struct BandsSpec {
    /// Mean width of a band, model units.
    pub spacing: f32,
    /// How much widths differ: 0 to 1.
    pub width_spread: f32,
    /// Fine lines within a band, at most; 0 for none.
    pub lines: f32,
    /// How strong fine lines are: 0 to 1.
    pub line_contrast: f32,
    /// Which part of a band passes over into the next.
    pub blur: f32,
    /// Another seed, other bands.
    pub seed: u32,
}

impl BandsSpec {
    /// Bands with the usual irregularity.
    pub fn of(spacing: f32) -> Self {
        Self { spacing, width_spread: 0.7, lines: 6.0, line_contrast: 0.35, blur: 0.2, seed: 0 }
    }
}

/// Checked bands, ready to be asked.
#[derive(Clone, Debug)]
pub struct Bands {
    spec: BandsSpec,
}

impl Bands {
    /// Bands from their description.
    ///
    /// # Errors
    /// A number that makes no sense.
    pub fn new(spec: BandsSpec) -> Result<Self> {
        positive("spacing", spec.spacing)?;
        within("width spread", spec.width_spread, 0.0..=1.0, "from 0 to 1")?;
        within("lines", spec.lines, 0.0..=64.0, "from 0 to 64 a band")?;
        within("line contrast", spec.line_contrast, 0.0..=1.0, "from 0 to 1")?;
        within("blur", spec.blur, 0.001..=1.0, "from 0.001 to 1 band")?;
        Ok(Self { spec })
    }

    /// The tone at a depth, model units.
    pub fn tone(&self, depth: f32) -> f32 {
        let BandsSpec { spacing, width_spread, lines, line_contrast, blur, seed } = self.spec;
        let s = depth / spacing;
        let wander = gradient_2d(vec2(s * 0.61, 0.37), Lattice::seeded(seed)).value;
        let s = s + width_spread * 0.9 * wander;
        let band = floor(s);
        let part = s - band;
        let draw = |k: f32, which: u32| unit_float(hash(hash((k as i32) as u32 ^ seed).wrapping_add(which)));
        let share = clamp01((part - 1.0 + blur) / blur);
        let share = share * share * (3.0 - 2.0 * share);
        let base = draw(band, 1) + (draw(band + 1.0, 1) - draw(band, 1)) * share;
        // Some bands have lines, some are plain; none at their borders, so that the number of lines may change there.
        let n_lines = floor(draw(band, 2) * (lines + 1.0));
        let wave = sin_cos(part * n_lines * std::f32::consts::TAU).0;
        clamp01(base + line_contrast * 0.5 * wave * draw(band, 3) * (1.0 - share))
    }

    pub(super) fn answer(&self, p: DVec3, question: &Question) -> Hit {
        Hit { tone: self.tone((question.depth)(p)), ..question.plain(p) }
    }
}
