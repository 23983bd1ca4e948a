//! Light from everywhere on matte surfaces: nine spherical-harmonic terms a channel.
//!
//! Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance Environment Maps", 2001: a clamped cosine lets
//! so little of the higher terms through that nine are within 3 % of the truth for natural surroundings.

use crate::assets::Image;
use crate::color::LinearRgb;
use crate::math::{Vec3, exact, vec3};
use crate::picture::Surroundings;

/// Light that arrives at a matte surface from all around, as a quadratic polynomial of its normal.
///
/// Counted like lights are: surroundings of even brightness 1 give 1 for every normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    /// Factors of [`basis`]'s nine polynomials, each for red, green, blue.
    pub terms: [LinearRgb; 9],
}

/// The nine polynomials of a unit vector, up to constants the first spherical harmonics.
#[inline(always)]
pub fn basis(n: Vec3) -> [f32; 9] {
    [1.0, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3.0 * n.z * n.z - 1.0, n.x * n.z, n.x * n.x - n.y * n.y]
}

/// For each polynomial: the square of its spherical harmonic's constant, times the cosine lobe's attenuation over pi.
/// The first factor takes radiance to a coefficient and back to a value, the second from radiance to light received.
const RECEIVED_FROM_SEEN: [f64; 9] = {
    use std::f64::consts::PI;
    let (one, linear) = (0.25 / PI, 0.75 / PI * (2.0 / 3.0));
    let (mixed, zz, xx) = (3.75 / PI * 0.25, 0.3125 / PI * 0.25, 0.9375 / PI * 0.25);
    [one, linear, linear, linear, mixed, mixed, zz, mixed, xx]
};

impl Ambient {
    /// The same from every side.
    pub fn constant(color: LinearRgb) -> Self {
        let mut terms = [[0.0; 3]; 9];
        terms[0] = color;
        Self { terms }
    }

    /// Whether all normals get the same.
    pub fn is_constant(&self) -> bool {
        self.terms[1..].iter().flatten().all(|t| *t == 0.0)
    }

    /// What a surface with this unit normal receives; never negative.
    pub fn at(&self, normal: Vec3) -> LinearRgb {
        let b = basis(normal);
        std::array::from_fn(|c| {
            let sum = self.terms.iter().zip(b).fold(0.0, |sum, (t, b)| sum + t[c] * b);
            if sum > 0.0 { sum } else { 0.0 }
        })
    }

    /// Projects surroundings given as directions with their solid angle (steradians, 4 pi in all) and radiance.
    pub fn project(samples: impl IntoIterator<Item = (Vec3, f64, LinearRgb)>) -> Self {
        let mut sums = [[0.0f64; 3]; 9];
        for (toward, solid_angle, radiance) in samples {
            for (sum, b) in sums.iter_mut().zip(basis(toward)) {
                for c in 0..3 {
                    sum[c] += b as f64 * solid_angle * radiance[c] as f64;
                }
            }
        }
        Self { terms: std::array::from_fn(|i| sums[i].map(|s| (s * RECEIVED_FROM_SEEN[i]) as f32)) }
    }

    /// Sky and floor of surroundings, without their panels: those are lights of their own.
    pub fn of_surroundings(surroundings: &Surroundings) -> Self {
        // A spiral of directions with equal solid angles; a smooth gradient needs no more.
        const N: usize = 1024;
        Self::project(spiral(N).map(|d| (d, 4.0 * std::f64::consts::PI / N as f64, surroundings.gradient(d))))
    }

    /// An equirectangular panorama: row 0 is straight up (+Y), column 0 faces -Z turned by half a turn, so that the
    /// middle of the picture is at -Z and +X lies to the right of it.
    pub fn of_panorama(image: &Image<[f32; 4]>) -> Self {
        let (width, height) = (image.size.width, image.size.height);
        let columns: Vec<[f64; 2]> = (0..width).map(|x| panorama_azimuth(x as f64 + 0.5, width)).collect();
        Self::project((0..height).flat_map(|y| {
            let [low, high] = [y, y + 1].map(|e| std::f64::consts::PI * e as f64 / height as f64);
            let (sin, cos) = (exact::sin(0.5 * (low + high)), exact::cos(0.5 * (low + high)));
            let cell = (exact::cos(low) - exact::cos(high)) * 2.0 * std::f64::consts::PI / width as f64;
            columns.iter().zip(image.row(y)).map(move |(a, texel)| {
                let d = vec3((a[0] * sin) as f32, cos as f32, (a[1] * sin) as f32);
                (d, cell, [texel[0], texel[1], texel[2]])
            })
        }))
    }

    /// Six square faces, +X -X +Y -Y +Z -Z, seen from inside as glTF and OpenGL order and turn them.
    pub fn of_cube(faces: &[Image<[f32; 4]>; 6]) -> Self {
        Self::project(faces.iter().enumerate().flat_map(|(face, image)| {
            let n = image.size.width;
            (0..n * image.size.height).map(move |i| {
                let (x, y) = (i % n, i / n);
                let [u, v] = [x, y].map(|t| (2.0 * (t as f64 + 0.5) / n as f64 - 1.0) as f32);
                let texel = image.at(x, y);
                let squared = 1.0 + (u * u + v * v) as f64;
                // A texel's area over the cube of its distance.
                let solid_angle = 4.0 / (n as f64 * n as f64) / (squared * squared.sqrt());
                (cube_direction(face, u, v), solid_angle, [texel[0], texel[1], texel[2]])
            })
        }))
    }
}

/// The unit vector through a cube face at (u, v), both within [-1, 1], v down.
pub(super) fn cube_direction(face: usize, u: f32, v: f32) -> Vec3 {
    let d = match face {
        0 => vec3(1.0, -v, -u),
        1 => vec3(-1.0, -v, u),
        2 => vec3(u, 1.0, v),
        3 => vec3(u, -1.0, -v),
        4 => vec3(u, -v, 1.0),
        _ => vec3(-u, -v, -1.0),
    };
    d * (1.0 / d.length_squared().sqrt())
}

/// x and z on the unit circle for a column of a panorama.
fn panorama_azimuth(x: f64, width: u32) -> [f64; 2] {
    let angle = (x / width as f64 - 0.5) * 2.0 * std::f64::consts::PI;
    [exact::sin(angle), -exact::cos(angle)]
}

/// `n` directions with equal solid angles about each (Gonzalez, "Measurement of Areas on a Sphere Using Fibonacci and
/// Latitude-Longitude Lattices", 2010).
pub(super) fn spiral(n: usize) -> impl Iterator<Item = Vec3> {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    (0..n).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f64 / n as f64;
        let radius = (1.0 - z * z).sqrt();
        let angle = GOLDEN_ANGLE * i as f64;
        vec3((radius * exact::cos(angle)) as f32, (radius * exact::sin(angle)) as f32, z as f32)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Size;

    /// What a normal receives by its definition: radiance times clamped cosine over pi, summed.
    fn received(normal: Vec3, radiance: impl Fn(Vec3) -> f32) -> f32 {
        const N: usize = 40_000;
        let sum: f64 = spiral(N).map(|d| (radiance(d) * d.dot(normal).max(0.0)) as f64).sum();
        (sum * 4.0 / N as f64) as f32
    }

    #[test]
    fn nine_terms_agree_with_numeric_integration() {
        // Quadratic surroundings are within the nine terms: exact. A clamped lobe is not: within 3 % of its peak.
        let quadratic = |d: Vec3| 1.0 + 0.5 * d.y - 0.3 * d.x * d.z + 0.2 * (d.x * d.x - d.y * d.y) + 0.1 * d.z * d.z;
        let lobe = |d: Vec3| d.dot(vec3(0.6, 0.8, 0.0)).max(0.0);
        check("quadratic", quadratic, 2e-3);
        check("lobe", lobe, 0.03);

        fn check(name: &str, radiance: impl Fn(Vec3) -> f32 + Copy, tolerance: f32) {
            let solid_angle = 4.0 * std::f64::consts::PI / 40_000.0;
            let ambient = Ambient::project(spiral(40_000).map(|d| (d, solid_angle, [radiance(d); 3])));
            for normal in spiral(50) {
                let (got, wanted) = (ambient.at(normal)[1], received(normal, radiance));
                assert!((got - wanted).abs() < tolerance, "{name} {normal}: {got} not {wanted}");
            }
        }
    }

    #[test]
    fn even_pictures_give_even_light() {
        let panorama = Image::filled(Size::new(16, 8), [0.25, 0.5, 1.0, 1.0]);
        let faces = std::array::from_fn(|_| Image::filled(Size::new(32, 32), [0.25, 0.5, 1.0, 1.0]));
        for ambient in [Ambient::of_panorama(&panorama), Ambient::of_cube(&faces)] {
            for normal in spiral(20) {
                let got = ambient.at(normal);
                for (got, wanted) in got.into_iter().zip([0.25, 0.5, 1.0]) {
                    assert!((got / wanted - 1.0).abs() < 0.02, "{got} not {wanted}");
                }
            }
        }
    }

    #[test]
    fn pictures_light_the_side_they_show() {
        // Bright only in the upper half; and only on the right of the middle, which is +X.
        let up = Image::from_fn(Size::new(64, 32), |_, y| [(y < 16) as u32 as f32; 4]);
        let right = Image::from_fn(Size::new(64, 32), |x, _| [(x >= 32) as u32 as f32; 4]);
        assert!(Ambient::of_panorama(&up).at(Vec3::Y)[0] > 0.95 && Ambient::of_panorama(&up).at(Vec3::NEG_Y)[0] < 0.05);
        assert!(Ambient::of_panorama(&right).at(Vec3::X)[0] > 0.95);
        for (face, toward) in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].into_iter().enumerate()
        {
            let faces = std::array::from_fn(|f| Image::filled(Size::new(8, 8), [(f == face) as u32 as f32; 4]));
            let ambient = Ambient::of_cube(&faces);
            assert!(ambient.at(toward)[0] > 0.5 && ambient.at(-toward)[0] < 0.1, "face {face}");
        }
    }
}
