//! How far the belt of a run has run.

use crate::measurement::Run;

/// Distance that the belt of a run has passed.
#[derive(Debug, Clone)]
pub enum BeltPath {
    /// At a constant velocity in m/s.
    Even(f64),
    /// At a velocity that was measured.
    Uneven {
        /// Interval of the distances in s.
        interval: f64,
        /// Distance in m since the run began.
        distance: Vec<f64>,
    },
}

impl BeltPath {
    /// Of a run whose belt has the velocities `belt` in m/s at an `interval` in s, where they vary.
    pub fn of(run: &Run, interval: f64, belt: Option<&[f64]>) -> Self {
        let Some(belt) = belt else {
            return Self::Even(run.belt_velocity);
        };
        let mut passed = 0.0;
        let steps = belt.windows(2).map(|v| 0.5 * interval * (v[0] + v[1]));
        let distance = std::iter::once(0.0).chain(steps.map(|step| {
            passed += step;
            passed
        }));
        Self::Uneven {
            interval,
            distance: distance.collect(),
        }
    }

    /// Distance in m at sample `k` of a record with this `interval` in s.
    pub fn at_sample(&self, k: usize, interval: f64) -> f64 {
        match self {
            Self::Even(velocity) => velocity * k as f64 * interval,
            Self::Uneven { .. } => self.at(k as f64 * interval),
        }
    }

    /// Distance in m at `time` in s since the run began.
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Even(velocity) => velocity * time,
            Self::Uneven { interval, distance } => {
                let last = distance.len() - 1;
                let place = (time / interval).clamp(0.0, last as f64);
                let k = (place.floor() as usize).min(last.saturating_sub(1));
                let next = distance[(k + 1).min(last)];
                distance[k] + (place - k as f64) * (next - distance[k])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoothing::pushed_run::pushed;
    use crate::smoothing::sampled;

    #[test]
    fn a_belt_that_speeds_up_has_passed_its_integral() {
        let run = pushed(|_| 0.0, Some(|t| 0.1 + 0.4 * t));
        let series = run.inputs.belt_velocity.as_ref().unwrap();
        let belt = sampled(series, &run, 1e-3, 1001);
        let path = BeltPath::of(&run, 1e-3, Some(&belt));
        assert!((path.at(0.5) - (0.05 + 0.05)).abs() < 1e-12);
        assert!((path.at(0.5005) - (0.05005 + 0.2 * 0.5005_f64.powi(2))).abs() < 1e-6);
        assert_eq!(BeltPath::of(&run, 1e-3, None).at(2.0), 0.2);
    }
}
