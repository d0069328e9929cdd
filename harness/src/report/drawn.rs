//! A figure as Plotly reads it.

use plotly::Layout;
use serde_json::{Value, json};

use super::axis::{Axis, Kind};
use super::trace::Traces;

/// Columns of a picture that keep their lowest and highest point, unless a page needs room.
pub(super) const COLUMNS: usize = 2000;

/// Data and layout, and how much of the data they show.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// `data` and `layout`.
    pub(super) json: Value,
    shown: usize,
    given: usize,
}

impl Drawn {
    pub(super) fn new(traces: Traces, layout: Layout, axes: [&Axis; 2]) -> Drawn {
        let mut plot = plotly::Plot::new();
        plot.add_traces(traces.list);
        plot.set_layout(layout);
        let mut json = serde_json::to_value(&plot).expect("figures have text keys and numbers");
        json["layout"]["meta"] = json!({ "xaxis": axes[0].meaning(), "yaxis": axes[1].meaning() });
        Drawn {
            json: json!({ "data": json["data"].take(), "layout": json["layout"].take() }),
            shown: traces.shown,
            given: traces.given,
        }
    }

    /// Entries of its legend.
    pub(super) fn legend(&self) -> usize {
        let traces = self.json["data"].as_array().map_or(&[][..], Vec::as_slice);
        traces.iter().filter(|t| t["showlegend"] == true).count()
    }

    /// Says how many points were left out, where some were.
    pub(super) fn thinned(&self) -> Option<String> {
        (self.shown < self.given).then(|| {
            format!(
                "{} of {} points are drawn: extremes are kept, what lies on other points is left out.",
                self.shown, self.given
            )
        })
    }
}

impl Axis {
    /// What the coordinates of a figure mean, for those who read them back: `names` of ticks, or of a symmetric logarithmic
    /// axis the value `s` below which it is linear; there the coordinate is asinh(value / s).
    fn meaning(&self) -> Value {
        match self.kind {
            Kind::Symlog(linear) => json!(linear),
            _ if !self.names.is_empty() => json!("names"),
            _ => Value::Null,
        }
    }
}
