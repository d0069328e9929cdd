//! What an FMU of another make does not say itself: which of its variables are inputs, outputs and states of a rubbed structure,
//! which constants may be calibrated, and which parameters switch which effect on. A TOML file beside the FMU,
//! `<name>.effects.toml` or `effects.toml` (docs/other-fmus.md).

mod check;
mod file;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::description::ModelDescription;
use super::effect_card::EffectCard;
use crate::error::Error;
use crate::measurement::line_of;
use check::Check;
use file::Raw;

/// Names under which this program looks for variables, which `[variables]` may lead to others, and whether it sets them.
const ROLES: [(&str, bool); 12] = [
    ("belt_velocity", true),
    ("normal_force", true),
    ("external_force", true),
    ("clamp_acceleration", true),
    ("tip_displacement", false),
    ("tip_velocity", false),
    ("tip_acceleration", false),
    ("friction_force", false),
    ("belt_travel.start", true),
    ("dwell_time.start", true),
    ("sensor.offset", true),
    ("tolerance", true),
];

/// How well a constant is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Belief {
    /// Standard deviation of its logarithm: a positive constant, known to a factor.
    Relative(f64),
    /// Standard deviation of its value, in its own unit.
    Absolute(f64),
}

/// A constant of the model that is calibrated with every hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// The FMU's variable.
    pub variable: String,
    /// Its value reference.
    pub reference: u32,
    /// Unit symbol.
    pub unit: String,
    /// Value believed before the data.
    pub value: f64,
    /// How well it is known.
    pub belief: Belief,
    /// Smallest value allowed, where one is stated.
    pub min: Option<f64>,
    /// Largest value allowed, where one is stated.
    pub max: Option<f64>,
    /// Whether each run has its own.
    pub per_run: bool,
}

/// A side file, checked against the description of its FMU.
#[derive(Debug, Clone, PartialEq)]
pub struct SideFile {
    path: PathBuf,
    text: String,
    /// The FMU's own names by those under which this program looks for them.
    own_names: HashMap<String, String>,
    /// What the modal displacements and velocities are set by, in turn: name and value reference.
    starts: Vec<(String, u32)>,
    /// Coefficient of friction, roughly, where it is stated.
    pub friction_coefficient: Option<f64>,
    /// Constants that are calibrated.
    pub constants: Vec<Constant>,
    /// Effects that the FMU offers.
    pub effects: Vec<EffectCard>,
}

impl SideFile {
    /// The side file of an FMU; `None` where there is none, and for an FMU that declares its effects itself.
    ///
    /// # Errors
    /// A file that can't be read, or does not fit the FMU.
    pub(super) fn beside(
        fmu: &Path,
        description: &ModelDescription,
    ) -> Result<Option<SideFile>, Error> {
        if description.vendor_annotation("StickSlip").is_some() {
            return Ok(None);
        }
        let named = SideFile::place(fmu);
        let common = fmu.with_file_name("effects.toml");
        let Some(path) = [named, common].into_iter().find(|p| p.is_file()) else {
            return Ok(None);
        };
        let text = std::fs::read_to_string(&path).map_err(Error::read(&path))?;
        SideFile::parse(&path, &text, description).map(Some)
    }

    /// Where the side file of an FMU is looked for first.
    pub(crate) fn place(fmu: &Path) -> PathBuf {
        fmu.with_extension("effects.toml")
    }

    /// The file as it was read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads the text of a side file.
    fn parse(path: &Path, text: &str, description: &ModelDescription) -> Result<SideFile, Error> {
        let raw: Raw = toml::from_str(text).map_err(|e| Error::EffectFile {
            path: path.to_owned(),
            line: e.span().map(|span| line_of(text, span)),
            problem: e.message().to_owned(),
        })?;
        let check = Check {
            path,
            text,
            description,
        };
        check.side_file(raw)
    }

    /// An error of this file as a whole.
    pub fn error(&self, problem: impl Into<String>) -> Error {
        Error::EffectFile {
            path: self.path.clone(),
            line: None,
            problem: problem.into(),
        }
    }

    /// The FMU's own name of a variable that this program knows by another.
    pub fn own_name(&self, name: &str) -> Option<&str> {
        self.own_names.get(name).map(String::as_str)
    }

    /// Names by which modal displacements and velocities, in turn, are set before a start.
    pub fn start_names(&self) -> impl Iterator<Item = &str> {
        self.starts.iter().map(|(name, _)| name.as_str())
    }

    /// That no variable of the FMU is named for what this program asks for, if it can be named in the file.
    pub fn unnamed(&self, name: &str) -> Option<Error> {
        let is_role = ROLES.iter().any(|(role, _)| *role == name);
        is_role.then(|| {
            self.error(format!(
                "{name} is asked for, and [variables] does not say which variable of the FMU that is; add it"
            ))
        })
    }

    /// Value references by which `count` modal displacements and velocities, in turn, are set before a start.
    ///
    /// # Errors
    /// Another number of states in the file.
    pub fn starts(&self, count: usize) -> Result<Vec<u32>, Error> {
        if self.starts.len() == count {
            return Ok(self
                .starts
                .iter()
                .map(|(_, reference)| *reference)
                .collect());
        }
        Err(self.error(format!(
            "{} tables [[state]], but the {} modes of [structure] in campaign.toml have {count} states; give displacement and velocity of each mode in turn",
            self.starts.len(),
            count / 2
        )))
    }
}
