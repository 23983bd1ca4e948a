//! Colour tables from files: lists of colours, lists of values with colours, ParaView's JSON, NumPy arrays.

use crate::assets::npy;
use crate::color::{LinearRgba, linear_from_srgb};
use crate::error::{Error, Result};
use crate::lookup::ColorTable;
use crate::lookup::mixing::{Mix, sampled};
use serde_json::Value;
use std::path::Path;

/// A table with more entries than this is a mistake.
const MOST_ENTRIES: usize = 1 << 16;
/// Entries of a table that is given by stops.
const N_SAMPLES: usize = 256;

/// Reads a colour table; `name` is for messages. Where the file names values, they are the table's range, else it is
/// [0, 1]. Known are:
/// - text, a colour a line: `#rrggbb` or `#rrggbbaa`, or `r g b` (0-1 or 0-255; blanks, commas or slashes between);
/// - text, a value and its colour a line: `value r g b` or `value r g b a`, mixed in sRGB; `nan r g b` for missing values;
/// - GMT's `.cpt`: `value r g b value r g b`, with `B`, `F` and `N` lines for below, above and missing;
/// - ParaView's JSON colour maps: `RGBPoints` mixed in their `ColorSpace`, or `IndexedColors`; `NanColor`;
/// - NumPy: `n x 3` or `n x 4`.
///
/// # Errors
/// `Parse` with the line, `Format`.
pub fn parse(bytes: &[u8], name: &str) -> Result<ColorTable> {
    let path = Path::new(name);
    if bytes.starts_with(b"\x93NUMPY") {
        return of_array(&npy::read(bytes, path)?, path);
    }
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    match text.trim_start().starts_with(['{', '[']) {
        true => of_json(text, path),
        false => of_text(text, path),
    }
}

fn fault(path: &Path, what: impl Into<String>) -> Error {
    Error::Format { path: path.into(), fault: what.into() }
}

/// Colours as the table's entries.
fn listed(colors: Vec<LinearRgba>, path: &Path) -> Result<ColorTable> {
    match colors.len() {
        0 => Err(fault(path, "no colour in it; a table is #rrggbb a line, or `value r g b` lines, or ParaView's JSON")),
        n if n > MOST_ENTRIES => {
            Err(fault(path, format!("{n} colours are too many for a table, {MOST_ENTRIES} the most")))
        }
        _ => Ok(ColorTable::over([0.0, 1.0], colors)),
    }
}

/// Colours at values, in rising or falling order.
fn of_stops(mut stops: Vec<(f64, LinearRgba)>, mix: Mix, path: &Path) -> Result<ColorTable> {
    if stops.first().zip(stops.last()).is_some_and(|(a, b)| a.0 > b.0) {
        stops.reverse();
    }
    if let Some(i) = (1..stops.len()).find(|&i| stops[i].0 < stops[i - 1].0) {
        return Err(fault(path, format!("the values must rise: {} stands beside {}", stops[i].0, stops[i - 1].0)));
    }
    if stops.len() < 2 || stops[0].0 == stops[stops.len() - 1].0 {
        return Err(fault(path, "a table by values needs two of them"));
    }
    let range = [stops[0].0 as f32, stops[stops.len() - 1].0 as f32];
    Ok(ColorTable::over(range, sampled(&stops, N_SAMPLES, mix)))
}

/// sRGB numbers to a colour; all of a file are either within 0-1 or within 0-255.
#[derive(Clone, Copy)]
struct Scale(f64);

impl Scale {
    fn of(numbers: impl IntoIterator<Item = f64>, path: &Path) -> Result<Self> {
        let mut most = 0.0;
        for x in numbers {
            if !(0.0..=255.0).contains(&x) {
                return Err(fault(path, format!("{x} is no part of a colour, which has 0 to 1 or 0 to 255")));
            }
            most = x.max(most);
        }
        Ok(Self(if most > 1.0 { 255.0 } else { 1.0 }))
    }

    fn color(self, c: &[f64]) -> LinearRgba {
        let part = |x: f64| linear_from_srgb((x / self.0).clamp(0.0, 1.0)) as f32;
        [part(c[0]), part(c[1]), part(c[2]), c.get(3).map_or(1.0, |a| (a / self.0) as f32)]
    }
}

fn of_array(array: &npy::Array, path: &Path) -> Result<ColorTable> {
    let &[_, n @ (3 | 4)] = &array.shape[..] else {
        return Err(fault(
            path,
            format!("an array of shape {:?} is no colour table, which is n x 3 or n x 4", array.shape),
        ));
    };
    let scale = Scale::of(array.values.iter().copied(), path)?;
    listed(array.values.chunks_exact(n).take(MOST_ENTRIES + 1).map(|c| scale.color(c)).collect(), path)
}

/// What a line of text says.
enum Line {
    Color(LinearRgba),
    Numbers(Vec<f64>),
    Below(Vec<f64>),
    Above(Vec<f64>),
    Missing(Vec<f64>),
}

fn of_text(text: &str, path: &Path) -> Result<ColorTable> {
    let (mut colors, mut rows) = (Vec::new(), Vec::new());
    let [mut below, mut above, mut missing] = [None, None, None];
    for (i, line) in text.lines().enumerate() {
        let wrong = |expected: &str| Error::Parse {
            path: path.into(),
            line: i + 1,
            expected: expected.into(),
            found: line.trim().chars().take(40).collect(),
        };
        match said(line) {
            None if is_silent(line) => {}
            None => return Err(wrong("#rrggbb, or numbers like `value r g b`")),
            Some(Line::Color(_)) if !rows.is_empty() => return Err(wrong("numbers, as in the lines before")),
            Some(Line::Color(color)) => colors.push(color),
            Some(Line::Numbers(_)) if !colors.is_empty() => return Err(wrong("#rrggbb, as in the lines before")),
            Some(Line::Numbers(row)) => {
                let n = rows.first().map_or(row.len(), Vec::len);
                if row.len() != n || !matches!(n, 3 | 4 | 5 | 8) {
                    return Err(wrong(&match n {
                        3 | 4 | 5 | 8 => format!("{n} numbers, as in the lines before"),
                        _ => "`r g b`, `value r g b` or `value r g b a`".into(),
                    }));
                }
                rows.push(row);
            }
            Some(Line::Below(c)) => below = Some(c),
            Some(Line::Above(c)) => above = Some(c),
            Some(Line::Missing(c)) => missing = Some(c),
        }
        if rows.len().max(colors.len()) > MOST_ENTRIES {
            return Err(fault(path, format!("more than {MOST_ENTRIES} colours are too many for a table")));
        }
    }
    let Some(n) = rows.first().map(Vec::len) else { return listed(colors, path) };
    let parts = |row: &[f64]| -> Vec<f64> {
        match n {
            3 => row.to_vec(),
            8 => [&row[1..4], &row[5..8]].concat(),
            _ => row[1..].to_vec(),
        }
    };
    let apart = [&below, &above, &missing].into_iter().flatten().flatten();
    let scale = Scale::of(rows.iter().flat_map(|r| parts(r)).chain(apart.copied()), path)?;
    let mut table = match n {
        3 => listed(rows.iter().map(|r| scale.color(r)).collect(), path)?,
        8 => {
            let ends = |r: &Vec<f64>| [(r[0], scale.color(&r[1..4])), (r[4], scale.color(&r[5..8]))];
            of_stops(rows.iter().flat_map(ends).collect(), Mix::Srgb, path)?
        }
        _ => of_stops(rows.iter().map(|r| (r[0], scale.color(&r[1..]))).collect(), Mix::Srgb, path)?,
    };
    table.below = below.map(|c| scale.color(&c));
    table.above = above.map(|c| scale.color(&c));
    table.missing = missing.map_or(table.missing, |c| scale.color(&c));
    Ok(table)
}

/// Blank, or a remark.
fn is_silent(line: &str) -> bool {
    line.trim().is_empty() || line.trim_start().starts_with(['#', ';', '%']) || line.starts_with("//")
}

/// None for what is not understood, and for remarks.
fn said(line: &str) -> Option<Line> {
    let line = line.trim();
    let bare = line.trim_matches(['"', '\'', ',', ' ']);
    if let Some(color) = bare.strip_prefix('#').and_then(hex) {
        return Some(Line::Color(color));
    }
    if line.starts_with(['#', ';', '%']) {
        return None;
    }
    let words: Vec<&str> = line.split([' ', '\t', ',', '/']).filter(|w| !w.is_empty()).collect();
    let number = |w: &&str| w.parse::<f64>().ok().filter(|x| x.is_finite());
    let numbers = |words: &[&str]| words.iter().map(number).collect::<Option<Vec<f64>>>();
    let color = |words: &[&str]| numbers(words).filter(|c| matches!(c.len(), 3 | 4));
    match words.split_first()? {
        (&"B", rest) => color(rest).map(Line::Below),
        (&"F", rest) => color(rest).map(Line::Above),
        (word, rest) if ["n", "nan", "nv"].contains(&word.to_ascii_lowercase().as_str()) => {
            color(rest).map(Line::Missing)
        }
        _ => numbers(&words).map(Line::Numbers),
    }
}

fn hex(digits: &str) -> Option<LinearRgba> {
    if !matches!(digits.len(), 6 | 8) || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let parts: Vec<f64> = (0..digits.len())
        .step_by(2)
        .filter_map(|i| u8::from_str_radix(&digits[i..i + 2], 16).ok())
        .map(f64::from)
        .collect();
    Some(Scale(255.0).color(&parts))
}

fn of_json(text: &str, path: &Path) -> Result<ColorTable> {
    let json: Value = serde_json::from_str(text).map_err(|e| fault(path, e.to_string()))?;
    let map = if json.is_array() { &json[0] } else { &json };
    let numbers = |key: &str| -> Result<Option<Vec<f64>>> {
        let Some(list) = map.get(key) else { return Ok(None) };
        let list = list.as_array().and_then(|l| l.iter().map(Value::as_f64).collect::<Option<Vec<_>>>());
        list.map(Some).ok_or_else(|| fault(path, format!("{key:?} is no list of numbers")))
    };
    let color = |key: &str| -> Result<Option<LinearRgba>> {
        let Some(c) = numbers(key)? else { return Ok(None) };
        match c.len() {
            3 | 4 => Ok(Some(Scale::of(c.iter().copied(), path)?.color(&c))),
            n => Err(fault(path, format!("{key:?} has {n} numbers, a colour has three"))),
        }
    };
    let grouped =
        |list: &[f64], key: &str, n: usize| match list.len().is_multiple_of(n) && list.len() / n <= MOST_ENTRIES {
            true => Ok(()),
            false => Err(fault(path, format!("{key:?} has {} numbers, no usable multiple of {n}", list.len()))),
        };
    let mut table = if let Some(points) = numbers("RGBPoints")? {
        grouped(&points, "RGBPoints", 4)?;
        let scale = Scale::of(points.chunks_exact(4).flat_map(|p| p[1..].iter().copied()), path)?;
        let mix = match map.get("ColorSpace").and_then(Value::as_str).unwrap_or("RGB").to_ascii_lowercase().as_str() {
            "lab" | "cielab" | "lab/ciede2000" => Mix::Lab,
            "hsv" => Mix::Hsv,
            "diverging" => Mix::Diverging,
            "step" => Mix::Step,
            _ => Mix::Srgb,
        };
        of_stops(points.chunks_exact(4).map(|p| (p[0], scale.color(&p[1..]))).collect(), mix, path)?
    } else if let Some(colors) = numbers("IndexedColors")? {
        grouped(&colors, "IndexedColors", 3)?;
        let scale = Scale::of(colors.iter().copied(), path)?;
        listed(colors.chunks_exact(3).map(|c| scale.color(c)).collect(), path)?
    } else {
        return Err(fault(path, "JSON without \"RGBPoints\" or \"IndexedColors\" is no colour map of ParaView"));
    };
    table.missing = color("NanColor")?.unwrap_or(table.missing);
    let is_used = |key: &str| map.get(key).is_some_and(|v| v.as_bool() == Some(true) || v.as_f64() == Some(1.0));
    if is_used("UseBelowRangeColor") {
        table.below = color("BelowRangeColor")?;
    }
    if is_used("UseAboveRangeColor") {
        table.above = color("AboveRangeColor")?;
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::srgb8_from_linear;

    fn bytes(c: LinearRgba) -> [u8; 3] {
        [0, 1, 2].map(|k| srgb8_from_linear(c[k]))
    }

    fn check(text: &str, range: [f32; 2], n: usize, ends: [[u8; 3]; 2]) -> ColorTable {
        let table = parse(text.as_bytes(), "a.txt").unwrap_or_else(|e| panic!("{text:?}: {e}"));
        assert_eq!((table.range, table.colors.len()), (range, n), "{text:?}");
        assert_eq!([table.colors[0], table.colors[n - 1]].map(bytes), ends, "{text:?}");
        table
    }

    #[test]
    fn lists_of_colours_are_tables() {
        check("# a remark\n#ff0000\n\n#00FF00\r\n\"#0000ff\",\n", [0.0, 1.0], 3, [[255, 0, 0], [0, 0, 255]]);
        check("0 0 0\n128,128,128\n255\t255 255", [0.0, 1.0], 3, [[0; 3], [255; 3]]);
        check("0.0 0.0 1.0\n1 1 1\n", [0.0, 1.0], 2, [[0, 0, 255], [255; 3]]);
        assert_eq!(parse(b"#00000080", "a").unwrap().colors[0][3], 128.0 / 255.0);
    }

    #[test]
    fn values_with_colours_bring_their_range() {
        let table = check(
            "-10 0 0 255\n0 255 255 255\nnan 9 9 9\n30 255 0 0\n",
            [-10.0, 30.0],
            256,
            [[0, 0, 255], [255, 0, 0]],
        );
        assert_eq!(bytes(table.missing), [9; 3]);
        let (white, half) = (bytes(table.color(0.0)), bytes(table.color(-5.0)));
        assert!(white[0] > 248 && half[0].abs_diff(128) < 4 && half[2] == 255, "{white:?} {half:?}");
        check("1 255 0 0\n0 0 0 255\n", [0.0, 1.0], 256, [[0, 0, 255], [255, 0, 0]]);
        let gmt =
            "# COLOR_MODEL = RGB\n0 10 20 30 5 10 20 30\n5 200/210/220 10 200/210/220\nB 1 1 1\nF 2 2 2\nN 3 3 3\n";
        let table = check(gmt, [0.0, 10.0], 256, [[10, 20, 30], [200, 210, 220]]);
        assert_eq!([4.9, 5.1, -1.0, 11.0, f32::NAN].map(|v| bytes(table.color(v))[0]), [10, 200, 1, 2, 3]);
    }

    #[test]
    fn paraviews_maps_are_mixed_as_they_say() {
        let json = r#"[{"ColorSpace": "Diverging", "Name": "Cool to Warm", "NanColor": [1, 1, 0],
            "RGBPoints": [-1, 0.23137254902, 0.298039215686, 0.752941176471, 1, 0.705882352941, 0.0156862745098, 0.149019607843]}]"#;
        let table = check(json, [-1.0, 1.0], 256, [[59, 76, 192], [180, 4, 38]]);
        let middle = bytes(table.color(0.0));
        assert!(middle.iter().all(|c| c.abs_diff(221) <= 3), "{middle:?}");
        assert_eq!(bytes(table.missing), [255, 255, 0]);
        check(r#"{"IndexedColors": [0, 0, 0, 1, 1, 1]}"#, [0.0, 1.0], 2, [[0; 3], [255; 3]]);
    }

    #[test]
    fn arrays_are_tables() {
        let array = |shape: &str, data: &[f32]| {
            let head = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
            let mut bytes = b"\x93NUMPY\x01\0".to_vec();
            bytes.extend((head.len() as u16).to_le_bytes());
            bytes.extend(head.bytes());
            bytes.extend(data.iter().flat_map(|x| x.to_le_bytes()));
            bytes
        };
        let table = parse(&array("(2, 3)", &[0.0, 0.5, 1.0, 1.0, 1.0, 1.0]), "a.npy").expect("a table");
        assert_eq!(bytes(table.colors[0]), [0, 128, 255]);
        let fault = parse(&array("(6,)", &[0.0; 6]), "a.npy").expect_err("no table").to_string();
        assert!(fault.contains("n x 3"), "{fault}");
    }

    #[test]
    fn faults_name_their_place() {
        for (text, wanted) in [
            ("", "no colour in it"),
            ("# only remarks\n", "no colour in it"),
            ("#ff0000\n#gg0000\nred", "line 3: expected #rrggbb"),
            ("0 0 0\n1 2", "line 2: expected 3 numbers"),
            ("1 2", "line 1: expected `r g b`"),
            ("#ff0000\n1 2 3", "line 2: expected #rrggbb, as"),
            ("0 0 0 0\n1 300 0 0", "300 is no part of a colour"),
            ("0 0 0 -1\n1 3 0 0", "-1 is no part"),
            ("0 0 0 1\n2 1 1 1\n1 0 0 0\n3 1 1 1", "the values must rise"),
            ("0 0 0 1", "needs two"),
            ("{", "EOF"),
            ("[]", "RGBPoints"),
            (r#"{"RGBPoints": [1, 2, 3]}"#, "3 numbers"),
            (r#"{"RGBPoints": "x"}"#, "no list of numbers"),
            ("1e400 0 0 0\n0 0 0 0", "line 1"),
        ] {
            let fault = parse(text.as_bytes(), "a.txt").expect_err(text).to_string();
            assert!(fault.contains("a.txt") && fault.contains(wanted) && !fault.contains('\n'), "{text:?}: {fault}");
        }
    }
}
