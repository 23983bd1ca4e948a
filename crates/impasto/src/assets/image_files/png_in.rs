//! PNG to texels (W3C PNG, third edition), through crate `png`.
//!
//! Colours are sRGB unless the file says otherwise: cICP goes before iCCP, that before sRGB, that before gAMA. Of other
//! colour spaces only linear ones are honoured (cICP transfer 8, gAMA 1.0); the rest is taken as sRGB and reported.

use super::{Decoded, Fault, MAX_BYTES, check_claim, usual_encoding, widen};
use crate::assets::{Image, Texels};
use crate::color::Encoding;
use crate::error::{Mended, note};
use crate::math::Size;
use png::{BitDepth, ColorType, DecodeOptions, Decoder, DecodingError, Info, Limits, Transformations};
use std::io::Cursor;

pub(super) fn decode(bytes: &[u8], mended: &mut Vec<Mended>) -> Result<Decoded, Fault> {
    let mut options = DecodeOptions::default();
    options.set_ignore_checksums(false);
    options.set_ignore_text_chunk(true);
    let mut decoder = Decoder::new_with_options(Cursor::new(bytes), options);
    decoder.set_limits(Limits { bytes: MAX_BYTES });
    decoder.set_transformations(Transformations::EXPAND);
    let info = decoder.read_header_info().map_err(plain)?;
    let size = Size::new(info.width, info.height);
    check_claim(size, if info.bit_depth == BitDepth::Sixteen { 8 } else { 4 }, bytes.len())?;

    let mut reader = decoder.read_info().map_err(plain)?;
    let n_bytes = reader.output_buffer_size().ok_or("the image is larger than memory")?;
    let mut samples = vec![0; n_bytes];
    reader.next_frame(&mut samples).map_err(plain)?;
    match reader.finish() {
        Ok(()) => {}
        Err(DecodingError::IoError(_)) => note(mended, 1, "missing end of file after the last texel ignored"),
        Err(fault) => return Err(plain(fault)),
    }

    let (color, depth) = reader.output_color_type();
    let n_channels = match color {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgb | ColorType::Indexed => 3,
        ColorType::Rgba => 4,
    };
    let texels = if depth == BitDepth::Sixteen {
        let samples: Vec<u16> = samples.as_chunks().0.iter().map(|&b| u16::from_be_bytes(b)).collect();
        Texels::U16(Image { size, texels: widen(&samples, n_channels as usize, u16::MAX) })
    } else {
        Texels::U8(Image { size, texels: widen(&samples, n_channels as usize, u8::MAX) })
    };
    let encoding = told_encoding(reader.info(), mended).unwrap_or_else(|| usual_encoding(&texels, n_channels));
    Ok(Decoded { texels, encoding, n_channels })
}

/// What the file says about its colours; none if it says nothing.
fn told_encoding(info: &Info, mended: &mut Vec<Mended>) -> Option<Encoding> {
    const SRGB_LIKE: [u8; 5] = [1, 6, 13, 14, 15];
    const LINEAR: u8 = 8;
    if let Some(points) = &info.coding_independent_code_points {
        if points.transfer_function == LINEAR {
            return Some(Encoding::Linear);
        }
        let foreign = !SRGB_LIKE.contains(&points.transfer_function);
        note(mended, foreign as usize, format!("transfer function (cICP {}) taken as sRGB", points.transfer_function));
        return Some(Encoding::Srgb);
    }
    if let Some(profile) = &info.icc_profile {
        // Its description is ASCII in version 2 of the format, UTF-16 in version 4.
        let names = |text: &[u8]| profile.windows(text.len()).any(|w| w == text);
        let foreign = !names(b"sRGB") && !names(b"s\0R\0G\0B");
        note(mended, foreign as usize, "colour profile (iCCP) taken as sRGB");
        return Some(Encoding::Srgb);
    }
    if info.srgb.is_some() {
        return Some(Encoding::Srgb);
    }
    let gamma = info.gama_chunk?.into_value();
    if (0.99..=1.01).contains(&gamma) {
        return Some(Encoding::Linear);
    }
    // sRGB is near 1/2.2; writers give 0.45455, 0.45 or, by mistake, 0.55.
    let foreign = !(0.40..=0.56).contains(&gamma);
    note(mended, foreign as usize, format!("gamma of {gamma} (gAMA) taken as sRGB"));
    Some(Encoding::Srgb)
}

fn plain(error: DecodingError) -> Fault {
    match error {
        DecodingError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => "the PNG is cut short".into(),
        other => format!("broken PNG: {other}"),
    }
}
