//! The friction characteristic of friction.csv.

use super::Observation;
use crate::observer::{FrictionCurve, PhaseMode};

/// One line of friction.csv.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Relative velocity in m/s; negative where the tip lags behind the belt.
    pub relative_velocity: f64,
    /// Friction coefficient there (1).
    pub mu: f64,
    /// Its standard deviation (1).
    pub mu_std: f64,
    /// Number of slip samples nearest to it.
    pub count: usize,
}

/// Points per direction of slip that the curve is written at.
const POINTS: usize = 60;

/// The curve by shooting where it explains the slip events, else the means in bins with their standard errors.
///
/// Within the samples next to break-away and arrival the smoothed force is smeared, so that means are several percent low below
/// about 0.05 m/s; the curve is not.
pub fn best(o: &Observation) -> Vec<Point> {
    match o.curve.as_ref().filter(|_| o.curve_trusted) {
        Some(curve) => [
            (PhaseMode::BackwardSlip, -1.0),
            (PhaseMode::ForwardSlip, 1.0),
        ]
        .into_iter()
        .flat_map(|(mode, sign)| of_curve(o, curve, mode, sign))
        .collect(),
        None => o
            .bins
            .iter()
            .map(|b| Point {
                relative_velocity: b.relative_velocity,
                mu: b.mu,
                mu_std: b.mu_error,
                count: b.count,
            })
            .collect(),
    }
}

/// The curve at speeds that are squares of evenly spaced numbers, for one direction of slip, in the order of relative velocity.
fn of_curve(o: &Observation, curve: &FrictionCurve, mode: PhaseMode, sign: f64) -> Vec<Point> {
    let speeds: Vec<f64> = o
        .phases
        .iter()
        .filter(|p| p.mode == mode)
        .flat_map(|p| &o.relative_velocity[p.first..p.past])
        .map(|v| v.abs())
        .collect();
    let fastest = speeds
        .iter()
        .fold(0.0, |m: f64, v| m.max(*v))
        .min(curve.speed.last().copied().unwrap_or(0.0));
    // Too little slip this way to say anything of it.
    if !o.bins.iter().any(|b| b.relative_velocity * sign > 0.0) || fastest <= 0.0 {
        return Vec::new();
    }
    let mut count = vec![0; POINTS + 1];
    for v in &speeds {
        let nearest = (POINTS as f64 * (v / fastest).sqrt()).round() as usize;
        count[nearest.min(POINTS)] += 1;
    }
    let mut points: Vec<Point> = (1..=POINTS)
        .map(|i| {
            let v = fastest * (i as f64 / POINTS as f64).powi(2);
            Point {
                relative_velocity: sign * v,
                mu: curve.at(v),
                mu_std: curve.std_at(v),
                count: count[i],
            }
        })
        .collect();
    points.sort_by(|a, b| a.relative_velocity.total_cmp(&b.relative_velocity));
    points
}
