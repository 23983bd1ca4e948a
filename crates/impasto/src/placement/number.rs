//! Numbers that know how fast they change: the coordinate functions are written once, and their footprint is exact.
//!
//! Forward-mode differentiation (Wengert, "A simple automatic derivative evaluation program", 1964): a [`Dual`] carries
//! a value and its change for one cell to the right and one cell down.

use crate::math;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// What the coordinate functions calculate with: [`Dual`] in the engine, plain f64 in the tests.
pub(super) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A number that does not change from cell to cell.
    fn constant(x: f32) -> Self;
    /// Times a constant.
    fn times(self, factor: f32) -> Self;
    /// Plus a constant.
    fn plus(self, offset: f32) -> Self;
    /// Square root; its change is limited at 0, where it would be infinite.
    fn sqrt(self) -> Self;
    /// The angle of the point (`x`, `self`), radians; its change runs on smoothly over the cut at +-pi.
    fn atan2(self, x: Self) -> Self;
    /// Whether the value is below the other.
    fn is_below(self, other: Self) -> bool;

    /// Magnitude.
    #[inline(always)]
    fn abs(self) -> Self {
        if self.is_below(Self::constant(0.0)) { -self } else { self }
    }
}

/// A value and its derivatives by the column and the row of the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dual {
    /// The value at the cell's centre.
    pub(super) value: f32,
    /// Change for one cell to the right.
    pub(super) dx: f32,
    /// Change for one cell down.
    pub(super) dy: f32,
}

/// A point or direction.
pub(super) type Vector<N> = [N; 3];

impl Dual {
    /// The chain rule: `value` changes `slope` times as fast as `self`.
    #[inline(always)]
    fn mapped(self, value: f32, slope: f32) -> Self {
        Self { value, dx: self.dx * slope, dy: self.dy * slope }
    }
}

impl Number for Dual {
    #[inline(always)]
    fn constant(x: f32) -> Self {
        Self { value: x, dx: 0.0, dy: 0.0 }
    }

    #[inline(always)]
    fn times(self, factor: f32) -> Self {
        self.mapped(self.value * factor, factor)
    }

    #[inline(always)]
    fn plus(self, offset: f32) -> Self {
        Self { value: self.value + offset, ..self }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = if self.value > 0.0 { self.value.sqrt() } else { 0.0 };
        let slope = if root > f32::MIN_POSITIVE { 0.5 / root } else { 0.0 };
        self.mapped(root, slope)
    }

    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        // d angle = (x dy - y dx) / (x^2 + y^2): the same on both sides of the cut. On the axis itself there is no angle.
        let squared = x.value * x.value + self.value * self.value;
        let inverse = if squared > f32::MIN_POSITIVE { 1.0 / squared } else { 0.0 };
        Self {
            value: math::atan2(self.value, x.value),
            dx: (x.value * self.dx - self.value * x.dx) * inverse,
            dy: (x.value * self.dy - self.value * x.dy) * inverse,
        }
    }

    #[inline(always)]
    fn is_below(self, other: Self) -> bool {
        self.value < other.value
    }
}

impl Add for Dual {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self { value: self.value + b.value, dx: self.dx + b.dx, dy: self.dy + b.dy }
    }
}

impl Sub for Dual {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self { value: self.value - b.value, dx: self.dx - b.dx, dy: self.dy - b.dy }
    }
}

impl Mul for Dual {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        Self {
            value: self.value * b.value,
            dx: self.dx * b.value + self.value * b.dx,
            dy: self.dy * b.value + self.value * b.dy,
        }
    }
}

impl Div for Dual {
    type Output = Self;
    /// Dividing by 0 gives 0 without change: the callers' quotients have no better limit there.
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        let inverse = if b.value != 0.0 { 1.0 / b.value } else { 0.0 };
        let value = self.value * inverse;
        Self { value, dx: (self.dx - value * b.dx) * inverse, dy: (self.dy - value * b.dy) * inverse }
    }
}

impl Neg for Dual {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: -self.value, dx: -self.dx, dy: -self.dy }
    }
}

/// `a` where `condition` holds, else `b`.
#[inline(always)]
pub(super) fn select<T>(condition: bool, a: T, b: T) -> T {
    if condition { a } else { b }
}

/// The component along an axis, without a memory access.
#[inline(always)]
pub(super) fn pick<T: Copy>(v: [T; 3], axis: u32) -> T {
    select(axis == 2, v[2], select(axis == 0, v[0], v[1]))
}

/// Scalar product.
#[inline(always)]
pub(super) fn dot<N: Number>(a: Vector<N>, b: Vector<N>) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The difference of two points.
#[inline(always)]
pub(super) fn minus<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// A vector times a number.
#[inline(always)]
pub(super) fn scaled<N: Number>(v: Vector<N>, factor: N) -> Vector<N> {
    [v[0] * factor, v[1] * factor, v[2] * factor]
}

/// The vector at length 1; zero stays zero.
#[inline(always)]
pub(super) fn unit<N: Number>(v: Vector<N>) -> Vector<N> {
    let length = dot(v, v).sqrt();
    scaled(v, N::constant(1.0) / length)
}

/// The component-wise product of a vector with constants.
#[inline(always)]
pub(super) fn stretched<N: Number>(v: Vector<N>, factors: [f32; 3]) -> Vector<N> {
    [v[0].times(factors[0]), v[1].times(factors[1]), v[2].times(factors[2])]
}

/// `row . v + offset`.
#[inline(always)]
pub(super) fn affine<N: Number>(row: [f32; 3], offset: f32, v: Vector<N>) -> N {
    (v[0].times(row[0]) + v[1].times(row[1]) + v[2].times(row[2])).plus(offset)
}

/// Vector product.
#[inline(always)]
pub(super) fn cross<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
