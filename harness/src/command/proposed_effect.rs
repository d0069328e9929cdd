//! Terms that a diagnosis proposes, as files for `pack --effect`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::diagnose::explanation::proposed_term::ProposedTerm;
use crate::diagnose::model::library::with_values;
use crate::error::Error;
use crate::output::write_file;

/// Bounds of a proposed coefficient in units of its value: a regression of the slip force is good to a factor.
const RANGE: f64 = 10.0;

/// Writes proposed_1.toml, proposed_2.toml, ... into `folder`.
///
/// # Errors
/// A file that can't be written.
pub fn write(terms: &[ProposedTerm], folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut files = Vec::new();
    for (i, term) in terms.iter().enumerate() {
        let id = format!("proposed_{}", i + 1);
        let path = folder.join(format!("{id}.toml"));
        write_file(&path, text(&id, term).as_bytes())?;
        files.push(path);
    }
    Ok(files)
}

fn text(id: &str, term: &ProposedTerm) -> String {
    let head = format!(
        "# Proposed by a diagnosis: {}. Try it:\n\
         #     stickslip pack --effect {id}.toml -o per_run.fmu\n\
         #     stickslip try CAMPAIGN --fmu per_run.fmu --add {id}\n",
        term.worth()
    );
    if let Some(file) = &term.file {
        let values = term.parameters.iter();
        let values = values.map(|(name, p)| (name.clone(), p.value)).collect();
        return head + &with_values(file, id, &values);
    }
    let mut out = format!(
        "{head}\
         id = \"{id}\"\n\
         title = \"Proposed term\"\n\
         target = \"{}\"\n\
         expression = \"{}\"\n",
        term.target, term.expression
    );
    for (name, estimate) in &term.parameters {
        let is_shape = term.shapes.contains(name);
        let most = RANGE * estimate.value.abs();
        let least = if is_shape {
            estimate.value / RANGE
        } else {
            -most
        };
        let _ = write!(
            out,
            "\n[[parameter]]\nname = \"{name}\"\nunit = \"{}\"\nmin = {least:e}\nmax = {most:e}\ntypical = {:e}\n",
            estimate.unit, estimate.value
        );
        if is_shape {
            out += "role = \"shape\"\n";
        }
    }
    for name in &term.phases {
        let _ = write!(
            out,
            "\n[[parameter]]\nname = \"{name}\"\nunit = \"rad\"\nmin = {:e}\nmax = {:e}\ntypical = 0.0\nrole = \"phase\"\n",
            -std::f64::consts::PI,
            std::f64::consts::PI
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::pack::pack_with;
    use crate::diagnose::model::library::{FILES, File, text_among};
    use crate::diagnose::validation::estimate::Estimate;
    use crate::fmu::Fmu;
    use crate::fmu::effect_card::candidates;
    use std::collections::BTreeMap;

    #[test]
    fn what_is_proposed_can_be_packed_and_is_a_candidate_then() {
        let folder = tempfile::tempdir().unwrap();
        let of = |target: &str, expression: &str, value: f64, unit: &str| ProposedTerm {
            target: target.into(),
            expression: expression.into(),
            parameters: BTreeMap::from([(
                "c".to_owned(),
                Estimate {
                    value,
                    std: 0.1 * value.abs(),
                    unit: unit.into(),
                    at_bound: false,
                },
            )]),
            explained_share: 0.3,
            fitted: false,
            effect: None,
            file: None,
            shapes: Vec::new(),
            phases: Vec::new(),
        };
        let terms = [
            of("tip_force", "c*w^2", -2.5e6, "N/m2"),
            of("friction_factor", "1 + c*max(v_r, 0)", 0.4, "s/m"),
        ];
        let files = write(&terms, folder.path()).unwrap();
        assert_eq!(files.len(), 2);
        let fmu = folder.path().join("own.fmu");
        pack_with(&fmu, &files).unwrap();
        let known = candidates(&Fmu::load(&fmu).unwrap()).unwrap();
        let first = known.iter().find(|c| c.id == "proposed_1").unwrap();
        assert_eq!(first.parameters[0].typical, -2.5e6);
        assert_eq!(first.parameters[0].max, 2.5e7);
        assert!(known.iter().any(|c| c.id == "proposed_2"));
    }

    #[test]
    fn an_effect_with_states_is_proposed_with_them() {
        let folder = tempfile::tempdir().unwrap();
        let id = "term_vibration_absorber";
        let file = text_among(FILES, id).unwrap();
        let of = |(name, value, unit): (&str, f64, &str)| {
            let estimate = Estimate {
                value,
                std: 0.1 * value,
                unit: unit.into(),
                at_bound: false,
            };
            (name.to_owned(), estimate)
        };
        let values = [("m", 0.004, "kg"), ("f", 310.0, "Hz"), ("D", 0.02, "1")];
        let term = ProposedTerm {
            target: "tip_force".into(),
            expression: File::of_library(id).unwrap().expression,
            parameters: values.into_iter().map(of).collect(),
            explained_share: 0.9,
            fitted: true,
            effect: Some(id.to_owned()),
            file: Some(file.to_owned()),
            shapes: Vec::new(),
            phases: Vec::new(),
        };
        let files = write(&[term], folder.path()).unwrap();
        let fmu = folder.path().join("own.fmu");
        pack_with(&fmu, &files).unwrap();
        let known = candidates(&Fmu::load(&fmu).unwrap()).unwrap();
        let proposed = known.iter().find(|c| c.id == "proposed_1").unwrap();
        assert_eq!(proposed.states.len(), 2);
        let typical = |name: &str| {
            let mut parameters = proposed.parameters.iter();
            parameters.find(|p| p.name == name).unwrap().typical
        };
        assert_eq!((typical("m"), typical("f")), (0.004, 310.0));
    }
}
