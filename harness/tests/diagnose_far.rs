//! Fits that begin where the motion runs away from the measurement in every segment.

use std::path::Path;
use stickslip::command::open_fmu;
use stickslip::diagnose::estimation::fit::Fit;
use stickslip::diagnose::estimation::fit_options::FitOptions;
use stickslip::diagnose::estimation::fitter::Fitter;
use stickslip::diagnose::model::observations::Observations;

use stickslip::diagnose::model::point::Point;
use stickslip::diagnose::model::problem::Problem;
use stickslip::diagnose::selection::screening::Screen;
use stickslip::measurement::Campaign;

/// Start states of the reference model, fitted from the smoothed ones, the first modal velocity `faster` in m/s.
fn fit(problem: &Problem, screen: &Screen, faster: f64) -> Fit {
    let h = problem.hypothesis(&[]).unwrap();
    let mut predictor = problem.predictor(&h).unwrap();
    let data: Observations = problem.data(&screen.segments);
    let mut start = Point::centre(&h, &screen.segments);
    for state in &mut start.states {
        state[1] += faster;
    }
    let options = FitOptions {
        parameters: false,
        reinitialise: false,
        ..FitOptions::search(20)
    };
    Fitter::new(&mut predictor, &h, &data, options).run(start)
}

#[test]
fn a_fit_descends_from_where_every_segment_runs_away() {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo");
    let fmu = open_fmu(None).unwrap();
    let campaign = Campaign::load(&demo).unwrap();
    let problem = Problem::new(&fmu, &campaign).unwrap();
    let screen = Screen::new(&problem);
    let near = fit(&problem, &screen, 0.0);
    // 4 m/s swing the tip by 16 mm, sixteen times as far as the measured motion.
    let far = fit(&problem, &screen, 4.0);
    assert!(far.trimmed.is_finite(), "objective {}", far.trimmed);
    assert!(
        far.trimmed < 2.0 * near.trimmed,
        "{} from afar, {} from near by",
        far.trimmed,
        near.trimmed
    );
}
