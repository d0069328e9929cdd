//! The smoother that knows stick and slip.
//!
//! A friction force jumps when the tip comes to rest on the belt, and in stick it is whatever
//! holds the tip at the belt's speed. Three steps, repeated:
//! 1. phases from the smoothed relative velocity ([`super::segmentation`]);
//! 2. in stick the relative velocity is taken as measured to be zero (pseudo measurement,
//!    Tahk and Speyer 1990), away from the transitions, which stay free to move;
//! 3. outside stick every sample interval has its own force variance, found by
//!    expectation-maximisation (Dempster, Laird, Rubin 1977; as sparse Bayesian learning,
//!    Tipping 2001): it shrinks where the force is smooth and stays where it jumps.
//!
//! In stick a beam of two modes or more can vibrate at a zero of its transfer function (363 Hz
//! for the nominal beam) without moving the tip: that part of the force is invisible to any
//! filter without step 2.
//!
//! Holds for rigid contacts with a known belt speed. With tangential compliance in the contact, or
//! a belt speed that gives way, the velocity in stick is not zero: [`StickSlip::stick_misfit`] says
//! so, and a larger [`StickSlipSettings::velocity_std`] or the plain smoother is right.

use std::borrow::Cow;

use super::error::ObserverError;
use super::kernel::{self, Known, Problem, Solution, VaryingNoise};
use super::segmentation::{Phase, PhaseMode, SegmentSettings, phases_of, segments};
use super::smoother::{Levels, Record, Settings, Smoothed};
use super::structure::{ForceModel, Structure};
use crate::measurement::Measurand;

/// Speed of the belt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BeltVelocity<'a> {
    /// The same throughout, in m/s.
    Constant(f64),
    /// One value per sample, in m/s.
    Sampled(&'a [f64]),
}

impl BeltVelocity<'_> {
    /// Value at sample `k` in m/s.
    pub fn at(&self, k: usize) -> f64 {
        match self {
            BeltVelocity::Constant(v) => *v,
            BeltVelocity::Sampled(values) => values[k],
        }
    }

    /// Largest absolute value in m/s.
    fn size(&self, count: usize) -> f64 {
        (0..count).fold(0.0, |size: f64, k| size.max(self.at(k).abs()))
    }

    fn check(&self, count: usize) -> Result<(), ObserverError> {
        match self {
            BeltVelocity::Constant(v) if !v.is_finite() => Err(ObserverError::BadSetting {
                name: "belt_velocity",
                value: *v,
                unit: "m/s",
                rule: "must be finite",
            }),
            BeltVelocity::Sampled(values) if values.len() != count => {
                Err(ObserverError::LengthMismatch {
                    what: "belt velocity",
                    expected: count,
                    found: values.len(),
                })
            }
            _ => Ok(()),
        }
    }
}

/// Choices for [`smooth_stick_slip`].
#[derive(Debug, Clone, PartialEq)]
pub struct StickSlipSettings {
    /// Noise levels and offset; the force model is always the random walk.
    pub smoother: Settings,
    /// How phases are found.
    pub segments: SegmentSettings,
    /// For each sample, whether it is known to be in stick before anything is smoothed. An acceleration alone tells no
    /// velocity from which that could be found: the first round takes the phases from here.
    pub known_stick: Option<Vec<bool>>,
    /// What the force is expected to be in N wherever the velocity is not held, and with what standard deviation in N each
    /// sample tells that; `None` where nothing is expected. Needed where an acceleration was measured: a slow change of force
    /// and of the deflection that balances it shows in that hardly at all.
    pub expected_force: Option<(f64, f64)>,
    /// Standard deviation of the relative velocity in stick in m/s; 1/1000 of the belt velocity
    /// if `None`.
    pub velocity_std: Option<f64>,
    /// How often the phases are found anew.
    pub rounds: usize,
    /// Expectation-maximisation steps in the last round.
    pub iterations: usize,
    /// Samples at the beginning of a stick phase without pseudo measurement: which of two samples
    /// is the last in slip cannot be told when the tip comes to rest close to one, and a sample
    /// wrongly held at rest loses the peak of the force before the jump.
    pub arrival_samples: usize,
    /// Samples at the end of a stick phase without pseudo measurement: the velocity leaves zero
    /// gradually there.
    pub break_away_samples: usize,
}

impl Default for StickSlipSettings {
    fn default() -> Self {
        Self {
            smoother: Settings::default(),
            segments: SegmentSettings::default(),
            known_stick: None,
            expected_force: None,
            velocity_std: None,
            rounds: 3,
            iterations: 30,
            arrival_samples: 1,
            break_away_samples: 3,
        }
    }
}

/// What [`smooth_stick_slip`] finds.
#[derive(Debug, Clone, PartialEq)]
pub struct StickSlip {
    /// Force and motion.
    pub smoothed: Smoothed,
    /// Tip velocity less belt velocity in m/s.
    pub relative_velocity: Vec<f64>,
    /// Stick and slip phases, without gap.
    pub phases: Vec<Phase>,
    /// Root mean square of the pseudo measurements' normalised innovations (1): about 1 or less
    /// where the tip really rests on the belt.
    pub stick_misfit: f64,
}

impl StickSlip {
    /// Mode of every sample.
    pub fn modes(&self) -> Vec<PhaseMode> {
        let mut out = Vec::with_capacity(self.relative_velocity.len());
        for phase in &self.phases {
            out.resize(phase.past, phase.mode);
        }
        out
    }

    /// Share of the samples in stick (1).
    pub fn stick_fraction(&self) -> f64 {
        let stick: usize = self
            .phases
            .iter()
            .filter(|p| p.mode == PhaseMode::Stick)
            .map(|p| p.past - p.first)
            .sum();
        stick as f64 / self.relative_velocity.len() as f64
    }
}

/// Standard deviation of the relative velocity in stick per belt velocity (1).
const DEFAULT_HELD_SHARE: f64 = 1e-3;
/// Samples about a transition that stay free while the phases are still being found.
const SEARCH_MARGIN: usize = 3;
/// Expectation-maximisation steps in the rounds before the last.
const SEARCH_ITERATIONS: usize = 3;
/// Smallest force variance of an interval relative to the random walk's.
const LEAST_LEVEL: f64 = 1e-9;
/// Longest part smoothed at once, in samples: bounds the memory.
const BLOCK: usize = 200_000;
/// Samples smoothed beyond either end of a block.
const OVERLAP: usize = 5_000;

/// Smooths a displacement, velocity or acceleration ([`Settings::measurand`]), caused by stick-slip on a belt of known speed.
///
/// `sample_interval` in s; `displacement` in m (m/s, m/s^2) at the tip, NaN where a sample is missing; the belt
/// velocity positive in the direction of positive displacement.
pub fn smooth_stick_slip(
    structure: &Structure,
    sample_interval: f64,
    displacement: &[f64],
    belt: BeltVelocity,
    settings: &StickSlipSettings,
) -> Result<StickSlip, ObserverError> {
    belt.check(displacement.len())?;
    let plain = Settings {
        force_model: ForceModel::RandomWalk,
        ..settings.smoother.clone()
    };
    let record = Record::new(structure, sample_interval, displacement, &plain)?;
    let levels = record.levels(&plain)?;
    let walk = kernel::smooth(&record.problem(levels, plain.converged_gain), false);
    let mut smoothed = record.unscale(&walk, levels);
    let velocity_std = settings
        .velocity_std
        .unwrap_or_else(|| DEFAULT_HELD_SHARE * sliding_speed(&smoothed.velocity, belt));
    let time: Vec<f64> = (0..displacement.len())
        .map(|k| k as f64 * sample_interval)
        .collect();
    let mut stick_misfit = 0.0;
    let mut phases = Vec::new();
    for round in 0..settings.rounds.max(1) {
        let relative = relative_velocity(&smoothed.velocity, belt);
        let std = in_stick(
            &smoothed.velocity_std,
            settings.smoother.measurand,
            velocity_std,
        );
        phases = match &settings.known_stick {
            Some(stick) if round == 0 => phases_of(&time, &relative, stick)?,
            _ => segments(&time, &relative, &std, &settings.segments)?,
        };
        let last = round + 1 >= settings.rounds;
        let (before, after, iterations) = if last {
            (
                settings.arrival_samples,
                settings.break_away_samples,
                settings.iterations,
            )
        } else {
            (SEARCH_MARGIN, SEARCH_MARGIN, SEARCH_ITERATIONS)
        };
        let mut held = held_velocity(
            &phases,
            belt,
            velocity_std,
            displacement.len(),
            before,
            after,
        );
        if let Some((force, std)) = settings.expected_force {
            let scale = record.model.force_scale;
            let expected = Known::force(force * scale, (std * scale).powi(2));
            let free = held.iter_mut().filter(|held| !held.is_something());
            free.for_each(|held| *held = expected);
        }
        let solution = learn_jumps(&record, levels, &held, iterations);
        stick_misfit = solution.held_misfit();
        let white = (
            smoothed.whiteness,
            smoothed.innovation,
            smoothed.log_likelihood,
        );
        smoothed = record.unscale(&solution, levels);
        // The random walk's innovations speak of the structure; the learnt ones are fitted.
        (
            smoothed.whiteness,
            smoothed.innovation,
            smoothed.log_likelihood,
        ) = white;
    }
    Ok(StickSlip {
        relative_velocity: relative_velocity(&smoothed.velocity, belt),
        smoothed,
        phases,
        stick_misfit,
    })
}

/// Smooths with phases and noise levels that are known already: `(phases, levels, iterations)`.
pub(super) fn smooth_fixed(
    structure: &Structure,
    sample_interval: f64,
    displacement: &[f64],
    belt: BeltVelocity,
    settings: &StickSlipSettings,
    (phases, levels, iterations): (&[Phase], Levels, usize),
) -> Result<Smoothed, ObserverError> {
    let plain = Settings {
        force_model: ForceModel::RandomWalk,
        ..settings.smoother.clone()
    };
    let record = Record::new(structure, sample_interval, displacement, &plain)?;
    let count = displacement.len();
    let velocity_std = settings
        .velocity_std
        .unwrap_or_else(|| DEFAULT_HELD_SHARE * belt.size(count));
    let (before, after) = (settings.arrival_samples, settings.break_away_samples);
    let held = held_velocity(phases, belt, velocity_std, count, before, after);
    let solution = learn_jumps(&record, levels, &held, iterations);
    Ok(record.unscale(&solution, levels))
}

/// Standard deviation in m/s by which a relative velocity is told from zero. A measured velocity, or one held in stick and
/// followed by a measured acceleration, is known far better than that of the belt, so that what the belt may be off by counts too.
fn in_stick(smoothed: &[f64], measurand: Measurand, held: f64) -> Cow<'_, [f64]> {
    match measurand {
        Measurand::Displacement => Cow::Borrowed(smoothed),
        Measurand::Velocity | Measurand::Acceleration => {
            smoothed.iter().map(|std| std.hypot(held)).collect()
        }
    }
}

/// What sliding speeds are measured by in m/s: the belt's, or where it rests or varies the root mean square of the relative
/// velocity.
fn sliding_speed(velocity: &[f64], belt: BeltVelocity) -> f64 {
    let first = belt.at(0);
    let is_even = (0..velocity.len()).all(|k| belt.at(k) == first);
    if is_even && first != 0.0 {
        return first.abs();
    }
    let squares = relative_velocity(velocity, belt).into_iter();
    let sum: f64 = squares.map(|v| v * v).sum();
    (sum / velocity.len() as f64).sqrt()
}

fn relative_velocity(velocity: &[f64], belt: BeltVelocity) -> Vec<f64> {
    velocity
        .iter()
        .enumerate()
        .map(|(k, v)| v - belt.at(k))
        .collect()
}

/// The belt's velocity in stick, nothing elsewhere and within the margins of a stick phase.
fn held_velocity(
    phases: &[Phase],
    belt: BeltVelocity,
    velocity_std: f64,
    count: usize,
    before: usize,
    after: usize,
) -> Vec<Known> {
    let mut held = vec![Known::NOTHING; count];
    for phase in phases.iter().filter(|p| p.mode == PhaseMode::Stick) {
        let first = phase.first + if phase.first > 0 { before } else { 0 };
        let past = phase.past
            - if phase.past < count {
                after.min(phase.past)
            } else {
                0
            };
        for (k, held) in held.iter_mut().enumerate().take(past).skip(first) {
            *held = Known::velocity(belt.at(k), velocity_std * velocity_std);
        }
    }
    held
}

/// Learns the force variance of every interval outside stick and smooths with it.
fn learn_jumps(record: &Record, levels: Levels, held: &[Known], iterations: usize) -> Solution {
    let n = held.len();
    let mut out = Solution::empty(n, record.model.output.len());
    let mut first = 0;
    while first < n {
        let past = if n - first <= BLOCK + OVERLAP {
            n
        } else {
            first + BLOCK
        };
        let (from, to) = (first.saturating_sub(OVERLAP), (past + OVERLAP).min(n));
        let part = learn_block(record, levels, held, iterations, from..to);
        out.take(&part, from, first..past);
        first = past;
    }
    out
}

fn learn_block(
    record: &Record,
    levels: Levels,
    held: &[Known],
    iterations: usize,
    range: std::ops::Range<usize>,
) -> Solution {
    let held = &held[range.clone()];
    let mut level = vec![levels.intensity; held.len()];
    let pass = |level: &mut Vec<f64>, learn: bool| {
        let still = Levels {
            intensity: 0.0,
            ..levels
        };
        let problem = Problem {
            varying: vec![VaryingNoise {
                unit: &record.model.noise[0],
                level,
            }],
            known: Some(held),
            ..record.problem_on(&record.measured[range.clone()], still, false)
        };
        let solution = kernel::smooth(&problem, learn);
        if learn {
            for k in 0..held.len() - 1 {
                if !(held[k].holds() && held[k + 1].holds()) {
                    level[k] = (solution.increments[0][k] / record.sample_interval)
                        .max(LEAST_LEVEL * levels.intensity);
                }
            }
        }
        solution
    };
    for _ in 1..iterations {
        pass(&mut level, true);
    }
    pass(&mut level, false)
}
