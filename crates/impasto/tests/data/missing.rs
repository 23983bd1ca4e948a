//! A missing value is shown as missing, where it is missing and nowhere else.

use crate::oracle::{front, plain, prepare, seen, sheet, sphere, table, with_values};
use impasto::assets::RawMesh;
use impasto::math::DVec3;
use impasto::recipe::Prepared;

/// Some values, not in any pattern.
fn is_hole(p: DVec3) -> bool {
    let h = ((p.x * 91.7).round() as i64).wrapping_mul(7919) ^ ((p.y * 67.3).round() as i64).wrapping_mul(104_729);
    h.rem_euclid(5) == 0
}

fn holey(raw: RawMesh) -> RawMesh {
    with_values(raw, "v", |p| if is_hole(p) { f64::NAN } else { p.x + p.y })
}

fn is_missing(prepared: &Prepared, vertex: u32) -> bool {
    prepared.scene.mesh.fields()[0].values.at(vertex as usize).is_nan()
}

#[test]
fn the_nearest_vertex_says_whether_a_value_is_missing() {
    for (name, raw, view) in [
        ("sheet", sheet(12, |_, _| 0.0), front(300)),
        ("sphere", sphere(), format!("camera = {{ azimuth = 20.0, elevation = 15.0 }}\n{}", plain(300))),
    ] {
        for mode in ["", "missing_mode = 'nearest'\n"] {
            let keys = format!("[[layers]]\ntable = 'viridis'\nfield = 'v'\n{mode}missing = '#ff00ff'");
            let prepared = prepare(&holey(raw.clone()), &format!("{view}{keys}"));
            let missing = table(&prepared).missing;
            let (mut n_missing, mut over_vertices) = (0, 0);
            for s in seen(&prepared) {
                let corners = prepared.scene.mesh.triangles()[s.triangle];
                let mut order = [0, 1, 2];
                order.sort_by(|a, b| s.weights[*b].total_cmp(&s.weights[*a]));
                if s.weights[order[0]] - s.weights[order[1]] < 1e-4 {
                    continue;
                }
                let wanted = is_missing(&prepared, corners[order[0]]);
                assert_eq!(s.light == missing, wanted, "{name}, pixel {:?}, weights {:?}", s.cell, s.weights);
                n_missing += wanted as usize;
                over_vertices += (s.weights[order[0]] > 0.93) as usize;
            }
            assert!(
                n_missing > 1000 && over_vertices > 50,
                "{name}: {n_missing} missing, {over_vertices} over vertices"
            );
        }
    }
}

#[test]
fn values_beside_holes_are_between_those_that_are_there() {
    // One corner of each of two triangles is missing: the rest goes by the other two.
    let raw = with_values(sheet(1, |_, _| 0.0), "v", |p| if p.x > 0.0 && p.y < 0.0 { f64::NAN } else { 1.0 });
    let keys = "[[layers]]\ntable = 'viridis'\nbands = 4\nfield = 'v'\nrange = [0.0, 1.9]";
    let prepared = prepare(&raw, &format!("{}{keys}", front(100)));
    let (missing, own) = (table(&prepared).missing, table(&prepared).colors[2]);
    let pixels = seen(&prepared);
    assert!(pixels.iter().all(|s| s.light == own || s.light == missing), "one value, one colour");
    let share = pixels.iter().filter(|s| s.light == missing).count() as f64 / pixels.len() as f64;
    assert!((share - 1.0 / 6.0).abs() < 0.01, "a third of one of two triangles, not {share}");
}

#[test]
fn a_fan_leaves_out_every_triangle_with_a_hole() {
    let keys = "[[layers]]\ntable = 'viridis'\nfield = 'v'\nmissing_mode = 'fan'\nmissing = '#ff00ff'";
    let prepared = prepare(&holey(sheet(12, |_, _| 0.0)), &format!("{}{keys}", front(240)));
    let missing = table(&prepared).missing;
    let pixels = seen(&prepared);
    for s in &pixels {
        let wanted = prepared.scene.mesh.triangles()[s.triangle].iter().any(|v| is_missing(&prepared, *v));
        assert_eq!(s.light == missing, wanted, "pixel {:?}", s.cell);
    }
    assert!(pixels.iter().any(|s| s.light == missing) && pixels.iter().any(|s| s.light != missing));
}
