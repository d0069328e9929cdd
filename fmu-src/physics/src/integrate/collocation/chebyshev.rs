//! Chebyshev series on a step: values, integrals, and the first sign change, none missed.

use super::TERMS;
use super::nodes::{Aligned, total};
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Coefficients of `sum c_k T_k(2 theta - 1)` on theta in [0, 1].
pub type Chebyshev = [f64; TERMS];

/// Halvings after which a touch without a sign change counts as no crossing.
const MAX_DEPTH: u32 = 48;
/// Newton step, in half intervals, that is not worth taking; it is foreseen from the two before.
const LAST_STEP: f64 = 1e-15;

/// `LEFT[k]` = coefficients of `T_k((x - 1)/2)`, the polynomial T_k on the left half of its interval; on the right half the signs
/// of `k + m` odd are turned. From `T_(k+1)(y) = 2 y T_k(y) - T_(k-1)(y)`.
static LEFT: Aligned<[Chebyshev; TERMS]> = Aligned({
    let mut table = [[0.0; TERMS]; TERMS];
    table[0][0] = 1.0;
    table[1][0] = -0.5;
    table[1][1] = 0.5;
    let mut k = 1;
    while k + 1 < TERMS {
        let mut m = 0;
        while m <= k {
            // x T_m = (T_(m+1) + T_|m-1|) / 2.
            let c = table[k][m];
            table[k + 1][m] -= c;
            if m == 0 {
                table[k + 1][1] += c;
            } else {
                table[k + 1][m + 1] += 0.5 * c;
                table[k + 1][m - 1] += 0.5 * c;
            }
            m += 1;
        }
        m = 0;
        while m < k {
            table[k + 1][m] -= table[k - 1][m];
            m += 1;
        }
        k += 1;
    }
    table
});

/// 1/k, except for k = 0.
const RECIPROCAL: Chebyshev = {
    let mut r = [0.0; TERMS];
    let mut k = 1;
    while k < TERMS {
        r[k] = 1.0 / k as f64;
        k += 1;
    }
    r
};

/// The places theta in [0, 1] at which [`from_values`] wants values.
pub fn places() -> Chebyshev {
    std::array::from_fn(|i| 0.5 - 0.5 * (PI * (i as f64 + 0.5) / TERMS as f64).cos())
}

/// The series through values at [`places`].
pub fn from_values(values: &Chebyshev) -> Chebyshev {
    // Columns of the discrete cosine transform, worked out once.
    static COLUMNS: OnceLock<[Chebyshev; TERMS]> = OnceLock::new();
    let columns = COLUMNS.get_or_init(|| {
        std::array::from_fn(|i| {
            std::array::from_fn(|k| {
                // The places rise, so the angles fall; whole turns are taken out before rounding.
                let turns = (k * (2 * (TERMS - i) - 1)) % (4 * TERMS);
                let angle = PI * turns as f64 / (2 * TERMS) as f64;
                angle.cos() * if k == 0 { 1.0 } else { 2.0 } / TERMS as f64
            })
        })
    });
    let mut out = [0.0; TERMS];
    for (column, value) in columns.iter().zip(values) {
        for (sum, c) in out.iter_mut().zip(column) {
            *sum += c * value;
        }
    }
    out
}

/// Terms that are summed side by side, so that none waits long for the one before.
const GROUP: usize = 4;
/// Terms of a sum without a recurrence that are summed side by side.
const LANES: usize = 8;

/// Value at `theta`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
pub fn value(c: &Chebyshev, theta: f64) -> f64 {
    value_in_any(c, theta)
}

/// The same, to be compiled into functions that are there for each processor.
#[inline(always)]
pub fn value_in_any(c: &Chebyshev, theta: f64) -> f64 {
    at(c, 2.0 * theta - 1.0)
}

/// T_0 to T_7, and T_8.
#[inline(always)]
fn first_polynomials(x: f64) -> ([f64; LANES], f64) {
    let next = |a: f64, b: f64, c: f64| (2.0 * a).mul_add(b, -c);
    let t2 = next(x, x, 1.0);
    let t3 = next(x, t2, x);
    let t4 = next(t2, t2, 1.0);
    let (t5, t6, t7) = (next(t2, t3, x), next(t3, t3, 1.0), next(t3, t4, x));
    ([1.0, x, t2, t3, t4, t5, t6, t7], next(t4, t4, 1.0))
}

/// Clenshaw's rule in strides of [`GROUP`]: `T_(k+4) = 2 T_4 T_k - T_|k-4|`.
#[inline(always)]
fn at(c: &Chebyshev, x: f64) -> f64 {
    let (t, _) = first_polynomials(x);
    strides(c, &t)
}

#[inline(always)]
fn strides(c: &Chebyshev, t: &[f64; LANES]) -> f64 {
    let twice = 2.0 * t[GROUP];
    let (mut b, mut before) = ([0.0; GROUP], [0.0; GROUP]);
    for g in (1..TERMS / GROUP).rev() {
        for i in 0..GROUP {
            let next = twice.mul_add(b[i], c[g * GROUP + i] - before[i]);
            (b[i], before[i]) = (next, b[i]);
        }
    }
    for i in 0..GROUP {
        b[i] = t[i].mul_add(c[i] - before[i], t[GROUP + i] * b[i]);
    }
    (b[0] + b[2]) + (b[1] + b[3])
}

/// All T_k at `theta`: `T_(k+8) = 2 T_8 T_k - T_|k-8|`.
#[inline(always)]
pub(super) fn polynomials(theta: f64) -> Chebyshev {
    let (first, eighth) = first_polynomials(2.0 * theta - 1.0);
    let mut t = [0.0; TERMS];
    let twice = 2.0 * eighth;
    for i in 0..LANES {
        t[i] = first[i];
        let mirrored = if i == 0 { eighth } else { first[LANES - i] };
        t[LANES + i] = twice.mul_add(first[i], -mirrored);
    }
    for i in 0..LANES {
        t[2 * LANES + i] = twice.mul_add(t[LANES + i], -t[i]);
    }
    t
}

/// Sum of the products of two lists.
#[inline(always)]
pub(super) fn dot(a: &Chebyshev, b: &Chebyshev) -> f64 {
    let mut sums = [0.0; LANES];
    for g in 0..TERMS / LANES {
        for i in 0..LANES {
            sums[i] = a[g * LANES + i].mul_add(b[g * LANES + i], sums[i]);
        }
    }
    total(sums)
}

/// Derivative by x = 2 theta - 1: `d_(k-1) = d_(k+1) + 2 k c_k`, two at once.
#[inline(always)]
fn derivative(c: &Chebyshev) -> Chebyshev {
    let mut rise = [0.0; TERMS + GROUP];
    for k in 1..TERMS {
        rise[k - 1] = (2 * k) as f64 * c[k];
    }
    let mut d = [0.0; TERMS + GROUP];
    for g in (0..TERMS / GROUP).rev() {
        for i in 0..GROUP {
            let k = g * GROUP + i;
            d[k] = d[k + GROUP] + (rise[k] + rise[k + 2]);
        }
    }
    d[0] *= 0.5;
    std::array::from_fn(|k| d[k])
}

/// Integral over theta from 0 to `theta`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
pub fn integral_to(c: &Chebyshev, theta: f64) -> f64 {
    // The integral of T_k over x = 2 theta - 1 is (T_(k+1)/(k+1) - T_|k-1|/(k-1))/2.
    let mut out = [0.0; TERMS];
    out[1] = 0.5 * c[0] - 0.25 * c[2];
    for k in 2..TERMS - 1 {
        out[k] = (c[k - 1] - c[k + 1]) * (0.25 * RECIPROCAL[k]);
    }
    out[TERMS - 1] = c[TERMS - 2] * (0.25 * RECIPROCAL[TERMS - 1]);
    value_in_any(&out, theta) - dot(&out, &TURNED)
}

/// The series divided by theta, up to a constant factor, for one that vanishes at theta = 0 to rounding.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
pub fn without_first_root(c: &Chebyshev) -> Chebyshev {
    // c = (1 + x) q; (1 + x) T_m = T_m + (T_(m+1) + T_|m-1|)/2, solved from the highest power down.
    let mut q = [0.0f64; TERMS + 1];
    for m in (2..TERMS).rev() {
        q[m - 1] = q[m].mul_add(-2.0, 2.0 * c[m] - q[m + 1]);
    }
    q[0] = c[1] - q[1] - 0.5 * q[2];
    std::array::from_fn(|k| q[k])
}

/// The series on the left half of its interval, and on the right one.
#[inline(always)]
fn halves(c: &Chebyshev) -> [Chebyshev; 2] {
    let (mut even, mut odd) = ([0.0; TERMS], [0.0; TERMS]);
    // On the left, T_k is made of the terms up to its own.
    for group in 0..TERMS / LANES {
        let reach = (group + 1) * LANES;
        for k in (group * LANES..reach).step_by(2) {
            for m in 0..reach {
                even[m] = c[k].mul_add(LEFT.0[k][m], even[m]);
                odd[m] = c[k + 1].mul_add(LEFT.0[k + 1][m], odd[m]);
            }
        }
    }
    let (mut left, mut right) = (even, even);
    for m in 0..TERMS {
        left[m] += odd[m];
        right[m] = TURNED[m] * (even[m] - odd[m]);
    }
    [left, right]
}

/// T_k at x = 0.
const MIDDLE: Chebyshev = {
    let mut t = [0.0; TERMS];
    let mut k = 0;
    while k < TERMS {
        t[k] = if k % 4 == 0 { 1.0 } else { -1.0 };
        k += 2;
    }
    t
};

/// 1 and -1 in turn: T_k at x = -1.
const TURNED: Chebyshev = {
    let mut t = [1.0; TERMS];
    let mut k = 1;
    while k < TERMS {
        t[k] = -1.0;
        k += 2;
    }
    t
};

/// Sum of the magnitudes from term 1 on: as far as the series can be from its mean.
#[inline(always)]
pub fn spread(c: &Chebyshev) -> f64 {
    let mut sums = [0.0; LANES];
    for group in c.chunks_exact(LANES) {
        for (sum, a) in sums.iter_mut().zip(group) {
            *sum += a.abs();
        }
    }
    total(sums) - c[0].abs()
}

/// The first theta in `(low, 1]` at which the series falls below zero, provided it is not negative at `low` >= 0.
///
/// Rigorous as `integrate::roots`: since `|T_k| <= 1`, a stretch is dropped only if its coefficients prove that the series
/// can't vanish there, and a root is sought only where those of the derivative prove it monotone.
pub fn first_below_zero(c: &Chebyshev, low: f64) -> Option<f64> {
    search(c, 0.0, 1.0, low, 0)
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
fn search(c: &Chebyshev, from: f64, to: f64, low: f64, depth: u32) -> Option<f64> {
    if to <= low {
        return None;
    }
    let spread_here = spread(c);
    // The series 0 stays; what has overflowed has no roots worth looking for.
    if c[0] >= spread_here || !spread_here.is_finite() {
        return None;
    }
    let slope = derivative(c);
    let middle = 0.5 * (from + to);
    if slope[0].abs() > spread(&slope) {
        let last = dot(c, &[1.0; TERMS]);
        if !(last < 0.0) {
            return None;
        }
        let begin = ((low - middle) / (to - middle)).max(-1.0);
        let x = polish(c, &slope, begin);
        return Some(middle + x * (to - middle));
    }
    if depth == MAX_DEPTH {
        return (dot(c, &[1.0; TERMS]) < 0.0).then_some(to);
    }
    let [left, right] = halves(c);
    let first = search(&left, from, middle, low, depth + 1);
    if first.is_some() {
        return first;
    }
    if middle > low && dot(&right, &TURNED) < 0.0 {
        return Some(middle);
    }
    search(&right, middle, to, low, depth + 1)
}

/// The root in [low, 1] of a monotone series that is negative at 1: Newton's method, kept inside by bisection.
#[inline(always)]
fn polish(c: &Chebyshev, slope: &Chebyshev, low: f64) -> f64 {
    let (mut low, mut high) = (low, 1.0);
    let f_high = dot(c, &[1.0; TERMS]);
    let whole = low == -1.0;
    let f_low = if whole { dot(c, &TURNED) } else { at(c, low) };
    if f_low <= 0.0 {
        return low;
    }
    let mut x = if whole {
        // The parabola of x over f through both ends and the middle.
        let f = dot(c, &MIDDLE);
        let (from_low, from_high) = (
            (f_low - f) * (f_low - f_high),
            (f_high - f_low) * (f_high - f),
        );
        f_low * f / from_high - f * f_high / from_low
    } else {
        (low * f_high - high * f_low) / (f_high - f_low)
    };
    let mut last = 1.0;
    for _ in 0..100 {
        if !(x > low && x < high) {
            x = 0.5 * (low + high);
        }
        let (t, _) = first_polynomials(x);
        let (f, rise) = (strides(c, &t), strides(slope, &t));
        if f > 0.0 {
            low = x;
        } else {
            high = x;
        }
        let step = f / rise;
        x -= step;
        // Each step is the square of the one before, times what the series bends.
        let (size, before) = (step.abs(), last * last);
        if size * size * size <= LAST_STEP * before || high - low <= 4.0 * f64::EPSILON {
            break;
        }
        last = size;
    }
    x.clamp(-1.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn series(f: impl Fn(f64) -> f64) -> Chebyshev {
        from_values(&places().map(f))
    }

    #[test]
    fn val_a_function_its_derivative_and_its_integral() {
        // Source: exp(-2 t) sin(5 t), differentiated and integrated by hand.
        let c = series(|t| (-2.0 * t).exp() * (5.0 * t).sin());
        let d = derivative(&c);
        for t in [0.0f64, 0.2, 0.77, 1.0] {
            let e = (-2.0 * t).exp();
            let (s, k) = (5.0 * t).sin_cos();
            assert_relative_eq!(value(&c, t), e * s, epsilon = 1e-13);
            // x = 2 t - 1.
            let slope = 0.5 * e * (5.0 * k - 2.0 * s);
            assert_relative_eq!(value(&d, t), slope, epsilon = 1e-11);
            let area = (5.0 - e * (2.0 * s + 5.0 * k)) / 29.0;
            assert_relative_eq!(integral_to(&c, t), area, epsilon = 1e-13);
        }
    }

    #[test]
    fn val_halves_are_the_series_itself() {
        // Source: the whole series at the same places.
        let c = series(|t| (3.0 * t).cos() + t);
        for t in [0.0, 0.3, 0.9, 1.0] {
            assert_relative_eq!(
                value(&halves(&c)[0], t),
                value(&c, 0.5 * t),
                epsilon = 1e-14
            );
            let right = value(&c, 0.5 + 0.5 * t);
            assert_relative_eq!(value(&halves(&c)[1], t), right, epsilon = 1e-14);
        }
    }

    #[test]
    fn val_the_first_of_two_close_roots_is_found() {
        // Source: (t - 0.3)(t - 0.3001) is negative only on a ten-thousandth of the interval.
        let c = series(|t| (t - 0.3) * (t - 0.3001));
        assert_relative_eq!(first_below_zero(&c, 0.0).unwrap(), 0.3, epsilon = 1e-12);
        assert_eq!(first_below_zero(&c, 0.3002), None);
        let down = series(|t| (0.1 - t) * (t - 0.6) * (t - 0.9) * 10.0);
        assert_relative_eq!(first_below_zero(&down, 0.0).unwrap(), 0.1, epsilon = 1e-12);
        assert_relative_eq!(first_below_zero(&down, 0.65).unwrap(), 0.9, epsilon = 1e-12);
    }

    #[test]
    fn a_touch_is_no_crossing_and_overflow_ends_the_search() {
        assert_eq!(
            first_below_zero(&series(|t| (t - 0.5).powi(2) + 1e-12), 0.0),
            None
        );
        assert_eq!(first_below_zero(&[0.0; TERMS], 0.0), None);
        let mut c = [1.0; TERMS];
        c[3] = f64::NAN;
        assert_eq!(first_below_zero(&c, 0.0), None);
        c[3] = f64::INFINITY;
        assert_eq!(first_below_zero(&c, 0.0), None);
    }

    #[test]
    fn val_a_root_at_the_start_is_divided_out() {
        // Source: t (0.4 - t) exp(t) vanishes at 0 and at 0.4.
        let c = without_first_root(&series(|t| t * (0.4 - t) * t.exp()));
        assert_relative_eq!(first_below_zero(&c, 0.0).unwrap(), 0.4, epsilon = 1e-12);
    }
}
