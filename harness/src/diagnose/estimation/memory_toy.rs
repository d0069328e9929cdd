//! A model with a memory that does not fade: a state that each segment may start with anew, or that goes on from the segment before.
//!
//! ```text
//! w(t) = that of the linear toy without constants + z cos(WAVE t),   z' = 0
//! ```
//!
//! With a start value of its own in each segment the memory takes up a force that is another one in each.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::linear_toy::{LinearToy, NOISE, hypothesis, segments_of};
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::{Samples, SegmentStart, SegmentValues, Simulator, Turn};
use crate::diagnose::model::work::Work;
use crate::error::Error;

/// Angular frequency with which the memory shows, in rad/s.
const WAVE: f64 = 700.0;
/// Size of the memory, in m.
const SIZE: f64 = 20.0 * NOISE;
/// Samples of one segment.
const SAMPLES: f64 = 60.0;

struct MemoryToy {
    toy: LinearToy,
    /// What is remembered at the end of the segment predicted last.
    memory: f64,
}

impl Simulator for MemoryToy {
    fn predict(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        samples: Samples,
        out: &mut Vec<f64>,
    ) -> Result<bool, Error> {
        let (state, memory) = values.state.split_at(2);
        self.memory = memory[0];
        let own = SegmentValues { state, ..values };
        let is_whole = self.toy.predict(segment, own, samples, out)?;
        for (i, w) in out.iter_mut().enumerate() {
            *w += self.memory * (WAVE * segment.time[i * samples.stride]).cos();
        }
        Ok(is_whole)
    }

    fn differentiate(
        &mut self,
        _: &Segment,
        _: SegmentValues,
        _: &[Turn],
        _: Samples,
        _: &mut Vec<f64>,
    ) -> bool {
        false
    }

    fn carry_on(&mut self, next: &Segment, u: &[f64], own: &[f64]) -> Result<SegmentStart, Error> {
        let mut start = self.toy.carry_on(next, u, own)?;
        start.state.push(self.memory);
        Ok(start)
    }

    fn limit(&self, run: usize) -> f64 {
        self.toy.limit(run)
    }
}

/// What a fit finds remembered at the start of each segment, and the root-mean-square errors over the noise, of a record whose memory is
/// that of `sign` in each segment.
fn fitted(sign: impl Fn(&Segment) -> f64, goes_on: bool) -> (Vec<f64>, Vec<f64>) {
    let mut segments = segments_of(|_, _| 0.0);
    for segment in &mut segments {
        let memory = SIZE * sign(segment);
        for (w, t) in segment.measured.iter_mut().zip(&segment.time) {
            *w += memory * (WAVE * t).cos();
        }
        segment.goes_on = goes_on && segment.first > 0;
    }
    let h = Hypothesis {
        extra_states: vec![(0, SIZE)],
        ..hypothesis(1)
    };
    let work = Work::default();
    let data = Observations {
        segments: &segments,
        noise: &[NOISE; 2],
        work: &work,
    };
    let mut toy = MemoryToy {
        toy: LinearToy::new(false),
        memory: 0.0,
    };
    let options = FitOptions {
        stride: 1,
        robust: false,
        ..FitOptions::search(10)
    };
    let fit = Fitter::new(&mut toy, &h, &data, options).run(Point::centre(&h, &segments));
    let over_noise = fit.mean_square.iter().map(|m| m.sqrt() / NOISE);
    let memories = fit.point.states.iter().map(|x| x[2]);
    (memories.collect(), over_noise.collect())
}

/// Another memory in each segment, as none is.
fn in_turn(segment: &Segment) -> f64 {
    match (segment.first as f64 / SAMPLES) % 2.0 == 0.0 {
        true => 1.0,
        false => -1.0,
    }
}

#[test]
fn a_memory_that_goes_on_takes_up_no_force_that_is_another_in_each_segment() {
    let (_, free) = fitted(in_turn, false);
    let (_, tied) = fitted(in_turn, true);
    assert!(free.iter().all(|e| *e < 1.3), "{free:?}");
    assert!(tied.iter().any(|e| *e > 10.0), "{tied:?}");
}

#[test]
fn val_a_memory_that_goes_on_is_found_and_is_the_same_in_all_segments_of_a_run() {
    // Source: the memory that made the data; its standard deviation from one segment is NOISE sqrt(2 / samples).
    let (memories, errors) = fitted(|_| 1.0, true);
    let std = NOISE * (2.0 / SAMPLES).sqrt();
    for memory in &memories {
        let error = memory - SIZE;
        assert!(error.abs() < 4.0 * std, "{memories:?}");
    }
    assert!(errors.iter().all(|e| *e < 1.3), "{errors:?}");
    assert!(memories[..3].iter().all(|m| *m == memories[0]));
    assert!(memories[3..].iter().all(|m| *m == memories[3]));
    assert!(memories[0] != memories[3], "two runs, two memories");
}
