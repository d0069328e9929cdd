//! The names and units above a table's rows.

use super::cell::Cell;
use super::dialect::Dialect;
use super::lines::Place;
use super::unit::{self, Name, Quantity};

/// Names and units above the rows.
pub(super) struct Header {
    pub names: Option<Vec<Name>>,
    /// Lines that it takes, comments not counted.
    pub lines: usize,
    pub remark: Option<&'static str>,
}

impl Header {
    pub fn find(
        text: &str,
        dialect: &Dialect,
        (fields, trailing): (usize, bool),
        above: &[Place],
        comment: Option<&Place>,
    ) -> Header {
        let names = |place: &Place| {
            let line = &text[place.range.clone()];
            let line = line.trim_start().trim_start_matches(['#', '%', '/', ';']);
            let names = fitted(dialect.names(line), fields, trailing)?;
            let is_name = |n: &String| !dialect.cell(n).is_number();
            names.iter().all(is_name).then_some(names)
        };
        let Some(last) = above.last().and_then(names) else {
            let of_comment = comment.and_then(names);
            let remark = of_comment.is_some().then_some("header in a comment");
            return Header {
                names: of_comment.map(|n| n.iter().map(|n| Name::read(n)).collect()),
                lines: 0,
                remark,
            };
        };
        let before = above.len().checked_sub(2).map(|i| &above[i]);
        match before.and_then(names).filter(|_| is_units(&last)) {
            None => Header {
                names: Some(last.iter().map(|n| Name::read(n)).collect()),
                lines: 1,
                remark: None,
            },
            Some(titles) => {
                let with_unit = |(title, cell): (&String, &String)| {
                    let mut name = Name::read(title);
                    name.unit = name.unit.or_else(|| unit::of_cell(cell));
                    name.strange = name.strange.filter(|_| name.unit.is_none());
                    name
                };
                Header {
                    names: Some(titles.iter().zip(&last).map(with_unit).collect()),
                    lines: 2,
                    remark: Some("row of units"),
                }
            }
        }
    }
}

/// A line of names with as many fields as the rows have. A delimiter behind the last counts for
/// nothing, in rows (`trailing`) as in names.
fn fitted(mut names: Vec<String>, fields: usize, trailing: bool) -> Option<Vec<String>> {
    if names.len() == fields + 1 && names.last().is_some_and(String::is_empty) {
        names.pop();
    }
    if trailing && names.len() + 1 == fields {
        names.push(String::new());
    }
    (names.len() == fields).then_some(names)
}

/// Whether a line's cells are units, at least one of a time or a length.
fn is_units(cells: &[String]) -> bool {
    let known = cells.iter().map(|cell| unit::of_cell(cell));
    let fits = |(cell, unit): (&String, Option<unit::Unit>)| {
        unit.is_some() || matches!(Cell::read(cell, '.'), Cell::Missing)
    };
    let of_motion = |unit: unit::Unit| {
        matches!(
            unit.quantity,
            Quantity::Time | Quantity::Length | Quantity::Velocity | Quantity::Acceleration
        )
    };
    cells.iter().zip(known.clone()).all(fits) && known.flatten().any(of_motion)
}
