//! The reference model with its nominal values, judged.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::selection::screening::Screen;
use crate::diagnose::validation::forecast::{Forecast, forecasts};
use crate::diagnose::validation::segment_errors;
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::error::Error;

/// The reference model with its nominal values.
pub(super) fn as_given(
    problem: &Problem,
    screen: &Screen,
) -> Result<(SegmentErrors, SegmentErrors, Vec<Forecast>), Error> {
    let h = problem.hypothesis(&[])?;
    let mut predictor = problem.predictor(&h)?;
    let options = FitOptions::search(5);
    let segments = &screen.segments;
    let data = problem.data(segments);
    let fit = Fitter::new(&mut predictor, &h, &data, options)
        .fit_initial_states(Point::centre(&h, segments));
    let on_fit = segment_errors::of_fit(problem, &screen.indices, &fit);
    let (_, test) = segment_errors::held_out_segments(problem);
    let test_segments = problem.copies(&test);
    let data = problem.data(&test_segments);
    let on_test = Fitter::new(&mut predictor, &h, &data, options)
        .fit_initial_states(Point::centre(&h, &test_segments));
    drop(predictor);
    let fitted = FittedHypothesis { hypothesis: h, fit };
    let forecasts = forecasts(problem, &fitted)?;
    Ok((
        on_fit,
        segment_errors::of_fit(problem, &test, &on_test),
        forecasts,
    ))
}
