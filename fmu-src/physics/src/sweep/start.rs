//! From which state a point starts.

use super::{Subject, static_compliance};
use crate::integrate::{MAX_STATES, State};
use crate::model::Model;
use crate::simulate::{Start, StartContact};

/// Share of the static limit that bends the beam in the fixed start.
const BEND: f64 = 0.95;

/// What a motion hands to the next point of a continuation: its last section point.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Carry {
    /// Number of modes.
    pub modes: usize,
    /// Number of states.
    pub dimension: usize,
    /// State at the last peak.
    pub state: State,
    /// Place on the belt in m.
    pub travel: f64,
}

/// How a point starts.
#[derive(Debug, Clone, PartialEq)]
pub enum StartRule {
    /// The start state among the values where one is set, else in stick, the beam bent by 0.95 of the break-away
    /// force.
    Fixed,
    /// Bent by `bend` times the static limit with `velocity` times the belt's velocity.
    Grid {
        /// Share of the static limit, -1 to 1.
        bend: f64,
        /// Share of the belt's velocity, -1 to 1.
        velocity: f64,
    },
    /// Where the motion at the point before was; `Fixed` where there is none.
    Carried,
}

/// The start of a point by its rule.
pub(super) fn start(rule: &StartRule, subject: &Subject, carried: Option<&Carry>) -> Start {
    let model = &subject.model;
    match (rule, carried) {
        (StartRule::Carried, Some(carry)) => continued(carry, model),
        (StartRule::Grid { bend, velocity }, _) => bent(model, *bend, *velocity),
        _ => subject.given.clone().unwrap_or_else(|| Start {
            contact: StartContact::Stick,
            settled: true,
            ..bent(model, BEND, 1.0)
        }),
    }
}

/// The beam bent as by a force at its tip, and moving in the same shape:
/// `q_j = F phi_j / (m_j w_j^2)`, `q_j' = w' (q_j / w)`.
fn bent(model: &Model, bend: f64, velocity: f64) -> Start {
    let mut state = [0.0; MAX_STATES];
    let belt = model.inputs.belt_velocity;
    let limit = model.static_limit(0.0, &state);
    let compliance = static_compliance(model);
    for (j, mode) in model.beam().modes().iter().enumerate() {
        let share = mode.tip_value / (mode.mass * mode.angular_frequency().powi(2));
        state[2 * j] = bend * limit * share * if belt < 0.0 { -1.0 } else { 1.0 };
        state[2 * j + 1] = velocity * belt * share / compliance;
    }
    Start {
        state,
        settled: true,
        ..Start::default()
    }
}

fn continued(carry: &Carry, model: &Model) -> Start {
    let modes = model.beam().modes().len();
    let same = carry.dimension == model.dimension() && carry.modes == modes;
    let mut state = [0.0; MAX_STATES];
    if same {
        state = carry.state;
    } else {
        // Effects that come or go bring or take their states; the modes that both have go on.
        let shared = 2 * carry.modes.min(modes);
        state[..shared].copy_from_slice(&carry.state[..shared]);
    }
    Start {
        state,
        contact: StartContact::Slip,
        belt_travel: carry.travel,
        settled: !same,
        ..Start::default()
    }
}
