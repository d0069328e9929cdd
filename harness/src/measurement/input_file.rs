//! Inputs from a file of their own, for runs that are only simulated.

use std::path::Path;

use super::table::Table;
use super::unit::{Name, Quantity};
use super::{InputSeries, InputTrack, Interpolation, Sampling};
use crate::error::Error;
use crate::wording::nearest;

/// Names of a column of times.
const TIMES: [&str; 3] = ["time", "time_s", "t"];

/// Reads a table of inputs: a column of times, and one for each input under the FMU's name; units in the header are taken to
/// SI. The first time is the simulation's start.
///
/// # Errors
/// [`Error`] with line and column where the file can't be read as such, or where a value is missing.
pub fn read_inputs(
    path: &Path,
    interpolation: Option<Interpolation>,
) -> Result<Vec<(String, InputTrack)>, Error> {
    let table = Table::read(path, None)?;
    let names = &table.names;
    let is_time =
        |name: &Name| TIMES.contains(&name.bare.as_str()) || name.measures(Quantity::Time);
    let factor = |column: usize| names[column].unit.map_or(1.0, |unit| unit.factor);
    let time_at = names.iter().position(is_time).ok_or_else(|| {
        table.lacks(Error::MissingColumn {
            path: path.to_owned(),
            line: table.header_line,
            column: "time".into(),
            key: "time",
            present: names.iter().map(|n| n.full.clone()).collect(),
            nearest: nearest("time", names.iter().map(|n| n.full.as_str())),
        })
    })?;
    let lines: Vec<u64> = table.lines().collect();
    let column = |at: usize| -> Result<Vec<f64>, Error> {
        if let Some(text) = &names[at].strange {
            return Err(Error::CsvRecord {
                path: path.to_owned(),
                line: table.header_line,
                problem: format!(
                    "'{}' is in {text}, a unit that is not known; write it in SI units and name that unit, or drop the brackets",
                    names[at].full
                ),
            });
        }
        let [mut values] = table.columns([at])?;
        if let Some(row) = values.iter().position(|v| v.is_nan()) {
            return Err(Error::CsvRecord {
                path: path.to_owned(),
                line: lines[row],
                problem: format!(
                    "'{}' has no value; an input must be known throughout, leave the row out",
                    names[at].full
                ),
            });
        }
        values.iter_mut().for_each(|v| *v *= factor(at));
        Ok(values)
    };
    let mut time = column(time_at)?;
    if time.len() < 2 {
        return Err(Error::TooFewSamples {
            path: path.to_owned(),
            samples: time.len(),
            needed: 2,
        });
    }
    if let Some(row) = (1..time.len()).find(|i| time[*i] <= time[i - 1]) {
        return Err(Error::TimeNotIncreasing {
            path: path.to_owned(),
            line: lines[row],
            previous: time[row - 1],
            value: time[row],
        });
    }
    let start = time[0];
    time.iter_mut().for_each(|t| *t -= start);
    let sampling = Sampling::of(&time);
    let chosen = interpolation.unwrap_or_else(|| Interpolation::usual(&sampling));
    let mut tracks = Vec::new();
    for at in (0..names.len()).filter(|at| *at != time_at) {
        let full = names[at].full.clone();
        if chosen == Interpolation::BandLimited && !super::inputs::is_even(&sampling) {
            return Err(Error::UnevenInput {
                path: path.to_owned(),
                column: full,
                jitter: 100.0 * sampling.jitter,
                gaps: sampling.gaps.len(),
            });
        }
        let name = match names[at].bare.as_str() {
            "" => full.clone(),
            bare => bare.to_owned(),
        };
        let least = if name == "normal_force" {
            0.0
        } else {
            f64::NEG_INFINITY
        };
        let values = column(at)?;
        if let Some(worst) = values.iter().position(|v| *v < least) {
            return Err(Error::NegativeLoad {
                path: path.to_owned(),
                column: full,
                sample: worst + 1,
                value: values[worst],
            });
        }
        let series = InputSeries {
            column: full,
            values,
            between: chosen.into(),
        };
        tracks.push((name, InputTrack::of(&series, &time, least)));
    }
    Ok(tracks)
}
