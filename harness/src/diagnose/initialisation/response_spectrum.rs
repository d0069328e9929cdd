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
//! [`MOST_PERIODS`](super::projected_out::MOST_PERIODS) periods of each segment, so that a grid costs as many motions of a segment however long it is.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::initialisation::projected_out::{Changes, Parts, span, travel_after};
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::model::periodic::{Argument, Line, argument, periodic};
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::{Samples, Simulator};
use crate::fmu::effect_card::{EffectCard, Role};
use nalgebra::DVector;
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

struct SegmentNormal {
    run: usize,
    middle: f64,
    matrix: [[f64; 2]; 2],
    right: [f64; 2],
}

/// A periodic effect around a fitted point, and what each segment is there without it: its lines.
pub(crate) struct ResponseSpectrum<'a> {
    simulator: &'a mut dyn Simulator,
    h: &'a Hypothesis,
    data: &'a Observations<'a>,
    /// The point, the effect so weak that responses are linear.
    probe: Point,
    stride: usize,
    argument: Argument,
    /// Places of strength and of frequency or wavelength among the shared parameters.
    strength: usize,
    shape: usize,
    /// Least and largest frequency or wave number per unit of the argument.
    bounds: (f64, f64),
    /// Place of each run's phase among its parameters.
    phases: Vec<usize>,
    /// Prediction and residual of each segment without the effect.
    base: Vec<Option<(Vec<f64>, Vec<f64>)>>,
    /// What is projected out of each.
    changes: Vec<Option<Changes>>,
}

impl<'a> ResponseSpectrum<'a> {
    /// The spectrum around `point`; `None` of an effect that does not repeat.
    pub fn new(
        simulator: &'a mut dyn Simulator,
        h: &'a Hypothesis,
        effect: &EffectCard,
        data: &'a Observations<'a>,
        point: &Point,
        stride: usize,
    ) -> Option<Self> {
        let ((amplitude, shape), argument) = (periodic(effect)?, argument(effect)?);
        let name = |i: usize| format!("{}.{}", effect.id, effect.parameters[i].name);
        let strength = h.shared_index(&name(amplitude))?;
        let of_shape = h.shared_index(&name(shape))?;
        let phase = effect.find_role(Role::Phase).map(name);
        let place = |own: &Vec<Parameter>| own.iter().position(|k| Some(&k.name) == phase.as_ref());
        let phases = h.per_run.iter().map(place).collect::<Option<Vec<_>>>()?;
        let p = &effect.parameters[shape];
        let bounds = match argument {
            Argument::Time => (p.min, p.max),
            Argument::Travel => (p.max.recip(), p.min.recip()),
        };
        let mut without = point.clone();
        without.shared[strength] = 0.0;
        let segments = 0..data.segments.len();
        let base: Vec<Option<(Vec<f64>, Vec<f64>)>> = segments
            .clone()
            .map(|k| baseline(simulator, data, &without, k, stride))
            .collect();
        let changes = segments
            .map(|k| {
                let (y, _) = base[k].as_ref()?;
                Changes::of(simulator, h, data, &without, (k, y), stride)
            })
            .collect();
        let mut probe = without;
        probe.shared[strength] = 0.001 * effect.parameters[amplitude].typical;
        Some(Self {
            simulator,
            h,
            data,
            probe,
            stride,
            argument,
            strength,
            shape: of_shape,
            bounds,
            phases,
            base,
            changes,
        })
    }

    /// Frequencies or wave numbers that the campaign can tell from each other, in five steps.
    fn fine(&self) -> f64 {
        0.2 / range(self.data.segments, self.argument)
    }

    /// The strongest lines of all.
    pub fn strongest(&mut self, most: usize) -> Vec<Line> {
        let (low, high) = self.bounds;
        let whole = range(self.data.segments, self.argument);
        self.lines((low.max(0.3 / whole), high), most, true)
    }

    /// The strongest line near a frequency or wavelength.
    pub fn near(&mut self, value: f64) -> Option<Line> {
        let wave = self.wave(value);
        let reach = NEIGHBOURS * self.fine();
        let found = self.lines((wave - reach, wave + reach), 1, false);
        found.into_iter().next()
    }

    /// Frequency or wave number of a frequency or wavelength, and the other way round.
    fn wave(&self, value: f64) -> f64 {
        match self.argument {
            Argument::Time => value,
            Argument::Travel => value.recip(),
        }
    }

    /// The strongest lines between two frequencies or wave numbers; with `shortens`, fast ones in the first part of each segment.
    fn lines(&mut self, (low, high): (f64, f64), most: usize, shortens: bool) -> Vec<Line> {
        let (data, argument) = (self.data, self.argument);
        let spans = data.segments.iter();
        let spans = spans.map(|s| span(s, argument, s.time.len()));
        let widest = spans.fold(0.0, f64::max);
        let changes = std::mem::take(&mut self.changes);
        let mut parts = Parts::of(data.segments, argument, widest, self.stride, &changes);
        let fine = self.fine();
        let mut found: Vec<Line> = Vec::new();
        let mut coarse = 0.5 / widest;
        let mut centre = low + 0.5 * coarse;
        while centre - 0.5 * coarse < high {
            if shortens && parts.shorten_for(centre) {
                let from = centre - 0.5 * coarse;
                coarse = 0.5 / parts.widest;
                centre = from + 0.5 * coarse;
            }
            let normals = self.normals(centre, &parts);
            let mut shift = -0.5 * coarse;
            while shift < 0.5 * coarse {
                let at = centre + shift;
                if at >= low && at <= high {
                    let (gain, amplitude, phase) = spectrum(&normals, shift, self.h.per_run.len());
                    let line = Line {
                        value: self.wave(at),
                        amplitude,
                        phase,
                        gain,
                    };
                    let is_length = argument == Argument::Travel;
                    insert(&mut found, line, most, fine * 3.0, is_length);
                }
                shift += fine;
            }
            centre += coarse;
        }
        self.changes = changes;
        found
    }

    /// Normal equations of each segment's part for strengths in and out of phase, at a frequency or wave number.
    fn normals(&mut self, centre: f64, parts: &Parts) -> Vec<SegmentNormal> {
        let value = self.wave(centre);
        self.probe.shared[self.shape] = self.h.shared[self.shape].position(value);
        let segments = 0..self.data.segments.len();
        segments.filter_map(|k| self.normal(k, parts)).collect()
    }

    fn normal(&mut self, k: usize, parts: &Parts) -> Option<SegmentNormal> {
        let (y, residual) = self.base[k].as_ref()?;
        let remove = parts.bases[k].as_ref()?;
        let segment = &self.data.segments[k];
        let used = parts.used[k];
        let samples = Samples::of(used, self.stride);
        let (y, residual) = (&y[..samples.count], &residual[..samples.count]);
        let beliefs = parts.beliefs(k);
        let strength = self.probe.shared[self.strength];
        let mut columns = Vec::new();
        for angle in [0.0, -0.25 * TAU] {
            self.probe.per_run[segment.run][self.phases[segment.run]] = angle;
            let mut out = Vec::new();
            let values = self.probe.values(k, segment.run);
            let done = self.simulator.predict(segment, values, samples, &mut out);
            done.ok().filter(|done| *done)?;
            let change = out.iter().zip(y).map(|(b, a)| (b - a) / strength);
            let believed = beliefs.iter().map(|_| 0.0);
            columns.push(DVector::from_iterator(
                y.len() + beliefs.len(),
                change.chain(believed),
            ));
        }
        let all = columns.iter();
        let clean: Vec<DVector<f64>> = all.map(|c| c - remove * (remove.tr_mul(c))).collect();
        let believed = beliefs.iter().map(|b| b.residual);
        let r = DVector::from_iterator(
            residual.len() + beliefs.len(),
            residual.iter().copied().chain(believed),
        );
        let r = &r - remove * remove.tr_mul(&r);
        let noise = self.data.noise[segment.run];
        let weight = 1.0 / (noise * noise).max(r.norm_squared() / r.len() as f64);
        let middle = match self.argument {
            Argument::Time => 0.5 * (segment.time[0] + segment.time[used - 1]),
            Argument::Travel => 0.5 * (segment.travel + travel_after(segment, used)),
        };
        Some(SegmentNormal {
            run: segment.run,
            middle,
            matrix: std::array::from_fn(|i| {
                std::array::from_fn(|j| weight * clean[i].dot(&clean[j]))
            }),
            right: std::array::from_fn(|i| weight * clean[i].dot(&r)),
        })
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
    k: usize,
    stride: usize,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let segment = &data.segments[k];
    let mut out = Vec::new();
    let samples = Samples::of(segment.time.len(), stride);
    let done = simulator.predict(segment, point.values(k, segment.run), samples, &mut out);
    done.ok().filter(|done| *done)?;
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
