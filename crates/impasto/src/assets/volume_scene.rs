//! Grids as scenes: an isosurface, or two of opposite sign.

use crate::assets::isolevel::Levels;
use crate::assets::isosurface::{self, Options, Side};
use crate::assets::text::format_error;
use crate::assets::volume::{Kind, Volume};
use crate::assets::{Element, Field, Grid, Material, Part, RawMesh, Scene, Values};
use crate::error::{Report, Result, note};
use std::path::Path;

/// Grids with more points are thinned before they are shown.
const MOST_POINTS: usize = 1 << 24;

/// The first grid's isosurface at a level, or at one that suits its values, with the field `gradient`: how fast the values
/// change there.
///
/// # Errors
/// `Format` when there is no surface at the level.
pub fn to_scene(volume: Volume, kind: Kind, name: String, level: Option<f64>) -> Result<Report<Scene>> {
    let mut mended = Vec::new();
    let path = Path::new(&name);
    let length_unit = volume.length_unit;
    let mut grids = volume.grids.into_iter();
    let Some(grid) = grids.next() else { return Err(format_error(path, "no grid in it")) };
    note(&mut mended, grids.len(), "further grids not shown");
    let n_points = grid.values().len();
    let (grid, step) = grid.thinned(MOST_POINTS);
    note(
        &mut mended,
        n_points - grid.values().len(),
        format!("points left out: blocks of {step} x {step} x {step} joined"),
    );
    let range = grid.range();
    note(&mut mended, range.n_missing, "points without a value left as holes");
    let levels = match level {
        Some(level) => Levels::asked(&grid, level),
        None => Levels::automatic(&grid, kind).ok_or_else(|| {
            let fault = format!("no surface in it: all values are {} or missing", range.min);
            format_error(path, fault)
        })?,
    };
    let mut raw = RawMesh::default();
    let mut materials = Vec::new();
    for &(level, side) in &levels.levels {
        let mesh = isosurface::of(&grid, &Options { level, side, closed: true });
        if mesh.triangles().is_empty() {
            continue;
        }
        append(&mut raw, mesh.into_raw(), &format!("{} {}", grid.name, number(level)), materials.len() as u32);
        materials.push(material(side, levels.levels.len() > 1));
    }
    let said = levels.levels.iter().map(|(l, _)| number(*l)).collect::<Vec<_>>().join(" and ");
    let unit = if grid.unit.is_empty() { String::new() } else { format!(" {}", grid.unit) };
    if raw.triangles.is_empty() {
        let fault = format!("no surface at {said}{unit}: its values run from {} to {}", range.min, range.max);
        return Err(format_error(path, fault));
    }
    raw.fields = vec![steepness(&grid, &raw, length_unit)];
    let up_note = format!("grid: axes as in the file; isosurface of {} at {said}{unit}: {}", grid.name, levels.why);
    let scene = Scene { materials, up_note, ..Scene::of(name.clone(), raw.trusted()) };
    Ok(Report { value: scene, mended })
}

/// A level for people: six digits.
fn number(x: f64) -> String {
    let text = format!("{x:.6e}");
    text.parse::<f64>().map_or(text, |x| x.to_string())
}

fn append(raw: &mut RawMesh, other: RawMesh, name: &str, material: u32) {
    let (first, start) = (raw.positions.len() as u32, raw.triangles.len() as u32);
    raw.positions.extend(other.positions);
    raw.normals.extend(other.normals);
    raw.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    let triangles = start..raw.triangles.len() as u32;
    raw.parts.push(Part { name: name.into(), triangles, material: Some(material) });
}

/// Blue for greater values, red for lesser ones; a neutral colour for one surface alone.
fn material(side: Side, is_one_of_two: bool) -> Material {
    let (name, color) = match (is_one_of_two, side) {
        (false, _) => ("isosurface", [0.42, 0.50, 0.56, 1.0]),
        (true, Side::Above) => ("positive", [0.09, 0.20, 0.62, 1.0]),
        (true, Side::Below) => ("negative", [0.60, 0.06, 0.05, 1.0]),
    };
    Material { name: name.into(), base_color: color, roughness: 0.4, ..Material::default() }
}

/// The length of the gradient at the vertices.
fn steepness(grid: &Grid, raw: &RawMesh, length_unit: &str) -> Field {
    let unit = match (grid.unit.as_str(), length_unit) {
        ("", _) | (_, "") => String::new(),
        (unit, length) => format!("{unit}/{length}"),
    };
    let values = raw.positions.iter().map(|p| grid.gradient(*p).length()).collect();
    Field { name: "gradient".into(), unit, element: Element::Vertex, n_components: 1, values: Values::F32(values) }
}
