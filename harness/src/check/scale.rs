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

/// Factors that turn a column into SI if it is in another unit: of displacement, of time, of the
/// belt's speed, of the force.
#[derive(Debug, Clone, Copy)]
struct Factors {
    displacement: f64,
    time: f64,
    belt: f64,
    force: f64,
}

const NONE: Factors = Factors {
    displacement: 1.0,
    time: 1.0,
    belt: 1.0,
    force: 1.0,
};

const fn displacement(factor: f64) -> Factors {
    Factors {
        displacement: factor,
        ..NONE
    }
}

const fn time(factor: f64) -> Factors {
    Factors {
        time: factor,
        ..NONE
    }
}

/// The mistakes that are made, the more frequent ones first; single ones before two at once.
const MISTAKES: [(&str, Factors, &str); 15] = [
    ("time_in_ms", time(1e-3), "times are in ms"),
    (
        "displacement_in_mm",
        displacement(1e-3),
        "the displacement is in mm",
    ),
    (
        "displacement_in_um",
        displacement(1e-6),
        "the displacement is in um",
    ),
    ("time_in_us", time(1e-6), "times are in us"),
    (
        "displacement_in_cm",
        displacement(1e-2),
        "the displacement is in cm",
    ),
    (
        "displacement_in_inch",
        displacement(0.0254),
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
        displacement(1e3),
        "the displacement is scaled from mm to m twice",
    ),
    (
        "displacement_scaled_twice",
        displacement(1e6),
        "the displacement is scaled from um to m twice",
    ),
    (
        "time_in_ms_displacement_in_mm",
        Factors {
            displacement: 1e-3,
            time: 1e-3,
            ..NONE
        },
        "times are in ms and the displacement is in mm",
    ),
    (
        "time_in_ms_displacement_in_um",
        Factors {
            displacement: 1e-6,
            time: 1e-3,
            ..NONE
        },
        "times are in ms and the displacement is in um",
    ),
];

impl Factors {
    /// Whether everything measured is plausible once these factors are applied; a sign is not
    /// looked at.
    fn explain(&self, run: &Examined) -> bool {
        let speed = self.displacement / self.time / self.belt;
        let by_stick = run
            .speed_ratio()
            .map(|ratio| (ratio.abs() * speed - 1.0).abs() < FACTOR_FITS);
        let by_fastest = || {
            let ratio = speed * run.motion.fastest / run.run.belt_velocity.abs();
            !ratio.is_finite() || SPEEDS.contains(&ratio)
        };
        let range = run.range_ratio().is_none_or(|ratio| {
            let by_speed = run.range_by_speed().unwrap_or(0.0) * self.belt / self.force;
            let ratio = ratio * self.displacement / self.force;
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
            ("displacement_scale", self.displacement),
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
    if !(contradicted || too_far || too_fast) {
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
    if (contradicted || speed.is_none())
        && let Some((id, what)) = other_quantity(run)
    {
        let remedy = format!(
            "it seems that {what} was measured: integrate it to a displacement in m, or name the column of the displacement with displacement_column"
        );
        return error(id, remedy);
    }
    let reversed = speed.is_some_and(|a| a < 0.0);
    let of_sign = "the tip sticks to a belt that runs the other way: change the sign of belt_velocity_m_per_s, or of displacement_scale if the sensor looks from the other side";
    if reversed && NONE.explain(run) {
        return error("sign", of_sign.to_owned());
    }
    match MISTAKES.iter().find(|(_, factors, _)| factors.explain(run)) {
        Some((id, factors, what)) => {
            let sign = if reversed { "; and the sign is reversed" } else { "" };
            error(id, factors.remedy(run, what) + sign)
        }
        None if contradicted => error(
            "stick_speed",
            "no usual unit explains it: check belt_velocity_m_per_s, time_scale, displacement_scale and which file belongs to this run".to_owned(),
        ),
        None if too_fast => error(
            "speed",
            "no usual unit explains it: check time_scale, displacement_scale and belt_velocity_m_per_s".to_owned(),
        ),
        None => error(
            "deflection",
            "no usual unit explains it: check normal_force_n, displacement_scale and [beam] (frequencies, masses, tip values)".to_owned(),
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

/// Velocity or acceleration in place of the displacement: the signal itself, or its integral, rests
/// at the belt's speed.
fn other_quantity(run: &Examined) -> Option<(&'static str, &'static str)> {
    let belt = run.run.belt_velocity;
    let fits = |value: f64| (value / belt - 1.0).abs() < FACTOR_FITS;
    let (rest, share) = run.motion.rest?;
    if share < REST_SHARE {
        return None;
    }
    if fits(rest) {
        return Some(("velocity", "a velocity"));
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
