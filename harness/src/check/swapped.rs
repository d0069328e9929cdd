//! Files that belong to other runs: each sticks at the speed that another run states.

use super::examined::Examined;
use super::finding::{Finding, Severity, digits};
use super::thresholds::{SAME_SPEED, SPEED_OFF};

/// Findings on runs whose stick speed is not the one stated but that of another run, which is off
/// itself.
pub fn swapped(runs: &[Examined]) -> Vec<(usize, Finding)> {
    let off = |i: usize| {
        let ratio = runs[i].speed_ratio();
        ratio.is_some_and(|a| (a - 1.0).abs() > SPEED_OFF)
    };
    let mut found = Vec::new();
    for i in (0..runs.len()).filter(|i| off(*i)) {
        let Some(speed) = runs[i].motion.stick_speed else {
            continue;
        };
        let fits = |j: &usize| (speed / runs[*j].run.belt_velocity - 1.0).abs() < SAME_SPEED;
        let Some(other) = (0..runs.len()).filter(|j| *j != i && off(*j)).find(fits) else {
            continue;
        };
        let (run, other) = (runs[i].run, runs[other].run);
        let remedy = format!(
            "its stick speed is the belt speed of run '{}', which is off too: these files seem to be swapped, exchange their names (file) in campaign.toml",
            other.name
        );
        found.push((
            i,
            Finding::of(
                Severity::Error,
                "swapped_files",
                &run.name,
                (
                    format!("the tip moves at {} m/s in stick", digits(speed)),
                    format!("belt_velocity_m_per_s = {}", run.belt_velocity),
                    remedy,
                ),
            ),
        ));
    }
    found
}
