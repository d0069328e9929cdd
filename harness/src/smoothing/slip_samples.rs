//! Samples of the smoothed motion in slip.

use super::smoothed_run::Smoothing;
use crate::measurement::Run;
use crate::observer::PhaseMode;

/// Time in s about a transition in which the smoothed force can't follow.
const CLEAR: f64 = 4e-4;

/// A sample in slip.
#[derive(Debug, Clone, Copy)]
pub struct SlipSample {
    /// Time since the run began in s.
    pub time: f64,
    /// Distance in m that belt and tip have moved against each other since then.
    pub travel: f64,
    /// Relative velocity in m/s.
    pub relative_velocity: f64,
    /// Smoothed force in N, positive along the belt's motion.
    pub force: f64,
    /// Force in N by the free characteristic.
    pub expected: f64,
}

/// Slip samples of one run, without what a characteristic expects; none where nothing is pressed on, so that nothing rubs.
pub fn slip_of_run(run: &Run, smoothing: &Smoothing) -> Vec<SlipSample> {
    if run.normal_force == 0.0 {
        return Vec::new();
    }
    let stick_slip = &smoothing.stick_slip;
    let smoothed = &stick_slip.smoothed;
    let h = smoothed.sample_interval;
    let mut out = Vec::new();
    for phase in stick_slip
        .phases
        .iter()
        .filter(|p| p.mode != PhaseMode::Stick)
    {
        for k in phase.first..phase.past {
            let time = k as f64 * h;
            if time > phase.start + CLEAR && time < phase.end - CLEAR {
                out.push(SlipSample {
                    time,
                    travel: smoothing.belt_path.at(time)
                        - (smoothed.displacement[k] - smoothed.displacement[0]),
                    relative_velocity: stick_slip.relative_velocity[k],
                    force: smoothed.force[k],
                    expected: f64::NAN,
                });
            }
        }
    }
    out
}
