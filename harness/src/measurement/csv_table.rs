//! Time, measured motion and inputs of a run from a table, in SI units.

use std::path::{Path, PathBuf};

use super::further_sensor::{FurtherSensor, Reading};
use super::measurand::Measurand;
use super::own_clock::{self, Readings};
use super::table::Table;
use super::unit::{Name, Quantity};
use crate::error::Error;
use crate::wording::nearest;

/// What the sensor at the tip measured; what is `None` is found in the header.
#[derive(Default)]
pub(super) struct Measured {
    pub measurand: Option<Measurand>,
    pub column: Option<String>,
    pub scale: Option<f64>,
}

/// Which columns to read, and the factors that turn them into SI units. What is `None` is found in
/// the header.
pub(super) struct Channels {
    pub time_column: Option<String>,
    pub measured: Measured,
    pub time_scale: Option<f64>,
    pub delimiter: Option<u8>,
    /// Samples per second, for a file without a column of times.
    pub sample_rate: Option<f64>,
    /// Column and scale of each of [`INPUTS`]; no column, no input.
    pub inputs: [(Option<String>, Option<f64>); 4],
}

/// Time, motion of the tip and what was measured of the inputs.
pub(super) struct Record {
    /// s; strictly increasing.
    pub time: Vec<f64>,
    /// What was measured at the tip.
    pub measurand: Measurand,
    /// Its values in the measurand's SI unit.
    pub measured: Vec<f64>,
    /// Name and values of each of [`INPUTS`], SI units.
    pub inputs: [Option<(String, Vec<f64>)>; 4],
    /// Readings of each further sensor in SI units.
    pub further: Vec<Readings>,
    /// How the file was read, where it is not plain comma-separated values in SI units.
    pub understood: Option<String>,
}

/// Reads time (s), the measured motion (SI units), inputs and what further sensors read. Rows without motion or an input are left
/// out, as missing samples.
pub(super) fn read(
    path: &Path,
    channels: &Channels,
    (further_sensors, further_files): (&[FurtherSensor], &[PathBuf]),
) -> Result<Record, Error> {
    let table = Table::read(path, channels.delimiter)?;
    let choice = Choice {
        path,
        table: &table,
        further_sensors,
    };
    let mut differs = table.differs.clone();
    let (measurand, measured_at) = choice.measured(channels)?;
    let scale = choice.scale(
        of_motion(measurand),
        measured_at,
        channels.measured.scale,
        &mut differs,
    )?;
    let (times, values) = match channels.sample_rate {
        Some(rate) => {
            differs.push(format!("times from sample_rate_hz = {rate}"));
            let [values] = table.columns([measured_at])?;
            let times = (0..values.len()).map(|i| i as f64 / rate).collect();
            (times, values)
        }
        None => {
            let (time_at, scale) = choice.time(channels, &mut differs)?;
            let [mut times, values] = table.columns([time_at, measured_at])?;
            times.iter_mut().for_each(|t| *t *= scale);
            (times, values)
        }
    };
    let mut of_inputs: Vec<Vec<f64>> = Vec::new();
    for (wanted, (stated, own)) in INPUTS.iter().zip(&channels.inputs) {
        if stated.is_some() {
            let at = choice.column(wanted, stated.as_deref())?;
            let scale = choice.scale(wanted, at, *own, &mut differs)?;
            let [mut column] = table.columns([at])?;
            column.iter_mut().for_each(|v| *v *= scale);
            of_inputs.push(column);
        }
    }
    let further_tables = further_files
        .iter()
        .map(|file| Ok((file.as_path(), Table::read(file, channels.delimiter)?)))
        .collect::<Result<Vec<_>, Error>>()?;
    let mut taken = vec![measured_at];
    let mut of_sensors: Vec<Readings> = Vec::new();
    for sensor in further_sensors {
        let own = match choice.of_sensor(sensor, &mut taken, &mut differs) {
            Err(lacking @ Error::MissingColumn { .. }) => {
                let found = further_tables.iter().find_map(|(path, table)| {
                    let other = Choice {
                        path,
                        table,
                        further_sensors,
                    };
                    let found = other.of_sensor(sensor, &mut Vec::new(), &mut differs);
                    (!matches!(found, Err(Error::MissingColumn { .. }))).then_some((other, found))
                });
                let (other, values) = found.ok_or(lacking)?;
                let (time_at, scale) = other.time(channels, &mut differs)?;
                let [mut own_times] = other.table.columns([time_at])?;
                own_times.iter_mut().for_each(|t| *t *= scale);
                other.at_times(sensor, (&own_times, &values?), &times)?
            }
            Ok(values) if sensor.delay != 0.0 => {
                choice.at_times(sensor, (&times, &values), &times)?
            }
            values => Readings::in_rows(values?),
        };
        of_sensors.push(own);
    }
    let empty = |own: &Readings| Readings {
        values: Vec::new(),
        ..*own
    };
    let mut further: Vec<Readings> = of_sensors.iter().map(empty).collect();
    let mut kept: Vec<Vec<f64>> = vec![Vec::new(); of_inputs.len()];
    let rows = values.len();
    let (mut time, mut measured) = (Vec::with_capacity(rows), Vec::with_capacity(rows));
    for (row, ((line, &t), value)) in table.lines().zip(&times).zip(values).enumerate() {
        let lacks_input = of_inputs.iter().any(|column| column[row].is_nan());
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
        measured.push(value * scale);
        for (kept, column) in kept.iter_mut().zip(&of_inputs) {
            kept.push(column[row]);
        }
        for (kept, column) in further.iter_mut().zip(&of_sensors) {
            kept.values.push(column.values[row]);
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
        measurand,
        measured,
        inputs,
        further,
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
const VELOCITY: Wanted = Wanted {
    quantity: Quantity::Velocity,
    usual: ["tip_velocity_m_per_s", "tip_velocity"],
    plain: &[],
    key: "velocity_column",
    scale_key: "velocity_scale",
    unit: "m/s",
};

const ACCELERATION: Wanted = Wanted {
    quantity: Quantity::Acceleration,
    usual: ["tip_acceleration_m_per_s2", "tip_acceleration"],
    plain: &[],
    key: "acceleration_column",
    scale_key: "acceleration_scale",
    unit: "m/s^2",
};

fn of_motion(measurand: Measurand) -> &'static Wanted {
    match measurand {
        Measurand::Displacement => &DISPLACEMENT,
        Measurand::Velocity => &VELOCITY,
        Measurand::Acceleration => &ACCELERATION,
    }
}

/// A column of a further sensor, which campaign.toml always names.
fn of_reading(reading: Reading) -> Wanted {
    let motion = match reading {
        Reading::Displacement => &DISPLACEMENT,
        Reading::Velocity => &VELOCITY,
        Reading::Acceleration => &ACCELERATION,
        // Only its quantity and unit are taken.
        Reading::FrictionForce => &INPUTS[1],
    };
    Wanted {
        key: "column under [[further_sensor]]",
        scale_key: "scale",
        usual: [""; 2],
        ..*motion
    }
}

/// The inputs that a column can give: belt velocity, normal force, external force, acceleration of the clamp.
pub(super) const INPUTS: [Wanted; 4] = [
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
    Wanted {
        quantity: Quantity::Acceleration,
        usual: ["clamp_acceleration_m_per_s2", "clamp_acceleration"],
        plain: &[],
        key: "clamp_acceleration_column",
        scale_key: "clamp_acceleration_scale",
        unit: "m/s^2",
    },
];

struct Choice<'a> {
    path: &'a Path,
    table: &'a Table,
    /// Whose columns are nobody else's.
    further_sensors: &'a [FurtherSensor],
}

impl Choice<'_> {
    /// The column of times, and its factor to s.
    fn time(&self, channels: &Channels, differs: &mut Vec<String>) -> Result<(usize, f64), Error> {
        let at = self.column(&TIME, channels.time_column.as_deref())?;
        Ok((at, self.scale(&TIME, at, channels.time_scale, differs)?))
    }

    /// What a further sensor read at the times of the first one.
    fn at_times(
        &self,
        sensor: &FurtherSensor,
        (own_times, values): (&[f64], &[f64]),
        times: &[f64],
    ) -> Result<Readings, Error> {
        let rows = self.table.lines().zip(own_times).zip(values);
        let mut read: (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for ((line, &t), &y) in rows.filter(|((_, t), y)| t.is_finite() && y.is_finite()) {
            if let Some(&previous) = read.0.last()
                && t <= previous
            {
                return Err(Error::TimeNotIncreasing {
                    path: self.path.to_owned(),
                    line,
                    previous,
                    value: t,
                });
            }
            read.0.push(t);
            read.1.push(y);
        }
        if read.0.len() < 2 {
            return Ok(Readings::in_rows(vec![f64::NAN; times.len()]));
        }
        let own = (&read.0[..], &read.1[..]);
        own_clock::at(times, own, sensor.delay, sensor.reading.jumps()).map_err(|sampling| {
            Error::UnevenFurtherSensor {
                path: self.path.to_owned(),
                sensor: sensor.name.clone(),
                jitter: 100.0 * sampling.jitter,
                gaps: sampling.gaps.len(),
            }
        })
    }

    /// The readings of a further sensor in SI units, NaN where there are none; no column of `taken` is its own.
    fn of_sensor(
        &self,
        sensor: &FurtherSensor,
        taken: &mut Vec<usize>,
        differs: &mut Vec<String>,
    ) -> Result<Vec<f64>, Error> {
        let wanted = of_reading(sensor.reading);
        let at = self.column(&wanted, Some(&sensor.column))?;
        let scale = self.scale(&wanted, at, sensor.scale, differs)?;
        if taken.contains(&at) {
            return Err(Error::ColumnTwice {
                path: self.path.to_owned(),
                line: self.table.header_line,
                column: self.table.names[at].full.clone(),
                sensor: sensor.name.clone(),
            });
        }
        taken.push(at);
        let [mut column] = match self.table.columns([at]) {
            // In this run it read nothing.
            Err(Error::EmptyColumn { rows, .. }) => [vec![f64::NAN; rows]],
            read => read?,
        };
        column.iter_mut().for_each(|v| *v *= scale);
        Ok(column)
    }

    /// Whether a column is that of a further sensor.
    fn is_taken(&self, name: &Name) -> bool {
        let mut columns = self.further_sensors.iter().map(|s| s.column.as_str());
        columns.any(|column| name.full == column || name.is(column))
    }

    /// What was measured at the tip, and its column. Where nothing is stated, a displacement, or, where the header has none, a
    /// velocity that is not the belt's, or, where it has none of these either, an acceleration.
    fn measured(&self, channels: &Channels) -> Result<(Measurand, usize), Error> {
        let Measured {
            measurand, column, ..
        } = &channels.measured;
        if let Some(measurand) = measurand {
            // The belt's velocity must not be taken for the tip's.
            let named_by_none = *measurand == Measurand::Velocity && column.is_none();
            let found = named_by_none.then(|| self.tip_velocity(channels)).flatten();
            let wanted = of_motion(*measurand);
            let at = found.map_or_else(|| self.column(wanted, column.as_deref()), Ok)?;
            return Ok((*measurand, at));
        }
        match self.column(&DISPLACEMENT, None) {
            Err(lacking @ Error::MissingColumn { .. }) => {
                if let Some(at) = self.tip_velocity(channels) {
                    return Ok((Measurand::Velocity, at));
                }
                match self.column(&ACCELERATION, None) {
                    Err(Error::MissingColumn { .. }) => Err(lacking),
                    found => Ok((Measurand::Acceleration, found?)),
                }
            }
            found => Ok((Measurand::Displacement, found?)),
        }
    }

    /// The only column that may be the tip's velocity, without a key that says so.
    fn tip_velocity(&self, channels: &Channels) -> Option<usize> {
        let names = &self.table.names;
        let belt = &INPUTS[0];
        let is_belt = |name: &Name| {
            let stated = channels.inputs[0].0.as_deref();
            stated.is_some_and(|stated| name.is(stated)) || belt.usual.iter().any(|u| name.is(u))
        };
        let only = |fits: &dyn Fn(&Name) -> bool| {
            let is_free = |name: &Name| !is_belt(name) && !self.is_taken(name);
            let mut found = (0..names.len()).filter(|i| fits(&names[*i]) && is_free(&names[*i]));
            found.next().filter(|_| found.next().is_none())
        };
        only(&|n| VELOCITY.usual.iter().any(|usual| n.is(usual)))
            .or_else(|| only(&|n| n.measures(Quantity::Velocity)))
    }

    /// The column named; without a name the usual one, else the only one with a unit of the
    /// quantity, else the only one with a plain name.
    fn column(&self, wanted: &Wanted, stated: Option<&str>) -> Result<usize, Error> {
        let names = &self.table.names;
        let all = |fits: &dyn Fn(&Name) -> bool| -> Vec<usize> {
            let is_open = |name: &Name| stated.is_some() || !self.is_taken(name);
            let fitting = (0..names.len()).filter(|i| fits(&names[*i]) && is_open(&names[*i]));
            fitting.collect()
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
        let refused = |problem: String| {
            Err(Error::ColumnQuantity {
                path: self.path.to_owned(),
                line: self.table.header_line,
                column: name.full.clone(),
                problem,
                key: wanted.key,
                scale_key: wanted.scale_key,
            })
        };
        let Some(unit) = name.unit else {
            return match &name.strange {
                Some(text) => refused(format!(
                    "{text}, a unit that is not known, where {} is needed",
                    wanted.quantity.words()
                )),
                None => Ok(1.0),
            };
        };
        if unit.quantity != wanted.quantity {
            return refused(format!(
                "{}, {}, where {} is needed",
                unit.symbol,
                unit.quantity.words(),
                wanted.quantity.words()
            ));
        }
        if unit.factor != 1.0 {
            let (full, symbol) = (&name.full, unit.symbol);
            differs.push(format!("'{full}' in {symbol} taken to {}", wanted.unit));
        }
        Ok(unit.factor)
    }
}
