//! What drove a run, where it was measured along with the displacement: belt velocity, normal force, a force on the tip,
//! acceleration of the clamp.

use std::ops::Range;

use serde::Deserialize;

use super::band_limited::{HALF_WIDTH, refine};
use super::{Run, Sampling};

/// What an input does between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// The signal of least bandwidth through the samples, for signals that were filtered before they were sampled.
    BandLimited,
    /// A straight line from sample to sample.
    Linear,
    /// The last sample, as a digital output holds it.
    Held,
}

impl Interpolation {
    /// Its name in a sentence.
    pub fn words(self) -> &'static str {
        match self {
            Self::BandLimited => "band-limited",
            Self::Linear => "linear",
            Self::Held => "held",
        }
    }

    /// What is taken where nothing is stated: band-limited where the record is even, else linear.
    pub fn usual(sampling: &Sampling) -> Self {
        if is_even(sampling) {
            Self::BandLimited
        } else {
            Self::Linear
        }
    }
}

/// Scatter of the intervals, as a share, up to which sampling counts as even.
const EVEN: f64 = 0.01;
/// Points of a band-limited input for each sample, where no fewer are known to do; between them it is a straight line, which leaves
/// `(pi f h/8)^2 / 3` of a sine of frequency f (Hz) sampled each h (s): 1.3 % at half the sample rate, 0.05 % at a tenth.
pub const REFINEMENT: usize = 8;

/// Samples beyond a part of a series on which what lies between its own depends.
const REACH: usize = HALF_WIDTH + 1;

/// Whether a record can be interpolated band-limited.
pub(super) fn is_even(sampling: &Sampling) -> bool {
    sampling.gaps.is_empty() && sampling.jitter <= EVEN
}

/// One input over a run.
#[derive(Debug, Clone, PartialEq)]
pub struct InputSeries {
    /// The column it was read from.
    pub column: String,
    /// Its values in SI units at the run's times.
    pub values: Vec<f64>,
    /// What it does between them.
    pub between: Between,
}

/// What an input does between its samples, with the knots between which it is a straight line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Between {
    /// [`Interpolation::BandLimited`], by so many points for each sample.
    BandLimited(usize),
    /// [`Interpolation::Linear`], with so many samples from one knot to the next: those between lie on the line.
    Linear(usize),
    /// [`Interpolation::Held`].
    Held,
}

impl Between {
    /// The interpolation that it is.
    pub fn interpolation(self) -> Interpolation {
        match self {
            Self::BandLimited(_) => Interpolation::BandLimited,
            Self::Linear(_) => Interpolation::Linear,
            Self::Held => Interpolation::Held,
        }
    }
}

impl From<Interpolation> for Between {
    fn from(interpolation: Interpolation) -> Self {
        match interpolation {
            Interpolation::BandLimited => Self::BandLimited(REFINEMENT),
            Interpolation::Linear => Self::Linear(1),
            Interpolation::Held => Self::Held,
        }
    }
}

/// The inputs of a run; those without a series are constant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InputSignals {
    /// Belt velocity, m/s.
    pub belt_velocity: Option<InputSeries>,
    /// Normal force, N.
    pub normal_force: Option<InputSeries>,
    /// External force on the tip, N, positive along the belt's motion.
    pub external_force: Excitation,
    /// Acceleration of the clamp, m/s^2, positive along the belt's motion.
    pub clamp_acceleration: Excitation,
}

/// What excites the structure beside the belt: a series, or a constant; without either there is none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Excitation {
    /// Where it varies; a constant part is added to its values.
    pub series: Option<InputSeries>,
    /// Where it does not, in its SI unit.
    pub constant: f64,
}

impl Excitation {
    /// Whether it does anything.
    pub fn acts(&self) -> bool {
        self.series.is_some() || self.constant != 0.0
    }

    /// Its value at sample `k` of its run, in its SI unit.
    pub fn at_sample(&self, k: usize) -> f64 {
        self.series.as_ref().map_or(self.constant, |s| s.values[k])
    }

    /// The largest value that it has, without sign, in its SI unit.
    pub fn largest(&self) -> f64 {
        let values = self.series.iter().flat_map(|s| &s.values);
        values.fold(self.constant.abs(), |a, v| a.max(v.abs()))
    }
}

impl InputSignals {
    /// The series with the FMU's names of the inputs.
    pub fn series(&self) -> impl Iterator<Item = (&'static str, &InputSeries)> {
        [
            ("belt_velocity", &self.belt_velocity),
            ("normal_force", &self.normal_force),
            ("external_force", &self.external_force.series),
            ("clamp_acceleration", &self.clamp_acceleration.series),
        ]
        .into_iter()
        .filter_map(|(name, series)| Some((name, series.as_ref()?)))
    }

    /// What excites the structure beside the belt, with the FMU's names of the inputs and the unit.
    pub fn excitations(&self) -> [(&'static str, &'static str, &Excitation); 2] {
        [
            ("external_force", "N", &self.external_force),
            ("clamp_acceleration", "m/s^2", &self.clamp_acceleration),
        ]
    }

    /// Whether an external force or the clamp does anything.
    pub fn is_excited(&self) -> bool {
        self.excitations().iter().any(|(_, _, e)| e.acts())
    }

    /// Whether an excitation has a series: it sets the times at which anything happens.
    pub fn is_shaken(&self) -> bool {
        let excitations = self.excitations();
        excitations.iter().any(|(_, _, e)| e.series.is_some())
    }

    /// The first samples of each series, at most so many.
    pub fn beginning(&self, samples: usize) -> Self {
        let cut = |series: &Option<InputSeries>| {
            series.as_ref().map(|s| InputSeries {
                values: s.values[..samples.min(s.values.len())].to_vec(),
                ..s.clone()
            })
        };
        let of = |excitation: &Excitation| Excitation {
            series: cut(&excitation.series),
            constant: excitation.constant,
        };
        Self {
            belt_velocity: cut(&self.belt_velocity),
            normal_force: cut(&self.normal_force),
            external_force: of(&self.external_force),
            clamp_acceleration: of(&self.clamp_acceleration),
        }
    }
}

impl Run {
    /// Whether a constant belt and a constant load are all that drives the run.
    pub fn is_plain(&self) -> bool {
        self.inputs.series().next().is_none() && !self.inputs.is_excited()
    }

    /// Whether the belt moves at some time.
    pub fn belt_moves(&self) -> bool {
        self.belt_velocity != 0.0 || self.inputs.belt_velocity.is_some()
    }

    /// Whether anything presses on the contact at some time.
    pub fn is_pressed(&self) -> bool {
        self.normal_force != 0.0 || self.inputs.normal_force.is_some()
    }

    /// Whether the motion can keep itself going and forgets its start: a belt that runs evenly, and no other drive. What
    /// is driven, or dies out, has its place in time.
    pub fn sustains_itself(&self) -> bool {
        self.is_plain() && self.belt_velocity != 0.0
    }
}

/// An input as a function of time.
#[derive(Debug, Clone, PartialEq)]
pub struct InputTrack {
    /// Times in s at which it may bend or jump, rising.
    knots: Vec<f64>,
    values: Vec<f64>,
    held: bool,
}

impl InputTrack {
    /// Of a series with samples at `time` in s; a normal force is kept from overshooting below `least`.
    pub fn of(series: &InputSeries, time: &[f64], least: f64) -> Self {
        let (knots, values) = match series.between {
            Between::BandLimited(points) => {
                let values = refine(&series.values, points);
                let last = time.len() - 1;
                let step = (time[last] - time[0]) / (last * points) as f64;
                let knots = (0..values.len()).map(|i| time[0] + i as f64 * step);
                (knots.collect(), values)
            }
            Between::Linear(samples) if samples > 1 => {
                let is_knot = |k: &usize| k.is_multiple_of(samples) || k + 1 == time.len();
                let places = (0..time.len()).filter(is_knot);
                places.map(|k| (time[k], series.values[k])).unzip()
            }
            _ => (time.to_vec(), series.values.clone()),
        };
        Self {
            knots,
            values: values.into_iter().map(|v| v.max(least)).collect(),
            held: series.between == Between::Held,
        }
    }

    /// Of the samples of `range` alone, as [`Self::of`] the whole series has it there; times count from the run's first.
    pub fn within(series: &InputSeries, time: &[f64], range: Range<usize>, least: f64) -> Self {
        let from = range.start.saturating_sub(REACH);
        // The knots of a part are those of the whole.
        let from = match series.between {
            Between::Linear(samples) => from - from % samples,
            _ => from,
        };
        let past = (range.end + REACH).min(time.len());
        let part = InputSeries {
            column: String::new(),
            values: series.values[from..past].to_vec(),
            between: series.between,
        };
        let since: Vec<f64> = time[from..past].iter().map(|t| t - time[0]).collect();
        Self::of(&part, &since, least)
    }

    /// The first knot after `t`, in s.
    pub fn next_knot(&self, t: f64) -> Option<f64> {
        let next = self.knots.partition_point(|knot| *knot <= t);
        self.knots.get(next).copied()
    }

    /// Value at `t` in s and rate per s on the piece that reaches from `t` to `end`, which no knot divides. Before and
    /// behind the record it stays as it begins and ends.
    pub fn piece(&self, t: f64, end: f64) -> (f64, f64) {
        let after = self.knots.partition_point(|knot| *knot <= 0.5 * (t + end));
        let last = self.knots.len() - 1;
        if after == 0 {
            return (self.values[0], 0.0);
        }
        let before = after - 1;
        if self.held || before == last {
            return (self.values[before], 0.0);
        }
        let span = self.knots[after] - self.knots[before];
        let rate = (self.values[after] - self.values[before]) / span;
        (self.values[before] + rate * (t - self.knots[before]), rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(interpolation: Interpolation) -> InputTrack {
        let series = InputSeries {
            column: "u".into(),
            values: vec![1.0, 3.0, -2.0],
            between: interpolation.into(),
        };
        InputTrack::of(&series, &[0.0, 1.0, 2.0], f64::NEG_INFINITY)
    }

    #[test]
    fn each_interpolation_has_its_pieces() {
        let held = track(Interpolation::Held);
        assert_eq!(held.piece(1.0, 2.0), (3.0, 0.0));
        assert_eq!(held.piece(0.2, 0.9), (1.0, 0.0));
        let linear = track(Interpolation::Linear);
        assert_eq!(linear.piece(1.0, 2.0), (3.0, -5.0));
        assert_eq!(linear.piece(0.25, 0.5), (1.5, 2.0));
        for track in [held, linear] {
            assert_eq!(track.piece(-2.0, -1.0), (1.0, 0.0));
            assert_eq!(track.piece(2.0, 3.0), (-2.0, 0.0));
            assert_eq!(track.next_knot(0.0), Some(1.0));
            assert_eq!(track.next_knot(2.0), None);
        }
        let band_limited = track(Interpolation::BandLimited);
        assert_eq!(band_limited.next_knot(0.0), Some(0.125));
        assert_eq!(band_limited.piece(1.0, 1.125).0, 3.0);
    }

    #[test]
    fn a_part_is_as_the_whole_has_it_there() {
        let wave = |k: usize| (0.4 * k as f64).sin() + 0.2 * (1.7 * k as f64).cos();
        let series = InputSeries {
            column: "u".into(),
            values: (0..300).map(wave).collect(),
            between: Interpolation::BandLimited.into(),
        };
        let time: Vec<f64> = (0..300).map(|k| 5.0 + 0.25 * k as f64).collect();
        let since: Vec<f64> = time.iter().map(|t| t - 5.0).collect();
        let whole = InputTrack::of(&series, &since, f64::NEG_INFINITY);
        for range in [0..20, 120..160, 280..300] {
            let part = InputTrack::within(&series, &time, range.clone(), f64::NEG_INFINITY);
            for k in 8 * range.start..8 * (range.end - 1) {
                let (t, end) = (k as f64 / 32.0, (k + 1) as f64 / 32.0);
                let (a, b) = (whole.piece(t, end), part.piece(t, end));
                assert!(
                    (a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-10,
                    "{k}: {a:?} {b:?}"
                );
            }
        }
    }

    #[test]
    fn a_normal_force_does_not_overshoot_below_zero() {
        let series = InputSeries {
            column: "load".into(),
            values: vec![5.0, 5.0, 0.0, 0.0, 0.0, 5.0, 5.0],
            between: Interpolation::BandLimited.into(),
        };
        let time: Vec<f64> = (0..7).map(f64::from).collect();
        let least = |least: f64| {
            let track = InputTrack::of(&series, &time, least);
            track.values.iter().copied().fold(f64::INFINITY, f64::min)
        };
        assert!(least(f64::NEG_INFINITY) < -0.1);
        assert_eq!(least(0.0), 0.0);
    }
}
