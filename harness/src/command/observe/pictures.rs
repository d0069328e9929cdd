//! The pictures of observer.html.

use super::Observation;
use crate::metric::half_width;
use crate::observer::PhaseMode;
use crate::report::{Axis, Colour, Plot};

/// Phases shown in the pictures over time.
const PHASES_SHOWN: usize = 8;
/// Most points in a cloud.
const POINTS: usize = 4000;

/// Factor and prefixed unit in which the largest of `values` has digits before the point.
fn readable(values: &[f64], unit: &'static str) -> (f64, &'static str) {
    let largest = values
        .iter()
        .filter(|v| v.is_finite())
        .fold(0.0, |m: f64, v| m.max(v.abs()));
    match (unit, largest) {
        ("m", v) if v < 1e-4 => (1e6, "µm"),
        ("m", v) if v < 0.1 => (1e3, "mm"),
        ("m/s", v) if v < 0.1 => (1e3, "mm/s"),
        ("m/s^2", v) if v < 0.1 => (1e3, "mm/s^2"),
        ("s", v) if v < 0.1 => (1e3, "ms"),
        _ => (1.0, unit),
    }
}

fn times(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|v| v * factor).collect()
}

/// A few phases from the middle of the record.
pub fn window(o: &Observation) -> std::ops::Range<usize> {
    let middle = o.phases.len() / 2;
    let last = (middle + PHASES_SHOWN).min(o.phases.len() - 1);
    let (first, past) = (o.phases[middle.min(last)].first, o.phases[last].past);
    // At least a few samples, at most what a picture can show.
    first
        ..past
            .clamp((first + 200).min(o.time.len()), first + 20_000)
            .min(o.time.len())
}

fn sticks(o: &Observation, window: &std::ops::Range<usize>) -> Vec<(f64, f64)> {
    let inside = |p: &&crate::observer::Phase| p.first < window.end && p.past > window.start;
    o.phases
        .iter()
        .filter(|p| p.mode == PhaseMode::Stick)
        .filter(inside)
        .map(|p| {
            (
                p.start.max(o.time[window.start]),
                p.end.min(o.time[window.end - 1]),
            )
        })
        .collect()
}

/// The force with its band.
pub fn force(o: &Observation, window: &std::ops::Range<usize>) -> Plot {
    let t = &o.time[window.clone()];
    let f = &o.force[window.clone()];
    let mut plot = Plot::new(
        Axis::linear("time", "s"),
        Axis::linear("friction force", "N"),
    )
    .caption("Friction force on the tip with its 95 % band (where it is wide enough to be seen); stick phases shaded.")
    .shade("stick", Colour::Grey, &sticks(o, window));
    let std = &o.force_std[window.clone()];
    if std.iter().all(|s| s.is_finite()) {
        let low: Vec<f64> = f.iter().zip(std).map(|(f, s)| f - half_width(*s)).collect();
        let high: Vec<f64> = f.iter().zip(std).map(|(f, s)| f + half_width(*s)).collect();
        plot = plot.band("95 % band", Colour::Sky, t, &low, &high);
    }
    plot.line("force", Colour::Blue, t, f)
}

/// What was measured, and what the estimated motion has of it.
pub fn motion(o: &Observation, window: &std::ops::Range<usize>) -> Plot {
    let kept: Vec<usize> = window
        .clone()
        .filter(|k| o.measured[*k].is_finite())
        .collect();
    let at = |values: &[f64]| -> Vec<f64> { kept.iter().map(|k| values[*k]).collect() };
    let estimated = o.estimated();
    let (factor, unit) = readable(&estimated[window.clone()], o.measurand.unit());
    let quantity = o.measurand.name();
    Plot::new(
        Axis::linear("time", "s"),
        Axis::linear(&format!("tip {quantity}"), unit),
    )
    .caption(&format!(
        "Measured {quantity}, and the {quantity} of the tip that goes with the estimated force."
    ))
    .line(
        match o.structure.is_collocated() {
            true => "measured",
            false => "measured, where the sensor looks",
        },
        Colour::Grey,
        &at(&o.time),
        &times(&at(&o.measured), factor),
    )
    .thin_line(
        "estimated",
        Colour::Orange,
        &o.time[window.clone()],
        &times(&estimated[window.clone()], factor),
    )
}

/// Velocity of the tip less that of the belt.
pub fn velocity(o: &Observation, window: &std::ops::Range<usize>) -> Plot {
    let (factor, unit) = readable(&o.relative_velocity[window.clone()], "m/s");
    Plot::new(
        Axis::linear("time", "s"),
        Axis::linear("relative velocity", unit),
    )
    .caption("Velocity of the tip less that of the belt; zero in stick.")
    .shade("stick", Colour::Grey, &sticks(o, window))
    .line(
        "relative velocity",
        Colour::Green,
        &o.time[window.clone()],
        &times(&o.relative_velocity[window.clone()], factor),
    )
}

/// Friction coefficient over the speed of slip.
pub fn characteristic(o: &Observation) -> Plot {
    let slip = |sign: f64| {
        o.bins
            .iter()
            .filter(move |b| b.relative_velocity * sign > 0.0)
    };
    let fastest = o
        .bins
        .iter()
        .map(|b| b.relative_velocity.abs())
        .fold(0.0, f64::max);
    let (factor, unit) = readable(&[fastest], "m/s");
    let caption = format!(
        "Friction coefficient over the speed of slip (Figure 14 of the paper): means of the force in bins with two standard errors{} \
         and the best law; friction.csv holds the {}.",
        if o.curve_trusted {
            ", the sharper curve by shooting"
        } else {
            ""
        },
        if o.curve_trusted { "curve" } else { "means" },
    );
    let mut plot = Plot::new(
        Axis::linear("speed of slip", unit),
        Axis::linear("friction coefficient", "1"),
    )
    .caption(&caption);
    for (sign, name, colour) in [
        (-1.0, "backward", Colour::Blue),
        (1.0, "forward", Colour::Green),
    ] {
        let mut bins: Vec<_> = slip(sign).collect();
        bins.sort_by(|a, b| {
            a.relative_velocity
                .abs()
                .total_cmp(&b.relative_velocity.abs())
        });
        if bins.is_empty() {
            continue;
        }
        let v: Vec<f64> = bins
            .iter()
            .map(|b| factor * b.relative_velocity.abs())
            .collect();
        let column = |f: &dyn Fn(&crate::observer::Bin) -> f64| -> Vec<f64> {
            bins.iter().map(|b| f(b)).collect()
        };
        plot = plot
            .band(
                &format!("{name} slip, 2 standard errors"),
                Colour::Sky,
                &v,
                &column(&|b| b.mu - 2.0 * b.mu_error),
                &column(&|b| b.mu + 2.0 * b.mu_error),
            )
            .scatter(
                &format!("{name} slip, means"),
                colour,
                &v,
                &column(&|b| b.mu),
            );
    }
    let grid: Vec<f64> = (0..=200)
        .map(|i| fastest * (f64::from(i) / 200.0).powi(2))
        .collect();
    let shown = times(&grid, factor);
    if let Some(curve) = o.curve.as_ref().filter(|_| o.curve_trusted) {
        let mu: Vec<f64> = grid.iter().map(|v| curve.at(*v)).collect();
        plot = plot.line("curve", Colour::Orange, &shown, &mu);
    }
    if let Some(best) = o.best_law() {
        let mu: Vec<f64> = grid.iter().map(|v| best.law.mu(*v)).collect();
        plot = plot.dashed_line(
            &format!("{} law", best.law.name()),
            Colour::Ink,
            &shown,
            &mu,
        );
    }
    plot
}

/// Force over relative velocity, coloured by whether the relative velocity rises or falls.
pub fn hysteresis(o: &Observation) -> Plot {
    let n = o.time.len();
    let every = (n / POINTS).max(1);
    let modes = o.modes();
    let (factor, unit) = readable(&o.relative_velocity, "m/s");
    let mut plot = Plot::new(
        Axis::linear("relative velocity", unit),
        Axis::linear("friction force", "N"),
    )
    .caption(
        "Force over relative velocity: where the two colours of slip part, friction depends on more than the velocity (hysteresis); in \
         stick the force is whatever holds the tip.",
    );
    let inner = || (n / 50 + 1..n - n / 50 - 1).step_by(every);
    let rises = |k: usize| o.relative_velocity[k + 1] > o.relative_velocity[k - 1];
    let cloud = |plot: Plot, name: &str, colour, kept: &dyn Fn(usize) -> bool| {
        let kept: Vec<usize> = inner().filter(|k| kept(*k)).collect();
        let v: Vec<f64> = kept
            .iter()
            .map(|k| factor * o.relative_velocity[*k])
            .collect();
        let f: Vec<f64> = kept.iter().map(|k| o.force[*k]).collect();
        plot.cloud(name, colour, &v, &f)
    };
    plot = cloud(plot, "stick", Colour::Grey, &|k| modes[k] == 0);
    plot = cloud(plot, "slip, v_r rising", Colour::Blue, &|k| {
        modes[k] != 0 && rises(k)
    });
    cloud(plot, "slip, v_r falling", Colour::Orange, &|k| {
        modes[k] != 0 && !rises(k)
    })
}

/// Break-away coefficient over dwell time.
pub fn break_away(o: &Observation) -> Plot {
    let events = o.dwell.iter().flat_map(|d| &d.events);
    let (t, mu): (Vec<f64>, Vec<f64>) = events.map(|e| (e.dwell, e.mu)).unzip();
    let (factor, unit) = readable(&t, "s");
    Plot::new(
        Axis::linear("dwell time", unit),
        Axis::linear("break-away coefficient", "1"),
    )
    .caption("Break-away force over normal force against the time in stick before it, one point per stick phase.")
    .scatter("break-away", Colour::Purple, &times(&t, factor), &mu)
}
