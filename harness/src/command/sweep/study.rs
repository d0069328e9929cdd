//! A finished study, as the page, the tables and the terminal show it.

use super::orbits::Branches;
use super::plan::{Plan, Row};
use super::table;

/// A finished study.
pub struct Study<'a> {
    /// What was asked for.
    pub plan: &'a Plan,
    /// The rows of its table.
    pub rows: &'a [Row],
    /// What came out, row by row.
    pub results: Vec<table::Result>,
    /// Displacements in m at the section points, row by row.
    pub section: Vec<Vec<f64>>,
    /// Branches of periodic motions, where they were asked for.
    pub branches: Branches,
}

impl<'a> Study<'a> {
    pub(super) fn new(
        plan: &'a Plan,
        rows: &'a [Row],
        done: Vec<Option<table::Result>>,
        section: Vec<Vec<f64>>,
        branches: Branches,
    ) -> Self {
        let missing = || table::Result::failed("not computed");
        Self {
            plan,
            rows,
            results: done
                .into_iter()
                .map(|r| r.unwrap_or_else(missing))
                .collect(),
            section,
            branches,
        }
    }
}
