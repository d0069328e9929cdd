//! What a fit is compared with.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::model::work::Work;

/// The segments of a fit and the noise that each counts with.
pub struct Observations<'a> {
    /// Segments to be fitted.
    pub segments: &'a [Segment],
    /// Noise of each run in m.
    pub noise: &'a [f64],
    /// Where fits are counted.
    pub work: &'a Work,
}
