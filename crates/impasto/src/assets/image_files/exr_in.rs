//! OpenEXR to texels, through crate `exr`: the first flat layer at full resolution, any channel names.
//!
//! The picture is the display window; texels outside of the data window are black and empty, data outside of the display
//! window are cut off. Colours are taken as Rec. 709 primaries, light as linear.

use super::{Decoded, Fault, check_claim};
use crate::assets::{Image, Texels};
use crate::color::Encoding;
use crate::error::{Mended, note};
use crate::math::Size;
use exr::block::chunk::CompressedBlock;
use exr::compression::Compression;
use exr::meta::MetaData;
use exr::meta::attribute::IntegerBounds;
use exr::prelude::{AnyChannel, FlatSamples, ReadChannels, ReadLayers, read};
use std::io::Cursor;

pub(super) fn decode(bytes: &[u8], mended: &mut Vec<Mended>) -> Result<Decoded, Fault> {
    let plain = |e: exr::error::Error| format!("broken or unknown EXR: {e}");
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(plain)?;
    let header = meta.headers.iter().find(|h| !h.deep).ok_or("the EXR holds only deep data, which is not read")?;
    if header.channels.list.is_empty() {
        return Err("the EXR's first layer has no channels".into());
    }
    // Every channel is widened to 4 bytes while it is read; the picture needs 16 a texel.
    let n_channels = header.channels.list.len().max(4);
    check_claim(size_of(header.layer_size)?, 4 * n_channels, bytes.len())?;
    check_claim(size_of(header.shared_attributes.display_window.size)?, 16, bytes.len())?;
    if let Some(channel) = header.channels.list.iter().find(|c| c.sampling.x() != 1 || c.sampling.y() != 1) {
        return Err(format!("channel {:?} of the EXR is subsampled, which is not read", channel.name.to_string()));
    }
    if meta.headers.iter().any(|h| matches!(h.compression, Compression::DWAA(_) | Compression::DWAB(_))) {
        check_dwa(bytes, &meta)?;
    }
    note(mended, meta.headers.len() - 1, "further layers of the EXR left out");

    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(plain)?;
    let layer = image.layer_data;
    let channels = &layer.channel_data.list;
    let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
    let roles = Roles::of(&names);
    note(mended, roles.remark.is_some() as usize, roles.remark.clone().unwrap_or_default());

    let data = IntegerBounds { position: layer.attributes.layer_position, size: layer.size };
    let mut window = image.attributes.display_window;
    if overlap(data, window).is_none() {
        note(mended, 1, "display window without data replaced by the data window");
        window = data;
    }
    let texels = placed(channels, &roles, data, window)?;
    Ok(Decoded { texels: Texels::F32(texels), encoding: Encoding::Linear, n_channels: roles.n_channels() })
}

/// Refuses blocks whose own header claims more numbers than their layer has: the decoder asks for memory before it looks.
fn check_dwa(bytes: &[u8], meta: &MetaData) -> Result<(), Fault> {
    let plain = |e: exr::error::Error| format!("broken or unknown EXR: {e}");
    let chunks = exr::block::read(Cursor::new(bytes), false).and_then(|r| r.all_chunks(false)).map_err(plain)?;
    for chunk in chunks {
        let chunk = chunk.map_err(plain)?;
        let data = match &chunk.compressed_block {
            CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
            CompressedBlock::Tile(block) => &block.compressed_pixels_le,
            _ => continue,
        };
        let header = meta.headers.get(chunk.layer_index).ok_or("an EXR block of no layer")?;
        if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
            continue;
        }
        // Cosine blocks are of 8 x 8 texels; a number takes 2 or 4 bytes, and may be counted in bytes.
        let padded = |n: usize| (n as u64).saturating_add(8);
        let n_texels = padded(header.layer_size.x()).saturating_mul(padded(header.layer_size.y()));
        let most = n_texels.saturating_mul(8 * header.channels.list.len() as u64);
        // A version, nine sizes and counts, a method.
        let claims = data.as_chunks::<8>().0.iter().map(|b| u64::from_le_bytes(*b)).skip(1).take(9);
        if claims.into_iter().any(|claim| claim > most) {
            return Err("a DWA block of the EXR claims more numbers than its layer has".into());
        }
    }
    Ok(())
}

fn size_of(size: exr::math::Vec2<usize>) -> Result<Size, Fault> {
    let side = |n: usize| u32::try_from(n).map_err(|_| "the EXR's size is out of range".to_owned());
    Ok(Size::new(side(size.x())?, side(size.y())?))
}

/// Which of a layer's channels are red, green, blue (or all three: grey) and alpha.
struct Roles {
    color: [Option<usize>; 3],
    alpha: Option<usize>,
    remark: Option<String>,
}

impl Roles {
    fn of(names: &[String]) -> Self {
        let find = |prefix: &str, last: &str| {
            let is_it = |n: &String| n.strip_prefix(prefix).is_some_and(|rest| rest.eq_ignore_ascii_case(last));
            names.iter().position(is_it)
        };
        // Plain names first, then the first group "layer.R", "layer.G", "layer.B".
        let prefixes = names.iter().map(|n| n.rfind('.').map_or("", |dot| &n[..=dot]));
        for prefix in std::iter::once("").chain(prefixes) {
            let rgb = ["R", "G", "B"].map(|c| find(prefix, c));
            let alpha = find(prefix, "A");
            let remark = |what: &str| {
                (!prefix.is_empty()).then(|| format!("layer {:?} read as {what}", prefix.trim_end_matches('.')))
            };
            if rgb.iter().all(Option::is_some) {
                return Self { color: rgb, alpha, remark: remark("colour") };
            }
            if let Some(grey) = find(prefix, "Y") {
                return Self { color: [Some(grey); 3], alpha, remark: remark("grey") };
            }
        }
        let alpha = find("", "A").filter(|_| names.len() > 1);
        let rest: Vec<usize> = (0..names.len()).filter(|i| Some(*i) != alpha).collect();
        let color = if rest.len() == 1 { [Some(rest[0]); 3] } else { std::array::from_fn(|i| rest.get(i).copied()) };
        let listed: Vec<&str> = rest.iter().take(3).map(|&i| names[i].as_str()).collect();
        let meaning = if rest.len() == 1 { "grey" } else { "red, green, blue in this order" };
        Self { color, alpha, remark: Some(format!("group of channels {} read as {meaning}", listed.join(", "))) }
    }

    fn n_channels(&self) -> u8 {
        let grey = self.color[0] == self.color[1];
        (if grey { 1 } else { 3 }) + self.alpha.is_some() as u8
    }
}

/// The part of `data` that is inside of `window`: first column and row counted in `data`, then in `window`, and its size.
fn overlap(data: IntegerBounds, window: IntegerBounds) -> Option<[[usize; 2]; 3]> {
    let axis = |data_at: i32, n_data: usize, at: i32, n: usize| {
        let start = (data_at as i64).max(at as i64);
        let end = (data_at as i64 + n_data as i64).min(at as i64 + n as i64);
        (end > start).then(|| [start - data_at as i64, start - at as i64, end - start].map(|x| x as usize))
    };
    let x = axis(data.position.x(), data.size.x(), window.position.x(), window.size.x())?;
    let y = axis(data.position.y(), data.size.y(), window.position.y(), window.size.y())?;
    Some(std::array::from_fn(|i| [x[i], y[i]]))
}

fn placed(
    channels: &[AnyChannel<FlatSamples>],
    roles: &Roles,
    data: IntegerBounds,
    window: IntegerBounds,
) -> Result<Image<[f32; 4]>, Fault> {
    let size = size_of(window.size)?;
    let full = if roles.alpha.is_none() { 1.0 } else { 0.0 };
    let mut texels = Image::filled(size, [0.0, 0.0, 0.0, full]);
    let Some([from, to, [width, height]]) = overlap(data, window) else { return Ok(texels) };
    let [r, g, b] = roles.color;
    for (slot, channel) in [r, g, b, roles.alpha].into_iter().enumerate() {
        let Some(channel) = channel else { continue };
        let samples = &channels[channel].sample_data;
        for y in 0..height {
            let source = (from[1] + y) * data.size.x() + from[0];
            let target = &mut texels.texels[(to[1] + y) * size.width as usize + to[0]..][..width];
            match samples {
                FlatSamples::F32(s) => target.iter_mut().zip(&s[source..]).for_each(|(t, &x)| t[slot] = x),
                FlatSamples::F16(s) => target.iter_mut().zip(&s[source..]).for_each(|(t, &x)| t[slot] = x.to_f32()),
                FlatSamples::U32(s) => target.iter_mut().zip(&s[source..]).for_each(|(t, &x)| t[slot] = x as f32),
            }
        }
    }
    Ok(texels)
}
