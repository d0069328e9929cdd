//! HDF5, and MATLAB 7.3, which is HDF5 with conventions of its own.

use std::collections::HashMap;

use hdf5_pure::{AttrValue, DType, Dataset, File, Group};

use super::{Channel, Found, Trouble, mat5, names};

/// Groups in groups.
const DEEPEST: usize = 16;
/// Numbers of one data set.
const MOST: u64 = 500_000_000;
/// Data sets that are read.
const MOST_SETS: usize = 4096;

const UNIT: [&str; 4] = ["unit", "units", "unit_string", "ni_unitdescription"];
const INTERVAL: [&str; 8] = [
    "dt",
    "delta_t",
    "increment",
    "wf_increment",
    "interval",
    "sample_interval",
    "sampling_interval",
    "ts",
];
const RATE: [&str; 8] = [
    "fs",
    "rate",
    "sample_rate",
    "samplerate",
    "sampling_rate",
    "sampling_frequency",
    "sample_rate_hz",
    "sr",
];

pub fn read(bytes: Vec<u8>) -> Result<Found, Trouble> {
    let file = File::from_bytes(bytes).map_err(damaged)?;
    let mut reader = Reader::default();
    reader.group(&file.root(), "", None, 0)?;
    names::units_beside(&mut reader.found.channels, &reader.texts);
    Ok(reader.found)
}

fn damaged(error: hdf5_pure::Error) -> Trouble {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default();
    Trouble::damaged(format!("not whole ({first})"))
}

#[derive(Default)]
struct Reader {
    found: Found,
    texts: Vec<(String, String)>,
}

type Attributes = HashMap<String, AttrValue>;

impl Reader {
    fn group(
        &mut self,
        group: &Group,
        path: &str,
        above: Option<(f64, f64)>,
        depth: usize,
    ) -> Result<(), Trouble> {
        let even = even(&group.attrs().unwrap_or_default()).or(above);
        let mut sets = group.datasets().map_err(damaged)?;
        sets.sort_by_key(|name| name.to_lowercase());
        for name in sets {
            if self.found.channels.len() >= MOST_SETS {
                return Ok(());
            }
            let whole = format!("{path}{name}");
            let set = group.dataset(&name).map_err(|e| damaged(e).of(&whole))?;
            self.dataset(&set, &whole, even).map_err(|t| t.of(&whole))?;
        }
        let mut inner = group.groups().map_err(damaged)?;
        inner.sort();
        // What cells of MATLAB point to.
        inner.retain(|name| !name.starts_with('#'));
        for name in inner {
            if depth >= DEEPEST {
                break;
            }
            let whole = format!("{path}{name}/");
            let inside = group.group(&name).map_err(|e| damaged(e).of(&whole))?;
            self.group(&inside, &whole, even, depth + 1)?;
        }
        Ok(())
    }

    fn dataset(
        &mut self,
        set: &Dataset,
        name: &str,
        above: Option<(f64, f64)>,
    ) -> Result<(), Trouble> {
        let attributes = set.attrs().unwrap_or_default();
        let kind = set.dtype().map_err(damaged)?;
        let class = text(&attributes, &["matlab_class"]);
        match kind {
            DType::String | DType::VariableLengthString => {
                if let Ok(texts) = set.read_string()
                    && let [one] = texts.as_slice()
                {
                    self.texts.push((name.to_owned(), one.clone()));
                }
                return Ok(());
            }
            DType::F32
            | DType::F64
            | DType::I8
            | DType::I16
            | DType::I32
            | DType::I64
            | DType::U8
            | DType::U16
            | DType::U32
            | DType::U64 => {}
            other => {
                let other = match other {
                    DType::Compound(_) => "a table of records".to_owned(),
                    other => format!("of type {other}"),
                };
                self.found.remarks.push(format!(
                    "'{name}' is {other}, not read: save each of its columns as an array"
                ));
                return Ok(());
            }
        }
        let shape = set.shape().map_err(damaged)?;
        let count = shape.iter().try_fold(1u64, |all, d| all.checked_mul(*d));
        if count.is_none_or(|count| count > MOST) {
            return Err(Trouble::damaged(format!(
                "an array of {shape:?} is announced, {MOST} numbers are the most"
            )));
        }
        if is_empty_in_matlab(&attributes) {
            self.found.channels.push(Channel::new(name, Vec::new()));
            return Ok(());
        }
        if class.as_deref() == Some("char") {
            let characters = set.read_u16().map_err(damaged)?;
            let text = String::from_utf16_lossy(&characters);
            self.texts.push((name.to_owned(), text));
            return Ok(());
        }
        let values = set.read_f64().map_err(damaged)?;
        // Rows come first in HDF5, columns in `array`.
        let dimensions: Vec<usize> = shape.iter().rev().map(|d| *d as usize).collect();
        let before = self.found.channels.len();
        mat5::array(&mut self.found, name, &dimensions, values)?;
        let unit = text(&attributes, &UNIT);
        let even = even(&attributes).or(above);
        for channel in &mut self.found.channels[before..] {
            channel.even = even;
            if let Some(unit) = &unit {
                *channel = channel.clone().with_unit(unit);
            }
        }
        Ok(())
    }
}

/// MATLAB stores the size of what is empty in its place.
fn is_empty_in_matlab(attributes: &Attributes) -> bool {
    number(attributes, &["matlab_empty"]).is_some_and(|empty| empty != 0.0)
}

fn find<'a>(attributes: &'a Attributes, names: &[&str]) -> Option<&'a AttrValue> {
    let is = |name: &str| names.iter().any(|known| name.eq_ignore_ascii_case(known));
    let mut found: Vec<_> = attributes.iter().filter(|(name, _)| is(name)).collect();
    found.sort_by_key(|(name, _)| (*name).clone());
    found.first().map(|(_, value)| *value)
}

fn text(attributes: &Attributes, names: &[&str]) -> Option<String> {
    match find(attributes, names)? {
        AttrValue::String(text) | AttrValue::AsciiString(text) => Some(text.clone()),
        AttrValue::StringArray(texts) => texts.first().cloned(),
        AttrValue::F64(_) | AttrValue::F32(_) => None,
        other => quoted(&format!("{other:?}")),
    }
}

/// The first text in quotation marks of what has a text in another form.
fn quoted(shown: &str) -> Option<String> {
    let inside = shown.split('"').nth(1)?;
    Some(inside.to_owned())
}

fn number(attributes: &Attributes, names: &[&str]) -> Option<f64> {
    Some(match find(attributes, names)? {
        AttrValue::F64(v) => *v,
        AttrValue::F64Array(v) => *v.first()?,
        AttrValue::F32(v) => f64::from(*v),
        AttrValue::I64(v) => *v as f64,
        AttrValue::U64(v) => *v as f64,
        AttrValue::I32(v) => f64::from(*v),
        AttrValue::U32(v) => f64::from(*v),
        AttrValue::I16(v) => f64::from(*v),
        AttrValue::U16(v) => f64::from(*v),
        AttrValue::I8(v) => f64::from(*v),
        AttrValue::U8(v) => f64::from(*v),
        AttrValue::I64Array(v) => *v.first()? as f64,
        _ => return None,
    })
}

/// Start and samples per second.
fn even(attributes: &Attributes) -> Option<(f64, f64)> {
    let start = number(attributes, &["t0", "start", "wf_start_offset"]).unwrap_or(0.0);
    let rate = number(attributes, &RATE)
        .or_else(|| number(attributes, &INTERVAL).map(|interval| 1.0 / interval));
    rate.filter(|rate| *rate > 0.0 && rate.is_finite())
        .map(|rate| (if start.is_finite() { start } else { 0.0 }, rate))
}
