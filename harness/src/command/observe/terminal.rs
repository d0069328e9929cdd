//! The summary for the terminal.

use std::fmt::Write as _;

use console::style;

use super::Observation;
use crate::metric::half_width;
use crate::report::{number, with_unit};

/// A dozen lines.
pub fn summary(o: &Observation) -> String {
    let mut text = String::new();
    let title = format!(
        "{} at {} m/s, {} N: {}",
        o.name,
        o.belt_velocity,
        o.normal_force,
        o.method.name()
    );
    let _ = writeln!(text, "{}\n", style(title).bold());
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "  {name:<28} {value}");
    };
    line(
        "samples",
        format!(
            "{} in {}",
            o.time.len(),
            with_unit(o.time[o.time.len() - 1] - o.time[0], "s")
        ),
    );
    if let Some(belt) = &o.belt_in_stick {
        let value = format!(
            "{:.6} ± {} m/s (95 %)",
            belt.velocity,
            number(half_width(belt.std), 2)
        );
        line("belt velocity in stick", value);
    }
    line("sensor noise", with_unit(o.noise_std, o.measurand.unit()));
    line(
        "in stick",
        format!(
            "{:.1} % of the time, {} complete sticks",
            100.0 * o.stick_fraction(),
            o.sticks()
        ),
    );
    let known: Vec<f64> = o
        .force_std
        .iter()
        .copied()
        .filter(|s| s.is_finite())
        .collect();
    if !known.is_empty() {
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        line("force uncertainty (mean)", with_unit(mean, "N"));
    }
    if let Some(dwell) = &o.dwell {
        line(
            "static coefficient",
            format!(
                "{}, scatter {} from stick to stick",
                number(dwell.mu_mean, 3),
                number(dwell.mu_std, 2)
            ),
        );
        line("dwell time", dwell.verdict().to_owned());
    }
    if let Some(best) = o.best_law() {
        line(
            "best law",
            format!(
                "{} (residual {})",
                best.law.name(),
                number(best.residual, 2)
            ),
        );
        for p in &best.parameters {
            let range = if p.is_determined() {
                format!(
                    "{}  [{} to {}] {}",
                    number(p.value, 3),
                    number(p.low, 3),
                    number(p.high, 3),
                    p.unit
                )
            } else {
                format!("{}  not determined by this record", number(p.value, 3))
            };
            line(&format!("  {}", p.name), range);
        }
    }
    for remark in &o.remarks {
        let _ = writeln!(text, "  {}", style(remark).yellow());
    }
    text.push('\n');
    text
}
