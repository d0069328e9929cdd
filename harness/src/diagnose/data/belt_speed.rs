//! By how much the stated belt speeds are off: in stick the tip moves with the belt.

use crate::error::Error;
use crate::measurement::{Campaign, Measurand, Run};
use crate::metric::MAD;
use crate::observer::{Structure, smooth};
use crate::parallel::parallel;
use crate::smoothing::{belt_in_stick, smoother_settings, trusted_signal};

/// Standard deviations from the stated speed beyond which a plateau of the velocity is none of the belt's: a contact that
/// creeps moves slower.
const CREDIBLE: f64 = 5.0;
/// Scatter between runs that no standard error within a run shows: a stick that creeps, a drive that gives way.
const LEAST_STD: f64 = 5e-4;

/// A factor from the stated belt speeds to the true ones, and its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeltScale {
    /// The factor.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// Factor from the stated belt speeds to those that the stick phases show, the same for all runs: the median over the runs,
/// weighted by their precision, drawn to 1 by what is believed of stated speeds,
///
/// ```text
/// s = (m / sigma^2 + 1 / sigma_0^2) / (1 / sigma^2 + 1 / sigma_0^2)
/// ```
///
/// with sigma the scatter between the runs over the root of their number, robust against runs that creep. 1 where no more than half of the runs show
/// such a speed. sigma_0 is the standard deviation of the belief in the stated speeds, as a share.
///
/// The second are the factors of the runs: the common one, drawn to what a run itself shows as far as the campaign says that speeds
/// differ from run to run.
///
/// # Errors
/// A run that can't be smoothed.
pub fn belt_scale(
    campaign: &Campaign,
    structure: &Structure,
) -> Result<(BeltScale, Vec<f64>), Error> {
    let runs = &campaign.runs;
    let known = &campaign.uncertainty;
    let (stated_std, run_std) = (known.belt_velocity_std, known.belt_velocity_run_std);
    let of_run = |run: &Run| -> Result<Option<(f64, f64)>, Error> {
        // A belt at rest has no scale, and one whose speed varies no plateau. An acceleration shows no speed but by its mean over
        // whole cycles, which says less than is stated.
        if !run.sustains_itself() || run.measurand == Measurand::Acceleration {
            return Ok(None);
        }
        let signal = trusted_signal(run);
        let h = run.sample_interval();
        let settings = smoother_settings(run);
        let plain = smooth(structure, h, &signal, &settings).map_err(|source| Error::Observer {
            run: run.name.clone(),
            source,
        })?;
        let measured = (run.measurand, &signal[..]);
        let found = belt_in_stick(structure, &plain, measured, run.belt_velocity);
        Ok(found.map(|f| {
            let share = f.std / run.belt_velocity.abs();
            (f.velocity / run.belt_velocity, share.hypot(LEAST_STD))
        }))
    };
    let believed = CREDIBLE * stated_std.hypot(run_std);
    let of_runs: Vec<Option<(f64, f64)>> = parallel(runs, of_run)?
        .into_iter()
        .map(|found| found.filter(|(factor, _)| (factor - 1.0).abs() <= believed))
        .collect();
    let found = of_runs.iter().flatten();
    let found: Vec<(f64, f64)> = found.map(|&(f, std)| (f, std.hypot(run_std))).collect();
    let is_common = 2 * found.len() > runs.len();
    let common = combined(if is_common { found } else { Vec::new() }, stated_std);
    let factors = of_runs.iter().map(|f| of_one(*f, &common, run_std));
    Ok((common, factors.collect()))
}

/// The factor of a run that shows `found` with its standard deviation, where factors differ from run to run by `run_std`.
fn of_one(found: Option<(f64, f64)>, common: &BeltScale, run_std: f64) -> f64 {
    match found {
        Some((factor, std)) if run_std > 0.0 => {
            let share = run_std.powi(2) / (run_std.powi(2) + std.powi(2));
            common.value + share * (factor - common.value)
        }
        _ => common.value,
    }
}

/// The factor from those of the runs and their standard deviations.
fn combined(mut found: Vec<(f64, f64)>, stated_std: f64) -> BeltScale {
    if found.is_empty() {
        return BeltScale {
            value: 1.0,
            std: stated_std,
        };
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let weight = |f: &(f64, f64)| f.1.powi(-2);
    let total: f64 = found.iter().map(weight).sum();
    let mut below = 0.0;
    let middle = found.iter().find(|f| {
        below += weight(f);
        below >= 0.5 * total
    });
    let middle = middle.map_or(1.0, |f| f.0);
    let mut away: Vec<f64> = found.iter().map(|f| (f.0 - middle).abs()).collect();
    away.sort_by(f64::total_cmp);
    let scatter = MAD * away[away.len() / 2];
    let variance = (scatter * scatter / found.len() as f64).max(1.0 / total);
    let (data, belief) = (1.0 / variance, stated_std.powi(-2));
    BeltScale {
        value: (middle * data + belief) / (data + belief),
        std: (data + belief).sqrt().recip(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_that_agree_give_their_factor_and_none_gives_one() {
        assert_eq!(combined(Vec::new(), 0.01).value, 1.0);
        let s = combined(vec![(1.02, 5e-4), (1.0201, 5e-4), (0.95, 0.1)], 0.01).value;
        assert!((s - 1.02).abs() < 2e-4, "{s}");
    }

    #[test]
    fn a_run_has_its_own_factor_only_where_runs_differ() {
        let common = combined(vec![(1.01, 5e-4)], 0.01);
        assert_eq!(of_one(Some((1.02, 5e-4)), &common, 0.0), common.value);
        let own = of_one(Some((1.02, 5e-4)), &common, 0.01);
        assert!((own - 1.02).abs() < 1e-4, "{own}");
        assert_eq!(of_one(None, &common, 0.01), common.value);
    }

    #[test]
    fn runs_that_scatter_are_drawn_to_what_is_stated() {
        let s = combined(
            vec![(0.98, 1e-3), (1.02, 1e-3), (1.05, 1e-3), (1.08, 1e-3)],
            0.01,
        )
        .value;
        assert!(s > 1.0 && s < 1.02, "{s}");
    }
}
