//! The layers of a plot as traces of Plotly.

use plotly::common::{
    DashType, ErrorData, ErrorType, Fill, HoverInfo, Line, Marker, Mode, Position,
};
use plotly::{Scatter, Trace};

use super::axis::{Axis, Scale};
use super::colour::Colour;
use super::layer::{Layer, Shape};
use super::number;
use super::thinning::{Point, is_finite, kept, one_per_cell};

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
type Runs = Vec<Vec<usize>>;

impl Traces {
    /// Adds a trace with its name in the legend; without one it stays out.
    fn push(&mut self, name: &str, trace: Curve) {
        self.list.push(if name.is_empty() {
            trace.show_legend(false).name(" ")
        } else {
            trace.name(name).show_legend(true)
        });
    }

    fn count(&mut self, given: &[Point], runs: &Runs) {
        self.given += given.iter().filter(|p| is_finite(p)).count();
        self.shown += runs.iter().map(Vec::len).sum::<usize>();
    }
}

impl Frame<'_> {
    /// Adds what shows a layer.
    pub fn add(&self, layer: &Layer, traces: &mut Traces) {
        let (name, colour) = (layer.name.as_str(), layer.colour);
        match &layer.shape {
            Shape::Line {
                points,
                dashed,
                width,
            } => {
                let cells = self.cells(points, 1.0);
                let runs = kept(&cells, self.columns).runs;
                traces.count(&cells, &runs);
                let line = self.curve(points, &runs).mode(Mode::Lines);
                traces.push(name, line.line(stroke(colour, width.max(1.1), *dashed)));
            }
            Shape::Points(points) => {
                let points = self.curve(points, &all(points)).mode(Mode::Markers);
                traces.push(
                    name,
                    points.marker(Marker::new().color(colour.hex()).size(7)),
                );
            }
            Shape::Cloud(points) => {
                // A point of a cloud is three columns wide.
                let cells = self.cells(points, 1.0 / 3.0);
                let runs = vec![one_per_cell(&cells, self.columns)];
                traces.count(&cells, &runs);
                let marker = Marker::new().color(colour.hex()).size(4).opacity(0.6);
                let cloud = self.curve(points, &runs).mode(Mode::Markers);
                traces.push(name, cloud.marker(marker));
            }
            Shape::Band(band) => {
                let [low, high] = self.band(band, colour).map(|edge| {
                    // One entry of the legend shows and hides both.
                    edge.legend_group(format!("{name} {}", colour.hex()))
                });
                let low = low.name(format!("{name}, low")).show_legend(false);
                traces.list.push(low);
                let fill = high.fill(Fill::ToNextY);
                traces.push(name, fill.fill_color(colour.translucent(0.22)));
            }
            Shape::Shade(intervals) => traces.push(name, self.shade(intervals, colour)),
            Shape::Level(value) => {
                let line = edge_to_edge(self.y.0.coordinate(*value, &self.y.1));
                let trace = Scatter::new(line.0, line.1).x_axis("x2");
                let hover = self.y.0.hover_of("y", &number(*value, 4));
                traces.push(name, across(trace, colour, hover));
            }
            Shape::Upright(value) => {
                let line = edge_to_edge(self.x.0.coordinate(*value, &self.x.1));
                let trace = Scatter::new(line.1, line.0).y_axis("y2");
                let hover = self.x.0.hover_of("x", &number(*value, 4));
                traces.push(name, across(trace, colour, hover));
            }
            Shape::Intervals(intervals) => traces.push(name, self.intervals(intervals, colour)),
            Shape::Notes(notes) => {
                let points: Vec<(f64, f64)> = notes.iter().map(|n| n.0).collect();
                // Plotly centres texts on points unless told otherwise, and leaves no room beside them.
                let texts = notes.iter().map(|n| format!("\u{2002}{}", n.1)).collect();
                let trace = self.curve(&points, &all(&points)).mode(Mode::Text);
                let trace = trace.text_array(texts).text_position(Position::TopRight);
                traces.push(name, trace.hover_info(HoverInfo::Skip));
            }
        }
    }

    /// Points in cells of the picture, `size` cells a column.
    fn cells(&self, points: &[(f64, f64)], size: f64) -> Vec<Point> {
        let columns = size * self.columns as f64;
        let cell = |p: &(f64, f64)| {
            let (x, y) = (self.x.1.share(p.0), self.y.1.share(p.1));
            (columns * x, 0.5 * columns * y)
        };
        points.iter().map(cell).collect()
    }

    /// A trace through points; between runs it is interrupted.
    fn curve(&self, points: &[(f64, f64)], runs: &Runs) -> Curve {
        let (mut x, mut y, mut values) = (Vec::new(), Vec::new(), Vec::new());
        let symlog = [self.x.0.is_symlog(), self.y.0.is_symlog()];
        for (n, run) in runs.iter().enumerate() {
            if n > 0 {
                for list in [&mut x, &mut y, &mut values] {
                    list.push(f64::NAN);
                }
            }
            for p in run.iter().map(|i| points[*i]) {
                x.push(self.x.0.coordinate(p.0, &self.x.1));
                y.push(self.y.0.coordinate(p.1, &self.y.1));
                values.push(if symlog[0] { p.0 } else { p.1 });
            }
        }
        let hover = [self.x.0.hover("x"), self.y.0.hover("y")].join("<br>");
        let trace = Scatter::new(x, y).hover_template(hover);
        if symlog.contains(&true) {
            trace.custom_data(values)
        } else {
            trace
        }
    }

    /// The lower and the upper edge of a band.
    fn band(&self, band: &[(f64, f64, f64)], colour: Colour) -> [Curve; 2] {
        let finite = |p: &&(f64, f64, f64)| [p.0, p.1, p.2].iter().all(|v| v.is_finite());
        let edge = |of: fn(&(f64, f64, f64)) -> f64| -> Curve {
            let points = band.iter().filter(finite).map(|p| (p.0, of(p)));
            let points: Vec<(f64, f64)> = points.collect();
            let kept = kept(&self.cells(&points, 1.0), self.columns);
            let trace = self.curve(&points, &kept.runs);
            trace.mode(Mode::Lines).line(stroke(colour, 0.0, false))
        };
        [edge(|p| p.1), edge(|p| p.2)]
    }

    fn shade(&self, intervals: &[(f64, f64)], colour: Colour) -> Curve {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for (from, to) in intervals {
            let [from, to] = [from, to].map(|v| self.x.0.coordinate(*v, &self.x.1));
            x.extend([from, from, to, to, f64::NAN]);
            y.extend([0.0, 1.0, 1.0, 0.0, f64::NAN]);
        }
        Scatter::new(x, y)
            .y_axis("y2")
            .mode(Mode::Lines)
            .line(stroke(colour, 0.0, false))
            .fill(Fill::ToSelf)
            .fill_color(colour.translucent(0.16))
            .hover_info(HoverInfo::Skip)
    }

    /// Points at y with a middle, a low and a high end along x each.
    fn intervals(&self, all_of_them: &[(f64, f64, f64, f64)], colour: Colour) -> Curve {
        let shown: Vec<_> = all_of_them.iter().filter(|i| i.1.is_finite()).collect();
        let points: Vec<(f64, f64)> = shown.iter().map(|i| (i.1, i.0)).collect();
        let axis = self.x.0;
        let reach = |ends: fn(&(f64, f64, f64, f64)) -> f64| {
            let size = |i: &&(f64, f64, f64, f64)| {
                let [end, middle] = [ends(i), i.1].map(|v| axis.coordinate(v, &self.x.1));
                Some((end - middle).abs()).filter(|s| s.is_finite())
            };
            let sizes = shown.iter().map(|i| size(i).unwrap_or(0.0));
            sizes.collect::<Vec<f64>>()
        };
        let text = |i: &&(f64, f64, f64, f64)| {
            let range = if i.2.is_finite() && i.3.is_finite() {
                format!(" ({} to {})", number(i.2, 4), number(i.3, 4))
            } else {
                String::new()
            };
            format!("{}{range} {}", number(i.1, 4), axis.unit)
        };
        let error = ErrorData::new(ErrorType::Data)
            .symmetric(false)
            .array(reach(|i| i.3))
            .array_minus(reach(|i| i.2))
            .color(colour.hex())
            .thickness(1.6)
            .width(4);
        self.curve(&points, &all(&points))
            .mode(Mode::Markers)
            .marker(Marker::new().color(colour.hex()).size(8))
            .text_array(shown.iter().map(text).collect())
            .hover_template(format!("%{{y}}<br>{} %{{text}}", axis.quantity()))
            .error_x(error)
    }
}

fn all(points: &[(f64, f64)]) -> Runs {
    vec![(0..points.len()).collect()]
}

/// From 0 to 1 along one axis, at one place of the other, so many points that the pointer finds the line anywhere.
fn edge_to_edge(at: f64) -> (Vec<f64>, Vec<f64>) {
    let along: Vec<f64> = (0..=40).map(|i| f64::from(i) / 40.0).collect();
    let at = vec![at; along.len()];
    (along, at)
}

fn across(trace: Curve, colour: Colour, hover: String) -> Curve {
    let line = trace.mode(Mode::Lines).line(stroke(colour, 1.2, true));
    line.hover_template(hover)
}

fn stroke(colour: Colour, width: f64, dashed: bool) -> Line {
    let line = Line::new().color(colour.hex()).width(width);
    if dashed {
        line.dash(DashType::Dash)
    } else {
        line
    }
}
