//! House rules, as a program: module order, heads of files, their length, and what README promises.

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All Rust files below a folder.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        for path in entries.map(|e| e.unwrap().path()) {
            if path.is_dir() && !path.ends_with("target") {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// Modules in the order that lib.rs declares them.
fn modules() -> Vec<String> {
    let lib = std::fs::read_to_string(root().join("crates/impasto/src/lib.rs")).unwrap();
    lib.lines().filter_map(|l| l.strip_prefix("pub mod ")?.strip_suffix(';')).map(str::to_owned).collect()
}

#[test]
fn every_file_says_its_job_and_is_short() {
    for folder in ["crates", "fuzz"] {
        for path in rust_files(&root().join(folder)) {
            let text = std::fs::read_to_string(&path).unwrap();
            // Fuzz targets open with the attribute that takes `main` away.
            let head = text.lines().find(|l| !l.starts_with("#!")).unwrap_or("");
            assert!(head.starts_with("//! "), "{path:?} opens with a //! line");
            let n_lines = text.lines().count();
            assert!(n_lines <= 1000, "{path:?} has {n_lines} lines; split it by topic");
        }
    }
}

/// Keys of recipes are public fields of these structures.
#[test]
fn every_key_of_a_recipe_is_documented() {
    let docs = std::fs::read_to_string(root().join("docs/recipes.md")).unwrap();
    for (file, name, section) in [
        ("mod", "Input", "[input]"),
        ("mod", "CutRecipe", "[cut]"),
        ("mod", "CameraRecipe", "[camera]"),
        ("mod", "PictureRecipe", "[picture]"),
        ("mod", "SurfaceRecipe", "[surface]"),
        ("mod", "LightRecipe", "[[lights]]"),
        ("layer", "LayerRecipe", "[[layers]]"),
        ("mod", "LegendRecipe", "[legend]"),
        ("mod", "Output", "[output]"),
        ("mod", "TurntableRecipe", "[turntable]"),
        ("mod", "GalleryPlace", "[gallery]"),
    ] {
        let source = root().join(format!("crates/impasto/src/recipe/{file}.rs"));
        let source = std::fs::read_to_string(source).unwrap();
        let fields = source.split(&format!("pub struct {name} {{")).nth(1).and_then(|s| s.split("\n}").next()).unwrap();
        let told = docs.split(&format!("### `{section}`")).nth(1).unwrap_or_else(|| panic!("{section} is not told"));
        let told = told.split("\n#").next().unwrap();
        for key in fields.lines().filter_map(|l| l.trim().strip_prefix("pub ")?.split(':').next()) {
            assert!(told.contains(&format!("| `{key}` |")), "{key} of {section} is not in docs/recipes.md");
        }
    }
}

/// `use crate::a::...` in module b is right when a stands above b in lib.rs. Tests may look anywhere.
#[test]
fn modules_use_only_those_above_them() {
    let modules = modules();
    let source = root().join("crates/impasto/src");
    let rank = |name: &str| modules.iter().position(|m| m == name);
    let mut arrows_down = Vec::new();
    for path in rust_files(&source) {
        let inside = path.strip_prefix(&source).unwrap();
        let first = inside.components().next().unwrap().as_os_str().to_string_lossy().into_owned();
        let Some(own) = rank(first.trim_end_matches(".rs")) else { continue };
        if inside.to_string_lossy().contains("tests") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        for line in code.lines().filter(|l| !l.trim_start().starts_with("//")) {
            for used in line.split("crate::").skip(1) {
                let name: String = used.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                if rank(&name).is_some_and(|r| r > own) {
                    arrows_down.push(format!("{} uses {name}", inside.display()));
                }
            }
        }
    }
    arrows_down.dedup();
    assert!(arrows_down.is_empty(), "arrows against the order of lib.rs: {}", arrows_down.join("; "));
}

#[test]
fn only_recipes_know_serde_and_only_par_knows_threads() {
    for path in rust_files(&root().join("crates/impasto/src")) {
        let text = std::fs::read_to_string(&path).unwrap();
        let place = path.to_string_lossy().replace('\\', "/");
        let uses = |word: &str| text.lines().any(|l| !l.trim_start().starts_with("//") && l.contains(word));
        if !place.contains("/recipe/") {
            assert!(!uses("use serde::"), "{path:?} knows serde");
        }
        if !place.ends_with("/par.rs") {
            assert!(!uses("rayon::") && !uses("std::thread::spawn"), "{path:?} knows threads");
        }
    }
}
