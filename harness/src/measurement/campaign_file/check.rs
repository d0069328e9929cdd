//! Checks on single keys: a number, a list, a separator; each names file, line, key and what was read.

use crate::error::Error;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// The checks; knows the text, so that it can name lines.
pub(in crate::measurement) struct Check<'a> {
    pub(in crate::measurement) path: &'a Path,
    pub(in crate::measurement) text: &'a str,
}

/// What a number must be.
pub(in crate::measurement) type Rule = (fn(f64) -> bool, &'static str);

pub(in crate::measurement) const POSITIVE: Rule = (|v| v > 0.0, "it must be greater than zero");

pub(in crate::measurement) const NOT_NEGATIVE: Rule = (|v| v >= 0.0, "it must not be negative");

pub(in crate::measurement) const NOT_ZERO: Rule = (|v| v != 0.0, "it must not be zero");

pub(in crate::measurement) const SHARE: Rule = (
    |v| (1e-6..=0.5).contains(&v),
    "it is a share of the value, from 0.000001 to 0.5",
);

pub(in crate::measurement) const ANY: Rule = (|_| true, "it must be a finite number");

/// The line, counted from 1, on which a stretch of a text begins.
pub(crate) fn line_of(text: &str, span: Range<usize>) -> usize {
    1 + text
        .bytes()
        .take(span.start)
        .filter(|b| *b == b'\n')
        .count()
}

impl Check<'_> {
    pub(in crate::measurement) fn number(
        &self,
        key: &str,
        unit: &'static str,
        (holds, rule): Rule,
        value: Spanned<f64>,
    ) -> Result<f64, Error> {
        let line = line_of(self.text, value.span());
        let value = value.into_inner();
        if value.is_finite() && holds(value) {
            return Ok(value);
        }
        Err(Error::CampaignValue {
            path: self.path.to_owned(),
            line: Some(line),
            key: key.to_owned(),
            value,
            unit,
            rule,
        })
    }

    pub(in crate::measurement) fn list(
        &self,
        key: &str,
        unit: &'static str,
        rule: Rule,
        values: Option<Vec<Spanned<f64>>>,
    ) -> Result<Vec<f64>, Error> {
        values
            .unwrap_or_default()
            .into_iter()
            .map(|v| self.number(key, unit, rule, v))
            .collect()
    }

    pub(in crate::measurement) fn delimiter(
        &self,
        given: Option<Spanned<char>>,
    ) -> Result<Option<u8>, Error> {
        let Some(given) = given else {
            return Ok(None);
        };
        let line = line_of(self.text, given.span());
        let delimiter = given.into_inner();
        // What numbers, comments and quotes are made of can't stand between them.
        let fits = (delimiter.is_ascii_punctuation() && !".+-_#\"".contains(delimiter))
            || delimiter == ' '
            || delimiter == '\t';
        match u8::try_from(delimiter) {
            Ok(byte) if fits => Ok(Some(byte)),
            _ => Err(Error::CampaignFile {
                path: self.path.to_owned(),
                line,
                problem: format!(
                    "delimiter = {delimiter:?} can't separate numbers; give \",\", \";\", \"\\t\", \" \" or another sign of punctuation"
                ),
            }),
        }
    }

    /// The constant value of an input; with a column it may be left out, and is then its mean.
    pub(in crate::measurement) fn constant(
        &self,
        (key, unit, rule): (&'static str, &'static str, Rule),
        value: Option<Spanned<f64>>,
        column: (&'static str, bool),
        run: &Range<usize>,
    ) -> Result<f64, Error> {
        let problem = match (value, column) {
            (Some(value), (_, false)) => {
                return self.number(&format!("[[run]] {key}"), unit, rule, value);
            }
            (None, (_, true)) => return Ok(0.0),
            (None, (column, false)) => {
                format!(
                    "a [[run]] lacks {key}: give it, or {column} where the run's file has it as a column"
                )
            }
            (Some(_), (column, true)) => {
                format!("a [[run]] has both {key} and {column}: give the number or the column")
            }
        };
        Err(Error::CampaignFile {
            path: self.path.to_owned(),
            line: line_of(self.text, run.clone()),
            problem,
        })
    }
}
