//! Tables of text, as [`Table`] reads them.

use std::path::Path;

use super::super::table::Table;
use super::super::unit::Name;
use super::{Channel, Recording, Trouble};
use crate::error::Error;
use crate::file_kind::{Wanted, explain};

/// Reads every column. One whose rows are no numbers is kept with its error, for the case that it is asked for.
pub fn read(path: &Path) -> Result<Recording, Error> {
    let table = Table::read(path, None).map_err(|e| explain(e, path, Wanted::Table))?;
    let column = |at: usize, name: &Name| -> Result<Channel, Error> {
        let values = match table.columns([at]) {
            Ok([values]) => Ok(values),
            // A row that is not whole makes the whole file doubtful, a text in a column that column.
            Err(Error::NotANumber {
                line,
                column,
                value,
                remedy,
                ..
            }) => Err(Trouble::new(
                format!("line {line} reads '{value}', which is not a finite number"),
                remedy,
            )
            .of(&column)),
            Err(Error::EmptyColumn { rows, .. }) => Ok(vec![f64::NAN; rows]),
            Err(error) => return Err(error),
        };
        let mut channel = Channel::new(&name.full, Vec::new());
        if let Some(unit) = name.unit {
            channel.unit = Some(unit);
            channel.strange_unit = None;
            channel.name = match name.bare.as_str() {
                "" => name.full.clone(),
                bare => bare.to_owned(),
            };
        }
        channel.values = values;
        Ok(channel)
    };
    let channels = table.names.iter().enumerate();
    let mut channels = channels
        .map(|(at, name)| column(at, name))
        .collect::<Result<Vec<_>, _>>()?;
    super::names::make_unlike(&mut channels);
    Ok(Recording {
        path: path.to_owned(),
        format: "CSV",
        channels,
        scalars: Vec::new(),
        remarks: table.differs.clone(),
    })
}
