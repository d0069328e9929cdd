//! How well what a campaign states is known.

/// Standard deviations of stated quantities, as shares of the value (0.01 is one percent).
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Of a factor that all belt velocities share; tachometers and drives on a rig are good for 1 %.
    pub belt_velocity_std: f64,
    /// Of a factor that all normal forces share; load cells and weights, 2.5 %.
    pub normal_force_std: f64,
    /// Of each run's belt velocity besides; 0 where nothing is stated: one drive, one tachometer.
    pub belt_velocity_run_std: f64,
    /// Of each run's normal force besides; 0 where nothing is stated. It acts as the friction level of the run does.
    pub normal_force_run_std: f64,
    /// Of each natural frequency; modal analysis of the structure as mounted, 0.6 %.
    pub natural_frequencies_std: f64,
    /// Of what a force at the tip does to each mode, `phi_j^2 / m_j`: tip values to 2.5 % and modal masses to 3 % give 6 %.
    pub participations_std: f64,
    /// Of the first sensor's zero, in the unit of what is measured; `None` where nothing is stated: 2 % of what varies.
    pub zero_std: Option<f64>,
    /// What is stated mode by mode, which goes first.
    pub of_modes: OfModes,
}

/// Standard deviations of modal data as shares of the value, one for each mode; empty where none are stated.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OfModes {
    /// Of the natural frequencies.
    pub frequencies: Vec<f64>,
    /// Of the damping ratios.
    pub damping_ratios: Vec<f64>,
    /// Of the damping rates.
    pub damping_rates: Vec<f64>,
    /// Of the modal masses.
    pub masses: Vec<f64>,
    /// Of the mode shapes at the tip.
    pub tip_values: Vec<f64>,
}

/// Standard deviation of a modal mass as a share, where only the tip values' is stated.
const MASS_STD: f64 = 0.03;
/// The same of a tip value, where only the masses' is stated.
pub(super) const TIP_VALUE_STD: f64 = 0.025;
/// The same of a damping ratio: half-power widths and decrements of lightly damped modes scatter by half of the value.
const DAMPING_STD: f64 = 0.5;

impl Default for Uncertainty {
    fn default() -> Self {
        Self {
            belt_velocity_std: 0.01,
            normal_force_std: 0.025,
            belt_velocity_run_std: 0.0,
            normal_force_run_std: 0.0,
            natural_frequencies_std: 0.006,
            participations_std: 0.06,
            zero_std: None,
            of_modes: OfModes::default(),
        }
    }
}

impl Uncertainty {
    /// Of the natural frequency of mode `j` (from 0), as a share.
    pub fn frequency(&self, j: usize) -> f64 {
        stated(&self.of_modes.frequencies, j).unwrap_or(self.natural_frequencies_std)
    }

    /// Of its damping ratio.
    pub fn damping_ratio(&self, j: usize) -> f64 {
        stated(&self.of_modes.damping_ratios, j).unwrap_or(DAMPING_STD)
    }

    /// Of its damping rate, which scatters as a ratio does.
    pub fn damping_rate(&self, j: usize) -> f64 {
        stated(&self.of_modes.damping_rates, j).unwrap_or(DAMPING_STD)
    }

    /// Of its participation `phi_j^2 / m_j`: that of the mass and twice that of the tip value together.
    pub fn participation(&self, j: usize) -> f64 {
        let mass = stated(&self.of_modes.masses, j);
        let tip_value = stated(&self.of_modes.tip_values, j);
        match (mass, tip_value) {
            (None, None) => self.participations_std,
            (mass, tip_value) => mass
                .unwrap_or(MASS_STD)
                .hypot(2.0 * tip_value.unwrap_or(TIP_VALUE_STD)),
        }
    }
}

fn stated(shares: &[f64], j: usize) -> Option<f64> {
    shares.get(j).copied().filter(|share| share.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stated_of_a_mode_goes_before_what_holds_for_all() {
        let u = Uncertainty {
            of_modes: OfModes {
                frequencies: vec![0.001],
                masses: vec![0.04, 0.04],
                tip_values: vec![0.015, f64::NAN],
                ..OfModes::default()
            },
            ..Uncertainty::default()
        };
        assert_eq!((u.frequency(0), u.frequency(1)), (0.001, 0.006));
        assert!((u.participation(0) - 0.05).abs() < 1e-12);
        assert!((u.participation(1) - 0.04f64.hypot(0.05)).abs() < 1e-12);
        assert_eq!((u.participation(2), u.damping_ratio(0)), (0.06, 0.5));
    }
}
