//! White noise for simulated measurements.

/// A standard normal number (Box and Muller 1958).
pub(crate) fn gaussian(random: &mut fastrand::Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.f64()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.f64()).cos()
}
