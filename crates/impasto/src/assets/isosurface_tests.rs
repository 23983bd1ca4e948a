//! Isosurfaces: closed, of the right shape, wherever they lie.

use super::*;
use crate::assets::{Lattice, Topology};
use crate::math::hash_cell;

/// The grid of a function on a box about the origin.
fn grid_of(n: [u32; 3], half: DVec3, f: impl Fn(DVec3) -> f64) -> Grid {
    let step = |a: usize| 2.0 * half[a] / (n[a] - 1) as f64;
    let axes = [DVec3::X * step(0), DVec3::Y * step(1), DVec3::Z * step(2)];
    let lattice = Lattice { size: n, origin: -half, axes };
    let mut values = Vec::new();
    for k in 0..n[2] {
        for j in 0..n[1] {
            for i in 0..n[0] {
                values.push(f(lattice.place(DVec3::new(i as f64, j as f64, k as f64))) as f32);
            }
        }
    }
    Grid::new(lattice, values).unwrap()
}

fn volume(mesh: &Mesh) -> f64 {
    let at = |v: u32| mesh.positions()[v as usize].as_dvec3();
    mesh.triangles().iter().map(|&[a, b, c]| at(a).dot(at(b).cross(at(c))) / 6.0).sum()
}

fn area(mesh: &Mesh) -> f64 {
    let at = |v: u32| mesh.positions()[v as usize].as_dvec3();
    mesh.triangles().iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)).length() / 2.0).sum()
}

/// The share of triangles' corners whose normals look to the front.
fn share_of_right_normals(mesh: &Mesh) -> f64 {
    let at = |v: u32| mesh.positions()[v as usize].as_dvec3();
    let right = mesh.triangles().iter().flat_map(|&t| {
        let [a, b, c] = t.map(at);
        let front = (b - a).cross(c - a);
        t.map(|v| mesh.normals()[v as usize].as_dvec3().dot(front) > 0.0)
    });
    right.filter(|r| *r).count() as f64 / (3 * mesh.triangles().len()) as f64
}

#[test]
fn a_sphere_has_its_area_volume_and_normals() {
    let pi = std::f64::consts::PI;
    let grid = grid_of([30, 33, 36], DVec3::splat(1.2), |p| 2.0 - p.length());
    let mesh = of(&grid, &Options { level: 1.0, ..Default::default() });
    let topology = Topology::of(&mesh);
    assert!(topology.is_solid() && topology.genus() == Some(0), "{topology:?}");
    assert!((volume(&mesh) / (4.0 / 3.0 * pi) - 1.0).abs() < 0.01, "{}", volume(&mesh));
    assert!((area(&mesh) / (4.0 * pi) - 1.0).abs() < 0.01, "{}", area(&mesh));
    for (p, n) in mesh.positions().iter().zip(mesh.normals()) {
        assert!((p.length() - 1.0).abs() < 0.005 && (n.length() - 1.0).abs() < 1e-5);
        assert!(p.normalize().dot(*n) > 0.999);
    }
    // The other side of the same values: a solid that fills the rest, and has a cavity.
    let rest = of(&grid, &Options { level: 1.0, side: Side::Below, closed: true });
    let box_volume = 2.4f64.powi(3);
    assert!(Topology::of(&rest).is_solid());
    assert!((volume(&rest) / (box_volume - 4.0 / 3.0 * pi) - 1.0).abs() < 0.01, "{}", volume(&rest));
    assert!(share_of_right_normals(&rest) > 0.999);
}

#[test]
fn a_torus_has_one_handle() {
    let torus = |p: DVec3| 0.3 - ((p.x * p.x + p.y * p.y).sqrt() - 0.8).hypot(p.z);
    let mesh = of(&grid_of([40, 40, 20], DVec3::new(1.2, 1.2, 0.4), torus), &Options::default());
    let topology = Topology::of(&mesh);
    assert!(topology.is_solid() && topology.genus() == Some(1) && topology.n_pieces == 1, "{topology:?}");
    let pi = std::f64::consts::PI;
    assert!((volume(&mesh) / (2.0 * pi * pi * 0.8 * 0.09) - 1.0).abs() < 0.01);
    assert!(share_of_right_normals(&mesh) > 0.99);
}

#[test]
fn any_values_give_a_closed_solid_without_non_manifold_edges() {
    for seed in 0..40 {
        // Few different values: ties with the level, saddles and edges crossed at their ends are all there.
        let n_values = [2, 3, 5, 1000][seed as usize % 4];
        let size = [5 + seed % 3, 6, 4 + seed % 4];
        let values =
            (0..size.iter().product::<u32>()).map(|i| (hash_cell(i as i32, seed as i32, 0, 3) % n_values) as f32);
        let axes = match seed % 2 {
            0 => [DVec3::X, DVec3::Y, DVec3::Z],
            _ => [DVec3::new(0.3, 1.0, 0.0), DVec3::new(1.0, 0.0, 0.2), DVec3::Z],
        };
        let lattice = Lattice { size, origin: DVec3::new(3.0, -40.0, 0.1), axes };
        let grid = Grid::new(lattice, values.collect()).unwrap();
        for side in [Side::Above, Side::Below] {
            let options = Options { level: (n_values / 2) as f64, side, closed: true };
            let mesh = of(&grid, &options);
            let topology = Topology::of(&mesh);
            assert!(topology.is_solid(), "{seed} {side:?}: {topology:?}");
            assert!(volume(&mesh) > 0.0, "{seed} {side:?}");
            assert!(mesh.normals().iter().all(|n| (n.length() - 1.0).abs() < 1e-4));
            let report = mesh.clone().into_raw().mend();
            assert!(report.value.triangles().len() == mesh.triangles().len(), "{:?}", report.mended);
            let open = of(&grid, &Options { closed: false, ..options });
            let topology = Topology::of(&open);
            assert!(topology.n_non_manifold_edges == 0 && topology.n_inconsistent_edges == 0 && !topology.is_closed());
        }
    }
}

#[test]
fn caps_lie_on_the_border_and_have_its_normals() {
    // A ball cut in half by the box.
    let grid = grid_of([41, 41, 21], DVec3::new(1.0, 1.0, 0.5), |p| 0.8 - (p + DVec3::new(0.0, 0.0, 0.5)).length());
    let mesh = of(&grid, &Options { closed: true, ..Default::default() });
    let topology = Topology::of(&mesh);
    assert!(topology.is_solid() && topology.genus() == Some(0), "{topology:?}");
    let wanted = 2.0 / 3.0 * std::f64::consts::PI * 0.512;
    assert!((volume(&mesh) / wanted - 1.0).abs() < 0.01, "{}", volume(&mesh));
    assert!(mesh.positions().iter().filter(|p| p.z == -0.5).count() > 100);
    assert!(mesh.normals().iter().filter(|n| **n == -Vec3::Z).count() > 100);
    assert!(mesh.positions().iter().all(|p| grid.sample(*p).is_finite()), "all of it can be looked up");
    let whole = of(&grid, &Options { level: -10.0, closed: true, ..Default::default() });
    assert!((volume(&whole) - 4.0).abs() < 1e-5 && Topology::of(&whole).is_solid());
    assert!(of(&grid, &Options { level: -10.0, ..Default::default() }).triangles().is_empty());
    assert!(of(&grid, &Options { level: f64::NAN, closed: true, ..Default::default() }).triangles().is_empty());
}

#[test]
fn missing_values_leave_holes() {
    let grid = grid_of([20, 20, 20], DVec3::splat(1.2), |p| if p.x > 0.5 { f64::NAN } else { 1.0 - p.length() });
    let mesh = of(&grid, &Options { closed: true, ..Default::default() });
    let topology = Topology::of(&mesh);
    assert!(topology.n_border_edges > 10 && topology.n_non_manifold_edges == 0 && topology.n_pieces == 1);
    assert!(mesh.positions().iter().all(|p| p.is_finite() && p.x < 0.6));
}
