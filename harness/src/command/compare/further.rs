//! What further sensors read beside what the model makes there.

use std::ops::Range;

use serde::Serialize;

use crate::diagnose::model::further_sensors::FurtherSensors;
use crate::diagnose::model::known_structure::structure;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::{Campaign, FurtherSensor, Run};
use crate::metric::{line, nrmse};

/// The further sensors of a campaign and what they read of an FMU.
pub(super) struct Further<'a> {
    sensors: &'a [FurtherSensor],
    model: Option<FurtherSensors>,
}

/// One further sensor in one run. Only the numbers go to JSON.
#[derive(Debug, Clone, Serialize)]
pub struct FurtherComparison {
    /// The sensor's name.
    pub name: String,
    /// What it reads.
    pub quantity: &'static str,
    /// Error of the model with factor 1 and zero 0, of the sensor as stated, over the spread of the readings, 1.
    pub nrmse: f64,
    /// The error that a perfect model would have: noise over the spread of the readings, 1.
    pub noise_floor: f64,
    /// Slope of the readings over the model's values, 1: where the motion is right, the factor by which the sensor is off.
    pub factor: f64,
    /// Readings that count.
    pub samples: usize,
    /// SI unit.
    #[serde(skip)]
    pub unit: &'static str,
    /// Readings at the run's sample times; NaN where there is none.
    #[serde(skip)]
    pub measured: Vec<f64>,
    /// The model at the same times, aligned by the first sensor.
    #[serde(skip)]
    pub model: Vec<f64>,
}

impl<'a> Further<'a> {
    /// The sensors of a campaign.
    ///
    /// # Errors
    /// An FMU without an output that a sensor reads.
    pub fn of(fmu: &Fmu, campaign: &'a Campaign) -> Result<Self, Error> {
        let sensors = &campaign.further_sensors[..];
        let model = match sensors.is_empty() {
            true => None,
            false => {
                let structure = structure(fmu, &campaign.beam)?;
                let tip_values = structure.modes().iter().map(|m| m.tip_value).collect();
                Some(FurtherSensors::new(fmu, sensors, tip_values)?)
            }
        };
        Ok(Self { sensors, model })
    }

    /// The FMU's outputs that the sensors read.
    pub fn outputs(&self) -> &[String] {
        self.model.as_ref().map_or(&[], |model| &model.output_names)
    }

    /// What each sensor reads, as it is stated, of these outputs, output after output.
    pub fn read(&self, outputs: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let Some(model) = &self.model else {
            return Vec::new();
        };
        let samples = outputs.first().map_or(0, Vec::len);
        let sensor = |number: usize| {
            let at = |k: usize| model.as_stated(number, &|i| outputs[i][k]);
            (0..samples).map(at).collect()
        };
        (0..self.sensors.len()).map(sensor).collect()
    }

    /// The sensors beside what the model makes, `motions` sensor after sensor; `sticks` tells of each sample of the run whether it
    /// sticks. What jumps does not count beside a transition.
    pub fn compare(
        &self,
        run: &Run,
        motions: Vec<Vec<f64>>,
        sticks: &[bool],
    ) -> Vec<FurtherComparison> {
        let records = self.sensors.iter().zip(&run.further).zip(motions);
        let read = records.filter_map(|((s, record), model)| Some((s, record.as_ref()?, model)));
        read.map(|(sensor, record, model)| {
            let near = near_transitions(sticks, record.beside_jump.ceil() as usize);
            let mut measured = record.values.clone();
            for range in near {
                measured[range].fill(f64::NAN);
            }
            let pairs = measured.iter().zip(&model);
            let counted = pairs.filter(|(y, m)| y.is_finite() && m.is_finite());
            let (readings, values): (Vec<f64>, Vec<f64>) = counted.map(|(y, m)| (*y, *m)).unzip();
            let pairs: Vec<(f64, f64)> = values.iter().copied().zip(readings.clone()).collect();
            FurtherComparison {
                name: sensor.name.clone(),
                quantity: sensor.reading.name(),
                nrmse: nrmse(&readings, &values),
                noise_floor: record.noise_std / super::comparison::spread(&readings),
                factor: line(&pairs).1,
                samples: readings.len(),
                unit: sensor.reading.unit(),
                measured,
                model,
            }
        })
        .collect()
    }
}

/// Samples within `width` of a change between stick and slip.
fn near_transitions(sticks: &[bool], width: usize) -> Vec<Range<usize>> {
    if width == 0 {
        return Vec::new();
    }
    let changes = (1..sticks.len()).filter(|&k| sticks[k] != sticks[k - 1]);
    changes
        .map(|k| k.saturating_sub(width)..(k + width).min(sticks.len()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_jumps_is_left_out_beside_each_transition() {
        let sticks = [true, true, false, false, false, true];
        assert_eq!(near_transitions(&sticks, 1), [1..3, 4..6]);
        assert_eq!(near_transitions(&sticks, 2), [0..4, 3..6]);
        assert!(near_transitions(&sticks, 0).is_empty());
    }
}
