//! A hollow whose wall is lined with crystals: a geode.
//!
//! The hollow begins at a depth below the skin. On its wall stand six-sided prisms with pointed tips, one on each node of a
//! perturbed lattice that lies near the wall, towards the middle and a little askew. A cut shows them flat where it goes
//! through them, and behind the hollow it shows the far wall: a ray goes down by the distance that is free for certain
//! (Hart, "Sphere Tracing", 1996). It has no pieces: all kinds of sections show the same.

use super::chance::Source;
use super::check::{positive, within};
use super::eval::{Hit, HitKind};
use super::lattice_rotation;
use super::mottle::clamp01;
use super::particle::{add, for_cells};
use super::place_of;
use super::question::Question;
use super::spec::{Chance, LatticeAxes};
use crate::Result;
use crate::math::{DMat3, DVec3, Frame, Vec3, sin_cos, vec3};

/// A hollow as a person describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct DruseSpec {
    /// Between neighbouring crystals, model units.
    pub spacing: f32,
    /// Depth below the skin of the wall they stand on, model units.
    pub wall: f32,
    /// How far the longest stand out, in spacings: 0.1 to 1.1.
    pub length: f32,
    /// Radius of the prisms, in spacings.
    pub radius: f32,
    /// How far they lean: 0 is straight to the middle.
    pub lean: f32,
    /// Rays end at this depth below the section, model units.
    pub deepest: f32,
    /// Another seed, other crystals.
    pub seed: u32,
}

impl DruseSpec {
    /// Quartz with the usual irregularity, below a wall of this depth.
    pub fn of(spacing: f32, wall: f32) -> Self {
        Self { spacing, wall, length: 0.95, radius: 0.5, lean: 0.35, deepest: 40.0 * spacing, seed: 0 }
    }
}

/// A checked hollow, ready to be asked.
#[derive(Clone, Debug)]
pub struct Druse {
    spec: DruseSpec,
    source: Source,
    lattice_from_model: DMat3,
}

/// What is nearest at a place: all in spacings.
#[derive(Clone, Copy)]
struct Near {
    /// To the surface, negative inside a crystal or the wall.
    distance: f32,
    /// Unit, out of the solid, lattice axes.
    normal: Vec3,
    /// The crystal; `MATRIX` for the wall between them.
    crystal: u32,
    /// How high above the wall.
    rise: f32,
}

/// The wall near a place, taken as flat: lattice axes, spacings.
#[derive(Clone, Copy)]
struct Wall {
    /// The place where it was measured.
    at: DVec3,
    /// How far that is beyond the wall, in the hollow; negative behind it.
    height: f32,
    /// Unit vector into the hollow.
    inwards: Vec3,
}

/// How steep a tip's faces are: quartz has 52 degrees from the level.
const TIP: f32 = 1.27;
/// Depths with waves are no true distances; steps are that much shorter.
const CAUTION: f32 = 0.75;

impl Druse {
    /// A hollow from its description.
    ///
    /// # Errors
    /// A number that makes no sense.
    pub fn new(spec: DruseSpec) -> Result<Self> {
        positive("spacing", spec.spacing)?;
        within("wall", spec.wall, 0.0..=f32::MAX, "it is a depth, zero or above")?;
        within("crystal length", spec.length, 0.1..=1.1, "from 0.1 to 1.1 spacings")?;
        within("crystal radius", spec.radius, 0.1..=0.8, "from 0.1 to 0.8 spacings")?;
        within("lean", spec.lean, 0.0..=1.0, "from 0 to 1")?;
        positive("deepest", spec.deepest)?;
        let turn = lattice_rotation(LatticeAxes::Turned);
        let lattice_from_model = turn.transpose() * (1.0 / spec.spacing as f64);
        Ok(Self { source: Source { chance: Chance::Hash, seed: spec.seed }, lattice_from_model, spec })
    }

    pub(super) fn answer(&self, p: DVec3, question: &Question) -> Hit {
        let n = question.outward(p);
        let outward = n.as_vec3();
        let per = 1.0 / self.spec.spacing;
        let height = ((question.depth)(p) - self.spec.wall) * per;
        let tone = |rise: f32| clamp01((rise + 1.0) / (1.0 + self.spec.length));
        if height < -1.5 {
            return Hit { tone: 0.0, kind: HitKind::Disc, ..Hit::matrix(outward, 0.0) };
        }
        if height < self.reach() {
            let near = self.near(p, &self.wall(p, height, question));
            if near.distance <= 0.0 {
                let kind = HitKind::Disc;
                return Hit { tone: tone(near.rise), kind, particle: near.crystal, ..Hit::matrix(outward, 0.0) };
            }
        }
        let Some((way, near)) = self.far_wall(p, n, height, question) else {
            let kind = HitKind::Cavity;
            return Hit { tone: 1.0, kind, openness: 0.1, ..Hit::matrix(outward, -self.spec.deepest) };
        };
        let normal = (self.lattice_from_model.transpose() * near.normal.as_dvec3()).as_vec3().normalize_or(outward);
        // The opening is about as wide as the place is far from the wall; between crystals it is darker than on their tips.
        let wide = height.max(1.0) * 1.5;
        let deep = way * per;
        let open = wide * wide / (wide * wide + deep * deep);
        let between = 0.35 + 0.65 * clamp01(near.rise / self.spec.length);
        let openness = open * between * clamp01(0.5 + 0.5 * normal.dot(outward));
        let (kind, particle) = (HitKind::Cavity, near.crystal);
        Hit { height: -way, normal, kind, particle, openness, leaf: 0, tone: tone(near.rise) }
    }

    /// No crystal's tip is farther from the wall than this, spacings.
    fn reach(&self) -> f32 {
        self.spec.length + 0.5
    }

    /// Down through the hollow, which the place is in: way in model units.
    fn far_wall(&self, p: DVec3, n: DVec3, height: f32, question: &Question) -> Option<(f32, Near)> {
        let spacing = self.spec.spacing;
        let (mut way, mut height, mut wall) = (0.0f32, height, None);
        for _ in 0..64 {
            let at = p - n * way as f64;
            let free = match &wall {
                None if height > self.reach() + 0.1 => height - self.reach(),
                None => {
                    wall = Some(self.wall(at, height, question));
                    continue;
                }
                Some(flat) => {
                    let near = self.near(at, flat);
                    if near.distance < 2e-3 {
                        return Some(self.touched(p, n, way, question));
                    }
                    // Away from this wall the next one counts: it is measured anew.
                    let left = self.above(flat, self.lattice_from_model * at);
                    if left > self.reach() + 1.0 {
                        wall = None;
                        height = ((question.depth)(at) - self.spec.wall) / spacing;
                        continue;
                    }
                    near.distance
                }
            };
            way += free.max(2e-3) * CAUTION * spacing;
            if way > self.spec.deepest {
                return None;
            }
            if wall.is_none() {
                height = ((question.depth)(p - n * way as f64) - self.spec.wall) / spacing;
            }
        }
        None
    }

    /// The surface near a place of a ray: from the wall as it is there, so that neighbouring rays agree; facets are flat.
    fn touched(&self, p: DVec3, n: DVec3, way: f32, question: &Question) -> (f32, Near) {
        let spacing = self.spec.spacing;
        let at = p - n * way as f64;
        let wall = self.wall(at, ((question.depth)(at) - self.spec.wall) / spacing, question);
        let along = (self.lattice_from_model * n).normalize_or(DVec3::Z).as_vec3();
        let (mut way, mut near) = (way, self.near(at, &wall));
        for _ in 0..3 {
            // Facets seen at a grazing angle are left where they are.
            way += near.distance * spacing / near.normal.dot(along).max(0.2);
            way = way.max(0.0);
            near = self.near(p - n * way as f64, &wall);
        }
        (way, near)
    }

    /// The wall as it is seen from a place.
    fn wall(&self, p: DVec3, height: f32, question: &Question) -> Wall {
        let step = 0.1 * self.spec.spacing as f64;
        let slope = |axis: DVec3| ((question.depth)(p + axis * step) - (question.depth)(p - axis * step)) as f64;
        let g = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
        let inwards = (self.lattice_from_model * g).normalize_or(DVec3::Z).as_vec3();
        Wall { at: self.lattice_from_model * p, height, inwards }
    }

    /// How far a place of the lattice is above the wall.
    fn above(&self, wall: &Wall, x: DVec3) -> f32 {
        wall.height + wall.inwards.dot((x - wall.at).as_vec3())
    }

    /// The nearest of the wall and its crystals.
    fn near(&self, p: DVec3, wall: &Wall) -> Near {
        let x = self.lattice_from_model * p;
        let (node, local) = place_of(x);
        let rise = self.above(wall, x);
        let mut best = Near { distance: rise, normal: wall.inwards, crystal: Hit::MATRIX, rise };
        // Behind the wall crystals still part the solid into columns.
        let mut column = f32::INFINITY;
        for_cells(1, |step| {
            let cell = add(node, step);
            let center = vec3(step[0] as f32, step[1] as f32, step[2] as f32) + self.source.center(cell) * 0.35;
            let m = local - center;
            // How far its foot is from the wall.
            let foot = rise - wall.inwards.dot(m);
            let share = 1.0 - (foot / 0.65) * (foot / 0.65);
            if share <= 0.0 {
                return;
            }
            let even = self.source.even(cell);
            let sizes = self.source.sizes(cell);
            let axis = (wall.inwards + self.source.tilt(cell) * self.spec.lean).normalize_or(wall.inwards);
            let length = self.spec.length * (0.75 + 0.25 * sizes[0]) * share - foot;
            let radius = self.spec.radius * (0.8 + 0.2 * sizes[1]);
            let frame = Frame::about(axis);
            let (l, across) = (m.dot(axis), m - axis * m.dot(axis));
            // The nearest of six sides.
            let (mut side, mut out) = (f32::NEG_INFINITY, Vec3::ZERO);
            for k in 0..3 {
                let (s, c) = sin_cos((even[0] + k as f32) * std::f32::consts::FRAC_PI_3);
                let e = frame.tangent * c + frame.bitangent * s;
                let d = across.dot(e);
                if d.abs() > side {
                    (side, out) = (d.abs(), if d < 0.0 { -e } else { e });
                }
            }
            let prism = side - radius;
            let tip = (l + TIP * side - length) / (1.0 + TIP * TIP).sqrt();
            let (distance, normal) =
                if prism > tip { (prism, out) } else { (tip, (axis + out * TIP).normalize_or(axis)) };
            if distance < best.distance {
                best = Near { distance, normal, crystal: self.source.id(cell), rise };
            }
            if best.distance < 0.0 && prism < column {
                (column, best.crystal) = (prism, self.source.id(cell));
            }
        });
        best
    }
}
