//! Parquet: each column of numbers is a channel.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::{Channel, Found, Trouble};

fn damaged(error: ParquetError) -> Trouble {
    Trouble::damaged(format!("not a whole Parquet file ({error})"))
}

pub fn read(bytes: Vec<u8>) -> Result<Found, Trouble> {
    let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).map_err(damaged)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let mut found = Found::default();
    for (at, column) in schema.columns().iter().enumerate() {
        let name = column.path().parts().join("/");
        if column.max_rep_level() > 0 {
            found
                .remarks
                .push(format!("'{name}' holds lists, not read"));
            continue;
        }
        let mut values = Vec::new();
        let mut is_number = true;
        let per_second = instants(column);
        let mut origin = per_second.is_none().then_some(0);
        for group in 0..reader.num_row_groups() {
            let group = reader.get_row_group(group).map_err(damaged)?;
            let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
            let column = group.get_column_reader(at).map_err(damaged)?;
            match numbers(column, rows, &mut origin).map_err(|e| damaged(e).of(&name))? {
                Some(part) if part.len() == rows => values.extend(part),
                Some(part) => {
                    return Err(Trouble::damaged(format!(
                        "{rows} samples are announced and {} are there",
                        part.len()
                    ))
                    .of(&name));
                }
                None => is_number = false,
            }
        }
        if !is_number {
            found
                .remarks
                .push(format!("'{name}' is no column of numbers, not read"));
            continue;
        }
        let mut channel = Channel::new(&name, values);
        if let Some(per_second) = per_second {
            if let Ok(values) = &mut channel.values {
                values.iter_mut().for_each(|v| *v /= per_second);
            }
            channel = channel.with_unit("s");
        }
        found.channels.push(channel);
    }
    Ok(found)
}

/// Values of one row group; NaN where one is missing. `None` for texts and others that are no numbers. Of 64-bit numbers the
/// `origin` is taken off, the first of them where there is none yet: instants in ns have more digits than an f64.
fn numbers(
    reader: ColumnReader,
    rows: usize,
    origin: &mut Option<i64>,
) -> Result<Option<Vec<f64>>, ParquetError> {
    Ok(Some(match reader {
        ColumnReader::BoolColumnReader(r) => all(r, rows, |v| f64::from(u8::from(*v)))?,
        ColumnReader::Int32ColumnReader(r) => all(r, rows, |v| f64::from(*v))?,
        ColumnReader::Int64ColumnReader(r) => all(r, rows, |v| {
            v.wrapping_sub(*origin.get_or_insert(*v)) as f64
        })?,
        ColumnReader::FloatColumnReader(r) => all(r, rows, |v| f64::from(*v))?,
        ColumnReader::DoubleColumnReader(r) => all(r, rows, |v| *v)?,
        _ => return Ok(None),
    }))
}

fn all<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
    mut number: impl FnMut(&T::T) -> f64,
) -> Result<Vec<f64>, ParquetError> {
    let (mut values, mut levels, mut out) = (Vec::new(), Vec::new(), Vec::new());
    while out.len() < rows {
        values.clear();
        levels.clear();
        let (records, _, _) =
            reader.read_records(rows - out.len(), Some(&mut levels), None, &mut values)?;
        if records == 0 {
            break;
        }
        // Without levels every value is there.
        if values.len() == records {
            out.extend(values.iter().map(&mut number));
            continue;
        }
        let there = levels.iter().copied().max().unwrap_or(0);
        let mut next = values.iter();
        for level in &levels {
            let value = (*level == there).then(|| next.next()).flatten();
            out.push(value.map_or(f64::NAN, &mut number));
        }
        if values.is_empty() {
            let from = out.len() - levels.len();
            out[from..].fill(f64::NAN);
        }
    }
    Ok(out)
}

/// Ticks per second of a column of instants.
fn instants(column: &ColumnDescriptor) -> Option<f64> {
    if let Some(LogicalType::Timestamp(kind)) = column.logical_type_ref() {
        return Some(match kind.unit {
            TimeUnit::MILLIS => 1e3,
            TimeUnit::MICROS => 1e6,
            TimeUnit::NANOS => 1e9,
        });
    }
    match column.converted_type() {
        ConvertedType::TIMESTAMP_MILLIS => Some(1e3),
        ConvertedType::TIMESTAMP_MICROS => Some(1e6),
        _ => None,
    }
}
