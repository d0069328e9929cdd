//! A claim of the paper, held against numbers of the model.

use crate::report::number;

/// How what the model shows compares with what the paper says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Every finding keeps its bound.
    Agrees,
    /// Some do.
    InPart,
    /// None does.
    Differs,
}

impl Verdict {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::InPart => "agrees in part",
            Verdict::Differs => "differs",
        }
    }
}

/// What a number must keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// No more than this.
    AtMost(f64),
    /// No less than this.
    AtLeast(f64),
    /// More than this.
    Above(f64),
    /// Between these.
    Between(f64, f64),
}

/// A number of the model beside its bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What was measured.
    pub what: String,
    /// The number; NaN where the model has none.
    pub value: f64,
    /// Its unit; empty for a count or ratio.
    pub unit: &'static str,
    /// What the paper's claim asks of it.
    pub bound: Bound,
    /// Why this bound.
    pub reason: String,
}

impl Finding {
    /// A finding.
    pub fn new(
        what: impl Into<String>,
        value: f64,
        unit: &'static str,
        bound: Bound,
        reason: impl Into<String>,
    ) -> Self {
        Self {
            what: what.into(),
            value,
            unit,
            bound,
            reason: reason.into(),
        }
    }

    /// Whether the bound is kept; no number keeps none.
    pub fn holds(&self) -> bool {
        match self.bound {
            Bound::AtMost(most) => self.value <= most,
            Bound::AtLeast(least) => self.value >= least,
            Bound::Above(limit) => self.value > limit,
            Bound::Between(low, high) => (low..=high).contains(&self.value),
        }
    }

    /// The number with its unit.
    pub fn value_words(&self) -> String {
        if self.value.is_nan() {
            return "none".into();
        }
        self.with_unit(self.value)
    }

    /// The bound with its unit.
    pub fn bound_words(&self) -> String {
        match self.bound {
            Bound::AtMost(most) => format!("at most {}", self.with_unit(most)),
            Bound::AtLeast(least) => format!("at least {}", self.with_unit(least)),
            Bound::Above(limit) => format!("above {}", self.with_unit(limit)),
            Bound::Between(low, high) => {
                format!("{} to {}", number(low, 3), self.with_unit(high))
            }
        }
    }

    fn with_unit(&self, value: f64) -> String {
        let number = match value {
            f64::INFINITY => "inf".into(),
            f64::NEG_INFINITY => "-inf".into(),
            value => number(value, 3),
        };
        format!("{number} {}", self.unit).trim_end().to_owned()
    }
}

/// A claim of the paper and what the model shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// What the paper says.
    pub paper: String,
    /// What this model shows besides, in words.
    pub model: String,
    /// Numbers with their bounds; at least one.
    pub findings: Vec<Finding>,
}

impl Claim {
    /// A claim.
    pub fn new(paper: &str, model: impl Into<String>, findings: Vec<Finding>) -> Self {
        Self {
            paper: paper.into(),
            model: model.into(),
            findings,
        }
    }

    /// From the findings alone.
    pub fn verdict(&self) -> Verdict {
        let kept = self.findings.iter().filter(|f| f.holds()).count();
        match kept {
            0 => Verdict::Differs,
            n if n == self.findings.len() => Verdict::Agrees,
            _ => Verdict::InPart,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(values: &[f64], bound: Bound) -> Verdict {
        let finding = |v: &f64| Finding::new("x", *v, "N", bound, "");
        Claim::new("", "", values.iter().map(finding).collect()).verdict()
    }

    #[test]
    fn verdicts_follow_from_numbers_and_bounds() {
        assert_eq!(claim(&[1.0, 2.0], Bound::AtMost(2.0)), Verdict::Agrees);
        assert_eq!(claim(&[1.0, 2.1], Bound::AtMost(2.0)), Verdict::InPart);
        assert_eq!(claim(&[2.1, 2.2], Bound::AtMost(2.0)), Verdict::Differs);
        assert_eq!(claim(&[1.0, 2.0], Bound::AtLeast(1.5)), Verdict::InPart);
        assert_eq!(claim(&[2.0], Bound::Between(2.0, 3.0)), Verdict::Agrees);
        assert_eq!(claim(&[3.1], Bound::Between(2.0, 3.0)), Verdict::Differs);
        assert_eq!(claim(&[0.0], Bound::Above(0.0)), Verdict::Differs);
        assert_eq!(claim(&[0.1], Bound::Above(0.0)), Verdict::Agrees);
        for bound in [Bound::AtMost(9.0), Bound::AtLeast(-9.0)] {
            assert_eq!(claim(&[f64::NAN], bound), Verdict::Differs);
        }
    }

    #[test]
    fn words_have_number_unit_and_bound() {
        let finding = Finding::new("force", 1.2345, "N", Bound::Between(1.0, 2.0), "");
        assert_eq!(finding.value_words(), "1.23 N");
        assert_eq!(finding.bound_words(), "1 to 2 N");
    }
}
