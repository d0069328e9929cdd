//! The return map of the section w' = 0, falling, in coordinates of its own.

use super::super::Subject;
use super::super::follow::{Features, Follower};
use super::super::run::Run;
use super::shooting::OrbitError;
use crate::contact::ContactMode;
use crate::integrate::{MAX_STATES, State};
use crate::simulate::{Simulation, Start, StartContact};
use nalgebra::DVector;

/// Periods of the lowest mode after which a motion that has not returned is given up.
const PATIENCE: f64 = 200.0;
/// Integration for orbits is at least this exact, because derivatives are differences of runs.
const TOLERANCE: f64 = 1e-13;

/// What one return saw.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Return {
    /// State at the section.
    pub(super) state: State,
    /// Time taken in s.
    pub(super) duration: f64,
    /// Highest peak and lowest trough in m.
    pub(super) range: (f64, f64),
    /// Modes entered on the way: `s` stick, `-` backward slip, `+` forward slip.
    pub(super) sequence: String,
    /// Share of time in stick.
    pub(super) stick: f64,
}

/// The map of a model.
///
/// Coordinates: all states but the velocity of the mode that moves the tip most, which w' = 0 determines; each in m
/// by what it contributes at the tip (velocities over their angular frequency).
pub(super) struct ReturnMap {
    follower: Follower,
    returns: usize,
    weight: State,
    /// The state that is not a coordinate, and how the others determine it.
    dependent: usize,
    row: State,
    pub(super) dimension: usize,
    quiet: f64,
    tolerance: f64,
}

impl ReturnMap {
    /// The map of `returns` returns.
    pub(super) fn new(subject: &Subject, returns: usize) -> Result<Self, OrbitError> {
        let model = &subject.model;
        if super::super::companion::is_driven(model) {
            return Err(OrbitError::Driven);
        }
        let (mut weight, mut row) = ([0.0; MAX_STATES], [0.0; MAX_STATES]);
        let modes = model.beam().modes();
        let scales = model.state_scales();
        let mut lowest = f64::INFINITY;
        let mut dependent = 1;
        for (j, m) in modes.iter().enumerate() {
            let share = if m.tip_value == 0.0 {
                1.0
            } else {
                m.tip_value.abs()
            };
            weight[2 * j] = share;
            weight[2 * j + 1] = share / m.angular_frequency();
            row[2 * j + 1] = m.tip_value;
            if m.tip_value.abs() > row[dependent].abs() {
                dependent = 2 * j + 1;
            }
            lowest = lowest.min(m.frequency);
        }
        for i in 2 * modes.len()..model.dimension() {
            weight[i] = 1e-5 / scales[i];
        }
        let tolerance = subject.tolerance.min(TOLERANCE);
        let start = Start {
            contact: StartContact::Slip,
            ..Start::default()
        };
        let run = Simulation::from_model(model.clone(), model.inputs, &start, tolerance)?;
        Ok(Self {
            follower: Follower::new(Run::general(run)),
            returns,
            weight,
            dependent,
            row,
            dimension: model.dimension(),
            quiet: PATIENCE / lowest,
            tolerance,
        })
    }

    /// Number of coordinates.
    pub(super) fn count(&self) -> usize {
        self.dimension - 1
    }

    /// Tip displacement in m of a state.
    pub(super) fn displacement(&self, x: &State) -> f64 {
        self.follower.displacement(x)
    }

    /// Coordinates of a state.
    pub(super) fn coordinates(&self, x: &State) -> DVector<f64> {
        let free = (0..self.dimension).filter(|i| *i != self.dependent);
        DVector::from_iterator(self.count(), free.map(|i| self.weight[i] * x[i]))
    }

    /// State of coordinates.
    pub(super) fn state(&self, y: &DVector<f64>) -> State {
        let mut x = [0.0; MAX_STATES];
        let free = (0..self.dimension).filter(|i| *i != self.dependent);
        for (i, value) in free.zip(y.iter()) {
            x[i] = value / self.weight[i];
        }
        let rest: f64 = (0..self.dimension).map(|i| self.row[i] * x[i]).sum();
        x[self.dependent] = -rest / self.row[self.dependent];
        x
    }

    /// Follows the motion from a state on the section until it has returned.
    pub(super) fn apply(&mut self, x: &State) -> Result<Return, OrbitError> {
        self.follower.restart_at_peak(x, 0.0, self.tolerance)?;
        let mut features = Features::default();
        let mut seen = 0;
        let mut sequence = String::new();
        let mut range = (f64::NEG_INFINITY, f64::INFINITY);
        let mut stick = 0.0;
        loop {
            self.follower.next(&mut features)?;
            if features.mode == Some(ContactMode::Stuck) {
                stick += features.to - features.from;
            }
            range.1 = features.troughs.iter().copied().fold(range.1, f64::min);
            for peak in &features.peaks {
                range.0 = range.0.max(peak.displacement);
                seen += 1;
                if seen == self.returns {
                    return Ok(Return {
                        state: peak.state,
                        duration: peak.time,
                        range,
                        sequence,
                        stick: stick / peak.time,
                    });
                }
            }
            if let Some(transition) = features.transition {
                sequence.push(match transition.to {
                    ContactMode::Stuck => 's',
                    ContactMode::Backward => '-',
                    ContactMode::Forward => '+',
                });
            }
            if features.to > self.quiet {
                return Err(OrbitError::NoReturn { time: features.to });
            }
        }
    }
}
