//! A matrix of coloured cells, for values over two parameters.

use std::fmt::Write as _;

use super::number;
use super::page::Figure;
use super::svg::{Canvas, escape};

/// A heat map with the value written in each cell.
#[derive(Debug, Clone)]
pub struct Matrix {
    rows: (String, Vec<String>),
    columns: (String, Vec<String>),
    values: Vec<Vec<f64>>,
    marked: Vec<(usize, usize)>,
    caption: String,
}

const CELL_HEIGHT: f64 = 34.0;

impl Matrix {
    /// `values[row][column]`; NaN leaves the cell empty. The names are those of the two parameters, with unit.
    pub fn new(
        row_name: &str,
        rows: &[String],
        column_name: &str,
        columns: &[String],
        values: Vec<Vec<f64>>,
    ) -> Matrix {
        Matrix {
            rows: (row_name.to_owned(), rows.to_vec()),
            columns: (column_name.to_owned(), columns.to_vec()),
            values,
            marked: Vec::new(),
            caption: String::new(),
        }
    }

    /// Marks a cell with a border, e.g. the runs that were used for fitting.
    pub fn mark(mut self, row: usize, column: usize) -> Matrix {
        self.marked.push((row, column));
        self
    }

    /// One sentence that says what it shows, the quantity and its unit included.
    pub fn caption(mut self, sentence: &str) -> Matrix {
        self.caption = sentence.to_owned();
        self
    }
}

impl Figure for Matrix {
    fn svg(&self) -> String {
        let height = 60.0 + CELL_HEIGHT * self.rows.1.len() as f64;
        let mut canvas = Canvas::new(620.0, height, &[]);
        let (left, top) = (canvas.left + 24.0, canvas.top);
        let width = (canvas.width - 24.0) / self.columns.1.len().max(1) as f64;
        let all = || {
            self.values
                .iter()
                .flatten()
                .copied()
                .filter(|v| v.is_finite())
        };
        let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        for (r, row) in self.values.iter().enumerate() {
            let y = top + r as f64 * CELL_HEIGHT;
            canvas.label(
                left - 6.0,
                y + CELL_HEIGHT / 2.0 + 4.0,
                "end",
                &self.rows.1[r],
            );
            for (c, value) in row.iter().enumerate().filter(|(_, v)| v.is_finite()) {
                let x = left + c as f64 * width;
                let share = if high > low {
                    (value - low) / (high - low)
                } else {
                    0.5
                };
                let border = if self.marked.contains(&(r, c)) {
                    r#" class="marked""#
                } else {
                    ""
                };
                let _ = write!(
                    canvas.text,
                    r#"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}"{border} style="fill:var(--orange)" fill-opacity="{:.2}"/>"#,
                    x + 1.0,
                    y + 1.0,
                    width - 2.0,
                    CELL_HEIGHT - 2.0,
                    0.06 + 0.84 * share
                );
                canvas.label(
                    x + width / 2.0,
                    y + CELL_HEIGHT / 2.0 + 4.0,
                    "middle",
                    &escape(&number(*value, 3)),
                );
            }
        }
        let bottom = top + CELL_HEIGHT * self.rows.1.len() as f64;
        for (c, name) in self.columns.1.iter().enumerate() {
            canvas.label(
                left + (c as f64 + 0.5) * width,
                bottom + 16.0,
                "middle",
                name,
            );
        }
        canvas.label(
            left + width * self.columns.1.len() as f64 / 2.0,
            bottom + 38.0,
            "middle",
            &self.columns.0,
        );
        canvas.upright(
            14.0,
            top + CELL_HEIGHT * self.rows.1.len() as f64 / 2.0,
            &self.rows.0,
        );
        canvas.finish(&self.caption)
    }

    fn caption(&self) -> &str {
        &self.caption
    }
}
