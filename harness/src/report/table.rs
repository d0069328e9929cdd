//! Tables of text and numbers.

use maud::{Markup, html};

/// One cell.
#[derive(Debug, Clone)]
pub enum Cell {
    /// Words, left-aligned.
    Text(String),
    /// A number as it shall read, right-aligned.
    Number(String),
    /// A number that needs attention.
    Alert(String),
}

/// A table with a header; units belong into the header or the cells.
#[derive(Debug, Clone, Default)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// An empty table with these columns.
    pub fn new(header: &[&str]) -> Table {
        Table {
            header: header.iter().map(|h| (*h).to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row with one cell per column.
    pub fn row(mut self, cells: Vec<Cell>) -> Table {
        self.rows.push(cells);
        self
    }

    pub(super) fn html(&self) -> Markup {
        html! {
            div.table tabindex="0" { table {
                thead { tr { @for name in &self.header { th { (name) } } } }
                tbody { @for row in &self.rows { tr { @for cell in row {
                    @match cell {
                        Cell::Text(text) => td { (text) },
                        Cell::Number(text) => td.number { (text) },
                        Cell::Alert(text) => td.number.alert { (text) },
                    }
                } } } }
            } }
        }
    }
}
