//! Texels and numbers to files in memory: PNG, OpenEXR, NPY, NPZ.

use crate::color::Encoding;
use crate::math::Size;
use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Layer, LayerAttributes, Text, WritableImage};
use std::io::{Cursor, Write};

/// An 8-bit PNG of 1 (grey), 2 (grey, alpha), 3 (colour) or 4 (colour, alpha) samples a texel, rows from the top.
///
/// How many they are is told by the length of `samples`. The encoding is written down (an sRGB chunk, or gAMA 1.0), so
/// that [`read`](crate::assets::image_files::read) gives it back; `metadata` become text chunks.
pub fn png8(size: Size, samples: &[u8], encoding: Encoding, metadata: &[(&str, String)]) -> Vec<u8> {
    png(size, samples, png::BitDepth::Eight, Some(encoding), metadata)
}

/// A picture in sRGB with straight alpha as a PNG: three channels when it is opaque, four otherwise.
pub fn png_picture(size: Size, pixels: &[[u8; 4]], metadata: &[(&str, String)]) -> Vec<u8> {
    match pixels.iter().all(|p| p[3] == 255) {
        true => {
            let rgb: Vec<u8> = pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
            png8(size, &rgb, Encoding::Srgb, metadata)
        }
        false => png8(size, pixels.as_flattened(), Encoding::Srgb, metadata),
    }
}

/// An image as [`png8`] writes it, with 16 bits a sample.
pub fn png16(size: Size, samples: &[u16], encoding: Encoding, metadata: &[(&str, String)]) -> Vec<u8> {
    let bytes: Vec<u8> = samples.iter().flat_map(|x| x.to_be_bytes()).collect();
    png(size, &bytes, png::BitDepth::Sixteen, Some(encoding), metadata)
}

/// A PNG from the bytes of its samples; without an encoding it says nothing about colour, as glTF wants it.
pub(super) fn png(
    size: Size,
    bytes: &[u8],
    depth: png::BitDepth,
    encoding: Option<Encoding>,
    metadata: &[(&str, String)],
) -> Vec<u8> {
    let n_bytes = if depth == png::BitDepth::Sixteen { 2 } else { 1 };
    let n_channels = bytes.len() / n_bytes / size.n_cells().max(1);
    assert!(
        size.n_cells() > 0 && (1..=4).contains(&n_channels) && bytes.len() == size.n_cells() * n_channels * n_bytes,
        "{} bytes are no image of {size}",
        bytes.len()
    );
    let mut out = Vec::with_capacity(bytes.len() / 2 + 1024);
    let mut encoder = png::Encoder::new(&mut out, size.width, size.height);
    encoder.set_color(
        [png::ColorType::Grayscale, png::ColorType::GrayscaleAlpha, png::ColorType::Rgb, png::ColorType::Rgba]
            [n_channels - 1],
    );
    encoder.set_depth(depth);
    // Of a 1280x720 picture: 40 % of the time of choosing a filter for each row, at a size within 7 %.
    encoder.set_deflate_compression(png::DeflateCompression::FdeflateUltraFast);
    encoder.set_filter(png::Filter::Paeth);
    match encoding {
        Some(Encoding::Srgb) => encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric),
        Some(Encoding::Linear) => encoder.set_source_gamma(png::ScaledFloat::new(1.0)),
        None => {}
    }
    const WRITES: &str = "writing to memory does not fail";
    let mut writer = encoder.write_header().expect(WRITES);
    write_texts(&mut writer, metadata).expect(WRITES);
    writer.write_image_data(bytes).expect(WRITES);
    writer.finish().expect(WRITES);
    out
}

/// Metadata as text chunks.
pub(super) fn write_texts<W: Write>(
    writer: &mut png::Writer<W>,
    metadata: &[(&str, String)],
) -> Result<(), png::EncodingError> {
    for (keyword, text) in metadata {
        // Keywords have 1 to 79 Latin-1 characters; texts may be any.
        let keyword: String = keyword.chars().filter(|c| c.is_ascii_graphic() || *c == ' ').take(79).collect();
        let keyword = if keyword.trim().is_empty() { "Comment".into() } else { keyword.trim().to_owned() };
        match text.is_ascii() {
            true => writer.write_text_chunk(&png::text_metadata::TEXtChunk::new(keyword, text.as_str()))?,
            false => writer.write_text_chunk(&png::text_metadata::ITXtChunk::new(keyword, text.as_str()))?,
        }
    }
    Ok(())
}

/// Numbers of one type, borrowed.
#[derive(Clone, Copy, Debug)]
pub enum Numbers<'a> {
    /// Ids, counts.
    U32(&'a [u32]),
    /// Measures.
    F32(&'a [f32]),
    /// Exact measures.
    F64(&'a [f64]),
}

impl Numbers<'_> {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::U32(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::F64(v) => v.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// An OpenEXR file of named channels, one number a cell each, rows from the top: information buffers and HDR pictures
/// (channels `R`, `G`, `B`, `A`; linear, Rec. 709).
///
/// Lossless (ZIP, 16 rows a block). EXR knows 32 bits at most: `F64` is rounded to f32. Names are shortened to 255 ASCII
/// characters and made different where they are equal. `metadata` become text attributes.
pub fn exr(size: Size, channels: &[(&str, Numbers)], metadata: &[(&str, String)]) -> Vec<u8> {
    let mut names: Vec<String> = Vec::new();
    let list = channels.iter().map(|(name, numbers)| {
        assert!(numbers.len() == size.n_cells(), "channel {name:?} has {} numbers for {size} cells", numbers.len());
        let name = unused(ascii(name), &names);
        names.push(name.clone());
        let samples = match numbers {
            Numbers::U32(v) => FlatSamples::U32(v.to_vec()),
            Numbers::F32(v) => FlatSamples::F32(v.to_vec()),
            Numbers::F64(v) => FlatSamples::F32(v.iter().map(|&x| x as f32).collect()),
        };
        AnyChannel::new(Text::from(name.as_str()), samples)
    });
    let channels = AnyChannels::sort(list.collect());
    let mut attributes = LayerAttributes { software_name: Some(Text::from("Impasto")), ..LayerAttributes::default() };
    for (key, text) in metadata {
        let text: String = text.chars().map(|c| if (c as u32) < 256 { c } else { '?' }).collect();
        let value = Text::new_or_none(&text).unwrap_or_default();
        attributes.other.insert(Text::from(ascii(key).as_str()), exr::meta::attribute::AttributeValue::Text(value));
    }
    let encoding = exr::image::Encoding {
        compression: exr::compression::Compression::ZIP16,
        blocks: exr::image::Blocks::ScanLines,
        line_order: exr::meta::attribute::LineOrder::Increasing,
    };
    let layer = Layer::new((size.width as usize, size.height as usize), attributes, encoding, channels);
    let mut out = Cursor::new(Vec::new());
    exr::image::Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut out)
        .expect("a valid layer written to memory does not fail");
    out.into_inner()
}

/// A name of printable ASCII, 1 to 250 characters.
fn ascii(name: &str) -> String {
    let name: String = name.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '_' }).take(250).collect();
    if name.is_empty() { "_".into() } else { name }
}

fn unused(name: String, taken: &[String]) -> String {
    let mut candidates = std::iter::once(name.clone()).chain((2..).map(|i| format!("{name}_{i}")));
    candidates.find(|n| !taken.contains(n)).expect("there are more numbers than names")
}

/// A NumPy file (.npy, version 1.0): numbers of any rank in C order, little-endian.
pub fn npy(shape: &[usize], numbers: Numbers) -> Vec<u8> {
    assert!(shape.iter().product::<usize>() == numbers.len(), "{} numbers are no {shape:?}", numbers.len());
    let (kind, n_bytes) = match numbers {
        Numbers::U32(_) => ("<u4", 4),
        Numbers::F32(_) => ("<f4", 4),
        Numbers::F64(_) => ("<f8", 8),
    };
    // A tuple of one needs its comma.
    let dims: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let dims = if shape.len() > 1 { dims.trim_end_matches(", ") } else { dims.trim_end() };
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({dims}), }}");
    // Magic, version and length take 10 bytes; the numbers start at a multiple of 64, after a line feed.
    let n_padding = 63 - (10 + header.len()) % 64;
    header.extend(std::iter::repeat_n(' ', n_padding));
    header.push('\n');

    let mut out = Vec::with_capacity(10 + header.len() + numbers.len() * n_bytes);
    out.extend_from_slice(b"\x93NUMPY\x01\x00");
    out.extend_from_slice(&(header.len() as u16).to_le_bytes());
    out.extend_from_slice(header.as_bytes());
    match numbers {
        Numbers::U32(v) => v.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes())),
        Numbers::F32(v) => v.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes())),
        Numbers::F64(v) => v.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes())),
    }
    out
}

/// Several named arrays in one compressed file (.npz).
pub fn npz(arrays: &[(&str, &[usize], Numbers)]) -> Vec<u8> {
    const WRITES: &str = "writing to memory does not fail";
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let mut names = Vec::new();
    for (name, shape, numbers) in arrays {
        let name = unused(name.to_string(), &names);
        let bytes = npy(shape, *numbers);
        // Level 1: floats hardly pack better with more. The date is always the format's first, so that bytes repeat.
        let options = zip::write::SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Deflated)
            .compression_level(Some(1))
            .last_modified_time(zip::DateTime::default())
            .large_file(bytes.len() > u32::MAX as usize / 2);
        zip.start_file(format!("{name}.npy"), options).expect(WRITES);
        zip.write_all(&bytes).expect(WRITES);
        names.push(name);
    }
    zip.finish().expect(WRITES).into_inner()
}
