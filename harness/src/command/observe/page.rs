//! observer.html.

use super::Observation;
use crate::observer::{LawFit, PhaseMode};
use crate::report::{Axis, Cell, Colour, Page, Plot, Table, number, with_unit};

/// Phases shown in the pictures over time.
const PHASES_SHOWN: usize = 8;
/// Most points in a scatter.
const POINTS: usize = 4000;

/// The finished document.
pub fn html(o: &Observation) -> String {
    let lead = format!(
        "Run {} at {} m/s and {}: {}.",
        o.name,
        number(o.belt_velocity, 3),
        with_unit(o.normal_force, "N"),
        o.method.name()
    );
    let window = window(o);
    let mut page = Page::new("Friction force from the measured displacement", &lead)
        .paragraph(
            "The beam is known: its natural frequencies, damping and mass. The friction force on its tip is not, so it is estimated \
             together with the motion from the measured displacement (Stelter 1992, section 5, and Kalman smoothers).",
        )
        .table(&summary(o))
        .list(&o.remarks)
        .section("Force over time")
        .figures(&[&force(o, &window), &motion(o, &window), &velocity(o, &window)])
        .section("Friction characteristic")
        .figures(&[&characteristic(o), &hysteresis(o)]);
    if !o.laws.is_empty() {
        page = page
            .paragraph("Laws fitted to the characteristic, best first, with 95 % intervals; the names are those of the FMU.")
            .table(&laws(&o.laws));
    }
    if let Some(dwell) = &o.dwell {
        let verdict = format!("Verdict: {}.", dwell.verdict());
        page = page
            .section("Break-away")
            .paragraph(&verdict)
            .figure(&break_away(o));
    }
    page.section("The paper's observer beside it")
        .paragraph(
            "Difference of the pole-placed observer's force from the force above, over the spread of the force, for several pole speeds. \
             It knows only the past, so it is late; the last column has the delay taken out.",
        )
        .table(&poles(o))
        .html()
}

fn summary(o: &Observation) -> Table {
    let row = |t: Table, name: &str, value: String| {
        t.row(vec![Cell::Text(name.into()), Cell::Number(value)])
    };
    let frequencies: Vec<String> = o
        .structure
        .modes()
        .iter()
        .map(|m| with_unit(m.frequency_hz, "Hz"))
        .collect();
    let mut table = Table::new(&["quantity", "value"]);
    table = row(table, "natural frequencies", frequencies.join(", "));
    table = row(table, "sensor noise", with_unit(o.noise_std, "m"));
    table = row(
        table,
        "share of time in stick",
        number(o.stick_fraction(), 3),
    );
    table = row(table, "complete stick phases", o.sticks().to_string());
    table = row(
        table,
        "largest autocorrelation of the innovation (below 0.3 is good)",
        number(o.whiteness.largest_autocorrelation(), 2),
    );
    if let Some(d) = &o.dwell {
        table = row(
            table,
            "static coefficient",
            format!("{} ± {}", number(d.mu_mean, 3), number(d.mu_std, 2)),
        );
    }
    table
}

/// A few phases from the middle of the record.
fn window(o: &Observation) -> std::ops::Range<usize> {
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

fn force(o: &Observation, window: &std::ops::Range<usize>) -> Plot {
    let t = &o.time[window.clone()];
    let f = &o.force[window.clone()];
    let mut plot = Plot::new(
        Axis::linear("time", "s"),
        Axis::linear("friction force", "N"),
    )
    .caption("Friction force on the tip with its 95 % band; stick phases shaded.")
    .shade("stick", Colour::Grey, &sticks(o, window));
    let std = &o.force_std[window.clone()];
    if std.iter().all(|s| s.is_finite()) {
        let low: Vec<f64> = f.iter().zip(std).map(|(f, s)| f - 1.96 * s).collect();
        let high: Vec<f64> = f.iter().zip(std).map(|(f, s)| f + 1.96 * s).collect();
        plot = plot.band("95 %", Colour::Sky, t, &low, &high);
    }
    plot.line("force", Colour::Blue, t, f)
}

fn motion(o: &Observation, window: &std::ops::Range<usize>) -> Plot {
    let kept: Vec<usize> = window
        .clone()
        .filter(|k| o.measured[*k].is_finite())
        .collect();
    let at = |values: &[f64]| -> Vec<f64> { kept.iter().map(|k| values[*k]).collect() };
    Plot::new(
        Axis::linear("time", "s"),
        Axis::linear("tip displacement", "m"),
    )
    .caption("Measured and estimated displacement.")
    .line("measured", Colour::Ink, &at(&o.time), &at(&o.measured))
    .thin_line(
        "estimated",
        Colour::Orange,
        &o.time[window.clone()],
        &o.displacement[window.clone()],
    )
}

fn velocity(o: &Observation, window: &std::ops::Range<usize>) -> Plot {
    Plot::new(
        Axis::linear("time", "s"),
        Axis::linear("relative velocity", "m/s"),
    )
    .caption("Velocity of the tip less that of the belt; zero in stick.")
    .shade("stick", Colour::Grey, &sticks(o, window))
    .line(
        "relative velocity",
        Colour::Green,
        &o.time[window.clone()],
        &o.relative_velocity[window.clone()],
    )
}

fn characteristic(o: &Observation) -> Plot {
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
    let mut plot = Plot::new(Axis::linear("speed of slip", "m/s"), Axis::linear("friction coefficient", "1"))
        .caption("Friction coefficient over the speed of slip (Figure 14 of the paper): binned means with two standard errors, the curve by shooting, and the best law.");
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
        let v: Vec<f64> = bins.iter().map(|b| b.relative_velocity.abs()).collect();
        let column = |f: &dyn Fn(&crate::observer::Bin) -> f64| -> Vec<f64> {
            bins.iter().map(|b| f(b)).collect()
        };
        plot = plot
            .band(
                &format!("{name}, 2 standard errors"),
                Colour::Sky,
                &v,
                &column(&|b| b.mu - 2.0 * b.mu_error),
                &column(&|b| b.mu + 2.0 * b.mu_error),
            )
            .scatter(name, colour, &v, &column(&|b| b.mu));
    }
    let grid: Vec<f64> = (0..=200)
        .map(|i| fastest * (f64::from(i) / 200.0).powi(2))
        .collect();
    if let Some(curve) = &o.curve {
        let mu: Vec<f64> = grid.iter().map(|v| curve.at(*v)).collect();
        plot = plot.line("curve", Colour::Orange, &grid, &mu);
    }
    if let Some(best) = o.best_law() {
        let mu: Vec<f64> = grid.iter().map(|v| best.law.mu(*v)).collect();
        plot = plot.dashed_line(best.law.name(), Colour::Ink, &grid, &mu);
    }
    plot
}

/// Force over relative velocity, coloured by whether the relative velocity rises or falls.
fn hysteresis(o: &Observation) -> Plot {
    let n = o.time.len();
    let every = (n / POINTS).max(1);
    let mut plot = Plot::new(Axis::linear("relative velocity", "m/s"), Axis::linear("friction force", "N"))
        .caption("Force over relative velocity; where the two colours part, friction depends on more than the velocity (hysteresis).");
    for (rising, name, colour) in [
        (true, "accelerating", Colour::Blue),
        (false, "decelerating", Colour::Orange),
    ] {
        let kept: Vec<usize> = (n / 50 + 1..n - n / 50 - 1)
            .step_by(every)
            .filter(|k| (o.relative_velocity[k + 1] > o.relative_velocity[k - 1]) == rising)
            .collect();
        let v: Vec<f64> = kept.iter().map(|k| o.relative_velocity[*k]).collect();
        let f: Vec<f64> = kept.iter().map(|k| o.force[*k]).collect();
        plot = plot.scatter(name, colour, &v, &f);
    }
    plot
}

fn break_away(o: &Observation) -> Plot {
    let events = o.dwell.iter().flat_map(|d| &d.events);
    let (t, mu): (Vec<f64>, Vec<f64>) = events.map(|e| (e.dwell, e.mu)).unzip();
    Plot::new(
        Axis::linear("dwell time", "s"),
        Axis::linear("break-away force / normal force", "1"),
    )
    .caption("Break-away coefficient against the time in stick.")
    .scatter("break-away", Colour::Purple, &t, &mu)
}

fn laws(fits: &[LawFit]) -> Table {
    let mut table = Table::new(&[
        "law",
        "parameter",
        "value",
        "95 % interval",
        "unit",
        "residual",
    ]);
    for fit in fits {
        let name = |first: bool| {
            Cell::Text(if first {
                fit.law.name().into()
            } else {
                String::new()
            })
        };
        if fit.parameters.is_empty() {
            table = table.row(vec![
                name(true),
                Cell::Text("points: see the JSON output".into()),
                Cell::Number(String::new()),
                Cell::Number(String::new()),
                Cell::Text(String::new()),
                Cell::Number(number(fit.residual, 2)),
            ]);
        }
        for (i, p) in fit.parameters.iter().enumerate() {
            table = table.row(vec![
                name(i == 0),
                Cell::Text(p.name.into()),
                Cell::Number(number(p.value, 4)),
                Cell::Number(format!("{} to {}", number(p.low, 4), number(p.high, 4))),
                Cell::Text(p.unit.into()),
                Cell::Number(if i == 0 {
                    number(fit.residual, 2)
                } else {
                    String::new()
                }),
            ]);
        }
    }
    table
}

fn poles(o: &Observation) -> Table {
    let header = ["pole speed", "difference", "difference, delay taken out"];
    o.pole_speeds
        .iter()
        .fold(Table::new(&header), |table, (f, causal, shifted)| {
            table.row(vec![
                Cell::Number(with_unit(*f, "Hz")),
                Cell::Number(number(*causal, 3)),
                Cell::Number(number(*shifted, 3)),
            ])
        })
}
