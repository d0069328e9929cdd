//! Horizontal bars with a name each, in one or more groups.

use plotly::Bar;
use plotly::common::{HoverInfo, Marker, Orientation};
use plotly::layout::BarMode;

use super::axis::Axis;
use super::colour::Colour;
use super::drawn::Drawn;
use super::layer::{Layer, Shape};
use super::layout::{edge_to_edge, layout};
use super::number;
use super::page::Figure;
use super::trace::{Frame, Traces};

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

/// Height of a bar and of the room between two rows, px.
const BAR: f64 = 15.0;
const BETWEEN_ROWS: f64 = 10.0;

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
    fn draw(&self, _columns: usize) -> Drawn {
        let values = self
            .series
            .iter()
            .flat_map(|s| s.2.iter().copied())
            .chain([0.0])
            .chain(self.threshold.iter().map(|t| t.1));
        let scale = self.axis.scale(values);
        let mut traces = Traces::default();
        for (name, colour, values) in &self.series {
            let paint = |row: usize| {
                let own = self.highlighted.iter().find(|h| h.0 == row);
                own.map_or(*colour, |h| h.1).hex()
            };
            let lengths = values
                .iter()
                .map(|v| self.axis.coordinate(*v, &scale))
                .collect();
            let rows: Vec<f64> = (0..values.len()).map(|r| r as f64).collect();
            let texts = values.iter().zip(&self.rows).map(|(v, row)| {
                format!(
                    "{row}<br>{} {} {}",
                    self.axis.quantity(),
                    number(*v, 4),
                    self.axis.unit
                )
            });
            let bar = Bar::new(lengths, rows)
                .orientation(Orientation::Horizontal)
                .name(if name.is_empty() { " " } else { name })
                .show_legend(!name.is_empty())
                .marker(
                    Marker::new()
                        .color_array((0..values.len()).map(paint).collect())
                        .opacity(0.85),
                )
                .hover_text_array(texts.collect())
                .hover_info(HoverInfo::Text);
            traces.list.push(bar);
        }
        let rows = Axis::rows(&self.rows);
        let places = rows.scale(std::iter::empty());
        if let Some((name, value)) = &self.threshold {
            let frame = Frame {
                x: (&self.axis, scale),
                y: (&rows, places),
                columns: 1,
            };
            frame.add(
                &Layer {
                    name: name.clone(),
                    colour: Colour::Red,
                    shape: Shape::Upright(*value),
                },
                &mut traces,
            );
        }
        let layout = layout()
            .bar_mode(BarMode::Group)
            .bar_gap(0.3)
            .x_axis(self.axis.layout(&scale))
            .y_axis(rows.layout(&places).show_grid(false))
            .y_axis2(edge_to_edge("y"));
        Drawn::new(traces, layout, [&self.axis, &rows])
    }

    fn caption(&self) -> &str {
        &self.caption
    }

    fn height(&self) -> f64 {
        let row = self.series.len() as f64 * BAR + BETWEEN_ROWS;
        90.0 + row * self.rows.len() as f64
    }

    fn boxed(&self) -> Box<dyn Figure> {
        Box::new(self.clone())
    }
}
