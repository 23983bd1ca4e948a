//! Textures by formula, at any resolution: stripes, checker, noise, cells, wood, marble.
//!
//! Each is a number in [0, 1] at (s, t, r), shown between two colours. Nothing aliases: stripes and checker are integrated
//! over the footprint, octaves of noise fade out before a cell is half their wavelength wide, the others fade to their mean.

use crate::color::LinearRgba;
use crate::lookup::Reading;
use crate::math::{floor, hash_cell, unit_float};
use crate::placement::TexCoords;

/// A texture by formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Procedural {
    /// What is drawn.
    pub pattern: Pattern,
    /// Repetitions, or features, in one unit of each coordinate.
    pub frequency: [f32; 3],
    /// Colours of 0 and of 1.
    pub colors: [LinearRgba; 2],
    /// Another seed is another texture of the same kind.
    pub seed: u32,
}

/// What a procedural texture draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// Bands across s: the first `share` of each repetition is 1.
    Stripes {
        /// 0 to 1.
        share: f32,
    },
    /// Squares in s and t, cubes if r changes.
    Checker,
    /// Sum of octaves of gradient noise (Perlin 1985, "An image synthesizer"; 2002), each of half the size and `gain`
    /// times the height of the one before.
    Noise {
        /// 1 to 16.
        octaves: u32,
        /// Usually 0.5.
        gain: f32,
    },
    /// Distance to the nearest of scattered points (Worley 1996).
    Cells,
    /// Rings about the r axis, bent by noise.
    Wood {
        /// How much, in ring widths.
        bend: f32,
    },
    /// Veins across s, bent by several octaves of noise.
    Marble {
        /// How much, in vein distances.
        bend: f32,
    },
}

impl Procedural {
    #[inline(always)]
    pub(super) fn read(&self, at: &TexCoords, n: usize, out: &mut Reading) {
        out.is_whole = true;
        let [a, b] = self.colors;
        for i in 0..n {
            let d = [[at.d_dx[0][i], at.d_dx[1][i], at.r[1][i]], [at.d_dy[0][i], at.d_dy[1][i], at.r[2][i]]];
            let value = self.value([at.st[0][i], at.st[1][i], at.r[0][i]], d);
            (0..4).for_each(|c| out.rgba[c][i] = a[c] + (b[c] - a[c]) * value);
        }
    }

    /// The number at a point, averaged over the footprint that its changes `d` right and down span.
    pub fn value(&self, p: [f32; 3], d: [[f32; 3]; 2]) -> f32 {
        let p: [f32; 3] = std::array::from_fn(|a| bounded(p[a] * self.frequency[a]));
        // How far each coordinate moves from cell to cell, in features.
        let widths: [f32; 3] = std::array::from_fn(|a| {
            let [dx, dy] = d.map(|d| bounded(d[a] * self.frequency[a]).abs());
            if dx > dy { dx } else { dy }
        });
        let width = (widths[0] * widths[0] + widths[1] * widths[1] + widths[2] * widths[2]).sqrt();
        match self.pattern {
            Pattern::Stripes { share } => pulse_mean(p[0], widths[0], if share < 1.0 { share.max(0.0) } else { 1.0 }),
            Pattern::Checker => {
                let wave = |a: usize| 2.0 * pulse_mean(p[a] * 0.5, widths[a] * 0.5, 0.5) - 1.0;
                0.5 - 0.5 * wave(0) * wave(1) * wave(2)
            }
            Pattern::Noise { octaves, gain } => 0.5 + 0.5 * self.octaves(p, width, octaves.min(16), gain),
            Pattern::Cells => mixed(CELLS_MEAN, nearest_point(p, self.seed), presence(width)),
            Pattern::Wood { bend } => {
                let around = [p[0] * 0.5, p[1] * 0.5, p[2] * 0.5];
                let ring = (p[0] * p[0] + p[1] * p[1]).sqrt() + bend * self.octaves(around, width, 2, 0.5);
                // Early wood grows slowly darker, late wood ends abruptly.
                let phase = ring - floor(ring);
                let grain = phase * phase * (3.0 - 2.0 * phase) * step_down(phase, 0.92);
                mixed(WOOD_MEAN, grain, presence(width * (1.0 + bend)))
            }
            Pattern::Marble { bend } => {
                let vein = p[0] + bend * self.octaves(p, width, 6, 0.5);
                let phase = (vein - floor(vein)) * 2.0 - 1.0;
                mixed(1.0 / 3.0, phase * phase, presence(width * (1.0 + bend)))
            }
        }
    }

    /// About -1 to 1, mean 0.
    fn octaves(&self, p: [f32; 3], width: f32, octaves: u32, gain: f32) -> f32 {
        let (mut sum, mut total, mut height, mut scale) = (0.0, 0.0, 1.0, 1.0);
        for octave in 0..octaves {
            let present = presence(width * scale);
            if present > 0.0 {
                let seed = self.seed.wrapping_add(octave);
                sum += height * present * gradient_noise(p.map(|x| bounded(x * scale)), seed);
            }
            total += height;
            height *= gain;
            scale *= 2.0;
        }
        if total > 0.0 { sum / total } else { 0.0 }
    }
}

/// Means over all space, for where a cell covers many features; measured by the test below.
const CELLS_MEAN: f32 = 0.520;
const WOOD_MEAN: f32 = 0.4615;

/// Hash cells are i32: coordinates beyond 2^22, where f32 has no fraction left to speak of, and NaN become 0.
fn bounded(x: f32) -> f32 {
    if x.abs() < 4_194_304.0 { x } else { 0.0 }
}

fn mixed(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// How much of a feature is left: all while a cell is at most a quarter of it wide, nothing from three quarters on.
fn presence(width: f32) -> f32 {
    let x = 1.5 - 2.0 * width;
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < 1.0 { x } else { 1.0 };
    x * x * (3.0 - 2.0 * x)
}

/// 1 before `edge`, falling to 0 at 1.
fn step_down(x: f32, edge: f32) -> f32 {
    if x < edge { 1.0 } else { (1.0 - x) / (1.0 - edge) }
}

/// The mean of the pulse train that is 1 for the first `share` of each unit, over `width` about x.
fn pulse_mean(x: f32, width: f32, share: f32) -> f32 {
    // Below a width of 1e-3 of a repetition the integral's differences would lose their digits.
    let width = if width > 1e-3 { width } else { 1e-3 };
    let start = floor(x - 0.5 * width);
    let integral = |x: f32| {
        let x = x - start;
        let whole = floor(x);
        let part = x - whole;
        whole * share + if part < share { part } else { share }
    };
    let mean = (integral(x + 0.5 * width) - integral(x - 0.5 * width)) / width;
    let mean = if mean > 0.0 { mean } else { 0.0 };
    if mean < 1.0 { mean } else { 1.0 }
}

/// Gradient noise with quintic fade, within [-1, 1], zero at lattice points.
fn gradient_noise(p: [f32; 3], seed: u32) -> f32 {
    let cell = p.map(floor);
    let f: [f32; 3] = std::array::from_fn(|a| p[a] - cell[a]);
    let fade = f.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let [x, y, z] = cell.map(|c| c as i32);
    let corner = |i: i32, j: i32, k: i32| {
        let hash = hash_cell(x + i, y + j, z + k, seed);
        let (dx, dy, dz) = (f[0] - i as f32, f[1] - j as f32, f[2] - k as f32);
        // The twelve edges of a cube, four of them twice.
        let h = hash & 15;
        let u = if h < 8 { dx } else { dy };
        let v = if h < 4 {
            dy
        } else if h == 12 || h == 14 {
            dx
        } else {
            dz
        };
        (if h & 1 == 0 { u } else { -u }) + (if h & 2 == 0 { v } else { -v })
    };
    let along_x = |j, k| mixed(corner(0, j, k), corner(1, j, k), fade[0]);
    let along_y = |k| mixed(along_x(0, k), along_x(1, k), fade[1]);
    mixed(along_y(0), along_y(1), fade[2])
}

/// Distance to the nearest point, one point a cell; at most 1.
fn nearest_point(p: [f32; 3], seed: u32) -> f32 {
    let cell = p.map(floor);
    let [x, y, z] = cell.map(|c| c as i32);
    let mut least = 1.0;
    for k in -1..=1 {
        for j in -1..=1 {
            for i in -1..=1 {
                let hash = hash_cell(x + i, y + j, z + k, seed);
                let point = |step: i32, salt: u32| step as f32 + unit_float(crate::math::hash(hash ^ salt));
                let d = [point(i, 1), point(j, 2), point(k, 3)];
                let d: [f32; 3] = std::array::from_fn(|a| d[a] - (p[a] - cell[a]));
                let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                least = if squared < least { squared } else { least };
            }
        }
    }
    least.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patterns() -> [Pattern; 6] {
        [
            Pattern::Stripes { share: 0.3 },
            Pattern::Checker,
            Pattern::Noise { octaves: 5, gain: 0.5 },
            Pattern::Cells,
            Pattern::Wood { bend: 0.6 },
            Pattern::Marble { bend: 1.5 },
        ]
    }

    fn texture(pattern: Pattern) -> Procedural {
        Procedural { pattern, frequency: [1.0; 3], colors: [[0.0; 4], [1.0; 4]], seed: 7 }
    }

    fn point(i: i32) -> [f32; 3] {
        [1, 2, 3].map(|s| unit_float(hash_cell(i, 0, 0, s)) * 40.0 - 20.0)
    }

    #[test]
    fn wide_footprints_give_the_mean_and_all_values_are_in_range() {
        for pattern in patterns() {
            let texture = texture(pattern);
            let sharp: Vec<f32> = (0..40_000).map(|i| texture.value(point(i), [[0.0; 3]; 2])).collect();
            assert!(sharp.iter().all(|v| (0.0..=1.0).contains(v)), "{pattern:?}");
            let mean = sharp.iter().sum::<f32>() / sharp.len() as f32;
            let wide = texture.value(point(1), [[400.0, 0.0, 400.0], [0.0, 400.0, 400.0]]);
            assert!((mean - wide).abs() < 0.02, "{pattern:?}: mean {mean}, wide {wide}");
        }
    }

    #[test]
    fn stripes_are_integrated_exactly() {
        for (x, width, share) in [(0.3, 0.5, 0.4), (7.9, 3.3, 0.25), (-2.2, 0.01, 0.5), (0.0, 0.2, 0.7)] {
            let n = 20_000;
            let inside = (0..n).filter(|k| {
                let y = x + width * ((*k as f64 + 0.5) / n as f64 - 0.5);
                y - y.floor() < share
            });
            let truth = inside.count() as f64 / n as f64;
            let got = pulse_mean(x as f32, width as f32, share as f32) as f64;
            assert!((got - truth).abs() < 1e-3, "{x} {width}: {got} not {truth}");
        }
    }

    #[test]
    fn strange_coordinates_give_a_number_in_range() {
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e9, -1e9, 1e-40, 0.0];
        for pattern in patterns() {
            for i in 0..512 {
                let pick = |k: usize| odd[(i >> (3 * k)) & 7];
                let value = texture(pattern).value([pick(0), pick(1), pick(2)], [[pick(2), pick(0), pick(1)]; 2]);
                assert!((0.0..=1.0).contains(&value), "{pattern:?} {value}");
            }
        }
    }
}
