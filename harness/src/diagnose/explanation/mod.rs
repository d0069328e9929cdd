//! Where a model fails and what that depends on.

pub mod curve_estimate;
pub mod dependence;
pub mod library_term;
pub mod proposed_term;
pub mod replay;
pub mod residual;
pub mod short_formula;
