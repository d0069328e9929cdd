//! The summary for the terminal.

use std::fmt::Write as _;

use console::style;

use super::series::Series;
use crate::dimension::Analysis;
use crate::metric::half_width;
use crate::report::{number, with_unit};

/// `value` samples, and in seconds where the interval is known.
pub fn samples(value: f64, series: &Series) -> String {
    let count = number(value, 4);
    match series.interval {
        Some(dt) => format!("{count} samples ({})", with_unit(value * dt, "s")),
        None => format!("{count} samples"),
    }
}

/// Names and values of the summary, for terminal and page.
pub fn rows(series: &Series, a: &Analysis) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    let mut row = |name: &str, value: String| rows.push((name.to_owned(), value));
    if let Some(d) = a.dimension() {
        let std = a.std.map_or(String::new(), |s| {
            format!(" ± {} (95 %)", number(half_width(s), 2))
        });
        row("correlation dimension", format!("{d:.3}{std}"));
    }
    row("samples", samples(a.samples as f64, series));
    row("delay", samples(a.delay as f64, series));
    row("Theiler window", samples(a.theiler as f64, series));
    if let Some(r) = &a.region {
        row(
            "scaling region",
            format!(
                "{} to {} ({:.1} octaves), m = {} to {}, slope {:.3}",
                with_unit(r.from, &series.unit),
                with_unit(r.to, &series.unit),
                r.octaves(),
                r.dimensions.0,
                r.dimensions.1,
                r.slope
            ),
        );
    }
    if let (Some(r), Some(c)) = (&a.region, a.convergence) {
        row(
            "change over m",
            format!(
                "{:+.3} ± {:.3} (95 %) from m = {} to {}, {}",
                c.change,
                half_width(c.std),
                r.dimensions.0,
                r.dimensions.1,
                if c.is_plateau() {
                    "a plateau"
                } else {
                    "no plateau"
                }
            ),
        );
    }
    row("returns", a.returns.to_string());
    if let Some(takens) = a.takens {
        row("Takens' estimate", number(takens, 3));
    }
    row(
        "surrogates",
        format!(
            "{}, z = {}, p = {}",
            a.surrogates.surrogates.len(),
            number(a.surrogates.z, 2),
            number(a.surrogates.p_value, 2)
        ),
    );
    row(
        "bound 2 log10 N",
        format!(
            "{:.1} (necessary, not sufficient)",
            a.eckmann_ruelle_bound()
        ),
    );
    if let Some(d) = &a.divergence {
        let (value, std, unit) = match series.interval {
            Some(dt) => (d.exponent / dt, d.std / dt, "1/s"),
            None => (d.exponent, d.std, "1/sample"),
        };
        row(
            "largest Lyapunov exponent",
            format!(
                "{} ± {} {unit} (95 %)",
                number(value, 3),
                number(half_width(std), 2)
            ),
        );
    }
    if let Some(p) = a.period.filter(|p| p.repeats()) {
        row(
            "period",
            format!(
                "{}, misfit {}",
                samples(p.period, series),
                number(p.after_many, 2)
            ),
        );
    }
    if let Some(r) = a.noise_radius {
        row("noise below", with_unit(r, &series.unit));
    }
    rows
}

/// A dozen lines.
pub fn summary(series: &Series, a: &Analysis) -> String {
    let mut text = format!(
        "{}: {}\n\n",
        style(&series.name).bold(),
        style(a.verdict.title()).bold()
    );
    for (name, value) in rows(series, a) {
        let _ = writeln!(text, "  {name:<26} {value}");
    }
    let _ = writeln!(text, "  {}", a.verdict.meaning());
    for remark in &a.remarks {
        let _ = writeln!(text, "  {}", style(remark).yellow());
    }
    text.push('\n');
    text
}
