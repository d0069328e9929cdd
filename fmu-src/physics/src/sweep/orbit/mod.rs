//! Periodic motions found directly, stable or not: shooting, Floquet multipliers, continuation in a parameter.
//!
//! A periodic motion is a fixed point of the return map of the section w' = 0, falling. Newton's method finds it from
//! a guess; the map's derivative at it gives the multipliers; pseudo-arclength continuation follows it through folds.
//! Sources: Seydel, Practical Bifurcation and Stability Analysis (2010), ch. 4 and 7; Leine and Nijmeijer, Dynamics and
//! Bifurcations of Non-Smooth Mechanical Systems (2004), for what transitions do to multipliers.

mod branch;
mod return_map;
mod shooting;

pub use branch::{Bifurcation, Branch, BranchEnd, BranchKind, BranchPoint, continue_branch};
pub use shooting::{Orbit, OrbitError, shoot};
