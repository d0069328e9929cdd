//! A noise that falls in the course of a fit.
//!
//! The objective of a search forgives segments that are lost. A model may settle on most of them, give the others up and have no
//! way back: what would bring those nearer takes these away. A graduated fit allows at first for as much as nine segments of ten
//! leave, so that it is least squares on all of those, and for less from step to step, down to the sensor's noise halfway
//! through:
//!
//! ```text
//! sigma_i = sigma max(1, r^(1 - i / (N/2))),   r = 0.9-quantile of the segments' errors over sigma
//! ```
//!
//! with i the number of Jacobians before and N the most that the fit takes. It holds where the model is near on most segments. From
//! afar least squares follow the segments that are lost most, and their motions say little. Source: graduated non-convexity,
//! Blake and Zisserman 1987, Visual Reconstruction, ch. 7.

use crate::diagnose::estimation::fitter::{Fitter, Place, TRIMMED};

/// Share of the segments on which a fit begins as least squares: half of what a search leaves out may be lost for good.
pub(crate) const SHARE: f64 = 1.0 - 0.5 * TRIMMED;

/// The course of the noise in one fit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Graduation {
    /// Error over the noise at the start.
    start: f64,
    /// Jacobians until the noise is the sensor's.
    steps: f64,
}

impl Graduation {
    /// Factor of the noise after so many Jacobians.
    pub(crate) fn at(self, iteration: usize) -> f64 {
        let left = 1.0 - iteration as f64 / self.steps;
        self.start.powf(left.max(0.0))
    }
}

impl Fitter<'_, '_> {
    /// The course of the noise in a fit that begins at a place; constant where none was asked for.
    pub(crate) fn graduation(&self, here: &Place) -> Graduation {
        let mut ratios: Vec<f64> = (0..here.sums.len())
            .map(|k| {
                let noise = self.data.noise[self.data.segments[k].run];
                (here.sums[k] / self.count(k)).sqrt() / noise
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        let at = (ratios.len().saturating_sub(1) as f64 * SHARE).round() as usize;
        let is_wanted = |r: &f64| self.options.graduated && r.is_finite();
        Graduation {
            start: ratios
                .get(at)
                .copied()
                .filter(is_wanted)
                .map_or(1.0, |r| r.max(1.0)),
            steps: (0.5 * self.options.iterations as f64).max(1.0),
        }
    }

    /// Allows for so many times the noise from here on.
    pub(crate) fn allow(&mut self, allowance: f64, here: &mut Place) {
        if allowance != self.allowance {
            self.allowance = allowance;
            here.merit = self.trimmed(&here.point, &here.sums);
        }
    }
}
