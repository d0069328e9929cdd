//! Horizontal bars with a name each, in one or more groups.

use std::fmt::Write as _;

use super::axis::Axis;
use super::colour::Colour;
use super::number;
use super::page::Figure;
use super::svg::{Canvas, LEGEND_ROW, Mark, NARROW};

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
/// Height of a name above its bars, and room left of bars that have it there, px.
const NAME: f64 = 15.0;
const NARROW_LEFT: f64 = 10.0;

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

impl Bars {
    /// With the names beside the bars, or on narrow screens above them.
    fn draw(&self, total: f64, names_above: bool) -> String {
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
        let longest = self.rows.iter().map(|r| r.chars().count()).max();
        let names = longest.unwrap_or(0) as f64 * 6.8 + 14.0;
        let name = if names_above { NAME } else { 0.0 };
        let row = self.series.len() as f64 * BAR + BETWEEN_ROWS + name;
        let rows_of_legend = if names_above {
            legend.len() as f64
        } else {
            1.0
        };
        let height = 62.0 + LEGEND_ROW * rows_of_legend + row * self.rows.len() as f64;
        let mut canvas = Canvas::new(total, height, &legend);
        if names_above {
            canvas.narrow_left(NARROW_LEFT);
        } else {
            canvas.widen_left(names);
        }
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
        for (i, text) in self.rows.iter().enumerate() {
            let y = top + BETWEEN_ROWS / 2.0 + i as f64 * row + name;
            if names_above {
                canvas.label(left + 4.0, y - 4.0, "start", text);
            } else {
                let middle = y + (row - BETWEEN_ROWS) / 2.0;
                canvas.label(left - 6.0, middle + 4.0, "end", text);
            }
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
                    super::svg::escape(text),
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
}

impl Figure for Bars {
    fn svg(&self) -> String {
        self.draw(620.0, false)
    }

    fn narrow_svg(&self) -> Option<String> {
        Some(self.draw(NARROW, true))
    }

    fn caption(&self) -> &str {
        &self.caption
    }
}
