//! One column of any table, as a series at even times.

use std::path::Path;

use super::table::Table;
use super::unit::{Name, Quantity};
use crate::error::Error;
use crate::wording::nearest;

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name without a unit; `value` for a file without a header.
    pub name: String,
    /// SI unit of the values, where the header says in which unit they are written.
    pub unit: Option<&'static str>,
    /// Sample interval, s, if the file has a column of times.
    pub interval: Option<f64>,
    /// Samples; NaN where one is missing.
    pub values: Vec<f64>,
}

/// Names of a column of times.
const TIMES: [&str; 3] = ["time", "time_s", "t"];
/// Columns taken without being asked for.
const USUAL: [&str; 2] = ["tip_displacement_m", "tip_displacement"];
/// Share of the interval that a sample may lie off the grid.
const OFF_GRID: f64 = 0.1;

/// Reads a column of a table in any dialect ([`Table`]), with the SI factor of the unit in its name. An empty field, `NaN` or
/// `-` is a missing sample, and so is a gap in the times.
///
/// # Errors
/// [`Error`] with line and value where the file cannot be read as such.
pub fn read_column(path: &Path, wanted: Option<&str>) -> Result<Column, Error> {
    let table = Table::read(path, None)?;
    let names = &table.names;
    let rows = table.lines().count();
    if rows < 2 {
        return Err(Error::TooFewSamples {
            path: path.to_owned(),
            samples: rows,
            needed: 2,
        });
    }
    let is_time =
        |name: &Name| TIMES.contains(&name.bare.as_str()) || name.measures(Quantity::Time);
    let time_at = names.iter().position(is_time);
    let others: Vec<usize> = (0..names.len()).filter(|i| Some(*i) != time_at).collect();
    let place = |name: &str| names.iter().position(|n| n.is(name));
    let at = match wanted {
        Some(name) => place(name),
        None => USUAL
            .iter()
            .find_map(|name| place(name))
            .or((others.len() == 1).then(|| others[0])),
    };
    let at = at.ok_or_else(|| Error::ColumnChoice {
        path: path.to_owned(),
        wanted: wanted.map(str::to_owned),
        present: names.iter().map(|n| n.full.clone()).collect(),
        nearest: nearest(
            wanted.unwrap_or_default(),
            names.iter().map(|n| n.full.as_str()),
        ),
    })?;
    let factor = |column: usize| names[column].unit.map_or(1.0, |unit| unit.factor);
    let name = match names[at].bare.as_str() {
        "" => names[at].full.clone(),
        bare => bare.to_owned(),
    };
    let unit = names[at].unit.and_then(|unit| unit.quantity.si());
    let Some(time_at) = time_at else {
        let [mut values] = table.columns([at])?;
        values.iter_mut().for_each(|v| *v *= factor(at));
        return Ok(Column {
            name,
            unit,
            interval: None,
            values,
        });
    };
    let [times, values] = table.columns([time_at, at])?;
    let (mut time, mut kept, mut lines) = (Vec::new(), Vec::new(), Vec::new());
    for ((line, t), value) in table.lines().zip(times).zip(values) {
        if !t.is_nan() {
            time.push(t * factor(time_at));
            kept.push(value * factor(at));
            lines.push(line);
        }
    }
    if time.len() < 2 {
        return Err(Error::TooFewSamples {
            path: path.to_owned(),
            samples: time.len(),
            needed: 2,
        });
    }
    let (interval, values) = on_grid(path, &time, kept, &|i| lines[i])?;
    Ok(Column {
        name,
        unit,
        interval: Some(interval),
        values,
    })
}

/// Puts samples on an even grid, with NaN in the gaps.
fn on_grid(
    path: &Path,
    time: &[f64],
    values: Vec<f64>,
    line: &dyn Fn(usize) -> u64,
) -> Result<(f64, Vec<f64>), Error> {
    if let Some(i) = (1..time.len()).find(|i| time[*i] <= time[i - 1]) {
        return Err(Error::TimeNotIncreasing {
            path: path.to_owned(),
            line: line(i),
            previous: time[i - 1],
            value: time[i],
        });
    }
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_by(f64::total_cmp);
    let rough = steps[steps.len() / 2];
    // The median step has the rounding of two times; the whole record sharpens it.
    let span = time[time.len() - 1] - time[0];
    let count: f64 = time
        .windows(2)
        .map(|w| ((w[1] - w[0]) / rough).round().max(1.0))
        .sum();
    let interval = span / count;
    if count > 100.0 * time.len() as f64 {
        return Err(Error::UnevenTimes {
            path: path.to_owned(),
            line: line(1),
            share: f64::INFINITY,
            interval,
        });
    }
    let mut out = vec![f64::NAN; count as usize + 1];
    for (i, (t, value)) in time.iter().zip(values).enumerate() {
        let place = (t - time[0]) / interval;
        let off = (place - place.round()).abs();
        if off > OFF_GRID {
            return Err(Error::UnevenTimes {
                path: path.to_owned(),
                line: line(i),
                share: off,
                interval,
            });
        }
        out[place.round() as usize] = value;
    }
    Ok((interval, out))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(text: &str, wanted: Option<&str>) -> Result<Column, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.csv");
        std::fs::write(&path, text).unwrap();
        read_column(&path, wanted)
    }

    #[test]
    fn a_gap_in_the_times_is_missing_samples() {
        let found = column("time_s,a,b\n0,1,5\n0.1,2,6\n0.4,3,7\n0.5,,8\n", Some("a")).unwrap();
        assert!((found.interval.unwrap() - 0.1).abs() < 1e-12);
        assert_eq!(found.values[..2], [1.0, 2.0]);
        assert!(found.values[2].is_nan() && found.values[3].is_nan() && found.values[5].is_nan());
        assert_eq!(found.values[4], 3.0);
    }

    #[test]
    fn numbers_alone_need_no_header() {
        let found = column("# laser\n\n86\n141\n95\n", None).unwrap();
        assert_eq!(
            (found.values, found.interval),
            (vec![86.0, 141.0, 95.0], None)
        );
    }

    #[test]
    fn what_cannot_be_chosen_or_read_is_named() {
        let text = |r: Result<Column, Error>| r.unwrap_err().to_string();
        assert!(text(column("a,b\n1,2\n3,4\n", None)).contains("--column"));
        assert!(text(column("speed,b\n1,2\n3,4\n", Some("sped"))).contains("'speed'"));
        assert!(text(column("a\n1\nx\n", None)).contains(":3"));
        assert!(text(column("a\n1\ninf\n", None)).contains("inf"));
        assert!(text(column("t,a\n0,1\n1,1\n0.5,1\n", None)).contains("0.5"));
        assert!(text(column("t,a\n0,1\n1,1\n2,1\n3.5,1\n4.5,1\n", None)).contains("even"));
    }
}
