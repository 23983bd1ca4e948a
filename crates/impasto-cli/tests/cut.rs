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
fn several_cuts_leave_closed_pieces_with_a_letter_for_each() {
    let dir = tempfile::tempdir().unwrap();
    ok(dir.path(), &format!("{SAMPLE} --normal 1,0,0 --then 0,1,0.2@0.4 --spacing 0.4 -o part.stl"));
    let sum: f64 =
        ["aa", "ab", "ba", "bb"].iter().map(|l| closed_volume(&dir.path().join(format!("part-{l}.stl")))).sum();
    assert!((sum - sample_volume()).abs() < 1e-5 * sum);
}

#[test]
fn maps_are_textures_of_the_cap_and_files_beside_it() {
    let dir = tempfile::tempdir().unwrap();
    let said = ok(dir.path(), &format!("{SAMPLE} --grain tissue --relief none --maps 128 -o half.glb"));
    assert!(said.contains("half-a-height.png: heights from"), "{said}");
    for half in ["a", "b"] {
        let scene = files::load(&dir.path().join(format!("half-{half}.glb")), &Default::default()).unwrap().value;
        let cap = scene.materials.iter().find(|m| m.name == "section").expect("the cap's material");
        assert!(cap.base_color_texture.is_some() && cap.normal_texture.is_some() && cap.occlusion_texture.is_some());
        for map in ["color", "normal", "height", "openness", "particles"] {
            let path = dir.path().join(format!("half-{half}-{map}.png"));
            let image = files::load_image(&path).unwrap().value;
            assert_eq!(image.texels.size().width.max(image.texels.size().height), 128, "{map}");
        }
    }
    ok(dir.path(), &format!("{SAMPLE} --spacing 0.4 -o flat.ply"));
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 14);
}

#[test]
fn sections_are_drawn_and_grains_written_as_shaders() {
    let dir = tempfile::tempdir().unwrap();
    let said = ok(dir.path(), &format!("{SAMPLE} --spacing 0.3 -o section.svg"));
    let text = std::fs::read_to_string(dir.path().join("section.svg")).unwrap();
    let n = text.matches("<circle").count();
    assert!(text.starts_with("<svg ") && n > 10 && said.contains(&format!("{n} particles")), "{said}");
    for (language, word) in [("wgsl", "fn impasto_grain"), ("glsl", "ImpastoHit impasto_grain")] {
        ok(dir.path(), &format!("{SAMPLE} --spacing 0.3 --shader {language} -o grain.{language}"));
        let text = std::fs::read_to_string(dir.path().join(format!("grain.{language}"))).unwrap();
        assert!(text.contains(word), "{language}");
    }
    let out = cut(dir.path(), &format!("{SAMPLE} --grain wood --shader wgsl -o wood.wgsl"));
    let error = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(out.status.code() == Some(1) && error.lines().count() == 1 && error.contains("shader"), "{error}");
}

#[test]
fn grains_are_listed_and_a_printed_one_can_be_used() {
    let dir = tempfile::tempdir().unwrap();
    let list = ok(dir.path(), "--list-grains");
    assert!(list.lines().count() == 14 && list.contains("granite") && list.contains("geode"), "{list}");
    let text = ok(dir.path(), "--print-grain tissue").replace("#5b2a86", "#00ff00");
    std::fs::write(dir.path().join("own.toml"), text).unwrap();
    ok(dir.path(), &format!("{SAMPLE} --grain own.toml --size 64x48 -o own.png"));
    ok(dir.path(), &format!("{SAMPLE} --grain tissue --size 64x48 -o usual.png"));
    let [own, usual] = ["own.png", "usual.png"].map(|f| std::fs::read(dir.path().join(f)).unwrap());
    assert!(own != usual);
    std::fs::write(dir.path().join("bad.toml"), "spacing = 0.1\n[[layers]]\nof = \"cels\"").unwrap();
    let out = cut(dir.path(), &format!("{SAMPLE} --grain bad.toml -o bad.png"));
    assert!(String::from_utf8_lossy(&out.stderr).contains("did you mean `cells`?"));
}

#[test]
fn a_cut_moves_through_the_model() {
    let dir = tempfile::tempdir().unwrap();
    let said = ok(dir.path(), &format!("{SAMPLE} --spacing 0.5 --sweep 0.3..0.7 --frames 3 --size 64x48 -o frames"));
    assert!(said.contains("3 frames"), "{said}");
    let frames: Vec<Vec<u8>> =
        (1..=3).map(|i| std::fs::read(dir.path().join(format!("frames/frame-000{i}.png"))).unwrap()).collect();
    assert!(frames[0] != frames[1] && frames[1] != frames[2]);
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
        ("--grain granit", "did you mean `granite`?"),
        ("--grain nothing.toml", "nothing.toml"),
        ("--grain bone --kind tear", "no pieces"),
        ("--then 1,0", "X,Y,Z"),
        ("--rough 1", "rough"),
        ("--stroke 0,0", "corners"),
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
