//! `campaign.toml`: its keys, and the checks on its numbers.

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::csv_table::Channels;
use super::further_sensor::{FurtherSensor, RawFurtherSensor};
use super::sensor_place::{RawSensor, SensorPlace};
use super::uncertainty::{OfModes, Uncertainty};
use super::{BeamKnowledge, Interpolation, Role};
use crate::error::Error;

/// The file's content, checked.
pub(super) struct CampaignFile {
    pub name: Option<String>,
    pub beam: BeamKnowledge,
    pub uncertainty: Uncertainty,
    pub further_sensors: Vec<FurtherSensor>,
    pub runs: Vec<RunEntry>,
}

/// One `[[run]]`.
pub(super) struct RunEntry {
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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    name: Option<String>,
    #[serde(default)]
    beam: RawBeam,
    #[serde(default)]
    uncertainty: RawUncertainty,
    #[serde(default)]
    rig: RawRig,
    #[serde(default)]
    sensor: RawSensor,
    #[serde(default)]
    further_sensor: Vec<RawFurtherSensor>,
    #[serde(default)]
    channels: RawChannels,
    #[serde(default)]
    run: Vec<RawRun>,
}

/// Standard deviations as shares of the value; what is left out has a default.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawUncertainty {
    belt_velocity_std: Option<Spanned<f64>>,
    normal_force_std: Option<Spanned<f64>>,
    natural_frequencies_std: Option<Spanned<f64>>,
    participations_std: Option<Spanned<f64>>,
}

/// Standard deviations of the stated inputs as shares: of a factor common to all runs, and from run to run.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawRig {
    belt_velocity_std: Option<Spanned<f64>>,
    normal_force_std: Option<Spanned<f64>>,
    belt_velocity_run_std: Option<Spanned<f64>>,
    normal_force_run_std: Option<Spanned<f64>>,
}

/// One number for all modes, or one for each.
#[derive(Deserialize)]
#[serde(untagged)]
enum OneOrEach {
    One(f64),
    Each(Vec<f64>),
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawBeam {
    natural_frequencies_hz: Option<Vec<Spanned<f64>>>,
    damping_ratios: Option<Vec<Spanned<f64>>>,
    damping_rates_per_s: Option<Vec<Spanned<f64>>>,
    mass_kg: Option<Spanned<f64>>,
    masses_kg: Option<Vec<Spanned<f64>>>,
    tip_values: Option<Vec<Spanned<f64>>>,
    clamp_shares: Option<Vec<Spanned<f64>>>,
    natural_frequencies_std_hz: Option<Spanned<OneOrEach>>,
    damping_ratios_std: Option<Spanned<OneOrEach>>,
    damping_rates_std_per_s: Option<Spanned<OneOrEach>>,
    mass_std_kg: Option<Spanned<OneOrEach>>,
    tip_values_std: Option<Spanned<OneOrEach>>,
}

/// How to read the CSV files; in `[channels]` for all runs, or in a `[[run]]` for that one.
#[derive(Deserialize, Default, Clone)]
#[serde(deny_unknown_fields)]
struct RawChannels {
    time_column: Option<String>,
    displacement_column: Option<Spanned<String>>,
    velocity_column: Option<Spanned<String>>,
    acceleration_column: Option<Spanned<String>>,
    time_scale: Option<Spanned<f64>>,
    displacement_scale: Option<Spanned<f64>>,
    velocity_scale: Option<Spanned<f64>>,
    acceleration_scale: Option<Spanned<f64>>,
    delimiter: Option<Spanned<char>>,
    sample_rate_hz: Option<Spanned<f64>>,
    belt_velocity_column: Option<String>,
    belt_velocity_scale: Option<Spanned<f64>>,
    normal_force_column: Option<String>,
    normal_force_scale: Option<Spanned<f64>>,
    external_force_column: Option<String>,
    external_force_scale: Option<Spanned<f64>>,
    clamp_acceleration_column: Option<String>,
    clamp_acceleration_scale: Option<Spanned<f64>>,
    input_interpolation: Option<Interpolation>,
}

// Not `flatten`ed with RawChannels: serde cannot refuse unknown keys there.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRun {
    file: Spanned<String>,
    #[serde(default)]
    further_files: Vec<String>,
    name: Option<String>,
    role: Option<Role>,
    belt_velocity_m_per_s: Option<Spanned<f64>>,
    normal_force_n: Option<Spanned<f64>>,
    external_force_n: Option<Spanned<f64>>,
    clamp_acceleration_m_per_s2: Option<Spanned<f64>>,
    time_column: Option<String>,
    displacement_column: Option<Spanned<String>>,
    velocity_column: Option<Spanned<String>>,
    acceleration_column: Option<Spanned<String>>,
    time_scale: Option<Spanned<f64>>,
    displacement_scale: Option<Spanned<f64>>,
    velocity_scale: Option<Spanned<f64>>,
    acceleration_scale: Option<Spanned<f64>>,
    delimiter: Option<Spanned<char>>,
    sample_rate_hz: Option<Spanned<f64>>,
    belt_velocity_column: Option<String>,
    belt_velocity_scale: Option<Spanned<f64>>,
    normal_force_column: Option<String>,
    normal_force_scale: Option<Spanned<f64>>,
    external_force_column: Option<String>,
    external_force_scale: Option<Spanned<f64>>,
    clamp_acceleration_column: Option<String>,
    clamp_acceleration_scale: Option<Spanned<f64>>,
    input_interpolation: Option<Interpolation>,
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
        runs,
    })
}

/// A file of which only `[beam]`, `[sensor]` and `[channels]` count.
#[derive(Deserialize)]
struct RawBeamFile {
    #[serde(default)]
    beam: RawBeam,
    #[serde(default)]
    sensor: RawSensor,
    #[serde(default)]
    channels: RawChannels,
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
        beam: check.beam(raw.beam, raw.sensor)?.0,
        uncertainty: Uncertainty::default(),
        further_sensors: Vec::new(),
        runs: vec![check.run(run, &raw.channels)?],
    })
}

/// The line, counted from 1, on which a stretch of a text begins.
pub(crate) fn line_of(text: &str, span: Range<usize>) -> usize {
    1 + text
        .bytes()
        .take(span.start)
        .filter(|b| *b == b'\n')
        .count()
}

/// The checks; knows the text, so that it can name lines.
pub(super) struct Check<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

/// What a number must be.
pub(super) type Rule = (fn(f64) -> bool, &'static str);

pub(super) const POSITIVE: Rule = (|v| v > 0.0, "it must be greater than zero");
const NOT_NEGATIVE: Rule = (|v| v >= 0.0, "it must not be negative");
pub(super) const NOT_ZERO: Rule = (|v| v != 0.0, "it must not be zero");
const SHARE: Rule = (
    |v| (1e-6..=0.5).contains(&v),
    "it is a share of the value, from 0.000001 to 0.5",
);
pub(super) const ANY: Rule = (|_| true, "it must be a finite number");

impl Check<'_> {
    pub(super) fn number(
        &self,
        key: &str,
        unit: &'static str,
        (holds, rule): Rule,
        value: Spanned<f64>,
    ) -> Result<f64, Error> {
        let line = line_of(self.text, value.span());
        let value = value.into_inner();
        if value.is_finite() && holds(value) {
            return Ok(value);
        }
        Err(Error::CampaignValue {
            path: self.path.to_owned(),
            line: Some(line),
            key: key.to_owned(),
            value,
            unit,
            rule,
        })
    }

    fn list(
        &self,
        key: &str,
        unit: &'static str,
        rule: Rule,
        values: Option<Vec<Spanned<f64>>>,
    ) -> Result<Vec<f64>, Error> {
        values
            .unwrap_or_default()
            .into_iter()
            .map(|v| self.number(key, unit, rule, v))
            .collect()
    }

    fn delimiter(&self, given: Option<Spanned<char>>) -> Result<Option<u8>, Error> {
        let Some(given) = given else {
            return Ok(None);
        };
        let line = line_of(self.text, given.span());
        let delimiter = given.into_inner();
        // What numbers, comments and quotes are made of can't stand between them.
        let fits = (delimiter.is_ascii_punctuation() && !".+-_#\"".contains(delimiter))
            || delimiter == ' '
            || delimiter == '\t';
        match u8::try_from(delimiter) {
            Ok(byte) if fits => Ok(Some(byte)),
            _ => Err(Error::CampaignFile {
                path: self.path.to_owned(),
                line,
                problem: format!(
                    "delimiter = {delimiter:?} can't separate numbers; give \",\", \";\", \"\\t\", \" \" or another sign of punctuation"
                ),
            }),
        }
    }

    fn uncertainty(
        &self,
        raw: RawUncertainty,
        rig: RawRig,
        of_modes: OfModes,
    ) -> Result<Uncertainty, Error> {
        let usual = Uncertainty::default();
        let share = |key: &str, given: Option<Spanned<f64>>, usual: f64| match given {
            Some(value) => self.number(key, "1", SHARE, value),
            None => Ok(usual),
        };
        // The same key in both tables is one too many: neither is more right.
        let both = |key: &str, a: &Option<Spanned<f64>>, b: &Option<Spanned<f64>>| match (a, b) {
            (Some(_), Some(again)) => Err(Error::CampaignFile {
                path: self.path.to_owned(),
                line: line_of(self.text, again.span()),
                problem: format!("{key} stands under [rig] and under [uncertainty]; leave one out"),
            }),
            _ => Ok(()),
        };
        both(
            "belt_velocity_std",
            &rig.belt_velocity_std,
            &raw.belt_velocity_std,
        )?;
        both(
            "normal_force_std",
            &rig.normal_force_std,
            &raw.normal_force_std,
        )?;
        Ok(Uncertainty {
            zero_std: usual.zero_std,
            belt_velocity_std: share(
                "belt_velocity_std",
                rig.belt_velocity_std.or(raw.belt_velocity_std),
                usual.belt_velocity_std,
            )?,
            normal_force_std: share(
                "normal_force_std",
                rig.normal_force_std.or(raw.normal_force_std),
                usual.normal_force_std,
            )?,
            belt_velocity_run_std: share(
                "[rig] belt_velocity_run_std",
                rig.belt_velocity_run_std,
                usual.belt_velocity_run_std,
            )?,
            normal_force_run_std: share(
                "[rig] normal_force_run_std",
                rig.normal_force_run_std,
                usual.normal_force_run_std,
            )?,
            natural_frequencies_std: share(
                "[uncertainty] natural_frequencies_std",
                raw.natural_frequencies_std,
                usual.natural_frequencies_std,
            )?,
            participations_std: share(
                "[uncertainty] participations_std",
                raw.participations_std,
                usual.participations_std,
            )?,
            of_modes,
        })
    }

    /// Standard deviations of the modes as shares of `values`; empty where none are stated. One number stands for all modes.
    fn shares_of_modes(
        &self,
        (key, unit): (&str, &'static str),
        given: Option<Spanned<OneOrEach>>,
        (values_key, values): (&str, &[f64]),
    ) -> Result<Vec<f64>, Error> {
        let Some(given) = given else {
            return Ok(Vec::new());
        };
        let span = given.span();
        let stds = match given.into_inner() {
            OneOrEach::One(std) => vec![std; values.len().max(1)],
            OneOrEach::Each(stds) => stds,
        };
        let stds = stds.into_iter().map(|s| Spanned::new(span.clone(), s));
        let stds = self.list(key, unit, POSITIVE, Some(stds.collect()))?;
        if values.is_empty() {
            return Err(Error::CampaignFile {
                path: self.path.to_owned(),
                line: line_of(self.text, span),
                problem: format!(
                    "{key} says how well {values_key} is known, which is not stated; state both under [beam]"
                ),
            });
        }
        if stds.len() != values.len() {
            return Err(Error::CampaignModes {
                path: self.path.to_owned(),
                key: key.to_owned(),
                found: stds.len(),
                expected: values.len(),
            });
        }
        // A damping ratio of zero has no share: its belief is as wide as where nothing is stated.
        let shares = stds.iter().zip(values);
        Ok(shares
            .map(|(std, value)| match *value == 0.0 {
                true => f64::NAN,
                false => (std / value.abs()).clamp(1e-6, 0.5),
            })
            .collect())
    }

    fn beam(&self, raw: RawBeam, sensor: RawSensor) -> Result<(BeamKnowledge, OfModes), Error> {
        let mut beam = BeamKnowledge {
            natural_frequencies_hz: self.list(
                "[beam] natural_frequencies_hz",
                "Hz",
                NOT_NEGATIVE,
                raw.natural_frequencies_hz,
            )?,
            damping_ratios: self.list(
                "[beam] damping_ratios",
                "1",
                NOT_NEGATIVE,
                raw.damping_ratios,
            )?,
            damping_rates_per_s: self.list(
                "[beam] damping_rates_per_s",
                "1/s",
                NOT_NEGATIVE,
                raw.damping_rates_per_s,
            )?,
            masses_kg: self.list("[beam] masses_kg", "kg", POSITIVE, raw.masses_kg)?,
            tip_values: self.list("[beam] tip_values", "1", NOT_ZERO, raw.tip_values)?,
            clamp_shares: self.list("[beam] clamp_shares", "1", ANY, raw.clamp_shares)?,
            sensor: SensorPlace::default(),
        };
        let modes = beam.natural_frequencies_hz.len();
        if let Some(mass) = raw.mass_kg {
            let mass = self.number("[beam] mass_kg", "kg", POSITIVE, mass)?;
            if beam.masses_kg.is_empty() {
                // Without frequencies the number of modes is the FMU's to say; one entry then stands for all.
                beam.masses_kg = vec![mass; modes.max(1)];
            }
        }
        beam.sensor = self.sensor("[sensor]", sensor, modes)?;
        let lists = [
            ("damping_ratios", beam.damping_ratios.len()),
            ("damping_rates_per_s", beam.damping_rates_per_s.len()),
            ("masses_kg", beam.masses_kg.len()),
            ("tip_values", beam.tip_values.len()),
            ("clamp_shares", beam.clamp_shares.len()),
        ];
        match lists
            .into_iter()
            .find(|(_, n)| modes > 0 && *n > 0 && *n != modes)
        {
            None => {
                let of_modes = OfModes {
                    frequencies: self.shares_of_modes(
                        ("natural_frequencies_std_hz", "Hz"),
                        raw.natural_frequencies_std_hz,
                        ("natural_frequencies_hz", &beam.natural_frequencies_hz),
                    )?,
                    damping_ratios: self.shares_of_modes(
                        ("damping_ratios_std", "1"),
                        raw.damping_ratios_std,
                        ("damping_ratios", &beam.damping_ratios),
                    )?,
                    damping_rates: self.shares_of_modes(
                        ("damping_rates_std_per_s", "1/s"),
                        raw.damping_rates_std_per_s,
                        ("damping_rates_per_s", &beam.damping_rates_per_s),
                    )?,
                    masses: self.shares_of_modes(
                        ("mass_std_kg", "kg"),
                        raw.mass_std_kg,
                        ("mass_kg", &beam.masses_kg),
                    )?,
                    tip_values: self.shares_of_modes(
                        ("tip_values_std", "1"),
                        raw.tip_values_std,
                        ("tip_values", &beam.tip_values),
                    )?,
                };
                Ok((beam, of_modes))
            }
            Some((key, found)) => Err(Error::CampaignModes {
                path: self.path.to_owned(),
                key: key.to_owned(),
                found,
                expected: modes,
            }),
        }
    }

    /// The constant value of an input; with a column it may be left out, and is then its mean.
    fn constant(
        &self,
        (key, unit, rule): (&'static str, &'static str, Rule),
        value: Option<Spanned<f64>>,
        column: (&'static str, bool),
        run: &Range<usize>,
    ) -> Result<f64, Error> {
        let problem = match (value, column) {
            (Some(value), (_, false)) => {
                return self.number(&format!("[[run]] {key}"), unit, rule, value);
            }
            (None, (_, true)) => return Ok(0.0),
            (None, (column, false)) => {
                format!(
                    "a [[run]] lacks {key}: give it, or {column} where the run's file has it as a column"
                )
            }
            (Some(_), (column, true)) => {
                format!("a [[run]] has both {key} and {column}: give the number or the column")
            }
        };
        Err(Error::CampaignFile {
            path: self.path.to_owned(),
            line: line_of(self.text, run.clone()),
            problem,
        })
    }

    fn run(&self, raw: RawRun, common: &RawChannels) -> Result<RunEntry, Error> {
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
