//! An FMU with other start values: the same text with other `start` attributes and another GUID.

use crate::layout::Layout;
use crate::variable::Kind;
use crate::{guid_of, xml};
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

/// Folder of the FMU's resources that holds the users' effects, one file each.
pub const EFFECTS_FOLDER: &str = "effects";

impl Layout {
    /// The description with these start values in place of the built-in ones, and its GUID.
    ///
    /// # Errors
    /// Unknown or unsettable names, values outside the variable's range.
    pub fn xml_with_starts(
        &self,
        starts: &[(impl AsRef<str>, f64)],
    ) -> Result<(String, String), StartValueError> {
        let mut all: Vec<Option<f64>> = self.variables().iter().map(|v| v.start).collect();
        for (name, value) in starts {
            all[self.check_start(name.as_ref(), *value)?] = Some(*value);
        }
        Ok(xml::generate(self, &all))
    }

    /// The content of [`START_VALUES_FILE`] for an FMU made by [`Layout::xml_with_starts`] from the same
    /// values: its GUID, its users' effects each with the digest of its file, its start values.
    ///
    /// # Errors
    /// As [`Layout::xml_with_starts`].
    pub fn start_values_toml(
        &self,
        starts: &[(impl AsRef<str>, f64)],
        guid: &str,
    ) -> Result<String, StartValueError> {
        let mut text = format!("guid = \"{guid}\"\n");
        for effect in self.effects() {
            let (id, digest) = (&effect.id, guid_of(&effect.text));
            write!(
                text,
                "\n[[effect]]\nfile = \"{EFFECTS_FOLDER}/{id}.toml\"\ndigest = \"{digest}\"\n"
            )
            .expect("writing to a string");
        }
        text += "\n[start]\n";
        for (name, value) in starts {
            self.check_start(name.as_ref(), *value)?;
            writeln!(text, "\"{}\" = {value:?}", name.as_ref()).expect("writing to a string");
        }
        Ok(text)
    }

    /// Index of the variable if `value` may be its start value.
    ///
    /// # Errors
    /// Unknown or unsettable names, a value outside the variable's range.
    pub fn check_start(&self, name: &str, value: f64) -> Result<usize, StartValueError> {
        let unknown = || StartValueError::Unknown { name: name.into() };
        let index = self.index_of_name(name).ok_or_else(unknown)?;
        let variable = &self.variables()[index];
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
}
