//! Slip of the reference model alone, the motion that is computed most.

use super::Workspace;
use crate::beam::MAX_MODES;
use crate::contact::ContactMode;
use crate::friction::series::{CoefficientSeries, ExponentialSum};
use crate::integrate::series::RECIPROCAL;
use crate::integrate::taylor::SeriesSystem;
use crate::integrate::{MAX_DEGREE, State};
use crate::model::Model;
use crate::real::{Real, ZERO};

/// The reference model in slip. Signs and factors are folded into the coefficients beforehand, because
/// each power waits for the one before.
pub(super) struct BaseSeries<'a> {
    model: &'a Model,
    belt_velocity: [Real; 2],
    normal_force: [Real; 2],
    external_force: [Real; 2],
    clamp_acceleration: [Real; 2],
    /// Sliding speed per modal velocity.
    row: [Real; MAX_MODES],
    /// Modal acceleration per coefficient of friction and normal force, in m/(s^2 N).
    drive: [Real; MAX_MODES],
    friction: CoefficientSeries<'a>,
    pub(super) room: &'a mut Workspace,
    /// Coefficient of friction of the power before.
    mu_before: Real,
}

impl<'a> BaseSeries<'a> {
    #[cfg_attr(feature = "tangent", inline(always))]
    #[cfg_attr(not(feature = "tangent"), inline)]
    pub(super) fn new(
        model: &'a Model,
        law: &'a ExponentialSum,
        mode: ContactMode,
        t: Real,
        room: &'a mut Workspace,
    ) -> Self {
        let [
            mut belt_velocity,
            normal_force,
            external_force,
            clamp_acceleration,
        ] = model.given(t, model.series_unit);
        let sign = mode.sign();
        belt_velocity.iter_mut().for_each(|v| *v *= sign);
        let scale = -sign * model.level;
        Self {
            model,
            belt_velocity,
            normal_force,
            external_force,
            clamp_acceleration,
            row: model.tip_value.map(|phi| sign * phi),
            drive: model.gain.map(|gain| gain * scale),
            friction: CoefficientSeries::new(law, model.friction_slope),
            room,
            mu_before: ZERO,
        }
    }

    /// Works out the sliding speed.
    #[cfg_attr(feature = "tangent", inline(always))]
    #[cfg_attr(not(feature = "tangent"), inline)]
    pub(super) fn observe(&mut self, k: usize, x: &State) -> Real {
        let mut speed = ZERO;
        for j in 0..self.model.mode_count {
            speed += self.row[j] * x[2 * j + 1];
        }
        if k < 2 {
            speed -= self.belt_velocity[k];
        }
        self.room.motion.speed[k] = speed;
        speed
    }
}

impl BaseSeries<'_> {
    /// Whether the normal force stays positive up to `theta`.
    pub(super) fn holds(&self, theta: f64) -> bool {
        let [force, rate] = self.normal_force;
        force + rate * theta >= 0.0
    }
}

impl SeriesSystem for BaseSeries<'_> {
    fn dimension(&self) -> usize {
        self.model.dimension
    }

    #[cfg_attr(feature = "tangent", inline(always))]
    #[cfg_attr(not(feature = "tangent"), inline)]
    fn extend(&mut self, k: usize, coefficients: &mut [State; MAX_DEGREE + 1]) {
        let m = self.model;
        let (known, next) = coefficients.split_at_mut(k + 1);
        let (x, next) = (&known[k], &mut next[0]);
        let speed = self.observe(k, x);
        let mu = self.friction.next(k, speed, &mut self.room.friction);
        let [force, rate] = self.normal_force;
        let ramp = rate * self.mu_before;
        self.mu_before = mu;
        let step = m.series_unit * RECIPROCAL[k + 1];
        for j in 0..m.mode_count {
            let (q, v) = (x[2 * j], x[2 * j + 1]);
            let drive = step * self.drive[j];
            let rest = drive * ramp - step * (m.damping[j] * v + m.stiffness[j] * q);
            next[2 * j] = step * v;
            next[2 * j + 1] = drive * force * mu + rest;
        }
        if k < 2 {
            for j in 0..m.mode_count {
                let given = m.gain[j] * self.external_force[k]
                    - m.clamp_participation[j] * self.clamp_acceleration[k];
                next[2 * j + 1] += step * given;
            }
        }
    }
}
