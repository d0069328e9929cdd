//! The elastic structure in modal coordinates (Stelter 1992, eqs. 1-6).

use crate::error::{PhysicsError, require};
use crate::real::{Real, ZERO, real};
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Most modes a model may have, effects that add modes included.
pub const MAX_MODES: usize = 8;

/// One modal oscillator, `q'' + (2 D w + d) q' + w^2 q = phi(1) F / m` with `w = 2 pi f`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModalOscillator {
    /// Natural frequency f in Hz; 0 is a mass that slides freely, without a spring.
    pub frequency: Real,
    /// Damping ratio D.
    pub damping_ratio: Real,
    /// Viscous damping per modal mass d = c/m in 1/s, beside what the ratio gives: that of a mass without a spring.
    pub damping_rate: Real,
    /// Modal mass m in kg.
    pub mass: Real,
    /// Value of the mode shape at the tip, phi(1).
    pub tip_value: Real,
}

impl ModalOscillator {
    /// Natural angular frequency w = 2 pi f in rad/s.
    pub fn angular_frequency(&self) -> Real {
        2.0 * PI * self.frequency
    }

    /// Factor of the modal velocity in the equation of motion, `2 D w + d` in 1/s.
    pub fn damping(&self) -> Real {
        2.0 * self.damping_ratio * self.angular_frequency() + self.damping_rate
    }
}

/// A structure driven and measured at its tip: `w_tip = sum_j phi_j(1) q_j`.
///
/// Any modal data are allowed: a one-mode spring-mass slider, a measured structure or a cantilever
/// given by its dimensions. Holds for small deflections (linear elasticity).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    modes: [ModalOscillator; MAX_MODES],
    count: usize,
    /// Shares of the modes in what the tip does where the clamp moves; at the start those of a cantilever.
    clamp_shares: [Real; MAX_MODES],
}

/// Dimensions of a uniform cantilever.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CantileverDimensions {
    /// Length l in m.
    pub length: Real,
    /// Young's modulus E in N/m^2.
    pub youngs_modulus: Real,
    /// Second moment of area I in m^4.
    pub second_moment: Real,
    /// Density rho in kg/m^3.
    pub density: Real,
    /// Cross-section A in m^2.
    pub area: Real,
}

impl Default for Beam {
    /// The nominal beam: 80 and 510 Hz, D = 0.00015 and 0.00085 (measured in Stelter 1992,
    /// section 2), modal mass 0.427 kg, tip values +2 and -2.
    fn default() -> Self {
        Self::nominal(2)
    }
}

impl Beam {
    /// A structure from given modal data.
    ///
    /// # Errors
    /// No mode or more than [`MAX_MODES`]; a mass that is not positive; a negative frequency,
    /// damping ratio or rate; a tip value that is zero or not finite for all modes.
    pub fn new(modes: &[ModalOscillator]) -> Result<Self, PhysicsError> {
        if modes.is_empty() || modes.len() > MAX_MODES {
            return Err(PhysicsError::ModeCount {
                count: modes.len(),
                max: MAX_MODES,
            });
        }
        for (j, mode) in modes.iter().enumerate() {
            let name = |what: &str| format!("mode[{}].{what}", j + 1);
            require(
                mode.frequency >= 0.0,
                &name("frequency"),
                mode.frequency,
                "Hz",
                "positive, or zero for a mass that slides freely",
            )?;
            require(
                mode.damping_ratio >= 0.0,
                &name("damping_ratio"),
                mode.damping_ratio,
                "1",
                "zero or positive",
            )?;
            require(
                mode.damping_rate >= 0.0,
                &name("damping_rate"),
                mode.damping_rate,
                "1/s",
                "zero or positive",
            )?;
            require(mode.mass > 0.0, &name("mass"), mode.mass, "kg", "positive")?;
            require(true, &name("tip_value"), mode.tip_value, "1", "finite")?;
        }
        if modes.iter().all(|m| m.tip_value == 0.0) {
            return Err(PhysicsError::OutOfRange {
                name: "mode[1].tip_value".into(),
                value: 0.0,
                unit: "1",
                required: "different from zero for at least one mode",
            });
        }
        let mut all = [modes[0]; MAX_MODES];
        all[..modes.len()].copy_from_slice(modes);
        Ok(Self {
            modes: all,
            count: modes.len(),
            clamp_shares: std::array::from_fn(cantilever_clamp_share),
        })
    }

    /// The nominal beam ([`Beam::default`]) with `count` modes, 1 to [`MAX_MODES`], continued as in
    /// [`Beam::from_frequencies`].
    ///
    /// # Panics
    /// With any other number of modes.
    pub fn nominal(count: usize) -> Self {
        Self::from_frequencies(
            &[80.0, 510.0].map(real),
            &[0.000_15, 0.000_85].map(real),
            real(0.427),
            count,
        )
        .expect("nominal data are valid")
    }

    /// A cantilever with the eigenfunctions of eq. (6): all modal masses are `mass` (= rho A l),
    /// tip values alternate +2, -2. Frequencies beyond those given follow
    /// `f_j = f_1 (k_j / k_1)^2`; damping ratios beyond those given repeat the last.
    ///
    /// # Errors
    /// As [`Beam::new`]; at least one frequency must be given.
    pub fn from_frequencies(
        frequencies: &[Real],
        damping_ratios: &[Real],
        mass: Real,
        count: usize,
    ) -> Result<Self, PhysicsError> {
        if count == 0 || count > MAX_MODES || frequencies.is_empty() {
            return Err(PhysicsError::ModeCount {
                count: count.min(frequencies.len()),
                max: MAX_MODES,
            });
        }
        let modes: Vec<_> = (0..count)
            .map(|j| ModalOscillator {
                frequency: frequencies
                    .get(j)
                    .copied()
                    .unwrap_or_else(|| frequencies[0] * (eigenvalue(j) / eigenvalue(0)).powi(2)),
                damping_ratio: damping_ratios
                    .get(j)
                    .or(damping_ratios.last())
                    .copied()
                    .unwrap_or(ZERO),
                damping_rate: ZERO,
                mass,
                tip_value: if j % 2 == 0 { real(2.0) } else { real(-2.0) },
            })
            .collect();
        Self::new(&modes)
    }

    /// A uniform cantilever from its dimensions: `w_j = k_j^2 sqrt(E I / (rho A l^4))`,
    /// `m = rho A l` (Stelter 1992, eqs. 1, 6).
    ///
    /// # Errors
    /// As [`Beam::new`], and when a dimension is not positive.
    pub fn from_dimensions(
        dimensions: &CantileverDimensions,
        damping_ratios: &[Real],
        count: usize,
    ) -> Result<Self, PhysicsError> {
        let d = dimensions;
        require(d.length > 0.0, "length", d.length, "m", "positive")?;
        require(
            d.youngs_modulus > 0.0,
            "youngs_modulus",
            d.youngs_modulus,
            "N/m^2",
            "positive",
        )?;
        require(
            d.second_moment > 0.0,
            "second_moment",
            d.second_moment,
            "m^4",
            "positive",
        )?;
        require(d.density > 0.0, "density", d.density, "kg/m^3", "positive")?;
        require(d.area > 0.0, "area", d.area, "m^2", "positive")?;
        let line_mass = d.density * d.area;
        let base = (d.youngs_modulus * d.second_moment / (line_mass * d.length.powi(4))).sqrt();
        let f1 = eigenvalue(0).powi(2) * base / (2.0 * PI);
        Self::from_frequencies(&[f1], damping_ratios, line_mass * d.length, count)
    }

    /// The same structure where the modes have other `shares` in what the tip does where the clamp moves: 1 for a mass on a
    /// spring.
    ///
    /// # Errors
    /// A share that is not finite.
    pub fn with_clamp_shares(self, shares: [Real; MAX_MODES]) -> Result<Self, PhysicsError> {
        for (j, share) in shares.iter().enumerate() {
            let name = format!("mode[{}].clamp_share", j + 1);
            require(true, &name, *share, "1", "finite")?;
        }
        Ok(Self {
            clamp_shares: shares,
            ..self
        })
    }

    /// Shares of the modes in what the tip does where the clamp moves.
    pub fn clamp_shares(&self) -> &[Real; MAX_MODES] {
        &self.clamp_shares
    }

    /// The modes, lowest first.
    pub fn modes(&self) -> &[ModalOscillator] {
        &self.modes[..self.count]
    }

    /// Adds a mode beyond those present.
    ///
    /// # Errors
    /// As [`Beam::new`].
    pub fn push(&mut self, mode: ModalOscillator) -> Result<(), PhysicsError> {
        let mut modes = self.modes().to_vec();
        modes.push(mode);
        *self = Self::new(&modes)?.with_clamp_shares(self.clamp_shares)?;
        Ok(())
    }

    /// Mobility of the tip, `sum_j phi_j^2 / m_j` in 1/kg: acceleration per unit tip force.
    pub fn tip_mobility(&self) -> Real {
        self.modes()
            .iter()
            .map(|m| m.tip_value * m.tip_value / m.mass)
            .sum()
    }
}

/// Eigenvalue k_(j+1) of the cantilever, the root of `cos k cosh k = -1` (k_1 = 1.8751, ...).
pub fn eigenvalue(j: usize) -> f64 {
    const FIRST: [f64; 3] = [
        1.875_104_068_711_961,
        4.694_091_132_974_175,
        7.854_757_438_237_613,
    ];
    FIRST.get(j).copied().unwrap_or_else(|| {
        // The asymptote (j + 1/2) pi, improved by one Newton step on cos k + 1/cosh k.
        let k0 = (j as f64 + 0.5) * PI;
        k0 - (k0.cos() + 1.0 / k0.cosh()) / (-k0.sin() - k0.sinh() / k0.cosh().powi(2))
    })
}

/// Scale of a cantilever's mode `j` whose shape is `tip_value` at the tip, against the eigenfunction of
/// eq. (6), which is +2, -2, +2, ... there; 1 where the mode does not move the tip.
///
/// Effects that need integrals of the mode shapes use it, so that neither sign nor norm of the modes
/// given changes the motion.
pub fn cantilever_scale(j: usize, tip_value: Real) -> Real {
    let reference = if j.is_multiple_of(2) { 2.0 } else { -2.0 };
    if tip_value == 0.0 {
        real(1.0)
    } else {
        tip_value / reference
    }
}

/// Eigenfunction of eq. (6) and its slope at `xi` in 0..1; `phi(1) = +2, -2, +2, ...`.
pub fn eigenfunction(j: usize, xi: f64) -> (f64, f64) {
    let k = eigenvalue(j);
    let x = k * xi;
    // With r = sigma - 1 the growing parts of cosh and sinh cancel analytically for high modes.
    let sigma = (k.cos() + k.cosh()) / (k.sin() + k.sinh());
    let value = sigma * (x.sin() - x.sinh()) - (x.cos() - x.cosh());
    let slope = k * (sigma * (x.cos() - x.cosh()) + x.sin() + x.sinh());
    (value, slope)
}

/// Integrals over the length that effects need.
pub struct ModeIntegrals {
    /// `integral of phi_j over xi` = 0.783, 0.434, 0.254, ...
    pub mean: [f64; MAX_MODES],
    /// `integral of phi_i' phi_j' over xi`.
    pub slope_product: [[f64; MAX_MODES]; MAX_MODES],
}

/// The integrals of the eigenfunctions of eq. (6), by Simpson's rule on 2000 intervals (error below
/// 1e-9 for all modes), computed once.
pub fn mode_integrals() -> &'static ModeIntegrals {
    static INTEGRALS: OnceLock<ModeIntegrals> = OnceLock::new();
    INTEGRALS.get_or_init(|| {
        const INTERVALS: usize = 2000;
        let mut out = ModeIntegrals {
            mean: [0.0; MAX_MODES],
            slope_product: [[0.0; MAX_MODES]; MAX_MODES],
        };
        for i in 0..=INTERVALS {
            let weight = match i {
                0 | INTERVALS => 1.0,
                i if i % 2 == 1 => 4.0,
                _ => 2.0,
            } / (3.0 * INTERVALS as f64);
            let at: [(f64, f64); MAX_MODES] =
                std::array::from_fn(|j| eigenfunction(j, i as f64 / INTERVALS as f64));
            for j in 0..MAX_MODES {
                out.mean[j] += weight * at[j].0;
                for k in 0..MAX_MODES {
                    out.slope_product[j][k] += weight * at[j].1 * at[k].1;
                }
            }
        }
        out
    })
}

/// Share of mode `j` of a cantilever in what the tip does where the clamp moves, `phi_j(1) integral(phi_j)` = 1.566, -0.868,
/// 0.509, ...: all modes together give 1, since a beam that moves as one body takes its tip along. The norm of the modes is
/// of no account.
pub fn cantilever_clamp_share(j: usize) -> Real {
    real(if j.is_multiple_of(2) { 2.0 } else { -2.0 } * mode_integrals().mean[j])
}

/// What a clamp's acceleration a does to the modes, `q_j'' = ... - g_j a`, in the unit of 1/phi: `g_j = (integral of phi_j dm)/m_j`
/// = clamp share / tip value; of a cantilever for a mode that does not move the tip.
pub fn clamp_participation(beam: &Beam) -> [Real; MAX_MODES] {
    let mut out = [ZERO; MAX_MODES];
    for (j, mode) in beam.modes().iter().enumerate() {
        out[j] = if mode.tip_value == 0.0 {
            real(mode_integrals().mean[j])
        } else {
            beam.clamp_shares[j] / mode.tip_value
        };
    }
    out
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn val_eigenvalues_and_tip_values_of_the_cantilever() {
        // Source: Blevins, Formulas for Natural Frequency and Mode Shape (1979), table 8-1.
        for (j, k) in [1.875_104, 4.694_091, 7.854_757, 10.995_541, 14.137_168]
            .iter()
            .enumerate()
        {
            assert_relative_eq!(eigenvalue(j), k, epsilon = 1e-6);
        }
        for j in 0..4 {
            let sign = if j % 2 == 0 { 2.0 } else { -2.0 };
            assert_relative_eq!(eigenfunction(j, 1.0).0, sign, epsilon = 1e-6);
        }
        for (j, mean) in [0.783, 0.434, 0.254].iter().enumerate() {
            assert_relative_eq!(mode_integrals().mean[j], mean, epsilon = 1e-3);
        }
    }

    #[test]
    fn val_dimensions_give_the_static_tip_stiffness() {
        // Source: beam theory, 3 E I / l^3; two modes carry 1 / (1/1.0301 - ...) of it: physics.md says 26.3 kN/m.
        let d = CantileverDimensions {
            length: 0.3,
            youngs_modulus: 2.1e11,
            second_moment: 0.0211 * 0.0086f64.powi(3) / 12.0,
            density: 7850.0,
            area: 0.0211 * 0.0086,
        };
        let beam = Beam::from_dimensions(&d, &[0.0], MAX_MODES).unwrap();
        let compliance: f64 = beam
            .modes()
            .iter()
            .map(|m| m.tip_value.powi(2) / (m.mass * m.angular_frequency().powi(2)))
            .sum();
        let exact = d.length.powi(3) / (3.0 * d.youngs_modulus * d.second_moment);
        assert_relative_eq!(compliance, exact, max_relative = 2e-4);
    }

    #[test]
    fn impossible_structures_are_refused() {
        let bad = ModalOscillator {
            frequency: 80.0,
            damping_ratio: 0.0,
            damping_rate: 0.0,
            mass: -1.0,
            tip_value: 2.0,
        };
        let message = Beam::new(&[bad]).unwrap_err().to_string();
        assert!(message.contains("mode[1].mass = -1 kg"), "{message}");
        assert!(matches!(
            Beam::new(&[]),
            Err(PhysicsError::ModeCount { count: 0, .. })
        ));
    }
}
