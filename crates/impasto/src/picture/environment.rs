//! Panoramas as surroundings, blurred once for every roughness.
//!
//! The sphere is unfolded onto one square (octahedral map; Engelhardt, Dachsbacher, "Octahedron Environment Maps",
//! 2008), so that a look-up is a division and four texels, and a border of folded-over texels hides the seam. Each level
//! is the panorama seen through the GGX lobe of one roughness, by importance sampling from coarser copies (Křivánek,
//! Colbert, "Real-time Shading with Filtered Importance Sampling", 2008) with normal = view, as Karis 2013 splits it.

use crate::assets::{Image, Texels, TextureImage};
use crate::color::{Encoding, LINEAR_FROM_SRGB8, LinearRgb, linear_from_srgb};
use crate::math::{Frame, Size, Vec3, exact, vec3};
use crate::par::Workers;
use crate::picture::Ambient;
use crate::picture::lanes::{V, V3, at_least, clamp01, larger, per_channel, splat, width};
use fearless_simd::{Simd, prelude::*};

/// A panorama prepared for look-ups.
#[derive(Clone, Debug)]
pub struct Environment {
    /// What matte surfaces receive of it.
    pub ambient: Ambient,
    /// From sharp to the lobe of roughness 1, in even steps of roughness.
    levels: Vec<Unfolded>,
}

/// A sphere of colours unfolded onto a square, with a border one texel wide.
#[derive(Clone, Debug)]
pub(super) struct Unfolded {
    /// Texels in a row, without the border.
    size: usize,
    /// `(size + 2)^2`.
    texels: Vec<[f32; 4]>,
}

/// Texels in a row for each level: as many as its lobe can tell apart.
const SIZES: [usize; 8] = [512, 128, 64, 64, 32, 32, 16, 16];

/// Directions a texel of a blurred level is averaged from.
const N_SAMPLES: usize = 64;

impl Environment {
    /// Prepares an equirectangular panorama: row 0 is straight up (+Y), the middle of the picture is at -Z and +X lies
    /// to the right of it, turned about the vertical by `turn` radians (positive moves the picture to the left).
    pub fn of_panorama(image: &TextureImage, turn: f64, workers: &Workers) -> Self {
        let panorama = halved_until(linear(image), 2048);
        let (sin, cos) = (exact::sin(turn) as f32, exact::cos(turn) as f32);
        let turned = |d: Vec3| vec3(d.x * cos - d.z * sin, d.y, d.x * sin + d.z * cos);
        Self::of_directions(|d| panorama_at(&panorama, turned(d)), workers)
    }

    /// Prepares six square faces, +X -X +Y -Y +Z -Z, seen from inside as glTF and OpenGL order and turn them.
    pub fn of_cube(faces: &[TextureImage; 6], workers: &Workers) -> Self {
        let faces = faces.each_ref().map(linear);
        Self::of_directions(|d| cube_at(&faces, d), workers)
    }

    /// Prepares any function of unit directions to linear radiance.
    pub fn of_directions(radiance: impl Fn(Vec3) -> LinearRgb + Sync, workers: &Workers) -> Self {
        let mut coarser = coarser(Unfolded::of_directions(SIZES[0], workers, &radiance));
        let ambient = ambient_of(&coarser[3]);
        let mut levels: Vec<Unfolded> = (1..SIZES.len())
            .map(|k| {
                let lobe = Lobe::new(k as f64 / (SIZES.len() - 1) as f64);
                Unfolded::of_directions(SIZES[k], workers, |d| lobe.seen(&coarser, d))
            })
            .collect();
        levels.insert(0, coarser.swap_remove(0));
        Self { ambient, levels }
    }

    /// Linear light from a unit direction, seen through the lobe of a roughness.
    pub fn at(&self, toward: Vec3, roughness: f32) -> LinearRgb {
        let [u, v] = unfold(toward);
        self.mixed(u, v, roughness.clamp(0.0, 1.0) * (self.levels.len() - 1) as f32)
    }

    /// The same for a register of directions.
    #[inline(always)]
    pub(super) fn mirrored<S: Simd>(&self, simd: S, toward: V3<S>, roughness: V<S>) -> V3<S> {
        let [x, y, z] = toward;
        let (ax, ay, az) = (larger::<S>(x, -x), larger::<S>(y, -y), larger::<S>(z, -z));
        let inverse = splat(simd, 1.0) / at_least(simd, ax + ay + az, 1e-20);
        let (u, v) = (x * inverse, z * inverse);
        let (au, av) = (ax * inverse, az * inverse);
        let below = y.simd_lt(splat(simd, 0.0));
        let one = splat(simd, 1.0);
        let u_sign = splat(simd, 1.0).copysign(u);
        let v_sign = splat(simd, 1.0).copysign(v);
        let u = below.select((one - av) * u_sign, u) * 0.5 + 0.5;
        let v = below.select((one - au) * v_sign, v) * 0.5 + 0.5;
        let level = clamp01(simd, roughness) * (self.levels.len() - 1) as f32;
        // Texels are fetched cell by cell: hardware gathers are slower where they exist.
        let mut color = [[0.0; 16]; 3];
        for i in 0..width::<S>() {
            let [r, g, b] = self.mixed(u[i], v[i], level[i]);
            color[0][i] = r;
            color[1][i] = g;
            color[2][i] = b;
        }
        per_channel!(c => V::<S>::from_slice(simd, &color[c][..width::<S>()]))
    }

    /// Between two levels.
    #[inline(always)]
    fn mixed(&self, u: f32, v: f32, level: f32) -> LinearRgb {
        let last = self.levels.len() - 1;
        let low = (level as usize).min(last);
        let t = level - low as f32;
        let (a, b) = (self.levels[low].at(u, v), self.levels[(low + 1).min(last)].at(u, v));
        per_channel!(c => a[c] + (b[c] - a[c]) * t)
    }
}

/// A unit direction on the square: +Y in the middle, -Y in the four corners.
fn unfold(d: Vec3) -> [f32; 2] {
    let inverse = 1.0 / (d.x.abs() + d.y.abs() + d.z.abs());
    let (u, v) = (d.x * inverse, d.z * inverse);
    let signed = |t: f32, s: f32| if s < 0.0 { -t } else { t };
    let (u, v) = if d.y < 0.0 { (signed(1.0 - v.abs(), u), signed(1.0 - u.abs(), v)) } else { (u, v) };
    [u * 0.5 + 0.5, v * 0.5 + 0.5]
}

/// The reverse of [`unfold`]; beyond the square's edges it goes on over the fold.
fn fold(u: f32, v: f32) -> Vec3 {
    let over = |a: f32, b: f32| match a {
        a if a < 0.0 => (-a, 1.0 - b),
        a if a > 1.0 => (2.0 - a, 1.0 - b),
        a => (a, b),
    };
    let (u, v) = over(u, v);
    let (v, u) = over(v, u);
    let (x, z) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let y = 1.0 - x.abs() - z.abs();
    let signed = |t: f32, s: f32| if s < 0.0 { -t } else { t };
    let (x, z) = if y < 0.0 { (signed(1.0 - z.abs(), x), signed(1.0 - x.abs(), z)) } else { (x, z) };
    let d = vec3(x, y, z);
    d * (1.0 / d.length_squared().sqrt())
}

impl Unfolded {
    fn of_directions(size: usize, workers: &Workers, radiance: impl Fn(Vec3) -> LinearRgb + Sync + Send) -> Self {
        let place = |i: usize| (i as f32 - 0.5) / size as f32;
        let rows = workers.map(size + 2, |y| {
            let texel = |x| {
                let [r, g, b] = radiance(fold(place(x), place(y)));
                [r, g, b, 0.0]
            };
            (0..size + 2).map(texel).collect::<Vec<_>>()
        });
        Self { size, texels: rows.concat() }
    }

    /// Any function of unit directions to linear radiance, seen through the lobe of one roughness.
    pub(super) fn blurred(radiance: impl Fn(Vec3) -> LinearRgb + Sync, roughness: f32, workers: &Workers) -> Self {
        let coarser = coarser(Self::of_directions(SIZES[0], workers, &radiance));
        let roughness = roughness.clamp(0.0, 1.0) as f64;
        // A lobe is about alpha wide: some thirty texels for each radian of it.
        let size = (32.0 / (roughness * roughness).max(1e-6)).clamp(64.0, SIZES[0] as f64) as usize;
        let lobe = Lobe::new(roughness);
        Self::of_directions(size, workers, |d| lobe.seen(&coarser, d))
    }

    /// The colour in a unit direction.
    pub(super) fn toward(&self, d: Vec3) -> LinearRgb {
        let [u, v] = unfold(d);
        self.at(u, v)
    }

    /// Four neighbouring texels, for `u` and `v` within [0, 1].
    #[inline(always)]
    fn at(&self, u: f32, v: f32) -> LinearRgb {
        let row = self.size + 2;
        let (x, y) = (u * self.size as f32 + 0.5, v * self.size as f32 + 0.5);
        // The cast takes NaN and negatives to 0.
        let (i, j) = ((x as usize).min(self.size), (y as usize).min(self.size));
        let (fx, fy) = (x - i as f32, y - j as f32);
        let texel = |k: usize| self.texels[j * row + i + k];
        let (a, b, c, d) = (texel(0), texel(1), texel(row), texel(row + 1));
        per_channel!(k => {
            let (top, bottom) = (a[k] + (b[k] - a[k]) * fx, c[k] + (d[k] - c[k]) * fx);
            top + (bottom - top) * fy
        })
    }

    /// Half as many texels in a row, each the mean of four.
    fn halved(&self) -> Self {
        let (size, row) = (self.size / 2, self.size + 2);
        let inner = |x: usize, y: usize| -> [f32; 4] {
            let at = (2 * y + 1) * row + 2 * x + 1;
            let four = [at, at + 1, at + row, at + row + 1].map(|i| self.texels[i]);
            std::array::from_fn(|c| (four[0][c] + four[1][c] + four[2][c] + four[3][c]) * 0.25)
        };
        // The border repeats the texel that lies across the fold.
        let mirrored = |i: usize| size - 1 - i;
        let texels = (0..(size + 2) * (size + 2)).map(|i| {
            let across = |a: usize, b: usize| match a {
                0 => (0, mirrored(b)),
                a if a == size + 1 => (size - 1, mirrored(b)),
                a => (a - 1, b),
            };
            let (x, y) = (i % (size + 2), i / (size + 2));
            let clamped = y.clamp(1, size) - 1;
            let (x, clamped) = across(x, clamped);
            let (y, x) = match y {
                0 => (0, mirrored(x)),
                y if y == size + 1 => (size - 1, mirrored(x)),
                _ => (clamped, x),
            };
            inner(x, y)
        });
        Self { size, texels: texels.collect() }
    }
}

/// A sphere and ever coarser copies of it.
fn coarser(sharp: Unfolded) -> Vec<Unfolded> {
    let mut coarser = vec![sharp];
    while coarser[coarser.len() - 1].size > 4 {
        coarser.push(coarser[coarser.len() - 1].halved());
    }
    coarser
}

/// The spherical harmonics of a coarse copy, each texel weighted by its solid angle.
fn ambient_of(coarse: &Unfolded) -> Ambient {
    let n = coarse.size;
    let texel = |i: usize| {
        let (x, y) = (i % n, i / n);
        let [u, v] = [x, y].map(|t| (t as f32 + 0.5) / n as f32);
        // The square's area is spread evenly over the octahedron's faces, all equally far from the middle; so a
        // texel's solid angle goes with one over the cube of its distance there, which is 1 / (|x| + |y| + |z|).
        let d = fold(u, v);
        let inverse = (d.x.abs() + d.y.abs() + d.z.abs()) as f64;
        let [r, g, b, _] = coarse.texels[(y + 1) * (n + 2) + x + 1];
        (d, inverse * inverse * inverse, [r, g, b])
    };
    let sum: f64 = (0..n * n).map(|i| texel(i).1).sum();
    let whole = 4.0 * std::f64::consts::PI;
    Ambient::project((0..n * n).map(texel).map(|(d, weight, color)| (d, weight * whole / sum, color)))
}

/// Directions about +Z that a rough mirror sees, with their weights and how coarse a copy each may read.
struct Lobe {
    samples: Vec<(Vec3, f32, f32)>,
}

impl Lobe {
    fn new(roughness: f64) -> Self {
        use std::f64::consts::PI;
        let alpha = roughness * roughness;
        let texel = 4.0 * PI / (SIZES[0] * SIZES[0]) as f64;
        let sample = |i: usize| {
            // Hammersley's points: even in both directions.
            let (a, b) = ((i as f64 + 0.5) / N_SAMPLES as f64, (i as u32).reverse_bits() as f64 / 4_294_967_296.0);
            let cos_squared = (1.0 - a) / (1.0 + (alpha * alpha - 1.0) * a);
            let (cos, sin) = (cos_squared.sqrt(), (1.0 - cos_squared).sqrt());
            let angle = 2.0 * PI * b;
            // The mirror direction of +Z about the half vector.
            let l = [2.0 * cos * sin * exact::cos(angle), 2.0 * cos * sin * exact::sin(angle), 2.0 * cos_squared - 1.0];
            let slope = cos_squared * (alpha * alpha - 1.0) + 1.0;
            let density = alpha * alpha / (PI * slope * slope) / 4.0;
            let level = 0.5 * exact::log2(1.0 / (N_SAMPLES as f64 * density) / texel) + 1.0;
            (vec3(l[0] as f32, l[1] as f32, l[2] as f32), l[2] as f32, level.max(0.0) as f32)
        };
        Self { samples: (0..N_SAMPLES).map(sample).filter(|s| s.1 > 0.0).collect() }
    }

    fn seen(&self, coarser: &[Unfolded], toward: Vec3) -> LinearRgb {
        let frame = Frame::about(toward);
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for (l, weight, level) in &self.samples {
            let d = frame.tangent * l.x + frame.bitangent * l.y + frame.normal * l.z;
            let [u, v] = unfold(d);
            let color = coarser[(*level as usize).min(coarser.len() - 1)].at(u, v);
            for c in 0..3 {
                sum[c] += color[c] * weight;
            }
            weights += weight;
        }
        sum.map(|s| s / weights)
    }
}

/// Texels as linear light; what is no finite number of light is dark, and brighter than 2^16 is that.
pub(super) fn linear(image: &TextureImage) -> Image<[f32; 4]> {
    let srgb = image.encoding == Encoding::Srgb;
    let from_byte = |b: u8| if srgb { LINEAR_FROM_SRGB8[b as usize] } else { b as f32 / 255.0 };
    let from_word = |w: u16| {
        let x = w as f64 / 65535.0;
        (if srgb { linear_from_srgb(x) } else { x }) as f32
    };
    let from_float = |x: f32| if x > 0.0 { x.min(65536.0) } else { 0.0 };
    match &image.texels {
        Texels::U8(i) => Image { size: i.size, texels: i.texels.iter().map(|t| t.map(from_byte)).collect() },
        Texels::U16(i) => Image { size: i.size, texels: i.texels.iter().map(|t| t.map(from_word)).collect() },
        Texels::F32(i) => Image { size: i.size, texels: i.texels.iter().map(|t| t.map(from_float)).collect() },
    }
}

/// Means of four until no wider than `width`: more detail than a level holds would flicker.
fn halved_until(mut image: Image<[f32; 4]>, width: u32) -> Image<[f32; 4]> {
    while image.size.width > width && image.size.height > 1 {
        image = halved(&image);
    }
    image
}

fn panorama_at(image: &Image<[f32; 4]>, d: Vec3) -> LinearRgb {
    use std::f64::consts::PI;
    let u = 0.5 + exact::atan2(d.x as f64, -d.z as f64) / (2.0 * PI);
    let v = exact::acos((d.y as f64).clamp(-1.0, 1.0)) / PI;
    let (width, height) = (image.size.width as i64, image.size.height as i64);
    let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
    let (i, j) = (x.floor(), y.floor());
    let texel = |dx: i64, dy: i64| {
        image.at((i as i64 + dx).rem_euclid(width) as u32, (j as i64 + dy).clamp(0, height - 1) as u32)
    };
    mixed_four([texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)], (x - i) as f32, (y - j) as f32)
}

fn cube_at(faces: &[Image<[f32; 4]>; 6], d: Vec3) -> LinearRgb {
    let (face, [u, v]) = cube_face(d);
    within(&faces[face], u, v)
}

/// Which face of a cube a direction falls on, and where, as OpenGL turns them.
pub(super) fn cube_face(d: Vec3) -> (usize, [f32; 2]) {
    let a = d.abs();
    let (face, u, v, major) = if a.x >= a.y && a.x >= a.z {
        if d.x > 0.0 { (0, -d.z, -d.y, a.x) } else { (1, d.z, -d.y, a.x) }
    } else if a.y >= a.z {
        if d.y > 0.0 { (2, d.x, d.z, a.y) } else { (3, d.x, -d.z, a.y) }
    } else if d.z > 0.0 {
        (4, d.x, -d.y, a.z)
    } else {
        (5, -d.x, -d.y, a.z)
    };
    (face, [u, v].map(|t| t / major * 0.5 + 0.5))
}

/// Four texels of a face.
pub(super) fn within(image: &Image<[f32; 4]>, u: f32, v: f32) -> LinearRgb {
    let last = image.size.width.min(image.size.height) - 1;
    let place = |t: f32| (t * (last + 1) as f32 - 0.5).clamp(0.0, last as f32);
    let (x, y) = (place(u), place(v));
    let (i, j) = (x as u32, y as u32);
    let texel = |dx: u32, dy: u32| image.at((i + dx).min(last), (j + dy).min(last));
    mixed_four([texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)], x - i as f32, y - j as f32)
}

/// Half as many texels each way, means of four; an odd last row or column is left out.
pub(super) fn halved(image: &Image<[f32; 4]>) -> Image<[f32; 4]> {
    Image::from_fn(Size::new(image.size.width / 2, image.size.height / 2), |x, y| {
        let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| *image.at(2 * x + i, 2 * y + j));
        std::array::from_fn(|c| (four[0][c] + four[1][c] + four[2][c] + four[3][c]) * 0.25)
    })
}

pub(super) fn mixed_four(four: [&[f32; 4]; 4], fx: f32, fy: f32) -> LinearRgb {
    std::array::from_fn(|c| {
        let top = four[0][c] + (four[1][c] - four[0][c]) * fx;
        let bottom = four[2][c] + (four[3][c] - four[2][c]) * fx;
        top + (bottom - top) * fy
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::ambient::{cube_direction, spiral};

    #[test]
    fn folding_and_unfolding_are_inverse() {
        for d in spiral(500) {
            let [u, v] = unfold(d);
            assert!((fold(u, v) - d).length() < 1e-5, "{d}");
        }
        // Over the edge the sphere goes on without a jump.
        for t in [0.1f32, 0.4, 0.9] {
            for (inside, outside) in [([0.001, t], [-0.001, t]), ([t, 0.999], [t, 1.001])] {
                let (a, b) = (fold(inside[0], inside[1]), fold(outside[0], outside[1]));
                assert!((a - b).length() < 0.02, "{a} {b}");
            }
        }
    }

    #[test]
    fn smooth_surroundings_are_found_again_at_any_roughness() {
        // Through a lobe a linear gradient keeps its direction and loses contrast; its mean stays.
        let environment = Environment::of_directions(|d| [1.0 + 0.5 * d.y, 1.0, 0.5 + 0.5 * d.x], &Workers::new(1));
        for d in spiral(200) {
            let sharp = environment.at(d, 0.0);
            assert!((sharp[0] - 1.0 - 0.5 * d.y).abs() < 0.01 && (sharp[2] - 0.5 - 0.5 * d.x).abs() < 0.01, "{d}");
            for roughness in [0.0, 0.25, 0.5, 1.0] {
                let seen = environment.at(d, roughness);
                assert!((seen[1] - 1.0).abs() < 1e-4);
                assert!((seen[0] - 1.0).abs() <= (0.5 * d.y).abs() + 0.02, "{d} {roughness}: {seen:?}");
            }
            let (got, wanted) = (environment.ambient.at(d)[0], 1.0 + 0.5 * d.y * 2.0 / 3.0);
            assert!((got - wanted).abs() < 0.01, "{d}: {got} not {wanted}");
        }
    }

    #[test]
    fn panoramas_and_cubes_show_the_same_place() {
        let of = |d: Vec3| [0.5 + 0.5 * d.x, 0.5 + 0.5 * d.y, 0.5 + 0.5 * d.z, 1.0];
        let panorama = Image::from_fn(Size::new(256, 128), |x, y| {
            let (a, b) = ((x as f64 + 0.5) / 256.0 - 0.5, (y as f64 + 0.5) / 128.0);
            let (sin, cos) = (exact::sin(b * std::f64::consts::PI), exact::cos(b * std::f64::consts::PI));
            let a = 2.0 * std::f64::consts::PI * a;
            of(vec3((exact::sin(a) * sin) as f32, cos as f32, (-exact::cos(a) * sin) as f32))
        });
        let image =
            |i| TextureImage { name: String::new(), texels: Texels::F32(i), encoding: Encoding::Linear, n_channels: 3 };
        let cube = std::array::from_fn(|face| {
            image(Image::from_fn(Size::new(64, 64), |x, y| {
                let [u, v] = [x, y].map(|t| (t as f32 + 0.5) / 32.0 - 1.0);
                of(cube_direction(face, u, v))
            }))
        });
        let workers = Workers::new(1);
        for environment in
            [Environment::of_panorama(&image(panorama), 0.0, &workers), Environment::of_cube(&cube, &workers)]
        {
            for d in spiral(200) {
                let (got, wanted) = (environment.at(d, 0.0), of(d));
                assert!((0..3).all(|c| (got[c] - wanted[c]).abs() < 0.03), "{d}: {got:?} not {wanted:?}");
            }
        }
    }

    #[test]
    fn thread_count_does_not_matter() {
        let of = |d: Vec3| [d.x * d.x, d.y * d.y, if d.z > 0.9 { 30.0 } else { 0.1 }];
        let (one, five) =
            (Environment::of_directions(of, &Workers::new(1)), Environment::of_directions(of, &Workers::new(5)));
        for (a, b) in one.levels.iter().zip(&five.levels) {
            assert!(a.texels == b.texels);
        }
    }
}
