//! The pictures: Figures 15 and 16 of the paper, and what the choices rest on.

use super::series::Series;
use crate::dimension::{Analysis, Verdict};
use crate::report::{Axis, Colour, Plot};

/// Points of a cloud: more would only make the page heavy.
const POINTS: usize = 6000;

/// Colour and legend of an embedding dimension: those that agree stand out, of the others one stands for all.
fn lines(a: &Analysis) -> Vec<(usize, Colour, String)> {
    let (first, last) = a.region.as_ref().map_or((0, 0), |r| r.dimensions);
    let mut named = (false, false);
    (1..=a.sum.counts.len())
        .map(|m| {
            let agrees = (first..=last).contains(&m);
            let seen = if agrees { &mut named.0 } else { &mut named.1 };
            let name = match (*seen, agrees) {
                (true, _) => String::new(),
                (false, true) => format!("m = {first} to {last}: slopes agree"),
                (false, false) if first == 0 => format!("m = 1 to {}", a.sum.counts.len()),
                (false, false) => "other m".to_owned(),
            };
            *seen = true;
            (m, if agrees { Colour::Orange } else { Colour::Grey }, name)
        })
        .collect()
}

fn radius(series: &Series) -> Axis {
    Axis::log("radius r", unit(series))
}

fn unit(series: &Series) -> &str {
    if series.unit.is_empty() {
        "1"
    } else {
        &series.unit
    }
}

/// The delay's plane.
pub fn embedding(series: &Series, a: &Analysis) -> Plot {
    let every = (series.values.len() / POINTS).max(1);
    let count = series.values.len() - a.delay;
    let largest = series.values.iter().fold(0.0_f64, |l, v| l.max(v.abs()));
    let (factor, prefix) = match largest {
        _ if unit(series) != "m" => (1.0, ""),
        l if l < 1e-4 => (1e6, "µ"),
        l if l < 0.1 => (1e3, "m"),
        _ => (1.0, ""),
    };
    let unit = format!("{prefix}{}", unit(series));
    let shown = |i: usize| factor * series.values[i];
    let x: Vec<f64> = (0..count).step_by(every).map(shown).collect();
    let y: Vec<f64> = (0..count)
        .step_by(every)
        .map(|i| shown(i + a.delay))
        .collect();
    Plot::new(
        Axis::linear(&format!("{} at t", series.quantity), &unit),
        Axis::linear("the same one delay later", &unit),
    )
    .caption("The series against itself one delay later (eq. 12; upper half of Figures 15 and 16 of the paper).")
    .cloud("samples", Colour::Blue, &x, &y)
}

/// C(m, r).
pub fn sums(series: &Series, a: &Analysis) -> Plot {
    let mut plot = Plot::new(radius(series), Axis::log("C(m, r)", "1")).caption(
        "Share of pairs within a radius, over the radius, one line per embedding dimension (eq. 13; lower half of Figures 15 and 16): the slope \
         is the dimension where the lines are straight and parallel.",
    );
    if let Some(r) = &a.region {
        plot = plot.shade("scaling region", Colour::Sky, &[(r.from, r.to)]);
    }
    for (m, colour, name) in lines(a) {
        plot = plot.line(&name, colour, &a.sum.radii, &a.sum.sums(m));
    }
    plot
}

/// Local slopes.
pub fn slopes(series: &Series, a: &Analysis) -> Plot {
    let mut plot = Plot::new(radius(series), Axis::linear("local slope", "1")).caption(
        "Slope of ln C over ln r within an octave around each radius: a dimension is a plateau that stays when m grows; lines that rise \
         with m are noise or too few points.",
    );
    if let Some(r) = &a.region {
        plot = plot.shade("scaling region", Colour::Sky, &[(r.from, r.to)]);
    }
    for (m, colour, name) in lines(a) {
        plot = plot.line(&name, colour, &a.sum.radii, &a.slopes[m - 1]);
    }
    if let Some(r) = &a.region {
        plot = plot.level("slope in the region", Colour::Red, r.slope);
    }
    plot
}

/// Slope over m.
pub fn over_dimensions(a: &Analysis) -> Plot {
    let m: Vec<f64> = (1..=a.sum.counts.len()).map(|m| m as f64).collect();
    let mut plot = Plot::new(
        Axis::linear("embedding dimension m", "1"),
        Axis::linear("slope", "1"),
    )
    .caption(
        "Slope in the scaling region over the embedding dimension: it must stop growing. White noise follows the dashed line.",
    )
    .dashed_line("white noise: slope m", Colour::Grey, &m, &m);
    if let (Some(r), Some(std)) = (&a.region, a.std) {
        let of = |s: f64| vec![s; m.len()];
        plot = plot.band(
            "dimension, 2 standard deviations",
            Colour::Sky,
            &m,
            &of(r.slope - 2.0 * std),
            &of(r.slope + 2.0 * std),
        );
    }
    plot.scatter(
        "slope in the region",
        Colour::Orange,
        &m,
        &a.over_dimensions,
    )
}

/// The series among its surrogates.
pub fn surrogates(series: &Series, a: &Analysis) -> Plot {
    let s = &a.surrogates;
    let shown = |v: f64| if v > 0.0 { v } else { f64::NAN };
    let band = |f: &dyn Fn(&(f64, f64)) -> f64| -> Vec<f64> {
        s.band.iter().map(|b| shown(f(b))).collect()
    };
    let caption = format!(
        "C at m = {} of the series and of {} surrogates, noise with the same spectrum and values: a low dimension has the flatter line \
         (slope {:.2} against {:.2} where C is near 0.001).",
        s.dimension,
        s.surrogates.len(),
        s.slope,
        s.surrogates.iter().sum::<f64>() / s.surrogates.len().max(1) as f64
    );
    Plot::new(radius(series), Axis::log("C(m, r)", "1"))
        .caption(&caption)
        .band(
            "surrogates, lowest to highest",
            Colour::Purple,
            &a.sum.radii,
            &band(&|b| b.0),
            &band(&|b| b.1),
        )
        .line(
            "series",
            Colour::Orange,
            &a.sum.radii,
            &a.sum.sums(s.dimension),
        )
}

/// Time in s, or lags in samples.
fn lags(series: &Series, count: usize, from: usize) -> (Axis, Vec<f64>) {
    let step = series.interval.unwrap_or(1.0);
    let unit = if series.interval.is_some() {
        "s"
    } else {
        "samples"
    };
    let values = (from..from + count).map(|k| k as f64 * step).collect();
    (Axis::linear("lag", unit), values)
}

/// Mutual information and autocorrelation.
pub fn delay(series: &Series, a: &Analysis) -> Plot {
    let count = (6 * a.delay)
        .max(30)
        .min(a.delay_choice.mutual_information.len());
    let (axis, k) = lags(series, count, 0);
    Plot::new(axis, Axis::linear("information [bit], correlation", "1"))
        .caption("Information that one sample carries about a later one: the delay is the first minimum of the mutual information, where there is one.")
        .line("mutual information", Colour::Blue, &k[1..], &a.delay_choice.mutual_information[1..count])
        .line("autocorrelation", Colour::Green, &k, &a.delay_choice.autocorrelation[..count])
        .upright("delay", Colour::Red, a.delay as f64 * series.interval.unwrap_or(1.0))
}

/// Space-time separation.
pub fn separation(series: &Series, a: &Analysis) -> Plot {
    let (axis, k) = lags(series, a.separation.contours[0].len(), 1);
    let mut plot = Plot::new(axis, Axis::log("radius", unit(series))).caption(
        "Radius that holds 10, 50 and 90 % of the pairs at a lag: left of the Theiler window pairs are close because they are close in time; \
         they are not counted.",
    );
    let colours = [Colour::Blue, Colour::Green, Colour::Purple];
    for ((share, contour), colour) in a
        .separation
        .shares
        .iter()
        .zip(&a.separation.contours)
        .zip(colours)
    {
        let name = format!("{:.0} % of pairs", 100.0 * share);
        plot = plot.thin_line(&name, colour, &k, contour);
    }
    plot.upright(
        "Theiler window",
        Colour::Red,
        a.theiler as f64 * series.interval.unwrap_or(1.0),
    )
}

/// How neighbours part.
pub fn divergence(series: &Series, a: &Analysis) -> Option<Plot> {
    let d = a.divergence.as_ref()?;
    let (axis, k) = lags(series, d.mean_log.len(), 0);
    let (from, to) = d.fitted;
    let fit: Vec<f64> = (from..=to)
        .map(|i| d.mean_log[from] + d.exponent * (i - from) as f64)
        .collect();
    let what = match a.verdict {
        Verdict::Dimension => "its slope is the largest Lyapunov exponent",
        _ => "without a low dimension its slope is no proof of chaos",
    };
    let caption = format!(
        "Mean logarithm of the distance of neighbours over time: where it grows evenly, {what}."
    );
    Some(
        Plot::new(axis, Axis::linear("mean of ln(distance)", "1"))
            .caption(&caption)
            .line("neighbours", Colour::Blue, &k, &d.mean_log)
            .dashed_line("straight part", Colour::Red, &k[from..=to], &fit),
    )
}
