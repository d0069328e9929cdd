//! The break-aways of a run: the force, the place and the dwell of each.

use crate::measurement::Run;
use crate::metric::line;
use crate::observer::PhaseMode;
use crate::smoothing::Smoothing;

/// Time in s before a transition in which the smoothed force can't follow, ...
const CLEAR: f64 = 4e-4;
/// ..., samples in which it can't, ...
const CLEAR_SAMPLES: f64 = 4.0;
/// ..., and the time in s before that from which the force is carried on, ...
const BEFORE: f64 = 1.2e-3;
/// ... of at least so many samples.
const BEFORE_SAMPLES: f64 = 6.0;

/// A break-away after a whole stick.
#[derive(Debug, Clone, Copy)]
pub struct Event {
    /// Friction force over normal force (1).
    pub force: f64,
    /// The same when the stick began (1).
    pub beginning: f64,
    /// Belt travel s in m where it happened.
    pub place: f64,
    /// Length of the stick in s.
    pub dwell: f64,
}

/// The break-aways of a run, in the order of time. The force of each is carried on to the transition by a straight
/// line from where the smoother can still follow.
pub fn events(run: &Run, smoothing: &Smoothing) -> Vec<Event> {
    let normal = run.normal_force;
    if normal == 0.0 {
        return Vec::new();
    }
    let smoothed = &smoothing.stick_slip.smoothed;
    let h = smoothed.sample_interval;
    let last = smoothed.force.len() - 1;
    let clear = CLEAR.max(CLEAR_SAMPLES * h);
    let before = BEFORE.max(BEFORE_SAMPLES * h);
    // A line through the force over the samples from `from` to `to` in s, at `at` in s.
    let carried = |from: f64, to: f64, at: f64| -> Option<f64> {
        let (first, past) = ((from / h).ceil() as usize, (to / h).floor() as usize);
        let points: Vec<(f64, f64)> = (first..=past.min(last))
            .map(|k| (k as f64 * h - at, smoothed.force[k].abs() / normal))
            .collect();
        (points.len() > 1).then(|| line(&points).0)
    };
    let phases = &smoothing.stick_slip.phases;
    let sticks = phases.windows(3).filter(|w| {
        let modes = [0, 1, 2].map(|i| w[i].mode == PhaseMode::Stick);
        modes == [false, true, false]
    });
    sticks
        .filter_map(|w| {
            let (start, end) = (w[1].start, w[1].end);
            // Both ends need room.
            if end - start < 2.0 * (before + clear) {
                return None;
            }
            let k = (((end - clear) / h) as usize).min(last);
            let moved = smoothed.displacement[k] - smoothed.displacement[0];
            Some(Event {
                force: carried(end - before - clear, end - clear, end)?,
                beginning: carried(start + clear, start + clear + before, start)?,
                place: smoothing.belt_path.at_sample(k, h) - moved,
                dwell: end - start,
            })
        })
        .collect()
}
