//! Broken meshes and what becomes of them.

use super::*;
use crate::assets::UvSet;
use crate::assets::topology::Topology;
use crate::math::{hash_cell, vec3, vec4};

/// A cube of side 2 about the origin, wound outwards, 12 triangles.
fn cube() -> RawMesh {
    let sign = |i: u32, bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
    let positions = (0..8).map(|i| vec3(sign(i, 0), sign(i, 1), sign(i, 2))).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    RawMesh { positions, triangles, ..Default::default() }
}

fn notes(report: &Report<Mesh>) -> String {
    report.mended.iter().map(|m| m.to_string()).collect::<Vec<_>>().join("; ")
}

fn volume(mesh: &Mesh) -> f64 {
    let at = |v: u32| mesh.positions()[v as usize].as_dvec3();
    mesh.triangles().iter().map(|&[a, b, c]| at(a).dot(at(b).cross(at(c))) / 6.0).sum()
}

#[test]
fn a_good_mesh_stays_as_it_is() {
    let mut raw = cube();
    raw.normals = raw.positions.iter().map(|p| p.normalize()).collect();
    let report = raw.clone().mend();
    assert!(report.mended.is_empty(), "{}", notes(&report));
    assert_eq!(report.value.positions(), raw.positions);
    assert_eq!(report.value.triangles(), raw.triangles);
    assert_eq!(report.value.normals(), raw.normals);
    assert_eq!(report.value.parts().len(), 1);
}

#[test]
fn each_defect_is_mended_and_told() {
    let check = |wanted: &str, break_it: fn(&mut RawMesh)| {
        let mut raw = cube();
        raw.normals = raw.positions.iter().map(|p| p.normalize()).collect();
        break_it(&mut raw);
        let report = raw.mend();
        assert_eq!(notes(&report), wanted);
        let again = report.value.clone().into_raw().mend();
        let told_again = notes(&again);
        assert!(told_again.is_empty() || told_again.contains("left as they are"), "mended twice: {told_again}");
        report.value
    };
    check("1 triangles with vertices that do not exist dropped", |m| m.triangles.push([0, 1, 8]));
    check("1 triangles that repeat a corner dropped", |m| m.triangles.insert(0, [0, 1, 0]));
    check("1 triangles without area dropped", |m| {
        m.positions.push(vec3(0.0, -1.0, -1.0));
        m.normals.push(Vec3::Y);
        m.triangles.push([0, 8, 1]);
    });
    check("2 triangles that come twice dropped", |m| {
        let [a, b, c] = m.triangles[3];
        m.triangles.extend([[b, c, a], [a, b, c]]);
    });
    let mesh = check("2 triangles wound against their neighbours turned", |m| {
        m.triangles[4].swap(0, 1);
        m.triangles[9].swap(1, 2);
    });
    assert_eq!(volume(&mesh), 8.0);
    let mesh = check("1 closed pieces that were inside out turned", |m| {
        m.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        m.normals.iter_mut().for_each(|n| *n = -*n);
    });
    assert_eq!(volume(&mesh), 8.0);
    assert!(mesh.normals().iter().zip(mesh.positions()).all(|(n, p)| n.dot(*p) > 0.0));
    check(
        "1 vertices without a finite position moved to the first good one; 6 triangles with such vertices dropped",
        |m| m.positions[0] = vec3(1.0, f32::NAN, 0.0),
    );
    check("2 missing normals made from the triangles", |m| {
        m.normals[3] = Vec3::ZERO;
        m.normals[4] = Vec3::NAN;
    });
    check("1 texture coordinates that are not finite set to zero", |m| {
        m.uv_sets = vec![UvSet { name: "uv0".into(), uv: vec![Vec2::ONE; 8] }];
        m.uv_sets[0].uv[2].x = f32::INFINITY;
    });
    check("2 attributes of the wrong length dropped: colours, heat", |m| {
        m.colors = vec![vec4(1.0, 1.0, 1.0, 1.0); 7];
        let values = Values::F32(vec![0.0; 11]);
        m.fields.push(Field {
            name: "heat".into(),
            unit: String::new(),
            element: Element::Face,
            n_components: 1,
            values,
        });
    });
    check("1 edges of more than two triangles left as they are", |m| {
        m.positions.push(vec3(9.0, 9.0, 9.0));
        m.normals.push(Vec3::Y);
        m.triangles.push([0, 1, 8]);
    });
    check("2 parts that do not cover the triangles in order joined to one", |m| {
        m.parts = [0..4, 5..12].map(|triangles| Part { name: String::new(), triangles, material: None }).to_vec();
    });
}

#[test]
fn a_cavity_keeps_looking_inwards() {
    let mut raw = cube();
    let inner = cube();
    raw.positions.extend(inner.positions.iter().map(|p| *p * 0.5));
    raw.triangles.extend(inner.triangles.iter().map(|t| [t[0] + 8, t[2] + 8, t[1] + 8]));
    let report = raw.mend();
    assert_eq!(notes(&report), "");
    assert!((volume(&report.value) - 7.0).abs() < 1e-12);
}

#[test]
fn a_moebius_strip_is_left_alone() {
    let at = |i: usize, side: f64| {
        let a = i as f64 / 12.0 * std::f64::consts::TAU;
        let r = 2.0 + side * exact::cos(a / 2.0);
        vec3((r * exact::cos(a)) as f32, (r * exact::sin(a)) as f32, (side * exact::sin(a / 2.0)) as f32)
    };
    let positions = (0..12).flat_map(|i| [at(i, -0.5), at(i, 0.5)]).collect();
    let triangles = (0..12u32).flat_map(|i| {
        let [a, b] = [2 * i, 2 * i + 1];
        let [c, d] = if i == 11 { [1, 0] } else { [a + 2, b + 2] };
        [[a, c, b], [b, c, d]]
    });
    let report = RawMesh { positions, triangles: triangles.collect(), ..Default::default() }.mend();
    assert_eq!(notes(&report), "1 one-sided pieces (as a Moebius strip) left as they are");
}

#[test]
fn a_cube_without_normals_gets_sharp_edges_and_a_ball_none() {
    let mut raw = cube();
    let values = Values::F32((0..8).map(|i| i as f32).collect());
    raw.fields.push(Field {
        name: "id".into(),
        unit: String::new(),
        element: Element::Vertex,
        n_components: 1,
        values,
    });
    let mesh = raw.clone().mend().value;
    assert_eq!(mesh.positions().len(), 24);
    for (v, (p, n)) in mesh.positions().iter().zip(mesh.normals()).enumerate() {
        assert_eq!(n.abs().max_element(), 1.0, "normals of a cube follow its axes");
        assert!(n.dot(*p) > 0.9);
        let source = mesh.source_points()[v] as usize;
        assert_eq!((raw.positions[source], mesh.fields()[0].values.at(v)), (*p, source as f64));
    }
    assert!(Topology::of(&mesh).is_solid());

    let mesh = raw.clone().mend_with(MendOptions { crease: 3.0, ..Default::default() }).value;
    assert_eq!(mesh.positions().len(), 8);
    // Angle weights make a cube's corner normals point along its diagonals, whatever its triangulation.
    assert!(mesh.normals().iter().zip(mesh.positions()).all(|(n, p)| (*n - p.normalize()).length() < 1e-6));

    let smooth_groups = (0..12).map(|t| if t < 4 { 1 } else { 2 }).collect();
    let mesh = raw.mend_with(MendOptions { smooth_groups, ..Default::default() }).value;
    assert_eq!(mesh.positions().len(), 16);
}

#[test]
fn winding_is_mended_whichever_triangles_were_turned() {
    for seed in 0..200 {
        let mut raw = cube();
        for t in 0..12 {
            if hash_cell(t, 0, 0, seed).is_multiple_of(3) {
                raw.triangles[t as usize].swap(0, 1);
            }
            raw.triangles[t as usize].rotate_left(hash_cell(t, 1, 0, seed) as usize % 3);
        }
        let mesh = raw.mend().value;
        assert_eq!((volume(&mesh), Topology::of(&mesh).n_inconsistent_edges), (8.0, 0), "seed {seed}");
    }
}
