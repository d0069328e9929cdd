//! What the sensor at the tip measures.

use serde::{Deserialize, Serialize};

use super::Campaign;

/// The quantity that a run holds: what its sensor measures at the tip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Measurand {
    /// Displacement w in m: a distance sensor.
    #[default]
    Displacement,
    /// Velocity w' in m/s: a vibrometer.
    Velocity,
    /// Acceleration w'' in m/s^2: an accelerometer.
    Acceleration,
}

impl Measurand {
    /// What a run may hold.
    pub const ALL: [Measurand; 3] = [
        Measurand::Displacement,
        Measurand::Velocity,
        Measurand::Acceleration,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Measurand::Displacement => "displacement",
            Measurand::Velocity => "velocity",
            Measurand::Acceleration => "acceleration",
        }
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Measurand::Displacement => "m",
            Measurand::Velocity => "m/s",
            Measurand::Acceleration => "m/s^2",
        }
    }

    /// A thousandth of [`Self::unit`], in which motions of a tip are read best.
    pub fn milli_unit(self) -> &'static str {
        match self {
            Measurand::Displacement => "mm",
            Measurand::Velocity => "mm/s",
            Measurand::Acceleration => "mm/s^2",
        }
    }

    /// Its sign in formulas.
    pub fn symbol(self) -> &'static str {
        match self {
            Measurand::Displacement => "w",
            Measurand::Velocity => "w'",
            Measurand::Acceleration => "w''",
        }
    }

    /// The key of campaign.toml that names its column.
    pub fn column_key(self) -> &'static str {
        match self {
            Measurand::Displacement => "displacement_column",
            Measurand::Velocity => "velocity_column",
            Measurand::Acceleration => "acceleration_column",
        }
    }

    /// The key of campaign.toml with the factor of its column.
    pub fn scale_key(self) -> &'static str {
        match self {
            Measurand::Displacement => "displacement_scale",
            Measurand::Velocity => "velocity_scale",
            Measurand::Acceleration => "acceleration_scale",
        }
    }

    /// The column that it has in a campaign's CSV where campaign.toml names none.
    pub fn usual_column(self) -> &'static str {
        match self {
            Measurand::Displacement => "tip_displacement_m",
            Measurand::Velocity => "tip_velocity_m_per_s",
            Measurand::Acceleration => "tip_acceleration_m_per_s2",
        }
    }
}

/// The standard deviation of a sensor's noise, under the key that names its unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum NoiseStd {
    /// Of a displacement.
    Displacement {
        /// In m.
        noise_std_m: f64,
    },
    /// Of a velocity.
    Velocity {
        /// In m/s.
        noise_std_m_per_s: f64,
    },
    /// Of an acceleration.
    Acceleration {
        /// In m/s^2.
        noise_std_m_per_s2: f64,
    },
}

impl NoiseStd {
    /// A standard deviation in the measurand's SI unit.
    pub fn of(measurand: Measurand, std: f64) -> Self {
        match measurand {
            Measurand::Displacement => Self::Displacement { noise_std_m: std },
            Measurand::Velocity => Self::Velocity {
                noise_std_m_per_s: std,
            },
            Measurand::Acceleration => Self::Acceleration {
                noise_std_m_per_s2: std,
            },
        }
    }

    /// The number.
    pub fn value(self) -> f64 {
        match self {
            Self::Displacement { noise_std_m: std }
            | Self::Velocity {
                noise_std_m_per_s: std,
            }
            | Self::Acceleration {
                noise_std_m_per_s2: std,
            } => std,
        }
    }
}

impl Campaign {
    /// What was measured at the tip, the same in all runs.
    pub fn measurand(&self) -> Measurand {
        self.runs
            .first()
            .map_or_else(Measurand::default, |run| run.measurand)
    }
}
