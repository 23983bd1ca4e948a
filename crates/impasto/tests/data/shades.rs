//! What is read off a picture is its value: of the gallery's pictures by the table, of shaded ones by eye.

use crate::oracle::{prepare, seen, sphere, table, value, with_values};
use impasto::assets::{Element, Mesh};
use impasto::color::{LinearRgba, lab_from_linear, linear_from_srgb};
use impasto::inspect;
use impasto::lookup::ColorTable;
use impasto::par::Workers;
use impasto::recipe::{self, text};
use impasto::visibility::Samples;
use std::path::{Path, PathBuf};

/// All recipes of the gallery.
fn recipes() -> Vec<PathBuf> {
    let gallery = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../gallery");
    let entries =
        |folder: &Path| -> Vec<PathBuf> { std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect() };
    let topics = entries(&gallery).into_iter().filter(|p| p.is_dir());
    let mut found: Vec<PathBuf> =
        topics.flat_map(|t| entries(&t)).filter(|p| p.extension().is_some_and(|e| e == "toml")).collect();
    found.sort();
    found
}

#[test]
fn picked_values_give_the_pixels_of_the_gallery() {
    let workers = Workers::new(1);
    let mut n_recipes = 0;
    for path in recipes() {
        let mut recipe = text::parse(&std::fs::read_to_string(&path).unwrap(), &path).unwrap();
        let Some(layer) = recipe.layers.iter().rfind(|l| l.table.is_some() && l.gouraud != Some(true)).cloned() else {
            continue;
        };
        // The table's colours alone: without lines over them, and without shades.
        recipe.layers.retain(|l| *l == layer);
        recipe.layers[0].shades = None;
        recipe.picture.unlit = Some(true);
        recipe.picture.samples = Some(1);
        recipe.picture.size = Some([56, 42]);
        recipe.picture.ground = None;
        recipe.legend = Default::default();
        recipe.legend.place = Some("none".into());
        let prepared = recipe::prepare(&recipe, path.parent().unwrap(), &workers).unwrap().value;
        let picture = prepared.light(&workers, &|_| ());
        let (domain, shot) = (prepared.domain(), prepared.shot(Samples::One));
        let given = layer.field.as_deref().unwrap_or_default();
        let Some((index, component)) = named(&prepared.scene.mesh, given) else { continue };
        let table = table(&prepared);
        let [from, to] = prepared.keys[0].range;
        let buffer = inspect::probe::buffer(&domain, &shot, &workers);
        let shown = inspect::measured(&prepared.keys[0].property, &buffer, &domain, &workers);
        let mut n_covered = 0;
        for cell in 0..56 * 42 {
            let probe = inspect::probe(&domain, &shot, [cell % 56, cell / 56], &workers);
            let Some(found) = probe.found.first() else { continue };
            if layer.missing_mode.is_some() && shown[cell as usize].is_nan() {
                let drawn = picture.light[cell as usize];
                assert!(drawn == table.missing || Some(drawn) == table.hatch, "{path:?}, pixel {:?}", probe.cell);
                n_covered += 1;
                continue;
            }
            let numbers = &found.fields[index];
            let picked = component.map_or_else(|| numbers.iter().map(|x| x * x).sum::<f64>().sqrt(), |c| numbers[c]);
            let is_even = table.range == [0.0, 1.0] && table.scale == Default::default();
            // Logarithms count in units of the range's greatest value.
            let at = if is_even { (picked - from) / (to - from) } else { picked / from.abs().max(to.abs()) };
            let place = at * table.colors.len() as f64;
            // On a border between two entries the last digit decides.
            let is_border = is_even && (place - place.round()).abs() < 1e-3;
            let drawn = picture.light[cell as usize];
            assert!(is_border || drawn == table.color(at as f32), "{path:?}, pixel {:?}: {picked}", probe.cell);
            n_covered += 1;
        }
        assert!(n_covered > 200, "{path:?}: {n_covered} pixels are covered");
        n_recipes += 1;
    }
    assert!(n_recipes >= 2, "the gallery has recipes with data");
}

/// The field and the component that a recipe names; none for vectors' lengths, which are not picked but looked up.
fn named(mesh: &Mesh, given: &str) -> Option<(usize, Option<usize>)> {
    let name = given.split('@').next().unwrap_or(given);
    let find = |name: &str| mesh.fields().iter().position(|f| f.name == name && f.element == Element::Vertex);
    if let Some(index) = find(name) {
        return (mesh.fields()[index].n_components == 1).then_some((index, Some(0)));
    }
    let (stem, suffix) = name.rsplit_once('.')?;
    let component = ["x", "y", "z"].iter().position(|s| *s == suffix).or_else(|| suffix.parse().ok())?;
    Some((find(stem)?, Some(component)))
}

/// The value that a reader finds for a colour: that of the nearest in Lab.
fn read_off(labs: &[[f64; 3]], seen: LinearRgba) -> f64 {
    // The picture has bytes.
    let byte = |x: f32| linear_from_srgb(impasto::color::srgb8_from_linear(x) as f64 / 255.0);
    let lab = lab_from_linear([byte(seen[0]), byte(seen[1]), byte(seen[2])]);
    let squared = |other: &[f64; 3]| (0..3).map(|k| (other[k] - lab[k]).powi(2)).sum::<f64>();
    let nearest = (0..labs.len()).min_by(|a, b| squared(&labs[*a]).total_cmp(&squared(&labs[*b])));
    (nearest.expect("a table has entries") as f64 + 0.5) / labs.len() as f64
}

fn labs(table: &ColorTable) -> Vec<[f64; 3]> {
    table.colors.iter().map(|c| lab_from_linear([c[0] as f64, c[1] as f64, c[2] as f64])).collect()
}

#[test]
fn shaded_colours_are_read_as_their_values() {
    // Values that go another way than the light does, so that every value is seen in light and in shadow.
    let raw = with_values(sphere(), "v", |p| (2.3 * p.x).sin() + 0.8 * (3.1 * p.y + p.z).sin());
    for (name, bands) in [("viridis", 0), ("coolwarm", 0), ("grey", 0), ("viridis", 10)] {
        let bands_key = if bands > 0 { format!("bands = {bands}\n") } else { String::new() };
        let recipe = format!(
            "camera = {{ azimuth = 30.0, elevation = 20.0 }}\npicture = {{ size = [240, 240], samples = 1 }}\n\
             surface = {{ shading = 'unlit' }}\n[[layers]]\ntable = '{name}'\n{bands_key}field = 'v'\nshades = true"
        );
        let prepared = prepare(&raw, &recipe);
        let [from, to] = prepared.keys[0].range;
        let table = table(&prepared);
        let labs = labs(table);
        let (mut errors, mut lightness) = (Vec::new(), Vec::new());
        for s in seen(&prepared) {
            let share = (value(&prepared.scene.mesh, "v", Some(0), &s) - from) / (to - from);
            let read = read_off(&labs, s.light);
            // Within a band all values look alike: what counts is the band.
            let wrong = if bands > 0 {
                ((share * bands as f64).floor().min(bands as f64 - 1.0) - (read * bands as f64).floor()).abs()
                    / bands as f64
            } else {
                (share - read).abs()
            };
            errors.push(wrong);
            let own = labs[((share * labs.len() as f64) as usize).min(labs.len() - 1)];
            let shown = lab_from_linear([s.light[0] as f64, s.light[1] as f64, s.light[2] as f64]);
            lightness.push((0..3).map(|k| (shown[k] - own[k]).powi(2)).sum::<f64>().sqrt());
        }
        errors.sort_by(f64::total_cmp);
        lightness.sort_by(f64::total_cmp);
        let p95 = errors[errors.len() * 95 / 100];
        assert!(p95 <= 0.02, "{name} in {bands} bands: read off {p95} of the range wrong at p95");
        // And still the form is seen.
        let moved = lightness[lightness.len() / 2];
        assert!(moved > 2.0, "{name} in {bands} bands: shades are {moved} of Lab from the table");
    }
}
