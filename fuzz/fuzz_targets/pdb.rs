//! Any bytes as atoms, the first byte picks PDB or PQR: an error or a molecule with a closed surface, never a panic.
#![no_main]

use impasto::assets::{Topology, molecular_surface, pdb, pqr};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else { return };
    let read = if first % 2 == 0 { pdb::read } else { pqr::read };
    let Ok(report) = read(rest, Path::new("fuzz")) else { return };
    let molecule = report.value;
    assert!(molecule.bonds.iter().all(|[a, b]| a < b && (*b as usize) < molecule.atoms.len()));
    // Coarse, so that there is time for many.
    let options = molecular_surface::Options { spacing: Some(1.0) };
    let mesh = molecular_surface::of(&molecule, &options).value;
    assert!(mesh.positions().iter().all(|p| p.is_finite()));
    let topology = Topology::of(&mesh);
    assert!(topology.n_pieces <= topology.n_triangles);
});
