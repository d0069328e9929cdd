//! Nodes and weights of Gauss and Legendre on [0, 1], and the polynomials through them.

use super::{NODES, Nodes};
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Nodes of Gauss-Legendre with `n` points on [0, 1], rising, and their weights.
///
/// Newton's method on the Legendre polynomial (Press et al. 2007, sect. 4.6).
pub(super) fn rule(n: usize) -> Vec<(f64, f64)> {
    let mut found = Vec::with_capacity(n);
    for i in (0..n).rev() {
        let mut z = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..20 {
            let (p, before) = legendre(n, z);
            slope = n as f64 * (z * p - before) / (z * z - 1.0);
            z -= p / slope;
        }
        found.push((0.5 + 0.5 * z, 1.0 / ((1.0 - z * z) * slope * slope)));
    }
    found
}

/// Legendre polynomials of degree `n` and `n - 1` at `z` in [-1, 1].
fn legendre(n: usize, z: f64) -> (f64, f64) {
    let (mut p, mut before) = (1.0, 0.0);
    for k in 0..n {
        let k = k as f64;
        (p, before) = (((2.0 * k + 1.0) * z * p - k * before) / (k + 1.0), p);
    }
    (p, before)
}

/// The nodes of a step.
pub(super) struct Gauss {
    pub(super) nodes: Nodes,
    /// The two last Legendre coefficients of the polynomial through values at the nodes, per value.
    pub(super) tail: [Nodes; 2],
    /// 1 / product of (x_j - x_m) over the other nodes.
    barycentric: Nodes,
}

/// The nodes, worked out once.
pub(super) fn gauss() -> &'static Gauss {
    static GAUSS: OnceLock<Gauss> = OnceLock::new();
    GAUSS.get_or_init(|| {
        let rule = rule(NODES);
        let nodes: Nodes = std::array::from_fn(|i| rule[i].0);
        let tail = [NODES - 2, NODES - 1].map(|k| {
            std::array::from_fn(|i| {
                let (x, weight) = rule[i];
                (2 * k + 1) as f64 * weight * legendre(k, 2.0 * x - 1.0).0
            })
        });
        let barycentric = std::array::from_fn(|j| {
            let others = (0..NODES).filter(|m| *m != j);
            1.0 / others.map(|m| nodes[j] - nodes[m]).product::<f64>()
        });
        Gauss {
            nodes,
            tail,
            barycentric,
        }
    })
}

impl Gauss {
    /// All Lagrange polynomials of the nodes at `t`, by products from both sides.
    pub(super) fn lagrange(&self, t: f64) -> Nodes {
        let mut out = self.barycentric;
        let mut product = 1.0;
        for j in 0..NODES {
            out[j] *= product;
            product *= t - self.nodes[j];
        }
        product = 1.0;
        for j in (0..NODES).rev() {
            out[j] *= product;
            product *= t - self.nodes[j];
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn val_the_rule_integrates_powers_exactly() {
        // Source: the integral of x^k over [0, 1] is 1 / (k + 1), up to k = 2 n - 1.
        for n in [5, NODES, 32] {
            let rule = rule(n);
            for k in 0..2 * n {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(k as i32)).sum();
                assert_relative_eq!(sum, 1.0 / (k + 1) as f64, max_relative = 1e-13);
            }
        }
    }

    #[test]
    fn val_lagrange_polynomials_reproduce_a_polynomial_and_its_tail() {
        // Source: the polynomial itself, 2 P_15 - 3 P_14 + P_2 of Legendre.
        let f = |t: f64| {
            let z = 2.0 * t - 1.0;
            let (last, before) = legendre(15, z);
            2.0 * last - 3.0 * before + legendre(2, z).0
        };
        let g = gauss();
        for t in [0.0, 0.123, 0.5, 0.99, 1.0] {
            let l = g.lagrange(t);
            let sum: f64 = (0..NODES).map(|j| f(g.nodes[j]) * l[j]).sum();
            assert_relative_eq!(sum, f(t), epsilon = 1e-11);
        }
        let tail = g
            .tail
            .map(|row| (0..NODES).map(|i| row[i] * f(g.nodes[i])).sum::<f64>());
        assert_relative_eq!(tail[0], -3.0, epsilon = 1e-12);
        assert_relative_eq!(tail[1], 2.0, epsilon = 1e-12);
    }
}
