//! Lines, points, bands and shaded intervals over two axes.

use std::fmt::Write as _;

use super::axis::{Axis, Scale};
use super::colour::Colour;
use super::page::Figure;
use super::svg::{Canvas, Mark};

/// A picture over two axes. Later layers lie on top of earlier ones.
#[derive(Debug, Clone)]
pub struct Plot {
    x: Axis,
    y: Axis,
    layers: Vec<Layer>,
    caption: String,
    size: (f64, f64),
}

#[derive(Debug, Clone)]
struct Layer {
    name: String,
    colour: Colour,
    shape: Shape,
}

#[derive(Debug, Clone)]
enum Shape {
    Line {
        points: Vec<(f64, f64)>,
        dashed: bool,
        width: f64,
    },
    Points(Vec<(f64, f64)>),
    Band(Vec<(f64, f64, f64)>),
    Shade(Vec<(f64, f64)>),
    Level(f64),
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

    fn xs(&self) -> impl Iterator<Item = f64> + '_ {
        self.layers.iter().flat_map(|layer| match &layer.shape {
            Shape::Line { points, .. } | Shape::Points(points) => {
                points.iter().map(|p| p.0).collect()
            }
            Shape::Band(points) => points.iter().map(|p| p.0).collect::<Vec<_>>(),
            Shape::Shade(_) | Shape::Level(_) => Vec::new(),
        })
    }

    /// The values on the y axis, of points inside the x range only: what is cut off must not set the scale.
    fn ys(&self, x: Scale) -> impl Iterator<Item = f64> + '_ {
        let inside = move |v: f64| (x.low..=x.high).contains(&v);
        self.layers
            .iter()
            .flat_map(move |layer| match &layer.shape {
                Shape::Line { points, .. } | Shape::Points(points) => {
                    points.iter().filter(|p| inside(p.0)).map(|p| p.1).collect()
                }
                Shape::Band(points) => points
                    .iter()
                    .filter(|p| inside(p.0))
                    .flat_map(|p| [p.1, p.2])
                    .collect::<Vec<_>>(),
                Shape::Level(y) => vec![*y],
                Shape::Shade(_) => Vec::new(),
            })
    }
}

impl Figure for Plot {
    fn svg(&self) -> String {
        let legend: Vec<_> = self
            .layers
            .iter()
            .filter(|l| !l.name.is_empty())
            .map(|l| (l.name.clone(), l.colour, l.shape.mark()))
            .collect();
        let mut canvas = Canvas::new(self.size.0, self.size.1, &legend);
        let x = self.x.scale(self.xs());
        let y = self.y.scale(self.ys(x));
        canvas.axes((&self.x, &x), (&self.y, &y));
        canvas.open_area();
        for layer in &self.layers {
            layer.draw(&mut canvas, x, y);
        }
        canvas.close_area();
        canvas.finish(&self.caption)
    }

    fn caption(&self) -> &str {
        &self.caption
    }
}

fn pairs(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    x.iter().copied().zip(y.iter().copied()).collect()
}

impl Shape {
    fn mark(&self) -> Mark {
        match self {
            Shape::Line { dashed: false, .. } => Mark::Line,
            Shape::Line { .. } | Shape::Level(_) => Mark::Dashed,
            Shape::Points(_) => Mark::Point,
            Shape::Band(_) | Shape::Shade(_) => Mark::Area,
        }
    }
}

impl Layer {
    fn draw(&self, canvas: &mut Canvas, x: Scale, y: Scale) {
        let (left, top, width, height) = (canvas.left, canvas.top, canvas.width, canvas.height);
        let at_x = |v: f64| left + width * x.share(v);
        let at_y = |v: f64| top + height * (1.0 - y.share(v));
        let colour = self.colour.css();
        let out = &mut canvas.text;
        let _ = match &self.shape {
            Shape::Line { points, dashed, width } => {
                let dash = if *dashed { r#" stroke-dasharray="6 4""# } else { "" };
                let d = path(points.iter().map(|p| (at_x(p.0), at_y(p.1))));
                write!(out, r#"<path d="{d}" fill="none" style="stroke:{colour}" stroke-width="{width}"{dash} stroke-linejoin="round"/>"#)
            }
            Shape::Points(points) => points.iter().filter(|p| p.0.is_finite() && p.1.is_finite()).try_for_each(|p| {
                write!(out, r#"<circle cx="{:.1}" cy="{:.1}" r="3" style="fill:{colour}"/>"#, at_x(p.0), at_y(p.1))
            }),
            Shape::Band(points) => {
                let there = points.iter().map(|p| (at_x(p.0), at_y(p.1)));
                let back = points.iter().rev().map(|p| (at_x(p.0), at_y(p.2)));
                write!(out, r#"<path d="{}Z" style="fill:{colour}" fill-opacity="0.22"/>"#, path(there.chain(back)))
            }
            Shape::Shade(intervals) => intervals.iter().try_for_each(|(from, to)| {
                let (from, to) = (at_x(*from), at_x(*to));
                write!(out, r#"<rect x="{from:.1}" y="{top}" width="{:.1}" height="{height:.1}" style="fill:{colour}" fill-opacity="0.16"/>"#, to - from)
            }),
            Shape::Level(value) => {
                let at = at_y(*value);
                write!(out, r#"<line x1="{left}" x2="{:.1}" y1="{at:.1}" y2="{at:.1}" style="stroke:{colour}" stroke-width="1.2" stroke-dasharray="6 4"/>"#, left + width)
            }
        };
    }
}

/// Path data. Points within 0.4 px of the one drawn before are left out: nobody sees them, and the file stays small.
fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut d = String::new();
    let mut pen_up = true;
    let mut last = (f64::NAN, f64::NAN);
    for (x, y) in points {
        if !(x.is_finite() && y.is_finite()) {
            pen_up = true;
            continue;
        }
        let near = (x - last.0).abs() < 0.4 && (y - last.1).abs() < 0.4;
        if near && !pen_up {
            continue;
        }
        let _ = write!(d, "{}{x:.1} {y:.1}", if pen_up { 'M' } else { 'L' });
        (pen_up, last) = (false, (x, y));
    }
    d
}
