//! What is projected out of the response to a line: what a segment's start state explains, and the values of a profile along the belt.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fitter::directions;
use crate::diagnose::estimation::scaled_matrix::scaled_inverse;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::periodic::Argument;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::{Samples, SegmentValues, Simulator};
use nalgebra::DMatrix;

/// Periods of a line within the part of a segment in which it is looked for. Of so many, what the start state explains takes
/// a few percent, and a segment of 20 to 40 ms holds no more of the fastest line that an effect of the catalogue may have.
pub(crate) const MOST_PERIODS: f64 = 16.0;

/// Distance in m that belt and tip have moved against each other after the first `used` samples of a segment.
pub(crate) fn travel_after(segment: &Segment, used: usize) -> f64 {
    let last = segment.time.len() - 1;
    if used > last {
        return segment.travel_end;
    }
    let share = (used - 1) as f64 / last as f64;
    segment.travel + share * (segment.travel_end - segment.travel)
}

/// Time in s or distance in m that the first `used` samples of a segment pass through.
pub(crate) fn span(segment: &Segment, argument: Argument, used: usize) -> f64 {
    match argument {
        Argument::Time => segment.time[used - 1] - segment.time[0],
        Argument::Travel => (travel_after(segment, used) - segment.travel).abs(),
    }
}

/// The first part of every segment in which lines are looked for.
pub(crate) struct Parts<'a> {
    segments: &'a [Segment],
    argument: Argument,
    stride: usize,
    /// What is projected out, in each segment as a whole.
    changes: &'a [Option<Changes>],
    /// Longest part in s or m.
    pub widest: f64,
    /// Samples of each segment in its part.
    pub used: Vec<usize>,
    /// Orthonormal basis of that in each part, with a row for each belief.
    pub bases: Vec<Option<DMatrix<f64>>>,
}

impl<'a> Parts<'a> {
    /// All of every segment.
    pub fn of(
        segments: &'a [Segment],
        argument: Argument,
        widest: f64,
        stride: usize,
        changes: &'a [Option<Changes>],
    ) -> Self {
        let mut parts = Self {
            segments,
            argument,
            stride,
            changes,
            widest,
            used: segments.iter().map(|s| s.time.len()).collect(),
            bases: Vec::new(),
        };
        parts.project();
        parts
    }

    /// Halves the parts until they hold no more than [`MOST_PERIODS`] of frequency or wave number `wave`; whether that was
    /// needed.
    pub fn shorten_for(&mut self, wave: f64) -> bool {
        let before = self.widest;
        while self.widest * wave > MOST_PERIODS {
            self.widest *= 0.5;
        }
        if self.widest == before {
            return false;
        }
        for (segment, used) in self.segments.iter().zip(&mut self.used) {
            let whole = span(segment, self.argument, segment.time.len());
            let wanted = (self.widest / whole).min(1.0) * (segment.time.len() - 1) as f64;
            *used = (wanted as usize + 1).max(2 * self.stride);
            *used = (*used).min(segment.time.len());
        }
        self.project();
        true
    }

    fn project(&mut self) {
        let of_part = |(changes, used): (&Option<Changes>, &usize)| {
            let rows = Samples::of(*used, self.stride).count;
            let part = changes.as_ref()?.of_first(rows);
            let gram = part.tr_mul(&part);
            scaled_inverse(&gram, 1e-9)?;
            Some(part.qr().q())
        };
        self.bases = self.changes.iter().zip(&self.used).map(of_part).collect();
    }

    /// What is believed of the values along the belt in segment `k`.
    pub fn beliefs(&self, k: usize) -> &[Belief] {
        self.changes[k].as_ref().map_or(&[], |c| &c.beliefs)
    }
}

/// What is believed of a value along the belt, as a row of the residual: what the row leaves, in m, and what it weighs, m per unit.
pub(crate) struct Belief {
    pub residual: f64,
    weight: f64,
}

/// What is projected out of a segment.
pub(crate) struct Changes {
    /// How the prediction changes with start state and values along the belt: samples x (directions + values).
    matrix: DMatrix<f64>,
    /// Of the values along the belt.
    beliefs: Vec<Belief>,
}

impl Changes {
    /// What is projected out of segment `k`, whose prediction is `y` at `point`.
    pub fn of(
        simulator: &mut dyn Simulator,
        h: &Hypothesis,
        data: &Observations,
        point: &Point,
        (k, y): (usize, &[f64]),
        stride: usize,
    ) -> Option<Self> {
        let segment = &data.segments[k];
        let own = &point.per_run[segment.run];
        let mut column = |state: &[f64], own: &[f64], step: f64| -> Option<Vec<f64>> {
            let mut out = Vec::new();
            let values = SegmentValues {
                state,
                per_run: own,
                ..point.values(k, segment.run)
            };
            let samples = Samples::of(segment.time.len(), stride);
            let done = simulator.predict(segment, values, samples, &mut out);
            done.ok().filter(|done| *done)?;
            Some(out.iter().zip(y).map(|(b, a)| (b - a) / step).collect())
        };
        let mut columns = Vec::new();
        for i in directions(h, point.stuck[k]) {
            let mut state = point.states[k].clone();
            let step = if i % 2 == 0 { 1e-8 } else { 1e-5 };
            state[i] += step;
            columns.push(column(&state, own, step)?);
        }
        let mut beliefs = Vec::new();
        let (from, to) = (
            segment.travel.min(segment.travel_end),
            segment.travel.max(segment.travel_end),
        );
        for (i, parameter) in h.per_run[segment.run].iter().enumerate() {
            if !parameter
                .support
                .is_some_and(|(low, high)| low < to && from < high)
            {
                continue;
            }
            let mut moved = own.clone();
            // Linear too, beside values that move the prediction by hundreds of times the noise.
            let step = 0.01 * parameter.step;
            moved[i] += step;
            columns.push(column(&point.states[k], &moved, step)?);
            let weight = data.noise[segment.run] / parameter.prior_std;
            beliefs.push(Belief {
                residual: weight * (parameter.prior - own[i]),
                weight,
            });
        }
        let matrix = DMatrix::from_fn(y.len(), columns.len(), |row, c| columns[c][row]);
        Some(Self { matrix, beliefs })
    }

    /// The first rows, with one for each belief.
    fn of_first(&self, rows: usize) -> DMatrix<f64> {
        let (columns, beliefs) = (self.matrix.ncols(), self.beliefs.len());
        let mut part = self.matrix.rows(0, rows).into_owned();
        part = part.insert_rows(rows, beliefs, 0.0);
        for (i, belief) in self.beliefs.iter().enumerate() {
            part[(rows + i, columns - beliefs + i)] = belief.weight;
        }
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn val_what_is_projected_out_is_what_beliefs_leave_to_the_values() {
        // Source: least squares of start state and value with the belief as a penalty, by their normal equations.
        let matrix =
            DMatrix::from_row_slice(5, 2, &[1.0, 0.0, 1.0, 0.5, 1.0, 1.5, 1.0, 0.2, 9.0, 9.0]);
        let (weight, believed) = (0.7, -0.4);
        let changes = Changes {
            matrix: matrix.clone(),
            beliefs: vec![Belief {
                residual: weight * believed,
                weight,
            }],
        };
        let residual = [0.3, -1.0, 2.0, 0.6];
        let part = changes.of_first(4);
        assert_eq!(part.shape(), (5, 2));
        let basis = part.qr().q();
        let r = DVector::from_row_slice(&[0.3, -1.0, 2.0, 0.6, weight * believed]);
        let left = (&r - &basis * basis.tr_mul(&r)).norm_squared();

        let a = matrix.rows(0, 4).into_owned();
        let y = DVector::from_row_slice(&residual);
        let mut normal = a.tr_mul(&a);
        normal[(1, 1)] += weight * weight;
        let mut right = a.tr_mul(&y);
        right[1] += weight * weight * believed;
        let x = normal.lu().solve(&right).expect("regular");
        let penalty = (weight * (believed - x[1])).powi(2);
        let expected = (y - a * &x).norm_squared() + penalty;
        assert!((left - expected).abs() < 1e-12, "{left} {expected}");
    }
}
