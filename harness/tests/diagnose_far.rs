//! Fits that begin far from the data: where the motion runs away from the measurement in every segment, and on windows that
//! segments fall into.

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

#[test]
fn windows_share_out_a_segment_and_start_away_from_transitions() {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo");
    let fmu = open_fmu(None).unwrap();
    let campaign = Campaign::load(&demo).unwrap();
    let problem = Problem::new(&fmu, &campaign).unwrap();
    // Shortest distance of a start from a transition in s, of windows and if they were cut evenly.
    let (mut shortest, mut shortest_if_even) = (f64::INFINITY, f64::INFINITY);
    for segment in &problem.segments {
        let smoothing = &problem.smoothings[segment.run];
        let interval = problem.campaign.runs[segment.run].sample_interval();
        let length = segment.time.len() / 4;
        let windows = segment.windows(smoothing, interval, length);
        assert_eq!(windows.len(), 4);
        let measured: Vec<f64> = windows.iter().flat_map(|w| w.measured.clone()).collect();
        assert_eq!(measured, segment.measured);
        assert_eq!(
            (windows[0].first, &windows[0].state, windows[0].stuck),
            (segment.first, &segment.state, segment.stuck)
        );
        let distance = |time: f64| {
            let phases = smoothing.stick_slip.phases.iter().skip(1);
            phases
                .map(|p| (p.start - (time - smoothing.first_time)).abs())
                .fold(f64::INFINITY, f64::min)
        };
        for (i, window) in windows.iter().enumerate().skip(1) {
            let even = i * segment.time.len() / 4;
            assert!(window.first.abs_diff(segment.first + even) <= length / 4);
            assert_eq!(window.count, window.trusted.iter().filter(|t| **t).count());
            shortest = shortest.min(distance(window.time[0]));
            shortest_if_even = shortest_if_even.min(distance(segment.time[even]));
        }
    }
    assert!(
        shortest > 3e-4 && shortest > 2.0 * shortest_if_even,
        "{shortest} s, evenly cut {shortest_if_even} s"
    );
}
