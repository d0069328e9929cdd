//! `campaign.toml`: its keys, and the checks on its numbers.

pub(super) mod check;
mod keys;
mod knowledge;
pub(super) mod run_entry;

use crate::error::Error;
use crate::measurement::BeamKnowledge;
use crate::measurement::further_sensor::FurtherSensor;
use crate::measurement::uncertainty::Uncertainty;
use check::{Check, POSITIVE, line_of};
use keys::{RawBeamFile, RawFile, RawRun};
use run_entry::RunEntry;
use std::path::Path;
use toml::Spanned;

/// The file's content, checked.
pub(super) struct CampaignFile {
    pub name: Option<String>,
    pub beam: BeamKnowledge,
    pub uncertainty: Uncertainty,
    pub further_sensors: Vec<FurtherSensor>,
    /// Corner frequency of the filter that the first sensor's reading has passed, Hz.
    pub high_pass_hz: Option<f64>,
    pub runs: Vec<RunEntry>,
}

/// Reads and checks the file.
pub(super) fn read(path: &Path) -> Result<CampaignFile, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::read(path))?;
    let raw: RawFile = toml::from_str(&text).map_err(|e| Error::CampaignFile {
        path: path.to_owned(),
        line: line_of(&text, e.span().unwrap_or(0..0)),
        problem: e.message().replace('\n', "; "),
    })?;
    let check = Check { path, text: &text };
    let zero_std = raw.sensor.offset_std.clone();
    let high_pass_hz = check.high_pass(&raw.sensor)?;
    let (beam, of_modes) = check.beam(raw.beam, raw.sensor)?;
    let zero_std = zero_std
        .map(|std| check.number("[sensor] offset_std", "SI", POSITIVE, std))
        .transpose()?;
    let uncertainty = Uncertainty {
        zero_std,
        ..check.uncertainty(raw.uncertainty, raw.rig, of_modes)?
    };
    let modes = beam.natural_frequencies_hz.len();
    let further_sensors = check.further_sensors(raw.further_sensor, modes)?;
    if raw.run.is_empty() {
        return Err(Error::NoRuns {
            path: path.to_owned(),
        });
    }
    let runs = raw
        .run
        .into_iter()
        .map(|run| check.run(run, &raw.channels))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(CampaignFile {
        name: raw.name,
        beam,
        uncertainty,
        further_sensors,
        high_pass_hz,
        runs,
    })
}

/// One run that no campaign describes: the beam and the channels come from the file at `path`.
pub(super) fn read_beam(path: &Path, single: &super::SingleRun) -> Result<CampaignFile, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::read(path))?;
    let raw: RawBeamFile = toml::from_str(&text).map_err(|e| Error::CampaignFile {
        path: path.to_owned(),
        line: line_of(&text, e.span().unwrap_or(0..0)),
        problem: e.message().replace('\n', "; "),
    })?;
    let check = Check { path, text: &text };
    let run = RawRun {
        file: Spanned::new(0..0, single.file.to_string_lossy().into_owned()),
        further_files: Vec::new(),
        name: None,
        role: None,
        belt_velocity_m_per_s: Some(Spanned::new(0..0, single.belt_velocity)),
        normal_force_n: Some(Spanned::new(0..0, single.normal_force)),
        external_force_n: None,
        clamp_acceleration_m_per_s2: None,
        time_column: single.time_column.clone(),
        displacement_column: single
            .displacement_column
            .clone()
            .map(|name| Spanned::new(0..0, name)),
        velocity_column: None,
        acceleration_column: None,
        time_scale: None,
        displacement_scale: None,
        velocity_scale: None,
        acceleration_scale: None,
        delimiter: None,
        sample_rate_hz: None,
        belt_velocity_column: None,
        belt_velocity_scale: None,
        normal_force_column: None,
        normal_force_scale: None,
        external_force_column: None,
        external_force_scale: None,
        clamp_acceleration_column: None,
        clamp_acceleration_scale: None,
        input_interpolation: None,
    };
    Ok(CampaignFile {
        name: None,
        high_pass_hz: check.high_pass(&raw.sensor)?,
        beam: check.beam(raw.beam, raw.sensor)?.0,
        uncertainty: Uncertainty::default(),
        further_sensors: Vec::new(),
        runs: vec![check.run(run, &raw.channels)?],
    })
}
