//! A picture's legend, from what its layers show.

use crate::color::{LinearRgb, LinearRgba};
use crate::error::{Mended, Result};
use crate::lookup::{Levels, Scale};
use crate::math::Size;
use crate::picture::Background;
use crate::picture::Drawing;
use crate::picture::legend::{
    LegendLayout, LegendLine, LegendScale, LegendSpec, Position, Theme, layout, legend_alone,
};
use crate::picture::numbers::Notation;
use crate::picture::swatch::{AxisSpec, SwatchSpec, swatch_alone, swatch_layout};
use crate::placement::Property;
use crate::recipe::data::{self, Key};
use crate::recipe::layer::LayerRecipe;
use crate::recipe::stack::Ground;
use crate::recipe::words::choose_or;
use crate::recipe::{LegendRecipe, Recipe};

/// What a picture says about its data: what colours stand for, the legend that tells it, and isolines with their values.
pub(super) type Told = (Vec<Key>, Option<(Legend, LegendLayout)>, Vec<Labelled>);

/// What is told of a recipe's data; an atlas has no legend.
pub(super) fn told(
    recipe: &Recipe,
    on: &Ground,
    (size, background): (Size, Background),
    mended: &mut Vec<Mended>,
) -> Result<Told> {
    let keys = data::keys(&recipe.layers, on, mended)?;
    let on = &Ground { known: &keys, ..*on };
    let legend = match recipe.camera.view.as_deref() {
        Some("atlas") => None,
        _ => legend(recipe, &keys, on, size, background)?,
    };
    let labelled = labelled(recipe, on)?;
    Ok((keys, legend, labelled))
}

/// What a legend tells: of one property, or of one that another filters.
#[derive(Clone, Debug, PartialEq)]
pub enum Legend {
    /// A bar.
    Bar(LegendSpec),
    /// A square.
    Swatch(SwatchSpec),
}

impl Legend {
    /// On a sheet of its own, as large as a picture of this size has it.
    pub fn alone(&self, picture: Size) -> Drawing {
        match self {
            Self::Bar(spec) => legend_alone(spec, picture),
            Self::Swatch(spec) => swatch_alone(spec, picture),
        }
    }
}

/// More lines than this on a bar are no help.
const MOST_LINES: usize = 40;

/// The legend of a picture with these keys, if it is to have one: for pictures through a camera, of their first table.
fn legend(
    recipe: &Recipe,
    keys: &[Key],
    on: &Ground,
    size: Size,
    background: Background,
) -> Result<Option<(Legend, LegendLayout)>> {
    let places = [
        ("right", Some(Position::Right)),
        ("left", Some(Position::Left)),
        ("bottom", Some(Position::Bottom)),
        ("none", None),
    ];
    let place = choose_or("legend", &recipe.legend.place, &places, Some(Position::Right))?;
    let (Some(position), Some(key)) = (place, keys.first()) else { return Ok(None) };
    let mut spec = LegendSpec { position, ..spec(&recipe.legend, key, background)? };
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
    let of_two = recipe.layers.iter().find(|l| {
        let is_colour = l.target.as_deref().is_none_or(|t| t == "color");
        l.filter.is_some() && is_colour && l.grid.is_none() && l.field.as_deref() != Some(&key.asked)
    });
    let (legend, layout) = match of_two {
        None => {
            let layout = layout(&spec, size);
            (Legend::Bar(spec), layout)
        }
        Some(layer) => {
            let swatch = swatch(layer, key, on, &spec)?;
            let layout = swatch_layout(&swatch, size);
            (Legend::Swatch(swatch), layout)
        }
    };
    // A picture that would be all legend shows none.
    let side = if position == Position::Bottom { size.height } else { size.width };
    let fits = layout.width < side * 6 / 10;
    Ok(fits.then_some((legend, layout)))
}

/// The colours of two properties: the table's from left to right, the filter's effect from bottom to top.
fn swatch(layer: &LayerRecipe, key: &Key, on: &Ground, bar: &LegendSpec) -> Result<SwatchSpec> {
    const N: usize = 96;
    let data::Filtering { filter, ends: [zero, one], range, title, unit } = data::filter_of(layer, on)?;
    let across = AxisSpec {
        title: bar.title.clone(),
        unit: bar.unit.clone(),
        scale: bar.scale,
        range: bar.range,
        notation: bar.notation,
    };
    let up = AxisSpec { title, unit, range, notation: bar.notation, ..AxisSpec::default() };
    let colors = &key.table.colors;
    let spec = SwatchSpec::from_fn([across, up], N, |x, y| {
        let own = colors[((x * colors.len() as f32) as usize).min(colors.len() - 1)];
        let value = range[0] + (range[1] - range[0]) * y as f64;
        let kept = filter.kept(((value - zero) / (one - zero)) as f32, 0.0);
        std::array::from_fn(|c| filter.color[c] + (own[c] - filter.color[c]) * kept)
    });
    Ok(SwatchSpec {
        missing: bar.missing,
        hatch: bar.hatch,
        missing_share: bar.missing_share,
        theme: bar.theme,
        position: bar.position,
        ..spec
    })
}

/// Isolines whose values stand on them: whose they are, at which values, and what they look like.
#[derive(Clone, Debug, PartialEq)]
pub struct Labelled {
    /// What they are lines of.
    pub property: Property,
    /// Values of the lines that get labels.
    pub levels: Vec<f32>,
    /// Of the lines.
    pub color: LinearRgba,
}

/// The lines of a recipe that get labels: the major ones, where there are such.
fn labelled(recipe: &Recipe, on: &Ground) -> Result<Vec<Labelled>> {
    let mut all = Vec::new();
    if recipe.legend.line_labels != Some(true) {
        return Ok(all);
    }
    for layer in recipe.layers.iter().filter(|l| l.isolines.is_some()) {
        let (isolines, [first, second]) = data::lines(layer, on)?;
        let (property, range) = data::property_of(layer, on)?;
        let levels = isolines.levels.within(range.map(|v| (v - first) / (second - first)), 4 * MOST_LINES);
        let every = isolines.major.map_or(1, |(every, _)| every.max(1) as i64);
        let numbered = levels.into_iter().enumerate().map(|(i, level)| match isolines.levels {
            Levels::Steps { .. } => (level.round() as i64, level),
            Levels::List(_) => (i as i64, level),
        });
        let major = numbered.filter(|(number, _)| number.rem_euclid(every) == 0);
        let levels = major.map(|(_, level)| (first + level * (second - first)) as f32).collect();
        all.push(Labelled { property, levels, color: isolines.minor.color });
    }
    Ok(all)
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
        hatch: table.hatch,
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
