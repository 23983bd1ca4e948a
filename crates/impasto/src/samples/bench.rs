//! The scenes that speed is measured on, vertex for vertex those of the OpenGL baseline that Impasto is compared with.
//!
//! Everything is computed in f64 in the baseline's order of operations and rounded to f32 where it does. Triangles without
//! area (the sphere's poles) are kept in the raw mesh, because the baseline draws them too.

use crate::assets::{Image, RawMesh, Texels, TextureImage, UvSet};
use crate::color::Encoding;
use crate::math::exact::{cos, sin, tan};
use crate::math::{DVec3, Mat4, Size, Vec3, vec2};
use std::f64::consts::PI;

/// A scene by the baseline's name: `sphere10k`, `sphere100k`, `sphere1m`, `layers_btf`, `layers_ftb` or `terrain`.
pub fn mesh(name: &str) -> Option<RawMesh> {
    Some(match name {
        "sphere10k" => sphere(50, 100),
        "sphere100k" => sphere(158, 316),
        "sphere1m" => sphere(500, 1000),
        "layers_btf" => layers(false),
        "layers_ftb" => layers(true),
        "terrain" => terrain(512),
        _ => return None,
    })
}

/// The names that [`mesh`] and [`camera`] know.
pub const NAMES: [&str; 6] = ["sphere10k", "sphere100k", "sphere1m", "layers_btf", "layers_ftb", "terrain"];

/// Width and height of the scene's texture, in texels.
pub fn texture_size(name: &str) -> u32 {
    if name == "terrain" { 4096 } else { 1024 }
}

/// Linear background of all scenes.
pub const BACKGROUND: [f32; 3] = [0.1, 0.1, 0.15];
/// Towards the only light; not yet a unit vector.
pub const TO_LIGHT: [f64; 3] = [0.5, 0.8, 0.6];
/// Blinn-Phong's exponent in all scenes. Colour = texture * (0.15 + 0.85 diffuse) + 0.35 specular, in the texture's own numbers.
pub const EXPONENT: f32 = 48.0;

/// A waved sphere of about unit radius, 2 `n_lat` `n_lon` triangles; u runs to 4, v to 2.
pub fn sphere(n_lat: u32, n_lon: u32) -> RawMesh {
    let at = |theta: f64, phi: f64| {
        let r = 1.0 + 0.04 * sin(9.0 * phi) * sin(7.0 * theta);
        DVec3::new(r * sin(theta) * cos(phi), r * cos(theta), r * sin(theta) * sin(phi))
    };
    let mut raw = empty();
    for j in 0..=n_lat {
        for i in 0..=n_lon {
            let (theta, phi) = (PI * j as f64 / n_lat as f64, 2.0 * PI * i as f64 / n_lon as f64);
            const H: f64 = 1e-4;
            let d_theta = at(theta + H, phi) - at(theta - H, phi);
            let d_phi = at(theta, phi + H) - at(theta, phi - H);
            let normal = match j {
                0 => DVec3::Y,
                j if j == n_lat => -DVec3::Y,
                _ => cross(d_phi, d_theta),
            };
            let uv = [4.0 * i as f64 / n_lon as f64, 2.0 * j as f64 / n_lat as f64];
            push(&mut raw, at(theta, phi), normal, uv);
        }
    }
    index_grid(&mut raw, [n_lon, n_lat], 0, true);
    raw
}

/// Eight waved sheets one behind the other, 64x64 cells each, in this order of drawing.
pub fn layers(front_to_back: bool) -> RawMesh {
    const N: u32 = 64;
    let mut raw = empty();
    for layer in 0..8u32 {
        let k = if front_to_back { layer } else { 7 - layer } as f64;
        let base = raw.positions.len() as u32;
        for j in 0..=N {
            for i in 0..=N {
                let (x, y) = (-4.0 + 8.0 * i as f64 / N as f64, -2.6 + 5.2 * j as f64 / N as f64);
                let (fx, fy) = (3.0 + 0.5 * k, 2.5 + 0.25 * k);
                let z = -0.2 * k + 0.15 * sin(fx * x + k) * cos(fy * y - k);
                let dx = 0.15 * fx * cos(fx * x + k) * cos(fy * y - k);
                let dy = -0.15 * fy * sin(fx * x + k) * sin(fy * y - k);
                push(&mut raw, DVec3::new(x, y, z), DVec3::new(-dx, -dy, 1.0), [x * 0.5 + 0.1 * k, y * 0.5]);
            }
        }
        index_grid(&mut raw, [N, N], base, true);
    }
    raw
}

/// Rolling hills, 20 x 20 model units in `n` x `n` cells, seen at grazing angles.
pub fn terrain(n: u32) -> RawMesh {
    let height = |x: f64, z: f64| {
        0.35 * sin(0.9 * x) * cos(0.7 * z)
            + 0.12 * sin(2.7 * x + 1.0) * sin(2.3 * z)
            + 0.03 * sin(9.0 * x) * cos(8.0 * z + 2.0)
    };
    let mut raw = empty();
    for j in 0..=n {
        for i in 0..=n {
            let (x, z) = (-10.0 + 20.0 * i as f64 / n as f64, -10.0 + 20.0 * j as f64 / n as f64);
            const H: f64 = 1e-4;
            let dx = (height(x + H, z) - height(x - H, z)) / (2.0 * H);
            let dz = (height(x, z + H) - height(x, z - H)) / (2.0 * H);
            let uv = [4.0 * i as f64 / n as f64, 4.0 * j as f64 / n as f64];
            push(&mut raw, DVec3::new(x, height(x, z), z), DVec3::new(-dx, 1.0, -dz), uv);
        }
    }
    index_grid(&mut raw, [n, n], 0, false);
    raw
}

/// Checkers over two ramps with a grain of 4x4 texels; the first row is at v = 0. Linear bytes, mips to be box-filtered.
pub fn texture(n: u32) -> TextureImage {
    let texels = Image::from_fn(Size::new(n, n), |x, y| {
        let grain = grain(x >> 2, y >> 2) & 63;
        let dark = ((x >> 5) ^ (y >> 5)) & 1 == 0;
        let ramp = |x: u32, to: u64| (x as u64 * to / n as u64) as u32;
        [(if dark { 50 } else { 180 } + grain) as u8, ramp(x, 255) as u8, (ramp(y, 191) + (grain >> 1)) as u8, 255]
    });
    TextureImage { name: "bench".into(), texels: Texels::U8(texels), encoding: Encoding::Linear, n_channels: 4 }
}

fn grain(x: u32, y: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77);
    h ^= h >> 15;
    h = h.wrapping_mul(0x2C1B_3C6D);
    h ^= h >> 12;
    h = h.wrapping_mul(0x297A_2D39);
    h ^ h >> 15
}

/// Where the baseline's camera stands in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye, model units.
    pub eye: DVec3,
    /// What it looks at.
    pub target: DVec3,
    /// Full vertical field of view, radians.
    pub fov_y: f64,
    /// Width over height.
    pub aspect: f64,
    /// Distance of the near plane.
    pub near: f64,
    /// Distance of the far plane.
    pub far: f64,
}

/// The view of a frame; the eye moves on by 0.05 radians a frame. None for a name that [`mesh`] does not know.
pub fn camera(name: &str, frame: u32, aspect: f64) -> Option<View> {
    let angle = 0.05 * frame as f64;
    let (eye, target) = match name {
        "layers_btf" | "layers_ftb" => (DVec3::new(0.3 * sin(angle), 0.3 * cos(angle), 3.0), DVec3::ZERO),
        "terrain" => (DVec3::new(8.0 * sin(0.3 * angle), 0.9, 8.0 * cos(0.3 * angle)), DVec3::new(0.0, 0.3, 0.0)),
        "sphere10k" | "sphere100k" | "sphere1m" => (DVec3::new(2.9 * sin(angle), 0.4, 2.9 * cos(angle)), DVec3::ZERO),
        _ => return None,
    };
    Some(View { eye, target, fov_y: PI / 4.0, aspect, near: 0.1, far: 100.0 })
}

impl View {
    /// OpenGL's projection times view matrix (depth -1 to 1), computed in f64 as the baseline does.
    pub fn clip_from_world(&self) -> Mat4 {
        let f = unit(self.target - self.eye);
        let s = unit(DVec3::new(-f.z, 0.0, f.x));
        let u = cross(s, f);
        let view = [
            [s.x, u.x, -f.x, 0.0],
            [s.y, u.y, -f.y, 0.0],
            [s.z, u.z, -f.z, 0.0],
            [-dot(s, self.eye), -dot(u, self.eye), dot(f, self.eye), 1.0],
        ];
        let t = 1.0 / tan(self.fov_y / 2.0);
        let depth = self.far - self.near;
        let projection = [
            [t / self.aspect, 0.0, 0.0, 0.0],
            [0.0, t, 0.0, 0.0],
            [0.0, 0.0, -(self.far + self.near) / depth, -1.0],
            [0.0, 0.0, -2.0 * self.far * self.near / depth, 0.0],
        ];
        Mat4::from_cols_array_2d(&std::array::from_fn(|c| {
            std::array::from_fn(|r| (0..4).map(|k| projection[k][r] * view[c][k]).fold(0.0, |s, x| s + x) as f32)
        }))
    }
}

fn empty() -> RawMesh {
    RawMesh { uv_sets: vec![UvSet { name: "uv0".into(), uv: Vec::new() }], ..RawMesh::default() }
}

fn push(raw: &mut RawMesh, position: DVec3, normal: DVec3, uv: [f64; 2]) {
    raw.positions.push(position.as_vec3());
    raw.normals.push(unit(normal).as_vec3());
    raw.uv_sets[0].uv.push(vec2(uv[0] as f32, uv[1] as f32));
}

/// Two triangles a cell of a row-major grid of (n[0]+1) x (n[1]+1) vertices.
fn index_grid(raw: &mut RawMesh, n: [u32; 2], base: u32, flip: bool) {
    for j in 0..n[1] {
        for i in 0..n[0] {
            let a = base + j * (n[0] + 1) + i;
            let (b, c) = (a + 1, a + n[0] + 1);
            let d = c + 1;
            raw.triangles.extend(if flip { [[a, b, c], [b, d, c]] } else { [[a, c, b], [b, c, d]] });
        }
    }
}

// Written out because the baseline's order of operations counts.
fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

fn cross(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

fn unit(v: DVec3) -> DVec3 {
    let length = dot(v, v).sqrt();
    DVec3::new(v.x / length, v.y / length, v.z / length)
}

/// Unit vector towards the only light.
pub fn to_light() -> Vec3 {
    unit(DVec3::from(TO_LIGHT)).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FNV-1a, as the baseline's dump was hashed.
    fn fnv(bytes: impl IntoIterator<Item = u8>) -> u64 {
        bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ b as u64).wrapping_mul(0x100_0000_01b3))
    }

    /// Hashes of the baseline's own arrays: positions, texture coordinates, indices.
    #[test]
    fn scenes_are_those_of_the_baseline_bit_for_bit() {
        let truths = [
            ("sphere10k", [0xb6035dd209de1371, 0xe70624299dbf73d5, 0xa82a0709543dc005]),
            ("sphere100k", [0x004a083e6b0530d5, 0x6ff68b9cf2da9d0d, 0x08f9907a0cc8747a]),
            ("layers_btf", [0x7b0f3e8898ecc0cc, 0xd958519caded3f2e, 0xaede693c615e628b]),
            ("layers_ftb", [0xebb21c6cf35051f8, 0x3a2b511edc4c611e, 0xaede693c615e628b]),
            ("terrain", [0x60cd93231420e580, 0xa663b180e30993e5, 0x148de492c47ed369]),
        ];
        for (name, truth) in truths {
            let raw = mesh(name).unwrap();
            let got = [
                fnv(raw.positions.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes)),
                fnv(raw.uv_sets[0].uv.iter().flat_map(|t| t.to_array()).flat_map(f32::to_le_bytes)),
                fnv(raw.triangles.iter().flatten().flat_map(|i| i.to_le_bytes())),
            ];
            assert!(got == truth, "{name}: {got:x?}");
            assert!(raw.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6));
        }
    }

    #[test]
    fn texture_and_cameras_are_those_of_the_baseline_bit_for_bit() {
        let Texels::U8(image) = texture(1024).texels else { panic!("bytes") };
        assert_eq!(fnv(image.texels.into_iter().flatten()), 0x252e_42fc_6428_174d);
        for (name, truth) in [
            ("sphere10k", 0xef7e_25a9_8021_2305),
            ("layers_btf", 0x21c5_b6d4_1251_46cf),
            ("terrain", 0x69b3_d8ec_c463_3dbc),
        ] {
            let matrix = camera(name, 7, 1280.0 / 720.0).unwrap().clip_from_world();
            let got = fnv(matrix.to_cols_array().into_iter().flat_map(f32::to_le_bytes));
            assert!(got == truth, "{name}: {got:x}");
        }
    }
}
