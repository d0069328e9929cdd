//! What of the start values of effects' states is left at the end of a segment.
//!
//! ```text
//! share_i = max_j |z_j,end(z + d_i) - z_j,end(z)| / s_j / (|d_i| / s_i)
//! ```
//!
//! with s the typical sizes of the states: what has gone from one state to another, as from a displacement to a velocity, is left too.

use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::model::point::Point;
use crate::metric::median;

/// How far a start value is moved, as a share of its typical size: linear, and far above what an integrator loses.
const MOVED: f64 = 0.01;

impl Fitter<'_, '_> {
    /// The share of the start value of each state of an effect that is left when the segment after begins, in the median of the segments that another one
    /// follows; NaN where no segment tells it.
    pub(crate) fn memory_left(&mut self, point: &Point) -> Vec<f64> {
        let (h, segments) = (self.hypothesis, self.data.segments);
        let modal = 2 * h.modes;
        let mut left: Vec<Vec<f64>> = vec![Vec::new(); h.extra_states.len()];
        let followed = (1..segments.len()).filter(|&k| segments[k].follows(&segments[k - 1]));
        for k in followed {
            let Some(reached) = self.carried_on(k, point) else {
                continue;
            };
            for (i, (_, typical)) in h.extra_states.iter().enumerate() {
                let mut moved = point.clone();
                moved.states[k - 1][modal + i] += MOVED * typical;
                if let Some(other) = self.carried_on(k, &moved) {
                    let both = other.state[modal..].iter().zip(&reached.state[modal..]);
                    let all = both.zip(&h.extra_states);
                    let shares = all.map(|((a, b), (_, typical))| ((a - b) / typical).abs());
                    left[i].push(shares.fold(0.0, f64::max) / MOVED);
                }
            }
        }
        let median_of = |left: &mut Vec<f64>| match left.is_empty() {
            true => f64::NAN,
            false => median(left),
        };
        left.iter_mut().map(median_of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::data::segment::Segment;
    use crate::diagnose::estimation::fit_options::FitOptions;
    use crate::diagnose::estimation::linear_toy::{LinearToy, NOISE, hypothesis, segments_of};
    use crate::diagnose::model::hypothesis::Hypothesis;
    use crate::diagnose::model::observations::Observations;
    use crate::diagnose::model::simulator::{
        Samples, SegmentStart, SegmentValues, Simulator, Turn,
    };
    use crate::diagnose::model::work::Work;
    use crate::error::Error;

    /// Rates in 1/s at which two memories of the linear toy fade: one within a segment of 60 ms, one not.
    const RATES: [f64; 2] = [50.0, 0.5];

    /// The linear toy with memories that no sensor sees.
    struct FadingToy {
        toy: LinearToy,
        /// Beginning of the segment predicted last, in s, and its memories there.
        last: (f64, Vec<f64>),
    }

    impl Simulator for FadingToy {
        fn predict(
            &mut self,
            segment: &Segment,
            values: SegmentValues,
            samples: Samples,
            out: &mut Vec<f64>,
        ) -> Result<bool, Error> {
            let (state, memories) = values.state.split_at(2);
            self.last = (segment.time[0], memories.to_vec());
            let own = SegmentValues { state, ..values };
            self.toy.predict(segment, own, samples, out)
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

        fn carry_on(
            &mut self,
            next: &Segment,
            shared: &[f64],
            own: &[f64],
        ) -> Result<SegmentStart, Error> {
            let mut start = self.toy.carry_on(next, shared, own)?;
            let (from, memories) = &self.last;
            let both = memories.iter().zip(RATES);
            let faded = both.map(|(z, rate)| z * (-rate * (next.time[0] - from)).exp());
            start.state.extend(faded);
            Ok(start)
        }

        fn limit(&self, run: usize) -> f64 {
            self.toy.limit(run)
        }
    }

    #[test]
    fn val_what_is_left_of_a_memory_is_its_exponential() {
        // Source: exp(-rate T), T from the start of one segment to that of the next.
        let segments = segments_of(|_, _| 0.0);
        let h = Hypothesis {
            extra_states: vec![(0, 1.0), (1, 2.0)],
            ..hypothesis(1)
        };
        let work = Work::default();
        let data = Observations {
            segments: &segments,
            noise: &[NOISE; 2],
            work: &work,
        };
        let mut toy = FadingToy {
            toy: LinearToy::new(false),
            last: (0.0, Vec::new()),
        };
        let mut fitter = Fitter::new(&mut toy, &h, &data, FitOptions::search(1));
        let left = fitter.memory_left(&Point::centre(&h, &segments));
        let step = segments[1].time[0] - segments[0].time[0];
        for (left, rate) in left.iter().zip(RATES) {
            let expected = (-rate * step).exp();
            assert!((left - expected).abs() < 1e-12, "{left} {expected}");
        }
        // Segments that nothing follows tell nothing.
        let apart = [segments[0].clone(), segments[3].clone()];
        let data = Observations {
            segments: &apart,
            ..data
        };
        let mut fitter = Fitter::new(&mut toy, &h, &data, FitOptions::search(1));
        let left = fitter.memory_left(&Point::centre(&h, &apart));
        assert!(left.iter().all(|l| l.is_nan()), "{left:?}");
    }
}
