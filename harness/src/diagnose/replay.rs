//! Predictions of shots where a judgement left the knobs and start states: for pictures, sample by sample.

use super::hypothesis::{Hypothesis, References};
use super::judge::Judgement;
use super::predictor::Predictor;
use super::session::{Session, parallel};
use super::shot::Shot;
use crate::error::Error;

/// The FMU's contact force, where it has one.
const FORCE: &str = "friction_force";

/// A shot as a model predicts it.
#[derive(Debug, Clone)]
pub struct Replay {
    /// Index of the shot in the session.
    pub shot: usize,
    /// Predicted displacement in m, one per sample; NaN once the prediction was given up.
    pub displacement: Vec<f64>,
    /// The model's contact force in N at the same times; NaN where it is not known.
    pub force: Vec<f64>,
}

/// Predicts every shot of a judgement at every sample.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn replay(
    session: &Session,
    hypothesis: &Hypothesis,
    judgement: &Judgement,
) -> Result<Vec<Replay>, Error> {
    let force = session.fmu.variable(FORCE).ok().map(|v| v.reference);
    let observed = observing(
        &session.references,
        force.unwrap_or(session.references.measured),
    );
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let places: Vec<usize> = (0..judgement.shots.len()).collect();
    let parts: Vec<&[usize]> = places
        .chunks(places.len().div_ceil(threads).max(1))
        .collect();
    let results = parallel(&parts, |part| {
        let runs = &session.campaign.runs;
        let mut motion = Predictor::new(session.fmu, &session.references, runs, hypothesis)?;
        let mut contact = Predictor::new(session.fmu, &observed, runs, hypothesis)?;
        let one = |&i: &usize| {
            let index = judgement.shots[i];
            let shot = &session.shots[index];
            let displacement = run_shot(&mut motion, shot, judgement, i);
            // Another output must not be compared with the measured displacement.
            let free = Shot {
                measured: vec![f64::NAN; shot.measured.len()],
                ..shot.clone()
            };
            let whole = displacement.last().is_some_and(|d| d.is_finite());
            let force = if whole && force.is_some() {
                run_shot(&mut contact, &free, judgement, i)
            } else {
                vec![f64::NAN; shot.time.len()]
            };
            Replay {
                shot: index,
                displacement,
                force,
            }
        };
        Ok(part.iter().map(one).collect::<Vec<Replay>>())
    })?;
    Ok(results.into_iter().flatten().collect())
}

/// One output over a shot, filled up with NaN where the FMU or the prediction gave up.
fn run_shot(
    predictor: &mut Predictor,
    shot: &Shot,
    judgement: &Judgement,
    place: usize,
) -> Vec<f64> {
    let point = &judgement.point;
    let mut out = Vec::with_capacity(shot.time.len());
    let own = &point.own[shot.run];
    // A state that the FMU can't start from leaves the picture empty at this shot.
    let _ = predictor.predict(
        shot,
        &point.shared,
        own,
        &point.states[place],
        point.stuck[place],
        shot.time.len(),
        1,
        &mut out,
    );
    out.resize(shot.time.len(), f64::NAN);
    out
}

/// The same names with another output in the place of the measured displacement.
fn observing(references: &References, output: u32) -> References {
    References {
        inputs: references.inputs,
        measured: output,
        contact_mode: references.contact_mode,
        contact: references.contact,
        start_effects: references.start_effects,
        mode_count: references.mode_count,
        tolerance: references.tolerance,
        history: references.history,
        states: references.states.clone(),
    }
}
