//! Time, displacement and measured inputs of a run from a table, in SI units.

use std::path::Path;

use super::table::Table;
use super::unit::{Name, Quantity};
use crate::error::Error;
use crate::wording::nearest;

/// Which columns to read, and the factors that turn them into s and m. What is `None` is found in
/// the header.
pub(super) struct Channels {
    pub time_column: Option<String>,
    pub displacement_column: Option<String>,
    pub time_scale: Option<f64>,
    pub displacement_scale: Option<f64>,
    pub delimiter: Option<u8>,
    /// Samples per second, for a file without a column of times.
    pub sample_rate: Option<f64>,
    /// Column and scale of each of [`INPUTS`]; no column, no input.
    pub inputs: [(Option<String>, Option<f64>); 3],
}

/// Time, displacement and what was measured of the inputs.
pub(super) struct Record {
    /// s; strictly increasing.
    pub time: Vec<f64>,
    /// m.
    pub displacement: Vec<f64>,
    /// Name and values of each of [`INPUTS`], SI units.
    pub inputs: [Option<(String, Vec<f64>)>; 3],
    /// How the file was read, where it is not plain comma-separated values in SI units.
    pub understood: Option<String>,
}

/// Reads time (s), displacement (m) and inputs. Rows without one of them are left out, as missing
/// samples.
pub(super) fn read(path: &Path, channels: &Channels) -> Result<Record, Error> {
    let table = Table::read(path, channels.delimiter)?;
    let choice = Choice {
        path,
        table: &table,
    };
    let mut differs = table.differs.clone();
    let at = choice.column(&DISPLACEMENT, channels.displacement_column.as_deref())?;
    let scale = choice.scale(&DISPLACEMENT, at, channels.displacement_scale, &mut differs)?;
    let (times, values) = match channels.sample_rate {
        Some(rate) => {
            differs.push(format!("times from sample_rate_hz = {rate}"));
            let [values] = table.columns([at])?;
            let times = (0..values.len()).map(|i| i as f64 / rate).collect();
            (times, values)
        }
        None => {
            let time_at = choice.column(&TIME, channels.time_column.as_deref())?;
            let scale = choice.scale(&TIME, time_at, channels.time_scale, &mut differs)?;
            let [mut times, values] = table.columns([time_at, at])?;
            times.iter_mut().for_each(|t| *t *= scale);
            (times, values)
        }
    };
    let mut measured: Vec<Vec<f64>> = Vec::new();
    for (wanted, (stated, own)) in INPUTS.iter().zip(&channels.inputs) {
        if stated.is_some() {
            let at = choice.column(wanted, stated.as_deref())?;
            let scale = choice.scale(wanted, at, *own, &mut differs)?;
            let [mut column] = table.columns([at])?;
            column.iter_mut().for_each(|v| *v *= scale);
            measured.push(column);
        }
    }
    let mut kept: Vec<Vec<f64>> = vec![Vec::new(); measured.len()];
    let rows = values.len();
    let (mut time, mut displacement) = (Vec::with_capacity(rows), Vec::with_capacity(rows));
    for (row, ((line, t), value)) in table.lines().zip(times).zip(values).enumerate() {
        let lacks_input = measured.iter().any(|column| column[row].is_nan());
        if t.is_nan() || value.is_nan() || lacks_input {
            continue;
        }
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
        displacement.push(value * scale);
        for (kept, column) in kept.iter_mut().zip(&measured) {
            kept.push(column[row]);
        }
    }
    if time.len() < rows {
        let missing = rows - time.len();
        differs.push(format!("{missing} of {rows} samples missing"));
    }
    let mut kept = kept.into_iter();
    let inputs = std::array::from_fn(|i| {
        let name = channels.inputs[i].0.clone()?;
        Some((name, kept.next()?))
    });
    Ok(Record {
        time,
        displacement,
        inputs,
        understood: (!differs.is_empty()).then(|| differs.join(", ")),
    })
}

/// What a column is looked for by.
pub(super) struct Wanted {
    quantity: Quantity,
    /// Names that it has where campaign.toml gives none: the format's own, and the one that
    /// `simulate` writes.
    usual: [&'static str; 2],
    /// Names without a unit that say as much, in lower case.
    plain: &'static [&'static str],
    key: &'static str,
    scale_key: &'static str,
    unit: &'static str,
}

const TIME: Wanted = Wanted {
    quantity: Quantity::Time,
    usual: ["time_s", "time"],
    plain: &["time", "t", "zeit"],
    key: "time_column",
    scale_key: "time_scale",
    unit: "s",
};
const DISPLACEMENT: Wanted = Wanted {
    quantity: Quantity::Length,
    usual: ["tip_displacement_m", "tip_displacement"],
    plain: &[],
    key: "displacement_column",
    scale_key: "displacement_scale",
    unit: "m",
};

/// The inputs that a column can give: belt velocity, normal force, external force.
pub(super) const INPUTS: [Wanted; 3] = [
    Wanted {
        quantity: Quantity::Velocity,
        usual: ["belt_velocity_m_per_s", "belt_velocity"],
        plain: &[],
        key: "belt_velocity_column",
        scale_key: "belt_velocity_scale",
        unit: "m/s",
    },
    Wanted {
        quantity: Quantity::Force,
        usual: ["normal_force_n", "normal_force"],
        plain: &[],
        key: "normal_force_column",
        scale_key: "normal_force_scale",
        unit: "N",
    },
    Wanted {
        quantity: Quantity::Force,
        usual: ["external_force_n", "external_force"],
        plain: &[],
        key: "external_force_column",
        scale_key: "external_force_scale",
        unit: "N",
    },
];

struct Choice<'a> {
    path: &'a Path,
    table: &'a Table,
}

impl Choice<'_> {
    /// The column named; without a name the usual one, else the only one with a unit of the
    /// quantity, else the only one with a plain name.
    fn column(&self, wanted: &Wanted, stated: Option<&str>) -> Result<usize, Error> {
        let names = &self.table.names;
        let all = |fits: &dyn Fn(&Name) -> bool| -> Vec<usize> {
            (0..names.len()).filter(|i| fits(&names[*i])).collect()
        };
        let ways: Vec<Vec<usize>> = match stated {
            Some(stated) => vec![
                all(&|n| n.full == stated),
                all(&|n| n.is(stated)),
                // A campaign may name the format's own column and be given a file that `simulate`
                // wrote.
                all(&|n| stated == wanted.usual[0] && n.full == wanted.usual[1]),
            ],
            None => vec![
                all(&|n| n.full == wanted.usual[0]),
                all(&|n| n.is(wanted.usual[0])),
                all(&|n| n.is(wanted.usual[1])),
                all(&|n| n.measures(wanted.quantity)),
                all(&|n| {
                    n.unit.is_none() && wanted.plain.contains(&n.bare.to_lowercase().as_str())
                }),
            ],
        };
        let present = || names.iter().map(|n| n.full.clone()).collect();
        match ways.into_iter().find(|found| !found.is_empty()) {
            Some(found) if found.len() == 1 => Ok(found[0]),
            Some(found) => Err(Error::SeveralColumns {
                path: self.path.to_owned(),
                line: self.table.header_line,
                quantity: wanted.quantity.words(),
                found: found.iter().map(|i| names[*i].full.clone()).collect(),
                key: wanted.key,
            }),
            None => {
                let name = stated.unwrap_or(wanted.usual[0]);
                Err(self.table.lacks(Error::MissingColumn {
                    path: self.path.to_owned(),
                    line: self.table.header_line,
                    column: name.to_owned(),
                    key: wanted.key,
                    present: present(),
                    nearest: nearest(name, names.iter().map(|n| n.full.as_str())),
                }))
            }
        }
    }

    /// The factor to SI: the one stated, else that of the column's unit.
    fn scale(
        &self,
        wanted: &Wanted,
        at: usize,
        stated: Option<f64>,
        differs: &mut Vec<String>,
    ) -> Result<f64, Error> {
        let name = &self.table.names[at];
        if let Some(scale) = stated {
            return Ok(scale);
        }
        let Some(unit) = name.unit else {
            return Ok(1.0);
        };
        if unit.quantity != wanted.quantity {
            return Err(Error::ColumnQuantity {
                path: self.path.to_owned(),
                line: self.table.header_line,
                column: name.full.clone(),
                problem: format!(
                    "{}, {}, where {} is needed",
                    unit.symbol,
                    unit.quantity.words(),
                    wanted.quantity.words()
                ),
                key: wanted.key,
                scale_key: wanted.scale_key,
            });
        }
        if unit.factor != 1.0 {
            let (full, symbol) = (&name.full, unit.symbol);
            differs.push(format!("'{full}' in {symbol} taken to {}", wanted.unit));
        }
        Ok(unit.factor)
    }
}
