//! Numbers that carry their derivatives by several directions along: forward differentiation.
//!
//! `x + sum_i x_i e_i` with `e_i e_j = 0` (Griewank and Walther 2008, Evaluating Derivatives, ch. 3). Every operation
//! gives the value that plain numbers give, and the derivatives by the chain rule. Comparisons look at values only, so that
//! a motion takes the same decisions as without derivatives; equality looks at everything, so that a strength of zero that is
//! being differentiated does not count as off.

use crate::integrate::MAX_DEGREE;
use std::cmp::Ordering;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Deref, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use wide::f64x2;

/// How many derivatives a number carries.
pub const DIRECTIONS: usize = 8;

/// A value with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tangent {
    /// Its derivatives.
    pub slope: Slope,
    /// The value.
    pub value: f64,
}

/// Derivatives by all directions, in the pairs that every processor works on together.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slope([f64x2; DIRECTIONS / 2]);

impl Slope {
    /// None.
    pub const NONE: Self = Self([f64x2::ZERO; DIRECTIONS / 2]);

    /// The derivative by direction `i` alone is 1.
    pub fn by(i: usize) -> Self {
        let mut out = Self::NONE;
        out.change(i, 1.0);
        out
    }
    /// The derivative by direction `i`.
    #[inline]
    pub fn get(&self, i: usize) -> f64 {
        self.0[i / 2].to_array()[i % 2]
    }
    /// Adds to the derivative by direction `i`.
    pub fn change(&mut self, i: usize, by: f64) {
        let mut pair = self.0[i / 2].to_array();
        pair[i % 2] += by;
        self.0[i / 2] = pair.into();
    }
    /// Whether all are zero.
    #[inline]
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }
    /// `factor` times these.
    #[inline(always)]
    pub fn times(self, factor: f64) -> Self {
        let factor = f64x2::splat(factor);
        Self(self.0.map(|s| s * factor))
    }
    /// Adds `factor` times others.
    #[inline(always)]
    pub fn add_times(&mut self, other: &Self, factor: f64) {
        let factor = f64x2::splat(factor);
        for (s, o) in self.0.iter_mut().zip(&other.0) {
            *s += *o * factor;
        }
    }
    #[inline(always)]
    fn plus(mut self, other: &Self) -> Self {
        for (s, o) in self.0.iter_mut().zip(&other.0) {
            *s += *o;
        }
        self
    }
    #[inline(always)]
    fn minus(mut self, other: &Self) -> Self {
        for (s, o) in self.0.iter_mut().zip(&other.0) {
            *s -= *o;
        }
        self
    }
}

/// Nothing.
pub const ZERO: Tangent = real(0.0);

/// A constant.
#[inline(always)]
pub const fn real(constant: f64) -> Tangent {
    Tangent {
        value: constant,
        slope: Slope::NONE,
    }
}

/// The value, on which decisions are taken.
#[inline(always)]
pub const fn value(quantity: Tangent) -> f64 {
    quantity.value
}

/// The values of the coefficients of a polynomial.
pub struct Values {
    list: [f64; MAX_DEGREE + 1],
    count: usize,
}

impl Deref for Values {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.list[..self.count]
    }
}

/// Whether a quantity is this constant, without a derivative.
pub fn is_constant(quantity: Tangent, constant: f64) -> bool {
    quantity.value == constant && quantity.slope.is_none()
}

/// The values of a list of at most `MAX_DEGREE + 1`.
#[inline]
pub fn values(list: &[Tangent]) -> Values {
    let mut out = Values {
        list: [0.0; MAX_DEGREE + 1],
        count: list.len(),
    };
    for (value, x) in out.list[..list.len()].iter_mut().zip(list) {
        *value = x.value;
    }
    out
}

/// Value of the polynomial with coefficients `c`, power by power: of the place its derivative alone is needed.
#[inline]
pub fn polynomial<'a>(c: impl DoubleEndedIterator<Item = &'a Tangent>, theta: Tangent) -> Tangent {
    let (at, mut sum, mut rise) = (theta.value, ZERO, 0.0);
    for a in c.rev() {
        rise = rise * at + sum.value;
        sum = sum * at + a;
    }
    sum + Tangent {
        value: 0.0,
        slope: theta.slope.times(rise),
    }
}

/// The root `theta` of an equation `g(theta) = 0` with its derivatives `-dg / g'` (implicit function theorem).
pub fn root(theta: f64, equation: impl Fn(Tangent) -> Tangent) -> Tangent {
    // Where it is known how g moves with theta: its own derivative, read off the first direction.
    let mut along = real(theta);
    along.slope = Slope::by(0);
    let fixed = equation(real(theta));
    let slope = equation(along).slope.get(0) - fixed.slope.get(0);
    Tangent {
        value: theta,
        slope: fixed.slope.times(-1.0 / slope),
    }
}

impl Tangent {
    /// `f(x)` from its value and its derivative by x.
    #[inline(always)]
    fn chain(self, value: f64, derivative: f64) -> Self {
        Self {
            value,
            slope: self.slope.times(derivative),
        }
    }

    /// |x|; the derivative at 0 is that of x > 0.
    #[inline]
    pub fn abs(self) -> Self {
        if self.value < 0.0 { -self } else { self }
    }
    /// The sign of x, 1 or -1.
    #[inline]
    pub fn signum(self) -> Self {
        real(self.value.signum())
    }
    /// The larger of both.
    #[inline]
    pub fn max(self, other: impl Into<Self>) -> Self {
        let other = other.into();
        if self.value >= other.value || other.value.is_nan() {
            self
        } else {
            other
        }
    }
    /// The smaller of both.
    #[inline]
    pub fn min(self, other: impl Into<Self>) -> Self {
        let other = other.into();
        if self.value <= other.value || other.value.is_nan() {
            self
        } else {
            other
        }
    }
    /// x between `low` and `high`.
    #[inline]
    pub fn clamp(self, low: impl Into<Self>, high: impl Into<Self>) -> Self {
        self.max(low).min(high)
    }
    /// Whether the value is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.value.is_finite()
    }
    /// Whether the value is not a number.
    #[inline]
    pub fn is_nan(self) -> bool {
        self.value.is_nan()
    }
    /// The square root.
    #[inline]
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }
    /// e to the power of x.
    #[inline]
    pub fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }
    /// `exp(x) - 1`.
    #[inline]
    pub fn exp_m1(self) -> Self {
        self.chain(self.value.exp_m1(), self.value.exp())
    }
    /// The natural logarithm.
    #[inline]
    pub fn ln(self) -> Self {
        self.chain(self.value.ln(), 1.0 / self.value)
    }
    /// `ln(1 + x)`.
    #[inline]
    pub fn ln_1p(self) -> Self {
        self.chain(self.value.ln_1p(), 1.0 / (1.0 + self.value))
    }
    /// Sine and cosine.
    #[inline]
    pub fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }
    /// The sine.
    #[inline]
    pub fn sin(self) -> Self {
        self.sin_cos().0
    }
    /// The tangent of an angle.
    #[inline]
    pub fn tan(self) -> Self {
        let t = self.value.tan();
        self.chain(t, 1.0 + t * t)
    }
    /// The angle with this sine.
    #[inline]
    pub fn asin(self) -> Self {
        let x = self.value;
        self.chain(x.asin(), 1.0 / (1.0 - x * x).sqrt())
    }
    /// The angle with this cosine.
    #[inline]
    pub fn acos(self) -> Self {
        let x = self.value;
        self.chain(x.acos(), -1.0 / (1.0 - x * x).sqrt())
    }
    /// The angle with this tangent.
    #[inline]
    pub fn atan(self) -> Self {
        let x = self.value;
        self.chain(x.atan(), 1.0 / (1.0 + x * x))
    }
    /// The angle of the point (x, self).
    #[inline]
    pub fn atan2(self, x: Self) -> Self {
        let (b, a) = (self.value, x.value);
        let square = a * a + b * b;
        let mut slope = self.slope.times(a / square);
        slope.add_times(&x.slope, -b / square);
        Self {
            slope,
            value: b.atan2(a),
        }
    }
    /// The hyperbolic sine.
    #[inline]
    pub fn sinh(self) -> Self {
        self.chain(self.value.sinh(), self.value.cosh())
    }
    /// The hyperbolic cosine.
    #[inline]
    pub fn cosh(self) -> Self {
        self.chain(self.value.cosh(), self.value.sinh())
    }
    /// The hyperbolic tangent.
    #[inline]
    pub fn tanh(self) -> Self {
        let t = self.value.tanh();
        self.chain(t, 1.0 - t * t)
    }
    /// The logarithm to the base of ten.
    #[inline]
    pub fn log10(self) -> Self {
        let x = self.value;
        self.chain(x.log10(), 1.0 / (x * std::f64::consts::LN_10))
    }
    /// The whole number below.
    #[inline]
    pub fn floor(self) -> Self {
        real(self.value.floor())
    }
    /// The cosine.
    #[inline]
    pub fn cos(self) -> Self {
        self.sin_cos().1
    }
    /// A whole power.
    #[inline]
    pub fn powi(self, n: i32) -> Self {
        self.chain(self.value.powi(n), f64::from(n) * self.value.powi(n - 1))
    }
    /// Any power of a positive number (or of 0, where the derivative by the exponent is 0).
    #[inline]
    pub fn powf(self, exponent: impl Into<Self>) -> Self {
        let exponent = exponent.into();
        let power = self.value.powf(exponent.value);
        let by_base = exponent.value * self.value.powf(exponent.value - 1.0);
        let by_exponent = if self.value > 0.0 {
            power * self.value.ln()
        } else {
            0.0
        };
        self.chain(power, by_base)
            + Self {
                value: 0.0,
                ..exponent.chain(0.0, by_exponent)
            }
    }
}

impl From<f64> for Tangent {
    #[inline(always)]
    fn from(constant: f64) -> Self {
        real(constant)
    }
}
impl From<Tangent> for f64 {
    #[inline(always)]
    fn from(quantity: Tangent) -> Self {
        quantity.value
    }
}

impl PartialEq<f64> for Tangent {
    #[inline]
    fn eq(&self, other: &f64) -> bool {
        *self == real(*other)
    }
}
impl PartialOrd for Tangent {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}
impl PartialOrd<f64> for Tangent {
    #[inline]
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.value.partial_cmp(other)
    }
}
impl PartialEq<Tangent> for f64 {
    #[inline]
    fn eq(&self, other: &Tangent) -> bool {
        other == self
    }
}
impl PartialOrd<Tangent> for f64 {
    #[inline]
    fn partial_cmp(&self, other: &Tangent) -> Option<Ordering> {
        self.partial_cmp(&other.value)
    }
}

impl Neg for Tangent {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            slope: Slope::NONE.minus(&self.slope),
        }
    }
}

impl Add for Tangent {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self {
            slope: self.slope.plus(&b.slope),
            value: self.value + b.value,
        }
    }
}
impl Sub for Tangent {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self {
            slope: self.slope.minus(&b.slope),
            value: self.value - b.value,
        }
    }
}
impl Mul for Tangent {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        let mut slope = self.slope.times(b.value);
        slope.add_times(&b.slope, self.value);
        Self {
            slope,
            value: self.value * b.value,
        }
    }
}
impl Div for Tangent {
    type Output = Self;
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        let quotient = self.value / b.value;
        let mut slope = self.slope;
        slope.add_times(&b.slope, -quotient);
        Self {
            slope: slope.times(1.0 / b.value),
            value: quotient,
        }
    }
}
impl Add<f64> for Tangent {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: f64) -> Self {
        Self {
            value: self.value + b,
            ..self
        }
    }
}
impl Sub<f64> for Tangent {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: f64) -> Self {
        Self {
            value: self.value - b,
            ..self
        }
    }
}
impl Mul<f64> for Tangent {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: f64) -> Self {
        self.chain(self.value * b, b)
    }
}
impl Div<f64> for Tangent {
    type Output = Self;
    #[inline(always)]
    fn div(self, b: f64) -> Self {
        self.chain(self.value / b, 1.0 / b)
    }
}
impl Add<Tangent> for f64 {
    type Output = Tangent;
    #[inline(always)]
    fn add(self, b: Tangent) -> Tangent {
        b + self
    }
}
impl Sub<Tangent> for f64 {
    type Output = Tangent;
    #[inline(always)]
    fn sub(self, b: Tangent) -> Tangent {
        Tangent {
            value: self - b.value,
            slope: Slope::NONE.minus(&b.slope),
        }
    }
}
impl Mul<Tangent> for f64 {
    type Output = Tangent;
    #[inline(always)]
    fn mul(self, b: Tangent) -> Tangent {
        b * self
    }
}
impl Div<Tangent> for f64 {
    type Output = Tangent;
    #[inline(always)]
    fn div(self, b: Tangent) -> Tangent {
        let quotient = self / b.value;
        b.chain(quotient, -quotient / b.value)
    }
}

/// The same operations with references, as iterators give them, and in place.
macro_rules! by_reference {
    ($($operation:ident $function:ident $assign:ident $in_place:ident),*) => {$(
        impl $operation<&Tangent> for Tangent {
            type Output = Tangent;
            #[inline(always)]
            fn $function(self, b: &Tangent) -> Tangent { self.$function(*b) }
        }
        impl $operation<Tangent> for &Tangent {
            type Output = Tangent;
            #[inline(always)]
            fn $function(self, b: Tangent) -> Tangent { (*self).$function(b) }
        }
        impl $operation<&Tangent> for &Tangent {
            type Output = Tangent;
            #[inline(always)]
            fn $function(self, b: &Tangent) -> Tangent { (*self).$function(*b) }
        }
        impl $operation<f64> for &Tangent {
            type Output = Tangent;
            #[inline(always)]
            fn $function(self, b: f64) -> Tangent { (*self).$function(b) }
        }
        impl $operation<&f64> for Tangent {
            type Output = Tangent;
            #[inline(always)]
            fn $function(self, b: &f64) -> Tangent { self.$function(*b) }
        }
        impl $operation<&Tangent> for f64 {
            type Output = Tangent;
            #[inline(always)]
            fn $function(self, b: &Tangent) -> Tangent { self.$function(*b) }
        }
        impl $operation<Tangent> for &f64 {
            type Output = Tangent;
            #[inline(always)]
            fn $function(self, b: Tangent) -> Tangent { (*self).$function(b) }
        }
        impl $operation<&Tangent> for &f64 {
            type Output = Tangent;
            #[inline(always)]
            fn $function(self, b: &Tangent) -> Tangent { (*self).$function(*b) }
        }
        impl $assign for Tangent {
            #[inline(always)]
            fn $in_place(&mut self, b: Tangent) { *self = (*self).$function(b); }
        }
        impl $assign<&Tangent> for Tangent {
            #[inline(always)]
            fn $in_place(&mut self, b: &Tangent) { *self = (*self).$function(*b); }
        }
        impl $assign<f64> for Tangent {
            #[inline(always)]
            fn $in_place(&mut self, b: f64) { *self = (*self).$function(b); }
        }
    )*};
}
by_reference!(
    Add add AddAssign add_assign,
    Sub sub SubAssign sub_assign,
    Mul mul MulAssign mul_assign,
    Div div DivAssign div_assign
);

impl Sum for Tangent {
    fn sum<I: Iterator<Item = Self>>(list: I) -> Self {
        list.fold(ZERO, |sum, x| sum + x)
    }
}
