//! The friction laws that are sums of exponentials, and their power series along a motion.

use super::FrictionLaw;
use crate::integrate::LANES;
use crate::real::{Real, ZERO, value};

// The innermost loop of all: what costs least differs with the numbers.
#[cfg_attr(feature = "tangent", path = "series/coefficient_tangent.rs")]
mod coefficient;

pub use coefficient::{CoefficientRoom, CoefficientSeries};

/// Exponent from which on an exponential is less than the rounding of 1, `-ln(2^-52)`.
const NOTHING: f64 = 36.05;

/// `mu(v) = constant + linear v + sum weight_i exp(-rate_i a)` with `a = v` or `a = v^2`.
///
/// Eq. (7) of Stelter 1992 multiplied out, Coulomb's law, and the Stribeck curve with exponent 1 or 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExponentialSum {
    pub(super) constant: Real,
    /// Coefficient in s/m.
    pub(super) linear: Real,
    pub(super) weight: [Real; LANES],
    /// Rates in s/m, or in s^2/m^2 where `squared`. A third is the sum of the first two.
    pub(super) rate: [Real; LANES],
    /// How many exponentials there are.
    count: usize,
    pub(super) squared: bool,
}

impl ExponentialSum {
    /// Normalised time up to `reach` within which the series of every exponential is good, given those of the speed in m/s (at
    /// least 0 at the start): its exponent changes by no more than the degree, or it is nothing beside a friction coefficient
    /// however the change is directed: cut, its series is off by less than `e^-(z - change)` for the exponent z of the start.
    ///
    /// An exponential that is next to nothing where a step begins, `e^-80` at 1.6 m/s, stands in none of the coefficients that end
    /// the step and may be all that counts at its end. `exp(z)` cut after z^N is told from its last term, 9 % of it for N = 20,
    /// as long as z <= N.
    pub fn reach(&self, speed: &[Real], reach: f64) -> f64 {
        let degree = (speed.len() - 1) as f64;
        let start = value(speed[0]).abs();
        let exponent = |rate: f64, speed: f64| match self.squared {
            true => rate * speed * speed,
            false => rate * speed,
        };
        let rates = self.rate.map(value);
        // What begins within the degree can only fall by more.
        let falls = |rate: &f64| exponent(*rate, start) > degree;
        if !rates[..self.count].iter().any(falls) {
            return reach;
        }
        // Written so that what is no number ends the step nowhere: the motion runs away by itself.
        let is_lost = |rate: &f64, change: f64| {
            let by = match self.squared {
                true => change * (2.0 * start + change),
                false => change,
            };
            rate * by > degree && exponent(*rate, (start - change).max(0.0)) < NOTHING
        };
        let mut reach = reach;
        loop {
            let terms = speed[1..].iter().rev().map(|c| value(*c).abs());
            let change = terms.fold(0.0, |sum, c| (sum + c) * reach);
            let mut falling = rates[..self.count].iter().filter(|rate| falls(rate));
            if !falling.any(|rate| is_lost(rate, change)) {
                return reach;
            }
            reach *= 0.5;
        }
    }
}

impl FrictionLaw {
    /// The law as a sum of exponentials for speeds v >= 0; `None` where it is not one.
    pub fn exponential_sum(&self) -> Option<ExponentialSum> {
        let constant = |constant| ExponentialSum {
            constant,
            linear: ZERO,
            weight: [ZERO; LANES],
            rate: [ZERO; LANES],
            count: 0,
            squared: false,
        };
        match self {
            Self::Stelter(p) => {
                let (fast, slow) = (1.0 / p.v1, p.c2);
                let (a, b) = (1.0 - p.a1, 1.0 - p.a2);
                Some(ExponentialSum {
                    weight: [
                        p.mu_0 * p.a1 * b,
                        p.mu_0 * a * p.a2,
                        p.mu_0 * p.a1 * p.a2,
                        ZERO,
                    ],
                    rate: [fast, slow, fast + slow, ZERO],
                    count: 3,
                    ..constant(p.mu_0 * a * b)
                })
            }
            Self::Coulomb { mu_k, .. } => Some(constant(*mu_k)),
            Self::Stribeck {
                mu_s,
                mu_k,
                velocity,
                exponent,
                viscous,
            } if *exponent == 1.0 || *exponent == 2.0 => Some(ExponentialSum {
                linear: *viscous,
                weight: [mu_s - mu_k, ZERO, ZERO, ZERO],
                rate: [velocity.powf(-*exponent), ZERO, ZERO, ZERO],
                count: 1,
                squared: *exponent == 2.0,
                ..constant(*mu_k)
            }),
            Self::Stribeck { .. } | Self::StelterAsPrinted(_) | Self::Table(_) => None,
        }
    }
}

#[cfg(all(test, not(feature = "tangent")))]
pub(super) mod tests {
    use super::*;
    use crate::friction::Exponential;
    use crate::integrate::MAX_DEGREE;
    use approx::assert_relative_eq;

    /// One law of each kind.
    pub fn laws() -> [FrictionLaw; 4] {
        let stribeck = |exponent| FrictionLaw::Stribeck {
            mu_s: 0.66,
            mu_k: 0.3,
            velocity: 0.03,
            exponent,
            viscous: 0.2,
        };
        [
            FrictionLaw::Stelter(Exponential::default()),
            FrictionLaw::Coulomb {
                mu_s: 0.6,
                mu_k: 0.4,
            },
            stribeck(1.0),
            stribeck(2.0),
        ]
    }

    #[test]
    fn val_the_series_sums_to_the_law() {
        // Source: FrictionLaw::coefficient along v = 0.01 + 0.004 theta - 0.001 theta^2.
        let speed = [0.01, 0.004, -0.001];
        for law in laws() {
            let sum = law.exponential_sum().unwrap();
            let mut series = CoefficientSeries::new(&sum, 0.0);
            let mut room = CoefficientRoom::default();
            let c: Vec<f64> = (0..=MAX_DEGREE)
                .map(|k| series.next(k, speed.get(k).copied().unwrap_or(0.0), &mut room))
                .collect();
            for theta in [0.0, 0.3, 1.0] {
                let at = |c: &[f64]| c.iter().rev().fold(0.0, |s, a| s * theta + a);
                assert_relative_eq!(at(&c), law.coefficient(at(&speed)), max_relative = 1e-13);
            }
        }
    }

    /// How far a step may go whose speed in m/s is `start + change theta`, by a law with an exponent of 1000 s/m times the speed.
    fn reach_along(start: f64, change: f64) -> f64 {
        let law = FrictionLaw::Stribeck {
            mu_s: 0.66,
            mu_k: 0.3,
            velocity: 1e-3,
            exponent: 1.0,
            viscous: 0.0,
        };
        let mut speed = [0.0; MAX_DEGREE + 1];
        (speed[0], speed[1]) = (start, change);
        law.exponential_sum().unwrap().reach(&speed, 1.0)
    }

    #[test]
    fn a_step_ends_before_an_exponential_comes_up_by_more_than_its_series_can_follow() {
        // From an exponent of 200 to 10 would be too far; to 105 there is nothing yet.
        assert_eq!(reach_along(0.2, -0.19), 0.5);
        // From 40 the series follows by as many as its degree at a time.
        assert_eq!(reach_along(0.04, -0.039), 0.5);
    }

    #[test]
    fn an_exponential_that_is_nothing_all_along_ends_no_step() {
        assert_eq!(reach_along(0.2, -0.16), 1.0);
        // The terms of the series do not ask for the sign of the change.
        assert_eq!(reach_along(0.2, 0.16), 1.0);
        assert_eq!(reach_along(0.2, 0.18), 0.5);
    }

    #[test]
    fn what_is_no_number_ends_no_step() {
        assert_eq!(reach_along(0.2, f64::NAN), 1.0);
        assert_eq!(reach_along(f64::INFINITY, -0.1), 1.0);
    }

    #[test]
    fn laws_with_corners_or_a_singularity_have_no_series() {
        let printed = FrictionLaw::StelterAsPrinted(Exponential::default());
        assert_eq!(printed.exponential_sum(), None);
    }
}
