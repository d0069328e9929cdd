//! Axes: quantity, unit, scale and ticks.

/// One axis of a plot.
#[derive(Debug, Clone)]
pub struct Axis {
    pub(super) label: String,
    pub(super) log: bool,
    pub(super) range: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis for a quantity in a unit (`"1"` for ratios). The range follows the data.
    pub fn linear(quantity: &str, unit: &str) -> Axis {
        let label = if unit == "1" {
            quantity.to_owned()
        } else {
            format!("{quantity} [{unit}]")
        };
        Axis {
            label,
            log: false,
            range: None,
        }
    }

    /// A logarithmic axis; values that are not positive are left out.
    pub fn log(quantity: &str, unit: &str) -> Axis {
        Axis {
            log: true,
            ..Axis::linear(quantity, unit)
        }
    }

    /// A fixed range.
    pub fn from_to(mut self, low: f64, high: f64) -> Axis {
        self.range = Some((low, high));
        self
    }

    /// The scale that shows `values`.
    pub(super) fn scale(&self, values: impl Iterator<Item = f64>) -> Scale {
        let shown = values.filter(|v| v.is_finite() && (!self.log || *v > 0.0));
        let (low, high) = self.range.unwrap_or_else(|| {
            let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            });
            if low > high {
                (if self.log { 1.0 } else { 0.0 }, 10.0)
            } else if self.log {
                (low / 1.2, high * 1.2)
            } else {
                let margin = if high > low {
                    0.04 * (high - low)
                } else {
                    0.5 * high.abs().max(1e-12)
                };
                (low - margin, high + margin)
            }
        });
        Scale {
            low,
            high,
            log: self.log,
        }
    }
}

/// Maps values to 0..1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    log: bool,
}

impl Scale {
    pub fn share(&self, value: f64) -> f64 {
        if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// About `count` round values inside the range.
    pub fn ticks(&self, count: usize) -> Vec<f64> {
        if self.log && self.high / self.low >= 10.0 {
            return decades(self.low, self.high);
        }
        let raw = (self.high - self.low) / count.max(1) as f64;
        let magnitude = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|m| m * magnitude)
            .find(|s| *s >= raw * 0.999)
            .unwrap_or(raw);
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }

    /// Text of a tick, with the decimals that its step needs.
    pub fn tick_text(&self, ticks: &[f64], value: f64) -> String {
        if self.log {
            return super::number(value, 3);
        }
        let step = ticks
            .windows(2)
            .map(|w| w[1] - w[0])
            .fold(f64::INFINITY, f64::min);
        let largest = ticks.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
        if value != 0.0
            && (!(1e-3..1e5).contains(&largest) || ticks.len() > 1 && largest / step > 1e6)
        {
            return super::number(value, 3);
        }
        let decimals = if step.is_finite() && step > 0.0 {
            (-(step * 1.001).log10().floor()).max(0.0) as usize
        } else {
            2
        };
        format!("{value:.decimals$}")
    }
}

fn decades(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = (low.log10().ceil() as i32, high.log10().floor() as i32);
    let every = ((last - first) / 6 + 1).max(1) as usize;
    (first..=last)
        .step_by(every)
        .map(|e| 10f64.powi(e))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let scale = Axis::linear("x", "s")
            .from_to(-0.13, 0.61)
            .scale(std::iter::empty());
        let ticks = scale.ticks(5);
        let shown: Vec<String> = ticks.iter().map(|t| scale.tick_text(&ticks, *t)).collect();
        assert_eq!(shown, ["0.0", "0.2", "0.4", "0.6"]);
        let log = Axis::log("A", "m")
            .from_to(1e-8, 1e-3)
            .scale(std::iter::empty());
        assert_eq!(log.ticks(5).len(), 6);
        assert!((log.share(1e-8)).abs() < 1e-12 && (log.share(1e-3) - 1.0).abs() < 1e-12);
    }
}
