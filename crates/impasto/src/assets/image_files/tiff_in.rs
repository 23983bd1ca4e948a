//! TIFF to texels, through crate `tiff`: 8 and 16 bits, floats, palettes, grey to colour with alpha, CMYK, planes or not.
//!
//! Signed and 32-bit integers and 64-bit floats (elevations, masks, measurements) become f32 numbers, not fractions of a range.

use super::{Decoded, Fault, MAX_BYTES, check_claim, usual_encoding, widen};
use crate::assets::{Image, Texels};
use crate::error::{Mended, note};
use crate::math::Size;
use std::io::Cursor;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

pub(super) fn decode(bytes: &[u8], mended: &mut Vec<Mended>) -> Result<Decoded, Fault> {
    let plain = |e: tiff::TiffError| format!("broken or unknown TIFF: {e}");
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_BYTES;
    limits.intermediate_buffer_size = MAX_BYTES;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(plain)?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(plain)?;
    let size = Size::new(width, height);
    let color = decoder.colortype().map_err(plain)?;
    let depth = color.bit_depth();
    let bytes_per_texel = if depth > 16 { 16 } else { depth.div_ceil(8) as usize * 4 };
    check_claim(size, bytes_per_texel, bytes.len())?;
    // Layers without compression lie in the file in full: nothing bigger than the file can be in it.
    let uncompressed = decoder.find_tag_unsigned::<u16>(Tag::Compression).map_err(plain)?.unwrap_or(1) == 1;
    if uncompressed && size.n_cells() as u64 * color.num_samples() as u64 * depth as u64 / 8 > bytes.len() as u64 {
        return Err(format!("the TIFF claims {size} uncompressed texels, which cannot be in {} bytes", bytes.len()));
    }
    let mut samples = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut samples).map_err(plain)?;

    let mut n_samples = color.num_samples() as usize;
    let n_planes = layout.planes.max(1);
    if n_planes > 1 {
        samples = interleaved(samples, size.n_cells(), n_planes).ok_or("not all planes of the TIFF could be read")?;
    }
    match color {
        ColorType::Palette(8) => {
            let map = decoder.get_tag_u16_vec(Tag::ColorMap).map_err(plain)?;
            samples = looked_up(samples, &map).ok_or("the TIFF's palette is incomplete")?;
            n_samples = 3;
        }
        ColorType::CMYK(8 | 16) => {
            samples = without_ink(samples).ok_or("CMYK of this depth is not read")?;
            n_samples = 3;
            note(mended, 1, "picture in CMYK converted to RGB without its colour profile");
        }
        ColorType::Gray(_) | ColorType::GrayA(_) | ColorType::RGB(_) | ColorType::RGBA(_) => {}
        ColorType::Multiband { num_samples, .. } => {
            note(
                mended,
                1,
                format!("TIFF with {num_samples} bands of unknown meaning; the first {} are used", num_samples.min(4)),
            );
        }
        other => return Err(format!("TIFF colours of kind {other:?} are not read")),
    }
    let n_channels = n_samples.min(4) as u8;
    let texels = texels(samples, size, n_samples, depth).ok_or("the TIFF has fewer texels than it says")?;
    let encoding = usual_encoding(&texels, n_channels);
    Ok(Decoded { texels, encoding, n_channels })
}

/// Numbers of any type to texels: 8 and 16 bits as they are, all else as f32.
fn texels(samples: DecodingResult, size: Size, n: usize, depth: u8) -> Option<Texels> {
    use DecodingResult as D;
    fn image<T: Copy>(samples: &[T], size: Size, n: usize, full: T) -> Option<Image<[T; 4]>> {
        let samples = samples.get(..size.n_cells() * n)?;
        let texels = match n {
            0 => return None,
            1..=4 => widen(samples, n, full),
            _ => samples.chunks_exact(n).map(|c| [c[0], c[1], c[2], c[3]]).collect(),
        };
        Some(Image { size, texels })
    }
    fn floats<T: Copy>(samples: &[T], size: Size, n: usize, f: impl Fn(T) -> f32) -> Option<Texels> {
        image(&samples.iter().map(|&x| f(x)).collect::<Vec<f32>>(), size, n, 1.0).map(Texels::F32)
    }
    match samples {
        D::U8(s) if depth < 8 => {
            let s = unpacked(&s, size, n, depth)?;
            image(&s, size, n, u8::MAX).map(Texels::U8)
        }
        D::U8(s) => image(&s, size, n, u8::MAX).map(Texels::U8),
        D::U16(s) => image(&s, size, n, u16::MAX).map(Texels::U16),
        D::F32(s) => image(&s, size, n, 1.0).map(Texels::F32),
        D::F16(s) => floats(&s, size, n, |x| x.to_f32()),
        D::F64(s) => floats(&s, size, n, |x| x as f32),
        D::I8(s) => floats(&s, size, n, |x| x as f32),
        D::I16(s) => floats(&s, size, n, |x| x as f32),
        D::I32(s) => floats(&s, size, n, |x| x as f32),
        D::I64(s) => floats(&s, size, n, |x| x as f32),
        D::U32(s) => floats(&s, size, n, |x| x as f32),
        D::U64(s) => floats(&s, size, n, |x| x as f32),
    }
}

/// Samples of 1, 2 or 4 bits, rows padded to whole bytes, to the full range of a byte.
fn unpacked(packed: &[u8], size: Size, n: usize, depth: u8) -> Option<Vec<u8>> {
    let per_row = size.width as usize * n;
    let row_bytes = (per_row * depth as usize).div_ceil(8);
    let most = (1u32 << depth) - 1;
    let packed = packed.get(..row_bytes * size.height as usize)?;
    Some(
        packed
            .chunks_exact(row_bytes)
            .flat_map(|row| {
                (0..per_row).map(move |i| {
                    let bit = i * depth as usize;
                    let value = (row[bit / 8] as u32 >> (8 - depth as usize - bit % 8)) & most;
                    (value * 255 / most) as u8
                })
            })
            .collect(),
    )
}

/// Plane after plane to texel after texel.
fn interleaved(samples: DecodingResult, n_texels: usize, n_planes: usize) -> Option<DecodingResult> {
    use DecodingResult as D;
    fn go<T: Copy>(s: &[T], n_texels: usize, n_planes: usize) -> Option<Vec<T>> {
        let s = s.get(..n_texels * n_planes)?;
        Some((0..n_texels).flat_map(|i| (0..n_planes).map(move |p| s[p * n_texels + i])).collect())
    }
    Some(match samples {
        D::U8(s) => D::U8(go(&s, n_texels, n_planes)?),
        D::U16(s) => D::U16(go(&s, n_texels, n_planes)?),
        D::U32(s) => D::U32(go(&s, n_texels, n_planes)?),
        D::F32(s) => D::F32(go(&s, n_texels, n_planes)?),
        D::F64(s) => D::F64(go(&s, n_texels, n_planes)?),
        D::I16(s) => D::I16(go(&s, n_texels, n_planes)?),
        _ => return None,
    })
}

/// Palette indices to colours; the map holds all reds, then all greens, then all blues, in 16 bits.
fn looked_up(samples: DecodingResult, map: &[u16]) -> Option<DecodingResult> {
    let DecodingResult::U8(indices) = samples else { return None };
    let n = map.len() / 3;
    let color = |i: usize| Some([*map.get(i)?, *map.get(n + i)?, *map.get(2 * n + i)?].map(|c| (c >> 8) as u8));
    let colors: Option<Vec<[u8; 3]>> =
        indices.iter().map(|&i| color(i as usize).filter(|_| (i as usize) < n)).collect();
    Some(DecodingResult::U8(colors?.into_flattened()))
}

/// Four inks to three lights: `(1 - ink) * (1 - black)`.
fn without_ink(samples: DecodingResult) -> Option<DecodingResult> {
    fn go(samples: impl Iterator<Item = [u32; 4]>, full: u32) -> impl Iterator<Item = [u32; 3]> {
        samples.map(move |[c, m, y, k]| [c, m, y].map(|ink| ((full - ink) * (full - k) + full / 2) / full))
    }
    Some(match samples {
        DecodingResult::U8(s) => {
            let inks = s.as_chunks().0.iter().map(|t: &[u8; 4]| t.map(u32::from));
            DecodingResult::U8(go(inks, 255).flatten().map(|x| x as u8).collect())
        }
        DecodingResult::U16(s) => {
            let inks = s.as_chunks().0.iter().map(|t: &[u16; 4]| t.map(u32::from));
            DecodingResult::U16(go(inks, 65535).flatten().map(|x| x as u16).collect())
        }
        _ => return None,
    })
}
