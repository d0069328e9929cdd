//! Which runs are kept out of every fit.

use crate::measurement::{Campaign, Role, Run};
use crate::metric::standard_deviation;

/// A rule for what is kept out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum HoldOut {
    /// As campaign.toml says, else a third of the runs, from the middle of the operating points: interpolation
    #[default]
    Middle,
    /// The runs at the highest belt speed and at the highest normal force: extrapolation
    Extrapolate,
}

impl HoldOut {
    /// For each run whether it is kept out.
    pub(crate) fn of(self, campaign: &Campaign) -> Vec<bool> {
        match self {
            Self::Middle => middle(campaign),
            Self::Extrapolate => extremes(campaign),
        }
    }
}

/// The runs at the highest belt speed and at the highest normal force. None where all runs are at one operating point.
fn extremes(campaign: &Campaign) -> Vec<bool> {
    let runs = &campaign.runs;
    let at_most = |value: fn(&Run) -> f64| -> Vec<bool> {
        let values: Vec<f64> = runs.iter().map(value).collect();
        let most = values.iter().copied().fold(0.0, f64::max);
        let differ = values.iter().any(|v| *v < most);
        values.iter().map(|v| differ && *v == most).collect()
    };
    let fastest = at_most(|r| r.belt_velocity.abs());
    let heaviest = at_most(|r| r.normal_force);
    fastest
        .iter()
        .zip(&heaviest)
        .map(|(a, b)| *a || *b)
        .collect()
}

/// Runs kept out of every fit: those that the campaign names, else a third, from the middle of the
/// operating points.
fn middle(campaign: &Campaign) -> Vec<bool> {
    let count = campaign.runs.len();
    if campaign.runs.iter().any(|r| r.role.is_some()) {
        return campaign
            .runs
            .iter()
            .map(|r| r.role == Some(Role::Holdout))
            .collect();
    }
    let mut out = vec![false; count];
    if count >= 3 {
        // The points nearest the middle of the (v0, F_N) plane, so that fits need not extrapolate.
        let centred = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let all: Vec<f64> = (0..count).map(value).collect();
            let mean = all.iter().sum::<f64>() / count as f64;
            let width = standard_deviation(&all).max(1e-12);
            all.iter().map(|v| (v - mean) / width).collect()
        };
        let speed = centred(&|r| campaign.runs[r].belt_velocity);
        let force = centred(&|r| campaign.runs[r].normal_force);
        let distance: Vec<f64> = speed.iter().zip(&force).map(|(a, b)| a.hypot(*b)).collect();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| distance[a].total_cmp(&distance[b]));
        for &run in &order[..count / 3] {
            out[run] = true;
        }
    }
    out
}
