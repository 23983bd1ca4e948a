//! Any bytes as a height map; the first byte picks the kind.
#![no_main]

use impasto::assets::height_map::{Kind, Options, read_as};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else { return };
    let kind = [Kind::Asc, Kind::Dem, Kind::Npy, Kind::Npz][*first as usize % 4];
    if let Ok(report) = read_as(kind, rest, Path::new("fuzz"), &Options::default()) {
        let mesh = &report.value.mesh;
        assert!(mesh.triangles().as_flattened().iter().all(|v| (*v as usize) < mesh.positions().len()));
        assert!(mesh.positions().iter().all(|p| p.is_finite()));
    }
});
