//! Break-away force against the dwell time in stick.

use super::characteristic::Contact;
use super::error::ObserverError;
use super::segmentation::PhaseMode;

/// One complete stick phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BreakAway {
    /// Time of break-away in s (from the start of the record, in its own time).
    pub time: f64,
    /// Dwell time: duration of the stick phase in s.
    pub dwell: f64,
    /// Force on arrival in N.
    pub arrival_force: f64,
    /// Force at break-away in N.
    pub force: f64,
    /// Static friction coefficient `abs(F) / F_N` at break-away (1).
    pub mu: f64,
    /// Mean rate of the force in stick in N/s.
    pub force_rate: f64,
}

/// Break-away forces of a record and what they say of the dwell time.
#[derive(Debug, Clone, PartialEq)]
pub struct DwellResult {
    /// Complete stick phases in the order of time.
    pub events: Vec<BreakAway>,
    /// Mean static coefficient (1).
    pub mu_mean: f64,
    /// Its standard deviation over the events (1).
    pub mu_std: f64,
    /// Slope of the static coefficient over `ln(dwell / 1 s)` (1), least squares.
    pub slope: f64,
    /// Half width of the slope's 95 % interval (1).
    pub slope_interval: f64,
    /// Ratio of the longest to the shortest dwell time (1).
    pub dwell_ratio: f64,
}

impl DwellResult {
    /// What may be concluded, in plain words.
    ///
    /// In steady stick-slip at constant belt speed the force rises at a nearly constant rate, so a
    /// threshold that happens to be high makes a long stick: the slope comes out positive without
    /// any ageing. Only different belt speeds or holds of prescribed length tell the two apart.
    pub fn verdict(&self) -> &'static str {
        if self.dwell_ratio < 1.2 {
            "all sticks are about equally long: nothing can be said about ageing"
        } else if self.slope.abs() <= self.slope_interval {
            "no dependence of the break-away force on the dwell time is visible"
        } else {
            "break-away force and dwell time go together; a threshold that is high by chance makes a \
             long stick, so this alone is no ageing: compare other belt speeds"
        }
    }
}

/// Samples at the end of stick whose second largest force counts as break-away.
const WINDOW: usize = 6;

/// Collects break-away events from complete stick phases.
pub fn break_away(contact: &Contact) -> Result<DwellResult, ObserverError> {
    contact.check()?;
    let events: Vec<BreakAway> = contact
        .phases
        .windows(2)
        .filter(|pair| pair[0].mode == PhaseMode::Stick && pair[0].complete)
        .map(|pair| {
            let stick = &pair[0];
            let mut last: Vec<f64> = (stick.past.saturating_sub(WINDOW).max(stick.first)
                ..stick.past)
                .map(|k| contact.force[k])
                .collect();
            // The tip lags behind afterwards: the force had pulled it along. The second largest, so
            // that one stray value does not count.
            let sign = -f64::from(pair[1].mode.number());
            last.sort_by(|a, b| (sign * b).total_cmp(&(sign * a)));
            let force = last[1.min(last.len() - 1)];
            let arrival_force = contact.force[stick.first];
            BreakAway {
                time: stick.end,
                dwell: stick.duration(),
                arrival_force,
                force,
                mu: force.abs() / contact.normal_force.at(stick.past - 1),
                force_rate: (force - arrival_force) / stick.duration(),
            }
        })
        .collect();
    let needed = 3;
    if events.len() < needed {
        return Err(ObserverError::TooFewEvents {
            what: "break-away force against dwell time",
            found: events.len(),
            needed,
            unit: "complete stick phases",
            action: "record longer, or lower the belt speed",
        });
    }
    let n = events.len() as f64;
    let mean = |value: fn(&BreakAway) -> f64| events.iter().map(value).sum::<f64>() / n;
    let (x0, y0) = (mean(|e| e.dwell.ln()), mean(|e| e.mu));
    let sum = |value: &dyn Fn(&BreakAway) -> f64| events.iter().map(value).sum::<f64>();
    let xx = sum(&|e| (e.dwell.ln() - x0).powi(2)).max(f64::MIN_POSITIVE);
    let slope = sum(&|e| (e.dwell.ln() - x0) * (e.mu - y0)) / xx;
    let left = sum(&|e| (e.mu - y0 - slope * (e.dwell.ln() - x0)).powi(2));
    let longest = events.iter().map(|e| e.dwell).fold(0.0, f64::max);
    let shortest = events.iter().map(|e| e.dwell).fold(f64::INFINITY, f64::min);
    Ok(DwellResult {
        mu_mean: y0,
        mu_std: (sum(&|e| (e.mu - y0).powi(2)) / (n - 1.0)).sqrt(),
        slope,
        slope_interval: student(n - 2.0) * (left / (n - 2.0) / xx).sqrt(),
        dwell_ratio: longest / shortest,
        events,
    })
}

/// Two-sided 95 % quantile of Student's t (expansion of Abramowitz and Stegun 1964, 26.7.5; within
/// 1 % from 3 degrees of freedom, too small below).
pub(super) fn student(degrees: f64) -> f64 {
    let x: f64 = 1.959_964;
    let first = (x.powi(3) + x) / 4.0;
    let second = (5.0 * x.powi(5) + 16.0 * x.powi(3) + 3.0 * x) / 96.0;
    let third = (3.0 * x.powi(7) + 19.0 * x.powi(5) + 17.0 * x.powi(3) - 15.0 * x) / 384.0;
    x + first / degrees + second / degrees.powi(2) + third / degrees.powi(3)
}
