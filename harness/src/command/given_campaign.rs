//! The campaign that a command is given: read, looked at, and told how.

use std::path::Path;

use clap::Args;

use crate::check::{Quality, check};
use crate::error::Error;
use crate::measurement::{BeamKnowledge, Campaign, Run};
use crate::output::tell;

/// The option of commands that look at the data before they begin.
#[derive(Debug, Default, Clone, Copy, Args)]
pub struct Forced {
    /// Begin even where `stickslip check` finds values that can't be meant
    #[arg(long)]
    pub force: bool,
}

/// Loads a campaign and looks at its data. Tells on standard error how its files were read, where
/// they are not plain CSV in SI units, and what was found.
///
/// # Errors
/// A campaign that can't be read; a value in it that can't be meant, unless it is `forced`.
pub fn load(path: &Path, forced: Forced) -> Result<Campaign, Error> {
    let campaign = Campaign::load(path)?;
    campaign.runs.iter().for_each(tell_how);
    let quality = check(&campaign);
    for finding in &quality.findings {
        tell(format_args!(
            "{}: {} where {} is stated; {}",
            finding.runs.join(", "),
            finding.measured,
            finding.stated,
            finding.remedy
        ));
    }
    match questionable(&quality, path) {
        Some(error) if !forced.force => Err(error),
        _ => Ok(campaign),
    }
}

/// As [`load`], for commands that read runs at constant belt velocity and normal force on a structure with springs.
///
/// # Errors
/// As [`load`]; a run that something else drives, a mode without a spring.
pub fn load_plain(path: &Path, forced: Forced, command: &'static str) -> Result<Campaign, Error> {
    let campaign = load(path, forced)?;
    campaign
        .runs
        .iter()
        .try_for_each(|run| require_plain(run, command))?;
    require_springs(&campaign.beam, path, command)?;
    Ok(campaign)
}

/// A run that a constant belt and load alone drive.
///
/// # Errors
/// [`Error::DrivenRun`] with the input.
pub fn require_plain(run: &Run, command: &'static str) -> Result<(), Error> {
    let series = run.inputs.series().next();
    let input = match series {
        Some((name, series)) => format!("{name} from column '{}'", series.column),
        None => {
            let excitations = run.inputs.excitations();
            let Some((name, unit, excitation)) = excitations.iter().find(|(_, _, e)| e.acts())
            else {
                return Ok(());
            };
            format!("{name} of {} {unit}", excitation.constant)
        }
    };
    Err(Error::DrivenRun {
        run: run.name.clone(),
        input,
        command,
    })
}

/// A structure whose modes all have springs.
///
/// # Errors
/// [`Error::FreeMode`] with the mode.
pub fn require_springs(
    beam: &BeamKnowledge,
    path: &Path,
    command: &'static str,
) -> Result<(), Error> {
    let free = beam.natural_frequencies_hz.iter().position(|f| *f == 0.0);
    free.map_or(Ok(()), |mode| {
        Err(Error::FreeMode {
            path: path.to_owned(),
            mode: mode + 1,
            command,
        })
    })
}

/// The error of a campaign with values that can't be meant.
pub fn questionable(quality: &Quality, path: &Path) -> Option<Error> {
    let first = quality.errors().next()?;
    Some(Error::Questionable {
        campaign: path.to_owned(),
        errors: quality.errors().count(),
        runs: first.runs.join(", "),
        finding: format!(
            "{} where {} is stated; {}",
            first.measured, first.stated, first.remedy
        ),
    })
}

/// One line for a file that is not plain CSV in SI units.
pub fn tell_how(run: &Run) {
    if let Some(understood) = &run.understood {
        let file = run.file.file_name().unwrap_or(run.file.as_os_str());
        tell(format_args!("{}: {understood}", file.display()));
    }
}
