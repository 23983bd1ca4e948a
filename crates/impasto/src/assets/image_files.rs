//! Image files to texels: PNG, JPEG, WebP, TIFF, Radiance HDR, OpenEXR, PNM, BMP, TGA, GIF (its first frame).
//!
//! What the numbers stand for: colours of 8 and 16 bits are sRGB, floats are linear, and so is 16-bit grey, which holds
//! measured data (height maps, scans) far oftener than photographs. What a file says about itself goes first (PNG's sRGB,
//! cICP, gAMA chunks: see [`png_in`]). 16 bits stay 16 bits, floats stay floats.
//!
//! The size in a header is never trusted with memory: see [`check_claim`].

mod exr_in;
mod png_in;
mod tiff_in;

use crate::Result;
use crate::assets::{Image, Texels, TextureImage};
use crate::color::Encoding;
use crate::error::{Error, Mended, Report, note};
use crate::math::Size;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, metadata::Orientation};
use std::io::Cursor;
use std::path::Path;

/// The formats that [`read`] knows, for messages.
pub const KNOWN: &str = "PNG, JPEG, WebP, TIFF, HDR, EXR, PNM, BMP, TGA, GIF";

/// No image may take more memory than this.
const MAX_BYTES: usize = 1 << 30;
/// Images of up to this many texels are tried whatever the size of their file.
const ALWAYS_TRIED: usize = 4096 * 4096;
/// No useful image packs more texels into a byte: deflate gives at most 1032 bytes for one, each of 8 one-bit texels.
const MAX_TEXELS_PER_BYTE: usize = 1032 * 8;

/// Decodes an image file of any kind that is known; the kind is told by its first bytes, else by the name.
///
/// Pictures that a camera has marked as turned (EXIF) are turned upright. Broken checksums are errors.
pub fn read(bytes: &[u8], path: &Path) -> Result<Report<TextureImage>> {
    let mut mended = Vec::new();
    let decoded = match Kind::of(bytes, path)? {
        Kind::Png => png_in::decode(bytes, &mut mended),
        Kind::Tiff => tiff_in::decode(bytes, &mut mended),
        Kind::Exr => exr_in::decode(bytes, &mut mended),
        Kind::Other(format) => decode(bytes, format, &mut mended),
    };
    let decoded = decoded.map_err(|fault| Error::Format { path: path.into(), fault: one_line(&fault) })?;
    if let Texels::F32(image) = &decoded.texels {
        let n_odd = image.texels.iter().filter(|t| t.iter().any(|x| !x.is_finite())).count();
        note(&mut mended, n_odd, "texels that are not finite, kept as missing values");
    }
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let Decoded { texels, encoding, n_channels } = decoded;
    Ok(Report { value: TextureImage { name, texels, encoding, n_channels }, mended })
}

/// What a decoder gives: a [`TextureImage`] before it has a name.
struct Decoded {
    texels: Texels,
    encoding: Encoding,
    n_channels: u8,
}

/// What is wrong with the file, for a message.
type Fault = String;

/// Which decoder a file needs.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Png,
    Tiff,
    Exr,
    Other(ImageFormat),
}

impl Kind {
    /// By the file's first bytes, then by its extension.
    fn of(bytes: &[u8], path: &Path) -> Result<Self> {
        let magic = |magic: &[u8]| bytes.starts_with(magic);
        let extension = path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase());
        let pnm = matches!(bytes, [b'P', b'1'..=b'7', c, ..] if c.is_ascii_whitespace() || *c == b'#');
        Ok(match () {
            _ if magic(b"\x89PNG") => Self::Png,
            _ if magic(b"\xff\xd8\xff") => Self::Other(ImageFormat::Jpeg),
            _ if magic(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") => Self::Other(ImageFormat::WebP),
            _ if magic(b"II*\0") || magic(b"MM\0*") || magic(b"II+\0") || magic(b"MM\0+") => Self::Tiff,
            _ if magic(b"#?") => Self::Other(ImageFormat::Hdr),
            _ if magic(b"\x76\x2f\x31\x01") => Self::Exr,
            _ if magic(b"GIF8") => Self::Other(ImageFormat::Gif),
            _ if pnm => Self::Other(ImageFormat::Pnm),
            _ if magic(b"BM") && extension != "tga" => Self::Other(ImageFormat::Bmp),
            // TGA has no magic bytes.
            _ if extension == "tga" => Self::Other(ImageFormat::Tga),
            _ => {
                let kind = foreign_name(bytes, &extension);
                return Err(Error::UnknownFormat { path: path.into(), kind, verb: "reads", known: KNOWN });
            }
        })
    }
}

/// What to call a file that is none of ours.
fn foreign_name(bytes: &[u8], extension: &str) -> String {
    let names: [(&[u8], &str); 6] = [
        (b"\xabKTX 20", "KTX2"),
        (b"\xabKTX 11", "KTX"),
        (b"DDS ", "DDS"),
        (b"\0\0\0\x0cjP  ", "JPEG 2000"),
        (b"8BPS", "PSD"),
        (b"Pf", "PFM"),
    ];
    let brand = bytes.get(4..12).and_then(|b| b.strip_prefix(b"ftyp"));
    match names.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        _ if bytes.is_empty() => "an empty file".into(),
        Some((_, name)) => (*name).into(),
        None if brand == Some(b"avif") => "AVIF".into(),
        None if brand.is_some() => "HEIF".into(),
        None if extension.is_empty() => "this content".into(),
        None => extension.into(),
    }
}

/// Refuses sizes that cannot be true, or that need more than 1 GiB, before any memory is asked for them.
fn check_claim(size: Size, bytes_per_texel: usize, n_file_bytes: usize) -> std::result::Result<(), Fault> {
    let n_texels = size.width as u64 * size.height as u64;
    if n_texels == 0 {
        return Err(format!("the image is {size}: it has no texels"));
    }
    if n_texels > (MAX_BYTES / bytes_per_texel) as u64 {
        return Err(format!("the image is {size}, which needs more than the 1 GiB that an image may take"));
    }
    let possible = (n_file_bytes as u64).saturating_mul(MAX_TEXELS_PER_BYTE as u64);
    if n_texels > ALWAYS_TRIED as u64 && n_texels > possible {
        return Err(format!("the image claims to be {size}, which cannot be in {n_file_bytes} bytes"));
    }
    Ok(())
}

/// Formats that crate `image` decodes and that need nothing special.
fn decode(bytes: &[u8], format: ImageFormat, mended: &mut Vec<Mended>) -> std::result::Result<Decoded, Fault> {
    let mut limits = image::Limits::no_limits();
    limits.max_alloc = Some(MAX_BYTES as u64);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|e| e.to_string())?;
    let size = Size::new(decoder.dimensions().0, decoder.dimensions().1);
    let color = decoder.color_type();
    let bytes_per_texel = color.bytes_per_pixel() as usize / color.channel_count() as usize * 4;
    check_claim(size, bytes_per_texel, bytes.len())?;
    if format == ImageFormat::Jpeg && !has_end_of_jpeg(bytes) {
        return Err("the file is cut short: it has no end-of-image mark".into());
    }
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut picture = DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())?;
    if orientation != Orientation::NoTransforms {
        picture.apply_orientation(orientation);
        note(mended, 1, "picture turned upright as its camera tag says");
    }
    Ok(widened(picture))
}

/// Whether an end-of-image mark stands anywhere after the last start of scan: the decoder fills what is missing with grey.
fn has_end_of_jpeg(bytes: &[u8]) -> bool {
    let after = bytes.windows(2).rposition(|w| w == [0xff, 0xda]).unwrap_or(0);
    bytes[after..].windows(2).any(|w| w == [0xff, 0xd9])
}

fn widened(picture: DynamicImage) -> Decoded {
    let size = Size::new(picture.width(), picture.height());
    let n_channels = picture.color().channel_count();
    let n = n_channels as usize;
    let eight = |samples: &[u8]| Texels::U8(Image { size, texels: widen(samples, n, u8::MAX) });
    let sixteen = |samples: &[u16]| Texels::U16(Image { size, texels: widen(samples, n, u16::MAX) });
    let float = |samples: &[f32]| Texels::F32(Image { size, texels: widen(samples, n, 1.0) });
    let texels = match &picture {
        DynamicImage::ImageLuma16(i) => sixteen(i.as_raw()),
        DynamicImage::ImageLumaA16(i) => sixteen(i.as_raw()),
        DynamicImage::ImageRgb16(i) => sixteen(i.as_raw()),
        DynamicImage::ImageRgba16(i) => sixteen(i.as_raw()),
        DynamicImage::ImageRgb32F(i) => float(i.as_raw()),
        DynamicImage::ImageRgba32F(i) => float(i.as_raw()),
        other => eight(other.as_bytes()),
    };
    let encoding = usual_encoding(&texels, n_channels);
    Decoded { texels, encoding, n_channels }
}

/// What numbers stand for when the file does not say.
fn usual_encoding(texels: &Texels, n_channels: u8) -> Encoding {
    match texels {
        Texels::U8(_) => Encoding::Srgb,
        Texels::U16(_) if n_channels >= 3 => Encoding::Srgb,
        Texels::U16(_) | Texels::F32(_) => Encoding::Linear,
    }
}

/// Samples of 1 to 4 channels to four: grey is repeated, absent alpha is `full`.
fn widen<T: Copy>(samples: &[T], n_channels: usize, full: T) -> Vec<[T; 4]> {
    match n_channels {
        1 => samples.iter().map(|&g| [g, g, g, full]).collect(),
        2 => samples.as_chunks().0.iter().map(|&[g, a]| [g, g, g, a]).collect(),
        3 => samples.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, full]).collect(),
        _ => samples.as_chunks().0.to_vec(),
    }
}

/// Messages of decoders as part of our one line.
fn one_line(fault: &str) -> String {
    let line = fault.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(300) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line,
    }
}

#[cfg(test)]
mod tests;
