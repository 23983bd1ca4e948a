//! Lines, words and numbers of text formats, from bytes of any encoding and any line ending.

use crate::error::Error;
use std::borrow::Cow;
use std::path::Path;

/// The lines of a text, counted from 1. A line ends at `\n`, `\r\n` or `\r`.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
    /// A `\` before the line's end joins the next line to it.
    joined: bool,
}

/// A line and its number.
pub(super) type Line<'a> = (usize, Cow<'a, [u8]>);

impl<'a> Lines<'a> {
    /// The lines as they stand.
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self { rest: text, number: 0, joined: false }
    }

    /// The lines, with those that end in `\` joined to the next.
    pub(super) fn joined(text: &'a [u8]) -> Self {
        Self { rest: text, number: 0, joined: true }
    }

    /// What has not been read yet.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r');
        let (line, rest) = match end {
            None => (self.rest, &[][..]),
            Some(i) => {
                let skip = if self.rest[i..].starts_with(b"\r\n") { 2 } else { 1 };
                (&self.rest[..i], &self.rest[i + skip..])
            }
        };
        self.rest = rest;
        Some(line)
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let line = self.physical()?;
        let number = self.number;
        if !self.joined || line.last() != Some(&b'\\') {
            return Some((number, Cow::Borrowed(line)));
        }
        let mut whole = line[..line.len() - 1].to_vec();
        while let Some(line) = self.physical() {
            whole.push(b' ');
            match line.strip_suffix(b"\\") {
                Some(part) => whole.extend_from_slice(part),
                None => {
                    whole.extend_from_slice(line);
                    break;
                }
            }
        }
        Some((number, Cow::Owned(whole)))
    }
}

/// The words of a line or of a whole text: what stands between blanks.
#[derive(Clone)]
pub(super) struct Words<'a>(pub(super) &'a [u8]);

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        let start = self.0.iter().position(|b| *b > b' ')?;
        let word = &self.0[start..];
        let end = word.iter().position(|b| *b <= b' ').unwrap_or(word.len());
        self.0 = &word[end..];
        Some(&word[..end])
    }
}

/// Without blanks at either end.
pub(super) fn trimmed(line: &[u8]) -> &[u8] {
    line.trim_ascii()
}

/// The number a word stands for; none unless all of it is a number. Knows `inf` and `nan` in any case.
#[inline]
pub(super) fn number(word: &[u8]) -> Option<f64> {
    match fast_float2::parse_partial::<f64, _>(word) {
        Ok((x, n)) if n == word.len() => Some(x),
        _ => None,
    }
}

/// The number a word begins with, and whether that is all of it.
#[inline]
pub(super) fn number_prefix(word: &[u8]) -> Option<(f32, bool)> {
    fast_float2::parse_partial::<f32, _>(word).ok().map(|(x, n)| (x, n == word.len()))
}

/// A whole number, with or without a sign; none if it does not fit.
#[inline]
pub(super) fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0i64;
    for d in digits {
        let d = d.wrapping_sub(b'0');
        if d > 9 {
            return None;
        }
        value = value * 10 + d as i64;
    }
    Some(if negative { -value } else { value })
}

/// Text for names and messages: invalid UTF-8 is replaced.
pub(super) fn string(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Bytes of a text file as UTF-8: a byte order mark is taken off, UTF-16 (told by its mark) is decoded.
pub(super) fn utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    let utf16 = |unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|c| unit([c[0], c[1]])).collect();
        Cow::Owned(String::from_utf16_lossy(&units).into_bytes())
    };
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(rest),
        [0xff, 0xfe, ..] => utf16(u16::from_le_bytes),
        [0xfe, 0xff, ..] => utf16(u16::from_be_bytes),
        _ => Cow::Borrowed(bytes),
    }
}

/// "Expected this, found that" at a line; what was found is shortened.
pub(super) fn parse_error(path: &Path, line: usize, expected: &str, found: &[u8]) -> Error {
    let text = String::from_utf8_lossy(&found[..found.len().min(160)]).into_owned();
    let mut found: String = text.chars().take(40).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().count() > 40 {
        found.push_str("...");
    }
    Error::Parse { path: path.into(), line, expected: expected.into(), found }
}

/// Any other fault of a file.
pub(super) fn format_error(path: &Path, fault: impl Into<String>) -> Error {
    Error::Format { path: path.into(), fault: fault.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_any_way_and_may_be_joined() {
        let lines: Vec<_> = Lines::joined(b"a\r\nb \\\nc\rd\n\ne").map(|(n, l)| (n, string(&l))).collect();
        let wanted = [(1, "a"), (2, "b  c"), (4, "d"), (5, ""), (6, "e")];
        assert_eq!(lines, wanted.map(|(n, l)| (n, l.to_string())));
    }

    #[test]
    fn numbers_are_whole_words() {
        for (word, wanted) in
            [("1.e2", Some(100.0)), ("+.5", Some(0.5)), ("-inf", Some(f64::NEG_INFINITY)), ("3.1+e2", None), ("", None)]
        {
            assert_eq!(number(word.as_bytes()), wanted, "{word}");
        }
        assert_eq!(integer(b"-12"), Some(-12));
        assert_eq!(integer(b"1234567890123456789"), None);
        assert_eq!(integer(b"1.0"), None);
    }

    #[test]
    fn utf16_is_decoded() {
        assert_eq!(&*utf8(&[0xfe, 0xff, 0, b'v', 0, b' ']), b"v ");
        assert_eq!(&*utf8(&[0xff, 0xfe, b'v', 0, 0x7f]), b"v");
    }
}
