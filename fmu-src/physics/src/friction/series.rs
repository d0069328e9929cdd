//! The friction laws that are sums of exponentials, and their power series along a motion.

use super::FrictionLaw;
use crate::integrate::LANES;
use crate::real::{Real, ZERO};

// The innermost loop of all: what costs least differs with the numbers.
#[cfg_attr(feature = "tangent", path = "series/coefficient_tangent.rs")]
mod coefficient;

pub use coefficient::{CoefficientRoom, CoefficientSeries};

/// `mu(v) = constant + linear v + sum weight_i exp(-rate_i a)` with `a = v` or `a = v^2`.
///
/// Eq. (7) of Stelter 1992 multiplied out, Coulomb's law, and the Stribeck curve with exponent 1 or 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExponentialSum {
    constant: Real,
    /// Coefficient in s/m.
    linear: Real,
    weight: [Real; LANES],
    /// Rates in s/m, or in s^2/m^2 where `squared`.
    rate: [Real; LANES],
    /// How many exponentials there are.
    count: usize,
    squared: bool,
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
mod tests {
    use super::*;
    use crate::friction::Exponential;
    use crate::integrate::MAX_DEGREE;
    use approx::assert_relative_eq;

    fn laws() -> [FrictionLaw; 4] {
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

    #[test]
    fn laws_with_corners_or_a_singularity_have_no_series() {
        let printed = FrictionLaw::StelterAsPrinted(Exponential::default());
        assert_eq!(printed.exponential_sum(), None);
    }
}
