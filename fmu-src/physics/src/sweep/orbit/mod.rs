//! Periodic motions found directly.
