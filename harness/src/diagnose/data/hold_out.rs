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
    #[value(skip)]
    /// Others than the first rule keeps out, again from the middle of the operating points: where those contradicted what was found without
    /// them.
    Others,
}

impl HoldOut {
    /// For each run whether it is kept out.
    pub(crate) fn of(self, campaign: &Campaign) -> Vec<bool> {
        match self {
            Self::Middle => middle(campaign),
            Self::Extrapolate => extremes(campaign),
            Self::Others => others(campaign),
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

/// Whether the campaign says itself what is kept out.
fn is_stated(campaign: &Campaign) -> bool {
    campaign.runs.iter().any(|r| r.role.is_some())
}

/// Runs kept out of every fit: those that the campaign names, else a third, from the middle of the
/// operating points.
fn middle(campaign: &Campaign) -> Vec<bool> {
    if is_stated(campaign) {
        return campaign
            .runs
            .iter()
            .map(|r| r.role == Some(Role::Holdout))
            .collect();
    }
    third(campaign, 0)
}

/// A third of the runs, the first or a later one from the middle of the operating points.
fn third(campaign: &Campaign, number: usize) -> Vec<bool> {
    let count = campaign.runs.len();
    let kept_out = count / 3;
    let mut out = vec![false; count];
    for &run in &from_the_middle(campaign)[number * kept_out..][..kept_out] {
        out[run] = true;
    }
    out
}

/// As many others; the same where the campaign names them, or has too few.
fn others(campaign: &Campaign) -> Vec<bool> {
    match is_stated(campaign) {
        true => middle(campaign),
        false => third(campaign, 1),
    }
}

/// Places of the runs, that nearest the middle of the (v0, F_N) plane first, so that fits without it need not extrapolate.
fn from_the_middle(campaign: &Campaign) -> Vec<usize> {
    let count = campaign.runs.len();
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
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn others_are_as_many_and_none_of_the_first_unless_the_campaign_names_them() {
        let mut campaign = Campaign::load(Path::new("../reference-data/demo")).unwrap();
        for run in &mut campaign.runs {
            run.role = None;
        }
        let count = |out: &[bool]| out.iter().filter(|o| **o).count();
        let [first, others] = [HoldOut::Middle, HoldOut::Others].map(|rule| rule.of(&campaign));
        assert_eq!(count(&first), campaign.runs.len() / 3);
        assert_eq!(count(&others), count(&first));
        assert!(!first.iter().zip(&others).any(|(a, b)| *a && *b));
        campaign.runs[0].role = Some(Role::Holdout);
        let stated: Vec<bool> = (0..campaign.runs.len()).map(|i| i == 0).collect();
        assert_eq!(HoldOut::Others.of(&campaign), stated);
        campaign.runs.truncate(2);
        campaign.runs[0].role = None;
        assert_eq!(count(&HoldOut::Others.of(&campaign)), 0);
    }
}
