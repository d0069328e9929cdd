//! A small difference to the motion, carried along by the variational equation, with what transitions do to it (saltation).

use super::Collocated;
use crate::contact::ContactMode;
use crate::integrate::collocation::{NODES, Nodes, vary};
use crate::integrate::{MAX_STATES, State};

/// A difference of the states.
#[derive(Clone)]
pub(super) struct Variation {
    /// At the begin of the present piece.
    begin: State,
    /// At its end, after the jump there.
    front: State,
    /// What it changes of friction in N at the nodes of a step of slip.
    friction: Nodes,
}

/// The instant of a transition, just before it.
pub(super) struct Crossing {
    pub(super) time: f64,
    pub(super) state: State,
    pub(super) mode: ContactMode,
    /// What must vanish for the transition to come, linear in the state.
    pub(super) gap: fn(&Collocated, &State) -> f64,
}

impl Collocated {
    /// Carries a difference along from the end of the present piece on.
    pub(crate) fn vary(&mut self, difference: &State) {
        self.variation = Some(Box::new(Variation {
            begin: *difference,
            front: *difference,
            friction: [0.0; NODES],
        }));
    }

    /// The difference at time `t` in s within the present piece.
    pub(crate) fn difference_at(&self, t: f64) -> Option<State> {
        let v = self.variation.as_ref()?;
        let theta = self.piece.theta(t);
        Some(
            self.piece
                .difference_at(&self.structure, theta, &v.begin, &v.friction),
        )
    }

    /// Takes a lead in s of the whole motion out of the difference at the end of the present piece, and multiplies it.
    pub(crate) fn renew_difference(&mut self, lead: f64, factor: f64) {
        let rates = self.rates(self.front, &self.front_state, self.front_mode);
        if let Some(v) = &mut self.variation {
            for (d, rate) in v.front.iter_mut().zip(&rates) {
                *d = factor * (*d - lead * rate);
            }
        }
    }

    /// Carries the difference over a step of slip to its end.
    pub(super) fn vary_slip(&mut self, level: usize, sign: f64) {
        if let Some(v) = &mut self.variation {
            let ladder = &self.structure.ladder;
            v.begin = v.front;
            let response = ladder.response(level);
            let slope = &self.step.slope;
            v.friction = vary(ladder, response, slope, sign, &v.begin, &mut v.front);
        }
    }

    /// Carries the difference over a stick of `length` in s.
    pub(super) fn vary_stick(&mut self, length: f64) {
        if let Some(v) = &mut self.variation {
            v.begin = v.front;
            v.front = self.structure.stick.state_at(length, &v.begin);
        }
    }

    /// Carries the difference over the transition that ends the present piece.
    ///
    /// `dx+ = P (dx + f- dt) - f+ dt` with the rates f before and after, the delay `dt = -h(dx) / h(f-)` of the transition
    /// where h vanishes, and P that puts the velocity of the tip at rest on the belt (saltation: Leine and Nijmeijer 2004,
    /// sect. 7.3).
    pub(super) fn vary_transition(&mut self, at: &Crossing) {
        if self.variation.is_none() {
            return;
        }
        let mut d = self.difference_at(at.time).expect("carried along");
        let before = self.rates(at.time, &at.state, at.mode);
        let after = self.rates(at.time, &self.front_state, self.front_mode);
        let delay = -(at.gap)(self, &d) / (at.gap)(self, &before);
        for (d, rate) in d.iter_mut().zip(&before) {
            *d += delay * rate;
        }
        self.model.push(-self.model.tip(&d).1, &mut d);
        for (d, rate) in d.iter_mut().zip(&after) {
            *d -= delay * rate;
        }
        self.variation.as_mut().expect("carried along").front = d;
    }

    fn rates(&self, t: f64, x: &State, mode: ContactMode) -> State {
        let mut rates = [0.0; MAX_STATES];
        self.model.rates(t, x, mode, &mut rates);
        rates
    }
}
