//! Any bytes as glTF or GLB: a scene that can be written again, or one line; never a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let neighbours = |_: &str| Ok(vec![0; 4096]);
    match impasto::assets::gltf_in::read(bytes, Path::new("a.gltf"), &neighbours) {
        Ok(report) => drop(impasto::assets::glb::write(&report.value)),
        Err(e) => assert!(!e.to_string().contains('\n')),
    }
});
