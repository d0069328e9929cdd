//! A fitted parameter with its uncertainty.

use crate::diagnose::estimation::fit::Fit;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::parameter::Scale;
use serde::Serialize;

/// A calibrated value.
#[derive(Debug, Clone, Serialize)]
pub struct Estimate {
    /// Value in the unit.
    pub value: f64,
    /// Standard deviation in the same unit; people are shown [`Estimate::half_width`].
    pub std: f64,
    /// Unit symbol.
    pub unit: String,
    /// Whether the value lies on its bound, so that it is not to be trusted.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub at_bound: bool,
}

/// A shared parameter's value and standard deviation in its unit.
pub fn estimate(h: &Hypothesis, fit: &Fit, index: usize) -> Estimate {
    let parameter = &h.shared[index];
    let value = parameter.value(fit.point.shared[index]);
    let spread = fit
        .covariance
        .as_ref()
        .map_or(f64::NAN, |c| c[(index, index)].max(0.0).sqrt());
    let std = match parameter.scale {
        Scale::Linear => spread,
        Scale::Log => spread * value,
    };
    Estimate {
        value,
        std,
        unit: parameter.unit.clone(),
        at_bound: parameter.is_at_bound(fit.point.shared[index]),
    }
}
