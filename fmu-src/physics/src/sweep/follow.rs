//! A run followed piece by piece: turning points of the tip located on the polynomials, none sampled.

use super::Section;
use super::run::{Curve, Run};
use crate::beam::MAX_MODES;
use crate::contact::{ContactMode, Transition};
use crate::error::PhysicsError;
use crate::integrate::State;
use crate::simulate::{Start, StartContact};

/// Pieces after which progress is judged, and the least progress in s over them.
const PATIENCE: u32 = 2_000;
const LEAST_PROGRESS: f64 = 2e-4;
/// Share of a piece next to a turning point within which no second one is looked for.
const APART: f64 = 1e-6;

/// A point of the section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Time in s.
    pub time: f64,
    /// State there.
    pub state: State,
    /// Tip displacement w in m.
    pub displacement: f64,
    /// Tip velocity w' in m/s.
    pub velocity: f64,
}

/// What a piece of the motion contains.
#[derive(Debug, Clone, Default)]
pub struct Features {
    /// Peaks (w' = 0, falling) in the order of time.
    pub peaks: Vec<Crossing>,
    /// Displacements in m at the troughs (w' = 0, rising).
    pub troughs: Vec<f64>,
    /// The transition that ends the piece.
    pub transition: Option<Transition>,
    /// Mode and ends in s of the piece.
    pub mode: Option<ContactMode>,
    /// Start of the piece in s.
    pub from: f64,
    /// End of the piece in s.
    pub to: f64,
}

/// A run with what is needed to look for turning points.
#[derive(Clone)]
pub struct Follower {
    run: Run,
    /// phi_j at the places of q_j, and of q_j'.
    displacement_row: [f64; 2 * MAX_MODES],
    velocity_row: [f64; 2 * MAX_MODES],
    /// Whether the tip's velocity was positive after the last turning point.
    rising: bool,
    pieces: u32,
    since: f64,
}

impl Follower {
    /// Follows `run` from its present time on.
    pub fn new(run: Run) -> Self {
        let mut rows = [[0.0; 2 * MAX_MODES]; 2];
        for (j, mode) in run.model().beam().modes().iter().enumerate() {
            rows[0][2 * j] = mode.tip_value;
            rows[1][2 * j + 1] = mode.tip_value;
        }
        let mut follower = Self {
            displacement_row: rows[0],
            velocity_row: rows[1],
            rising: false,
            pieces: 0,
            since: run.time(),
            run,
        };
        follower.look();
        follower
    }

    /// Reads off which way the tip moves.
    fn look(&mut self) {
        let x = self.run.state();
        let (_, velocity) = self.run.model().tip(&x);
        self.rising = velocity > 0.0;
        self.since = self.run.time();
        self.pieces = 0;
    }

    /// Starts the same model anew from a peak with state `x`.
    ///
    /// # Errors
    /// A state with which the model can't start.
    pub fn restart_at_peak(
        &mut self,
        x: &State,
        travel: f64,
        tolerance: f64,
    ) -> Result<(), PhysicsError> {
        let start = Start {
            time: 0.0,
            state: *x,
            contact: StartContact::Slip,
            belt_travel: travel,
            ..Start::default()
        };
        self.run.restart(&start, tolerance)?;
        self.look();
        self.rising = false;
        Ok(())
    }

    /// The run.
    pub fn run(&self) -> &Run {
        &self.run
    }

    /// The run, to carry a difference along.
    pub fn run_mut(&mut self) -> &mut Run {
        &mut self.run
    }

    /// Tip displacement in m.
    pub fn displacement(&self, x: &State) -> f64 {
        dot(&self.displacement_row, x)
    }

    /// Tip velocity in m/s.
    pub fn velocity(&self, x: &State) -> f64 {
        dot(&self.velocity_row, x)
    }

    /// State at time `t` in s within the present piece.
    pub fn state_at(&mut self, t: f64) -> State {
        self.run.state_at(t)
    }

    /// Appends the tip's displacement in m at these times in s within the present piece.
    pub fn displacements(&mut self, times: impl Iterator<Item = f64>, out: &mut Vec<f64>) {
        self.run.displacements(&self.displacement_row, times, out);
    }

    /// A point of the section at `t` in s within the present piece.
    pub fn crossing(&mut self, t: f64) -> Crossing {
        let state = self.state_at(t);
        Crossing {
            time: t,
            displacement: self.displacement(&state),
            velocity: self.velocity(&state),
            state,
        }
    }

    /// Integrates the next piece and finds what it contains.
    ///
    /// # Errors
    /// As [`Simulation::advance_to`].
    pub fn next(&mut self, features: &mut Features) -> Result<(), PhysicsError> {
        self.run.next_piece()?;
        self.pieces += 1;
        let (start, end) = self.run.piece();
        if self.pieces == PATIENCE {
            if end - self.since < LEAST_PROGRESS {
                return Err(self.run.stalled(start, end));
            }
            self.pieces = 0;
            self.since = end;
        }
        features.peaks.clear();
        features.troughs.clear();
        features.transition = self.run.piece_transition();
        features.mode = Some(self.run.contact_mode());
        (features.from, features.to) = (start, end);
        if end > start {
            self.find_turns(features);
        }
        Ok(())
    }

    fn find_turns(&mut self, features: &mut Features) {
        // Stick follows the belt: where both ends agree there is no turning point between.
        if self.run.contact_mode() == ContactMode::Stuck {
            let velocity = self.velocity(self.run.piece_end());
            if velocity == 0.0 || (velocity > 0.0) == self.rising {
                return;
            }
        }
        if self.run.keeps_direction(self.rising) {
            return;
        }
        let (mut c, reach) = self.run.velocity(&self.velocity_row);
        if !self.rising {
            c.turn();
        }
        if c.stays_positive(reach) {
            return;
        }
        let mut low = 0.0;
        while let Some(theta) = next_turn(&c, low, reach) {
            let time = self.run.time_at(theta);
            if self.rising {
                features.peaks.push(self.crossing(time));
            } else {
                self.displacements(std::iter::once(time), &mut features.troughs);
            }
            self.rising = !self.rising;
            c.turn();
            low = theta + APART * reach;
        }
    }

    /// The section's points in the piece that `features` describe.
    pub fn section_points(
        &mut self,
        section: Section,
        features: &Features,
        out: &mut Vec<Crossing>,
    ) {
        match section {
            Section::Peak => out.extend(&features.peaks),
            Section::Release => {
                if let Some(t) = features.transition
                    && t.from == ContactMode::Stuck
                {
                    out.push(self.crossing(t.time));
                }
            }
            Section::Stroboscopic { period } => {
                let mut k = (features.from / period).floor() + 1.0;
                while k * period <= features.to {
                    out.push(self.crossing(k * period));
                    k += 1.0;
                }
            }
        }
    }
}

/// The first turning point in (low, reach]; the curve is the velocity times the sign it had last.
fn next_turn(c: &Curve, low: f64, reach: f64) -> Option<f64> {
    if low >= reach {
        return None;
    }
    // Rounding may put a turning point on the far side of a border of pieces.
    let from = if c.value(low) < 0.0 {
        let inside = low + APART * reach;
        if c.value(inside) < 0.0 {
            return (low == 0.0).then_some(0.0);
        }
        inside
    } else {
        low
    };
    c.first_below_zero(from, reach)
}

fn dot(row: &[f64; 2 * MAX_MODES], x: &State) -> f64 {
    row.iter().zip(x).map(|(a, b)| a * b).sum()
}
