//! What a model that was found has of its own in each run, in the FMU's own variables, so that it can be run again without
//! the diagnosis: the run's parameters, and the start states of the pieces on which its error was judged.

use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::result::error_ladder::Step;

/// One run of a campaign as a model was fitted to it.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSet {
    /// The run's name.
    pub run: String,
    /// FMU variable and value: inputs, structure, friction, effects, and what is the run's own.
    pub parameters: Vec<(String, f64)>,
    /// FMU variables that every piece starts with.
    pub start_names: Vec<String>,
    /// The pieces, in the order of time.
    pub pieces: Vec<Piece>,
}

/// A piece of a run that is predicted from a start state of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Time in s of its first sample since the run's first one.
    pub start: f64,
    /// The same of its last sample.
    pub end: f64,
    /// What was measured at its start, in m or m/s, by which the record is known again.
    pub measured: f64,
    /// Values of the variables that it starts with.
    pub values: Vec<f64>,
}

/// What a step of the ladder has of its own in each run. The pieces of a run are those of the error in the ladder: all of them
/// where it was fitted, and those judged where it was kept out.
pub fn run_sets(problem: &Problem, step: &Step) -> Vec<RunSet> {
    (0..problem.campaign.runs.len())
        .map(|run| run_set(problem, step, run))
        .collect()
}

fn run_set(problem: &Problem, step: &Step, run: usize) -> RunSet {
    let is_judged = step.holdout.by_run[run].is_finite();
    let judgement = if is_judged { &step.holdout } else { &step.fit };
    let of_run = judgement.segments.iter().enumerate();
    let of_run = of_run.filter(|(_, k)| problem.segments[**k].run == run);
    let mut pieces: Vec<Piece> = of_run
        .map(|(place, &k)| piece(problem, step, &judgement.point, place, k))
        .collect();
    pieces.sort_by(|a, b| a.start.total_cmp(&b.start));
    RunSet {
        run: problem.campaign.runs[run].name.clone(),
        parameters: parameters(problem, step, &judgement.point, run),
        start_names: start_names(problem, step),
        pieces,
    }
}

/// Real variables that the FMU is given before each piece of a run, each once.
fn settings(problem: &Problem, step: &Step, point: &Point, run: usize) -> Vec<(u32, f64)> {
    let h = &step.fitted.hypothesis;
    let of_run = &problem.campaign.runs[run];
    let inputs = h.inputs(&problem.references, of_run, &point.shared);
    let mut out: Vec<(u32, f64)> = inputs.collect();
    out.extend(&h.fixed);
    let shared = h.shared.iter().zip(&point.shared);
    let per_run = h.per_run[run].iter().zip(&point.per_run[run]);
    for (parameter, position) in shared.chain(per_run) {
        for (reference, value) in parameter.settings(*position) {
            match parameter.adds_to(out.iter().map(|o| o.0), reference) {
                Some(i) => out[i].1 += value,
                None => out.push((reference, value)),
            }
        }
    }
    out
}

/// Everything that the FMU is given before each piece of a run, by name.
fn parameters(problem: &Problem, step: &Step, point: &Point, run: usize) -> Vec<(String, f64)> {
    let all = settings(problem, step, point, run).into_iter();
    let reals = all.map(|(reference, value)| (real_name(problem, reference), value));
    let modes = problem.references.mode_count;
    let modes = modes.map(|_| ("mode_count".to_owned(), step.fitted.hypothesis.modes as f64));
    modes.into_iter().chain(reals).collect()
}

/// Values of the effects of a step by FMU variable, a phase as in the first run.
pub fn effect_values(problem: &Problem, step: &Step) -> Vec<(String, f64)> {
    let choices = step.fitted.hypothesis.choices.iter();
    let of_effects: Vec<u32> = choices
        .flat_map(|c| problem.catalogue[c.effect].parameters.iter())
        .map(|p| p.reference)
        .collect();
    let all = settings(problem, step, &step.fitted.fit.point, 0).into_iter();
    all.filter(|(reference, _)| of_effects.contains(reference))
        .map(|(reference, value)| (real_name(problem, reference), value))
        .collect()
}

/// Column of what is to be added to the output that the sensor measures, in its unit, where the FMU does not do so.
pub const SENSOR_OFFSET: &str = "sensor_offset";

/// Values of `start.contact`.
const STICK: f64 = 1.0;
const SLIP: f64 = 2.0;
/// Value of `start.effects`: effects' states count from where they settle.
const SETTLED: f64 = 1.0;

/// How a start of contact, effects, belt travel in m and dwell in s is given besides its state, as
/// [`crate::diagnose::model::predictor::Predictor`] gives it: variables and values of those that the FMU has.
fn how(problem: &Problem, stuck: bool, travel: f64, dwell: f64) -> Vec<(&'static str, f64)> {
    let r = &problem.references;
    let contact = if stuck { STICK } else { SLIP };
    [
        ("start.contact", r.contact, contact),
        ("start.effects", r.start_effects, SETTLED),
        ("belt_travel.start", r.history[0], travel),
        ("dwell_time.start", r.history[1], dwell),
    ]
    .into_iter()
    .filter_map(|(name, reference, value)| reference.map(|_| (name, value)))
    .collect()
}

fn start_names(problem: &Problem, step: &Step) -> Vec<String> {
    let states = problem.references.starts.iter().copied();
    let extra = step.fitted.hypothesis.extra_states.iter().map(|s| s.0);
    let states = states.chain(extra).map(|s| real_name(problem, s));
    let how = how(problem, false, 0.0, 0.0).into_iter();
    let how = how.map(|(name, _)| problem.fmu.own_name(name).to_owned());
    let offset = problem.references.lacks_offset;
    let offset = offset.then(|| SENSOR_OFFSET.to_owned());
    how.chain(states).chain(offset).collect()
}

fn piece(problem: &Problem, step: &Step, point: &Point, place: usize, k: usize) -> Piece {
    let segment = &problem.segments[k];
    let origin = problem.campaign.runs[segment.run].time[0];
    let h = &step.fitted.hypothesis;
    let run = &problem.campaign.runs[segment.run];
    let state = &point.states[place];
    let travel = h.travel(&problem.references, (run, segment), &point.shared, state);
    let how = how(problem, point.stuck[place], travel, segment.dwell).into_iter();
    let states = state.iter().copied();
    let own = h.per_run[segment.run]
        .iter()
        .zip(&point.per_run[segment.run]);
    let offset = own.filter(|(parameter, _)| parameter.is_offset());
    let offset = offset.map(|(parameter, position)| parameter.value(*position));
    let offset = offset.filter(|_| problem.references.lacks_offset);
    Piece {
        start: segment.time[0] - origin,
        end: segment.time[segment.time.len() - 1] - origin,
        measured: segment.measured[0],
        values: how
            .map(|(_, value)| value)
            .chain(states)
            .chain(offset)
            .collect(),
    }
}

/// Name of the Real variable with a value reference.
fn real_name(problem: &Problem, reference: u32) -> String {
    use crate::fmu::Kind;
    let variables = &problem.fmu.description().variables;
    let is_it = |v: &&crate::fmu::Variable| v.kind == Kind::Real && v.reference == reference;
    let mut found = variables.iter().filter(is_it);
    found
        .next()
        .expect("the reference was looked up by a name")
        .name
        .clone()
}
