//! The coefficient of friction along a motion, power by power.

use super::ExponentialSum;
use crate::integrate::series::{RECIPROCAL, Series, product};
use crate::integrate::{LANES, MAX_DEGREE};
use crate::real::{Real, ZERO};

/// Series that belong to a [`CoefficientSeries`]; those of the powers worked out so far are valid.
#[derive(Clone)]
pub struct CoefficientRoom {
    speed: Series,
    /// `k a_k` of the exponent's variable a.
    slope: Series,
    /// The weighted exponentials, power by power.
    terms: [[Real; LANES]; MAX_DEGREE + 1],
}

impl Default for CoefficientRoom {
    fn default() -> Self {
        Self {
            speed: [ZERO; MAX_DEGREE + 1],
            slope: [ZERO; MAX_DEGREE + 1],
            terms: [[ZERO; LANES]; MAX_DEGREE + 1],
        }
    }
}

/// The coefficient of friction along a motion as a power series, from the series of the speed.
pub struct CoefficientSeries<'a> {
    law: &'a ExponentialSum,
    /// Coefficient of the speed in s/m, of the law and of what is added to it.
    linear: Real,
    /// Derivatives of the weighted exponentials by a at the start.
    direct: [Real; LANES],
    /// The sum of these.
    stiffness: Real,
}

impl<'a> CoefficientSeries<'a> {
    /// A series without coefficients yet, with `added` times the speed (s/m) besides the law.
    #[inline]
    pub fn new(law: &'a ExponentialSum, added: Real) -> Self {
        Self {
            law,
            linear: law.linear + added,
            direct: [ZERO; LANES],
            stiffness: ZERO,
        }
    }

    /// Coefficient `k` of mu from coefficient `k` of the speed in m/s; to be asked for from 0 upwards.
    #[inline]
    pub fn next(&mut self, k: usize, speed: Real, room: &mut CoefficientRoom) -> Real {
        let law = self.law;
        if law.count == 0 {
            return self.linear * speed + if k == 0 { law.constant } else { ZERO };
        }
        let argument = if law.squared {
            room.speed[k] = speed;
            product(&room.speed, &room.speed, k)
        } else {
            speed
        };
        if k == 0 {
            let mut mu = law.constant + self.linear * speed;
            room.terms[0] = [ZERO; LANES];
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
    fn known(&self, k: usize, room: &CoefficientRoom) -> [Real; LANES] {
        let middle = k / 2;
        let (mut low, mut high) = ([ZERO; LANES], [ZERO; LANES]);
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
