//! The folder of a study: results are appended as they come, so that an interrupted study goes on where it was.
//!
//! A row counts as done once its line in sweep.csv is whole. Section points and end states are written before it;
//! those of rows that are not done are dropped when the study goes on.

use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use beam_physics::sweep::{Carry, Motion};

use super::plan::{Plan, Row};
use super::table;
use crate::error::Error;
use crate::output::{make_folder, write_file};

const PLAN: &str = "sweep.json";
const TABLE: &str = "sweep.csv";
const SECTION: &str = "section.csv";
/// End states of continuations.
const STATES: &str = "states.csv";
const LOCK: &str = ".sweep.lock";

/// An open folder.
pub struct Store {
    folder: PathBuf,
    table: File,
    section: File,
    states: File,
    /// Results by row.
    pub done: Vec<Option<table::Result>>,
    /// End states of continuations by row.
    pub carried: Vec<Option<Carry>>,
    /// Held while this process writes.
    _lock: File,
}

impl Store {
    /// Opens `folder` for the plan, with what is there already.
    ///
    /// # Errors
    /// A folder of another sweep, one that can't be written, or one in use.
    pub fn open(folder: &Path, plan: &Plan, rows: &[Row]) -> Result<Store, Error> {
        let at = |name: &str| folder.join(name);
        let identity = serde_json::to_string_pretty(&plan.identity()).expect("plain values") + "\n";
        let is_new = !at(PLAN).exists();
        if is_new {
            for name in [TABLE, SECTION] {
                if at(name).exists() {
                    return Err(Error::OtherSweep {
                        folder: folder.into(),
                        difference: format!("there is a {name} but no {PLAN}"),
                    });
                }
            }
        } else {
            let found = std::fs::read_to_string(at(PLAN)).map_err(Error::read(&at(PLAN)))?;
            if found != identity {
                return Err(Error::OtherSweep {
                    folder: folder.into(),
                    difference: difference(&found, &plan.identity()),
                });
            }
        }
        make_folder(folder)?;
        let lock = File::create(at(LOCK)).map_err(Error::write(&at(LOCK)))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(Error::FolderInUse {
                    folder: folder.into(),
                });
            }
            Err(TryLockError::Error(source)) => return Err(Error::write(&at(LOCK))(source)),
        }
        if is_new {
            write_file(&at(TABLE), table::header(plan).as_bytes())?;
            write_file(&at(SECTION), table::section_header(plan).as_bytes())?;
            write_file(&at(STATES), b"id,modes,dimension,travel_m,state\n")?;
            // Last, because it says that the others are there.
            write_file(&at(PLAN), identity.as_bytes())?;
        }
        let done = clean(plan, rows, folder)?;
        let carried = states(&at(STATES), rows.len())?;
        let append = |name: &str| {
            OpenOptions::new()
                .append(true)
                .open(at(name))
                .map_err(Error::write(&at(name)))
        };
        Ok(Store {
            table: append(TABLE)?,
            section: append(SECTION)?,
            states: append(STATES)?,
            folder: folder.into(),
            done,
            carried,
            _lock: lock,
        })
    }

    /// Adds a row's result.
    ///
    /// # Errors
    /// A disk that is full.
    pub fn add(
        &mut self,
        id: usize,
        row: &Row,
        motion: Result<&Motion, String>,
    ) -> Result<(), Error> {
        let result = match &motion {
            Ok(motion) => table::Result::of(motion),
            Err(reason) => table::Result::failed(reason),
        };
        let write = |file: &mut File, name: &str, text: &str| {
            file.write_all(text.as_bytes())
                .map_err(Error::write(&self.folder.join(name)))
        };
        if let Ok(motion) = motion {
            write(
                &mut self.section,
                SECTION,
                &table::section_lines(row, motion),
            )?;
            if let Some(end) = &motion.end {
                write(&mut self.states, STATES, &state_line(id, end))?;
                self.carried[id] = Some(end.clone());
            }
        }
        write(&mut self.table, TABLE, &table::line(row, &result))?;
        self.done[id] = Some(result);
        Ok(())
    }

    /// Puts the tables into the order of the plan, so that they do not depend on which point came first.
    ///
    /// # Errors
    /// A disk that is full; the tables are then as they were.
    pub fn sort(&self, plan: &Plan, rows: &[Row]) -> Result<(), Error> {
        let mut text = table::header(plan);
        for (row, result) in rows.iter().zip(&self.done) {
            if let Some(result) = result {
                text += &table::line(row, result);
            }
        }
        write_file(&self.folder.join(TABLE), text.as_bytes())?;
        let path = self.folder.join(SECTION);
        let old = std::fs::read_to_string(&path).map_err(Error::read(&path))?;
        let mut sorted: Vec<(usize, &str)> = Vec::new();
        let places = places(rows);
        for line in old.lines().skip(1) {
            if let Some(&id) = key_of(plan, line).and_then(|key| places.get(&key)) {
                sorted.push((id, line));
            }
        }
        // Stable: the points of a row stay in the order of time.
        sorted.sort_by_key(|(id, _)| *id);
        let mut text = table::section_header(plan);
        for (_, line) in sorted {
            text += line;
            text.push('\n');
        }
        write_file(&path, text.as_bytes())
    }

    /// Section points by row: displacements in m.
    ///
    /// # Errors
    /// A file that can't be read.
    pub fn section(&self, plan: &Plan, rows: &[Row]) -> Result<Vec<Vec<f64>>, Error> {
        let path = self.folder.join(SECTION);
        let text = std::fs::read_to_string(&path).map_err(Error::read(&path))?;
        let places = places(rows);
        let mut out = vec![Vec::new(); rows.len()];
        for line in text.lines().skip(1) {
            if let Some(&id) = key_of(plan, line).and_then(|key| places.get(&key))
                && let Some(w) = line.split(',').nth(plan.axes.len() + 3)
                && let Ok(w) = w.parse()
            {
                out[id].push(w);
            }
        }
        Ok(out)
    }
}

fn places(rows: &[Row]) -> HashMap<String, usize> {
    let keys = rows.iter().enumerate();
    keys.map(|(i, row)| (row.key(), i)).collect()
}

/// The first fields of a line of section.csv; starts' names have no commas.
fn key_of(plan: &Plan, line: &str) -> Option<String> {
    let fields: Vec<&str> = line.split(',').collect();
    let keys = plan.axes.len() + 1;
    (fields.len() == keys + 4).then(|| fields[..keys].join(","))
}

/// Reads what is done, and drops what a crash or a full disk has cut off.
fn clean(plan: &Plan, rows: &[Row], folder: &Path) -> Result<Vec<Option<table::Result>>, Error> {
    let places = places(rows);
    let mut done = vec![None; rows.len()];
    let path = folder.join(TABLE);
    let text = std::fs::read_to_string(&path).map_err(Error::read(&path))?;
    let mut kept = table::header(plan);
    for line in text.split_inclusive('\n').skip(1) {
        let whole = line.ends_with('\n').then(|| table::parse(plan, line));
        if let Some(Some((key, result))) = whole
            && let Some(&id) = places.get(&key)
            && done[id].is_none()
        {
            kept += &table::line(&rows[id], &result);
            done[id] = Some(result);
        }
    }
    if kept != text {
        write_file(&path, kept.as_bytes())?;
    }
    let path = folder.join(SECTION);
    let text = std::fs::read_to_string(&path).map_err(Error::read(&path))?;
    let mut kept = table::section_header(plan);
    let is_done = |line: &str| {
        let id = key_of(plan, line).and_then(|key| places.get(&key).copied());
        id.is_some_and(|id| done[id].is_some())
    };
    for line in text.split_inclusive('\n').skip(1) {
        if line.ends_with('\n') && is_done(line) {
            kept += line;
        }
    }
    if kept != text {
        write_file(&path, kept.as_bytes())?;
    }
    Ok(done)
}

fn state_line(id: usize, carry: &Carry) -> String {
    let state: Vec<String> = carry.state[..carry.dimension]
        .iter()
        .map(f64::to_string)
        .collect();
    format!(
        "{id},{},{},{},{}\n",
        carry.modes,
        carry.dimension,
        carry.travel,
        state.join(" ")
    )
}

fn states(path: &Path, rows: usize) -> Result<Vec<Option<Carry>>, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::read(path))?;
    let mut out = vec![None; rows];
    for line in text.split_inclusive('\n').skip(1) {
        if let Some((id, carry)) = line.strip_suffix('\n').and_then(parse_state)
            && id < rows
        {
            out[id] = Some(carry);
        }
    }
    Ok(out)
}

fn parse_state(line: &str) -> Option<(usize, Carry)> {
    let mut fields = line.split(',');
    let id = fields.next()?.parse().ok()?;
    let modes = fields.next()?.parse().ok()?;
    let dimension: usize = fields.next()?.parse().ok()?;
    let travel = fields.next()?.parse().ok()?;
    let values: Vec<f64> = fields
        .next()?
        .split(' ')
        .map(|v| v.parse().ok())
        .collect::<Option<_>>()?;
    let mut carry = Carry {
        modes,
        dimension,
        travel,
        ..Carry::default()
    };
    if values.len() != dimension || dimension > carry.state.len() {
        return None;
    }
    carry.state[..dimension].copy_from_slice(&values);
    Some((id, carry))
}

/// The first key in which two plans differ, with both values.
fn difference(found: &str, wanted: &serde_json::Value) -> String {
    let Ok(serde_json::Value::Object(found)) = serde_json::from_str(found) else {
        return format!("its {PLAN} can't be read");
    };
    let short = |v: Option<&serde_json::Value>| {
        let text = v.map_or("nothing".to_owned(), ToString::to_string);
        match text.char_indices().nth(120) {
            Some((cut, _)) => format!("{}...", &text[..cut]),
            None => text,
        }
    };
    let keys = wanted.as_object().into_iter().flatten();
    for (key, value) in keys {
        if found.get(key) != Some(value) {
            return format!(
                "{key} is {} there and {} here",
                short(found.get(key)),
                short(Some(value))
            );
        }
    }
    "it has further keys".into()
}
