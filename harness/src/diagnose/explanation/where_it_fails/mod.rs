//! Where predictions fail, by six quantities, each with the sentence that follows from the numbers: what the contact does, velocity and
//! displacement, the place on the belt, the time in the run, the operating point, the frequency.

mod dependence_test;
mod level;
mod quantities;
mod sentence;

pub use dependence_test::{CHANCE, FACTOR, Finding, SHUFFLES};
pub use level::Level;
pub use quantities::{COLUMNS, ROWS};

use crate::diagnose::explanation::misses::misses;
use crate::diagnose::explanation::replay::Replay;
use crate::diagnose::model::problem::Problem;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The error over one quantity.
#[derive(Debug, Clone)]
pub struct ErrorOver {
    /// The quantity's key in `diagnosis.json`.
    pub key: &'static str,
    /// The quantity in a sentence.
    pub quantity: &'static str,
    /// The error in its intervals.
    pub levels: Vec<Level>,
    /// Of a plane, the middles of the second quantity's intervals; else empty.
    pub rows: Vec<f64>,
    /// Whether the error depends on it.
    pub finding: Finding,
    /// What that says.
    pub statement: String,
}

impl ErrorOver {
    fn new(key: &'static str, quantity: &'static str, levels: Vec<Level>) -> ErrorOver {
        let finding = dependence_test::judge(&levels);
        ErrorOver {
            key,
            quantity,
            finding,
            statement: sentence::sentence(quantity, &levels, finding),
            levels,
            rows: Vec::new(),
        }
    }

    /// Smallest and largest error over the noise of the intervals that count.
    pub fn range(&self) -> Option<(f64, f64)> {
        let known = || self.levels.iter().filter(|l| l.is_known());
        let low = known().map(|l| l.over_noise).reduce(f64::min)?;
        Some((low, known().map(|l| l.over_noise).reduce(f64::max)?))
    }

    fn json(&self) -> Value {
        let intervals: Vec<Value> = self
            .levels
            .iter()
            .filter(|l| l.is_known())
            .map(|l| {
                let place = match l.stratum_name.is_empty() {
                    true => l.place.clone(),
                    false => format!("in {}, {}", l.stratum_name, l.place),
                };
                json!({ "where": place, "over_noise": l.over_noise, "std_of_log": l.std_of_log(), "segments": l.segments })
            })
            .collect();
        json!({
            "over": self.key,
            "depends": match self.finding {
                Finding::Depends => Some(true),
                Finding::Same => Some(false),
                Finding::Chance | Finding::TooFew => None,
            },
            "statement": self.statement,
            "intervals": intervals,
        })
    }
}

/// The error over each of the six quantities.
#[derive(Debug, Clone)]
pub struct WhereItFails {
    /// What the contact does.
    pub contact_phase: ErrorOver,
    /// Relative velocity and displacement: [`ROWS`] of displacement times [`COLUMNS`] of velocity, stick the first of them.
    pub plane: ErrorOver,
    /// The place on the belt, run by run.
    pub place: ErrorOver,
    /// The time since the run began.
    pub time: ErrorOver,
    /// The operating point.
    pub operating_point: ErrorOver,
    /// The frequency, in octaves.
    pub frequency: ErrorOver,
}

impl WhereItFails {
    /// Where the predictions of a model fail.
    pub fn new(problem: &Problem, replays: &BTreeMap<usize, Replay>) -> WhereItFails {
        let misses = misses(problem, replays);
        WhereItFails {
            contact_phase: ErrorOver::new(
                "contact_phase",
                "what the contact does",
                quantities::by_contact_phase(&misses),
            ),
            plane: ErrorOver {
                rows: quantities::rows_of_plane(&misses),
                ..ErrorOver::new(
                    "relative_velocity_and_displacement",
                    "velocity and displacement",
                    quantities::by_plane(&misses),
                )
            },
            place: ErrorOver::new(
                "belt_position",
                "the place on the belt",
                quantities::by_place(problem, &misses),
            ),
            time: ErrorOver::new("time", "the time in the run", quantities::by_time(&misses)),
            operating_point: ErrorOver::new(
                "operating_point",
                "the operating point",
                quantities::by_operating_point(problem, &misses),
            ),
            frequency: ErrorOver::new(
                "frequency",
                "the frequency",
                quantities::by_frequency(problem, replays),
            ),
        }
    }

    /// All six, in the order of the report.
    pub fn all(&self) -> [&ErrorOver; 6] {
        [
            &self.contact_phase,
            &self.plane,
            &self.place,
            &self.time,
            &self.operating_point,
            &self.frequency,
        ]
    }

    /// For `diagnosis.json`.
    pub fn json(&self) -> Value {
        self.all().iter().map(|e| e.json()).collect()
    }
}
