//! A diagnosis in words.

use super::beyond_catalogue::{argument_in_words, place_in_words};
use crate::diagnose::data::break_away::BreakAways;
use crate::diagnose::explanation::proposed_term::ProposedTerm;
use crate::diagnose::model::library::{FORMULA_PREFIX, is_library_effect};
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::is_unknown_function;
use crate::diagnose::result::diagnosis::{FoundEffect, Rung, Verdict};
use crate::diagnose::selection::outcome::{Beyond, Selection};
use crate::diagnose::selection::ties::others;
use crate::diagnose::thresholds::{FLOOR_MEDIAN, MOST_SPECTRAL_RATIO};
use crate::diagnose::validation::estimate::Estimate;
use crate::diagnose::validation::prior_conflict::PriorConflict;
use crate::diagnose::validation::segment_errors::{SegmentErrors, UnmetRun};
use crate::fmu::effect_card::EffectCard;
use crate::report::percent;

/// A value with its 95 % interval, if it has one: `name = value +- half width unit (95 %)`.
fn with_interval(name: &str, estimate: &Estimate) -> String {
    let unit = match estimate.unit.as_str() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    match estimate.half_width() {
        Some(half) => format!("{name} = {:.4e} +- {half:.1e}{unit} (95 %)", estimate.value),
        None => format!("{name} = {}{unit}", estimate.value),
    }
}

/// Share of the error on runs kept out that an effect must remove to be mentioned although it is not all.
const HELPS: f64 = 0.3;

/// What the effects of the ladder remove of a misfit that they do not explain, run by run; empty if that is little.
fn helps(problem: &Problem, ladder: &[Rung]) -> String {
    let Some((calibrated, effects)) = ladder.get(1..).and_then(|rungs| rungs.split_first()) else {
        return String::new();
    };
    let Some(last) = effects.last() else {
        return String::new();
    };
    let overall = 1.0 - last.holdout_nrmse / calibrated.holdout_nrmse;
    if !(overall >= HELPS) {
        return String::new();
    }
    let titled = |rung: &Rung| {
        let id = rung.step.trim_start_matches("+ ");
        let card = problem.catalogue.iter().find(|c| c.id == id);
        let curve = problem.unknown_functions.iter().find(|f| f.id == id);
        match (curve, card) {
            (Some(curve), _) => format!(
                "{id} (an unknown function of {} that acts on {})",
                argument_in_words(curve.argument),
                place_in_words(curve.place)
            ),
            (None, Some(card)) => format!("{id} ({})", card.title),
            (None, None) => id.to_owned(),
        }
    };
    let names: Vec<String> = effects.iter().map(titled).collect();
    format!(
        " {} of it is explained by {}: the error on what was kept out falls by {:.0} %, from {} to {} ({}). {:.1} times the sensor noise remains: something else is missing too.",
        if overall >= 0.5 { "Most" } else { "Part" },
        names.join(" and "),
        100.0 * overall,
        percent(calibrated.holdout_nrmse),
        percent(last.holdout_nrmse),
        falls_by_run(problem, calibrated, last),
        last.holdout_over_noise
    )
}

/// Fall of the error from one rung to another, run by run.
fn falls_by_run(problem: &Problem, before: &Rung, after: &Rung) -> String {
    let errors = before.by_run.iter().zip(&after.by_run);
    let runs: Vec<String> = problem
        .campaign
        .runs
        .iter()
        .zip(errors)
        .map(|(run, (a, b))| format!("{} {:.0} %", run.name, 100.0 * (1.0 - b / a)))
        .collect();
    runs.join(", ")
}

/// Mean fall of the error of predicting break-aways over the runs that is worth a word: less is seen where nothing is
/// there, as the force just before a transition is known roughly only.
const FORETELLS: f64 = 0.2;

/// What the break-aways of a campaign depend on that no effect explains; empty where nothing foretells them.
fn foretold(break_aways: &[BreakAways]) -> String {
    let told = |b: &&BreakAways| b.fall_by_place.is_finite();
    let all: Vec<&BreakAways> = break_aways.iter().filter(told).collect();
    let mean = |fall: fn(&BreakAways) -> f64| {
        all.iter().map(|b| fall(b).max(0.0)).sum::<f64>() / all.len() as f64
    };
    let percent = |fall: f64| format!("{:.0} %", 100.0 * fall);
    let mut out = String::new();
    if mean(|b| b.fall_by_place) >= FORETELLS {
        let runs: Vec<String> = all
            .iter()
            .map(|b| format!("{} {}", b.file, percent(b.fall_by_place)))
            .collect();
        out += &format!(
            " The force at break-away depends on the place on the belt (or on time, where each place is passed once): the place takes away so much of the error of predicting each from the others of its run: {}.",
            runs.join(", ")
        );
    }
    let (dwell, foretold) = (
        mean(|b| b.fall_by_dwell),
        mean(|b| b.fall_by_dwell_foretold),
    );
    if foretold >= FORETELLS {
        out += &format!(
            " Break-away grows with the dwell predicted at stick onset (it removes {} of the error), as ageing predicts.",
            percent(foretold)
        );
    } else if dwell >= FORETELLS || !out.is_empty() {
        out += &format!(
            " Dwell takes away {} of that error; but a high threshold makes a long stick by itself, and what is known when a stick begins takes away {}: that contacts age can't be concluded.",
            percent(dwell),
            percent(foretold)
        );
    }
    out
}

/// Errors below this many times the noise look like noise by their size.
const NEARLY_NOISE: f64 = 1.5;

/// What the words are about.
pub(crate) struct Seen<'a> {
    /// The error ladder.
    pub ladder: &'a [Rung],
    /// Colour of what each model leaves.
    pub spectral_ratio: &'a [f64],
    /// A constant of the structure that the model which explains the data had to bend.
    pub prior_conflict: Option<&'a PriorConflict>,
    /// Terms proposed.
    pub proposed: &'a [ProposedTerm],
}

/// What was found and how sure it is, in plain words.
pub(crate) fn words(
    problem: &Problem,
    verdict: Verdict,
    effects: &[FoundEffect],
    seen: &Seen,
    selection: &Selection,
) -> String {
    let ladder = seen.ladder;
    let break_aways = &problem.break_aways;
    let stopped = &selection.stopped;
    let by_hand = selection.tried_by_hand(problem);
    let last = ladder.last().expect("the ladder has its first rung");
    let calibrated = &ladder[1.min(ladder.len() - 1)];
    match verdict {
        Verdict::EffectFound => {
            let names: Vec<String> = effects
                .iter()
                .map(|e| {
                    let title = problem
                        .catalogue
                        .iter()
                        .find(|c| c.id == e.id)
                        .map_or("", |c| c.title.as_str());
                    let values: Vec<String> = e
                        .parameters
                        .iter()
                        .map(|(n, p)| with_interval(n, p))
                        .collect();
                    let known: Vec<&str> = std::iter::once(title)
                        .chain(values.iter().map(String::as_str))
                        .collect();
                    format!("{} ({})", e.id, known.join("; "))
                })
                .collect();
            if selection.by_break_aways {
                return format!(
                    "Missing: {}, by the break-aways.{} The error of the motion on runs kept out of the fit falls from {} to {} (run by run, fitted ones included, it falls by: {}). That is not all: {:.1} times the sensor noise remains, which {}. To separate place from time, pass the same track twice; to see ageing, slide, hold, and slide again.",
                    names.join(" and "),
                    foretold(break_aways),
                    percent(calibrated.holdout_nrmse),
                    percent(last.holdout_nrmse),
                    falls_by_run(problem, calibrated, last),
                    last.holdout_over_noise,
                    match by_hand {
                        Some(_) => "is more than noise; no other effect was tried",
                        None => "no effect of the catalogue removes",
                    }
                );
            }
            let mut ties: Vec<&str> = Vec::new();
            for tie in effects.iter().flat_map(|e| &e.confounded_with) {
                if !ties.contains(&tie.as_str()) {
                    ties.push(tie);
                }
            }
            let told = match ties.is_empty() {
                true => String::new(),
                false => format!(
                    "These data can't distinguish it from: {}. ",
                    ties.join(", ")
                ),
            };
            let sure = told + &others(problem, selection);
            format!(
                "Missing: {}. The error on runs kept out of the fit falls from {} to {}; what remains is {:.2} times the sensor noise. {sure}",
                names.join(" and "),
                percent(calibrated.holdout_nrmse),
                percent(last.holdout_nrmse),
                last.holdout_over_noise
            )
        }
        Verdict::NoMissingEffect => format!(
            "Nothing is missing: the calibrated model explains the data down to {:.2} times the sensor noise, and {} by more than chance.",
            calibrated.holdout_over_noise,
            match by_hand {
                Some(tried) => format!("{tried}, all that was tried, does not improve it"),
                None => "no candidate improves it".to_owned(),
            }
        ),
        Verdict::UnknownEffect => {
            if let Some(beyond) = &selection.beyond {
                return match seen.proposed.first().filter(|term| term.fitted) {
                    Some(_) => {
                        let parts = Parts::of(problem, selection, seen.proposed);
                        beyond_words(beyond, &parts, calibrated, last)
                    }
                    None => curve_words(calibrated, last),
                };
            }
            if let Some(prior_conflict) = seen
                .prior_conflict
                .filter(|_| last.holdout_over_noise < NEARLY_NOISE)
            {
                return format!(
                    "{} is missing, or the structure is not as stated: the residual falls to {:.2} times the sensor noise, but only with {} = {:.5} {}, where the campaign says {:.5} {}, {:.1} standard deviations of what modal analysis is believed to miss. What is missing has been taken up there. If the structure's data are that rough, correct them in campaign.toml and diagnose again.",
                    match by_hand {
                        Some(tried) => format!("Something other than what was tried ({tried})"),
                        None => "Something outside the catalogue".to_owned(),
                    },
                    last.holdout_over_noise,
                    prior_conflict.name,
                    prior_conflict.fitted,
                    prior_conflict.unit,
                    prior_conflict.believed,
                    prior_conflict.unit,
                    prior_conflict.deviations
                );
            }
            let left = seen.spectral_ratio.last().copied().unwrap_or(f64::NAN);
            let near = if last.holdout_over_noise < NEARLY_NOISE && left > MOST_SPECTRAL_RATIO {
                format!(
                    " The last step of the ladder comes to {:.2} times the sensor noise, but what it leaves is not white as noise is: its low frequencies have {left:.2} times the power of its high ones.",
                    last.holdout_over_noise
                )
            } else {
                String::new()
            };
            if let Some(tried) = by_hand {
                return format!(
                    "What was tried by hand ({tried}) does not explain the data: after calibration {:.1} times the sensor noise remains, and {:.1} times with all that was tried. No other effect was tried; `diagnose` searches the catalogue.{near}{}{}",
                    calibrated.holdout_over_noise,
                    last.holdout_over_noise,
                    helps(problem, ladder),
                    foretold(break_aways)
                );
            }
            let tried = if *stopped {
                "The search was stopped, so this is not decided: after calibration"
            } else {
                "Something outside the catalogue is missing: after calibration"
            };
            let without = if *stopped {
                "none of the candidates tried so far removes it"
            } else {
                "no effect of the catalogue, nor two of them, removes it"
            };
            format!(
                "{tried} {:.1} times the sensor noise remains, and {without}.{near}{}{}",
                calibrated.holdout_over_noise,
                helps(problem, ladder),
                foretold(break_aways)
            )
        }
    }
}

/// That the last step of the ladder does not meet some runs, where it is down to the noise on most segments.
pub(crate) fn unmet_words(problem: &Problem, fit: &SegmentErrors) -> String {
    if !(fit.quantile(0.5) <= FLOOR_MEDIAN) {
        return String::new();
    }
    let of_run = |unmet: &UnmetRun| {
        let what = unmet.words(problem);
        format!("{what} ({:.1} times the noise)", unmet.over_noise)
    };
    let runs: Vec<String> = fit.unmet_runs.iter().map(of_run).collect();
    match runs.is_empty() {
        true => String::new(),
        false => format!(
            " The last step of the ladder is down to the sensor noise on most of what was fitted, but does not meet {}.",
            runs.join(", ")
        ),
    }
}

/// That the data ask for a curve for which there is no short formula.
fn curve_words(calibrated: &Rung, last: &Rung) -> String {
    format!(
        "Something outside the catalogue is missing: no named effect removes the misfit, but an unknown function of one quantity does. With it the error on runs kept out of the fit falls from {} to {}, {:.2} times the sensor noise; unknown.toml is ready for `pack --effect` and `try`.",
        percent(calibrated.holdout_nrmse),
        percent(last.holdout_nrmse),
        last.holdout_over_noise
    )
}

/// The effects of a hypothesis that reaches beyond the catalogue, each with its title.
struct Parts {
    /// Those of the catalogue.
    named: Vec<String>,
    /// Those of the library and formulas in place of curves, with what was fitted.
    beyond: Vec<String>,
    /// Files with which they can be tried.
    files: Vec<String>,
}

impl Parts {
    fn of(problem: &Problem, selection: &Selection, proposed: &[ProposedTerm]) -> Self {
        let choices = selection.path.last().map_or(&[][..], |m| &m.choices);
        let cards: Vec<&EffectCard> = choices
            .iter()
            .map(|c| &problem.catalogue[c.effect])
            .collect();
        let (beyond, named): (Vec<&EffectCard>, Vec<&EffectCard>) = cards
            .into_iter()
            .partition(|card| is_library_effect(&card.id));
        let titled = |card: &&EffectCard| format!("{} ({})", card.id, card.title);
        let mut files: Vec<String> = (1..=proposed.len())
            .map(|i| format!("proposed_{i}.toml"))
            .collect();
        let in_words = |card: &&EffectCard| {
            let term = proposed
                .iter()
                .find(|t| t.effect.as_ref() == Some(&card.id));
            match term {
                None => titled(card),
                Some(term) if card.id.starts_with(FORMULA_PREFIX) => formula(term),
                Some(term) => format!("{}, {}", titled(card), formula(term)),
            }
        };
        if beyond.iter().any(|card| is_unknown_function(&card.id)) {
            files.push("unknown.toml".to_owned());
        }
        Self {
            named: named.iter().map(titled).collect(),
            beyond: beyond.iter().map(in_words).collect(),
            files,
        }
    }
}

/// A term's formula with the values fitted.
fn formula(term: &ProposedTerm) -> String {
    let values = term.parameters.iter();
    let values: Vec<String> = values.map(|(n, p)| with_interval(n, p)).collect();
    let (target, expression) = (&term.target, &term.expression);
    format!("{target} = {expression} with {}", values.join(", "))
}

/// That the data ask for terms beyond the catalogue.
fn beyond_words(beyond: &Beyond, parts: &Parts, calibrated: &Rung, last: &Rung) -> String {
    let (terms, explain, do_so) = match parts.beyond.len() {
        1 => ("one term beyond", "explains", "does"),
        _ => ("terms beyond", "explain", "do"),
    };
    let compared = match (&beyond.rival, &parts.named[..]) {
        (Some(rival), _) => format!(
            "{rival} explains the data to the noise level too, but {terms} the catalogue {explain} them better, by {:.0} in the logarithm of the likelihood with parameters priced in",
            beyond.gain
        ),
        (None, []) => {
            format!("no effect of the catalogue removes the misfit, but {terms} it {do_so}")
        }
        (None, named) => format!(
            "no effect of the catalogue removes the misfit alone, but {} together with {terms} it {do_so}",
            named.join(" and ")
        ),
    };
    let (it, are_leads) = match parts.beyond.len() {
        1 => (
            "it",
            "It is the simplest of its kind and a lead, not a name",
        ),
        _ => (
            "them",
            "They are the simplest of their kinds and leads, not names",
        ),
    };
    let ready = if parts.files.len() == 1 { "is" } else { "are" };
    format!(
        "Something outside the catalogue is missing: {compared}: {}. With {it} the error on runs kept out of the fit falls from {} to {}, {:.2} times the sensor noise. {are_leads}: {} {ready} ready for `pack --effect` and `try`.",
        parts.beyond.join("; and "),
        percent(calibrated.holdout_nrmse),
        percent(last.holdout_nrmse),
        last.holdout_over_noise,
        parts.files.join(" and ")
    )
}
