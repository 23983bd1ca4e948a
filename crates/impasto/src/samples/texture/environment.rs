//! Light from all around, by formula: one sky, as a map of latitudes, as six cube faces, as a photographed ball.

use crate::assets::{Image, Texels, TextureImage};
use crate::color::{Encoding, LinearRgb};
use crate::math::exact::{cos, sin};
use crate::math::{Size, Vec3, unit_or, vec2, vec3};
use crate::samples::texture::{center, edge, font, mix, opaque, rgb, smooth};
use std::f64::consts::PI;

/// Linear light that comes from a unit direction: a soft evening sky over warm ground, a sun of about 40 times white
/// paper, two softboxes as a studio has them.
pub fn sky(d: Vec3) -> LinearRgb {
    let up = d.y;
    let zenith = [0.16, 0.33, 0.68];
    let horizon = [0.98, 0.78, 0.58];
    let ground = [0.20, 0.16, 0.13];
    let mut c = mix(horizon, zenith, smooth(0.0, 0.75, up));
    c = mix(c, mix(ground, [0.42, 0.34, 0.27], smooth(-0.5, 0.0, up)), smooth(0.015, -0.015, up));
    let sun = d.dot(unit_or(vec3(-0.55, 0.42, 0.72), Vec3::Y));
    let glow = smooth(0.86, 1.0, sun);
    c = add(c, [1.5, 1.05, 0.6], glow * glow);
    c = add(c, [40.0, 34.0, 26.0], smooth(0.9965, 0.9985, sun));
    // Softboxes: rectangles seen from the middle.
    for (axis, strength) in [(vec3(0.85, 0.45, 0.30), 3.2), (vec3(0.10, 0.85, -0.52), 2.2)] {
        let axis = unit_or(axis, Vec3::Y);
        let right = unit_or(Vec3::Y.cross(axis), Vec3::X);
        let ahead = d.dot(axis);
        if ahead > 0.1 {
            let (x, y) = (d.dot(right) / ahead, d.dot(axis.cross(right)) / ahead);
            let inside = (0.22 - x.abs()).min(0.34 - y.abs());
            c = add(c, [1.0, 1.0, 1.05], strength * smooth(-0.02, 0.03, inside));
        }
    }
    c
}

fn add(a: LinearRgb, b: LinearRgb, by: f32) -> LinearRgb {
    std::array::from_fn(|k| a[k] + b[k] * by)
}

/// The sky as a map of longitude and latitude (float, linear): the middle looks along -Z, +X lies to the right, +Y on top.
pub fn sky_map(size: Size) -> TextureImage {
    lights("sky", size, |u, v| {
        let (longitude, polar) = (2.0 * PI * (u as f64 - 0.5), PI * v as f64);
        let (s, c) = (sin(polar), cos(polar));
        vec3((s * sin(longitude)) as f32, c as f32, (-s * cos(longitude)) as f32)
    })
}

/// The sky on the six faces of a cube (float, linear), in the order and with the directions of OpenGL's cube maps:
/// +X, -X, +Y, -Y, +Z, -Z, the first row of each on top.
pub fn sky_cube(n: u32) -> [TextureImage; 6] {
    std::array::from_fn(|face| {
        lights(&format!("sky {}", FACE_NAMES[face]), Size::new(n, n), |u, v| {
            unit_or(cube_direction(face, u, v), Vec3::Y)
        })
    })
}

const FACE_NAMES: [&str; 6] = ["+X", "-X", "+Y", "-Y", "+Z", "-Z"];

/// Six faces, each with its colour, its name and a frame, to see which is where and which way up.
pub fn labelled_cube(n: u32) -> [TextureImage; 6] {
    const COLORS: [u32; 6] = [0xd1495b, 0xe39aa5, 0x3d9a6a, 0x9ed0b4, 0x30638e, 0x8fb3d0];
    std::array::from_fn(|face| {
        opaque(FACE_NAMES[face], Size::new(n, n), |t| {
            let border = t.uv.min(vec2(1.0, 1.0) - t.uv).min_element();
            let c = mix(rgb(COLORS[face]), rgb(0xffffff), 0.16 * (1.0 - t.uv.y));
            let c = mix(c, rgb(0xfdf6e6), edge(0.04 - border, t.size) * 0.9);
            let dot = 0.052;
            let at = (t.uv - vec2(0.5 - 5.5 * dot, 0.5 - 3.5 * dot)) / dot;
            mix(c, rgb(0xfdf6e6), font::coverage(FACE_NAMES[face], at, t.size / dot))
        })
    })
}

/// The direction that a place on a cube face stands for; not a unit vector (OpenGL 4.6, table 8.19).
fn cube_direction(face: usize, u: f32, v: f32) -> Vec3 {
    let (s, t) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    match face {
        0 => vec3(1.0, -t, -s),
        1 => vec3(-1.0, -t, s),
        2 => vec3(s, 1.0, t),
        3 => vec3(s, -1.0, -t),
        4 => vec3(s, -t, 1.0),
        _ => vec3(-s, -t, -1.0),
    }
}

fn lights(name: &str, size: Size, direction: impl Fn(f32, f32) -> Vec3) -> TextureImage {
    let size = Size::new(size.width.max(1), size.height.max(1));
    let image = Image::from_fn(size, |x, y| {
        let uv = center(x, y, size);
        let [r, g, b] = sky(direction(uv.x, uv.y));
        [r, g, b, 1.0]
    });
    TextureImage { name: name.into(), texels: Texels::F32(image), encoding: Encoding::Linear, n_channels: 3 }
}

/// A glazed clay ball as a painter would light it: the colour for each normal that faces the eye, x right and y up.
pub fn matcap(size: Size) -> TextureImage {
    opaque("matcap", size, |t| {
        let q = (t.uv - vec2(0.5, 0.5)) * vec2(2.0, -2.0);
        let r2 = q.length_squared();
        // Beside the disc the rim goes on, so that a filter finds nothing foreign.
        let q = if r2 > 0.999 { q * (0.999 / r2).sqrt() } else { q };
        let n = vec3(q.x, q.y, (1.0 - q.length_squared()).max(0.0).sqrt());
        let key = n.dot(unit_or(vec3(-0.5, 0.65, 0.6), Vec3::Y));
        let c = mix(rgb(0x4a2335), rgb(0xd9644a), smooth(-0.55, 0.75, key));
        let c = mix(c, rgb(0xffc98a), smooth(0.55, 1.0, key) * 0.8);
        let rim = smooth(0.62, 1.0, 1.0 - n.z) * smooth(-0.2, 0.8, n.x - 0.4 * n.y);
        let c = mix(c, rgb(0x8fb8e8), 0.75 * rim);
        let half = n.dot(unit_or(vec3(-0.28, 0.38, 0.9), Vec3::Z));
        mix(c, rgb(0xffffff), 0.9 * smooth(0.975, 0.992, half))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neighbouring faces agree where they meet: the same direction seen from both.
    #[test]
    fn cube_faces_meet_without_a_gap() {
        let near = |a: Vec3, b: Vec3| (unit_or(a, Vec3::Y) - unit_or(b, Vec3::Y)).length() < 1e-6;
        for v in [0.0, 0.3, 1.0] {
            assert!(near(cube_direction(4, 1.0, v), cube_direction(0, 0.0, v)), "+Z meets +X");
            assert!(near(cube_direction(0, 1.0, v), cube_direction(5, 0.0, v)), "+X meets -Z");
            assert!(near(cube_direction(5, 1.0, v), cube_direction(1, 0.0, v)), "-Z meets -X");
            assert!(near(cube_direction(1, 1.0, v), cube_direction(4, 0.0, v)), "-X meets +Z");
            assert!(near(cube_direction(2, v, 1.0), cube_direction(4, v, 0.0)), "+Y meets +Z");
            assert!(near(cube_direction(3, v, 0.0), cube_direction(4, v, 1.0)), "-Y meets +Z");
        }
    }
}
