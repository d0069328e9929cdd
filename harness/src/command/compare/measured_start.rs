//! Where a record's tip starts, and how far it bends.

use crate::diagnose::model::friction_prior::StartFriction;
use crate::diagnose::model::known_structure::structure;
use crate::fmu::Fmu;
use crate::measurement::{BeamKnowledge, Measurand, Run};
use crate::metric::{LEAST_REST, integral, quantile, resting_stick, stick_fraction, velocity};

/// Samples to either side for the velocity at the start.
const START_HALF_WIDTH: usize = 5;

/// Displacement (m) and velocity (m/s) of the tip at the start, and the farthest that it bends along the belt, m; about, where the sensor looks
/// elsewhere.
///
/// A velocity does not tell where the tip is: its displacement, the integral of the velocity, is taken to swing about the
/// deflection of the friction that the FMU starts with. Of an acceleration the velocity is that of [`resting_stick`].
pub(super) fn measured_start(fmu: &Fmu, beam: &BeamKnowledge, run: &Run) -> ((f64, f64), f64) {
    let end = if run.belt_velocity < 0.0 {
        0.005
    } else {
        0.995
    };
    let ends = 2 * START_HALF_WIDTH;
    let share = beam.seen_share();
    let measured: Vec<f64> = run.measured.iter().map(|y| y / share).collect();
    let first = &measured[..ends];
    let by_velocity = |velocity: &[f64], speed: f64| {
        let bent = friction_deflection(fmu, beam, run);
        let swing = integral(&run.time, velocity);
        ((bent + swing[0], speed), bent + quantile(&swing, end))
    };
    match run.measurand {
        Measurand::Displacement => {
            let speed = velocity(&run.time[..ends], first, START_HALF_WIDTH)[0];
            ((measured[0], speed), quantile(&measured, end))
        }
        Measurand::Velocity => {
            let speed = first.iter().sum::<f64>() / ends as f64;
            by_velocity(&measured, speed)
        }
        Measurand::Acceleration => {
            let (belt, noise) = (run.belt_velocity, run.noise.std);
            let found = resting_stick(&run.time, &measured, belt, noise);
            if stick_fraction(&run.time, &found.sticks) < LEAST_REST {
                // The integral drifts. Bent by friction, a tip at rest turns at twice the deflection at most.
                let bent = friction_deflection(fmu, beam, run);
                return ((bent, 0.0), 2.0 * bent);
            }
            by_velocity(&found.velocity, found.velocity[0])
        }
    }
}

/// Static deflection (m) under the friction at the belt's speed that the FMU's start values have; 0 where it has none, and
/// where a mass slides freely.
fn friction_deflection(fmu: &Fmu, beam: &BeamKnowledge, run: &Run) -> f64 {
    match (StartFriction::of(fmu), structure(fmu, beam)) {
        (Ok(friction), Ok(structure)) if !structure.is_free() => {
            let speed = run.belt_velocity;
            let force = friction.at(speed.abs()) * run.normal_force * speed.signum();
            // Without a coefficient there is no force to start from.
            let deflection = structure.static_compliance() * force;
            if deflection.is_finite() {
                deflection
            } else {
                0.0
            }
        }
        _ => 0.0,
    }
}
