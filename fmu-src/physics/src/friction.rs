//! Friction laws mu(v): the coefficient over the magnitude of the sliding velocity.

#[cfg(not(feature = "tangent"))]
mod characteristic;
pub mod series;

use crate::error::{PhysicsError, require};
use crate::real::{Real, ZERO, real, value};

/// Most rows of a tabulated law.
pub const MAX_TABLE: usize = 32;

/// A friction characteristic mu(|v_r|) with its static coefficient.
///
/// In slip the friction force on the tip is `F = -mu(|v_r|) F_N sgn(v_r)` (Stelter 1992, eq. 4); in
/// stick it is the constraint force, at most `static_coefficient * F_N`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "a law is read in every evaluation and moved once"
)]
pub enum FrictionLaw {
    /// `mu = mu_0 [1 - a1 + a1 exp(-v/v1)] [1 - a2 + a2 exp(-c2 v)]`: Stelter 1992, eq. (7), with the
    /// exponent read as |v_r|/c1. See docs/adr/0002-friction-law.md.
    Stelter(Exponential),
    /// `mu = mu_0 [1 - a1 + a1 exp(-v1/v)] [1 - a2 + a2 exp(-c2 v)]`: eq. (7) as printed. It rises up
    /// to 0.28 m/s, so nothing vibrates by itself; kept for comparison.
    StelterAsPrinted(Exponential),
    /// Constant kinetic coefficient below a static one (Coulomb).
    Coulomb {
        /// Static coefficient mu_s.
        mu_s: Real,
        /// Kinetic coefficient mu_k.
        mu_k: Real,
    },
    /// `mu = mu_k + (mu_s - mu_k) exp(-(v/v_s)^delta) + c v` (Stribeck curve; Armstrong-Helouvry 1991).
    Stribeck {
        /// Static coefficient mu_s.
        mu_s: Real,
        /// Kinetic coefficient mu_k.
        mu_k: Real,
        /// Stribeck velocity v_s in m/s.
        velocity: Real,
        /// Exponent delta.
        exponent: Real,
        /// Viscous coefficient c in s/m.
        viscous: Real,
    },
    /// Given points, joined by monotone cubics.
    Table(Table),
}

/// Constants of eq. (7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exponential {
    /// Static coefficient mu_0.
    pub mu_0: Real,
    /// Share a1 that falls fast.
    pub a1: Real,
    /// Velocity v1 in m/s over which it falls.
    pub v1: Real,
    /// Share a2 that falls slowly.
    pub a2: Real,
    /// Its rate c2 in s/m.
    pub c2: Real,
}

impl Default for Exponential {
    /// Stelter 1992, eq. (7).
    fn default() -> Self {
        Self {
            mu_0: real(0.66),
            a1: real(0.5),
            v1: real(0.02),
            a2: real(0.5),
            c2: real(0.25),
        }
    }
}

/// A tabulated law: velocities rising from 0, coefficients, and slopes of the monotone cubic
/// interpolant (Fritsch & Carlson 1980; Fritsch & Butland 1984 for the slopes).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table {
    count: usize,
    velocity: [Real; MAX_TABLE],
    coefficient: [Real; MAX_TABLE],
    slope: [Real; MAX_TABLE],
}

impl Table {
    /// A table from its rows, velocities in m/s.
    ///
    /// # Errors
    /// Fewer than 2 or more than [`MAX_TABLE`] rows, velocities that do not rise or start below zero,
    /// coefficients that are negative or not numbers (a hole in the table).
    pub fn new(velocity: &[Real], coefficient: &[Real]) -> Result<Self, PhysicsError> {
        let count = velocity.len();
        let wrong = |row: usize, problem: String| Err(PhysicsError::Table { row, problem });
        if !(2..=MAX_TABLE).contains(&count) || coefficient.len() != count {
            return wrong(
                count,
                format!(
                    "{count} velocities and {} coefficients (2 to {MAX_TABLE} rows allowed)",
                    coefficient.len()
                ),
            );
        }
        for i in 0..count {
            let (v, mu) = (velocity[i], coefficient[i]);
            if !v.is_finite() || v < 0.0 || (i > 0 && v <= velocity[i - 1]) {
                return wrong(
                    i + 1,
                    format!(
                        "velocity {} m/s does not rise from the row before",
                        value(v)
                    ),
                );
            }
            if !mu.is_finite() || mu < 0.0 {
                return wrong(
                    i + 1,
                    format!("coefficient {} at {} m/s", value(mu), value(v)),
                );
            }
        }
        let mut table = Self {
            count,
            velocity: [ZERO; MAX_TABLE],
            coefficient: [ZERO; MAX_TABLE],
            slope: [ZERO; MAX_TABLE],
        };
        table.velocity[..count].copy_from_slice(velocity);
        table.coefficient[..count].copy_from_slice(coefficient);
        let secant =
            |i: usize| (coefficient[i + 1] - coefficient[i]) / (velocity[i + 1] - velocity[i]);
        table.slope[0] = secant(0);
        table.slope[count - 1] = secant(count - 2);
        for i in 1..count - 1 {
            let (a, b) = (secant(i - 1), secant(i));
            table.slope[i] = if a * b <= 0.0 {
                ZERO
            } else {
                2.0 * a * b / (a + b)
            };
        }
        Ok(table)
    }

    /// Coefficient at speed `v` in m/s; constant outside the table.
    fn coefficient(&self, v: Real) -> Real {
        let rows = &self.velocity[..self.count];
        let i = rows.partition_point(|&x| x <= v);
        if i == 0 {
            return self.coefficient[0];
        }
        if i == self.count {
            return self.coefficient[self.count - 1];
        }
        let h = rows[i] - rows[i - 1];
        let s = (v - rows[i - 1]) / h;
        let (y0, y1) = (self.coefficient[i - 1], self.coefficient[i]);
        let (d0, d1) = (self.slope[i - 1] * h, self.slope[i] * h);
        y0 + s * (d0 + s * (3.0 * (y1 - y0) - 2.0 * d0 - d1 + s * (d0 + d1 - 2.0 * (y1 - y0))))
    }
}

impl Default for FrictionLaw {
    fn default() -> Self {
        Self::Stelter(Exponential::default())
    }
}

impl FrictionLaw {
    /// Coefficient of friction at sliding speed `v` >= 0 in m/s.
    ///
    /// Slightly negative `v` continues the law smoothly: the integrator needs this while it locates
    /// the instant at which the sliding velocity vanishes.
    #[inline]
    pub fn coefficient(&self, v: Real) -> Real {
        match self {
            Self::Stelter(p) => {
                // Beyond -v1 the continuation stays constant, so that a rejected step can't overflow.
                let v = v.max(-p.v1);
                p.mu_0
                    * (1.0 - p.a1 + p.a1 * (-v / p.v1).exp())
                    * (1.0 - p.a2 + p.a2 * (-p.c2 * v).exp())
            }
            Self::StelterAsPrinted(p) => {
                let fast = if v > 0.0 { (-p.v1 / v).exp() } else { ZERO };
                p.mu_0
                    * (1.0 - p.a1 + p.a1 * fast)
                    * (1.0 - p.a2 + p.a2 * (-p.c2 * v.max(0.0)).exp())
            }
            Self::Coulomb { mu_k, .. } => *mu_k,
            Self::Stribeck {
                mu_s,
                mu_k,
                velocity,
                exponent,
                viscous,
            } => {
                let v = v.max(0.0);
                mu_k + (mu_s - mu_k) * (-(v / velocity).powf(*exponent)).exp() + viscous * v
            }
            Self::Table(table) => table.coefficient(v),
        }
    }

    /// Static coefficient: the largest |F_c|/F_N that stick can carry.
    pub fn static_coefficient(&self) -> Real {
        match self {
            Self::Coulomb { mu_s, .. } | Self::Stribeck { mu_s, .. } => *mu_s,
            other => other.coefficient(ZERO),
        }
    }

    /// Checks the constants.
    ///
    /// # Errors
    /// A coefficient that is negative, a velocity scale or exponent that is not positive.
    pub fn check(&self) -> Result<(), PhysicsError> {
        match self {
            Self::Stelter(p) | Self::StelterAsPrinted(p) => {
                require(
                    p.mu_0 >= 0.0,
                    "friction.mu_0",
                    p.mu_0,
                    "1",
                    "zero or positive",
                )?;
                require(p.v1 > 0.0, "friction.v1", p.v1, "m/s", "positive")?;
                require(
                    (0.0..=1.0).contains(&p.a1),
                    "friction.a1",
                    p.a1,
                    "1",
                    "between 0 and 1",
                )?;
                require(
                    (0.0..=1.0).contains(&p.a2),
                    "friction.a2",
                    p.a2,
                    "1",
                    "between 0 and 1",
                )?;
                require(p.c2 >= 0.0, "friction.c2", p.c2, "s/m", "zero or positive")
            }
            Self::Coulomb { mu_s, mu_k } => {
                require(
                    *mu_k >= 0.0,
                    "friction.mu_k",
                    *mu_k,
                    "1",
                    "zero or positive",
                )?;
                require(
                    mu_s >= mu_k,
                    "friction.mu_s",
                    *mu_s,
                    "1",
                    "at least friction.mu_k",
                )
            }
            Self::Stribeck {
                mu_s,
                mu_k,
                velocity,
                exponent,
                viscous,
            } => {
                require(
                    *mu_k >= 0.0,
                    "friction.mu_k",
                    *mu_k,
                    "1",
                    "zero or positive",
                )?;
                require(
                    mu_s >= mu_k,
                    "friction.mu_s",
                    *mu_s,
                    "1",
                    "at least friction.mu_k",
                )?;
                require(
                    *velocity > 0.0,
                    "friction.stribeck_velocity",
                    *velocity,
                    "m/s",
                    "positive",
                )?;
                require(
                    *exponent > 0.0,
                    "friction.stribeck_exponent",
                    *exponent,
                    "1",
                    "positive",
                )?;
                require(
                    *viscous >= 0.0,
                    "friction.viscous",
                    *viscous,
                    "s/m",
                    "zero or positive",
                )
            }
            Self::Table(_) => Ok(()),
        }
    }
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn val_eq7_as_read_falls_and_as_printed_rises() {
        // Source: Stelter 1992, eq. (7) and Figure 4, evaluated by hand.
        let read = FrictionLaw::default();
        assert_relative_eq!(read.static_coefficient(), 0.66);
        let at = |v: f64| 0.66 * (0.5 + 0.5 * (-v / 0.02).exp()) * (0.5 + 0.5 * (-0.25 * v).exp());
        assert_relative_eq!(read.coefficient(0.1), at(0.1), max_relative = 1e-15);
        let printed = FrictionLaw::StelterAsPrinted(Exponential::default());
        assert_relative_eq!(printed.static_coefficient(), 0.33);
        assert!(
            (1..28).all(|i| printed.coefficient(0.01 * i as f64)
                > printed.coefficient(0.01 * (i - 1) as f64))
        );
    }

    #[test]
    fn table_passes_through_its_points_and_stays_monotone() {
        let v = [0.0, 0.01, 0.05, 0.2];
        let mu = [0.66, 0.5, 0.34, 0.32];
        let law = FrictionLaw::Table(Table::new(&v, &mu).unwrap());
        for i in 0..4 {
            assert_relative_eq!(law.coefficient(v[i]), mu[i], max_relative = 1e-14);
        }
        let fine: Vec<_> = (0..400).map(|i| law.coefficient(i as f64 * 5e-4)).collect();
        assert!(fine.windows(2).all(|w| w[1] <= w[0] + 1e-15));
    }

    #[test]
    fn a_table_with_holes_is_refused() {
        let message = Table::new(&[0.0, 0.1, 0.2], &[0.6, f64::NAN, 0.3])
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("row 2") && message.contains("NaN"),
            "{message}"
        );
        assert!(Table::new(&[0.0, 0.0], &[0.6, 0.5]).is_err());
    }
}
