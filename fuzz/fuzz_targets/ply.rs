//! Any bytes as PLY: an error or a valid mesh, never a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    // What the file refers to is the file itself.
    let neighbours = |_: &str| Ok(bytes.to_vec());
    if let Ok(report) = impasto::assets::ply::read(bytes, Path::new("fuzz.ply"), &neighbours) {
        let mesh = &report.value.mesh;
        let n = mesh.positions().len();
        assert!(mesh.triangles().as_flattened().iter().all(|v| (*v as usize) < n));
        assert!(mesh.normals().len() == n && mesh.normals().iter().all(|v| (v.length() - 1.0).abs() < 1e-3));
        assert!(mesh.positions().iter().all(|p| p.is_finite()));
        assert!(mesh.uv_sets().iter().all(|set| set.uv.len() == n));
        let topology = impasto::assets::Topology::of(mesh);
        assert!(topology.n_pieces <= topology.n_triangles);
    }
});
