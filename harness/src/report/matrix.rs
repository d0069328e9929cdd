//! A matrix of coloured cells, for values over two parameters.

use plotly::common::{ColorScale, ColorScaleElement, HoverInfo, Mode};
use plotly::layout::{Shape, ShapeLine, ShapeType};
use plotly::{HeatMap, Scatter};

use super::axis::Axis;
use super::colour::Colour;
use super::drawn::Drawn;
use super::layout::layout;
use super::number;
use super::page::Figure;
use super::trace::Traces;

/// A heat map with the value written in each cell.
#[derive(Debug, Clone)]
pub struct Matrix {
    rows: (String, Vec<String>),
    columns: (String, Vec<String>),
    values: Vec<Vec<f64>>,
    marked: Vec<(usize, usize)>,
    caption: String,
    logarithmic: bool,
}

/// px.
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
            logarithmic: false,
        }
    }

    /// Colours by the logarithm of the values, for positive values over decades.
    pub fn logarithmic(mut self) -> Matrix {
        self.logarithmic = true;
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
    /// Colour by depth, 0 to 1, in the orange of the page.
    fn colours() -> ColorScale {
        let depth = |share: f64| Colour::Orange.translucent(0.06 + 0.74 * share);
        ColorScale::Vector([0.0, 1.0].map(|s| ColorScaleElement(s, depth(s))).to_vec())
    }
}

impl Figure for Matrix {
    fn draw(&self, _columns: usize) -> Drawn {
        let depth = |v: &f64| if self.logarithmic { v.log10() } else { *v };
        let places = |names: &[String]| (0..names.len()).map(|i| i as f64).collect::<Vec<f64>>();
        let (x, y) = (places(&self.columns.1), places(&self.rows.1));
        let depths: Vec<Vec<f64>> = self
            .values
            .iter()
            .map(|row| row.iter().map(depth).collect())
            .collect();
        let mut traces = Traces::default();
        traces.list.push(
            HeatMap::new(x.clone(), y.clone(), depths)
                .color_scale(Matrix::colours())
                .show_scale(false)
                .hover_on_gaps(false)
                .x_gap(2)
                .y_gap(2)
                .hover_info(HoverInfo::Skip),
        );
        let finite = |(r, c): &(usize, usize)| self.values[*r][*c].is_finite();
        let cells: Vec<(usize, usize)> = (0..self.values.len())
            .flat_map(|r| (0..self.values[r].len()).map(move |c| (r, c)))
            .filter(finite)
            .collect();
        let of = |pick: &dyn Fn(usize, usize) -> String| {
            cells.iter().map(|(r, c)| pick(*r, *c)).collect::<Vec<_>>()
        };
        traces.list.push(
            Scatter::new(
                cells.iter().map(|c| c.1 as f64).collect(),
                cells.iter().map(|c| c.0 as f64).collect(),
            )
            .name("value")
            .show_legend(false)
            .mode(Mode::Text)
            .text_array(of(&|r, c| short(self.values[r][c])))
            .hover_text_array(of(&|r, c| {
                let (row, column) = (&self.rows, &self.columns);
                let value = number(self.values[r][c], 4);
                format!(
                    "{} {}<br>{} {}<br>{value}",
                    row.0, row.1[r], column.0, column.1[c]
                )
            }))
            .hover_info(HoverInfo::Text),
        );
        let border = |(r, c): &(usize, usize)| {
            let (r, c) = (*r as f64, *c as f64);
            Shape::new()
                .shape_type(ShapeType::Rect)
                .x0(c - 0.48)
                .x1(c + 0.48)
                .y0(r - 0.46)
                .y1(r + 0.46)
                .line(ShapeLine::new().color(Colour::Ink.hex()).width(2.0))
        };
        let axis = |title: &str, axis: &Axis| {
            let scale = axis.scale(std::iter::empty());
            axis.layout(&scale).title(title.to_owned()).show_grid(false)
        };
        let (across, down) = (Axis::places("", &self.columns.1), Axis::rows(&self.rows.1));
        let layout = layout()
            .shapes(self.marked.iter().map(border).collect())
            .x_axis(axis(&self.columns.0, &across))
            .y_axis(axis(&self.rows.0, &down));
        Drawn::new(traces, layout, [&across, &down])
    }

    fn caption(&self) -> &str {
        &self.caption
    }

    fn height(&self) -> f64 {
        80.0 + CELL_HEIGHT * self.rows.1.len() as f64
    }

    fn boxed(&self) -> Box<dyn Figure> {
        Box::new(self.clone())
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
}
