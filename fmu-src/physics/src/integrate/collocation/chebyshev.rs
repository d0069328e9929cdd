//! Chebyshev series on a step: values, integrals, and the first sign change, none missed.

use super::TERMS;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Coefficients of `sum c_k T_k(2 theta - 1)` on theta in [0, 1].
pub type Chebyshev = [f64; TERMS];

/// Halvings after which a touch without a sign change counts as no crossing.
const MAX_DEPTH: u32 = 48;
/// Share of a series below which its last terms do not matter for where it vanishes.
const ROUNDING: f64 = 1e-15;
/// Newton step, in half intervals, after which the next would be below rounding.
const LAST_STEP: f64 = 1e-8;

/// `LEFT[k]` = coefficients of `T_k((x - 1)/2)`, the polynomial T_k on the left half of its interval; on the right half the signs
/// of `k + m` odd are turned. From `T_(k+1)(y) = 2 y T_k(y) - T_(k-1)(y)`.
const LEFT: [Chebyshev; TERMS] = {
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
};

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

/// Value at `theta`, by Clenshaw's rule.
#[inline]
pub fn value(c: &[f64], theta: f64) -> f64 {
    at(c, 2.0 * theta - 1.0)
}

#[inline]
fn at(c: &[f64], x: f64) -> f64 {
    // What does not wait for the term before is summed first.
    let (mut b, mut before, twice) = (0.0, 0.0, 2.0 * x);
    for a in c[1..].iter().rev() {
        (b, before) = (twice * b + (a - before), b);
    }
    x * b - before + c[0]
}

/// All T_k at `theta`.
#[inline(always)]
pub(super) fn polynomials(theta: f64) -> Chebyshev {
    let x = 2.0 * theta - 1.0;
    let mut t = [1.0; TERMS];
    t[1] = x;
    for k in 2..TERMS {
        t[k] = 2.0 * x * t[k - 1] - t[k - 2];
    }
    t
}

/// Values of two series of the same length.
#[inline]
fn both(a: &[f64], b: &[f64], x: f64) -> [f64; 2] {
    let (mut f, mut g, twice) = ((0.0, 0.0), (0.0, 0.0), 2.0 * x);
    for (a, b) in a[1..].iter().zip(&b[1..]).rev() {
        f = (twice * f.0 + (a - f.1), f.0);
        g = (twice * g.0 + (b - g.1), g.0);
    }
    [x * f.0 + (a[0] - f.1), x * g.0 + (b[0] - g.1)]
}

/// Derivative by x = 2 theta - 1.
#[inline]
pub fn derivative(c: &Chebyshev) -> Chebyshev {
    let mut d = [0.0; TERMS];
    for k in (1..TERMS).rev() {
        let next = if k + 1 < TERMS { d[k + 1] } else { 0.0 };
        d[k - 1] = next + 2.0 * k as f64 * c[k];
    }
    d[0] *= 0.5;
    d
}

/// Value and derivative by theta at theta = 1: `T_k = 1` and `dT_k/dx = k^2` there.
pub fn end(c: &Chebyshev) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for (k, c) in c.iter().enumerate().rev() {
        value += c;
        slope += (2 * k * k) as f64 * c;
    }
    (value, slope)
}

/// Integral over theta times `length`, `start` at theta = 0.
#[inline]
pub fn integral(c: &Chebyshev, length: f64, start: f64) -> Chebyshev {
    let mut out = [0.0; TERMS];
    let quarter = 0.25 * length;
    out[1] = quarter * (2.0 * c[0] - c[2]);
    for k in 2..TERMS {
        let next = if k + 1 < TERMS { c[k + 1] } else { 0.0 };
        out[k] = (c[k - 1] - next) * (quarter * RECIPROCAL[k]);
    }
    let mut first = 0.0;
    for k in 1..TERMS {
        first += if k % 2 == 0 { out[k] } else { -out[k] };
    }
    out[0] = start - first;
    out
}

/// The series divided by theta, up to a constant factor, for one that vanishes at theta = 0 to rounding.
pub fn without_first_root(c: &Chebyshev) -> Chebyshev {
    // c = (1 + x) q; (1 + x) T_m = T_m + (T_(m+1) + T_|m-1|)/2, solved from the highest power down.
    let mut q = [0.0; TERMS + 1];
    for m in (2..TERMS).rev() {
        q[m - 1] = 2.0 * (c[m] - q[m]) - q[m + 1];
    }
    q[0] = c[1] - q[1] - 0.5 * q[2];
    std::array::from_fn(|k| q[k])
}

/// The series on the left half of its interval, or on the right one.
#[inline(always)]
fn half(c: &Chebyshev, right: bool) -> Chebyshev {
    let mut even = [0.0; TERMS];
    let mut odd = [0.0; TERMS];
    for k in (0..TERMS).step_by(2) {
        for m in 0..TERMS {
            even[m] = c[k].mul_add(LEFT[k][m], even[m]);
            odd[m] = c[k + 1].mul_add(LEFT[k + 1][m], odd[m]);
        }
    }
    if right {
        for m in (0..TERMS).step_by(2) {
            odd[m] = -odd[m];
            even[m + 1] = -even[m + 1];
        }
    }
    for m in 0..TERMS {
        even[m] += odd[m];
    }
    even
}

/// [`half`], for each instruction set.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
fn halved(c: &Chebyshev, right: bool) -> Chebyshev {
    half(c, right)
}

/// How many terms there are up to the last that is larger than `least`; at least 2.
pub fn terms(c: &Chebyshev, least: f64) -> usize {
    let small = c.iter().rev().take_while(|a| a.abs() <= least).count();
    (TERMS - small).max(2)
}

/// Sum of the magnitudes from term 1 on: as far as the series can be from its mean.
#[inline]
pub fn spread(c: &Chebyshev) -> f64 {
    let mut sums = [0.0; 8];
    for group in c.chunks_exact(8) {
        for (sum, a) in sums.iter_mut().zip(group) {
            *sum += a.abs();
        }
    }
    let [a, b, c_, d, e, f, g, h] = sums;
    ((a + b) + (c_ + d)) + ((e + f) + (g + h)) - c[0].abs()
}

/// The first theta in `(low, 1]` at which the series falls below zero, provided it is not negative at `low` >= 0.
///
/// Rigorous as `integrate::roots`: since `|T_k| <= 1`, a stretch is dropped only if its coefficients prove that the series
/// can't vanish there, and a root is sought only where those of the derivative prove it monotone.
pub fn first_below_zero(c: &Chebyshev, low: f64) -> Option<f64> {
    search(c, 0.0, 1.0, low, 0)
}

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
        let last: f64 = c.iter().sum();
        if !(last < 0.0) {
            return None;
        }
        let begin = ((low - middle) / (to - middle)).max(-1.0);
        let x = polish(c, &slope, begin);
        return Some(middle + x * (to - middle));
    }
    if depth == MAX_DEPTH {
        return (c.iter().sum::<f64>() < 0.0).then_some(to);
    }
    let first = search(&halved(c, false), from, middle, low, depth + 1);
    if first.is_some() {
        return first;
    }
    if middle > low && at(c, 0.0) < 0.0 {
        return Some(middle);
    }
    search(&halved(c, true), middle, to, low, depth + 1)
}

/// The root in [low, 1] of a monotone series that is negative at 1: Newton's method, kept inside by bisection.
fn polish(c: &Chebyshev, slope: &Chebyshev, low: f64) -> f64 {
    let used = terms(c, ROUNDING * spread(c));
    let (c, slope) = (&c[..used], &slope[..used]);
    let (mut low, mut high) = (low, 1.0);
    let (f_low, f_high) = (at(c, low), at(c, high));
    if f_low <= 0.0 {
        return low;
    }
    let mut x = (low * f_high - high * f_low) / (f_high - f_low);
    for _ in 0..100 {
        if !(x > low && x < high) {
            x = 0.5 * (low + high);
        }
        let [f, rise] = both(c, slope, x);
        if f > 0.0 {
            low = x;
        } else {
            high = x;
        }
        let step = f / rise;
        x -= step;
        if step.abs() <= LAST_STEP || high - low <= 4.0 * f64::EPSILON {
            break;
        }
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
        let i = integral(&c, 1.0, 0.25);
        for t in [0.0f64, 0.2, 0.77, 1.0] {
            let e = (-2.0 * t).exp();
            let (s, k) = (5.0 * t).sin_cos();
            assert_relative_eq!(value(&c, t), e * s, epsilon = 1e-13);
            // x = 2 t - 1.
            let slope = 0.5 * e * (5.0 * k - 2.0 * s);
            assert_relative_eq!(value(&d, t), slope, epsilon = 1e-11);
            let area = (5.0 - e * (2.0 * s + 5.0 * k)) / 29.0;
            assert_relative_eq!(value(&i, t), 0.25 + area, epsilon = 1e-13);
        }
    }

    #[test]
    fn val_halves_are_the_series_itself() {
        // Source: the whole series at the same places.
        let c = series(|t| (3.0 * t).cos() + t);
        for t in [0.0, 0.3, 0.9, 1.0] {
            assert_relative_eq!(
                value(&halved(&c, false), t),
                value(&c, 0.5 * t),
                epsilon = 1e-14
            );
            let right = value(&c, 0.5 + 0.5 * t);
            assert_relative_eq!(value(&halved(&c, true), t), right, epsilon = 1e-14);
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
