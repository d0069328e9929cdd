//! Friction laws fitted to a measured characteristic.

use super::characteristic::Bin;
use super::curve::FrictionCurve;
use super::dwell::student;
use super::error::ObserverError;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

/// A friction law `mu(v)`, `v = abs(v_r)` in m/s; parameters are named as in the FMU.
#[derive(Debug, Clone, PartialEq)]
pub enum FrictionLaw {
    /// Eq. (7) of Stelter 1992, exponent read as `abs(v_r)/c1`:
    /// `mu_0 [1 - a1 + a1 exp(-v/v1)] [1 - a2 + a2 exp(-c2 v)]`.
    Stelter {
        /// Static coefficient (1).
        mu_0: f64,
        /// Share that falls off fast (1).
        a1: f64,
        /// Speed of the fast fall in m/s.
        v1: f64,
        /// Share that falls off slowly (1).
        a2: f64,
        /// Rate of the slow fall in s/m.
        c2: f64,
    },
    /// `mu_k + (mu_s - mu_k) exp(-(v/v_s)^delta) + c v` (Stribeck 1902; Armstrong-Helouvry 1994).
    Stribeck {
        /// Static coefficient (1).
        mu_s: f64,
        /// Kinetic coefficient (1).
        mu_k: f64,
        /// Stribeck velocity `v_s` in m/s.
        stribeck_velocity: f64,
        /// Exponent `delta` (1).
        stribeck_exponent: f64,
        /// Viscous coefficient `c` in s/m.
        viscous: f64,
    },
    /// `mu_k` in slip, `mu_s` in stick (Coulomb 1785).
    Coulomb {
        /// Static coefficient (1).
        mu_s: f64,
        /// Kinetic coefficient (1).
        mu_k: f64,
    },
    /// Straight from point to point, constant beyond the ends.
    Table {
        /// Speeds in m/s, rising from 0.
        velocity: Vec<f64>,
        /// Coefficients (1).
        coefficient: Vec<f64>,
    },
}

/// Largest number of points of a table in the FMU.
pub const TABLE_LIMIT: usize = 32;

impl FrictionLaw {
    /// Coefficient at speed `v >= 0` in m/s.
    pub fn mu(&self, v: f64) -> f64 {
        match self {
            FrictionLaw::Stelter {
                mu_0,
                a1,
                v1,
                a2,
                c2,
            } => mu_0 * (1.0 - a1 + a1 * (-v / v1).exp()) * (1.0 - a2 + a2 * (-c2 * v).exp()),
            FrictionLaw::Stribeck {
                mu_s,
                mu_k,
                stribeck_velocity,
                stribeck_exponent,
                viscous,
            } => {
                let fall = (-(v / stribeck_velocity).powf(*stribeck_exponent)).exp();
                mu_k + (mu_s - mu_k) * fall + viscous * v
            }
            FrictionLaw::Coulomb { mu_k, .. } => *mu_k,
            FrictionLaw::Table {
                velocity,
                coefficient,
            } => interpolate(velocity, coefficient, v),
        }
    }

    /// Name of the law as in the FMU's enumeration.
    pub fn name(&self) -> &'static str {
        match self {
            FrictionLaw::Stelter { .. } => "Stelter",
            FrictionLaw::Stribeck { .. } => "Stribeck",
            FrictionLaw::Coulomb { .. } => "Coulomb",
            FrictionLaw::Table { .. } => "Table",
        }
    }

    /// The FMU's start values for this law: name and value, `friction.law` first.
    pub fn start_values(&self) -> Vec<(String, f64)> {
        let fixed = |law: f64, pairs: &[(&str, f64)]| {
            let first = std::iter::once(("friction.law".to_owned(), law));
            let rest = pairs.iter().map(|(n, v)| (format!("friction.{n}"), *v));
            first.chain(rest).collect()
        };
        match self {
            FrictionLaw::Stelter {
                mu_0,
                a1,
                v1,
                a2,
                c2,
            } => fixed(
                1.0,
                &[
                    ("mu_0", *mu_0),
                    ("a1", *a1),
                    ("v1", *v1),
                    ("a2", *a2),
                    ("c2", *c2),
                ],
            ),
            FrictionLaw::Coulomb { mu_s, mu_k } => fixed(3.0, &[("mu_s", *mu_s), ("mu_k", *mu_k)]),
            FrictionLaw::Stribeck {
                mu_s,
                mu_k,
                stribeck_velocity,
                stribeck_exponent,
                viscous,
            } => fixed(
                4.0,
                &[
                    ("mu_s", *mu_s),
                    ("mu_k", *mu_k),
                    ("stribeck_velocity", *stribeck_velocity),
                    ("stribeck_exponent", *stribeck_exponent),
                    ("viscous", *viscous),
                ],
            ),
            FrictionLaw::Table {
                velocity,
                coefficient,
            } => {
                let mut out = fixed(5.0, &[("table.count", velocity.len() as f64)]);
                for (i, (v, mu)) in velocity.iter().zip(coefficient).enumerate() {
                    out.push((format!("friction.table.velocity[{}]", i + 1), *v));
                    out.push((format!("friction.table.coefficient[{}]", i + 1), *mu));
                }
                out
            }
        }
    }
}

/// A fitted parameter with its 95 % interval.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedParameter {
    /// Name as in the FMU, without `friction.`.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Value of least squares.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
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
        criterion: criterion(points, &law, 1),
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

/// Whether a parameter is searched by its logarithm (it is positive) or as it is.
#[derive(Clone, Copy, PartialEq)]
enum Scale {
    Log,
    Linear,
}

impl Scale {
    fn outer(self, x: f64) -> f64 {
        match self {
            Scale::Log => x.clamp(-50.0, 50.0).exp(),
            Scale::Linear => x,
        }
    }

    fn inner(self, value: f64) -> f64 {
        match self {
            Scale::Log => value.ln(),
            Scale::Linear => value,
        }
    }
}

type Start<'a> = (&'static str, &'static str, Scale, f64);

/// Weighted least squares (Levenberg 1944, Marquardt 1963), intervals from the curvature, widened
/// where the law does not fit within the errors.
fn fit(
    points: &LawPoints,
    start: &[Start],
    build: impl Fn(&[f64]) -> FrictionLaw,
) -> Option<LawFit> {
    let inner: Vec<f64> = start
        .iter()
        .map(|(_, _, scale, v)| scale.inner(*v))
        .collect();
    let problem = Fit {
        points,
        scales: start.iter().map(|s| s.2).collect(),
        at: DVector::from_vec(inner),
        build: &build,
    };
    let (solved, _) = LevenbergMarquardt::new()
        .with_patience(200)
        .minimize(problem);
    let law = solved.law(&solved.at);
    let degrees = (points.mu.len() as f64 - start.len() as f64).max(1.0);
    let chi = chi_squared(points, &law);
    if !chi.is_finite() {
        return None;
    }
    let jacobian = solved.jacobian()?;
    let information = jacobian.transpose() * &jacobian;
    let spread = information
        .clone()
        .pseudo_inverse(1e-12 * information.amax())
        .ok()?;
    let widen = (chi / degrees).max(1.0).sqrt() * student(degrees);
    let parameters = start
        .iter()
        .enumerate()
        .map(|(i, (name, unit, scale, _))| {
            let half = widen * spread[(i, i)].max(0.0).sqrt();
            FittedParameter {
                name,
                unit,
                value: scale.outer(solved.at[i]),
                low: scale.outer(solved.at[i] - half),
                high: scale.outer(solved.at[i] + half),
            }
        })
        .collect();
    Some(LawFit {
        parameters,
        residual: residual(points, &law),
        criterion: criterion(points, &law, start.len()),
        law,
    })
}

struct Fit<'a, B> {
    points: &'a LawPoints,
    scales: Vec<Scale>,
    at: DVector<f64>,
    build: &'a B,
}

impl<B: Fn(&[f64]) -> FrictionLaw> Fit<'_, B> {
    fn law(&self, at: &DVector<f64>) -> FrictionLaw {
        let values: Vec<f64> = self
            .scales
            .iter()
            .zip(at.iter())
            .map(|(s, x)| s.outer(*x))
            .collect();
        (self.build)(&values)
    }

    fn deviations(&self, at: &DVector<f64>) -> DVector<f64> {
        let law = self.law(at);
        let p = self.points;
        DVector::from_fn(p.mu.len(), |i, _| {
            (law.mu(p.speed[i]) - p.mu[i]) / p.error[i]
        })
    }
}

impl<B: Fn(&[f64]) -> FrictionLaw> LeastSquaresProblem<f64, Dyn, Dyn> for Fit<'_, B> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.at.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.deviations(&self.at))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let h = 1e-5;
        let columns: Vec<DVector<f64>> = (0..self.at.len())
            .map(|i| {
                let mut beside = self.at.clone();
                beside[i] += h;
                let after = self.deviations(&beside);
                beside[i] -= 2.0 * h;
                (after - self.deviations(&beside)) / (2.0 * h)
            })
            .collect();
        Some(DMatrix::from_columns(&columns))
    }
}

fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    let above = x.partition_point(|v| *v <= at);
    match above {
        0 => y[0],
        n if n == x.len() => y[n - 1],
        n => y[n - 1] + (y[n] - y[n - 1]) * (at - x[n - 1]) / (x[n] - x[n - 1]),
    }
}
