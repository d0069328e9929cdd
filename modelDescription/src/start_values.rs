//! An FMU with other start values: the same text with other `start` attributes and another GUID.

use crate::variable::Kind;
use crate::{index_of_name, variables, xml};
use std::fmt::Write as _;

/// Name of the file in the FMU's resources that holds start values and the GUID that goes with them.
pub const START_VALUES_FILE: &str = "start_values.toml";

/// Why start values can't be used.
#[derive(Debug, Clone, PartialEq)]
pub enum StartValueError {
    /// No variable of that name.
    Unknown {
        /// The name asked for.
        name: String,
    },
    /// The variable is a result.
    NotSettable {
        /// Its name.
        name: String,
    },
    /// The value is not finite, not whole for an Integer, or outside the variable's range.
    BadValue {
        /// Name of the variable.
        name: String,
        /// The offending value.
        value: f64,
        /// The condition in words.
        required: String,
    },
}

impl std::fmt::Display for StartValueError {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Unknown { name } => write!(
                f,
                "start value for '{name}': no such variable; use the names of modelDescription.xml"
            ),
            Self::NotSettable { name } => write!(
                f,
                "start value for '{name}': this is a result and has no start value; remove it"
            ),
            Self::BadValue {
                name,
                value,
                required,
            } => write!(f, "start value {name} = {value}: it must be {required}"),
        }
    }
}

impl std::error::Error for StartValueError {}

/// The description with other start values, and its GUID.
///
/// # Errors
/// Unknown or unsettable names, values outside the variable's range.
pub fn xml_with_starts(
    starts: &[(impl AsRef<str>, f64)],
) -> Result<(String, String), StartValueError> {
    let mut all: Vec<Option<f64>> = variables().iter().map(|v| v.start).collect();
    for (name, value) in starts {
        all[check_start(name.as_ref(), *value)?] = Some(*value);
    }
    Ok(xml::generate(&all))
}

/// The content of [`START_VALUES_FILE`] for an FMU made by [`xml_with_starts`] from the same values.
///
/// # Errors
/// As [`xml_with_starts`].
pub fn start_values_toml(
    starts: &[(impl AsRef<str>, f64)],
    guid: &str,
) -> Result<String, StartValueError> {
    let mut text = format!("guid = \"{guid}\"\n\n[start]\n");
    for (name, value) in starts {
        check_start(name.as_ref(), *value)?;
        writeln!(text, "\"{}\" = {value:?}", name.as_ref()).expect("writing to a string");
    }
    Ok(text)
}

/// Index of the variable if `value` may be its start value.
///
/// # Errors
/// Unknown or unsettable names, a value outside the variable's range.
pub fn check_start(name: &str, value: f64) -> Result<usize, StartValueError> {
    let index =
        index_of_name(name).ok_or_else(|| StartValueError::Unknown { name: name.into() })?;
    let variable = &variables()[index];
    if !variable.is_settable() {
        return Err(StartValueError::NotSettable { name: name.into() });
    }
    let required = if !value.is_finite() {
        "finite".to_owned()
    } else if !matches!(variable.kind, Kind::Real(_)) && value.fract() != 0.0 {
        "a whole number".to_owned()
    } else if variable.min.is_some_and(|min| value < min) {
        format!("at least {:?}", variable.min.unwrap_or_default())
    } else if variable.max.is_some_and(|max| value > max) {
        format!("at most {:?}", variable.max.unwrap_or_default())
    } else {
        return Ok(index);
    };
    Err(StartValueError::BadValue {
        name: name.into(),
        value,
        required,
    })
}
