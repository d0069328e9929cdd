//! Remarks on a diagnosis: what the data cannot tell, values on their bounds, what was not tried.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::model::friction_prior::is_foreign;
use crate::diagnose::model::library::is_library_effect;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::result::diagnosis::FoundEffect;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::outcome::{Contradiction, Selection};
use crate::diagnose::thresholds::CLAIMED;
use crate::measurement::Run;
use crate::report::{number, percent};

/// What the data can't tell and why, values on their bounds, and whether the search was stopped.
pub(crate) fn remarks(
    problem: &Problem,
    fitted: &FittedHypothesis,
    selection: &Selection,
    effects: &[FoundEffect],
) -> Vec<String> {
    let mut out = problem.remarks.clone();
    let runs = &problem.campaign.runs;
    if !problem.held_out.iter().any(|h| *h) {
        let (place, more) = match runs.iter().any(Run::is_pressed) {
            true => ("at another belt speed or load", "operating points"),
            false => ("in another motion", "runs"),
        };
        out.push(format!(
            "{} run(s): too few to keep any out, so every second shot was kept out instead; what would fail {place} stays open. Measure at least 3 {more}.",
            runs.len()
        ));
    }
    out.extend(one_operating_point(runs));
    for (run, smoothing) in runs.iter().zip(&problem.smoothings) {
        let can_stick = run.belt_moves() && run.is_pressed();
        if can_stick && smoothing.cycle.is_nan() {
            out.push(format!(
                "{}: no stick-slip cycles seen; this run says nothing of static friction, of how it ages, or of how break-away depends on the place.",
                run.name
            ));
        }
        if !run.faults.is_empty() {
            let samples: usize = run.faults.iter().map(|f| f.samples).sum();
            out.push(format!(
                "{}: {samples} samples are clipped or held and were left out.",
                run.name
            ));
        }
    }
    if let Some(Contradiction {
        answer,
        runs,
        error,
    }) = &selection.contradicted
    {
        out.push(format!(
            "{} were kept out at first and contradicted what the others gave ({answer}): an error of {error} there. They are fitted here, and other runs kept out.",
            runs.join(", ")
        ));
    }
    // The constants of an FMU of another make come from its side file, whatever the force.
    let of_beam = problem.fmu.side_file().is_none();
    if let Some(ratio) = problem.friction.foreign.filter(|_| of_beam) {
        let why = match is_foreign(ratio) {
            true => format!(
                "Friction is {ratio:.2} times what the FMU's start values expect: other surfaces, another machine, or readings that do not count from the tip's rest (then state offset_std under [sensor])."
            ),
            false => {
                "The machine is of another size than that of the FMU's start values.".to_owned()
            }
        };
        out.push(format!(
            "{why} The friction constants were started from the measured force instead."
        ));
    }
    for (index, parameter) in fitted.hypothesis.shared.iter().enumerate() {
        if parameter.is_at_bound(fitted.fit.point.shared[index]) {
            out.push(format!(
                "{} = {} {} lies on its bound: the value is not to be trusted.",
                parameter.name,
                number(parameter.value(fitted.fit.point.shared[index]), 4),
                parameter.unit
            ));
        }
    }
    for effect in effects {
        for form in &effect.other_forms {
            let values: Vec<String> = form.iter().map(|(n, v)| format!("{n} = {v:.3e}")).collect();
            out.push(format!(
                "{}: another form of it explains the data as well ({}); the intervals stated hold within the form reported.",
                effect.id,
                values.join(", ")
            ));
        }
    }
    if let (Some(named), Some(more)) = (selection.path.last(), small_remainder(selection)) {
        let cards = more.choices.iter().map(|c| &problem.catalogue[c.effect]);
        let beyond: Vec<String> = cards
            .filter(|card| is_library_effect(&card.id))
            .map(|card| format!("{} ({})", card.id, card.title))
            .collect();
        out.push(format!(
            "Something small is missing beside what is named: {} takes the error on the runs fitted from {} to {}; `try --add` adds it.",
            beyond.join(" and "),
            percent(named.fit.nrmse),
            percent(more.fit.nrmse)
        ));
    }
    if let (Some(next), false) = (selection.untried.first(), selection.stopped) {
        out.push(format!(
            "{} pairs of effects were compared to first order and not fitted, {next} the next of them; \
             `try --add` of two effects tries a pair, `untried_pairs` in diagnosis.json lists them.",
            selection.untried.len(),
        ));
    }
    if selection.stopped {
        out.push("Stopped before the end: candidates not listed were not tried.".into());
    }
    out
}

/// What can't be told apart where all runs have one belt speed and one load; nothing rubs on what no load presses on.
fn one_operating_point(runs: &[Run]) -> Option<String> {
    let first = (runs[0].belt_velocity, runs[0].normal_force);
    let is_first = |r: &Run| (r.belt_velocity, r.normal_force) == first;
    if !runs.iter().any(Run::is_pressed) || !runs.iter().all(is_first) {
        return None;
    }
    Some(if runs.iter().any(Run::belt_moves) {
        format!(
            "All runs have {} m/s and {} N: effects that differ only in how they change with speed or load can't be distinguished. Measure at a second speed and a second load.",
            first.0, first.1
        )
    } else {
        format!(
            "All runs have a load of {} N: effects that differ only in how they change with load can't be distinguished. Measure at a second load.",
            first.1
        )
    })
}

/// The hypothesis that is more probable than the one named and has all of its effects: what it has more is of the library and small.
fn small_remainder(selection: &Selection) -> Option<&FittedModel> {
    let named = selection
        .path
        .last()
        .filter(|_| selection.explained && !selection.by_hand)?;
    selection.pairs.iter().find(|pair| {
        pair.log_posterior > named.log_posterior + CLAIMED.ln()
            && pair.reaches_floor()
            && named.choices.iter().all(|c| pair.choices.contains(c))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoothing::pushed_run::pushed;

    #[test]
    fn one_operating_point_is_told_where_something_rubs() {
        let run = |belt_velocity: f64, normal_force: f64| {
            let mut run = pushed(|_| 0.0, None);
            (run.belt_velocity, run.normal_force) = (belt_velocity, normal_force);
            run
        };
        let said = |runs: &[Run]| one_operating_point(runs).unwrap_or_default();
        assert!(said(&[run(0.1, 30.0), run(0.1, 30.0)]).contains("speed or load"));
        assert!(said(&[run(0.0, 30.0), run(0.0, 30.0)]).contains("a second load"));
        assert_eq!(said(&[run(0.1, 30.0), run(0.2, 30.0)]), "");
        assert_eq!(said(&[run(0.1, 0.0), run(0.1, 0.0)]), "");
    }
}
