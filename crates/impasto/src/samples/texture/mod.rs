//! Textures by formula, at any size: charts to measure with, and materials to look at.
//!
//! Colours are written as sRGB hexadecimal numbers and mixed as such, as a painter would. Edges are one and a half texels
//! wide at any size. What is called tiling continues itself exactly across all four borders.

pub mod charts;
pub mod environment;
mod font;
pub mod materials;

use crate::assets::{Image, Texels, TextureImage};
use crate::color::{Encoding, unorm8};
use crate::math::{Size, Vec2, vec2};

pub(in crate::samples) type Rgb = [f32; 3];

/// A texel asked for: its place in the texture, and its size there.
pub(super) struct Texel {
    /// Centre, [0, 1], v down.
    pub(super) uv: Vec2,
    /// The larger of width and height.
    pub(super) size: f32,
}

/// An sRGB image from a colour and alpha for each texel.
fn painted(name: &str, size: Size, n_channels: u8, mut f: impl FnMut(&Texel) -> [f32; 4]) -> TextureImage {
    let size = Size::new(size.width.max(1), size.height.max(1));
    let texel = (1.0 / size.width as f32).max(1.0 / size.height as f32);
    let image = Image::from_fn(size, |x, y| f(&Texel { uv: center(x, y, size), size: texel }).map(unorm8));
    TextureImage { name: name.into(), texels: Texels::U8(image), encoding: Encoding::Srgb, n_channels }
}

/// The same, opaque.
fn opaque(name: &str, size: Size, mut f: impl FnMut(&Texel) -> Rgb) -> TextureImage {
    painted(name, size, 3, |t| {
        let [r, g, b] = f(t);
        [r, g, b, 1.0]
    })
}

/// A grey linear image of 16 bits from a height in [0, 1] for each texel.
fn heights(name: &str, size: Size, mut f: impl FnMut(&Texel) -> f32) -> TextureImage {
    let size = Size::new(size.width.max(1), size.height.max(1));
    let texel = (1.0 / size.width as f32).max(1.0 / size.height as f32);
    let image = Image::from_fn(size, |x, y| {
        let h = f(&Texel { uv: center(x, y, size), size: texel });
        let h = (h.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16;
        [h, h, h, 65535]
    });
    TextureImage { name: name.into(), texels: Texels::U16(image), encoding: Encoding::Linear, n_channels: 1 }
}

/// The tangent-space normal map (+Y up, linear bytes) of a tiling height map; `relief` is the height 1.0 in texture widths.
pub fn normal_map(height: &TextureImage, relief: f32) -> TextureImage {
    let size = height.texels.size();
    let (w, h) = (size.width, size.height);
    let at = |x: u32, y: u32| match &height.texels {
        Texels::U8(i) => i.at(x % w, y % h)[0] as f32 / 255.0,
        Texels::U16(i) => i.at(x % w, y % h)[0] as f32 / 65535.0,
        Texels::F32(i) => i.at(x % w, y % h)[0],
    };
    let image = Image::from_fn(size, |x, y| {
        let right = (at(x + 1, y) - at(x + w - 1, y)) * 0.5 * relief * w as f32;
        let down = (at(x, y + 1) - at(x, y + h - 1)) * 0.5 * relief * h as f32;
        let length = (right * right + down * down + 1.0).sqrt();
        let [r, g, b] = [-right, down, 1.0].map(|n| unorm8(n / length * 0.5 + 0.5));
        [r, g, b, 255]
    });
    let name = format!("{} normals", height.name);
    TextureImage { name, texels: Texels::U8(image), encoding: Encoding::Linear, n_channels: 3 }
}

fn center(x: u32, y: u32, size: Size) -> Vec2 {
    vec2((x as f32 + 0.5) / size.width as f32, (y as f32 + 0.5) / size.height as f32)
}

/// 0 outside, 1 inside, one and a half texels between; `inside` is a signed distance.
fn edge(inside: f32, texel: f32) -> f32 {
    (0.5 + inside / (1.5 * texel)).clamp(0.0, 1.0)
}

/// 0 up to `a`, 1 from `b`, smooth between.
fn smooth(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

pub(in crate::samples) fn mix(a: Rgb, b: Rgb, t: f32) -> Rgb {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
}

fn shade(c: Rgb, by: f32) -> Rgb {
    c.map(|x| x * by)
}

pub(in crate::samples) fn rgb(hex: u32) -> Rgb {
    [hex >> 16 & 255, hex >> 8 & 255, hex & 255].map(|b| b as f32 / 255.0)
}

/// The fractional part, for negative numbers too.
fn fract(x: f32) -> f32 {
    x - crate::math::floor(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(image: &TextureImage) -> &Image<[u8; 4]> {
        let Texels::U8(i) = &image.texels else { panic!("{} has bytes", image.name) };
        i
    }

    /// The step across the border is no larger than the largest step inside, row by row and column by column on average.
    #[test]
    fn tiling_textures_continue_across_their_borders() {
        let size = Size::new(128, 128);
        for image in [
            materials::bricks(size, 1),
            materials::wood(size, 1),
            materials::marble(size, 1),
            materials::scales(size, 1),
            charts::stripes(size, 8),
            charts::checker(size, 8),
            charts::alpha_dots(size, 4),
        ] {
            let i = bytes(&image);
            let step = |x0: u32, y0: u32, x1: u32, y1: u32| -> i64 {
                let (a, b) = (i.at(x0 % 128, y0 % 128), i.at(x1 % 128, y1 % 128));
                (0..4).map(|k| (a[k] as i64 - b[k] as i64).abs()).sum()
            };
            let across: Vec<i64> = (0..128).map(|x| (0..128).map(|y| step(x, y, x + 1, y)).sum()).collect();
            let down: Vec<i64> = (0..128).map(|y| (0..128).map(|x| step(x, y, x, y + 1)).sum()).collect();
            for steps in [across, down] {
                let inside = steps[..127].iter().max().unwrap();
                assert!(steps[127] <= inside + inside / 4 + 200, "{}: {} over {inside}", image.name, steps[127]);
            }
        }
    }

    #[test]
    fn every_texture_has_the_size_asked_for_even_the_smallest() {
        for (w, h) in [(1, 1), (7, 3), (64, 32)] {
            let size = Size::new(w, h);
            for image in all(size) {
                assert_eq!(image.texels.size(), size, "{}", image.name);
            }
        }
    }

    fn all(size: Size) -> Vec<TextureImage> {
        vec![
            charts::uv_grid(size),
            charts::checker(size, 8),
            charts::stripes(size, 8),
            charts::letter_f(size),
            charts::alpha_dots(size, 4),
            materials::bricks(size, 1),
            materials::brick_heights(size, 1),
            materials::wood(size, 1),
            materials::marble(size, 1),
            materials::scales(size, 1),
            materials::scale_heights(size, 1),
            materials::leaf(size),
            environment::sky_map(size),
            environment::matcap(size),
        ]
    }

    #[test]
    fn a_flat_height_map_has_upright_normals_and_a_slope_leans_away_from_the_rise() {
        let flat = heights("flat", Size::new(4, 4), |_| 0.5);
        assert!(bytes(&normal_map(&flat, 1.0)).texels.iter().all(|t| *t == [128, 128, 255, 255]));
        let wave = heights("wave", Size::new(8, 8), |t| 0.5 - 0.5 * (t.uv.x - 0.5).abs());
        let n = normal_map(&wave, 1.0);
        assert!(bytes(&n).at(2, 4)[0] < 128 && bytes(&n).at(6, 4)[0] > 128 && bytes(&n).at(2, 4)[1] == 128);
    }
}
