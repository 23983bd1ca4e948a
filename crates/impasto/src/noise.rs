//! Noise: smooth randomness in the plane and in space, the same bits everywhere.
//!
//! Gradient noise after Perlin, "Improving Noise", 2002, with its analytic gradient; cellular noise after Worley, "A
//! Cellular Texture Basis Function", 1996; sums of octaves (fractional Brownian motion, Mandelbrot and Van Ness 1968). The
//! lattice is hashed, not tabulated, so that it never repeats - or repeats exactly where a texture has to tile.

use crate::math::{Vec2, Vec3, floor, hash_cell, unit_float, vec2, vec3};

/// The integer lattice that noise hangs on: which randomness, and where it repeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// Another seed, another noise.
    pub seed: u32,
    /// Repeats after this many cells along x, y and z; 0 never does.
    pub period: [i32; 3],
}

impl Lattice {
    /// Never repeats.
    pub const fn seeded(seed: u32) -> Self {
        Self { seed, period: [0; 3] }
    }

    /// Repeats after `n` cells in all directions: what a texture that tiles needs.
    pub const fn tiled(seed: u32, n: i32) -> Self {
        Self { seed, period: [n; 3] }
    }

    /// The lattice of half the cell size, with other randomness: the next octave.
    pub const fn octave(self) -> Self {
        let [x, y, z] = self.period;
        Self { seed: self.seed.wrapping_add(0x9e37_79b9), period: [x * 2, y * 2, z * 2] }
    }

    #[inline(always)]
    fn hash(self, cell: [i32; 3]) -> u32 {
        let fold = |x: i32, n: i32| if n > 0 { x.rem_euclid(n) } else { x };
        let [x, y, z] = self.period;
        hash_cell(fold(cell[0], x), fold(cell[1], y), fold(cell[2], z), self.seed)
    }
}

/// A smooth function's value and how it changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smooth<V> {
    /// The value.
    pub value: f32,
    /// Its derivative by each coordinate of the point asked for.
    pub gradient: V,
}

/// Gradient noise in the plane: value in [-1, 1], mean 0, zero on lattice points, features about one unit wide.
pub fn gradient_2d(p: Vec2, lattice: Lattice) -> Smooth<Vec2> {
    let base = [floor(p.x), floor(p.y)];
    let f = p - Vec2::from(base);
    let (fade, slope) = (vec2(ease(f.x), ease(f.y)), vec2(ease_slope(f.x), ease_slope(f.y)));
    let corner = |dx: i32, dy: i32| {
        let cell = [(base[0] as i32).wrapping_add(dx), (base[1] as i32).wrapping_add(dy), 0];
        let g = direction_2d(lattice.hash(cell));
        (g.dot(f - vec2(dx as f32, dy as f32)), g)
    };
    let ((a, ga), (b, gb), (c, gc), (d, gd)) = (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1));
    let twist = a - b - c + d;
    let value = a + fade.x * (b - a) + fade.y * (c - a) + fade.x * fade.y * twist;
    let weighted = ga + (gb - ga) * fade.x + (gc - ga) * fade.y + (ga - gb - gc + gd) * (fade.x * fade.y);
    let change = vec2(slope.x * (b - a + fade.y * twist), slope.y * (c - a + fade.x * twist));
    // Unit gradients reach sqrt(2)/2 in the middle of a cell.
    Smooth { value: value * std::f32::consts::SQRT_2, gradient: (weighted + change) * std::f32::consts::SQRT_2 }
}

/// Gradient noise in space: value in [-1, 1], mean 0, zero on lattice points, features about one unit wide.
pub fn gradient_3d(p: Vec3, lattice: Lattice) -> Smooth<Vec3> {
    let base = [floor(p.x), floor(p.y), floor(p.z)];
    let f = p - Vec3::from(base);
    let fade = vec3(ease(f.x), ease(f.y), ease(f.z));
    let slope = vec3(ease_slope(f.x), ease_slope(f.y), ease_slope(f.z));
    let mut value = 0.0;
    let mut gradient = Vec3::ZERO;
    for corner in 0..8 {
        let d = [corner & 1, corner >> 1 & 1, corner >> 2];
        let cell = std::array::from_fn(|k| (base[k] as i32).wrapping_add(d[k]));
        let g = direction_3d(lattice.hash(cell));
        let height = g.dot(f - vec3(d[0] as f32, d[1] as f32, d[2] as f32));
        let weight = |k: usize| if d[k] == 1 { fade[k] } else { 1.0 - fade[k] };
        let change = |k: usize| if d[k] == 1 { slope[k] } else { -slope[k] };
        let (wx, wy, wz) = (weight(0), weight(1), weight(2));
        value += wx * wy * wz * height;
        gradient += g * (wx * wy * wz) + vec3(change(0) * wy * wz, change(1) * wx * wz, change(2) * wx * wy) * height;
    }
    // Perlin's edge directions reach 1.03635 a little off the middle of a cell.
    const SCALE: f32 = 0.964_92;
    Smooth { value: value * SCALE, gradient: gradient * SCALE }
}

/// The sum of `n_octaves` gradient noises in the plane, each twice as fine and `gain` times as strong as the one before,
/// scaled to [-1, 1].
pub fn fbm_2d(p: Vec2, n_octaves: u32, gain: f32, lattice: Lattice) -> Smooth<Vec2> {
    let mut sum = Smooth { value: 0.0, gradient: Vec2::ZERO };
    let (mut strength, mut total, mut scale, mut lattice) = (1.0, 0.0, 1.0, lattice);
    for _ in 0..n_octaves {
        let n = gradient_2d(p * scale, lattice);
        sum.value += strength * n.value;
        sum.gradient += n.gradient * (strength * scale);
        total += strength;
        (strength, scale, lattice) = (strength * gain, scale * 2.0, lattice.octave());
    }
    let norm = if total > 0.0 { 1.0 / total } else { 0.0 };
    Smooth { value: sum.value * norm, gradient: sum.gradient * norm }
}

/// The same in space.
pub fn fbm_3d(p: Vec3, n_octaves: u32, gain: f32, lattice: Lattice) -> Smooth<Vec3> {
    let mut sum = Smooth { value: 0.0, gradient: Vec3::ZERO };
    let (mut strength, mut total, mut scale, mut lattice) = (1.0, 0.0, 1.0, lattice);
    for _ in 0..n_octaves {
        let n = gradient_3d(p * scale, lattice);
        sum.value += strength * n.value;
        sum.gradient += n.gradient * (strength * scale);
        total += strength;
        (strength, scale, lattice) = (strength * gain, scale * 2.0, lattice.octave());
    }
    let norm = if total > 0.0 { 1.0 / total } else { 0.0 };
    Smooth { value: sum.value * norm, gradient: sum.gradient * norm }
}

/// The feature points around a place, one to a lattice cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cellular<V> {
    /// Distance to the nearest point: at most sqrt(2) in the plane, sqrt(3) in space.
    pub nearest: f32,
    /// Distance to the second nearest. Their difference is zero on the border between two cells.
    pub second: f32,
    /// From the place to the nearest point.
    pub to_nearest: V,
    /// A hash that belongs to the nearest point.
    pub id: u32,
}

/// Cellular noise in the plane. `jitter` moves the points off their cells' centres: 0 a square grid, 1 anywhere in the cell.
pub fn cellular_2d(p: Vec2, jitter: f32, lattice: Lattice) -> Cellular<Vec2> {
    let base = [floor(p.x), floor(p.y)];
    let f = p - Vec2::from(base);
    let mut found = Cellular { nearest: f32::INFINITY, second: f32::INFINITY, to_nearest: Vec2::ZERO, id: 0 };
    for &dy in &RINGS {
        for &dx in &RINGS {
            if squared_gap(dx, f.x) + squared_gap(dy, f.y) >= found.second {
                continue;
            }
            let h = lattice.hash([(base[0] as i32).wrapping_add(dx), (base[1] as i32).wrapping_add(dy), 0]);
            let to = vec2(dx as f32, dy as f32) + vec2(feature(h, 0, jitter), feature(h, 1, jitter)) - f;
            found.take(to.length_squared(), to, h);
        }
    }
    found.rooted()
}

/// Cellular noise in space. `jitter` moves the points off their cells' centres: 0 a cubic grid, 1 anywhere in the cell.
pub fn cellular_3d(p: Vec3, jitter: f32, lattice: Lattice) -> Cellular<Vec3> {
    let base = [floor(p.x), floor(p.y), floor(p.z)];
    let f = p - Vec3::from(base);
    let mut found = Cellular { nearest: f32::INFINITY, second: f32::INFINITY, to_nearest: Vec3::ZERO, id: 0 };
    for &dz in &RINGS {
        for &dy in &RINGS {
            for &dx in &RINGS {
                if squared_gap(dx, f.x) + squared_gap(dy, f.y) + squared_gap(dz, f.z) >= found.second {
                    continue;
                }
                let d = [dx, dy, dz];
                let h = lattice.hash(std::array::from_fn(|k| (base[k] as i32).wrapping_add(d[k])));
                let point = vec3(feature(h, 0, jitter), feature(h, 1, jitter), feature(h, 2, jitter));
                let to = vec3(dx as f32, dy as f32, dz as f32) + point - f;
                found.take(to.length_squared(), to, h);
            }
        }
    }
    found.rooted()
}

/// Neighbour cells, the likely ones first, so that the rest is skipped.
const RINGS: [i32; 5] = [0, 1, -1, 2, -2];

/// Squared distance along one axis from `f` in [0, 1) to the cell `d` cells away.
#[inline(always)]
fn squared_gap(d: i32, f: f32) -> f32 {
    let gap = match d {
        0 => 0.0,
        d if d > 0 => d as f32 - f,
        d => f - (d + 1) as f32,
    };
    gap * gap
}

/// Where along axis `k` a cell's point lies in it.
#[inline(always)]
fn feature(h: u32, k: u32, jitter: f32) -> f32 {
    0.5 + (unit_float(crate::math::hash(h.wrapping_add(k))) - 0.5) * jitter
}

impl<V> Cellular<V> {
    #[inline(always)]
    fn take(&mut self, squared: f32, to: V, id: u32) {
        if squared < self.nearest {
            (self.second, self.nearest, self.to_nearest, self.id) = (self.nearest, squared, to, id);
        } else if squared < self.second {
            self.second = squared;
        }
    }

    fn rooted(self) -> Self {
        Self { nearest: self.nearest.sqrt(), second: self.second.sqrt(), ..self }
    }
}

/// From 0 to 1 with vanishing first and second derivative at both ends.
#[inline(always)]
fn ease(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[inline(always)]
fn ease_slope(t: f32) -> f32 {
    30.0 * t * t * (t * (t - 2.0) + 1.0)
}

/// One of sixteen unit vectors, evenly around the circle.
#[inline(always)]
fn direction_2d(h: u32) -> Vec2 {
    // Cosines of 11.25, 33.75, 56.25 and 78.75 degrees: no direction lies along an axis, which would show.
    const COS: [f32; 4] = [0.980_785_3, 0.831_469_6, 0.555_570_2, 0.195_090_3];
    let (c, s) = (COS[(h >> 28 & 3) as usize], COS[3 - (h >> 28 & 3) as usize]);
    vec2(if h >> 30 & 1 == 0 { c } else { -c }, if h >> 31 == 0 { s } else { -s })
}

/// One of the twelve directions to a cube's edges; length sqrt(2).
#[inline(always)]
fn direction_3d(h: u32) -> Vec3 {
    let sign = |bit: u32| if h >> bit & 1 == 0 { 1.0 } else { -1.0 };
    let (a, b) = (sign(30), sign(31));
    // 2^28 / 3 divides the upper bits evenly enough: no direction differs from another by more than 1e-8.
    match (h & 0x0fff_ffff) / 89_478_486 {
        0 => vec3(a, b, 0.0),
        1 => vec3(a, 0.0, b),
        _ => vec3(0.0, a, b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(i: i32, k: i32) -> f32 {
        unit_float(hash_cell(i, k, 0, 5)) * 20.0 - 10.0
    }

    #[test]
    fn gradients_are_those_of_the_values() {
        let l = Lattice::seeded(3);
        let h = 1e-2;
        for i in 0..500 {
            let p = vec2(random(i, 0), random(i, 1));
            let slope = |d: Vec2| (fbm_2d(p + d, 3, 0.5, l).value - fbm_2d(p - d, 3, 0.5, l).value) / (2.0 * h);
            let truth = vec2(slope(vec2(h, 0.0)), slope(vec2(0.0, h)));
            assert!((fbm_2d(p, 3, 0.5, l).gradient - truth).length() < 0.02, "at {p}");
            let p = vec3(p.x, p.y, random(i, 2));
            let slope = |d: Vec3| (fbm_3d(p + d, 3, 0.5, l).value - fbm_3d(p - d, 3, 0.5, l).value) / (2.0 * h);
            let truth = vec3(slope(Vec3::X * h), slope(Vec3::Y * h), slope(Vec3::Z * h));
            assert!((fbm_3d(p, 3, 0.5, l).gradient - truth).length() < 0.02, "at {p}");
        }
    }

    #[test]
    fn values_stay_in_their_range_and_use_it() {
        let l = Lattice::seeded(7);
        let (mut low, mut high, mut sum) = ([0f32; 2], [0f32; 2], [0f64; 2]);
        for i in 0..40_000 {
            let p = vec3(random(i, 0), random(i, 1), random(i, 2)) * 9.0;
            for (k, n) in [gradient_2d(vec2(p.x, p.y), l).value, gradient_3d(p, l).value].into_iter().enumerate() {
                (low[k], high[k]) = (low[k].min(n), high[k].max(n));
                sum[k] += n as f64;
            }
        }
        for k in 0..2 {
            assert!(low[k] >= -1.0 && high[k] <= 1.0 && low[k] < -0.75 && high[k] > 0.75, "{low:?} {high:?}");
            assert!((sum[k] / 40_000.0).abs() < 0.02, "mean {}", sum[k] / 40_000.0);
        }
    }

    #[test]
    fn tiled_noise_repeats_exactly() {
        let l = Lattice::tiled(1, 4);
        for i in 0..200 {
            // Multiples of 1/64, so that adding the period loses no bit.
            let p = vec3(random(i, 0), random(i, 1), random(i, 2));
            let p = vec3(floor(p.x * 64.0), floor(p.y * 64.0), floor(p.z * 64.0)) / 64.0;
            assert_eq!(fbm_3d(p, 3, 0.5, l), fbm_3d(p + vec3(4.0, -8.0, 12.0), 3, 0.5, l));
            let (a, b) = (vec2(p.x, p.y), vec2(p.x - 4.0, p.y + 4.0));
            assert_eq!(fbm_2d(a, 3, 0.5, l), fbm_2d(b, 3, 0.5, l));
            assert_eq!(cellular_2d(a, 1.0, l), cellular_2d(b, 1.0, l));
        }
    }

    #[test]
    fn cellular_noise_agrees_with_looking_at_every_point() {
        let l = Lattice::seeded(11);
        for i in 0..300 {
            let p = vec3(random(i, 0), random(i, 1), random(i, 2));
            let (mut flat, mut deep) = (Vec::new(), Vec::new());
            for z in -4..=4 {
                for y in -4..=4 {
                    for x in -4..=4 {
                        let c = [floor(p.x) as i32 + x, floor(p.y) as i32 + y, floor(p.z) as i32 + z];
                        let at = |c: [i32; 3], k: usize| c[k] as f32 + feature(l.hash(c), k as u32, 0.9);
                        deep.push(vec3(at(c, 0), at(c, 1), at(c, 2)).distance(p));
                        let c = [c[0], c[1], 0];
                        if z == 0 {
                            flat.push(vec2(at(c, 0), at(c, 1)).distance(vec2(p.x, p.y)));
                        }
                    }
                }
            }
            flat.sort_by(f32::total_cmp);
            deep.sort_by(f32::total_cmp);
            let (a, b) = (cellular_2d(vec2(p.x, p.y), 0.9, l), cellular_3d(p, 0.9, l));
            for (got, truth) in [(a.nearest, flat[0]), (a.second, flat[1]), (b.nearest, deep[0]), (b.second, deep[1])] {
                assert!((got - truth).abs() < 1e-5, "{got} not {truth} at {p}");
            }
        }
    }
}
