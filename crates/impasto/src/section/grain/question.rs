//! What is asked of a filling, apart from the place.

use super::eval::{Candidate, Hit, Look, Side};
use crate::math::{DMat3, DVec3};
use crate::section::CutSurface;

/// A knife, what is looked at, and what may be there.
#[derive(Clone, Copy)]
pub(super) struct Question<'a> {
    pub(super) surface: &'a dyn CutSurface,
    pub(super) look: Look,
    /// How deep below the skin a point lies, model units.
    pub(super) depth: &'a dyn Fn(DVec3) -> f32,
    /// Particles that may be there.
    pub(super) keep: &'a dyn Fn(&Candidate) -> bool,
}

impl Question<'_> {
    /// Unit normal of the section, out of the half that is looked at.
    pub(super) fn outward(&self, p: DVec3) -> DVec3 {
        let n = self.surface.normal(p);
        if self.look.side == Side::Below { n } else { -n }
    }

    /// Flat matrix.
    pub(super) fn plain(&self, p: DVec3) -> Hit {
        Hit::matrix(self.outward(p).as_vec3(), 0.0)
    }
}

/// A filling's own space, turned and moved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    /// A rotation.
    pub(super) own_from_model: DMat3,
    /// Where the model's origin comes to lie, own space.
    pub(super) origin: DVec3,
}

impl Turn {
    pub(super) fn point(&self, p: DVec3) -> DVec3 {
        self.own_from_model * p + self.origin
    }

    fn back(&self, p: DVec3) -> DVec3 {
        self.own_from_model.transpose() * (p - self.origin)
    }

    /// What `answer` says to the same question in the own space, in model space.
    pub(super) fn ask(&self, p: DVec3, question: &Question, answer: impl Fn(DVec3, &Question) -> Hit) -> Hit {
        let surface = Turned { turn: self, surface: question.surface };
        let depth = |x: DVec3| (question.depth)(self.back(x));
        let keep = |c: &Candidate| (question.keep)(&Candidate { center: self.back(c.center), ..*c });
        let own = Question { surface: &surface, look: question.look, depth: &depth, keep: &keep };
        let hit = answer(self.point(p), &own);
        Hit { normal: (self.own_from_model.transpose() * hit.normal.as_dvec3()).as_vec3(), ..hit }
    }
}

/// A cut as it is seen in a turned space.
struct Turned<'a> {
    turn: &'a Turn,
    surface: &'a dyn CutSurface,
}

impl CutSurface for Turned<'_> {
    fn distance(&self, p: DVec3) -> f64 {
        self.surface.distance(self.turn.back(p))
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        self.turn.own_from_model * self.surface.normal(self.turn.back(p))
    }
}
