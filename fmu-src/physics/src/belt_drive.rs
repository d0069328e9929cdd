//! A belt drive: a motor that pulls, through an elastic belt, the mass that the friction force brakes.
//!
//! `M u' = -F - k x - c (u - v_m),  x' = u - v_m`
//!
//! M mass of the belt and its rollers at the contact (kg), u velocity of the belt there (m/s), F friction force
//! on the beam's tip, whose reaction brakes the belt (N), v_m velocity at which the motor pays out (m/s), k and
//! c stiffness (N/m) and damping (N.s/m) of the belt between motor and contact, x its stretch (m).
//!
//! Holds for a motor that keeps its speed whatever the load. With constant v_m it is the two-mass system of
//! Popp and Stelter 1990, Phil. Trans. R. Soc. A 332:89, whose other mass is the beam.

use crate::error::{PhysicsError, require};
use nalgebra::{Matrix4, Vector4};

/// Constants of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeltDrive {
    /// Mass M in kg.
    pub mass: f64,
    /// Stiffness k in N/m.
    pub stiffness: f64,
    /// Damping c in N.s/m.
    pub damping: f64,
}

/// What acts on the drive during a step, linear in the time since its begin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Load {
    /// Friction force F in N on the beam's tip, and its rate in N/s.
    pub friction_force: [f64; 2],
    /// Velocity v_m in m/s of the motor, and its rate in m/s^2.
    pub motor_velocity: [f64; 2],
}

/// State of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveState {
    /// Stretch x in m.
    pub stretch: f64,
    /// Velocity u of the belt in m/s.
    pub velocity: f64,
}

impl BeltDrive {
    /// Checks the constants.
    ///
    /// # Errors
    /// A mass that is not positive, a negative stiffness or damping, a value that is not finite.
    pub fn check(&self) -> Result<(), PhysicsError> {
        let Self {
            mass,
            stiffness,
            damping,
        } = *self;
        require(mass > 0.0, "mass", mass, "kg", "positive")?;
        let not_negative = "zero or positive";
        require(
            stiffness >= 0.0,
            "stiffness",
            stiffness,
            "N/m",
            not_negative,
        )?;
        require(damping >= 0.0, "damping", damping, "N.s/m", not_negative)
    }

    /// Force in N with which the motor pulls at the belt.
    pub fn pull(&self, state: &DriveState, motor_velocity: f64) -> f64 {
        -self.stiffness * state.stretch - self.damping * (state.velocity - motor_velocity)
    }

    /// The belt's acceleration in m/s^2.
    pub fn acceleration(&self, state: &DriveState, load: &Load) -> f64 {
        (self.pull(state, load.motor_velocity[0]) - load.friction_force[0]) / self.mass
    }

    /// The state after `step` in s, exact to rounding: the equations are linear, and time joins the states.
    pub fn after(&self, state: &DriveState, load: &Load, step: f64) -> DriveState {
        let [force, force_rate] = load.friction_force;
        let [motor, motor_rate] = load.motor_velocity;
        let (k, c) = (self.stiffness / self.mass, self.damping / self.mass);
        // Of x, u, 1 and the time since the step's begin.
        #[rustfmt::skip]
        let rates = Matrix4::new(
            0.0, 1.0, -motor, -motor_rate,
            -k, -c, c * motor - force / self.mass, c * motor_rate - force_rate / self.mass,
            0.0, 0.0, 0.0, 0.0,
            0.0, 0.0, 1.0, 0.0,
        );
        let start = Vector4::new(state.stretch, state.velocity, 1.0, 0.0);
        let end = (rates * step).exp() * start;
        DriveState {
            stretch: end[0],
            velocity: end[1],
        }
    }
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const DRIVE: BeltDrive = BeltDrive {
        mass: 1.5,
        stiffness: 2e4,
        damping: 50.0,
    };

    #[test]
    fn val_a_free_vibration_decays_as_the_formula_says() {
        // Truth: x = exp(-d t) (x0 cos w t + (x0' + d x0)/w sin w t), d = c/2M, w^2 = k/M - d^2.
        let (x0, t) = (1e-3, 0.0137);
        let start = DriveState {
            stretch: x0,
            velocity: 0.0,
        };
        let end = DRIVE.after(&start, &Load::default(), t);
        let d: f64 = 50.0 / 3.0;
        let w = (2e4 / 1.5 - d * d).sqrt();
        let x = (-d * t).exp() * x0 * ((w * t).cos() + d / w * (w * t).sin());
        assert_relative_eq!(end.stretch, x, epsilon = 1e-16);
    }

    #[test]
    fn val_a_ramp_of_the_force_is_followed_as_the_formula_says() {
        // Truth: with F = r t the particular solution is x = -(r/k) (t - c/k), u - v_m = -r/k.
        let (rate, motor) = (300.0, 0.1);
        let at = |t: f64| DriveState {
            stretch: -rate / 2e4 * (t - 50.0 / 2e4),
            velocity: motor - rate / 2e4,
        };
        let load = Load {
            friction_force: [0.0, rate],
            motor_velocity: [motor, 0.0],
        };
        let end = DRIVE.after(&at(0.0), &load, 0.02);
        assert_relative_eq!(end.stretch, at(0.02).stretch, epsilon = 1e-16);
        assert_relative_eq!(end.velocity, at(0.02).velocity, epsilon = 1e-14);
    }

    #[test]
    fn one_step_is_as_good_as_many() {
        let load = Load {
            friction_force: [40.0, -2e3],
            motor_velocity: [0.1, 0.5],
        };
        let start = DriveState {
            stretch: -1e-3,
            velocity: 0.03,
        };
        let whole = DRIVE.after(&start, &load, 0.01);
        let mut parts = start;
        for i in 0..10 {
            let at = |[value, rate]: [f64; 2]| [value + rate * 1e-3 * f64::from(i), rate];
            let now = Load {
                friction_force: at(load.friction_force),
                motor_velocity: at(load.motor_velocity),
            };
            parts = DRIVE.after(&parts, &now, 1e-3);
        }
        assert_relative_eq!(whole.stretch, parts.stretch, epsilon = 1e-15);
        assert_relative_eq!(whole.velocity, parts.velocity, epsilon = 1e-13);
    }

    #[test]
    fn a_mass_of_zero_is_refused() {
        let drive = BeltDrive { mass: 0.0, ..DRIVE };
        assert!(drive.check().unwrap_err().to_string().contains("mass = 0"));
    }
}
