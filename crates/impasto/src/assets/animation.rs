//! Pictures in a row to one file that plays for ever (GIF, animated PNG), or to a folder of numbered PNGs.
//!
//! Frames are written as they come, and none but the last is kept. The file is whole or not there. A GIF has at most 256
//! colours a frame: they are chosen for each frame by Dekker's network ("Kohonen neural networks for optimal colour
//! quantization", 1994), and the most frequent colour, mostly the background's, is kept exactly. What did not change since
//! the frame before is not written again.

use crate::assets::files::write_atomically;
use crate::assets::image_write::{self, write_texts};
use crate::error::{Error, Result};
use crate::math::Size;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What kind of animation a name asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 256 colours a frame; plays everywhere.
    Gif,
    /// Animated PNG: all colours, and soft alpha.
    Apng,
    /// A folder of numbered PNGs, for other programs.
    Frames,
}

/// How an animation runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// How many frames.
    pub n_frames: u32,
    /// Frames a second.
    pub fps: f32,
}

/// What all frames of an animation share.
#[derive(Clone, Copy)]
pub struct Clip<'a> {
    /// Pixels across and down.
    pub size: Size,
    /// How it runs.
    pub timing: Timing,
    /// Goes into PNGs and, as comments, into GIFs.
    pub metadata: &'a [(&'a str, String)],
}

/// One frame: sRGB bytes and straight alpha, rows from the top.
pub type Pixels = Vec<[u8; 4]>;

/// The most frames an animation may have.
pub const MOST_FRAMES: u32 = 10_000;

impl Format {
    /// By the name's end: `.gif`, `.png` or `.apng`; a name without an end, or with a slash behind it, is a folder.
    ///
    /// # Errors
    /// `UnknownFormat`.
    pub fn of(path: &Path) -> Result<Self> {
        let text = path.to_string_lossy();
        let extension = path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_str() {
            _ if text.ends_with(['/', '\\']) || path.is_dir() => Ok(Self::Frames),
            "gif" => Ok(Self::Gif),
            "png" | "apng" => Ok(Self::Apng),
            "" => Ok(Self::Frames),
            kind => {
                let known = "gif, png (animated), or a folder of frames (a name that ends in /)";
                Err(Error::UnknownFormat { path: path.into(), kind: format!(".{kind}"), verb: "writes", known })
            }
        }
    }

    /// The fastest that this format can play.
    pub fn most_fps(self) -> f32 {
        match self {
            // Viewers slow down what waits less than two hundredths of a second.
            Self::Gif => 50.0,
            Self::Apng | Self::Frames => 240.0,
        }
    }
}

/// Writes an animation; `frame` makes the frames, asked for one after the other.
///
/// # Errors
/// `Write`, and what `frame` gives; then nothing is left behind.
pub fn write(path: &Path, clip: Clip, mut frame: impl FnMut(u32) -> Result<Pixels>) -> Result<()> {
    let Clip { size, timing, .. } = clip;
    let format = Format::of(path)?;
    let fault = |what: &str, given: String, why: String| Error::Parameter { what: what.into(), given, why };
    if !(1..=MOST_FRAMES).contains(&timing.n_frames) {
        return Err(fault("frames", timing.n_frames.to_string(), format!("1 to {MOST_FRAMES}")));
    }
    if !(timing.fps >= 0.1 && timing.fps <= format.most_fps()) {
        return Err(fault("fps", timing.fps.to_string(), format!("0.1 to {} frames a second", format.most_fps())));
    }
    if format == Format::Gif && size.width.max(size.height) > u16::MAX.into() {
        return Err(fault("size", size.to_string(), "a GIF has at most 65535 pixels a side".into()));
    }
    if format == Format::Frames {
        return folder(path, clip, frame);
    }
    // The writer knows errors of the file system alone; the others wait outside.
    let mut other = None;
    let mut next = |i| {
        let pixels: Pixels = frame(i).map_err(|error| {
            other = Some(error);
            io::Error::other("no frame")
        })?;
        assert_eq!(pixels.len(), size.n_cells(), "a frame has one pixel a cell");
        Ok(pixels)
    };
    let written = write_atomically(path, |file| match format {
        Format::Gif => gif(file, clip, &mut next),
        _ => apng(file, clip, &mut next),
    });
    other.map_or(written, Err)
}

type Next<'a> = dyn FnMut(u32) -> io::Result<Pixels> + 'a;

fn apng(file: &mut dyn Write, Clip { size, timing, metadata }: Clip, next: &mut Next) -> io::Result<()> {
    let first = next(0)?;
    // All frames have the channels of the first.
    let is_opaque = first.iter().all(|p| p[3] == 255);
    let mut encoder = png::Encoder::new(file, size.width, size.height);
    encoder.set_color(if is_opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    if timing.n_frames > 1 {
        encoder.set_animated(timing.n_frames, 0)?;
        // Hundredths of frames a second are exact enough.
        encoder.set_frame_delay(100, (timing.fps * 100.0 + 0.5) as u16)?;
    }
    let mut writer = encoder.write_header()?;
    write_texts(&mut writer, metadata)?;
    let mut pixels = first;
    for i in 0..timing.n_frames {
        if i > 0 {
            pixels = next(i)?;
        }
        match is_opaque {
            true => {
                writer.write_image_data(&pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect::<Vec<u8>>())?
            }
            false => writer.write_image_data(pixels.as_flattened())?,
        }
    }
    Ok(writer.finish()?)
}

fn gif(file: &mut dyn Write, Clip { size, timing, metadata }: Clip, next: &mut Next) -> io::Result<()> {
    let [width, height] = [size.width as u16, size.height as u16];
    let broken = |e: gif::EncodingError| match e {
        gif::EncodingError::Io(e) => e,
        other => io::Error::other(other.to_string()),
    };
    let mut encoder = gif::Encoder::new(file, width, height, &[]).map_err(broken)?;
    encoder.set_repeat(gif::Repeat::Infinite).map_err(broken)?;
    for (keyword, text) in metadata {
        let comment = format!("{keyword}: {text}");
        let parts: Vec<&[u8]> = comment.as_bytes().chunks(255).collect();
        encoder.write_raw_extension(gif::AnyExtension(0xfe), &parts).map_err(broken)?;
    }
    // Hundredths of a second from the start, so that rounding never adds up.
    let time = |i: u32| (i as f64 * 100.0 / timing.fps as f64 + 0.5) as u32;
    let mut before: Option<Pixels> = None;
    for i in 0..timing.n_frames {
        let mut pixels = next(i)?;
        // A GIF knows seen and not seen.
        for p in &mut pixels {
            *p = if p[3] < 128 { [0; 4] } else { [p[0], p[1], p[2], 255] };
        }
        let is_opaque = pixels.iter().all(|p| p[3] == 255);
        let [x, y, w, h] = match &before {
            Some(before) if is_opaque => changed(size, before, &pixels),
            _ => [0, 0, size.width, size.height],
        };
        let rows = (y..y + h).flat_map(|row| &pixels[(row * size.width + x) as usize..][..w as usize]);
        let (palette, transparent, buffer) = quantized(&rows.copied().collect::<Pixels>());
        encoder
            .write_frame(&gif::Frame {
                delay: (time(i + 1) - time(i)).min(u16::MAX.into()) as u16,
                dispose: if is_opaque { gif::DisposalMethod::Keep } else { gif::DisposalMethod::Background },
                transparent,
                left: x as u16,
                top: y as u16,
                width: w as u16,
                height: h as u16,
                palette: Some(palette),
                buffer: Cow::Owned(buffer),
                ..gif::Frame::default()
            })
            .map_err(broken)?;
        before = is_opaque.then_some(pixels);
    }
    Ok(())
}

/// The least rectangle that holds all that changed: column, row, width, height; at least one pixel.
fn changed(size: Size, before: &Pixels, now: &Pixels) -> [u32; 4] {
    let (mut least, mut most) = ([u32::MAX; 2], [0; 2]);
    for (i, (a, b)) in before.iter().zip(now).enumerate() {
        if a != b {
            let place = [i as u32 % size.width, i as u32 / size.width];
            (0..2).for_each(|k| (least[k], most[k]) = (least[k].min(place[k]), most[k].max(place[k])));
        }
    }
    if least[0] == u32::MAX {
        return [0, 0, 1, 1];
    }
    [least[0], least[1], most[0] + 1 - least[0], most[1] + 1 - least[1]]
}

/// At most 256 colours, which of them is no colour at all, and each pixel's.
fn quantized(pixels: &Pixels) -> (Vec<u8>, Option<u8>, Vec<u8>) {
    let mut counts: HashMap<[u8; 4], u32> = HashMap::new();
    pixels.iter().for_each(|p| *counts.entry(*p).or_default() += 1);
    let has_holes = counts.contains_key(&[0; 4]);
    let most = if has_holes { 255 } else { 256 };
    let mut colors: Vec<[u8; 4]> = counts.keys().filter(|c| c[3] != 0).copied().collect();
    // A map has no order of its own.
    colors.sort_unstable();
    let mut entry_of: HashMap<[u8; 4], u8> = HashMap::new();
    if colors.len() <= most {
        entry_of.extend(colors.iter().enumerate().map(|(i, c)| (*c, i as u8)));
    } else {
        let kept = colors.iter().copied().max_by_key(|c| (counts[c], *c)).unwrap_or([0, 0, 0, 255]);
        let seen: Vec<u8> = pixels.iter().filter(|p| p[3] != 0 && **p != kept).flatten().copied().collect();
        // Every third pixel teaches the network; more changes little.
        let network = color_quant::NeuQuant::new(3, most - 1, &seen);
        let map = network.color_map_rgba();
        for color in &colors {
            let entry = if *color == kept { most - 1 } else { network.index_of(color) };
            entry_of.insert(*color, entry as u8);
        }
        colors = map.as_chunks().0.iter().take(most - 1).map(|c: &[u8; 4]| [c[0], c[1], c[2], 255]).collect();
        colors.resize(most - 1, kept);
        colors.push(kept);
    }
    let hole = has_holes.then_some(colors.len() as u8);
    if let Some(hole) = hole {
        entry_of.insert([0; 4], hole);
        colors.push([0; 4]);
    }
    let palette = colors.iter().flat_map(|c| [c[0], c[1], c[2]]).collect();
    (palette, hole, pixels.iter().map(|p| entry_of[p]).collect())
}

/// `frame-0001.png` and so on: made beside their place, and moved there when all are whole.
fn folder(
    path: &Path,
    Clip { size, timing, metadata }: Clip,
    mut frame: impl FnMut(u32) -> Result<Pixels>,
) -> Result<()> {
    let error = |source| Error::Write { path: path.into(), source };
    let is_new = !path.exists();
    let names: Vec<PathBuf> = (1..=timing.n_frames).map(|i| PathBuf::from(format!("frame-{i:04}.png"))).collect();
    let foreign = |entry: &std::fs::DirEntry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_frame = name.strip_prefix("frame-").is_some_and(|n| n.ends_with(".png"));
        is_frame && !names.iter().any(|n| n.as_os_str() == name.as_str())
    };
    if !is_new && let Some(other) = std::fs::read_dir(path).map_err(error)?.flatten().find(foreign) {
        let why = format!("it holds {:?} of a longer animation; empty it, or name another folder", other.file_name());
        return Err(Error::Parameter { what: "folder".into(), given: path.display().to_string(), why });
    }
    if is_new {
        std::fs::create_dir(path).map_err(error)?;
    }
    let mut make = || -> Result<()> {
        let room = tempfile::Builder::new().prefix(".impasto-").suffix(".part").tempdir_in(path).map_err(error)?;
        for (i, name) in names.iter().enumerate() {
            let pixels = frame(i as u32)?;
            assert_eq!(pixels.len(), size.n_cells(), "a frame has one pixel a cell");
            let bytes = image_write::png_picture(size, &pixels, metadata);
            std::fs::write(room.path().join(name), bytes).map_err(error)?;
        }
        names.iter().try_for_each(|name| std::fs::rename(room.path().join(name), path.join(name))).map_err(error)
    };
    let made = make();
    if made.is_err() && is_new {
        // Only an empty folder goes.
        let _ = std::fs::remove_dir(path);
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::AnimationDecoder;

    const SIZE: Size = Size::new(16, 12);

    /// A bright square that wanders over a grey ground, with more colours than a GIF has.
    fn frame(i: u32) -> Pixels {
        let pixel = |k: u32| {
            let (x, y) = (k % SIZE.width, k / SIZE.width);
            let inside = x.wrapping_sub(i) < 8 && (2..8).contains(&y);
            if inside { [(x * 16) as u8, (y * 20) as u8, (i * 30) as u8, 255] } else { [120, 121, 122, 255] }
        };
        (0..SIZE.n_cells() as u32).map(pixel).collect()
    }

    fn written(name: &str, timing: Timing, f: impl FnMut(u32) -> Result<Pixels>) -> (tempfile::TempDir, Result<()>) {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let result =
            write(&folder.path().join(name), Clip { timing, metadata: &[("Software", "Impasto".into())], ..CLIP }, f);
        (folder, result)
    }

    const TIMING: Timing = Timing { n_frames: 4, fps: 12.0 };
    const CLIP: Clip = Clip { size: SIZE, timing: TIMING, metadata: &[] };

    #[test]
    fn gifs_show_every_frame_again() {
        let (folder, result) = written("a.gif", TIMING, |i| Ok(frame(i)));
        result.expect("a GIF");
        let bytes = std::fs::read(folder.path().join("a.gif")).expect("the file");
        let decoder = image::codecs::gif::GifDecoder::new(io::Cursor::new(&bytes)).expect("a GIF");
        let frames = decoder.into_frames().collect_frames().expect("frames");
        assert_eq!(frames.len(), 4);
        for (i, got) in frames.iter().enumerate() {
            let wanted = frame(i as u32);
            assert!(got.buffer().pixels().zip(&wanted).all(|(a, b)| a.0 == *b), "frame {i} has few colours: all exact");
        }
        // 12 frames a second are 8, 9, 8, 8 hundredths.
        let delays: Vec<u32> = frames.iter().map(|f| f.delay().numer_denom_ms().0).collect();
        assert_eq!(delays, [80, 90, 80, 80]);
        let (again, _) = written("a.gif", TIMING, |i| Ok(frame(i)));
        assert_eq!(std::fs::read(again.path().join("a.gif")).expect("the file"), bytes);
    }

    #[test]
    fn many_colours_become_near_ones_and_the_background_stays() {
        let pixels: Pixels = (0..4096u32)
            .map(|i| if i < 1500 { [244, 243, 240, 255] } else { [(i >> 4) as u8, (i >> 5) as u8, (i * 7) as u8, 255] })
            .collect();
        let (palette, hole, entries) = quantized(&pixels);
        assert_eq!((palette.len(), hole), (768, None));
        let shown = |i: usize| &palette[entries[i] as usize * 3..][..3];
        assert_eq!(shown(0), [244, 243, 240]);
        let far = (0..4096).filter(|&i| (0..3).any(|c| shown(i)[c].abs_diff(pixels[i][c]) > 48)).count();
        assert!(far < 100, "{far} pixels are far off");
    }

    #[test]
    fn animated_pngs_hold_all_frames_and_alpha() {
        let clear = |i: u32| {
            let mut pixels = frame(i);
            pixels[0] = [9, 8, 7, 100];
            Ok(pixels)
        };
        let (folder, result) = written("a.png", TIMING, clear);
        result.expect("an APNG");
        let file = std::fs::File::open(folder.path().join("a.png")).expect("the file");
        let decoder = png::Decoder::new(io::BufReader::new(file));
        let mut reader = decoder.read_info().expect("a PNG");
        assert_eq!(reader.info().animation_control.map(|a| (a.num_frames, a.num_plays)), Some((4, 0)));
        let mut buffer = vec![0; SIZE.n_cells() * 4];
        for i in 0..4 {
            reader.next_frame(&mut buffer).expect("a frame");
            assert_eq!(buffer, clear(i).expect("a frame").as_flattened(), "frame {i}");
            let delay = reader.info().frame_control.map(|f| (f.delay_num, f.delay_den));
            assert_eq!(delay, Some((100, 1200)));
        }
    }

    #[test]
    fn a_frame_that_fails_leaves_nothing() {
        for name in ["a.gif", "a.png", "frames"] {
            let (folder, result) = written(name, TIMING, |i| match i {
                2 => Err(Error::Parameter { what: "frame".into(), given: "2".into(), why: "it fails".into() }),
                i => Ok(frame(i)),
            });
            assert!(result.expect_err(name).to_string().contains("it fails"), "{name}");
            assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0, "{name}");
        }
    }

    #[test]
    fn folders_hold_numbered_pictures() {
        let (folder, result) = written("frames", TIMING, |i| Ok(frame(i)));
        result.expect("frames");
        let path = folder.path().join("frames");
        let names = |path: &Path| {
            let mut names: Vec<_> =
                std::fs::read_dir(path).expect("the folder").flatten().map(|e| e.file_name()).collect();
            names.sort();
            names
        };
        assert_eq!(names(&path), ["frame-0001.png", "frame-0002.png", "frame-0003.png", "frame-0004.png"]);
        write(&path, CLIP, |i| Ok(frame(i))).expect("as many again");
        let fewer = Timing { n_frames: 2, ..TIMING };
        let fault = write(&path, Clip { timing: fewer, ..CLIP }, |i| Ok(frame(i)))
            .expect_err("an older one is longer")
            .to_string();
        assert!(fault.contains("frame-000") && names(&path).len() == 4, "{fault}");
    }

    #[test]
    fn numbers_that_cannot_be_are_refused() {
        for (name, n_frames, fps) in [
            ("a.gif", 0, 10.0),
            ("a.gif", 4, 60.0),
            ("a.png", 4, f32::NAN),
            ("a.png", 20_000, 10.0),
            ("a.mp4", 4, 10.0),
        ] {
            let (folder, result) = written(name, Timing { n_frames, fps }, |i| Ok(frame(i)));
            assert!(result.is_err(), "{name} {n_frames} {fps}");
            assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0);
        }
    }
}
