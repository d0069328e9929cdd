//! A model with one segment that its start state meets in a narrow gap alone, of which its beginning tells little and derivatives nothing.
//!
//! ```text
//! w(t) = that of the linear toy + JUMP [|x_2 - RATE| > GAP, second half of the first segment only]
//! ```
//!
//! As a break-away does that comes at its time only where the beam moves right inside the stick before. In the second
//! test it is the last quarter of the second segment, of which the first half is not measured: the segment before tells the rate.

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
/// The same in the second test, in m/s; the whole segment before tells it to 7e-6.
const NARROW: f64 = 1e-6;
/// How far it jumps, in m.
const JUMP: f64 = 40.0 * NOISE;

/// Segments of which the first ones, so many, are measured on one motion.
fn lasting(count: usize, seed: u64) -> Vec<Segment> {
    let mut segments = segments_of(|_, t| RATE * t);
    let mut random = fastrand::Rng::with_seed(seed);
    for segment in &mut segments[..count] {
        let times = segment.time.iter();
        let motion = times.map(|t| RATE * t + NOISE * gaussian(&mut random));
        segment.measured = motion.collect();
    }
    segments
}

fn options(draws: bool) -> FitOptions {
    FitOptions {
        stride: 1,
        robust: false,
        draws,
        ..FitOptions::search(10)
    }
}

/// Root-mean-square error of the first segment over the noise after a fit with or without draws.
fn error_of_first(draws: bool) -> f64 {
    let segments = lasting(1, 1);
    let h = hypothesis(1);
    let work = Work::default();
    let data = Observations {
        segments: &segments,
        noise: &[NOISE; 2],
        work: &work,
    };
    let mut toy = JumpToy {
        toy: LinearToy::new(true),
        jump: |segment: &Segment, values: &SegmentValues| {
            let misses = is_first(segment) && (values.state[1] - RATE).abs() > GAP;
            misses.then_some((segment.time.len() / 2, JUMP))
        },
    };
    let fit = Fitter::new(&mut toy, &h, &data, options(draws)).run(Point::centre(&h, &segments));
    fit.mean_square[0].sqrt() / NOISE
}

#[test]
fn a_start_that_derivatives_do_not_find_is_found_by_draws() {
    let (without, with) = (error_of_first(false), error_of_first(true));
    assert!(without > 3.0, "{without} times the noise");
    assert!(with < 1.2, "{with} times the noise");
}

/// Whether it is the segment after the first.
fn is_second(segment: &Segment) -> bool {
    segment.run == 0 && segment.first > 0 && segment.first == segment.time.len()
}

#[test]
fn a_start_of_which_the_beginning_tells_little_is_found_from_the_segment_before() {
    let mut segments = lasting(2, 3);
    let half = segments[1].time.len() / 2;
    segments[1].trusted[..half].fill(false);
    segments[1].count = half;
    let h = hypothesis(1);
    let work = Work::default();
    let data = Observations {
        segments: &segments,
        noise: &[NOISE; 2],
        work: &work,
    };
    let jump = |segment: &Segment, values: &SegmentValues| {
        let misses = is_second(segment) && (values.state[1] - RATE).abs() > NARROW;
        misses.then_some((segment.time.len() * 3 / 4, JUMP))
    };
    let toy = LinearToy::new(true);
    let mut toy = JumpToy { toy, jump };
    let mut fitter = Fitter::new(&mut toy, &h, &data, options(false));
    let fit = fitter.run(Point::centre(&h, &segments));
    let over_noise =
        |fitter: &mut Fitter, point: &Point| (fitter.sum(1, point) / half as f64).sqrt() / NOISE;
    let without = over_noise(&mut fitter, &fit.point);
    assert!(without > 3.0, "{without} times the noise");
    assert!(fitter.carried_on(0, &fit.point).is_none());
    assert!(fitter.drawn_and_carried_on(3, &fit.point).is_none());
    let mut carried = fit.point.clone();
    carried.put(1, fitter.carried_on(1, &fit.point).unwrap());
    let by_end = over_noise(&mut fitter, &carried);
    assert!(by_end > 3.0, "{by_end} times the noise");
    let mut point = fit.point.clone();
    assert!(fitter.try_carried_on(&mut point));
    let with = over_noise(&mut fitter, &point);
    // Of 30 samples of noise alone: three standard deviations.
    assert!(with < 1.4, "{with} times the noise");
}
