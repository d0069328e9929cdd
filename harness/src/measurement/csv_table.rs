//! Two columns of a CSV file, in SI units.

use std::fs::File;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use crate::error::Error;
use crate::wording::nearest;

/// Which columns to read, and the factors that turn them into s and m.
pub(super) struct Channels {
    pub time_column: String,
    pub displacement_column: String,
    pub time_scale: f64,
    pub displacement_scale: f64,
    pub delimiter: u8,
}

/// Reads time (s) and displacement (m). Lines that begin with `#` are comments.
pub(super) fn read(path: &Path, channels: &Channels) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let file = File::open(path).map_err(Error::read(path))?;
    let mut reader = ReaderBuilder::new()
        .delimiter(channels.delimiter)
        .trim(Trim::All)
        .comment(Some(b'#'))
        .from_reader(file);
    let header = reader
        .headers()
        .map_err(|e| record_error(path, &e))?
        .clone();
    if header.is_empty() {
        return Err(Error::TooFewSamples {
            path: path.to_owned(),
            samples: 0,
            needed: super::FEWEST_SAMPLES,
        });
    }
    let time_at = column(path, &header, &channels.time_column, "time_column")?;
    let displacement_at = column(
        path,
        &header,
        &channels.displacement_column,
        "displacement_column",
    )?;

    let (mut time, mut displacement) = (Vec::new(), Vec::new());
    let mut record = StringRecord::new();
    while reader
        .read_record(&mut record)
        .map_err(|e| record_error(path, &e))?
    {
        let line = record.position().map_or(0, csv::Position::line);
        let t = number(path, line, &channels.time_column, &record[time_at])? * channels.time_scale;
        if let Some(&previous) = time.last()
            && t <= previous
        {
            return Err(Error::TimeNotIncreasing {
                path: path.to_owned(),
                line,
                previous,
                value: t,
            });
        }
        time.push(t);
        displacement.push(
            number(
                path,
                line,
                &channels.displacement_column,
                &record[displacement_at],
            )? * channels.displacement_scale,
        );
    }
    Ok((time, displacement))
}

/// Names of the usual columns in the CSV files that `simulate` writes.
const SIMULATED: [(&str, &str); 2] = [
    ("time_s", "time"),
    ("tip_displacement_m", "tip_displacement"),
];

fn column(
    path: &Path,
    header: &StringRecord,
    name: &str,
    key: &'static str,
) -> Result<usize, Error> {
    let missing = || Error::MissingColumn {
        path: path.to_owned(),
        column: name.to_owned(),
        key,
        present: header.iter().map(str::to_owned).collect(),
        nearest: nearest(name, header.iter()),
    };
    let place = |name: &str| header.iter().position(|h| h == name);
    let as_simulated = || SIMULATED.iter().find(|(own, _)| *own == name);
    place(name)
        .or_else(|| as_simulated().and_then(|(_, simulated)| place(simulated)))
        .ok_or_else(missing)
}

fn number(path: &Path, line: u64, column: &str, text: &str) -> Result<f64, Error> {
    let refuse = || Error::NotANumber {
        path: path.to_owned(),
        line,
        column: column.to_owned(),
        value: text.to_owned(),
    };
    text.parse()
        .ok()
        .filter(|v: &f64| v.is_finite())
        .ok_or_else(refuse)
}

fn record_error(path: &Path, error: &csv::Error) -> Error {
    let problem = match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => format!("{len} fields where the header has {expected_len}"),
        csv::ErrorKind::Utf8 { .. } => "not UTF-8 text".into(),
        _ => error.to_string(),
    };
    Error::CsvRecord {
        path: path.to_owned(),
        line: error.position().map_or(1, csv::Position::line),
        problem,
    }
}
