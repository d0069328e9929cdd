//! Axes, legend and surroundings of a figure, as Plotly reads them.

use plotly::Layout;
use plotly::common::{Anchor, ExponentFormat, Font, Label, Orientation, TickMode, Title};
use plotly::layout::{
    Axis as PlotlyAxis, AxisType, HoverMode, ItemSizing, Legend, Margin, ModeBar,
};

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
                .background_color("#00000000")
                .item_sizing(ItemSizing::Constant)
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
            let axis = axis.type_(AxisType::Log);
            // Over some decades their powers are enough.
            return if high - low > 2.0 {
                axis.dtick(1.0)
            } else {
                axis
            };
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

    /// A value as the axis takes it, to a hundred-thousandth of what the axis shows: the browser reads it as text.
    pub(super) fn coordinate(&self, value: f64, scale: &Scale) -> f64 {
        match self.kind {
            Kind::Log if value > 0.0 => format!("{value:.5e}").parse().unwrap_or(value),
            Kind::Log => f64::NAN,
            _ => {
                let [low, high, at] = [scale.low, scale.high, value].map(|v| self.kind.place(v));
                let decimals = 6.0 - (high - low).abs().log10().ceil();
                format!("{at:.*}", decimals.clamp(0.0, 300.0) as usize)
                    .parse()
                    .unwrap_or(at)
            }
        }
    }

    /// How a pointed-out value reads: quantity, value, unit. `field` is Plotly's name of the coordinate.
    pub(super) fn hover(&self, field: &str) -> String {
        let value = if !self.names.is_empty() {
            format!("%{{{field}}}")
        } else if self.is_symlog() {
            "%{customdata:.4~g}".to_owned()
        } else {
            format!("%{{{field}:.5~g}}")
        };
        self.worded(&value)
    }

    /// The same where all points have one `value`.
    pub(super) fn hover_of(&self, field: &str, value: &str) -> String {
        if self.is_symlog() {
            self.worded(value)
        } else {
            self.hover(field)
        }
    }

    fn worded(&self, value: &str) -> String {
        let parts = [self.quantity(), value, &self.unit];
        let parts: Vec<&str> = parts.into_iter().filter(|p| !p.is_empty()).collect();
        parts.join(" ")
    }
}
