//! What a measured velocity or acceleration leaves open: the level of force and deflection.
//!
//! A structure on springs that a constant force deflects has no velocity and no acceleration, so that these say nothing of that
//! force and of the deflection. The smoother finds both up to a level. Here the level is set by the friction expected: for a
//! diagnosis a belief like that of the friction constants, which the fit then starts from.

use super::slip_samples::{SlipSample, slip_of_run};
use super::smoothed_run::Smoothing;
use crate::measurement::{Measurand, Run};
use crate::metric::median;
use crate::observer::Structure;

/// By how much the friction expected in slip exceeds the smoothed force in the median, c in N; `None` where nothing slips.
pub fn missing_force(slip: &[SlipSample], run: &Run, friction: &dyn Fn(f64) -> f64) -> Option<f64> {
    let off = slip.iter().map(|s| {
        let v = s.relative_velocity;
        -v.signum() * friction(v.abs()) * run.normal_force - s.force
    });
    let mut off: Vec<f64> = off.filter(|c| c.is_finite()).collect();
    (!off.is_empty()).then(|| median(&mut off))
}

/// Sets the level of force and displacement of a smoothed velocity or acceleration such that friction in slip is what is expected.
///
/// ```text
/// F + c,   q_j + phi_j c / (m_j w_j^2),   c = median over slip of (-sign(v_r) mu(|v_r|) F_N - F)
/// ```
///
/// `friction` is mu (1) over the relative speed in m/s. Nothing changes where a displacement was measured, where a mass has no
/// spring (a constant force then shows), and where nothing slips.
pub fn settle(
    smoothing: &mut Smoothing,
    run: &Run,
    structure: &Structure,
    friction: &dyn Fn(f64) -> f64,
) {
    if run.measurand == Measurand::Displacement || structure.is_free() {
        return;
    }
    let Some(level) = missing_force(&slip_of_run(run, smoothing), run, friction) else {
        return;
    };
    let raise = |values: &mut [f64], by: f64| values.iter_mut().for_each(|v| *v += by);
    let smoothed = &mut smoothing.stick_slip.smoothed;
    raise(&mut smoothed.force, level);
    raise(
        &mut smoothed.displacement,
        level * structure.static_compliance(),
    );
    for (q, mode) in smoothed.q.iter_mut().zip(structure.modes()) {
        raise(q, level * mode.modal_compliance());
    }
}
