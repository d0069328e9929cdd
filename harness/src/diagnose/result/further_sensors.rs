//! What a diagnosis says of each further sensor: how well its readings are met, and how far off it is.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::model::parameter::{Kind, SensorConstant};
use crate::diagnose::model::problem::Problem;
use crate::diagnose::validation::estimate::{Estimate, estimate};
use crate::measurement::Reading;
use serde::Serialize;

/// A further sensor, as the model that the diagnosis ends with has it.
#[derive(Debug, Clone, Serialize)]
pub struct FoundSensor {
    /// What it is called.
    pub name: String,
    /// What it reads.
    pub quantity: Reading,
    /// SI unit of that.
    pub unit: &'static str,
    /// Mean standard deviation of its noise over the runs in which it read something, in that unit; NaN where in none.
    pub noise_std: f64,
    /// Factor of its readings.
    pub gain: Option<Estimate>,
    /// Time by which its clock is later than stated; absent where that is known exactly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay: Option<Estimate>,
    /// Mode shapes where it looks over those at the contact; empty for a sensor there.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mode_ratios: Vec<Estimate>,
}

/// The further sensors of a campaign.
pub fn found_sensors(problem: &Problem, fitted: &FittedHypothesis) -> Vec<FoundSensor> {
    let h = &fitted.hypothesis;
    let estimates = |number: usize, wanted: fn(SensorConstant) -> bool| -> Vec<Estimate> {
        let is_it = |kind: Kind| matches!(kind, Kind::Sensor(n, of) if n == number && wanted(of));
        let places = (0..h.shared.len()).filter(|&i| is_it(h.shared[i].kind));
        places.map(|i| estimate(h, &fitted.fit, i)).collect()
    };
    let one = |(number, sensor): (usize, &crate::measurement::FurtherSensor)| {
        let records = problem.campaign.runs.iter();
        let noise = records.filter_map(|run| Some(run.further.get(number)?.as_ref()?.noise_std));
        let noise: Vec<f64> = noise.collect();
        FoundSensor {
            name: sensor.name.clone(),
            quantity: sensor.reading,
            unit: sensor.reading.unit(),
            noise_std: noise.iter().sum::<f64>() / noise.len() as f64,
            gain: estimates(number, |of| of == SensorConstant::Gain).pop(),
            delay: estimates(number, |of| of == SensorConstant::Delay).pop(),
            mode_ratios: estimates(number, |of| matches!(of, SensorConstant::Ratio(_))),
        }
    };
    let sensors = problem.campaign.further_sensors.iter().enumerate();
    sensors.map(one).collect()
}
