//! How a table separates its fields and writes its numbers, found from the lines themselves.

use std::borrow::Cow;

use super::cell::Cell;

/// What stands between fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Delimiter {
    Sign(u8),
    /// Spaces and tabs, any number of them.
    Spaces,
}

/// Delimiter and decimal mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dialect {
    pub delimiter: Delimiter,
    pub decimal: char,
}

const fn of(delimiter: Delimiter, decimal: char) -> Dialect {
    Dialect { delimiter, decimal }
}

/// Those that are tried where campaign.toml states none; of two that fit equally well the first is
/// taken.
const USUAL: [Dialect; 7] = [
    of(Delimiter::Sign(b','), '.'),
    of(Delimiter::Sign(b';'), '.'),
    of(Delimiter::Sign(b';'), ','),
    of(Delimiter::Sign(b'\t'), '.'),
    of(Delimiter::Sign(b'\t'), ','),
    of(Delimiter::Spaces, '.'),
    of(Delimiter::Spaces, ','),
];
/// Lines that are looked at, at most: more of them decide nothing that these do not.
const LOOKED_AT: usize = 4000;

impl Dialect {
    /// The one that makes most lines rows of numbers; with a `stated` delimiter only the decimal
    /// mark is open.
    pub fn find(lines: &[(u64, &str)], stated: Option<u8>) -> Dialect {
        let tried: Vec<Dialect> = match stated {
            None => USUAL.to_vec(),
            Some(sign) => {
                let delimiter = match sign {
                    b' ' => Delimiter::Spaces,
                    sign => Delimiter::Sign(sign),
                };
                let marks = ['.', ',']
                    .into_iter()
                    .filter(|mark| *mark != char::from(sign));
                marks.map(|mark| of(delimiter, mark)).collect()
            }
        };
        let step = lines.len().div_ceil(LOOKED_AT).max(1);
        let looked_at: Vec<&str> = lines.iter().step_by(step).map(|line| line.1).collect();
        let mut best = (tried[0], Fit::default());
        for dialect in tried {
            let fit = Fit::of(dialect, &looked_at);
            if fit.better_than(&best.1) {
                best = (dialect, fit);
            }
        }
        best.0
    }

    /// The fields of a line, without spaces and quotes around them.
    pub fn fields<'a>(&self, line: &'a str) -> Vec<Cow<'a, str>> {
        match self.delimiter {
            Delimiter::Spaces => line.split_whitespace().map(Cow::Borrowed).collect(),
            Delimiter::Sign(sign) if line.contains('"') => quoted(line, sign),
            Delimiter::Sign(sign) => line
                .split(sign as char)
                .map(|field| Cow::Borrowed(field.trim()))
                .collect(),
        }
    }

    /// The fields of a line of names: spaces separate no name from its unit.
    pub fn names(&self, line: &str) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for field in self.fields(line) {
            let is_unit = self.delimiter == Delimiter::Spaces && field.starts_with(['[', '(']);
            match names.last_mut().filter(|_| is_unit) {
                Some(name) => *name += &format!(" {field}"),
                None => names.push(field.into_owned()),
            }
        }
        names
    }

    pub fn cell(&self, field: &str) -> Cell {
        Cell::read(field, self.decimal)
    }

    /// In words; `None` for plain commas and points.
    pub fn words(&self) -> Option<String> {
        let delimiter = match self.delimiter {
            Delimiter::Sign(b',') => return None,
            Delimiter::Sign(b';') => "semicolons".to_owned(),
            Delimiter::Sign(b'\t') => "tabs".to_owned(),
            Delimiter::Sign(sign) => format!("'{}' between fields", sign as char),
            Delimiter::Spaces => "spaces".to_owned(),
        };
        Some(match self.decimal {
            ',' => format!("{delimiter}, decimal commas"),
            _ => delimiter,
        })
    }
}

/// A line with quotes, split as RFC 4180 says.
fn quoted(line: &str, sign: u8) -> Vec<Cow<'static, str>> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(sign)
        .trim(csv::Trim::All)
        .from_reader(line.as_bytes());
    let mut record = csv::StringRecord::new();
    match reader.read_record(&mut record) {
        Ok(true) => record
            .iter()
            .map(|field| Cow::Owned(field.to_owned()))
            .collect(),
        _ => Vec::new(),
    }
}

/// What a line is under a dialect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Line {
    pub fields: usize,
    /// Fields that are numbers.
    pub numbers: usize,
    /// Fields that are neither numbers nor missing samples.
    pub texts: usize,
    /// It begins as a number does.
    pub begins: bool,
}

impl Line {
    pub fn of(dialect: &Dialect, line: &str) -> Line {
        let fields = dialect.fields(line);
        let cells = fields.iter().map(|field| dialect.cell(field));
        let (mut numbers, mut texts) = (0, 0);
        for cell in cells {
            numbers += usize::from(cell.is_number());
            texts += usize::from(cell == Cell::Text);
        }
        Line {
            fields: fields.len(),
            numbers,
            texts,
            begins: line
                .trim_start()
                .trim_start_matches(['+', '-', '.', '"'])
                .starts_with(|c: char| c.is_ascii_digit()),
        }
    }

    /// Numbers and nothing else but missing samples.
    pub fn is_row(&self) -> bool {
        self.numbers > 0 && self.texts == 0
    }
}

/// How well a dialect fits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Fit {
    /// Lines that are rows of numbers, of the most frequent number of fields.
    rows: usize,
    /// The line above the first of them has as many fields, all names.
    headed: bool,
    /// There are several fields.
    several: bool,
    /// Sum over all lines of the share of fields that are numbers: for tables with a column of
    /// texts.
    share: f64,
}

impl Fit {
    fn of(dialect: Dialect, lines: &[&str]) -> Fit {
        let kinds: Vec<Line> = lines.iter().map(|l| Line::of(&dialect, l)).collect();
        let fields = most_frequent(kinds.iter().filter(|k| k.is_row()).map(|k| k.fields));
        let is_one = |kind: &Line| kind.is_row() && Some(kind.fields) == fields;
        let above = kinds.iter().position(is_one).and_then(|i| i.checked_sub(1));
        let headed = above.is_some_and(|i| {
            kinds[i].numbers == 0 && Some(dialect.names(lines[i]).len()) == fields
        });
        let shares = kinds.iter().filter(|k| k.numbers > 1);
        Fit {
            rows: kinds.iter().filter(|k| is_one(k)).count(),
            headed,
            several: fields.is_some_and(|n| n > 1),
            share: shares.map(|k| k.numbers as f64 / k.fields as f64).sum(),
        }
    }

    fn better_than(&self, other: &Fit) -> bool {
        let key = |fit: &Fit| (fit.rows, fit.headed, fit.several);
        (key(self), self.share).partial_cmp(&(key(other), other.share))
            == Some(std::cmp::Ordering::Greater)
    }
}

/// The most frequent of some small numbers, the larger of two that are equally frequent.
pub(super) fn most_frequent(numbers: impl Iterator<Item = usize>) -> Option<usize> {
    let mut counts = std::collections::BTreeMap::new();
    for number in numbers {
        *counts.entry(number).or_insert(0_usize) += 1;
    }
    counts
        .into_iter()
        .max_by_key(|(_, count)| *count)
        .map(|(number, _)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Dialect {
        let lines: Vec<(u64, &str)> = (1..).zip(text.lines()).collect();
        Dialect::find(&lines, None)
    }

    #[test]
    fn delimiter_and_decimal_mark_are_found_together() {
        let cases = [
            ("t,x\n0,1\n1,2", USUAL[0]),
            ("0.5, 1\n1.5, 2", USUAL[0]),
            ("t;x\n0.5;1\n1.5;2", USUAL[1]),
            ("t;x\n0,5;1\n1,5;2", USUAL[2]),
            ("t;x\n0;1\n1;2", USUAL[1]),
            ("t\tx\n0.5\t1\n1.5\t2", USUAL[3]),
            ("t\tx\n0,5\t1\n1,5\t2", USUAL[4]),
            ("t  x\n 0.5  1\n 1.5 -2", USUAL[5]),
            ("t x\n0,5 1\n1,5 2", USUAL[6]),
            ("t;x;n\n0,5;1;ok\n1,5;2;ok", USUAL[2]),
            ("\"t\";\"x\"\n\"0,5\";\"1\"\n\"1,5\";\"2\"", USUAL[2]),
            ("x\n0,5\n1,5\n2,5", USUAL[2]),
        ];
        for (text, expected) in cases {
            assert_eq!(found(text), expected, "{text}");
        }
    }

    #[test]
    fn spaces_separate_no_name_from_its_unit() {
        let names = USUAL[5].names("t [ms]  x (mm)");
        assert_eq!(names, ["t [ms]", "x (mm)"]);
    }
}
