//! Turns of phrase that error messages share.

/// Up to three of `known` that look like `name`, best first.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut scored: Vec<(f64, &str)> = known
        .into_iter()
        .map(|k| {
            (
                strsim::jaro_winkler(&name.to_lowercase(), &k.to_lowercase()),
                k,
            )
        })
        .filter(|(score, _)| *score > 0.75)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored
        .into_iter()
        .take(3)
        .map(|(_, k)| k.to_owned())
        .collect()
}

/// `:12`, or nothing.
pub fn at_line(line: Option<usize>) -> String {
    line.map(|l| format!(":{l}")).unwrap_or_default()
}

/// `channel 'x': `, or nothing.
pub fn of_channel(channel: Option<&str>) -> String {
    channel
        .map(|name| format!("channel '{name}': "))
        .unwrap_or_default()
}

/// A value with its unit; ratios have none.
pub fn with_unit(value: f64, unit: &str) -> String {
    if unit == "1" {
        value.to_string()
    } else {
        format!("{value} {unit}")
    }
}

/// 'a', 'b'.
pub fn quoted(names: &[String]) -> String {
    if names.is_empty() {
        return "nothing".into();
    }
    names
        .iter()
        .map(|n| format!("'{n}'"))
        .collect::<Vec<_>>()
        .join(", ")
}

/// What was probably meant.
pub fn suggestion(nearest: &[String]) -> String {
    if nearest.is_empty() {
        String::new()
    } else {
        format!("; did you mean {}?", quoted(nearest))
    }
}

/// What an FMU said, or that it said nothing.
pub fn or_silent(messages: &str) -> &str {
    if messages.is_empty() {
        "the FMU logged no reason"
    } else {
        messages
    }
}
