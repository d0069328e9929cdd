//! A run for tests: pushed by a force, sampled every millisecond.

use crate::measurement::{
    Excitation, InputSeries, InputSignals, Interpolation, Measurand, Noise, Run, Sampling,
};
use crate::observer::{Mode, Structure};

/// A run pushed by `force`, sampled every ms.
pub fn pushed(force: impl Fn(f64) -> f64, belt: Option<fn(f64) -> f64>) -> Run {
    let time: Vec<f64> = (0..1001).map(|k| 2.0 + 1e-3 * f64::from(k)).collect();
    let series = |of: &dyn Fn(f64) -> f64| InputSeries {
        column: "input".into(),
        values: time.iter().map(|t| of(t - 2.0)).collect(),
        between: Interpolation::Linear.into(),
    };
    Run {
        name: "pushed".into(),
        file: "pushed.csv".into(),
        further_files: Vec::new(),
        role: None,
        belt_velocity: 0.1,
        normal_force: 0.0,
        inputs: InputSignals {
            belt_velocity: belt.map(|of| series(&of)),
            external_force: Excitation {
                series: Some(series(&force)),
                constant: 0.0,
            },
            ..InputSignals::default()
        },
        measurand: Measurand::Displacement,
        measured: vec![0.0; time.len()],
        further: Vec::new(),
        sampling: Sampling::of(&time),
        noise: Noise {
            std: 1e-6,
            resolution: 1e-9,
            is_white: true,
        },
        time,
        faults: Vec::new(),
        understood: None,
    }
}

/// Modes by frequency (Hz), damping ratio (1), mass (kg) and tip value (1).
pub fn structure(modes: &[(f64, f64, f64, f64)]) -> Structure {
    let mode = |&(frequency_hz, damping_ratio, mass_kg, tip_value)| Mode {
        frequency_hz,
        damping_ratio,
        damping_rate: 0.0,
        mass_kg,
        tip_value,
        sensor_ratio: 1.0,
        clamp_share: 1.0,
    };
    Structure::new(modes.iter().map(mode).collect()).unwrap()
}
