//! How the error grows while a prediction runs on.

use super::Material;
use super::statistics::{Bins, bins, stretches};
use super::views::COLOURS;
use crate::diagnose::explanation::misses::NORMAL_MEDIAN;
use crate::report::{Axis, Colour, Plot};

/// The error over the time since a prediction began.
pub fn by_horizon(material: &Material) -> Plot {
    let mut plot = Plot::new(
        Axis::linear("time since the prediction began", "ms"),
        Axis::log("error over noise", "1"),
    );
    for (view, colour) in COLOURS.iter().enumerate() {
        let points: Vec<(f64, f64)> = sizes(material, view)
            .map(|(s, v)| (1e3 * s.since_start, v))
            .collect();
        plot = quartiles(
            plot,
            &material.views.pair[view].name,
            *colour,
            &bins(&points, 40),
        );
    }
    plot.level("noise", Colour::Green, 1.0)
        .caption("How the error grows while a prediction runs on (median and middle half): a right model stays at the noise to the end.")
}

/// Absolute residual over noise of each sample, so scaled that its median is 1 for noise alone.
fn sizes<'a>(
    material: &'a Material,
    view: usize,
) -> impl Iterator<Item = (&'a super::samples::Sample, f64)> {
    let noise = &material.problem.noise;
    material
        .views
        .samples
        .iter()
        .map(move |s| (s, s.residual[view].abs() / noise[s.run] / NORMAL_MEDIAN))
}

/// Median line with the middle half as a band.
pub fn quartiles(mut plot: Plot, name: &str, colour: Colour, bins: &Bins) -> Plot {
    for part in stretches(bins) {
        let part = |v: &[f64]| v[part.clone()].to_vec();
        plot = plot.band(
            "",
            colour,
            &part(&bins.x),
            &part(&bins.low),
            &part(&bins.high),
        );
    }
    plot.line(name, colour, &bins.x, &bins.middle)
}
