//! What effects gain by chance, from simulated campaigns.

use crate::diagnose::model::problem::Problem;
use crate::diagnose::selection::bootstrap;
use crate::diagnose::selection::outcome::Selection;
use crate::error::Error;
use crate::watch::Watch;
use std::ops::Range;

/// Simulates `count` campaigns without the effect for each step of a selection's path (for the calibrated model where the
/// path is empty) and raises the threshold to the largest gain by chance, where that is more.
///
/// # Errors
/// An FMU that can't be run.
pub fn calibrate_threshold(
    problem: &Problem,
    selection: &mut Selection,
    count: usize,
    watch: &dyn Watch,
) -> Result<(), Error> {
    let gains = gains_by_chance(problem, selection, 0..count, watch)?;
    selection.judge_by_chance(gains);
    Ok(())
}

/// The largest gains by chance for each step of the path, in those of the simulated campaigns that `which` numbers.
///
/// # Errors
/// An FMU that can't be run.
pub fn gains_by_chance(
    problem: &Problem,
    selection: &Selection,
    which: Range<usize>,
    watch: &dyn Watch,
) -> Result<Vec<Vec<f64>>, Error> {
    let steps = 0..selection.path.len().max(1);
    let of_step = |search: usize| {
        let base = match search {
            0 => &selection.calibrated,
            _ => &selection.path[search - 1],
        };
        bootstrap::largest_gains(problem, base, which.clone(), watch)
    };
    steps.map(of_step).collect()
}
