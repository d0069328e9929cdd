//! Horizontal bars with a name each, in one or more groups.

use std::fmt::Write as _;

use super::axis::Axis;
use super::colour::Colour;
use super::number;
use super::page::Figure;
use super::svg::{Canvas, Mark};

/// Bars from zero; each row is one name, each series one bar in every row.
#[derive(Debug, Clone)]
pub struct Bars {
    axis: Axis,
    rows: Vec<String>,
    series: Vec<(String, Colour, Vec<f64>)>,
    highlighted: Vec<(usize, Colour)>,
    threshold: Option<(String, f64)>,
    caption: String,
}

const BAR: f64 = 13.0;
const BETWEEN_ROWS: f64 = 9.0;

impl Bars {
    /// Empty bars over a linear axis, one row per name.
    pub fn new(axis: Axis, rows: &[String]) -> Bars {
        Bars {
            axis,
            rows: rows.to_vec(),
            series: Vec::new(),
            highlighted: Vec::new(),
            threshold: None,
            caption: String::new(),
        }
    }

    /// Adds a bar to every row; NaN leaves it out.
    pub fn series(mut self, name: &str, colour: Colour, values: &[f64]) -> Bars {
        self.series.push((name.to_owned(), colour, values.to_vec()));
        self
    }

    /// Gives the bars of a row another colour.
    pub fn highlight(mut self, row: usize, colour: Colour) -> Bars {
        self.highlighted.push((row, colour));
        self
    }

    /// A dashed line through all rows at a value.
    pub fn threshold(mut self, name: &str, value: f64) -> Bars {
        self.threshold = Some((name.to_owned(), value));
        self
    }

    /// One sentence that says what it shows.
    pub fn caption(mut self, sentence: &str) -> Bars {
        self.caption = sentence.to_owned();
        self
    }
}

impl Figure for Bars {
    fn svg(&self) -> String {
        let legend: Vec<_> = self
            .series
            .iter()
            .filter(|s| !s.0.is_empty())
            .map(|s| (s.0.clone(), s.1, Mark::Area))
            .chain(
                self.threshold
                    .iter()
                    .map(|t| (t.0.clone(), Colour::Red, Mark::Dashed)),
            )
            .collect();
        let names = self
            .rows
            .iter()
            .map(|r| r.chars().count())
            .max()
            .unwrap_or(0) as f64
            * 6.8
            + 14.0;
        let row = self.series.len() as f64 * BAR + BETWEEN_ROWS;
        let height = 80.0 + row * self.rows.len() as f64;
        let mut canvas = Canvas::new(620.0, height, &legend);
        canvas.widen_left(names);
        let values = self
            .series
            .iter()
            .flat_map(|s| s.2.iter().copied())
            .chain([0.0])
            .chain(self.threshold.iter().map(|t| t.1));
        let scale = self.axis.scale(values);
        let (top, left, width) = (canvas.top, canvas.left, canvas.width);
        let x = |v: f64| left + width * scale.share(v);
        canvas.axis_below(&self.axis, &scale);
        for (i, name) in self.rows.iter().enumerate() {
            let y = top + BETWEEN_ROWS / 2.0 + i as f64 * row;
            canvas.label(
                left - 6.0,
                y + (row - BETWEEN_ROWS) / 2.0 + 4.0,
                "end",
                name,
            );
            for (k, (_, colour, values)) in self.series.iter().enumerate() {
                let Some(value) = values.get(i).copied().filter(|v| v.is_finite()) else {
                    continue;
                };
                let (from, to) = (x(0.0).min(x(value)), x(0.0).max(x(value)));
                let at = y + k as f64 * BAR;
                let colour = self
                    .highlighted
                    .iter()
                    .find(|h| h.0 == i)
                    .map_or(colour, |h| &h.1);
                let _ = write!(
                    canvas.text,
                    r#"<rect x="{from:.1}" y="{at:.1}" width="{:.1}" height="{:.1}" style="fill:{}" fill-opacity="0.8"><title>{}: {}</title></rect>"#,
                    (to - from).max(0.5),
                    BAR - 2.0,
                    colour.css(),
                    super::svg::escape(name),
                    number(value, 4)
                );
            }
        }
        if let Some((_, value)) = &self.threshold {
            let _ = write!(
                canvas.text,
                r#"<line x1="{0:.1}" x2="{0:.1}" y1="{top}" y2="{1:.1}" style="stroke:{2}" stroke-width="1.4" stroke-dasharray="6 4"/>"#,
                x(*value),
                top + row * self.rows.len() as f64,
                Colour::Red.css()
            );
        }
        canvas.finish(&self.caption)
    }

    fn caption(&self) -> &str {
        &self.caption
    }
}
