//! Motion, phases and friction force of a run by the smoother, what an external force does alone taken off first.

use crate::diagnose::data::driven_motion::{BeltPath, differences, driven_motion, sampled};
use crate::diagnose::data::smoothing::{Smoothing, smoother_settings, trusted_signal};
use crate::diagnose::data::velocity_level::settle;
use crate::error::Error;
use crate::measurement::{Measurand, Run};
use crate::metric::{Rest, rest};
use crate::observer::{
    BeltVelocity, Mode, PhaseMode, Settings, Smoothed, StickSlipSettings, Structure,
    smooth_stick_slip,
};

/// Estimates motion and phases of a run with the linear structure as known. `friction` is the expected coefficient (1) over the
/// relative speed in m/s, which sets the level of force and deflection where a velocity or an acceleration leaves it open
/// ([`settle`]).
///
/// # Errors
/// Sampling too slow for the modes and whatever else the smoother refuses.
pub fn smooth_run(
    run: &Run,
    structure: &Structure,
    friction: &dyn Fn(f64) -> f64,
) -> Result<Smoothing, Error> {
    let h = run.sample_interval();
    let mut signal = trusted_signal(run);
    let count = signal.len();
    let belt = run.inputs.belt_velocity.as_ref();
    let belt = belt.map(|series| sampled(series, run, h, count));
    let driven = driven_motion(structure, run, h, count);
    let driven = driven.map(|modal| {
        let seen = motion_of(structure, h, &modal, Mode::sensor_value);
        (
            motion_of(structure, h, &modal, |mode| mode.tip_value),
            seen,
            modal,
        )
    });
    let resting = rest_of(run, structure, &signal, belt.as_deref());
    // The structure is linear: what an external force does alone is taken off first, from the belt's velocity too, and put
    // on again.
    let mut relative_belt = belt.clone();
    if let Some(([_, of_tip, _], [displacement, velocity, acceleration], _)) = &driven {
        let less = |values: &mut [f64], part: &[f64]| {
            values.iter_mut().zip(part).for_each(|(v, p)| *v -= p);
        };
        less(
            &mut signal,
            match run.measurand {
                Measurand::Displacement => displacement,
                Measurand::Velocity => velocity,
                Measurand::Acceleration => acceleration,
            },
        );
        let belt = relative_belt.get_or_insert_with(|| vec![run.belt_velocity; count]);
        less(belt, of_tip);
    }
    let settings = StickSlipSettings {
        smoother: Settings {
            offset: resting.as_ref().map_or(0.0, |rest| rest.offset),
            ..smoother_settings(run)
        },
        known_stick: resting.map(|rest| rest.on),
        expected_force: expected_force(run, structure, friction),
        rounds: 2,
        iterations: 4,
        ..StickSlipSettings::default()
    };
    let stick_slip = smooth_stick_slip(
        structure,
        h,
        &signal,
        match &relative_belt {
            Some(belt) => BeltVelocity::Sampled(belt),
            None => BeltVelocity::Constant(run.belt_velocity),
        },
        &settings,
    )
    .map_err(|source| Error::Observer {
        run: run.name.clone(),
        source,
    })?;
    let starts: Vec<f64> = stick_slip
        .phases
        .windows(2)
        .filter(|w| w[0].mode == PhaseMode::Stick && w[1].mode != PhaseMode::Stick)
        .map(|w| w[1].start)
        .collect();
    let mut cycles: Vec<f64> = starts.windows(2).map(|w| w[1] - w[0]).collect();
    cycles.sort_by(f64::total_cmp);
    let cycle = cycles.get(cycles.len() / 2).copied().unwrap_or(f64::NAN);
    let mut smoothing = Smoothing {
        stick_slip,
        cycle,
        first_time: run.time[0],
        belt_path: BeltPath::of(run, h, belt.as_deref()),
    };
    settle(&mut smoothing, run, structure, friction);
    if let Some((tip, _, modal)) = &driven {
        add(&mut smoothing.stick_slip.smoothed, modal, tip);
    }
    Ok(smoothing)
}

/// What an acceleration leaves open of the force, in N: the friction expected at the speed of the belt, known to no better than
/// its size in a period of the lowest mode, and so in each sample of it less by the root of their number. `None` where something
/// else was measured, which tells the motion by itself, and where no spring would turn a force into a deflection.
fn expected_force(
    run: &Run,
    structure: &Structure,
    friction: &dyn Fn(f64) -> f64,
) -> Option<(f64, f64)> {
    if run.measurand != Measurand::Acceleration || structure.is_free() {
        return None;
    }
    let modes = structure.modes().iter();
    let lowest = modes.map(|m| m.frequency_hz).fold(f64::INFINITY, f64::min);
    let samples = (1.0 / (lowest * run.sample_interval())).max(1.0);
    let speed = run.belt_velocity;
    let force = speed.signum() * friction(speed.abs()) * run.normal_force;
    (force != 0.0 && force.is_finite()).then(|| (force, force.abs() * samples.sqrt()))
}

/// Stretches of a measured acceleration in which the tip rests on the belt, for a quarter of a period of the lowest mode or half a
/// period of the highest at least: a tip that does not stick turns within that. `None` where something else was measured, and where
/// no mode has a spring that would move it.
fn rest_of(run: &Run, structure: &Structure, signal: &[f64], belt: Option<&[f64]>) -> Option<Rest> {
    if run.measurand != Measurand::Acceleration || !structure.is_collocated() {
        return None;
    }
    let sprung = structure.modes().iter().filter(|mode| !mode.is_free());
    let frequencies = sprung.map(|mode| mode.frequency_hz);
    let (lowest, highest) = frequencies.fold((f64::INFINITY, 0.0), |(low, high), f| {
        (f.min(low), f.max(high))
    });
    let h = run.sample_interval();
    let shortest = (0.25 / lowest).min(0.5 / highest) / h;
    let mut against_belt = signal.to_vec();
    if let Some(belt) = belt {
        let of_belt = differences(belt, h);
        against_belt
            .iter_mut()
            .zip(of_belt)
            .for_each(|(a, b)| *a -= b);
    }
    lowest
        .is_finite()
        .then(|| rest(&against_belt, run.noise.std, shortest.round() as usize))?
}

/// Displacement, velocity and acceleration, the latter by differences, of where the modes have the values `shape`; from modal displacements
/// and velocities.
fn motion_of(
    structure: &Structure,
    h: f64,
    modal: &[Vec<Vec<f64>>; 2],
    shape: fn(&Mode) -> f64,
) -> [Vec<f64>; 3] {
    let there = |columns: &Vec<Vec<f64>>| -> Vec<f64> {
        let at = |k: usize| {
            let modes = structure.modes().iter().zip(columns);
            modes.map(|(mode, column)| shape(mode) * column[k]).sum()
        };
        (0..columns[0].len()).map(at).collect()
    };
    let (displacement, velocity) = (there(&modal[0]), there(&modal[1]));
    let acceleration = differences(&velocity, h);
    [displacement, velocity, acceleration]
}

/// Adds the motion that an external force makes to that of the friction force, which stays as it is.
fn add(smoothed: &mut Smoothed, modal: &[Vec<Vec<f64>>; 2], tip: &[Vec<f64>; 3]) {
    let sum = |to: &mut [f64], part: &[f64]| to.iter_mut().zip(part).for_each(|(a, b)| *a += b);
    for (to, part) in smoothed.q.iter_mut().zip(&modal[0]) {
        sum(to, part);
    }
    for (to, part) in smoothed.q_dot.iter_mut().zip(&modal[1]) {
        sum(to, part);
    }
    sum(&mut smoothed.displacement, &tip[0]);
    sum(&mut smoothed.velocity, &tip[1]);
    sum(&mut smoothed.acceleration, &tip[2]);
}
