//! Natural frequencies estimated together with the force.
//!
//! Natural frequencies from a modal analysis are often a few tenths of a percent off once the beam
//! is clamped into the rig. A wrong one shows as a spurious force that rings at that frequency.
//! The likelihood of a random-walk force hardly sees it (the force is free, and friction follows
//! the motion: in trials its maximum lay 1 % off). What does see it: friction in slip is one curve
//! over the relative velocity, whichever curve, but a spurious force is not. So the frequencies
//! are taken that make the scatter of the smoothed force about its own curve least.

use super::error::ObserverError;
use super::segmentation::PhaseMode;
use super::smoother::{Levels, Record, minimise};
use super::stick_slip::{
    BeltVelocity, StickSlip, StickSlipSettings, smooth_fixed, smooth_stick_slip,
};
use super::structure::Structure;

/// What [`estimate_frequencies`] finds.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyEstimate {
    /// The structure with the estimated frequencies (those not determined as given).
    pub structure: Structure,
    /// One entry per mode, in their order.
    pub modes: Vec<ModeFrequency>,
    /// Scatter of the force about its curve in N, with the frequencies given.
    pub scatter_given_n: f64,
    /// The same with the frequencies estimated.
    pub scatter_n: f64,
}

/// Estimate for one mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeFrequency {
    /// Frequency given in Hz.
    pub given_hz: f64,
    /// Frequency of least scatter in Hz.
    pub found_hz: f64,
    /// Its standard deviation in Hz, from the curvature of the scatter.
    pub std_hz: f64,
    /// Whether the record determines it: the minimum lies inside the range searched and is sharp
    /// against it. If not, the frequency given is kept.
    pub determined: bool,
}

/// Longest part of the record used, in samples.
const PART: usize = 12_000;
/// Expectation-maximisation steps per trial.
const ITERATIONS: usize = 4;
/// Samples next to a transition left out.
const GUARD: usize = 5;
/// Share of the smallest deviations kept in each bin.
const KEPT: f64 = 0.9;
/// Number of bins over the relative velocity of each sign.
const BINS: usize = 25;
/// Samples after which deviations count as independent: about one slip phase, within which the
/// smoothing errors hang together.
const CORRELATION: f64 = 200.0;

/// Finds the natural frequencies within `range` (share, for example 0.01) of those given that make
/// friction in slip most nearly one curve over the relative velocity.
///
/// Holds where friction depends on the relative velocity alone; hysteresis (frictional lag) and
/// friction that changes along the belt add scatter and may shift the result. A mode far above the
/// motion's frequencies is determined to about 0.1 %; the first mode often is not, because far
/// from resonance an error of its stiffness is a factor on the force: see
/// [`ModeFrequency::determined`].
pub fn estimate_frequencies(
    structure: &Structure,
    sample_interval: f64,
    displacement: &[f64],
    belt: BeltVelocity,
    settings: &StickSlipSettings,
    range: f64,
) -> Result<FrequencyEstimate, ObserverError> {
    if !(range > 0.0 && range < 0.5) {
        return Err(ObserverError::BadSetting {
            name: "frequency range",
            value: range,
            unit: "",
            rule: "must be above 0 and below 0.5",
        });
    }
    let n = displacement.len();
    let start = n.saturating_sub(PART) / 2;
    let part = start..(start + PART).min(n);
    let belt_part: Vec<f64> = part.clone().map(|k| belt.at(k)).collect();
    let mut search = Search {
        structure,
        sample_interval,
        displacement: &displacement[part],
        belt: BeltVelocity::Sampled(&belt_part),
        settings,
        base: None,
    };
    let given: Vec<f64> = structure.modes().iter().map(|m| m.frequency_hz).collect();
    let mut found = given.clone();
    search.segment(&found)?;
    let scatter_given_n = search.scatter(&given);
    // The sharpest determined last in the first round, so that all start near their best.
    for (round, width) in [range, 0.2 * range].into_iter().enumerate() {
        for j in (0..found.len()).rev() {
            let centre = found[j];
            let along = |share: f64| {
                let mut trial = found.clone();
                trial[j] = centre * (1.0 + share);
                search.scatter(&trial)
            };
            let count = if round == 0 { 6 } else { 2 };
            let step = width / f64::from(count);
            let best = centre * (1.0 + minimise(along, 0.0, step, count, 0.1 * step));
            found[j] = best.clamp(given[j] * (1.0 - range), given[j] * (1.0 + range));
        }
        search.segment(&found)?;
    }
    let scatter_n = search.scatter(&found);
    let modes: Vec<ModeFrequency> = (0..found.len())
        .map(|j| {
            let std_hz = search.std(&found, j, scatter_n);
            let inside = (found[j] / given[j] - 1.0).abs() < 0.95 * range;
            ModeFrequency {
                given_hz: given[j],
                found_hz: found[j],
                std_hz,
                determined: inside && std_hz < 0.25 * range * given[j],
            }
        })
        .collect();
    let kept: Vec<f64> = modes
        .iter()
        .map(|m| if m.determined { m.found_hz } else { m.given_hz })
        .collect();
    Ok(FrequencyEstimate {
        structure: structure.with_frequencies(&kept)?,
        modes,
        scatter_given_n,
        scatter_n,
    })
}

struct Search<'a> {
    structure: &'a Structure,
    sample_interval: f64,
    displacement: &'a [f64],
    belt: BeltVelocity<'a>,
    settings: &'a StickSlipSettings,
    base: Option<Base>,
}

/// Phases and noise levels found with the frequencies so far.
struct Base {
    found: StickSlip,
    levels: Levels,
    slip: Vec<bool>,
}

impl Search<'_> {
    fn segment(&mut self, frequencies_hz: &[f64]) -> Result<(), ObserverError> {
        let structure = self.structure.with_frequencies(frequencies_hz)?;
        let short = StickSlipSettings {
            rounds: 2,
            iterations: ITERATIONS,
            ..self.settings.clone()
        };
        let (y, interval) = (self.displacement, self.sample_interval);
        let found = smooth_stick_slip(&structure, interval, y, self.belt, &short)?;
        let record = Record::new(&structure, interval, y, &self.settings.smoother)?;
        let modes = found.modes();
        let slip: Vec<bool> = (0..modes.len())
            .map(|k| {
                let near = k.saturating_sub(GUARD)..(k + GUARD + 1).min(modes.len());
                modes[k] != PhaseMode::Stick && modes[near].iter().all(|m| *m == modes[k])
            })
            .collect();
        let samples = slip.iter().filter(|s| **s).count();
        let needed = 10 * BINS;
        if samples < needed {
            return Err(ObserverError::TooFewEvents {
                what: "natural frequencies",
                found: samples,
                needed,
                unit: "samples in slip",
                action: "record longer, or a motion that slips more",
            });
        }
        self.base = Some(Base {
            levels: record.scaled_levels(&found.smoothed),
            found,
            slip,
        });
        Ok(())
    }

    /// Root mean square deviation of the force from its curve over the relative velocity in N.
    fn scatter(&self, frequencies_hz: &[f64]) -> f64 {
        let Some(base) = &self.base else {
            return f64::NAN;
        };
        let smoothed = self
            .structure
            .with_frequencies(frequencies_hz)
            .and_then(|structure| {
                smooth_fixed(
                    &structure,
                    self.sample_interval,
                    self.displacement,
                    self.belt,
                    self.settings,
                    (&base.found.phases, base.levels, ITERATIONS),
                )
            });
        let Ok(smoothed) = smoothed else {
            return f64::NAN;
        };
        let relative: Vec<f64> = (0..smoothed.velocity.len())
            .map(|k| smoothed.velocity[k] - self.belt.at(k))
            .collect();
        scatter(&relative, &smoothed.force, &base.slip)
    }

    /// Standard deviation of frequency `j`: where `N ln(scatter)` rises by one half, with `N`
    /// independent deviations.
    fn std(&self, found: &[f64], j: usize, least: f64) -> f64 {
        let Some(base) = &self.base else {
            return f64::NAN;
        };
        let samples = base.slip.iter().filter(|s| **s).count() as f64;
        let independent = samples / CORRELATION;
        let h = 1e-3 * found[j];
        let beside = |sign: f64| {
            let mut trial = found.to_vec();
            trial[j] += sign * h;
            self.scatter(&trial)
        };
        let rise = independent * (0.5 * (beside(1.0) + beside(-1.0)) / least).ln();
        h * (0.5 / rise.max(1e-12)).sqrt()
    }
}

/// Robust RMS deviation of `force` from a piecewise straight curve over `relative` (both signs).
fn scatter(relative: &[f64], force: &[f64], used: &[bool]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for sign in [-1.0, 1.0] {
        let mut order: Vec<usize> = (0..relative.len())
            .filter(|k| used[*k] && relative[*k] * sign > 0.0)
            .collect();
        order.sort_by(|a, b| relative[*a].total_cmp(&relative[*b]));
        for bin in order.chunks((order.len() / BINS).max(20)) {
            if bin.len() < 10 {
                continue;
            }
            let n = bin.len() as f64;
            let mean = |values: &[f64]| bin.iter().map(|k| values[*k]).sum::<f64>() / n;
            let (x0, y0) = (mean(relative), mean(force));
            let xx: f64 = bin.iter().map(|k| (relative[*k] - x0).powi(2)).sum();
            let xy: f64 = bin
                .iter()
                .map(|k| (relative[*k] - x0) * (force[*k] - y0))
                .sum();
            let slope = xy / xx.max(f64::MIN_POSITIVE);
            let mut off: Vec<f64> = bin
                .iter()
                .map(|k| (force[*k] - y0 - slope * (relative[*k] - x0)).powi(2))
                .collect();
            off.sort_by(f64::total_cmp);
            let kept = (n * KEPT) as usize;
            sum += off[..kept].iter().sum::<f64>();
            count += kept as f64;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}
