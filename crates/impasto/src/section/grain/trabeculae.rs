//! Walls or a network without end: spongy bone, the skeleton of a sponge, coral.
//!
//! A level set of a random smooth field, the sum of cosine waves in all directions (Cahn, "Phase Separation by Spinodal
//! Decomposition in Isotropic Systems", 1965), or of the gyroid (Schoen 1970), stretched along a load. It has no pieces: the
//! hollow cut looks into the void between the walls, the solid one has the void filled; torn, it is hollow.

use super::check::{positive, within};
use super::eval::{Hit, HitKind, SectionKind};
use super::mottle::clamp01;
use super::question::Question;
use super::spec::parameter;
use crate::Result;
use crate::math::{DMat3, DVec3, Vec3, exact, hash, sin_cos, unit_float, vec3};

/// Which field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Field {
    /// Random waves.
    #[default]
    Waves,
    /// The gyroid: regular.
    Gyroid,
}

/// What of the field is solid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Skeleton {
    /// Where it is nearly zero: walls that part two voids.
    #[default]
    Walls,
    /// Where it is high: beams and plates in one void.
    Network,
}

/// A skeleton as a person describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrabeculaeSpec {
    /// Width of a void and its wall, model units: half a wavelength across the load.
    pub spacing: f32,
    /// Which field.
    pub field: Field,
    /// What of it is solid.
    pub skeleton: Skeleton,
    /// Which part of the volume is solid at the skin, and in the middle.
    pub solid: [f32; 2],
    /// At this depth the middle's share is reached, model units.
    pub until: f32,
    /// Where the load comes from, model space.
    pub load: Vec3,
    /// How much longer voids are along the load.
    pub stretch: f32,
    /// No void is seen deeper than this, in spacings.
    pub deepest: f32,
    /// Depth and width of a solid cut's bevel, in spacings.
    pub bevel: f32,
    /// Another seed, another skeleton.
    pub seed: u32,
}

impl TrabeculaeSpec {
    /// Walls of random waves that fill a fifth of the volume.
    pub fn of(spacing: f32) -> Self {
        Self {
            spacing,
            field: Field::Waves,
            skeleton: Skeleton::Walls,
            solid: [0.2; 2],
            until: 1.0,
            load: Vec3::Y,
            stretch: 1.4,
            deepest: 3.0,
            bevel: 0.1,
            seed: 0,
        }
    }
}

/// Waves in the sum: a multiple of what a vector unit holds.
const N_WAVES: usize = 32;

/// A checked skeleton, ready to be asked.
#[derive(Clone, Debug)]
pub struct Trabeculae {
    spec: TrabeculaeSpec,
    /// To the space of the waves, in radians of a wave of mean length.
    field_from_model: DMat3,
    waves: Box<Waves>,
    /// Thresholds for solid shares of 0, 1/32 ... 1.
    thresholds: Vec<f32>,
}

#[derive(Clone, Debug)]
struct Waves {
    /// Wave vectors.
    k: [[f32; N_WAVES]; 3],
    phase: [f32; N_WAVES],
}

/// Steps of a ray through the void: three to a spacing find all walls but the thinnest edges.
const STEPS_PER_SPACING: f32 = 6.0;

/// Samples from which thresholds are read; their error is 0.01 of the volume.
const N_SAMPLES: usize = 4096;

impl Trabeculae {
    /// A skeleton from its description.
    ///
    /// # Errors
    /// A number that makes no sense.
    pub fn new(spec: TrabeculaeSpec) -> Result<Self> {
        positive("spacing", spec.spacing)?;
        positive("depth of the middle", spec.until)?;
        for share in spec.solid {
            within("solid share", share, 0.01..=0.99, "from 0.01 to 0.99 of the volume")?;
        }
        within("stretch", spec.stretch, 0.1..=10.0, "from 0.1 to 10")?;
        within("deepest void", spec.deepest, 0.1..=8.0, "from 0.1 to 8 spacings")?;
        within("bevel", spec.bevel, 0.0..=0.5, "from 0 to 0.5 spacings")?;
        let load = spec.load.as_dvec3();
        if !load.is_finite() || load.length() < 1e-30 {
            let given = format!("{},{},{}", spec.load.x, spec.load.y, spec.load.z);
            return Err(parameter("load", given, "it needs three finite numbers that are not all zero"));
        }
        let plane = crate::section::Plane { normal: load.normalize(), offset: 0.0 };
        let [u, v] = plane.axes();
        let per = std::f64::consts::PI / spec.spacing as f64;
        let turn = DMat3::from_cols(u, v, plane.normal).transpose();
        let scale = DMat3::from_diagonal(DVec3::new(per, per, per / spec.stretch as f64));
        // The gyroid's own axes are turned away from the load's, where sections would be too regular.
        let field_from_model = super::turned() * scale * turn;
        let waves = Box::new(Waves::drawn(spec.seed));
        let mut made = Self { spec, field_from_model, waves, thresholds: Vec::new() };
        made.thresholds = made.measured_thresholds();
        Ok(made)
    }

    /// What it was made from.
    pub fn spec(&self) -> &TrabeculaeSpec {
        &self.spec
    }

    /// Above which value of `height` a place is solid, by the share that is to be.
    fn measured_thresholds(&self) -> Vec<f32> {
        let mut values: Vec<f32> = (0..N_SAMPLES)
            .map(|i| {
                let r = |k: u32| unit_float(hash((i as u32).wrapping_mul(3).wrapping_add(k))) * 400.0;
                self.height(self.value(vec3(r(0), r(1), r(2))).0)
            })
            .collect();
        values.sort_by(f32::total_cmp);
        (0..=32).map(|k| values[(N_SAMPLES - 1) * (32 - k) / 32]).collect()
    }

    /// What is compared to the threshold.
    fn height(&self, value: f32) -> f32 {
        if self.spec.skeleton == Skeleton::Walls { -value.abs() } else { value }
    }

    fn threshold(&self, depth: f32) -> f32 {
        let [skin, middle] = self.spec.solid;
        let share = skin + (middle - skin) * clamp01(depth / self.spec.until);
        let at = share * 32.0;
        let k = (at as usize).min(31);
        self.thresholds[k] + (self.thresholds[k + 1] - self.thresholds[k]) * (at - k as f32)
    }

    /// The field and its gradient, field space.
    fn value(&self, x: Vec3) -> (f32, Vec3) {
        match self.spec.field {
            Field::Waves => self.waves.value(x),
            Field::Gyroid => {
                let [(sx, cx), (sy, cy), (sz, cz)] = [sin_cos(x.x), sin_cos(x.y), sin_cos(x.z)];
                let slope = vec3(cx * cy - sz * sx, cy * cz - sx * sy, cz * cx - sy * sz);
                (sx * cy + sy * cz + sz * cx, slope)
            }
        }
    }

    /// How far inside the solid a place is, in the field's units (negative in the void), and the gradient.
    fn inside(&self, x: Vec3, threshold: f32) -> (f32, Vec3) {
        let (value, gradient) = self.value(x);
        let sign = if self.spec.skeleton == Skeleton::Walls && value > 0.0 { -1.0 } else { 1.0 };
        (self.height(value) - threshold, gradient * sign)
    }

    pub(super) fn answer(&self, p: DVec3, question: &Question) -> Hit {
        let n = question.outward(p);
        let normal = n.as_vec3();
        let x = (self.field_from_model * p).as_vec3();
        let threshold = self.threshold((question.depth)(p));
        let (inside, gradient) = self.inside(x, threshold);
        if inside >= 0.0 {
            return Hit { kind: HitKind::Disc, particle: 1, ..Hit::matrix(normal, 0.0) };
        }
        let gradient = (self.field_from_model.transpose() * gradient.as_dvec3()).as_vec3();
        if question.look.kind == SectionKind::Solid {
            return self.filled(inside, gradient, normal);
        }
        self.void(x, n, threshold)
    }

    /// A void that is filled: flat, with a bevel up to the walls.
    fn filled(&self, inside: f32, gradient: Vec3, n: Vec3) -> Hit {
        let t = self.spec.bevel * self.spec.spacing;
        let slope = gradient - n * gradient.dot(n);
        let steep = slope.length();
        let gap = if steep > 1e-6 { -inside / steep } else { f32::INFINITY };
        if gap < t {
            let normal = (n - slope / steep).normalize_or(n);
            let kind = HitKind::Bevel;
            return Hit { height: -gap, normal, kind, openness: 0.5 + 0.5 * normal.dot(n), ..Hit::matrix(n, 0.0) };
        }
        Hit { leaf: 1, ..Hit::matrix(n, -t) }
    }

    /// Down to the next wall.
    fn void(&self, x: Vec3, n: DVec3, threshold: f32) -> Hit {
        let spacing = self.spec.spacing;
        let along = (self.field_from_model * -n).as_vec3();
        let n_steps = (self.spec.deepest * STEPS_PER_SPACING).ceil();
        let step = self.spec.deepest * spacing / n_steps;
        let at = |way: f32| self.inside(x + along * way, threshold).0;
        let outward = n.as_vec3();
        let found = match self.spec.field {
            Field::Waves => self.waves.march(x, along * step, n_steps as usize, |f| self.height(f) >= threshold),
            Field::Gyroid => (1..=n_steps as usize).find(|&k| at(step * k as f32) >= 0.0),
        };
        let Some(k) = found else {
            let height = -self.spec.deepest * spacing;
            return Hit {
                kind: HitKind::Cavity,
                leaf: 1,
                openness: self.openness(-height, 1.0),
                ..Hit::matrix(outward, height)
            };
        };
        // The wall is between two steps: false position with the smaller side kept alive (Dowell and Jarratt 1971).
        let (mut low, mut high) = (step * (k - 1) as f32, step * k as f32);
        let (mut below, mut above) = (at(low), at(high));
        for _ in 0..4 {
            let share = below / (below - above);
            let middle = low + (high - low) * if share > 0.0 && share < 1.0 { share } else { 0.5 };
            let value = at(middle);
            if value >= 0.0 {
                (high, above, below) = (middle, value, below * 0.5);
            } else {
                (low, below, above) = (middle, value, above * 0.5);
            }
        }
        let share = below / (below - above);
        let way = low + (high - low) * if share > 0.0 && share < 1.0 { share } else { 0.5 };
        let (_, gradient) = self.inside(x + along * way, threshold);
        let gradient = (self.field_from_model.transpose() * gradient.as_dvec3()).as_vec3();
        let normal = (-gradient).normalize_or(outward);
        let openness = self.openness(way, normal.dot(outward));
        Hit { kind: HitKind::Cavity, leaf: 0, normal, openness, ..Hit::matrix(outward, -way) }
    }

    /// An estimate: the floor of a round pit as wide as voids are in the mean, and the slope's own share.
    fn openness(&self, way: f32, cos: f32) -> f32 {
        let wide = 0.45 * self.spec.spacing;
        let pit = wide * wide / (wide * wide + way * way);
        pit * clamp01(0.5 + 0.5 * cos)
    }
}

impl Waves {
    /// Waves in even directions, lengths within a tenth of each other.
    fn drawn(seed: u32) -> Self {
        let mut waves = Self { k: [[0.0; N_WAVES]; 3], phase: [0.0; N_WAVES] };
        for i in 0..N_WAVES {
            let r = |which: u32| unit_float(hash(hash(seed ^ 0x5b07_e5a1).wrapping_add(i as u32 * 4 + which))) as f64;
            // A spiral on the sphere, a little off: no direction has more waves than others.
            let z = 1.0 - (2.0 * i as f64 + r(0) + 0.5) / (N_WAVES as f64 + 0.5);
            let z = z.clamp(-1.0, 1.0);
            let turn = 2.399_963_229_728_653 * i as f64 + r(1);
            let out = (1.0 - z * z).max(0.0).sqrt();
            let length = 0.9 + 0.2 * r(2);
            let k = [out * exact::cos(turn), out * exact::sin(turn), z];
            (0..3).for_each(|c| waves.k[c][i] = (k[c] * length) as f32);
            waves.phase[i] = (r(3) * std::f64::consts::TAU) as f32;
        }
        waves
    }

    /// Scales the sum to a variance of one.
    const STRENGTH: f32 = 0.25;

    fn value(&self, x: Vec3) -> (f32, Vec3) {
        let (mut sum, mut slope) = (0.0, Vec3::ZERO);
        let mut sin = [0.0f32; N_WAVES];
        let mut cos = [0.0f32; N_WAVES];
        for i in 0..N_WAVES {
            (sin[i], cos[i]) = sin_cos(self.phase_at(x, i));
        }
        for i in 0..N_WAVES {
            sum += cos[i];
            slope -= vec3(self.k[0][i], self.k[1][i], self.k[2][i]) * sin[i];
        }
        (sum * Self::STRENGTH, slope * Self::STRENGTH)
    }

    #[inline(always)]
    fn phase_at(&self, x: Vec3, i: usize) -> f32 {
        self.k[0][i] * x.x + self.k[1][i] * x.y + self.k[2][i] * x.z + self.phase[i]
    }

    /// The first of `n` steps along a ray whose value `stops`: phases go on evenly, so that each step only turns them.
    fn march(&self, x: Vec3, step: Vec3, n: usize, stops: impl Fn(f32) -> bool) -> Option<usize> {
        let (mut sin, mut cos) = ([0.0f32; N_WAVES], [0.0f32; N_WAVES]);
        let (mut turn_sin, mut turn_cos) = ([0.0f32; N_WAVES], [0.0f32; N_WAVES]);
        for i in 0..N_WAVES {
            (sin[i], cos[i]) = sin_cos(self.phase_at(x, i));
        }
        for i in 0..N_WAVES {
            let angle = self.k[0][i] * step.x + self.k[1][i] * step.y + self.k[2][i] * step.z;
            (turn_sin[i], turn_cos[i]) = sin_cos(angle);
        }
        for k in 1..=n {
            // Four sums side by side, in an order that no vector length changes.
            let mut sums = [0.0f32; 4];
            for i in 0..N_WAVES {
                let (s, c) = (sin[i], cos[i]);
                cos[i] = c * turn_cos[i] - s * turn_sin[i];
                sin[i] = s * turn_cos[i] + c * turn_sin[i];
            }
            for i in 0..N_WAVES {
                sums[i & 3] += cos[i];
            }
            if stops((sums[0] + sums[1] + sums[2] + sums[3]) * Self::STRENGTH) {
                return Some(k);
            }
        }
        None
    }
}
