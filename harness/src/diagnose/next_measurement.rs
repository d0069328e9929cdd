//! Which operating point to measure next, where the data at hand can't tell effects apart.
//!
//! T-optimal design (Atkinson and Fedorov 1975): at each point a run is simulated by each of the rivals, from rest and
//! after its transient, with the sensor's noise; every other rival is judged on it as on a run kept out: friction level, offset, phases
//! and start states are its own, the common constants stay. The separation is the median error over the noise of the rival
//! that does best, and the point taken is the one where that is largest. (Predictions from the states of the measured runs would
//! promise much at points where the motion never comes to such states.) That the constants would move too, were they fitted
//! anew, is left out.

use super::contender::{Contender, name};
use super::fit::Fit;
use super::hypothesis::structure;
use super::judge::{self, Care};
use super::null::gaussian;
use super::outcome::NextMeasurement;
use super::predictor::{Point, Predictor};
use super::search::Trial;
use super::session::{Session, parallel};
use super::shot::Shot;
use super::unexplained::median;
use crate::error::Error;
use crate::measurement::{Campaign, Role, Run, Sampling};

/// Belt velocities that are tried, in units of the fastest run's.
const VELOCITIES: [f64; 4] = [0.25, 0.5, 0.8, 1.3];
/// Normal forces that are tried, in units of the largest run's.
const FORCES: [f64; 3] = [0.4, 0.75, 1.3];
/// Rivals that are told apart, the best ones.
const MOST_RIVALS: usize = 3;
/// Periods of the lowest mode until the transient has died down far enough, ...
const TRANSIENT: f64 = 10.0;
/// ... and horizons that are judged.
const HORIZONS: f64 = 8.0;
/// Distance in m at which a simulated motion is given up, beyond any beam's.
const FAR: f64 = 0.1;
/// Error over the noise below which a rival is not told apart.
const TELLS: f64 = 2.0;

/// The operating point that tells rivals apart best; `None` if there is nothing to tell apart or no point helps.
///
/// # Errors
/// An FMU that can't be run.
pub fn recommend(
    session: &Session,
    rivals: &[&Contender],
) -> Result<Option<NextMeasurement>, Error> {
    if rivals.len() < 2 {
        return Ok(None);
    }
    let rivals = &rivals[..rivals.len().min(MOST_RIVALS)];
    let runs = &session.campaign.runs;
    let most =
        |value: fn(&Run) -> f64| runs.iter().map(value).fold(0.0, |a: f64, b| a.max(b.abs()));
    let (fastest, strongest) = (most(|r| r.belt_velocity), most(|r| r.normal_force));
    let points: Vec<(f64, f64)> = VELOCITIES
        .iter()
        .flat_map(|v| FORCES.map(|f| (rounded(v * fastest), rounded(f * strongest))))
        .collect();
    let separations = parallel(&points, |&point| separation(session, rivals, point))?;
    let best = points
        .iter()
        .zip(separations)
        .filter(|(_, s)| *s >= TELLS)
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let mut separates: Vec<String> = rivals.iter().map(|r| name(session, &r.choices)).collect();
    separates.dedup();
    Ok(
        best.map(|(&(velocity, force), separation)| NextMeasurement {
            belt_velocity_m_per_s: velocity,
            normal_force_n: force,
            separates,
            separation,
        }),
    )
}

/// To two digits: nobody sets a rig closer.
fn rounded(value: f64) -> f64 {
    let digits = format!("{value:.1e}");
    digits.parse().expect("a number that was just written")
}

/// Least median error over the noise of any rival on a run simulated by another at a point; NaN if a motion can't be simulated
/// or judged there.
fn separation(session: &Session, rivals: &[&Contender], point: (f64, f64)) -> Result<f64, Error> {
    let mut least = f64::INFINITY;
    for truth in rivals {
        let Some(run) = simulated(session, truth, point)? else {
            return Ok(f64::NAN);
        };
        let campaign = Campaign {
            runs: vec![run],
            ..session.campaign.clone()
        };
        // A motion without cycles, or one that the observer refuses, tells nothing.
        let Ok(alone) = Session::new(session.fmu, &campaign) else {
            return Ok(f64::NAN);
        };
        for other in rivals.iter().filter(|o| o.effects() != truth.effects()) {
            let trial = carried(session, &alone, other)?;
            let judged = judge::held_out(&alone, &trial, Care::Thorough)?;
            let error = judged.quantile(0.5);
            if !error.is_finite() {
                return Ok(f64::NAN);
            }
            least = least.min(error);
        }
    }
    Ok(least)
}

/// The first run that a contender was fitted to, with which it simulates.
fn origin(session: &Session) -> usize {
    session.held_out.iter().position(|h| !h).unwrap_or(0)
}

/// A run as a contender has it at a point, from rest, without its transient; `None` if the motion can't be simulated.
fn simulated(
    session: &Session,
    truth: &Contender,
    (velocity, force): (f64, f64),
) -> Result<Option<Run>, Error> {
    let r = origin(session);
    let measured = &session.campaign.runs[r];
    let belt = velocity.copysign(measured.belt_velocity);
    let mut runs = session.campaign.runs.clone();
    runs[r] = Run {
        belt_velocity: belt,
        normal_force: force,
        displacement: vec![-FAR, FAR],
        ..measured.clone()
    };
    let modes = structure(session.fmu, &session.campaign.beam)?;
    let lowest = modes.modes().iter().map(|m| m.frequency_hz);
    let transient = TRANSIENT / lowest.fold(f64::INFINITY, f64::min);
    let h = measured.sample_interval();
    let skipped = (transient / h).round() as usize;
    let count = skipped + (HORIZONS * session.horizon / h).round() as usize;
    let hypothesis = &truth.trial.hypothesis;
    let mut state = vec![0.0; 2 * hypothesis.modes + hypothesis.extra_states.len()];
    state[1] = belt / modes.modes()[0].tip_value;
    let shot = Shot {
        run: r,
        first: 0,
        time: (0..count)
            .map(|k| measured.time[0] + h * k as f64)
            .collect(),
        measured: vec![0.0; count],
        trusted: vec![true; count],
        count,
        stuck: !hypothesis.has_memory,
        dwell: 0.0,
        travel: 0.0,
        travel_end: 0.0,
        state,
    };
    let mut predictor = Predictor::new(session.fmu, &session.references, &runs, hypothesis)?;
    let point = &truth.trial.fit.point;
    let mut out = Vec::new();
    let done = predictor.predict(
        &shot,
        &point.shared,
        &point.own[r],
        &shot.state,
        shot.stuck,
        count,
        1,
        &mut out,
    );
    if !matches!(done, Ok(true)) {
        return Ok(None);
    }
    let mut random = fastrand::Rng::with_seed(1);
    let noise = session.noise[r];
    let time: Vec<f64> = (0..count - skipped).map(|k| h * k as f64).collect();
    Ok(Some(Run {
        name: "simulated".into(),
        role: Some(Role::Holdout),
        sampling: Sampling::of(&time),
        time,
        displacement: out[skipped..]
            .iter()
            .map(|y| y + noise * gaussian(&mut random))
            .collect(),
        faults: Vec::new(),
        ..runs.swap_remove(r)
    }))
}

/// A contender as a hypothesis of the session with the simulated run alone, its level and offset believed near those found.
fn carried(session: &Session, alone: &Session, contender: &Contender) -> Result<Trial, Error> {
    let mut hypothesis = alone.hypothesis(&contender.choices)?;
    let (old, found) = (&contender.trial.hypothesis, &contender.trial.fit.point);
    let fitted = || (0..session.held_out.len()).filter(|&r| !session.held_out[r]);
    for knob in &mut hypothesis.own[0] {
        if knob.support.is_some() || knob.is_phase() || knob.prior_std == 0.0 {
            continue;
        }
        let mut values: Vec<f64> = fitted()
            .filter_map(|r| {
                let i = old.own[r].iter().position(|k| k.name == knob.name)?;
                Some(found.own[r][i])
            })
            .collect();
        if !values.is_empty() {
            knob.prior = knob.value(median(&mut values));
        }
    }
    let centre = Point::centre(&hypothesis, &[]);
    let fit = Fit {
        point: Point {
            shared: found.shared.clone(),
            ..centre
        },
        objective: f64::NAN,
        trimmed: f64::NAN,
        mean_square: Vec::new(),
        covariance: None,
    };
    Ok(Trial { hypothesis, fit })
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
