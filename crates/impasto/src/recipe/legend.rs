//! A picture's legend, from what its layers show.

use crate::color::LinearRgb;
use crate::error::Result;
use crate::lookup::{Levels, Scale};
use crate::math::Size;
use crate::picture::Background;
use crate::picture::legend::{LegendLayout, LegendLine, LegendScale, LegendSpec, Theme, layout};
use crate::picture::numbers::Notation;
use crate::recipe::data::{self, Key};
use crate::recipe::stack::Ground;
use crate::recipe::words::choose_or;
use crate::recipe::{LegendRecipe, Recipe};

/// More lines than this on a bar are no help.
const MOST_LINES: usize = 40;

/// The legend of a picture with these keys, if it is to have one: for pictures through a camera, of their first table.
pub(super) fn legend(
    recipe: &Recipe,
    keys: &[Key],
    on: &Ground,
    size: Size,
    background: Background,
) -> Result<Option<(LegendSpec, LegendLayout)>> {
    let is_wanted = choose_or("legend", &recipe.legend.place, &[("right", true), ("none", false)], true)?;
    let (true, Some(key)) = (is_wanted, keys.first()) else { return Ok(None) };
    let mut spec = spec(&recipe.legend, key, background)?;
    for layer in recipe.layers.iter().filter(|l| l.isolines.is_some() && l.field.as_deref() == Some(&key.asked)) {
        let (isolines, [first, second]) = data::lines(layer, on)?;
        let value = |place: f64| first + place * (second - first);
        let place = |value: f64| (value - first) / (second - first);
        let levels = isolines.levels.within(key.range.map(place), MOST_LINES);
        for (i, level) in levels.into_iter().enumerate() {
            let number = if matches!(isolines.levels, Levels::Steps { .. }) { level.round() as i64 } else { i as i64 };
            let is_major = isolines.major.is_some_and(|(every, _)| number.rem_euclid(every.max(1) as i64) == 0);
            spec.lines.push(LegendLine { value: value(level), is_major, color: isolines.minor.color });
        }
    }
    let layout = layout(&spec, size);
    // A picture that would be all legend shows none.
    let fits = layout.width < size.width * 6 / 10;
    Ok(fits.then_some((spec, layout)))
}

fn spec(recipe: &LegendRecipe, key: &Key, background: Background) -> Result<LegendSpec> {
    let notation = choose_or(
        "notation",
        &recipe.notation,
        &[
            ("auto", Notation::Auto),
            ("plain", Notation::Plain),
            ("si", Notation::Si),
            ("engineering", Notation::Engineering),
        ],
        Notation::Auto,
    )?;
    let title = recipe.title.clone().unwrap_or_else(|| key.title.clone());
    let [n, missing, before, beyond] = key.counts;
    let table = &key.table;
    Ok(LegendSpec {
        scale: match key.scale {
            Scale::Linear => LegendScale::Linear,
            Scale::Log => LegendScale::Log,
            Scale::SymLog { linear } => LegendScale::SymLog { linear_up_to: linear as f64 },
        },
        is_smooth: table.filter == crate::assets::Filter::Linear,
        bands: key.bands,
        below: table.below.filter(|_| before > 0),
        above: table.above.filter(|_| beyond > 0),
        missing: (missing > 0).then_some(table.missing),
        missing_share: missing as f64 / n.max(1) as f64,
        notation,
        theme: if luminance(background) < 0.18 { Theme::Dark } else { Theme::Light },
        ..LegendSpec::new(title, key.unit.clone(), key.range, table.colors.clone())
    })
}

fn luminance(background: Background) -> f32 {
    let of = |[r, g, b]: LinearRgb| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    match background {
        Background::Plain(color) => of(color),
        Background::Gradient { top, bottom } => 0.5 * (of(top) + of(bottom)),
        _ => 1.0,
    }
}
