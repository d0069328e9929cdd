//! One step by the Taylor series of the solution; its polynomial is the dense output.

use super::{MAX_DEGREE, MAX_STATES, Scales, Segment, State};
use crate::real::value;

/// Lowest degree in use.
const MIN_DEGREE: usize = 8;
/// Longest step in units of the series, for motions whose last coefficients vanish.
const MAX_REACH: f64 = 4.0;
/// Share of the tolerance that a step may use up; a tenth costs a tenth of the speed at this order.
const SAFETY: f64 = 0.1;

/// A smooth system whose solution can be expanded.
pub trait SeriesSystem {
    /// Number of states.
    fn dimension(&self) -> usize;
    /// Writes the coefficients of power `power + 1` of all states, given those up to `power`.
    ///
    /// `x' = f(t, x)` says `(k + 1) x_(k+1) = unit f_k` in powers of `theta = (t - start) / unit`.
    fn extend(&mut self, power: usize, coefficients: &mut [State; MAX_DEGREE + 1]);
}

/// Degree of the series for a relative tolerance.
///
/// With coefficients that fall like `rho^-k` the work per time is least near `1 - ln(tolerance) / 2`
/// (Jorba and Zou 2005, Experimental Mathematics 14:99, sect. 3.1). The sums that grow with the degree
/// are a part of the work only, which moves the optimum up; 5 was found by trial on the default case.
pub fn degree(tolerance: f64) -> usize {
    let optimum = 5.0 - 0.5 * tolerance.ln();
    (optimum.ceil() as usize).clamp(MIN_DEGREE, MAX_DEGREE)
}

/// Expands the solution from the state and time at which `segment` starts, in units of
/// `segment.length` in s, to `degree`.
#[cfg_attr(feature = "tangent", inline(always))]
pub fn expand(system: &mut impl SeriesSystem, degree: usize, segment: &mut Segment) {
    segment.degree = degree;
    segment.dimension = system.dimension();
    for power in 0..degree {
        system.extend(power, &mut segment.coefficients);
    }
}

/// Normalised time up to which the cut series is good to the tolerance: the first of the two last
/// terms to grow to a tenth of `tolerance (|x_i| + scale_i)` in any state ends the step (Jorba and Zou 2005, eq. 3-8).
///
/// What is left out is less than that by the ratio of the step to the radius of convergence.
pub fn reach(segment: &Segment, tolerance: f64, scales: &Scales) -> f64 {
    let c = &segment.coefficients;
    let mut weight = [0.0; MAX_STATES];
    for i in 0..segment.dimension {
        weight[i] = 1.0 / (value(c[0][i]).abs() + scales[i]);
    }
    let largest = |power: usize| {
        (0..segment.dimension).fold(0.0, |m: f64, i| m.max(value(c[power][i]).abs() * weight[i]))
    };
    // The smaller of the roots (SAFETY tolerance / largest)^(1/power), by way of its logarithm.
    let end = |power: usize| (SAFETY * tolerance / largest(power)).ln() / power as f64;
    end(segment.degree)
        .min(end(segment.degree - 1))
        .exp()
        .min(MAX_REACH)
}
