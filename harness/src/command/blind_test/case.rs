//! One campaign's result, and whether it is right.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::answer::{Answer, Kind, is_outside};
use super::power::Power;
use crate::diagnose::result::diagnosis::{Diagnosis, Verdict};
use crate::diagnose::thresholds::TIE;
use crate::error::Error;
use crate::provenance::Provenance;

/// Verdicts of this probability and more are claims; what is less probable is undecided.
pub const CLAIM: f64 = 0.9;

/// How a verdict compares with the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It is the truth.
    Right,
    /// It is not, and was given with less than [`CLAIM`].
    Undecided,
    /// It is not, or there is none.
    Wrong,
}

/// One campaign's result.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BlindCase {
    /// Name of the campaign.
    pub campaign: String,
    /// Its kind.
    pub kind: Kind,
    /// Hidden effects.
    pub hidden: Vec<String>,
    /// Effects named.
    pub named: Vec<String>,
    /// Verdict; `None` where the diagnosis ended with an error.
    pub verdict: Option<Verdict>,
    /// Posterior probability of the verdict.
    pub probability: Option<f64>,
    /// Whether the verdict is right.
    pub right: bool,
    /// The same, with what is undecided apart.
    pub outcome: Outcome,
    /// What the diagnosis ended with, where it gave no verdict.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Held-out error of the calibrated model and of the last rung.
    pub holdout_nrmse: [Option<f64>; 2],
    /// Held-out error of the last rung over the noise.
    pub over_noise: Option<f64>,
    /// Relative error of each parameter of the effects named rightly, and the same in standard
    /// deviations.
    pub parameter_errors: BTreeMap<String, [Option<f64>; 2]>,
    /// What an ideal test could see of the hidden effects; `None` where that can't be told.
    pub power: Option<Power>,
    /// Wall time of the diagnosis in s.
    pub seconds: f64,
    /// Processor time of the diagnosis in s; `None` for one that had been stopped and went on.
    pub processor_s: Option<f64>,
    /// Where it comes from; the list itself, an array, has no place for that.
    pub provenance: Provenance,
}

/// What diagnosing a campaign took: wall time, and processor time where that is known, in s.
pub type Cost = (f64, Option<f64>);

impl BlindCase {
    /// What a diagnosis, or the error that it ended with, is worth beside the truth.
    pub fn new(
        answer: &Answer,
        ended: &Result<Diagnosis, Error>,
        power: Option<Power>,
        (seconds, processor_s): Cost,
        provenance: Provenance,
    ) -> Self {
        let mut case = Self {
            campaign: answer.campaign.clone(),
            kind: answer.kind(),
            hidden: answer.effects.clone(),
            named: Vec::new(),
            verdict: None,
            probability: None,
            right: false,
            outcome: Outcome::Wrong,
            error: ended.as_ref().err().map(ToString::to_string),
            holdout_nrmse: [None; 2],
            over_noise: None,
            parameter_errors: BTreeMap::new(),
            power,
            seconds,
            processor_s,
            provenance,
        };
        if let Ok(diagnosis) = ended {
            case.tell(answer, diagnosis);
        }
        case
    }

    fn tell(&mut self, answer: &Answer, diagnosis: &Diagnosis) {
        let finite = |value: f64| value.is_finite().then_some(value);
        self.verdict = Some(diagnosis.verdict);
        self.probability = diagnosis.verdict_probability.and_then(finite);
        let said = Said::by(diagnosis, &answer.effects);
        self.outcome = outcome(self.kind, &answer.effects, &said);
        self.named = said.named;
        self.right = self.outcome == Outcome::Right;
        let hidden = |id: &String| answer.effects.contains(id);
        for effect in diagnosis.effects.iter().filter(|e| hidden(&e.id)) {
            for (name, estimate) in &effect.parameters {
                let truth = answer.parameter(&effect.id, name);
                if let Some(truth) = truth.filter(|v| *v != 0.0) {
                    let off = estimate.value - truth;
                    let errors = [finite(off / truth), finite(off / estimate.std)];
                    let name = format!("{}.{name}", effect.id);
                    self.parameter_errors.insert(name, errors);
                }
            }
        }
        let ladder = &diagnosis.error_ladder;
        let last = ladder.last().expect("the ladder has its first rung");
        let calibrated = &ladder[1.min(ladder.len() - 1)];
        self.holdout_nrmse = [calibrated, last].map(|rung| finite(rung.holdout_nrmse));
        self.over_noise = finite(last.holdout_over_noise);
    }

    /// Whether all that is hidden is named, and nothing else.
    pub fn is_named(&self) -> bool {
        is_named(&self.hidden, &self.named)
    }

    /// Whether an effect is named that is not hidden.
    pub fn is_named_wrongly(&self) -> bool {
        !self.right && self.named.iter().any(|id| !self.hidden.contains(id))
    }

    /// The line for the terminal.
    pub fn line(&self) -> String {
        let list = |names: &[String]| {
            if names.is_empty() {
                "none".to_owned()
            } else {
                names.join(" + ")
            }
        };
        let answer = match (self.verdict, &self.error) {
            (Some(Verdict::EffectFound), _) => list(&self.named),
            (Some(Verdict::NoMissingEffect), _) => "none".into(),
            (Some(Verdict::UnknownEffect), _) => "unknown".into(),
            (None, error) => error.clone().unwrap_or_default(),
        };
        let mut out = format!(
            "{} {} {} -> {answer}",
            self.campaign,
            match self.outcome {
                Outcome::Right => "ok       ",
                Outcome::Undecided => "undecided",
                Outcome::Wrong => "WRONG    ",
            },
            list(&self.hidden),
        );
        let per_cent = |value: Option<f64>| 100.0 * value.unwrap_or(f64::NAN);
        if self.verdict.is_some() {
            out += &format!(
                " ({:.0} %); held out {:.3} % -> {:.3} % ({:.2} x noise)",
                per_cent(self.probability),
                per_cent(self.holdout_nrmse[0]),
                per_cent(self.holdout_nrmse[1]),
                self.over_noise.unwrap_or(f64::NAN),
            );
        }
        for (name, [share, stds]) in &self.parameter_errors {
            let name = name.rsplit('.').next().unwrap_or(name);
            let stds = stds.unwrap_or(f64::NAN);
            out += &format!("; {name} {:+.1} % ({stds:+.1} s)", per_cent(*share));
        }
        if let Some(power) = &self.power {
            out += &format!("; power {:.1}", power.value);
        }
        out + &match self.processor_s {
            Some(time) => format!("; {time:.0} s"),
            None => "; resumed".to_owned(),
        }
    }
}

/// What a diagnosis says, as far as it is counted.
struct Said {
    verdict: Verdict,
    named: Vec<String>,
    probability: f64,
    /// Whether the one hidden effect can't be told from what is said.
    is_tied: bool,
}

impl Said {
    fn by(diagnosis: &Diagnosis, hidden: &[String]) -> Self {
        // A verdict without a probability was not compared with others.
        let probability = diagnosis.verdict_probability.unwrap_or(1.0);
        let close = probability * (-TIE).exp();
        let is_tied = |id: &String| {
            let mut candidates = diagnosis.candidates.iter();
            let mut named = diagnosis.effects.iter();
            named.any(|e| e.confounded_with.contains(id))
                || candidates.any(|c| c.id == *id && c.probability >= close)
        };
        Self {
            verdict: diagnosis.verdict,
            named: diagnosis.effects.iter().map(|e| e.id.clone()).collect(),
            probability,
            is_tied: hidden.len() == 1 && is_tied(&hidden[0]),
        }
    }
}

/// How a verdict compares with the truth. Where all runs are at one load, a hidden effect that is tied
/// with what is said counts as told: more can't be told from such runs.
fn outcome(kind: Kind, hidden: &[String], said: &Said) -> Outcome {
    let is_true = if hidden.is_empty() {
        said.verdict == Verdict::NoMissingEffect
    } else if is_outside(hidden) {
        said.verdict == Verdict::UnknownEffect
    } else {
        is_named(hidden, &said.named)
    };
    if is_true || (kind == Kind::OneLoad && said.is_tied) {
        Outcome::Right
    } else if said.probability < CLAIM {
        Outcome::Undecided
    } else {
        Outcome::Wrong
    }
}

/// Whether all that is hidden is named, and nothing else.
fn is_named(hidden: &[String], named: &[String]) -> bool {
    named.len() == hidden.len() && hidden.iter().all(|id| named.contains(id))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(kind: Kind, hidden: &[&str], named: &[&str], probability: f64, is_tied: bool) -> Outcome {
        let list = |ids: &[&str]| ids.iter().map(|id| (*id).to_owned()).collect::<Vec<_>>();
        let verdict = match named {
            [] => Verdict::NoMissingEffect,
            ["unknown"] => Verdict::UnknownEffect,
            _ => Verdict::EffectFound,
        };
        let named = match verdict {
            Verdict::EffectFound => list(named),
            _ => Vec::new(),
        };
        let said = Said {
            verdict,
            named,
            probability,
            is_tied,
        };
        outcome(kind, &list(hidden), &said)
    }

    #[test]
    fn what_is_true_is_right_and_what_is_not_is_wrong_only_where_it_is_claimed() {
        use Kind::{None, OneLoad, Outside, Pair, Single, Weak};
        use Outcome::{Right, Undecided, Wrong};
        assert_eq!(of(Single, &["a"], &["a"], 0.6, false), Right);
        assert_eq!(of(Single, &["a"], &["b"], 0.89, false), Undecided);
        assert_eq!(of(Single, &["a"], &["b"], 0.9, true), Wrong);
        assert_eq!(of(Single, &["a"], &["a", "b"], 0.95, false), Wrong);
        assert_eq!(of(Pair, &["a", "b"], &["b", "a"], 0.95, false), Right);
        assert_eq!(of(Pair, &["a", "b"], &["a"], 0.95, false), Wrong);
        assert_eq!(of(None, &[], &[], 0.95, false), Right);
        assert_eq!(of(None, &[], &["a"], 0.95, false), Wrong);
        assert_eq!(
            of(Outside, &["outside:a"], &["unknown"], 0.89, false),
            Right
        );
        assert_eq!(of(Outside, &["outside:a"], &[], 0.95, false), Wrong);
        assert_eq!(of(Weak, &["a"], &[], 0.89, false), Undecided);
        assert_eq!(of(OneLoad, &["a"], &["b"], 0.95, true), Right);
        assert_eq!(of(OneLoad, &["a"], &["b"], 0.95, false), Wrong);
    }
}
