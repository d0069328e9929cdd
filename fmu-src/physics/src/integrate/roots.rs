//! The first sign change of a polynomial on an interval, none missed.

use super::MAX_DEGREE;
use crate::real::{Real, polynomial, root, values};

/// Values of the coefficients, power by power.
type Values = [f64; MAX_DEGREE + 1];

/// Interval halvings after which a touch without a sign change counts as no crossing.
const MAX_DEPTH: u32 = 48;

/// The first `theta` in `(low, high]` at which the polynomial with coefficients `c` (power by power)
/// falls below zero, provided it is not negative at `low` >= 0.
///
/// Rigorous: an interval is dropped only if the Taylor coefficients about its middle prove that the
/// polynomial can't reach zero in it, and a root is sought only where they prove it monotone
/// (mean-value form, Moore 1966).
pub fn first_below_zero(c: &[Real], low: f64, high: f64) -> Option<Real> {
    let theta = search(&values(c)[..c.len()], low, high, 0)?;
    Some(root(theta, |theta| polynomial(c.iter(), theta)))
}

/// The same on `(0, high]` of values, without their derivatives.
pub fn first_root_below(c: &[f64], high: f64) -> Option<f64> {
    search(c, 0.0, high, 0)
}

/// Value of the polynomial.
#[inline]
pub fn value(c: &[f64], theta: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, a| sum * theta + a)
}

fn search(c: &[f64], low: f64, high: f64, depth: u32) -> Option<f64> {
    let middle = 0.5 * (low + high);
    let shifted = about(c, middle, 0.5 * (high - low));
    let n = c.len();
    let (mut spread, mut slope_spread) = (0.0, 0.0);
    for (k, a) in shifted[..n].iter().enumerate().skip(1) {
        if k > 1 {
            slope_spread += k as f64 * a.abs();
        }
        spread += a.abs();
    }
    // The polynomial 0 stays; what has overflowed has no roots worth looking for.
    if shifted[0] >= spread || !spread.is_finite() {
        return None;
    }
    if n > 1 && shifted[1].abs() > slope_spread {
        return if value(c, high) < 0.0 {
            Some(polish(c, low, high))
        } else {
            None
        };
    }
    if depth == MAX_DEPTH {
        return (value(c, high) < 0.0).then_some(high);
    }
    if value(c, middle) < 0.0 {
        return search(c, low, middle, depth + 1).or(Some(middle));
    }
    search(c, low, middle, depth + 1).or_else(|| search(c, middle, high, depth + 1))
}

/// Binomial coefficients, `BINOMIAL[j][k]` = j over k.
const BINOMIAL: [Values; MAX_DEGREE + 1] = {
    let mut table = [[0.0; MAX_DEGREE + 1]; MAX_DEGREE + 1];
    let mut j = 0;
    while j <= MAX_DEGREE {
        table[j][0] = 1.0;
        let mut k = 1;
        while k <= j {
            table[j][k] = table[j - 1][k - 1] + table[j - 1][k];
            k += 1;
        }
        j += 1;
    }
    table
};

/// Taylor coefficients about `middle` > 0 in units of `radius`:
/// `a_k = (radius/middle)^k sum (j over k) c_j middle^j`.
fn about(c: &[f64], middle: f64, radius: f64) -> Values {
    let mut out = [0.0; MAX_DEGREE + 1];
    let mut power = 1.0;
    for (j, a) in c.iter().enumerate() {
        let term = a * power;
        for (sum, binomial) in out[..=j].iter_mut().zip(&BINOMIAL[j]) {
            *sum += term * binomial;
        }
        power *= middle;
    }
    let (ratio, mut power) = (radius / middle, 1.0);
    for a in &mut out[..c.len()] {
        *a *= power;
        power *= ratio;
    }
    out
}

/// The root between `low`, where the polynomial is positive, and `high`, where it is negative and
/// between which it is monotone: Newton's method, kept inside by bisection.
fn polish(c: &[f64], mut low: f64, mut high: f64) -> f64 {
    let (f_low, f_high) = (value(c, low), value(c, high));
    if f_low <= 0.0 {
        return low;
    }
    let mut theta = (low * f_high - high * f_low) / (f_high - f_low);
    for _ in 0..100 {
        if !(theta > low && theta < high) {
            theta = 0.5 * (low + high);
        }
        let (f, slope) = value_and_slope(c, theta);
        if f > 0.0 {
            low = theta;
        } else {
            high = theta;
        }
        let step = f / slope;
        if step.abs() <= 2.0 * f64::EPSILON * high || high - low <= 4.0 * f64::EPSILON * high {
            break;
        }
        theta -= step;
    }
    theta
}

/// Value and derivative of the polynomial.
#[inline]
fn value_and_slope(c: &[f64], theta: f64) -> (f64, f64) {
    c.iter().rev().fold((0.0, 0.0), |(f, slope), a| {
        (f * theta + a, slope * theta + f)
    })
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_first_of_two_close_roots_is_found() {
        // (theta - 0.3)(theta - 0.3001) is negative only on a ten-thousandth of the interval.
        let c = [0.3 * 0.3001, -0.6001, 1.0];
        assert_relative_eq!(
            first_below_zero(&c, 0.0, 1.0).unwrap(),
            0.3,
            epsilon = 1e-12
        );
    }

    #[test]
    fn a_touch_is_no_crossing() {
        assert_eq!(first_below_zero(&[0.25 + 1e-12, -1.0, 1.0], 0.0, 1.0), None);
    }

    #[test]
    fn zero_and_overflow_end_the_search() {
        assert_eq!(first_below_zero(&[0.0; 21], 0.0, 1.0), None);
        assert_eq!(first_below_zero(&[1.0, f64::NAN, 0.0], 0.0, 1.0), None);
        assert_eq!(first_below_zero(&[1.0, f64::INFINITY], 0.0, 1.0), None);
    }

    #[test]
    fn a_root_outside_the_interval_is_not_reported() {
        assert_eq!(first_below_zero(&[1.0, -0.5], 0.0, 1.0), None);
        assert_relative_eq!(
            first_below_zero(&[1.0, -2.0], 0.0, 1.0).unwrap(),
            0.5,
            epsilon = 1e-14
        );
    }
}
