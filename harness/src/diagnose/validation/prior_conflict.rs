//! Whether a fit leaves the structure as the campaign knows it: a model that explains the data only with frequencies that no
//! modal analysis would have missed by so much has taken up something else in their place.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::model::parameter::{Kind, Parameter};

/// Standard deviations of what is believed of a natural frequency by which a fit may differ from it. The true ones of the campaigns
/// of docs/blind-test.md lie within 1.6; one that a hidden quadratic stiffness had bent, 5.7. Damping ratios and the modal mass
/// are often left out of a campaign or known to a factor, so they say nothing.
const BELIEVED: f64 = 3.0;

/// A constant of the structure that a fit had to bend.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorConflict {
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

/// The natural frequency that a fit contradicts most, if any; of an FMU without modes, the constant of its model.
pub fn prior_conflict(fitted: &FittedHypothesis) -> Option<PriorConflict> {
    let parameters = &fitted.hypothesis.shared;
    let is_of_mode = |p: &Parameter| p.name.starts_with("mode[");
    let has_modes = parameters.iter().any(is_of_mode);
    let is_well_known = |p: &Parameter| match has_modes {
        true => is_of_mode(p) && p.name.ends_with(".frequency"),
        false => p.kind == Kind::Reference,
    };
    let all = parameters.iter().zip(&fitted.fit.point.shared);
    all.filter(|(parameter, _)| is_well_known(parameter) && parameter.prior_std > 0.0)
        .map(|(parameter, &position)| PriorConflict {
            name: parameter.name.clone(),
            fitted: parameter.value(position),
            believed: parameter.prior,
            unit: parameter.unit.clone(),
            deviations: (position - parameter.position(parameter.prior)).abs()
                / parameter.prior_std,
        })
        .filter(|s| s.deviations > BELIEVED)
        .max_by(|a, b| a.deviations.total_cmp(&b.deviations))
}
