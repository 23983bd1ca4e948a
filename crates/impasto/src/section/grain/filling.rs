//! What fills a model: one of the grains, or several one within the other.
//!
//! A filling is a tree; its leaves are what has a colour of its own, and a hit tells which of them it is on.

use super::bands::Bands;
use super::chambers::Chambers;
use super::druse::Druse;
use super::eval::{Candidate, Hit, Look};
use super::mottle::{Mottled, Wavy};
use super::question::Question;
use super::rings::Rings;
use super::scales::Scales;
use super::trabeculae::Trabeculae;
use super::{Cells, Fibres, Grain};
use crate::math::DVec3;
use crate::section::CutSurface;
use std::cell::Cell;

/// A solid texture of any kind.
#[derive(Clone, Debug)]
pub enum Filling {
    /// Nothing but matrix.
    Plain,
    /// Particles.
    Particles(Box<Grain>),
    /// Cells without or with walls, with or without nuclei.
    Cells(Box<Cells>),
    /// Fibres.
    Fibres(Box<Fibres>),
    /// Particles of several sizes.
    Scales(Box<Scales>),
    /// Growth rings of wood.
    Rings(Box<Rings>),
    /// A network or walls without end: spongy bone.
    Trabeculae(Box<Trabeculae>),
    /// Bands that follow the skin: agate.
    Bands(Box<Bands>),
    /// A hollow lined with crystals.
    Druse(Box<Druse>),
    /// Rooms with walls, and what is in each of them.
    Chambers(Box<Chambers>),
    /// Rind and flesh, cortex and marrow.
    Layers(Vec<Layer>),
    /// A filling whose matrix is not of one colour.
    Mottled(Box<Mottled>),
    /// A filling for which the skin has waves, so that what follows the skin does, too.
    Wavy(Box<Wavy>),
}

/// A layer below the model's skin.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Where it ends: depth below the skin, model units. The last layer goes on to the middle, whatever it says.
    pub until: f32,
    /// What it is made of.
    pub filling: Filling,
    /// Particles that reach over the layer's border are left out; else those stay whose centre is in it.
    pub strict: bool,
}

impl Filling {
    /// What a cut shows at a point of it, in model space; see [`Grain::eval`]. `depth` tells how deep below the skin any
    /// point near the cut lies, model units.
    pub fn eval(&self, p: DVec3, surface: &impl CutSurface, look: Look, depth: &dyn Fn(DVec3) -> f32) -> Hit {
        // Layers, chambers and particles' centres ask for the same two depths again and again; a depth is dear.
        let (here, there) = (Cell::new(None), Cell::new(None));
        let known = |x: DVec3| {
            let slot = if x == p { &here } else { &there };
            match slot.get() {
                Some((at, deep)) if at == x => deep,
                _ => {
                    let deep = depth(x);
                    slot.set(Some((x, deep)));
                    deep
                }
            }
        };
        self.answer(p, &Question { surface, look, depth: &known, keep: &|_| true })
    }

    /// How many leaves it has. They are numbered from 0, depth first: particles of several sizes from the coarse to the
    /// fine, layers from the skin inwards, walls of chambers before what is in them. Grains have one, the matrix around
    /// their particles included; cells with nuclei have two, wood and its pores, spongy bone and its marrow.
    pub fn n_leaves(&self) -> u16 {
        match self {
            Self::Plain | Self::Particles(_) | Self::Fibres(_) | Self::Bands(_) | Self::Druse(_) => 1,
            Self::Cells(cells) => 1 + cells.spec().nucleus.is_some() as u16,
            Self::Rings(_) | Self::Trabeculae(_) => 2,
            Self::Scales(scales) => scales.sizes().len() as u16,
            Self::Chambers(chambers) => 1 + chambers.inner().n_leaves(),
            Self::Layers(layers) => layers.iter().map(|l| l.filling.n_leaves()).sum(),
            Self::Mottled(mottled) => mottled.filling.n_leaves(),
            Self::Wavy(wavy) => wavy.filling.n_leaves(),
        }
    }

    /// Whether it asks how deep below the skin a place is.
    pub fn asks_depth(&self) -> bool {
        match self {
            Self::Layers(_) | Self::Trabeculae(_) | Self::Bands(_) | Self::Druse(_) | Self::Chambers(_) => true,
            Self::Mottled(mottled) => mottled.asks_depth() || mottled.filling.asks_depth(),
            Self::Wavy(wavy) => wavy.filling.asks_depth(),
            _ => false,
        }
    }

    /// Whether a tear of it parts pieces. What has none, such as spongy bone, is hollow where it is torn.
    pub fn has_pieces(&self) -> bool {
        match self {
            Self::Particles(_) | Self::Cells(_) | Self::Fibres(_) | Self::Scales(_) | Self::Rings(_) => true,
            Self::Plain | Self::Trabeculae(_) | Self::Bands(_) | Self::Druse(_) => false,
            Self::Chambers(chambers) => chambers.inner().has_pieces(),
            Self::Layers(layers) => layers.iter().any(|l| l.filling.has_pieces()),
            Self::Mottled(mottled) => mottled.filling.has_pieces(),
            Self::Wavy(wavy) => wavy.filling.has_pieces(),
        }
    }

    pub(super) fn answer(&self, p: DVec3, question: &Question) -> Hit {
        let Question { surface, look, keep, .. } = *question;
        match self {
            Self::Plain => question.plain(p),
            Self::Particles(grain) => grain.eval_where(p, &surface, look, keep),
            Self::Cells(cells) => cells.eval_where(p, &surface, look, keep),
            Self::Fibres(fibres) => fibres.eval_where(p, &surface, look, keep),
            Self::Scales(scales) => scales.answer(p, question),
            Self::Rings(rings) => rings.answer(p, question),
            Self::Trabeculae(trabeculae) => trabeculae.answer(p, question),
            Self::Bands(bands) => bands.answer(p, question),
            Self::Druse(druse) => druse.answer(p, question),
            Self::Chambers(chambers) => chambers.answer(p, question),
            Self::Layers(layers) => in_layers(layers, p, question),
            Self::Mottled(mottled) => mottled.answer(p, question),
            Self::Wavy(wavy) => wavy.answer(p, question),
        }
    }
}

fn in_layers(layers: &[Layer], p: DVec3, question: &Question) -> Hit {
    let Some((k, layer)) = layer_at(layers, (question.depth)(p)) else { return question.plain(p) };
    let inside = |c: &Candidate| Layer::holds(layers, k, c, question.depth) && (question.keep)(c);
    let hit = layer.filling.answer(p, &Question { keep: &inside, ..*question });
    Hit { leaf: Layer::first_leaf(layers, k) + hit.leaf, ..hit }
}

impl Layer {
    /// Whether the `k`th of some layers has a particle.
    pub(super) fn holds(layers: &[Layer], k: usize, c: &Candidate, depth: &dyn Fn(DVec3) -> f32) -> bool {
        let start = if k > 0 { layers[k - 1].until } else { 0.0 };
        let end = if k + 1 < layers.len() { layers[k].until } else { f32::INFINITY };
        let (at, reach) = (depth(c.center), if layers[k].strict { c.reach } else { 0.0 });
        // The skin itself is no border that counts: what sticks out there is the rim's matter.
        (k == 0 || at - reach >= start) && at + reach <= end
    }

    /// The number of the first leaf of the `k`th of some layers.
    pub(super) fn first_leaf(layers: &[Layer], k: usize) -> u16 {
        layers[..k].iter().map(|l| l.filling.n_leaves()).sum()
    }
}

pub(super) fn layer_at(layers: &[Layer], depth: f32) -> Option<(usize, &Layer)> {
    let k = layers.iter().position(|l| depth < l.until).or(layers.len().checked_sub(1))?;
    Some((k, &layers[k]))
}
