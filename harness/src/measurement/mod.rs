//! Measurement campaigns: a folder with `campaign.toml` and one CSV file per run.
//!
//! ```no_run
//! # fn main() -> Result<(), stickslip::error::Error> {
//! use stickslip::measurement::Campaign;
//! let campaign = Campaign::load("reference-data/demo".as_ref())?;
//! for run in &campaign.runs {
//!     println!("{}: {} samples, noise {:.1e} {}", run.name, run.time.len(), run.noise.std, run.measurand.unit());
//! }
//! # Ok(()) }
//! ```
//!
//! Everything is in SI units once loaded. Samples are kept as measured: gaps and uneven sampling are found and
//! reported, never filled.

mod band_limited;
mod campaign_file;
mod cell;
mod column;
mod csv_table;
mod dialect;
mod encoding;
mod faults;
mod further_sensor;
mod header;
mod input_file;
mod input_lines;
mod inputs;
mod lines;
pub mod logger;
mod measurand;
mod measured_keys;
mod noise;
mod own_clock;
mod sampling;
mod sensor_place;
mod table;
mod uncertainty;
mod unit;

use std::path::{Path, PathBuf};

pub(crate) use campaign_file::check::line_of;
pub use column::{Column, read_column};
pub use faults::{Fault, FaultKind};
pub use further_sensor::{BESIDE_JUMP, FurtherRecord, FurtherSensor, LEAST_NOISE, Reading};
pub use input_file::read_inputs;
pub use input_lines::on_lines;
pub use inputs::{Between, Excitation, InputSeries, InputSignals, InputTrack, Interpolation};
pub use measurand::{Measurand, NoiseStd};
pub use noise::{Noise, of_one_sensor};
pub use sampling::{Gap, Sampling};
pub use sensor_place::SensorPlace;
pub use uncertainty::{OfModes, Uncertainty};
pub(crate) use unit::factor_to_si;

use crate::error::Error;
use crate::file_kind::{Wanted, explain};

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

/// What a run is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Parameters may be fitted to it.
    Fit,
    /// It only checks.
    Holdout,
}

/// One measured run at one operating point.
#[derive(Debug, Clone)]
pub struct Run {
    /// Its name: the file's, without suffix, unless campaign.toml gives one.
    pub name: String,
    /// The CSV file.
    pub file: PathBuf,
    /// Files of further sensors with clocks of their own.
    pub further_files: Vec<PathBuf>,
    /// Its role, where campaign.toml gives one.
    pub role: Option<Role>,
    /// Belt velocity, m/s; any sign. The mean, where it varies.
    pub belt_velocity: f64,
    /// Normal force, N; never negative. The mean, where it varies.
    pub normal_force: f64,
    /// What varies in time, and external forces.
    pub inputs: InputSignals,
    /// Sample times, s; strictly increasing.
    pub time: Vec<f64>,
    /// What was measured at the tip.
    pub measurand: Measurand,
    /// Its values, in the measurand's SI unit; as long as `time`.
    pub measured: Vec<f64>,
    /// What each of the campaign's further sensors read; `None` where one read nothing.
    pub further: Vec<Option<FurtherRecord>>,
    /// How evenly it was sampled, and what is missing.
    pub sampling: Sampling,
    /// How noisy it is.
    pub noise: Noise,
    /// Samples that look clipped or held by the recorder.
    pub faults: Vec<Fault>,
    /// How the file was read, where it is not plain comma-separated values in SI units.
    pub understood: Option<String>,
}

impl Run {
    /// Typical sample interval, s.
    pub fn sample_interval(&self) -> f64 {
        self.sampling.interval
    }

    /// Last time minus first, s.
    pub fn duration(&self) -> f64 {
        self.time[self.time.len() - 1] - self.time[0]
    }

    /// Its first samples, at most so many; faults that reach beyond them are left out.
    pub fn beginning(&self, samples: usize) -> Run {
        if samples >= self.time.len() {
            return self.clone();
        }
        let is_within = |fault: &&Fault| fault.first + fault.samples <= samples;
        Run {
            name: self.name.clone(),
            file: self.file.clone(),
            further_files: self.further_files.clone(),
            inputs: self.inputs.beginning(samples),
            time: self.time[..samples].to_vec(),
            measured: self.measured[..samples].to_vec(),
            further: self
                .further
                .iter()
                .map(|record| record.as_ref().map(|r| r.beginning(samples)))
                .collect(),
            sampling: Sampling::of(&self.time[..samples]),
            faults: self.faults.iter().filter(is_within).cloned().collect(),
            understood: self.understood.clone(),
            ..*self
        }
    }

    /// The same with what is measured, and its noise, over `share`.
    pub fn over(&self, share: f64) -> Run {
        let mut run = self.clone();
        run.measured.iter_mut().for_each(|y| *y /= share);
        run.noise.std /= share.abs();
        run
    }

    /// For each sample, whether it can be trusted (not clipped, not held).
    pub fn trusted(&self) -> Vec<bool> {
        let mut trusted = vec![true; self.time.len()];
        for fault in &self.faults {
            trusted[fault.first..fault.first + fault.samples].fill(false);
        }
        trusted
    }
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

/// Fewest samples from which period, noise and spectrum mean anything.
const FEWEST_SAMPLES: usize = 32;
/// Longest run, s: eleven days, while no vibration needs more than minutes.
const LONGEST_RUN: f64 = 1e6;
/// Places on the grid of the usual interval for each sample there is, at most: beyond, a time is wrong.
const MOST_MISSING: f64 = 100.0;

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
            .map(|entry| load_run(&folder, entry, &parsed.further_sensors))
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

fn load_run(
    folder: &Path,
    entry: campaign_file::run_entry::RunEntry,
    further_sensors: &[FurtherSensor],
) -> Result<Run, Error> {
    let file = folder.join(&entry.file);
    let further_files: Vec<PathBuf> = entry.further_files.iter().map(|f| folder.join(f)).collect();
    let csv_table::Record {
        time,
        measurand,
        mut measured,
        inputs,
        mut further,
        understood,
    } = csv_table::read(&file, &entry.channels, (further_sensors, &further_files))
        .map_err(|error| explain(error, &file, Wanted::Table))?;
    if time.len() < FEWEST_SAMPLES {
        return Err(Error::TooFewSamples {
            path: file,
            samples: time.len(),
            needed: FEWEST_SAMPLES,
        });
    }
    let sampling = Sampling::of(&time);
    let span = time[time.len() - 1] - time[0];
    if !(span <= LONGEST_RUN) {
        return Err(Error::RunTooLong {
            path: file,
            span,
            longest: LONGEST_RUN,
        });
    }
    let places = span / sampling.interval;
    if !(places <= MOST_MISSING * time.len() as f64) {
        return Err(Error::MostlyMissing {
            path: file,
            samples: time.len(),
            span,
            interval: sampling.interval,
        });
    }
    let inputs = input_signals(&file, &entry, inputs, &sampling)?;
    let mean = |series: &Option<InputSeries>, stated: f64| {
        series.as_ref().map_or(stated, |s| {
            s.values.iter().sum::<f64>() / s.values.len() as f64
        })
    };
    // An accelerometer reads the clamp's motion too.
    let absolute = (measurand == Measurand::Acceleration).then_some(&mut measured);
    let of_further = further_sensors.iter().zip(&mut further);
    let of_further = of_further.filter(|(sensor, _)| sensor.reading == Reading::Acceleration);
    let of_further = of_further.map(|(_, readings)| &mut readings.values);
    for values in absolute.into_iter().chain(of_further) {
        let clamp = &inputs.clamp_acceleration;
        let all = values.iter_mut().enumerate();
        all.for_each(|(k, value)| *value -= clamp.at_sample(k));
    }
    let noise = Noise::estimate(&measured, &sampling);
    let further = further_sensors.iter().zip(further);
    let further = further.map(|(sensor, values)| FurtherRecord::of(sensor, &file, &time, values));
    let further = further.collect::<Result<_, _>>()?;
    let belt_velocity = mean(&inputs.belt_velocity, entry.belt_velocity);
    let faults = match measurand {
        Measurand::Displacement => faults::find(&measured, &noise),
        Measurand::Velocity => faults::of_velocity(&measured, &noise, belt_velocity),
        Measurand::Acceleration => faults::of_acceleration(&measured, &noise),
    };
    let lost: usize = faults.iter().map(|fault| fault.samples).sum();
    if let Some(fault) = faults.iter().max_by_key(|fault| fault.samples)
        && time.len() - lost < FEWEST_SAMPLES
    {
        return Err(Error::NothingMeasured {
            path: file,
            usable: time.len() - lost,
            samples: time.len(),
            value: measured[fault.first],
            unit: measurand.unit(),
            needed: FEWEST_SAMPLES,
        });
    }
    Ok(Run {
        name: entry.name,
        file,
        further_files,
        role: entry.role,
        belt_velocity,
        normal_force: mean(&inputs.normal_force, entry.normal_force),
        inputs,
        time,
        measurand,
        measured,
        further,
        sampling,
        noise,
        faults,
        understood,
    })
}

/// The inputs of a run from the columns read, in the order of [`csv_table::INPUTS`].
fn input_signals(
    file: &Path,
    entry: &campaign_file::run_entry::RunEntry,
    columns: [Option<(String, Vec<f64>)>; 4],
    sampling: &Sampling,
) -> Result<InputSignals, Error> {
    let usual = Interpolation::usual(sampling);
    let interpolation = entry.interpolation.unwrap_or(usual);
    let first = columns.iter().flatten().next();
    if let Some((column, _)) = first
        && interpolation == Interpolation::BandLimited
        && !inputs::is_even(sampling)
    {
        return Err(Error::UnevenInput {
            path: file.to_owned(),
            column: column.clone(),
            jitter: 100.0 * sampling.jitter,
            gaps: sampling.gaps.len(),
        });
    }
    if let Some((column, values)) = &columns[1]
        && let Some(worst) = values.iter().position(|force| *force < 0.0)
    {
        return Err(Error::NegativeLoad {
            path: file.to_owned(),
            column: column.clone(),
            sample: worst + 1,
            value: values[worst],
        });
    }
    let series = columns.map(|column| {
        column.map(|(column, values)| InputSeries {
            column,
            values,
            between: interpolation.into(),
        })
    });
    let [
        belt_velocity,
        normal_force,
        external_force,
        clamp_acceleration,
    ] = series;
    // A column and a constant add up: an offset of the amplifier, a weight beside the hammer.
    let excitation = |series: Option<InputSeries>, constant: f64| match series {
        Some(mut series) => {
            series.values.iter_mut().for_each(|v| *v += constant);
            Excitation {
                series: Some(series),
                constant: 0.0,
            }
        }
        None => Excitation {
            series: None,
            constant,
        },
    };
    Ok(InputSignals {
        belt_velocity,
        normal_force,
        external_force: excitation(external_force, entry.external_force),
        clamp_acceleration: excitation(clamp_acceleration, entry.clamp_acceleration),
    })
}

#[cfg(test)]
mod bad_input;
#[cfg(test)]
mod logger_files;
#[cfg(test)]
mod measured_acceleration;
#[cfg(test)]
mod measured_velocity;
