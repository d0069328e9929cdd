//! What a check has to say.

use serde::Serialize;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A value that can't be meant: long work is not begun on it.
    Error,
    /// Something to know.
    Warning,
}

/// One thing found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// What it is, for programs.
    pub id: &'static str,
    /// The runs it concerns, by name.
    pub runs: Vec<String>,
    /// What was measured.
    pub measured: String,
    /// What was stated.
    pub stated: String,
    /// What to do.
    pub remedy: String,
}

impl Finding {
    /// A finding on one run.
    pub fn of(
        severity: Severity,
        id: &'static str,
        run: &str,
        (measured, stated, remedy): (String, String, String),
    ) -> Finding {
        Finding {
            severity,
            id,
            runs: vec![run.to_owned()],
            measured,
            stated,
            remedy,
        }
    }
}

/// A number in three digits.
pub fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e4).contains(&size) {
        let places = 2 - (size.max(1e-3).log10().floor() as i32).clamp(-3, 2);
        let text = format!("{value:.*}", places.max(0) as usize);
        if text.contains('.') {
            return text.trim_end_matches('0').trim_end_matches('.').to_owned();
        }
        return text;
    }
    format!("{value:.2e}")
}

/// Findings of the same kind and remedy as one, for all their runs; errors first.
pub fn gathered(findings: Vec<Finding>) -> Vec<Finding> {
    let mut all: Vec<Finding> = Vec::new();
    for finding in findings {
        let same = |other: &&mut Finding| {
            other.id == finding.id
                && other.severity == finding.severity
                && other.remedy == finding.remedy
        };
        match all.iter_mut().find(same) {
            Some(known) => known.runs.extend(finding.runs),
            None => all.push(finding),
        }
    }
    all.sort_by_key(|finding| finding.severity);
    all
}

#[cfg(test)]
mod tests {
    use super::digits;

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (0.0, "0"),
            (0.06, "0.06"),
            (80.0, "80"),
            (1648.4, "1648"),
            (3.1459, "3.15"),
            (0.012_345, "0.0123"),
            (-0.1, "-0.1"),
            (6e-5, "6.00e-5"),
            (4.34e7, "4.34e7"),
        ];
        for (value, text) in cases {
            assert_eq!(digits(value), text);
        }
    }
}
