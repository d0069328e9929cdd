//! Predicts shots with one instance of the FMU.

use super::hypothesis::{Hypothesis, References};
use super::knob::Knob;
use super::shot::Shot;
use super::unexplained::median;
use crate::error::Error;
use crate::fmu::{Directions, Fmu, Instance, Tangents};
use crate::measurement::Run;

/// Relative tolerance of the FMU while it is fitted: errors of 1e-10 m, far below any sensor's noise.
const TOLERANCE: f64 = 1e-9;

/// Deviation from the measurement, relative to the run's amplitude, at which a prediction is given up.
const RUNAWAY: f64 = 5.0;

fn reach(displacement: &[f64]) -> f64 {
    let mean = displacement.iter().sum::<f64>() / displacement.len() as f64;
    displacement
        .iter()
        .map(|d| (d - mean).abs())
        .fold(0.0, f64::max)
}

/// Values of everything that can be turned, and the start states of all shots.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Positions of the shared knobs.
    pub shared: Vec<f64>,
    /// Positions of each run's own knobs.
    pub own: Vec<Vec<f64>>,
    /// Start states of each shot: modal states, then deviations of the effects' states.
    pub states: Vec<Vec<f64>>,
    /// Whether each shot starts in stick.
    pub stuck: Vec<bool>,
}

/// One thing that can be turned in a shot.
#[derive(Debug, Clone, Copy)]
pub enum Turn {
    /// A component of its start state.
    State(usize),
    /// A shared knob.
    Shared(usize),
    /// One of its run's own knobs.
    Own(usize),
}

/// Where a shot starts, besides its knobs.
#[derive(Debug, Clone, PartialEq)]
pub struct ShotStart {
    /// Modal states, then deviations of the effects' states.
    pub state: Vec<f64>,
    /// Whether it starts in stick.
    pub stuck: bool,
}

impl Point {
    /// The priors' centres and the smoothed start states.
    pub fn centre(hypothesis: &Hypothesis, shots: &[Shot]) -> Self {
        Self {
            shared: hypothesis
                .shared
                .iter()
                .map(|k| k.position(k.prior))
                .collect(),
            own: hypothesis
                .own
                .iter()
                .map(|run| run.iter().map(|k| k.position(k.prior)).collect())
                .collect(),
            states: shots
                .iter()
                .map(|s| {
                    let mut x = s.state.clone();
                    x.resize(x.len() + hypothesis.extra_states.len(), 0.0);
                    x
                })
                .collect(),
            stuck: shots.iter().map(|s| s.stuck).collect(),
        }
    }

    /// Gives the runs `to` the median of how far the runs `from` lie from what was believed of them, in what is their own:
    /// friction level and offset, but not phases and profiles, which have nothing in common.
    pub fn share_own(&mut self, h: &Hypothesis, from: &[usize], to: &[usize]) {
        let is_common = |k: &Knob| k.support.is_none() && k.prior_std > 0.0 && !k.is_phase();
        let believed = |k: &Knob| k.position(k.prior);
        for &run in to {
            for (i, knob) in h.own[run].iter().enumerate().filter(|(_, k)| is_common(k)) {
                let mut others: Vec<f64> = from
                    .iter()
                    .filter_map(|&r| {
                        let j = h.own[r].iter().position(|k| k.name == knob.name)?;
                        Some(self.own[r][j] - believed(&h.own[r][j]))
                    })
                    .collect();
                if !others.is_empty() {
                    self.own[run][i] = believed(knob) + median(&mut others);
                }
            }
        }
    }

    /// The start of shot `k`.
    pub fn start(&self, k: usize) -> ShotStart {
        ShotStart {
            state: self.states[k].clone(),
            stuck: self.stuck[k],
        }
    }

    /// Sets the start of shot `k`.
    pub fn put(&mut self, k: usize, start: ShotStart) {
        self.states[k] = start.state;
        self.stuck[k] = start.stuck;
    }
}

/// Runs shots through the FMU. Belongs to one thread.
pub struct Predictor<'a> {
    instance: Instance,
    references: &'a References,
    runs: &'a [Run],
    hypothesis: &'a Hypothesis,
    /// Gives derivatives along motions, where the FMU offers that.
    tangents: Option<Tangents>,
    directions: Directions,
    names: Vec<u32>,
    values: Vec<f64>,
    /// Largest distance from the mean in each run, m.
    reach: Vec<f64>,
    /// Time in s at which the last prediction ended.
    now: f64,
}

impl<'a> Predictor<'a> {
    /// A predictor for a hypothesis.
    ///
    /// # Errors
    /// An FMU that refuses to be instantiated.
    pub fn new(
        fmu: &Fmu,
        references: &'a References,
        runs: &'a [Run],
        hypothesis: &'a Hypothesis,
    ) -> Result<Self, Error> {
        Ok(Self {
            instance: fmu.instantiate("diagnosis")?,
            references,
            runs,
            hypothesis,
            tangents: fmu.tangents(),
            directions: Directions::default(),
            names: Vec::new(),
            values: Vec::new(),
            reach: runs.iter().map(|r| reach(&r.displacement)).collect(),
            now: 0.0,
        })
    }

    fn push(&mut self, reference: u32, value: f64) {
        self.names.push(reference);
        self.values.push(value);
    }

    /// Lists the Real variables that a shot starts with.
    fn gather(&mut self, shot: &Shot, shared: &[f64], own: &[f64], state: &[f64]) {
        let h = self.hypothesis;
        let r = self.references;
        let run = &self.runs[shot.run];
        self.names.clear();
        self.values.clear();
        self.push(r.tolerance, TOLERANCE);
        for (reference, value) in r.inputs.into_iter().zip(h.inputs(run, shared)) {
            self.push(reference, value);
        }
        self.push(r.history[0], h.travel(run, shot, shared));
        self.push(r.history[1], shot.dwell);
        for &(reference, value) in &h.fixed {
            self.push(reference, value);
        }
        let knobs = h.shared.iter().zip(shared);
        for (knob, &position) in knobs.chain(h.own[shot.run].iter().zip(own)) {
            for (reference, value) in knob.settings(position) {
                self.push(reference, value);
            }
        }
        let modal = 2 * h.modes;
        for (&reference, &value) in r.states.iter().zip(&state[..modal]) {
            self.push(reference, value);
        }
        for (&(reference, _), &value) in h.extra_states.iter().zip(&state[modal..]) {
            self.push(reference, value);
        }
    }

    /// The Integer variables that a shot starts with: contact (Stick = 1, Slip = 2), effects (Settled = 1), modes.
    fn integers(&self, stuck: bool) -> ([u32; 3], [i32; 3]) {
        let r = self.references;
        (
            [r.contact, r.start_effects, r.mode_count],
            [if stuck { 1 } else { 2 }, 1, self.hypothesis.modes as i32],
        )
    }

    /// Puts the FMU at the start of a shot.
    fn start(
        &mut self,
        shot: &Shot,
        shared: &[f64],
        own: &[f64],
        state: &[f64],
        stuck: bool,
    ) -> Result<(), Error> {
        self.gather(shot, shared, own, state);
        let (names, values) = self.integers(stuck);
        self.instance.reset()?;
        self.instance.set_integer(&names, &values)?;
        self.instance.set_real(&self.names, &self.values)?;
        let origin = self.runs[shot.run].time[0];
        self.instance.initialize(shot.time[0] - origin, None, None)
    }

    /// Derivatives of the displacement at every `stride`-th of the first times of the shot, `count` of them, by each of
    /// `turns`, one after another in `slopes`; `false` where the FMU does not offer them or can't follow the motion.
    #[allow(clippy::too_many_arguments)]
    pub fn differentiate(
        &mut self,
        shot: &Shot,
        shared: &[f64],
        own: &[f64],
        state: &[f64],
        stuck: bool,
        turns: &[Turn],
        (count, stride): (usize, usize),
        slopes: &mut Vec<f64>,
    ) -> bool {
        if self.tangents.is_none() || turns.is_empty() {
            return false;
        }
        self.gather(shot, shared, own, state);
        let (h, r) = (self.hypothesis, self.references);
        self.directions.clear();
        for &turn in turns {
            let modal = 2 * h.modes;
            match turn {
                Turn::State(i) if i < modal => self.directions.push([(r.states[i], 1.0)]),
                Turn::State(i) => self.directions.push([(h.extra_states[i - modal].0, 1.0)]),
                Turn::Shared(c) => {
                    let of = (&self.runs[shot.run], shot);
                    self.directions.push(h.changes(r, of, c, shared[c]));
                }
                Turn::Own(c) => self.directions.push(h.own[shot.run][c].changes(own[c])),
            }
        }
        let origin = self.runs[shot.run].time[0];
        let times: Vec<f64> = (0..count).map(|i| shot.time[i * stride] - origin).collect();
        let (integers, integer_values) = self.integers(stuck);
        let mut values = vec![0.0; count];
        slopes.clear();
        slopes.resize(count * turns.len(), 0.0);
        let tangents = self.tangents.as_mut().expect("looked at above");
        tangents.set((&integers, &integer_values), (&self.names, &self.values))
            && tangents.evaluate(&times, r.measured, &self.directions, &mut values, slopes)
    }

    /// Deviation in m from the measurement at which a prediction of run `run` is given up.
    pub fn limit(&self, run: usize) -> f64 {
        RUNAWAY * self.reach[run]
    }

    /// Writes the predicted displacement at every `stride`-th of the first `used` times of the shot;
    /// `false` if the motion ran away from the measurement and was given up, after the times written.
    ///
    /// # Errors
    /// Values that the FMU refuses, or a motion that it can't follow.
    #[allow(clippy::too_many_arguments)]
    pub fn predict(
        &mut self,
        shot: &Shot,
        shared: &[f64],
        own: &[f64],
        state: &[f64],
        stuck: bool,
        used: usize,
        stride: usize,
        out: &mut Vec<f64>,
    ) -> Result<bool, Error> {
        // Time of the campaign's runs counts from their own first sample.
        let origin = self.runs[shot.run].time[0];
        let mut t = shot.time[0] - origin;
        self.start(shot, shared, own, state, stuck)?;
        let r = self.references;
        out.clear();
        let mut y = [0.0];
        self.instance.get_real(&[r.measured], &mut y)?;
        out.push(y[0]);
        let mut k = stride;
        while k < used {
            let next = shot.time[k] - origin;
            self.instance.do_step(t, next - t)?;
            self.instance.get_real(&[r.measured], &mut y)?;
            if (y[0] - shot.measured[k]).abs() > self.limit(shot.run) {
                // A motion that runs away would cost the time of a thousand others.
                return Ok(false);
            }
            out.push(y[0]);
            t = next;
            k += stride;
        }
        self.now = t;
        Ok(true)
    }

    /// Goes on from the end of the shot just predicted to the start of the next one and reads where the
    /// motion is then.
    ///
    /// # Errors
    /// A motion that the FMU can't follow.
    pub fn carry_on(
        &mut self,
        next: &Shot,
        shared: &[f64],
        own: &[f64],
    ) -> Result<ShotStart, Error> {
        let t = next.time[0] - self.runs[next.run].time[0];
        if t > self.now {
            self.instance.do_step(self.now, t - self.now)?;
        }
        let r = self.references;
        let modal = 2 * self.hypothesis.modes;
        let mut state = vec![0.0; modal];
        self.instance.get_real(&r.states, &mut state)?;
        let mut mode = [0];
        self.instance.get_integer(&[r.contact_mode], &mut mode)?;
        let stuck = mode[0] == 0;
        let extra: Vec<u32> = self.hypothesis.extra_states.iter().map(|s| s.0).collect();
        let mut values = vec![0.0; extra.len()];
        self.instance.get_real(&extra, &mut values)?;
        state.resize(modal + extra.len(), 0.0);
        if !extra.is_empty() {
            // Effects' states count from their equilibrium, which the FMU tells when it is started there.
            self.start(next, shared, own, &state, stuck)?;
            let mut equilibrium = vec![0.0; extra.len()];
            self.instance.get_real(&extra, &mut equilibrium)?;
            for (i, (value, rest)) in values.iter().zip(&equilibrium).enumerate() {
                state[modal + i] = value - rest;
            }
        }
        Ok(ShotStart { state, stuck })
    }
}
