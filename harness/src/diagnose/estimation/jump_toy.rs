//! A model with one segment that grazes a transition: its motion jumps where a constant passes a value, and no derivative tells of it.
//!
//! ```text
//! w(t) = x_1 + x_2 t + b + theta cos(a t) + JUMP [theta > EDGE, first segment only]
//! ```
//!
//! The start state x_1 undoes the jump, so that the segment bars no way once its start state follows.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::linear_toy::{NOISE, fit_from, hypothesis, segments_of};
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::{Samples, SegmentStart, SegmentValues, Simulator, Turn};
use crate::error::Error;

/// The constant that acts, in m; small enough that a fit begins at the noise where it is zero.
const TRUE: f64 = 0.7 * NOISE;
/// Its value where the motion jumps, in m.
const EDGE: f64 = 0.5 * TRUE;
/// How far it jumps, in m.
const JUMP: f64 = 20.0 * NOISE;

struct JumpToy;

fn wave(t: f64) -> f64 {
    (40.0 * t).cos()
}

impl Simulator for JumpToy {
    fn predict(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        samples: Samples,
        out: &mut Vec<f64>,
    ) -> Result<bool, Error> {
        let times = (0..samples.count).map(|i| segment.time[i * samples.stride]);
        let grazes = segment.run == 0 && segment.first == 0 && values.shared[0] > EDGE;
        let jump = if grazes { JUMP } else { 0.0 };
        let start = |t: f64| values.state[0] + values.state[1] * (t - segment.time[0]);
        out.clear();
        out.extend(times.map(|t| start(t) + values.per_run[0] + values.shared[0] * wave(t) + jump));
        Ok(true)
    }

    fn differentiate(
        &mut self,
        segment: &Segment,
        _: SegmentValues,
        turns: &[Turn],
        samples: Samples,
        slopes: &mut Vec<f64>,
    ) -> bool {
        slopes.clear();
        for turn in turns {
            let times = (0..samples.count).map(|i| segment.time[i * samples.stride]);
            slopes.extend(times.map(|t| match turn {
                Turn::State(0) | Turn::PerRun(_) => 1.0,
                Turn::State(_) => t - segment.time[0],
                Turn::Shared(_) => wave(t),
            }));
        }
        true
    }

    fn carry_on(&mut self, next: &Segment, _: &[f64], _: &[f64]) -> Result<SegmentStart, Error> {
        Ok(SegmentStart {
            state: next.state.clone(),
            stuck: next.stuck,
        })
    }

    fn limit(&self, _: usize) -> f64 {
        1.0
    }
}

#[test]
fn val_a_segment_that_jumps_does_not_bar_the_way() {
    // Source: the constant that made the data; its standard deviation is NOISE sqrt(2 / samples).
    let segments = segments_of(|_, t| TRUE * wave(t));
    let mut h = hypothesis(1);
    h.shared[0].prior_std = 1e-3;
    let start = Point::centre(&h, &segments);
    let fit = fit_from(&mut JumpToy, &h, &segments, start, 10);
    let std = NOISE * (2.0_f64 / 360.0).sqrt();
    let error = fit.point.shared[0] - TRUE;
    assert!(error.abs() < 4.0 * std, "{error:e} m, {std:e} m");
}
