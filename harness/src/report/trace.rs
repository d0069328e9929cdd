//! The layers of a plot as traces of Plotly.

use plotly::common::{
    DashType, ErrorData, ErrorType, Fill, HoverInfo, Line, Marker, Mode, Position,
};
use plotly::{Scatter, Trace};

use super::axis::{Axis, Scale};
use super::colour::Colour;
use super::layer::{Layer, Shape};
use super::layout::area;
use super::number;
use super::thinning::{Point, kept, one_per_cell};

/// Two axes and how finely they are resolved.
pub(super) struct Frame<'a> {
    pub x: (&'a Axis, Scale),
    pub y: (&'a Axis, Scale),
    /// Columns of the picture: each keeps its lowest and its highest point.
    pub columns: usize,
}

/// Traces, and how many points of how many they show.
#[derive(Default)]
pub(super) struct Traces {
    pub list: Vec<Box<dyn Trace>>,
    pub shown: usize,
    pub given: usize,
}

type Curve = Box<Scatter<f64, f64>>;

impl Frame<'_> {
    fn cells(&self, points: &[(f64, f64)]) -> Vec<Point> {
        let (columns, rows) = (self.columns as f64, 0.5 * self.columns as f64);
        let cell = |p: &(f64, f64)| (columns * self.x.1.share(p.0), rows * self.y.1.share(p.1));
        points.iter().map(cell).collect()
    }

    /// A trace through points; between runs it is interrupted.
    fn curve(&self, points: &[(f64, f64)], runs: &[Vec<usize>]) -> Curve {
        let (mut x, mut y, mut data) = (Vec::new(), Vec::new(), Vec::new());
        let symlog = [self.x.0.is_symlog(), self.y.0.is_symlog()];
        for (n, run) in runs.iter().enumerate() {
            if n > 0 {
                for list in [&mut x, &mut y, &mut data] {
                    list.push(f64::NAN);
                }
            }
            for p in run.iter().map(|i| points[*i]) {
                x.push(self.x.0.coordinate(p.0));
                y.push(self.y.0.coordinate(p.1));
                data.push(if symlog[0] { p.0 } else { p.1 });
            }
        }
        let trace = Scatter::new(x, y).hover_template(self.hover());
        if symlog.contains(&true) {
            trace.custom_data(data)
        } else {
            trace
        }
    }

    fn hover(&self) -> String {
        let lines = [self.x.0.hover("x"), self.y.0.hover("y")];
        lines.join("<br>")
    }

    pub fn add(&self, layer: &Layer, traces: &mut Traces) {
        let (name, hex) = (layer.name.as_str(), layer.colour.hex());
        let list = &mut traces.list;
        let mut push = |trace: Curve| list.push(named(trace, name));
        match &layer.shape {
            Shape::Line {
                points,
                dashed,
                width,
            } => {
                let runs = kept(&self.cells(points)).runs;
                traces.given += points.len();
                traces.shown += runs.iter().map(Vec::len).sum::<usize>();
                push(self.curve(points, &runs).mode(Mode::Lines).line(stroke(
                    layer.colour,
                    *width,
                    *dashed,
                )));
            }
            Shape::Points(points) => {
                let all = vec![(0..points.len()).collect()];
                push(
                    self.curve(points, &all)
                        .mode(Mode::Markers)
                        .marker(Marker::new().color(hex).size(7)),
                );
            }
            Shape::Cloud(points) => {
                // Cells of three columns: a point of a cloud is that wide.
                let coarse: Vec<Point> = self
                    .cells(points)
                    .iter()
                    .map(|p| (p.0 / 3.0, p.1 / 3.0))
                    .collect();
                let shown = one_per_cell(&coarse);
                traces.given += points.len();
                traces.shown += shown.len();
                let marker = Marker::new().color(hex).size(4).opacity(0.6);
                push(
                    self.curve(points, &[shown])
                        .mode(Mode::Markers)
                        .marker(marker),
                );
            }
            Shape::Band(band) => {
                let finite = band
                    .iter()
                    .filter(|p| p.0.is_finite() && p.1.is_finite() && p.2.is_finite());
                let band: Vec<_> = finite.copied().collect();
                let edge = |of: fn(&(f64, f64, f64)) -> f64| -> Curve {
                    let points: Vec<(f64, f64)> = band.iter().map(|p| (p.0, of(p))).collect();
                    let runs = kept(&self.cells(&points)).runs;
                    self.curve(&points, &runs)
                        .mode(Mode::Lines)
                        .legend_group(format!("{name} {hex}"))
                        .line(stroke(layer.colour, 0.0, false))
                };
                let low = edge(|p| p.1)
                    .name(format!("{name}, low"))
                    .show_legend(false);
                let high = edge(|p| p.2)
                    .fill(Fill::ToNextY)
                    .fill_color(area(layer.colour, 0.22));
                list.extend([low as Box<dyn Trace>, named(high, name)]);
            }
            Shape::Shade(intervals) => {
                let (mut x, mut y) = (Vec::new(), Vec::new());
                for (from, to) in intervals {
                    let (from, to) = (self.x.0.coordinate(*from), self.x.0.coordinate(*to));
                    x.extend([from, from, to, to, f64::NAN]);
                    y.extend([0.0, 1.0, 1.0, 0.0, f64::NAN]);
                }
                push(
                    Scatter::new(x, y)
                        .y_axis("y2")
                        .mode(Mode::Lines)
                        .line(stroke(layer.colour, 0.0, false))
                        .fill(Fill::ToSelf)
                        .fill_color(area(layer.colour, 0.16))
                        .hover_info(HoverInfo::Skip),
                );
            }
            Shape::Level(value) => {
                let along: Vec<f64> = (0..=40).map(|i| f64::from(i) / 40.0).collect();
                let at = vec![self.y.0.coordinate(*value); along.len()];
                push(
                    Scatter::new(along, at)
                        .x_axis("x2")
                        .mode(Mode::Lines)
                        .line(stroke(layer.colour, 1.2, true))
                        .hover_template(self.edge_hover(self.y.0, "y", *value)),
                );
            }
            Shape::Upright(value) => {
                let up: Vec<f64> = (0..=40).map(|i| f64::from(i) / 40.0).collect();
                let at = vec![self.x.0.coordinate(*value); up.len()];
                push(
                    Scatter::new(at, up)
                        .y_axis("y2")
                        .mode(Mode::Lines)
                        .line(stroke(layer.colour, 1.2, true))
                        .hover_template(self.edge_hover(self.x.0, "x", *value)),
                );
            }
            Shape::Intervals(all) => {
                let all: Vec<_> = all.iter().filter(|i| i.1.is_finite()).collect();
                let points: Vec<(f64, f64)> = all.iter().map(|i| (i.1, i.0)).collect();
                let reach = |end: f64, middle: f64| {
                    let ends = [end, middle].map(|v| self.x.0.coordinate(v));
                    let reach = (ends[0] - ends[1]).abs();
                    if reach.is_finite() { reach } else { 0.0 }
                };
                let whole = |i: &&(f64, f64, f64, f64)| i.2.is_finite() && i.3.is_finite();
                let up = all
                    .iter()
                    .map(|i| if whole(i) { reach(i.3, i.1) } else { 0.0 })
                    .collect();
                let down = all
                    .iter()
                    .map(|i| if whole(i) { reach(i.2, i.1) } else { 0.0 })
                    .collect();
                let texts = all.iter().map(|i| {
                    let range = if whole(i) {
                        format!(" ({} to {})", number(i.2, 4), number(i.3, 4))
                    } else {
                        String::new()
                    };
                    format!("{}{range} {}", number(i.1, 4), self.x.0.unit)
                });
                let quantity = self.x.0.quantity();
                let hover = format!("%{{y}}<br>{quantity} %{{text}}");
                let runs = vec![(0..points.len()).collect()];
                push(
                    self.curve(&points, &runs)
                        .mode(Mode::Markers)
                        .marker(Marker::new().color(hex).size(8))
                        .text_array(texts.collect())
                        .hover_template(hover)
                        .error_x(
                            ErrorData::new(ErrorType::Data)
                                .symmetric(false)
                                .array(up)
                                .array_minus(down)
                                .color(hex)
                                .thickness(1.6)
                                .width(4),
                        ),
                );
            }
            Shape::Notes(notes) => {
                let points: Vec<(f64, f64)> = notes.iter().map(|n| n.0).collect();
                let runs = vec![(0..points.len()).collect()];
                let texts: Vec<String> = notes.iter().map(|n| n.1.clone()).collect();
                push(
                    self.curve(&points, &runs)
                        .mode(Mode::Text)
                        .text_array(texts)
                        .text_position(Position::TopRight)
                        .hover_info(HoverInfo::Skip),
                );
            }
        }
    }

    fn edge_hover(&self, axis: &Axis, field: &str, value: f64) -> String {
        // What reaches from edge to edge has one coordinate to tell, and on a symmetric logarithmic axis no data of its own.
        let text = axis.hover(field);
        text.replace("%{customdata:.4~g}", &number(value, 4))
    }
}

/// With its name in the legend; without one it stays out.
fn named(trace: Curve, name: &str) -> Curve {
    if name.is_empty() {
        trace.show_legend(false).name(" ")
    } else {
        trace.name(name).show_legend(true)
    }
}

fn stroke(colour: Colour, width: f64, dashed: bool) -> Line {
    let line = Line::new().color(colour.hex()).width(width);
    if dashed {
        line.dash(DashType::Dash)
    } else {
        line
    }
}
