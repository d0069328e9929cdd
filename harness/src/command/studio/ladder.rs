//! The error ladder as a history: every try is a rung. It lives in a file of the output folder, so that closing and opening goes on.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::model::{Draft, Starts, Values};
use super::preview::Errors;
use crate::error::Error;
use crate::output::write_file;

/// The file.
pub const FILE: &str = "studio.json";
/// Form of the file; another one is not read.
const FORM: u32 = 1;

/// How a rung came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// The model as given, without effects.
    Given,
    /// By the sliders.
    Hand,
    /// By a fit.
    Fit,
    /// By a diagnosis.
    Diagnosis,
}

/// One try.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Rung {
    /// Number that it keeps.
    pub id: u64,
    /// Name.
    pub name: String,
    /// How it came about.
    pub origin: Origin,
    /// The rung that it began from.
    pub before: Option<u64>,
    /// The model.
    pub draft: Draft,
    /// Its errors.
    pub errors: Errors,
    /// Error of one-cycle forecasts of the runs kept out; `None` where none is kept out or they are too short.
    pub forecast: Option<f64>,
    /// Where its segments start; none once the campaign has changed.
    pub starts: Option<Starts>,
}

/// All tries, and the model that was turned last.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Ladder {
    form: u32,
    /// Digest of the campaign and the program's version.
    pub inputs: String,
    /// The tries, in the order in which they were made.
    pub rungs: Vec<Rung>,
    /// The model on the page.
    pub draft: Draft,
    /// The rung that it starts from.
    pub base: u64,
}

impl Ladder {
    /// A new one that begins with `first`.
    pub fn new(inputs: String, first: Rung) -> Ladder {
        Ladder {
            form: FORM,
            inputs,
            draft: first.draft.clone(),
            base: first.id,
            rungs: vec![first],
        }
    }

    /// The one in `folder`; `None` where there is none.
    ///
    /// # Errors
    /// A file that can't be read or is of another form.
    pub fn read(folder: &Path) -> Result<Option<Ladder>, Error> {
        let path = folder.join(FILE);
        if !path.exists() {
            return Ok(None);
        }
        let text = std::fs::read_to_string(&path).map_err(Error::read(&path))?;
        let broken = |problem: String| Error::StudioState {
            path: path.clone(),
            problem,
        };
        let ladder: Ladder = serde_json::from_str(&text).map_err(|e| broken(e.to_string()))?;
        if ladder.form != FORM {
            return Err(broken(format!("its form is {}, not {FORM}", ladder.form)));
        }
        match ladder.rung(ladder.base) {
            Ok(_) => Ok(Some(ladder)),
            Err(_) => Err(broken(
                "its model begins from a rung that is not there".into(),
            )),
        }
    }

    /// Writes it into `folder`.
    ///
    /// # Errors
    /// A folder that can't be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let text = serde_json::to_vec(self).expect("numbers and texts have a JSON form");
        write_file(&folder.join(FILE), &text)
    }

    /// The rung with a number.
    ///
    /// # Errors
    /// [`Error::NoRung`].
    pub fn rung(&self, id: u64) -> Result<&Rung, Error> {
        let found = self.rungs.iter().find(|rung| rung.id == id);
        found.ok_or(Error::NoRung { id })
    }

    /// The next free number.
    pub fn next_id(&self) -> u64 {
        self.rungs.iter().map(|rung| rung.id + 1).max().unwrap_or(0)
    }

    /// Takes a rung away; the first stays, and what began from it begins from the first.
    ///
    /// # Errors
    /// [`Error::NoRung`], also for the first.
    pub fn forget(&mut self, id: u64) -> Result<(), Error> {
        let first = self.rungs[0].id;
        if id == first {
            return Err(Error::NoRung { id });
        }
        self.rung(id)?;
        self.rungs.retain(|rung| rung.id != id);
        if self.base == id {
            self.base = first;
        }
        for rung in &mut self.rungs {
            if rung.before == Some(id) {
                rung.before = Some(first);
            }
        }
        Ok(())
    }
}

/// One thing in which two models differ.
#[derive(Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The parameter, with the run where it is a run's own, or the effect.
    pub name: String,
    /// In the first; `None` where it is off or not given.
    pub first: Option<f64>,
    /// In the second.
    pub second: Option<f64>,
}

/// Relative difference of two values that counts as none: their rounding in files.
const SAME: f64 = 1e-9;

/// In what two drafts differ, and nothing else.
pub fn differences(a: &Draft, b: &Draft) -> Vec<Difference> {
    let mut found = Vec::new();
    let on = |draft: &Draft, id: &String| draft.effects.contains_key(id).then_some(1.0);
    let mut ids: Vec<&String> = a.effects.keys().chain(b.effects.keys()).collect();
    ids.sort();
    ids.dedup();
    for id in ids {
        let (first, second) = (on(a, id), on(b, id));
        if first != second {
            found.push(Difference {
                name: id.clone(),
                first,
                second,
            });
        }
        let none = Values::new();
        let settings = |draft: &Draft| draft.effects.get(id).unwrap_or(&none).clone();
        compare(
            &format!("{id}."),
            "",
            &settings(a),
            &settings(b),
            &mut found,
        );
    }
    compare("", "", &a.shared, &b.shared, &mut found);
    let mut runs: Vec<&String> = a.own.keys().chain(b.own.keys()).collect();
    runs.sort();
    runs.dedup();
    for run in runs {
        let of = |draft: &Draft| draft.own.get(run).cloned().unwrap_or_default();
        compare("", &format!(" ({run})"), &of(a), &of(b), &mut found);
    }
    found
}

fn compare(before: &str, behind: &str, a: &Values, b: &Values, found: &mut Vec<Difference>) {
    let mut names: Vec<&String> = a.keys().chain(b.keys()).collect();
    names.sort();
    names.dedup();
    for name in names {
        let (first, second) = (a.get(name).copied(), b.get(name).copied());
        let same = match (first, second) {
            (Some(x), Some(y)) => (x - y).abs() <= SAME * x.abs().max(y.abs()),
            _ => false,
        };
        if !same {
            found.push(Difference {
                name: format!("{before}{name}{behind}"),
                first,
                second,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors() -> Errors {
        Errors {
            by_run: vec![Some(0.1)],
            fitted: Some(0.1),
            kept_out: None,
            ran_away: 0,
            segments: 1,
        }
    }

    fn rung(id: u64, before: Option<u64>) -> Rung {
        Rung {
            id,
            name: format!("try {id}"),
            origin: Origin::Hand,
            before,
            draft: Draft::default(),
            errors: errors(),
            forecast: None,
            starts: None,
        }
    }

    #[test]
    fn what_was_written_is_read_and_what_is_broken_is_told() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Ladder::read(folder.path()).unwrap().is_none());
        let mut ladder = Ladder::new("digest".into(), rung(0, None));
        ladder
            .draft
            .shared
            .insert("friction.mu_0".into(), 0.123_456_789_012_345_67);
        ladder.write(folder.path()).unwrap();
        let read = Ladder::read(folder.path()).unwrap().unwrap();
        assert_eq!(read.draft, ladder.draft);
        let path = folder.path().join(FILE);
        let text = std::fs::read_to_string(&path).unwrap();
        for broken in [
            &text[..text.len() / 2],
            &text.replace("\"form\":1", "\"form\":9"),
        ] {
            std::fs::write(&path, broken).unwrap();
            let error = Ladder::read(folder.path()).unwrap_err().to_string();
            assert!(error.contains(FILE), "{error}");
        }
    }

    #[test]
    fn a_rung_that_goes_leaves_its_heirs_to_the_first_which_stays() {
        let mut ladder = Ladder::new(String::new(), rung(0, None));
        ladder.rungs.extend([rung(1, Some(0)), rung(2, Some(1))]);
        ladder.base = 1;
        ladder.forget(1).unwrap();
        assert_eq!((ladder.base, ladder.rungs[1].before), (0, Some(0)));
        assert_eq!(ladder.next_id(), 3);
        assert!(ladder.forget(0).is_err() && ladder.forget(1).is_err());
    }

    #[test]
    fn two_models_show_only_what_differs() {
        let mut a = Draft::default();
        a.shared.insert("friction.mu_0".into(), 0.3);
        a.shared.insert("friction.v1".into(), 1.0);
        let mut b = a.clone();
        assert_eq!(differences(&a, &b), []);
        b.shared.insert("friction.v1".into(), 1.0 + 1e-12);
        b.effects.insert("drag".into(), Values::new());
        b.own
            .entry("run01".into())
            .or_default()
            .insert("level".into(), 2.0);
        let names: Vec<String> = differences(&a, &b).into_iter().map(|d| d.name).collect();
        assert_eq!(names, ["drag", "level (run01)"]);
    }
}
