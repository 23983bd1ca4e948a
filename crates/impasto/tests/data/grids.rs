//! Values on 3-D grids, read at every pixel's surface point: not between vertices.

use crate::lines::check_widths;
use crate::oracle::{entry, front, plain, prepare_with, seen, sheet, sphere, table};
use impasto::math::DVec3;
use impasto::recipe::Prepared;
use std::path::Path;

/// A function on `n` points a side over [-1.5, 1.5], as an OpenDX file.
fn dx(n: usize, value: impl Fn(DVec3) -> f64) -> String {
    let step = 3.0 / (n - 1) as f64;
    let mut text = format!(
        "object 1 class gridpositions counts {n} {n} {n}\norigin -1.5 -1.5 -1.5\n\
         delta {step} 0 0\ndelta 0 {step} 0\ndelta 0 0 {step}\n\
         object 2 class gridconnections counts {n} {n} {n}\n\
         object 3 class array type double rank 0 items {} data follows\n",
        n * n * n
    );
    let at = |i: usize| i as f64 * step - 1.5;
    for i in 0..n * n * n {
        let place = DVec3::new(at(i / (n * n)), at(i / n % n), at(i % n));
        text += &format!("{}\n", value(place));
    }
    text
}

fn truth(p: DVec3) -> f64 {
    0.4 * p.x - 0.3 * p.y + 0.6 * p.z
}

fn check(prepared: &Prepared, what: &str, truth: impl Fn(DVec3) -> f64) {
    let table = table(prepared);
    let mut n_sure = 0;
    let pixels = seen(prepared);
    for s in &pixels {
        let Some(wanted) = entry(truth(s.place) * 0.5 + 0.5, table.colors.len(), 1e-5) else { continue };
        n_sure += 1;
        assert_eq!(s.light, table.colors[wanted], "{what}, pixel {:?}", s.cell);
    }
    assert!(n_sure > 10_000 && n_sure * 100 > pixels.len() * 95, "{what}: {n_sure} of {}", pixels.len());
}

#[test]
fn pixels_show_the_grid_where_they_are() {
    let files = [("g.dx", dx(7, truth))];
    let keys = "[[layers]]\ntable = 'viridis'\ngrid = 'g.dx'\nrange = [-1.0, 1.0]\n";
    let view = format!("camera = {{ azimuth = 33.0, elevation = 41.0 }}\n{}", plain(240));
    check(&prepare_with(&sphere(), &format!("{view}{keys}"), &files), "sphere", truth);
    let flat = sheet(1, |_, _| 0.0);
    check(&prepare_with(&flat, &format!("{}{keys}", front(160)), &files), "two triangles", truth);
    // A quarter unit in front of the sheet.
    let off = prepare_with(&flat, &format!("{}{keys}grid_offset = 0.25", front(160)), &files);
    check(&off, "off the sheet", |p| truth(p + DVec3::new(0.0, 0.0, 0.25)));
}

#[test]
fn two_triangles_show_all_of_a_grid() {
    // What happens between the vertices is seen: rings, where the corners all have one value.
    let files = [("g.dx", dx(121, |p| p.x.hypot(p.y)))];
    let keys = "[[layers]]\ntable = 'viridis'\nbands = 6\ngrid = 'g.dx'\nrange = [0.0, 1.2]";
    let prepared = prepare_with(&sheet(1, |_, _| 0.0), &format!("{}{keys}", front(200)), &files);
    let table = table(&prepared);
    let pixels = seen(&prepared);
    let wrong = pixels.iter().filter(|s| {
        let wanted = entry(s.place.x.hypot(s.place.y) / 1.2, 6, 1e-3);
        wanted.is_some_and(|wanted| s.light != table.colors[wanted])
    });
    assert_eq!(wrong.count(), 0);
}

#[test]
fn lines_of_grids_are_as_wide_as_asked_for() {
    let lines = "surface = { color = '#000000' }\n[[layers]]\ncolor = '#ffffff'\nmajor = 0\n\
                 isolines = 0.0\nlevels = [0.35, 0.5, 0.62, 0.85]\nwidth = 2.0\ngrid = 'g.dx'";
    let rings = [("g.dx", dx(121, |p| p.x.hypot(p.y)))];
    let prepared = prepare_with(&sheet(1, |_, _| 0.0), &format!("{}{lines}", front(240)), &rings);
    check_widths(&prepared, "rings", (2.0, 800, 0.25), |s| s.place.x.hypot(s.place.y));
    // On a sphere, through a camera: slices, none of them beside an edge that it runs along, where slopes change within
    // the line's width.
    let slices = [("g.dx", dx(9, |p| p.y))];
    let view = format!("camera = {{ azimuth = 10.0, elevation = 85.0 }}\n{}", plain(300));
    let prepared = prepare_with(
        &sphere(),
        &format!("{view}{}", lines.replace("0.35, 0.5, 0.62, 0.85", "0.63, 0.77, 0.88")),
        &slices,
    );
    check_widths(&prepared, "slices", (2.0, 300, 0.35), |s| s.place.y);
}

#[test]
fn outside_of_a_grid_and_in_its_holes_nothing_is_known() {
    let files = [("g.dx", dx(7, |p| if p.x > 0.9 { f64::NAN } else { p.y }))];
    let keys = "[[layers]]\ntable = 'viridis'\ngrid = 'g.dx'\nrange = [-1.0, 1.0]\nmissing = '#ff00ff'";
    let mut raw = sheet(1, |_, _| 0.0);
    raw.positions.iter_mut().for_each(|p| *p *= 2.0);
    let prepared = prepare_with(&raw, &format!("{}{keys}", front(160)), &files);
    let missing = table(&prepared).missing;
    for s in seen(&prepared) {
        // The hole reaches to the last point with a value, at 1/2.
        let is_known = s.place.x.abs() < 1.499 && s.place.y.abs() < 1.499 && s.place.x < 0.499;
        let is_unknown = s.place.x.abs() > 1.502 || s.place.y.abs() > 1.502 || s.place.x > 0.501;
        assert!(is_known || is_unknown || s.place.abs().max_element() > 0.4);
        assert!(!(is_known && s.light == missing || is_unknown && s.light != missing), "{:?}", s.place);
    }
    assert_eq!(prepared.keys[0].counts[..2], [4, 4], "all four corners lie outside");
}

/// Real grids on their own surfaces: what the grid says and what the file says at its vertices agree.
#[test]
fn grids_agree_with_the_values_that_were_made_from_them() {
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/5_science"));
    if !data.is_dir() {
        println!("skipped: no data at {data:?}");
        return;
    }
    let workers = impasto::par::Workers::new(1);
    for (mesh, grid, name, offset) in [
        ("ethanol/ethanol_iso0.002_mep.ply", "ethanol/ethanol_mep.cube", "mep", 0.0),
        // Made 1.4 A outside of the surface, where water begins.
        ("gramicidin/1grm_gauss_surface_pot.ply", "gramicidin/1grm_pot-PE0.dx.gz", "potential", 1.4),
    ] {
        let toml = format!(
            "input.file = '{mesh}'\n{}surface.shading = 'unlit'\n[[layers]]\ntable = 'viridis'\ngrid = '{grid}'\n\
             grid_offset = {offset:?}",
            plain(120)
        );
        let mut recipe = impasto::recipe::text::parse(&toml, Path::new("inline")).unwrap();
        recipe.legend.place = Some("none".into());
        let prepared = impasto::recipe::prepare(&recipe, data, &workers).unwrap().value;
        let mesh = &prepared.scene.mesh;
        let index = mesh.fields().iter().position(|f| f.name == name).expect("the file has it");
        let field = mesh.fields()[index].range(0);
        let [from, to] = prepared.keys[0].range;
        let span = field.max - field.min;
        assert!(
            (from - field.min).abs() < 0.05 * span && (to - field.max).abs() < 0.05 * span,
            "{from} {to} {field:?}"
        );
        let table = table(&prepared);
        let (mut n_near, mut n) = (0, 0);
        for s in seen(&prepared) {
            let wanted = entry((crate::oracle::value(mesh, name, Some(0), &s) - from) / (to - from), 256, 0.0);
            let got = table.colors.iter().position(|c| *c == s.light).expect("a colour of the table");
            n += 1;
            n_near += (wanted.expect("an entry").abs_diff(got) <= 6) as usize;
        }
        assert!(n > 2000 && n_near * 100 > n * 97, "{grid}: {n_near} of {n} pixels agree");
    }
}
