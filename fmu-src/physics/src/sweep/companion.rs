//! The largest Lyapunov exponent from a second motion that starts close by.
//!
//! Both motions run through their own transitions, so what happens to a difference there (saltation) is in the result
//! without a formula of its own, hidden memories as dwell times included.

use super::follow::{Crossing, Follower};
use super::run::Run;
use crate::contact::ContactMode;
use crate::error::PhysicsError;
use crate::integrate::{MAX_STATES, State};
use crate::model::Model;
use crate::simulate::{Start, StartContact};

/// Distance of the motions as a share of the amplitude.
const APART: f64 = 1e-6;
/// Growth factors below this are lost in the integration's error: the difference has died out.
const LOST: f64 = 3e-4;
/// Share of the growths at the begin that are left out, while the difference turns into its own direction.
const ALIGNING: usize = 10;

/// A motion beside the one that is measured, put back to a small distance at every peak.
pub(super) struct Companion {
    run: Run,
    /// The size that counts of each state, in m per its unit.
    weight: State,
    apart: f64,
    tolerance: f64,
    /// The model depends on time, or on the place on the belt: then a shift in time is a difference too.
    driven: bool,
    /// ln(growth) and time in s of each stretch.
    growths: Vec<(f64, f64)>,
    last: Option<f64>,
    lost: bool,
}

impl Companion {
    /// Beside a motion with this amplitude in m.
    pub(super) fn new(follower: &Follower, amplitude: f64, tolerance: f64) -> Self {
        let run = follower.run().clone();
        let model = run.model();
        let scales = model.state_scales();
        let mut weight = [0.0; MAX_STATES];
        let modes = model.beam().modes();
        for (j, m) in modes.iter().enumerate() {
            weight[2 * j] = m.tip_value.abs();
            weight[2 * j + 1] = m.tip_value.abs() / m.angular_frequency();
        }
        for i in 2 * modes.len()..model.dimension() {
            weight[i] = amplitude / (100.0 * scales[i]);
        }
        Self {
            driven: is_driven(model),
            run,
            weight,
            apart: APART * amplitude,
            tolerance,
            growths: Vec::new(),
            last: None,
            lost: false,
        }
    }

    fn norm(&self, difference: &State) -> f64 {
        let parts = difference.iter().zip(&self.weight).map(|(d, w)| d * w);
        parts.map(|d| d * d).sum::<f64>().sqrt()
    }

    /// Measures the difference at a peak of the motion, and starts from a small one again.
    pub(super) fn meet(
        &mut self,
        follower: &Follower,
        peak: &Crossing,
        mode: ContactMode,
    ) -> Result<(), PhysicsError> {
        if self.lost {
            return Ok(());
        }
        let model = follower.run().model();
        let mut rates = [0.0; MAX_STATES];
        model.rates(peak.time, &peak.state, mode, &mut rates);
        let mut difference = [0.0; MAX_STATES];
        if let Some(since) = self.last {
            let x = self.run.advance_to(peak.time)?;
            for i in 0..MAX_STATES {
                difference[i] = x[i] - peak.state[i];
            }
            self.take_out_the_flow(follower, &rates, &mut difference);
            let size = self.norm(&difference);
            self.growths
                .push(((size / self.apart).ln(), peak.time - since));
            if !(size > LOST * self.apart) {
                self.lost = true;
                return Ok(());
            }
        } else {
            // Any direction that is not the flow's will turn into the one that grows most.
            for (i, m) in model.beam().modes().iter().enumerate() {
                difference[2 * i] = 1.0 / (1.0 + i as f64);
                difference[2 * i + 1] = 0.3 * m.angular_frequency() / (2.0 + i as f64);
            }
            self.take_out_the_flow(follower, &rates, &mut difference);
        }
        let factor = self.apart / self.norm(&difference);
        let mut state = peak.state;
        for i in 0..MAX_STATES {
            state[i] += factor * difference[i];
        }
        let motion = model.motion(peak.time, &peak.state, mode);
        let start = Start {
            time: peak.time,
            state,
            contact: StartContact::Slip,
            belt_travel: motion.travel,
            ..Start::default()
        };
        self.run.restart(&start, self.tolerance)?;
        self.last = Some(peak.time);
        Ok(())
    }

    /// Shifts the companion along the flow to its own peak: a mere delay is no difference of motions.
    fn take_out_the_flow(&self, follower: &Follower, rates: &State, difference: &mut State) {
        if self.driven {
            return;
        }
        let slope = follower.velocity(rates);
        if slope == 0.0 {
            return;
        }
        let delay = follower.velocity(difference) / slope;
        for i in 0..MAX_STATES {
            difference[i] -= delay * rates[i];
        }
    }

    /// The exponent in 1/s: `lambda = sum ln(growth) / time`; minus infinity where the difference died out.
    pub(super) fn exponent(&self) -> Option<f64> {
        if self.lost {
            return Some(f64::NEG_INFINITY);
        }
        let counted = &self.growths[self.growths.len() / ALIGNING..];
        let (growth, time) = counted
            .iter()
            .fold((0.0, 0.0), |(g, t), (a, b)| (g + a, t + b));
        (time > 0.0).then_some(growth / time)
    }
}

/// Whether the equations depend on time or on the place on the belt, found by trying.
pub(super) fn is_driven(model: &Model) -> bool {
    let mut x = [0.0; MAX_STATES];
    for i in 0..model.dimension() {
        x[i] = 1e-5 * (1.0 + i as f64);
    }
    let look = |t: f64, mode: ContactMode| {
        let mut rates = [0.0; MAX_STATES];
        let mut model = model.clone();
        model.stick_since = t;
        model.rates(t, &x, mode, &mut rates);
        let limit = model.static_limit(t, &x);
        (rates, limit)
    };
    [
        ContactMode::Backward,
        ContactMode::Forward,
        ContactMode::Stuck,
    ]
    .into_iter()
    .any(|mode| {
        let first = look(0.0, mode);
        [0.0137, 0.171, 1.93, 7.7]
            .iter()
            .any(|t| look(*t, mode) != first)
    })
}
