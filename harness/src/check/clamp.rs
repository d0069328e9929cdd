//! What a shaking clamp is taken to do to a structure.

use super::finding::{Finding, Severity};
use crate::measurement::{Campaign, Run};

/// A warning for each run whose clamp shakes a structure with one mode of which it is not stated what the mode has of the tip's motion: it is
/// taken for a cantilever, 1.566, and a mass on a spring has 1.
pub fn clamp(campaign: &Campaign) -> Vec<Finding> {
    let beam = &campaign.beam;
    if !beam.clamp_shares.is_empty() || beam.natural_frequencies_hz.len() != 1 {
        return Vec::new();
    }
    let shaken = campaign.runs.iter();
    let shaken = shaken.filter(|run| run.inputs.clamp_acceleration.acts());
    let finding = |run: &Run| {
        Finding::of(
            Severity::Warning,
            "clamp_shares",
            &run.name,
            (
                "the clamp shakes a structure with one mode".to_owned(),
                "no clamp_shares, so that a cantilever's 1.566 is taken".to_owned(),
                "state clamp_shares under [beam]: [1.0] for a mass on a spring, [1.566] for a beam"
                    .to_owned(),
            ),
        )
    };
    shaken.map(finding).collect()
}
