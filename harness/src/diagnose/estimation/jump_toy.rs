//! A model with one segment that grazes a transition: its motion jumps where a constant passes a value, and no derivative tells of it.
//!
//! ```text
//! w(t) = that of the linear toy with one constant theta + JUMP [theta > EDGE, first segment only]
//! ```
//!
//! The start state x_1 undoes the jump, so that the segment bars no way once its start state follows.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::linear_toy::{
    LinearToy, NOISE, fit_from, hypothesis, segments_of, shape,
};
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::{Samples, SegmentStart, SegmentValues, Simulator, Turn};
use crate::error::Error;

/// The constant that acts, in m; small enough that a fit begins at the noise where it is zero.
const TRUE: f64 = 0.7 * NOISE;
/// Its value where the motion jumps, in m.
const EDGE: f64 = 0.5 * TRUE;
/// How far it jumps, in m.
const JUMP: f64 = 20.0 * NOISE;

/// The linear toy with a jump of its motion that no derivative tells of.
pub(crate) struct JumpToy<J> {
    pub(crate) toy: LinearToy,
    /// Of a segment with these values: the sample from which on it jumps, and how far in m.
    pub(crate) jump: J,
}

impl<J: Fn(&Segment, &SegmentValues) -> Option<(usize, f64)>> Simulator for JumpToy<J> {
    fn predict(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        samples: Samples,
        out: &mut Vec<f64>,
    ) -> Result<bool, Error> {
        let jump = (self.jump)(segment, &values);
        let is_whole = self.toy.predict(segment, values, samples, out)?;
        if let Some((from, by)) = jump {
            let later = out.iter_mut().skip(from / samples.stride);
            later.for_each(|w| *w += by);
        }
        Ok(is_whole)
    }

    fn differentiate(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        turns: &[Turn],
        samples: Samples,
        slopes: &mut Vec<f64>,
    ) -> bool {
        self.toy
            .differentiate(segment, values, turns, samples, slopes)
    }

    fn carry_on(&mut self, next: &Segment, u: &[f64], own: &[f64]) -> Result<SegmentStart, Error> {
        self.toy.carry_on(next, u, own)
    }

    fn limit(&self, run: usize) -> f64 {
        self.toy.limit(run)
    }
}

/// Whether it is the segment that jumps.
pub(crate) fn is_first(segment: &Segment) -> bool {
    segment.run == 0 && segment.first == 0
}

#[test]
fn val_a_segment_that_jumps_does_not_bar_the_way() {
    // Source: the constant that made the data; its standard deviation is NOISE sqrt(2 / samples).
    let segments = segments_of(|_, t| TRUE * shape(0, t));
    let mut h = hypothesis(1);
    h.shared[0].prior_std = 1e-3;
    let start = Point::centre(&h, &segments);
    let mut toy = JumpToy {
        toy: LinearToy::new(true),
        jump: |segment: &Segment, values: &SegmentValues| {
            let jumps = is_first(segment) && values.shared[0] > EDGE;
            jumps.then_some((0, JUMP))
        },
    };
    let fit = fit_from(&mut toy, &h, &segments, start, 10);
    let std = NOISE * (2.0_f64 / 360.0).sqrt();
    let error = fit.point.shared[0] - TRUE;
    assert!(error.abs() < 4.0 * std, "{error:e} m, {std:e} m");
}
