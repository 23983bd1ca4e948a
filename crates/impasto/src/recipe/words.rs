//! Words and colours that people write, and what they stand for.

use crate::color::{LinearRgba, linear_from_srgb};
use crate::error::{Error, Result};
use crate::recipe::text::guess;

/// The value that a word stands for.
///
/// # Errors
/// `Parameter` with a guess at what was meant.
pub(super) fn choose<T: Copy>(what: &str, given: &str, known: &[(&str, T)]) -> Result<T> {
    let folded = given.to_ascii_lowercase().replace('_', "-");
    known.iter().find(|(name, _)| *name == folded).map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        impossible(what, given, guess(&folded, &names))
    })
}

/// [`choose`], or `absent` when nothing is given.
pub(super) fn choose_or<T: Copy>(what: &str, given: &Option<String>, known: &[(&str, T)], absent: T) -> Result<T> {
    given.as_deref().map_or(Ok(absent), |given| choose(what, given, known))
}

/// The error about a number or name that cannot be.
pub(super) fn impossible(what: &str, given: impl ToString, why: impl Into<String>) -> Error {
    Error::Parameter { what: what.into(), given: given.to_string(), why: why.into() }
}

/// `#rgb`, `#rrggbb` or `#rrggbbaa` in sRGB, a comma list of bytes, or one of a few names; to linear light and alpha.
///
/// # Errors
/// `Parameter` when it is none of these.
pub fn color(what: &str, given: &str) -> Result<LinearRgba> {
    const NAMES: [(&str, [u8; 4]); 8] = [
        ("white", [255; 4]),
        ("black", [0, 0, 0, 255]),
        ("grey", [128, 128, 128, 255]),
        ("red", [214, 69, 65, 255]),
        ("green", [62, 142, 90, 255]),
        ("blue", [52, 108, 176, 255]),
        ("yellow", [240, 196, 72, 255]),
        ("transparent", [255, 255, 255, 0]),
    ];
    let why = "a colour is #rrggbb, #rrggbbaa, three numbers 0-255 like 244,243,240, or a name like white";
    let bytes = if let Some(hex) = given.strip_prefix('#') {
        hex_bytes(hex)
    } else if given.contains(',') {
        let numbers: Option<Vec<u8>> = given.split(',').map(|x| x.trim().parse().ok()).collect();
        numbers.and_then(|v| match v[..] {
            [r, g, b] => Some([r, g, b, 255]),
            [r, g, b, a] => Some([r, g, b, a]),
            _ => None,
        })
    } else {
        NAMES.iter().find(|(name, _)| *name == given).map(|(_, bytes)| *bytes)
    };
    let [r, g, b, a] = bytes.ok_or_else(|| impossible(what, given, why))?;
    let linear = |x: u8| linear_from_srgb(x as f64 / 255.0) as f32;
    Ok([linear(r), linear(g), linear(b), a as f32 / 255.0])
}

fn hex_bytes(hex: &str) -> Option<[u8; 4]> {
    let digits: Option<Vec<u8>> = hex.chars().map(|c| c.to_digit(16).map(|d| d as u8)).collect();
    match digits?[..] {
        [r, g, b] => Some([r * 17, g * 17, b * 17, 255]),
        [r, s, g, h, b, c] => Some([r * 16 + s, g * 16 + h, b * 16 + c, 255]),
        [r, s, g, h, b, c, a, d] => Some([r * 16 + s, g * 16 + h, b * 16 + c, a * 16 + d]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read_in_their_spellings() {
        let white = [1.0; 4];
        for text in ["#fff", "#ffffff", "#FFFFFFFF", "255,255,255", "255, 255, 255, 255", "white"] {
            assert_eq!(color("c", text).unwrap(), white, "{text}");
        }
        assert_eq!(color("c", "#00000080").unwrap()[3], 128.0 / 255.0);
        for text in ["#ffff", "#gggggg", "1,2", "256,0,0", "whyte", ""] {
            assert!(color("c", text).is_err(), "{text}");
        }
    }
}
