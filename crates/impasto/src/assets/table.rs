//! Tables as text: comma, semicolon, tab or blanks between entries, with or without a line of names.
//!
//! Empty entries, `NA`, `NaN` and the like are missing. A line of names may stand behind a `#`. With semicolons and tabs a
//! comma in a number is a decimal point.

use crate::assets::Values;
use crate::assets::join::{Column, Columns};
use crate::assets::text::{self, Lines, format_error, number, string, trimmed};
use crate::error::{Report, Result, note};
use std::borrow::Cow;
use std::path::Path;

/// No table for a mesh has more columns.
const MAX_COLUMNS: usize = 1 << 16;

/// Reads a table; columns without a name have `stem` and their number, or `stem` alone.
pub(super) fn read(bytes: &[u8], path: &Path, stem: &str) -> Result<Report<Columns>> {
    let text = text::utf8(bytes);
    let mut mended = Vec::new();
    let mut comment = None;
    let mut first = None;
    // What stands before the first row.
    let mut lines = Lines::new(&text);
    let start = loop {
        let rest = lines.rest();
        let Some((_, line)) = lines.next() else { break &[][..] };
        let line = trimmed(&line);
        if let Some(said) = line.strip_prefix(b"#") {
            comment = Some(string(trimmed(said)));
        } else if !line.is_empty() {
            first = Some(string(line));
            break rest;
        }
    };
    let first = first.ok_or_else(|| format_error(path, "the table has no rows"))?;
    let separator = Separator::of(first.as_bytes());
    let first = separator.entries(first.as_bytes());
    let has_head = first.iter().any(|e| separator.number(e).is_none());
    let mut rows = Lines::new(start);
    if has_head {
        rows.next();
    }

    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut n_words: Vec<usize> = Vec::new();
    let (mut n_rows, mut n_uneven) = (0, 0);
    let most = text.len().saturating_mul(4) + (1 << 20);
    for (line_number, line) in rows {
        let line = trimmed_of(&line, separator);
        if line.is_empty() || line.starts_with(b"#") {
            continue;
        }
        let entries = separator.entries(line);
        if entries.len() > columns.len() {
            n_uneven += (n_rows > 0) as usize;
            let n = entries.len();
            if n > MAX_COLUMNS || n.saturating_mul(n_rows + 1) > most {
                let fault = format!("line {line_number}: {n} entries are too many for a table of {n_rows} rows");
                return Err(format_error(path, fault));
            }
            columns.resize(n, vec![f64::NAN; n_rows]);
            n_words.resize(n, 0);
        } else if entries.len() < columns.len() {
            n_uneven += 1;
        }
        if columns.len().saturating_mul(n_rows + 1) > most {
            let fault = format!("line {line_number}: most of its rows lack entries; it is no table");
            return Err(format_error(path, fault));
        }
        for (i, column) in columns.iter_mut().enumerate() {
            let x = entries.get(i).map_or(Some(f64::NAN), |e| separator.number(e));
            n_words[i] += x.is_none() as usize;
            column.push(x.unwrap_or(f64::NAN));
        }
        n_rows += 1;
    }
    if n_rows == 0 {
        return Err(format_error(path, "the table has no rows"));
    }
    note(&mut mended, n_uneven, "rows with another number of entries than those before; what lacks is missing");

    let mut names = match (has_head, comment) {
        (true, _) => first.iter().map(|e| string(e)).collect(),
        (false, Some(said)) => {
            Separator::of(said.as_bytes()).entries(said.as_bytes()).iter().map(|e| string(e)).collect()
        }
        (false, None) => Vec::new(),
    };
    if !has_head && names.len() != columns.len() {
        names = Vec::new();
    }
    // Some leave out the name of the column of rows' names.
    if has_head && names.len() + 1 == columns.len() {
        names.insert(0, String::new());
    }
    let has_names = !names.is_empty();
    let n_columns = columns.len();
    let (mut kept, mut n_text, mut n_bad) = (Vec::new(), 0, 0);
    for (i, (values, n_words)) in columns.into_iter().zip(n_words).enumerate() {
        if n_words > 0 && values.iter().all(|x| x.is_nan()) {
            n_text += 1;
            continue;
        }
        n_bad += n_words;
        let name = match names.get(i).map(|n| n.trim()).filter(|n| !n.is_empty()) {
            Some(name) => name.to_string(),
            None if n_columns == 1 => stem.to_string(),
            None => format!("{stem} {}", i + 1),
        };
        kept.push(Column::of(name, Values::F64(values)));
    }
    note(&mut mended, n_text, "columns of words passed over");
    note(&mut mended, n_bad, "entries that are no numbers taken as missing");
    Ok(Report { value: Columns { path: path.into(), columns: kept, has_names }, mended })
}

/// What stands between entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Separator {
    Byte(u8),
    Blanks,
}

/// Blanks at a line's ends are no entries; tabs may be.
fn trimmed_of(line: &[u8], separator: Separator) -> &[u8] {
    match separator {
        Separator::Byte(b'\t') => {
            let is_tab = line.iter().all(|b| *b == b'\t');
            if is_tab { &[] } else { line }
        }
        _ => trimmed(line),
    }
}

impl Separator {
    /// As the first line tells: the first of tab, semicolon and comma that stands outside of quotes.
    fn of(line: &[u8]) -> Self {
        let mut is_quoted = false;
        let mut found = [false; 3];
        for b in line {
            match b {
                b'"' => is_quoted = !is_quoted,
                b'\t' if !is_quoted => found[0] = true,
                b';' if !is_quoted => found[1] = true,
                b',' if !is_quoted => found[2] = true,
                _ => {}
            }
        }
        let at = found.iter().position(|f| *f);
        at.map_or(Self::Blanks, |i| Self::Byte(b"\t;,"[i]))
    }

    /// The entries of a line, quotes taken off.
    fn entries<'a>(self, line: &'a [u8]) -> Vec<Cow<'a, [u8]>> {
        let mut entries = Vec::new();
        let mut rest = line;
        loop {
            if self == Self::Blanks {
                rest = rest.trim_ascii_start();
                if rest.is_empty() {
                    return entries;
                }
            }
            let is_end = |b: &u8| match self {
                Self::Byte(s) => *b == s,
                Self::Blanks => *b <= b' ',
            };
            let body = match self {
                Self::Byte(b'\t') => rest,
                _ => rest.trim_ascii_start(),
            };
            let (entry, after) = match quoted(body) {
                Some((entry, after)) => {
                    let end = after.iter().position(is_end).unwrap_or(after.len());
                    (Cow::Owned(entry), &after[end..])
                }
                None => {
                    let end = rest.iter().position(is_end).unwrap_or(rest.len());
                    (Cow::Borrowed(trimmed(&rest[..end])), &rest[end..])
                }
            };
            entries.push(entry);
            match after.split_first() {
                Some((_, after)) => rest = after,
                None => return entries,
            }
        }
    }

    /// The number of an entry, NaN when it is missing; none when it is a word.
    fn number(self, entry: &[u8]) -> Option<f64> {
        const MISSING: [&str; 9] = ["", "na", "nan", "n/a", "null", "none", "-", "?", "."];
        let word = string(&entry[..entry.len().min(8)]).to_ascii_lowercase();
        if MISSING.contains(&word.as_str()) {
            return Some(f64::NAN);
        }
        number(entry).or_else(|| {
            let is_comma_free = !matches!(self, Self::Byte(b';' | b'\t'));
            if is_comma_free || entry.iter().filter(|b| **b == b',').count() != 1 {
                return None;
            }
            let pointed: Vec<u8> = entry.iter().map(|b| if *b == b',' { b'.' } else { *b }).collect();
            number(&pointed)
        })
    }
}

/// An entry in quotes, and what follows; a quote inside is doubled.
fn quoted(text: &[u8]) -> Option<(Vec<u8>, &[u8])> {
    let mut rest = text.strip_prefix(b"\"")?;
    let mut out = Vec::new();
    loop {
        let end = rest.iter().position(|b| *b == b'"').unwrap_or(rest.len());
        out.extend_from_slice(&rest[..end]);
        rest = rest.get(end + 1..).unwrap_or_default();
        match rest.strip_prefix(b"\"") {
            Some(after) => {
                out.push(b'"');
                rest = after;
            }
            None => return Some((out, rest)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(text: &str) -> Vec<(String, Vec<String>)> {
        let columns = read(text.as_bytes(), Path::new("a"), "a").unwrap().value.columns;
        let numbers = |c: &Column| c.values.numbers().map(|x| format!("{x}")).collect();
        columns.iter().map(|c| (c.name.clone(), numbers(c))).collect()
    }

    #[test]
    fn tables_of_all_kinds_are_understood() {
        for (text, wanted) in [
            ("1\n2\n\n3", "a:1,2,3"),
            ("x,y\n1,2\n3,4\n", "x:1,3 y:2,4"),
            ("\"a \"\"b\"\"\", c \r\n1 , 2\r\n", "a \"b\":1 c:2"),
            ("x;y\n1,5;-2\n", "x:1.5 y:-2"),
            ("x\ty\n\t2\n3\t\n", "x:NaN,3 y:2,NaN"),
            ("# u v\n1 2\n  3   4\n", "u:1,3 v:2,4"),
            ("# made by hand\n1 2\n", "a 1:1 a 2:2"),
            ("x y\nr1 1 2\nr2 3 NA\n", "x:1,3 y:2,NaN"),
            ("n,x\nfoo,1\nbar,nan\n", "x:1,NaN"),
            ("1,2\n3\n4,5,6", "a 1:1,3,4 a 2:2,NaN,5 a 3:NaN,NaN,6"),
        ] {
            let got: Vec<String> = columns(text).iter().map(|(n, v)| format!("{n}:{}", v.join(","))).collect();
            assert_eq!(got.join(" "), wanted, "{text:?}");
        }
    }

    #[test]
    fn what_is_no_table_is_refused_or_told() {
        for text in ["", "\n\n", "# only this\n", "x,y\n"] {
            assert!(read(text.as_bytes(), Path::new("a"), "a").is_err(), "{text:?}");
        }
        let wide = format!("{}\n{}", "1,".repeat(60_000), "1\n".repeat(200_000));
        assert!(read(wide.as_bytes(), Path::new("a"), "a").unwrap_err().to_string().contains("no table"));
        let report = read(b"x\n1\nq\n2\n", Path::new("a"), "a").unwrap();
        assert_eq!(report.mended[0].to_string(), "1 entries that are no numbers taken as missing");
    }
}
