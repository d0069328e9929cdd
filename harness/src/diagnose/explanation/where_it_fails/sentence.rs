//! What levels say, in one sentence.

use super::dependence_test::{Finding, extremes};
use super::level::Level;
use crate::report::number;

/// A level in two digits: `14`, `1.0`.
fn times(level: f64) -> String {
    match level {
        v if (0.095..9.95).contains(&v) => format!("{v:.1}"),
        v if v >= 1e4 => number(1e3 * (v / 1e3).round(), 2),
        v => number(v, 2),
    }
}

/// The sentence about the error over a quantity, e.g. `the time in the run`.
pub fn sentence(quantity: &str, levels: &[Level], finding: Finding) -> String {
    let known = || levels.iter().filter(|l| l.is_known());
    let most = known().map(|l| l.over_noise).fold(0.0, f64::max);
    let least = known().map(|l| l.over_noise).fold(f64::INFINITY, f64::min);
    let between = match (times(least), times(most)) {
        (a, b) if a == b => format!("{a} times the noise throughout"),
        (a, b) => format!("between {a} and {b} times the noise"),
    };
    match (finding, extremes(levels)) {
        (Finding::Depends, Some((largest, smallest))) => format!(
            "{} error is {} times the noise {} and {} times {}.",
            match largest.stratum_name.as_str() {
                "" => "The".to_owned(),
                name => format!("In {name} the"),
            },
            times(largest.over_noise),
            largest.place,
            times(smallest.over_noise),
            smallest.place
        ),
        (Finding::Same, _) => format!("No dependence on {quantity}: {between}."),
        (Finding::Chance, _) => format!(
            "No dependence on {quantity} is significant: {between}, no further apart than chance makes it."
        ),
        _ => format!(
            "Too few predictions to say whether the error depends on {quantity}: fewer than two intervals hold {}.",
            super::level::LEAST
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::dependence_test::{judge, tests::level};
    use super::*;

    fn said(levels: &[Level]) -> String {
        sentence("what the contact does", levels, judge(levels))
    }

    #[test]
    fn sentences_follow_from_the_numbers() {
        let phases = |stick: f64, break_away: f64, scatter: f64, segments: usize| {
            [
                level("in stick", stick, scatter, segments, 1),
                level("at break-away", break_away, scatter, segments, 2),
            ]
        };
        let told = said(&phases(1.1, 14.0, 0.02, 20));
        assert_eq!(
            told,
            "The error is 14 times the noise at break-away and 1.1 times in stick."
        );
        let told = said(&phases(0.9, 1.2, 0.02, 20));
        assert_eq!(
            told,
            "No dependence on what the contact does: between 0.9 and 1.2 times the noise."
        );
        let told = said(&phases(1.0, 1.0, 0.0, 20));
        assert!(told.ends_with("1.0 times the noise throughout."), "{told}");
        let told = said(&phases(10.0, 20.0, 4.0, 5));
        assert!(
            told.ends_with("no further apart than chance makes it."),
            "{told}"
        );
        let in_run = phases(1.1, 14.0, 0.02, 20).map(|l| l.within("run01"));
        assert!(
            said(&in_run).starts_with("In run01 the error is 14 times the noise at break-away")
        );
        let told = said(&phases(1.0, 20.0, 0.1, 2));
        assert!(told.starts_with("Too few predictions to say"), "{told}");
    }
}
