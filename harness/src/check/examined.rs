//! A run beside what is stated of it, in ratios that are near 1 where all is well.

use super::motion::Motion;
use crate::measurement::{BeamKnowledge, Run};

/// A run with its motion.
pub struct Examined<'a> {
    /// The run.
    pub run: &'a Run,
    /// What it says of itself.
    pub motion: Motion,
    /// Static stiffness of the tip from what is stated, N/m.
    pub stiffness: Option<f64>,
    /// Lowest natural frequency stated, Hz.
    pub lowest: Option<f64>,
}

/// Mode shape at the tip where none is stated: of the eigenfunctions of a clamped beam.
const TIP_VALUE: f64 = 2.0;
/// Range of a motion without stick over `belt speed / natural frequency`: 2 if the tip's speed just
/// reaches the belt's; more for higher modes.
const RANGE_BY_SPEED: f64 = 2.5;

impl<'a> Examined<'a> {
    /// Of a run on a beam.
    pub fn of(run: &'a Run, beam: &BeamKnowledge) -> Examined<'a> {
        let springs = beam.natural_frequencies_hz.iter().filter(|f| **f > 0.0);
        let mut examined = Examined {
            run,
            motion: Motion::of(run, beam),
            stiffness: stiffness(beam),
            lowest: springs.copied().reduce(f64::min),
        };
        if !beam.sensor.is_tip() {
            // Higher modes ring on there.
            examined.motion.stick_speed = None;
        }
        if !run.sustains_itself() {
            // Speeds and deflections of a driven motion are the drive's as much as the structure's, and those of one that
            // dies out are its start's.
            examined.stiffness = None;
            examined.motion.stick_speed = None;
            examined.motion.slip_frequency = None;
        }
        examined
    }

    /// Stick speed over the stated belt speed.
    pub fn speed_ratio(&self) -> Option<f64> {
        let ratio = self.motion.stick_speed? / self.run.belt_velocity;
        ratio.is_finite().then_some(ratio)
    }

    /// Frequency of the motion in slip over the lowest stated one.
    pub fn frequency_ratio(&self) -> Option<f64> {
        let ratio = self.motion.slip_frequency? / self.lowest?;
        let seen = self.motion.stick_share >= super::thresholds::STICK_FOR_FREQUENCY;
        seen.then_some(ratio)
    }

    /// The force that bends the tip over the range of its motion, over the normal force.
    pub fn range_ratio(&self) -> Option<f64> {
        let ratio = self.stiffness? * self.motion.range / self.run.normal_force;
        ratio.is_finite().then_some(ratio)
    }

    /// The part of [`Self::range_ratio`] that needs no friction: a motion as fast as the belt.
    pub fn range_by_speed(&self) -> Option<f64> {
        let omega = std::f64::consts::TAU * self.lowest?;
        let range = RANGE_BY_SPEED * self.run.belt_velocity.abs() / omega;
        let ratio = self.stiffness? * range / self.run.normal_force;
        ratio.is_finite().then_some(ratio)
    }

    /// Mean deflection times stiffness over the normal force: the mean coefficient of friction, if
    /// the sensor has no offset.
    pub fn mean_friction(&self) -> Option<f64> {
        let ratio = self.stiffness? * self.motion.mean? / self.run.normal_force;
        ratio.is_finite().then_some(ratio)
    }
}

/// `1 / sum phi_j^2 / (m_j w_j^2)`, where masses and frequencies are stated.
fn stiffness(beam: &BeamKnowledge) -> Option<f64> {
    let modes = beam.natural_frequencies_hz.len();
    let slides = beam.natural_frequencies_hz.contains(&0.0);
    if modes == 0 || slides || beam.masses_kg.len() != modes {
        return None;
    }
    let tip = |j: usize| beam.tip_values.get(j).copied().unwrap_or(TIP_VALUE);
    let mode = |j: usize| {
        let omega = std::f64::consts::TAU * beam.natural_frequencies_hz[j];
        tip(j).powi(2) / (beam.masses_kg[j] * omega * omega)
    };
    let compliance: f64 = (0..modes).map(mode).sum();
    (compliance > 0.0).then(|| 1.0 / compliance)
}
