//! Friction over relative velocity and dwell time, from the estimated force.

use super::{Observation, characteristic};
use crate::observer::{
    BeltVelocity, Contact, CurveSettings, DwellResult, LawPoints, NormalForce, ObserverError,
    PoleRule, StickSlip, TimeForm, break_away, fit_laws, friction_characteristic, friction_curve,
    observe as place, offset_from_symmetry,
};

/// Misfit of the friction curve above which friction is not one curve.
const CURVE_MISFIT: f64 = 1.5;

/// Characteristic, curve, break-away and laws; what the record does not give becomes a remark. The curve by shooting is sought where
/// `shot` gives a motion that knows stick and slip, the displacement that it comes from and the belt's velocity.
pub fn friction(
    out: &mut Observation,
    shot: Option<(&StickSlip, &[f64], BeltVelocity)>,
    normal_force: NormalForce,
) {
    let mut remarks = Vec::new();
    let mut note = |error: ObserverError| remarks.push(format!("{}.", capital(&error.to_string())));
    let contact = Contact {
        relative_velocity: &out.relative_velocity,
        force: &out.force,
        normal_force,
        phases: &out.phases,
    };
    let bins = friction_characteristic(&contact, &Default::default())
        .map_err(&mut note)
        .unwrap_or_default();
    let dwell = break_away(&contact).map_err(&mut note).ok();
    let curve = shot.and_then(|(found, y, belt)| {
        friction_curve(
            &out.structure,
            y,
            belt,
            &contact,
            found,
            &CurveSettings::default(),
        )
        .map_err(&mut note)
        .ok()
    });
    let trusted = curve.as_ref().filter(|c| c.misfit < CURVE_MISFIT);
    let points = match trusted {
        Some(curve) => LawPoints::from_curve(curve),
        None => {
            let mean = |d: &DwellResult| (d.mu_mean, d.mu_std / (d.events.len() as f64).sqrt());
            LawPoints::from_bins(&bins, dwell.as_ref().map(mean))
        }
    };
    let laws = fit_laws(&points).map_err(&mut note).unwrap_or_default();
    if let (Some(curve), None) = (&curve, trusted) {
        remarks.push(format!(
            "Friction in slip is not one curve over the speed within the noise (misfit {:.1}); the laws are fitted to the binned means.",
            curve.misfit
        ));
    }
    out.offset = offset_from_symmetry(&out.structure, &bins, normal_force);
    out.curve_trusted = trusted.is_some();
    (out.bins, out.dwell, out.curve, out.laws) = (bins, dwell, curve, laws);
    out.characteristic = characteristic::best(out);
    out.remarks.extend(remarks);
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or(String::new(), |c| c.to_uppercase().chain(letters).collect())
}

/// Multiples of the speed that the data suggest.
const SPEEDS: [f64; 5] = [0.25, 0.5, 0.75, 1.0, 1.5];

/// Pole speed in Hz, and what its force differs by, causal and without its delay, for pole-placed observers beside the estimate.
pub fn pole_speeds(out: &Observation, interval: f64) -> Vec<(f64, f64, f64)> {
    let rule = PoleRule::FromData;
    let Ok(poles) = rule.poles(&out.structure, interval, &out.measured) else {
        return Vec::new();
    };
    let suggested = poles[0].norm() / std::f64::consts::TAU;
    SPEEDS
        .iter()
        .filter_map(|factor| {
            let rule = PoleRule::AtZeros {
                frequency_hz: factor * suggested,
            };
            let form = TimeForm::Discrete;
            let found = place(&out.structure, interval, &out.measured, &rule, form).ok()?;
            let earlier = found.force_without_delay(interval);
            let off = |force: &[f64]| difference(force, &out.force);
            Some((factor * suggested, off(&found.force), off(&earlier)))
        })
        .collect()
}

/// RMS difference over the spread of `reference`, middle 80 %.
fn difference(force: &[f64], reference: &[f64]) -> f64 {
    let n = reference.len();
    let part = n / 10..n - n / 10;
    let count = part.len() as f64;
    let mean = reference[part.clone()].iter().sum::<f64>() / count;
    let spread: f64 = reference[part.clone()]
        .iter()
        .map(|f| (f - mean).powi(2))
        .sum();
    let off: f64 = part.map(|k| (force[k] - reference[k]).powi(2)).sum();
    (off / spread).sqrt()
}
