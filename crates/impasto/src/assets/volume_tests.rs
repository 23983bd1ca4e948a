//! What the readers of grids and molecules share: damage, and the real files.

use super::*;
use crate::assets::files::{self, LoadOptions};
use crate::assets::{Element, Mesh, Scene, Topology};
use crate::math::hash_cell;
use std::path::PathBuf;

/// Calls `read` with some hundred damaged copies of a file: bytes changed, ends cut off, parts doubled.
pub(crate) fn for_each_damage(good: &[u8], read: impl Fn(&[u8])) {
    let n = good.len() as u32;
    for i in 0..600 {
        let random = |k: i32| hash_cell(i, k, 0, 11);
        let mut bytes = good.to_vec();
        match i % 4 {
            0 => bytes.truncate((random(0) % n) as usize),
            1 => {
                let at = (random(0) % n) as usize;
                let part = bytes[at..(at + 1 + random(1) as usize % 40).min(n as usize)].to_vec();
                bytes.splice(at..at, part);
            }
            _ => {
                for k in 0..1 + random(0) % 8 {
                    let at = (random(2 * k as i32 + 1) % n) as usize;
                    // Digits and signs as often as any byte: they keep text a text.
                    let byte = random(2 * k as i32 + 2);
                    bytes[at] = if byte & 256 == 0 { byte as u8 } else { b"0123456789-+.e \n"[byte as usize % 16] };
                }
            }
        }
        read(&bytes);
    }
}

/// Whatever happened to a file: a sound grid, or an error of one line.
pub(crate) fn survives_damage(kind: Kind, good: &[u8]) {
    read_as(kind, good, Path::new("good")).unwrap_or_else(|e| panic!("{e}"));
    for_each_damage(good, |bytes| match read_as(kind, bytes, Path::new("bad")) {
        Ok(report) => {
            for grid in &report.value.grids {
                let [x, y, z] = grid.size().map(|n| n as usize);
                assert!(x * y * z == grid.values().len() && grid.lattice().cell_volume() != 0.0);
                assert!(grid.values().iter().all(|v| !v.is_infinite()));
            }
        }
        Err(e) => assert!(!e.to_string().contains('\n'), "{e}"),
    });
}

/// A file of the shared data, if it is there.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/5_science")).join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no shared data {name}");
    None
}

fn mesh_of(name: &str) -> Option<Scene> {
    let report = files::load(&shared(name)?, &LoadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
    println!("{name}: {:?} {}", report.mended, report.value.up_note);
    Some(report.value)
}

fn values(mesh: &Mesh, name: &str) -> Vec<f64> {
    let field = mesh.fields().iter().find(|f| f.name == name).unwrap_or_else(|| panic!("no field {name}"));
    assert_eq!(field.element, Element::Vertex);
    (0..field.n_elements()).map(|i| field.values.at(i)).collect()
}

#[test]
fn real_grids_and_molecules_become_closed_surfaces() {
    for (name, n_parts, least) in [
        ("ethanol/ethanol.pdb", 1, 5000),
        ("ethanol/ethanol_density.cube", 1, 5000),
        ("ethanol/ethanol_mep.cube", 2, 2000),
        ("gramicidin/1grm.pqr", 1, 20000),
        ("gramicidin/1grm_single.pdb", 1, 20000),
        ("gramicidin/1grm_pot-PE0.dx.gz", 2, 2000),
    ] {
        let Some(scene) = mesh_of(name) else { return };
        let topology = Topology::of(&scene.mesh);
        println!("  {topology:?}");
        assert!(topology.is_solid() && scene.mesh.parts().len() == n_parts, "{name}");
        assert!(topology.n_triangles > least, "{name}: {topology:?}");
    }
}

#[test]
fn sampled_values_are_those_the_files_carry() {
    // The density's own surface: all its points have one density, and the potential that the file says.
    let Some(scene) = mesh_of("ethanol/ethanol_iso0.002_mep.ply") else { return };
    let grid = |name: &str| files::load_volume(&shared(name).unwrap()).unwrap().value.grids.remove(0);
    let density = grid("ethanol/ethanol_density.cube");
    let far = scene.mesh.positions().iter().map(|p| (density.sample(*p) as f64 - 0.002).abs()).fold(0.0, f64::max);
    assert!(far < 3e-5, "density off by {far}");
    let potential = grid("ethanol/ethanol_mep.cube").at_vertices(&scene.mesh);
    assert_eq!((potential.name.as_str(), potential.unit.as_str()), ("potential", "hartree/e"));
    let mep = values(&scene.mesh, "mep");
    let worst = mep.iter().enumerate().map(|(i, v)| (potential.values.at(i) - v).abs()).fold(0.0, f64::max);
    let range = potential.range(0);
    println!("worst {worst} of {range:?}");
    assert!(worst < 0.01 * (range.max - range.min), "{worst}");

    // The potential of the other file was taken 1.4 angstrom outside of the surface.
    let Some(scene) = mesh_of("gramicidin/1grm_gauss_surface_pot.ply") else { return };
    let grid = grid("gramicidin/1grm_pot-PE0.dx.gz");
    assert_eq!((grid.name.as_str(), grid.unit.as_str()), ("potential", "kT/e"));
    let mesh = &scene.mesh;
    let wanted = values(mesh, "potential");
    let outside = mesh.positions().iter().zip(mesh.normals()).map(|(p, n)| grid.sample(*p + *n * 1.4) as f64);
    let worst = outside.zip(&wanted).map(|(v, w)| (v - w).abs()).fold(0.0, f64::max);
    println!("worst {worst}");
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn files_are_unpacked_and_levels_are_taken_as_asked() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let gzipped = |bytes: &[u8]| {
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), Default::default());
        std::io::Write::write_all(&mut gz, bytes).unwrap();
        gz.finish().unwrap()
    };
    let values: Vec<String> = (0..125).map(|i| if i == 62 { "8".into() } else { "-1".to_string() }).collect();
    let text = format!("NRRD0004\ntype: float\nencoding: txt\nsizes: 5 5 5\n\n{}\n", values.join(" "));
    let path = write("a.nrrd.gz", &gzipped(text.as_bytes()));
    let load = |isolevel| files::load(&path, &LoadOptions { isolevel, ..Default::default() });
    let extent = |isolevel| load(isolevel).unwrap().value.mesh.bounds().extent().x;
    assert!((extent(None) - 1.0).abs() < 0.01, "halfway between the two values");
    assert!((extent(Some(-0.1)) - 1.8).abs() < 1e-5 && (extent(Some(7.1)) - 0.2).abs() < 1e-5);
    let scene = load(Some(0.0)).unwrap().value;
    assert!(scene.up_note.ends_with("isosurface of value at 0: as asked"), "{}", scene.up_note);
    assert_eq!(scene.mesh.fields()[0].name, "gradient");
    let fault = load(Some(9.5)).unwrap_err().to_string();
    assert!(fault.ends_with("no surface at 9.5: its values run from -1 to 8"), "{fault}");
    assert_eq!(files::load_volume(&path).unwrap().value.grids[0].size(), [5, 5, 5]);

    let triangle = b"OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let off = write("a.off.gz", &gzipped(triangle));
    assert_eq!(files::load(&off, &LoadOptions::default()).unwrap().value.mesh.triangles().len(), 1);
    let fault = files::load_volume(&off).unwrap_err().to_string();
    assert!(fault.contains(".off is not a format Impasto reads as a grid"), "{fault}");
    let torn = write("b.off.gz", &gzipped(triangle)[..20]);
    assert!(files::load(&torn, &LoadOptions::default()).unwrap_err().to_string().contains("cannot be unpacked"));
    let far = "HETATM    1  C   A       1    ********   0.000   0.000  1.00  0.00           C\n";
    let far = write("far.pdb", far.as_bytes());
    assert!(files::load(&far, &LoadOptions::default()).unwrap_err().to_string().contains("no atom in it"));
}
