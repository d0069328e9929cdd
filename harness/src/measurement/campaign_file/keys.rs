//! The keys of `campaign.toml`, as they are read.

use crate::measurement::further_sensor::RawFurtherSensor;
use crate::measurement::sensor_place::RawSensor;
use crate::measurement::{Interpolation, Role};
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFile {
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) beam: RawBeam,
    #[serde(default)]
    pub(super) uncertainty: RawUncertainty,
    #[serde(default)]
    pub(super) rig: RawRig,
    #[serde(default)]
    pub(super) sensor: RawSensor,
    #[serde(default)]
    pub(super) further_sensor: Vec<RawFurtherSensor>,
    #[serde(default)]
    pub(super) channels: RawChannels,
    #[serde(default)]
    pub(super) run: Vec<RawRun>,
}

/// Standard deviations as shares of the value; what is left out has a default.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawUncertainty {
    pub(super) belt_velocity_std: Option<Spanned<f64>>,
    pub(super) normal_force_std: Option<Spanned<f64>>,
    pub(super) natural_frequencies_std: Option<Spanned<f64>>,
    pub(super) participations_std: Option<Spanned<f64>>,
}

/// Standard deviations of the stated inputs as shares: of a factor common to all runs, and from run to run.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRig {
    pub(super) belt_velocity_std: Option<Spanned<f64>>,
    pub(super) normal_force_std: Option<Spanned<f64>>,
    pub(super) belt_velocity_run_std: Option<Spanned<f64>>,
    pub(super) normal_force_run_std: Option<Spanned<f64>>,
}

/// One number for all modes, or one for each.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum OneOrEach {
    One(f64),
    Each(Vec<f64>),
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBeam {
    pub(super) natural_frequencies_hz: Option<Vec<Spanned<f64>>>,
    pub(super) damping_ratios: Option<Vec<Spanned<f64>>>,
    pub(super) damping_rates_per_s: Option<Vec<Spanned<f64>>>,
    pub(super) mass_kg: Option<Spanned<f64>>,
    pub(super) masses_kg: Option<Vec<Spanned<f64>>>,
    pub(super) tip_values: Option<Vec<Spanned<f64>>>,
    pub(super) clamp_shares: Option<Vec<Spanned<f64>>>,
    pub(super) natural_frequencies_std_hz: Option<Spanned<OneOrEach>>,
    pub(super) damping_ratios_std: Option<Spanned<OneOrEach>>,
    pub(super) damping_rates_std_per_s: Option<Spanned<OneOrEach>>,
    pub(super) mass_std_kg: Option<Spanned<OneOrEach>>,
    pub(super) tip_values_std: Option<Spanned<OneOrEach>>,
}

/// How to read the CSV files; in `[channels]` for all runs, or in a `[[run]]` for that one.
#[derive(Deserialize, Default, Clone)]
#[serde(deny_unknown_fields)]
pub(super) struct RawChannels {
    pub(super) time_column: Option<String>,
    pub(super) displacement_column: Option<Spanned<String>>,
    pub(super) velocity_column: Option<Spanned<String>>,
    pub(super) acceleration_column: Option<Spanned<String>>,
    pub(super) time_scale: Option<Spanned<f64>>,
    pub(super) displacement_scale: Option<Spanned<f64>>,
    pub(super) velocity_scale: Option<Spanned<f64>>,
    pub(super) acceleration_scale: Option<Spanned<f64>>,
    pub(super) delimiter: Option<Spanned<char>>,
    pub(super) sample_rate_hz: Option<Spanned<f64>>,
    pub(super) belt_velocity_column: Option<String>,
    pub(super) belt_velocity_scale: Option<Spanned<f64>>,
    pub(super) normal_force_column: Option<String>,
    pub(super) normal_force_scale: Option<Spanned<f64>>,
    pub(super) external_force_column: Option<String>,
    pub(super) external_force_scale: Option<Spanned<f64>>,
    pub(super) clamp_acceleration_column: Option<String>,
    pub(super) clamp_acceleration_scale: Option<Spanned<f64>>,
    pub(super) input_interpolation: Option<Interpolation>,
}

// Not `flatten`ed with RawChannels: serde cannot refuse unknown keys there.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRun {
    pub(super) file: Spanned<String>,
    #[serde(default)]
    pub(super) further_files: Vec<String>,
    pub(super) name: Option<String>,
    pub(super) role: Option<Role>,
    pub(super) belt_velocity_m_per_s: Option<Spanned<f64>>,
    pub(super) normal_force_n: Option<Spanned<f64>>,
    pub(super) external_force_n: Option<Spanned<f64>>,
    pub(super) clamp_acceleration_m_per_s2: Option<Spanned<f64>>,
    pub(super) time_column: Option<String>,
    pub(super) displacement_column: Option<Spanned<String>>,
    pub(super) velocity_column: Option<Spanned<String>>,
    pub(super) acceleration_column: Option<Spanned<String>>,
    pub(super) time_scale: Option<Spanned<f64>>,
    pub(super) displacement_scale: Option<Spanned<f64>>,
    pub(super) velocity_scale: Option<Spanned<f64>>,
    pub(super) acceleration_scale: Option<Spanned<f64>>,
    pub(super) delimiter: Option<Spanned<char>>,
    pub(super) sample_rate_hz: Option<Spanned<f64>>,
    pub(super) belt_velocity_column: Option<String>,
    pub(super) belt_velocity_scale: Option<Spanned<f64>>,
    pub(super) normal_force_column: Option<String>,
    pub(super) normal_force_scale: Option<Spanned<f64>>,
    pub(super) external_force_column: Option<String>,
    pub(super) external_force_scale: Option<Spanned<f64>>,
    pub(super) clamp_acceleration_column: Option<String>,
    pub(super) clamp_acceleration_scale: Option<Spanned<f64>>,
    pub(super) input_interpolation: Option<Interpolation>,
}

/// A file of which only `[beam]`, `[sensor]` and `[channels]` count.
#[derive(Deserialize)]
pub(super) struct RawBeamFile {
    #[serde(default)]
    pub(super) beam: RawBeam,
    #[serde(default)]
    pub(super) sensor: RawSensor,
    #[serde(default)]
    pub(super) channels: RawChannels,
}
