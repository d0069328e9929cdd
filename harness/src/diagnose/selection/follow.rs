//! Effects that are named by hand, one after another.

use crate::diagnose::initialisation::search_options::THOROUGH;
use crate::diagnose::model::belt_profile::is_profile;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::variants::variants;
use crate::diagnose::selection::as_given::as_given;
use crate::diagnose::selection::decision::log_prior;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::selection::screening::Screen;
use crate::diagnose::selection::windows::Lengths;
use crate::diagnose::stages;
use crate::error::Error;
use crate::watch::{Silent, Watch};

/// Adds the effects with these indices one after another, whether they help or not.
///
/// # Errors
/// An FMU that can't be run.
pub fn follow(problem: &Problem, effects: &[usize], watch: &dyn Watch) -> Result<Selection, Error> {
    let screen = Screen::new(problem);
    watch.stage(stages::REFERENCE);
    let (as_given, as_given_holdout, as_given_forecasts) = as_given(problem, &screen)?;
    let alone = screen.calibrate(1.0)?;
    let mut calibrated = alone.clone();
    let mut path: Vec<FittedModel> = Vec::new();
    watch.stage(stages::SINGLES);
    for (done, &effect) in effects.iter().enumerate() {
        if watch.stop() {
            break;
        }
        watch.step(&problem.catalogue[effect].id, done, effects.len());
        let base = path.last().unwrap_or(&calibrated);
        let jobs: Vec<Vec<Choice>> = variants(problem, effect)
            .into_iter()
            .map(|choice| base.choices.iter().cloned().chain([choice]).collect())
            .collect();
        let mut forms = screen.compete(&jobs, base, THOROUGH, &Silent(watch))?;
        screen.polish(&mut forms, &Silent(watch))?;
        screen.finish(&mut forms, &Silent(watch))?;
        // Beside an effect that is missing still, a fit to whole segments goes astray. Where the break-aways tell of the place,
        // friction scatters: no fit comes down to the noise on any length.
        let is_one_of_many = effects.len() > 1 && !problem.place_is_told();
        if is_one_of_many && !forms[0].reaches_floor() {
            let on_windows = Lengths::of(&screen).search(&jobs, base, &Silent(watch))?;
            screen.keep_better(&mut forms, on_windows);
        }
        if path.is_empty() {
            calibrated = screen.recalibrate(calibrated, &forms)?;
        }
        path.push(forms.swap_remove(0));
    }
    let explained = match path.last_mut() {
        // Where friction scatters nothing is compared on all segments.
        Some(last) if !problem.place_is_told() && !watch.stop() => {
            full_refit::stands(problem, last)?
        }
        last => last.map_or(calibrated.reaches_floor(), |last| last.reaches_floor()),
    };
    let is_profile_alone =
        path.len() == 1 && is_profile(&problem.catalogue[path[0].choices[0].effect]);
    Ok(Selection {
        as_given,
        as_given_holdout,
        as_given_forecasts,
        alone,
        calibrated,
        singles: Vec::new(),
        pairs: Vec::new(),
        untried: Vec::new(),
        tested: Vec::new(),
        by_break_aways: !explained && is_profile_alone && problem.place_is_told(),
        explained,
        beyond: None,
        is_incomplete: false,
        contradicted: None,
        stopped: path.len() < effects.len(),
        by_hand: true,
        path,
        threshold: -log_prior(problem, 1),
        by_chance: Vec::new(),
    })
}
