//! Energy balance: belt work + external work = stored + dissipated in the contact + dissipated in the structure.

use crate::contact::ContactMode;
use crate::integrate::{MAX_STATES, Segment};
use crate::model::Model;
use crate::real::{Real, ZERO};

/// Energies in J.
///
/// `belt_work + external_work = change of stored + contact_dissipation + structural_dissipation`, from
/// `F v_belt = F w' - F v_r`. Effects that do work of their own (base excitation, drag, further
/// springs) are not in this balance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Kinetic and potential energy of the structure.
    pub stored: Real,
    /// Work of the friction force on the moving belt's side, `integral F v_belt dt`.
    pub belt_work: Real,
    /// Work of the external force and of the clamp's acceleration a, `integral (F_ext w' - a sum m_j g_j q_j') dt`.
    pub external_work: Real,
    /// Heat in the contact, `- integral F v_r dt`.
    pub contact_dissipation: Real,
    /// Heat in the structure, `integral sum (2 D_j w_j + d_j) m_j q_j'^2 dt`.
    pub structural_dissipation: Real,
}

/// Gauss-Legendre nodes and weights on [0, 1], 8 points (exact to degree 15).
const GAUSS: [(f64, f64); 8] = [
    (0.019_855_071_751_231_88, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

impl Energy {
    /// Adds what flows during a segment up to time `until` in s.
    pub fn add(&mut self, model: &Model, segment: &Segment, mode: ContactMode, until: Real) {
        let span = until - segment.start;
        let mut x = [ZERO; MAX_STATES];
        let mut rates = [ZERO; MAX_STATES];
        for (node, weight) in GAUSS {
            let t = segment.start + node * span;
            segment.state_at(segment.theta(t), &mut x);
            let force = model.evaluate(t, &x, mode, &mut rates).force;
            let motion = model.motion(t, &x, mode);
            self.belt_work += weight * span * force * motion.belt_velocity;
            self.external_work += weight * span * model.external_power(t, &x, motion.velocity);
            self.contact_dissipation -= weight * span * force * motion.relative_velocity;
            self.structural_dissipation += weight * span * model.structural_dissipation(&x);
        }
    }
}
