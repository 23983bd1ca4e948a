//! Values that several commands take.

use impasto::math::Size;

/// WIDTHxHEIGHT.
pub(crate) fn size(text: &str) -> Result<Size, String> {
    let (w, h) = text.split_once(['x', 'X']).ok_or("write it as WIDTHxHEIGHT, such as 1280x720")?;
    let n = |s: &str| s.trim().parse::<u32>().ok().filter(|n| (1..=32768).contains(n));
    let pair = n(w).zip(n(h)).ok_or("both numbers must be between 1 and 32768")?;
    Ok(Size::new(pair.0, pair.1))
}
