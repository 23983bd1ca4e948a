//! Grids: what lies between their points.

use super::*;
use crate::math::{hash_cell, unit_float, vec3};

/// A skew, left-handed lattice.
fn skew(size: [u32; 3]) -> Lattice {
    let axes = [DVec3::new(0.5, 0.1, 0.0), DVec3::new(0.0, 0.2, 0.7), DVec3::new(0.1, 0.4, 0.2)];
    Lattice { size, origin: DVec3::new(10.0, -3.0, 2.0), axes }
}

/// The grid of a function of the place.
fn grid_of(lattice: Lattice, f: impl Fn(DVec3) -> f64) -> Grid {
    let [nx, ny, nz] = lattice.size;
    let mut values = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                values.push(f(lattice.place(DVec3::new(i as f64, j as f64, k as f64))) as f32);
            }
        }
    }
    Grid::new(lattice, values).unwrap()
}

fn random_index(size: [u32; 3], i: i32) -> DVec3 {
    let f = |axis: usize| unit_float(hash_cell(i, axis as i32, 0, 7)) as f64 * (size[axis] - 1) as f64;
    DVec3::new(f(0), f(1), f(2))
}

#[test]
fn linear_functions_come_back_everywhere_with_their_gradient() {
    let lattice = skew([5, 4, 7]);
    let slope = DVec3::new(1.5, -2.0, 0.25);
    let grid = grid_of(lattice, |p| p.dot(slope) + 3.0);
    for i in 0..1000 {
        let p = lattice.place(random_index(lattice.size, i));
        let wanted = p.dot(slope) + 3.0;
        assert!((grid.sample(p.as_vec3()) as f64 - wanted).abs() < 1e-4, "{p}");
        assert!((grid.gradient(p.as_vec3()).as_dvec3() - slope).length() < 1e-3, "{p}");
    }
    assert_eq!(grid.at(2, 3, 4), grid.values()[2 + 5 * (3 + 4 * 4)]);
    assert_eq!(grid.range().n_missing, 0);
}

#[test]
fn outside_is_missing_and_the_border_is_inside() {
    let lattice = skew([5, 4, 7]);
    let grid = grid_of(lattice, |p| p.x);
    for corner in 0..8u32 {
        let [x, y, z] = [0, 1, 2].map(|a| if corner >> a & 1 == 0 { 0.0 } else { (lattice.size[a] - 1) as f64 });
        let at = |d: f64| lattice.place(DVec3::new(x, y, z) * (1.0 + d) - d * 2.0).as_vec3();
        assert!(grid.sample(at(0.0)).is_finite());
        assert!(grid.sample(at(0.1)).is_nan() && grid.gradient(at(0.1)).is_nan());
    }
    assert!(grid.sample(Vec3::NAN).is_nan() && grid.sample(Vec3::splat(1e30)).is_nan());
}

#[test]
fn a_missing_corner_spoils_only_where_it_has_weight() {
    let lattice = Lattice { size: [3, 3, 3], origin: DVec3::ZERO, axes: [DVec3::X, DVec3::Y, DVec3::Z] };
    let mut values = vec![1.0; 27];
    (values[13], values[0]) = (f32::NAN, f32::INFINITY);
    let grid = Grid::new(lattice, values).unwrap();
    assert_eq!(grid.range(), Range { min: 1.0, max: 1.0, n_missing: 2 });
    assert!(grid.sample(vec3(1.0, 1.0, 1.0)).is_nan() && grid.sample(vec3(0.5, 0.5, 0.5)).is_nan());
    assert_eq!(grid.sample(vec3(2.0, 1.5, 1.5)), 1.0);
    assert_eq!(grid.sample(vec3(1.0, 0.0, 1.0)), 1.0);
    assert_eq!(grid.gradient(vec3(2.0, 1.0, 1.0)), Vec3::ZERO);
}

#[test]
fn lanes_are_as_single_places() {
    let lattice = skew([5, 4, 7]);
    let grid = grid_of(lattice, |p| p.x * p.y - p.z);
    let places: Vec<Vec3> = (0..300).map(|i| lattice.place(random_index([6, 6, 6], i)).as_vec3()).collect();
    let lane = |axis: usize| places.iter().map(|p| p[axis]).collect::<Vec<f32>>();
    let mut out = vec![0.0; places.len()];
    grid.sample_lanes([&lane(0), &lane(1), &lane(2)], &mut out);
    assert!(out.iter().zip(&places).all(|(o, p)| o.to_bits() == grid.sample(*p).to_bits()));
    assert!(out.iter().any(|o| o.is_nan()) && out.iter().any(|o| o.is_finite()));
}

#[test]
fn grids_that_are_none_are_refused() {
    let good = skew([2, 2, 2]);
    let fault = |lattice, n| Grid::new(lattice, vec![0.0; n]).unwrap_err();
    assert_eq!(fault(good, 7), "a grid of 2 x 2 x 2 points with 7 values");
    assert!(fault(Lattice { size: [u32::MAX; 3], ..good }, 7).contains("with 7 values"));
    assert!(fault(Lattice { size: [0, 2, 2], ..good }, 0).contains("with 0 values"));
    assert!(fault(Lattice { axes: [DVec3::X; 3], ..good }, 8).contains("span no volume"));
    assert!(fault(Lattice { origin: DVec3::splat(1e300), ..good }, 8).contains("span no volume"));
    assert!(fault(Lattice { axes: [DVec3::X * 1e-200, DVec3::Y, DVec3::Z], ..good }, 8).contains("span no volume"));
}

#[test]
fn large_grids_are_thinned_by_means_in_place() {
    let lattice = skew([7, 4, 9]);
    let grid = grid_of(lattice, |p| p.x + 2.0 * p.y).named("f", "V");
    let (thin, step) = grid.clone().thinned(50);
    assert_eq!((step, thin.size(), thin.name.as_str()), (2, [4, 2, 5], "f"));
    // Whole blocks of a linear function keep it.
    let p = thin.lattice().place(DVec3::new(1.0, 0.5, 2.0)).as_vec3();
    assert!((thin.sample(p) - grid.sample(p)).abs() < 1e-4);
    assert_eq!(grid.clone().thinned(1000), (grid, 1));
}
