//! Words everyone uses: vectors, sizes, rays, frames, and elementary functions that give the same bits everywhere.
//!
//! The platform's `sin`, `pow` and `exp` differ between systems, so nothing that reaches a picture may call them. Set-up
//! code uses the f64 functions re-exported in [`exact`]; per-pixel code the f32 polynomials [`exp2`], [`log2`],
//! [`pow`], [`sin_cos`], [`atan2`], [`acos`].

pub use glam::{
    DMat3, DMat4, DVec2, DVec3, DVec4, IVec2, Mat3, Mat4, UVec2, Vec2, Vec3, Vec4, dvec3, vec2, vec3, vec4,
};

/// How many cells a batch holds at most: shading runs as short passes over this many numbers at a time.
pub const BATCH: usize = 256;

/// One number for each cell of a batch. Entries past the batch's count are stale and must not matter.
pub type Lane = [f32; BATCH];

/// Width and height of a grid of cells: pixels or texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Size {
    /// Cells in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Size {
    /// A grid of `width` x `height` cells.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// How many cells there are.
    pub const fn n_cells(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Width over height.
    pub fn aspect(self) -> f32 {
        self.width as f32 / self.height as f32
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// A half line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes; need not be a unit vector.
    pub direction: Vec3,
}

/// An axis-aligned box; empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// Holds nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Whether it holds no point at all.
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// The point in its middle; the origin for an empty box.
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { (self.min + self.max) * 0.5 }
    }

    /// Edge lengths; zero for an empty box.
    pub fn extent(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// Half the diagonal.
    pub fn radius(&self) -> f32 {
        self.extent().length() * 0.5
    }

    /// The eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f32, hi: f32| if i >> bit & 1 == 0 { lo } else { hi };
            vec3(pick(0, self.min.x, self.max.x), pick(1, self.min.y, self.max.y), pick(2, self.min.z, self.max.z))
        })
    }
}

/// How a camera's view volume is shaped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Lines of sight meet in the eye.
    Perspective {
        /// Full vertical field of view, radians.
        fov_y: f32,
    },
    /// Lines of sight are parallel.
    Orthographic {
        /// Height of the view, model units.
        height: f32,
    },
}

/// A right-handed orthonormal basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First axis.
    pub tangent: Vec3,
    /// Second axis.
    pub bitangent: Vec3,
    /// Third axis.
    pub normal: Vec3,
}

impl Frame {
    /// Some frame about a unit normal, continuous but at -Z (Duff et al., "Building an Orthonormal Basis, Revisited", 2017).
    pub fn about(normal: Vec3) -> Self {
        let sign = if normal.z >= 0.0 { 1.0 } else { -1.0 };
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: vec3(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: vec3(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }
}

/// `v` as a unit vector, or `fallback` when it is too short or not finite. Plain `* / sqrt`, the same bits everywhere.
#[inline(always)]
pub fn unit_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let squared = v.x * v.x + v.y * v.y + v.z * v.z;
    if squared > 1e-30 && squared < f32::INFINITY { v * (1.0 / squared.sqrt()) } else { fallback }
}

/// `[T; N]::map` that is always inlined. The library's may stay a call, and a SIMD kernel that calls leaves its
/// instruction set behind.
pub(crate) trait Each<T>: Sized {
    /// The array with other elements.
    type Of<U>;
    /// `f` of each element.
    fn each<U>(self, f: impl FnMut(T) -> U) -> Self::Of<U>;
}

/// `f` itself: gives a closure that is kept in a variable the place where stable Rust takes `#[inline(always)]`.
#[inline(always)]
pub(crate) fn kernel<F>(f: F) -> F {
    f
}

macro_rules! each {
    ($n:literal, $($x:ident),*) => {
        impl<T> Each<T> for [T; $n] {
            type Of<U> = [U; $n];
            #[inline(always)]
            fn each<U>(self, mut f: impl FnMut(T) -> U) -> [U; $n] {
                let [$($x),*] = self;
                [$(f($x)),*]
            }
        }
    };
}
each!(2, a, b);
each!(3, a, b, c);
each!(4, a, b, c, d);

/// Elementary functions in f64 for set-up code: written in Rust, the same bits everywhere (crate `libm`).
pub mod exact {
    pub use libm::{acos, asin, atan, atan2, cbrt, cos, exp, exp2, log, log2, log10, pow, sin, tan};
}

/// Base-2 exponential, relative error below 3e-7 for results in the normal range; saturates outside of it.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    let x = if x < -126.0 { -126.0 } else { x };
    let x = if x > 126.999 { 126.999 } else { x };
    // Split into an integer and a fraction in [-0.5, 0.5]: adding 1.5 * 2^23 rounds to the nearest integer.
    let rounded = (x + 12582912.0) - 12582912.0;
    let f = x - rounded;
    let p = 1.540353e-4_f32;
    let p = p * f + 1.333356e-3;
    let p = p * f + 9.618129e-3;
    let p = p * f + 5.550411e-2;
    let p = p * f + 2.402265e-1;
    let p = p * f + 6.931472e-1;
    let p = p * f + 1.0;
    let scale = f32::from_bits(((rounded as i32 + 127) as u32) << 23);
    p * scale
}

/// Base-2 logarithm of a positive number, absolute error below 2e-7 near 1, relative 2e-7 elsewhere; -127 for zero and below.
#[inline(always)]
pub fn log2(x: f32) -> f32 {
    let x = if x > f32::MIN_POSITIVE { x } else { f32::MIN_POSITIVE * 0.5 };
    let bits = x.to_bits();
    // Mantissa in [sqrt(1/2), sqrt(2)): the offset moves the split there.
    let shifted = bits.wrapping_sub(0x3f35_04f3);
    let exponent = (shifted as i32) >> 23;
    let m = f32::from_bits(bits.wrapping_sub((exponent as u32) << 23));
    // log2(m) = 2/ln 2 * atanh((m-1)/(m+1)), |s| < 0.1716.
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let p = 0.412_198_6_f32;
    let p = p * z + 0.577_078_04;
    let p = p * z + 0.961_796_7;
    let p = p * z + 2.885_39;
    exponent as f32 + s * p
}

/// `x` to the power of `y` for x >= 0; 0 for x <= 0. Relative error below 1e-5 for |y| up to 64.
#[inline(always)]
pub fn pow(x: f32, y: f32) -> f32 {
    if x <= 0.0 { 0.0 } else { exp2(y * log2(x)) }
}

/// Sine and cosine of `x` radians, absolute error below 2e-7 for |x| up to 8192; worse beyond, but always within [-1, 1].
#[inline(always)]
pub fn sin_cos(x: f32) -> (f32, f32) {
    let x = if x > -4e6 { x } else { -4e6 };
    let x = if x < 4e6 { x } else { 4e6 };
    // x = k pi/2 + r. Adding 1.5 * 2^23 rounds to the nearest integer; pi/2 in three parts, so that k times the first
    // two is exact (Cody and Waite, "Software Manual for the Elementary Functions", 1980).
    let k = (x * std::f32::consts::FRAC_2_PI + 12582912.0) - 12582912.0;
    let r = ((x - k * 1.5703125) - k * 4.837_513e-4) - k * 7.549_790e-8;
    let z = r * r;
    let sin = r + r * z * (-0.166_666_67 + z * (8.333_332e-3 + z * (-1.984_008_7e-4 + z * 2.724_99e-6)));
    let cos = 1.0 - 0.5 * z + z * z * (4.166_666_4e-2 + z * (-1.388_830_2e-3 + z * 2.454_791_7e-5));
    let quadrant = k as i32;
    let (s, c) = if quadrant & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let s = if quadrant & 2 == 0 { s } else { -s };
    let c = if (quadrant + 1) & 2 == 0 { c } else { -c };
    (clamp_unit(s), clamp_unit(c))
}

/// `x` within [-1, 1].
#[inline(always)]
fn clamp_unit(x: f32) -> f32 {
    let x = if x > -1.0 { x } else { -1.0 };
    if x < 1.0 { x } else { 1.0 }
}

/// The angle of the point (`x`, `y`) from +x towards +y, in [-pi, pi], absolute error below 4e-7; 0 for the origin.
/// On the negative x axis +pi, whatever the sign of a zero `y`.
#[inline(always)]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay > ax;
    let (low, high) = if steep { (ax, ay) } else { (ay, ax) };
    // atan(q) = pi/4 + atan((q - 1) / (q + 1)) brings the argument below tan(pi/8).
    let far = low > 0.414_213_57 * high;
    let numerator = if far { low - high } else { low };
    let denominator = if far { low + high } else { high };
    let denominator = if denominator > 0.0 { denominator } else { 1.0 };
    let q = numerator / denominator;
    let z = q * q;
    let p = -0.333_333_3 + z * (0.199_995_4 + z * (-0.142_639_55 + z * (0.107_437_25 + z * -6.451_907e-2)));
    let angle = q + q * z * p;
    let angle = if far { angle + std::f32::consts::FRAC_PI_4 } else { angle };
    let angle = if steep { std::f32::consts::FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { std::f32::consts::PI - angle } else { angle };
    if y < 0.0 { -angle } else { angle }
}

/// The angle whose cosine is `x` (clamped to [-1, 1]), in [0, pi], absolute error below 4e-7.
#[inline(always)]
pub fn acos(x: f32) -> f32 {
    let x = clamp_unit(x);
    atan2(((1.0 - x) * (1.0 + x)).sqrt(), x)
}

/// The largest integer not above `x`, for |x| below 2^22; beyond that, where fractions end, `x` itself. Faster than the
/// library's without SSE4.1, and vectors of it need no conversion to integers and back.
#[inline(always)]
pub fn floor(x: f32) -> f32 {
    // Adding 1.5 * 2^23 rounds to the nearest integer.
    let nearest = (x + 12_582_912.0) - 12_582_912.0;
    let below = if nearest > x { nearest - 1.0 } else { nearest };
    if x.abs() < 4_194_304.0 { below } else { x }
}

/// Mixes an integer thoroughly: all output bits depend on all input bits (Wellons' lowbias32).
#[inline(always)]
pub const fn hash(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A hash of a lattice cell and a seed, the only source of randomness in the engine.
#[inline(always)]
pub const fn hash_cell(x: i32, y: i32, z: i32, seed: u32) -> u32 {
    hash(x as u32 ^ hash(y as u32 ^ hash(z as u32 ^ hash(seed))))
}

/// A hash's upper 24 bits as a number in [0, 1).
#[inline(always)]
pub const fn unit_float(hash: u32) -> f32 {
    (hash >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp2_and_log2_are_close_to_the_truth() {
        for i in -2000..2000 {
            let x = i as f32 * 0.05;
            let truth = exact::exp2(x as f64);
            assert!(((exp2(x) as f64 - truth) / truth).abs() < 4e-7, "exp2({x}) = {} not {truth}", exp2(x));
        }
        for i in 1..20000 {
            let x = i as f32 * 0.01;
            let truth = exact::log2(x as f64);
            assert!(
                (log2(x) as f64 - truth).abs() < 6e-7 * truth.abs().max(1.0),
                "log2({x}) = {} not {truth}",
                log2(x)
            );
        }
    }

    #[test]
    fn angles_are_close_to_the_truth_all_around() {
        for i in -4000..=4000 {
            let x = i as f32 * 0.0137;
            let (s, c) = sin_cos(x);
            assert!((s as f64 - exact::sin(x as f64)).abs() < 2e-7, "sin({x}) = {s}");
            assert!((c as f64 - exact::cos(x as f64)).abs() < 2e-7, "cos({x}) = {c}");
            let big = i as f32 * 2.0471;
            assert!((sin_cos(big).0 as f64 - exact::sin(big as f64)).abs() < 2e-7, "sin({big})");
            for length in [1e-20, 1.0, 1e20] {
                let truth = exact::atan2((s * length) as f64, (c * length) as f64);
                let got = atan2(s * length, c * length);
                assert!((got as f64 - truth).abs() < 4e-7, "atan2({s}, {c}) * {length} = {got} not {truth}");
            }
            let cosine = i as f32 / 4000.0;
            assert!((acos(cosine) as f64 - exact::acos(cosine as f64)).abs() < 4e-7, "acos({cosine})");
        }
        assert_eq!((atan2(0.0, 0.0), atan2(-0.0, -1.0), acos(2.0)), (0.0, std::f32::consts::PI, 0.0));
        assert!([f32::NAN, f32::INFINITY, -1e30].iter().all(|&x| sin_cos(x).0.abs() <= 1.0));
    }

    #[test]
    fn floor_is_the_librarys() {
        for i in 0..100_000 {
            let x = (unit_float(hash(i)) - 0.5) * [2.0, 300.0, 8e6][i as usize % 3];
            assert_eq!(floor(x), x.floor(), "{x}");
        }
        for x in [0.0, -0.5, 0.5, 1.0, -1.0, 1.5, -1.5, 4194303.5, -4194303.5, 1e20, f32::INFINITY] {
            assert_eq!(floor(x), x.floor(), "{x}");
        }
        assert!(floor(f32::NAN).is_nan());
    }

    #[test]
    fn frames_are_orthonormal_everywhere() {
        for i in 0..1000 {
            let f = |s| unit_float(hash_cell(i, 0, 0, s)) * 2.0 - 1.0;
            let frame = Frame::about(unit_or(vec3(f(1), f(2), f(3)), Vec3::Z));
            assert!(frame.tangent.dot(frame.normal).abs() < 1e-5 && frame.bitangent.dot(frame.normal).abs() < 1e-5);
            assert!((frame.tangent.cross(frame.bitangent) - frame.normal).length() < 1e-5);
        }
    }
}
