//! The known answers of a folder of campaigns: truth.json, read only to count.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::Error;
use crate::file_kind::{Wanted, explain};

/// What sort of campaign one is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// One hidden effect of the catalogue.
    Single,
    /// None.
    None,
    /// Two.
    Pair,
    /// One that the catalogue does not have.
    Outside,
    /// One that nothing in the project mirrors.
    OutsideNewPhysics,
    /// The same, of the kinds that were written when the diagnosis was finished.
    OutsideFurtherPhysics,
    /// The same, of the kinds that were written last, after it was frozen.
    OutsideFreshPhysics,
    /// The same, written by someone who had not seen what the diagnosis can explain.
    OutsideBlindPhysics,
    /// At most one, on a rig that is known only roughly.
    Misstated,
    /// At most one, all runs at one operating point.
    OneLoad,
    /// One, hardly visible.
    Weak,
}

impl Kind {
    /// The kind as truth.json has it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Single => "single",
            Kind::None => "none",
            Kind::Pair => "pair",
            Kind::Outside => "outside",
            Kind::OutsideNewPhysics => "outside-new-physics",
            Kind::OutsideFurtherPhysics => "outside-further-physics",
            Kind::OutsideFreshPhysics => "outside-fresh-physics",
            Kind::OutsideBlindPhysics => "outside-blind-physics",
            Kind::Misstated => "misstated",
            Kind::OneLoad => "one-load",
            Kind::Weak => "weak",
        }
    }
}

/// What the maker of a campaign knows of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Answer {
    /// Name of the campaign, a folder beside truth.json.
    pub campaign: String,
    /// Its kind, where the file says it; see [`Answer::kind`].
    #[serde(default)]
    kind: Option<Kind>,
    /// Hidden effects.
    pub effects: Vec<String>,
    /// Their parameters, by effect and name, in SI units.
    #[serde(default)]
    pub parameters: Value,
    /// True natural frequencies in Hz; of the structure first, then of hidden modes.
    #[serde(default)]
    pub true_f_hz: Vec<f64>,
    /// True damping ratios, likewise.
    #[serde(default, rename = "true_D")]
    pub true_d: Vec<f64>,
    /// True constants of the friction law.
    #[serde(default)]
    pub true_law: BTreeMap<String, f64>,
    /// What belongs to each run.
    #[serde(default)]
    pub runs: Vec<TrueRun>,
    /// True over stated belt speed; only of rigs that are known roughly.
    drive: Option<f64>,
    /// Normal force in N and belt speed in m/s of each run.
    #[serde(default)]
    points: Vec<[f64; 2]>,
}

/// What the maker knows of one run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TrueRun {
    /// Factor on its friction.
    pub friction_level: f64,
    /// Values of effects that each run has of its own, by effect and name.
    #[serde(default)]
    pub own: BTreeMap<String, BTreeMap<String, Value>>,
}

impl Answer {
    /// The kind: as the file says it, else as far as its other keys tell it. That an effect is
    /// weak, or new physics, they do not.
    pub fn kind(&self) -> Kind {
        let is_one_point = |points: &[[f64; 2]]| {
            points.len() > 1 && points.iter().all(|point| *point == points[0])
        };
        match self.kind {
            Some(kind) => kind,
            None if self.drive.is_some() => Kind::Misstated,
            None if is_one_point(&self.points) => Kind::OneLoad,
            None if self.effects.is_empty() => Kind::None,
            None if is_outside(&self.effects) => Kind::Outside,
            None if self.effects.len() == 1 => Kind::Single,
            None => Kind::Pair,
        }
    }

    /// True value of a parameter of a hidden effect.
    pub fn parameter(&self, effect: &str, parameter: &str) -> Option<f64> {
        self.parameters[effect][parameter].as_f64()
    }
}

/// Whether what the catalogue does not have is among these effects.
pub fn is_outside(effects: &[String]) -> bool {
    effects.iter().any(|id| id.starts_with("outside:"))
}

/// The answers of a folder.
///
/// # Errors
/// A truth.json that is not there or is no list of answers.
pub fn read(folder: &Path) -> Result<Vec<Answer>, Error> {
    let file = folder.join("truth.json");
    let text = std::fs::read_to_string(&file)
        .map_err(Error::read(&file))
        .map_err(|error| explain(error, folder, Wanted::BlindTest))?;
    serde_json::from_str(&text).map_err(|e| Error::Truth {
        path: file,
        problem: e.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(text: &str) -> Kind {
        serde_json::from_str::<Answer>(text).unwrap().kind()
    }

    #[test]
    fn the_kind_is_what_the_file_says_or_what_its_keys_tell() {
        let of = |effects: &str, more: &str| {
            kind(&format!(
                "{{\"campaign\": \"001\", \"effects\": [{effects}]{more}}}"
            ))
        };
        assert_eq!(of("", ""), Kind::None);
        assert_eq!(of("\"a\"", ""), Kind::Single);
        assert_eq!(of("\"a\", \"b\"", ""), Kind::Pair);
        assert_eq!(of("\"outside:a\"", ""), Kind::Outside);
        assert_eq!(of("\"a\"", ", \"drive\": 1.01"), Kind::Misstated);
        let points = |second: &str| format!(", \"points\": [[36, 0.04], [{second}]]");
        assert_eq!(of("\"a\"", &points("36, 0.04")), Kind::OneLoad);
        assert_eq!(of("\"a\"", &points("60, 0.04")), Kind::Single);
        let said = ", \"kind\": \"outside-new-physics\"";
        assert_eq!(of("\"outside:a\"", said), Kind::OutsideNewPhysics);
        let said = ", \"kind\": \"outside-further-physics\"";
        assert_eq!(of("\"outside:a\"", said), Kind::OutsideFurtherPhysics);
        let said = ", \"kind\": \"outside-fresh-physics\"";
        assert_eq!(of("\"outside:a\"", said), Kind::OutsideFreshPhysics);
        let said = ", \"kind\": \"outside-blind-physics\"";
        assert_eq!(of("\"outside:a\"", said), Kind::OutsideBlindPhysics);
        assert_eq!(of("\"a\"", ", \"kind\": \"weak\""), Kind::Weak);
    }
}
