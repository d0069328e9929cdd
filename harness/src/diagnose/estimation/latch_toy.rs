//! A model with one segment that its start state meets in a narrow gap alone, of which its beginning tells little and derivatives nothing.
//!
//! ```text
//! w(t) = that of the linear toy + JUMP [|x_2 - RATE| > GAP, second half of the first segment only]
//! ```
//!
//! As a break-away does that comes at its time only where the beam moves right inside the stick before.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::data::white_noise::gaussian;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::jump_toy::{JumpToy, is_first};
use crate::diagnose::estimation::linear_toy::{LinearToy, NOISE, hypothesis, segments_of};
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::SegmentValues;
use crate::diagnose::model::work::Work;

/// The slope that made the data, in m/s.
const RATE: f64 = 1e-3;
/// How far from it the motion jumps, in m/s; the first half of the segment tells it to 2e-5.
const GAP: f64 = 4e-6;
/// How far it jumps, in m.
const JUMP: f64 = 40.0 * NOISE;

/// Root-mean-square error of the first segment over the noise after a fit with or without draws.
fn error_of_first(draws: bool) -> f64 {
    let mut segments = segments_of(|_, t| RATE * t);
    let mut random = fastrand::Rng::with_seed(1);
    let times = segments[0].time.iter();
    let motion = times.map(|t| RATE * t + NOISE * gaussian(&mut random));
    segments[0].measured = motion.collect();
    let h = hypothesis(1);
    let work = Work::default();
    let data = Observations {
        segments: &segments,
        noise: &[NOISE; 2],
        work: &work,
    };
    let options = FitOptions {
        stride: 1,
        robust: false,
        draws,
        ..FitOptions::search(10)
    };
    let mut toy = JumpToy {
        toy: LinearToy { tangents: true },
        jump: |segment: &Segment, values: &SegmentValues| {
            let misses = is_first(segment) && (values.state[1] - RATE).abs() > GAP;
            misses.then_some((segment.time.len() / 2, JUMP))
        },
    };
    let fit = Fitter::new(&mut toy, &h, &data, options).run(Point::centre(&h, &segments));
    fit.mean_square[0].sqrt() / NOISE
}

#[test]
fn a_start_that_derivatives_do_not_find_is_found_by_draws() {
    let (without, with) = (error_of_first(false), error_of_first(true));
    assert!(without > 3.0, "{without} times the noise");
    assert!(with < 1.2, "{with} times the noise");
}
