//! Numbers of the fast loops: one `f64`, or as many side by side as a SIMD vector holds.
//!
//! The formulas of [`crate::dimension`] and [`crate::constitutive`] are written once for both. SIMD lanes do not mix and
//! products are not fused with sums, so every lane gets the bits that a lone `f64` would get, on any CPU.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use bytemuck::Pod;
use pulp::Simd;

/// An array `[first; n]` whose entries are then computed one by one.
///
/// Unlike `std::array::from_fn` without a closure: what is in one is compiled for a CPU without SIMD, and called.
macro_rules! array {
    ([$first:expr; $count:expr], $i:ident => $entry:expr) => {{
        let mut all = [$first; $count];
        for $i in 0..$count {
            all[$i] = $entry;
        }
        all
    }};
}
pub(crate) use array;

/// An array, not empty, of what a function gives for each place. `std::array::from_fn` compiles to five times as much.
#[inline(always)]
pub fn array_of<T: Copy, const N: usize, F: FnMut(usize) -> T>(mut entry: F) -> [T; N] {
    let (mut all, mut i) = ([entry(0); N], 1);
    while i < N {
        all[i] = entry(i);
        i += 1;
    }
    all
}

/// [`array_of`] what a function makes of each entry of another.
#[inline(always)]
pub fn map_of<T: Copy, U: Copy, const N: usize, F: FnMut(T) -> U>(from: &[T; N], mut entry: F) -> [U; N] {
    array_of(|i| entry(from[i]))
}

/// A number, or several.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// A constant, as many times as this number has lanes.
    fn like(self, constant: f64) -> Self;
    /// Its square root.
    fn root(self) -> Self;
    /// The larger of two; the other one if either is no number.
    fn larger(self, other: Self) -> Self;
    /// The smaller of two; the other one if either is no number.
    fn smaller(self, other: Self) -> Self;
    /// One of two numbers: the first where this is below `other`.
    fn if_below(self, other: Self, first: Self, second: Self) -> Self;
    /// The same of so many numbers.
    #[inline(always)]
    fn if_below_all<const N: usize>(self, other: Self, first: &[Self; N], second: &[Self; N]) -> [Self; N] {
        array!([first[0]; N], i => self.if_below(other, first[i], second[i]))
    }
}

impl Real for f64 {
    #[inline(always)]
    fn like(self, constant: f64) -> Self {
        constant
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn if_below(self, other: Self, first: Self, second: Self) -> Self {
        if self < other { first } else { second }
    }
}

/// Cells that a SIMD vector never straddles: the most lanes of any CPU. Sums over cells are kept in as many parts, so that
/// their bits do not depend on the CPU.
pub const MAX_LANES: usize = 8;

/// Numbers as vectors, or as arrays of these, of which there are so many without a rest.
///
/// # Panics
/// There is a rest.
#[inline(always)]
pub fn vectors_mut<V: Pod>(numbers: &mut [f64]) -> &mut [V] {
    bytemuck::cast_slice_mut(numbers)
}

/// Several numbers that are computed at once; S: the SIMD type of the CPU.
#[derive(Debug, Clone, Copy)]
pub struct SimdReal<S: Simd> {
    /// Proof that the SIMD instructions of the CPU may be used.
    pub simd: S,
    /// The numbers.
    pub value: S::f64s,
}

impl<S: Simd> SimdReal<S> {
    /// How many.
    pub const COUNT: usize = S::F64_LANES;

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, constant: f64) -> Self {
        Self { simd, value: simd.splat_f64s(constant) }
    }

    /// The first numbers of a slice.
    ///
    /// # Panics
    /// The slice is too short.
    #[inline(always)]
    pub fn load(simd: S, from: &[f64]) -> Self {
        Self { simd, value: S::as_simd_f64s(&from[..Self::COUNT]).0[0] }
    }

    /// Writes the numbers to the start of a slice.
    ///
    /// # Panics
    /// The slice is too short.
    #[inline(always)]
    pub fn store(self, to: &mut [f64]) {
        S::as_mut_simd_f64s(&mut to[..Self::COUNT]).0[0] = self.value;
    }

    /// The number in a lane.
    ///
    /// # Panics
    /// There is no such lane.
    #[inline(always)]
    pub fn lane(self, lane: usize) -> f64 {
        bytemuck::cast_slice::<_, f64>(std::slice::from_ref(&self.value))[lane]
    }

    /// Replaces the number in a lane.
    ///
    /// # Panics
    /// There is no such lane.
    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, number: f64) {
        bytemuck::cast_slice_mut::<_, f64>(std::slice::from_mut(&mut self.value))[lane] = number;
    }

    /// Every number so many lanes up, those above the last lane to the first ones.
    #[inline(always)]
    pub fn turned(self, by: usize) -> Self {
        Self { value: self.simd.rotate_right_f64s(self.value, by), ..self }
    }

    /// This where the mask holds, `other` elsewhere.
    #[inline(always)]
    pub fn or(self, mask: S::m64s, other: Self) -> Self {
        Self { value: self.simd.select_f64s(mask, self.value, other.value), ..self }
    }

    /// Where this is below `other`.
    #[inline(always)]
    pub fn below(self, other: Self) -> S::m64s {
        self.simd.less_than_f64s(self.value, other.value)
    }

    /// Where this equals `other`.
    #[inline(always)]
    pub fn equals(self, other: Self) -> S::m64s {
        self.simd.equal_f64s(self.value, other.value)
    }

    /// Where this is in [0, 1): not where it is no number.
    #[inline(always)]
    pub fn in_unit_interval(self) -> S::m64s {
        let (zero, one) = (self.like(0.0), self.like(1.0));
        let simd = self.simd;
        simd.and_m64s(simd.less_than_or_equal_f64s(zero.value, self.value), simd.less_than_f64s(self.value, one.value))
    }

    /// Whether a mask holds in no lane.
    #[inline(always)]
    pub fn nowhere(simd: S, mask: S::m64s) -> bool {
        simd.first_true_m64s(mask) == Self::COUNT
    }

    /// This over another where a mask holds, itself elsewhere: there the other is one. A division takes as long as a dozen products,
    /// and is left out where no lane needs it.
    #[inline(always)]
    pub fn over_where(self, mask: S::m64s, other: Self) -> Self {
        if Self::nowhere(self.simd, mask) { self } else { (self / other).or(mask, self) }
    }

    /// Where this differs from `other`.
    #[inline(always)]
    pub fn differs(self, other: Self) -> S::m64s {
        self.simd.not_m64s(self.equals(other))
    }

    /// This where it is positive, one elsewhere.
    #[inline(always)]
    pub fn or_one(self) -> Self {
        self.or(self.like(0.0).below(self), self.like(1.0))
    }

    /// The lesser of each pair.
    #[inline(always)]
    pub fn lesser(self, other: Self) -> Self {
        Self { value: self.simd.min_f64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Real for SimdReal<S> {
    #[inline(always)]
    fn like(self, constant: f64) -> Self {
        Self::splat(self.simd, constant)
    }

    #[inline(always)]
    fn root(self) -> Self {
        Self { value: self.simd.sqrt_f64s(self.value), ..self }
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.or(other.below(self), other)
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.or(self.below(other), other)
    }

    #[inline(always)]
    fn if_below(self, other: Self, first: Self, second: Self) -> Self {
        first.or(self.below(other), second)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $of_simd:ident) => {
        impl<S: Simd> $trait for SimdReal<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { value: self.simd.$of_simd(self.value, other.value), ..self }
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Mul<f64> for SimdReal<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * self.like(factor)
    }
}

impl<S: Simd> Neg for SimdReal<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // Not `neg_f64s`, which is compiled for a CPU without SIMD, and called.
        self.like(-0.0) - self
    }
}

impl<S: Simd> AddAssign for SimdReal<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> SubAssign for SimdReal<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
