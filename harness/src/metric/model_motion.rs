//! A model motion that is compared with a measurement.

/// An evenly sampled model motion.
#[derive(Debug, Clone, Copy)]
pub struct ModelMotion<'a> {
    /// Time of the first value, s.
    pub start: f64,
    /// Sample interval, s.
    pub interval: f64,
    /// Values, in the unit of the measurement.
    pub values: &'a [f64],
    /// Largest shift either way that makes sense, s: infinite for a motion that has no clock.
    pub reach: f64,
}

impl ModelMotion<'_> {
    /// The value at `time` (s), straight lines between samples; NaN outside.
    pub fn at(&self, time: f64) -> f64 {
        let at = (time - self.start) / self.interval;
        if !(at >= 0.0 && at < (self.values.len() - 1) as f64) {
            return f64::NAN;
        }
        let i = at as usize;
        self.values[i] + (at - i as f64) * (self.values[i + 1] - self.values[i])
    }

    /// The values at these times, as [`ModelMotion::at`].
    pub fn at_all(&self, time: &[f64]) -> Vec<f64> {
        time.iter().map(|t| self.at(*t)).collect()
    }

    /// Smallest and largest shift that keep every time between these two inside the model, and that are within its reach.
    pub(super) fn shifts_covering(&self, (first, last): (f64, f64)) -> (f64, f64) {
        let end = self.start + (self.values.len() - 1) as f64 * self.interval;
        // A hundredth of a sample keeps rounding from leaving the model.
        let margin = 0.01 * self.interval;
        (
            (self.start - first + margin).max(-self.reach),
            (end - last - margin).min(self.reach),
        )
    }
}
