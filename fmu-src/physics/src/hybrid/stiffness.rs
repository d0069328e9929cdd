//! How long steps an integrator from outside may take: the eigenvalues of the equations at rest, in stick and in
//! slip.

use super::Hybrid;
use crate::contact::ContactMode;
use crate::integrate::MAX_STATES;
use nalgebra::DMatrix;

/// Eigenvalues below this share of the fastest are those of states that nothing acts on, up to rounding.
const ROUNDING: f64 = 1e-6;

/// What a step of an explicit integrator has to be measured by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiffness {
    /// The largest eigenvalue by magnitude, in 1/s.
    pub fastest: f64,
    /// Largest step in s with which the explicit Euler method keeps every decaying motion bounded:
    /// the least `-2 Re(l)/|l|^2` over the eigenvalues `l` with `Re(l) < 0` (Hairer and Wanner, Solving Ordinary
    /// Differential Equations II, section IV.2). Infinite where nothing decays.
    pub euler_limit: f64,
}

impl Hybrid {
    /// The stiffness of the equations at rest under the present inputs, over the modes that the contact can have.
    /// `None` where the equations can't be evaluated there.
    pub fn stiffness(&self) -> Option<Stiffness> {
        let scales = self.model.state_scales();
        let count = self.model.dimension();
        let slip = ContactMode::slip_towards(-self.model.inputs.belt_velocity);
        let sticks = !self.model.has_memory();
        let modes = [slip, ContactMode::Stuck];
        let mut eigenvalues = Vec::new();
        for mode in &modes[..1 + usize::from(sticks)] {
            let mut at_rest = self.clone();
            at_rest.mode = *mode;
            at_rest.state = [0.0; MAX_STATES];
            let columns = (0..count).map(|i| at_rest.column(i, scales[i]));
            let columns: Vec<f64> = columns.collect::<Option<Vec<_>>>()?.concat();
            let jacobian = DMatrix::from_vec(count, count, columns);
            let schur = jacobian.try_schur(f64::EPSILON, 10_000)?;
            eigenvalues.extend(schur.complex_eigenvalues().iter().copied());
        }
        let fastest = eigenvalues.iter().map(|l| l.norm()).fold(0.0, f64::max);
        let limits = eigenvalues
            .iter()
            .filter(|l| l.norm() > ROUNDING * fastest && l.re < 0.0)
            .map(|l| -2.0 * l.re / l.norm_sqr());
        Some(Stiffness {
            fastest,
            euler_limit: limits.fold(f64::INFINITY, f64::min),
        })
    }

    /// Derivatives of all rates by state `i` at rest, by a central difference of width `h`.
    fn column(&self, i: usize, h: f64) -> Option<Vec<f64>> {
        let rates = |x: f64| {
            let mut there = self.clone();
            there.set_state(i, x);
            there.rates().ok()
        };
        let (ahead, behind) = (rates(h)?, rates(-h)?);
        let one = |k: usize| (ahead.state[k] - behind.state[k]) / (2.0 * h);
        Some((0..self.model.dimension()).map(one).collect())
    }
}
