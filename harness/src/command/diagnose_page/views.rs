//! Two models side by side: the one before the effect and the one after, replayed over the same shots.

use std::collections::BTreeMap;

use super::samples::{Sample, samples};
use crate::diagnose::judge::Judgement;
use crate::diagnose::outcome::{Diagnosis, Verdict};
use crate::diagnose::replay::Replay;
use crate::diagnose::residual::replays;
use crate::diagnose::select::Selection;
use crate::diagnose::session::Session;
use crate::diagnose::steps::Step;
use crate::error::Error;
use crate::report::Colour;

/// Colour of the model before, and after.
pub const COLOURS: [Colour; 2] = [Colour::Orange, Colour::Blue];

/// One of the two models.
pub struct View {
    /// Its name in legends.
    pub name: String,
    /// Its predictions by shot; held-out ones where a run is kept out.
    pub replays: BTreeMap<usize, Replay>,
    /// Error of each run, held-out error where it is kept out (1).
    pub by_run: Vec<f64>,
}

/// Both, and what they say of each sample.
pub struct Views {
    /// Before, after.
    pub pair: [View; 2],
    /// Samples of the shots that both predict.
    pub samples: Vec<Sample>,
}

impl Views {
    /// Replays the models that the verdict rests on.
    ///
    /// Where nothing is missing these are the model as given and as calibrated; else the calibrated
    /// model and the last rung.
    pub fn new(
        session: &Session,
        selection: &Selection,
        steps: &[Step],
        diagnosis: &Diagnosis,
    ) -> Result<Views, Error> {
        let rung = |name: &str, i: usize| {
            let h = &steps[i].trial.hypothesis;
            view(session, name, h, &steps[i].fit, &steps[i].holdout)
        };
        let last = steps.len() - 1;
        let pair = if diagnosis.verdict == Verdict::NoMissingEffect || last == 0 {
            let plain = session.hypothesis(&[])?;
            let (fit, holdout) = (&selection.as_given, &selection.as_given_holdout);
            [
                view(session, "as given", &plain, fit, holdout)?,
                rung("calibrated", 0)?,
            ]
        } else {
            let step = diagnosis
                .error_ladder
                .last()
                .map_or("last", |r| r.step.as_str());
            let name = match diagnosis.verdict {
                Verdict::EffectFound if last == 1 => {
                    format!("with {}", step.trim_start_matches("+ "))
                }
                Verdict::EffectFound => "with the effects found".to_owned(),
                _ if selection.beyond.is_some() => {
                    format!("with {}", step.trim_start_matches("+ "))
                }
                _ => format!("best candidate ({step}), not believed"),
            };
            [rung("calibrated", 0)?, rung(&name, last)?]
        };
        let samples = samples(session, &pair);
        Ok(Views { pair, samples })
    }
}

fn view(
    session: &Session,
    name: &str,
    hypothesis: &crate::diagnose::hypothesis::Hypothesis,
    fit: &Judgement,
    holdout: &Judgement,
) -> Result<View, Error> {
    let replays = replays(session, hypothesis, fit, holdout)?;
    let by_run = fit
        .by_run
        .iter()
        .zip(&holdout.by_run)
        .map(|(f, h)| if h.is_finite() { *h } else { *f })
        .collect();
    Ok(View {
        name: name.to_owned(),
        replays,
        by_run,
    })
}
