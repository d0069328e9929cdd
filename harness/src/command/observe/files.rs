//! force.csv, friction.csv and the JSON summary.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::Observation;
use crate::observer::LawFit;

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

/// One line per bin.
pub fn friction(o: &Observation) -> String {
    let mut csv = String::from("relative_velocity_m_per_s,mu,mu_std,count\n");
    for bin in &o.bins {
        let _ = writeln!(
            csv,
            "{:.6e},{:.6e},{:.6e},{}",
            bin.relative_velocity, bin.mu, bin.mu_std, bin.count
        );
    }
    csv
}

/// The results without the columns.
pub fn json(o: &Observation) -> String {
    let estimate = |e: Option<crate::observer::Estimate>| {
        e.map_or(Value::Null, |e| json!({ "value": e.value, "std": e.std }))
    };
    let value = json!({
        "run": o.name,
        "method": o.method.name(),
        "belt_velocity_m_per_s": o.belt_velocity,
        "normal_force_n": o.normal_force,
        "natural_frequencies_hz": o.structure.modes().iter().map(|m| m.frequency_hz).collect::<Vec<_>>(),
        "noise_std_m": o.noise_std,
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
        "friction_curve": o.curve.as_ref().map(|c| json!({
            "speed_m_per_s": c.speed, "mu": c.mu, "mu_std": c.mu_std, "events": c.events, "misfit": c.misfit,
        })),
        "laws": o.laws.iter().map(law).collect::<Vec<_>>(),
        "drift_m_per_s": estimate(o.drift),
        "offset_m": estimate(o.offset),
        "pole_speeds": o.pole_speeds.iter().map(|(f, causal, shifted)| json!({
            "pole_frequency_hz": f, "force_difference": causal, "force_difference_without_delay": shifted,
        })).collect::<Vec<_>>(),
        "remarks": o.remarks,
    });
    serde_json::to_string_pretty(&value).expect("numbers and texts have a JSON form")
}

fn law(fit: &LawFit) -> Value {
    json!({
        "law": fit.law.name(),
        "residual": fit.residual,
        "criterion": fit.criterion,
        "parameters": fit.parameters.iter().map(|p| json!({
            "name": p.name, "unit": p.unit, "value": p.value, "low": p.low, "high": p.high,
        })).collect::<Vec<_>>(),
        "start_values": fit.law.start_values().into_iter().collect::<std::collections::BTreeMap<_, _>>(),
    })
}
