//! Effects that the user wrote, one TOML file each.

use std::path::PathBuf;

use beam_model_description::{Layout, UserCard, UserEffectError};

use crate::error::Error;

/// The variables of an FMU with the effects in these files.
///
/// # Errors
/// A file that can't be read or used, two effects with one id, or too many.
pub fn layout(paths: &[PathBuf]) -> Result<&'static Layout, Error> {
    let mut cards: Vec<UserCard> = Vec::new();
    let mut layout = Layout::plain();
    for path in paths {
        let text = std::fs::read_to_string(path).map_err(Error::read(path))?;
        let at = |error: UserEffectError| Error::EffectFile {
            path: path.clone(),
            line: error.line(),
            problem: error.to_string(),
        };
        cards.push(UserCard::parse(&text).map_err(at)?);
        // One after another, so that the file that does not go with those before it is named.
        layout = Layout::with(cards.clone()).map_err(at)?;
    }
    Ok(layout)
}
