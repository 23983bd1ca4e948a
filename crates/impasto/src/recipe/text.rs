//! Recipes as TOML text: read with errors that name line and column and guess what was meant, and written.

use crate::error::{Error, Result};
use crate::recipe::Recipe;
use std::path::Path;

/// Reads a recipe. `path` is only for messages.
///
/// # Errors
/// `Format` with line and column, in one line.
pub fn parse(text: &str, path: &Path) -> Result<Recipe> {
    parse_as(text, path)
}

/// Any form of TOML, with the same errors.
pub(super) fn parse_as<T: serde::de::DeserializeOwned>(text: &str, path: &Path) -> Result<T> {
    toml::from_str(text).map_err(|e| {
        let place = e.span().map(|span| {
            let before = &text[..span.start.min(text.len())];
            let line = before.matches('\n').count() + 1;
            let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
            format!("line {line}, column {column}: ")
        });
        Error::Format { path: path.into(), fault: format!("{}{}", place.unwrap_or_default(), one_line(e.message())) }
    })
}

/// A recipe as TOML.
pub fn to_toml(recipe: &Recipe) -> String {
    toml::to_string_pretty(recipe).expect("a recipe has no key that TOML cannot say")
}

/// A message of the parser in one line; where it lists what it knows, the nearest name is put first.
pub(super) fn one_line(message: &str) -> String {
    let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let Some((given, known)) = quoted.split_first() else { return message };
    let Some((what, _)) = message.split_once(", expected") else { return message };
    if !message.starts_with("unknown ") {
        return message;
    }
    let what = what.replace("unknown field", "unknown key").replace("unknown variant", "unknown name");
    format!("{what}; {}", guess(given, known))
}

/// "did you mean `x`?", or the list of what is known.
pub fn guess(given: &str, known: &[&str]) -> String {
    let near = known.iter().map(|k| (distance(given, k), k)).min_by_key(|(d, _)| *d);
    match near {
        Some((d, name)) if d <= 1 + name.len().min(given.len()) / 4 => format!("did you mean `{name}`?"),
        _ => format!("known are {}", known.join(", ")),
    }
}

/// Letters to insert, remove, replace or swap to get from one word to the other (Damerau 1964, restricted form).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) =
        (a.to_lowercase().replace('_', "-").chars().collect(), b.to_lowercase().replace('_', "-").chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let replace = rows[i - 1][j - 1] + (a[i - 1] != b[j - 1]) as usize;
                let best = replace.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
                let swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                if swapped { best.min(rows[i - 2][j - 2] + 1) } else { best }
            };
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, wanted: &str) {
        let got = parse(text, Path::new("a.toml")).expect_err(text).to_string();
        assert_eq!(got, wanted, "{text:?}");
    }

    #[test]
    fn errors_say_where_and_guess_what_was_meant() {
        check("[input]\nfiel = \"a.obj\"", "\"a.toml\": line 2, column 1: unknown key `fiel`; did you mean `file`?");
        check("[picture]\nsampels = 4", "\"a.toml\": line 2, column 1: unknown key `sampels`; did you mean `samples`?");
        check("title = 3", "\"a.toml\": line 1, column 9: invalid type: integer `3`, expected a string");
        check(
            "[[layers]]\n  image = 'a'\n  wrop = 'repeat'",
            "\"a.toml\": line 3, column 3: unknown key `wrop`; did you mean `wrap`?",
        );
        let list = parse("zzzzzz = 1", Path::new("a.toml")).unwrap_err().to_string();
        assert!(list.contains("known are title, about, input") && !list.contains('\n'), "{list}");
        let broken = parse("[input\nfile = 1", Path::new("a.toml")).unwrap_err().to_string();
        assert!(broken.contains("line 1") && !broken.contains('\n'), "{broken}");
    }

    #[test]
    fn a_recipe_survives_the_round_trip() {
        let text =
            "title = \"T\"\n[input]\nfile = \"sample:knot\"\n[camera]\nview = \"top\"\n[[layers]]\nimage = \"a.png\"\n";
        let recipe = parse(text, Path::new("a.toml")).unwrap();
        let again = to_toml(&recipe);
        assert_eq!(parse(&again, Path::new("b.toml")).unwrap(), recipe, "{again}");
        assert!(!again.contains("[picture]"), "{again}");
    }
}
