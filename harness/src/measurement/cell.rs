//! One field of a table: a number, a missing sample, or neither.

/// What a field holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    /// Empty, `NaN`, `-` and what else loggers write where a sample is missing.
    Missing,
    /// Anything else.
    Text,
}

/// What loggers and spreadsheets write for a missing sample; capitals do not matter.
const MISSING: [&str; 10] = [
    "", "nan", "-nan", "-", "--", "---", "n/a", "na", "null", "#n/a",
];

impl Cell {
    /// Reads a field whose numbers have this `decimal` mark.
    pub fn read(text: &str, decimal: char) -> Cell {
        if MISSING.iter().any(|word| text.eq_ignore_ascii_case(word)) {
            return Cell::Missing;
        }
        let parsed = if decimal == '.' {
            text.parse()
        } else if text.contains('.') {
            return Cell::Text;
        } else {
            text.replace(decimal, ".").parse()
        };
        match parsed {
            Ok(value) if f64::is_finite(value) => Cell::Number(value),
            _ => Cell::Text,
        }
    }

    pub fn is_number(self) -> bool {
        matches!(self, Cell::Number(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_gaps_and_texts_are_told_apart() {
        let cases = [
            ("1.5e-3", '.', Cell::Number(1.5e-3)),
            ("-1,5E-3", ',', Cell::Number(-1.5e-3)),
            ("1,5", '.', Cell::Text),
            ("1.5", ',', Cell::Text),
            ("1.234,5", ',', Cell::Text),
            ("", '.', Cell::Missing),
            ("NaN", '.', Cell::Missing),
            ("-", ',', Cell::Missing),
            ("inf", '.', Cell::Text),
            ("1e999", '.', Cell::Text),
            ("3 um", '.', Cell::Text),
        ];
        for (text, decimal, expected) in cases {
            assert_eq!(Cell::read(text, decimal), expected, "{text}");
        }
    }
}
