//! Where to look for an effect that repeats in time or along the belt: its frequency or wavelength, and
//! a phase of its own in each run, by a spectrum of the model's residuals.
//!
//! Around the calibrated model the response to a weak effect is linear in `a cos p` and `a sin p`. Within a
//! segment a small shift of frequency is only a shift of phase, so a coarse grid of simulations gives a
//! fine spectrum: per run r, `gain(f) = b_r' M_r^-1 b_r / 2` with the segments' normal equations turned by
//! their phases (a generalised Lomb-Scargle periodogram through the model).
//!
//! What the start state of a segment explains, and the values of a profile along the belt within it, is projected out; each of these
//! values with what is believed of it, as a row more: what they have taken of the line is missed there.
//!
//! A fine grid of a long segment would cost the square of its length. Fast lines are therefore looked for in the first
//! [`MOST_PERIODS`] periods of each segment, so that a grid costs as many motions of a segment however long it is.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fitter::directions;
use crate::diagnose::estimation::scaled_matrix::scaled_inverse;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::model::periodic::{Argument, Line, argument, periodic};
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::{Samples, SegmentValues, Simulator};
use crate::fmu::effect_card::{EffectCard, Role};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Number of frequencies or wave numbers within the bounds of a periodic effect that a campaign can tell apart: their range
/// times the length of time or of belt seen.
pub fn independent_lines(effect: &EffectCard, segments: &[Segment]) -> f64 {
    let (Some((_, shape)), Some(argument)) = (periodic(effect), argument(effect)) else {
        return 1.0;
    };
    let p = &effect.parameters[shape];
    let width = match argument {
        Argument::Time => p.max - p.min,
        Argument::Travel => p.min.recip() - p.max.recip(),
    };
    (width * range(segments, argument)).max(1.0)
}

/// Steps to each side that count as near a line.
const NEIGHBOURS: f64 = 5.0;

/// Periods of a line within the part of a segment in which it is looked for. Of so many, what the start state explains takes
/// a few percent, and a segment of 20 to 40 ms holds no more of the fastest line that an effect of the catalogue may have.
const MOST_PERIODS: f64 = 16.0;

struct SegmentNormal {
    run: usize,
    middle: f64,
    matrix: [[f64; 2]; 2],
    right: [f64; 2],
}

/// The strongest lines of a periodic effect around a fitted point, all or those `near` a frequency or wavelength; empty for
/// other effects.
#[allow(clippy::too_many_arguments)]
pub fn lines(
    simulator: &mut dyn Simulator,
    h: &Hypothesis,
    effect: &EffectCard,
    data: &Observations,
    point: &Point,
    stride: usize,
    most: usize,
    near: Option<f64>,
) -> Vec<Line> {
    let (Some((amplitude, shape)), Some(argument)) = (periodic(effect), argument(effect)) else {
        return Vec::new();
    };
    let index = |i: usize| h.shared_index(&format!("{}.{}", effect.id, effect.parameters[i].name));
    let (Some(a), Some(f)) = (index(amplitude), index(shape)) else {
        return Vec::new();
    };
    let phase = effect
        .find_role(Role::Phase)
        .map(|i| format!("{}.{}", effect.id, effect.parameters[i].name));
    let place = |own: &Vec<Parameter>| own.iter().position(|k| Some(&k.name) == phase.as_ref());
    let Some(phases) = h.per_run.iter().map(place).collect::<Option<Vec<_>>>() else {
        return Vec::new();
    };
    let widest = data
        .segments
        .iter()
        .map(|s| span(s, argument, s.time.len()))
        .fold(0.0, f64::max);
    let whole = range(data.segments, argument);
    // As frequency or wave number per unit of the argument.
    let bounds = &effect.parameters[shape];
    let (low, high) = if argument == Argument::Time {
        (bounds.min, bounds.max)
    } else {
        (bounds.max.recip(), bounds.min.recip())
    };
    let fine = 0.2 / whole;
    let (low, high) = match near {
        None => (low.max(0.3 / whole), high),
        Some(value) => {
            let wave = if argument == Argument::Time {
                value
            } else {
                value.recip()
            };
            (wave - NEIGHBOURS * fine, wave + NEIGHBOURS * fine)
        }
    };
    let mut probe = point.clone();
    // Weak enough to be linear.
    probe.shared[a] = 0.001 * effect.parameters[amplitude].typical;
    let strength = probe.shared[a];
    let base: Vec<Option<(Vec<f64>, Vec<f64>)>> = (0..data.segments.len())
        .map(|k| baseline(simulator, data, point, a, k, stride))
        .collect();
    let changes: Vec<Option<Changes>> = (0..data.segments.len())
        .map(|k| {
            let (y, _) = base[k].as_ref()?;
            changes(simulator, h, data, point, a, k, stride, y)
        })
        .collect();
    let mut found: Vec<Line> = Vec::new();
    let mut parts = Parts::of(data.segments, argument, widest, stride, &changes);
    let mut coarse = 0.5 / widest;
    let mut centre = low + 0.5 * coarse;
    while centre - 0.5 * coarse < high {
        if near.is_none() && parts.shorten_for(centre) {
            let from = centre - 0.5 * coarse;
            coarse = 0.5 / parts.widest;
            centre = from + 0.5 * coarse;
        }
        let value = if argument == Argument::Time {
            centre
        } else {
            centre.recip()
        };
        probe.shared[f] = h.shared[f].position(value);
        let mut normals = Vec::new();
        for k in 0..data.segments.len() {
            let (Some((y, residual)), Some(remove)) = (&base[k], &parts.bases[k]) else {
                continue;
            };
            let segment = &data.segments[k];
            let used = parts.used[k];
            let samples = Samples::of(used, stride);
            let (y, residual) = (&y[..samples.count], &residual[..samples.count]);
            let beliefs = changes[k].as_ref().map_or(&[][..], |c| &c.beliefs);
            let mut columns = Vec::new();
            for angle in [0.0, -0.25 * TAU] {
                probe.per_run[segment.run][phases[segment.run]] = angle;
                let mut out = Vec::new();
                if simulator
                    .predict(segment, probe.values(k, segment.run), samples, &mut out)
                    .is_ok_and(|done| done)
                {
                    let change = out.iter().zip(y).map(|(b, a)| (b - a) / strength);
                    let believed = beliefs.iter().map(|_| 0.0);
                    columns.push(DVector::from_iterator(
                        y.len() + beliefs.len(),
                        change.chain(believed),
                    ));
                }
            }
            if columns.len() < 2 {
                continue;
            }
            let clean: Vec<DVector<f64>> = columns
                .iter()
                .map(|c| c - remove * (remove.tr_mul(c)))
                .collect();
            let believed = beliefs.iter().map(|b| b.residual);
            let r = DVector::from_iterator(
                residual.len() + beliefs.len(),
                residual.iter().copied().chain(believed),
            );
            let r = &r - remove * remove.tr_mul(&r);
            let noise = data.noise[segment.run];
            let weight = 1.0 / (noise * noise).max(r.norm_squared() / r.len() as f64);
            let middle = match argument {
                Argument::Time => 0.5 * (segment.time[0] + segment.time[used - 1]),
                Argument::Travel => 0.5 * (segment.travel + travel_after(segment, used)),
            };
            normals.push(SegmentNormal {
                run: segment.run,
                middle,
                matrix: std::array::from_fn(|i| {
                    std::array::from_fn(|j| weight * clean[i].dot(&clean[j]))
                }),
                right: std::array::from_fn(|i| weight * clean[i].dot(&r)),
            });
        }
        let mut shift = -0.5 * coarse;
        while shift < 0.5 * coarse {
            let at = centre + shift;
            if at >= low && at <= high {
                let (gain, amplitude, phase) = spectrum(&normals, shift, h.per_run.len());
                let value = if argument == Argument::Time {
                    at
                } else {
                    at.recip()
                };
                insert(
                    &mut found,
                    Line {
                        value,
                        amplitude,
                        phase,
                        gain,
                    },
                    most,
                    fine * 3.0,
                    argument == Argument::Travel,
                );
            }
            shift += fine;
        }
        centre += coarse;
    }
    found
}

/// Distance in m that belt and tip have moved against each other after the first `used` samples of a segment.
fn travel_after(segment: &Segment, used: usize) -> f64 {
    let last = segment.time.len() - 1;
    if used > last {
        return segment.travel_end;
    }
    let share = (used - 1) as f64 / last as f64;
    segment.travel + share * (segment.travel_end - segment.travel)
}

/// Time in s or distance in m that the first `used` samples of a segment pass through.
fn span(segment: &Segment, argument: Argument, used: usize) -> f64 {
    match argument {
        Argument::Time => segment.time[used - 1] - segment.time[0],
        Argument::Travel => (travel_after(segment, used) - segment.travel).abs(),
    }
}

/// The first part of every segment in which lines are looked for.
struct Parts<'a> {
    segments: &'a [Segment],
    argument: Argument,
    stride: usize,
    /// What is projected out, in each segment as a whole.
    changes: &'a [Option<Changes>],
    /// Longest part in s or m.
    widest: f64,
    /// Samples of each segment in its part.
    used: Vec<usize>,
    /// Orthonormal basis of that in each part, with a row for each belief.
    bases: Vec<Option<DMatrix<f64>>>,
}

impl<'a> Parts<'a> {
    /// All of every segment.
    fn of(
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
    fn shorten_for(&mut self, wave: f64) -> bool {
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
}

fn range(segments: &[Segment], argument: Argument) -> f64 {
    let mut widest: f64 = 0.0;
    let runs = segments.iter().map(|s| s.run).max().map_or(0, |r| r + 1);
    for run in 0..runs {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for s in segments.iter().filter(|s| s.run == run) {
            let (a, b) = if argument == Argument::Time {
                (s.time[0], s.time[s.time.len() - 1])
            } else {
                (s.travel, s.travel_end)
            };
            low = low.min(a.min(b));
            high = high.max(a.max(b));
        }
        widest = widest.max(high - low);
    }
    widest
}

/// Prediction and residual without the effect.
fn baseline(
    simulator: &mut dyn Simulator,
    data: &Observations,
    point: &Point,
    a: usize,
    k: usize,
    stride: usize,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let segment = &data.segments[k];
    let mut shared = point.shared.clone();
    shared[a] = 0.0;
    let mut out = Vec::new();
    simulator
        .predict(
            segment,
            SegmentValues {
                shared: &shared,
                ..point.values(k, segment.run)
            },
            Samples::of(segment.time.len(), stride),
            &mut out,
        )
        .ok()
        .filter(|done| *done)?;
    let residual = out
        .iter()
        .enumerate()
        .map(|(i, y)| {
            if segment.trusted[i * stride] {
                segment.measured[i * stride] - y
            } else {
                0.0
            }
        })
        .collect();
    Some((out, residual))
}

/// What is believed of a value along the belt, as a row of the residual: what the row leaves, in m, and what it weighs, m per unit.
struct Belief {
    residual: f64,
    weight: f64,
}

/// What is projected out of a segment.
struct Changes {
    /// How the prediction changes with start state and values along the belt: samples x (directions + values).
    matrix: DMatrix<f64>,
    /// Of the values along the belt.
    beliefs: Vec<Belief>,
}

impl Changes {
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

/// What is projected out of segment `k`, whose prediction is `y`.
#[allow(clippy::too_many_arguments)]
fn changes(
    simulator: &mut dyn Simulator,
    h: &Hypothesis,
    data: &Observations,
    point: &Point,
    a: usize,
    k: usize,
    stride: usize,
    y: &[f64],
) -> Option<Changes> {
    let segment = &data.segments[k];
    let mut shared = point.shared.clone();
    shared[a] = 0.0;
    let own = &point.per_run[segment.run];
    let mut column = |state: &[f64], own: &[f64], step: f64| -> Option<Vec<f64>> {
        let mut out = Vec::new();
        let values = SegmentValues {
            shared: &shared,
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
    Some(Changes { matrix, beliefs })
}

/// Gain, amplitude and phases at a frequency shifted by `shift` from the grid's.
fn spectrum(normals: &[SegmentNormal], shift: f64, runs: usize) -> (f64, f64, Vec<f64>) {
    let mut matrix = vec![[[0.0; 2]; 2]; runs];
    let mut right = vec![[0.0; 2]; runs];
    for n in normals {
        // cos(2 pi (f + d) t + p) = cos(2 pi f t + (2 pi d t + p)): turn the coefficients.
        let (s, c) = (TAU * shift * n.middle).sin_cos();
        let turn = [[c, s], [-s, c]];
        for i in 0..2 {
            for j in 0..2 {
                for (k, row) in n.matrix.iter().enumerate() {
                    for (l, m) in row.iter().enumerate() {
                        matrix[n.run][i][j] += turn[k][i] * m * turn[l][j];
                    }
                }
            }
            right[n.run][i] += turn[0][i] * n.right[0] + turn[1][i] * n.right[1];
        }
    }
    let (mut gain, mut weight, mut mean) = (0.0, 0.0, 0.0);
    let mut phase = vec![0.0; runs];
    for r in 0..runs {
        let m = &matrix[r];
        let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        if determinant <= 1e-12 * m[0][0] * m[1][1] {
            continue;
        }
        let x = (m[1][1] * right[r][0] - m[0][1] * right[r][1]) / determinant;
        let y = (m[0][0] * right[r][1] - m[1][0] * right[r][0]) / determinant;
        gain += 0.5 * (x * right[r][0] + y * right[r][1]);
        let strength = m[0][0] + m[1][1];
        weight += strength;
        mean += strength * x.hypot(y);
        // a cos(u + p) = (a cos p) cos u + (a sin p) cos(u + pi/2), and the second column has phase -pi/2.
        phase[r] = (-y).atan2(x);
    }
    (gain, if weight > 0.0 { mean / weight } else { 0.0 }, phase)
}

/// Keeps the strongest lines, at least `apart` from one another.
fn insert(found: &mut Vec<Line>, line: Line, most: usize, apart: f64, is_length: bool) {
    let wave = |v: f64| if is_length { v.recip() } else { v };
    if let Some(near) = found
        .iter_mut()
        .find(|l| (wave(l.value) - wave(line.value)).abs() < apart)
    {
        if line.gain > near.gain {
            *near = line;
        }
    } else {
        found.push(line);
    }
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    found.truncate(most);
}

#[cfg(test)]
mod tests {
    use super::*;

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
