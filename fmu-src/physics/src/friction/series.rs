//! The friction laws that are sums of exponentials, and their power series along a motion.

use super::FrictionLaw;
use crate::integrate::series::{RECIPROCAL, Series, product};
use crate::integrate::{LANES, MAX_DEGREE};

/// `mu(v) = constant + linear v + sum weight_i exp(-rate_i a)` with `a = v` or `a = v^2`.
///
/// Eq. (7) of Stelter 1992 multiplied out, Coulomb's law, and the Stribeck curve with exponent 1 or 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExponentialSum {
    constant: f64,
    /// Coefficient in s/m.
    linear: f64,
    weight: [f64; LANES],
    /// Rates in s/m, or in s^2/m^2 where `squared`.
    rate: [f64; LANES],
    /// How many exponentials there are.
    count: usize,
    squared: bool,
}

impl FrictionLaw {
    /// The law as a sum of exponentials for speeds v >= 0; `None` where it is not one.
    pub fn exponential_sum(&self) -> Option<ExponentialSum> {
        let constant = |constant| ExponentialSum {
            constant,
            linear: 0.0,
            weight: [0.0; LANES],
            rate: [0.0; LANES],
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
                        0.0,
                    ],
                    rate: [fast, slow, fast + slow, 0.0],
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
                weight: [mu_s - mu_k, 0.0, 0.0, 0.0],
                rate: [velocity.powf(-exponent), 0.0, 0.0, 0.0],
                count: 1,
                squared: *exponent == 2.0,
                ..constant(*mu_k)
            }),
            Self::Stribeck { .. } | Self::StelterAsPrinted(_) | Self::Table(_) => None,
        }
    }
}

/// Series that belong to a [`CoefficientSeries`]; those of the powers worked out so far are valid.
#[derive(Clone)]
pub struct CoefficientRoom {
    speed: Series,
    /// `k a_k` of the exponent's variable a.
    slope: Series,
    /// The weighted exponentials, power by power.
    terms: [[f64; LANES]; MAX_DEGREE + 1],
}

impl Default for CoefficientRoom {
    fn default() -> Self {
        Self {
            speed: [0.0; MAX_DEGREE + 1],
            slope: [0.0; MAX_DEGREE + 1],
            terms: [[0.0; LANES]; MAX_DEGREE + 1],
        }
    }
}

/// The coefficient of friction along a motion as a power series, from the series of the speed.
pub struct CoefficientSeries<'a> {
    law: &'a ExponentialSum,
    /// Coefficient of the speed in s/m, of the law and of what is added to it.
    linear: f64,
    /// Derivatives of the weighted exponentials by a at the start.
    direct: [f64; LANES],
    /// The sum of these.
    stiffness: f64,
}

impl<'a> CoefficientSeries<'a> {
    /// A series without coefficients yet, with `added` times the speed (s/m) besides the law.
    #[inline]
    pub fn new(law: &'a ExponentialSum, added: f64) -> Self {
        Self {
            law,
            linear: law.linear + added,
            direct: [0.0; LANES],
            stiffness: 0.0,
        }
    }

    /// Coefficient `k` of mu from coefficient `k` of the speed in m/s; to be asked for from 0 upwards.
    #[inline]
    pub fn next(&mut self, k: usize, speed: f64, room: &mut CoefficientRoom) -> f64 {
        let law = self.law;
        if law.count == 0 {
            return self.linear * speed + if k == 0 { law.constant } else { 0.0 };
        }
        let argument = if law.squared {
            room.speed[k] = speed;
            product(&room.speed, &room.speed, k)
        } else {
            speed
        };
        if k == 0 {
            let mut mu = law.constant + self.linear * speed;
            room.terms[0] = [0.0; LANES];
            for i in 0..law.count {
                let term = law.weight[i] * (-law.rate[i] * argument).exp();
                room.terms[0][i] = term;
                self.direct[i] = -law.rate[i] * term;
                self.stiffness += self.direct[i];
                mu += term;
            }
            return mu;
        }
        // e' = -rate a' e: what a_k itself brings apart, as the one part that has to wait for it.
        let known = self.known(k, room);
        room.slope[k] = k as f64 * argument;
        for lane in 0..LANES {
            room.terms[k][lane] = self.direct[lane] * argument + known[lane];
        }
        let sum = (known[0] + known[1]) + (known[2] + known[3]) + self.linear * speed;
        self.stiffness * argument + sum
    }

    /// What the coefficients below `k` contribute to those of power `k` of the exponentials:
    /// `-rate sum i a_i e_(k-i) / k` over i = 1 .. k-1.
    ///
    /// The sum runs from its middle outwards, so that what was found last is needed last.
    #[inline]
    fn known(&self, k: usize, room: &CoefficientRoom) -> [f64; LANES] {
        let middle = k / 2;
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        let inner = room.slope[1..=middle].iter().rev();
        for (slope, e) in inner.zip(&room.terms[k - middle..k]) {
            for lane in 0..LANES {
                low[lane] += slope * e[lane];
            }
        }
        let outer = room.slope[middle + 1..k].iter();
        for (slope, e) in outer.zip(room.terms[1..k - middle].iter().rev()) {
            for lane in 0..LANES {
                high[lane] += slope * e[lane];
            }
        }
        let share = -RECIPROCAL[k];
        std::array::from_fn(|lane| share * self.law.rate[lane] * (low[lane] + high[lane]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::Exponential;
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
