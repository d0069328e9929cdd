//! Predicts segments with one instance of the FMU.

use crate::diagnose::data::segment::{FurtherPart, Segment, reach};
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::instants::Instants;
use crate::diagnose::model::parameter::{Kind, Parameter, SensorConstant};
use crate::diagnose::model::references::References;
use crate::diagnose::model::simulator::{
    RUNAWAY, Samples, SegmentStart, SegmentValues, Simulator, Turn,
};
use crate::diagnose::model::work::Work;
use crate::error::Error;
use crate::fmu::{Course, Directions, Drive, Fmu, Instance, Tangents};
use crate::measurement::Run;
use std::ops::Range;

/// Relative tolerance of the FMU while it is fitted: errors of 1e-10 m, or 1e-7 m/s, far below any sensor's noise.
const TOLERANCE: f64 = 1e-9;

/// Runs segments through the FMU. Belongs to one thread.
pub struct Predictor<'a> {
    instance: Instance,
    references: &'a References,
    runs: &'a [Run],
    hypothesis: &'a Hypothesis,
    /// Gives derivatives along motions, where the FMU offers that.
    tangents: Option<Tangents>,
    directions: Directions,
    work: &'a Work,
    /// Whether inputs can be given slopes.
    has_slopes: bool,
    names: Vec<u32>,
    values: Vec<f64>,
    /// Largest distance from the mean in each run, in m or m/s.
    reach: Vec<f64>,
    /// Time in s at which the last prediction ended.
    now: f64,
    /// The last sample that it reached.
    reached: usize,
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
        work: &'a Work,
    ) -> Result<Self, Error> {
        let has_slopes = fmu.description().capabilities.can_interpolate_inputs;
        let is_driven = runs.iter().any(|r| r.inputs.series().next().is_some());
        Ok(Self {
            instance: if is_driven && has_slopes {
                fmu.instantiate_driven("diagnosis")?
            } else {
                fmu.instantiate("diagnosis")?
            },
            has_slopes,
            references,
            runs,
            hypothesis,
            tangents: fmu.tangents(),
            directions: Directions::default(),
            work,
            names: Vec::new(),
            values: Vec::new(),
            reach: runs
                .iter()
                .map(|r| reach(r.measured.iter().copied()))
                .collect(),
            now: 0.0,
            reached: 0,
        })
    }

    /// What the sensor of a run adds to the output, where the FMU does not.
    fn offset(&self, run: usize, per_run: &[f64]) -> f64 {
        if !self.references.lacks_offset {
            return 0.0;
        }
        let parameters = self.hypothesis.per_run[run].iter().zip(per_run);
        let offsets = parameters.filter(|(parameter, _)| parameter.is_offset());
        offsets.map(|(parameter, &u)| parameter.value(u)).sum()
    }

    fn push(&mut self, reference: u32, value: f64) {
        self.names.push(reference);
        self.values.push(value);
    }

    fn push_if_any(&mut self, reference: Option<u32>, value: f64) {
        if let Some(reference) = reference {
            self.push(reference, value);
        }
    }

    /// Lists the Real variables that a segment starts with.
    fn gather(&mut self, segment: &Segment, values: SegmentValues) {
        let SegmentValues {
            shared,
            per_run,
            state,
            ..
        } = values;
        let h = self.hypothesis;
        let r = self.references;
        let run = &self.runs[segment.run];
        self.names.clear();
        self.values.clear();
        self.push_if_any(r.tolerance, TOLERANCE);
        for (reference, value) in h.inputs(r, run, shared) {
            self.push(reference, value);
        }
        let travel = h.travel(r, (run, segment), shared, state);
        self.push_if_any(r.history[0], travel);
        self.push_if_any(r.history[1], segment.dwell);
        for &(reference, value) in &h.fixed {
            self.push(reference, value);
        }
        let parameters = h.shared.iter().zip(shared);
        for (parameter, &position) in parameters.chain(h.per_run[segment.run].iter().zip(per_run)) {
            for (reference, value) in parameter.settings(position) {
                match parameter.adds_to(self.names.iter().copied(), reference) {
                    Some(i) => self.values[i] += value,
                    None => self.push(reference, value),
                }
            }
        }
        let modal = 2 * h.modes;
        for (&reference, &value) in r.starts.iter().zip(&state[..modal]) {
            self.push(reference, value);
        }
        for (&(reference, _), &value) in h.extra_states.iter().zip(&state[modal..]) {
            self.push(reference, value);
        }
    }

    /// The Integer variables that a segment starts with: contact (Stick = 1, Slip = 2), effects (Settled = 1), modes.
    fn integers(&self, stuck: bool) -> (Vec<u32>, Vec<i32>) {
        let r = self.references;
        let all = [
            (r.contact, if stuck { 1 } else { 2 }),
            (r.start_effects, 1),
            (r.mode_count, self.hypothesis.modes as i32),
        ];
        let there = all.into_iter();
        there.filter_map(|(r, value)| Some((r?, value))).unzip()
    }

    /// The constants that the sensors of a run have, and where they stand.
    fn sensor_constants<'v>(
        &self,
        run: usize,
        values: SegmentValues<'v>,
    ) -> Vec<(&'a Parameter, f64)> {
        let h = self.hypothesis;
        let shared = h.shared.iter().zip(values.shared);
        let all = shared.chain(h.per_run[run].iter().zip(values.per_run));
        let of_sensors = all.filter(|(p, _)| matches!(p.kind, Kind::Sensor(..)));
        of_sensors.map(|(p, position)| (p, *position)).collect()
    }

    /// Outputs that are read: that of the first sensor, then those of further ones, where a segment has any.
    fn outputs(&self, further: &[FurtherPart]) -> Vec<u32> {
        let r = self.references;
        let others: &[u32] = match further {
            [] => &[],
            _ => &r.further.outputs,
        };
        std::iter::once(&r.measured)
            .chain(others)
            .copied()
            .collect()
    }

    /// Times of samples of a segment, and those at which clocks that are late by `delays` in s read them. Time of the campaign's runs counts
    /// from their own first sample.
    fn instants(
        &self,
        segment: &Segment,
        samples: Samples,
        delays: &[f64],
        with_later: bool,
    ) -> Instants {
        let origin = self.runs[segment.run].time[0];
        let asked = segment.time.iter().step_by(samples.stride);
        let times: Vec<f64> = asked.take(samples.count).map(|t| t - origin).collect();
        let end = segment.time[segment.time.len() - 1] - origin;
        Instants::new(&times, end, delays, with_later)
    }

    /// What drives run `run` over samples; empty where its inputs are constant.
    fn drive(&self, run: usize, range: Range<usize>, shared: &[f64]) -> Option<Drive> {
        let run = &self.runs[run];
        run.inputs.series().next()?;
        let (h, r) = (self.hypothesis, self.references);
        let of_input = |name: &str| h.input_scale(r, name, shared);
        Some(Drive::over(run, range, self.has_slopes, of_input))
    }

    /// Puts the FMU at the start of a segment.
    fn start(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        drive: Option<&Drive>,
    ) -> Result<(), Error> {
        self.gather(segment, values);
        let (names, integers) = self.integers(values.stuck);
        self.instance.reset()?;
        self.instance.set_integer(&names, &integers)?;
        self.instance.set_real(&self.names, &self.values)?;
        let origin = self.runs[segment.run].time[0];
        let begin = segment.time[0] - origin;
        if let Some(drive) = drive {
            drive.begin(&mut self.instance, begin)?;
        }
        self.instance.initialize(begin, None, None)
    }

    /// Takes the instance from `now` to `next` in s.
    fn advance(&mut self, drive: Option<&Drive>, now: f64, next: f64) -> Result<(), Error> {
        match drive {
            Some(drive) => drive.advance(&mut self.instance, now, next),
            None => self.instance.do_step(now, next - now),
        }
    }
}

/// The further sensors of a segment that samples are asked of.
fn further_of(segment: &Segment, samples: Samples) -> &[FurtherPart] {
    match samples.further {
        true => &segment.further,
        false => &[],
    }
}

/// The samples of a segment within its run.
fn samples_of(segment: &Segment) -> Range<usize> {
    segment.first..segment.first + segment.time.len()
}

impl Simulator for Predictor<'_> {
    fn differentiate(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        turns: &[Turn],
        samples: Samples,
        slopes: &mut Vec<f64>,
    ) -> bool {
        if self.tangents.is_none() || turns.is_empty() {
            return false;
        }
        self.work.sensitivities(turns.len());
        self.gather(segment, values);
        let (h, r) = (self.hypothesis, self.references);
        self.directions.clear();
        let further = further_of(segment, samples);
        let of_sensor = |turn: &Turn| {
            let parameter = match *turn {
                Turn::State(_) => return None,
                Turn::Shared(c) => &h.shared[c],
                Turn::PerRun(c) => &h.per_run[segment.run][c],
            };
            match parameter.kind {
                Kind::Sensor(number, of) => Some((number, of)),
                _ => None,
            }
        };
        for &turn in turns.iter().filter(|turn| of_sensor(turn).is_none()) {
            match turn {
                Turn::State(i) => self.directions.push(h.start_changes(r, i)),
                Turn::Shared(c) => {
                    let of = (&self.runs[segment.run], segment);
                    self.directions.push(h.changes(r, of, c, values.shared[c]));
                }
                Turn::PerRun(c) => self
                    .directions
                    .push(h.per_run[segment.run][c].changes(values.per_run[c])),
            }
        }
        let Samples { count, .. } = samples;
        let constants = self.sensor_constants(segment.run, values);
        let by_delay = |turn: &Turn| matches!(of_sensor(turn), Some((_, SensorConstant::Delay)));
        let delays = r.further.delays(further, &constants);
        let instants = self.instants(segment, samples, &delays, turns.iter().any(by_delay));
        let (integers, integer_values) = self.integers(values.stuck);
        let outputs = self.outputs(further);
        let all = instants.times.len();
        let width = all * outputs.len();
        let mut motion = vec![0.0; width];
        let mut of_outputs = vec![0.0; width * self.directions.len()];
        let drive = self.drive(segment.run, samples_of(segment), values.shared);
        let course = drive.map_or_else(Course::default, |drive| {
            drive.course(instants.times[0], instants.times[all - 1])
        });
        let tangents = self.tangents.as_mut().expect("looked at above");
        let done = tangents.set((&integers, &integer_values), (&self.names, &self.values))
            && tangents.evaluate(
                (&instants.times, &course),
                &outputs,
                &self.directions,
                &mut motion,
                &mut of_outputs,
            );
        if further.is_empty() && self.directions.len() == turns.len() {
            *slopes = of_outputs;
            return done;
        }
        slopes.clear();
        let mut directions = of_outputs.chunks(width.max(1));
        for turn in turns {
            if let Some(constant) = of_sensor(turn) {
                slopes.resize(slopes.len() + count, 0.0);
                r.further.slopes_of_constant(
                    further,
                    &constants,
                    constant,
                    &motion[all..],
                    &instants,
                    slopes,
                );
            } else {
                let (first, others) = directions.next().expect("one each").split_at(all);
                slopes.extend(instants.samples.iter().map(|&place| first[place]));
                r.further
                    .slopes(further, &constants, others, &instants, slopes);
            }
        }
        done
    }

    fn limit(&self, run: usize) -> f64 {
        RUNAWAY * self.reach[run]
    }

    fn predict(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        samples: Samples,
        out: &mut Vec<f64>,
    ) -> Result<bool, Error> {
        self.work.motion();
        let drive = self.drive(segment.run, samples_of(segment), values.shared);
        self.start(segment, values, drive.as_ref())?;
        let r = self.references;
        let offset = self.offset(segment.run, values.per_run);
        out.clear();
        let further = further_of(segment, samples);
        let constants = self.sensor_constants(segment.run, values);
        let delays = r.further.delays(further, &constants);
        let instants = self.instants(segment, samples, &delays, false);
        let names = self.outputs(further);
        let mut y = vec![0.0; names.len()];
        let mut others = Vec::new();
        let mut is_near = true;
        let mut t = instants.times[0];
        for (place, &next) in instants.times.iter().enumerate() {
            if place > 0 {
                self.advance(drive.as_ref(), t, next)?;
            }
            self.instance.get_real(&names, &mut y)?;
            if instants.samples.get(out.len()) == Some(&place) {
                y[0] += offset;
                let measured = segment.measured[out.len() * samples.stride];
                if place > 0 && (y[0] - measured).abs() > self.limit(segment.run) {
                    // A motion that runs away would cost the time of a thousand others.
                    is_near = false;
                    break;
                }
                out.push(y[0]);
            }
            others.extend(&y[1..]);
            t = next;
        }
        if !further.is_empty() {
            let seen = (&others[..], out.len());
            r.further.read(further, &constants, seen, &instants, out);
        }
        if !is_near {
            return Ok(false);
        }
        self.now = t;
        self.reached = segment.first + (samples.count - 1) * samples.stride;
        Ok(true)
    }

    fn carry_on(
        &mut self,
        next: &Segment,
        shared: &[f64],
        per_run: &[f64],
    ) -> Result<SegmentStart, Error> {
        let t = next.time[0] - self.runs[next.run].time[0];
        if t > self.now {
            let gap = self.reached..next.first + 1;
            let drive = self.drive(next.run, gap, shared);
            self.advance(drive.as_ref(), self.now, t)?;
        }
        let r = self.references;
        let modal = 2 * self.hypothesis.modes;
        let mut state = vec![0.0; modal];
        self.instance.get_real(&r.states, &mut state)?;
        let stuck = match r.contact_mode {
            Some(contact) => {
                let mut mode = [1];
                self.instance.get_integer(&[contact], &mut mode)?;
                mode[0] == 0
            }
            None => false,
        };
        let extra: Vec<u32> = self.hypothesis.extra_states.iter().map(|s| s.0).collect();
        let mut reached = vec![0.0; extra.len()];
        self.instance.get_real(&extra, &mut reached)?;
        state.resize(modal + extra.len(), 0.0);
        if !extra.is_empty() {
            // Effects' states count from their equilibrium, which the FMU tells when it is started there.
            let values = SegmentValues {
                shared,
                per_run,
                state: &state,
                stuck,
            };
            let drive = self.drive(next.run, samples_of(next), shared);
            self.start(next, values, drive.as_ref())?;
            let mut equilibrium = vec![0.0; extra.len()];
            self.instance.get_real(&extra, &mut equilibrium)?;
            for (i, (value, rest)) in reached.iter().zip(&equilibrium).enumerate() {
                state[modal + i] = value - rest;
            }
        }
        Ok(SegmentStart { state, stuck })
    }
}
