//! Vectors of cells: the arithmetic of the shading kernels, a native SIMD width at a time.
//!
//! Every function does the same operations in the same order on each lane, so the bits depend on neither the width nor
//! the number of cells. `exp2`, `log2` and `pow` give the same bits as their scalar twins in [`crate::math`].

//!
//! Kernels use neither `array::map` nor `array::from_fn`: the standard library's loops are compiled without the SIMD
//! level's instructions, so nothing inside of them would be inlined. [`per_channel`] writes the three terms out.

use crate::math::{BATCH, Lane};
use fearless_simd::{Simd, prelude::*};

/// An array of three, from an expression for the channel or component `$c`.
macro_rules! per_channel {
    ($c:ident => $value:expr) => {
        [
            {
                let $c = 0;
                $value
            },
            {
                let $c = 1;
                $value
            },
            {
                let $c = 2;
                $value
            },
        ]
    };
}
pub(super) use per_channel;

/// As many cells as fit into one register.
pub(super) type V<S> = <S as Simd>::f32s;

/// Three numbers a cell: a direction or a colour.
pub(super) type V3<S> = [V<S>; 3];

/// The cells from `at` on. Kernels step by the register's width, which divides [`BATCH`].
#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, lane: &Lane, at: usize) -> V<S> {
    V::<S>::from_slice(simd, &lane[at..at + width::<S>()])
}

/// Three lanes at once.
#[inline(always)]
pub(super) fn load3<S: Simd>(simd: S, lanes: &[Lane; 3], at: usize) -> V3<S> {
    [load(simd, &lanes[0], at), load(simd, &lanes[1], at), load(simd, &lanes[2], at)]
}

/// The reverse of [`load3`].
#[inline(always)]
pub(super) fn store3<S: Simd>(v: V3<S>, lanes: &mut [Lane; 3], at: usize) {
    v[0].store_slice(&mut lanes[0][at..at + width::<S>()]);
    v[1].store_slice(&mut lanes[1][at..at + width::<S>()]);
    v[2].store_slice(&mut lanes[2][at..at + width::<S>()]);
}

/// Cells in a register.
#[inline(always)]
pub(super) const fn width<S: Simd>() -> usize {
    const { assert!(BATCH.is_multiple_of(V::<S>::LEN)) };
    V::<S>::LEN
}

/// Where the registers of a batch of `n` cells begin.
#[inline(always)]
pub(super) fn registers<S: Simd>(n: usize) -> impl Iterator<Item = usize> {
    // Never more than a batch; said so that lanes need no bounds check.
    (0..n.min(BATCH).div_ceil(width::<S>())).map(
        #[inline(always)]
        |register| register * width::<S>(),
    )
}

/// The same number in every cell.
#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, x: f32) -> V<S> {
    V::<S>::splat(simd, x)
}

/// The same three numbers in every cell.
#[inline(always)]
pub(super) fn splat3<S: Simd>(simd: S, x: [f32; 3]) -> V3<S> {
    [splat(simd, x[0]), splat(simd, x[1]), splat(simd, x[2])]
}

/// The larger of `x` and a bound; the bound where `x` is NaN.
#[inline(always)]
pub(super) fn at_least<S: Simd>(simd: S, x: V<S>, bound: f32) -> V<S> {
    let bound = splat(simd, bound);
    x.simd_gt(bound).select(x, bound)
}

/// The smaller of `x` and a bound; the bound where `x` is NaN.
#[inline(always)]
pub(super) fn at_most<S: Simd>(simd: S, x: V<S>, bound: f32) -> V<S> {
    let bound = splat(simd, bound);
    x.simd_lt(bound).select(x, bound)
}

/// The larger of two; `b` where `a` is NaN.
#[inline(always)]
pub(super) fn larger<S: Simd>(a: V<S>, b: V<S>) -> V<S> {
    a.simd_gt(b).select(a, b)
}

/// The smaller of two; `b` where `a` is NaN.
#[inline(always)]
pub(super) fn smaller<S: Simd>(a: V<S>, b: V<S>) -> V<S> {
    a.simd_lt(b).select(a, b)
}

/// `x` kept within [0, 1].
#[inline(always)]
pub(super) fn clamp01<S: Simd>(simd: S, x: V<S>) -> V<S> {
    at_most(simd, at_least(simd, x, 0.0), 1.0)
}

/// `a` at 0, `b` at 1.
#[inline(always)]
pub(super) fn mix<S: Simd>(a: V<S>, b: V<S>, t: V<S>) -> V<S> {
    a + (b - a) * t
}

/// The classic cubic from 0 to 1 for `t` within [0, 1].
#[inline(always)]
pub(super) fn smooth<S: Simd>(t: V<S>) -> V<S> {
    t * t * (t * -2.0 + 3.0)
}

/// Scalar product, summed from the left.
#[inline(always)]
pub(super) fn dot<S: Simd>(a: V3<S>, b: V3<S>) -> V<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Component by component.
#[inline(always)]
pub(super) fn add<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Every component times a number.
#[inline(always)]
pub(super) fn scale<S: Simd>(a: V3<S>, t: V<S>) -> V3<S> {
    [a[0] * t, a[1] * t, a[2] * t]
}

/// `d` seen in a mirror: the direction that light comes from which leaves along `view`.
#[inline(always)]
pub(super) fn reflect<S: Simd>(view: V3<S>, normal: V3<S>) -> V3<S> {
    let k = dot::<S>(view, normal) * 2.0;
    [normal[0] * k - view[0], normal[1] * k - view[1], normal[2] * k - view[2]]
}

/// One over the length of a vector whose square is given; finite for a zero vector.
#[inline(always)]
pub(super) fn inverse_length<S: Simd>(simd: S, squared: V<S>) -> V<S> {
    splat(simd, 1.0) / at_least(simd, squared, 1e-30).sqrt()
}

/// [`crate::math::exp2`] for every cell.
#[inline(always)]
pub(super) fn exp2<S: Simd>(simd: S, x: V<S>) -> V<S> {
    // As the scalar twin treats them: NaN saturates upwards.
    let x = x.simd_lt(splat(simd, -126.0)).select(splat(simd, -126.0), x);
    let x = x.simd_gt(splat(simd, 126.999)).select(splat(simd, 126.999), x);
    let rounded = (x + 12582912.0) - 12582912.0;
    let f = x - rounded;
    let p = f * 1.540353e-4 + 1.333356e-3;
    let p = p * f + 9.618129e-3;
    let p = p * f + 5.550411e-2;
    let p = p * f + 2.402265e-1;
    let p = p * f + 6.931472e-1;
    let p = p * f + 1.0;
    let exponent: S::i32s = rounded.to_int();
    let scale: V<S> = ((exponent + 127) << 23).bitcast();
    p * scale
}

/// [`crate::math::log2`] for every cell.
#[inline(always)]
pub(super) fn log2<S: Simd>(simd: S, x: V<S>) -> V<S> {
    let x = x.simd_gt(splat(simd, f32::MIN_POSITIVE)).select(x, splat(simd, f32::MIN_POSITIVE * 0.5));
    let bits: S::i32s = x.bitcast();
    let exponent = (bits - 0x3f35_04f3) >> 23;
    let m: V<S> = (bits - (exponent << 23)).bitcast();
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let p = z * 0.412_198_6 + 0.577_078_04;
    let p = p * z + 0.961_796_7;
    let p = p * z + 2.885_39;
    exponent.to_float::<V<S>>() + s * p
}

/// [`crate::math::pow`] for every cell, with one exponent.
#[inline(always)]
pub(super) fn pow<S: Simd>(simd: S, x: V<S>, y: f32) -> V<S> {
    let p = exp2(simd, log2(simd, x) * y);
    x.simd_le(splat(simd, 0.0)).select(splat(simd, 0.0), p)
}

/// Below this the power is as good as zero; going there would meet numbers that processors are slow with.
#[inline(always)]
pub(super) fn power_floor(y: f32) -> f32 {
    crate::math::exp2(-120.0 / y)
}

/// `x` to the power of `y` by multiplications alone, for a whole `y` from 1 to 256 with its [`power_floor`]; 0 for x <= 0.
/// Relative error below 1e-5.
#[inline(always)]
pub(super) fn whole_pow<S: Simd>(simd: S, x: V<S>, y: u32, floor: f32) -> V<S> {
    let mut square = at_least(simd, x, floor);
    let mut p = splat(simd, 1.0);
    let mut rest = y;
    loop {
        if rest & 1 == 1 {
            p *= square;
        }
        rest >>= 1;
        if rest == 0 {
            break;
        }
        square *= square;
    }
    x.simd_le(splat(simd, 0.0)).select(splat(simd, 0.0), p)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{math, par};
    use fearless_simd::dispatch;

    /// Calls `check` with every level of this machine.
    pub(in crate::picture) fn at_every_level(mut check: impl FnMut(&str, par::Level)) {
        for name in par::LEVEL_NAMES {
            if let Some(level) = par::level_by_name(name) {
                check(name, level);
            }
        }
    }

    #[test]
    fn elementary_functions_give_the_bits_of_their_scalar_twins() {
        let xs: Lane = std::array::from_fn(|i| match i {
            0 => 0.0,
            1 => -1.0,
            2 => f32::MIN_POSITIVE,
            3 => 1e-40,
            4 => 3e38,
            5 => 1.0,
            _ => math::unit_float(math::hash(i as u32)) * 4.0,
        });
        at_every_level(|name, level| {
            let (mut e, mut l, mut p) = (xs, xs, xs);
            dispatch!(level, simd => kernel(simd, &xs, [&mut e, &mut l, &mut p]));
            for (i, x) in xs.into_iter().enumerate() {
                let wanted = [math::exp2(x), math::log2(x), math::pow(x, 48.0)];
                assert_eq!([e[i], l[i], p[i]].map(f32::to_bits), wanted.map(f32::to_bits), "{name}: {x}");
            }
        });
    }

    #[inline(always)]
    fn kernel<S: Simd>(simd: S, xs: &Lane, out: [&mut Lane; 3]) {
        for at in (0..BATCH).step_by(width::<S>()) {
            let x = load(simd, xs, at);
            exp2(simd, x).store_slice(&mut out[0][at..at + width::<S>()]);
            log2(simd, x).store_slice(&mut out[1][at..at + width::<S>()]);
            pow(simd, x, 48.0).store_slice(&mut out[2][at..at + width::<S>()]);
        }
    }
}
