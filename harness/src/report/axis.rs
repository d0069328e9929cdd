//! Axes: quantity, unit, scale and ticks.

/// One axis of a plot.
#[derive(Debug, Clone)]
pub struct Axis {
    pub(super) label: String,
    pub(super) unit: String,
    pub(super) kind: Kind,
    pub(super) names: Vec<String>,
    range: Option<(f64, f64)>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Linear,
    Log,
    /// Logarithmic on either side of zero, linear below this size.
    Symlog(f64),
}

impl Kind {
    /// The coordinate in which the axis is even.
    pub fn place(self, value: f64) -> f64 {
        match self {
            Kind::Linear => value,
            Kind::Log => value.log10(),
            Kind::Symlog(linear) => (value / linear).asinh(),
        }
    }
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
            unit: if unit == "1" {
                String::new()
            } else {
                unit.to_owned()
            },
            kind: Kind::Linear,
            names: Vec::new(),
            range: None,
        }
    }

    /// A logarithmic axis; values that are not positive are left out.
    pub fn log(quantity: &str, unit: &str) -> Axis {
        Axis {
            kind: Kind::Log,
            ..Axis::linear(quantity, unit)
        }
    }

    /// Logarithmic on either side of zero and linear where values are smaller than `linear`.
    pub fn symlog(quantity: &str, unit: &str, linear: f64) -> Axis {
        Axis {
            kind: Kind::Symlog(linear),
            ..Axis::linear(quantity, unit)
        }
    }

    /// A horizontal axis with named places at 0, 1, 2, ...
    pub fn places(quantity: &str, names: &[String]) -> Axis {
        Axis {
            names: names.to_vec(),
            range: Some((-0.5, names.len() as f64 - 0.5)),
            ..Axis::linear(quantity, "1")
        }
    }

    /// A vertical axis with named rows at 0, 1, 2, ... from top to bottom.
    pub fn rows(names: &[String]) -> Axis {
        Axis {
            range: Some((names.len() as f64 - 0.5, -0.5)),
            ..Axis::places("", names)
        }
    }

    /// What it shows, without its unit.
    pub(super) fn quantity(&self) -> &str {
        self.label.split(" [").next().unwrap_or_default()
    }

    /// Room in px that the names of the rows need.
    pub(super) fn name_width(&self) -> f64 {
        self.names
            .iter()
            .map(|n| n.chars().count())
            .max()
            .map_or(0.0, |n| 6.8 * n as f64 + 14.0)
    }

    /// Places and texts of about `count` ticks.
    pub(super) fn ticks(&self, scale: &Scale, count: usize) -> Vec<(f64, String)> {
        if self.names.is_empty() {
            let ticks = scale.ticks(count);
            return ticks
                .iter()
                .map(|t| (*t, scale.tick_text(&ticks, *t)))
                .collect();
        }
        self.names
            .iter()
            .enumerate()
            .map(|(i, n)| (i as f64, n.clone()))
            .collect()
    }

    /// Whether it is logarithmic on either side of zero.
    pub(super) fn is_symlog(&self) -> bool {
        matches!(self.kind, Kind::Symlog(_))
    }

    /// A fixed range.
    pub fn from_to(mut self, low: f64, high: f64) -> Axis {
        self.range = Some((low, high));
        self
    }

    /// The scale that shows `values`.
    pub(super) fn scale(&self, values: impl Iterator<Item = f64>) -> Scale {
        let shown = values.filter(|v| v.is_finite() && (self.kind != Kind::Log || *v > 0.0));
        let (low, high) = self.range.unwrap_or_else(|| {
            let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            });
            if low > high {
                (if self.kind == Kind::Log { 1.0 } else { 0.0 }, 10.0)
            } else if self.kind == Kind::Log {
                (low / 1.2, high * 1.2)
            } else if let Kind::Symlog(linear) = self.kind {
                (
                    low - 0.15 * low.abs() - 0.2 * linear,
                    high + 0.15 * high.abs() + 0.2 * linear,
                )
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
            kind: self.kind,
        }
    }
}

/// Maps values to 0..1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    kind: Kind,
}

impl Scale {
    pub fn share(&self, value: f64) -> f64 {
        let place = |v: f64| self.kind.place(v);
        (place(value) - place(self.low)) / (place(self.high) - place(self.low))
    }

    /// About `count` round values inside the range.
    pub fn ticks(&self, count: usize) -> Vec<f64> {
        match self.kind {
            Kind::Log if self.high / self.low >= 300.0 => return decades(self.low, self.high),
            Kind::Log => return round_steps(self.low, self.high),
            Kind::Symlog(linear) => return both_sides(self.low, self.high, linear),
            Kind::Linear => {}
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
        if self.kind != Kind::Linear {
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

/// Round values on a logarithmic axis of less than three decades: the closer, the shorter it is.
fn round_steps(low: f64, high: f64) -> Vec<f64> {
    let steps: &[f64] = match high / low {
        r if r < 4.0 => &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0],
        r if r < 30.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0, 3.0],
    };
    (low.log10().floor() as i32..=high.log10().floor() as i32)
        .flat_map(|e| steps.iter().map(move |m| m * 10f64.powi(e)))
        .filter(|t| (low..=high).contains(t))
        .collect()
}

/// Powers of ten on either side of zero, from `linear` on.
fn both_sides(low: f64, high: f64, linear: f64) -> Vec<f64> {
    let largest = low.abs().max(high.abs()).max(2.0 * linear);
    let sizes = decades(linear * 0.999, largest);
    let down = sizes.iter().rev().map(|s| -s);
    down.chain([0.0])
        .chain(sizes.iter().copied())
        .filter(|t| (low..=high).contains(t))
        .collect()
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
