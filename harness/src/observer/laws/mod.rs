//! Friction laws fitted to a measured characteristic.

mod law;
mod least_squares;

use super::characteristic::Bin;
use super::curve::FrictionCurve;
use super::dwell::student;
use super::error::ObserverError;
pub use law::{FrictionLaw, TABLE_LIMIT};
use least_squares::{Scale, fit};

/// A fitted parameter with its 95 % interval.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedParameter {
    /// Name as in the FMU, without `friction.`.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Value of least squares.
    pub value: f64,
    /// Lower end of the 95 % interval; 0 or minus infinity if the points do not determine it.
    pub low: f64,
    /// Upper end; infinite if the points do not determine it.
    pub high: f64,
}

impl FittedParameter {
    /// Whether the points determine it: its interval is bounded, and of a parameter that is
    /// positive by its nature spans less than six decades.
    pub fn is_determined(&self) -> bool {
        self.high.is_finite()
            && self.low.is_finite()
            && !(self.low > 0.0 && self.high > 1e6 * self.low)
    }
}

/// A law fitted to a characteristic.
#[derive(Debug, Clone, PartialEq)]
pub struct LawFit {
    /// The law with its fitted parameters.
    pub law: FrictionLaw,
    /// The parameters with intervals (none for the table; its points carry their errors).
    pub parameters: Vec<FittedParameter>,
    /// Root mean square deviation of the points from the law (1), weighted by samples.
    pub residual: f64,
    /// Bayesian information criterion (Schwarz 1978) for the points; smaller is better.
    pub criterion: f64,
}

/// Points of a characteristic that laws are fitted to.
#[derive(Debug, Clone, PartialEq)]
pub struct LawPoints {
    speed: Vec<f64>,
    mu: Vec<f64>,
    error: Vec<f64>,
    weight: Vec<f64>,
    /// Static coefficient with its standard error.
    break_away: Option<(f64, f64)>,
}

impl LawPoints {
    /// From the binned characteristic; `break_away` is the static coefficient with its standard
    /// error, where stick phases gave one.
    pub fn from_bins(bins: &[Bin], break_away: Option<(f64, f64)>) -> Self {
        Self {
            speed: bins.iter().map(|b| b.relative_velocity.abs()).collect(),
            mu: bins.iter().map(|b| b.mu).collect(),
            error: bins
                .iter()
                .map(|b| b.mu_error.hypot(LEAST_ERROR * b.mu))
                .collect(),
            weight: bins.iter().map(|b| b.count as f64).collect(),
            break_away,
        }
    }

    /// From the curve found by shooting; sharper at low speed.
    pub fn from_curve(curve: &FrictionCurve) -> Self {
        let error = |i: usize| curve.mu_std[i].hypot(LEAST_ERROR * curve.mu[i]);
        let moving = 1..curve.mu.len();
        Self {
            speed: curve.speed[1..].to_vec(),
            mu: curve.mu[1..].to_vec(),
            error: moving.clone().map(error).collect(),
            weight: moving.map(|i| curve.count[i] as f64 + 1.0).collect(),
            break_away: Some((curve.mu[0], error(0))),
        }
    }
}

/// Share of the coefficient taken as the least error of a bin: binning and smoothing are no better.
const LEAST_ERROR: f64 = 2e-3;

/// Fits every law. The best by [`LawFit::criterion`] comes first, the table last.
pub fn fit_laws(points: &LawPoints) -> Result<Vec<LawFit>, ObserverError> {
    let needed = 6;
    if points.mu.len() < needed {
        return Err(ObserverError::TooFewEvents {
            what: "friction laws",
            found: points.mu.len(),
            needed,
            unit: "points over the relative velocity",
            action: "record a motion with a wider range of relative velocity",
        });
    }
    let slowest = (0..points.mu.len()).min_by(|a, b| points.speed[*a].total_cmp(&points.speed[*b]));
    let at_slowest = (slowest.map_or(0.0, |i| points.mu[i]), f64::INFINITY);
    let (mu_static, static_error) = points.break_away.unwrap_or(at_slowest);
    let coulomb = fit_coulomb(points, mu_static, static_error);
    let table = table(points);
    let mut points = points.clone();
    if let Some((mu, error)) = points.break_away {
        points.speed.push(0.0);
        points.mu.push(mu);
        points.error.push(error.hypot(LEAST_ERROR * mu));
        points.weight.push(0.0);
    }
    let slow = points
        .mu
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min)
        .max(1e-6);
    let high = mu_static.max(slow * 1.01);
    let mut fits = vec![coulomb];
    fits.extend(fit(
        &points,
        &[
            ("mu_0", "1", Scale::Log, high),
            (
                "a1",
                "1",
                Scale::Linear,
                (1.0 - slow / high).clamp(0.05, 0.9),
            ),
            ("v1", "m/s", Scale::Log, 0.02),
            ("c2", "s/m", Scale::Linear, 0.25),
        ],
        |p| FrictionLaw::Stelter {
            mu_0: p[0],
            a1: p[1],
            v1: p[2],
            // Over the speeds of a rig only the product a2 c2 shows; a2 stays as in the paper.
            a2: 0.5,
            c2: p[3],
        },
    ));
    fits.extend(fit(
        &points,
        &[
            ("mu_s", "1", Scale::Log, high),
            ("mu_k", "1", Scale::Log, slow),
            ("stribeck_velocity", "m/s", Scale::Log, 0.02),
            ("stribeck_exponent", "1", Scale::Log, 1.0),
            ("viscous", "s/m", Scale::Linear, 0.0),
        ],
        |p| FrictionLaw::Stribeck {
            mu_s: p[0],
            mu_k: p[1],
            stribeck_velocity: p[2],
            stribeck_exponent: p[3],
            viscous: p[4],
        },
    ));
    fits.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
    fits.push(table);
    Ok(fits)
}

fn fit_coulomb(points: &LawPoints, mu_s: f64, static_error: f64) -> LawFit {
    let weights: Vec<f64> = points.error.iter().map(|e| e.powi(-2)).collect();
    let total: f64 = weights.iter().sum();
    let mu_k = points
        .mu
        .iter()
        .zip(&weights)
        .map(|(m, w)| m * w)
        .sum::<f64>()
        / total;
    let law = FrictionLaw::Coulomb { mu_s, mu_k };
    let degrees = (points.mu.len() - 1) as f64;
    let half = student(degrees) * (chi_squared(points, &law) / degrees / total).sqrt();
    let parameter = |name, value, half: f64| FittedParameter {
        name,
        unit: "1",
        value,
        low: value - half,
        high: value + half,
    };
    LawFit {
        parameters: vec![
            parameter("mu_s", mu_s, 1.96 * static_error),
            parameter("mu_k", mu_k, half),
        ],
        residual: residual(points, &law),
        // The static point, where there is one, is met exactly at the price of a parameter.
        criterion: criterion(points, &law, 1 + usize::from(points.break_away.is_some())),
        law,
    }
}

/// At most [`TABLE_LIMIT`] points: the static coefficient, then bins joined by samples.
fn table(points: &LawPoints) -> LawFit {
    let mut order: Vec<usize> = (0..points.mu.len()).collect();
    order.sort_by(|a, b| points.speed[*a].total_cmp(&points.speed[*b]));
    let group = order.len().div_ceil(TABLE_LIMIT - 1);
    let (mut velocity, mut coefficient) = (Vec::new(), Vec::new());
    if let Some((mu, _)) = points.break_away {
        velocity.push(0.0);
        coefficient.push(mu);
    }
    for members in order.chunks(group) {
        let total: f64 = members.iter().map(|i| points.weight[*i]).sum();
        let mean = |values: &[f64]| {
            members
                .iter()
                .map(|i| values[*i] * points.weight[*i])
                .sum::<f64>()
                / total
        };
        velocity.push(mean(&points.speed));
        coefficient.push(mean(&points.mu));
    }
    let law = FrictionLaw::Table {
        velocity,
        coefficient,
    };
    LawFit {
        parameters: Vec::new(),
        residual: residual(points, &law),
        criterion: criterion(points, &law, points.mu.len().min(TABLE_LIMIT)),
        law,
    }
}

fn chi_squared(points: &LawPoints, law: &FrictionLaw) -> f64 {
    (0..points.mu.len())
        .map(|i| ((points.mu[i] - law.mu(points.speed[i])) / points.error[i]).powi(2))
        .sum()
}

fn residual(points: &LawPoints, law: &FrictionLaw) -> f64 {
    let total: f64 = points.weight.iter().sum();
    let sum: f64 = (0..points.mu.len())
        .map(|i| points.weight[i] * (points.mu[i] - law.mu(points.speed[i])).powi(2))
        .sum();
    (sum / total).sqrt()
}

fn criterion(points: &LawPoints, law: &FrictionLaw, parameters: usize) -> f64 {
    chi_squared(points, law) + parameters as f64 * (points.mu.len() as f64).ln()
}
