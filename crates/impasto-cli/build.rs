//! Puts the gallery's recipes into the program, so that it needs no file at run time.

use std::fmt::Write;
use std::path::Path;

fn main() {
    let gallery = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../gallery");
    println!("cargo::rerun-if-changed={}", gallery.display());
    let mut recipes = Vec::new();
    for topic in sorted(&gallery) {
        println!("cargo::rerun-if-changed={}", topic.display());
        recipes.extend(sorted(&topic).into_iter().filter(|p| p.extension().is_some_and(|e| e == "toml")));
    }
    let mut code =
        String::from("/// Path within the gallery, and text, of every recipe.\nconst RECIPES: &[(&str, &str)] = &[\n");
    for path in recipes {
        println!("cargo::rerun-if-changed={}", path.display());
        let name = path.strip_prefix(&gallery).expect("recipes lie in the gallery").display().to_string();
        let text = std::fs::read_to_string(&path).expect("recipes are text");
        writeln!(code, "    ({:?}, {text:?}),", name.replace('\\', "/")).expect("strings grow");
    }
    code.push_str("];\n");
    let out = std::env::var("OUT_DIR").expect("cargo says where to");
    std::fs::write(Path::new(&out).join("gallery_recipes.rs"), code).expect("cargo's folder can be written to");
}

/// What is in a folder, by name; nothing if there is no such folder.
fn sorted(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut entries: Vec<_> =
        std::fs::read_dir(folder).map(|d| d.filter_map(|e| e.ok()).map(|e| e.path()).collect()).unwrap_or_default();
    entries.sort();
    entries
}
