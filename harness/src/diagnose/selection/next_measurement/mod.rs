//! Which operating point to measure next, where the data at hand can't tell effects apart.
//!
//! T-optimal design (Atkinson and Fedorov 1975): at each point a run is simulated by each of the rivals, from rest and after its
//! transient, with the sensor's noise. It joins the runs measured, every rival is fitted to all of them, common constants included,
//! and what counts is how far the others' scores then lie behind that of the rival which made the run: the same figure by
//! which a diagnosis of the larger campaign will call them tied or not. (With constants held at what the runs measured made of them, points
//! promise differences that the constants take up.) The point taken is the one where the least distance is largest, provided that it is
//! well beyond a tie.

mod joint;
mod simulated;

use crate::diagnose::model::problem::Problem;
use crate::parallel::parallel;

use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::screening::Screen;
use crate::diagnose::thresholds::TIE;
use crate::error::Error;
use crate::measurement::Run;
use joint::Prospect;
use serde::Serialize;

/// Which measurement would tell more.
#[derive(Debug, Clone, Serialize)]
pub struct NextMeasurement {
    /// Belt velocity.
    pub belt_velocity_m_per_s: f64,
    /// Normal force.
    pub normal_force_n: f64,
    /// Effects that it separates.
    pub separates: Vec<String>,
    /// Least error over the noise expected there of a rival where another is true, its constants as they are.
    pub separation: f64,
    /// Least distance in score expected of a rival behind the one that is true, once all are fitted to the new run too.
    pub expected_gain: f64,
}

/// Belt velocities that are tried, in units of the fastest run's.
const VELOCITIES: [f64; 4] = [0.25, 0.5, 0.8, 1.3];
/// Normal forces that are tried, in units of the largest run's.
const FORCES: [f64; 3] = [0.4, 0.75, 1.3];
/// Rivals that are told apart, the best ones.
const MOST_RIVALS: usize = 3;
/// Error over the noise of a rival as it stands below which its constants need not be fitted: they only make it less.
const TELLS: f64 = 1.2;
/// Segments of the comparison times points at which the rivals are fitted to the simulated runs: in poor campaigns all points, ...
const AFFORDED: usize = 240;
/// ... in rich ones at least so many, those where the rivals as they stand differ most.
const LEAST_POINTS: usize = 3;
/// Distance in score that a point must promise: the noise of one more run moves it by several units.
const SURE: f64 = 2.0 * TIE;

/// What to say where rivals are tied and no point promises to tell them apart.
pub const NONE_HELPS: &str = "none of twelve operating points tried would separate the tied effects with one more run as long and as noisy as \
                              those measured; longer runs, less noise or points further away may";

/// The operating point that tells rivals apart best; `None` if there is nothing to tell apart or no point helps.
///
/// # Errors
/// An FMU that can't be run.
pub fn recommend(
    problem: &Problem,
    rivals: &[&FittedModel],
) -> Result<Option<NextMeasurement>, Error> {
    // Another operating point is asked of the motion that keeps itself going; what drives a run would be another too.
    let is_plain = problem.campaign.runs.iter().all(Run::sustains_itself);
    if rivals.len() < 2 || !is_plain {
        return Ok(None);
    }
    let rivals = &rivals[..rivals.len().min(MOST_RIVALS)];
    let runs = &problem.campaign.runs;
    let most =
        |value: fn(&Run) -> f64| runs.iter().map(value).fold(0.0, |a: f64, b| a.max(b.abs()));
    let (fastest, strongest) = (most(|r| r.belt_velocity), most(|r| r.normal_force));
    let points: Vec<(f64, f64)> = VELOCITIES
        .iter()
        .flat_map(|v| FORCES.map(|f| (rounded(v * fastest), rounded(f * strongest))))
        .collect();
    let prospects = parallel(&points, |&point| Prospect::new(problem, rivals, point))?;
    let mut open: Vec<((f64, f64), Prospect)> = points
        .into_iter()
        .zip(prospects)
        .filter_map(|(point, prospect)| Some((point, prospect?)))
        .filter(|(_, prospect)| prospect.separation >= TELLS)
        .collect();
    open.sort_by(|a, b| b.1.separation.total_cmp(&a.1.separation));
    let screen = Screen::new(problem);
    open.truncate((AFFORDED / screen.segments.len().max(1)).max(LEAST_POINTS));
    let gains = parallel(&open, |(_, prospect)| {
        prospect.gain(problem, &screen, rivals)
    })?;
    let best = open
        .iter()
        .zip(gains)
        .filter(|(_, gain)| *gain >= SURE)
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let mut separates: Vec<String> = rivals.iter().map(|r| name(problem, &r.choices)).collect();
    separates.dedup();
    Ok(best.map(
        |(&((velocity, force), ref prospect), gain)| NextMeasurement {
            // As a user would state it.
            belt_velocity_m_per_s: rounded(velocity / problem.belt_scale.value),
            normal_force_n: force,
            separates,
            separation: prospect.separation,
            expected_gain: gain,
        },
    ))
}

/// To two digits: nobody sets a rig closer.
fn rounded(value: f64) -> f64 {
    let digits = format!("{value:.1e}");
    digits.parse().expect("a number that was just written")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operating_points_are_given_to_two_digits() {
        for (value, digits) in [(0.123_4, 0.12), (78.4, 78.0), (0.009_96, 0.01)] {
            assert_eq!(rounded(value), digits, "{value}");
        }
    }
}
