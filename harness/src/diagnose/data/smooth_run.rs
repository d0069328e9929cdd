//! Motion, phases and friction force of a run by the smoother, what an external force does alone taken off first.

use crate::diagnose::data::driven_motion::{BeltPath, driven_motion, sampled};
use crate::diagnose::data::smoothing::{Smoothing, smoother_settings, trusted_signal};
use crate::diagnose::data::velocity_level::settle;
use crate::error::Error;
use crate::measurement::{Measurand, Run};
use crate::observer::{
    BeltVelocity, PhaseMode, Smoothed, StickSlipSettings, Structure, smooth_stick_slip,
};

/// Estimates motion and phases of a run with the linear structure as known. `friction` is the expected coefficient (1) over the
/// relative speed in m/s, which sets the level of force and deflection where a velocity leaves it open ([`settle`]).
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
    let driven = driven_motion(structure, run, h, count).map(|modal| tip_motion(structure, modal));
    // The structure is linear: what an external force does alone is taken off first, from the belt's velocity too, and put
    // on again.
    let mut relative_belt = belt.clone();
    if let Some((_, [displacement, velocity])) = &driven {
        let less = |values: &mut [f64], part: &[f64]| {
            values.iter_mut().zip(part).for_each(|(v, p)| *v -= p);
        };
        less(
            &mut signal,
            match run.measurand {
                Measurand::Displacement => displacement,
                Measurand::Velocity => velocity,
            },
        );
        let belt = relative_belt.get_or_insert_with(|| vec![run.belt_velocity; count]);
        less(belt, velocity);
    }
    let settings = StickSlipSettings {
        smoother: smoother_settings(run),
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
    if let Some((modal, tip)) = &driven {
        add(&mut smoothing.stick_slip.smoothed, modal, tip);
    }
    Ok(smoothing)
}

/// Modal displacements and velocities, and those of the tip.
type DrivenPart = ([Vec<Vec<f64>>; 2], [Vec<f64>; 2]);

fn tip_motion(structure: &Structure, modal: [Vec<Vec<f64>>; 2]) -> DrivenPart {
    let tip = |columns: &Vec<Vec<f64>>| {
        let at = |k: usize| {
            let modes = structure.modes().iter().zip(columns);
            modes.map(|(mode, column)| mode.tip_value * column[k]).sum()
        };
        (0..columns[0].len()).map(at).collect()
    };
    let of_tip = [tip(&modal[0]), tip(&modal[1])];
    (modal, of_tip)
}

/// Adds the motion that an external force makes to that of the friction force. The friction force stays as it is, and the
/// acceleration of the tip becomes that of the sum by differences.
fn add(smoothed: &mut Smoothed, modal: &[Vec<Vec<f64>>; 2], tip: &[Vec<f64>; 2]) {
    let sum = |to: &mut [f64], part: &[f64]| to.iter_mut().zip(part).for_each(|(a, b)| *a += b);
    for (to, part) in smoothed.q.iter_mut().zip(&modal[0]) {
        sum(to, part);
    }
    for (to, part) in smoothed.q_dot.iter_mut().zip(&modal[1]) {
        sum(to, part);
    }
    sum(&mut smoothed.displacement, &tip[0]);
    sum(&mut smoothed.velocity, &tip[1]);
    let (velocity, h) = (&tip[1], smoothed.sample_interval);
    let last = velocity.len() - 1;
    let slope = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
        (velocity[b] - velocity[a]) / (h * (b - a).max(1) as f64)
    };
    let acceleration: Vec<f64> = (0..=last).map(slope).collect();
    sum(&mut smoothed.acceleration, &acceleration);
}
