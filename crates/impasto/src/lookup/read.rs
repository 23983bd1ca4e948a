//! Texture coordinates to texel values: wrap, choose levels, fetch, filter.
//!
//! Short passes over a batch: size the footprints, then fold the coordinates, fetch and filter. 8-bit linear planes read
//! isotropically by bilinear filters have a path of their own in integers (`packed`); all else is filtered in f32.
//! sRGB bytes are decoded by table before they are filtered.

use crate::assets::{Filter, MinFilter, Wrap};
use crate::color::LINEAR_FROM_SRGB8;
use crate::lookup::footprint::{self, Footprints};
use crate::lookup::packed::{self, Packed};
use crate::lookup::texture::{ImageTexture, Level, Shape, Store, cube_face, float_from_half};
use crate::math::{BATCH, Lane, floor, kernel};
use crate::placement::TexCoords;
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdInto, f32x4, f32x8};

/// What a texture says at each point of a batch.
#[derive(Clone)]
pub struct Reading {
    /// Red, green, blue and alpha as filtered: linear light for sRGB images, the numbers themselves otherwise.
    pub rgba: [Lane; 4],
    /// 1 where the texture is applied, 0 outside of a `ClampToBorder` one; only valid unless `is_whole`.
    pub applied: Lane,
    /// The texture is applied at all points.
    pub is_whole: bool,
}

impl Reading {
    /// All zero.
    pub const ZERO: Self = Self { rgba: [[0.0; BATCH]; 4], applied: [1.0; BATCH], is_whole: true };
}

/// Room for what passes hand to each other.
pub(super) struct ReadScratch {
    footprints: Footprints,
    packed: Packed,
}

impl ReadScratch {
    pub(super) const ZERO: Self = Self { footprints: Footprints::ZERO, packed: Packed::ZERO };
}

impl ImageTexture {
    /// Reads the texture at `n` points, each by its own coordinates and footprint.
    #[inline(always)]
    pub(super) fn read<S: Simd>(
        &self,
        simd: S,
        at: &TexCoords,
        n: usize,
        scratch: &mut ReadScratch,
        out: &mut Reading,
    ) {
        self.mark_applied(at, n, out);
        if let (Store::Unorm8(texels), true) = (&self.store, packed::suits(self)) {
            simd.vectorize(
                #[inline(always)]
                || packed::read(simd, (self, texels), at, n, (&mut scratch.packed, &mut out.rgba)),
            );
            return;
        }
        simd.vectorize(
            #[inline(always)]
            || match self.is_anisotropic() {
                true => footprint::anisotropic(simd, self, at, n, &mut scratch.footprints),
                false => {
                    footprint::isotropic(simd, self, at, n, &mut scratch.footprints);
                    scratch.footprints.n_taps[..n].fill(1.0);
                }
            },
        );
        let feet = &scratch.footprints;
        let table: &'static [f32; 256] = &LINEAR_FROM_SRGB8;
        match &self.store {
            Store::Srgb8(texels) => self.read_floats(simd, (texels, |t| srgb8(table, t)), (at, feet), n, out),
            Store::Unorm8(texels) => self.read_floats(simd, (texels, unorm8), (at, feet), n, out),
            Store::Unorm16(texels) => self.read_floats(simd, (texels, unorm16), (at, feet), n, out),
            Store::Half(texels) => {
                self.read_floats(simd, (texels, |t: [u16; 4]| t.map(float_from_half)), (at, feet), n, out)
            }
            Store::Float(texels) => self.read_floats(simd, (texels, |t| t), (at, feet), n, out),
        }
    }

    /// Whether it takes several taps along a footprint's longer axis.
    pub(super) fn is_anisotropic(&self) -> bool {
        let is_flat = matches!(self.shape, Shape::Line | Shape::Plane);
        let is_linear = matches!(
            self.sampler.min,
            MinFilter::Linear | MinFilter::LinearMipmapNearest | MinFilter::LinearMipmapLinear
        );
        is_flat && is_linear && self.sampler.max_anisotropy > 1
    }

    /// A border is no texel: the texture ends there.
    fn mark_applied(&self, at: &TexCoords, n: usize, out: &mut Reading) {
        let n_axes = match self.shape {
            Shape::Line => 1,
            Shape::Plane => 2,
            Shape::Volume => 3,
            Shape::Cube => 0,
        };
        out.is_whole = !self.sampler.wrap[..n_axes].contains(&Wrap::ClampToBorder);
        if out.is_whole {
            return;
        }
        out.applied[..n].fill(1.0);
        for axis in (0..n_axes).filter(|&a| self.sampler.wrap[a] == Wrap::ClampToBorder) {
            let lane = if axis < 2 { &at.st[axis] } else { &at.r[0] };
            for i in 0..n {
                // False for NaN as well.
                let is_inside = lane[i] >= 0.0 && lane[i] <= 1.0;
                out.applied[i] = if is_inside { out.applied[i] } else { 0.0 };
            }
        }
    }

    /// Fetches and filters in f32, point by point.
    #[inline(always)]
    fn read_floats<S: Simd, T: Copy, F: Fn(T) -> [f32; 4]>(
        &self,
        simd: S,
        (texels, value): (&[T], F),
        (at, feet): (&TexCoords, &Footprints),
        n: usize,
        out: &mut Reading,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let grid = Texels { simd, texels, value: &value, levels: &self.levels, wrap: self.sampler.wrap };
                // Never more; said so that bounds need no check in the loop.
                for i in 0..n.min(BATCH) {
                    let plan = Plan::new(self, feet.level[i]);
                    let [s, t, r] = [at.st[0][i], at.st[1][i], at.r[0][i]];
                    let rgba = match self.shape {
                        Shape::Line | Shape::Plane => {
                            let axis = [feet.axis[0][i], feet.axis[1][i]];
                            grid.taps(plan, [s, t], (axis, feet.n_taps[i]))
                        }
                        Shape::Volume => {
                            let st = [fold(s, grid.wrap[0]), fold(t, grid.wrap[1]), fold(r, grid.wrap[2])];
                            grid.mixed(
                                plan,
                                #[inline(always)]
                                |level, filter| grid.solid(level, filter, st),
                            )
                        }
                        Shape::Cube => {
                            let (face, st) = cube_face([s, t, r].map(finite));
                            grid.mixed(
                                plan,
                                #[inline(always)]
                                |level, filter| grid.face(level, filter, face, st),
                            )
                        }
                    };
                    let rgba = rgba.as_array();
                    (0..4).for_each(|c| out.rgba[c][i] = rgba[c]);
                }
            },
        );
    }
}

/// sRGB bytes: colour by table, alpha linear.
#[inline(always)]
fn srgb8(table: &[f32; 256], [r, g, b, a]: [u8; 4]) -> [f32; 4] {
    [table[r as usize], table[g as usize], table[b as usize], a as f32 * (1.0 / 255.0)]
}

#[inline(always)]
fn unorm8(t: [u8; 4]) -> [f32; 4] {
    t.map(|x| x as f32 * (1.0 / 255.0))
}

#[inline(always)]
fn unorm16(t: [u16; 4]) -> [f32; 4] {
    t.map(|x| x as f32 * (1.0 / 65535.0))
}

/// Which levels to read, how, and the second one's share.
#[derive(Clone, Copy)]
struct Plan {
    filter: Filter,
    levels: [usize; 2],
    mix: f32,
}

impl Plan {
    /// At or below level 0 a texel covers the cell and the magnification filter counts (OpenGL 4.6, 8.14 and 8.15).
    #[inline(always)]
    fn new(texture: &ImageTexture, level: f32) -> Self {
        if level <= 0.0 || level.is_nan() {
            return Self::full(texture.sampler.mag);
        }
        let last = texture.levels.len() - 1;
        match texture.sampler.min {
            MinFilter::Nearest => Self::full(Filter::Nearest),
            MinFilter::Linear => Self::full(Filter::Linear),
            MinFilter::NearestMipmapNearest => Self::nearest(Filter::Nearest, level, last),
            MinFilter::LinearMipmapNearest => Self::nearest(Filter::Linear, level, last),
            MinFilter::NearestMipmapLinear => Self::two(Filter::Nearest, level, last),
            MinFilter::LinearMipmapLinear => Self::two(Filter::Linear, level, last),
        }
    }

    #[inline(always)]
    fn full(filter: Filter) -> Self {
        Self { filter, levels: [0, 0], mix: 0.0 }
    }

    #[inline(always)]
    fn nearest(filter: Filter, level: f32, last: usize) -> Self {
        // Halfway the lower level wins.
        let l = (-floor(-(level + 0.5)) - 1.0) as usize;
        Self { filter, levels: [l.min(last); 2], mix: 0.0 }
    }

    #[inline(always)]
    fn two(filter: Filter, level: f32, last: usize) -> Self {
        let lower = floor(level);
        let l = lower as usize;
        let mix = if l < last { level - lower } else { 0.0 };
        Self { filter, levels: [l.min(last), (l + 1).min(last)], mix }
    }
}

/// Texels with what is needed to read them.
struct Texels<'a, S: Simd, T, F> {
    simd: S,
    texels: &'a [T],
    value: F,
    levels: &'a [Level],
    wrap: [Wrap; 3],
}

impl<S: Simd, T: Copy, F: Fn(T) -> [f32; 4]> Texels<'_, S, T, F> {
    /// One tap, or several of equal weight along the axis.
    #[inline(always)]
    fn taps(&self, plan: Plan, st: [f32; 2], (axis, n_taps): ([f32; 2], f32)) -> f32x4<S> {
        let mut sum = f32x4::splat(self.simd, 0.0);
        for k in 0..n_taps as usize {
            let along = (k as f32 + 0.5) / n_taps - 0.5;
            sum += self.tap(plan, [st[0] + axis[0] * along, st[1] + axis[1] * along]);
        }
        sum / f32x4::splat(self.simd, n_taps)
    }

    #[inline(always)]
    fn tap(&self, plan: Plan, st: [f32; 2]) -> f32x4<S> {
        let st = [fold(st[0], self.wrap[0]), fold(st[1], self.wrap[1])];
        self.mixed(
            plan,
            #[inline(always)]
            |level, filter| self.flat(level, filter, st),
        )
    }

    #[inline(always)]
    fn mixed(&self, plan: Plan, read: impl Fn(&Level, Filter) -> f32x4<S>) -> f32x4<S> {
        // A loop rather than two calls: what is inlined here is large.
        let mut both = [f32x4::splat(self.simd, 0.0); 2];
        let n_levels = if plan.mix == 0.0 { 1 } else { 2 };
        for l in 0..n_levels {
            both[l] = read(&self.levels[plan.levels[l]], plan.filter);
        }
        if n_levels == 1 { both[0] } else { lerp(both[0], both[1], plan.mix) }
    }

    #[inline(always)]
    fn flat(&self, level: &Level, filter: Filter, st: [f32; 2]) -> f32x4<S> {
        let [w, h, _] = level.size;
        match filter {
            Filter::Nearest => {
                let at = level.offset + nearest(st[1], h) * level.row + nearest(st[0], w);
                self.value(at)
            }
            Filter::Linear => {
                let ((x, u), (y, v)) = (between(st[0], w, self.wrap[0]), between(st[1], h, self.wrap[1]));
                self.four(level.offset + y * level.row + x, level.row, u, v)
            }
        }
    }

    #[inline(always)]
    fn solid(&self, level: &Level, filter: Filter, str: [f32; 3]) -> f32x4<S> {
        let n = level.size;
        match filter {
            Filter::Nearest => {
                let at =
                    nearest(str[2], n[2]) * level.slice + nearest(str[1], n[1]) * level.row + nearest(str[0], n[0]);
                self.value(level.offset + at)
            }
            Filter::Linear => {
                let [(x, u), (y, v), (z, w)] = [0, 1, 2].map(|a| between(str[a], n[a], self.wrap[a]));
                let at = level.offset + z * level.slice + y * level.row + x;
                let front = self.four(at, level.row, u, v);
                lerp(front, self.four(at + level.slice, level.row, u, v), w)
            }
        }
    }

    /// A cube's face has its neighbours' texels around it: places reach from -1 to n.
    #[inline(always)]
    fn face(&self, level: &Level, filter: Filter, face: usize, st: [f32; 2]) -> f32x4<S> {
        let n = level.size[0];
        let start = level.offset + face * level.slice;
        match filter {
            Filter::Nearest => self.value(start + nearest(st[1], n) * level.row + nearest(st[0], n)),
            Filter::Linear => {
                let place = |c: f32| {
                    let x = c * n as f32 + 0.5;
                    let i = (x as usize).min(n as usize);
                    (i, x - i as f32)
                };
                let ((x, u), (y, v)) = (place(st[0]), place(st[1]));
                // Places are counted from the neighbour's texel, one before the first.
                self.four(start + y * level.row + x - level.row - 1, level.row, u, v)
            }
        }
    }

    /// Four texels: at `at`, right of it, and below both.
    #[inline(always)]
    fn four(&self, at: usize, row: usize, u: f32, v: f32) -> f32x4<S> {
        lerp(self.pair(at, u), self.pair(at + row, u), v)
    }

    #[inline(always)]
    fn pair(&self, at: usize, u: f32) -> f32x4<S> {
        let [a, b]: [T; 2] = *self.texels[at..at + 2].as_array().expect("two texels");
        lerp(self.vector((self.value)(a)), self.vector((self.value)(b)), u)
    }

    #[inline(always)]
    fn value(&self, at: usize) -> f32x4<S> {
        self.vector((self.value)(self.texels[at]))
    }

    #[inline(always)]
    fn vector(&self, rgba: [f32; 4]) -> f32x4<S> {
        rgba.simd_into(self.simd)
    }
}

#[inline(always)]
fn lerp<S: Simd>(a: f32x4<S>, b: f32x4<S>, t: f32) -> f32x4<S> {
    a + (b - a) * t
}

/// A coordinate into [0, 1]; NaN gives 0.
#[inline(always)]
pub(super) fn fold(x: f32, wrap: Wrap) -> f32 {
    match wrap {
        Wrap::Repeat => {
            let x = fractional(x);
            x - floor(x)
        }
        Wrap::MirroredRepeat => {
            let x = fractional(x) * 0.5;
            let x = (x - floor(x)) * 2.0;
            if x > 1.0 { 2.0 - x } else { x }
        }
        Wrap::ClampToEdge | Wrap::ClampToBorder => {
            let x = if x > 0.0 { x } else { 0.0 };
            if x < 1.0 { x } else { 1.0 }
        }
    }
}

/// [`fold`] for eight coordinates, the same bits.
#[inline(always)]
pub(super) fn fold_vector<S: Simd>(simd: S, x: f32x8<S>, wrap: Wrap) -> f32x8<S> {
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let fractional = kernel(
        #[inline(always)]
        |x: f32x8<S>| x.abs().simd_lt(UNBROKEN).select(x, zero),
    );
    match wrap {
        Wrap::Repeat => {
            let x = fractional(x);
            x - x.floor()
        }
        Wrap::MirroredRepeat => {
            let x = fractional(x) * 0.5;
            let x = (x - x.floor()) * 2.0;
            x.simd_gt(one).select(f32x8::splat(simd, 2.0) - x, x)
        }
        Wrap::ClampToEdge | Wrap::ClampToBorder => {
            let x = x.simd_gt(zero).select(x, zero);
            x.simd_lt(one).select(x, one)
        }
    }
}

/// Floats from here on have at most halves; their fraction counts as 0, as does that of NaN.
const UNBROKEN: f32 = 4_194_304.0;

#[inline(always)]
fn fractional(x: f32) -> f32 {
    if x.abs() < UNBROKEN { x } else { 0.0 }
}

#[inline(always)]
fn finite(x: f32) -> f32 {
    if x.abs() < 1e15 { x } else { 0.0 }
}

#[inline(always)]
fn nearest(x: f32, n: u32) -> usize {
    let i = (x * n as f32) as u32;
    (if i < n { i } else { n - 1 }) as usize
}

/// The texel whose centre is at or before a folded coordinate, and how far towards the next one.
#[inline(always)]
fn between(x: f32, n: u32, wrap: Wrap) -> (usize, f32) {
    let x = x * n as f32 - 0.5;
    if wrap == Wrap::Repeat {
        let lower = floor(x);
        let i = lower as i32;
        let i = if i < 0 { i + n as i32 } else { i };
        return ((i as u32).min(n - 1) as usize, x - lower);
    }
    // At the edge, and at a mirror, a texel's neighbour is itself.
    let x = if x > 0.0 { x } else { 0.0 };
    let last = (n - 1) as f32;
    let x = if x < last { x } else { last };
    let i = x as u32;
    (i.min(n - 1) as usize, x - i as f32)
}
