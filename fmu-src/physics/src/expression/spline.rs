//! Curves through the nodes of a table: natural cubic splines, continued by straight lines.
//!
//! Between two nodes `y = c_0 + c_1 d + c_2 d^2 + c_3 d^3` with the distance d from the left one. Value, slope and curvature are
//! continuous, the curvature is zero at both ends and beyond (de Boor 1978, A Practical Guide to Splines, ch. IV).

use crate::real::{Real, ZERO, value};

/// A spline, linear in the values at its nodes.
#[derive(Debug, Clone)]
pub struct Spline {
    /// Places of the nodes, rising.
    at: Vec<f64>,
    /// The polynomial left of all nodes, then that right of each.
    pieces: Vec<[Real; 4]>,
}

impl Spline {
    /// The spline with `values` at the places `at`, which rise; there are as many values, and two or more.
    pub fn new(at: &[f64], values: &[Real]) -> Self {
        let n = at.len();
        let width = |i: usize| at[i + 1] - at[i];
        let slope = |i: usize| (values[i + 1] - values[i]) / width(i);
        // Half the curvatures at the inner nodes solve a tridiagonal system (elimination without pivots: it is dominant).
        let mut half = vec![ZERO; n];
        let mut ratio = vec![0.0; n];
        for i in 1..n - 1 {
            let below = 2.0 * (width(i - 1) + width(i)) - width(i - 1) * ratio[i - 1];
            ratio[i] = width(i) / below;
            half[i] = (3.0 * (slope(i) - slope(i - 1)) - width(i - 1) * half[i - 1]) / below;
        }
        for i in (1..n - 1).rev() {
            let next = half[i + 1];
            half[i] -= ratio[i] * next;
        }
        let mut pieces = vec![[ZERO; 4]; n + 1];
        for i in 0..n - 1 {
            let h = width(i);
            pieces[i + 1] = [
                values[i],
                slope(i) - h * (2.0 * half[i] + half[i + 1]) / 3.0,
                half[i],
                (half[i + 1] - half[i]) / (3.0 * h),
            ];
        }
        let h = width(n - 2);
        let last = pieces[n - 1];
        pieces[0] = [values[0], pieces[1][1], ZERO, ZERO];
        let end = last[1] + h * (2.0 * last[2] + 3.0 * h * last[3]);
        pieces[n] = [values[n - 1], end, ZERO, ZERO];
        Self {
            at: at.to_vec(),
            pieces,
        }
    }

    /// Value at `x`.
    pub fn value(&self, x: Real) -> Real {
        let piece = self.piece(value(x));
        let d = x - self.origin(piece);
        let [c0, c1, c2, c3] = self.pieces[piece];
        c0 + d * (c1 + d * (c2 + d * c3))
    }

    /// The piece in which `x` lies.
    pub(super) fn piece(&self, x: f64) -> usize {
        self.at.partition_point(|a| *a <= x)
    }

    /// The place from which a piece counts.
    pub(super) fn origin(&self, piece: usize) -> f64 {
        self.at[piece.saturating_sub(1)]
    }

    /// Coefficients of a piece.
    pub(super) fn coefficients(&self, piece: usize) -> &[Real; 4] {
        &self.pieces[piece]
    }

    /// Ends of a piece; the outer ones have one.
    pub(super) fn ends(&self, piece: usize) -> [Option<f64>; 2] {
        let left = piece.checked_sub(1).map(|i| self.at[i]);
        [left, self.at.get(piece).copied()]
    }
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;

    #[test]
    fn val_the_spline_is_the_natural_one() {
        // Source: the natural spline through (0, 0), (1, 1), (3, 0) has half the curvature -3/4 in the middle, by hand.
        let s = Spline::new(&[0.0, 1.0, 3.0], &[0.0, 1.0, 0.0]);
        let left = |x: f64| 1.25 * x - 0.25 * x.powi(3);
        let right = |x: f64| 1.0 + 0.5 * x - 0.75 * x * x + 0.125 * x.powi(3);
        for x in [0.0, 0.3, 0.9] {
            assert!((s.value(x) - left(x)).abs() < 1e-14);
            assert!((s.value(1.0 + 2.0 * x) - right(2.0 * x)).abs() < 1e-14);
        }
        assert!((s.value(-2.0) + 2.5).abs() < 1e-14);
        assert!((s.value(5.0) + 2.0).abs() < 1e-14);
    }

    #[test]
    fn two_nodes_make_a_line() {
        let s = Spline::new(&[-1.0, 3.0], &[2.0, 10.0]);
        for x in [-4.0, 0.0, 7.5] {
            assert!((s.value(x) - (4.0 + 2.0 * x)).abs() < 1e-13);
        }
    }
}
