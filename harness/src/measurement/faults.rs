//! Samples that the recorder, not the beam, made: clipped at the end of the range, or held.

use super::measurand::Measurand;
use std::ops::Range;

/// A stretch of equal samples that no motion explains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fault {
    /// What it looks like.
    pub kind: FaultKind,
    /// Index of its first sample.
    pub first: usize,
    /// Number of samples.
    pub samples: usize,
}

/// Kinds of fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// At the largest or smallest value of the run: the range was too small.
    Clipped,
    /// Elsewhere: samples were lost and the last value repeated.
    Held,
}

/// Shortest stretches that count. At a turning point a quantised signal repeats a value or two by itself.
const CLIPPED_FROM: usize = 3;
const HELD_FROM: usize = 5;
/// A stretch must be this improbable as chance among the equal samples that a coarse recorder makes anyway.
const BY_CHANCE: f64 = 0.01;
/// A step into or out of the stretch must exceed this many resolution steps, else the motion is just slow.
const ABRUPT: f64 = 5.0;

/// Share of equal neighbours inside the range below which a recorder is fine: there, equal samples at an end of the range need no
/// abrupt step to be clipped ones, only [`LONG`] of them. A smooth crest of so fine a record repeats a value four times at most
/// (1000 samples per radian, `2 sqrt(2 q/A)/(w dt)` samples within one step `q` of the crest `A`).
const FINE: f64 = 0.002;
const LONG: usize = 8;

/// The faults of what was measured, recorded with this resolution, on a belt of this velocity (m/s).
pub(super) fn of(measurand: Measurand, signal: &[f64], resolution: f64, belt: f64) -> Vec<Fault> {
    match measurand {
        Measurand::Displacement => find(signal, resolution),
        Measurand::Velocity => of_velocity(signal, resolution, belt),
        Measurand::Acceleration => of_acceleration(signal, resolution),
    }
}

/// What is left of stretches of samples, in order, without the faults.
pub(super) fn between(faults: &[Fault], stretches: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let mut left = Vec::new();
    for Range { mut start, end } in stretches {
        for fault in faults.iter().filter(|fault| fault.first < end) {
            left.push(start..fault.first);
            start = start.max(fault.first + fault.samples);
        }
        left.push(start..end);
    }
    left.retain(|stretch| !stretch.is_empty());
    left
}

/// Finds stretches of equal samples with an abrupt step at one end, and long ones at an end of a finely recorded range.
fn find(signal: &[f64], resolution: f64) -> Vec<Fault> {
    let largest = signal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = signal.iter().copied().fold(f64::INFINITY, f64::min);
    let equal = signal.windows(2).filter(|w| w[0] == w[1]).count() as f64 / signal.len() as f64;
    let by_chance = |samples: usize| signal.len() as f64 * equal.powi(samples as i32 - 1);
    let inside = |w: &&[f64]| w[0] == w[1] && w[0] != largest && w[0] != smallest;
    let fine = signal.windows(2).filter(inside).count() as f64 <= FINE * signal.len() as f64;
    let mut faults = Vec::new();
    let mut first = 0_usize;
    for stretch in signal.chunk_by(|a, b| a == b) {
        let (value, samples) = (stretch[0], stretch.len());
        let before = first
            .checked_sub(1)
            .map_or(0.0, |i| (signal[i] - value).abs());
        let after = signal
            .get(first + samples)
            .map_or(0.0, |v| (v - value).abs());
        let kind = if value == largest || value == smallest {
            FaultKind::Clipped
        } else {
            FaultKind::Held
        };
        let shortest = if kind == FaultKind::Clipped {
            CLIPPED_FROM
        } else {
            HELD_FROM
        };
        let abrupt = by_chance(samples) < BY_CHANCE && before.max(after) > ABRUPT * resolution;
        let saturated = kind == FaultKind::Clipped && fine && samples >= LONG;
        if samples >= shortest && (abrupt || saturated) {
            faults.push(Fault {
                kind,
                first,
                samples,
            });
        }
        first += samples;
    }
    faults
}

/// Distance from the belt's velocity, as a share of it and in steps of the recorder, within which a velocity is that of stick.
const WITH_THE_BELT: f64 = 0.05;
const STEPS: f64 = 3.0;

/// The faults of a measured velocity (m/s): in stick it stays at that of the belt (m/s), often the largest of the run, and a
/// coarse recorder or a simulation shows equal samples there.
fn of_velocity(signal: &[f64], resolution: f64, belt: f64) -> Vec<Fault> {
    let near = WITH_THE_BELT * belt.abs() + STEPS * resolution;
    away_from(belt, near, signal, resolution)
}

/// The faults of a measured acceleration (m/s^2): in stick on a belt of constant speed it stays at zero.
fn of_acceleration(signal: &[f64], resolution: f64) -> Vec<Fault> {
    away_from(0.0, STEPS * resolution, signal, resolution)
}

/// The faults but those within `near` of the value that stick has.
fn away_from(in_stick: f64, near: f64, signal: &[f64], resolution: f64) -> Vec<Fault> {
    let sticks = |fault: &Fault| (signal[fault.first] - in_stick).abs() <= near;
    let mut faults = find(signal, resolution);
    faults.retain(|fault| !sticks(fault));
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(quantum: f64) -> Vec<f64> {
        (0..1900)
            .map(|i| ((0.01 * f64::from(i)).sin() / quantum).round() * quantum)
            .collect()
    }

    #[test]
    fn val_a_coarsely_quantised_sine_has_no_fault() {
        assert_eq!(find(&sine(0.02), 0.02), []);
    }

    #[test]
    fn val_a_clipped_sine_is_clipped_at_every_crest() {
        let clipped: Vec<f64> = sine(1e-6).into_iter().map(|v| v.min(0.9)).collect();
        let faults = find(&clipped, 1e-6);
        assert_eq!(faults.len(), 3, "{faults:?}");
        assert!(
            faults
                .iter()
                .all(|f| f.kind == FaultKind::Clipped && f.samples > 80)
        );
    }

    #[test]
    fn val_slow_clipping_of_a_fine_record_is_found() {
        // The signal creeps into the limit: no step is abrupt.
        let clipped: Vec<f64> = sine(1e-9).into_iter().map(|v| v.min(0.9)).collect();
        let faults = find(&clipped, 1e-2);
        assert_eq!(faults.len(), 3, "{faults:?}");
        assert!(faults.iter().all(|f| f.kind == FaultKind::Clipped));
        assert_eq!(find(&sine(1e-9), 1e-2), []);
        assert_eq!(find(&sine(0.02), 1e-2), []);
    }

    #[test]
    fn val_the_velocity_of_stick_is_no_fault_and_the_end_of_a_range_is_one() {
        // A cycle of 300 samples: at the belt's 0.1 m/s, then a swing down and back.
        let cycle = |i: i32| match i % 300 {
            0..200 => 0.1,
            rest => 0.1 - 0.3 * (std::f64::consts::PI * f64::from(rest - 200) / 100.0).sin(),
        };
        let velocity: Vec<f64> = (0..3000).map(cycle).collect();
        assert_eq!(of_velocity(&velocity, 1e-6, 0.1), []);
        let clipped: Vec<f64> = velocity.iter().map(|v| v.max(-0.15)).collect();
        let faults = of_velocity(&clipped, 1e-6, 0.1);
        assert_eq!(faults.len(), 10, "{faults:?}");
        assert!(faults.iter().all(|f| f.kind == FaultKind::Clipped));
    }

    #[test]
    fn val_stretches_end_where_a_fault_begins() {
        let fault = |first, samples| Fault {
            kind: FaultKind::Held,
            first,
            samples,
        };
        // One inside, one over a gap at 50, one at the end.
        let faults = [fault(10, 5), fault(45, 10), fault(90, 10)];
        assert_eq!(
            between(&faults, vec![0..50, 50..100]),
            [0..10, 15..45, 55..90]
        );
        assert_eq!(between(&[], vec![0..50, 50..100]), [0..50, 50..100]);
    }

    #[test]
    fn val_a_held_value_is_found() {
        let mut held = sine(1e-6);
        let value = held[299];
        held[300..310].fill(value);
        assert_eq!(
            find(&held, 1e-6),
            [Fault {
                kind: FaultKind::Held,
                first: 299,
                samples: 11
            }]
        );
    }
}
