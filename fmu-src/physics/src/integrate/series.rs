//! Arithmetic of truncated power series, one coefficient after the other.
//!
//! A series `f(theta) = sum f_k theta^k` is the list of its coefficients. Each function gives the
//! coefficient of one power from those below it, so that the solution of a differential equation can
//! be expanded as it goes (Moore 1966, ch. 11; Jorba and Zou 2005, Experimental Mathematics 14:99, sect. 2.1).

use super::MAX_DEGREE;
use super::roots::first_root_below;
use crate::real::{Real, ZERO, value, values};

/// Coefficients, power by power.
pub type Series = [Real; MAX_DEGREE + 1];

/// 1/k, except for k = 0.
pub const RECIPROCAL: [f64; MAX_DEGREE + 1] = {
    let mut r = [0.0; MAX_DEGREE + 1];
    let mut k = 1;
    while k <= MAX_DEGREE {
        r[k] = 1.0 / k as f64;
        k += 1;
    }
    r
};

/// Coefficient `k` of the product `a b`: `sum a_i b_(k-i)`.
#[cfg_attr(feature = "tangent", inline(always))]
#[cfg_attr(not(feature = "tangent"), inline)]
pub fn product(a: &Series, b: &Series, k: usize) -> Real {
    match k {
        0 => a[0] * b[0],
        _ => a[0] * b[k] + a[k] * b[0] + convolve(&a[1..k], &b[1..k]),
    }
}

/// Coefficient `k >= 1` of a function `f` of the series `u` with `f' = g u'`, where `g` is known up to
/// power `k - 1`: `sum i u_i g_(k-i) / k` over i = 1 .. k. The exponential has `g = f`, the sine
/// `g` = cosine. `slope` holds the `i u_i`.
#[cfg_attr(feature = "tangent", inline(always))]
#[cfg_attr(not(feature = "tangent"), inline)]
pub fn chained(g: &Series, slope: &Series, k: usize) -> Real {
    crossed(slope, g, k) * RECIPROCAL[k]
}

/// Coefficient `k` of the quotient `a / b` whose lower coefficients are in `quotient`; `b_0` is not 0.
#[cfg_attr(feature = "tangent", inline(always))]
#[cfg_attr(not(feature = "tangent"), inline)]
pub fn quotient(a: Real, b: &Series, quotient: &Series, k: usize) -> Real {
    (a - crossed(b, quotient, k)) / b[0]
}

/// `sum a_i b_(k-i)` over i = 1 .. k.
#[cfg_attr(feature = "tangent", inline(always))]
#[cfg_attr(not(feature = "tangent"), inline)]
fn crossed(a: &Series, b: &Series, k: usize) -> Real {
    match k {
        0 => ZERO,
        1 => a[1] * b[0],
        _ => a[1] * b[k - 1] + a[k] * b[0] + convolve(&a[2..k], &b[1..k - 1]),
    }
}

/// `sum a_i b_(n-1-i)` of lists of the same length n.
///
/// Callers add the terms that were found last themselves: a sum that begins with one would keep waiting for it.
#[cfg_attr(feature = "tangent", inline(always))]
#[cfg_attr(not(feature = "tangent"), inline)]
fn convolve(a: &[Real], b: &[Real]) -> Real {
    a.iter().zip(b.iter().rev()).map(|(x, y)| x * y).sum()
}

/// Whether the series up to `degree` certainly is not negative on `[0, theta]`.
///
/// Its linear part is so far above zero at both ends as all further negative terms can take away.
pub fn stays_positive(f: &[Real], theta: f64) -> bool {
    let f = values(f);
    let taken = f[2..]
        .iter()
        .rev()
        .fold(0.0, |sum, c| sum * theta + (-c).max(0.0));
    f[0].min(f[0] + f[1] * theta) >= taken * theta * theta
}

/// Whether the series up to `degree` certainly keeps its sign on `[0, theta]`; one that is zero
/// throughout does.
fn keeps_sign(f: &Series, degree: usize, theta: f64) -> bool {
    if f[0] > 0.0 {
        return stays_positive(&f[..=degree], theta);
    }
    let mut mirrored = *f;
    mirrored.iter_mut().for_each(|c| *c = -*c);
    stays_positive(&mirrored[..=degree], theta)
}

/// Share of a series up to which its last two terms may count where its roots are those of the function: a branch that ends is met
/// to so much of the step, and none that ends is missed.
const RESOLVED: f64 = 1e-6;

/// Whether the series up to `degree` stands for its function on `[0, theta]`: what decides on a branch enters no state, so that the
/// length of a step says nothing of it.
fn is_resolved(f: &[f64], theta: f64) -> bool {
    let terms = f.iter().scan(1.0, |power, c| {
        let term = c.abs() * *power;
        *power *= theta;
        Some(term)
    });
    let largest = terms.clone().fold(0.0, f64::max);
    let last = terms.skip(f.len().saturating_sub(2));
    f.iter().all(|c| c.is_finite()) && last.fold(0.0, f64::max) <= RESOLVED * largest
}

/// Normalised time, at most `theta`, up to which the series up to `degree` keeps the sign that it has at 0: until it first crosses
/// zero, and no longer than it stands for its function. 0 where nothing tells, as for one that leaves zero itself; one that is zero
/// throughout keeps its sign.
pub fn sign_until(f: &Series, degree: usize, theta: f64) -> f64 {
    let start = value(f[0]);
    if start == 0.0 {
        let stays = f[..=degree].iter().all(|c| value(*c) == 0.0);
        return if stays { theta } else { 0.0 };
    }
    if keeps_sign(f, degree, theta) {
        return theta;
    }
    let positive = f.map(|c| value(c) * start.signum());
    let positive = &positive[..=degree];
    // Below an eighth of the step the integrator that controls its error is as quick.
    let shorter = [1.0, 0.5, 0.25, 0.125].map(|share| share * theta);
    let Some(until) = shorter.into_iter().find(|end| is_resolved(positive, *end)) else {
        return 0.0;
    };
    first_root_below(positive, until).unwrap_or(until)
}

/// `theta` if the series up to `degree` keeps its sign until then, 0 otherwise: for what ends where a series does.
pub fn all_or_nothing(f: &Series, degree: usize, theta: f64) -> f64 {
    if sign_until(f, degree, theta) < theta {
        0.0
    } else {
        theta
    }
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn val_a_sign_is_kept_until_the_first_root() {
        // Source: roots of (theta - 0.4)(theta - 0.7) and of its negative.
        let mut f = [0.0; MAX_DEGREE + 1];
        f[..3].copy_from_slice(&[0.28, -1.1, 1.0]);
        for sign in [1.0, -1.0] {
            let f = f.map(|c| sign * c);
            assert_relative_eq!(sign_until(&f, 6, 1.0), 0.4, max_relative = 1e-12);
            assert_eq!(sign_until(&f, 6, 0.3), 0.3);
            assert_eq!(all_or_nothing(&f, 6, 1.0), 0.0);
        }
        // It comes near zero without a crossing, as sums of magnitudes can't prove.
        f[0] = 0.31;
        assert!(!keeps_sign(&f, 2, 1.0));
        assert_eq!(all_or_nothing(&f, 6, 1.0), 1.0);
    }

    #[test]
    fn what_tells_nothing_of_its_sign_keeps_none() {
        let series = |coefficients: &[f64]| {
            let mut f = [0.0; MAX_DEGREE + 1];
            f[..coefficients.len()].copy_from_slice(coefficients);
            f
        };
        // It leaves zero itself, upwards or downwards; it stays there.
        assert_eq!(sign_until(&series(&[0.0, 1.0]), 2, 1.0), 0.0);
        assert_eq!(sign_until(&series(&[0.0, -1.0]), 2, 1.0), 0.0);
        assert_eq!(sign_until(&series(&[]), 2, 1.0), 1.0);
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(sign_until(&series(&[1.0, -2.0, wrong]), 2, 1.0), 0.0);
        }
        // cos(20 theta) to degree 8 crosses zero at 0.0785 and stands for its function that far alone.
        let mut f = [0.0; MAX_DEGREE + 1];
        f[0] = 1.0;
        for k in (2..=8).step_by(2) {
            f[k] = -f[k - 2] * 400.0 / (k * (k - 1)) as f64;
        }
        assert_eq!(sign_until(&f, 8, 1.0), 0.0);
        assert!(sign_until(&f, 8, 0.05) > 0.0);
    }

    fn exponential(rate: f64) -> Series {
        let mut f = [0.0; MAX_DEGREE + 1];
        f[0] = 1.0;
        for k in 1..=MAX_DEGREE {
            f[k] = f[k - 1] * rate / k as f64;
        }
        f
    }

    #[test]
    fn val_exponentials_multiply_divide_and_chain() {
        // Source: exp(a t) exp(b t) = exp((a + b) t).
        let (a, b, both) = (exponential(1.5), exponential(-0.4), exponential(1.1));
        let (mut ratio, mut anew) = ([0.0; MAX_DEGREE + 1], [0.0; MAX_DEGREE + 1]);
        let mut slope = [0.0; MAX_DEGREE + 1];
        slope[1] = 1.1;
        anew[0] = 1.0;
        for k in 0..=MAX_DEGREE {
            assert_relative_eq!(product(&a, &b, k), both[k], max_relative = 1e-12);
            ratio[k] = quotient(both[k], &b, &ratio, k);
            assert_relative_eq!(ratio[k], a[k], max_relative = 1e-9);
            if k > 0 {
                anew[k] = chained(&anew, &slope, k);
            }
            assert_relative_eq!(anew[k], both[k], max_relative = 1e-12);
        }
    }

    #[test]
    fn a_sign_is_kept_only_where_it_is_certain() {
        let mut f = [0.0; MAX_DEGREE + 1];
        assert!(keeps_sign(&f, 3, 1.0));
        f[0] = -1.0;
        f[2] = 0.5;
        assert!(keeps_sign(&f, 3, 1.0));
        assert!(!keeps_sign(&f, 3, 2.0));
        f[1] = 1.2;
        assert!(!keeps_sign(&f, 3, 1.0));
    }
}
