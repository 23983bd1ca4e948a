//! Where the marks of a scale go, and what they say: round numbers, never one over another.

use crate::math::exact;
use crate::picture::font::{self, Weight};
use crate::picture::numbers::{self, Notation, power_of_ten};

/// How values lie along a bar.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum LegendScale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm. A range that holds zero is taken as linear.
    Log,
    /// By `sign(x) log(1 + |x| / linear_up_to)`: a logarithm on both sides of zero that passes it smoothly.
    SymLog {
        /// The size up to about which values lie evenly; greater than 0.
        linear_up_to: f64,
    },
}

impl LegendScale {
    /// How far along the range a value is: 0 at its first end, 1 at its last. One half where the range has no extent.
    pub fn position(self, value: f64, range: [f64; 2]) -> f64 {
        let bend = self.bend(range);
        let [first, last] = range.map(&bend);
        let place = (bend(value) - first) / (last - first);
        if place.is_finite() { place } else { 0.5 }
    }

    /// The value that is so far along the range.
    pub fn value_at(self, position: f64, range: [f64; 2]) -> f64 {
        let bend = self.bend(range);
        let [first, last] = range.map(&bend);
        let place = first + (last - first) * position;
        match self.within(range) {
            Self::Linear => place,
            Self::Log => exact::pow(10.0, place.abs() - LOG_SHIFT) * place.signum(),
            Self::SymLog { linear_up_to } => (exact::pow(10.0, place.abs()) - 1.0) * linear_up_to * place.signum(),
        }
    }

    /// The scale itself, or a linear one where it is not possible.
    fn within(self, [a, b]: [f64; 2]) -> Self {
        match self {
            Self::Log if (a * b.signum()).is_nan() || a * b.signum() <= 0.0 => Self::Linear,
            Self::SymLog { linear_up_to } if !(linear_up_to > 0.0 && linear_up_to.is_finite()) => Self::Linear,
            scale => scale,
        }
    }

    /// The function that makes the scale even.
    fn bend(self, range: [f64; 2]) -> impl Fn(f64) -> f64 {
        let scale = self.within(range);
        let sign = range[0].signum();
        move |v: f64| match scale {
            Self::Linear => v,
            Self::Log => sign * (exact::log10((v * sign).max(f64::MIN_POSITIVE)) + LOG_SHIFT),
            Self::SymLog { linear_up_to } => exact::log10(1.0 + v.abs() / linear_up_to) * v.signum(),
        }
    }
}

/// Keeps logarithms positive, so that their sign can tell that of the values.
const LOG_SHIFT: f64 = 400.0;

/// A mark with its number.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// What is there.
    pub value: f64,
    /// Where: 0 at the range's first end, 1 at its last.
    pub position: f64,
    /// What is written there.
    pub label: String,
}

/// All marks of a scale.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Ticks {
    /// Marks with numbers, by value.
    pub major: Vec<Tick>,
    /// Positions of marks without numbers.
    pub minor: Vec<f64>,
    /// Labels are to be multiplied by ten to this power (see [`numbers::unit_text`]).
    pub exponent: i32,
    /// Then this is to be added.
    pub offset: f64,
    /// Whether all labels have the same decimals, so that right-aligned they stand point below point.
    pub is_column: bool,
}

/// How much place there is for marks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// The bar's length, pixels.
    pub length: f32,
    /// The em of labels, pixels.
    pub text_size: f32,
    /// Whether labels stand side by side, not one above the other.
    pub is_horizontal: bool,
}

impl Room {
    /// How many marks look well: not a number in every corner.
    fn n_best(&self) -> usize {
        let share = if self.is_horizontal { 5.5 } else { 3.2 };
        ((self.length / (share * self.text_size)) as usize).clamp(2, 9)
    }

    /// Whether no label touches its neighbour.
    fn holds(&self, ticks: &[Tick]) -> bool {
        let half = |t: &Tick| match self.is_horizontal {
            true => 0.5 * font::width(&t.label, self.text_size, Weight::Regular) + 0.4 * self.text_size,
            false => 0.62 * self.text_size,
        };
        let is_apart = |a: &Tick, b: &Tick| {
            let distance = (a.position - b.position).abs() as f32 * self.length;
            distance >= half(a) + half(b)
        };
        ticks.windows(2).all(|pair| is_apart(&pair[0], &pair[1]))
    }
}

/// Round marks of a scale between two values, the first of which may be the greater.
pub fn ticks(scale: LegendScale, range: [f64; 2], notation: Notation, room: Room) -> Ticks {
    let [low, high] = [range[0].min(range[1]), range[0].max(range[1])];
    if !(range[0].is_finite() && range[1].is_finite()) {
        return Ticks::default();
    }
    if high - low <= low.abs().max(high.abs()) * 1e-12 || !(high - low).is_finite() {
        let label = numbers::single(low, 6, notation);
        return Ticks { major: vec![Tick { value: low, position: 0.5, label }], ..Ticks::default() };
    }
    let axis = Axis { scale: scale.within(range), range, low, high, notation, room };
    match axis.scale {
        LegendScale::Linear => axis.linear(),
        LegendScale::Log => axis.log(),
        LegendScale::SymLog { linear_up_to } => axis.sym_log(linear_up_to),
    }
}

/// Marks between the bands of a scale that is cut into `n` equal ones, at every band or every so many.
pub fn band_edges(scale: LegendScale, range: [f64; 2], n: u32, notation: Notation, room: Room) -> Ticks {
    let n = n.clamp(1, 1000) as usize;
    if !(range[0].is_finite() && range[1].is_finite()) || range[0] == range[1] {
        return ticks(scale, range, notation, room);
    }
    let at = |i: usize| if i == n { range[1] } else { scale.value_at(i as f64 / n as f64, range) };
    let is_linear = scale.within(range) == LegendScale::Linear;
    let every = |stride: usize| {
        let values: Vec<f64> = (0..=n).step_by(stride).map(at).collect();
        let mut out = match is_linear {
            true => labelled(scale, range, &values, (range[1] - range[0]).abs() / n as f64 * 0.04, notation),
            false => singly(scale, range, &values, 3, notation),
        };
        out.major.sort_by(|a, b| a.value.total_cmp(&b.value));
        out
    };
    // First strides that end with the last band.
    let strides = (1..=n).filter(|s| n.is_multiple_of(*s)).chain((1..=n).filter(|s| !n.is_multiple_of(*s)));
    let mut tried: Vec<Ticks> = strides.take_while(|s| *s <= n).map(every).filter(|t| room.holds(&t.major)).collect();
    let n_best = room.n_best() + 4;
    let best = tried.iter().enumerate().max_by_key(|(i, t)| {
        let count = t.major.len();
        (if count <= n_best { count } else { 0 }, usize::MAX - i)
    });
    match best.map(|(i, _)| i) {
        Some(i) => tried.swap_remove(i),
        None => Ticks::default(),
    }
}

struct Axis {
    scale: LegendScale,
    range: [f64; 2],
    low: f64,
    high: f64,
    notation: Notation,
    room: Room,
}

impl Axis {
    /// The widest set of multiples of 1, 2, 2.5 or 5 times a power of ten that has room.
    fn linear(&self) -> Ticks {
        let extent = self.high - self.low;
        let n_best = self.room.n_best();
        let first = exact::log10(extent / n_best as f64).floor() as i32 - 1;
        let steps = (first..first + 5).flat_map(|e| [1.0, 2.0, 2.5, 5.0].map(|m| m * power_of_ten(e)));
        let mut best = Ticks::default();
        for step in steps.filter(|s| *s > 0.0) {
            let (from, to) = ((self.low / step - 1e-6).ceil(), (self.high / step + 1e-6).floor());
            let n = to - from + 1.0;
            if !(n >= 1.0 && n <= (3 * n_best) as f64) {
                continue;
            }
            let values: Vec<f64> = (0..n as usize).map(|i| round_multiple(from + i as f64, step)).collect();
            let ticks = labelled(self.scale, self.range, &values, step * 1e-5, self.notation);
            if !self.room.holds(&ticks.major) {
                continue;
            }
            let is_enough = ticks.major.len() <= n_best;
            if best.major.is_empty() || ticks.major.len() >= 2 {
                best = ticks;
            }
            if is_enough {
                break;
            }
        }
        best.minor = minor_of_linear(&best, self);
        best
    }

    /// Powers of ten; with twos and fives where there are few.
    fn log(&self) -> Ticks {
        let sign = self.low.signum();
        let [near, far] = if sign > 0.0 { [self.low, self.high] } else { [-self.high, -self.low] };
        let [from, to] = [near, far].map(exact::log10);
        let n_decades = to - from;
        let decades = (from - 1e-9).ceil() as i32..=(to + 1e-9).floor() as i32;
        let multiples = |mantissas: &[f64]| -> Vec<f64> {
            let all = (from.floor() as i32..=to.ceil() as i32)
                .flat_map(|e| mantissas.iter().map(move |m| m * power_of_ten(e)));
            all.filter(|v| *v >= near * (1.0 - 1e-9) && *v <= far * (1.0 + 1e-9)).map(|v| v * sign).collect()
        };
        let mut sets = Vec::new();
        if n_decades < 3.0 {
            sets.extend([multiples(&[1.0, 2.0, 5.0]), multiples(&[1.0, 3.0])]);
        }
        let n_best = self.room.n_best();
        for stride in 1..=(decades.clone().count().max(1)) {
            // The start that gives most; among equal ones that of 1.
            let every = |start: i32| -> Vec<f64> {
                let kept = decades.clone().filter(|e| (e - start).rem_euclid(stride as i32) == 0);
                kept.map(|e| power_of_ten(e) * sign).collect()
            };
            sets.extend((0..stride as i32).rev().map(every).max_by_key(|set| set.len()));
        }
        let chosen = sets.into_iter().map(|set| self.powers(set)).find(|t| {
            let n = t.major.len();
            n >= 2 && n <= n_best + 3 && self.room.holds(&t.major)
        });
        let Some(mut ticks) = chosen else { return Axis { notation: self.notation, ..*self }.linear_on_curve() };
        let per_decade = self.room.length as f64 / n_decades;
        let between: Vec<f64> = match per_decade {
            p if p >= 24.0 => multiples(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]),
            p if p >= 3.0 => multiples(&[1.0]),
            _ => Vec::new(),
        };
        ticks.minor = self.without_majors(&ticks, between);
        ticks
    }

    /// Zero, and powers of ten on both sides.
    fn sym_log(&self, linear_up_to: f64) -> Ticks {
        let greatest = self.low.abs().max(self.high.abs());
        let first = (exact::log10(linear_up_to) - 1e-9).ceil() as i32;
        let last = (exact::log10(greatest) + 1e-9).floor() as i32;
        let is_inside =
            |v: &f64| *v >= self.low * (1.0 - 1e-9 * self.low.signum()) && *v <= self.high + self.high.abs() * 1e-9;
        for stride in 1..=(last - first + 1).max(0) {
            let sizes: Vec<f64> = (first..=last).rev().step_by(stride as usize).map(power_of_ten).collect();
            let mut values: Vec<f64> =
                sizes.iter().map(|v| -v).chain([0.0]).chain(sizes.iter().rev().copied()).collect();
            values.retain(is_inside);
            let mut ticks = self.powers(values);
            let n_least = if self.low < 0.0 && self.high > 0.0 { 3 } else { 2 };
            if ticks.major.len() >= n_least
                && ticks.major.len() <= self.room.n_best() + 4
                && self.room.holds(&ticks.major)
            {
                let all = (first..=last).map(power_of_ten).flat_map(|v| [-v, v]).filter(is_inside).collect();
                ticks.minor = self.without_majors(&ticks, all);
                return ticks;
            }
        }
        self.linear_on_curve()
    }

    /// Round values placed on the curve; some are left out where they crowd.
    fn linear_on_curve(&self) -> Ticks {
        let even = Self { scale: LegendScale::Linear, ..*self };
        let mut values: Vec<f64> = even.linear().major.iter().map(|t| t.value).collect();
        // What rounding lets in evenly may be far out on the curve.
        values.retain(|v| (-1e-6..=1.000_001).contains(&self.scale.position(*v, self.range)));
        while values.len() >= 2 {
            let ticks = labelled(self.scale, self.range, &values, (values[1] - values[0]) * 1e-5, self.notation);
            if self.room.holds(&ticks.major) {
                return ticks;
            }
            // Every second one, and zero if it is among them.
            let odd = values.iter().position(|v| *v == 0.0).unwrap_or(0) % 2;
            values = values.into_iter().enumerate().filter(|(i, _)| i % 2 == odd).map(|(_, v)| v).collect();
        }
        let one = values.first().copied().unwrap_or(self.range[0]);
        singly(self.scale, self.range, &[one], 6, self.notation)
    }

    /// Powers of ten and their small multiples: as numbers where all are handy, else as powers.
    fn powers(&self, mut values: Vec<f64>) -> Ticks {
        values.sort_by(f64::total_cmp);
        let are_handy = values.iter().all(|v| *v == 0.0 || (v.abs() > 0.99e-3 && v.abs() < 1.01e4));
        if self.notation == Notation::Si || self.notation == Notation::Engineering || are_handy {
            return singly(self.scale, self.range, &values, 1, self.notation);
        }
        if self.notation == Notation::Plain && values.iter().all(|v| *v == 0.0 || (v.abs() > 1e-9 && v.abs() < 1e12)) {
            return singly(self.scale, self.range, &values, 1, self.notation);
        }
        let label = |v: f64| {
            let text = format!("{:e}", v.abs());
            let (mantissa, exponent) = text.split_once('e').unwrap_or(("0", "0"));
            let power = numbers::power_text(exponent.parse().unwrap_or(0));
            let sign = if v < 0.0 { "−" } else { "" };
            match mantissa {
                "0" => "0".to_owned(),
                "1" => format!("{sign}{power}"),
                // Two times a power may be 1.9999999999999998.
                m => format!("{sign}{:.0}×{power}", m.parse().unwrap_or(1.0)),
            }
        };
        let mut ticks = singly(self.scale, self.range, &values, 1, self.notation);
        ticks.major.iter_mut().for_each(|t| t.label = label(t.value));
        ticks
    }

    fn without_majors(&self, ticks: &Ticks, values: Vec<f64>) -> Vec<f64> {
        let is_new = |v: &f64| !ticks.major.iter().any(|t| (t.value - v).abs() <= v.abs() * 1e-9);
        values.into_iter().filter(is_new).map(|v| self.scale.position(v, self.range)).collect()
    }
}

/// A whole multiple of a round step, exactly rounded.
fn round_multiple(n: f64, step: f64) -> f64 {
    let value = n * step;
    // Through decimal text: 3 times 0.1 is to be 0.3.
    format!("{value:.12e}").parse().unwrap_or(value)
}

/// One mark half way, or four where a step is of five: only where the eye can part them.
fn minor_of_linear(ticks: &Ticks, axis: &Axis) -> Vec<f64> {
    let [Some(a), Some(b)] = [ticks.major.first(), ticks.major.get(1)] else { return Vec::new() };
    let step = b.value - a.value;
    let mantissa = step / power_of_ten(exact::log10(step * 1.000_001).floor() as i32);
    let n = if !(1.5..=4.0).contains(&mantissa) || (mantissa > 2.3 && mantissa < 3.0) { 5 } else { 4 };
    let distance = (step / (axis.high - axis.low)) as f32 * axis.room.length / n as f32;
    if distance < 4.0 || distance < axis.room.text_size * 0.45 {
        return Vec::new();
    }
    let small = step / n as f64;
    let (from, to) = ((axis.low / small - 1e-6).ceil(), (axis.high / small + 1e-6).floor());
    let all = (0..=(to - from).clamp(0.0, 1000.0) as usize).map(|i| round_multiple(from + i as f64, small)).collect();
    axis.without_majors_near(ticks, all, small)
}

impl Axis {
    fn without_majors_near(&self, ticks: &Ticks, values: Vec<f64>, step: f64) -> Vec<f64> {
        let is_new = |v: &f64| !ticks.major.iter().any(|t| (t.value - v).abs() < step * 0.1);
        values.into_iter().filter(is_new).map(|v| self.scale.position(v, self.range)).collect()
    }
}

/// Marks whose numbers stand in a column.
fn labelled(scale: LegendScale, range: [f64; 2], values: &[f64], tolerance: f64, notation: Notation) -> Ticks {
    let column = numbers::column(values, tolerance, notation);
    let tick = |(value, label): (&f64, String)| Tick { value: *value, position: scale.position(*value, range), label };
    let major = values.iter().zip(column.labels).map(tick).collect();
    Ticks { major, minor: Vec::new(), exponent: column.exponent, offset: column.offset, is_column: true }
}

/// Marks whose numbers are written each for itself.
fn singly(scale: LegendScale, range: [f64; 2], values: &[f64], n_digits: usize, notation: Notation) -> Ticks {
    let tick = |value: &f64| {
        let label = numbers::single(*value, n_digits, notation);
        Tick { value: *value, position: scale.position(*value, range), label }
    };
    Ticks { major: values.iter().map(tick).collect(), ..Ticks::default() }
}

#[cfg(test)]
#[path = "ticks_tests.rs"]
mod tests;
