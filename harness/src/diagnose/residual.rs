//! Where the calibrated model fails: by phase of the contact, operating point, frequency and place.

use super::dependence;
use super::judge::Judgement;
use super::session::Session;
use crate::observer::PhaseMode;
use serde_json::{Value, json};

/// Numbers of the places where the errors sit.
pub fn describe(session: &Session, fit: &Judgement, holdout: &Judgement) -> Value {
    json!({
        "by_phase": by_phase(session, fit),
        "by_operating_point": by_operating_point(session, fit, holdout),
        "unexplained_force": dependence::describe(session),
    })
}

/// Mean error over the noise of shots by what their run does most, and by the share of stick in the shot.
fn by_phase(session: &Session, fit: &Judgement) -> Value {
    let mut sums = [(0.0, 0.0); 3];
    for (&k, m) in fit.shots.iter().zip(&fit.mean_square) {
        let shot = &session.shots[k];
        let run = &session.campaign.runs[shot.run];
        let phases = &session.smoothings[shot.run].stick_slip.phases;
        let (start, end) = (
            shot.time[0] - run.time[0],
            shot.time[shot.time.len() - 1] - run.time[0],
        );
        let stick: f64 = phases
            .iter()
            .filter(|p| p.mode == PhaseMode::Stick)
            .map(|p| (p.end.min(end) - p.start.max(start)).max(0.0))
            .sum::<f64>()
            / (end - start);
        let class = if stick > 0.95 {
            0
        } else if stick > 0.05 {
            1
        } else {
            2
        };
        let error = (m / session.noise[shot.run].powi(2)).min(1e8).ln();
        sums[class].0 += error;
        sums[class].1 += 1.0;
    }
    let mean = |i: usize| {
        if sums[i].1 > 0.0 {
            (0.5 * sums[i].0 / sums[i].1).exp()
        } else {
            f64::NAN
        }
    };
    json!({ "stick": mean(0), "with_transitions": mean(1), "slip": mean(2), "unit": "geometric mean error over noise" })
}

fn by_operating_point(session: &Session, fit: &Judgement, holdout: &Judgement) -> Value {
    session
        .campaign
        .runs
        .iter()
        .enumerate()
        .map(|(r, run)| {
            let nrmse = if holdout.by_run[r].is_finite() { holdout.by_run[r] } else { fit.by_run[r] };
            json!({ "file": run.name, "belt_velocity_m_per_s": run.belt_velocity, "normal_force_n": run.normal_force, "nrmse": nrmse })
        })
        .collect()
}
