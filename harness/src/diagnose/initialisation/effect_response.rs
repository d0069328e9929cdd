//! What one effect changes in the prediction of short windows, beside a model that lacks it: columns of a regression on sets of effects
//! ([`super::subset_regression`]).
//!
//! An effect that is switched off by degrees enters by its derivative there, and by what it changes at strengths met in
//! practice, where it may be far from linear; what has no such switch (a natural frequency, a stiffness) by what it changes at places
//! of a grid; what repeats by a cosine and a sine in each run, at the strongest lines of the residuals; values along the belt by
//! their derivatives.

use crate::diagnose::estimation::fit_options::STRIDE;
use crate::diagnose::estimation::fitter::{Fitter, directions};
use crate::diagnose::estimation::nesting::widen;
use crate::diagnose::estimation::sensitivities::{Linear, Turned};
use crate::diagnose::initialisation::response_spectrum::{ResponseSpectrum, independent_lines};
use crate::diagnose::initialisation::score_test::{At, BARELY_ON, one_step};
use crate::diagnose::initialisation::shape_grid::shape_grid;
use crate::diagnose::initialisation::starts::{at as on_line, resonance_ratios};
use crate::diagnose::initialisation::subset_regression::{Change, Effect};
use crate::diagnose::model::belt_profile::{is_profile, tried_lengths};
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::thresholds::STATE_SPREAD;
use crate::error::Error;
use crate::fmu::effect_card::{EffectCard, Role};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::FRAC_PI_2;

/// Strengths met in practice, as factors on the typical one, of what can't be negative; of what can, the typical one to both sides.
const STRENGTHS: [f64; 3] = [1.0, 0.2, 5.0];
/// Lines of what repeats that are looked at.
const LINES: usize = 4;
/// Standard deviations that are tried of the values along the belt.
const STDS: [f64; 3] = [0.2, 0.05, 0.0125];

/// What an effect changes in one of its shapes.
pub(crate) struct Response {
    /// The effect as it is chosen.
    pub choice: Choice,
    /// What it changes in each window.
    pub effect: Effect,
    /// Positions of its shared parameters and of those of each run, by name.
    shared: Vec<(String, f64)>,
    per_run: Vec<Vec<(String, f64)>>,
    unit: Unit,
}

/// What a coefficient is of.
enum Unit {
    /// Of the strength with this name, in this unit.
    Strength(String, f64),
    /// Of what stands for itself: it is there as it is.
    Whole,
    /// Of the values along the belt with these names, each of one run.
    Nodes(Vec<(usize, String)>),
    /// Cosine and sine in each run of the amplitude with the first name, in this unit, and the phase with the second.
    Line(String, String, f64),
}

/// An effect beside the model, as its responses are taken.
struct Beside<'a> {
    problem: &'a Problem<'a>,
    h: &'a Hypothesis,
    card: &'a EffectCard,
    choice: &'a Choice,
    at: &'a At<'a>,
    /// The model as a point of the hypothesis with the effect.
    without: Point,
}

impl Response {
    /// Whether it is of values along the belt, which imitate much.
    pub fn has_many_values(&self) -> bool {
        matches!(self.unit, Unit::Nodes(_))
    }

    /// Sets the effect's parameters as these coefficients have them.
    pub fn put(&self, h: &Hypothesis, point: &mut Point, coefficients: &[f64]) {
        let strength = |point: &mut Point, name: &str, value: f64| {
            if let Some(i) = h.shared_index(name) {
                point.shared[i] = h.shared[i].clamp(h.shared[i].position(value));
            }
        };
        for (name, position) in &self.shared {
            if let Some(i) = h.shared_index(name) {
                point.shared[i] = *position;
            }
        }
        for (run, own) in self.per_run.iter().enumerate() {
            for (name, position) in own {
                move_own(h, point, run, name, |_| *position);
            }
        }
        match &self.unit {
            Unit::Whole => {}
            Unit::Strength(name, unit) => strength(point, name, coefficients[0] * unit),
            Unit::Nodes(nodes) => {
                for ((run, name), value) in nodes.iter().zip(coefficients) {
                    move_own(h, point, *run, name, |_| *value);
                }
            }
            Unit::Line(amplitude, phase, unit) => {
                let runs: Vec<&[f64]> = coefficients.chunks(2).collect();
                let squares = runs.iter().map(|r| r[0] * r[0] + r[1] * r[1]);
                // A run that is kept out tells nothing.
                let told: Vec<f64> = squares.filter(|s| *s > 0.0).collect();
                let size = (told.iter().sum::<f64>() / told.len().max(1) as f64).sqrt();
                strength(point, amplitude, size * unit);
                for (run, r) in runs.iter().enumerate() {
                    move_own(h, point, run, phase, |_| r[1].atan2(r[0]));
                }
            }
        }
    }
}

/// Moves a run's own parameter, if the hypothesis has it.
pub(super) fn move_own(
    h: &Hypothesis,
    point: &mut Point,
    run: usize,
    name: &str,
    to: impl Fn(f64) -> f64,
) {
    if let Some(i) = h.per_run[run].iter().position(|p| p.name == name) {
        let value = &mut point.per_run[run][i];
        *value = h.per_run[run][i].clamp(to(*value));
    }
}

/// What an effect changes beside the model at `at`, in each of its shapes.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(crate) fn responses_of(
    problem: &Problem,
    choice: &Choice,
    at: &At,
) -> Result<Vec<Response>, Error> {
    let card = &problem.catalogue[choice.effect];
    if !is_profile(card) {
        return in_shapes(problem, choice, at);
    }
    let lengths = tried_lengths(card, &problem.tracks);
    let mut found = Vec::new();
    for &length in &lengths {
        let mut choice = choice.clone();
        choice.roughness.length = length;
        found.extend(in_shapes(problem, &choice, at)?);
    }
    let price = (found.len() as f64).ln();
    found.iter_mut().for_each(|r| r.effect.price = price);
    Ok(found)
}

/// What an effect changes with these beliefs, in each of its shapes.
fn in_shapes(problem: &Problem, choice: &Choice, at: &At) -> Result<Vec<Response>, Error> {
    let known = at.base.hypothesis.choices.iter();
    let choices: Vec<Choice> = known.chain([choice]).cloned().collect();
    let h = problem.hypothesis(&choices)?;
    let beside = Beside {
        problem,
        h: &h,
        card: &problem.catalogue[choice.effect],
        choice,
        at,
        without: widen(at.base, &h, &Point::centre(&h, at.segments)),
    };
    let mut predictor = problem.predictor(&h)?;
    Ok(beside.responses(&mut predictor))
}

impl Beside<'_> {
    fn name(&self, parameter: usize) -> String {
        format!("{}.{}", self.card.id, self.card.parameters[parameter].name)
    }

    fn index(&self, parameter: usize) -> Option<usize> {
        self.h.shared_index(&self.name(parameter))
    }

    fn responses(&self, predictor: &mut Predictor<'_>) -> Vec<Response> {
        if self.card.repeats() {
            return self.lines(predictor).unwrap_or_default();
        }
        let nodes = self.nodes();
        if !nodes.is_empty() {
            return self.profiles(predictor, &nodes);
        }
        let switch = self.card.switch();
        let is_shape =
            |&i: &usize| Some(i) != switch && self.card.parameters[i].role == Role::Shape;
        let shapes: Vec<usize> = (0..self.card.parameters.len()).filter(is_shape).collect();
        let grid = match self.card.resonance() {
            Some(frequency) => self.resonances(&shapes, frequency),
            None => shape_grid(self.problem, self.choice.effect, &shapes),
        };
        let mut found = Vec::new();
        for values in &grid {
            let mut point = self.without.clone();
            for (&i, value) in shapes.iter().zip(values) {
                if let Some(j) = self.index(i) {
                    let parameter = &self.h.shared[j];
                    point.shared[j] = parameter.clamp(parameter.position(*value));
                }
            }
            match switch.and_then(|i| Some((i, self.index(i)?))) {
                Some(switch) => found.extend(self.strengths(predictor, &point, switch)),
                None => found.extend(self.change(predictor, &point, None)),
            }
        }
        let price = (found.len() as f64).ln();
        found.iter_mut().for_each(|r| r.effect.price = price);
        found
    }

    /// Natural frequencies about the typical one, the other shapes as they are met.
    fn resonances(&self, shapes: &[usize], frequency: usize) -> Vec<Vec<f64>> {
        let at = |ratio: f64| {
            let value = |&i: &usize| match i == frequency {
                true => ratio * self.card.parameters[i].typical,
                false => self.card.parameters[i].typical,
            };
            shapes.iter().map(value).collect()
        };
        resonance_ratios().map(at).collect()
    }

    /// Windows linearised at a point, beside what is known of the model without the effect.
    fn slopes(&self, predictor: &mut Predictor<'_>, point: &Point) -> Vec<Option<Linear>> {
        let data = self.problem.data(self.at.segments);
        let mut fitter = Fitter::new(predictor, self.h, &data, one_step());
        let windows = self.at.linear().iter().enumerate();
        let turned = Turned::Beside(self.at.known());
        let slopes = windows.map(|(k, known)| {
            let residual = known.as_ref()?.residual.clone();
            Some(fitter.linearise(k, point, residual, turned))
        });
        slopes.collect()
    }

    /// A response with these changes, at a point.
    fn response(&self, point: &Point, changes: Vec<Change>, std: Vec<f64>, unit: Unit) -> Response {
        let own = format!("{}.", self.card.id);
        let named = |parameters: &[Parameter], values: &[f64]| -> Vec<(String, f64)> {
            let all = parameters.iter().zip(values);
            let all = all.filter(|(p, _)| p.name.starts_with(&own));
            all.map(|(p, u)| (p.name.clone(), *u)).collect()
        };
        let runs = self.h.per_run.iter().zip(&point.per_run);
        Response {
            choice: self.choice.clone(),
            effect: Effect {
                changes,
                std,
                is_positive: false,
                price: 0.0,
            },
            shared: named(&self.h.shared, &point.shared),
            per_run: runs.map(|(p, u)| named(p, u)).collect(),
            unit,
        }
    }

    /// Derivative by a strength where it is off, and what strengths met in practice change.
    fn strengths(
        &self,
        predictor: &mut Predictor<'_>,
        shaped: &Point,
        (strength, place): (usize, usize),
    ) -> Vec<Response> {
        let (card, parameter) = (&self.card.parameters[strength], &self.h.shared[place]);
        let with = |value: f64| {
            let mut point = shaped.clone();
            point.shared[place] = parameter.clamp(parameter.position(value));
            point
        };
        let barely = with(BARELY_ON * card.typical);
        let unit = card.typical / parameter.slope(barely.shared[place]);
        let changes = self.slopes(predictor, &barely).into_iter().enumerate();
        let changes = changes.map(|(k, linear)| {
            let column = linear
                .as_ref()
                .map(|l| l.parameters.columns(place, 1) * unit);
            Change {
                columns: column.unwrap_or(DMatrix::zeros(0, 1)),
                states: self.states(k, &barely, linear.as_ref()),
            }
        });
        let std = (card.max - card.min) / 12.0_f64.sqrt() / card.typical.abs();
        let unit = Unit::Strength(self.name(strength), card.typical);
        let mut slope = self.response(&barely, changes.collect(), vec![std], unit);
        slope.effect.is_positive = card.min >= 0.0;
        let factors: &[f64] = match card.min < 0.0 {
            true => &[1.0, -1.0],
            false => &STRENGTHS,
        };
        let points = factors.iter().map(|factor| with(factor * card.typical));
        let changed = points.filter_map(|p| self.change(predictor, &p, Some((strength, place))));
        std::iter::once(slope).chain(changed).collect()
    }

    /// What the effect changes at a point, in units of its strength there; `None` where a window can't be predicted.
    fn change(
        &self,
        predictor: &mut Predictor<'_>,
        point: &Point,
        strength: Option<(usize, usize)>,
    ) -> Option<Response> {
        let data = self.problem.data(self.at.segments);
        let mut fitter = Fitter::new(predictor, self.h, &data, one_step());
        let mut changes = Vec::new();
        for (k, known) in self.at.linear().iter().enumerate() {
            let Some(known) = known else {
                changes.push(Change {
                    columns: DMatrix::zeros(0, 1),
                    states: DMatrix::zeros(0, 0),
                });
                continue;
            };
            let residual = fitter.residual(k, point)?;
            let pairs = known.residual.iter().zip(&residual);
            let column = DVector::from_iterator(known.residual.len(), pairs.map(|(a, b)| a - b));
            let states = match self.added_states(k, point)[..] {
                [] => DMatrix::zeros(residual.len(), 0),
                _ => {
                    let linear = fitter.linearise(k, point, residual, Turned::State);
                    self.states(k, point, Some(&linear))
                }
            };
            changes.push(Change {
                columns: DMatrix::from_columns(&[column]),
                states,
            });
        }
        let (std, unit) = match strength {
            Some((i, place)) => {
                let value = self.h.shared[place].value(point.shared[place]);
                let card = &self.card.parameters[i];
                let std = (card.max - card.min) / 12.0_f64.sqrt() / value.abs();
                (std, Unit::Strength(self.name(i), value))
            }
            None => (1.0, Unit::Whole),
        };
        let mut found = self.response(point, changes, vec![std], unit);
        found.effect.is_positive = true;
        Some(found)
    }

    /// What the effect adds to the start state of window `k`, its own states and the velocity that is no longer given where stick is not
    /// rigid: places among its directions, and which of the state they are.
    fn added_states(&self, k: usize, point: &Point) -> Vec<(usize, usize)> {
        let known = &self.at.base.hypothesis;
        let of_known = directions(known, self.at.base.fit.point.stuck[k]);
        let modal = self.h.state_scales.len();
        let is_known = |i: usize| match i.checked_sub(modal) {
            None => of_known.contains(&i),
            Some(own) => {
                let (reference, _) = self.h.extra_states[own];
                known.extra_states.iter().any(|s| s.0 == reference)
            }
        };
        let list = directions(self.h, point.stuck[k]).into_iter().enumerate();
        list.filter(|&(_, i)| !is_known(i)).collect()
    }

    /// Derivatives by these, in units of what is believed of them over the noise.
    fn states(&self, k: usize, point: &Point, linear: Option<&Linear>) -> DMatrix<f64> {
        let Some(linear) = linear else {
            return DMatrix::zeros(0, 0);
        };
        let modal = self.h.state_scales.len();
        let data = self.problem.data(self.at.segments);
        let noise = data.noise[self.at.segments[k].run];
        let scale = |i: usize| match self.h.state_scales.get(i) {
            Some(scale) => STATE_SPREAD * scale,
            None => STATE_SPREAD * self.h.extra_states[i - modal].1 / noise,
        };
        let added = self.added_states(k, point).into_iter();
        let columns: Vec<DVector<f64>> = added
            .map(|(c, i)| linear.states.column(c) * scale(i))
            .collect();
        match columns.is_empty() {
            true => DMatrix::zeros(linear.residual.len(), 0),
            false => DMatrix::from_columns(&columns),
        }
    }

    /// The effect's values along the belt.
    fn nodes(&self) -> Vec<(usize, String)> {
        let own = format!("{}.", self.card.id);
        let is_node = |p: &&Parameter| p.support.is_some() && p.name.starts_with(&own);
        let runs = self.h.per_run.iter().enumerate();
        let of_run = |(run, parameters): (usize, &Vec<Parameter>)| {
            let nodes = parameters.iter().filter(is_node);
            let named = nodes.map(|p| (run, p.name.clone()));
            named.collect::<Vec<_>>()
        };
        runs.flat_map(of_run).collect()
    }

    /// Values along the belt, with each of the spreads that they may have.
    fn profiles(&self, predictor: &mut Predictor<'_>, nodes: &[(usize, String)]) -> Vec<Response> {
        let slopes = self.slopes(predictor, &self.without);
        let column = |linear: &Linear, k: usize, (run, name): &(usize, String)| {
            let own = &self.h.per_run[*run];
            let place = own.iter().position(|p| p.name == *name);
            match place.filter(|_| self.at.segments[k].run == *run) {
                Some(i) => linear
                    .parameters
                    .column(self.h.shared.len() + i)
                    .into_owned(),
                None => DVector::zeros(linear.residual.len()),
            }
        };
        let change = |(k, linear): (usize, &Option<Linear>)| match linear {
            Some(linear) => {
                let columns: Vec<_> = nodes.iter().map(|node| column(linear, k, node)).collect();
                Change {
                    states: DMatrix::zeros(linear.residual.len(), 0),
                    columns: DMatrix::from_columns(&columns),
                }
            }
            None => Change {
                states: DMatrix::zeros(0, 0),
                columns: DMatrix::zeros(0, nodes.len()),
            },
        };
        let with_spread = |std: f64| {
            let changes = slopes.iter().enumerate().map(change).collect();
            let unit = Unit::Nodes(nodes.to_vec());
            let stds = vec![std; nodes.len()];
            let mut found = self.response(&self.without, changes, stds, unit);
            found.choice.roughness.std = std;
            found
        };
        STDS.into_iter().map(with_spread).collect()
    }

    /// What repeats, at the strongest lines of the residuals.
    fn lines(&self, predictor: &mut Predictor<'_>) -> Option<Vec<Response>> {
        let (amplitude, phase) = (
            self.card.find_role(Role::Amplitude)?,
            self.card.find_role(Role::Phase)?,
        );
        let (place, phase_name) = (self.index(amplitude)?, self.name(phase));
        let card = &self.card.parameters[amplitude];
        let data = self.problem.data(self.at.segments);
        let (h, origin) = (self.h, &self.without);
        let spectrum = ResponseSpectrum::new(predictor, h, self.card, &data, origin, STRIDE);
        let lines = spectrum.map_or(Vec::new(), |mut s| s.strongest(LINES));
        let independent = independent_lines(self.card, self.at.segments);
        let runs = h.per_run.len();
        let mut found = Vec::new();
        for line in lines {
            let there = on_line(h, self.card, origin, &line)?;
            let mut probe = there.clone();
            let parameter = &h.shared[place];
            probe.shared[place] = parameter.clamp(parameter.position(BARELY_ON * card.typical));
            let unit = card.typical / parameter.slope(probe.shared[place]);
            let waves = [0.0, FRAC_PI_2].map(|angle| {
                for run in 0..runs {
                    move_own(h, &mut probe, run, &phase_name, |_| angle);
                }
                self.slopes(predictor, &probe)
            });
            let change = |k: usize| {
                let rows = waves[0][k].as_ref().map_or(0, |l| l.residual.len());
                let mut columns = DMatrix::zeros(rows, 2 * runs);
                for (wave, slopes) in waves.iter().enumerate() {
                    if let Some(linear) = &slopes[k] {
                        let column = linear.parameters.column(place) * unit;
                        columns.set_column(2 * self.at.segments[k].run + wave, &column);
                    }
                }
                let states = DMatrix::zeros(rows, 0);
                Change { columns, states }
            };
            let changes = (0..self.at.segments.len()).map(change).collect();
            let std = (card.max - card.min) / 12.0_f64.sqrt() / card.typical;
            let of_line = Unit::Line(self.name(amplitude), phase_name.clone(), card.typical);
            let mut response = self.response(&there, changes, vec![std; 2 * runs], of_line);
            response.effect.price = independent.max(1.0).ln();
            found.push(response);
        }
        Some(found)
    }
}
