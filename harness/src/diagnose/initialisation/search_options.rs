//! How thoroughly a hypothesis is searched.

use crate::diagnose::estimation::fit::Fit;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::thresholds::{FLOOR_QUARTILE, LOST};
use serde::Serialize;

/// Jacobians for a first look at a start.
pub(crate) const FIRST_FIT: usize = 3;

/// Share of each segment for a first look: a short horizon is less easily caught in a local minimum.
pub(crate) const FIRST_FIT_SHARE: f64 = 0.4;

/// Jacobians for the starts that look best.
pub(crate) const CLIMB: usize = 10;

/// Starts that are followed to the end.
const FOLLOWED: usize = 2;

/// Strength with which an effect starts beside calibrated nuisances, as a share of the typical one.
const BARELY_ON: f64 = 0.02;

/// How thorough a search is.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct SearchOptions {
    /// Jacobians for a first look at a start.
    pub first_fit: usize,
    /// Share of each segment for it: a short horizon is less easily caught in a local minimum, a long one tells more.
    pub first_fit_share: f64,
    /// Starts that are followed to the end.
    pub followed: usize,
    /// Jacobians for these.
    pub climb: usize,
    /// Strength with which an effect starts beside the calibrated nuisances, as a share of the typical one.
    pub barely_on: f64,
    /// From which nuisances starts are taken.
    pub nuisances: Nuisances,
    /// Whether first looks leave the reference model's common constants where they are.
    pub fixed_first_fits: bool,
    /// How firmly the reference model is held to what is believed of it after that.
    pub belief: f64,
    /// Whether the segments that fit worst have no say.
    pub trims: bool,
}

/// Nuisances with which a search starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Nuisances {
    /// The calibrated ones only, with the effect barely on.
    Calibrated,
    /// The calibrated ones, and the nominal ones with the effect at practical strength; for periodic effects the nominal ones
    /// at the strongest lines only.
    Some,
    /// Both, for every effect.
    All,
}

/// How firmly the reference model's own constants are held while a hypothesis may still lack something. Its residuals
/// are no noise then: a hundred samples in a row err alike, and counted one by one they would bend frequencies, damping and
/// friction far beyond what is believed of them, into valleys from which no effect leads out.
pub const STRONG_PRIOR: f64 = 1000.0;

/// Every start is looked at, the best two are followed to the end.
pub const THOROUGH: SearchOptions = SearchOptions {
    first_fit: FIRST_FIT,
    first_fit_share: FIRST_FIT_SHARE,
    followed: FOLLOWED,
    climb: CLIMB,
    barely_on: BARELY_ON,
    nuisances: Nuisances::All,
    fixed_first_fits: false,
    belief: 1.0,
    trims: true,
};
/// For hypotheses that a rival at the noise floor has all but ruled out, and rivals from the library.
pub const BRIEF: SearchOptions = SearchOptions {
    first_fit: 2,
    first_fit_share: FIRST_FIT_SHARE,
    followed: 1,
    climb: 5,
    barely_on: BARELY_ON,
    nuisances: Nuisances::Some,
    fixed_first_fits: true,
    belief: 1.0,
    trims: true,
};
/// For a curve that nobody knows: short pieces first, which catch it from nothing, then with as many Jacobians as a start that is
/// followed in a thorough search, the reference model held.
pub const CURVE: SearchOptions = SearchOptions {
    first_fit: FIRST_FIT,
    climb: CLIMB,
    belief: STRONG_PRIOR,
    ..BRIEF
};
/// For a second effect that may hide behind one that explains the data: near what is known.
pub const HIDDEN: SearchOptions = SearchOptions {
    nuisances: Nuisances::Calibrated,
    fixed_first_fits: false,
    ..BRIEF
};
impl SearchOptions {
    /// The same beside a model that meets most segments while a few are lost: these show what is missing, and all have a say. Far from the
    /// noise those that fit worst are the ones that a fit has lost.
    pub(crate) fn beside(self, base: &Fit, data: &Observations) -> Self {
        let [quartile, largest] = [0.75, 1.0].map(|share| base.error_quantile(data, share));
        Self {
            trims: self.trims && !is_lost_in_some(quartile, largest),
            ..self
        }
    }

    /// The options of a first look at a start.
    pub(crate) fn first_fit(self) -> FitOptions {
        FitOptions {
            share: self.first_fit_share,
            reinitialise: false,
            belief: if self.fixed_first_fits {
                STRONG_PRIOR
            } else {
                1.0
            },
            reference: !self.fixed_first_fits,
            trims: self.trims,
            ..FitOptions::search(self.first_fit)
        }
    }

    /// The options of a fit that is followed, with so many Jacobians.
    pub(crate) fn following(self, iterations: usize) -> FitOptions {
        FitOptions {
            belief: self.belief,
            trims: self.trims,
            ..FitOptions::search(iterations)
        }
    }
}

/// Whether the upper quartile of the errors and the largest, in units of the noise, are those of a model that meets most segments and is lost
/// in some.
fn is_lost_in_some(quartile: f64, largest: f64) -> bool {
    quartile <= FLOOR_QUARTILE && largest > LOST
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_is_lost_in_some_segments_where_most_are_met() {
        assert!(is_lost_in_some(1.1, 40.0));
        assert!(!is_lost_in_some(1.1, 2.0));
        assert!(!is_lost_in_some(10.0, 40.0));
    }
}
