//! Cuts through corners, edges and faces, and of real meshes.

use super::tests::{eight, random_plane, topology};
use super::*;
use crate::assets::{Mesh, Topology, files};
use crate::math::hash_cell;
use std::path::Path;

/// A plane through a face, or through an edge, or upright through a corner.
fn hard_plane(mesh: &Mesh, i: i32) -> Option<Plane> {
    let p = mesh.positions();
    let pick = |k: i32| {
        let t = mesh.triangles()[hash_cell(i, k, 0, 9) as usize % mesh.triangles().len()];
        t.map(|v| p[v as usize])
    };
    let (t, u) = (pick(0), pick(1));
    let normal = match i % 5 {
        0 => (t[1] - t[0]).cross(t[2] - t[0]),
        1 => (t[1] - t[0]).cross(u[0] - t[0]),
        k => Vec3::AXES[k as usize - 2],
    };
    Plane::through(t[0], normal).ok()
}

/// Where a surface crosses itself its cap lies on itself: then edges have four triangles. No edge has one.
#[track_caller]
fn check_hard(mesh: &Mesh, plane: &Plane, name: &str) {
    let cut = cut(mesh, plane, Policy::Strict).unwrap();
    let whole = Soup::from(mesh).volume();
    let sum = Soup::from(&cut.below.raw).volume() + Soup::from(&cut.above.raw).volume();
    // The lobes of a figure of eight cancel each other: its box says how large it is.
    let size = whole.abs().max(0.01 * mesh.bounds().extent().element_product() as f64);
    assert!((sum - whole).abs() <= 1e-6 * size, "{name} {plane:?}: {sum} not {whole}");
    for half in [&cut.below, &cut.above] {
        let t = topology(&half.raw);
        let is_whole = t.n_non_manifold_edges == 0 || cut.overlaps;
        assert!(is_whole && t.n_border_edges == 0 && t.n_inconsistent_edges == 0, "{name} {plane:?}: {t:?}");
    }
}

#[test]
fn planes_through_corners_edges_and_faces_leave_no_crack() {
    for name in ["knot", "flange", "icosphere", "cylinder", "cone"] {
        let mesh = crate::samples::scene(name, 16, 1).unwrap().mesh;
        for plane in (0..60).filter_map(|i| hard_plane(&mesh, i)) {
            check_hard(&mesh, &plane, name);
            check_hard(&mesh, &plane.flipped(), name);
        }
    }
    let mesh = eight();
    for plane in (0..200).filter_map(|i| hard_plane(&mesh, i)) {
        check_hard(&mesh, &plane, "eight");
    }
}

/// Real meshes, where they are: closed ones stay closed, others end in a report.
#[test]
fn real_meshes_are_cut_into_closed_halves_or_reported() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(DATA);
    if !folder.is_dir() {
        println!("no {folder:?}: nothing to test");
        return;
    }
    // All with 50 planes each take a quarter of a minute: the environment may ask for them.
    let n_planes = std::env::var("ALL_PLANES").map_or(4, |_| 50);
    let mut n_closed = 0;
    for name in REAL {
        let Ok(report) = files::load(&folder.join(name), &files::LoadOptions::default()) else { panic!("{name}") };
        let mesh = report.value.mesh;
        let is_solid = Topology::of(&mesh).is_solid();
        let whole = Soup::from(&mesh).volume();
        for i in 0..n_planes {
            let cut = cut(&mesh, &random_plane(&mesh, i), Policy::Winding).unwrap();
            assert!(cut.n_lost == 0 || !cut.gaps.is_empty(), "{name} {i}");
            assert!(!is_solid || cut.gaps.is_empty(), "{name} {i}: {:?}", cut.gaps);
            if !is_solid {
                continue;
            }
            let sum = Soup::from(&cut.below.raw).volume() + Soup::from(&cut.above.raw).volume();
            assert!((sum - whole).abs() <= 1e-6 * whole.abs(), "{name} {i}: {sum} not {whole}");
            for half in [&cut.below, &cut.above] {
                let t = topology(&half.raw);
                // Where a surface crosses itself, its cap lies on itself.
                assert!(
                    t.is_solid() || t.n_triangles == 0 || cut.overlaps && t.n_border_edges == 0,
                    "{name} {i}: {t:?}"
                );
            }
            n_closed += 1;
        }
        for plane in (0..n_planes).filter_map(|i| hard_plane(&mesh, i)).filter(|_| is_solid) {
            check_hard(&mesh, &plane, name);
        }
    }
    assert!(n_closed >= 15 * n_planes as usize, "{n_closed} closed cuts");
}

const DATA: &str = "../../../shared/data/1_meshes";

const REAL: [&str; 24] = [
    "bunny/bun_zipper.ply",
    "bunny/bunny00.off",
    "bunny/bunny_npm.obj",
    "closed_and_cad/anchor_dense.off",
    "closed_and_cad/angle_block.STL",
    "closed_and_cad/ant.ply",
    "closed_and_cad/blobby.off",
    "closed_and_cad/camel.off",
    "closed_and_cad/cheese.off",
    "closed_and_cad/couplingdown.off",
    "closed_and_cad/cycloidal.ply",
    "closed_and_cad/elk.off",
    "closed_and_cad/featuretype.STL",
    "closed_and_cad/femur.off",
    "closed_and_cad/nut.ply",
    "closed_and_cad/quadknot.obj",
    "face_cyberhead_josie/cyberhead_josie.obj",
    "face_james/james.obj",
    "fuze/fuze.obj",
    "open/mushroom.off",
    "spot/spot_control_mesh.obj",
    "spot/spot_quadrangulated.obj",
    "suzanne/suzanne.ply",
    "teapot/teapot.stl",
];
