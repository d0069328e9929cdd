//! Two models side by side: the one before the effect and the one after, replayed over the same segments.

use std::collections::BTreeMap;

use super::samples::{Sample, samples};
use crate::diagnose::explanation::replay::Replay;
use crate::diagnose::explanation::residual::replays;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::result::diagnosis::{Diagnosis, Verdict};
use crate::diagnose::result::error_ladder::Step;
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::error::Error;
use crate::report::Colour;

/// Colour of the model before, and after.
pub const COLOURS: [Colour; 2] = [Colour::Orange, Colour::Blue];

/// One of the two models.
pub struct View {
    /// Its name in legends.
    pub name: String,
    /// Its predictions by segment; held-out ones where a run is kept out.
    pub replays: BTreeMap<usize, Replay>,
    /// Error of each run, held-out error where it is kept out (1).
    pub by_run: Vec<f64>,
}

/// Both, and what they say of each sample.
pub struct Views {
    /// Before, after.
    pub pair: [View; 2],
    /// Samples of the segments that both predict.
    pub samples: Vec<Sample>,
}

impl Views {
    /// Replays the models that the verdict rests on.
    ///
    /// Where nothing is missing these are the model as given and as calibrated; else the calibrated
    /// model and the last rung.
    pub fn new(
        problem: &Problem,
        selection: &Selection,
        steps: &[Step],
        diagnosis: &Diagnosis,
    ) -> Result<Views, Error> {
        let rung = |name: &str, i: usize| {
            let h = &steps[i].fitted.hypothesis;
            view(problem, name, h, &steps[i].fit, &steps[i].holdout)
        };
        let last = steps.len() - 1;
        let pair = if diagnosis.verdict == Verdict::NoMissingEffect || last == 0 {
            let plain = problem.hypothesis(&[])?;
            let (fit, holdout) = (&selection.as_given, &selection.as_given_holdout);
            [
                view(problem, "as given", &plain, fit, holdout)?,
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
        let samples = samples(problem, &pair);
        Ok(Views { pair, samples })
    }
}

fn view(
    problem: &Problem,
    name: &str,
    hypothesis: &crate::diagnose::model::hypothesis::Hypothesis,
    fit: &SegmentErrors,
    holdout: &SegmentErrors,
) -> Result<View, Error> {
    let replays = replays(problem, hypothesis, fit, holdout)?;
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
