//! Whether a fit leaves the structure as the campaign knows it: a model that explains the data only with frequencies that no
//! modal analysis would have missed by so much has taken up something else in their place.

use super::search::Trial;

/// Standard deviations of what is believed of a natural frequency beyond which a fit strains it. The true ones of the campaigns
/// of docs/blind-test.md lie within 1.6; one that a hidden quadratic stiffness had bent, 5.7. Damping ratios and the modal mass
/// are often left out of a campaign or known to a factor, so they say nothing.
const BELIEVED: f64 = 3.0;

/// A constant of the structure that a fit had to bend.
#[derive(Debug, Clone, PartialEq)]
pub struct Strain {
    /// Its name.
    pub name: String,
    /// What it was fitted to.
    pub fitted: f64,
    /// What the campaign says.
    pub believed: f64,
    /// Unit of both.
    pub unit: String,
    /// Standard deviations of belief between them.
    pub deviations: f64,
}

/// The natural frequency that a fit strains most, if any.
pub fn strain(trial: &Trial) -> Option<Strain> {
    let knobs = &trial.hypothesis.shared;
    let is_natural_frequency =
        |name: &str| name.starts_with("mode[") && name.ends_with(".frequency");
    let all = knobs.iter().zip(&trial.fit.point.shared);
    all.filter(|(knob, _)| is_natural_frequency(&knob.name) && knob.prior_std > 0.0)
        .map(|(knob, &position)| Strain {
            name: knob.name.clone(),
            fitted: knob.value(position),
            believed: knob.prior,
            unit: knob.unit.clone(),
            deviations: (position - knob.position(knob.prior)).abs() / knob.prior_std,
        })
        .filter(|s| s.deviations > BELIEVED)
        .max_by(|a, b| a.deviations.total_cmp(&b.deviations))
}
