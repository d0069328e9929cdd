//! Effects that the user wrote, one TOML file each.

use std::path::{Path, PathBuf};

use beam_model_description::{EFFECTS_FOLDER, Layout, UserCard, UserEffectError};

use super::contents::Entry;
use crate::error::Error;
use crate::file_kind::{Wanted, explain};
use crate::fmu::Fmu;

/// The variables of an FMU with the effects in these files.
///
/// # Errors
/// A file that can't be read or used, two effects with one id, or too many.
pub fn layout(paths: &[PathBuf]) -> Result<&'static Layout, Error> {
    let mut cards: Vec<UserCard> = Vec::new();
    let mut layout = Layout::plain();
    for path in paths {
        let at = |error: UserEffectError| Error::EffectFile {
            path: path.clone(),
            line: error.line(),
            problem: error.to_string(),
        };
        let read = || {
            let text = std::fs::read_to_string(path).map_err(Error::read(path))?;
            UserCard::parse(&text).map_err(at)
        };
        cards.push(read().map_err(|error| explain(error, path, Wanted::Effect))?);
        // One after another, so that the file that does not go with those before it is named.
        layout = Layout::with(cards.clone()).map_err(at)?;
    }
    Ok(layout)
}

/// The texts of all effects (`*.toml`) in a folder, sorted by name.
///
/// # Errors
/// A folder or file that can't be read, one that can't be used, two effects with one id.
pub fn of_folder(folder: &Path) -> Result<Vec<String>, Error> {
    let entries = std::fs::read_dir(folder).map_err(Error::read(folder))?;
    let mut paths: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    paths.sort();
    let layout = layout(&paths)?;
    Ok(layout.effects().iter().map(|e| e.text.clone()).collect())
}

/// The files of the users' effects among the resources.
pub fn files(layout: &Layout) -> impl Iterator<Item = Entry> {
    layout.effects().iter().map(|effect| {
        let name = format!("resources/{EFFECTS_FOLDER}/{}.toml", effect.id);
        (name, effect.text.clone().into_bytes())
    })
}

/// The users' effects in an FMU of this project, in its order.
///
/// # Errors
/// An archive that can't be read, or an effect in it that can't be used.
pub fn of_fmu(fmu: &Fmu) -> Result<Vec<UserCard>, Error> {
    let folder = format!("resources/{EFFECTS_FOLDER}/");
    let files = fmu.files()?;
    let effects = files
        .iter()
        .filter(|(name, _)| name.starts_with(&folder) && name.ends_with(".toml"));
    let read = |(name, content): &(String, Vec<u8>)| {
        let refused = |line: Option<usize>, problem: String| Error::EffectFile {
            path: fmu.path().join(name),
            line,
            problem,
        };
        let text = std::str::from_utf8(content).map_err(|e| refused(None, e.to_string()))?;
        UserCard::parse(text).map_err(|e| refused(e.line(), e.to_string()))
    };
    let mut cards = effects.map(read).collect::<Result<Vec<UserCard>, _>>()?;
    // In the order in which the FMU has their variables: the archive's is that of names.
    let variables = &fmu.description().variables;
    cards.sort_by_cached_key(|card| {
        let own = format!("{}.", card.id);
        variables.iter().position(|v| v.name.starts_with(&own))
    });
    Ok(cards)
}
