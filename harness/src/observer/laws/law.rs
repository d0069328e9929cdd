//! Friction laws with the parameters of the FMU.

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

fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    let above = x.partition_point(|v| *v <= at);
    match above {
        0 => y[0],
        n if n == x.len() => y[n - 1],
        n => y[n - 1] + (y[n] - y[n - 1]) * (at - x[n - 1]) / (x[n] - x[n - 1]),
    }
}
