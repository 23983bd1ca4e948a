//! What fills a model: one grain, two scales of particles, or layers by depth below the skin.

use super::eval::{Candidate, Hit, HitKind, Look, SectionKind, Side};
use super::particle::{add, for_cells};
use super::shape::Convex;
use super::{Cells, Fibres, Grain};
use crate::math::{DVec3, Vec3, vec3};
use crate::section::CutSurface;

/// A solid texture of any kind.
#[derive(Clone, Debug)]
pub enum Filling {
    /// Nothing but matrix.
    Plain,
    /// Particles.
    Particles(Box<Grain>),
    /// Cells without or with walls.
    Cells(Box<Cells>),
    /// Fibres.
    Fibres(Box<Fibres>),
    /// Coarse particles, and fine ones in the matrix between them.
    TwoScales {
        /// Large ones.
        coarse: Box<Grain>,
        /// Small ones; those nearer than `gap` to a large one are left out, whole.
        fine: Box<Grain>,
        /// Model units.
        gap: f32,
    },
    /// Rind and flesh, cortex and marrow.
    Layers(Vec<Layer>),
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
        self.eval_where(p, surface, look, depth, &|_| true)
    }

    fn eval_where(
        &self,
        p: DVec3,
        surface: &impl CutSurface,
        look: Look,
        depth: &dyn Fn(DVec3) -> f32,
        keep: &dyn Fn(&Candidate) -> bool,
    ) -> Hit {
        match self {
            Self::Plain => {
                let n = surface.normal(p);
                let normal = if look.side == Side::Below { n } else { -n }.as_vec3();
                Hit { height: 0.0, normal, kind: HitKind::Matrix, particle: Hit::MATRIX, openness: 1.0 }
            }
            Self::Particles(grain) => grain.eval_where(p, surface, look, keep),
            Self::Cells(cells) => cells.eval_where(p, surface, look, keep),
            Self::Fibres(fibres) => fibres.eval_where(p, surface, look, keep),
            Self::TwoScales { coarse, fine, gap } => {
                let hit = coarse.eval_where(p, surface, look, keep);
                let is_free = |c: &Candidate| keep(c) && coarse.clearance(c.center, c.reach) >= c.reach + gap;
                match (hit.kind, look.kind) {
                    (HitKind::Matrix, _) => {
                        let inner = fine.eval_where(p, surface, look, is_free);
                        // Between hard particles of two scales, the matrix lies as deep as the coarse ones have it.
                        if inner.kind == HitKind::Matrix { hit } else { inner }
                    }
                    (HitKind::Bevel, SectionKind::Solid) => {
                        let inner = fine.eval_where(p, surface, look, is_free);
                        let is_above = inner.kind != HitKind::Matrix && inner.height > hit.height;
                        if is_above { inner } else { hit }
                    }
                    _ => hit,
                }
            }
            Self::Layers(layers) => {
                let Some((k, layer)) = layer_at(layers, depth(p)) else {
                    return Self::Plain.eval_where(p, surface, look, depth, keep);
                };
                let start = if k > 0 { layers[k - 1].until } else { 0.0 };
                let end = if k + 1 < layers.len() { layer.until } else { f32::INFINITY };
                let inside = |c: &Candidate| {
                    let (at, reach) = (depth(c.center), if layer.strict { c.reach } else { 0.0 });
                    // The skin itself is no border that counts: what sticks out there is the rim's matter.
                    (k == 0 || at - reach >= start) && at + reach <= end && keep(c)
                };
                layer.filling.eval_where(p, surface, look, depth, &inside)
            }
        }
    }
}

fn layer_at(layers: &[Layer], depth: f32) -> Option<(usize, &Layer)> {
    let k = layers.iter().position(|l| depth < l.until).or(layers.len().checked_sub(1))?;
    Some((k, &layers[k]))
}

impl Grain {
    /// At least how far a point is from all particles, as far as that is less than twice `far`; model units.
    ///
    /// By separating planes across the line of centres: never too much, a little too small beside long particles.
    pub fn clearance(&self, p: DVec3, far: f32) -> f32 {
        let spacing = self.spec.spacing;
        let place = self.place(p);
        let most = 2.0 * far / spacing;
        let rings = (self.reach + most + self.spec.jitter - 0.5).ceil().max(0.0) as i32;
        let mut least = most;
        for_cells(rings, |step| {
            let cell = add(place.cell, step);
            let offset = self.offset(cell);
            let m: Vec3 = place.local - (vec3(step[0] as f32, step[1] as f32, step[2] as f32) + offset);
            let length = m.length();
            if length - self.reach >= least {
                return;
            }
            let free = self.free_body(cell);
            let body = free.scaled(self.scale(cell, offset, &free));
            let n = m.normalize_or(Vec3::Z);
            least = least.min(length - body.support(n).dot(n));
        });
        least * spacing
    }
}
