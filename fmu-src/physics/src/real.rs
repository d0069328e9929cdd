//! The number type of the equations: plain, or one that carries derivatives along.
//!
//! The equations are written once. The package `beam-physics` compiles them for plain numbers, the package
//! `beam-tangent` (the same files with the feature `tangent`) for numbers that carry the derivatives by a few
//! directions. Decision: docs/adr/0012-tangents.md.

#[cfg(feature = "tangent")]
pub use crate::tangent::{
    Tangent as Real, ZERO, is_constant, polynomial, real, root, value, values,
};

#[cfg(not(feature = "tangent"))]
pub use plain::{Real, ZERO, is_constant, polynomial, real, root, value, values};

#[cfg(not(feature = "tangent"))]
mod plain {
    /// A quantity of the equations.
    pub type Real = f64;

    /// Nothing.
    pub const ZERO: Real = 0.0;

    /// A constant as a quantity.
    #[inline(always)]
    pub const fn real(constant: f64) -> Real {
        constant
    }

    /// The value of a quantity, on which decisions are taken.
    #[inline(always)]
    pub const fn value(quantity: Real) -> f64 {
        quantity
    }

    /// Whether a quantity is this constant.
    #[inline(always)]
    pub fn is_constant(quantity: Real, constant: f64) -> bool {
        quantity == constant
    }

    /// The values of a list.
    #[inline(always)]
    pub const fn values(list: &[Real]) -> &[f64] {
        list
    }

    /// Value of the polynomial with coefficients `c`, power by power.
    #[inline]
    pub fn polynomial<'a>(c: impl DoubleEndedIterator<Item = &'a Real>, theta: Real) -> Real {
        c.rev().fold(0.0, |sum, a| sum * theta + a)
    }

    /// The root `theta` of an equation as a quantity: plain numbers have it already.
    #[inline(always)]
    pub fn root(theta: f64, _equation: impl FnOnce(Real) -> Real) -> Real {
        theta
    }
}
