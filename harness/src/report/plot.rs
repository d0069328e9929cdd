//! Lines, points, bands and shaded intervals over two axes.

use super::axis::{Axis, Scale};
use super::colour::Colour;
use super::drawn::Drawn;
use super::layer::{Layer, Shape, pairs};
use super::layout::{edge_to_edge, layout};
use super::page::Figure;
use super::svg::Canvas;
use super::trace::{Frame, Traces};

/// A picture over two axes. Later layers lie on top of earlier ones.
#[derive(Debug, Clone)]
pub struct Plot {
    x: Axis,
    y: Axis,
    layers: Vec<Layer>,
    caption: String,
    size: (f64, f64),
}

impl Plot {
    /// An empty plot.
    pub fn new(x: Axis, y: Axis) -> Plot {
        Plot {
            x,
            y,
            layers: Vec::new(),
            caption: String::new(),
            size: (620.0, 330.0),
        }
    }

    /// One sentence that says what it shows; also the text for readers who cannot see it.
    pub fn caption(mut self, sentence: &str) -> Plot {
        self.caption = sentence.to_owned();
        self
    }

    /// Size in px at full width; it scales with the page.
    pub fn size(mut self, width: f64, height: f64) -> Plot {
        self.size = (width, height);
        self
    }

    fn layer(mut self, name: &str, colour: Colour, shape: Shape) -> Plot {
        self.layers.push(Layer {
            name: name.to_owned(),
            colour,
            shape,
        });
        self
    }

    /// A line; NaN interrupts it. An empty name keeps it out of the legend, here and below.
    pub fn line(self, name: &str, colour: Colour, x: &[f64], y: &[f64]) -> Plot {
        self.layer(
            name,
            colour,
            Shape::Line {
                points: pairs(x, y),
                dashed: false,
                width: 1.6,
            },
        )
    }

    /// A thin line, for dense curves.
    pub fn thin_line(self, name: &str, colour: Colour, x: &[f64], y: &[f64]) -> Plot {
        self.layer(
            name,
            colour,
            Shape::Line {
                points: pairs(x, y),
                dashed: false,
                width: 0.8,
            },
        )
    }

    /// A dashed line.
    pub fn dashed_line(self, name: &str, colour: Colour, x: &[f64], y: &[f64]) -> Plot {
        self.layer(
            name,
            colour,
            Shape::Line {
                points: pairs(x, y),
                dashed: true,
                width: 1.6,
            },
        )
    }

    /// Points.
    pub fn scatter(self, name: &str, colour: Colour, x: &[f64], y: &[f64]) -> Plot {
        self.layer(name, colour, Shape::Points(pairs(x, y)))
    }

    /// The area between `low` and `high`.
    pub fn band(self, name: &str, colour: Colour, x: &[f64], low: &[f64], high: &[f64]) -> Plot {
        let points = x
            .iter()
            .zip(low)
            .zip(high)
            .map(|((x, l), h)| (*x, *l, *h))
            .collect();
        self.layer(name, colour, Shape::Band(points))
    }

    /// Intervals of x, shaded from bottom to top.
    pub fn shade(self, name: &str, colour: Colour, intervals: &[(f64, f64)]) -> Plot {
        self.layer(name, colour, Shape::Shade(intervals.to_vec()))
    }

    /// A dashed line across the plot at one y.
    pub fn level(self, name: &str, colour: Colour, y: f64) -> Plot {
        self.layer(name, colour, Shape::Level(y))
    }

    /// A dashed line from bottom to top at one x.
    pub fn upright(self, name: &str, colour: Colour, x: f64) -> Plot {
        self.layer(name, colour, Shape::Upright(x))
    }

    /// Small points that may lie over one another, for clouds of thousands.
    pub fn cloud(self, name: &str, colour: Colour, x: &[f64], y: &[f64]) -> Plot {
        self.layer(name, colour, Shape::Cloud(pairs(x, y)))
    }

    /// Points with an interval along x each.
    pub fn intervals(
        self,
        name: &str,
        colour: Colour,
        y: &[f64],
        middle: &[f64],
        low: &[f64],
        high: &[f64],
    ) -> Plot {
        let all = (0..y.len())
            .map(|i| (y[i], middle[i], low[i], high[i]))
            .collect();
        self.layer(name, colour, Shape::Intervals(all))
    }

    /// Short texts to the right of points.
    pub fn notes(self, colour: Colour, x: &[f64], y: &[f64], texts: &[String]) -> Plot {
        let notes = pairs(x, y).into_iter().zip(texts.iter().cloned()).collect();
        self.layer("", colour, Shape::Notes(notes))
    }

    /// The values on the y axis, of points inside the x range only: what is cut off must not set the scale.
    fn ys(&self, x: Scale) -> impl Iterator<Item = f64> + '_ {
        let inside = move |v: f64| (x.low..=x.high).contains(&v);
        self.layers.iter().flat_map(move |l| l.shape.ys(&inside))
    }
}

impl Plot {
    /// The picture as an `<svg>` element, for a file of its own.
    pub(super) fn svg(&self) -> String {
        let (width, height) = self.size;
        let legend: Vec<_> = self
            .layers
            .iter()
            .filter(|l| !l.name.is_empty())
            .map(|l| (l.name.clone(), l.colour, l.shape.mark()))
            .collect();
        let mut canvas = Canvas::new(width, height, &legend);
        canvas.widen_left(self.y.name_width());
        let x = self.x.scale(self.layers.iter().flat_map(|l| l.shape.xs()));
        let y = self.y.scale(self.ys(x));
        canvas.axes((&self.x, &x), (&self.y, &y));
        canvas.open_area();
        for layer in &self.layers {
            layer.draw(&mut canvas, x, y);
        }
        canvas.close_area();
        canvas.finish(&self.caption)
    }
}

impl Figure for Plot {
    fn draw(&self, columns: usize) -> Drawn {
        let x = self.x.scale(self.layers.iter().flat_map(|l| l.shape.xs()));
        let y = self.y.scale(self.ys(x));
        let frame = Frame {
            x: (&self.x, x),
            y: (&self.y, y),
            columns,
        };
        let mut traces = Traces::default();
        for layer in &self.layers {
            frame.add(layer, &mut traces);
        }
        let layout = layout()
            .x_axis(self.x.layout(&x))
            .y_axis(self.y.layout(&y))
            .x_axis2(edge_to_edge("x"))
            .y_axis2(edge_to_edge("y"));
        Drawn::new(traces, layout, [&self.x, &self.y])
    }

    fn caption(&self) -> &str {
        &self.caption
    }

    fn height(&self) -> f64 {
        self.size.1
    }

    fn boxed(&self) -> Box<dyn Figure> {
        Box::new(self.clone())
    }
}
