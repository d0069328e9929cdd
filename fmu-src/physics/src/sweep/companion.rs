//! A second motion that starts close by, for exponents of models whose runs carry no difference along.
//!
//! Both motions run through their own transitions, so what happens to a difference there (saltation) is in the result
//! without a formula of its own, hidden memories as dwell times included.

use super::exponent::{Norm, across, any_direction};
use super::follow::{Crossing, Follower};
use super::run::Run;
use crate::contact::ContactMode;
use crate::error::PhysicsError;
use crate::integrate::MAX_STATES;
use crate::model::Model;
use crate::simulate::{Start, StartContact};

/// Distance of the motions as a share of the amplitude.
const APART: f64 = 1e-6;
/// Growth factors below this are lost in the integration's error: the difference has died out.
const LOST: f64 = 3e-4;

/// A motion beside the one that is measured, put back to a small distance at every peak.
pub(super) struct Companion {
    run: Run,
    apart: f64,
    tolerance: f64,
    /// The model depends on time, or on the place on the belt: then a shift in time is a difference too.
    driven: bool,
    started: bool,
    lost: bool,
}

impl Companion {
    /// Beside a motion with this amplitude in m.
    pub(super) fn new(follower: &Follower, amplitude: f64, tolerance: f64) -> Self {
        let run = follower.run().clone();
        Self {
            driven: is_driven(run.model()),
            run,
            apart: APART * amplitude,
            tolerance,
            started: false,
            lost: false,
        }
    }

    /// Whether the difference has died out.
    pub(super) fn is_lost(&self) -> bool {
        self.lost
    }

    /// Starts from a small difference at a peak of the motion; how much the one before had grown.
    pub(super) fn meet(
        &mut self,
        follower: &Follower,
        peak: &Crossing,
        mode: ContactMode,
        norm: &Norm,
    ) -> Result<Option<f64>, PhysicsError> {
        let model = follower.run().model();
        let mut difference = if self.started {
            let mut x = self.run.advance_to(peak.time)?;
            for i in 0..MAX_STATES {
                x[i] -= peak.state[i];
            }
            x
        } else {
            any_direction(model)
        };
        if !self.driven {
            (difference, _) = across(follower, peak, mode, &difference);
        }
        let size = norm.of(&difference);
        let growth = self.started.then_some(size / self.apart);
        if growth.is_some_and(|growth| !(growth > LOST)) {
            self.lost = true;
            return Ok(growth);
        }
        let factor = self.apart / size;
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
        self.started = true;
        Ok(growth)
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
