//! Everything the observer says of one run.

use super::Method;
use super::characteristic::Point;
use crate::measurement::Measurand;
use crate::metric::StickVelocity;
use crate::observer::{
    Bin, DwellResult, Estimate, FrictionCurve, LawFit, Phase, PhaseMode, Structure, Whiteness,
};

/// Results for one run; columns have one entry per sample.
#[derive(Debug)]
pub struct Observation {
    /// The run's name.
    pub name: String,
    /// How the force was estimated.
    pub method: Method,
    /// The structure used.
    pub structure: Structure,
    /// Belt velocity in m/s, the mean where it varies.
    pub belt_velocity: f64,
    /// Normal force in N, the mean where it varies.
    pub normal_force: f64,
    /// Time in s.
    pub time: Vec<f64>,
    /// What was measured.
    pub measurand: Measurand,
    /// Coefficient in slip that was stated where the channel leaves the level of the force open.
    pub stated_coefficient: Option<f64>,
    /// Measured values less offset in m, m/s or m/s^2; NaN where missing.
    pub measured: Vec<f64>,
    /// Force in N.
    pub force: Vec<f64>,
    /// Its standard deviation in N; NaN for the pole-placed observer, which knows none.
    pub force_std: Vec<f64>,
    /// Displacement in m.
    pub displacement: Vec<f64>,
    /// Velocity in m/s.
    pub velocity: Vec<f64>,
    /// Acceleration in m/s^2; empty for the pole-placed observer.
    pub acceleration: Vec<f64>,
    /// Velocity less belt velocity in m/s.
    pub relative_velocity: Vec<f64>,
    /// Stick and slip.
    pub phases: Vec<Phase>,
    /// Friction coefficient over relative velocity.
    pub bins: Vec<Bin>,
    /// The friction curve by shooting, where there was one.
    pub curve: Option<FrictionCurve>,
    /// Whether that curve explains the slip events, so that it may stand for the friction.
    pub curve_trusted: bool,
    /// The characteristic as friction.csv has it.
    pub characteristic: Vec<Point>,
    /// Laws, best first, table last.
    pub laws: Vec<LawFit>,
    /// Break-away against dwell time.
    pub dwell: Option<DwellResult>,
    /// Innovation of the Kalman filter.
    pub whiteness: Whiteness,
    /// Sensor noise in the unit of what was measured.
    pub noise_std: f64,
    /// Drift of a measured displacement in m/s.
    pub drift: Option<Estimate>,
    /// Offset found from slip in both directions, in m of static deflection: of the sensor, or of the level that was stated.
    pub offset: Option<Estimate>,
    /// Pole-placed observers beside it: pole speed in Hz, and RMS difference of their force, causal and with the delay
    /// taken out, over the spread of the force.
    pub pole_speeds: Vec<(f64, f64, f64)>,
    /// The belt's velocity as the stick phases have it.
    pub belt_in_stick: Option<StickVelocity>,
    /// What the reader must know.
    pub remarks: Vec<String>,
}

impl Observation {
    /// Mode of every sample: -1, 0, 1.
    pub fn modes(&self) -> Vec<i8> {
        let mut out = Vec::with_capacity(self.time.len());
        for phase in &self.phases {
            out.resize(phase.past, phase.mode.number());
        }
        out
    }

    /// Share of the samples in stick.
    pub fn stick_fraction(&self) -> f64 {
        let modes = self.modes();
        modes.iter().filter(|m| **m == 0).count() as f64 / modes.len() as f64
    }

    /// Number of complete stick phases.
    pub fn sticks(&self) -> usize {
        let stick = |p: &&Phase| p.mode == PhaseMode::Stick && p.complete;
        self.phases.iter().filter(stick).count()
    }

    /// What the estimated motion of the tip has of the quantity that was measured.
    pub fn estimated(&self) -> &[f64] {
        match self.measurand {
            Measurand::Displacement => &self.displacement,
            Measurand::Velocity => &self.velocity,
            Measurand::Acceleration => &self.acceleration,
        }
    }

    /// The best law with parameters of its own.
    pub fn best_law(&self) -> Option<&LawFit> {
        self.laws.first().filter(|l| !l.parameters.is_empty())
    }
}
