//! Test charts: which way up, how large, how often, how sharp.

use crate::assets::TextureImage;
use crate::math::{Size, Vec2, vec2};
use crate::samples::texture::{Rgb, edge, font, fract, mix, opaque, painted, rgb, shade};

/// The chart for texture coordinates: 8 x 8 cells, A to H to the right and 1 to 8 down, each with its own colour, label
/// and an arrow that points up (towards v = 0); fine lines at sixteenths of a cell's edge on their borders.
pub fn uv_grid(size: Size) -> TextureImage {
    opaque("uv_grid", size, |t| {
        const N: f32 = 8.0;
        let cell = (t.uv * N).floor().min(vec2(N - 1.0, N - 1.0));
        let p = t.uv * N - cell;
        let texel = t.size * N;
        let mut c = cell_color(cell);
        if (cell.x + cell.y) as i32 & 1 == 1 {
            c = shade(c, 0.86);
        }
        // Quarter lines, the cell's border, and the middle of the chart stronger.
        let quarter = line_at(fract(p.x * 4.0), 0.035, texel * 4.0).max(line_at(fract(p.y * 4.0), 0.035, texel * 4.0));
        c = mix(c, rgb(0xffffff), 0.30 * quarter);
        let border = line_at(p.x, 0.016, texel).max(line_at(p.y, 0.016, texel));
        c = mix(c, rgb(0x262a31), 0.85 * border);
        let label = String::from_iter([(b'A' + cell.x as u8) as char, (b'1' + cell.y as u8) as char]);
        let dot = 0.058;
        let at = (p - vec2(0.5 - 5.5 * dot, 0.34)) / dot;
        let ink = rgb(0x1f2329);
        // A light halo keeps the label legible on the grid lines.
        let halo = (at - vec2(5.5, 3.5)).abs() - vec2(6.6, 4.6);
        c = mix(c, mix(c, rgb(0xffffff), 0.55), edge(-halo.max_element(), texel / dot));
        c = mix(c, ink, font::coverage(&label, at, texel / dot));
        mix(c, ink, arrow(p - vec2(0.5, 0.18), texel))
    })
}

/// Hue by column, lightness by row: neighbours differ, and a glance tells where one is.
fn cell_color(cell: Vec2) -> Rgb {
    const COLUMNS: [u32; 8] = [0xef6f6c, 0xf39c5a, 0xf2c14e, 0xa8c256, 0x5bb98c, 0x4aa8c0, 0x6d8bd0, 0xa67fc4];
    let c = rgb(COLUMNS[cell.x as usize]);
    let row = cell.y / 7.0;
    mix(mix(c, rgb(0xffffff), 0.34 * (1.0 - row)), rgb(0x39414f), 0.30 * row)
}

/// A line on both borders of [0, 1].
fn line_at(x: f32, half: f32, texel: f32) -> f32 {
    edge(half - x.min(1.0 - x), texel)
}

/// A small arrow that points up, about the origin.
fn arrow(p: Vec2, texel: f32) -> f32 {
    let head = edge((p.y + 0.09).min(0.02 - p.y).min((p.y + 0.09) * 0.75 - p.x.abs()), texel);
    let shaft = edge((0.018 - p.x.abs()).min(p.y).min(0.10 - p.y), texel);
    head.max(shaft)
}

/// `n` x `n` squares, warm white and blue grey. Tiles for even `n`.
pub fn checker(size: Size, n: u32) -> TextureImage {
    opaque("checker", size, |t| {
        let p = t.uv * n as f32;
        let texel = t.size * n as f32;
        // Signed distance to the next line, negative in dark squares: exact antialiasing of straight lines.
        let side = |x: f32| {
            let d = fract(x).min(1.0 - fract(x));
            let s = (0.5 + d / texel.max(1e-6)).min(1.0);
            if crate::math::floor(x) as i32 & 1 == 0 { s } else { 1.0 - s }
        };
        let (a, b) = (side(p.x), side(p.y));
        mix(rgb(0x5d7590), rgb(0xf4f1ea), a * b + (1.0 - a) * (1.0 - b))
    })
}

/// `n` slanted stripes of four colours. Tiles when `n` is a multiple of 4.
pub fn stripes(size: Size, n: u32) -> TextureImage {
    const COLORS: [u32; 4] = [0xf6ead2, 0xe76f51, 0x2a9d8f, 0x264653];
    opaque("stripes", size, |t| {
        let x = (t.uv.x + t.uv.y) * n as f32;
        let k = crate::math::floor(x) as i32;
        let color = |k: i32| rgb(COLORS[k.rem_euclid(4) as usize]);
        // Along the diagonal a texel is wider by the square root of two.
        mix(color(k), color(k + 1), edge(fract(x) - 1.0, 1.4 * t.size * n as f32) * 2.0 * 0.5)
    })
}

/// An F that looks different from every side, in a frame whose four edges differ: for pictures of wrap modes.
pub fn letter_f(size: Size) -> TextureImage {
    opaque("letter_f", size, |t| {
        let p = t.uv;
        let mut c = mix(rgb(0xfdf3dc), rgb(0xf7dfb4), p.y);
        // The F: a stem and two bars, with rounded ends.
        let bar = |a: Vec2, b: Vec2, half: f32| {
            let (q, d) = (p - a, b - a);
            let s = (q.dot(d) / d.length_squared()).clamp(0.0, 1.0);
            half - (q - d * s).length()
        };
        let f = bar(vec2(0.34, 0.24), vec2(0.34, 0.78), 0.065)
            .max(bar(vec2(0.34, 0.24), vec2(0.68, 0.24), 0.065))
            .max(bar(vec2(0.34, 0.49), vec2(0.58, 0.49), 0.065));
        let shadow = bar(vec2(0.36, 0.26), vec2(0.36, 0.80), 0.065)
            .max(bar(vec2(0.36, 0.26), vec2(0.70, 0.26), 0.065))
            .max(bar(vec2(0.36, 0.51), vec2(0.60, 0.51), 0.065));
        c = mix(c, rgb(0xe3c48d), edge(shadow, t.size));
        c = mix(c, rgb(0x21525c), edge(f, t.size));
        c = mix(c, rgb(0xe4572e), edge(0.055 - p.distance(vec2(0.72, 0.74)), t.size));
        // Top red, right yellow, bottom green, left blue; mitred in the corners.
        let sides = [(p.y, 0xd1495b), (1.0 - p.x, 0xedae49), (1.0 - p.y, 0x3d9a6a), (p.x, 0x30638e)];
        let (d, hex) = sides.into_iter().fold((1.0f32, 0), |m, s| if s.0 < m.0 { s } else { m });
        mix(c, rgb(hex), edge(0.07 - d, t.size))
    })
}

/// `n` x `n` round dots that are there, on a ground that is not (alpha 0); each second row shifted by half. Tiles for even `n`.
pub fn alpha_dots(size: Size, n: u32) -> TextureImage {
    painted("alpha_dots", size, 4, |t| {
        let p = t.uv * n as f32;
        let row = crate::math::floor(p.y);
        let shift = if row as i32 & 1 == 0 { 0.0 } else { 0.5 };
        let q = vec2(fract(p.x + shift), fract(p.y)) - vec2(0.5, 0.5);
        let [r, g, b] = mix(rgb(0xf2a65a), rgb(0xd1495b), edge(q.length() - 0.22, t.size * n as f32));
        [r, g, b, edge(0.36 - q.length(), t.size * n as f32)]
    })
}
