//! The short table for the terminal.

use std::fmt::Write as _;

use console::style;

use super::RunComparison;
use crate::measurement::Campaign;
use crate::report::{number, with_unit};

/// What the figure of [`super::from_start_states`] is.
pub const FROM_STARTS: &str = "NRMSE from start states: this FMU holds parameters and start states for each run (resources/runs); from \
    these, short pieces are predicted, the worst tenth left out, as in the error ladder of `diagnose`";

/// What the figures of further sensors are.
pub const FURTHER: &str = "Further sensors: NRMSE of the model that the first sensor aligns, sensors as stated; factor: slope of the readings \
    over the model, by which a sensor is off where the motion is right";

/// One line per run, worst first; colour only where standard output is a terminal.
pub fn table(campaign: &Campaign, comparisons: &[RunComparison], limit: Option<f64>) -> String {
    let mut text = format!(
        "Campaign '{}', {} runs, worst first (model | measured):\n\n",
        campaign.name,
        comparisons.len()
    );
    let header = format!(
        "{:<10} {:>9} {:>7}  {:>7} {:>7}  {:>19}  {:>17}  {:>13}",
        "run", "belt", "force", "NRMSE", "noise", "period", "amplitude", "stick share"
    );
    let _ = writeln!(text, "{}", style(header).bold());
    let any_held = comparisons
        .iter()
        .any(|r| r.nrmse_from_start_states.is_some());
    for run in comparisons {
        let score = format!("{:>7}", number(run.nrmse, 3));
        let score = match limit {
            Some(limit) if run.exceeds(limit) => style(score).red(),
            Some(_) => style(score).green(),
            None => style(score),
        };
        let unit = run.curves.measurand.unit();
        let period = |seconds: Option<f64>| seconds.map_or("none".into(), |s| with_unit(s, "s"));
        let _ = writeln!(
            text,
            "{:<10} {:>9} {:>7}  {score} {:>7}  {:>19}  {:>17}  {:>13}",
            run.name,
            format!("{} m/s", number(run.belt_velocity_m_per_s, 3)),
            with_unit(run.normal_force_n, "N"),
            number(run.noise_floor, 2),
            format!(
                "{} | {}",
                period(run.model.period),
                period(run.measured.period)
            ),
            format!(
                "{} | {}",
                with_unit(run.model.amplitude, unit),
                with_unit(run.measured.amplitude, unit)
            ),
            format!(
                "{} | {}",
                share(run.model.stick_fraction),
                share(run.measured.stick_fraction)
            ),
        );
        for remark in &run.remarks {
            let _ = writeln!(text, "{:<10} {}", "", style(remark).yellow());
        }
    }
    if any_held {
        let _ = writeln!(text, "\n{FROM_STARTS}:\n");
        for run in comparisons {
            let error = run.nrmse_from_start_states;
            let error = error.map_or("none held".into(), |e| number(e, 3));
            let floor = number(run.noise_floor, 2);
            let _ = writeln!(text, "{:<10} {error:>9}   noise {floor:>7}", run.name);
        }
    }
    if comparisons.iter().any(|r| !r.further_sensors.is_empty()) {
        let _ = writeln!(text, "\n{FURTHER}:\n");
        for run in comparisons {
            for sensor in &run.further_sensors {
                let _ = writeln!(
                    text,
                    "{:<10} {:<20} {:>9}   noise {:>7}   factor {:>7}",
                    run.name,
                    sensor.name,
                    number(sensor.nrmse, 3),
                    number(sensor.noise_floor, 2),
                    number(sensor.factor, 3)
                );
            }
        }
    }
    text.push('\n');
    text
}

/// A share of time, a dash where it is not known.
fn share(value: f64) -> String {
    match value.is_finite() {
        true => format!("{value:.2}"),
        false => "-".into(),
    }
}
