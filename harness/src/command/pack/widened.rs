//! An FMU of this project with further users' effects, for a diagnosis.

use beam_model_description::{EFFECTS_FOLDER, Layout, UserCard};

use super::{DESCRIPTION, START_VALUES, archive, describe, load_bytes, own_effects};
use crate::error::Error;
use crate::fmu::Fmu;

/// The FMU with the users' effects of these `texts` behind its own, its start values unchanged; `None` where that can't be: an
/// FMU of another make, one that has such effects already, one of another version.
///
/// # Errors
/// An archive that can't be read, a temporary folder that can't be written, or a text that is no effect.
pub fn with_effects(fmu: &Fmu, texts: &[&str]) -> Result<Option<Fmu>, Error> {
    let parsed = |(i, text): (usize, &&str)| {
        UserCard::parse(text).map_err(|e| Error::EffectFile {
            path: format!("effect {} of those to be added", i + 1).into(),
            line: e.line(),
            problem: e.to_string(),
        })
    };
    let cards = texts.iter().enumerate().map(parsed);
    with_cards(fmu, cards.collect::<Result<_, _>>()?)
}

/// The FMU with those users' effects of `from` that are among `ids` and not its own; `None` as in [`with_effects`].
///
/// # Errors
/// As [`with_effects`].
pub fn with_effects_of(fmu: &Fmu, from: &Fmu, ids: &[&str]) -> Result<Option<Fmu>, Error> {
    let own = own_effects::of_fmu(fmu)?;
    let mut wanted = own_effects::of_fmu(from)?;
    wanted.retain(|c| ids.contains(&c.id.as_str()) && own.iter().all(|o| o.id != c.id));
    if wanted.is_empty() {
        return Ok(None);
    }
    with_cards(fmu, wanted)
}

fn with_cards(fmu: &Fmu, further: Vec<UserCard>) -> Result<Option<Fmu>, Error> {
    let mut files = fmu.files()?;
    let Some(starts) = files.iter().find(|f| f.0 == START_VALUES) else {
        return Ok(None);
    };
    let Some(starts) = start_values(&starts.1) else {
        return Ok(None);
    };
    let mut cards = own_effects::of_fmu(fmu)?;
    cards.extend(further);
    let Ok(layout) = Layout::with(cards) else {
        return Ok(None);
    };
    let Ok((xml, starts)) = describe(layout, &starts) else {
        return Ok(None);
    };
    let folder = format!("resources/{EFFECTS_FOLDER}/");
    files.retain(|(name, _)| {
        name != DESCRIPTION && name != START_VALUES && !name.starts_with(&folder)
    });
    files.insert(0, (DESCRIPTION.to_owned(), xml.into_bytes()));
    files.push((START_VALUES.to_owned(), starts.into_bytes()));
    files.extend(own_effects::files(layout));
    let bytes = archive(&files).map_err(|e| Error::Write {
        path: fmu.path().to_owned(),
        source: e.into(),
    })?;
    let widened = load_bytes(&bytes)?;
    let works = widened.instantiate("widened").is_ok();
    Ok(works.then_some(widened))
}

/// What `[start]` says in a file of start values.
fn start_values(text: &[u8]) -> Option<Vec<(String, f64)>> {
    let table: toml::Table = std::str::from_utf8(text).ok()?.parse().ok()?;
    let Some(start) = table.get("start") else {
        return Some(Vec::new());
    };
    let number = |value: &toml::Value| match value {
        toml::Value::Float(x) => Some(*x),
        toml::Value::Integer(i) => Some(*i as f64),
        _ => None,
    };
    let all = start.as_table()?.iter();
    all.map(|(name, value)| Some((name.clone(), number(value)?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::open_fmu;
    use crate::command::pack::belt_drive;
    use crate::command::repaired_model::write_fmu;
    use crate::diagnose::model::library;
    use crate::diagnose::model::unknown_function::{FormulaConstant, NODES, unknown_functions};
    use crate::fmu::effect_card::candidates;
    use crate::measurement::Campaign;
    use std::path::Path;

    #[test]
    fn terms_stand_behind_the_effects_and_start_values_stay() {
        let folder = tempfile::tempdir().unwrap();
        let changed = folder.path().join("changed.fmu");
        let plain = open_fmu(None).unwrap();
        write_fmu(&plain, &[("normal_force".to_owned(), 77.0)], &changed).unwrap();
        let plain = Fmu::load(&changed).unwrap();
        let widened = with_effects(&plain, &library::FILES).unwrap().unwrap();
        let start = widened.variable("normal_force").unwrap().start_number();
        assert_eq!(start, Some(77.0));
        let (few, many) = (candidates(&plain).unwrap(), candidates(&widened).unwrap());
        assert_eq!(few, many[..few.len()]);
        assert_eq!(many.len(), few.len() + library::FILES.len());
        assert!(
            many[few.len()..]
                .iter()
                .all(|c| library::is_library_effect(&c.id))
        );
    }

    #[test]
    fn an_fmu_of_another_make_stays_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive.fmu");
        belt_drive::pack(&path).unwrap();
        let drive = Fmu::load(&path).unwrap();
        assert!(with_effects(&drive, &library::FILES).unwrap().is_none());
    }

    #[test]
    fn unknown_functions_of_a_campaign_are_effects_as_they_are_and_as_fitted() {
        let campaign = Campaign::load(Path::new("../reference-data/demo")).unwrap();
        let unknown = unknown_functions(&campaign, 80.0, 0.1, &[(-1e-3, 1e-3)]);
        let files: Vec<&str> = unknown.iter().map(|f| f.file.as_str()).collect();
        let plain = open_fmu(None).unwrap();
        let widened = with_effects(&plain, &files).unwrap().unwrap();
        let known = candidates(&widened).unwrap();
        for function in &unknown {
            let card = known.iter().find(|c| c.id == function.id).unwrap();
            let nodes = card.parameters.iter().filter(|p| p.name.starts_with("g_"));
            assert_eq!(nodes.count(), NODES, "{}", function.id);
            // What moves the belt brings its travel along.
            let has_state = function.remembers || function.place == "belt";
            assert_eq!(card.states.len(), usize::from(has_state));
            let values: Vec<f64> = (1..=NODES).map(|i| 1e-3 * i as f64).collect();
            let memory = function.remembers.then_some(0.2);
            let fitted = UserCard::parse(&function.file_with("unknown", &values, memory)).unwrap();
            assert_eq!(fitted.id, "unknown");
            let typical: Vec<f64> = fitted.parameters.iter().map(|p| p.typical).collect();
            assert!(values.iter().all(|v| typical.contains(v)), "{typical:?}");
            assert!(!function.remembers || typical.contains(&0.2), "{typical:?}");
        }
    }

    #[test]
    fn unknown_functions_of_a_free_decay_are_effects_too() {
        let mut campaign = Campaign::load(Path::new("../reference-data/demo")).unwrap();
        for run in &mut campaign.runs {
            (run.belt_velocity, run.normal_force) = (0.0, 0.0);
        }
        let unknown = unknown_functions(&campaign, 80.0, 0.1, &[(-1e-3, 1e-3)]);
        let files: Vec<&str> = unknown.iter().map(|f| f.file.as_str()).collect();
        let plain = open_fmu(None).unwrap();
        assert!(with_effects(&plain, &files).unwrap().is_some());
        let refused = with_effects(&plain, &["no effect"]).err().unwrap();
        assert!(refused.to_string().starts_with("effect 1 of"), "{refused}");
    }

    #[test]
    fn a_formula_stands_behind_what_was_there_and_alone_where_it_is_wanted() {
        let campaign = Campaign::load(Path::new("../reference-data/demo")).unwrap();
        let unknown = unknown_functions(&campaign, 80.0, 0.1, &[(-1e-3, 1e-3)]);
        let files: Vec<&str> = unknown.iter().map(|f| f.file.as_str()).collect();
        let plain = open_fmu(None).unwrap();
        let widened = with_effects(&plain, &files).unwrap().unwrap();
        let before = candidates(&widened).unwrap();
        for function in &unknown {
            let of = |name: &str, unit: &str, value: f64, is_shape: bool| FormulaConstant {
                name: name.into(),
                unit: unit.into(),
                value,
                is_shape,
            };
            let constants = [
                of("c_1", function.value_unit(), -0.3, false),
                of("l_1", function.argument_unit, 0.01, true),
            ];
            let curve = format!("c_1*(1 - exp(-abs({})/l_1))", function.variable());
            let file = function.formula_file("term_formula_1", &curve, &constants, Some(0.1));
            let further = with_effects(&widened, &[&file]).unwrap().unwrap();
            // A fit goes on with the same catalogue and variables.
            let after = candidates(&further).unwrap();
            assert!(after[..before.len()] == before, "{}", function.id);
            let card = after.last().unwrap();
            assert_eq!(
                (card.id.as_str(), after.len()),
                ("term_formula_1", before.len() + 1)
            );
            assert_eq!(card.parameters[0].typical, -0.3);
            let alone = with_effects_of(&plain, &further, &["term_formula_1"]).unwrap();
            let alone = candidates(&alone.unwrap()).unwrap();
            assert!(alone.iter().any(|c| c.id == "term_formula_1"));
            assert!(alone.iter().all(|c| c.id != function.id));
        }
    }
}
