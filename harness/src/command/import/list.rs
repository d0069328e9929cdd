//! What a logger's file holds, as a table of text.

use crate::error::Error;
use crate::measurement::logger::{Channel, Recording};
use crate::output::print;

/// Prints a file's channels.
pub fn show(recording: &Recording) -> Result<(), Error> {
    use std::fmt::Write as _;
    let mut text = format!(
        "{}: {}, {} channel(s)\n",
        recording.path.display(),
        recording.format,
        recording.channels.len()
    );
    let wide = recording.channels.iter().map(|c| c.name.chars().count());
    let wide = wide.max().unwrap_or(0).max(7);
    let _ = writeln!(
        text,
        "  {:<wide$}  {:<10} {:>9} {:>10}  range",
        "channel", "unit", "samples", "rate in Hz"
    );
    for channel in &recording.channels {
        let unit = match channel.unit() {
            "" => "-",
            unit => unit,
        };
        let rate = channel.even.map_or("-".to_owned(), |(_, rate)| short(rate));
        let _ = writeln!(
            text,
            "  {:<wide$}  {unit:<10} {:>9} {rate:>10}  {}",
            channel.name,
            channel.samples().len(),
            range(channel)
        );
    }
    for (name, value) in recording.scalars() {
        let _ = writeln!(text, "  {name:<wide$}  = {}", short(*value));
    }
    for remark in &recording.remarks {
        let _ = writeln!(text, "  {remark}");
    }
    print(&text)
}

/// A short number as it is, others with five digits.
fn short(value: f64) -> String {
    let plain = value.to_string();
    let size = value.abs();
    if plain.len() <= 8 {
        plain
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (4.0 - size.log10().floor()).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.4e}")
    }
}

fn range(channel: &Channel) -> String {
    let samples = channel.samples();
    if let Some(problem) = channel.problem() {
        return problem;
    }
    let numbers = || samples.iter().copied().filter(|v| v.is_finite());
    let missing = samples.len() - numbers().count();
    let (least, most) = (
        numbers().fold(f64::INFINITY, f64::min),
        numbers().fold(f64::NEG_INFINITY, f64::max),
    );
    let of_missing = match missing {
        0 => String::new(),
        missing => format!(", {missing} not finite"),
    };
    match least <= most {
        true => format!("{} ... {}{of_missing}", short(least), short(most)),
        false => format!("no number{of_missing}"),
    }
}
