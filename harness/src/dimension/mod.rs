//! Correlation dimension of a series (Stelter 1992, section 6, and beyond).
//!
//! Slices in, numbers out: it knows no FMU, no file and no report.

mod analysis;
mod convergence;
mod correlation_sum;
pub mod delay;
mod error;
mod euclidean;
mod lag;
pub mod lyapunov;
pub mod periodicity;
pub mod quantisation;
mod radii;
mod resampling;
pub mod scaling;
pub mod slopes;
pub mod surrogate;
pub mod theiler;
mod verdict;

pub use analysis::{Analysis, Settings, analyse};
pub use convergence::{Convergence, FEWEST_RETURNS};
pub use correlation_sum::{CorrelationSum, Norm, SumSettings};
pub use error::DimensionError;
pub use lag::Instructions;
pub use radii::Radii;
pub use resampling::SurrogateTest;
pub use verdict::Verdict;
