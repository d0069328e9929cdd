//! Measured runs of one rig, with what is known of it.

use super::further_sensor::FurtherSensor;
use super::measurand::Measurand;
use super::noise::{self, Noise};
use super::run::Run;
use super::sensor_place::SensorPlace;
use super::uncertainty::Uncertainty;
use super::{campaign_file, run_file};
use crate::error::Error;
use crate::file_kind::{Wanted, explain};
use std::path::{Path, PathBuf};

/// Measured runs of one rig.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// Its name; the folder's, where campaign.toml gives none.
    pub name: String,
    /// Where it lies.
    pub folder: PathBuf,
    /// What is known of the beam beforehand.
    pub beam: BeamKnowledge,
    /// How well what the file states is known.
    pub uncertainty: Uncertainty,
    /// Sensors beside the first.
    pub further_sensors: Vec<FurtherSensor>,
    /// The runs, in the order of the file; at least one.
    pub runs: Vec<Run>,
}

/// What is known of the structure. Empty or `None` means unknown; lists have one entry per mode.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BeamKnowledge {
    /// Natural frequencies, Hz.
    pub natural_frequencies_hz: Vec<f64>,
    /// Damping ratios, 1.
    pub damping_ratios: Vec<f64>,
    /// Viscous damping per modal mass beside the ratios, 1/s: that of masses without a spring.
    pub damping_rates_per_s: Vec<f64>,
    /// Modal masses, kg; a single `mass_kg` in the file stands for every mode.
    pub masses_kg: Vec<f64>,
    /// Mode shapes' values at the tip, 1.
    pub tip_values: Vec<f64>,
    /// Shares of the modes in what the tip does where the clamp moves, 1: 1 for a mass on a spring. Empty means those of a
    /// cantilever.
    pub clamp_shares: Vec<f64>,
    /// Where the sensor looks.
    pub sensor: SensorPlace,
}

/// A run outside any campaign, for [`Campaign::of_single_run`].
#[derive(Debug, Clone, PartialEq)]
pub struct SingleRun {
    /// The CSV file.
    pub file: PathBuf,
    /// Belt velocity, m/s; any sign.
    pub belt_velocity: f64,
    /// Normal force, N.
    pub normal_force: f64,
    /// Name of the time column; as in `[channels]` of the beam's file if `None`.
    pub time_column: Option<String>,
    /// Name of the displacement column; likewise.
    pub displacement_column: Option<String>,
}

impl Campaign {
    /// Loads a campaign from its folder, or from the path of its `campaign.toml`.
    pub fn load(path: &Path) -> Result<Campaign, Error> {
        let file = if path.is_dir() {
            path.join("campaign.toml")
        } else {
            path.to_owned()
        };
        let parsed =
            campaign_file::read(&file).map_err(|error| explain(error, path, Wanted::Campaign))?;
        Campaign::assemble(parsed, file.parent())
    }

    /// One run with what is known of the beam from `beam_file`, a TOML file with `[beam]` and, if need be, `[channels]`
    /// as in campaign.toml; its other tables are passed over.
    pub fn of_single_run(single: &SingleRun, beam_file: &Path) -> Result<Campaign, Error> {
        let parsed = campaign_file::read_beam(beam_file, single)
            .map_err(|error| explain(error, beam_file, Wanted::Beam))?;
        // The run's path is relative to the current folder, not to the beam's file.
        Campaign::assemble(parsed, Some(Path::new("")))
    }

    fn assemble(
        parsed: campaign_file::CampaignFile,
        folder: Option<&Path>,
    ) -> Result<Campaign, Error> {
        let folder = folder.unwrap_or(Path::new(".")).to_owned();
        let mut runs = parsed
            .runs
            .into_iter()
            .map(|entry| {
                let sensors = &parsed.further_sensors;
                run_file::load(&folder, entry, sensors, parsed.high_pass_hz)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let mut noises: Vec<&mut Noise> = runs.iter_mut().map(|run| &mut run.noise).collect();
        noise::of_quiet_runs(&mut noises);
        of_one_measurand(&folder, &runs)?;
        sensor_can_be_there(&folder, &parsed.beam.sensor, &runs)?;
        let folder_name = || folder.file_name().map(|n| n.to_string_lossy().into_owned());
        let name = parsed
            .name
            .or_else(folder_name)
            .unwrap_or_else(|| "campaign".into());
        Ok(Campaign {
            name,
            folder,
            beam: parsed.beam,
            uncertainty: parsed.uncertainty,
            further_sensors: parsed.further_sensors,
            runs,
        })
    }
}

/// All runs hold the same quantity: they are compared and fitted together.
fn of_one_measurand(folder: &Path, runs: &[Run]) -> Result<(), Error> {
    let Some(first) = runs.first() else {
        return Ok(());
    };
    match runs.iter().find(|run| run.measurand != first.measurand) {
        None => Ok(()),
        Some(other) => Err(Error::MixedQuantities {
            campaign: folder.to_owned(),
            first: (first.name.clone(), first.measurand.name()),
            other: (other.name.clone(), other.measurand.name()),
        }),
    }
}

/// An accelerometer away from the tip does not rest while the tip sticks, by which accelerations are read.
fn sensor_can_be_there(folder: &Path, place: &SensorPlace, runs: &[Run]) -> Result<(), Error> {
    match runs
        .iter()
        .find(|run| run.measurand == Measurand::Acceleration)
    {
        Some(run) if !place.is_tip() => Err(Error::AccelerometerAway {
            campaign: folder.to_owned(),
            run: run.name.clone(),
        }),
        _ => Ok(()),
    }
}
