//! Which effect: every candidate is fitted, judged, and added one after another while it helps.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::{Care, FitOptions};
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::initialisation::search_options::THOROUGH;
use crate::diagnose::model::belt_profile::is_profile;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library::is_library_effect;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::variants::{all_variants, variants};
use crate::diagnose::selection::bootstrap;
use crate::diagnose::selection::decision::{decide, log_prior};
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::screening::Screen;
use crate::diagnose::selection::search::{Exploration, explore};
use crate::diagnose::selection::tested::Tested;
use crate::diagnose::selection::windows::Lengths;
use crate::diagnose::stages;
use crate::diagnose::validation::forecast::{Forecast, forecasts};
use crate::diagnose::validation::segment_errors;
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::{Silent, Watch};
use std::ops::Range;

/// Single effects that are judged on the runs kept out, the best ones.
const SINGLES_JUDGED: usize = 8;
/// Pairs that are listed, the best ones.
const PAIRS_LISTED: usize = 5;

/// Share of the squares that a pair removes which its first effect must remove alone to be named: the usual 95 %.
const MOST: f64 = 0.95;

/// Why a term beyond the catalogue stands at the end of a path.
pub struct Beyond {
    /// What explains the data too, but not as well; `None` where nothing else does.
    pub rival: Option<String>,
    /// How far its posterior is above that rival's, or the calibrated model's, nats.
    pub gain: f64,
}

/// A first answer that does not hold on the runs kept out of its fit.
pub struct Contradiction {
    /// The answer, in words.
    pub answer: String,
    /// The runs.
    pub runs: Vec<String>,
    /// Its error there over the noise, three segments in four.
    pub over_noise: f64,
}

/// All that a selection found.
pub struct Selection {
    /// The reference model with nominal values, judged with start states fitted.
    pub as_given: SegmentErrors,
    /// The same on what was kept out.
    pub as_given_holdout: SegmentErrors,
    /// Its forecasts of the runs kept out.
    pub as_given_forecasts: Vec<Forecast>,
    /// The reference model calibrated by itself: it depends on the campaign alone, not on what is tried.
    pub alone: FittedModel,
    /// The same, or where that is better, fitted again from the optimum of an effect: what effects are compared with, so that
    /// none seems to gain what the reference model could by itself.
    pub calibrated: FittedModel,
    /// Single effects, best first.
    pub singles: Vec<FittedModel>,
    /// Pairs tried, best first.
    pub pairs: Vec<FittedModel>,
    /// Names of the pairs that were compared to first order and not fitted; empty where something explains the data.
    pub untried: Vec<String>,
    /// Effects beside an adequate hypothesis that were tested and not fitted.
    pub tested: Vec<Tested>,
    /// The path from the calibrated model: one effect more each time.
    pub path: Vec<FittedModel>,
    /// Whether the last of the path (or the calibrated model) is down to the noise.
    pub explained: bool,
    /// Whether the path is believed for what the break-aways tell, though it does not come down to the noise.
    pub by_break_aways: bool,
    /// The term beyond the catalogue at the end of the path, if it needs one.
    pub beyond: Option<Beyond>,
    /// Whether the path ends with what explains most while something else is missing too
    /// ([`super::discrepancy`]).
    pub is_incomplete: bool,
    /// What was found first and did not hold on the runs kept out then, which are fitted now.
    pub contradicted: Option<Contradiction>,
    /// Whether it was stopped before its end.
    pub stopped: bool,
    /// Whether the effects were named by hand, so that no other was tried.
    pub by_hand: bool,
    /// Gain below which an effect counts as chance.
    pub threshold: f64,
    /// For each step of the path, the largest gains by chance in simulated campaigns; empty unless asked for.
    pub by_chance: Vec<Vec<f64>>,
}

impl Selection {
    /// The calibrated model of the error ladder: the one calibrated by itself, so that every command shows the same. Only where
    /// the better one explains the data it takes the place, since the verdict rests on it then.
    pub fn calibration(&self) -> &FittedModel {
        if self.calibrated.reaches_floor() {
            &self.calibrated
        } else {
            &self.alone
        }
    }

    /// Adds a last step, a term beyond the catalogue that was fitted after the search.
    pub(crate) fn go_on_with(&mut self, problem: &Problem, mut model: FittedModel) {
        if let Some(before) = self.path.last() {
            model.log_posterior = before.log_posterior + before.score() - model.score();
        }
        self.explained = model.reaches_floor();
        self.path.push(model);
        let (calibrated, singles) = (&self.calibrated, &self.singles);
        let beyond = beyond(problem, self.explained, &self.path, calibrated, singles);
        self.beyond = self.beyond.take().or(beyond);
    }

    /// Judges the best candidates on the runs kept out, briefly.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn judge_candidates(&mut self, problem: &Problem) -> Result<(), Error> {
        judge_candidates(
            problem,
            &self.calibrated,
            &mut self.singles,
            &mut self.pairs,
        )
    }

    /// Takes a path whose last hypothesis explains the data.
    pub(crate) fn explained_by(&mut self, problem: &Problem, path: Vec<FittedModel>) {
        self.beyond = beyond(problem, true, &path, &self.calibrated, &self.singles);
        self.path = path;
        self.explained = true;
        self.is_incomplete = false;
        self.untried.clear();
        // Gains by chance were those beside another path.
        self.by_chance.clear();
        self.threshold = -log_prior(problem, 1);
    }

    /// Takes the gains by chance into account, for each step of the path those of all simulated campaigns.
    pub fn judge_by_chance(&mut self, gains: Vec<Vec<f64>>) {
        let all = gains.iter().flatten().copied();
        self.threshold = all.fold(self.threshold, f64::max);
        self.by_chance = gains;
    }

    /// The effects that were named by hand, in words; `None` where the catalogue was searched.
    pub fn tried_by_hand(&self, problem: &Problem) -> Option<String> {
        if !self.by_hand {
            return None;
        }
        let tried = self.path.last().map(|c| name(problem, &c.choices));
        Some(tried.unwrap_or_else(|| "nothing".to_owned()))
    }

    /// Pairs that stand beside the single effects: the best ones, none where one effect is enough.
    pub fn listed_pairs(&self) -> &[FittedModel] {
        let one_is_enough = self.explained && self.path.len() < 2;
        let count = if one_is_enough { 0 } else { PAIRS_LISTED };
        &self.pairs[..self.pairs.len().min(count)]
    }
}

/// Compares the catalogue on a campaign.
///
/// # Errors
/// An FMU that can't be run.
pub fn select(problem: &Problem, watch: &dyn Watch) -> Result<Selection, Error> {
    let screen = Screen::new(problem);
    watch.stage(stages::REFERENCE);
    let (as_given, as_given_holdout, as_given_forecasts) = as_given(problem, &screen)?;
    let Exploration {
        alone,
        mut calibrated,
        mut singles,
        mut pairs,
        tested,
        untried,
        ..
    } = explore(problem, &screen, watch)?;
    let stopped = watch.stop();
    if stopped && watch.discards() {
        return Err(Error::Discarded);
    }
    watch.stage(stages::ALL_DATA);
    let mut all: Vec<&mut FittedModel> = std::iter::once(&mut calibrated)
        .chain(&mut singles)
        .chain(&mut pairs)
        .collect();
    let best = decide(problem, &mut all)?;
    let explained = best.is_some();
    let mut untried: Vec<String> = match explained {
        true => Vec::new(),
        false => untried
            .iter()
            .flatten()
            .map(|pair| name(problem, pair))
            .collect(),
    };
    // Forms of an effect have one name.
    untried.dedup();
    let mut path = match best {
        Some(0) => Vec::new(),
        Some(i) if i <= singles.len() => vec![singles.remove(i - 1)],
        Some(i)
            if explains_most(
                problem,
                &calibrated,
                &singles,
                &pairs[i - 1 - singles.len()],
            ) =>
        {
            let known = &pairs[i - 1 - singles.len()].choices[..1];
            let place = singles.iter().position(|s| s.choices == known);
            vec![singles.remove(place.expect("it explains most"))]
        }
        Some(i) => {
            let pair = pairs.remove(i - 1 - singles.len());
            let first = singles.iter().position(|s| s.choices[0] == pair.choices[0]);
            let first = first.map(|i| singles.remove(i));
            first.into_iter().chain([pair]).collect()
        }
        // What helps most, to show how far it goes.
        None if singles
            .first()
            .is_some_and(|s| s.score() < calibrated.score()) =>
        {
            vec![singles.remove(0)]
        }
        None => Vec::new(),
    };
    judge_candidates(problem, &calibrated, &mut singles, &mut pairs)?;
    let list = all_variants(problem);
    let profile = list
        .iter()
        .find(|c| is_profile(&problem.catalogue[c.effect]));
    let by_break_aways = match profile {
        Some(choice) if !explained && !stopped && problem.place_is_told() => {
            let jobs = [vec![choice.clone()]];
            let mut found = screen.compete(&jobs, &calibrated, THOROUGH, &Silent(watch))?;
            screen.polish(&mut found, &Silent(watch))?;
            calibrated = screen.recalibrate(calibrated, &found)?;
            singles.extend(path);
            singles.retain(|s| s.choices != jobs[0]);
            screen.sort(&mut singles);
            path = found;
            true
        }
        _ => false,
    };
    let beyond = beyond(problem, explained, &path, &calibrated, &singles);
    Ok(Selection {
        as_given,
        as_given_holdout,
        as_given_forecasts,
        alone,
        calibrated,
        singles,
        pairs,
        untried,
        tested,
        path,
        explained,
        by_break_aways,
        is_incomplete: false,
        beyond,
        contradicted: None,
        stopped,
        by_hand: false,
        threshold: -log_prior(problem, 1),
        by_chance: Vec::new(),
    })
}

/// Whether the effect of the catalogue that leads a pair is adequate alone and what an effect of the library adds is small: then the
/// first is named, as every hypothesis that counts has it.
fn explains_most(
    problem: &Problem,
    calibrated: &FittedModel,
    singles: &[FittedModel],
    pair: &FittedModel,
) -> bool {
    let is_of_library = |c: &Choice| is_library_effect(&problem.catalogue[c.effect].id);
    let [first, second] = &pair.choices[..] else {
        return false;
    };
    if is_of_library(first) || !is_of_library(second) {
        return false;
    }
    let squares = |model: &FittedModel| model.fit.nrmse.powi(2);
    let mut alone = singles.iter().filter(|s| s.choices[..] == [first.clone()]);
    alone.any(|single| {
        let explained = squares(calibrated) - squares(single);
        single.reaches_floor() && explained > MOST * (squares(calibrated) - squares(pair))
    })
}

/// What is beyond the catalogue in a hypothesis that explains the data: a term at the end of its path.
fn beyond(
    problem: &Problem,
    explained: bool,
    path: &[FittedModel],
    calibrated: &FittedModel,
    singles: &[FittedModel],
) -> Option<Beyond> {
    let best = path.last().filter(|_| explained)?;
    let has_library_effect = |c: &FittedModel| {
        let mut effects = c.choices.iter().map(|choice| choice.effect);
        effects.any(|e| is_library_effect(&problem.catalogue[e].id))
    };
    if !has_library_effect(best) {
        return None;
    }
    let rival = std::iter::once(calibrated)
        .chain(singles)
        .filter(|c| c.reaches_floor() && !has_library_effect(c))
        .max_by(|a, b| a.log_posterior.total_cmp(&b.log_posterior));
    Some(Beyond {
        rival: rival.map(|r| match r.choices.is_empty() {
            true => "the calibrated model".to_owned(),
            false => name(problem, &r.choices),
        }),
        gain: best.log_posterior - rival.unwrap_or(calibrated).log_posterior,
    })
}

/// Simulates `count` campaigns without the effect for each step of a selection's path (for the calibrated model where the
/// path is empty) and raises the threshold to the largest gain by chance, where that is more.
///
/// # Errors
/// An FMU that can't be run.
pub fn calibrate_threshold(
    problem: &Problem,
    selection: &mut Selection,
    count: usize,
    watch: &dyn Watch,
) -> Result<(), Error> {
    let gains = gains_by_chance(problem, selection, 0..count, watch)?;
    selection.judge_by_chance(gains);
    Ok(())
}

/// The largest gains by chance for each step of the path, in those of the simulated campaigns that `which` numbers.
///
/// # Errors
/// An FMU that can't be run.
pub fn gains_by_chance(
    problem: &Problem,
    selection: &Selection,
    which: Range<usize>,
    watch: &dyn Watch,
) -> Result<Vec<Vec<f64>>, Error> {
    let steps = 0..selection.path.len().max(1);
    let of_step = |search: usize| {
        let base = match search {
            0 => &selection.calibrated,
            _ => &selection.path[search - 1],
        };
        bootstrap::largest_gains(problem, base, which.clone(), watch)
    };
    steps.map(of_step).collect()
}

/// Judges the best candidates on the runs kept out, briefly; not those that fit worse than the reference model.
///
/// # Errors
/// An FMU that can't be run.
fn judge_candidates(
    problem: &Problem,
    calibrated: &FittedModel,
    singles: &mut [FittedModel],
    pairs: &mut [FittedModel],
) -> Result<(), Error> {
    let listed = pairs.len().min(PAIRS_LISTED);
    let mut all: Vec<&mut FittedModel> = singles
        .iter_mut()
        .take(SINGLES_JUDGED)
        .chain(&mut pairs[..listed])
        .filter(|c| !calibrated.is_before(c))
        .collect();
    let all_fitted: Vec<&FittedHypothesis> = all.iter().map(|c| &c.fitted).collect();
    let judgements = parallel(&all_fitted, |fitted| {
        segment_errors::held_out(problem, fitted, Care::Brief)
    })?;
    for (model, judgement) in all.iter_mut().zip(judgements) {
        model.holdout = Some(judgement);
    }
    Ok(())
}

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
    let explained = path.last().unwrap_or(&calibrated).reaches_floor();
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

/// The reference model with its nominal values.
fn as_given(
    problem: &Problem,
    screen: &Screen,
) -> Result<(SegmentErrors, SegmentErrors, Vec<Forecast>), Error> {
    let h = problem.hypothesis(&[])?;
    let mut predictor = problem.predictor(&h)?;
    let options = FitOptions::search(5);
    let segments = &screen.segments;
    let data = problem.data(segments);
    let fit = Fitter::new(&mut predictor, &h, &data, options)
        .fit_initial_states(Point::centre(&h, segments));
    let on_fit = segment_errors::of_fit(problem, &screen.indices, &fit);
    let (_, test) = segment_errors::held_out_segments(problem);
    let test_segments = problem.copies(&test);
    let data = problem.data(&test_segments);
    let on_test = Fitter::new(&mut predictor, &h, &data, options)
        .fit_initial_states(Point::centre(&h, &test_segments));
    drop(predictor);
    let fitted = FittedHypothesis { hypothesis: h, fit };
    let forecasts = forecasts(problem, &fitted)?;
    Ok((
        on_fit,
        segment_errors::of_fit(problem, &test, &on_test),
        forecasts,
    ))
}
