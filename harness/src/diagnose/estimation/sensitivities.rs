//! Derivatives of a segment's prediction by its start state and by the parameters.

use crate::diagnose::estimation::fitter::{Fitter, LOST, Place, directions};
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::{Samples, SegmentValues, Turn};
use nalgebra::{DMatrix, DVector};

/// A segment's prediction, linearised.
#[derive(Clone)]
pub(crate) struct Linear {
    /// Measured less predicted, in m or m/s.
    pub residual: Vec<f64>,
    /// Derivatives of the prediction by the start state, in the order of [`directions`].
    pub states: DMatrix<f64>,
    /// Derivatives by the shared parameters, then by the run's own.
    pub parameters: DMatrix<f64>,
}

/// What a segment's prediction is differentiated by.
#[derive(Clone, Copy)]
pub(crate) enum Turned<'k> {
    /// Start state and parameters.
    All,
    /// The start state alone.
    State,
    /// Start state and parameters, where the derivatives by those of a smaller hypothesis are known.
    Beside(Known<'k>),
}

/// A smaller hypothesis, and the derivatives of all segments by what it has.
#[derive(Clone, Copy)]
pub(crate) struct Known<'k> {
    /// The smaller hypothesis.
    pub hypothesis: &'k Hypothesis,
    /// Whether each segment starts in stick.
    pub stuck: &'k [bool],
    /// The segments, linearised.
    pub linear: &'k [Option<Linear>],
}

impl Known<'_> {
    /// Copies the derivative by what `turn` is in a larger hypothesis; whether the smaller one has it.
    fn put(
        self,
        k: usize,
        run: usize,
        larger: &Hypothesis,
        turn: Turn,
        column: &mut [f64],
    ) -> bool {
        let (h, Some(linear)) = (self.hypothesis, &self.linear[k]) else {
            return false;
        };
        let same = |own: &[Parameter], wanted: &Parameter| {
            let mut all = own.iter();
            all.position(|p| p.name == wanted.name && p.support == wanted.support)
        };
        let from = match turn {
            Turn::Shared(c) => {
                same(&h.shared, &larger.shared[c]).map(|i| linear.parameters.column(i))
            }
            Turn::PerRun(c) => same(&h.per_run[run], &larger.per_run[run][c])
                .map(|i| linear.parameters.column(h.shared.len() + i)),
            Turn::State(i) => {
                let modal = 2 * larger.modes;
                let own = match i.checked_sub(modal) {
                    None => Some(i),
                    Some(extra) => {
                        let (reference, _) = larger.extra_states[extra];
                        let same = h.extra_states.iter().position(|s| s.0 == reference);
                        same.map(|j| modal + j)
                    }
                };
                let list = directions(h, self.stuck[k]);
                let place = own.and_then(|own| list.iter().position(|&j| j == own));
                place.map(|c| linear.states.column(c))
            }
        };
        let Some(from) = from.filter(|from| from.len() == column.len()) else {
            return false;
        };
        column.copy_from_slice(from.as_slice());
        true
    }
}

impl Fitter<'_, '_> {
    /// All segments, linearised by differences.
    pub(crate) fn linearise_all(&mut self, here: &Place) -> Vec<Option<Linear>> {
        let turned = if self.options.parameters {
            Turned::All
        } else {
            Turned::State
        };
        (0..self.data.segments.len())
            .map(|k| {
                let residual = here.residual[k].clone()?;
                Some(self.linearise(k, &here.point, residual, turned))
            })
            .collect()
    }

    /// Derivatives for one segment by differences.
    pub(crate) fn linearise(
        &mut self,
        k: usize,
        point: &Point,
        residual: Vec<f64>,
        turned: Turned<'_>,
    ) -> Linear {
        let segment = &self.data.segments[k];
        let h = self.hypothesis;
        let n = residual.len();
        let rows = n / (1 + segment.further.len());
        let predicted = self.predicted(k, &residual);
        let list = directions(h, point.stuck[k]);
        let per_run = h.per_run[segment.run].len();
        let mut states = DMatrix::zeros(n, list.len());
        let mut parameters = DMatrix::zeros(n, h.shared.len() + per_run);
        let mut values = Values {
            state: point.states[k].clone(),
            shared: point.shared.clone(),
            per_run: point.per_run[segment.run].clone(),
        };
        // What is the same for all segments of a run comes first, so that the FMU need not build its model anew for each.
        let with_parameters = !matches!(turned, Turned::State);
        let moves = |&c: &usize| with_parameters && self.moves(&h.shared[c]);
        let mut turns: Vec<Turn> = (0..h.shared.len())
            .filter(moves)
            .map(Turn::Shared)
            .collect();
        let mut local = Vec::new();
        for c in (0..per_run).filter(|_| with_parameters) {
            let parameter = &h.per_run[segment.run][c];
            let outside = parameter.support.is_some_and(|(low, high)| {
                segment.travel_end.max(segment.travel) < low
                    || segment.travel.min(segment.travel_end) > high
            });
            if parameter.prior_std == 0.0 || outside {
                continue;
            }
            if parameter.is_offset() {
                // Added to what is measured as it is.
                let mut column = parameters.column_mut(h.shared.len() + c);
                let stride = self.options.stride;
                for (i, slope) in column.iter_mut().enumerate().take(predicted) {
                    *slope = f64::from(u8::from(segment.trusted[i * stride]));
                }
            } else {
                let of_run = parameter.support.is_none();
                (if of_run { &mut turns } else { &mut local }).push(Turn::PerRun(c));
            }
        }
        turns.extend(list.iter().map(|&i| Turn::State(i)));
        turns.append(&mut local);
        let place = |turn: Turn| match turn {
            Turn::State(i) => list.iter().position(|&j| j == i).expect("from the list"),
            Turn::Shared(c) => c,
            Turn::PerRun(c) => h.shared.len() + c,
        };
        if let Turned::Beside(known) = turned {
            turns.retain(|&turn| {
                let mut column = match turn {
                    Turn::State(_) => states.column_mut(place(turn)),
                    _ => parameters.column_mut(place(turn)),
                };
                !known.put(k, segment.run, h, turn, column.as_mut_slice())
            });
        }
        let exact = self.differentiate(k, &values, &turns, predicted, point.stuck[k]);
        for (number, &turn) in turns.iter().enumerate() {
            let mut column = match turn {
                Turn::State(_) => states.column_mut(place(turn)),
                _ => parameters.column_mut(place(turn)),
            };
            let column = column.as_mut_slice();
            match &exact {
                Some(slopes) => {
                    let of_sensors = column.chunks_mut(rows);
                    let first = number * of_sensors.len();
                    for (sensor, column) in of_sensors.enumerate() {
                        let from = (first + sensor) * predicted;
                        column[..predicted].copy_from_slice(&slopes[from..from + predicted]);
                    }
                }
                None => {
                    let (residual, stuck) = (&residual[..], point.stuck[k]);
                    self.difference(k, &mut values, turn, (residual, predicted), stuck, column);
                }
            }
        }
        forget_unseen(&mut states, &list, &h.state_scales);
        Linear {
            residual,
            states,
            parameters,
        }
    }

    /// Derivatives of a segment's prediction at its first `count` samples by all `turns`, one after another, from the FMU
    /// itself, each sensor after sensor; nothing where it does not offer them. Samples that don't count have none.
    fn differentiate(
        &mut self,
        k: usize,
        values: &Values,
        turns: &[Turn],
        count: usize,
        stuck: bool,
    ) -> Option<Vec<f64>> {
        let segment = &self.data.segments[k];
        let stride = self.options.stride;
        let mut slopes = Vec::new();
        let done = self.simulator.differentiate(
            segment,
            values.at(stuck),
            turns,
            Samples {
                count,
                stride,
                further: true,
            },
            &mut slopes,
        );
        let of_further = segment.further.iter().map(|part| &part.trusted);
        let sensors: Vec<&Vec<bool>> = std::iter::once(&segment.trusted)
            .chain(of_further)
            .collect();
        let columns = slopes.chunks_mut(count.max(1)).enumerate();
        for (number, slopes) in columns {
            let trusted = sensors[number % sensors.len()];
            for (i, slope) in slopes.iter_mut().enumerate() {
                if !(trusted[i * stride] && slope.is_finite()) {
                    *slope = 0.0;
                }
            }
        }
        done.then_some(slopes)
    }

    /// Derivative of a segment's prediction by one thing that can be turned, by differences, written into `column`, beside what is left of
    /// `predicted` samples without it. A step whose response is far too strong to be linear is taken again smaller.
    fn difference(
        &mut self,
        k: usize,
        values: &mut Values,
        turn: Turn,
        (residual, predicted): (&[f64], usize),
        stuck: bool,
        column: &mut [f64],
    ) {
        let segment = &self.data.segments[k];
        let used = self.used(segment);
        let stride = self.options.stride;
        let sensors = 1 + segment.further.len();
        let rows = residual.len() / sensors;
        let followed = |out: &[f64]| (out.len() / sensors).min(predicted);
        let target = (RESPONSE * self.data.noise[segment.run]).max(LEAST_RESPONSE);
        let mut out = std::mem::take(&mut self.buffer);
        for _ in 0..ATTEMPTS {
            let (at, step) = self.step_of(k, values, turn);
            *values.of(turn) = at + step;
            let done = self.simulator.predict(
                segment,
                values.at(stuck),
                Samples::of(used, stride).of_all_sensors(),
                &mut out,
            );
            *values.of(turn) = at;
            let mut norm = 0.0;
            if done.is_ok() {
                column.fill(0.0);
                let changed = self.residual_of(k, &out);
                for i in (0..changed.len()).filter(|i| i % rows < followed(&out)) {
                    let slope = (residual[i] - changed[i]) / step;
                    column[i] = if slope.is_finite() { slope } else { 0.0 };
                    norm += column[i] * column[i];
                }
            }
            let compared = (followed(&out) * sensors).max(1);
            let response = (norm / compared as f64).sqrt() * step.abs();
            if response <= 0.0 || !response.is_finite() {
                break;
            }
            // The response should be a fraction of the noise, in the linear range.
            let (size, most) = self.size_of(k, turn);
            *size = (*size * (target / response).clamp(0.02, 20.0)).min(most);
            if response < TOO_STRONG * target {
                break;
            }
        }
        self.buffer = out;
    }

    /// Where a quantity stands, and the step to take.
    fn step_of(&mut self, k: usize, values: &mut Values, turn: Turn) -> (f64, f64) {
        let at = *values.of(turn);
        let size = self.side * *self.size_of(k, turn).0;
        let run = self.data.segments[k].run;
        let step = match turn {
            Turn::State(_) => size,
            Turn::Shared(c) => towards_inside(&self.hypothesis.shared[c], at, size),
            Turn::PerRun(c) => towards_inside(&self.hypothesis.per_run[run][c], at, size),
        };
        (at, step)
    }

    /// The size of a step, and the largest sensible one.
    fn size_of(&mut self, k: usize, turn: Turn) -> (&mut f64, f64) {
        let run = self.data.segments[k].run;
        let steps = &mut self.steps[k];
        match turn {
            Turn::State(i) => (&mut steps.states[i], f64::INFINITY),
            Turn::Shared(c) => (
                &mut steps.shared[c],
                LARGEST_STEP * self.hypothesis.shared[c].step,
            ),
            Turn::PerRun(c) => (
                &mut steps.per_run[c],
                LARGEST_STEP * self.hypothesis.per_run[run][c].step,
            ),
        }
    }
}

/// Derivatives below this share of the largest by a modal state are the integrator's errors: its relative tolerance.
const LEAST_SHARE: f64 = 1e-9;

/// Sets derivatives by components of the modal state to zero that are errors of the integrator beside the others, each by its scale: in
/// stick the velocity of an inner oscillation moves nothing that is seen, and what rounding leaves of its column would send it a
/// thousand million m/s away in one step.
fn forget_unseen(states: &mut DMatrix<f64>, list: &[usize], scales: &[f64]) {
    let of = |column: usize| scales.get(list[column]).copied();
    let sizes: Vec<Option<f64>> = (0..list.len())
        .map(|c| Some(states.column(c).norm() * of(c)?))
        .collect();
    let largest = sizes.iter().flatten().copied().fold(0.0, f64::max);
    for (c, size) in sizes.iter().enumerate() {
        if size.is_some_and(|size| size < LEAST_SHARE * largest) {
            states.column_mut(c).fill(0.0);
        }
    }
}

/// Response of a difference quotient's step in units of the noise, ...
const RESPONSE: f64 = 0.02;
/// ... at least this in m or m/s, above the integrator's errors; ...
const LEAST_RESPONSE: f64 = 1e-9;
/// ... a response this many times stronger may lie beyond a transition, ...
const TOO_STRONG: f64 = 20.0;
/// ... and is tried again so often at most.
const ATTEMPTS: usize = 3;
/// Largest step in units of the first one.
const LARGEST_STEP: f64 = 10.0;

/// Values of all that can be turned in a segment.
struct Values {
    state: Vec<f64>,
    shared: Vec<f64>,
    per_run: Vec<f64>,
}

impl Values {
    fn at(&self, stuck: bool) -> SegmentValues<'_> {
        SegmentValues {
            shared: &self.shared,
            per_run: &self.per_run,
            state: &self.state,
            stuck,
        }
    }

    fn of(&mut self, turn: Turn) -> &mut f64 {
        match turn {
            Turn::State(i) => &mut self.state[i],
            Turn::Shared(i) => &mut self.shared[i],
            Turn::PerRun(i) => &mut self.per_run[i],
        }
    }
}

/// A step that stays within the parameter's bounds.
fn towards_inside(parameter: &Parameter, at: f64, step: f64) -> f64 {
    if parameter.clamp(at + step) == at + step {
        step
    } else {
        -step
    }
}

impl Fitter<'_, '_> {
    /// Broyden's rank-one update after a step (Broyden 1965, method 1), with each direction measured by the
    /// response that it has: `J += (dy - J dx) (D dx)' D / |D dx|^2`, D the norms of the columns of J. Segments that
    /// left their basin or ran away wait for the next Jacobian.
    pub(crate) fn update(&self, linear: &mut [Option<Linear>], old: &Place, new: &Place) {
        let (h, segments) = (self.hypothesis, self.data.segments);
        for k in 0..linear.len() {
            let is_whole = |place: &Place| {
                let residual = place.residual[k].as_ref();
                let sensors = 1 + segments[k].further.len();
                residual.is_some_and(|r| self.predicted(k, r) == r.len() / sensors)
            };
            let lost = new.sums[k] > LOST * old.sums[k] || !is_whole(old) || !is_whole(new);
            let (Some(l), Some(after), false) = (&mut linear[k], &new.residual[k], lost) else {
                linear[k] = None;
                continue;
            };
            let run = segments[k].run;
            let difference = |a: &[f64], b: &[f64], i: usize| b[i] - a[i];
            let states = DVector::from_iterator(
                l.states.ncols(),
                directions(h, old.point.stuck[k])
                    .into_iter()
                    .map(|i| difference(&old.point.states[k], &new.point.states[k], i)),
            );
            let parameters =
                DVector::from_iterator(
                    l.parameters.ncols(),
                    (0..h.shared.len())
                        .map(|i| difference(&old.point.shared, &new.point.shared, i))
                        .chain((0..h.per_run[run].len()).map(|i| {
                            difference(&old.point.per_run[run], &new.point.per_run[run], i)
                        })),
                );
            let mut error = DVector::from_iterator(
                after.len(),
                l.residual
                    .iter()
                    .zip(after)
                    .map(|(before, after)| before - after),
            );
            error -= &l.states * &states + &l.parameters * &parameters;
            let weights = |matrix: &DMatrix<f64>, step: &DVector<f64>| -> Vec<f64> {
                (0..matrix.ncols())
                    .map(|i| matrix.column(i).norm_squared() * step[i])
                    .collect()
            };
            let (by_state, by_parameter) = (
                weights(&l.states, &states),
                weights(&l.parameters, &parameters),
            );
            let length: f64 = by_state
                .iter()
                .zip(&states)
                .map(|(w, d)| w * d)
                .sum::<f64>()
                + by_parameter
                    .iter()
                    .zip(&parameters)
                    .map(|(w, d)| w * d)
                    .sum::<f64>();
            if length > 0.0 {
                for (i, w) in by_state.iter().enumerate() {
                    l.states.column_mut(i).axpy(w / length, &error, 1.0);
                }
                for (i, w) in by_parameter.iter().enumerate() {
                    l.parameters.column_mut(i).axpy(w / length, &error, 1.0);
                }
            }
            l.residual.clone_from(after);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounding_leaves_of_a_modal_state_is_forgotten_and_nothing_else() {
        // Displacement, velocity and effect's state: rounding of the velocity, 3e-12 at a frequency of 100 rad/s, is 1.5e-10 of the rest.
        let mut states = DMatrix::from_row_slice(1, 4, &[2.0, 3e-12, 1e-3, 1e-15]);
        forget_unseen(&mut states, &[0, 1, 3, 4], &[1.0, 100.0, 1.0, 300.0]);
        assert_eq!(states.as_slice(), &[2.0, 0.0, 1e-3, 1e-15]);
    }
}
