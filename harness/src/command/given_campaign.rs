//! The campaign that a command is given: read, and told how.

use std::path::Path;

use crate::error::Error;
use crate::measurement::{Campaign, Run};
use crate::output::tell;

/// Loads a campaign and tells on standard error how its files were read, where they are not plain CSV in SI units.
pub fn load(path: &Path) -> Result<Campaign, Error> {
    let campaign = Campaign::load(path)?;
    campaign.runs.iter().for_each(tell_how);
    Ok(campaign)
}

/// One line for a file that is not plain CSV in SI units.
pub fn tell_how(run: &Run) {
    if let Some(understood) = &run.understood {
        let file = run.file.file_name().unwrap_or(run.file.as_os_str());
        tell(format_args!("{}: {understood}", file.display()));
    }
}
