//! Further sensors beside the one that every campaign has: `[[further_sensor]]` of campaign.toml.

use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::Sampling;
use super::campaign_file::check::{ANY, Check, NOT_NEGATIVE, NOT_ZERO, POSITIVE, Rule, line_of};
use super::noise::Noise;
use super::own_clock::Readings;
use super::run::Run;
use super::sensor_place::{RawSensor, SensorPlace};
use crate::error::Error;

/// Default standard deviation of a sensor's factor, as a share: calibrations of vibrometers, accelerometers and load cells state 0.5 to
/// 2 % (ISO 16063-41: 1 %).
const GAIN_STD: f64 = 0.01;
/// Distance in samples from a transition within which what jumps there does not count: it jumps by thousands of times the noise, and of
/// the two samples about a jump that moves a little within its interval each may lie on either side.
pub const BESIDE_JUMP: f64 = 1.5;

/// Standard deviations from what is stated within which a clock's delay is sought: channels that a recorder spreads over one interval, laid
/// over others to a sample, are off by two intervals at most.
const REACH_OF_DELAY: f64 = 3.0;
/// The largest delay that is sought, in samples: a segment, 200 samples or more as a rule, loses a tenth of its readings at each end for
/// it. A longer one shows in the correlation of the records and is to be stated.
const MOST_DELAY: f64 = 20.0;

/// Readings side by side from which a noise can be told.
const SIDE_BY_SIDE: usize = 32;

/// Least standard deviation of a sensor's noise over that of what it reads: 100 dB, more than any sensor's range. Records without noise are
/// a simulation's.
pub const LEAST_NOISE: f64 = 1e-5;

/// What a further sensor reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reading {
    /// Displacement in m.
    Displacement,
    /// Velocity in m/s.
    Velocity,
    /// Acceleration in m/s^2, at the contact alone.
    Acceleration,
    /// Friction force on the structure in N, positive along the belt's motion: a load cell that holds the counterpart.
    FrictionForce,
}

impl Reading {
    /// What it is called, as in campaign.toml.
    pub fn name(self) -> &'static str {
        match self {
            Reading::Displacement => "displacement",
            Reading::Velocity => "velocity",
            Reading::Acceleration => "acceleration",
            Reading::FrictionForce => "friction_force",
        }
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Reading::Displacement => "m",
            Reading::Velocity => "m/s",
            Reading::Acceleration => "m/s^2",
            Reading::FrictionForce => "N",
        }
    }

    /// The FMU's output that is it at the contact.
    pub fn output(self) -> &'static str {
        match self {
            Reading::Displacement => "tip_displacement",
            Reading::Velocity => "tip_velocity",
            Reading::Acceleration => "tip_acceleration",
            Reading::FrictionForce => "friction_force",
        }
    }

    /// Whether it jumps where stick begins or ends.
    pub fn jumps(self) -> bool {
        matches!(self, Reading::Acceleration | Reading::FrictionForce)
    }

    /// Whether it depends on where the sensor looks in a way that mode shapes tell.
    fn has_place(self) -> bool {
        matches!(self, Reading::Displacement | Reading::Velocity)
    }
}

/// A sensor beside the first one, in all runs.
///
/// It reads `g sum_j r_j phi_j q_j + b` (displacement), the same of `q_j'` (velocity), or `g y + b` with y the acceleration of
/// the contact or the friction force: g the factor by which its calibration is off (1), `r_j` the ratios of its place, b a zero of its own in
/// each run; all of it at `t - d`, d the time by which its clock is late. Where its cell is empty, nothing was read.
#[derive(Debug, Clone, PartialEq)]
pub struct FurtherSensor {
    /// What it is called in reports.
    pub name: String,
    /// What it reads.
    pub reading: Reading,
    /// Where it looks.
    pub place: SensorPlace,
    /// Standard deviation of g, 1.
    pub gain_std: f64,
    /// Standard deviation of b in the SI unit; as a share of what is read where it is `None`.
    pub offset_std: Option<f64>,
    /// Standard deviation of its noise in the SI unit; found in its record where it is `None`.
    pub noise_std: Option<f64>,
    /// Its column.
    pub column: String,
    /// Time in s by which its clock, or that of its column, is later than the first sensor's.
    pub delay: f64,
    /// Standard deviation of that in s; `None` for one interval of the samples: channels of a recorder are read one after another within
    /// it, and files of two recorders are laid over each other to a sample.
    pub delay_std: Option<f64>,
    /// Factor of the column to SI units; that of the unit in the header where it is `None`.
    pub scale: Option<f64>,
}

/// How far a sensor's clock may be off beside what is stated of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelayBelief {
    /// Standard deviation in s; 0 where it is known exactly.
    pub std: f64,
    /// Largest delay that is sought, in s.
    pub most: f64,
}

impl DelayBelief {
    /// Of a clock that is known exactly.
    pub const EXACT: Self = Self {
        std: 0.0,
        most: 0.0,
    };
}

impl FurtherSensor {
    /// How far its clock may be off. The delay is that of all runs, so that the shortest interval of their samples counts.
    pub fn delay_belief(&self, runs: &[Run]) -> DelayBelief {
        let is_driven = |run: &Run| run.inputs.clamp_acceleration.series.is_some();
        if self.reading == Reading::Acceleration && runs.iter().any(is_driven) {
            // The clamp's motion has been taken off at the instants that are stated.
            return DelayBelief::EXACT;
        }
        let intervals = runs.iter().map(Run::sample_interval);
        let interval = intervals.fold(f64::INFINITY, f64::min);
        let std = self.delay_std.unwrap_or(interval);
        DelayBelief {
            std,
            most: (REACH_OF_DELAY * std).min(MOST_DELAY * interval),
        }
    }
}

/// What a further sensor read in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct FurtherRecord {
    /// Values in the SI unit at the run's sample times; NaN where nothing was read.
    pub values: Vec<f64>,
    /// Standard deviation of its noise.
    pub noise_std: f64,
    /// Distance in samples from a transition within which it does not count; 0 for what does not jump there.
    pub beside_jump: f64,
}

impl FurtherRecord {
    /// The record of a sensor in the file `path` at the sample times `time` in s, perhaps interpolated there. `None` where it read nothing
    /// that varies.
    ///
    /// # Errors
    /// [`Error::FurtherSensorNoise`] where no noise is stated and gaps are too many to find it between them.
    pub(super) fn of(
        sensor: &FurtherSensor,
        path: &Path,
        time: &[f64],
        readings: Readings,
    ) -> Result<Option<Self>, Error> {
        let values = readings.values;
        let read = time.iter().zip(&values).filter(|(_, y)| y.is_finite());
        let (times, read): (Vec<f64>, Vec<f64>) = read.map(|(t, y)| (*t, *y)).unzip();
        if read.len() < super::run_file::FEWEST_SAMPLES {
            return Ok(None);
        }
        if read.iter().all(|y| *y == read[0]) {
            return Ok(None);
        }
        let sampling = Sampling::of(&times);
        let stretches = sampling.unbroken();
        let found = || match stretches.iter().map(|stretch| stretch.len()).max() {
            Some(longest) if longest >= SIDE_BY_SIDE => {
                Some(Noise::estimate(&read, &stretches).of_sensor())
            }
            _ => None,
        };
        let known = sensor.noise_std.or(readings.noise);
        let Some(noise_std) = known.or_else(found) else {
            return Err(Error::FurtherSensorNoise {
                path: path.to_owned(),
                sensor: sensor.name.clone(),
                samples: read.len(),
                rows: time.len(),
            });
        };
        Ok(Some(Self {
            values,
            noise_std,
            beside_jump: match sensor.reading.jumps() {
                true => BESIDE_JUMP + readings.drawn_over / Sampling::of(time).interval,
                false => 0.0,
            },
        }))
    }

    /// The first samples of it.
    pub(super) fn beginning(&self, samples: usize) -> Self {
        Self {
            values: self.values[..samples.min(self.values.len())].to_vec(),
            ..*self
        }
    }
}

/// The table as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFurtherSensor {
    quantity: Reading,
    column: Spanned<String>,
    name: Option<String>,
    scale: Option<Spanned<f64>>,
    gain_std: Option<Spanned<f64>>,
    offset_std: Option<Spanned<f64>>,
    noise_std: Option<Spanned<f64>>,
    delay_s: Option<Spanned<f64>>,
    delay_std_s: Option<Spanned<f64>>,
    position: Option<Spanned<f64>>,
    position_std: Option<Spanned<f64>>,
    mode_ratios: Option<Vec<Spanned<f64>>>,
    mode_ratios_std: Option<Spanned<f64>>,
}

const GAIN: Rule = (
    |v| v > 0.0 && v <= 0.5,
    "it is a share of the factor, above 0 and at most 0.5",
);

impl Check<'_> {
    /// The further sensors; `modes` is the number of natural frequencies stated, 0 for none.
    pub(super) fn further_sensors(
        &self,
        raw: Vec<RawFurtherSensor>,
        modes: usize,
    ) -> Result<Vec<FurtherSensor>, Error> {
        let mut sensors: Vec<FurtherSensor> = Vec::new();
        for raw in raw {
            let problem = |problem: String| Error::CampaignFile {
                path: self.path.to_owned(),
                line: line_of(self.text, raw.column.span()),
                problem,
            };
            let key = |item: &str| format!("[[further_sensor]] {item}");
            let number = |item: &str, unit, rule, value: Option<Spanned<f64>>| match value {
                Some(value) => self.number(&key(item), unit, rule, value).map(Some),
                None => Ok(None),
            };
            let column = raw.column.get_ref().clone();
            let name = raw.name.unwrap_or_else(|| column.clone());
            if let Some(other) = sensors.iter().find(|s| s.name == name) {
                return Err(problem(format!(
                    "two [[further_sensor]] are called '{}'; give one of them another name",
                    other.name
                )));
            }
            let place = RawSensor {
                position: raw.position,
                position_std: raw.position_std,
                mode_ratios: raw.mode_ratios,
                mode_ratios_std: raw.mode_ratios_std,
                offset_std: None,
                high_pass_hz: None,
            };
            let place = self.sensor("[[further_sensor]]", place, modes)?;
            if !place.is_tip() && !raw.quantity.has_place() {
                return Err(problem(format!(
                    "'{name}' reads {} away from the contact; only displacements and velocities may be read there, so leave out its place",
                    raw.quantity.name()
                )));
            }
            sensors.push(FurtherSensor {
                scale: number("scale", "1", NOT_ZERO, raw.scale)?,
                gain_std: number("gain_std", "1", GAIN, raw.gain_std)?.unwrap_or(GAIN_STD),
                offset_std: number("offset_std", raw.quantity.unit(), POSITIVE, raw.offset_std)?,
                delay: number("delay_s", "s", ANY, raw.delay_s)?.unwrap_or(0.0),
                delay_std: number("delay_std_s", "s", NOT_NEGATIVE, raw.delay_std_s)?,
                noise_std: number("noise_std", raw.quantity.unit(), POSITIVE, raw.noise_std)?,
                reading: raw.quantity,
                name,
                place,
                column,
            });
        }
        Ok(sensors)
    }
}
