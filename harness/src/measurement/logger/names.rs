//! Names and units as loggers write them.

use std::collections::HashMap;

use super::super::unit::{self, Name, Unit};
use super::Channel;

/// Words for no unit at all.
const NONE: [&str; 8] = ["", "none", "null", "n/a", "-", "unknown", "arb", "a.u."];

/// A unit known, or one that is not, as it is written.
pub fn unit_of(text: &str) -> (Option<Unit>, Option<String>) {
    let text = text.trim().trim_end_matches('\0').trim();
    if NONE.iter().any(|none| text.eq_ignore_ascii_case(none)) {
        return (None, None);
    }
    match find(text) {
        Some(unit) => (Some(unit), None),
        None => (None, Some(text.to_owned())),
    }
}

pub fn find(text: &str) -> Option<Unit> {
    let text = match text.eq_ignore_ascii_case("volts dc") {
        true => "V",
        false => text,
    };
    unit::find(text)
}

/// What a unit measures that the table of units has not, in words.
pub fn strange_quantity(text: &str) -> Option<&'static str> {
    let text = text.replace(['\u{b5}', '\u{3bc}'], "u").to_lowercase();
    let is = |list: &[&str]| list.contains(&text.as_str());
    if is(&[
        "strain",
        "ustrain",
        "microstrain",
        "ue",
        "um/m",
        "m/m",
        "mm/m",
        "u\u{3b5}",
    ]) {
        return Some("a strain");
    }
    if is(&["pa", "kpa", "mpa", "bar", "psi"]) {
        return Some("a pressure or stress");
    }
    is(&["grms"]).then_some("an acceleration")
}

/// A name with a unit in it: its name, its unit.
pub fn taken_apart(full: &str) -> (String, Option<Unit>, Option<String>) {
    let full = full.trim().trim_end_matches('\0').trim();
    // A slash separates groups too: only the last name may have a unit.
    let cut = |text: &str| text.rfind(['[', '(']).unwrap_or(text.len());
    let group_end = full[..cut(full)].rfind('/').map_or(0, |at| at + 1);
    let name = Name::read(&full[group_end..]);
    if let Some(unit) = name.unit {
        return (
            format!("{}{}", &full[..group_end], name.bare),
            Some(unit),
            None,
        );
    }
    // `w/mm` is a name with its unit, `rig/mm` could be a group: a known unit behind the only slash.
    let whole = Name::read(full);
    if let Some(unit) = whole.unit {
        return (whole.bare, Some(unit), None);
    }
    let in_brackets = |open: char, close: char| {
        let (bare, text) = full.strip_suffix(close)?.rsplit_once(open)?;
        (!bare.trim().is_empty()).then(|| (bare.trim().to_owned(), text.trim().to_owned()))
    };
    match in_brackets('[', ']').or_else(|| {
        in_brackets('(', ')')
            .filter(|(_, text)| find(text).is_some() || strange_quantity(text).is_some())
    }) {
        Some((bare, text)) => {
            let (unit, strange) = unit_of(&text);
            (bare, unit, strange)
        }
        None => (full.to_owned(), of_suffix(full), None),
    }
}

/// The unit behind the last underscore: `t_ms`, `x_um`. Short ones count in names that leave no doubt.
fn of_suffix(name: &str) -> Option<Unit> {
    let lower = name.to_lowercase();
    let known = [
        ("time_s", "s"),
        ("displacement_m", "m"),
        ("force_n", "N"),
        ("_mm_per_s", "mm/s"),
        ("_m_per_s", "m/s"),
        ("_ms", "ms"),
        ("_us", "us"),
        ("_mm", "mm"),
        ("_um", "um"),
        ("_kn", "kN"),
    ];
    let found = known.iter().find(|(end, _)| lower.ends_with(end))?;
    unit::find(found.1)
}

/// Numbers names that several channels have.
pub fn make_unlike(channels: &mut [Channel]) {
    let mut seen: HashMap<String, usize> = HashMap::new();
    for channel in channels.iter() {
        *seen.entry(channel.name.clone()).or_default() += 1;
    }
    let mut numbers: HashMap<String, usize> = HashMap::new();
    for channel in channels.iter_mut() {
        if seen[&channel.name] > 1 {
            let number = numbers.entry(channel.name.clone()).or_default();
            *number += 1;
            channel.name = format!("{}#{number}", channel.name);
        }
    }
}

/// States units that stand in texts beside the channels: `x_unit` beside `x`, `x.unit` in it, or `unit` in a group
/// with a single channel that has none.
pub fn units_beside(channels: &mut [Channel], texts: &[(String, String)]) {
    for (name, text) in texts {
        let lower = name.to_lowercase();
        let of = ["_units", "_unit", "/units", "/unit"]
            .iter()
            .find_map(|end| lower.strip_suffix(end).map(|rest| &name[..rest.len()]));
        let Some(of) = of else { continue };
        if let Some(channel) = channels.iter_mut().find(|c| c.name == of) {
            *channel = channel.clone().with_unit(text);
            continue;
        }
        let group = format!("{of}/");
        let (unit, _) = unit_of(text);
        let mut inside: Vec<&mut Channel> = channels
            .iter_mut()
            .filter(|c| c.name.starts_with(&group) && c.unit.is_none())
            .filter(|c| !super::role::is_time_name(c.last_name()))
            .collect();
        if let [one] = inside.as_mut_slice()
            && unit.is_some()
        {
            one.unit = unit;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_and_units_are_told_apart() {
        let cases = [
            ("x [mm]", "x", "mm", ""),
            ("Group/laser (um)", "Group/laser", "um", ""),
            ("rig/run 1/x", "rig/run 1/x", "", ""),
            ("v [mm/s]", "v", "mm/s", ""),
            ("t/ms", "t", "ms", ""),
            ("bridge [um/m]", "bridge", "", "um/m"),
            ("w (tip)", "w (tip)", "", ""),
            ("t_ms", "t_ms", "ms", ""),
        ];
        for (full, name, unit, strange) in cases {
            let found = taken_apart(full);
            assert_eq!(found.0, name, "{full}");
            assert_eq!(found.1.map_or("", |u| u.symbol), unit, "{full}");
            assert_eq!(found.2.unwrap_or_default(), strange, "{full}");
        }
    }
}
