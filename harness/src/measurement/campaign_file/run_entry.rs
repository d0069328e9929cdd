//! One `[[run]]`: its file, its channels and its inputs.

use super::check::{ANY, Check, NOT_NEGATIVE, NOT_ZERO, POSITIVE};
use super::keys::{RawChannels, RawRun};
use crate::error::Error;
use crate::measurement::csv_table::Channels;
use crate::measurement::{Interpolation, Role};
use std::path::Path;
use toml::Spanned;

/// One `[[run]]`.
pub(in crate::measurement) struct RunEntry {
    pub name: String,
    pub file: String,
    /// Files of further sensors.
    pub further_files: Vec<String>,
    pub role: Option<Role>,
    pub belt_velocity: f64,
    pub normal_force: f64,
    /// Constant force on the tip beside what a column gives, N.
    pub external_force: f64,
    /// Constant acceleration of the clamp beside what a column gives, m/s^2.
    pub clamp_acceleration: f64,
    /// What inputs do between their samples, where the file says it.
    pub interpolation: Option<Interpolation>,
    pub channels: Channels,
}

impl Check<'_> {
    pub(super) fn run(&self, raw: RawRun, common: &RawChannels) -> Result<RunEntry, Error> {
        let common = common.clone();
        let place = raw.file.span();
        let file = raw.file.into_inner();
        // A number in the run comes before a column that all runs have.
        let column = |own: Option<String>, common: Option<String>, stated: bool| {
            own.or(common.filter(|_| !stated))
        };
        let belt_column = column(
            raw.belt_velocity_column,
            common.belt_velocity_column,
            raw.belt_velocity_m_per_s.is_some(),
        );
        let load_column = column(
            raw.normal_force_column,
            common.normal_force_column,
            raw.normal_force_n.is_some(),
        );
        let push_column = raw.external_force_column.or(common.external_force_column);
        let clamp_column = raw
            .clamp_acceleration_column
            .or(common.clamp_acceleration_column);
        let constant = |key: &str, unit, given: Option<Spanned<f64>>| match given {
            None => Ok(0.0),
            Some(given) => self.number(key, unit, ANY, given),
        };
        let scale = |key, rule, own: Option<Spanned<f64>>, common: Option<Spanned<f64>>| match own
            .or(common)
        {
            Some(value) => self.number(key, "1", rule, value).map(Some),
            None => Ok(None),
        };
        let of_run = [
            (raw.displacement_column, raw.displacement_scale),
            (raw.velocity_column, raw.velocity_scale),
            (raw.acceleration_column, raw.acceleration_scale),
        ];
        let of_all = [
            (common.displacement_column, common.displacement_scale),
            (common.velocity_column, common.velocity_scale),
            (common.acceleration_column, common.acceleration_scale),
        ];
        let measured = self.measured(of_run, of_all)?;
        let stem = || {
            Path::new(&file)
                .file_stem()
                .map(|s| s.to_string_lossy().into_owned())
        };
        Ok(RunEntry {
            name: raw
                .name
                .clone()
                .or_else(stem)
                .unwrap_or_else(|| file.clone()),
            role: raw.role,
            belt_velocity: self.constant(
                ("belt_velocity_m_per_s", "m/s", ANY),
                raw.belt_velocity_m_per_s,
                ("belt_velocity_column", belt_column.is_some()),
                &place,
            )?,
            normal_force: self.constant(
                ("normal_force_n", "N", NOT_NEGATIVE),
                raw.normal_force_n,
                ("normal_force_column", load_column.is_some()),
                &place,
            )?,
            external_force: constant("[[run]] external_force_n", "N", raw.external_force_n)?,
            clamp_acceleration: constant(
                "[[run]] clamp_acceleration_m_per_s2",
                "m/s^2",
                raw.clamp_acceleration_m_per_s2,
            )?,
            interpolation: raw.input_interpolation.or(common.input_interpolation),
            channels: Channels {
                time_column: raw.time_column.or(common.time_column),
                measured,
                time_scale: scale("time_scale", POSITIVE, raw.time_scale, common.time_scale)?,
                delimiter: self.delimiter(raw.delimiter.or(common.delimiter))?,
                sample_rate: match raw.sample_rate_hz.or(common.sample_rate_hz) {
                    Some(rate) => Some(self.number("sample_rate_hz", "Hz", POSITIVE, rate)?),
                    None => None,
                },
                inputs: [
                    (
                        belt_column,
                        scale(
                            "belt_velocity_scale",
                            NOT_ZERO,
                            raw.belt_velocity_scale,
                            common.belt_velocity_scale,
                        )?,
                    ),
                    (
                        load_column,
                        scale(
                            "normal_force_scale",
                            POSITIVE,
                            raw.normal_force_scale,
                            common.normal_force_scale,
                        )?,
                    ),
                    (
                        push_column,
                        scale(
                            "external_force_scale",
                            NOT_ZERO,
                            raw.external_force_scale,
                            common.external_force_scale,
                        )?,
                    ),
                    (
                        clamp_column,
                        scale(
                            "clamp_acceleration_scale",
                            NOT_ZERO,
                            raw.clamp_acceleration_scale,
                            common.clamp_acceleration_scale,
                        )?,
                    ),
                ],
            },
            further_files: raw.further_files,
            file,
        })
    }
}
