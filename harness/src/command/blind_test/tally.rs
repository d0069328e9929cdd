//! Counts over all campaigns: by kind, by the probability of the verdicts, and by what an ideal
//! test could see.

use std::fmt::Write as _;

use serde::Serialize;

use super::answer::Kind;
use super::case::{BlindCase, CLAIM, Outcome};
use crate::metric::half_width;

/// Classes of a verdict's probability, the last with 1 in it.
const PROBABILITIES: [(f64, f64); 3] = [(CLAIM, 1.0), (0.5, CLAIM), (0.0, 0.5)];
/// Bounds of the classes of power.
const POWERS: [f64; 7] = [0.0, 2.0, 3.0, 4.0, 6.0, 10.0, f64::INFINITY];
/// A parameter is close if its relative error is less.
const CLOSE: f64 = 0.1;

/// Campaigns of one kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OfKind {
    /// The kind; `None` for all together.
    pub kind: Option<Kind>,
    /// Campaigns.
    pub campaigns: usize,
    /// Verdicts that are right.
    pub right: usize,
    /// Verdicts given with less than 90 % that are not.
    pub undecided: usize,
    /// The others.
    pub wrong: usize,
    /// Campaigns in which an effect is named that is not hidden.
    pub named_wrongly: usize,
    /// Median of the processor time of those that went through at once, s.
    pub processor_s_median: Option<f64>,
    /// The longest, s.
    pub processor_s_worst: Option<f64>,
}

/// Verdicts given with a probability of a class.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reliability {
    /// From this on ...
    pub from: f64,
    /// ... to this, which is not in the class unless it is 1.
    pub to: f64,
    /// Verdicts.
    pub verdicts: usize,
    /// Those that are right.
    pub right: usize,
}

/// Campaigns whose hidden effect has a power of a class.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OfPower {
    /// From this on ...
    pub from: f64,
    /// ... to this; `None` for no end.
    pub to: Option<f64>,
    /// Campaigns.
    pub campaigns: usize,
    /// Those in which the hidden effects were named.
    pub named: usize,
    /// Share (1) that an ideal test at the same price would name.
    pub ideal: f64,
}

/// Parameters of the effects named rightly.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OfParameters {
    /// Parameters.
    pub count: usize,
    /// Those within a tenth of the truth.
    pub close: usize,
    /// Those within the stated 95 % interval.
    pub inside: usize,
}

/// All counts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tally {
    /// By kind, all together last.
    pub kinds: Vec<OfKind>,
    /// By the verdicts' probability, the highest first.
    pub reliability: Vec<Reliability>,
    /// By power, the least first; classes without a campaign are left out.
    pub power: Vec<OfPower>,
    /// Parameters.
    pub parameters: OfParameters,
}

impl Tally {
    /// The counts of these campaigns.
    pub fn new(cases: &[BlindCase]) -> Self {
        let mut kinds: Vec<Kind> = cases.iter().map(|c| c.kind).collect();
        kinds.sort_unstable();
        kinds.dedup();
        let of_kind = |kind: Option<Kind>| {
            let is_of = |c: &&BlindCase| kind.is_none_or(|kind| c.kind == kind);
            of_kind(kind, &cases.iter().filter(is_of).collect::<Vec<_>>())
        };
        let rows = kinds.iter().map(|kind| of_kind(Some(*kind)));
        Self {
            kinds: rows.chain([of_kind(None)]).collect(),
            reliability: PROBABILITIES
                .map(|class| reliability(class, cases))
                .to_vec(),
            power: POWERS
                .windows(2)
                .filter_map(|w| of_power((w[0], w[1]), cases))
                .collect(),
            parameters: of_parameters(cases),
        }
    }

    /// The tables for the terminal.
    pub fn text(&self) -> String {
        let mut out = format!(
            "{:<20} {:>9} {:>13} {:>9} {:>5} {:>13} {:>20}\n",
            "kind",
            "campaigns",
            "right",
            "undecided",
            "wrong",
            "named wrongly",
            "processor s, worst"
        );
        for row in &self.kinds {
            let _ = writeln!(
                out,
                "{:<20} {:>9} {:>13} {:>9} {:>5} {:>13} {:>20}",
                row.kind.map_or("all", Kind::name),
                row.campaigns,
                share(row.right, row.campaigns),
                row.undecided,
                row.wrong,
                row.named_wrongly,
                times(row),
            );
        }
        let _ = writeln!(
            out,
            "\n{:<20} {:>9} {:>13}",
            "verdicts given with", "campaigns", "right"
        );
        for row in &self.reliability {
            let class = match row {
                r if r.from <= 0.0 => format!("less than {:.0} %", 100.0 * r.to),
                r if r.to >= 1.0 => format!("{:.0} % and more", 100.0 * r.from),
                r => format!("{:.0} to {:.0} %", 100.0 * r.from, 100.0 * r.to),
            };
            let right = share(row.right, row.verdicts);
            let _ = writeln!(out, "{class:<20} {:>9} {right:>13}", row.verdicts);
        }
        if !self.power.is_empty() {
            let _ = writeln!(
                out,
                "\n{:<20} {:>9} {:>13} {:>10}",
                "power", "campaigns", "named", "ideal test"
            );
        }
        for row in &self.power {
            let class = match row.to {
                Some(to) if row.from <= 0.0 => format!("less than {to}"),
                Some(to) => format!("{} to {to}", row.from),
                None => format!("{} and more", row.from),
            };
            let named = share(row.named, row.campaigns);
            let ideal = format!("{:.0} %", 100.0 * row.ideal);
            let _ = writeln!(
                out,
                "{class:<20} {:>9} {named:>13} {ideal:>10}",
                row.campaigns
            );
        }
        let p = &self.parameters;
        if p.count > 0 {
            let _ = writeln!(
                out,
                "\nparameters within 10 %: {} of {}; inside the stated 95 % interval: {} of {}",
                p.close, p.count, p.inside, p.count
            );
        }
        out
    }
}

fn share(some: usize, all: usize) -> String {
    match all {
        0 => "-".to_owned(),
        _ => format!("{some} ({:.0} %)", 100.0 * some as f64 / all as f64),
    }
}

fn times(row: &OfKind) -> String {
    match (row.processor_s_median, row.processor_s_worst) {
        (Some(median), Some(worst)) => format!("{median:.0}, {worst:.0}"),
        _ => "-".to_owned(),
    }
}

fn of_kind(kind: Option<Kind>, cases: &[&BlindCase]) -> OfKind {
    let with = |outcome: Outcome| cases.iter().filter(|c| c.outcome == outcome).count();
    let mut times: Vec<f64> = cases.iter().filter_map(|c| c.processor_s).collect();
    times.sort_by(f64::total_cmp);
    OfKind {
        kind,
        campaigns: cases.len(),
        right: with(Outcome::Right),
        undecided: with(Outcome::Undecided),
        wrong: with(Outcome::Wrong),
        named_wrongly: cases.iter().filter(|c| c.is_named_wrongly()).count(),
        processor_s_median: times.get(times.len() / 2).copied(),
        processor_s_worst: times.last().copied(),
    }
}

fn reliability((from, to): (f64, f64), cases: &[BlindCase]) -> Reliability {
    let is_in = |p: f64| p >= from && (p < to || to == 1.0);
    let given = cases.iter().filter(|c| c.probability.is_some_and(is_in));
    let given: Vec<&BlindCase> = given.collect();
    Reliability {
        from,
        to,
        verdicts: given.len(),
        right: given.iter().filter(|c| c.right).count(),
    }
}

fn of_power((from, to): (f64, f64), cases: &[BlindCase]) -> Option<OfPower> {
    let is_in = |value: f64| value >= from && value < to;
    let those: Vec<(&BlindCase, f64)> = cases
        .iter()
        .filter_map(|c| c.power.filter(|p| is_in(p.value)).map(|p| (c, p.ideal())))
        .collect();
    (!those.is_empty()).then(|| OfPower {
        from,
        to: to.is_finite().then_some(to),
        campaigns: those.len(),
        named: those.iter().filter(|(c, _)| c.is_named()).count(),
        ideal: those.iter().map(|(_, ideal)| ideal).sum::<f64>() / those.len() as f64,
    })
}

fn of_parameters(cases: &[BlindCase]) -> OfParameters {
    let right = cases.iter().filter(|c| c.right);
    let errors: Vec<[Option<f64>; 2]> = right
        .flat_map(|c| c.parameter_errors.values().copied())
        .collect();
    let within = |place: usize, limit: f64| {
        let is_within = |e: &&[Option<f64>; 2]| e[place].is_some_and(|e| e.abs() < limit);
        errors.iter().filter(is_within).count()
    };
    OfParameters {
        count: errors.len(),
        close: within(0, CLOSE),
        inside: within(1, half_width(1.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::blind_test::power::Power;
    use serde_json::json;

    fn case(kind: &str, outcome: &str, probability: f64, more: serde_json::Value) -> BlindCase {
        let mut value = json!({
            "campaign": "001", "kind": kind, "hidden": ["a"], "named": [], "verdict": null,
            "probability": probability, "right": outcome == "right", "outcome": outcome,
            "holdout_nrmse": [null, null], "over_noise": null, "parameter_errors": {},
            "power": null, "seconds": 1.0, "processor_s": 10.0,
            "provenance": {
                "version": "", "date": "", "command_line": "", "inputs_sha256": "", "inputs": [],
            },
        });
        let all = value.as_object_mut().unwrap();
        all.extend(more.as_object().unwrap().clone());
        serde_json::from_value(value).unwrap()
    }

    #[test]
    fn cases_are_counted_by_kind_probability_and_power() {
        let found = json!({"named": ["a"], "power": {"value": 5.0, "price": 8.0}});
        let missed = json!({"power": {"value": 4.5, "price": 8.0}, "processor_s": 30.0});
        let other = json!({"named": ["b"], "processor_s": 20.0});
        let cases = [
            case("weak", "right", 0.9, found),
            case("weak", "undecided", 0.5, missed),
            case("single", "wrong", 1.0, other),
        ];
        let tally = Tally::new(&cases);
        let counts: Vec<_> = tally
            .kinds
            .iter()
            .map(|k| {
                (
                    k.kind,
                    k.campaigns,
                    k.right,
                    k.undecided,
                    k.wrong,
                    k.named_wrongly,
                )
            })
            .collect();
        let expected = [
            (Some(Kind::Single), 1, 0, 0, 1, 1),
            (Some(Kind::Weak), 2, 1, 1, 0, 0),
            (None, 3, 1, 1, 1, 1),
        ];
        assert_eq!(counts, expected);
        let all = &tally.kinds[2];
        assert_eq!(
            (all.processor_s_median, all.processor_s_worst),
            (Some(20.0), Some(30.0))
        );
        let verdicts: Vec<_> = tally
            .reliability
            .iter()
            .map(|r| (r.verdicts, r.right))
            .collect();
        assert_eq!(verdicts, [(2, 1), (1, 0), (0, 0)]);
        let [power] = &tally.power[..] else {
            panic!("{:?}", tally.power)
        };
        assert_eq!(
            (power.from, power.to, power.campaigns, power.named),
            (4.0, Some(6.0), 2, 1)
        );
        let ideal = |value| Power { value, price: 8.0 }.ideal();
        assert!((power.ideal - 0.5 * (ideal(5.0) + ideal(4.5))).abs() < 1e-12);
        let text = tally.text();
        assert!(
            text.contains("90 % and more") && text.contains("4 to 6"),
            "{text}"
        );
    }
}
