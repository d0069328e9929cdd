//! What a plot is made of: each layer's shape, its extent and how it is drawn.

use std::fmt::Write as _;

use super::axis::Scale;
use super::colour::Colour;
use super::stroke;
use super::svg::{Canvas, Mark, escape};

#[derive(Debug, Clone)]
pub(super) struct Layer {
    pub name: String,
    pub colour: Colour,
    pub shape: Shape,
}

#[derive(Debug, Clone)]
pub(super) enum Shape {
    Line {
        points: Vec<(f64, f64)>,
        dashed: bool,
        width: f64,
    },
    Points(Vec<(f64, f64)>),
    Band(Vec<(f64, f64, f64)>),
    Shade(Vec<(f64, f64)>),
    Level(f64),
    Upright(f64),
    Cloud(Vec<(f64, f64)>),
    /// y, then middle, low and high along x.
    Intervals(Vec<(f64, f64, f64, f64)>),
    Notes(Vec<((f64, f64), String)>),
}

pub(super) fn pairs(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    x.iter().copied().zip(y.iter().copied()).collect()
}

impl Shape {
    /// Values along x.
    pub fn xs(&self) -> Vec<f64> {
        match self {
            Shape::Line { points, .. } | Shape::Points(points) | Shape::Cloud(points) => {
                points.iter().map(|p| p.0).collect()
            }
            Shape::Band(points) => points.iter().map(|p| p.0).collect(),
            Shape::Intervals(all) => all.iter().flat_map(|i| [i.1, i.2, i.3]).collect(),
            Shape::Upright(x) => vec![*x],
            Shape::Shade(_) | Shape::Level(_) | Shape::Notes(_) => Vec::new(),
        }
    }

    /// Values along y where x is inside.
    pub fn ys(&self, inside: &dyn Fn(f64) -> bool) -> Vec<f64> {
        match self {
            Shape::Line { points, .. } | Shape::Points(points) | Shape::Cloud(points) => {
                points.iter().filter(|p| inside(p.0)).map(|p| p.1).collect()
            }
            Shape::Band(points) => points
                .iter()
                .filter(|p| inside(p.0))
                .flat_map(|p| [p.1, p.2])
                .collect(),
            Shape::Level(y) => vec![*y],
            Shape::Intervals(all) => all.iter().map(|i| i.0).collect(),
            Shape::Shade(_) | Shape::Upright(_) | Shape::Notes(_) => Vec::new(),
        }
    }

    pub fn mark(&self) -> Mark {
        match self {
            Shape::Line { dashed: false, .. } => Mark::Line,
            Shape::Line { .. } | Shape::Level(_) | Shape::Upright(_) => Mark::Dashed,
            Shape::Points(_) | Shape::Cloud(_) | Shape::Intervals(_) | Shape::Notes(_) => {
                Mark::Point
            }
            Shape::Band(_) | Shape::Shade(_) => Mark::Area,
        }
    }
}

impl Layer {
    pub fn draw(&self, canvas: &mut Canvas, x: Scale, y: Scale) {
        let (left, top, width, height) = (canvas.left, canvas.top, canvas.width, canvas.height);
        let at_x = |v: f64| left + width * x.share(v);
        let at_y = |v: f64| top + height * (1.0 - y.share(v));
        let colour = self.colour.css();
        let out = &mut canvas.text;
        let _ = match &self.shape {
            Shape::Line { points, dashed, width } => {
                let dash = if *dashed { r#" stroke-dasharray="6 4""# } else { "" };
                let d = stroke::line(points.iter().map(|p| (at_x(p.0), at_y(p.1))));
                write!(out, r#"<path d="{d}" fill="none" style="stroke:{colour}" stroke-width="{width}"{dash} stroke-linejoin="round"/>"#)
            }
            Shape::Points(points) => points.iter().filter(|p| p.0.is_finite() && p.1.is_finite()).try_for_each(|p| {
                write!(out, r#"<circle cx="{:.1}" cy="{:.1}" r="3" style="fill:{colour}"/>"#, at_x(p.0), at_y(p.1))
            }),
            Shape::Band(points) => {
                let low: Vec<_> = points.iter().map(|p| (at_x(p.0), at_y(p.1))).collect();
                let high: Vec<_> = points.iter().map(|p| (at_x(p.0), at_y(p.2))).collect();
                write!(out, r#"<path d="{}Z" style="fill:{colour}" fill-opacity="0.22"/>"#, stroke::area(&low, &high))
            }
            Shape::Cloud(points) => {
                // Lines of no length with round ends: a third of the text that circles would need.
                let _ = write!(out, r#"<path style="stroke:{colour}" stroke-width="3" stroke-linecap="round" stroke-opacity="0.6" d=""#);
                let inside = points.iter().filter(|p| p.0.is_finite() && p.1.is_finite());
                let _ = inside.into_iter().try_for_each(|p| write!(out, "M{:.1} {:.1}h0", at_x(p.0), at_y(p.1)));
                write!(out, r#""/>"#)
            }
            Shape::Intervals(all) => all.iter().filter(|i| i.1.is_finite()).try_for_each(|(y, middle, low, high)| {
                let y = at_y(*y);
                if low.is_finite() && high.is_finite() {
                    let (low, high) = (at_x(*low), at_x(*high));
                    write!(out, r#"<path d="M{low:.1} {y:.1}H{high:.1}M{low:.1} {:.1}v8M{high:.1} {:.1}v8" style="stroke:{colour}" stroke-width="1.6"/>"#, y - 4.0, y - 4.0)?;
                }
                write!(out, r#"<circle cx="{:.1}" cy="{y:.1}" r="4" style="fill:{colour}"/>"#, at_x(*middle))
            }),
            Shape::Notes(notes) => notes.iter().filter(|((x, y), _)| x.is_finite() && y.is_finite()).try_for_each(|((x, y), text)| {
                write!(out, r#"<text x="{:.1}" y="{:.1}">{}</text>"#, at_x(*x) + 7.0, at_y(*y) - 5.0, escape(text))
            }),
            Shape::Upright(value) => {
                let at = at_x(*value);
                write!(out, r#"<line x1="{at:.1}" x2="{at:.1}" y1="{top}" y2="{:.1}" style="stroke:{colour}" stroke-width="1.2" stroke-dasharray="6 4"/>"#, top + height)
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
