//! Constants of the beam and of its friction law, which every hypothesis on this project's FMU calibrates.

use crate::diagnose::model::friction_prior::FrictionPrior;
use crate::diagnose::model::parameter::{Kind, Parameter, Scale};
use crate::diagnose::model::scales::Scales;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::{Campaign, Uncertainty};
use crate::observer::Structure;

/// Bounds of a natural frequency, of a damping ratio or rate that is stated, and of a modal mass, as a factor from its value: far
/// beyond what a stated value is off by.
const FREQUENCY_FACTOR: f64 = 1.06;
const DAMPING_FACTOR: f64 = 30.0;
const MASS_FACTOR: f64 = 1.5;
/// The same of a damping rate that nobody states, which is known to a decade.
const UNKNOWN_RATE_FACTOR: f64 = 1e3;

/// FMU variables by value reference, with values that stay.
type Fixed = Vec<(u32, f64)>;

/// Constants of the modes: those that are calibrated, and those that stay.
///
/// # Errors
/// An FMU without the parameters of a mode.
pub fn of_structure(
    fmu: &Fmu,
    campaign: &Campaign,
    structure: &Structure,
    scales: Scales,
) -> Result<(Vec<Parameter>, Fixed), Error> {
    let reference = |name: &str| fmu.variable(name).map(|v| v.reference);
    let known = &campaign.uncertainty;
    let (mut shared, mut fixed) = (Vec::new(), Vec::new());
    for (j, mode) in structure.modes().iter().enumerate() {
        let at = |item: &str| format!("mode[{}].{item}", j + 1);
        let mut calibrated = |item: &str, unit: &str, belief: (f64, f64), factor: f64| {
            let name = at(item);
            let target = reference(&name)?;
            shared.push(Parameter::positive(name, unit, target, belief, factor));
            Ok::<(), Error>(())
        };
        let rate = fmu.variable(&at("damping_rate"));
        let stated_rate = campaign.beam.damping_rates_per_s.get(j).copied();
        match (rate, stated_rate) {
            (Ok(_), Some(value)) if mode.is_free() && value > 0.0 => {
                let belief = (value, known.damping_rate(j));
                calibrated("damping_rate", "1/s", belief, DAMPING_FACTOR)?;
            }
            // Where nothing is known of a guide, the rate at which the mass runs through its range, to a decade.
            (Ok(rate), None) if mode.is_free() => {
                let start = rate.start_number().filter(|start| *start > 0.0);
                let value = start.unwrap_or(scales.velocity / scales.length);
                let belief = (value, std::f64::consts::LN_10);
                calibrated("damping_rate", "1/s", belief, UNKNOWN_RATE_FACTOR)?;
            }
            (Ok(rate), Some(value)) => fixed.push((rate.reference, value)),
            // It would be left out of every motion without a word.
            (Err(missing), Some(value)) if value != 0.0 => return Err(missing),
            _ => {}
        }
        if mode.is_free() {
            fixed.push((reference(&at("frequency"))?, 0.0));
            fixed.push((reference(&at("damping_ratio"))?, 0.0));
        } else {
            let belief = (mode.frequency_hz, known.frequency(j));
            calibrated("frequency", "Hz", belief, FREQUENCY_FACTOR)?;
            let belief = (mode.damping_ratio.max(1e-6), known.damping_ratio(j));
            calibrated("damping_ratio", "1", belief, DAMPING_FACTOR)?;
        }
        fixed.push((reference(&at("tip_value"))?, mode.tip_value));
        let belief = (mode.mass_kg, known.participation(j));
        calibrated("mass", "kg", belief, MASS_FACTOR)?;
    }
    Ok((shared, fixed))
}

/// Constants of the friction law.
///
/// # Errors
/// An FMU without them.
pub fn of_friction(fmu: &Fmu, friction: &FrictionPrior) -> Result<Vec<Parameter>, Error> {
    let reference = |name: &str| fmu.variable(name).map(|v| v.reference);
    let mut out = Vec::new();
    for (item, unit, belief, factor) in [
        ("mu_0", "1", friction.mu_0, 3.0),
        ("v1", "m/s", friction.v1, 5.0),
        ("c2", "s/m", friction.c2, 6.0),
        ("a2", "1", friction.a2, 3.0),
    ] {
        let name = format!("friction.{item}");
        let target = reference(&name)?;
        out.push(Parameter::positive(name, unit, target, belief, factor));
    }
    out.push(Parameter {
        name: "friction.a1".into(),
        unit: "1".into(),
        kind: Kind::Reference,
        targets: vec![(reference("friction.a1")?, 1.0)],
        scale: Scale::Linear,
        prior: friction.a1.0,
        prior_std: friction.a1.1,
        min: 0.0,
        max: 0.95,
        step: 0.002,
        support: None,
    });
    Ok(out)
}

/// The friction level of each run.
///
/// # Errors
/// An FMU without it.
pub fn levels(
    fmu: &Fmu,
    friction: &FrictionPrior,
    known: &Uncertainty,
) -> Result<Vec<Vec<Parameter>>, Error> {
    let name = "friction.level";
    let target = fmu.variable(name)?.reference;
    let level = |belief: &(f64, f64)| {
        // Only the product of a run's level and its normal force acts.
        let std = belief.1.hypot(known.normal_force_run_std);
        let level = Parameter::positive(name.to_owned(), "1", target, (belief.0, std), 4.0);
        let kind = Kind::Level;
        vec![Parameter { kind, ..level }]
    };
    Ok(friction.levels.iter().map(level).collect())
}
