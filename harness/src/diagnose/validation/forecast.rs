//! Forecasts of the runs kept out: the only figure for which no later sample was looked at.
//!
//! All that the runs share comes from the runs fitted. Of a run kept out the first part, two cycles or 40 ms, whichever is
//! longer, determines what is its own: friction level, offset, phases and the state at its end. Everything after is
//! predicted. Two figures say how well:
//!
//! - one-cycle forecasts: from states filtered through the past (the start state of a piece is fitted to that piece alone)
//!   each next piece is predicted; their root mean square error over the standard deviation of what is measured;
//! - valid time: how long the free motion from the end of the first part stays within 0.4 of that standard deviation (Pathak
//!   et al., Phys. Rev. Lett. 120 (2018) 024102). Its limit is that of the model's own motion with the sensor's noise on it,
//!   forecast in the same way: no model can do better than that with so noisy a beginning.
//!
//! The whole run counts: nothing is left out, whether it grazes a transition or not.

use crate::diagnose::data::white_noise::gaussian;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::validation::forecast_band::{Band, band};
use crate::diagnose::validation::learned_run::LearnedRun;
use crate::error::Error;
use crate::measurement::{Measurand, Run};
use crate::metric::characteristics;
use crate::parallel::parallel;
use serde::Serialize;

/// Shortest first part of a run in s.
const LEAST_LEARNED: f64 = 0.04;
/// Cycles in the first part of a run.
const CYCLES_LEARNED: f64 = 2.0;
/// Error over the standard deviation of what is measured at which a forecast is no longer valid.
const VALID: f64 = 0.4;
/// Seed of the noise on the model's own motion.
const SEED: u64 = 1;

/// A number as measured and as predicted.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Compared {
    /// As measured; `None` where the motion has none.
    pub measured: Option<f64>,
    /// As predicted.
    pub predicted: Option<f64>,
}

/// The amplitude of what was measured, under the key that names its unit.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(untagged)]
pub enum Amplitude {
    /// Of a displacement.
    Displacement {
        /// In m.
        amplitude_m: Compared,
    },
    /// Of a velocity.
    Velocity {
        /// In m/s.
        amplitude_m_per_s: Compared,
    },
    /// Of an acceleration.
    Acceleration {
        /// In m/s^2.
        amplitude_m_per_s2: Compared,
    },
}

impl Amplitude {
    fn of(measurand: Measurand, amplitude: Compared) -> Self {
        match measurand {
            Measurand::Displacement => Self::Displacement {
                amplitude_m: amplitude,
            },
            Measurand::Velocity => Self::Velocity {
                amplitude_m_per_s: amplitude,
            },
            Measurand::Acceleration => Self::Acceleration {
                amplitude_m_per_s2: amplitude,
            },
        }
    }

    /// The numbers, and their unit.
    pub fn with_unit(self) -> (Compared, &'static str) {
        match self {
            Self::Displacement { amplitude_m: a } => (a, "m"),
            Self::Velocity {
                amplitude_m_per_s: a,
            } => (a, "m/s"),
            Self::Acceleration {
                amplitude_m_per_s2: a,
            } => (a, "m/s^2"),
        }
    }
}

/// The forecast of a run.
#[derive(Debug, Clone, Serialize)]
pub struct Forecast {
    /// Name of the run.
    pub run: String,
    /// Length in s of the first part, from which the run's own values and its state were learned.
    pub learned_s: f64,
    /// Root mean square error of one-cycle forecasts over the standard deviation of what is measured.
    pub one_cycle_nrmse: f64,
    /// Time in s for which the free motion stays near the measured one; as long as the run lasts, if it never leaves it.
    pub valid_time_s: f64,
    /// The same for the model's own motion with the sensor's noise.
    pub valid_time_limit_s: f64,
    /// Period of the motion after the first part in s.
    pub period_s: Compared,
    /// Amplitude of it.
    #[serde(flatten)]
    pub amplitude: Amplitude,
    /// Share of the time in stick.
    pub stick_share: Compared,
    /// Share (1) of the samples measured within the valid time that lie in the forecast's band, which is to hold 8 of 10; only
    /// for the model that the diagnosis ends with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inside_band: Option<f64>,
    /// The band.
    #[serde(skip)]
    pub band: Option<Band>,
    /// Index of the run.
    #[serde(skip)]
    pub index: usize,
    /// Times in s since the run began, and what is predicted of the free motion in m or m/s, NaN once it was given up.
    #[serde(skip)]
    pub curve: (Vec<f64>, Vec<f64>),
}

/// Forecasts of the runs kept out.
///
/// # Errors
/// An FMU that can't be run.
pub fn forecasts(problem: &Problem, fitted: &FittedHypothesis) -> Result<Vec<Forecast>, Error> {
    let runs: Vec<usize> = (0..problem.held_out.len())
        .filter(|&r| problem.held_out[r])
        .collect();
    let found = parallel(&runs, |&r| forecast(problem, fitted, r))?;
    Ok(found.into_iter().flatten().collect())
}

/// The forecast of run `r`; `None` for a run that is not longer than what must be learned from.
fn forecast(
    problem: &Problem,
    fitted: &FittedHypothesis,
    r: usize,
) -> Result<Option<Forecast>, Error> {
    let measured = &problem.campaign.runs[r];
    let cycle = problem.smoothings[r].cycle;
    let learned_s = if cycle.is_finite() {
        LEAST_LEARNED.max(CYCLES_LEARNED * cycle)
    } else {
        LEAST_LEARNED
    }
    // A whole piece must fit into it.
    .max(2.5 * problem.horizon);
    let Some(seen) = LearnedRun::new(problem, fitted, measured, r, learned_s)? else {
        return Ok(None);
    };
    let ahead = seen.ahead()?;
    let (time, free) = seen.after(&ahead);
    let spread = problem.spread[r];
    let valid_time_s = valid_time(&time, &measured.measured[seen.past..], free, spread);
    // The model's own motion, measured by the same sensor.
    let mut random = fastrand::Rng::with_seed(SEED);
    let noise = problem.noise[r];
    let before = &measured.measured[..seen.last().first];
    let truth = [before, &ahead].concat();
    let per_run = Run {
        measured: truth
            .iter()
            .map(|y| y + noise * gaussian(&mut random))
            .collect(),
        further: Vec::new(),
        faults: Vec::new(),
        ..measured.clone()
    };
    let limit = match LearnedRun::new(problem, fitted, &per_run, r, learned_s)? {
        Some(again) if truth.iter().all(|y| y.is_finite()) => {
            let ahead = again.ahead()?;
            let (time, free) = again.after(&ahead);
            valid_time(&time, &truth[again.past..], free, spread)
        }
        _ => f64::NAN,
    };
    let of_measured = &measured.measured[seen.past..];
    let belt = problem.campaign.beam.sensor.seen(measured.belt_velocity);
    let measurand = measured.measurand;
    let described = |values: &[f64]| {
        let usable = values.len() > 32 && values.iter().all(|v| v.is_finite());
        usable.then(|| characteristics(&time, (measurand, values), belt, noise))
    };
    let (seen_there, predicted) = (described(of_measured), described(free));
    let compared = |read: &dyn Fn(&crate::metric::Characteristics) -> Option<f64>| Compared {
        measured: seen_there.as_ref().and_then(read),
        predicted: predicted.as_ref().and_then(read),
    };
    Ok(Some(Forecast {
        run: measured.name.clone(),
        learned_s,
        one_cycle_nrmse: seen.one_cycle()? / spread,
        valid_time_s,
        valid_time_limit_s: limit,
        period_s: compared(&|c| c.period),
        amplitude: Amplitude::of(measurand, compared(&|c| Some(c.amplitude))),
        stick_share: compared(&|c| Some(c.stick_fraction).filter(|share| share.is_finite())),
        inside_band: None,
        band: None,
        index: r,
        curve: (time.clone(), free.to_vec()),
    }))
}

impl Forecast {
    /// The same with its band.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn with_band(self, problem: &Problem, fitted: &FittedHypothesis) -> Result<Self, Error> {
        let run = &problem.campaign.runs[self.index];
        let band = band(problem, fitted, self.index, self.learned_s)?;
        let noise = problem.noise[self.index];
        let until = self.learned_s + self.valid_time_s;
        let share = |band: &Band| band.share_inside(&run.time, &run.measured, noise, until);
        Ok(Self {
            inside_band: band.as_ref().map(share),
            band,
            ..self
        })
    }
}

/// Time in s until the error exceeds [`VALID`] of the spread.
fn valid_time(time: &[f64], measured: &[f64], predicted: &[f64], spread: f64) -> f64 {
    let wrong = measured
        .iter()
        .zip(predicted)
        .position(|(m, p)| !((m - p).abs() <= VALID * spread));
    match (wrong, time) {
        (_, []) => f64::NAN,
        (Some(k), _) => time[k] - time[0],
        (None, _) => time[time.len() - 1] - time[0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_forecast_is_valid_until_it_first_errs_by_more_than_its_share_of_the_spread() {
        let time = [0.0, 0.1, 0.2, 0.3];
        let measured = [1.0, 2.0, 3.0, 4.0];
        // The bound is 0.4 of a spread of 1; later agreement does not count.
        assert_eq!(
            valid_time(&time, &measured, &[1.3, 2.39, 3.5, 4.0], 1.0),
            0.2
        );
        assert_eq!(valid_time(&time, &measured, &measured, 1.0), 0.3);
        // What ran away is wrong from there on.
        let run_away = [1.0, f64::NAN, 3.0, 4.0];
        assert_eq!(valid_time(&time, &measured, &run_away, 1.0), 0.1);
        assert!(valid_time(&[], &[], &[], 1.0).is_nan());
    }
}
