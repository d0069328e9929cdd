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

    /// A wide line, for another on top of it.
    pub fn wide_line(self, name: &str, colour: Colour, x: &[f64], y: &[f64]) -> Plot {
        self.layer(
            name,
            colour,
            Shape::Line {
                points: pairs(x, y),
                dashed: false,
                width: 3.2,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn data(plot: &Plot) -> Vec<serde_json::Value> {
        plot.figure_json()["data"].as_array().unwrap().clone()
    }

    fn numbers(value: &serde_json::Value) -> Vec<f64> {
        let list = value.as_array().unwrap();
        list.iter()
            .map(|v| v.as_f64().unwrap_or(f64::NAN))
            .collect()
    }

    fn plot(y: Axis) -> Plot {
        Plot::new(Axis::linear("time", "s"), y)
    }

    #[test]
    fn a_long_record_keeps_its_shortest_peak() {
        let x: Vec<f64> = (0..300_000).map(|i| 1e-4 * f64::from(i)).collect();
        let mut y: Vec<f64> = x.iter().map(|x| (50.0 * x).sin()).collect();
        (y[123_456], y[234_567]) = (7.5, -3.25);
        let drawn = &data(&plot(Axis::linear("way", "mm")).line("a", Colour::Blue, &x, &y))[0];
        let (x, y) = (numbers(&drawn["x"]), numbers(&drawn["y"]));
        assert!(x.len() <= 4000, "{}", x.len());
        let at = y.iter().position(|y| *y == 7.5).unwrap();
        assert!((x[at] - 12.3456).abs() < 1e-4, "{}", x[at]);
        assert!(y.contains(&-3.25));
        assert!(x.is_sorted());
    }

    #[test]
    fn values_keep_a_hundred_thousandth_of_the_axis() {
        let x: Vec<f64> = (0..1000).map(|i| 1e3 + 1e-3 * f64::from(i)).collect();
        let y: Vec<f64> = x.iter().map(|x| 1e-6 * (70.0 * x).sin()).collect();
        let drawn = &data(&plot(Axis::linear("way", "m")).scatter("", Colour::Blue, &x, &y))[0];
        for (given, shown, size) in [(&x, &drawn["x"], 1.0), (&y, &drawn["y"], 2e-6)] {
            for (a, b) in given.iter().zip(numbers(shown)) {
                assert!((a - b).abs() <= 1e-5 * size, "{a} {b}");
            }
        }
        assert_eq!(drawn["showlegend"], false);
    }

    #[test]
    fn a_value_reads_with_quantity_and_unit() {
        let drawn = &data(&plot(Axis::log("force", "N")).line("a", Colour::Red, &[1.0], &[2.0]))[0];
        assert_eq!(
            drawn["hovertemplate"],
            "time %{x:.5~g} s<br>force %{y:.5~g} N"
        );
        let level = &data(&plot(Axis::symlog("gain", "1", 10.0)).level("b", Colour::Red, -40.0))[0];
        assert_eq!(level["hovertemplate"], "gain -40");
    }

    // Source: asinh(40 / 10), by hand ln(4 + sqrt(17)).
    #[test]
    fn val_logarithmic_on_both_sides_of_zero() {
        let plot = plot(Axis::symlog("gain", "1", 10.0));
        let plot = plot.scatter("a", Colour::Red, &[1.0, 2.0], &[40.0, -40.0]);
        let (figure, place) = (plot.figure_json(), (4.0 + 17f64.sqrt()).ln());
        let drawn = &figure["data"][0];
        for (found, sign) in numbers(&drawn["y"]).iter().zip([1.0, -1.0]) {
            assert!((found - sign * place).abs() < 1e-5, "{found}");
        }
        assert_eq!(numbers(&drawn["customdata"]), [40.0, -40.0]);
        assert_eq!(figure["layout"]["meta"]["yaxis"], 10.0);
    }

    #[test]
    fn what_is_missing_interrupts_a_line_and_an_axis_of_logarithms_leaves_out_zero() {
        let (x, y) = ([0.0, 1.0, 2.0, 3.0], [1.0, f64::NAN, 2.0, 0.0]);
        let line = plot(Axis::linear("way", "mm")).line("a", Colour::Blue, &x, &y);
        assert!(numbers(&data(&line)[0]["y"])[1].is_nan());
        let line = plot(Axis::log("way", "mm")).scatter("a", Colour::Blue, &x, &y);
        let shown = numbers(&data(&line)[0]["y"]);
        assert_eq!(
            shown.iter().filter(|v| v.is_finite()).count(),
            2,
            "{shown:?}"
        );
    }

    #[test]
    fn a_band_is_shown_and_hidden_as_one() {
        let plot = plot(Axis::linear("way", "mm"));
        let band = plot.band("a", Colour::Blue, &[0.0, 1.0], &[1.0, 2.0], &[3.0, 5.0]);
        let [low, high] = &data(&band)[..] else {
            panic!("two edges")
        };
        assert_eq!(low["legendgroup"], high["legendgroup"]);
        assert_eq!(
            (numbers(&low["y"]), numbers(&high["y"])),
            (vec![1.0, 2.0], vec![3.0, 5.0])
        );
        assert_eq!(high["fill"], "tonexty");
        assert_eq!(
            (&low["showlegend"], &high["showlegend"]),
            (&false.into(), &true.into())
        );
    }
}
