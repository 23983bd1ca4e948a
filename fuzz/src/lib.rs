//! What every reader of meshes must do with any bytes: one macro, one target for each reader.

use impasto::assets::{Mesh, Topology};
use std::path::Path;

/// A target: any bytes to a reader `fn(&[u8], &Path, &Neighbours) -> Result<Report<Scene>>`.
#[macro_export]
macro_rules! mesh_target {
    ($read:path) => {
        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
            // What the file refers to is the file itself.
            let neighbours = |_: &str| Ok(bytes.to_vec());
            match $read(bytes, std::path::Path::new("fuzz"), &neighbours) {
                Ok(report) => $crate::check(&report.value.mesh),
                Err(e) => assert!(!e.to_string().contains('\n')),
            }
        });
    };
}

/// All that a valid mesh promises.
pub fn check(mesh: &Mesh) {
    let n = mesh.positions().len();
    assert!(mesh.triangles().as_flattened().iter().all(|v| (*v as usize) < n));
    assert!(mesh.normals().len() == n && mesh.normals().iter().all(|v| (v.length() - 1.0).abs() < 1e-3));
    assert!(mesh.positions().iter().all(|p| p.is_finite()));
    assert!(mesh.uv_sets().iter().all(|set| set.uv.len() == n));
    assert!(mesh.fields().iter().all(|f| f.n_elements() == mesh.n_elements(f.element)));
    let topology = Topology::of(mesh);
    assert!(topology.n_pieces <= topology.n_triangles);
}

/// Any bytes as a table, joined to a small mesh.
pub fn check_table(bytes: &[u8]) {
    use impasto::assets::{join, off};
    let path = Path::new("fuzz.csv");
    let square = b"OFF 4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 2 1 3\n";
    let mut mesh = off::read(square, path, &|_| Ok(Vec::new())).expect("a valid file").value.mesh;
    let joined = join::read_bytes(bytes, path, path).and_then(|c| c.value.join(&mut mesh, &Default::default()));
    if let Err(e) = joined {
        assert!(!e.to_string().contains('\n'));
    }
    check(&mesh);
}
