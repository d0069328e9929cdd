//! The form of the curve between its nodes.

/// Piecewise cubic (Catmull and Rom 1974) over `u = sqrt(v)` with evenly spaced nodes, even in `u`.
#[derive(Clone, Copy)]
pub(super) struct Basis {
    pub(super) step: f64,
    pub(super) nodes: usize,
}

impl Basis {
    pub(super) fn new(fastest: f64, nodes: usize) -> Self {
        Self {
            step: fastest.sqrt() / (nodes - 1) as f64,
            nodes,
        }
    }

    pub(super) fn weights(&self, v: f64) -> [(usize, f64); 4] {
        let u = (v.max(0.0).sqrt() / self.step).min(self.nodes as f64 - 1.0 - 1e-9);
        let first = u.floor();
        let t = u - first;
        let weights = [
            0.5 * (-t + 2.0 * t * t - t.powi(3)),
            0.5 * (2.0 - 5.0 * t * t + 3.0 * t.powi(3)),
            0.5 * (t + 4.0 * t * t - 3.0 * t.powi(3)),
            0.5 * (-t * t + t.powi(3)),
        ];
        std::array::from_fn(|i| {
            let node = (first as usize + i).abs_diff(1).min(self.nodes - 1);
            (node, weights[i])
        })
    }

    pub(super) fn value(&self, mu: &[f64], v: f64) -> f64 {
        self.weights(v).iter().map(|(i, w)| w * mu[*i]).sum()
    }
}
