//! Any bytes as a Gaussian cube file: an error or a sound grid whose isosurface holds together, never a panic.
#![no_main]

use impasto::assets::volume::{Kind, read_as};
use impasto::assets::volume_scene::to_scene;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let Ok(report) = read_as(Kind::Cube, bytes, Path::new("fuzz.cube")) else { return };
    for grid in &report.value.grids {
        let [x, y, z] = grid.size().map(|n| n as usize);
        assert!(x * y * z == grid.values().len());
        let first = grid.at(0, 0, 0);
        assert!(grid.sample(grid.origin().as_vec3()) == first || first.is_nan());
    }
    if let Ok(report) = to_scene(report.value, Kind::Cube, "fuzz".into(), None) {
        let mesh = &report.value.mesh;
        assert!(mesh.triangles().as_flattened().iter().all(|v| (*v as usize) < mesh.positions().len()));
        assert!(mesh.positions().iter().all(|p| p.is_finite()));
        assert!(mesh.normals().iter().all(|n| (n.length() - 1.0).abs() < 1e-3));
    }
});
