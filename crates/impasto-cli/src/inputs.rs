//! Many files in one go: patterns that the shell left as they are, and the names of what is written for each.

use anyhow::{Result, bail};
use impasto::recipe::source::SAMPLE;
use std::path::{Path, PathBuf};

/// The files that words stand for, in order: patterns with `*` and `?` are matched against the names in their folder,
/// unless a file has that very name.
///
/// # Errors
/// When nothing matches a pattern.
pub(crate) fn expand(words: &[String]) -> Result<Vec<String>> {
    let mut files = Vec::new();
    for word in words {
        let is_pattern = word.contains(['*', '?']) && !word.starts_with(SAMPLE) && !Path::new(word).exists();
        if !is_pattern {
            files.push(word.clone());
            continue;
        }
        let found = matching(word);
        if found.is_empty() {
            bail!("no file is called like {word:?}");
        }
        files.extend(found.iter().map(|p| p.to_string_lossy().into_owned()));
    }
    Ok(files)
}

/// All files whose path is like a pattern, sorted; folders may be patterns, too.
fn matching(pattern: &str) -> Vec<PathBuf> {
    let mut found = vec![PathBuf::new()];
    for component in Path::new(pattern).components() {
        let name = component.as_os_str().to_string_lossy();
        if !name.contains(['*', '?']) {
            found.iter_mut().for_each(|p| p.push(component));
            continue;
        }
        let like: Vec<char> = name.chars().collect();
        found = found.iter().flat_map(|folder| entries(folder, &like)).collect();
    }
    found.retain(|p| p.is_file());
    found
}

/// What in a folder has a name like a pattern; hidden files only if it begins with a dot.
fn entries(folder: &Path, like: &[char]) -> Vec<PathBuf> {
    let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = std::fs::read_dir(place) else { return Vec::new() };
    let names = entries.filter_map(|e| Some(e.ok()?.file_name()));
    let is_like = |name: &std::ffi::OsString| {
        let name: Vec<char> = name.to_string_lossy().chars().collect();
        (name.first() != Some(&'.') || like.first() == Some(&'.')) && is_match(&name, like)
    };
    let mut found: Vec<PathBuf> = names.filter(is_like).map(|n| folder.join(n)).collect();
    found.sort();
    found
}

/// Whether a name is like a pattern, in which `?` is any sign and `*` any number of them.
fn is_match(name: &[char], like: &[char]) -> bool {
    // The last star takes as little as it can, and one more each time that what follows does not fit.
    let (mut n, mut l) = (0, 0);
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        match like.get(l) {
            Some('*') => {
                star = Some((l, n));
                l += 1;
            }
            Some(c) if *c == '?' || *c == name[n] => (n, l) = (n + 1, l + 1),
            _ => match &mut star {
                Some((after, taken)) => {
                    *taken += 1;
                    (n, l) = (*taken, *after + 1);
                }
                None => return false,
            },
        }
    }
    like[l..].iter().all(|c| *c == '*')
}

/// What stands for placeholders in the names of what is written.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Words {
    /// `{name}`: the file's name without what comes after its dot.
    pub(crate) name: String,
    /// `{n}`: its number, from 1, with as many digits as the last one has.
    pub(crate) n: String,
    /// `{field}`: the field that is shown.
    pub(crate) field: String,
}

impl Words {
    /// Of the input number `index` of `n_inputs`.
    pub(crate) fn of(input: &str, index: usize, n_inputs: usize) -> Self {
        let bare = input.strip_prefix(SAMPLE).unwrap_or(input);
        let path = Path::new(bare);
        let path = if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz")) {
            path.with_extension("")
        } else {
            path.into()
        };
        let name = path.file_stem().map_or(String::new(), |s| s.to_string_lossy().into_owned());
        let digits = n_inputs.to_string().len();
        Self { name, n: format!("{:0digits$}", index + 1), field: String::new() }
    }

    /// The same for a field; what a file's name cannot hold becomes `-`.
    pub(crate) fn with_field(&self, field: &str) -> Self {
        let safe = |c: char| if c.is_control() || "/\\:*?\"<>|@ ".contains(c) { '-' } else { c };
        Self { field: field.chars().map(safe).collect(), ..self.clone() }
    }

    /// A name with its placeholders filled in.
    pub(crate) fn fill(&self, name: &str) -> String {
        name.replace("{name}", &self.name).replace("{n}", &self.n).replace("{field}", &self.field)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_as_in_a_shell() {
        let is_match =
            |name: &str, like: &str| is_match(&name.chars().collect::<Vec<_>>(), &like.chars().collect::<Vec<_>>());
        for (name, like) in
            [("a.ply", "*.ply"), ("a.ply", "?.ply"), ("abcbc", "a*bc"), ("", "*"), ("aaa", "*a*a*"), ("ä.x", "?.*")]
        {
            assert!(is_match(name, like), "{name} {like}");
        }
        for (name, like) in [("a.plyx", "*.ply"), ("ab.ply", "?.ply"), ("", "?"), ("abcb", "a*bc")] {
            assert!(!is_match(name, like), "{name} {like}");
        }
    }

    #[test]
    fn patterns_become_files_in_order() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["b.ply", "a.ply", "c.obj", ".d.ply"] {
            std::fs::write(dir.path().join(name), "").unwrap();
        }
        std::fs::create_dir(dir.path().join("folder.ply")).unwrap();
        let at = |name: &str| dir.path().join(name).to_string_lossy().into_owned();
        let of = |words: &[&str]| expand(&words.iter().map(|w| at(w)).collect::<Vec<_>>());
        assert_eq!(of(&["*.ply", "none.stl"]).unwrap(), [at("a.ply"), at("b.ply"), at("none.stl")]);
        assert_eq!(of(&["?.*"]).unwrap(), [at("a.ply"), at("b.ply"), at("c.obj")]);
        assert!(of(&["*.stl"]).unwrap_err().to_string().contains("*.stl"));
        std::fs::write(dir.path().join("x*.ply"), "").unwrap();
        assert_eq!(of(&["x*.ply"]).unwrap(), [at("x*.ply")]);
    }

    #[test]
    fn placeholders_are_filled_in() {
        let words = Words::of("in/head.scan.vtp.gz", 4, 120).with_field("T/T0 max");
        assert_eq!(words.fill("out/{n}-{name}_{field}.png"), "out/005-head.scan_T-T0-max.png");
        assert_eq!(Words::of("sample:knot", 0, 1).fill("{name}{n}"), "knot1");
    }
}
