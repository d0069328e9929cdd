//! A matrix of coloured cells, for values over two parameters.

use std::fmt::Write as _;

use super::number;
use super::page::Figure;
use super::svg::{Canvas, NARROW, escape};

/// A heat map with the value written in each cell.
#[derive(Debug, Clone)]
pub struct Matrix {
    rows: (String, Vec<String>),
    columns: (String, Vec<String>),
    values: Vec<Vec<f64>>,
    marked: Vec<(usize, usize)>,
    caption: String,
    logarithmic: bool,
    width: f64,
}

const CELL_HEIGHT: f64 = 34.0;
/// Room left of the cells beside that of every picture, px.
const NAMES: f64 = 24.0;
/// Width in px that a number needs.
const NUMBER: f64 = 32.0;

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
            logarithmic: false,
            width: 620.0,
        }
    }

    /// Colours by the logarithm of the values, for positive values over decades.
    pub fn logarithmic(mut self) -> Matrix {
        self.logarithmic = true;
        self
    }

    /// Width in px at full width; it scales with the page.
    pub fn width(mut self, width: f64) -> Matrix {
        self.width = width;
        self
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

/// Three digits, and thousands as `k`, so that it fits into a cell.
fn short(value: f64) -> String {
    match value.abs() {
        v if (9999.5..1e6).contains(&v) => format!("{:.0}k", value / 1e3),
        _ => number(value, 3),
    }
}

impl Matrix {
    fn draw(&self, total: f64) -> String {
        let height = 60.0 + CELL_HEIGHT * self.rows.1.len() as f64;
        let mut canvas = Canvas::new(total, height, &[]);
        let (left, top) = (canvas.left + NAMES, canvas.top);
        let width = (canvas.width - NAMES) / self.columns.1.len().max(1) as f64;
        let depth = |v: f64| if self.logarithmic { v.ln() } else { v };
        let all = || {
            let values = self.values.iter().flatten().map(|v| depth(*v));
            values.filter(|v| v.is_finite())
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
                    ((depth(*value) - low) / (high - low)).clamp(0.0, 1.0)
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
                    &escape(&short(*value)),
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
}

impl Figure for Matrix {
    fn svg(&self) -> String {
        self.draw(self.width)
    }

    fn narrow_svg(&self) -> Option<String> {
        let canvas = Canvas::new(NARROW, CELL_HEIGHT, &[]);
        let room = (canvas.width - NAMES) / self.columns.1.len().max(1) as f64;
        let longest = self.columns.1.iter().map(|c| c.chars().count()).max();
        let fits = room >= NUMBER && 6.2 * longest.unwrap_or(0) as f64 <= room;
        fits.then(|| self.draw(NARROW))
    }

    fn caption(&self) -> &str {
        &self.caption
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fit_into_cells() {
        let shown = [1.0, 0.0333, 281.0, 9999.0, 17_766.0].map(short);
        assert_eq!(shown, ["1", "0.0333", "281", "9999", "18k"]);
    }

    #[test]
    fn a_matrix_is_laid_out_for_phones_where_its_columns_fit() {
        let of = |columns: usize, name: &str| {
            let names = vec![name.to_owned(); columns];
            Matrix::new("a", &["1".into()], "b", &names, vec![vec![1.0; columns]])
        };
        assert!(of(7, "0.1").narrow_svg().is_some());
        assert!(of(12, "0.1").narrow_svg().is_none());
        assert!(of(7, "a long name").narrow_svg().is_none());
    }
}
