//! `impasto cut` as a user meets it: halves that are closed and add up, pictures, and single lines of error.

use impasto::assets::{Topology, files};
use impasto::recipe::{Input, source};
use impasto::section::cut::volume;
use std::path::Path;
use std::process::{Command, Output};

fn cut(folder: &Path, args: &str) -> Output {
    let words = args.split_whitespace();
    Command::new(env!("CARGO_BIN_EXE_impasto"))
        .current_dir(folder)
        .arg("cut")
        .args(words)
        .output()
        .expect("the program starts")
}

/// Runs and demands success; answers with standard output.
fn ok(folder: &Path, args: &str) -> String {
    let out = cut(folder, args);
    assert!(out.status.success(), "{args}: {}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8_lossy(&out.stdout).into_owned()
}

/// The volume of a closed file.
fn closed_volume(path: &Path) -> f64 {
    let mesh = files::load(path, &Default::default()).unwrap().value.mesh;
    let topology = Topology::of(&mesh);
    assert!(topology.is_solid(), "{path:?}: {topology:?}");
    volume(mesh.positions(), mesh.triangles())
}

const SAMPLE: &str = "sample:displaced --resolution 24";

fn sample_volume() -> f64 {
    let file = Some("sample:displaced".to_owned());
    let input = Input { file, resolution: Some(24), ..Input::default() };
    let mesh = source::scene(&input, Path::new("")).unwrap().value.mesh;
    volume(mesh.positions(), mesh.triangles())
}

#[test]
fn halves_are_closed_and_torn_ones_add_up() {
    let dir = tempfile::tempdir().unwrap();
    let whole = sample_volume();
    for (kind, file) in [("tear", "t.ply"), ("hollow", "h.stl"), ("solid", "s.glb")] {
        let grain = "--spacing 0.4 --radius 0.15 --normal 1,0.3,0.5 --at 0.45";
        let said = ok(dir.path(), &format!("{SAMPLE} {grain} --kind {kind} -o {file}"));
        assert!(said.lines().count() == 2 && said.contains("volume") && said.contains("no gaps"), "{said}");
        let halves = ["-a.", "-b."].map(|letter| closed_volume(&dir.path().join(file.replace('.', letter))));
        let sum: f64 = halves.iter().sum();
        match kind {
            "tear" => assert!((sum - whole).abs() < 1e-5 * whole, "{sum} of {whole}"),
            _ => assert!(sum < 0.999 * whole && sum > 0.8 * whole, "{kind}: {sum} of {whole}"),
        }
    }
}

#[test]
fn flat_and_plain_cuts_keep_the_volume() {
    let dir = tempfile::tempdir().unwrap();
    for how in ["--grain none", "--relief none --kind hollow --spacing 0.4 --radius 0.15"] {
        let said = ok(dir.path(), &format!("{SAMPLE} {how} --normal 0,1,0 -o half.ply --json"));
        let said: serde_json::Value = serde_json::from_str(&said).unwrap();
        let sum: f64 = ["half-a.ply", "half-b.ply"].iter().map(|f| closed_volume(&dir.path().join(f))).sum();
        assert!((sum - sample_volume()).abs() < 1e-5 * sum, "{how}");
        let told: f64 = said["halves"].as_array().unwrap().iter().map(|h| h["volume"].as_f64().unwrap()).sum();
        assert!((told - sum).abs() < 1e-5 * sum && said["gaps"].as_array().unwrap().is_empty());
    }
}

#[test]
fn pictures_show_one_half_or_both() {
    let dir = tempfile::tempdir().unwrap();
    let mut pictures = Vec::new();
    for half in ["a", "b", "both"] {
        ok(dir.path(), &format!("{SAMPLE} --spacing 0.4 --half {half} --size 64x48 -o {half}.png"));
        pictures.push(std::fs::read(dir.path().join(format!("{half}.png"))).unwrap());
    }
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
}

#[test]
fn what_cannot_be_gives_one_line_and_leaves_nothing_behind() {
    let dir = tempfile::tempdir().unwrap();
    for (wrong, word) in [
        ("--radius 0", "radius"),
        ("--spacing -1", "spacing"),
        ("--spacing nan", "spacing"),
        ("--spacing 0.00001", "particles"),
        ("--normal 0,0,0", "no length"),
        ("--normal nan,0,1", "finite"),
        ("--through 0,99,0 --normal 0,1,0", "misses"),
        ("--through 0,0,0 --at 0.5", "through a point already"),
        ("--at 1.5", "misses"),
        ("--at nan", "at"),
        ("--grain stone", "grain"),
        ("--kind torn", "tear"),
        ("--policy bridge:-1", "above zero"),
        ("--relief deep", "footprint"),
        ("--half c", "half"),
        ("--figure 3", "one of 6"),
    ] {
        for file in ["half.stl", "cut.png"] {
            let out = cut(dir.path(), &format!("{SAMPLE} {wrong} -o {file}"));
            let error = String::from_utf8_lossy(&out.stderr).into_owned();
            assert_eq!(out.status.code(), Some(1), "{wrong}: {error}");
            assert!(error.lines().count() == 1 && error.contains(word), "{wrong}: {error}");
        }
    }
    assert_eq!(cut(dir.path(), &format!("{SAMPLE} -o half.doc")).status.code(), Some(1));
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}
