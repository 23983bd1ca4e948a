//! The scene's images as PNG, made what glTF expects: colours in sRGB, data as numbers, no colour chunks.

use crate::assets::image_write;
use crate::assets::{Texels, TextureImage};
use crate::color::{Encoding, srgb_from_linear, unorm8};
use png::BitDepth;

/// Which images of the scene a texture shows, and what for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Use {
    /// Numbers as they are.
    Data(u32),
    /// Colour, and the image's own alpha.
    Color(u32),
    /// White, with the red channel of this image as alpha.
    Alpha(u32),
    /// The first one's colour, with the second one's red channel as alpha.
    ColorAndAlpha(u32, u32),
}

/// A name and a PNG file.
pub(super) fn png_of(shown: Use, images: &[TextureImage]) -> (String, Vec<u8>) {
    match shown {
        Use::Data(i) => encoded(&images[i as usize], false),
        Use::Color(i) => encoded(&images[i as usize], true),
        Use::Alpha(a) => {
            let alpha = &images[a as usize];
            with_alpha(None, alpha)
        }
        Use::ColorAndAlpha(c, a) => with_alpha(Some(&images[c as usize]), &images[a as usize]),
    }
}

fn encoded(image: &TextureImage, is_color: bool) -> (String, Vec<u8>) {
    let to_srgb = is_color && image.encoding == Encoding::Linear;
    let n = image.n_channels.clamp(1, 4) as usize;
    // glTF's colours have three channels or four; grey is given as grey, which PNG and glTF allow.
    let has_alpha = n == 2 || n == 4;
    let size = image.texels.size();
    let bytes = |texel: [u8; 4]| channels(texel, n);
    let png = match &image.texels {
        Texels::U8(i) => {
            let table: Vec<u8> = (0..256).map(|x| to_unorm(x as f64 / 255.0, to_srgb, 255.0) as u8).collect();
            let color = |x: u8| if to_srgb { table[x as usize] } else { x };
            let samples: Vec<u8> =
                i.texels.iter().flat_map(|t| bytes([color(t[0]), color(t[1]), color(t[2]), t[3]])).collect();
            image_write::png(size, &samples, BitDepth::Eight, None, &[])
        }
        Texels::U16(i) => {
            let color = |x: u16| if to_srgb { to_unorm(x as f64 / 65535.0, true, 65535.0) as u16 } else { x };
            let texels = i.texels.iter().map(|t| [color(t[0]), color(t[1]), color(t[2]), t[3]]);
            image_write::png(size, &big_endian(texels, n), BitDepth::Sixteen, None, &[])
        }
        Texels::F32(i) => {
            let color = |x: f32| to_unorm(x as f64, to_srgb, 65535.0) as u16;
            let alpha = |x: f32| if has_alpha { to_unorm(x as f64, false, 65535.0) as u16 } else { u16::MAX };
            let texels = i.texels.iter().map(|t| [color(t[0]), color(t[1]), color(t[2]), alpha(t[3])]);
            image_write::png(size, &big_endian(texels, n), BitDepth::Sixteen, None, &[])
        }
    };
    (image.name.clone(), png)
}

/// 8-bit colour of one image (white for none) and alpha of another, at the colour's size.
fn with_alpha(color: Option<&TextureImage>, alpha: &TextureImage) -> (String, Vec<u8>) {
    let shape = color.unwrap_or(alpha);
    let (size, from) = (shape.texels.size(), alpha.texels.size());
    let to_srgb = shape.encoding == Encoding::Linear;
    let mut samples = Vec::with_capacity(size.n_cells() * 4);
    for y in 0..size.height {
        for x in 0..size.width {
            let rgb = color.map_or([255; 3], |c| {
                let t = unit_texel(&c.texels, x, y);
                [t[0], t[1], t[2]].map(|v| to_unorm(v as f64, to_srgb, 255.0) as u8)
            });
            let [ax, ay] =
                [x as u64 * from.width as u64 / size.width as u64, y as u64 * from.height as u64 / size.height as u64];
            samples.extend(rgb);
            samples.push(unorm8(unit_texel(&alpha.texels, ax as u32, ay as u32)[0]));
        }
    }
    (shape.name.clone(), image_write::png(size, &samples, BitDepth::Eight, None, &[]))
}

fn unit_texel(texels: &Texels, x: u32, y: u32) -> [f32; 4] {
    match texels {
        Texels::U8(i) => i.at(x, y).map(|v| v as f32 / 255.0),
        Texels::U16(i) => i.at(x, y).map(|v| v as f32 / 65535.0),
        Texels::F32(i) => *i.at(x, y),
    }
}

/// A number in [0, 1] to the nearest of `most` steps; NaN gives 0.
fn to_unorm(x: f64, to_srgb: bool, most: f64) -> u32 {
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < 1.0 { x } else { 1.0 };
    let x = if to_srgb { srgb_from_linear(x) } else { x };
    (x * most + 0.5) as u32
}

fn channels<T: Copy>([r, g, b, a]: [T; 4], n: usize) -> impl Iterator<Item = T> {
    let picked = match n {
        1 => [r, r, r, r],
        2 => [r, a, a, a],
        _ => [r, g, b, a],
    };
    picked.into_iter().take(n)
}

fn big_endian(texels: impl Iterator<Item = [u16; 4]>, n: usize) -> Vec<u8> {
    texels.flat_map(|t| channels(t, n)).flat_map(|x| x.to_be_bytes()).collect()
}
