//! Data layers of a recipe: colour tables, isolines and filters over fields, with ranges found where none are given.

use crate::assets::{Element, Field, Filter as Interpolation, Grid, Scene, Values, files};
use crate::color::LinearRgba;
use crate::error::{Error, Mended, Result, note};
use crate::lookup::{ColorTable, Filter, Isolines, Keep, Levels, Line, Scale, Shades, Target, Texture};
use crate::math::{Vec3, vec3};
use crate::placement::{self, Missing, Placement, PropertyAxis};
use crate::recipe::layer::{LayerRecipe, Numbers};
use crate::recipe::source::{self, place};
use crate::recipe::stack::{FILTERS, Ground};
use crate::recipe::words::{choose_or, color, impossible};
use std::path::Path;
use std::sync::Arc;

/// One property of the surface: a field, or one component of it, or a grid.
#[derive(Clone, Copy)]
struct Property<'a> {
    index: usize,
    /// Of grids: the values at the vertices.
    field: &'a Field,
    component: Option<usize>,
    grid: Option<&'a Sampled>,
}

/// A grid that a layer shows, read from its file once.
pub(super) struct Sampled {
    file: String,
    distance: f32,
    grid: Arc<Grid>,
    at_vertices: Field,
}

/// The grids that layers name.
///
/// # Errors
/// What the file's reader says; `Parameter` for a distance that cannot be.
pub(super) fn grids(
    layers: &[LayerRecipe],
    base: &Path,
    scene: &Scene,
    mended: &mut Vec<Mended>,
) -> Result<Vec<Sampled>> {
    let mut found: Vec<Sampled> = Vec::new();
    for layer in layers {
        let Some(file) = &layer.grid else { continue };
        let distance = layer.distance()?;
        if found.iter().any(|s| s.file == *file && s.distance == distance) {
            continue;
        }
        let grid = match found.iter().find(|s| s.file == *file) {
            Some(known) => known.grid.clone(),
            None => {
                let report = files::load_volume(&place(base, file))?;
                mended.extend(report.mended);
                let n_more = report.value.grids.len().saturating_sub(1);
                note(mended, n_more, format!("further grids of {file:?} not shown"));
                let first = report.value.grids.into_iter().next();
                Arc::new(first.ok_or_else(|| impossible("grid", file, "no grid is in the file"))?)
            }
        };
        let mut at_vertices = grid.off_vertices(&scene.mesh, distance);
        if at_vertices.name.is_empty() {
            let name = Path::new(file).file_name().map_or("", |n| n.to_str().unwrap_or(""));
            at_vertices.name = name.split('.').next().unwrap_or(name).into();
        }
        found.push(Sampled { file: file.clone(), distance, grid, at_vertices });
    }
    Ok(found)
}

impl LayerRecipe {
    /// Whether it shows a field.
    pub fn is_data(&self) -> bool {
        self.table.is_some() || self.isolines.is_some() || self.filter.is_some()
    }

    /// How far outside of the surface a grid is read.
    fn distance(&self) -> Result<f32> {
        match self.grid_offset.unwrap_or(0.0) as f32 {
            d if d.is_finite() => Ok(d),
            d => Err(impossible("grid_offset", d, "a finite length")),
        }
    }
}

impl<'a> Property<'a> {
    /// What `NAME[.x|.mag|.0][@faces]` stands for.
    fn of(recipe: &LayerRecipe, on: &'a Ground) -> Result<Self> {
        if let Some(file) = &recipe.grid {
            if recipe.field.is_some() {
                return Err(impossible("layer", file, "it shows a field or a grid, not both"));
            }
            let distance = recipe.distance()?;
            let grid = on.grids.iter().find(|s| s.file == *file && s.distance == distance);
            let grid = grid.ok_or_else(|| impossible("grid", file, "it was not read"))?;
            return Ok(Self { index: 0, field: &grid.at_vertices, component: Some(0), grid: Some(grid) });
        }
        let fields = on.scene.mesh.fields();
        let known = || match fields {
            [] => "the surface carries no data".into(),
            _ => format!("the surface carries {}", fields.iter().map(describe).collect::<Vec<_>>().join(", ")),
        };
        let given = recipe.field.as_deref().ok_or_else(|| impossible("field", "", known()))?;
        let (name, element) = match given.rsplit_once('@') {
            Some((name, "vertices" | "points")) => (name, Some(Element::Vertex)),
            Some((name, "faces" | "cells")) => (name, Some(Element::Face)),
            Some((name, "corners")) => (name, Some(Element::Corner)),
            _ => (given, None),
        };
        let find = |name: &str| fields.iter().position(|f| f.name == name && element.is_none_or(|e| f.element == e));
        // A name may have a dot of its own.
        let (index, suffix) = match (find(name), name.rsplit_once('.')) {
            (Some(index), _) => (index, None),
            (None, Some((stem, suffix))) => match find(stem) {
                Some(index) => (index, Some(suffix)),
                None => return Err(impossible("field", given, known())),
            },
            (None, None) => return Err(impossible("field", given, known())),
        };
        let field = &fields[index];
        let n = field.n_components;
        let component = match suffix {
            None => recipe.component.map(|c| c as usize).or((n == 1).then_some(0)),
            Some("mag") => None,
            Some("x" | "r") => Some(0),
            Some("y" | "g") => Some(1),
            Some("z" | "b") => Some(2),
            Some("w" | "a") => Some(3),
            Some(number) => {
                Some(number.parse().map_err(|_| impossible("component", number, "x, y, z, w, mag, or 0, 1, 2 ..."))?)
            }
        };
        if let Some(c) = component.filter(|c| *c >= n) {
            return Err(impossible("component", c, format!("the field has {n}, from 0")));
        }
        Ok(Self { index, field, component, grid: None })
    }

    /// All its values, in the order of the field's elements.
    fn values(self) -> impl Iterator<Item = f64> + 'a {
        let Self { field, component, .. } = self;
        let n = field.n_components;
        (0..field.n_elements()).map(move |i| match component {
            Some(c) => field.values.at(i * n + c),
            None => (0..n).map(|c| field.values.at(i * n + c)).map(|x| x * x).sum::<f64>().sqrt(),
        })
    }

    /// How its values lie about a range.
    fn census(self, range: [f64; 2]) -> Census {
        match (&self.field.values, self.field.n_components) {
            // Large fields of single numbers are counted at each change of the range.
            (Values::F32(v), 1) => Census::of(v.iter().map(|x| *x as f64), range),
            (Values::F64(v), 1) => Census::of(v.iter().copied(), range),
            _ => Census::of(self.values(), range),
        }
    }

    /// As it is measured at surface points.
    fn measured(self, missing: Missing) -> placement::Property {
        match self.grid {
            Some(Sampled { grid, distance, .. }) => {
                placement::Property::Grid { grid: grid.clone(), distance: *distance }
            }
            None => placement::Property::Field { field: self.index, component: self.component, missing },
        }
    }

    /// As a coordinate: the ends of `range` fall on 0 and 1. Shaded by light from `toward`.
    fn placement(self, range: [f64; 2], missing: Missing, toward: Option<Vec3>) -> Placement {
        let axis = PropertyAxis::over(self.measured(missing), range);
        match toward {
            Some(toward) => Placement::PropertyInLight { axis, toward },
            None => Placement::Property { axes: [Some(axis), None, None] },
        }
    }
}

/// How many values there are, and how they lie about a range.
#[derive(Default)]
struct Census {
    n: usize,
    n_missing: usize,
    n_infinite: usize,
    n_below: usize,
    n_above: usize,
    n_not_positive: usize,
}

impl Census {
    #[inline(always)]
    fn of(values: impl Iterator<Item = f64>, [low, high]: [f64; 2]) -> Self {
        let mut census = Self::default();
        for x in values {
            let is_finite = x.is_finite();
            census.n += 1;
            census.n_missing += x.is_nan() as usize;
            census.n_infinite += x.is_infinite() as usize;
            census.n_below += (is_finite & (x < low)) as usize;
            census.n_above += (is_finite & (x > high)) as usize;
            census.n_not_positive += (is_finite & (x <= 0.0)) as usize;
        }
        census
    }
}

/// A field as messages name it.
fn describe(field: &Field) -> String {
    let element = match field.element {
        Element::Vertex => "",
        Element::Face => "@faces",
        Element::Corner => "@corners",
    };
    match field.n_components {
        1 => format!("{}{element}", field.name),
        n => format!("{}{element} ({n} components)", field.name),
    }
}

/// The colour table of a recipe's layer as the picture shows it, and what a legend says about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// The field as the recipe asks for it.
    pub asked: String,
    /// The field's name.
    pub field: String,
    /// Which of its components; none: the vector's length.
    pub component: Option<usize>,
    /// As it is measured at surface points.
    pub property: placement::Property,
    /// What the values are.
    pub title: String,
    /// Their unit; empty when unknown.
    pub unit: String,
    /// The colours; its own range is [0, 1] for even scales.
    pub table: ColorTable,
    /// How values spread over it.
    pub scale: Scale,
    /// The table's name.
    pub table_name: String,
    /// The values at its ends.
    pub range: [f64; 2],
    /// How many values there are, are missing, lie before and beyond the range.
    pub counts: [usize; 4],
    /// How many bands the colours fall into; none: a continuous table.
    pub bands: Option<u32>,
}

impl Key {
    /// For a picture's metadata: field, unit, range, scale, table, bands, and how many values are not shown by it.
    pub fn to_json(&self) -> String {
        let [n, missing, before, beyond] = self.counts;
        let scale = match self.scale {
            Scale::Linear => "linear".to_owned(),
            Scale::Log => "log".to_owned(),
            Scale::SymLog { linear } => format!("symlog, linear up to {linear}"),
        };
        serde_json::json!({
            "field": self.field, "component": self.component, "title": self.title, "unit": self.unit, "range": self.range,
            "scale": scale, "table": self.table_name, "bands": self.bands, "values": n, "missing": missing,
            "below": before, "above": beyond,
        })
        .to_string()
    }

    /// Where a value stands on the table, 0 to 1 within its range; none when it is missing.
    pub fn share(&self, value: f64) -> Option<f64> {
        let place = |x: f64| if self.scale == Scale::Linear { x } else { self.scale.place(x as f32) as f64 };
        let [first, last] = self.range.map(place);
        Some((place(value) - first) / (last - first)).filter(|s| s.is_finite())
    }
}

/// How a layer's values become its texture's coordinate, worked out once.
struct Plan<'a> {
    property: Property<'a>,
    scale: Scale,
    /// For tables: the values at its ends.
    range: [f64; 2],
    /// What falls on 0 and on 1 of the coordinate.
    unit: [f64; 2],
    missing: Missing,
    notes: Vec<Mended>,
}

fn plan<'a>(recipe: &LayerRecipe, on: &'a Ground) -> Result<Plan<'a>> {
    let property = Property::of(recipe, on)?;
    let missing = choose_or(
        "missing_mode",
        &recipe.missing_mode,
        &[("nearest", Missing::Nearest), ("fan", Missing::Fan), ("hatch", Missing::Nearest)],
        Missing::Nearest,
    )?;
    let mut notes = Vec::new();
    if recipe.table.is_none() {
        let unit = unit_of(recipe, &property)?;
        return Ok(Plan { property, scale: Scale::Linear, range: unit, unit, missing, notes });
    }
    let is_log = recipe.value_scale.as_deref().is_some_and(|s| s.eq_ignore_ascii_case("log"));
    // A file that names values means them, unless the recipe says otherwise.
    let own = source::table(recipe.table.as_deref().unwrap_or_default(), on.base)?.range;
    let range = match recipe.range.is_none() && recipe.percentiles.is_none() && own != [0.0, 1.0] {
        true => own.map(f64::from),
        false => range(recipe, property, is_log, &mut notes)?,
    };
    let widest = range[0].abs().max(range[1].abs());
    let linear = recipe.linear_up_to.unwrap_or(widest * 0.01).max(f64::MIN_POSITIVE) as f32;
    if !(linear > 0.0 && linear.is_finite()) {
        return Err(impossible("linear_up_to", linear, "above 0"));
    }
    let known = [("linear", Scale::Linear), ("log", Scale::Log), ("symlog", Scale::SymLog { linear })];
    let scale = choose_or("value_scale", &recipe.value_scale, &known, Scale::Linear)?;
    if scale == Scale::Log && !(range[0] > 0.0 && range[1] > 0.0) {
        let why = "a logarithm needs values above 0; value_scale=symlog takes others, too";
        return Err(impossible("range", format!("{} to {}", range[0], range[1]), why));
    }
    // Even scales are counted in f64 from the range's first end, so that a small range far from zero keeps its digits.
    // Others by the greatest, so that the largest numbers stay within f32's sight.
    let unit = if scale == Scale::Linear { range } else { [0.0, widest] };
    Ok(Plan { property, scale, range, unit, missing, notes })
}

/// What falls on 0 and on 1 for lines and filters: a step, or the ends of what is kept.
fn unit_of(recipe: &LayerRecipe, property: &Property) -> Result<[f64; 2]> {
    if recipe.filter.is_some() {
        let name = &property.field.name;
        return Ok(match &recipe.threshold {
            Some(Numbers::One(t)) => [*t as f64, *t as f64 + 1.0],
            Some(Numbers::Each(v)) if v.len() == 2 && v[0] < v[1] => [v[0] as f64, v[1] as f64],
            Some(Numbers::Each(v)) if v.len() == 1 => [v[0] as f64, v[0] as f64 + 1.0],
            _ => {
                return Err(impossible(
                    "threshold",
                    format!("{:?}", recipe.threshold),
                    format!("a value of {name:?}, or two ascending ones"),
                ));
            }
        });
    }
    if let Some(levels) = &recipe.levels {
        let (least, most) = levels.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        if levels.is_empty() || !(least.is_finite() && most.is_finite()) {
            return Err(impossible("levels", format!("{levels:?}"), "some finite numbers"));
        }
        return Ok([least, if most > least { most } else { least + 1.0 }]);
    }
    let step = match recipe.isolines.unwrap_or(0.0) {
        // Ten or so, round.
        0.0 => {
            let range = range(&LayerRecipe::default(), *property, false, &mut Vec::new())?;
            round_step((range[1] - range[0]) / 10.0)
        }
        step => step,
    };
    let first = recipe.level.unwrap_or(0.0);
    match step > 0.0 && step.is_finite() && first.is_finite() {
        true => Ok([first, first + step]),
        false => Err(impossible("isolines", step, "a step above 0")),
    }
}

/// The 1, 2 or 5 times a power of ten that is nearest from above.
fn round_step(x: f64) -> f64 {
    use crate::math::exact::{log10, pow};
    let power = pow(10.0, log10(x.max(f64::MIN_POSITIVE)).floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * power).find(|step| *step >= x * 0.999).unwrap_or(x)
}

/// The colours that a field holds, as coordinates.
pub(super) fn colors(name: &str, on: &Ground) -> Result<Placement> {
    let axis = |component| {
        let recipe = LayerRecipe { field: Some(name.into()), component: Some(component), ..LayerRecipe::default() };
        let property = Property::of(&recipe, on)?.measured(Missing::Nearest);
        Ok(Some(PropertyAxis { property, scale: 1.0, offset: 0.0 }))
    };
    Ok(Placement::Property { axes: [axis(0)?, axis(1)?, axis(2)?] })
}

/// Where a data layer's coordinate comes from.
pub(super) fn placement(recipe: &LayerRecipe, on: &Ground) -> Result<Placement> {
    if !recipe.is_data() {
        let property = Property::of(recipe, on)?;
        let range = range(recipe, property, false, &mut Vec::new())?;
        return Ok(property.placement(range, Missing::Nearest, None));
    }
    let plan = plan(recipe, on)?;
    let toward = (recipe.shades == Some(true)).then_some(KEY_LIGHT);
    Ok(plan.property.placement(plan.unit, plan.missing, toward))
}

/// Towards the light of shaded tables, eye space: from the upper left front, as the studio's key light.
const KEY_LIGHT: Vec3 = vec3(-0.405_579_8, std::f32::consts::FRAC_1_SQRT_2, 0.579_227_97);

/// The range that a recipe gives, or that the values have.
fn range(recipe: &LayerRecipe, property: Property, is_log: bool, notes: &mut Vec<Mended>) -> Result<[f64; 2]> {
    if let Some(range) = recipe.range {
        return match range {
            [a, b] if a.is_finite() && b.is_finite() && a != b => Ok(range),
            _ => Err(impossible("range", format!("{range:?}"), "two finite numbers that differ")),
        };
    }
    let name = &property.field.name;
    let mut values: Vec<f64> = property.values().filter(|x| x.is_finite() && (!is_log || *x > 0.0)).collect();
    if values.is_empty() {
        note(notes, 1, format!("field {name:?} has no value to show"));
        return Ok(if is_log { [1.0, 10.0] } else { [0.0, 1.0] });
    }
    let [mut least, mut most] = match recipe.percentiles {
        None => {
            let ends = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
            [ends.0, ends.1]
        }
        Some(percentiles) => {
            if !percentiles.iter().all(|p| (0.0..=100.0).contains(p)) {
                return Err(impossible("percentiles", format!("{percentiles:?}"), "0 to 100"));
            }
            percentiles.map(|p| {
                let at = (p / 100.0 * (values.len() - 1) as f64).round() as usize;
                *values.select_nth_unstable_by(at, f64::total_cmp).1
            })
        }
    };
    if least == most {
        note(notes, values.len(), format!("values of {name:?} are all {least}"));
        if is_log {
            (least, most) = (least * 0.5, most * 2.0);
        } else {
            let margin = if least == 0.0 { 1.0 } else { least.abs() * 0.5 };
            (least, most) = (least - margin, most + margin);
        }
    }
    if let Some(center) = recipe.center {
        let reach = (most - center).abs().max((center - least).abs());
        (least, most) = (center - reach, center + reach);
    }
    Ok([least, most])
}

/// The texture of a data layer.
pub(super) fn texture(recipe: &LayerRecipe, on: &Ground, target: Target, mended: &mut Vec<Mended>) -> Result<Texture> {
    let plan = plan(recipe, on)?;
    if recipe.table.is_some() {
        return Ok(Texture::Table(in_unit(table(recipe, &plan, on)?, plan.unit)));
    }
    if recipe.isolines.is_some() {
        return Ok(Texture::Isolines(isolines(recipe, plan.unit)?));
    }
    Ok(Texture::Filter(filter(recipe, &plan, target, mended)?))
}

fn filter(recipe: &LayerRecipe, plan: &Plan, target: Target, mended: &mut Vec<Mended>) -> Result<Filter> {
    let per_unit = 1.0 / (plan.unit[1] - plan.unit[0]);
    let kept = choose_or("filter", &recipe.filter, &[("above", 0), ("below", 1), ("within", 2)], 0)?;
    let softness = recipe.softness.unwrap_or(0.0);
    if !(softness >= 0.0 && softness.is_finite()) {
        return Err(impossible("softness", softness, "0 or more"));
    }
    let white = [1.0; 4];
    let keep = [Keep::Above(0.0), Keep::Below(0.0), Keep::Within(0.0, 1.0)][kept];
    let is_kept = |x: f64| {
        let (above, below) = (x - plan.unit[0], plan.unit[1] - x);
        !x.is_finite() || [above, -above, above.min(below)][kept] >= -softness
    };
    if !plan.property.values().any(is_kept) {
        let name = &plan.property.field.name;
        note(mended, plan.property.values().count(), format!("values of {name:?} do not pass the filter, all of them"));
    }
    Ok(Filter {
        keep,
        softness: (softness * per_unit) as f32,
        color: recipe.color.as_deref().map_or(Ok(white), |c| color("filter color", c))?,
        is_lit: recipe.shades == Some(true) && target == Target::Color,
        is_number: target != Target::Color,
    })
}

/// A filter and the property it looks at.
pub(super) struct Filtering {
    pub(super) filter: Filter,
    /// Which values 0 and 1 of its coordinate stand for.
    pub(super) ends: [f64; 2],
    /// The property's least and greatest value.
    pub(super) range: [f64; 2],
    pub(super) title: String,
    pub(super) unit: String,
}

/// What a filter layer does.
pub(super) fn filter_of(recipe: &LayerRecipe, on: &Ground) -> Result<Filtering> {
    let plan = plan(recipe, on)?;
    let range = range(&LayerRecipe::default(), plan.property, false, &mut Vec::new())?;
    let field = plan.property.field;
    let filter = filter(recipe, &plan, Target::Color, &mut Vec::new())?;
    Ok(Filtering { filter, ends: plan.unit, range, title: field.name.clone(), unit: field.unit.clone() })
}

/// What a layer shows, and its range.
pub(super) fn property_of(recipe: &LayerRecipe, on: &Ground) -> Result<(placement::Property, [f64; 2])> {
    let plan = plan(recipe, on)?;
    let range = range(&LayerRecipe::default(), plan.property, false, &mut Vec::new())?;
    Ok((plan.property.measured(plan.missing), range))
}

/// An isoline layer's lines, and the values that 0 and 1 of their coordinate stand for.
pub(super) fn lines(recipe: &LayerRecipe, on: &Ground) -> Result<(Isolines, [f64; 2])> {
    let plan = plan(recipe, on)?;
    Ok((isolines(recipe, plan.unit)?, plan.unit))
}

/// A table over values that count in a unit of theirs; that of even scales is [0, 1] already.
fn in_unit(table: ColorTable, [from, to]: [f64; 2]) -> ColorTable {
    let share = |x: f32| ((x as f64 - from) / (to - from)) as f32;
    match table.scale {
        Scale::Linear => table,
        Scale::Log => ColorTable { range: table.range.map(share), ..table },
        Scale::SymLog { linear } => {
            ColorTable { range: table.range.map(share), scale: Scale::SymLog { linear: share(linear) }, ..table }
        }
    }
}

fn isolines(recipe: &LayerRecipe, [first, second]: [f64; 2]) -> Result<Isolines> {
    let width = recipe.width.unwrap_or(1.25);
    if !(width > 0.0 && width <= 64.0) {
        return Err(impossible("width", width, "above 0, at most 64 pixels"));
    }
    let dark: LinearRgba = [0.012, 0.012, 0.014, 0.9];
    let color = recipe.color.as_deref().map_or(Ok(dark), |c| color("line color", c))?;
    let levels = match &recipe.levels {
        None => Levels::Steps { step: 1.0, offset: 0.0 },
        Some(levels) => {
            let mut places: Vec<f32> = levels.iter().map(|l| ((l - first) / (second - first)) as f32).collect();
            places.sort_by(f32::total_cmp);
            Levels::List(places)
        }
    };
    let absent = if recipe.levels.is_some() { 0 } else { 5 };
    let major = match recipe.major.unwrap_or(absent) {
        0 => None,
        every => Some((every, Line { width: width * 2.0, color })),
    };
    Ok(Isolines { levels, minor: Line { width, color }, major })
}

/// The colour table of a layer, its scale and range as the values have them.
fn table(recipe: &LayerRecipe, plan: &Plan, on: &Ground) -> Result<ColorTable> {
    let mut table = source::table(recipe.table.as_deref().unwrap_or_default(), on.base)?;
    table.filter = choose_or("mag", &recipe.mag, &FILTERS, Interpolation::Nearest)?;
    if let Some(n) = recipe.bands {
        if !(1..=256).contains(&n) {
            return Err(impossible("bands", n, "1 to 256"));
        }
        table = table.banded(n as usize);
    }
    // After the bands were chosen: they are the same ones from either end.
    if recipe.reversed == Some(true) {
        table.colors.reverse();
    }
    table.scale = plan.scale;
    table.range = if plan.scale == Scale::Linear { [0.0, 1.0] } else { plan.range.map(|x| x as f32) };
    let word = |what: &str, given: &Option<String>| given.as_deref().map(|c| color(what, c)).transpose();
    table.below = word("below", &recipe.below)?;
    table.above = word("above", &recipe.above)?;
    table.missing = word("missing", &recipe.missing)?.unwrap_or(MISSING);
    let is_hatched = recipe.missing_mode.as_deref().is_some_and(|m| m.eq_ignore_ascii_case("hatch"));
    // Dark lines over a light colour, and the other way round.
    let [r, g, b, a] = table.missing;
    let line = if 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.18 { [0.02; 3] } else { [0.6; 3] };
    table.hatch = is_hatched.then_some([line[0], line[1], line[2], a]);
    if recipe.shades == Some(true) {
        let known =
            on.known.iter().find(|key| key.table.colors == table.colors).and_then(|key| key.table.shades.clone());
        table.shades = Some(known.unwrap_or_else(|| Shades::of(&table.colors)));
    }
    Ok(table)
}

/// What legends say about the table layers.
pub(super) fn keys(layers: &[LayerRecipe], on: &Ground, mended: &mut Vec<Mended>) -> Result<Vec<Key>> {
    let mut keys = Vec::new();
    for layer in layers.iter().filter(|l| l.table.is_some()) {
        let (key, notes) = key(layer, on)?;
        keys.push(key);
        mended.extend(notes);
    }
    Ok(keys)
}

/// A table layer's colours, and what a legend says about them.
fn key(recipe: &LayerRecipe, on: &Ground) -> Result<(Key, Vec<Mended>)> {
    let plan = plan(recipe, on)?;
    let table = table(recipe, &plan, on)?;
    let census = plan.property.census([plan.range[0].min(plan.range[1]), plan.range[0].max(plan.range[1])]);
    let field = plan.property.field;
    let component = match plan.property.component {
        Some(c) if field.n_components > 1 => {
            format!(" {}", ["x", "y", "z", "w"].get(c).map_or(c.to_string(), |s| (*s).into()))
        }
        None if field.n_components > 1 => " magnitude".into(),
        _ => String::new(),
    };
    let mut notes = plan.notes;
    note(&mut notes, census.n_missing, format!("values of {:?} are missing", field.name));
    note(&mut notes, census.n_infinite, format!("values of {:?} are infinite, shown as missing", field.name));
    if plan.scale == Scale::Log {
        note(
            &mut notes,
            census.n_not_positive,
            format!("values of {:?} are 0 or less: they have no logarithm", field.name),
        );
    }
    let key = Key {
        asked: recipe.field.clone().unwrap_or_default(),
        field: field.name.clone(),
        component: plan.property.component,
        property: plan.property.measured(plan.missing),
        scale: plan.scale,
        title: recipe.label.clone().unwrap_or_else(|| format!("{}{component}", field.name)),
        unit: recipe.unit_label.clone().unwrap_or_else(|| field.unit.clone()),
        table,
        table_name: recipe.table.clone().unwrap_or_default(),
        range: plan.range,
        counts: [census.n, census.n_missing + census.n_infinite, census.n_below, census.n_above],
        bands: recipe.bands,
    };
    Ok((key, notes))
}

/// Colour of missing values: a grey that no table shows, a little transparent to nothing.
const MISSING: LinearRgba = [0.40, 0.40, 0.40, 1.0];

/// The colours of a table layer at the mesh's vertices, for Gouraud's way.
pub(super) fn vertex_colors(recipe: &LayerRecipe, on: &Ground) -> Result<Vec<LinearRgba>> {
    let plan = plan(recipe, on)?;
    let table = in_unit(table(recipe, &plan, on)?, plan.unit);
    if plan.property.field.element != Element::Vertex {
        return Err(Error::Parameter {
            what: "gouraud".into(),
            given: plan.property.field.name.clone(),
            why: "it needs one value a vertex".into(),
        });
    }
    let [from, to] = plan.unit;
    Ok(plan.property.values().map(|x| table.color(((x - from) / (to - from)) as f32)).collect())
}
