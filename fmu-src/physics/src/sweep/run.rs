//! A run by the quickest way that its model allows, piece by piece.
//!
//! The reference model goes by collocation; everything else, and a motion too steep for that, by the event loop.

use crate::contact::{ContactMode, Transition};
use crate::error::PhysicsError;
use crate::integrate::collocation::{self, Chebyshev};
use crate::integrate::series::{Series, stays_positive};
use crate::integrate::{MAX_STATES, State, roots};
use crate::model::Model;
use crate::simulate::collocated::Collocated;
use crate::simulate::{Simulation, Start, StartContact};

/// Pieces after which progress is judged, and the least progress in s over them.
const PATIENCE: u32 = 2_000;
const LEAST_PROGRESS: f64 = 2e-4;

/// A run of which every piece can be looked into.
#[derive(Clone)]
pub struct Run {
    general: Simulation,
    /// The run where it goes by collocation; the general one then only serves to start it.
    collocated: Option<Box<Collocated>>,
    /// Whether collocation is wanted.
    quick: bool,
}

/// A quantity over a piece of motion, in its normalised time theta.
pub enum Curve {
    /// Coefficients power by power, and the degree.
    Powers(Series, usize),
    /// Coefficients of Chebyshev polynomials.
    Chebyshev(Chebyshev),
    /// Value at theta = 0, and slope.
    Straight(f64, f64),
}

impl Curve {
    /// Value at `theta`.
    pub fn value(&self, theta: f64) -> f64 {
        match self {
            Self::Powers(c, degree) => roots::value(&c[..=*degree], theta),
            Self::Chebyshev(c) => collocation::value(c, theta),
            Self::Straight(value, slope) => value + slope * theta,
        }
    }

    /// Turns the sign.
    pub fn turn(&mut self) {
        match self {
            Self::Powers(c, _) => c.iter_mut().for_each(|a| *a = -*a),
            Self::Chebyshev(c) => c.iter_mut().for_each(|a| *a = -*a),
            Self::Straight(value, slope) => (*value, *slope) = (-*value, -*slope),
        }
    }

    /// Whether it certainly is not negative on [0, reach], as far as is told quickly.
    pub fn stays_positive(&self, reach: f64) -> bool {
        match self {
            Self::Powers(c, degree) => stays_positive(&c[..=(*degree).max(2)], reach),
            Self::Chebyshev(c) => c[0] >= collocation::spread(c),
            Self::Straight(value, slope) => value.min(value + slope * reach) >= 0.0,
        }
    }

    /// The first theta in (low, reach] at which it falls below zero, provided it is not negative at `low`; none is missed.
    pub fn first_below_zero(&self, low: f64, reach: f64) -> Option<f64> {
        match self {
            Self::Powers(c, degree) => roots::first_below_zero(&c[..=*degree], low, reach),
            Self::Chebyshev(c) => {
                collocation::first_below_zero(c, low).filter(|theta| *theta <= reach)
            }
            Self::Straight(value, slope) => roots::first_below_zero(&[*value, *slope], low, reach),
        }
    }
}

impl Run {
    /// A run by the event loop.
    pub fn general(run: Simulation) -> Self {
        Self {
            general: run,
            collocated: None,
            quick: false,
        }
    }

    /// A run by collocation where the model allows it.
    pub fn quickest(run: Simulation) -> Self {
        Self {
            collocated: Collocated::take_over(&run).map(Box::new),
            general: run,
            quick: true,
        }
    }

    /// Starts the same model anew.
    ///
    /// # Errors
    /// A state with which the model can't start.
    pub fn restart(&mut self, start: &Start, tolerance: f64) -> Result<(), PhysicsError> {
        let inputs = self.general.inputs();
        self.general.restart(inputs, start, tolerance)?;
        if self.quick {
            self.collocated = Collocated::take_over(&self.general).map(Box::new);
        }
        Ok(())
    }

    /// The model.
    pub fn model(&self) -> &Model {
        match &self.collocated {
            Some(run) => run.model(),
            None => self.general.model(),
        }
    }

    /// Goes to the end of the present piece and integrates the next.
    ///
    /// # Errors
    /// As [`Simulation::advance_to`], except that the caller watches the progress.
    pub fn next_piece(&mut self) -> Result<(), PhysicsError> {
        let Some(run) = &mut self.collocated else {
            return self.general.next_piece();
        };
        if run.next_piece()? {
            return Ok(());
        }
        // Too steep for collocation: the event loop goes on from here.
        let (time, state, mode) = run.front();
        let start = Start {
            time,
            state: *state,
            contact: match mode {
                ContactMode::Stuck => StartContact::Stick,
                _ => StartContact::Slip,
            },
            ..Start::default()
        };
        let (inputs, tolerance) = (self.general.inputs(), self.general.tolerance());
        self.general.restart(inputs, &start, tolerance)?;
        self.collocated = None;
        self.general.next_piece()
    }

    /// Goes on to time `t` in s; the state there.
    ///
    /// # Errors
    /// A motion that is no longer finite, or no progress in time.
    pub fn advance_to(&mut self, t: f64) -> Result<State, PhysicsError> {
        let (mut pieces, mut since) = (0, self.piece().1);
        while t >= self.piece().1 {
            self.next_piece()?;
            pieces += 1;
            if pieces % PATIENCE == 0 {
                let (start, end) = self.piece();
                if end - since < LEAST_PROGRESS {
                    return Err(self.stalled(start, end));
                }
                since = end;
            }
        }
        Ok(self.state_at(t))
    }

    /// The error of a run that gets nowhere, in a piece from `start` to `end` in s.
    pub fn stalled(&self, start: f64, end: f64) -> PhysicsError {
        PhysicsError::Stalled {
            time: end,
            step: end - start,
            transitions: match &self.collocated {
                Some(run) => run.transition_count(),
                None => self.general.transition_count(),
            },
        }
    }

    /// Start and end in s of the present piece.
    pub fn piece(&self) -> (f64, f64) {
        match &self.collocated {
            Some(run) => (run.piece().start, run.piece().end),
            None => (self.general.piece().start, self.general.piece().end),
        }
    }

    /// Mode of the contact in the present piece.
    pub fn contact_mode(&self) -> ContactMode {
        match &self.collocated {
            Some(run) => run.piece().mode,
            None => self.general.contact_mode(),
        }
    }

    /// State at the end of the present piece, after the jump there if one ends it.
    pub fn piece_end(&self) -> &State {
        match &self.collocated {
            Some(run) => run.front().1,
            None => self.general.piece_end(),
        }
    }

    /// The transition that ends the present piece.
    pub fn piece_transition(&self) -> Option<Transition> {
        match &self.collocated {
            Some(run) => run.piece_transition(),
            None => self.general.piece_transition(),
        }
    }

    /// Time in s at `theta` within the present piece.
    pub fn time_at(&self, theta: f64) -> f64 {
        match &self.collocated {
            Some(run) => run.piece().start + theta * run.piece().length,
            None => self.general.piece().start + theta * self.general.piece().length,
        }
    }

    /// State at time `t` in s within the present piece.
    pub fn state_at(&mut self, t: f64) -> State {
        if let Some(run) = &self.collocated {
            return run.state_at(t);
        }
        self.general.ready_piece();
        let piece = self.general.piece();
        let mut x = [0.0; MAX_STATES];
        piece.state_at(piece.theta(t), &mut x);
        x
    }

    /// Whether the tip's velocity certainly keeps the sign that is given, as far as is told at once.
    pub fn keeps_direction(&self, rising: bool) -> bool {
        self.collocated.as_ref().is_some_and(|run| {
            run.piece().mode != ContactMode::Stuck && run.piece().keeps_direction(rising)
        })
    }

    /// Velocity of the tip in m/s over the present piece, given its row of the state, and the theta at its end.
    pub fn velocity(&mut self, row: &[f64]) -> (Curve, f64) {
        if let Some(run) = &self.collocated {
            let piece = run.piece();
            let curve = if piece.mode == ContactMode::Stuck {
                Curve::Straight(run.model().inputs.belt_velocity, 0.0)
            } else {
                Curve::Chebyshev(piece.velocity())
            };
            return (curve, piece.theta(piece.end));
        }
        self.general.ready_piece();
        let piece = self.general.piece();
        let curve = Curve::Powers(piece.combine(row, &[]), piece.degree);
        (curve, piece.theta(piece.end))
    }

    /// Appends the displacement of the tip in m at these times in s within the present piece, given its row of the state.
    pub fn displacements(
        &mut self,
        row: &[f64],
        times: impl Iterator<Item = f64>,
        out: &mut Vec<f64>,
    ) {
        if let Some(run) = &self.collocated {
            let piece = run.piece();
            let start: f64 = row.iter().zip(&piece.state).map(|(a, b)| a * b).sum();
            if piece.mode == ContactMode::Stuck {
                // Stick follows the belt.
                let belt = run.model().inputs.belt_velocity;
                out.extend(times.map(|t| start + belt * (t - piece.start)));
            } else {
                out.extend(times.map(|t| start + piece.way_to(piece.theta(t))));
            }
            return;
        }
        self.general.ready_piece();
        let piece = self.general.piece();
        let series = piece.combine(row, &[]);
        let series = &series[..=piece.degree];
        out.extend(times.map(|t| roots::value(series, piece.theta(t))));
    }

    /// Carries a small difference along with the motion from the end of the present piece on; false where it can't.
    pub fn vary(&mut self, difference: &State) -> bool {
        match &mut self.collocated {
            Some(run) => {
                run.vary(difference);
                true
            }
            None => false,
        }
    }

    /// The difference that is carried along, at time `t` in s within the present piece.
    pub fn difference_at(&self, t: f64) -> Option<State> {
        self.collocated.as_ref()?.difference_at(t)
    }

    /// Takes a lead in s of the whole motion out of the difference from the end of the present piece on, and multiplies it.
    pub fn renew_difference(&mut self, lead: f64, factor: f64) {
        if let Some(run) = &mut self.collocated {
            run.renew_difference(lead, factor);
        }
    }

    /// Present time in s: the start of a run, then the start of its piece.
    pub fn time(&self) -> f64 {
        match &self.collocated {
            Some(run) => run.piece().start,
            None => self.general.time(),
        }
    }

    /// State at the present time.
    pub fn state(&self) -> State {
        match &self.collocated {
            Some(run) => run.piece().state,
            None => self.general.state(),
        }
    }
}
