//! The coefficient of friction along a motion with its derivatives, power by power.
//!
//! As [`ExponentialSum`] with unweighted exponentials `U_i = exp(-rate_i a)`: along each direction, with `d` for the derivative,
//! `d mu = d constant + v d linear + linear d v + sum U_i d weight_i - sum weight_i a U_i d rate_i + g d a`,
//! `g = -sum weight_i rate_i U_i`. The products are of series; `U_i`, `a U_i` and `g` have no directions, so that one sum over
//! directions is left where differentiating every exponential would need six.

use super::ExponentialSum;
use crate::integrate::series::{RECIPROCAL, Series, product};
use crate::integrate::{LANES, MAX_DEGREE};
use crate::tangent::{Slope, Tangent};

/// Series that belong to a [`CoefficientSeries`]; those of the powers worked out so far are valid.
#[derive(Clone)]
pub struct CoefficientRoom {
    speed: Series,
    /// The exponent's variable a.
    argument: [f64; MAX_DEGREE + 1],
    /// `k a_k`.
    slope: [f64; MAX_DEGREE + 1],
    /// Derivatives of a.
    moved: [Slope; MAX_DEGREE + 1],
    /// The exponentials, power by power.
    terms: [[f64; LANES]; MAX_DEGREE + 1],
    /// Derivative g of the coefficient by a.
    steepness: [f64; MAX_DEGREE + 1],
}

impl Default for CoefficientRoom {
    fn default() -> Self {
        Self {
            speed: [crate::tangent::ZERO; MAX_DEGREE + 1],
            argument: [0.0; MAX_DEGREE + 1],
            slope: [0.0; MAX_DEGREE + 1],
            moved: [Slope::NONE; MAX_DEGREE + 1],
            terms: [[0.0; LANES]; MAX_DEGREE + 1],
            steepness: [0.0; MAX_DEGREE + 1],
        }
    }
}

/// The coefficient of friction along a motion as a power series, from the series of the speed.
pub struct CoefficientSeries<'a> {
    law: &'a ExponentialSum,
    /// Coefficient of the speed in s/m, of the law and of what is added to it.
    linear: Tangent,
    /// Any rate has derivatives.
    rates_move: bool,
}

impl<'a> CoefficientSeries<'a> {
    /// A series without coefficients yet, with `added` times the speed (s/m) besides the law.
    #[inline(always)]
    pub fn new(law: &'a ExponentialSum, added: Tangent) -> Self {
        let moves = |rate: &Tangent| !rate.slope.is_none();
        Self {
            law,
            linear: law.linear + added,
            rates_move: law.rate[..law.count].iter().any(moves),
        }
    }

    /// Coefficient `k` of mu from coefficient `k` of the speed in m/s; to be asked for from 0 upwards.
    #[inline(always)]
    pub fn next(&mut self, k: usize, speed: Tangent, room: &mut CoefficientRoom) -> Tangent {
        let law = self.law;
        let mut mu = self.linear * speed;
        if k == 0 {
            mu += law.constant;
        }
        if law.count == 0 {
            return mu;
        }
        let argument = if law.squared {
            room.speed[k] = speed;
            product(&room.speed, &room.speed, k)
        } else {
            speed
        };
        room.argument[k] = argument.value;
        room.slope[k] = k as f64 * argument.value;
        room.moved[k] = argument.slope;
        let terms = self.terms(k, room);
        room.terms[k] = terms;
        room.steepness[k] = 0.0;
        for i in 0..law.count {
            mu.value += law.weight[i].value * terms[i];
            room.steepness[k] -= law.weight[i].value * law.rate[i].value * terms[i];
            mu.slope.add_times(&law.weight[i].slope, terms[i]);
        }
        if self.rates_move {
            let stretched = Self::stretched(k, room);
            for i in 0..law.count {
                let by_rate = law.weight[i].value * stretched[i];
                mu.slope.add_times(&law.rate[i].slope, -by_rate);
            }
        }
        for (g, moved) in room.steepness[..=k]
            .iter()
            .zip(room.moved[..=k].iter().rev())
        {
            mu.slope.add_times(moved, *g);
        }
        mu
    }

    /// Coefficients `k` of the exponentials: `-rate sum i a_i U_(k-i) / k` over i = 1 .. k.
    #[inline(always)]
    fn terms(&self, k: usize, room: &CoefficientRoom) -> [f64; LANES] {
        let law = self.law;
        if k == 0 {
            return law.rate.map(|rate| (-rate.value * room.argument[0]).exp());
        }
        let mut sum = [0.0; LANES];
        for (slope, term) in room.slope[1..=k].iter().zip(room.terms[..k].iter().rev()) {
            for lane in 0..LANES {
                sum[lane] += slope * term[lane];
            }
        }
        std::array::from_fn(|lane| -RECIPROCAL[k] * law.rate[lane].value * sum[lane])
    }

    /// Coefficients `k` of the products of a and the exponentials.
    #[inline(always)]
    fn stretched(k: usize, room: &CoefficientRoom) -> [f64; LANES] {
        let mut sum = [0.0; LANES];
        for (a, term) in room.argument[..=k]
            .iter()
            .zip(room.terms[..=k].iter().rev())
        {
            for lane in 0..LANES {
                sum[lane] += a * term[lane];
            }
        }
        sum
    }
}
