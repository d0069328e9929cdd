//! Unknown functions as effects: a curve of one quantity that acts in one place.
//!
//! Each is a user's effect with a table, a natural cubic spline through [`NODES`] nodes at even distances over the range of
//! its argument. Its values at the nodes are
//!
//! ```text
//! g_i = s sum_k d_k z_k cos(pi k i / (NODES - 1)),   d_0 = 1, d_k = k^-2
//! ```
//!
//! with independent normal z_k before the data, of standard deviation 1 unless the data tell another smoothness ([`Smoothness`]): the cosine coefficients of a curve of which the second derivative is
//! white have standard deviations that fall with the square of their number (Wahba 1990, Spline Models for Observational Data,
//! sect. 1.3). s is the strength as met in practice that the file gives as `typical`.

mod effect_file;
mod latent_values;
mod places;
mod ranges;

pub(crate) use effect_file::value_unit;
pub use effect_file::{FormulaConstant, UnknownFunction, is_unknown_function};
pub use latent_values::{NODES, Smoothness, latent_name, weight};
pub(crate) use latent_values::{is_node, latent};
pub(in crate::diagnose::model) use ranges::loads;
pub use ranges::{lowest_frequency, unknown_functions};
