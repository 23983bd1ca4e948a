//! Wood: growth rings about a bent pith, with rays, vessels and knots.
//!
//! The time at which a place grew is its distance from the pith, made uneven by noise; branches have a time of their own
//! that runs fast along and slowly across them, and a smooth minimum joins the two (Larsson, Ijiri, Yoshida, Huber, Guo,
//! Andersson and Toler-Franklin, "Procedural Texturing of Solid Wood with Knots", 2022). The tone is that of the season:
//! a slow rise from early to late wood and a sharp end. All with exact gradients, so that planed wood may have relief.
//!
//! Cut solid, late wood stands a little higher and vessels are open; torn, wood parts into splinters along its axis.

use super::check::{positive, within};
use super::eval::{Candidate, Hit, HitKind, Look, SectionKind};
use super::mottle::clamp01;
use super::question::Question;
use super::spec::parameter;
use super::{Fibres, FibresSpec};
use crate::Result;
use crate::math::{DMat3, DVec3, Vec3, atan2, exact, floor, hash, hash_cell, pow, unit_float, vec2, vec3};
use crate::noise::{Lattice, fbm_3d, gradient_2d, gradient_3d};

/// Wood as a person describes it. Where nothing else is said, lengths are in mean ring widths.
#[derive(Clone, Debug, PartialEq)]
pub struct RingsSpec {
    /// Mean width of a ring, model units.
    pub spacing: f32,
    /// A point of the pith, model space.
    pub pith: Vec3,
    /// Along the trunk, model space.
    pub axis: Vec3,
    /// How far the pith wanders.
    pub bend: f32,
    /// How far rings leave the circle.
    pub waviness: f32,
    /// How much ring widths differ: 0 to 1.
    pub width_spread: f32,
    /// How late and steep the rise to late wood is: 1 even, 6 steep.
    pub lateness: f32,
    /// How much higher late wood stands in a solid cut.
    pub relief: f32,
    /// How strong streaks along the fibres are: 0 to 1.
    pub streaks: f32,
    /// How bright rays are: 0 to 1.
    pub rays: f32,
    /// Its vessels.
    pub pores: Option<Pores>,
    /// Its branches.
    pub knots: Option<Knots>,
    /// Width of splinters in a tear.
    pub splinters: f32,
    /// Another seed, another tree.
    pub seed: u32,
}

/// Vessels: small round holes along the fibres. Lengths in mean ring widths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pores {
    /// Between neighbouring vessels.
    pub spacing: f32,
    /// Their radius.
    pub radius: f32,
    /// From wall to wall of one.
    pub length: f32,
    /// The part of a year in which they grow: 0.3 is ring-porous as oak, 1 diffuse-porous as beech.
    pub until: f32,
}

/// Branches. Lengths in mean ring widths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knots {
    /// Along the trunk from one to the next.
    pub distance: f32,
    /// How thick branches are against the trunk: 0.05 to 0.6.
    pub thickness: f32,
    /// How steeply they rise, radians from the level.
    pub rise: f32,
}

impl RingsSpec {
    /// Wood with the usual irregularity, vessels of a ring-porous tree and no knots.
    pub fn of(spacing: f32, axis: Vec3) -> Self {
        Self {
            spacing,
            pith: Vec3::ZERO,
            axis,
            bend: 2.0,
            waviness: 0.8,
            width_spread: 0.6,
            lateness: 2.5,
            relief: 0.08,
            streaks: 0.25,
            rays: 0.3,
            pores: Some(Pores { spacing: 0.24, radius: 0.075, length: 3.0, until: 0.35 }),
            knots: None,
            splinters: 0.5,
            seed: 0,
        }
    }
}

/// Checked wood, ready to be asked.
#[derive(Clone, Debug)]
pub struct Rings {
    spec: RingsSpec,
    model_from_trunk: DMat3,
    pores: Option<Fibres>,
    splinters: Fibres,
}

/// When a place grew.
#[derive(Clone, Copy)]
struct Grown {
    /// Years; the gradient by trunk coordinates.
    years: f32,
    gradient: Vec3,
    /// How far it belongs to a branch: 0 to 1.
    knot: f32,
    /// The place seen from the pith at its height, trunk axes, ring widths.
    at: Vec3,
}

/// A ring's season.
#[derive(Clone, Copy)]
struct Season {
    /// The part of the year.
    part: f32,
    /// 0 early, 1 late wood, and its change in a year.
    late: f32,
    change: f32,
}

/// The part of a ring in which late wood ends.
const END: f32 = 0.06;
/// The pith wanders within so many ring widths, and waves are as long.
const WAVE_LENGTH: f32 = 9.0;

impl Rings {
    /// Wood from its description.
    ///
    /// # Errors
    /// A number that makes no sense.
    pub fn new(spec: RingsSpec) -> Result<Self> {
        positive("spacing", spec.spacing)?;
        positive("splinters", spec.splinters)?;
        within("bend", spec.bend, 0.0..=50.0, "from 0 to 50 rings")?;
        within("waviness", spec.waviness, 0.0..=5.0, "from 0 to 5 rings")?;
        within("width spread", spec.width_spread, 0.0..=1.0, "from 0 to 1")?;
        within("lateness", spec.lateness, 0.2..=12.0, "from 0.2 to 12")?;
        within("relief", spec.relief, 0.0..=1.0, "from 0 to 1 ring")?;
        within("streaks", spec.streaks, 0.0..=1.0, "from 0 to 1")?;
        within("rays", spec.rays, 0.0..=1.0, "from 0 to 1")?;
        let axis = spec.axis.as_dvec3();
        if !(axis.is_finite() && axis.length() > 1e-30 && spec.pith.is_finite()) {
            let given = format!("{},{},{}", spec.axis.x, spec.axis.y, spec.axis.z);
            return Err(parameter(
                "axis",
                given,
                "it needs three finite numbers that are not all zero, as the pith does",
            ));
        }
        if let Some(knots) = spec.knots {
            positive("knot distance", knots.distance)?;
            within("knot thickness", knots.thickness, 0.05..=0.6, "from 0.05 to 0.6 of the trunk")?;
            within("knot rise", knots.rise, -1.2..=1.2, "from -1.2 to 1.2 radians")?;
        }
        let fibres = |spacing: f32, radius: f32, length: f32, spread: f32, seed: u32| {
            let per = spec.spacing;
            let of = FibresSpec::of(spacing * per, radius * per, spec.axis);
            let seed = spec.seed.wrapping_add(seed);
            Fibres::new(FibresSpec {
                length: length * per,
                jitter: 0.35,
                size_spread: spread,
                rounding: 0.9,
                seed,
                ..of
            })
        };
        let pores = match spec.pores {
            None => None,
            Some(p) => {
                within("vessels' part of a year", p.until, 0.0..=1.0, "from 0 to 1")?;
                Some(fibres(p.spacing, p.radius, p.length, 0.4, 1)?)
            }
        };
        let splinters = fibres(spec.splinters, spec.splinters * 0.75, spec.splinters * 14.0, 0.5, 2)?;
        let plane = crate::section::Plane { normal: axis.normalize(), offset: 0.0 };
        let [u, v] = plane.axes();
        Ok(Self { model_from_trunk: DMat3::from_cols(u, v, plane.normal), spec, pores, splinters })
    }

    pub(super) fn answer(&self, p: DVec3, question: &Question) -> Hit {
        match question.look.kind {
            SectionKind::Tear => self.torn(p, question),
            kind => self.planed(p, question, kind),
        }
    }

    fn torn(&self, p: DVec3, question: &Question) -> Hit {
        let hit = self.splinters.eval_where(p, &question.surface, question.look, question.keep);
        let at = p + question.outward(p) * hit.height as f64;
        Hit { tone: self.tone(&self.grown(at)), leaf: 0, ..hit }
    }

    fn planed(&self, p: DVec3, question: &Question, kind: SectionKind) -> Hit {
        let grown = self.grown(p);
        let tone = self.tone(&grown);
        let n = question.outward(p).as_vec3();
        if let (Some(pores), Some(spec)) = (&self.pores, self.spec.pores) {
            let keep = |c: &Candidate| {
                let there = self.grown(c.center);
                (question.keep)(c) && there.knot < 0.3 && self.season(there.years).part < spec.until
            };
            let look = Look { kind: SectionKind::Hollow, ..question.look };
            let hit = pores.eval_where(p, &question.surface, look, keep);
            if hit.kind == HitKind::Cavity {
                return Hit { leaf: 1, tone, ..hit };
            }
        }
        if kind == SectionKind::Hollow {
            return Hit { tone, ..Hit::matrix(n, 0.0) };
        }
        let season = self.season(grown.years);
        let relief = self.spec.relief;
        let slope = (self.model_from_trunk * (grown.gradient * (relief * season.change)).as_dvec3()).as_vec3();
        let normal = (n - (slope - n * slope.dot(n))).normalize_or(n);
        let height = relief * (season.late - 1.0) * self.spec.spacing;
        Hit { tone, normal, height, openness: 0.5 + 0.5 * normal.dot(n), ..Hit::matrix(n, 0.0) }
    }

    /// When a place grew: years from the pith.
    fn grown(&self, p: DVec3) -> Grown {
        let spec = &self.spec;
        let x = (self.model_from_trunk.transpose() * (p - spec.pith.as_dvec3()) / spec.spacing as f64).as_vec3();
        let lattice = |k: u32| Lattice::seeded(spec.seed.wrapping_mul(16).wrapping_add(k));
        let slow = 1.0 / (4.0 * WAVE_LENGTH);
        let wander = |k: u32, y: f32| gradient_2d(vec2(x.z * slow + 0.5, y), lattice(k));
        let (bx, by) = (wander(0, 0.31), wander(1, 0.67));
        let at = vec3(x.x - spec.bend * bx.value, x.y - spec.bend * by.value, x.z);
        let lean = vec2(bx.gradient.x, by.gradient.x) * (spec.bend * slow);
        let r = (at.x * at.x + at.y * at.y).sqrt();
        let out = if r > 1e-6 { vec3(at.x / r, at.y / r, 0.0) } else { Vec3::ZERO };
        // Waves of the rings, four times as long along the trunk; none at the pith.
        let scale = vec3(1.0, 1.0, 0.25) / WAVE_LENGTH;
        let wave = fbm_3d(at * scale + Vec3::splat(0.37), 2, 0.5, lattice(2));
        let share = r / (r + 3.0);
        let mut years = r + spec.waviness * wave.value * share;
        let mut gradient =
            out + (wave.gradient * scale * share + out * (wave.value * 3.0 / ((r + 3.0) * (r + 3.0)))) * spec.waviness;
        let mut knot = 0.0;
        if let Some(knots) = spec.knots {
            (years, gradient, knot) = self.with_branches(&knots, at, years, gradient);
        }
        // Good years and bad ones; never backwards, as the noise's slope is below 2.8.
        const PACE: f32 = 0.43;
        let pace = gradient_2d(vec2(years * PACE, 0.53), lattice(3));
        years += spec.width_spread * 0.8 * pace.value;
        gradient *= 1.0 + spec.width_spread * 0.8 * PACE * pace.gradient.x;
        gradient.z -= gradient.x * lean.x + gradient.y * lean.y;
        Grown { years, gradient, knot, at }
    }

    /// The trunk's time and those of the branches near a height, smoothly joined.
    fn with_branches(&self, knots: &Knots, at: Vec3, years: f32, gradient: Vec3) -> (f32, Vec3, f32) {
        // A tip grows four times as fast as the trunk's radius.
        const TIP: f32 = 0.25;
        const JOIN: f32 = 1.5;
        let (mut joined, mut slope, mut knot) = (years, gradient, 0.0);
        let here = floor(at.z / knots.distance);
        // A branch may pass two of its neighbours' heights.
        for k in -2..=2 {
            let place = here + k as f32;
            let name = hash_cell(place as i32, 0, 0, self.spec.seed ^ 0x6b6e_6f74);
            let draw = |k: u32| unit_float(hash(name.wrapping_add(k)));
            let start = vec3(0.0, 0.0, (place + 0.2 + 0.6 * draw(1)) * knots.distance);
            let rise = (knots.rise + 0.5 * (draw(2) - 0.5)) as f64;
            let turn = draw(3) as f64 * std::f64::consts::TAU;
            let (flat, up) = (exact::cos(rise), exact::sin(rise));
            let along = vec3((flat * exact::cos(turn)) as f32, (flat * exact::sin(turn)) as f32, up as f32);
            let rate = knots.thickness * (0.7 + 0.6 * draw(4));
            let m = at - start;
            let l = m.dot(along).max(0.0);
            let across = m - along * l;
            let d = across.length();
            let own = TIP * l + d / rate;
            let own_slope = along * if l > 0.0 { TIP } else { 0.0 } + across.normalize_or_zero() / rate;
            let share = clamp01(0.5 + 0.5 * (own - joined) / JOIN);
            joined = own + (joined - own) * share - JOIN * share * (1.0 - share);
            slope = slope * share + own_slope * (1.0 - share);
            knot = knot * share + (1.0 - share);
        }
        (joined, slope, knot)
    }

    fn season(&self, years: f32) -> Season {
        let year = floor(years);
        let part = years - year;
        let draw = unit_float(hash_cell(year as i32, 1, 0, self.spec.seed));
        // Some years have little late wood.
        let strength = 0.6 + 0.4 * draw;
        let e = self.spec.lateness;
        let (late, change) = if part < 1.0 - END {
            let t = part / (1.0 - END);
            let before = pow(t, e - 1.0);
            (if e > 1.0 { before * t } else { pow(t, e) }, e * before / (1.0 - END))
        } else {
            let t = (part - (1.0 - END)) / END;
            (1.0 - t * t * (3.0 - 2.0 * t), -6.0 * t * (1.0 - t) / END)
        };
        Season { part, late: late * strength, change: change * strength }
    }

    /// The colour's place between early and late wood.
    fn tone(&self, grown: &Grown) -> f32 {
        let spec = &self.spec;
        let late = self.season(grown.years).late;
        let fine = grown.at * vec3(5.0, 5.0, 0.18);
        let streak = gradient_3d(fine, Lattice::seeded(spec.seed.wrapping_add(77))).value
            + 0.6 * gradient_3d(grown.at * vec3(0.7, 0.7, 0.02), Lattice::seeded(spec.seed.wrapping_add(78))).value;
        let wood = 0.1 + 0.75 * late + 0.2 * spec.streaks * streak;
        let wood = wood * (1.0 - spec.rays * self.ray(grown));
        // Branches are denser and darker.
        clamp01(wood + grown.knot * (0.5 - 0.35 * wood))
    }

    /// How much of a ray is at a place: 0 to 1. Rays are lenses that stand on edge, thin around the trunk, long along its
    /// radius; one in each cell of a polar lattice that doubles its spokes as it goes out.
    fn ray(&self, grown: &Grown) -> f32 {
        if self.spec.rays <= 0.0 {
            return 0.0;
        }
        let at = grown.at;
        let r = (at.x * at.x + at.y * at.y).sqrt();
        let (mut n_spokes, mut outer, mut shell) = (48.0f32, 4.0f32, 0);
        while r > outer && shell < 12 {
            (n_spokes, outer, shell) = (n_spokes * 2.0, outer * 2.0, shell + 1);
        }
        const LONG: f32 = 5.0;
        const TALL: f32 = 2.2;
        let turn = (atan2(at.y, at.x) / std::f32::consts::TAU + 0.5) * n_spokes;
        let spoke = floor(turn);
        let draw = |a: i32, b: i32, k: u32| {
            let name = hash_cell(spoke as i32, a, b, self.spec.seed.wrapping_add(shell));
            unit_float(hash(name.wrapping_add(k)))
        };
        let radial = r / LONG + draw(0, 0, 1);
        let a = floor(radial) as i32;
        let axial = at.z / TALL + draw(a, 0, 2);
        let b = floor(axial) as i32;
        let middle = |x: f32| 2.0 * (x - floor(x)) - 1.0;
        let half = 0.035 + 0.09 * draw(a, b, 3);
        let side = (turn - spoke - 0.5 - 0.6 * (draw(a, b, 4) - 0.5)) * std::f32::consts::TAU * r / n_spokes / half;
        let lens = 1.0 - side * side - middle(radial) * middle(radial) - middle(axial) * middle(axial);
        clamp01(2.5 * lens)
    }
}
