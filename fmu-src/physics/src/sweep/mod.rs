//! Parameter studies: many points of a model at once, each reduced to the numbers that describe its motion.
//!
//! A point is a [`Subject`], mostly from [`Values`] by the names of the FMU's variables, with a [`StartRule`];
//! [`evaluate`] follows it to its motion. [`run`] does many on all cores. [`orbit`] finds periodic motions directly, stable or not.

mod batch;
mod companion;
mod exponent;
mod follow;
mod measure;
pub mod orbit;
mod period;
mod point;
mod run;
mod spectrum;
mod start;
mod trace;
mod values;

pub use crate::effects::user_expression::UserEffect;
pub use batch::{Chain, Outcome, Task, run};
pub use follow::Crossing;
pub use period::period_of;
pub use point::{Motion, Rule, Status, evaluate};
pub use spectrum::{Spectrum, main_frequency, spectrum};
pub use start::{Carry, StartRule};
pub use trace::{Sample, cycle_distance, trace};
pub use values::Values;

use crate::beam::eigenfunction;
use crate::contact::ContactMode;
use crate::integrate::MAX_STATES;
use crate::model::Model;
use crate::simulate::Start;

/// Where the motion is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Section {
    /// w' = 0, falling: the peaks of the displacement (the paper's w_P).
    Peak,
    /// The end of each stick.
    Release,
    /// Once in each `period` in s.
    Stroboscopic {
        /// Period in s.
        period: f64,
    },
}

/// A model ready to be followed.
#[derive(Clone)]
pub struct Subject {
    /// The model with its inputs.
    pub model: Model,
    /// The start state that the user has set, if one is.
    pub given: Option<Start>,
    /// Relative tolerance of the integration.
    pub tolerance: f64,
}

/// Static deflection of the tip per force, `sum phi_j^2 / (m_j w_j^2)` in m/N; `l^3 / (3 E I)` with all modes.
///
/// Source: Stelter 1992, eqs. (3) and (8).
pub fn static_compliance(model: &Model) -> f64 {
    model
        .beam()
        .modes()
        .iter()
        .map(|m| (m.tip_value / m.angular_frequency()).powi(2) / m.mass)
        .sum()
}

/// Deflection of the tip in m at which it may slide steadily under the belt: friction at the belt's velocity bends the
/// beam by `w_0 = F_N mu(v0) l^3/(3 E I)`.
///
/// Steady sliding may be unstable; it is the position from which the paper counts amplitudes.
pub fn sliding_deflection(model: &Model) -> f64 {
    let towards = ContactMode::slip_towards(-model.inputs.belt_velocity);
    let x = [0.0; MAX_STATES];
    let sliding = model.evaluate(0.0, &x, towards, &mut [0.0; MAX_STATES]);
    static_compliance(model) * sliding.force
}

/// Amplitude of the transition from stick to slip under static conditions, in m:
/// `w_A = F_N l^3/(3 E I) (mu_0 - mu(v0))`.
///
/// F_N normal force in N, mu_0 static coefficient, mu(v0) coefficient of sliding at the belt's velocity. Counts from
/// [`sliding_deflection`]; holds where inertia plays no part; effects enter with what they make of friction at rest.
/// Source: Stelter 1992, eq. (8).
pub fn static_amplitude(model: &Model) -> f64 {
    let limit = model.static_limit(0.0, &[0.0; MAX_STATES]);
    static_compliance(model) * limit - sliding_deflection(model).abs()
}

/// Shape of mode `j` (from 0) of the cantilever at `xi` in 0..1, eq. (6) of Stelter 1992.
pub fn mode_shape(j: usize, xi: f64) -> f64 {
    eigenfunction(j, xi).0
}
