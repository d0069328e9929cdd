//! Where the calibrated model fails: by phase of the contact, operating point, frequency and place.

use crate::diagnose::data::break_away::BreakAways;
use crate::diagnose::data::contact_phase::ContactPhase;
use crate::diagnose::explanation::dependence;
use crate::diagnose::explanation::misses::{Miss, misses};
use crate::diagnose::explanation::replay::{Replay, replay};
use crate::diagnose::explanation::spectrum::median_over_noise;
use crate::diagnose::explanation::where_it_fails::WhereItFails;
use crate::diagnose::model::belt_profile::Track;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::error::Error;
use crate::metric::median;
use crate::observer::PhaseMode;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Stretches of belt travel that each run is divided into.
const STRETCHES: usize = 16;

/// Numbers of the places where the errors sit.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn describe(
    problem: &Problem,
    hypothesis: &Hypothesis,
    fit: &SegmentErrors,
    holdout: &SegmentErrors,
    break_aways: &[BreakAways],
) -> Result<Value, Error> {
    let replays = replays(problem, hypothesis, fit, holdout)?;
    let misses = misses(problem, &replays);
    let over_noise: Vec<Value> = median_over_noise(problem, &replays)
        .into_iter()
        .map(|(frequency, ratio)| json!({ "frequency_hz": frequency, "over_noise": ratio }))
        .collect();
    Ok(json!({
        "by_phase": by_phase(problem, fit),
        "by_moment": by_contact_phase(&misses),
        "by_operating_point": by_operating_point(problem, fit, holdout),
        "by_frequency": over_noise,
        "by_belt_position": by_belt_position(problem, &misses),
        "unexplained_force": dependence::describe(problem),
        "break_away": break_aways,
        "statements": WhereItFails::new(problem, &replays).json(),
    }))
}

/// The predictions of all segments, by segment; those of runs kept out where there are both.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn replays(
    problem: &Problem,
    hypothesis: &Hypothesis,
    fit: &SegmentErrors,
    holdout: &SegmentErrors,
) -> Result<BTreeMap<usize, Replay>, Error> {
    let mut out = BTreeMap::new();
    for judgement in [fit, holdout] {
        for replayed in replay(problem, hypothesis, judgement)? {
            out.insert(replayed.segment, replayed);
        }
    }
    Ok(out)
}

fn middle<'a>(misses: impl Iterator<Item = &'a Miss>) -> f64 {
    median(&mut misses.map(|m| m.size).collect::<Vec<f64>>())
}

fn by_contact_phase(misses: &[Miss]) -> Value {
    let of = |moments: &[ContactPhase]| {
        middle(misses.iter().filter(|m| moments.contains(&m.contact_phase)))
    };
    json!({
        "stick": of(&[ContactPhase::Stick]),
        "break_away": of(&[ContactPhase::BreakAway]),
        "slip": of(&[ContactPhase::Accelerating, ContactPhase::Decelerating]),
        "arrival": of(&[ContactPhase::Arrival]),
        "unit": "median error of the samples over noise",
    })
}

fn by_belt_position(problem: &Problem, misses: &[Miss]) -> Vec<Value> {
    let mut out = Vec::new();
    for (r, run) in problem.campaign.runs.iter().enumerate() {
        let &Track { low, high, .. } = &problem.tracks[r];
        let width = (high - low) / STRETCHES as f64;
        for i in 0..STRETCHES {
            let (from, to) = (low + width * i as f64, low + width * (i + 1) as f64);
            let here = |m: &&Miss| m.run == r && (from..to).contains(&m.travel);
            let over_noise = middle(misses.iter().filter(here));
            if over_noise.is_finite() {
                out.push(json!({ "file": run.name, "from_m": from, "to_m": to, "over_noise": over_noise }));
            }
        }
    }
    out
}

/// Mean error over the noise of segments by what their run does most, and by the share of stick in the segment.
fn by_phase(problem: &Problem, fit: &SegmentErrors) -> Value {
    let mut sums = [(0.0, 0.0); 3];
    for (&k, m) in fit.segments.iter().zip(&fit.mean_square) {
        let segment = &problem.segments[k];
        let run = &problem.campaign.runs[segment.run];
        let phases = &problem.smoothings[segment.run].stick_slip.phases;
        let (start, end) = (
            segment.time[0] - run.time[0],
            segment.time[segment.time.len() - 1] - run.time[0],
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
        let error = (m / problem.noise[segment.run].powi(2)).min(1e8).ln();
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

fn by_operating_point(problem: &Problem, fit: &SegmentErrors, holdout: &SegmentErrors) -> Value {
    problem
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
