//! Axes, legend and surroundings of a figure, as Plotly reads them.

use plotly::Layout;
use plotly::color::Color;
use plotly::common::{Anchor, ExponentFormat, Font, Label, Orientation, TickMode, Title};
use plotly::layout::{Axis as PlotlyAxis, AxisType, HoverMode, Legend, Margin, ModeBar};

use super::axis::{Axis, Kind, Scale};
use super::colour::Colour;
use super::plotly_script::{GRID, PAPER};

/// The axis that spans a figure from 0 to 1, for what reaches from edge to edge.
pub(super) fn edge_to_edge(overlaying: &str) -> PlotlyAxis {
    PlotlyAxis::new()
        .overlaying(overlaying)
        .range(vec![0.0, 1.0])
        .fixed_range(true)
        .visible(false)
}

/// Everything but the axes.
pub(super) fn layout() -> Layout {
    let font = Font::new()
        .family("system-ui, \"Segoe UI\", Roboto, sans-serif")
        .size(12)
        .color(Colour::Ink.hex());
    Layout::new()
        .font(font)
        .paper_background_color(PAPER)
        .plot_background_color(PAPER)
        .margin(Margin::new().left(8).right(14).top(10).bottom(8))
        .hover_mode(HoverMode::Closest)
        .hover_label(
            Label::new()
                .background_color(PAPER)
                .font(Font::new().color(Colour::Ink.hex())),
        )
        .legend(
            Legend::new()
                .orientation(Orientation::Horizontal)
                .x(0.0)
                .y(1.0)
                .y_anchor(Anchor::Bottom)
                .x_anchor(Anchor::Left),
        )
        .mode_bar(
            ModeBar::new()
                .orientation(Orientation::Vertical)
                .background_color("#00000000")
                .color(Colour::Grey.hex())
                .active_color(Colour::Ink.hex()),
        )
}

impl Axis {
    /// The axis with the range that `scale` shows.
    pub(super) fn layout(&self, scale: &Scale) -> PlotlyAxis {
        let (low, high) = (self.kind.place(scale.low), self.kind.place(scale.high));
        let axis = PlotlyAxis::new()
            .title(Title::with_text(&self.label))
            .range(vec![low, high])
            .auto_margin(true)
            .zero_line(false)
            .show_line(true)
            .mirror(true)
            .line_color(Colour::Grey.hex())
            .grid_color(GRID)
            .exponent_format(ExponentFormat::Power);
        if self.kind == Kind::Log {
            return axis.type_(AxisType::Log);
        }
        if self.kind == Kind::Linear && self.names.is_empty() {
            return axis;
        }
        let (places, texts) = self.ticks(scale, 5).into_iter().unzip();
        let places: Vec<f64> = places;
        axis.tick_mode(TickMode::Array)
            .tick_values(places.into_iter().map(|v| self.kind.place(v)).collect())
            .tick_text(texts)
    }

    /// A value as the axis takes it, to seven digits: what Plotly is given has to be read by the browser as text.
    pub(super) fn coordinate(&self, value: f64) -> f64 {
        match self.kind {
            Kind::Linear => rounded(value),
            Kind::Log if value > 0.0 => rounded(value),
            Kind::Log => f64::NAN,
            Kind::Symlog(_) => rounded(self.kind.place(value)),
        }
    }

    /// How a pointed-out value reads: quantity, value, unit. `field` is Plotly's name of the coordinate.
    pub(super) fn hover(&self, field: &str) -> String {
        let quantity = self.quantity();
        let value = if !self.names.is_empty() {
            format!("%{{{field}}}")
        } else if let Kind::Symlog(_) = self.kind {
            "%{customdata:.4~g}".to_owned()
        } else {
            format!("%{{{field}:.5~g}}")
        };
        let parts = [quantity, &value, &self.unit];
        let parts: Vec<&str> = parts.into_iter().filter(|p| !p.is_empty()).collect();
        parts.join(" ")
    }
}

/// `value` with seven digits.
pub(super) fn rounded(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// Adds an opacity to a colour.
pub(super) fn area(colour: Colour, opacity: f64) -> impl Color {
    colour.translucent(opacity)
}
