//! The force over the sliding speed, at all nodes at once.

use super::nodes::largest;
use super::{NODES, Nodes, Tangent};
use std::f64::consts::{E, LOG2_E};

/// `p(u) = constant + linear u + w_0 e_0 + w_1 e_1 + w_2 e_0 e_1` in N, with `e_i = exp(-rate_i a)` and `a = u`, or `a = u^2`
/// where `squared`; u in m/s.
///
/// The friction laws that are products or sums of two exponentials, multiplied by the normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Characteristic {
    /// Force in N.
    pub constant: f64,
    /// Force per speed in N s/m.
    pub linear: f64,
    /// Forces in N.
    pub weight: [f64; 3],
    /// Rates in s/m, or in s^2/m^2 where `squared`.
    pub rate: [f64; 2],
    /// Whether the exponentials depend on the square of the speed.
    pub squared: bool,
}

impl Characteristic {
    /// Speed in m/s over which the force changes most.
    pub fn scale(&self) -> f64 {
        let rate = self.rate[0].max(self.rate[1]);
        let rate = if self.squared { rate.sqrt() } else { rate };
        // Laws without exponentials do not bend at all.
        if rate > 0.0 { 1.0 / rate } else { 1.0 }
    }

    /// The tangent at a speed in m/s.
    pub fn tangent(&self, speed: f64) -> Tangent {
        let (force, slope, _) = self.at(&[speed; NODES]);
        Tangent {
            speed,
            force: force[0],
            slope: slope[0],
        }
    }

    /// A bound of the third derivative in N s^3/m^3.
    ///
    /// That of `exp(-r u)` is less than 2 r^3 for u > -0.5/r, and that of `exp(-r u^2)` less than 5 r^1.5.
    pub fn third(&self) -> f64 {
        let [a, b, both] = self.weight;
        let [x, y] = self.rate;
        let of = |weight: f64, rate: f64| {
            let rate = rate.abs();
            weight.abs()
                * if self.squared {
                    5.0 * rate * rate.sqrt()
                } else {
                    2.0 * rate * rate * rate
                }
        };
        of(a, x) + of(b, y) + of(both, x + y)
    }

    /// A bound of the third derivative in N s^3/m^3 within half the [`scale`](Self::scale) of speeds at which half the second
    /// derivative is known, in N s^2/m^2.
    ///
    /// Where all exponentials pull the same way, `|p'''| <= r |p''|` with the sum r of both rates, and over `0.5 scale` p''
    /// changes by no more than `exp(0.5 r scale) <= e` times.
    #[inline(always)]
    pub fn third_near(&self, half_bend: &Nodes) -> f64 {
        let everywhere = self.third();
        let alike = self.weight.iter().all(|w| *w >= 0.0) || self.weight.iter().all(|w| *w <= 0.0);
        if self.squared || !alike || self.rate.iter().any(|r| *r < 0.0) {
            return everywhere;
        }
        let bend = 2.0 * largest(&half_bend.map(f64::abs));
        everywhere.min(E * (self.rate[0] + self.rate[1]) * bend)
    }

    /// Force in N, its slope in N s/m, and half its second derivative in N s^2/m^2.
    #[inline(always)]
    pub fn at(&self, u: &Nodes) -> (Nodes, Nodes, Nodes) {
        let (mut force, mut slope, mut half_bend) = ([0.0; NODES], [0.0; NODES], [0.0; NODES]);
        let (mut first, mut second) = ([0.0; NODES], [0.0; NODES]);
        let mut inner = [1.0; NODES];
        for i in 0..NODES {
            let a = if self.squared { u[i] * u[i] } else { u[i] };
            if self.squared {
                inner[i] = 2.0 * u[i];
            }
            first[i] = exponential(-self.rate[0] * a);
            second[i] = exponential(-self.rate[1] * a);
        }
        let [a, b, both] = self.weight;
        let r = [self.rate[0], self.rate[1], self.rate[0] + self.rate[1]];
        let outer = if self.squared { 1.0 } else { 0.0 };
        for i in 0..NODES {
            let (x, y) = (first[i], second[i]);
            let (x, y, xy) = (a * x, b * y, both * (x * y));
            force[i] = self.linear.mul_add(u[i], self.constant) + (x + y + xy);
            // By a, and twice by a.
            let once = r[0] * x + r[1] * y + r[2] * xy;
            let twice = r[0] * (r[0] * x) + r[1] * (r[1] * y) + r[2] * (r[2] * xy);
            slope[i] = self.linear - inner[i] * once;
            half_bend[i] = 0.5 * inner[i] * inner[i] * twice - outer * once;
        }
        (force, slope, half_bend)
    }
}

/// exp(x) to 1e-15 of its value for |x| < 700, beyond which it stays constant.
///
/// `exp(x) = 2^n exp(r)`, n the integer next to x / ln 2, exp(r) by its Taylor polynomial of degree 12 on |r| < 0.35. Without
/// branches, so that a loop over a list becomes vector instructions; ln 2 in two parts after Cody and Waite (1980).
#[inline(always)]
fn exponential(x: f64) -> f64 {
    // Added and taken away, it rounds to an integer, which then stands in the last bits of the sum.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    const C: [f64; 13] = {
        let mut c = [1.0; 13];
        let mut k = 1;
        while k < 13 {
            c[k] = c[k - 1] / k as f64;
            k += 1;
        }
        c
    };
    let x = x.clamp(-700.0, 700.0);
    let shifted = x.mul_add(LOG2_E, ROUND);
    let n = shifted - ROUND;
    let r = n.mul_add(-LN2_LOW, n.mul_add(-LN2_HIGH, x));
    let r2 = r * r;
    let r4 = r2 * r2;
    let pair = |k: usize| C[k + 1].mul_add(r, C[k]);
    let low = r2.mul_add(pair(2), pair(0));
    let middle = r2.mul_add(pair(6), pair(4));
    let high = r4.mul_add(C[12], r2.mul_add(pair(10), pair(8)));
    let power = r4.mul_add(r4.mul_add(high, middle), low);
    f64::from_bits(power.to_bits().wrapping_add(shifted.to_bits() << 52))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn val_the_exponential_is_that_of_the_library() {
        // Source: f64::exp.
        for i in -6990..=6990 {
            let x = 0.1 * f64::from(i);
            assert_relative_eq!(exponential(x), x.exp(), max_relative = 2e-15);
        }
        assert_relative_eq!(exponential(0.0), 1.0);
        assert!(exponential(1e9).is_finite() && exponential(-1e9) >= 0.0);
    }

    #[test]
    fn val_slopes_are_differences() {
        // Source: central differences of the force.
        for squared in [false, true] {
            let law = Characteristic {
                constant: 3.0,
                linear: 0.7,
                weight: [4.0, -2.0, 1.5],
                rate: [5.0, 0.3],
                squared,
            };
            let at = |h: f64| law.at(&std::array::from_fn(|i| 0.05 * i as f64 + h));
            let ((_, slope, bend), low, high) = (at(0.0), at(-1e-5), at(1e-5));
            for i in 0..NODES {
                let difference = (high.0[i] - low.0[i]) / 2e-5;
                assert_relative_eq!(slope[i], difference, max_relative = 1e-7);
                let difference = (high.1[i] - low.1[i]) / 4e-5;
                assert_relative_eq!(bend[i], difference, max_relative = 1e-7);
                let third = (high.2[i] - low.2[i]) / 1e-5;
                assert!(third.abs() <= law.third(), "{third}");
            }
        }
    }

    #[test]
    fn val_the_third_derivative_is_bounded_near_known_speeds() {
        // Source: differences of the second derivative.
        let law = Characteristic {
            constant: 3.0,
            linear: 0.7,
            weight: [4.0, 2.0, 1.5],
            rate: [50.0, 0.3],
            squared: false,
        };
        for i in 0..20 {
            let known = 0.01 * f64::from(i);
            let bound = law.third_near(&law.at(&[known; NODES]).2);
            for j in -10..=10 {
                let speed = known + 0.05 * f64::from(j) * law.scale();
                let (low, high) = (law.at(&[speed; NODES]), law.at(&[speed + 1e-6; NODES]));
                let third = (high.2[0] - low.2[0]) / 0.5e-6;
                assert!(third.abs() <= bound, "{third} {bound}");
            }
        }
        let bound = law.third_near(&law.at(&[0.2; NODES]).2);
        assert!(bound < 1e-3 * law.third(), "{bound}");
    }
}
