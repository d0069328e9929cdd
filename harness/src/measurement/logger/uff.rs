//! Universal files (UFF, UNV): data sets 58, functions of nodes, in text or binary (58b), with the units of data set 164.
//!
//! Source: Structural Dynamics Research Laboratory, University of Cincinnati, Universal File Formats, data sets
//! 58, 58b, 164. A data set stands between two lines `    -1`, begins with its number and, for 58, eleven lines of
//! text, which say what the numbers are.

use super::cursor::{Cursor, Stored};
use super::{Channel, Found, Trouble, names};

/// Lines of text before the numbers of a data set 58.
const HEAD: usize = 11;
const TIME_RESPONSE: usize = 1;
const ANY_FUNCTION: usize = 0;

/// Factors of data set 164: by them lengths and forces of the file are larger than in SI.
#[derive(Clone, Copy)]
struct Units {
    length: f64,
    force: f64,
}

pub fn read(bytes: &[u8]) -> Result<Found, Trouble> {
    let mut lines = Lines {
        bytes,
        at: 0,
        line: 0,
    };
    let mut found = Found::default();
    let mut units = None;
    let mut number = 0;
    while let Some(text) = lines.next() {
        if text.trim().is_empty() {
            continue;
        }
        if text.trim() != "-1" {
            return Err(Trouble::damaged(format!(
                "line {} reads '{}' where a data set should begin with -1",
                lines.line,
                short(&text)
            )));
        }
        let Some(kind) = lines.next() else { break };
        let word = kind
            .split_whitespace()
            .next()
            .unwrap_or_default()
            .to_owned();
        match word.as_str() {
            "58" | "58b" => {
                number += 1;
                // `58b` may stand apart: `    58b` and `    58 b` are both written.
                let is_binary = kind.get(..8).unwrap_or(&kind).contains(['b', 'B']);
                let name = format!("data set {number}");
                if let Some(channels) = function(&mut lines, &kind, is_binary, units, &mut found)
                    .map_err(|t| t.of(&name))?
                {
                    found.channels.extend(channels);
                }
                end(&mut lines).map_err(|t| t.of(&name))?;
            }
            "164" => {
                // The first line has the system's name, the second the factors.
                lines.next();
                let factors = lines.next().unwrap_or_default();
                let numbers: Vec<f64> = factors.split_whitespace().filter_map(real).collect();
                if let [length, force, ..] = numbers.as_slice()
                    && *length > 0.0
                    && *force > 0.0
                {
                    units = Some(Units {
                        length: *length,
                        force: *force,
                    });
                }
                skip(&mut lines);
            }
            other => {
                if other != "151" {
                    found.remarks.push(format!("data set {other} not read"));
                }
                skip(&mut lines);
            }
        }
    }
    Ok(found)
}

/// Lines of a file that may have binary stretches.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Number of the last line, counted from 1.
    line: usize,
}

impl Lines<'_> {
    fn next(&mut self) -> Option<String> {
        if self.at >= self.bytes.len() {
            return None;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        self.line += 1;
        let text = String::from_utf8_lossy(&rest[..length]).into_owned();
        Some(text.trim_end_matches('\r').to_owned())
    }

    /// The next line, without passing it.
    fn peek(&mut self) -> Option<String> {
        let (at, line) = (self.at, self.line);
        let next = self.next();
        (self.at, self.line) = (at, line);
        next
    }
}

fn short(text: &str) -> String {
    text.trim().chars().take(40).collect()
}

fn skip(lines: &mut Lines) {
    while let Some(text) = lines.next() {
        if text.trim_end() == "    -1" {
            break;
        }
    }
}

/// Passes the line that ends a data set.
fn end(lines: &mut Lines) -> Result<(), Trouble> {
    loop {
        match lines.next() {
            Some(text) if text.trim().is_empty() => {}
            Some(text) if text.trim() == "-1" => return Ok(()),
            Some(text) => {
                return Err(Trouble::damaged(format!(
                    "line {} reads '{}' where the data set should end with -1",
                    lines.line,
                    short(&text)
                )));
            }
            None => {
                return Err(Trouble::damaged("the file ends within the data set"));
            }
        }
    }
}

/// A number as Fortran writes it.
fn real(word: &str) -> Option<f64> {
    word.replace(['D', 'd'], "e").parse().ok()
}

fn fields(line: &str, from: usize, widths: &[usize]) -> Vec<String> {
    let characters: Vec<char> = line.chars().collect();
    let mut at = from;
    let cut = |width: &usize| {
        let begin = at.min(characters.len());
        let end = (at + width).min(characters.len());
        at += width;
        characters[begin..end]
            .iter()
            .collect::<String>()
            .trim()
            .to_owned()
    };
    widths.iter().map(cut).collect()
}

fn function(
    lines: &mut Lines,
    kind: &str,
    is_binary: bool,
    units: Option<Units>,
    found: &mut Found,
) -> Result<Option<Vec<Channel>>, Trouble> {
    let mut head = Vec::new();
    for _ in 0..HEAD {
        let line = lines
            .next()
            .ok_or_else(|| Trouble::damaged("the file ends within the head of the data set"))?;
        head.push(line);
    }
    let words: Vec<&str> = head[5].split_whitespace().collect();
    let function: usize = words.first().and_then(|w| w.parse().ok()).unwrap_or(0);
    let form: Vec<&str> = head[6].split_whitespace().collect();
    let at = |i: usize| form.get(i).copied().unwrap_or_default();
    let not_read = |what: &str| {
        Trouble::damaged(format!(
            "the line of the form reads '{}', {what}",
            short(&head[6])
        ))
    };
    let ordinate: u32 = at(0).parse().map_err(|_| not_read("no type of numbers"))?;
    let count: usize = at(1).parse().map_err(|_| not_read("no number of points"))?;
    let is_even = at(2) == "1";
    let start = real(at(3)).ok_or_else(|| not_read("no first abscissa"))?;
    let step = real(at(4)).ok_or_else(|| not_read("no increment"))?;
    let is_double = matches!(ordinate, 4 | 6);
    let is_complex = matches!(ordinate, 5 | 6);
    if !matches!(ordinate, 2 | 4 | 5 | 6) {
        return Err(not_read("2 or 4 (real), 5 or 6 (complex) must come first"));
    }
    let per_point = 1 + usize::from(is_complex) + usize::from(!is_even);
    let values = if is_binary {
        binary(lines, kind, (count, per_point, is_double))?
    } else {
        text(lines, (count, per_point, is_double, is_even))?
    };
    let name = name(&head);
    if is_complex || !matches!(function, TIME_RESPONSE | ANY_FUNCTION) {
        found.remarks.push(format!(
            "'{name}' is a function of type {function}, no time response, not read"
        ));
        return Ok(None);
    }
    let axis = |line: &str| {
        let labels = fields(line, 26, &[20, 1, 20]);
        let code: usize = line
            .split_whitespace()
            .next()
            .and_then(|w| w.parse().ok())
            .unwrap_or(0);
        (code, labels[2].clone())
    };
    let (time_code, time_unit) = axis(&head[7]);
    if !matches!(time_code, 0 | 1 | 17) {
        found
            .remarks
            .push(format!("'{name}' is no function of time, not read"));
        return Ok(None);
    }
    let time_factor = names::unit_of(&time_unit).0.map_or(1.0, |unit| unit.factor);
    let (code, label) = axis(&head[8]);
    let quantity = quantity(code);
    let describe = |values: Vec<f64>| {
        let mut channel = Channel {
            kind: quantity,
            ..Channel::new(&name, values)
        };
        channel.name.clone_from(&name);
        let channel = channel.with_unit(&label);
        match (channel.unit, units) {
            (None, Some(units)) if channel.strange_unit.is_none() => of_set(channel, code, units),
            _ => channel,
        }
    };
    if is_even {
        if !(step > 0.0) {
            return Err(not_read("the increment must be greater than zero"));
        }
        let mut channel = describe(values);
        channel.even = Some((start * time_factor, 1.0 / (step * time_factor)));
        return Ok(Some(vec![channel]));
    }
    let times = values.iter().step_by(2).map(|t| t * time_factor).collect();
    let signal = values.iter().skip(1).step_by(2).copied().collect();
    let times = Channel::new(&format!("{name}/time"), times).with_unit("s");
    let mut signal = describe(signal);
    signal.name = format!("{name}/value");
    Ok(Some(vec![times, signal]))
}

/// What the code of an axis says is measured.
fn quantity(code: usize) -> Option<&'static str> {
    Some(match code {
        2 => "a stress",
        3 => "a strain",
        5 => "a temperature",
        8 => "a length",
        9 | 13 => "a force",
        11 => "a velocity",
        12 => "an acceleration",
        15 => "a pressure",
        19 => "a speed of rotation",
        _ => return None,
    })
}

/// Values in the units of data set 164, taken to SI.
fn of_set(mut channel: Channel, code: usize, units: Units) -> Channel {
    let (factor, unit) = match code {
        8 => (units.length, "m"),
        9 | 13 => (units.force, "N"),
        11 => (units.length, "m/s"),
        12 => (units.length, "m/s2"),
        _ => return channel,
    };
    if factor != 1.0
        && let Ok(values) = &mut channel.values
    {
        values.iter_mut().for_each(|v| *v /= factor);
    }
    channel.with_unit(unit)
}

/// The first line of text, unless it says nothing; else node and direction.
fn name(head: &[String]) -> String {
    let id = head[0].trim();
    if !id.is_empty() && !id.eq_ignore_ascii_case("none") {
        return id.to_owned();
    }
    // Function, number, version, load case, then the response: name of 10, node of 10, direction of 4.
    let response = fields(&head[5], 31, &[10, 10, 4]);
    let direction: i32 = response[2].parse().unwrap_or(0);
    let axis = match direction.abs() {
        1 => "x",
        2 => "y",
        3 => "z",
        4 => "rx",
        5 => "ry",
        6 => "rz",
        _ => "",
    };
    let sign = if direction < 0 { "-" } else { "" };
    format!("node{}{sign}{axis}", response[1])
}

/// The numbers of a data set in text.
fn text(
    lines: &mut Lines,
    (count, per_point, is_double, is_even): (usize, usize, bool, bool),
) -> Result<Vec<f64>, Trouble> {
    let wanted = count.saturating_mul(per_point);
    let mut values = Vec::new();
    while values.len() < wanted {
        let is_end = |text: &String| text.trim_end() == "    -1";
        let Some(line) = lines.peek().filter(|line| !is_end(line)) else {
            return Err(Trouble::damaged(format!(
                "{count} points are announced and {} are there",
                values.len() / per_point
            )));
        };
        lines.next();
        let words: Vec<&str> = line.split_whitespace().collect();
        let by_spaces: Option<Vec<f64>> = words.iter().map(|word| real(word)).collect();
        // Numbers may touch each other: then they stand in columns of 13 or 20 places.
        let fit = by_spaces.or_else(|| {
            let widths: &[usize] = match (is_double, is_even) {
                (false, _) => &[13; 6],
                (true, true) => &[20; 4],
                (true, false) => &[13, 20, 13, 20],
            };
            let cut = fields(&line, 0, widths).into_iter();
            cut.filter(|f| !f.is_empty()).map(|f| real(&f)).collect()
        });
        let Some(numbers) = fit else {
            return Err(Trouble::damaged(format!(
                "line {} reads '{}' where numbers should stand",
                lines.line,
                short(&line)
            )));
        };
        values.extend(numbers);
    }
    let next = lines.peek().unwrap_or_default();
    let goes_on = next.trim() != "-1" && next.split_whitespace().next().and_then(real).is_some();
    if values.len() > wanted || goes_on {
        return Err(Trouble::damaged(format!(
            "{count} points are announced and more follow, up to line {} at least",
            lines.line + usize::from(goes_on)
        )));
    }
    Ok(values)
}

/// The numbers of a data set 58b.
fn binary(
    lines: &mut Lines,
    kind: &str,
    (count, per_point, is_double): (usize, usize, bool),
) -> Result<Vec<f64>, Trouble> {
    // `58b`, byte order, form of numbers, lines of text, bytes.
    let form = kind.replace(['b', 'B'], " ");
    let words: Vec<usize> = form
        .split_whitespace()
        .skip(1)
        .filter_map(|word| word.parse().ok())
        .collect();
    let [order, form, _, bytes, ..] = words.as_slice() else {
        return Err(Trouble::damaged(format!(
            "the first line reads '{}', no form of binary numbers",
            short(kind)
        )));
    };
    if *form != 2 {
        return Err(Trouble::new(
            format!("binary numbers of form {form}; form 2 (IEEE 754) can be read"),
            "export the file as text (data set 58)",
        ));
    }
    let wanted = count.saturating_mul(per_point);
    let wide = if is_double { 8 } else { 4 };
    let stored = if is_double { Stored::F64 } else { Stored::F32 };
    let rest = &lines.bytes[lines.at..];
    // Some writers count the ordinates alone: what counts is where the data set ends.
    let ends_behind = |bytes: usize| {
        let rest = rest.get(bytes..).unwrap_or_default();
        let rest = rest.strip_prefix(b"\r").unwrap_or(rest);
        rest.strip_prefix(b"\n")
            .unwrap_or(rest)
            .starts_with(b"    -1")
    };
    let whole = wanted.saturating_mul(wide);
    let bytes = match ends_behind(whole) && !ends_behind(*bytes) {
        true => whole,
        false => *bytes,
    };
    let mut rest = Cursor::new(rest);
    rest.big_end_first = *order == 2;
    let mut data = rest.part(bytes).map_err(|trouble| {
        Trouble::damaged(format!("{bytes} bytes of numbers: {}", trouble.problem))
    })?;
    lines.at += bytes;
    // Abscissas may be single where ordinates are double.
    if is_double && per_point == 2 && bytes == count.saturating_mul(12) {
        let mut values = Vec::new();
        for _ in 0..count {
            values.push(Stored::F32.read(&mut data)?);
            values.push(Stored::F64.read(&mut data)?);
        }
        return Ok(values);
    }
    if wanted.checked_mul(wide) != Some(bytes) {
        return Err(Trouble::damaged(format!(
            "{count} points of {per_point} numbers with {wide} bytes are announced, and {bytes} bytes"
        )));
    }
    stored.all(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A data set of four points, its ordinate without a unit.
    fn set(form: &str, data: &str) -> String {
        format!(
            "    -1\n    58\nNONE\nNONE\nNONE\nNONE\nNONE\n    1         0    0         0       NONE        12  -3       NONE         0   0\n\
             {form}\n        17    0    0    0 time                 ms\n         8    0    0    0 NONE                 NONE\n\
             \u{20}        0    0    0    0 NONE                 NONE\n         0    0    0    0 NONE                 NONE\n{data}    -1\n"
        )
    }

    #[test]
    fn units_of_the_file_and_uneven_points_are_understood() {
        let units = "    -1\n   164\n         5mm (milli-newton)           2\n  1.00000D+03  1.00000D+03  1.00000D+00\n  2.73150D+02\n    -1\n";
        let uneven = set(
            "         2         4         0  0.00000e+00  0.00000e+00  0.00000e+00",
            "  0.00000e+00 -1.00000e+00  1.00000e+00  2.00000e+00  2.50000e+00  3.00000e+00\n  4.00000e+00  4.00000e+00\n",
        );
        let found = read(format!("{units}{uneven}").as_bytes()).unwrap();
        let [time, value] = found.channels.as_slice() else {
            panic!("{:?}", found.channels)
        };
        assert_eq!(time.samples(), [0.0, 1e-3, 2.5e-3, 4e-3]);
        assert_eq!(value.samples(), [-1e-3, 2e-3, 3e-3, 4e-3]);
        assert_eq!((value.name.as_str(), value.unit()), ("node12-z/value", "m"));
    }

    #[test]
    fn numbers_that_touch_are_told_apart_by_their_columns() {
        let touching = set(
            "         2         4         1  0.00000e+00  2.00000e+00  0.00000e+00",
            " 1.00000e-100-2.00000e-100-3.00000e-100-4.00000e-100\n",
        );
        let found = read(touching.as_bytes()).unwrap();
        assert_eq!(found.channels[0].samples()[3], -4e-100);
        assert_eq!(found.channels[0].even, Some((0.0, 500.0)));
    }
}
