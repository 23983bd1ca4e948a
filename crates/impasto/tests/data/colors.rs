//! Every pixel has the colour that the table has for its value.

use crate::oracle::{self, Seen, cone, entry, field, front, plain, prepare, seen, sheet, sphere, table, with_values};
use impasto::assets::{Element, RawMesh, Values};
use impasto::math::DVec3;
use impasto::recipe::Prepared;

/// Values this near to an entry's border, as a share of the range, may have either colour.
const NEAR: f64 = 1e-5;

/// The share of the table at which each pixel's value stands must be the pixel's entry. Answers with how many were looked at.
fn check(prepared: &Prepared, what: &str, share: impl Fn(&Seen) -> f64) -> usize {
    let table = table(prepared);
    let n = table.colors.len();
    let pixels = seen(prepared);
    let mut n_sure = 0;
    for pixel in &pixels {
        let share = share(pixel);
        let Some(wanted) = entry(share, n, NEAR) else { continue };
        n_sure += 1;
        assert_eq!(
            pixel.light, table.colors[wanted],
            "{what}, pixel {:?}: share {share} is entry {wanted}",
            pixel.cell
        );
    }
    assert!(n_sure * 100 > pixels.len() * 95, "{what}: {n_sure} of {} pixels are sure", pixels.len());
    n_sure
}

const OBLIQUE: &str = "camera = { azimuth = 33.0, elevation = 41.0 }\n";

fn meshes() -> Vec<(&'static str, RawMesh, String)> {
    vec![
        ("two triangles", sheet(1, |_, _| 0.0), front(240)),
        ("ramp", sheet(4, |x, y| 0.7 * x - 0.2 * y), format!("{OBLIQUE}{}", plain(200))),
        ("cone", cone(24), format!("{OBLIQUE}{}", plain(200))),
        ("sphere", sphere(), format!("{OBLIQUE}{}", plain(240))),
        ("sphere near by", sphere(), format!("camera = {{ eye = [0.3, 0.8, 1.2], fov = 60.0 }}\n{}", plain(240))),
    ]
}

#[test]
fn pixels_are_the_entries_of_their_values() {
    // Linear over space, so that the truth does not depend on the triangles at all.
    let truth = |p: DVec3| 0.37 * p.x + 0.51 * p.y - 0.23 * p.z + 0.04;
    for (name, raw, view) in meshes() {
        // Also a small range far from zero: the file's f64 count, not f32.
        for (scale, offset) in [(1.0, 0.0), (1e-9, 0.0), (3e7, -2e6), (1.0, 1e6)] {
            let raw = with_values(raw.clone(), "v", |p| truth(p) * scale + offset);
            for table in ["table = 'viridis'", "table = 'coolwarm'\nbands = 8", "table = 'grey'\nbands = 3"] {
                let (least, most) = (-0.8 * scale + offset, 0.9 * scale + offset);
                let layer = format!("[[layers]]\n{table}\nfield = 'v'\nrange = [{least:e}, {most:e}]");
                let prepared = prepare(&raw, &format!("{view}{layer}"));
                // Numbers a file has once are rounded once; what is left of them at the vertices is the truth here.
                let what = format!("{name}, {table}, times {scale} plus {offset}");
                let share = |s: &Seen| {
                    let v = if offset == 0.0 { truth(s.place) * scale } else { field_value(&prepared, s) };
                    (v - least) / (most - least)
                };
                assert!(check(&prepared, &what, share) > 3_000, "{what}");
            }
        }
    }
}

fn field_value(prepared: &Prepared, s: &Seen) -> f64 {
    oracle::value(&prepared.scene.mesh, "v", Some(0), s)
}

#[test]
fn edges_of_bands_are_where_the_curve_is() {
    const N: u32 = 256;
    // Rings: finer than a pixel's fraction, the triangles do not matter.
    let raw = with_values(sheet(128, |_, _| 0.0), "v", |p| p.x.hypot(p.y));
    let layer = "[[layers]]\ntable = 'viridis'\nbands = 6\nfield = 'v'\nrange = [0.0, 1.2]";
    let prepared = prepare(&raw, &format!("{}{layer}", front(N)));
    let pixels = seen(&prepared);
    assert_eq!(pixels.len(), (N * N) as usize);
    let (mut n_edges, mut farthest) = (0, 0.0_f64);
    for pair in pixels.windows(2).filter(|p| p[0].cell[1] == p[1].cell[1] && p[0].light != p[1].light) {
        // The edge is taken halfway between two pixels that differ; rings are 0.2 apart.
        let middle = (pair[0].place + pair[1].place) * 0.5;
        let radius = middle.x.hypot(middle.y);
        let ring = (radius / 0.2).round() * 0.2;
        farthest = farthest.max((radius - ring).abs() * N as f64 * 0.5);
        n_edges += 1;
    }
    assert!(n_edges > 1000 && farthest <= 0.5, "{n_edges} edges, at most {farthest} px from the curve");
}

#[test]
fn logarithms_are_taken_of_interpolated_values() {
    let ramp = |p: DVec3| 1.0 + 999.0 * (p.x + 1.0) / 2.0;
    let raw = with_values(sheet(1, |_, _| 0.0), "v", ramp);
    let raw = with_values(raw, "both", |p| 500.0 * p.x);
    for bands in ["", "bands = 9\n"] {
        let layer = |keys: &str| format!("{}[[layers]]\ntable = 'viridis'\n{bands}{keys}", front(256));
        let log = prepare(&raw, &layer("field = 'v'\nvalue_scale = 'log'\nrange = [1.0, 1000.0]"));
        check(&log, "log", |s| ramp(s.place).log10() / 3.0);
        let reversed = prepare(&raw, &layer("field = 'v'\nvalue_scale = 'log'\nrange = [1000.0, 1.0]"));
        check(&reversed, "log reversed", |s| 1.0 - ramp(s.place).log10() / 3.0);
        let symlog = prepare(
            &raw,
            &layer("field = 'both'\nvalue_scale = 'symlog'\nlinear_up_to = 2.0\nrange = [-500.0, 500.0]"),
        );
        let place = |x: f64| (1.0 + x.abs() / 2.0).ln().copysign(x);
        check(&symlog, "symlog", |s| 0.5 + 0.5 * place(500.0 * s.place.x) / place(500.0));
    }
    // Over many powers of ten, on small triangles, too, and where values are huge.
    for (least, most) in [(1e-6, 1e6), (1e3, 1e15), (1e-22, 1e-10)] {
        let raw = with_values(sphere(), "v", |p| least * 10f64.powf(6.0 + 6.0 * p.y));
        let layer =
            format!("[[layers]]\ntable = 'viridis'\nfield = 'v'\nvalue_scale = 'log'\nrange = [{least:e}, {most:e}]");
        let prepared = prepare(&raw, &format!("{OBLIQUE}{}{layer}", plain(240)));
        let share = |v: f64| (v / least).log10() / 12.0;
        let (table, mut n_sure) = (table(&prepared), 0);
        // A corner is drawn at the nearest 1/256 of a pixel: a triangle may cover a place right outside of it, and has the
        // value of its edge there.
        for s in seen(&prepared).into_iter().filter(|s| s.weights.iter().all(|w| *w >= 0.0)) {
            let v = field_value(&prepared, &s);
            // What f32 corners leave open on triangles that are seen from the side: the values right beside.
            let mesh = &prepared.scene.mesh;
            let corners = mesh.triangles()[s.triangle].map(|c| mesh.fields()[0].values.at(c as usize));
            let change = |w: &[f64; 3]| (0..3).map(|k| (w[k] - s.weights[k]) * corners[k]).sum::<f64>().abs();
            let open = s.beside.iter().map(change).sum::<f64>();
            let [low, high] = [v - open, v + open].map(|v| entry(share(v.max(least)), 256, NEAR));
            if let (Some(low), Some(high)) = (low, high)
                && low == high
            {
                n_sure += 1;
                assert_eq!(s.light, table.colors[low], "from {least}, pixel {:?}: {v}", s.cell);
            }
        }
        assert!(n_sure > 20_000, "{n_sure} pixels are sure");
    }
}

#[test]
fn a_shifted_range_is_a_shifted_table() {
    let raw = with_values(sphere(), "v", |p| p.x + 0.5 * p.y);
    let raw = with_values(raw, "shifted", |p| p.x + 0.5 * p.y + 4.0);
    let picture = |keys: &str| {
        let prepared =
            prepare(&raw, &format!("{OBLIQUE}{}[[layers]]\ntable = 'viridis'\nbands = 16\n{keys}", plain(160)));
        (seen(&prepared).into_iter().map(|s| s.light).collect::<Vec<_>>(), table(&prepared).clone())
    };
    let (plain, own) = picture("field = 'v'\nrange = [-1.0, 1.0]");
    let (shifted, _) = picture("field = 'shifted'\nrange = [3.0, 5.0]");
    let differ = plain.iter().zip(&shifted).filter(|(a, b)| a != b).count();
    assert!(differ * 10_000 < plain.len(), "{differ} of {} pixels", plain.len());
    // By two entries: each colour becomes the one two before it.
    let (moved, _) = picture("field = 'v'\nrange = [-0.75, 1.25]");
    let entry_of = |c: &[f32; 4]| own.colors.iter().position(|x| x == c).expect("a colour of the table");
    // What lies beyond the first range has no entry of its own there.
    let inside = plain.iter().zip(&moved).filter(|(a, _)| entry_of(a) < 15);
    let wrong = inside.filter(|(a, b)| entry_of(a).saturating_sub(2) != entry_of(b)).count();
    assert!(wrong * 1000 < plain.len(), "{wrong} of {} pixels", plain.len());
    // A range from its end, and a table from its end, are one.
    let (range_reversed, _) = picture("field = 'v'\nrange = [1.0, -1.0]");
    let (table_reversed, _) = picture("field = 'v'\nrange = [-1.0, 1.0]\nreversed = true");
    let differ = range_reversed.iter().zip(&table_reversed).filter(|(a, b)| a != b).count();
    assert!(differ * 1000 < plain.len(), "{differ} of {} pixels", plain.len());
    assert!(plain.iter().zip(&table_reversed).all(|(a, b)| entry_of(a) == 15 - entry_of(b)));
}

#[test]
fn faces_components_and_magnitudes_are_told_apart() {
    let mut raw = with_values(sphere(), "v", |p| p.x);
    let n = raw.triangles.len();
    raw.fields.push(field("v", Element::Face, 1, Values::F64((0..n).map(|i| (i * 7 % 100) as f64).collect())));
    let vectors = raw.positions.iter().flat_map(|p| [p.x as f64 * 3.0, p.y as f64, p.z as f64 - 2.0]).collect();
    raw.fields.push(field("w", Element::Vertex, 3, Values::F64(vectors)));
    let picture = |keys: &str| prepare(&raw, &format!("{OBLIQUE}{}[[layers]]\ntable = 'viridis'\n{keys}", plain(160)));

    let faces = picture("field = 'v@faces'\nrange = [-0.3, 99.7]");
    check(&faces, "faces", |s| ((s.triangle * 7 % 100) as f64 + 0.3) / 100.0);
    let vertices = picture("field = 'v@vertices'\nrange = [-1.0, 1.0]");
    check(&vertices, "vertices", |s| (s.place.x + 1.0) * 0.5);
    for (keys, truth) in [
        ("field = 'w.x'", (|p| 3.0 * p.x) as fn(DVec3) -> f64),
        ("field = 'w.1'", |p| p.y),
        ("field = 'w'\ncomponent = 2", |p| p.z - 2.0),
    ] {
        let prepared = picture(&format!("{keys}\nrange = [-4.0, 4.0]"));
        check(&prepared, keys, |s| (truth(s.place) + 4.0) / 8.0);
    }
    // Lengths are taken at the vertices, and interpolated as any number is.
    for keys in ["field = 'w.mag'", "field = 'w'"] {
        let prepared = picture(&format!("{keys}\nrange = [0.0, 4.0]"));
        check(&prepared, keys, |s| oracle::value(&prepared.scene.mesh, "w", None, s) / 4.0);
    }
}
