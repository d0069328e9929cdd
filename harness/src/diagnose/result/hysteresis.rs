//! The loop that a function with a memory runs through over what its argument is at that instant.

use crate::diagnose::explanation::argument::{Course, course};
use crate::diagnose::model::problem::Problem;
use crate::metric::median;
use serde::Serialize;

/// Points of the loop that are kept.
const POINTS: usize = 100;
/// Time constants after which the start is forgotten.
const FORGOTTEN: f64 = 3.0;

/// A hysteresis loop of the target over the instantaneous argument.
#[derive(Debug, Clone, Serialize)]
pub struct Loop {
    /// Median over the cycles of the area that the loop goes round, in `unit`; positive clockwise: the value is higher on the way up.
    pub area: f64,
    /// Unit of the area: that of the value times that of the argument.
    pub unit: String,
    /// The size of the area over that of the rectangle about the loop, median over the cycles: 0 is a single line.
    pub share: f64,
    /// Cycles that this comes from.
    pub cycles: usize,
    /// Instantaneous argument and value along the cycle of which the area is nearest to the median.
    pub points: Vec<[f64; 2]>,
}

/// The loop of a curve given as argument, value and standard deviation; `None` where no run has a whole cycle.
pub fn hysteresis(
    problem: &Problem,
    argument: &str,
    memory_s: f64,
    curve: &[[f64; 3]],
    units: (&str, &str),
) -> Option<Loop> {
    let mut cycles: Vec<Vec<[f64; 2]>> = Vec::new();
    for run in 0..problem.campaign.runs.len() {
        let course = course(problem, run, argument, Some(memory_s))?;
        let h = problem.smoothings[run].stick_slip.smoothed.sample_interval;
        let first = (FORGOTTEN * memory_s / h) as usize;
        cycles.extend(cycles_of(&course, first, &|x| value(curve, x)));
    }
    let areas: Vec<f64> = cycles.iter().map(|c| area(c)).collect();
    let middle = median(&mut areas.clone());
    let typical = (0..cycles.len()).min_by(|a, b| {
        (areas[*a] - middle)
            .abs()
            .total_cmp(&(areas[*b] - middle).abs())
    })?;
    let mut shares: Vec<f64> = cycles
        .iter()
        .map(|c| area(c).abs() / rectangle(c))
        .collect();
    let every = cycles[typical].len().div_ceil(POINTS).max(1);
    Some(Loop {
        area: middle,
        unit: product(units.0, units.1),
        share: median(&mut shares),
        cycles: cycles.len(),
        points: cycles[typical].iter().step_by(every).copied().collect(),
    })
}

impl Loop {
    /// In words, as a sentence; `value` and `argument` name the two quantities.
    pub fn words(&self, value: &str, argument: &str) -> String {
        let way = if self.area > 0.0 {
            "clockwise"
        } else {
            "anticlockwise"
        };
        let unit = match self.unit.as_str() {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        format!(
            "Over {argument} of the same instant {value} runs {way} through a hysteresis loop of area {:.2e}{unit} in each cycle, {:.0} % of the rectangle about it.",
            self.area.abs(),
            100.0 * self.share
        )
    }
}

/// The whole cycles of a course that begin at `first` or later: instantaneous argument and value.
fn cycles_of(course: &Course, first: usize, value: &dyn Fn(f64) -> f64) -> Vec<Vec<[f64; 2]>> {
    let point = |k: usize| [course.instantaneous[k], value(course.argument[k])];
    let pairs = course.cycles.windows(2).filter(|c| c[0] >= first);
    pairs
        .filter(|c| c[1] > c[0] + 2 && c[1] <= course.argument.len())
        .map(|c| (c[0]..c[1]).map(point).collect())
        .collect()
}

/// The curve at an argument, straight between its nodes and constant outside.
fn value(curve: &[[f64; 3]], x: f64) -> f64 {
    let (first, last) = (curve[0], curve[curve.len() - 1]);
    let x = x.clamp(first[0], last[0]);
    let i = curve
        .partition_point(|c| c[0] < x)
        .clamp(1, curve.len() - 1);
    let (a, b) = (curve[i - 1], curve[i]);
    a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])
}

/// Area that a closed curve goes round, positive clockwise.
fn area(points: &[[f64; 2]]) -> f64 {
    let next = points.iter().cycle().skip(1);
    let pairs = points.iter().zip(next);
    0.5 * pairs
        .map(|(a, b)| (b[0] - a[0]) * (a[1] + b[1]))
        .sum::<f64>()
}

fn rectangle(points: &[[f64; 2]]) -> f64 {
    let side = |k: usize| {
        let of = points.iter().map(|p| p[k]);
        let (low, high) = of.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        high - low
    };
    (side(0) * side(1)).max(f64::MIN_POSITIVE)
}

fn product(a: &str, b: &str) -> String {
    match (a, b) {
        ("1", b) => b.to_owned(),
        (a, "1") => a.to_owned(),
        (a, b) => format!("{a}.{b}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::explanation::argument::low_passed;
    use std::f64::consts::PI;

    /// A first-order low-pass of sin(2 pi f t) runs round an ellipse of area pi A sin(phase), with A = 1/sqrt(1 + (w tau)^2) and
    /// sin(phase) = w tau A, anticlockwise: it lags, so it is lower on the way up.
    #[test]
    fn val_the_loop_of_a_low_pass_has_the_area_of_its_ellipse() {
        let (h, f, tau) = (1e-5, 10.0, 0.02);
        let u: Vec<f64> = (0..100_000)
            .map(|k| (2.0 * PI * f * h * f64::from(k)).sin())
            .collect();
        let course = Course {
            argument: low_passed(&u, h, tau),
            instantaneous: u,
            cycles: (0..=10).map(|c| 10_000 * c).collect(),
        };
        let found = cycles_of(&course, 20_000, &|x| 3.0 * x);
        assert_eq!(found.len(), 8);
        let turn = 2.0 * PI * f * tau;
        let expected = -3.0 * PI * turn / (1.0 + turn * turn);
        for cycle in &found {
            assert!(
                (area(cycle) / expected - 1.0).abs() < 1e-3,
                "{}",
                area(cycle)
            );
            let share = area(cycle).abs() / rectangle(cycle);
            // pi/4 sin(phase)
            let sine = turn / (1.0 + turn * turn).sqrt();
            assert!((share - 0.25 * PI * sine).abs() < 1e-3, "{share}");
        }
    }

    #[test]
    fn a_function_without_a_lag_has_no_loop() {
        let u: Vec<f64> = (0..1000)
            .map(|k| (0.01 * PI * f64::from(k)).sin())
            .collect();
        let course = Course {
            argument: u.clone(),
            instantaneous: u,
            cycles: vec![0, 200, 400],
        };
        for cycle in cycles_of(&course, 0, &|x| x * x) {
            assert!(area(&cycle).abs() / rectangle(&cycle) < 1e-9);
        }
    }

    #[test]
    fn the_sentence_names_way_area_and_share() {
        let found = Loop {
            area: -0.012,
            unit: product("1", "m/s"),
            share: 0.31,
            cycles: 40,
            points: Vec::new(),
        };
        let words = found.words("the coefficient of friction", "the sliding speed");
        assert!(
            words.contains("anticlockwise") && words.contains("1.20e-2 m/s in each cycle, 31 %")
        );
        assert_eq!(
            (product("N", "m"), product("1", "1")),
            ("N.m".into(), "1".into())
        );
    }
}
