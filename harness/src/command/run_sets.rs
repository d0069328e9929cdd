//! The files in which a calibrated FMU holds what each run has of its own: `resources/runs/<run>.ssv` with its parameters (SSP)
//! and `<run>.csv` with the start states of its pieces. Other masters ignore them.
//!
//! The CSV has a line for each piece: `start_s` and `end_s` since the run's first sample, `measured_m`, the displacement
//! measured at the start, and then FMU variables to be set before initialisation at `start_s`; `sensor_offset` is none of these but is
//! added to what the sensor reads, where the FMU has none.

use std::path::Path;

use super::parameter_set::{read_ssv, ssv};
use crate::diagnose::result::run_sets::{Piece, RunSet};
use crate::error::Error;
use crate::fmu::{Fmu, ModelDescription};
use crate::output::{make_folder, write_file};

/// Where they lie in an FMU.
pub const FOLDER: &str = "resources/runs/";
/// Where they lie beside it.
const BESIDE: &str = "runs";
/// Columns before the FMU's variables.
const COLUMNS: [&str; 3] = ["start_s", "end_s", "measured_m"];

/// The files of these sets: name and content.
pub fn files(description: &ModelDescription, sets: &[RunSet]) -> Vec<(String, Vec<u8>)> {
    let mut out: Vec<(String, Vec<u8>)> = Vec::new();
    for set in sets {
        let plain = plain(&set.run);
        let taken = |stem: &str| out.iter().any(|f| f.0 == format!("{stem}.ssv"));
        let further = (2..).map(|n| format!("{plain}-{n}"));
        let stem = std::iter::once(plain.clone()).chain(further);
        let stem = stem.into_iter().find(|s| !taken(s)).expect("one is free");
        let parameters = ssv(description, &set.run, &set.parameters);
        out.push((format!("{stem}.ssv"), parameters.into_bytes()));
        out.push((format!("{stem}.csv"), table(set).into_bytes()));
    }
    out
}

/// A run's name as that of a file on any system.
fn plain(run: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    run.chars()
        .map(|c| if is_plain(c) { c } else { '_' })
        .collect()
}

fn table(set: &RunSet) -> String {
    let names = COLUMNS.into_iter();
    let names = names.chain(set.start_names.iter().map(String::as_str));
    let mut out = names.collect::<Vec<_>>().join(",") + "\n";
    for piece in &set.pieces {
        let values = [piece.start, piece.end, piece.measured];
        let line: Vec<String> = values
            .iter()
            .chain(&piece.values)
            .map(|v| format!("{v:?}"))
            .collect();
        out += &(line.join(",") + "\n");
    }
    out
}

/// Writes the files into the folder `runs` of `folder`.
///
/// # Errors
/// A folder that can't be written.
pub fn write_beside(files: &[(String, Vec<u8>)], folder: &Path) -> Result<(), Error> {
    let folder = folder.join(BESIDE);
    make_folder(&folder)?;
    files
        .iter()
        .try_for_each(|(name, content)| write_file(&folder.join(name), content))
}

/// The sets that an FMU holds; none in one that was not calibrated.
///
/// # Errors
/// Files that do not say what they should.
pub fn of_fmu(fmu: &Fmu) -> Result<Vec<RunSet>, Error> {
    let files = fmu.files()?;
    let text = |name: &str| {
        let found = files.iter().find(|f| f.0 == name);
        let found = found.ok_or_else(|| broken(fmu, name, "it is missing".to_owned()))?;
        String::from_utf8(found.1.clone()).map_err(|e| broken(fmu, name, e.to_string()))
    };
    let stems = files
        .iter()
        .filter(|f| f.0.starts_with(FOLDER))
        .filter_map(|f| f.0.strip_suffix(".ssv"));
    stems
        .map(|stem| {
            let (ssv, csv) = (format!("{stem}.ssv"), format!("{stem}.csv"));
            let (run, parameters) =
                read_ssv(&text(&ssv)?).map_err(|problem| broken(fmu, &ssv, problem))?;
            let (start_names, pieces) =
                read_table(&text(&csv)?).map_err(|problem| broken(fmu, &csv, problem))?;
            Ok(RunSet {
                run,
                parameters,
                start_names,
                pieces,
            })
        })
        .collect()
}

fn broken(fmu: &Fmu, file: &str, problem: String) -> Error {
    Error::FmuArchive {
        path: fmu.path().to_owned(),
        reason: format!("{file}: {problem}; write the FMU anew with `diagnose` or `try`"),
    }
}

fn read_table(text: &str) -> Result<(Vec<String>, Vec<Piece>), String> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| e.to_string())?.clone();
    let names: Vec<String> = header.iter().map(str::to_owned).collect();
    if names.len() < COLUMNS.len() || names[..COLUMNS.len()] != COLUMNS {
        return Err(format!("the first columns are not {}", COLUMNS.join(", ")));
    }
    let mut pieces = Vec::new();
    for record in reader.deserialize() {
        let values: Vec<f64> = record.map_err(|e| e.to_string())?;
        pieces.push(Piece {
            start: values[0],
            end: values[1],
            measured: values[2],
            values: values[COLUMNS.len()..].to_vec(),
        });
    }
    Ok((names[COLUMNS.len()..].to_vec(), pieces))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::open_fmu;

    #[test]
    fn sets_are_read_as_they_were_written_whatever_the_runs_are_called() {
        let description = open_fmu(None).unwrap().description().clone();
        let set = |run: &str, level: f64| RunSet {
            run: run.to_owned(),
            parameters: vec![
                ("mode_count".to_owned(), 2.0),
                ("friction.level".to_owned(), level),
            ],
            start_names: vec!["start.contact".to_owned(), "q[1]".to_owned()],
            pieces: vec![Piece {
                start: 0.1,
                end: 0.1 + 0.02,
                measured: 1.0 / 3.0,
                values: vec![1.0, -2e-17],
            }],
        };
        // The same file name, and what XML must not hold as it is.
        let sets = [set("a/b \"c\" <&>", 0.9), set("a?b \"c\" <&>", 1.1)];
        let files = files(&description, &sets);
        assert_eq!(files.len(), 4);
        for (set, pair) in sets.iter().zip(files.chunks(2)) {
            let text = |i: usize| String::from_utf8(pair[i].1.clone()).unwrap();
            let (run, parameters) = read_ssv(&text(0)).unwrap();
            let (start_names, pieces) = read_table(&text(1)).unwrap();
            let read = RunSet {
                run,
                parameters,
                start_names,
                pieces,
            };
            assert_eq!(&read, set);
        }
        assert_ne!(files[0].0, files[2].0);
    }

    #[test]
    fn files_that_say_something_else_are_refused() {
        for text in [
            "",
            "t,x\n1,2\n",
            "start_s,end_s,measured_m,q[1]\n0,1,2\n",
            "start_s,end_s,measured_m\n0,1,x\n",
        ] {
            assert!(read_table(text).is_err(), "{text}");
        }
        for text in [
            "",
            "<a/>",
            "<ParameterSet name=\"x\"><Parameter/></ParameterSet>",
        ] {
            assert!(read_ssv(text).is_err(), "{text}");
        }
    }
}
