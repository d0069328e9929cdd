//! The file of a run, read and checked.

use super::campaign_file::run_entry::RunEntry;
use super::further_sensor::{FurtherRecord, FurtherSensor, Reading};
use super::inputs::{Excitation, InputSeries, InputSignals, Interpolation, is_even};
use super::measurand::Measurand;
use super::noise::{self, Noise};
use super::run::Run;
use super::sampling::Sampling;
use super::{csv_table, faults, high_pass};
use crate::error::Error;
use crate::file_kind::{Wanted, explain};
use std::path::{Path, PathBuf};

/// Fewest samples from which period, noise and spectrum mean anything.
pub(super) const FEWEST_SAMPLES: usize = 32;
/// Longest run, s: eleven days, while no vibration needs more than minutes.
const LONGEST_RUN: f64 = 1e6;
/// Places on the grid of the usual interval for each sample there is, at most: beyond, a time is wrong.
const MOST_MISSING: f64 = 100.0;

/// Reads and checks the file of one run.
pub(super) fn load(
    folder: &Path,
    entry: RunEntry,
    further_sensors: &[FurtherSensor],
    high_pass_hz: Option<f64>,
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
    let further = further_sensors.iter().zip(further);
    let further = further.map(|(sensor, values)| FurtherRecord::of(sensor, &file, &time, values));
    let further = further.collect::<Result<_, _>>()?;
    let belt_velocity = mean(&inputs.belt_velocity, entry.belt_velocity);
    let resolution = noise::resolution(&measured);
    let faults = faults::of(measurand, &measured, resolution, belt_velocity);
    let noise = Noise::estimate(&measured, &faults::between(&faults, sampling.unbroken()));
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
    let understood = match high_pass_hz {
        None => understood,
        Some(hz) if sampling.gaps.is_empty() => {
            // Noise and faults are those of the reading; what it was made of is what moves.
            high_pass::undo(&mut measured, &time, hz);
            let said = format!("a high pass at {hz} Hz undone, about the mean");
            let parts = understood.into_iter().chain([said]);
            Some(parts.collect::<Vec<_>>().join("; "))
        }
        Some(hz) => {
            return Err(Error::FilteredGaps {
                path: file,
                corner_hz: hz,
                gaps: sampling.gaps.len(),
            });
        }
    };
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
    entry: &RunEntry,
    columns: [Option<(String, Vec<f64>)>; 4],
    sampling: &Sampling,
) -> Result<InputSignals, Error> {
    let usual = Interpolation::usual(sampling);
    let interpolation = entry.interpolation.unwrap_or(usual);
    let first = columns.iter().flatten().next();
    if let Some((column, _)) = first
        && interpolation == Interpolation::BandLimited
        && !is_even(sampling)
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
