//! Terms beyond the catalogue that are fitted like its effects, to see whether something else explains the data better.
//!
//! Each is one file in the form of a user's effect (`terms/`), the simplest of its kind: the next terms of the beam's restoring
//! force and damping, friction that tells directions apart, stiffness and belt speed that pulsate. None is ever named as an
//! effect: where one is needed, the effect is none of the catalogue's, and the term is proposed.

use super::candidate::Role;
use super::conclude::estimate;
use super::hypothesis::Choice;
use super::propose::ProposedTerm;
use super::search::{Trial, variants_of};
use super::session::Session;
use serde::Deserialize;

/// The files.
pub const FILES: [&str; 10] = [
    include_str!("terms/quadratic_stiffness.toml"),
    include_str!("terms/stop.toml"),
    include_str!("terms/cubic_damping.toml"),
    include_str!("terms/damping_by_deflection.toml"),
    include_str!("terms/dry_damping.toml"),
    include_str!("terms/friction_by_direction.toml"),
    include_str!("terms/friction_by_tip_velocity.toml"),
    include_str!("terms/friction_by_deflection_squared.toml"),
    include_str!("terms/pulsating_stiffness.toml"),
    include_str!("terms/pulsating_belt.toml"),
];

/// How the identifiers of all of them begin.
const PREFIX: &str = "term_";

/// What a proposal takes from a file.
#[derive(Deserialize)]
struct File {
    id: String,
    target: String,
    expression: String,
}

/// Whether an effect is one of them.
pub fn is_term(id: &str) -> bool {
    id.starts_with(PREFIX)
}

/// All of them, where the session's FMU has them.
pub fn all(session: &Session) -> Vec<Choice> {
    variants_of(session, |effect| is_term(&effect.id))
}

/// Those without a phase.
pub fn smooth(session: &Session) -> Vec<Choice> {
    variants_of(session, |effect| {
        is_term(&effect.id) && effect.find_role(Role::Phase).is_none()
    })
}

/// A term as fitted, to be proposed; `explained_share` as there. `None` for an effect that is no term.
pub fn proposal(
    session: &Session,
    choice: &Choice,
    trial: &Trial,
    explained_share: f64,
) -> Option<ProposedTerm> {
    let card = &session.catalogue[choice.effect];
    let files = FILES.iter().filter_map(|f| toml::from_str::<File>(f).ok());
    let file = files.into_iter().find(|f| f.id == card.id)?;
    let fitted = card.parameters.iter().map(|p| {
        let h = &trial.hypothesis;
        let i = h.shared_index(&format!("{}.{}", card.id, p.name))?;
        Some((p.name.clone(), estimate(h, &trial.fit, i)))
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
        shapes: of_role(Role::Shape),
        phases: of_role(Role::Phase),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_file_has_an_identifier_of_its_own_that_is_known_for_a_term() {
        let ids: BTreeSet<String> = FILES
            .iter()
            .map(|f| toml::from_str::<File>(f).unwrap().id)
            .collect();
        assert_eq!(ids.len(), FILES.len());
        assert!(ids.iter().all(|id| is_term(id)), "{ids:?}");
    }
}
