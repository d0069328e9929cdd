//! The unknown functions of a campaign: what their nodes cover.

use super::effect_file::UnknownFunction;
use super::latent_values::NODES;
use super::places::{
    ALL, Argument, DAMPING, DEFLECTION, DWELL, FIRST_FREQUENCY, FREQUENCY, FRICTION,
    FRICTION_LEVEL, LOAD, MEASUREMENT, NORMAL_FORCE, PAST_POWER, PAST_SPEED, Place, SPEED, TIME,
    TIP_FORCE, VELOCITY,
};
use crate::measurement::{Campaign, Measurand};
use crate::metric::velocity;
use crate::observer::Structure;

/// Samples to either side of one at which the fastest motion of a free mass is looked for.
const SLOPE_HALF_WIDTH: usize = 5;

/// Peak velocity in m/s of a harmonic motion of this amplitude in m and frequency in Hz.
fn velocity_of(amplitude: f64, frequency_hz: f64) -> f64 {
    amplitude * std::f64::consts::TAU * frequency_hz
}

/// A frequency in Hz by which the motions of a campaign are measured: the lowest natural one, or, where no mode has a spring, that
/// of a harmonic motion as wide and as fast as the widest and the fastest measured. `ranges` is of the displacement, run by run
/// ([`crate::diagnose::model::displacement_range`]).
pub fn lowest_frequency(campaign: &Campaign, structure: &Structure, ranges: &[(f64, f64)]) -> f64 {
    let sprung = structure.modes().iter().filter(|m| !m.is_free());
    let lowest = sprung.map(|m| m.frequency_hz).fold(f64::INFINITY, f64::min);
    if lowest.is_finite() {
        return lowest;
    }
    let of_run = |(run, &(low, high)): (&crate::measurement::Run, &(f64, f64))| {
        let size = |a: f64, v: &f64| a.max(v.abs());
        // The range is of the tip, what is measured where the sensor looks.
        let half = 0.5 * (high - low) * campaign.beam.seen_share().abs();
        let angular = match run.measurand {
            Measurand::Displacement => {
                let speed = velocity(&run.time, &run.measured, SLOPE_HALF_WIDTH);
                speed.iter().fold(0.0, size) / half
            }
            Measurand::Velocity => run.measured.iter().fold(0.0, size) / half,
            Measurand::Acceleration => (run.measured.iter().fold(0.0, size) / half).sqrt(),
        };
        angular / std::f64::consts::TAU
    };
    let runs = campaign.runs.iter().zip(ranges);
    let highest = runs.map(of_run).fold(0.0, f64::max);
    if highest > 0.0 { highest } else { 1.0 }
}

/// Least and largest normal force that the runs of a campaign state, N.
pub(in crate::diagnose::model) fn loads(campaign: &Campaign) -> (f64, f64) {
    let of_run = |run: &crate::measurement::Run| match &run.inputs.normal_force {
        Some(series) => series.values.clone(),
        None => vec![run.normal_force],
    };
    let all = campaign.runs.iter().flat_map(of_run);
    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), f| {
        (low.min(f), high.max(f))
    })
}

/// The unknown functions of a campaign: their nodes cover what its runs pass. `lowest_hz` is that of [`lowest_frequency`], and
/// so are `ranges`. What would act on a sensor of displacements is left out where something else was measured.
pub fn unknown_functions(
    campaign: &Campaign,
    lowest_hz: f64,
    tip_mass_kg: f64,
    ranges: &[(f64, f64)],
) -> Vec<UnknownFunction> {
    let runs = &campaign.runs;
    let most =
        |of: &dyn Fn(&crate::measurement::Run) -> f64| runs.iter().map(of).fold(0.0, f64::max);
    let all = ranges.iter();
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| {
        (l.min(r.0), h.max(r.1))
    });
    let is_measured =
        |place: &Place| *place != MEASUREMENT || campaign.measurand() == Measurand::Displacement;
    let half = (0.5 * (high - low)).max(1e-9);
    let belt = most(&|r| r.belt_velocity.abs());
    let force = most(&|r| r.normal_force);
    let mean_force = runs.iter().map(|r| r.normal_force).sum::<f64>() / runs.len().max(1) as f64;
    // Where nothing rubs, forces are measured by the one that drives; where nothing drives either, by that of the moving mass.
    let push = |r: &crate::measurement::Run| {
        let shaken = tip_mass_kg * r.inputs.clamp_acceleration.largest();
        r.inputs.external_force.largest().max(shaken)
    };
    let inertia = tip_mass_kg * half * (std::f64::consts::TAU * lowest_hz).powi(2);
    let scales = [mean_force, most(&push), inertia];
    let mean_force = scales.into_iter().find(|f| *f > 0.0).unwrap_or(1.0);
    let sliding = if belt > 0.0 {
        belt
    } else {
        velocity_of(half, lowest_hz)
    };
    // A harmonic motion of this amplitude at the lowest natural frequency, or the belt, where that is faster.
    let velocity = velocity_of(half, lowest_hz).max(belt);
    let duration = most(&|r| r.time[r.time.len() - 1]);
    let range = |argument: Argument| match argument {
        DEFLECTION => (low, high),
        VELOCITY => (-velocity, velocity),
        SPEED => (0.0, velocity + belt),
        TIME => (0.0, duration),
        // Stick lasts for a period or a few.
        DWELL => (0.0, 3.0 / lowest_hz),
        LOAD => loads(campaign),
        PAST_SPEED => (0.0, velocity),
        PAST_POWER => (0.0, force * sliding),
        _ => (0.0, high.abs().max(low.abs())),
    };
    let strength = |place: Place| match place {
        FRICTION | FRICTION_LEVEL | NORMAL_FORCE => 0.3,
        TIP_FORCE => 0.1 * mean_force,
        FREQUENCY | FIRST_FREQUENCY => 0.03,
        DAMPING => 5.0,
        MEASUREMENT => 0.1 * half,
        _ => 0.1,
    };
    ALL.iter()
        .filter(|(place, _)| is_measured(place))
        .map(|&(place, argument)| {
            let (from, to) = match range(argument) {
                // It does not vary in this campaign: the curve can't act, and its nodes may be anywhere.
                (from, to) if to <= from => (from, from + 1.0),
                wide => wide,
            };
            let at: Vec<f64> = (0..NODES)
                .map(|i| from + (to - from) * i as f64 / (NODES - 1) as f64)
                .collect();
            UnknownFunction::new(place, argument, at, strength(place), mean_force)
        })
        .collect()
}
