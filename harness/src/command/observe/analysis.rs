//! From a run to its observation.

use super::friction::{friction, pole_speeds};
use super::observation::Observation;
use super::remarks::{faults, faulty, judge};
use super::{Arguments, Method};
use crate::measurement::{FaultKind, Measurand, Run};
use crate::metric::half_width;
use crate::observer::{
    NormalForce, ObserverError, Phase, PoleRule, SegmentSettings, Smoothed, StickSlip, Structure,
    TimeForm, UniformRecord, drift, estimate_frequencies, observe as place, segments, smooth,
    smooth_stick_slip,
};
use crate::smoothing::{Prepared, belt_in_stick, sampled};

/// Standard deviation of a pole-placed observer's velocity as share of the belt velocity, for finding stick.
const POLE_VELOCITY_STD: f64 = 0.03;
/// Misfit of the velocity in stick above which sticking is not rigid.
const STICK_MISFIT: f64 = 3.0;
/// Share of clipped samples from which on the force would be the model's and not the record's.
const MOSTLY: f64 = 0.5;

/// Whether the paper's observer, which is made for a displacement that friction alone moves, applies.
pub fn poles_apply(run: &Run, structure: &Structure) -> bool {
    run.measurand == Measurand::Displacement && !run.inputs.is_excited() && !structure.is_free()
}

/// Observes a run.
pub fn observe(
    run: &Run,
    mut structure: Structure,
    arguments: &Arguments,
    rule: &PoleRule,
    mut remarks: Vec<String>,
) -> Result<Observation, ObserverError> {
    require_range(run)?;
    let record = UniformRecord::of(&run.time, &run.measured, Some(&run.trusted()))?;
    remarks.extend(faults(run, &record));
    let y = &record.measured[..];
    let coefficient = arguments.friction_coefficient.unwrap_or(0.0);
    let expected = |_: f64| coefficient;
    if let Some(share) = arguments.estimate_frequencies {
        let even = (record.interval, y.to_vec());
        let prepared = Prepared::of(run, &structure, &expected, even, arguments.offset);
        structure = with_frequencies(&structure, &prepared, share, &mut remarks)?;
    }
    let even = (record.interval, y.to_vec());
    let prepared = Prepared::of(run, &structure, &expected, even, arguments.offset);
    let offset = prepared.settings().smoother.offset;
    let measured: Vec<f64> = y.iter().map(|y| y - offset).collect();
    let smoother = &prepared.settings().smoother;
    let plain = smooth(&structure, record.interval, prepared.signal(), smoother)?;
    let belt_in_stick = match run.sustains_itself() {
        true => belt_in_stick(&structure, &plain, (run.measurand, y), run.belt_velocity),
        false => None,
    };
    let (whiteness, noise_std) = (plain.whiteness.clone(), plain.noise_std);
    let found = match arguments.method {
        Method::Kalman => of_smoothed(plain, &prepared, None)?,
        Method::Pole => {
            let form = TimeForm::Discrete;
            let found = place(&structure, record.interval, &measured, rule, form)?;
            remarks.push(format!(
                "Poles at {}; the force is late by {:.2} ms and was moved earlier by that.",
                match rule {
                    PoleRule::Given(_) => "the places given".to_owned(),
                    _ => format!(
                        "{:.0} Hz and the transmission zeros",
                        found.poles[0].norm() / std::f64::consts::TAU
                    ),
                },
                1e3 * found.delay
            ));
            let placed = Smoothed {
                force: found.force_without_delay(record.interval),
                force_std: vec![f64::NAN; y.len()],
                displacement: found.displacement,
                velocity: found.velocity,
                ..plain
            };
            of_smoothed(
                placed,
                &prepared,
                Some(POLE_VELOCITY_STD * run.belt_velocity.abs()),
            )?
        }
        Method::StickSlip => {
            let (signal, belt) = (prepared.signal(), prepared.belt());
            let interval = record.interval;
            let found = smooth_stick_slip(&structure, interval, signal, belt, prepared.settings())?;
            if found.stick_misfit > STICK_MISFIT {
                remarks.push(format!(
                    "In stick the tip does not follow the belt within the noise (misfit {:.1}): the contact may be compliant or the \
                     belt's speed may give way; prefer --method kalman.",
                    found.stick_misfit
                ));
            }
            found
        }
    };
    let mut found = prepared.complete(found).stick_slip;
    let is_velocity = run.measurand == Measurand::Velocity;
    if is_velocity && arguments.friction_coefficient.is_some() {
        beside_the_level(&mut found.smoothed.force_std);
    }
    let is_displacement = run.measurand == Measurand::Displacement;
    let shifted = |p: &Phase| Phase {
        start: p.start + record.start,
        end: p.end + record.start,
        ..p.clone()
    };
    let mut out = Observation {
        name: run.name.clone(),
        method: arguments.method,
        belt_velocity: run.belt_velocity,
        normal_force: run.normal_force,
        measurand: run.measurand,
        stated_coefficient: arguments.friction_coefficient,
        time: record.time(),
        measured,
        force: found.smoothed.force.clone(),
        force_std: found.smoothed.force_std.clone(),
        displacement: found.smoothed.displacement.clone(),
        velocity: found.smoothed.velocity.clone(),
        acceleration: found.smoothed.acceleration.clone(),
        relative_velocity: found.relative_velocity.clone(),
        phases: found.phases.iter().map(shifted).collect(),
        bins: Vec::new(),
        curve: None,
        curve_trusted: false,
        characteristic: Vec::new(),
        laws: Vec::new(),
        dwell: None,
        whiteness,
        noise_std,
        drift: (is_displacement && run.sustains_itself())
            .then(|| drift(y, record.interval))
            .flatten(),
        offset: None,
        pole_speeds: Vec::new(),
        belt_in_stick,
        remarks,
        structure: structure.clone(),
    };
    let load = run.inputs.normal_force.as_ref();
    let load = load.map(|series| sampled(series, run, record.interval, y.len()));
    let load = match &load {
        Some(load) => NormalForce::Sampled(load),
        None => NormalForce::Constant(run.normal_force),
    };
    let shot = poles_apply(run, &structure) && arguments.method == Method::StickSlip;
    let shot = shot.then(|| (&found, y, prepared.belt()));
    friction(&mut out, shot, load);
    if poles_apply(run, &structure) {
        out.pole_speeds = pole_speeds(&out, record.interval);
    }
    judge(&mut out, &record);
    Ok(out)
}

/// Refuses a record that is saturated for the most part.
fn require_range(run: &Run) -> Result<(), ObserverError> {
    let clipped = faulty(run, FaultKind::Clipped);
    if clipped as f64 <= MOSTLY * run.time.len() as f64 {
        return Ok(());
    }
    let measured = || run.measured.iter().copied();
    Err(ObserverError::Saturated {
        clipped,
        count: run.time.len(),
        low: measured().fold(f64::INFINITY, f64::min),
        high: measured().fold(f64::NEG_INFINITY, f64::max),
        unit: run.measurand.unit(),
    })
}

/// The structure with natural frequencies within `share` of those given that explain the record best, and remarks on them.
fn with_frequencies(
    structure: &Structure,
    prepared: &Prepared,
    share: f64,
    remarks: &mut Vec<String>,
) -> Result<Structure, ObserverError> {
    let (interval, y) = (prepared.interval(), prepared.signal());
    let (belt, settings) = (prepared.belt(), prepared.settings());
    let found = estimate_frequencies(structure, interval, y, belt, settings, share)?;
    for (j, mode) in found.modes.iter().enumerate() {
        let kept = if mode.determined {
            "used"
        } else {
            "not determined by this record, kept as given"
        };
        remarks.push(format!(
            "Mode {}: {:.3} Hz given, {:.3} ± {:.3} Hz (95 %) found; {kept}.",
            j + 1,
            mode.given_hz,
            mode.found_hz,
            half_width(mode.std_hz)
        ));
    }
    Ok(found.structure)
}

/// Takes off the variance that all samples have in common: that of a level which a velocity leaves open, and which
/// is stated. Beside it an acceleration leaves the slow changes open too, so that its deviations count as they are.
///
/// ```text
/// s_k^2 -> s_k^2 - min_i s_i^2
/// ```
///
/// What the best known sample has of its own is taken off with it, a few percent of the others'.
fn beside_the_level(force_std: &mut [f64]) {
    let common = force_std.iter().copied().fold(f64::INFINITY, f64::min);
    force_std
        .iter_mut()
        .for_each(|std| *std = (*std * *std - common * common).sqrt());
}

/// Phases of a motion that was estimated without them; `velocity_std` in m/s where it is not the motion's own.
fn of_smoothed(
    smoothed: Smoothed,
    prepared: &Prepared,
    velocity_std: Option<f64>,
) -> Result<StickSlip, ObserverError> {
    let count = smoothed.velocity.len();
    let belt = prepared.belt();
    let relative: Vec<f64> = (0..count)
        .map(|k| smoothed.velocity[k] - belt.at(k))
        .collect();
    let time: Vec<f64> = (0..count).map(|k| k as f64 * prepared.interval()).collect();
    let std = match velocity_std {
        Some(std) => &vec![std; count],
        None => &smoothed.velocity_std,
    };
    let phases = segments(&time, &relative, std, &SegmentSettings::default())?;
    Ok(StickSlip {
        smoothed,
        relative_velocity: relative,
        phases,
        stick_misfit: 0.0,
    })
}
