//! The program as a user meets it: outputs, exit codes, lines of error, and nothing left behind.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn impasto(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_impasto")).current_dir(folder).args(args).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs and demands success; answers with standard output.
fn ok(folder: &Path, args: &[&str]) -> String {
    let out = impasto(folder, args);
    assert!(out.status.success(), "{args:?}: {}", text(&out.stderr));
    text(&out.stdout)
}

/// Runs and demands exit code 1 with one line; answers with it.
fn fails(folder: &Path, args: &[&str]) -> String {
    let out = impasto(folder, args);
    let error = text(&out.stderr);
    assert!(error.matches("os error").count() < 2, "{error} says its cause once");
    assert_eq!(out.status.code(), Some(1), "{args:?}: {error}");
    assert_eq!(error.lines().count(), 1, "{args:?} says one line: {error:?}");
    assert!(error.starts_with("impasto: "), "{error}");
    error
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

const SMALL: [&str; 4] = ["--resolution", "8", "--size", "64x48"];

fn render<'a>(rest: &[&'a str]) -> Vec<&'a str> {
    ["render", "sample:cube"].into_iter().chain(SMALL).chain(rest.iter().copied()).collect()
}

#[test]
fn render_writes_what_it_is_asked_for_and_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let said = ok(dir.path(), &render(&["-o", "a.png"]));
    assert!(said.starts_with("a.png: ") && said.contains("64x48") && said.lines().count() == 1, "{said}");
    ok(dir.path(), &render(&["-o", "a.exr", "--info-buffer", "b.npz", "--info-texture", "t.png"]));
    ok(dir.path(), &render(&["--info-buffer", "b.exr"]));
    ok(dir.path(), &render(&["--info-buffer", "ids.npy", "--info-texture", "w.png", "--coding", "wide"]));
    assert_eq!(files(dir.path()), ["a.exr", "a.png", "b.exr", "b.npz", "ids.npy", "t.png", "w.png"]);
    let png = std::fs::read(dir.path().join("a.png")).unwrap();
    let said = String::from_utf8_lossy(&png);
    assert!(said.contains("Software") && said.contains("impasto render sample:cube") && said.contains("Recipe"));
    let json = ok(dir.path(), &render(&["-o", "a.png", "--json"]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["size"], serde_json::json!([64, 48]));
}

#[test]
fn a_saved_recipe_draws_the_same_picture() {
    let dir = tempfile::tempdir().unwrap();
    let layer = "noise coordinate=position frequency=3 operator=modulate";
    ok(dir.path(), &render(&["-o", "a.png", "--camera", "20,-10", "--layer", layer, "--save-recipe", "a.toml"]));
    let first = std::fs::read(dir.path().join("a.png")).unwrap();
    std::fs::remove_file(dir.path().join("a.png")).unwrap();
    ok(dir.path(), &["run", "a.toml"]);
    let again = std::fs::read(dir.path().join("a.png")).unwrap();
    // The pixels' chunks are equal; the command line in the metadata is another.
    let data = |png: &[u8]| png.windows(4).position(|w| w == b"IDAT").map(|i| png[i..].to_vec());
    assert_eq!(data(&first), data(&again));
    assert!(ok(dir.path(), &["run", "a.toml", "--print"]).contains("azimuth = 20.0"));
}

#[test]
fn info_and_probe_tell_in_text_and_json() {
    let dir = tempfile::tempdir().unwrap();
    let info = ok(dir.path(), &["info", "sample:flange", "--resolution", "16"]);
    assert!(info.contains("triangles") && info.contains("closed") && info.contains("stress"), "{info}");
    let json = ok(dir.path(), &["info", "sample:flange", "--resolution", "16", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["topology"]["closed"], true);
    let probe: Vec<&str> = ["probe", "sample:cube", "--at", "32,24"].into_iter().chain(SMALL).collect();
    assert!(ok(dir.path(), &probe).contains("triangle"));
    let json: Vec<&str> = probe.into_iter().chain(["--json"]).collect();
    let json: serde_json::Value = serde_json::from_str(&ok(dir.path(), &json)).unwrap();
    assert!(json["surfaces"][0]["triangle"].is_u64());
}

#[test]
fn errors_are_one_line_with_the_cause_and_leave_nothing() {
    let dir = tempfile::tempdir().unwrap();
    for (args, wanted) in [
        (vec!["render", "none.obj", "-o", "a.png"], "none.obj"),
        (vec!["render", "sample:cub", "-o", "a.png"], "did you mean `cube`?"),
        (render(&["-o", "a.gif"]), "png, exr"),
        (render(&["-o", "nowhere/a.png"]), "there is no folder"),
        (render(&[]), "-o picture.png"),
        (render(&["-o", "a.png", "--light", "stdio"]), "did you mean `studio`?"),
        (render(&["-o", "a.png", "--camera", "fornt"]), "did you mean `front`?"),
        (render(&["-o", "a.png", "--background", "pink"]), "#f4f3f0"),
        (render(&["-o", "a.png", "--samples", "3"]), "1, 4 or 16"),
        (render(&["-o", "a.png", "--color-by", "heat"]), "carries no data"),
        (render(&["-o", "a.png", "--texture", "none.png"]), "none.png"),
        (vec!["run", "none.toml"], "none.toml"),
        (vec!["info", "."], "impasto"),
        (vec!["probe", "sample:cube", "--at", "9999,0"], "outside"),
    ] {
        let said = fails(dir.path(), &args);
        assert!(said.contains(wanted), "{args:?}: {said}");
        assert!(files(dir.path()).is_empty(), "{args:?} leaves nothing");
    }
    std::fs::write(dir.path().join("a.toml"), "[camera]\nvew = 'top'").unwrap();
    assert!(
        fails(dir.path(), &["run", "a.toml"]).contains("line 2, column 1: unknown key `vew`; did you mean `view`?")
    );
}

#[test]
fn wrong_usage_is_exit_code_2() {
    let dir = tempfile::tempdir().unwrap();
    for args in [vec!["paint"], vec!["render"], render(&["--layer", "a.png oprator=add"]), render(&["--size", "0x5"])] {
        assert_eq!(impasto(dir.path(), &args).status.code(), Some(2), "{args:?}");
    }
}

#[test]
fn every_command_teaches_by_example_and_is_in_the_readme() {
    let dir = tempfile::tempdir().unwrap();
    let help = ok(dir.path(), &["--help"]);
    let listed = help.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| !l.is_empty());
    // Further lines of a description stand deeper.
    let named = listed.filter_map(|l| l.strip_prefix("  ").filter(|l| !l.starts_with(' ')));
    let mut commands: Vec<String> = named.filter_map(|l| l.split_whitespace().next().map(str::to_owned)).collect();
    commands.retain(|c| c != "help");
    assert!(commands.len() >= 6, "{help}");
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md");
    let readme = std::fs::read_to_string(readme).unwrap();
    let in_readme: Vec<String> =
        readme.lines().filter_map(|l| l.strip_prefix("| `impasto ")?.split('`').next().map(str::to_owned)).collect();
    assert_eq!(commands, in_readme, "README lists the commands of --help, in order");
    for command in &commands {
        let help = ok(dir.path(), &[command, "--help"]);
        assert!(help.contains("Examples:"), "{command}: {help}");
    }
}

#[test]
fn a_turntable_is_a_gif_an_animated_png_or_a_folder() {
    let dir = tempfile::tempdir().unwrap();
    let walk = |rest: &[&'static str]| -> Vec<&str> {
        let words = ["turntable", "sample:cube", "--frames", "3"].into_iter();
        words.chain(SMALL).chain(rest.iter().copied()).collect()
    };
    let said = ok(dir.path(), &walk(&["-o", "a.gif"]));
    assert!(said.starts_with("a.gif: 3 frames") && said.lines().count() == 1, "{said}");
    ok(dir.path(), &walk(&["-o", "a.png", "--background", "transparent", "--turn", "-90", "--elevation", "40"]));
    ok(dir.path(), &walk(&["-o", "frames/", "--light", "outdoor"]));
    assert_eq!(files(dir.path()), ["a.gif", "a.png", "frames"]);
    assert_eq!(files(&dir.path().join("frames")).len(), 3);
    assert!(std::fs::read(dir.path().join("a.gif")).unwrap().starts_with(b"GIF89a"));
    let recipe = "[input]\nfile = 'sample:cube'\nresolution = 8\n[picture]\nsize = [40, 30]\n[turntable]\nframes = 2\n";
    std::fs::write(dir.path().join("r.toml"), recipe).unwrap();
    assert!(ok(dir.path(), &["run", "r.toml"]).contains("r.gif: 2 frames"));
    let flange = |range: &'static str| {
        let words = ["turntable", "sample:flange", "-o", "range/", "--frames", "2", "--color-by", "stress"].into_iter();
        words.chain(SMALL).chain(["--watch-range", range]).collect::<Vec<_>>()
    };
    ok(dir.path(), &flange("0:50..0:200"));
    assert_eq!(files(&dir.path().join("range")).len(), 2);
    assert!(fails(dir.path(), &flange("0:50")).contains("like 0:10..0:200"));
    for wrong in [&["-o", "a.mp4"][..], &["-o", "b.gif", "--fps", "1000"], &["-o", "b.gif", "--camera", "atlas"]] {
        fails(dir.path(), &walk(wrong));
    }
    assert!(!dir.path().join("b.gif").exists());
}

#[test]
fn a_closed_pipe_is_no_failure() {
    let dir = tempfile::tempdir().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_impasto"))
        .current_dir(dir.path())
        .args(["completions", "bash"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let out = child.wait_with_output().unwrap();
    assert!(out.status.success() && out.stderr.is_empty(), "{}", text(&out.stderr));
}

#[test]
fn the_gallery_needs_no_file_and_makes_a_page() {
    let dir = tempfile::tempdir().unwrap();
    let said = ok(dir.path(), &["gallery", "--out", "g", "--only", "wrap/", "--size", "60x60"]);
    assert!(said.contains("index.html") && said.contains("pictures in"), "{said}");
    let page = std::fs::read_to_string(dir.path().join("g/index.html")).unwrap();
    assert!(page.contains("wrap-repeat.png") && !page.contains("http://") && !page.contains("https://"));
}

fn all_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut entries: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() { all_files(&path, found) } else { found.push(path) }
    }
}

/// Every broken file ends in a picture or in one line, within 1 GB of address space.
#[test]
fn broken_files_give_a_picture_or_one_line() {
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/7_bad_input"));
    let mut broken = Vec::new();
    all_files(data, &mut broken);
    if broken.is_empty() {
        println!("skipped: no data at {data:?}");
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    for path in broken {
        let file = path.to_string_lossy().into_owned();
        let program = env!("CARGO_BIN_EXE_impasto");
        let line = format!(
            "ulimit -v 1000000; exec '{program}' --threads 1 render '{file}' -o a.png --size 64x48 --samples 1"
        );
        let out = Command::new("sh").current_dir(dir.path()).args(["-c", &line]).output().unwrap();
        let error = text(&out.stderr);
        assert!(matches!(out.status.code(), Some(0 | 1)), "{file}: {:?} {error}", out.status);
        assert!(error.lines().count() <= 1, "{file}: {error}");
        match out.status.success() {
            true => std::fs::remove_file(dir.path().join("a.png")).unwrap(),
            false => assert!(error.starts_with("impasto: "), "{file}: {error}"),
        }
        assert!(files(dir.path()).is_empty(), "{file} leaves {:?}", files(dir.path()));
    }
}

#[test]
fn values_of_other_files_become_fields() {
    let dir = tempfile::tempdir().unwrap();
    let info = |rest: &[&str]| -> serde_json::Value {
        let args: Vec<&str> =
            ["info", "sample:cube", "--resolution", "8", "--json"].into_iter().chain(rest.iter().copied()).collect();
        serde_json::from_str(&ok(dir.path(), &args)).unwrap()
    };
    let n = info(&[])["vertices"].as_u64().unwrap();
    let rows: String = (0..n).map(|i| format!("{i},{}\n", i % 7)).collect();
    std::fs::write(dir.path().join("t.csv"), format!("id,load\n{rows}")).unwrap();
    let fields = &info(&["--field", "t.csv:load@unit=N"])["fields"];
    let found = fields.as_array().unwrap().iter().find(|f| f["name"] == "load").unwrap();
    assert_eq!((&found["unit"], &found["ranges"][0]["max"]), (&serde_json::json!("N"), &serde_json::json!(6.0)));

    let args = ["--field", "t.csv:load@id=id", "--color-by", "load", "-o", "a.png", "--save-recipe", "r.toml"];
    ok(dir.path(), &render(&args));
    let recipe = std::fs::read_to_string(dir.path().join("r.toml")).unwrap();
    assert!(recipe.contains("fields = [\"t.csv:load@id=id\"]"), "{recipe}");
    std::fs::remove_file(dir.path().join("a.png")).unwrap();
    ok(dir.path(), &["run", "r.toml"]);
    assert!(dir.path().join("a.png").exists());
    let said = fails(dir.path(), &render(&["--field", "t.csv:lode", "-o", "b.png"]));
    assert!(said.contains("no column \"lode\" in it; it has 2 columns \"id\", \"load\""), "{said}");
}
