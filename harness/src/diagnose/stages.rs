//! The stages of a diagnosis, in the order in which they are passed; those that a campaign does not need are left out.

use crate::watch::Stage;

/// Smoothing and cutting the runs, and the reference model fitted.
pub const REFERENCE: Stage = stage("reference model", 0.1);
/// Every effect of the catalogue alone.
pub const SINGLES: Stage = stage("single effects", 0.5);
/// Effects of the library that may explain the data as well as the best of the catalogue.
pub const LIBRARY: Stage = stage("library effects", 0.6);
/// Effects of the library, and two effects together, on short windows.
pub const SETS: Stage = stage("library and pairs of effects", 0.7);
/// Two effects together, on beginnings of the segments.
pub const PAIRS_FURTHER: Stage = stage("pairs of effects, further", 0.72);
/// What comes close to the best, fitted until it compares.
pub const CLOSE: Stage = stage("effects close to the best", 0.75);
/// Curves of one quantity where the catalogue has no answer, or one with values along each run.
pub const UNKNOWN: Stage = stage("unknown functions", 0.8);
/// Every effect beside what explains the data.
pub const EXTENSIONS: Stage = stage("effects beside the best", 0.9);
/// What explains most where nothing explains all.
pub const INCOMPLETE: Stage = stage("what explains most", 0.96);
/// The best on all segments and samples.
pub const ALL_DATA: Stage = stage("the best on all data", 0.94);
/// The search once more, where runs kept out contradicted what it found: they are fitted, and others kept out.
pub const AGAIN: Stage = stage("search with other runs kept out", 0.95);
/// Forecasts of the runs kept out.
pub const KEPT_OUT: Stage = stage("runs kept out", 0.98);
/// Conclusions and report.
pub const REPORT: Stage = stage("report", 1.0);

/// A stage and the share of the whole that is done when it ends, roughly, of a campaign with one effect.
const fn stage(name: &'static str, until: f64) -> Stage {
    Stage { name, until }
}
