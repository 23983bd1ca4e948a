//! `FILE:COLUMN@rows=0..100`: values of another file that become fields of the scene's mesh.

use crate::assets::join::{self, JoinOptions};
use crate::assets::{Element, Scene};
use crate::error::{Mended, Result};
use crate::recipe::source::place;
use crate::recipe::words::impossible;
use std::ops::Range;
use std::path::Path;

/// What can be asked for, for messages.
const FORM: &str =
    "FILE, FILE:COLUMN, and after it @rows=0..100, @id=COLUMN, @on=vertices or @on=faces, @as=NAME, @unit=TEXT";

/// Gives the scene's mesh the fields that a recipe names.
pub(super) fn join(fields: &[String], base: &Path, scene: &mut Scene, mended: &mut Vec<Mended>) -> Result<()> {
    for given in fields {
        let (file, options) = parse(given)?;
        let columns = join::read(&place(base, file))?;
        mended.extend(columns.mended);
        mended.extend(columns.value.join(&mut scene.mesh, &options)?);
    }
    Ok(())
}

/// The file, and how its columns are joined.
fn parse(given: &str) -> Result<(&str, JoinOptions)> {
    const KEYS: [&str; 5] = ["@rows=", "@id=", "@on=", "@as=", "@unit="];
    let wrong = || impossible("field", given, FORM);
    let next_key = |text: &str| KEYS.iter().filter_map(|k| text.find(k)).min();
    let (head, mut rest) = given.split_at(next_key(given).unwrap_or(given.len()));
    let mut options = JoinOptions::default();
    while let Some((key, value)) = rest.split_once('=') {
        let (value, after) = value.split_at(next_key(value).unwrap_or(value.len()));
        match key {
            "@rows" => options.rows = Some(rows(value).ok_or_else(wrong)?),
            "@id" => options.id = Some(value.into()),
            "@on" => {
                options.element = Some(match value {
                    "vertices" | "vertex" | "points" => Element::Vertex,
                    "faces" | "face" | "cells" => Element::Face,
                    _ => return Err(wrong()),
                });
            }
            "@as" => options.name = Some(value.into()),
            _ => options.unit = Some(value.into()),
        }
        rest = after;
    }
    // The colon of a drive's letter is part of the file's name.
    let is_drive = head.as_bytes().get(1) == Some(&b':') && matches!(head.as_bytes().get(2), Some(b'/' | b'\\'));
    let colon = if is_drive { head[2..].find(':').map(|i| i + 2) } else { head.find(':') };
    let file = match colon {
        Some(i) if i + 1 < head.len() => {
            options.column = Some(head[i + 1..].into());
            &head[..i]
        }
        Some(_) => return Err(wrong()),
        None => head,
    };
    if file.is_empty() { Err(wrong()) } else { Ok((file, options)) }
}

/// `0..100`: the first and the one after the last.
fn rows(text: &str) -> Option<Range<usize>> {
    let (start, end) = text.split_once("..")?;
    Some(start.trim().parse().ok()?..end.trim().parse().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_columns_and_ways_are_told_apart() {
        let of = |given| parse(given).unwrap();
        assert_eq!(of("a.csv"), ("a.csv", JoinOptions::default()));
        let column = |c: &str| JoinOptions { column: Some(c.into()), ..Default::default() };
        assert_eq!(of("a/b.csv:x:y/z"), ("a/b.csv", column("x:y/z")));
        assert_eq!(of(r"C:\t\a.csv:2"), (r"C:\t\a.csv", column("2")));
        let all = JoinOptions {
            rows: Some(3..9),
            id: Some("no".into()),
            element: Some(Element::Face),
            name: Some("n".into()),
            unit: Some("m/s".into()),
            ..column("x")
        };
        assert_eq!(of("me@home.csv:x@rows=3..9@id=no@on=faces@as=n@unit=m/s"), ("me@home.csv", all));
        for wrong in ["", "a.csv:", ":x", "a@rows=3", "a@rows=x..3", "a@on=edges"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
