//! What shape a curve has, in words: flat, rising, falling, even, odd, with a threshold, saturating.

use crate::metric::half_width;
use nalgebra::{DMatrix, DVector};

/// Nodes of which the value, counted from the mean of the others, is uncertain by more than this share of the curve's span don't count.
const UNCERTAIN: f64 = 0.5;
/// Standard deviations by which two values must differ to be different.
const DIFFERENT: f64 = 2.0;
/// Slope over the steepest below which a stretch is called flat.
const FLAT: f64 = 0.1;
/// Share of the curve's range that a flat stretch must cover to be named: more than one interval of seven.
const STRETCH: f64 = 0.25;
/// Share of a curve's variation that its even or odd part must hold for the curve to be called so.
const SYMMETRIC: f64 = 0.9;
/// Share of the range that must lie on the shorter side of zero for a symmetry to be looked for.
const SIDE: f64 = 0.25;

/// How the words for a curve without a certain change begin.
const NO_CHANGE: &str = "is flat within its uncertainty";

/// Whether words of [`Nodes::shape`] say that nothing of a curve is certain to change.
pub fn is_flat(shape: &str) -> bool {
    shape.starts_with(NO_CHANGE)
}

/// A curve through nodes of which the errors go together.
#[derive(Clone, Copy)]
pub struct Nodes<'a> {
    /// Argument at each node.
    pub at: &'a [f64],
    /// Value at each node.
    pub values: &'a DVector<f64>,
    /// Covariance of the values. What a constant of the model takes up, as the level of a curve, is in it as what all are off by.
    pub covariance: &'a DMatrix<f64>,
}

impl Nodes<'_> {
    /// A weighted sum of the values, with its standard deviation.
    fn sum(&self, weights: &DVector<f64>) -> (f64, f64) {
        let variance = weights.dot(&(self.covariance * weights));
        (weights.dot(self.values), variance.max(0.0).sqrt())
    }

    /// The mean over the nodes that are chosen, as weights; zero where none is.
    fn mean(&self, chosen: &dyn Fn(usize) -> bool) -> DVector<f64> {
        let count = (0..self.at.len()).filter(|i| chosen(*i)).count();
        let weight = |i: usize| f64::from(u8::from(chosen(i))) / count.max(1) as f64;
        DVector::from_fn(self.at.len(), |i, _| weight(i))
    }

    /// How far value `j` lies above value `i`, with its standard deviation.
    fn rise(&self, i: usize, j: usize) -> (f64, f64) {
        let one = |k: usize| self.mean(&|other| other == k);
        self.sum(&(one(j) - one(i)))
    }

    /// How far the values at positive arguments lie above those at negative ones on average, with the standard deviation;
    /// `None` where zero is not passed, or the difference is less than certain.
    pub fn difference_of_sides(&self) -> Option<(f64, f64)> {
        let (above, below) = (|i: usize| self.at[i] > 0.0, |i: usize| self.at[i] < 0.0);
        let has = |chosen: &dyn Fn(usize) -> bool| (0..self.at.len()).any(chosen);
        let (difference, std) = self.sum(&(self.mean(&above) - self.mean(&below)));
        let is_certain = has(&above) && has(&below) && difference.abs() > DIFFERENT * std;
        is_certain.then_some((difference, std))
    }

    /// The shape, with the unit of the values, as the end of a sentence that begins with "the curve".
    pub fn shape(&self, unit: &str) -> String {
        let value = |v: f64| with_unit(v, unit);
        if !self.changes(&(0..self.at.len()).collect::<Vec<_>>()) {
            let (mean, std) = self.sum(&self.mean(&|_| true));
            return format!(
                "{NO_CHANGE}: {} +- {} (95 %)",
                value(mean),
                value(half_width(std))
            );
        }
        let span = self.values.max() - self.values.min();
        let one = |i: usize| self.mean(&|other| other == i);
        let others = |i: usize| self.mean(&|other| other != i);
        let own = |i: usize| self.sum(&(one(i) - others(i))).1;
        let known: Vec<usize> = (0..self.at.len())
            .filter(|&i| own(i) < UNCERTAIN * span)
            .collect();
        if known.len() < 3 || !self.changes(&known) {
            return "is not determined well enough to name a shape".to_owned();
        }
        let points: Vec<[f64; 2]> = known
            .iter()
            .map(|&i| [self.at[i], self.values[i]])
            .collect();
        let course = match self.direction(&known) {
            Some(sign) => {
                let verb = if sign > 0.0 { "rises" } else { "falls" };
                let (from, to) = (points[0][1], points[points.len() - 1][1]);
                format!(
                    "{verb} from {} to {}{}",
                    value(from),
                    value(to),
                    bend(&points)
                )
            }
            None => {
                let by = |a: &&[f64; 2], b: &&[f64; 2]| a[1].total_cmp(&b[1]);
                let least = points.iter().min_by(by).expect("three nodes");
                let most = points.iter().max_by(by).expect("three nodes");
                format!(
                    "has its least value {} at {:.2e} and its largest {} at {:.2e}{}",
                    value(least[1]),
                    least[0],
                    value(most[1]),
                    most[0],
                    flat_part(&points).map_or(String::new(), |(a, b)| format!(
                        ", and is flat from {a:.2e} to {b:.2e}"
                    ))
                )
            }
        };
        match symmetry(&points) {
            Some(word) => format!("is {word} about zero: it {course}"),
            None => course,
        }
    }

    /// Whether any two of these values are different.
    fn changes(&self, of: &[usize]) -> bool {
        let differ = |(i, j): (usize, usize)| {
            let (rise, std) = self.rise(i, j);
            rise.abs() > DIFFERENT * std
        };
        let pairs = of.iter().enumerate();
        pairs
            .flat_map(|(k, &i)| of[k + 1..].iter().map(move |&j| (i, j)))
            .any(differ)
    }

    /// 1 where no value is lower than an earlier one for certain, -1 where none is higher, else `None`.
    fn direction(&self, known: &[usize]) -> Option<f64> {
        let goes = |sign: f64| {
            known.iter().enumerate().all(|(k, &i)| {
                let mut later = known[k + 1..].iter().map(|&j| self.rise(i, j));
                later.all(|(rise, std)| sign * rise > -DIFFERENT * std)
            })
        };
        [1.0, -1.0].into_iter().find(|sign| goes(*sign))
    }
}

fn with_unit(value: f64, unit: &str) -> String {
    // Zero has no sign.
    let value = value + 0.0;
    match unit {
        "1" | "" => format!("{value:.2e}"),
        unit => format!("{value:.2e} {unit}"),
    }
}

/// Slopes between neighbours.
fn slopes(known: &[[f64; 2]]) -> Vec<f64> {
    let slope = |p: &[[f64; 2]]| (p[1][1] - p[0][1]) / (p[1][0] - p[0][0]);
    known.windows(2).map(slope).collect()
}

/// Where the longest flat stretch begins and ends, if it covers enough.
fn flat_part(known: &[[f64; 2]]) -> Option<(f64, f64)> {
    let slopes = slopes(known);
    let steepest = slopes.iter().fold(0.0f64, |m, s| m.max(s.abs()));
    let range = known[known.len() - 1][0] - known[0][0];
    let (mut best, mut first) = (None, 0);
    for part in slopes.chunk_by(|a, b| (a.abs() < FLAT * steepest) == (b.abs() < FLAT * steepest)) {
        let past = first + part.len();
        let (from, to) = (known[first][0], known[past][0]);
        let longest = best.map_or(STRETCH * range, |(a, b): (f64, f64)| b - a);
        if part[0].abs() < FLAT * steepest && to - from > longest {
            best = Some((from, to));
        }
        first = past;
    }
    best
}

/// How a curve that only rises or only falls bends.
fn bend(known: &[[f64; 2]]) -> String {
    let (begin, end) = (known[0][0], known[known.len() - 1][0]);
    let slopes = slopes(known);
    let (first, last) = (slopes[0].abs(), slopes[slopes.len() - 1].abs());
    match flat_part(known) {
        Some((a, b)) if a <= begin && b < end => format!(", beyond a threshold at {b:.2e}"),
        Some((a, b)) if b >= end => format!(", and saturates beyond {a:.2e}"),
        Some((a, b)) => format!(", with a dead zone from {a:.2e} to {b:.2e}"),
        None if first < 0.25 * last => ", slowly at first".to_owned(),
        None if last < 0.25 * first => ", ever more slowly".to_owned(),
        None => String::new(),
    }
}

/// Whether the curve is even or odd about zero, up to its value there, where it covers both sides.
fn symmetry(known: &[[f64; 2]]) -> Option<&'static str> {
    let (low, high) = (known[0][0], known[known.len() - 1][0]);
    let reach = (-low).min(high);
    if reach < SIDE * (high - low) {
        return None;
    }
    let at = |x: f64| {
        let i = known
            .partition_point(|c| c[0] < x)
            .clamp(1, known.len() - 1);
        let (a, b) = (known[i - 1], known[i]);
        a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])
    };
    const POINTS: usize = 16;
    let (mut even, mut odd) = (0.0, 0.0);
    // Between nodes the value at zero is that of a straight line, so that only what lies beyond the nodes about zero is compared.
    let zero = at(0.0);
    for i in 1..=POINTS {
        let x = reach * i as f64 / POINTS as f64;
        even += (0.5 * (at(x) + at(-x)) - zero).powi(2);
        odd += (0.5 * (at(x) - at(-x))).powi(2);
    }
    match even / (even + odd) {
        share if share > SYMMETRIC => Some("even"),
        share if share < 1.0 - SYMMETRIC => Some("odd"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shape of a curve given as argument, value and standard deviation, independent but for what all are off by together.
    fn shape(curve: &[[f64; 3]], common: f64, unit: &str) -> String {
        with_nodes(curve, common, |nodes| nodes.shape(unit))
    }

    fn with_nodes<T>(curve: &[[f64; 3]], common: f64, then: impl Fn(Nodes) -> T) -> T {
        let at: Vec<f64> = curve.iter().map(|c| c[0]).collect();
        let n = curve.len();
        let values = DVector::from_fn(n, |i, _| curve[i][1]);
        let own = DMatrix::from_diagonal(&DVector::from_fn(n, |i, _| curve[i][2].powi(2)));
        let covariance = own.add_scalar(common * common);
        then(Nodes {
            at: &at,
            values: &values,
            covariance: &covariance,
        })
    }

    fn of(f: &dyn Fn(f64) -> f64, from: f64, to: f64, std: f64) -> String {
        let node = |i: i32| {
            let x = from + (to - from) * f64::from(i) / 7.0;
            [x, f(x), std]
        };
        shape(&(0..8).map(node).collect::<Vec<_>>(), 0.0, "1")
    }

    #[test]
    fn what_is_certain_of_a_difference_is_told_though_each_value_is_not() {
        // A level and an even part that nobody knows, on an odd part that is known.
        let at = [-2.0, -1.0, 1.0, 2.0];
        let values = DVector::from_row_slice(&[-0.2, -0.25, -0.45, -0.5]);
        let even = DVector::from_row_slice(&[0.3, 0.1, 0.1, 0.3]);
        let covariance =
            (&even * even.transpose()).add_scalar(0.09) + DMatrix::identity(4, 4) * 1e-4;
        let nodes = Nodes {
            at: &at,
            values: &values,
            covariance: &covariance,
        };
        assert!(!is_flat(&nodes.shape("1")), "{}", nodes.shape("1"));
        let (difference, std) = nodes.difference_of_sides().unwrap();
        approx::assert_abs_diff_eq!(difference, -0.25, epsilon = 1e-12);
        // Two means of two values each, with errors of 0.01.
        approx::assert_abs_diff_eq!(std, 0.01, epsilon = 1e-9);
        let one_side = with_nodes(&[[1.0, 0.0, 0.1], [2.0, 9.0, 0.1]], 0.0, |nodes| {
            nodes.difference_of_sides()
        });
        assert!(one_side.is_none());
        let alike = with_nodes(&[[-1.0, 0.0, 0.1], [1.0, 0.1, 0.1]], 0.0, |nodes| {
            nodes.difference_of_sides()
        });
        assert!(alike.is_none());
    }

    #[test]
    fn shapes_are_named_by_what_is_certain() {
        let right = |f: &dyn Fn(f64) -> f64, std| of(f, 0.0, 7.0, std);
        assert_eq!(right(&|x| x, 0.01), "rises from 0.00e0 to 7.00e0");
        assert!(right(&|x| -x * x, 0.01).contains("falls from 0.00e0 to -4.90e1, slowly at first"));
        assert!(right(&|x| (x - 3.0).powi(2), 0.01).contains("least value 0.00e0 at 3.00e0"));
        assert_eq!(
            right(&|x| 0.01 * x, 0.1),
            "is flat within its uncertainty: 3.50e-2 +- 6.93e-2 (95 %)"
        );
        // What all are off by together says nothing of the shape.
        let level = [[0.0, 0.2, 0.1], [1.0, 0.1, 0.1], [2.0, 0.3, 0.1]];
        assert_eq!(
            shape(&level, 1.0, "m"),
            "is flat within its uncertainty: 2.00e-1 m +- 1.96e0 m (95 %)"
        );
        // Each step is less than its uncertainty, the whole is not.
        assert!(right(&|x| x, 0.9).starts_with("rises from"));
        // One value stands out of an uncertainty as large as the rest.
        let lone = [
            [0.0, 0.0, 4.0],
            [1.0, 1.0, 4.0],
            [2.0, 7.0, 1.0],
            [3.0, 0.0, 1.0],
        ];
        assert!(shape(&lone, 0.0, "1").contains("not determined"));
        assert!(shape(&lone[..0], 0.0, "1").contains("flat"));
    }

    #[test]
    fn thresholds_saturation_and_dead_zones_are_told() {
        let right = |f: &dyn Fn(f64) -> f64| of(f, 0.0, 7.0, 1e-3);
        assert!(right(&|x| 1.0 - (-x).exp()).ends_with(", and saturates beyond 3.00e0"));
        assert!(right(&|x| (x - 3.0).max(0.0)).ends_with(", beyond a threshold at 3.00e0"));
        assert!(right(&|x| -(x - 4.0).max(0.0)).starts_with("falls"));
        let stops = |x: f64| (x - 3.0).max(0.0) + (x + 3.0).min(0.0);
        let told = of(&stops, -7.0, 7.0, 1e-3);
        assert!(told.starts_with("is odd about zero: it rises"), "{told}");
        assert!(told.contains("with a dead zone from -"), "{told}");
        assert!(right(&|x| x.sqrt()).ends_with(", ever more slowly"));
    }

    #[test]
    fn curves_over_both_sides_of_zero_are_even_or_odd() {
        let both = |f: &dyn Fn(f64) -> f64| of(f, -7.0, 7.0, 1e-3);
        let told = both(&|x| x * x);
        assert!(
            told.starts_with("is even about zero: it has its least"),
            "{told}"
        );
        assert!(both(&|x| 1.0 + x.powi(3)).starts_with("is odd about zero: it rises"));
        assert!(
            both(&|x| x + 0.15 * x * x).starts_with("rises")
                || both(&|x| x + 0.15 * x * x).starts_with("has")
        );
        // One side only: nothing is said of the other.
        assert!(!of(&|x| x * x, -1.0, 7.0, 1e-3).contains("even"));
    }
}
