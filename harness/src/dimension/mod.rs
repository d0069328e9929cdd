//! Correlation dimension of a series (Stelter 1992, section 6, and beyond).
//!
//! Slices in, numbers out: it knows no FMU, no file and no report.

mod correlation_sum;
mod error;
mod euclidean;
mod lag;
mod radii;

pub use correlation_sum::{CorrelationSum, Norm, SumSettings};
pub use error::DimensionError;
pub use lag::Instructions;
pub use radii::Radii;
