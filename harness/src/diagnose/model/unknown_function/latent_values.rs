//! The values at the nodes of a curve, as latent values that are independent before the data.
//!
//! See [`super`] for the equation.

use crate::diagnose::model::parameter::{Kind, Parameter, Scale};
use crate::fmu::effect_card::EffectCard;
use serde::Serialize;

/// Nodes of a curve.
pub const NODES: usize = 8;
/// How the names of the values at the nodes begin.
const NODE: &str = "g_";
/// Largest latent value, in standard deviations before the data.
pub(super) const MOST: f64 = 20.0;

/// Whether a parameter of an unknown function is a value at a node.
pub(crate) fn is_node(name: &str) -> bool {
    name.starts_with(NODE)
}

/// How smooth a curve is believed to be: latent value `k` has the standard deviation `a max(k, 1)^(2 - p)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Smoothness {
    /// a, in units of the typical strength.
    pub strength: f64,
    /// p, by which cosine coefficients fall with their number: 1 for a curve that is continuous, 2 for one with a slope, 3 for a
    /// smoother one.
    pub decay: f64,
    /// Whether the evidence told both.
    pub is_told: bool,
}

impl Smoothness {
    /// What is believed where nothing told it.
    pub const UNTOLD: Self = Self {
        strength: 1.0,
        decay: 2.0,
        is_told: false,
    };

    /// Standard deviation of latent value `k` before the data.
    pub fn std(&self, k: usize) -> f64 {
        self.strength * (k.max(1) as f64).powf(2.0 - self.decay)
    }
}

/// Weight of the latent value `k` at node `i`, in units of the strength.
pub fn weight(k: usize, i: usize) -> f64 {
    let smooth = if k == 0 { 1.0 } else { (k as f64).powi(-2) };
    smooth * (std::f64::consts::PI * (k * i) as f64 / (NODES - 1) as f64).cos()
}

/// Name of the latent value `k` of an unknown function.
pub fn latent_name(id: &str, k: usize) -> String {
    format!("{id}.z_{}", k + 1)
}

/// The latent values of an unknown function that is believed so smooth, which set those at its nodes.
pub(crate) fn latent(card: &EffectCard, smoothness: Smoothness) -> Vec<Parameter> {
    let nodes: Vec<_> = card
        .parameters
        .iter()
        .filter(|p| is_node(&p.name))
        .collect();
    let of = |k: usize| Parameter {
        name: latent_name(&card.id, k),
        unit: "1".into(),
        kind: Kind::Latent,
        targets: nodes
            .iter()
            .enumerate()
            .map(|(i, p)| (p.reference, p.typical * weight(k, i)))
            .collect(),
        scale: Scale::Linear,
        prior: 0.0,
        prior_std: smoothness.std(k),
        min: -MOST * smoothness.std(k),
        max: MOST * smoothness.std(k),
        step: 1e-3,
        support: None,
    };
    (0..nodes.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latent_values_make_any_curve_and_rough_ones_are_less_believed() {
        // The cosines are independent: the curve through given nodes has one set of them.
        let matrix = nalgebra::DMatrix::from_fn(NODES, NODES, |i, k| weight(k, i));
        assert!(matrix.clone().lu().determinant().abs() > 1e-9);
        let straight = nalgebra::DVector::<f64>::from_fn(NODES, |i, _| i as f64);
        let zigzag = nalgebra::DVector::<f64>::from_fn(NODES, |i, _| (i % 2) as f64);
        let cost = |curve: nalgebra::DVector<f64>| {
            matrix.clone().lu().solve(&curve).unwrap().norm_squared()
        };
        assert!(cost(zigzag) > 5.0 * cost(straight));
    }
}
