//! A library effect as fitted, to be proposed.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::explanation::proposed_term::ProposedTerm;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library::{FILES, File, text_among};
use crate::diagnose::model::problem::Problem;
use crate::diagnose::validation::estimate::estimate;
use crate::fmu::effect_card::Role;

/// A term as fitted, to be proposed; `explained_share` as there. `None` for an effect that is no term.
pub fn proposal(
    problem: &Problem,
    choice: &Choice,
    fitted: &FittedHypothesis,
    explained_share: f64,
) -> Option<ProposedTerm> {
    let card = &problem.catalogue[choice.effect];
    let formulas = problem.formula_files.iter().map(String::as_str);
    let text = text_among(FILES.into_iter().chain(formulas), &card.id)?;
    let file = File::among([text], &card.id)?;
    let fitted = card.parameters.iter().map(|p| {
        let h = &fitted.hypothesis;
        let i = h.shared_index(&format!("{}.{}", card.id, p.name))?;
        Some((p.name.clone(), estimate(h, &fitted.fit, i)))
    });
    let of_role = |role: Role| {
        let with = card.parameters.iter().filter(move |p| p.role == role);
        with.map(|p| p.name.clone()).collect()
    };
    Some(ProposedTerm {
        target: file.target,
        expression: file.expression,
        parameters: fitted.flatten().collect(),
        explained_share,
        fitted: true,
        effect: Some(card.id.clone()),
        file: Some(text.to_owned()),
        shapes: of_role(Role::Shape),
        phases: of_role(Role::Phase),
    })
}
