//! A motion as a curve: even samples from a state on, for pictures and comparisons of cycles.

use super::{Carry, Subject};
use crate::contact::ContactMode;
use crate::error::PhysicsError;
use crate::simulate::{Simulation, Start, StartContact};

/// The motion at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time in s.
    pub time: f64,
    /// Tip displacement w in m.
    pub displacement: f64,
    /// Tip velocity w' in m/s.
    pub velocity: f64,
    /// Whether the tip sticks.
    pub stuck: bool,
}

/// `count` + 1 samples over `duration` in s, both ends included, from a peak that a point ended with.
///
/// # Errors
/// A run that can't go on.
pub fn trace(
    subject: &Subject,
    from: &Carry,
    duration: f64,
    count: usize,
) -> Result<Vec<Sample>, PhysicsError> {
    let start = Start {
        state: from.state,
        contact: StartContact::Slip,
        belt_travel: from.travel,
        ..Start::default()
    };
    let inputs = subject.model.inputs;
    let mut run = Simulation::from_model(subject.model.clone(), inputs, &start, subject.tolerance)?;
    (0..=count)
        .map(|i| {
            let time = duration * i as f64 / count as f64;
            run.advance_to(time)?;
            let (displacement, velocity) = subject.model.tip(&run.state());
            Ok(Sample {
                time,
                displacement,
                velocity,
                stuck: run.contact_mode() == ContactMode::Stuck,
            })
        })
        .collect()
}

/// Distance of two cycles of `samples` each: the root mean square of their difference in displacement at equal shares
/// of their periods, both begun at the peak, over the amplitude of the second.
///
/// 0 for the same shape; differences of the periods do not count (compare them separately).
pub fn cycle_distance(cycle: &[Sample], reference: &[Sample]) -> f64 {
    let range = |s: &[Sample]| {
        let all = s.iter().map(|p| p.displacement);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), w| {
            (l.min(w), h.max(w))
        });
        0.5 * (high - low)
    };
    let pairs = cycle.iter().zip(reference);
    let squares: f64 = pairs
        .map(|(a, b)| (a.displacement - b.displacement).powi(2))
        .sum();
    (squares / reference.len() as f64).sqrt() / range(reference)
}
