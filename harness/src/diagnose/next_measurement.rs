//! Which operating point to measure next, where the data at hand can't tell effects apart.
//!
//! T-optimal design (Atkinson and Fedorov 1975): every rival is fitted to the data at hand first; then the point is
//! taken where the predictions of the most alike two differ most. Predictions start from the same states, those of
//! the measured shots, and run over twice the horizon; their difference is the root mean square over the noise, the
//! median over the starts. Friction level and phases are those of the run that a start comes from.

use super::contender::Contender;
use super::outcome::NextMeasurement;
use super::predictor::Predictor;
use super::session::{Session, parallel};
use super::shot::Shot;
use crate::error::Error;
use crate::measurement::Run;

/// Belt velocities that are tried, in units of the fastest run's.
const VELOCITIES: [f64; 6] = [0.15, 0.3, 0.5, 0.75, 1.0, 1.3];
/// Normal forces that are tried, in units of the largest run's.
const FORCES: [f64; 5] = [0.3, 0.5, 0.75, 1.0, 1.3];
/// Starts for each point.
const STARTS: usize = 12;

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
    let runs = &session.campaign.runs;
    let most =
        |value: fn(&Run) -> f64| runs.iter().map(value).fold(0.0, |a: f64, b| a.max(b.abs()));
    let (fastest, strongest) = (most(|r| r.belt_velocity), most(|r| r.normal_force));
    let points: Vec<(f64, f64)> = VELOCITIES
        .iter()
        .flat_map(|v| FORCES.map(|f| (v * fastest, f * strongest)))
        .collect();
    let separations = parallel(&points, |&point| separation(session, rivals, point))?;
    let best = points
        .iter()
        .zip(separations)
        .filter(|(_, s)| s.is_finite())
        .max_by(|a, b| a.1.total_cmp(&b.1));
    Ok(
        best.map(|(&(velocity, force), separation)| NextMeasurement {
            belt_velocity_m_per_s: rounded(velocity),
            normal_force_n: rounded(force),
            separates: rivals
                .iter()
                .map(|r| super::contender::name(session, &r.choices))
                .collect(),
            separation,
        }),
    )
}

/// To two digits: nobody sets a rig closer.
fn rounded(value: f64) -> f64 {
    let unit = 10f64.powf(value.abs().max(1e-12).log10().floor() - 1.0);
    (value / unit).round() * unit
}

/// Difference over the noise of the two rivals that are most alike at a point.
fn separation(
    session: &Session,
    rivals: &[&Contender],
    (velocity, force): (f64, f64),
) -> Result<f64, Error> {
    let runs: Vec<Run> = session
        .campaign
        .runs
        .iter()
        .map(|run| Run {
            belt_velocity: rounded(velocity).copysign(run.belt_velocity),
            normal_force: rounded(force),
            ..run.clone()
        })
        .collect();
    let shots = &rivals[0].fit.shots;
    let every = shots.len().div_ceil(STARTS).max(1);
    let chosen: Vec<usize> = (0..shots.len()).step_by(every).collect();
    let mut motions: Vec<Vec<Option<Vec<f64>>>> = Vec::new();
    for rival in rivals {
        let h = &rival.trial.hypothesis;
        let mut predictor = Predictor::new(session.fmu, &session.references, &runs, h)?;
        let modal = 2 * h.modes;
        let mut of_rival = Vec::new();
        for &i in &chosen {
            let shot = stretched(session, shots[i]);
            // The same modal state for all; effects' own states at rest.
            let mut state = rivals[0].trial.fit.point.states[i][..modal].to_vec();
            state.resize(modal + h.extra_states.len(), 0.0);
            let point = &rival.trial.fit.point;
            let mut out = Vec::new();
            let done = predictor.predict(
                &shot,
                &point.shared,
                &point.own[shot.run],
                &state,
                false,
                shot.time.len(),
                1,
                &mut out,
            );
            of_rival.push(matches!(done, Ok(true)).then_some(out));
        }
        motions.push(of_rival);
    }
    let mut least = f64::INFINITY;
    for a in 0..rivals.len() {
        for b in 0..a {
            let mut differences: Vec<f64> = motions[a]
                .iter()
                .zip(&motions[b])
                .zip(&chosen)
                .filter_map(|((x, y), &i)| {
                    let (x, y) = (x.as_ref()?, y.as_ref()?);
                    let sum: f64 = x.iter().zip(y).map(|(p, q)| (p - q).powi(2)).sum();
                    let noise = session.noise[session.shots[shots[i]].run];
                    Some((sum / x.len() as f64).sqrt() / noise)
                })
                .collect();
            differences.sort_by(f64::total_cmp);
            let middle = differences.get(differences.len() / 2);
            least = least.min(middle.copied().unwrap_or(f64::NAN));
        }
    }
    Ok(least)
}

/// A shot of twice the horizon that is compared with nothing.
fn stretched(session: &Session, index: usize) -> Shot {
    let shot = &session.shots[index];
    let h = session.campaign.runs[shot.run].sample_interval();
    let count = (2.0 * session.horizon / h).round() as usize;
    let start = shot.time[0];
    Shot {
        time: (0..count).map(|k| start + h * k as f64).collect(),
        measured: vec![0.0; count],
        trusted: vec![true; count],
        count,
        ..shot.clone()
    }
}
