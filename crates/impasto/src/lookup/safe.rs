//! Light that leaves a colour table readable.
//!
//! Shading a data picture by multiplying its colours moves them along the table, and a reader finds the wrong value. Here
//! each entry moves *across* the table instead: in CIE Lab, along the direction nearest to lightness that is at right
//! angles to the table's curve, and only so far that the nearest colour of the table is still the entry itself.

use crate::color::{LinearRgba, lab_from_linear, lab_to_linear};

/// Each entry of a colour table in shadow and in light.
#[derive(Clone, Debug, PartialEq)]
pub struct Shades {
    /// Linear light: what is added in full shadow, and in full light.
    shifts: Vec<[[f32; 3]; 2]>,
}

/// How far a shade may read from its entry, as a share of the table.
const TOLERANCE: f64 = 0.0075;

/// No shade is further than this from its entry, in units of Lab: enough to see the form.
const FARTHEST: f64 = 22.0;

type Lab = [f64; 3];

fn minus(a: Lab, b: Lab) -> Lab {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Lab, b: Lab) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a` at right angles to the unit vector `t`.
fn across(a: Lab, t: Lab) -> Lab {
    let along = dot(a, t);
    std::array::from_fn(|k| a[k] - along * t[k])
}

fn unit(a: Lab) -> Option<Lab> {
    let length = dot(a, a).sqrt();
    (length > 1e-6).then(|| a.map(|x| x / length))
}

impl Shades {
    /// Shades for a table's colours.
    pub fn of(colors: &[LinearRgba]) -> Self {
        let labs: Vec<Lab> = colors.iter().map(|c| lab_from_linear([c[0] as f64, c[1] as f64, c[2] as f64])).collect();
        let n = labs.len();
        let directions: Vec<Lab> = (0..n).map(|i| direction(&labs, i)).collect();
        let reach: Vec<[f64; 2]> =
            (0..n).map(|i| [-1.0, 1.0].map(|sign| farthest(&labs, i, directions[i], sign))).collect();
        // No entry leaps where its neighbours crawl: the least around, then smoothed.
        let radius = n / 32;
        let around = |i: usize| i.saturating_sub(radius)..(i + radius + 1).min(n);
        let least: Vec<[f64; 2]> =
            (0..n).map(|i| [0, 1].map(|s| around(i).map(|j| reach[j][s]).fold(f64::INFINITY, f64::min))).collect();
        let shift = |i: usize, s: usize| {
            let mean = around(i).map(|j| least[j][s]).sum::<f64>() / around(i).len() as f64;
            let reach = mean.min(reach[i][s]) * [-1.0, 1.0][s];
            let there = lab_to_linear(std::array::from_fn(|k| labs[i][k] + reach * directions[i][k]));
            std::array::from_fn(|k| there[k].clamp(0.0, 1.0) as f32 - colors[i][k])
        };
        Self { shifts: (0..n).map(|i| [shift(i, 0), shift(i, 1)]).collect() }
    }

    /// An entry's colour in light from 0 to 1.
    #[inline(always)]
    pub(super) fn color(&self, entry: usize, own: LinearRgba, light: f32) -> LinearRgba {
        let [shadow, lit] = &self.shifts[entry];
        let amount = (light - 0.5) * 2.0;
        let (shift, amount) = if amount < 0.0 { (shadow, -amount) } else { (lit, amount) };
        [own[0] + shift[0] * amount, own[1] + shift[1] * amount, own[2] + shift[2] * amount, own[3]]
    }
}

/// The way towards lightness at right angles to the table's curve.
fn direction(labs: &[Lab], i: usize) -> Lab {
    let (before, after) = (labs[i.saturating_sub(1)], labs[(i + 1).min(labs.len() - 1)]);
    let lightness = [1.0, 0.0, 0.0];
    let Some(tangent) = unit(minus(after, before)) else { return lightness };
    let way = across(lightness, tangent);
    // Along a table of greys, lightness itself is taken: light is warm there, and shadow cool.
    let way = if dot(way, way) > 0.04 { way } else { across([0.35, 0.6, 0.8], tangent) };
    unit(way).unwrap_or(lightness)
}

/// How far entry `i` may go: all the way there, its nearest colour of the table is itself, or next to it.
fn farthest(labs: &[Lab], i: usize, direction: Lab, sign: f64) -> f64 {
    let tolerance = (TOLERANCE * labs.len() as f64) as usize;
    let own = lab_to_linear(labs[i]);
    let reads_well = |reach: f64| {
        let there = lab_to_linear(std::array::from_fn(|k| labs[i][k] + sign * reach * direction[k]));
        let is_shown = there.iter().all(|c| (-0.002..=1.002).contains(c));
        is_shown
            && [0.5, 1.0].iter().all(|share| {
                let lab = lab_from_linear(std::array::from_fn(|k| (own[k] + (there[k] - own[k]) * share).max(0.0)));
                let distance = |other: &Lab| {
                    let d = minus(*other, lab);
                    dot(d, d)
                };
                let near = i.saturating_sub(tolerance)..(i + tolerance + 1).min(labs.len());
                let limit = labs[near.clone()].iter().map(distance).fold(f64::INFINITY, f64::min);
                // Without a branch for each: nearly all of them are far.
                let is_far = |others: &[Lab]| others.iter().fold(true, |all, other| all & (distance(other) > limit));
                is_far(&labs[..near.start]) && is_far(&labs[near.end..])
            })
    };
    let (mut good, mut bad) = (0.0, FARTHEST);
    if reads_well(bad) {
        return bad;
    }
    for _ in 0..6 {
        let middle = 0.5 * (good + bad);
        if reads_well(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lookup::ColorTable;

    /// The share of the table between an entry and what a reader finds for its shades: the largest of all.
    fn worst_misreading(table: &ColorTable) -> f64 {
        let lab = |c: &LinearRgba| lab_from_linear([c[0] as f64, c[1] as f64, c[2] as f64]);
        let labs: Vec<Lab> = table.colors.iter().map(lab).collect();
        let shades = Shades::of(&table.colors);
        let mut worst = 0;
        for (i, own) in table.colors.iter().enumerate() {
            for light in [0.0, 0.2, 0.5, 0.7, 1.0] {
                let seen = lab(&shades.color(i, *own, light));
                let squared = |l: &Lab| dot(minus(*l, seen), minus(*l, seen));
                let read = (0..labs.len()).min_by(|a, b| squared(&labs[*a]).total_cmp(&squared(&labs[*b])));
                worst = worst.max(read.expect("a table has entries").abs_diff(i));
            }
        }
        worst as f64 / labs.len() as f64
    }

    #[test]
    fn shades_are_read_as_their_entries() {
        for name in ["viridis", "coolwarm", "grey"] {
            let table = ColorTable::named(name).expect("a known table");
            assert!(worst_misreading(&table) <= 0.012, "{name}: {}", worst_misreading(&table));
            assert_eq!(worst_misreading(&table.banded(9)), 0.0, "{name}");
        }
    }

    #[test]
    fn shades_show_the_form() {
        let table = ColorTable::named("viridis").expect("a known table");
        let shades = Shades::of(&table.colors);
        let lightness = |c: LinearRgba| lab_from_linear([c[0] as f64, c[1] as f64, c[2] as f64])[0];
        let spans = (10..246).map(|i| {
            let of = |light| lightness(shades.color(i, table.colors[i], light));
            of(1.0) - of(0.0)
        });
        let mean = spans.clone().sum::<f64>() / spans.len() as f64;
        assert!(mean > 8.0, "shadow and light are {mean} apart");
        assert_eq!(shades.color(7, table.colors[7], 0.5), table.colors[7]);
    }
}
