//! Stick-slip beam.
