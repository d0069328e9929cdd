//! force.csv, friction.csv and the JSON summary.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::Observation;
use crate::measurement::NoiseStd;
use crate::observer::{FrictionLaw, LawFit};
use crate::provenance::Provenance;

/// One line per sample; empty where a value is not known.
pub fn force(o: &Observation) -> String {
    let mut csv = String::from(
        "time_s,force_n,force_std_n,displacement_m,velocity_m_per_s,relative_velocity_m_per_s,mode\n",
    );
    let modes = o.modes();
    for k in 0..o.time.len() {
        let std = Some(o.force_std[k]).filter(|s| s.is_finite());
        let std = std.map_or(String::new(), |s| format!("{s:.4e}"));
        let _ = writeln!(
            csv,
            "{:.7},{:.6e},{std},{:.8e},{:.6e},{:.6e},{}",
            o.time[k],
            o.force[k],
            o.displacement[k],
            o.velocity[k],
            o.relative_velocity[k],
            modes[k]
        );
    }
    csv
}

/// One line per point of the characteristic.
pub fn friction(o: &Observation) -> String {
    let mut csv = String::from("relative_velocity_m_per_s,mu,mu_std,count\n");
    for point in &o.characteristic {
        let _ = writeln!(
            csv,
            "{:.6e},{:.6e},{:.6e},{}",
            point.relative_velocity, point.mu, point.mu_std, point.count
        );
    }
    csv
}

/// Start values that give the model the measured characteristic as a table: one NAME=VALUE per line, for `simulate --set @FILE`.
pub fn table(o: &Observation) -> Option<String> {
    let table = o
        .laws
        .iter()
        .find(|l| matches!(l.law, FrictionLaw::Table { .. }))?;
    let mut text = format!("# friction of {} as a table\n", o.name);
    for (name, value) in table.law.start_values() {
        let _ = writeln!(text, "{name}={value}");
    }
    Some(text)
}

/// The results without the columns.
pub fn json(o: &Observation, provenance: &Provenance) -> String {
    let estimate = |e: Option<crate::observer::Estimate>| {
        e.map_or(Value::Null, |e| json!({ "value": e.value, "std": e.std }))
    };
    let mut value = json!({
        "run": o.name,
        "method": o.method.name(),
        "belt_velocity_m_per_s": o.belt_velocity,
        "normal_force_n": o.normal_force,
        "natural_frequencies_hz": o.structure.modes().iter().map(|m| m.frequency_hz).collect::<Vec<_>>(),
        "measured_quantity": o.measurand.name(),
        "stated_friction_coefficient": o.stated_coefficient,
        "stick_fraction": o.stick_fraction(),
        "complete_stick_phases": o.sticks(),
        "innovation": {
            "largest_autocorrelation": o.whiteness.largest_autocorrelation(),
            "ljung_box": o.whiteness.ljung_box,
            "p_value": o.whiteness.p_value,
            "peak_frequency_hz": o.whiteness.peak_frequency_hz,
            "acceptable": o.whiteness.acceptable(),
        },
        "break_away": o.dwell.as_ref().map(|d| json!({
            "mu_mean": d.mu_mean, "mu_std": d.mu_std, "events": d.events.len(),
            "slope_per_ln_dwell": d.slope, "slope_interval": d.slope_interval, "verdict": d.verdict(),
        })),
        "bins": o.bins.iter().map(|b| json!({
            "low_m_per_s": b.low, "high_m_per_s": b.high, "relative_velocity_m_per_s": b.relative_velocity,
            "mu": b.mu, "spread": b.mu_std, "standard_error": b.mu_error, "count": b.count, "phases": b.phases,
        })).collect::<Vec<_>>(),
        "friction_curve": o.curve.as_ref().map(|c| json!({
            "speed_m_per_s": c.speed, "mu": c.mu, "mu_std": c.mu_std, "events": c.events, "misfit": c.misfit,
            "explains_the_slip": o.curve_trusted,
        })),
        "laws": o.laws.iter().map(law).collect::<Vec<_>>(),
        "drift_m_per_s": estimate(o.drift),
        "offset_m": estimate(o.offset),
        "pole_speeds": o.pole_speeds.iter().map(|(f, causal, shifted)| json!({
            "pole_frequency_hz": f, "force_difference": causal, "force_difference_without_delay": shifted,
        })).collect::<Vec<_>>(),
        "belt_velocity_in_stick": o.belt_in_stick.map(|b| json!({
            "value_m_per_s": b.velocity, "std_m_per_s": b.std, "phases": b.phases, "samples": b.samples,
            "stated_off_percent": 100.0 * b.stated_is_off_by(o.belt_velocity), "contradicts_stated": b.contradicts(o.belt_velocity),
        })),
        "remarks": o.remarks,
    });
    if let (Value::Object(all), Ok(Value::Object(noise))) = (
        &mut value,
        serde_json::to_value(NoiseStd::of(o.measurand, o.noise_std)),
    ) {
        all.extend(noise);
    }
    provenance.json(&value)
}

fn law(fit: &LawFit) -> Value {
    json!({
        "law": fit.law.name(),
        "residual": fit.residual,
        "criterion": fit.criterion,
        "parameters": fit.parameters.iter().map(|p| json!({
            "name": p.name, "unit": p.unit, "value": p.value, "low": p.low, "high": p.high,
            "determined": p.is_determined(),
        })).collect::<Vec<_>>(),
        "start_values": fit.law.start_values().into_iter().collect::<std::collections::BTreeMap<_, _>>(),
    })
}
