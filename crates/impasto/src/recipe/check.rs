//! How well a data picture can be read: values found by eye, from colours and legend alone, against the true ones.

use crate::color::{LinearRgba, lab_from_linear, linear_from_bytes};
use crate::error::Result;
use crate::inspect;
use crate::math::Size;
use crate::par::Workers;
use crate::placement::Property;
use crate::recipe::Prepared;
use crate::recipe::words::impossible;
use crate::visibility::Samples;

/// What a reader of the picture gets.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// What the values are, and their unit.
    pub title: String,
    /// Of the values.
    pub unit: String,
    /// The values at the table's ends.
    pub range: [f64; 2],
    /// Pixels that show a surface with a value within the range.
    pub n_values: usize,
    /// Of these, how many have a colour that is far from all of the table's: lines, edges, highlights.
    pub n_unreadable: usize,
    /// Misreadings of the others, as shares of the table: the middle one, the one that 95 of 100 stay below, the worst.
    pub median: f64,
    /// See `median`.
    pub p95: f64,
    /// See `median`.
    pub worst: f64,
}

/// Beyond this distance in CIE Lab nobody takes a colour for the table's.
const FAR: f64 = 30.0;

/// Reads a picture of what `prepared` says against its first table: for each pixel the nearest colour of the legend.
///
/// A reading is right when it finds the value's own entry, or band; else it is as wrong as the value is far from the entry
/// that was found.
///
/// # Errors
/// `Parameter` when the picture shows no data, or has another size.
pub fn check(pixels: &[[u8; 4]], size: Size, prepared: &Prepared, workers: &Workers) -> Result<Reading> {
    let Some(key) = prepared.keys.first() else {
        return Err(impossible("picture", "", "it shows no data: there is no colour table in its recipe"));
    };
    if size != prepared.size || pixels.len() != size.n_cells() {
        let why = format!("its recipe draws {}", prepared.size);
        return Err(impossible("picture", size, why));
    }
    let truth = values(prepared, &key.property, workers);
    let labs: Vec<[f64; 3]> = key.table.colors.iter().map(lab).collect();
    let n = labs.len();
    let rows: Vec<Vec<Option<f64>>> = workers.map(size.height as usize, |y| {
        let row = y * size.width as usize..(y + 1) * size.width as usize;
        let cells = truth[row.clone()].iter().zip(&pixels[row]);
        cells
            .filter_map(|(&value, pixel)| {
                let share = key.share(value as f64).filter(|s| (0.0..=1.0).contains(s))?;
                let [r, g, b, _] = *pixel;
                let [r, g, b] = linear_from_bytes([r, g, b]);
                let seen = lab(&[r, g, b, 1.0]);
                let distance = |l: &[f64; 3]| (0..3).map(|k| (l[k] - seen[k]) * (l[k] - seen[k])).sum::<f64>();
                let (entry, far) = labs.iter().map(distance).enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
                if far > FAR * FAR {
                    return Some(None);
                }
                let off = (share - (entry as f64 + 0.5) / n as f64).abs();
                Some(Some(if off <= 0.5 / n as f64 { 0.0 } else { off }))
            })
            .collect()
    });
    let all: Vec<Option<f64>> = rows.into_iter().flatten().collect();
    let mut errors: Vec<f64> = all.iter().flatten().copied().collect();
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors.get(((errors.len() as f64 * share) as usize).min(errors.len().saturating_sub(1)));
    let at = |share: f64| at(share).copied().unwrap_or(f64::NAN);
    Ok(Reading {
        title: key.title.clone(),
        unit: key.unit.clone(),
        range: key.range,
        n_values: all.len(),
        n_unreadable: all.len() - errors.len(),
        median: at(0.5),
        p95: at(0.95),
        worst: at(1.0),
    })
}

fn lab(c: &LinearRgba) -> [f64; 3] {
    lab_from_linear([c[0] as f64, c[1] as f64, c[2] as f64])
}

/// A property's value in each pixel, NaN where there is none.
pub(super) fn values(prepared: &Prepared, property: &Property, workers: &Workers) -> Vec<f32> {
    let (domain, shot) = (prepared.domain(), prepared.shot(Samples::One));
    let buffer = inspect::probe::buffer(&domain, &shot, workers);
    inspect::measured(property, &buffer, &domain, workers)
}
