//! Where a model fails and what that depends on.

pub mod argument;
pub mod dependence;
pub mod library_term;
pub mod misses;
pub mod proposed_term;
pub mod replay;
pub mod residual;
pub mod short_formula;
pub mod spectrum;
pub mod where_it_fails;
