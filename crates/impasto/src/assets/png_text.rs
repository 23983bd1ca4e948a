//! What a PNG file says about itself, with its pixels: to read a picture of ours again.

use crate::assets::text::format_error;
use crate::error::Result;
use crate::math::Size;
use std::path::Path;

/// A PNG picture with its texts.
#[derive(Clone, Debug, PartialEq)]
pub struct TextedPng {
    /// Pixels across and down.
    pub size: Size,
    /// Rows from the top, straight alpha, as encoded.
    pub pixels: Vec<[u8; 4]>,
    /// Keywords and texts, in the file's order.
    pub texts: Vec<(String, String)>,
}

impl TextedPng {
    /// The text of a keyword.
    pub fn text(&self, keyword: &str) -> Option<&str> {
        self.texts.iter().find(|(k, _)| k == keyword).map(|(_, text)| text.as_str())
    }
}

/// Pictures beyond this many bytes of pixels are not ours.
const MOST_BYTES: usize = 1 << 30;

/// Reads a PNG of any kind as 8 bits a channel.
///
/// # Errors
/// `Format` when it is none, or broken.
pub fn read(bytes: &[u8], path: &Path) -> Result<TextedPng> {
    let fault = |e: png::DecodingError| format_error(path, format!("not a PNG picture: {e}"));
    let mut decoder = png::Decoder::new_with_limits(std::io::Cursor::new(bytes), png::Limits { bytes: MOST_BYTES });
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(fault)?;
    let size = Size::new(reader.info().width, reader.info().height);
    let n = reader.output_buffer_size().filter(|n| *n <= MOST_BYTES);
    let mut buffer = vec![0; n.ok_or_else(|| format_error(path, "the picture is too large"))?];
    let frame = reader.next_frame(&mut buffer).map_err(fault)?;
    reader.finish().map_err(fault)?;
    let buffer = &buffer[..frame.buffer_size()];
    let pixels: Vec<[u8; 4]> = match frame.color_type {
        png::ColorType::Grayscale => buffer.iter().map(|g| [*g, *g, *g, 255]).collect(),
        png::ColorType::GrayscaleAlpha => buffer.as_chunks::<2>().0.iter().map(|[g, a]| [*g, *g, *g, *a]).collect(),
        png::ColorType::Rgb => buffer.as_chunks::<3>().0.iter().map(|[r, g, b]| [*r, *g, *b, 255]).collect(),
        _ => buffer.as_chunks::<4>().0.to_vec(),
    };
    if pixels.len() != size.n_cells() {
        return Err(format_error(path, "fewer pixels than it claims"));
    }
    let info = reader.info();
    let latin = info.uncompressed_latin1_text.iter().map(|t| (t.keyword.clone(), t.text.clone()));
    let utf8 = info.utf8_text.iter().filter_map(|t| Some((t.keyword.clone(), t.get_text().ok()?)));
    Ok(TextedPng { size, pixels, texts: latin.chain(utf8).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::image_write::png8;
    use crate::color::Encoding;

    #[test]
    fn texts_and_pixels_come_back() {
        let texts = [("Recipe", "a = 1\nb = \"two\"".to_owned()), ("Unit", "µm".to_owned())];
        let bytes = png8(Size::new(2, 1), &[1, 2, 3, 4, 5, 6], Encoding::Srgb, &texts);
        let png = read(&bytes, Path::new("a.png")).expect("a picture of our own");
        assert_eq!((png.size, &png.pixels[..]), (Size::new(2, 1), &[[1, 2, 3, 255], [4, 5, 6, 255]][..]));
        assert_eq!((png.text("Recipe"), png.text("Unit")), (Some("a = 1\nb = \"two\""), Some("µm")));
        for n in 0..bytes.len() - 12 {
            assert!(read(&bytes[..n], Path::new("a.png")).is_err(), "cut after {n} bytes");
        }
    }
}
