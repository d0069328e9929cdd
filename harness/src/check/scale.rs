//! Units, quantities and signs that can't be meant, by stick speed, static balance and frequency.
//!
//! Each possible mistake is a hypothesis: what it makes of the data must be plausible in all three,
//! else it is not named.

use super::examined::Examined;
use super::finding::{Finding, Severity, digits};
use super::thresholds::{
    FACTOR_FITS, FREQUENCIES, LEAST_FRICTION, LEAST_RANGE, REST_SHARE, SPEED_FACTOR, SPEED_OFF,
    SPEEDS,
};
use crate::measurement::Measurand;

/// Factors that turn a column into SI if it is in another unit: of what was measured, of time, of
/// the belt's speed, of the force.
#[derive(Debug, Clone, Copy)]
struct Factors {
    measured: f64,
    time: f64,
    belt: f64,
    force: f64,
}

const NONE: Factors = Factors {
    measured: 1.0,
    time: 1.0,
    belt: 1.0,
    force: 1.0,
};

const fn measured_in(factor: f64) -> Factors {
    Factors {
        measured: factor,
        ..NONE
    }
}

const fn time(factor: f64) -> Factors {
    Factors {
        time: factor,
        ..NONE
    }
}

/// The mistakes that are made with displacements, the more frequent ones first; single ones before
/// two at once.
const MISTAKES: [(&str, Factors, &str); 15] = [
    ("time_in_ms", time(1e-3), "times are in ms"),
    (
        "displacement_in_mm",
        measured_in(1e-3),
        "the displacement is in mm",
    ),
    (
        "displacement_in_um",
        measured_in(1e-6),
        "the displacement is in um",
    ),
    ("time_in_us", time(1e-6), "times are in us"),
    (
        "displacement_in_cm",
        measured_in(1e-2),
        "the displacement is in cm",
    ),
    (
        "displacement_in_inch",
        measured_in(0.0254),
        "the displacement is in inches",
    ),
    (
        "force_in_kn",
        Factors { force: 1e3, ..NONE },
        "the normal force is in kN",
    ),
    (
        "belt_velocity_in_mm_per_s",
        Factors { belt: 1e-3, ..NONE },
        "the belt velocity is in mm/s",
    ),
    (
        "belt_velocity_in_m_per_min",
        Factors {
            belt: 1.0 / 60.0,
            ..NONE
        },
        "the belt velocity is in m/min",
    ),
    (
        "belt_velocity_in_km_per_s",
        Factors { belt: 1e3, ..NONE },
        "the belt velocity is a thousandth of what it is",
    ),
    (
        "force_in_mn",
        Factors {
            force: 1e-3,
            ..NONE
        },
        "the normal force is in mN",
    ),
    (
        "displacement_scaled_twice",
        measured_in(1e3),
        "the displacement is scaled from mm to m twice",
    ),
    (
        "displacement_scaled_twice",
        measured_in(1e6),
        "the displacement is scaled from um to m twice",
    ),
    (
        "time_in_ms_displacement_in_mm",
        Factors {
            measured: 1e-3,
            time: 1e-3,
            ..NONE
        },
        "times are in ms and the displacement is in mm",
    ),
    (
        "time_in_ms_displacement_in_um",
        Factors {
            measured: 1e-6,
            time: 1e-3,
            ..NONE
        },
        "times are in ms and the displacement is in um",
    ),
];

/// The mistakes that are made with velocities.
const MISTAKES_WITH_VELOCITIES: [(&str, Factors, &str); 5] = [
    (
        "velocity_in_mm_per_s",
        measured_in(1e-3),
        "the velocity is in mm/s",
    ),
    (
        "velocity_in_um_per_s",
        measured_in(1e-6),
        "the velocity is in um/s",
    ),
    (
        "velocity_in_cm_per_s",
        measured_in(1e-2),
        "the velocity is in cm/s",
    ),
    (
        "velocity_in_inch_per_s",
        measured_in(0.0254),
        "the velocity is in inches per second",
    ),
    (
        "velocity_scaled_twice",
        measured_in(1e3),
        "the velocity is scaled from mm/s to m/s twice",
    ),
];

/// The mistakes that are made with accelerations; accelerometers are calibrated in g as often as in m/s2.
const MISTAKES_WITH_ACCELERATIONS: [(&str, Factors, &str); 4] = [
    (
        "acceleration_in_g",
        measured_in(9.806_65),
        "the acceleration is in g",
    ),
    (
        "acceleration_in_mm_per_s2",
        measured_in(1e-3),
        "the acceleration is in mm/s^2",
    ),
    (
        "acceleration_scaled_twice",
        measured_in(1e3),
        "the acceleration is scaled from mm/s^2 to m/s^2 twice",
    ),
    (
        "acceleration_scaled_twice",
        measured_in(1.0 / 9.806_65),
        "the acceleration is scaled from g to m/s^2 twice",
    ),
];

/// The mistakes that may have been made in a run.
fn mistakes(run: &Examined) -> Vec<(&'static str, Factors, &'static str)> {
    let others = MISTAKES.into_iter().filter(|m| m.1.measured == 1.0);
    match run.run.measurand {
        Measurand::Displacement => MISTAKES.to_vec(),
        Measurand::Velocity => MISTAKES_WITH_VELOCITIES.into_iter().chain(others).collect(),
        Measurand::Acceleration => MISTAKES_WITH_ACCELERATIONS
            .into_iter()
            .chain(others)
            .collect(),
    }
}

impl Factors {
    /// Whether everything measured is plausible once these factors are applied; a sign is not
    /// looked at.
    fn explain(&self, run: &Examined) -> bool {
        let (of_speed, of_range) = match run.run.measurand {
            Measurand::Displacement => (self.measured / self.time, self.measured),
            Measurand::Velocity => (self.measured, self.measured * self.time),
            Measurand::Acceleration => {
                let speed = self.measured * self.time;
                (speed, speed * self.time)
            }
        };
        let speed = of_speed / self.belt;
        let by_stick = run
            .speed_ratio()
            .map(|ratio| (ratio.abs() * speed - 1.0).abs() < FACTOR_FITS);
        let by_fastest = || {
            let ratio = speed * run.motion.fastest / run.run.belt_velocity.abs();
            !ratio.is_finite() || SPEEDS.contains(&ratio)
        };
        let range = run.range_ratio().is_none_or(|ratio| {
            let by_speed = run.range_by_speed().unwrap_or(0.0) * self.belt / self.force;
            let ratio = ratio * of_range / self.force;
            (LEAST_RANGE..LEAST_FRICTION + by_speed).contains(&ratio)
        });
        let frequency = run
            .frequency_ratio()
            .is_none_or(|ratio| FREQUENCIES.contains(&(ratio / self.time)));
        by_stick.unwrap_or_else(by_fastest) && range && frequency
    }

    fn remedy(&self, run: &Examined, what: &str) -> String {
        let mut to_do = Vec::new();
        let keys = [
            (run.run.measurand.scale_key(), self.measured),
            ("time_scale", self.time),
        ];
        for (key, factor) in keys {
            if factor != 1.0 {
                to_do.push(format!("multiply {key} (1 unless stated) by {factor}"));
            }
        }
        let values = [
            ("belt_velocity_m_per_s", self.belt, run.run.belt_velocity),
            ("normal_force_n", self.force, run.run.normal_force),
        ];
        for (key, factor, _) in values {
            if factor != 1.0 {
                to_do.push(format!("multiply {key} by {}", digits(factor)));
            }
        }
        format!(
            "it seems that {what}: {} in campaign.toml",
            to_do.join(" and ")
        )
    }
}

/// Whether the stick speed can't be that of the stated belt.
pub fn speed_contradicted(run: &Examined) -> bool {
    run.speed_ratio()
        .is_some_and(|a| a < 0.0 || !(1.0 / SPEED_FACTOR..=SPEED_FACTOR).contains(&a))
}

/// The finding on a run's scales and signs, if they can't be meant.
pub fn scale(run: &Examined) -> Option<Finding> {
    if run.motion.range == 0.0 || !run.run.sustains_itself() {
        return None;
    }
    let speed = run.speed_ratio();
    let contradicted = speed_contradicted(run);
    let (range, by_speed) = (run.range_ratio(), run.range_by_speed());
    let too_far = range.is_some_and(|r| r > LEAST_FRICTION + by_speed.unwrap_or(0.0));
    let too_fast = run.run.belt_velocity != 0.0
        && run.motion.fastest / run.run.belt_velocity.abs() > SPEEDS.end;
    let stick_off = speed.is_some_and(|a| (a - 1.0).abs() > SPEED_OFF);
    let error = |id, remedy: String| {
        Some(Finding::of(
            Severity::Error,
            id,
            &run.run.name,
            (measured(run), stated(run), remedy),
        ))
    };
    // What is no velocity need not contradict the belt's: displacements in m are small numbers.
    let mistaken = run.run.measurand != Measurand::Displacement && other_quantity(run).is_some();
    if !(contradicted || too_far || too_fast || mistaken) {
        return (stick_off && !too_far).then(|| {
            let remedy = "measure the belt's speed again; diagnose calibrates a common factor, not each run's own".to_owned();
            Finding::of(
                Severity::Warning,
                "belt_velocity_off",
                &run.run.name,
                (measured(run), stated(run), remedy),
            )
        });
    }
    if (contradicted || speed.is_none() || mistaken)
        && let Some((id, what)) = other_quantity(run)
    {
        let remedy = format!(
            "it seems that {what} was measured: {}",
            other_remedy(run.run.measurand, id)
        );
        return error(id, remedy);
    }
    let reversed = speed.is_some_and(|a| a < 0.0);
    let scale_key = run.run.measurand.scale_key();
    let of_sign = format!(
        "the tip sticks to a belt that runs the other way: change the sign of belt_velocity_m_per_s, or of {scale_key} if the sensor looks from the other side"
    );
    if reversed && NONE.explain(run) {
        return error("sign", of_sign);
    }
    let mut mistakes = mistakes(run).into_iter();
    match mistakes.find(|(_, factors, _)| factors.explain(run)) {
        Some((id, factors, what)) => {
            let sign = if reversed {
                "; and the sign is reversed"
            } else {
                ""
            };
            error(id, factors.remedy(run, what) + sign)
        }
        None if contradicted => error(
            "stick_speed",
            format!(
                "no usual unit explains it: check belt_velocity_m_per_s, time_scale, {scale_key} and which file belongs to this run"
            ),
        ),
        None if too_fast => error(
            "speed",
            format!(
                "no usual unit explains it: check time_scale, {scale_key} and belt_velocity_m_per_s"
            ),
        ),
        None => error(
            "deflection",
            format!(
                "no usual unit explains it: check normal_force_n, {scale_key} and [beam] (frequencies, masses, tip values)"
            ),
        ),
    }
}

/// Gives runs without stick the error that most runs have: they tell less, and runs of one campaign
/// are written alike.
pub fn share(runs: &[Examined], findings: &mut [Option<Finding>]) {
    let is_error = |finding: &&Finding| finding.severity == Severity::Error;
    let errors: Vec<&Finding> = findings.iter().flatten().filter(is_error).collect();
    let count = |id: &str| errors.iter().filter(|finding| finding.id == id).count();
    let Some(common) = errors.iter().max_by_key(|finding| count(finding.id)) else {
        return;
    };
    if 2 * count(common.id) <= runs.len() {
        return;
    }
    let common = (*common).clone();
    for (run, finding) in runs.iter().zip(findings) {
        let differs = finding.as_ref().is_none_or(|own| own.id != common.id);
        let tells_little = run.motion.stick_speed.is_none() && run.run.sustains_itself();
        if tells_little && run.motion.range > 0.0 && differs {
            *finding = Some(Finding {
                runs: vec![run.run.name.clone()],
                ..common.clone()
            });
        }
    }
}

/// What to do where something else was measured than is stated.
fn other_remedy(stated: Measurand, found: &str) -> &'static str {
    match (stated, found) {
        (Measurand::Displacement, "velocity") => {
            "name its column with velocity_column in place of displacement_column, or name the column of the displacement"
        }
        (Measurand::Displacement, _) => {
            "name its column with acceleration_column in place of displacement_column, or name the column of the displacement"
        }
        (Measurand::Velocity, "displacement") => {
            "name its column with displacement_column in place of velocity_column, or name the column of the velocity"
        }
        (Measurand::Velocity, _) => {
            "name its column with acceleration_column in place of velocity_column, or name the column of the velocity"
        }
        (Measurand::Acceleration, "displacement") => {
            "name its column with displacement_column in place of acceleration_column, or name the column of the acceleration"
        }
        (Measurand::Acceleration, _) => {
            "name its column with velocity_column in place of acceleration_column, or name the column of the acceleration"
        }
    }
}

/// Standard deviations of the noise beyond which a value is told from zero.
const TOLD: f64 = 4.0;

/// Another quantity in place of the one stated: the signal itself, its integral or its derivative rests at the belt's speed.
fn other_quantity(run: &Examined) -> Option<(&'static str, &'static str)> {
    let belt = run.run.belt_velocity;
    let fits = |value: f64| (value / belt - 1.0).abs() < FACTOR_FITS;
    let stated = run.run.measurand;
    if stated != Measurand::Displacement && run.motion.derivative_rest.is_some_and(fits) {
        return Some(("displacement", "a displacement"));
    }
    let (rest, share) = run.motion.rest?;
    if share < REST_SHARE {
        return None;
    }
    // The offset of an accelerometer lies within its noise, and a velocity is told from zero by far.
    let is_told = stated != Measurand::Acceleration || rest.abs() > TOLD * run.run.noise.std;
    if stated != Measurand::Velocity && is_told && fits(rest) {
        return Some(("velocity", "a velocity"));
    }
    if stated == Measurand::Acceleration {
        return None;
    }
    let at_zero = rest.abs() < 0.1 * run.motion.std;
    (at_zero && run.motion.integral_rest.is_some_and(fits))
        .then_some(("acceleration", "an acceleration"))
}

fn measured(run: &Examined) -> String {
    let motion = &run.motion;
    let mut parts = Vec::new();
    match motion.stick_speed {
        Some(speed) => parts.push(format!(
            "the tip moves at {} m/s in stick ({:.0} % of the time)",
            digits(speed),
            100.0 * motion.stick_share
        )),
        None => parts.push(format!(
            "the tip moves at up to {} m/s, no stick is seen",
            digits(motion.fastest)
        )),
    }
    match run.stiffness {
        Some(stiffness) => parts.push(format!(
            "over {} m, which takes {} N",
            digits(motion.range),
            digits(stiffness * motion.range)
        )),
        None => parts.push(format!("over {} m", digits(motion.range))),
    }
    parts.join(", ")
}

fn stated(run: &Examined) -> String {
    format!(
        "belt_velocity_m_per_s = {}, normal_force_n = {}",
        run.run.belt_velocity, run.run.normal_force
    )
}
