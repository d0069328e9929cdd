//! A model whose constants trade along a narrow bent valley, on which the way of a fit has a known end.
//!
//! ```text
//! w(t) = x_1 + x_2 t + b + (theta_0 + theta_1 + BEND theta_1^2) cos(a t) + WEAK theta_1 cos(2 a t)
//! ```
//!
//! Both constants show strongly, but apart from each other a hundred times less; on the way the bend is ten times the noise.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::Fit;
use crate::diagnose::estimation::linear_toy::{NOISE, fit_from, hypothesis, segments_of};
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::{Samples, SegmentStart, SegmentValues, Simulator, Turn};
use crate::error::Error;

const WEAK: f64 = 0.01;
const BEND: f64 = 4e3;
/// The constants that act, in m.
const TRUE: [f64; 2] = [1e-4, 5e-5];

struct BentToy;

fn waves(t: f64) -> [f64; 2] {
    [(40.0 * t).cos(), (80.0 * t).cos()]
}

fn motion(theta: &[f64], t: f64) -> f64 {
    let [first, second] = waves(t);
    let together = theta[0] + theta[1] + BEND * theta[1] * theta[1];
    together * first + WEAK * theta[1] * second
}

impl Simulator for BentToy {
    fn predict(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        samples: Samples,
        out: &mut Vec<f64>,
    ) -> Result<bool, Error> {
        let times = (0..samples.count).map(|i| segment.time[i * samples.stride]);
        let start = |t: f64| values.state[0] + values.state[1] * (t - segment.time[0]);
        out.clear();
        let offset = values.per_run[0];
        out.extend(times.map(|t| start(t) + offset + motion(values.shared, t)));
        Ok(true)
    }

    fn differentiate(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        turns: &[Turn],
        samples: Samples,
        slopes: &mut Vec<f64>,
    ) -> bool {
        slopes.clear();
        for turn in turns {
            let times = (0..samples.count).map(|i| segment.time[i * samples.stride]);
            slopes.extend(times.map(|t| {
                let [first, second] = waves(t);
                match turn {
                    Turn::State(0) => 1.0,
                    Turn::State(_) => t - segment.time[0],
                    Turn::Shared(0) => first,
                    Turn::Shared(_) => {
                        (1.0 + 2.0 * BEND * values.shared[1]) * first + WEAK * second
                    }
                    Turn::PerRun(_) => 1.0,
                }
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

/// A fit with so many Jacobians, from where the second constant does nothing and the first one fits as well as it can.
fn fit(jacobians: usize) -> Fit {
    let segments = segments_of(|_, t| motion(&TRUE, t));
    let mut h = hypothesis(2);
    h.shared.iter_mut().for_each(|p| p.prior_std = 1e-3);
    let mut start = Point::centre(&h, &segments);
    start.shared = vec![TRUE[0] + TRUE[1] + BEND * TRUE[1] * TRUE[1], 0.0];
    fit_from(&mut BentToy, &h, &segments, start, jacobians)
}

#[test]
fn val_a_bent_valley_is_passed_in_a_few_jacobians() {
    // Source: the constants that made the data; the standard deviation of the weak one is NOISE sqrt(2 / samples) / WEAK.
    let (few, many) = (fit(5), fit(60));
    assert!(
        few.misfit - many.misfit < 0.01,
        "{} {} nats",
        few.misfit,
        many.misfit
    );
    let std = NOISE * (2.0_f64 / 360.0).sqrt() / WEAK;
    let error = few.point.shared[1] - TRUE[1];
    assert!(error.abs() < 4.0 * std, "{error:e} m, {std:e} m");
    assert!(many.expected_fall < 1e-6, "{} nats", many.expected_fall);
}
