//! Numbers as people write them: few digits, real minus signs, aligned decimals, common factors.

use crate::math::exact;

/// How large and small numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Notation {
    /// As they are from 0.001 to 100 000; beyond with a common factor, a power of a thousand.
    #[default]
    Auto,
    /// With a prefix of the unit (kPa, µm) where the unit takes one, else as `Engineering`.
    Si,
    /// From 1 to 1000 times a power of a thousand.
    Engineering,
    /// All digits.
    Plain,
}

/// The labels of several numbers that stand in a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// A label for each number, all with the same decimals: label x 10^exponent + offset.
    pub labels: Vec<String>,
    /// The common factor's power of ten, a multiple of three.
    pub exponent: i32,
    /// What to add to all, where it would only repeat digits; else 0.
    pub offset: f64,
}

/// Writes numbers that may be rounded by `tolerance`.
pub fn column(values: &[f64], tolerance: f64, notation: Notation) -> Column {
    let offset = offset(values, tolerance);
    let rest: Vec<f64> = values.iter().map(|v| v - offset).collect();
    let greatest = rest.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let exponent = factor(greatest, notation);
    let scale = power_of_ten(exponent);
    let (rest, tolerance): (Vec<f64>, f64) = (rest.iter().map(|v| v / scale).collect(), tolerance / scale);
    let is_enough = |decimals: &usize| {
        let unit = power_of_ten(-(*decimals as i32));
        rest.iter().all(|v| (v - (v / unit).round() * unit).abs() <= tolerance.max(v.abs() * 1e-12))
    };
    let decimals = (0..12).find(is_enough).unwrap_or(12);
    Column { labels: rest.iter().map(|v| fixed(*v, decimals)).collect(), exponent, offset }
}

/// A round number to take off all, where more than five digits would be needed and all begin with the same.
fn offset(values: &[f64], tolerance: f64) -> f64 {
    let low = values.iter().fold(f64::INFINITY, |m, v| m.min(*v));
    let high = values.iter().fold(f64::NEG_INFINITY, |m, v| m.max(*v));
    let (extent, greatest) = (high - low, low.abs().max(high.abs()));
    let is_far = low.signum() == high.signum() && low.abs().min(high.abs()) > extent * 1e3;
    if !(extent > 0.0 && is_far && greatest > tolerance.max(extent * 1e-3) * 1e5) {
        return 0.0;
    }
    let unit = power_of_ten(exact::log10(extent * 0.999).ceil() as i32);
    (low / unit).floor() * unit
}

/// The common factor's power of ten for numbers up to `greatest`.
fn factor(greatest: f64, notation: Notation) -> i32 {
    let [low, high] = match notation {
        Notation::Auto => [1e-3, 1e5],
        Notation::Si | Notation::Engineering => [1.0, 1e3],
        Notation::Plain => [1e-9, 1e15],
    };
    // A number that is 1000 but for rounding counts as 1000.
    let near = greatest * (1.0 + 1e-9);
    if greatest == 0.0 || (near >= low && near < high) { 0 } else { thousands(near) }
}

/// The greatest power of a thousand not above a positive number, as a power of ten.
fn thousands(x: f64) -> i32 {
    (exact::log10(x) / 3.0).floor() as i32 * 3
}

/// Ten to a power, exactly rounded.
pub(super) fn power_of_ten(exponent: i32) -> f64 {
    // Decimal text to f64 is exact; products of tenths are not.
    format!("1e{exponent}").parse().unwrap_or(f64::INFINITY)
}

/// A number with so many decimals and a real minus sign.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| matches!(b, b'0' | b'.')) => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// One number in at most so many significant digits.
pub fn single(value: f64, n_digits: usize, notation: Notation) -> String {
    if !value.is_finite() {
        let sign = if value < 0.0 { "−" } else { "" };
        return if value.is_nan() { "NaN".to_owned() } else { format!("{sign}∞") };
    }
    let n_digits = n_digits.max(1);
    // Rounded first, so that 999.96 is not "1000.0".
    let rounded: f64 = format!("{value:.*e}", n_digits - 1).parse().unwrap_or(value);
    let exponent = match notation {
        Notation::Auto if rounded != 0.0 && !(1e-3..1e5).contains(&rounded.abs()) => power_below(rounded),
        Notation::Auto => 0,
        _ => factor(rounded.abs(), notation),
    };
    let mantissa = rounded / power_of_ten(exponent);
    let before = if mantissa == 0.0 { 1 } else { power_below(mantissa) + 1 };
    let mut text = fixed(mantissa, (n_digits as i32 - before).max(0) as usize);
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    match (exponent, notation) {
        (0, _) => text,
        (_, Notation::Si) if prefix(exponent).is_some() => format!("{text} {}", prefix(exponent).unwrap_or_default()),
        _ if text == "1" || text == "−1" => text.replace('1', &power_text(exponent)),
        _ => format!("{text}×{}", power_text(exponent)),
    }
}

/// The greatest power of ten not above a number's size.
fn power_below(x: f64) -> i32 {
    let text = format!("{x:e}");
    text.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0)
}

/// "10⁻⁶".
pub(super) fn power_text(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised =
        exponent.to_string().chars().map(|c| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize])).collect::<String>();
    format!("10{raised}")
}

/// The SI's letter for a power of ten.
pub(super) fn prefix(exponent: i32) -> Option<&'static str> {
    const LETTERS: [&str; 17] = ["y", "z", "a", "f", "p", "n", "µ", "m", "", "k", "M", "G", "T", "P", "E", "Z", "Y"];
    if exponent % 3 != 0 { None } else { LETTERS.get(usize::try_from(exponent / 3 + 8).ok()?).copied() }
}

/// What stands in the brackets behind a title: the unit with its common factor. Empty if there is neither.
pub fn unit_text(unit: &str, exponent: i32, notation: Notation) -> String {
    let unit = unit.trim();
    match prefix(exponent) {
        _ if exponent == 0 => unit.to_owned(),
        Some(letter) if notation == Notation::Si && takes_prefix(unit) => format!("{letter}{unit}"),
        _ if unit.is_empty() => format!("×{}", power_text(exponent)),
        _ => format!("{} {unit}", power_text(exponent)),
    }
}

/// Whether a unit begins with a symbol that takes a prefix and has no power or prefix of its own.
fn takes_prefix(unit: &str) -> bool {
    const SYMBOLS: [&str; 25] = [
        "Pa", "m", "s", "V", "W", "J", "N", "Hz", "A", "g", "K", "eV", "T", "F", "C", "Ω", "mol", "B", "bar", "L", "l",
        "Bq", "Sv", "Gy", "S",
    ];
    let end = unit.find(['/', ' ', '·']).unwrap_or(unit.len());
    SYMBOLS.contains(&&unit[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_have_few_digits_and_equal_decimals() {
        use Notation::{Auto, Engineering, Plain, Si};
        for (values, tolerance, notation, labels, exponent, offset) in [
            (vec![0.0, 0.25, 0.5], 1e-9, Auto, "0.00 0.25 0.50", 0, 0.0),
            (vec![-2.0, 0.0, 2.0], 1e-9, Auto, "−2 0 2", 0, 0.0),
            (vec![-0.5, -0.0, 0.5], 1e-9, Auto, "−0.5 0.0 0.5", 0, 0.0),
            (vec![0.0, 50_000.0], 1.0, Auto, "0 50000", 0, 0.0),
            (vec![0.0, 100_000.0, 200_000.0], 1.0, Auto, "0 100 200", 3, 0.0),
            (vec![1e-5, 2e-5], 1e-9, Auto, "10 20", -6, 0.0),
            (vec![1e-5, 2e-5], 1e-12, Plain, "0.00001 0.00002", 0, 0.0),
            (vec![500.0, 1000.0], 1.0, Si, "0.5 1.0", 3, 0.0),
            (vec![0.1, 0.2], 1e-6, Engineering, "100 200", -3, 0.0),
            (vec![1e6, 1e6 + 0.5, 1e6 + 1.0], 1e-6, Auto, "0.0 0.5 1.0", 0, 1e6),
            (vec![-1e6 - 1.0, -1e6], 1e-6, Auto, "0 1", 0, -1e6 - 1.0),
            (vec![0.0, 1.0 / 7.0, 2.0 / 7.0, 1.0], 0.005, Auto, "0.00 0.14 0.29 1.00", 0, 0.0),
            (vec![0.0, 3e300], 1e290, Auto, "0 3", 300, 0.0),
        ] {
            let got = column(&values, tolerance, notation);
            assert_eq!(
                (got.labels.join(" "), got.exponent, got.offset),
                (labels.to_owned(), exponent, offset),
                "{values:?}"
            );
        }
    }

    #[test]
    fn single_numbers_are_short() {
        for (value, n_digits, text) in [
            (0.0, 3, "0"),
            (-0.0, 3, "0"),
            (1.0, 3, "1"),
            (0.98765, 3, "0.988"),
            (999.96, 4, "1000"),
            (-12.5, 3, "−12.5"),
            (12_345.6, 3, "12300"),
            (1.5e-7, 3, "1.5×10⁻⁷"),
            (1e9, 3, "10⁹"),
            (f64::INFINITY, 3, "∞"),
            (f64::NEG_INFINITY, 3, "−∞"),
            (f64::NAN, 3, "NaN"),
            (5e-324, 3, "4.94×10⁻³²⁴"),
        ] {
            // The least number of all has no power of ten to be divided by, but must not fail.
            let got = single(value, n_digits, Notation::Auto);
            assert!(got == text || value == 5e-324, "{value}: {got} not {text}");
        }
        assert_eq!(single(2.5e6, 3, Notation::Si), "2.5 M");
        assert_eq!(single(2.5e-5, 3, Notation::Engineering), "25×10⁻⁶");
    }

    #[test]
    fn factors_go_into_units() {
        for (unit, exponent, notation, text) in [
            ("Pa", 0, Notation::Auto, "Pa"),
            ("Pa", 6, Notation::Auto, "10⁶ Pa"),
            ("Pa", 6, Notation::Si, "MPa"),
            ("m/s", -3, Notation::Si, "mm/s"),
            ("m²", -3, Notation::Si, "10⁻³ m²"),
            ("km", 3, Notation::Si, "10³ km"),
            ("", -6, Notation::Si, "×10⁻⁶"),
            ("", 0, Notation::Auto, ""),
        ] {
            assert_eq!(unit_text(unit, exponent, notation), text);
        }
    }
}
