//! A text file as a table: what is comment, where the rows begin, what the columns are called.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::cell::Cell;
use super::dialect::{Delimiter, Dialect, Line, most_frequent};
use super::encoding;
use super::header::Header;
use super::lines::{Lines, Place};
use super::unit::Name;
use crate::error::Error;

/// A table.
pub(super) struct Table {
    path: PathBuf,
    text: String,
    dialect: Dialect,
    /// One per column; `column1`, ... without a header, `value` for a single one.
    pub names: Vec<Name>,
    /// Line of the header, counted from 1; of the first row without one.
    pub header_line: u64,
    /// Whether there is a header.
    pub has_header: bool,
    /// Line and number of fields of what should be the header and is not.
    unfit: Option<(u64, usize)>,
    /// Each row's line, counted from 1, and its place in the text.
    rows: Vec<(u64, Range<usize>)>,
    /// What differs from plain CSV in UTF-8, in words.
    pub differs: Vec<String>,
}

/// Lines between two blocks of rows that may be broken rows; more is another table.
const BROKEN: usize = 3;

/// What a table's lines must have in common.
const ALIKE: &str = "; every line needs as many fields as the header";

impl Table {
    /// Reads a file. Lines that begin with `#`, `%`, `//` or `;` are comments. The table is the
    /// longest block of rows of numbers with the same number of fields; what stands above it is
    /// header, what stands below must belong to it.
    ///
    /// # Errors
    /// [`Error`] where the file can't be read or has no row of numbers.
    pub fn read(path: &Path, delimiter: Option<u8>) -> Result<Table, Error> {
        let bytes = std::fs::read(path).map_err(Error::read(path))?;
        let decoded = encoding::decode(&bytes);
        let text = decoded.content;
        let Lines {
            filled: lines,
            empty,
            comments,
        } = Lines::of(&text);
        let line = |place: &Place| &text[place.range.clone()];
        let numbered: Vec<(u64, &str)> = lines.iter().map(|p| (p.line, line(p))).collect();
        let dialect = Dialect::find(&numbered, delimiter);
        let kinds: Vec<Line> = numbered.iter().map(|l| Line::of(&dialect, l.1)).collect();
        let Some((start, fields)) = beginning(&kinds) else {
            return Err(no_rows(path, &numbered));
        };
        let trailing = dialect
            .fields(numbered[start].1)
            .last()
            .is_some_and(|field| field.is_empty());
        let above = &lines[..start];
        let comment = comments.iter().rev().find(|c| {
            let after = above.last().map_or(0, |last| last.line);
            c.line > after && c.line < lines[start].line
        });
        let header = Header::find(&text, &dialect, (fields, trailing), above, comment);
        let mut differs: Vec<String> = decoded.encoding.into_iter().map(str::to_owned).collect();
        differs.extend(dialect.words());
        let title = header.lines;
        if start > title {
            differs.push(format!("table from line {}", lines[start - title].line));
        }
        differs.extend(header.remark.map(str::to_owned));
        let unfit = (above.last().filter(|_| header.names.is_none()))
            .map(|place| (place.line, dialect.names(line(place)).len()))
            .filter(|(_, names)| *names > 1);
        let has_header = header.names.is_some();
        let names = header.names.unwrap_or_else(|| match fields {
            1 => vec![Name::read("value")],
            _ => (1..=fields)
                .map(|i| Name::read(&format!("column{i}")))
                .collect(),
        });
        let header_line = if has_header && title > 0 {
            lines[start - title].line
        } else {
            lines[start].line
        };
        let mut rows: Vec<(u64, Range<usize>)> = lines[start..].iter().map(Place::pair).collect();
        if fields == 1 {
            // In a single column an empty line between others is a missing sample.
            let within = rows[0].0..rows[rows.len() - 1].0;
            rows.extend(
                empty
                    .iter()
                    .filter(|p| within.contains(&p.line))
                    .map(Place::pair),
            );
            rows.sort_by_key(|row| row.0);
        }
        Ok(Table {
            path: path.to_owned(),
            rows,
            dialect,
            names,
            header_line,
            has_header,
            unfit,
            differs,
            text,
        })
    }

    /// What to say where a column is not found: that the header does not fit the rows, where it
    /// does not; else `error`.
    pub fn lacks(&self, error: Error) -> Error {
        match self.unfit {
            Some((line, found)) => Error::CsvRecord {
                path: self.path.clone(),
                line,
                problem: format!(
                    "{found} names above rows of {} fields; name each column{ALIKE}",
                    self.names.len()
                ),
            },
            None => error,
        }
    }

    /// Line of each row, counted from 1.
    pub fn lines(&self) -> impl Iterator<Item = u64> {
        self.rows.iter().map(|row| row.0)
    }

    /// The numbers of some columns, row by row; NaN where a sample is missing.
    ///
    /// # Errors
    /// A row with another number of fields, a text among the numbers, a column without a single
    /// number.
    pub fn columns<const N: usize>(&self, columns: [usize; N]) -> Result<[Vec<f64>; N], Error> {
        let mut values: [Vec<f64>; N] =
            std::array::from_fn(|_| Vec::with_capacity(self.rows.len()));
        for (line, range) in &self.rows {
            let text = &self.text[range.clone()];
            let mut fields = self.dialect.fields(text);
            if fields.is_empty() {
                fields.push("".into());
            }
            // A delimiter behind the last field is no further field.
            if fields.len() == self.names.len() + 1 && fields.last().is_some_and(|f| f.is_empty()) {
                fields.pop();
            }
            if fields.len() != self.names.len() {
                return Err(self.unequal(*line, text, fields.len()));
            }
            for (values, column) in values.iter_mut().zip(columns) {
                values.push(match self.dialect.cell(&fields[column]) {
                    Cell::Number(value) => value,
                    Cell::Missing => f64::NAN,
                    Cell::Text => return Err(self.not_a_number(*line, column, &fields[column])),
                });
            }
        }
        for (values, column) in values.iter().zip(columns) {
            if values.iter().all(|value| value.is_nan()) {
                return Err(Error::EmptyColumn {
                    path: self.path.clone(),
                    line: self.header_line,
                    column: self.names[column].full.clone(),
                    rows: values.len(),
                });
            }
        }
        Ok(values)
    }

    fn not_a_number(&self, line: u64, column: usize, text: &str) -> Error {
        let other = match self.dialect.decimal {
            '.' => ',',
            _ => '.',
        };
        let remedy = if Cell::read(text, other).is_number() {
            format!(
                "other rows have '{}' as decimal mark, write one throughout",
                self.dialect.decimal
            )
        } else {
            "leave the field empty (a missing sample is allowed) or repair the value".to_owned()
        };
        Error::NotANumber {
            path: self.path.clone(),
            line,
            column: self.names[column].full.clone(),
            value: text.to_owned(),
            remedy,
        }
    }

    fn unequal(&self, line: u64, text: &str, found: usize) -> Error {
        let expected = self.names.len();
        let whole = if self.has_header {
            "the header has"
        } else {
            "other rows have"
        };
        let is_last = self.rows.last().is_some_and(|last| last.0 == line);
        let other_delimiter = [b',', b';', b'\t'].into_iter().find(|sign| {
            let dialect = Dialect {
                delimiter: Delimiter::Sign(*sign),
                decimal: self.dialect.decimal,
            };
            let kind = Line::of(&dialect, text);
            Delimiter::Sign(*sign) != self.dialect.delimiter
                && kind.fields == expected
                && kind.is_row()
        });
        let reason = if let Some(sign) = other_delimiter {
            format!(
                "; here {:?} separates them, elsewhere {}",
                sign as char,
                self.dialect.words().map_or("','".to_owned(), |words| words
                    .replace(", decimal", " with decimal"))
            )
        } else if is_last && found < expected {
            "; the file is cut off there, copy it again or delete the line".to_owned()
        } else {
            String::new()
        };
        Error::CsvRecord {
            path: self.path.clone(),
            line,
            problem: format!("{found} fields where {whole} {expected}{reason}{ALIKE}"),
        }
    }
}

/// Index of the first row and the number of fields, of the longest block of rows that are alike.
fn beginning(kinds: &[Line]) -> Option<(usize, usize)> {
    let strict = most_frequent(kinds.iter().filter(|k| k.is_row()).map(|k| k.fields));
    let with_texts = || {
        let some = kinds.iter().filter(|k| k.numbers > 1);
        most_frequent(some.map(|k| k.fields))
    };
    let (fields, texts_allowed) = match strict {
        Some(fields) => (fields, false),
        None => (with_texts()?, true),
    };
    let is_row =
        |kind: &Line| kind.fields == fields && (kind.is_row() || texts_allowed && kind.numbers > 1);
    let mut blocks: Vec<Range<usize>> = Vec::new();
    let mut first = 0;
    for block in kinds.chunk_by(|a, b| is_row(a) == is_row(b)) {
        if is_row(&block[0]) {
            blocks.push(first..first + block.len());
        }
        first += block.len();
    }
    // Broken rows do not end a table: a block is joined with the one before if all between begin as
    // rows do.
    let mut joined: Vec<Range<usize>> = Vec::new();
    for block in blocks {
        match joined.last_mut() {
            Some(last)
                if block.start - last.end <= BROKEN
                    && kinds[last.end..block.start]
                        .iter()
                        .all(|k| k.begins || k.texts == 0) =>
            {
                last.end = block.end;
            }
            _ => joined.push(block),
        }
    }
    let longest = joined.into_iter().max_by_key(ExactSizeIterator::len)?;
    // Nor do they begin one late: what begins with a number between the names and the first whole
    // row is a broken row.
    let broken = kinds[..longest.start]
        .iter()
        .rev()
        .take_while(|kind| kind.begins)
        .count();
    let names = longest.start.checked_sub(broken + 1);
    let is_header = names.is_some_and(|i| kinds[i].fields == fields && kinds[i].numbers == 0);
    let start = if broken <= BROKEN && is_header {
        longest.start - broken
    } else {
        longest.start
    };
    Some((start, fields))
}

fn no_rows(path: &Path, lines: &[(u64, &str)]) -> Error {
    match lines.get(1).or(lines.first()) {
        Some((line, text)) if lines.len() > 1 => Error::NoTable {
            path: path.to_owned(),
            line: *line,
            text: text.trim().chars().take(60).collect(),
        },
        _ => Error::TooFewSamples {
            path: path.to_owned(),
            samples: 0,
            needed: super::run_file::FEWEST_SAMPLES,
        },
    }
}
