//! The classical method of Runge and Kutta, for machines that are no beam on a belt.
#![allow(dead_code)]

/// The state after a step of `h` from time `t`, where `rates` gives its derivative.
pub fn step<const N: usize>(
    rates: impl Fn(f64, [f64; N]) -> [f64; N],
    t: f64,
    state: [f64; N],
    h: f64,
) -> [f64; N] {
    let along = |rate: [f64; N], by: f64| std::array::from_fn(|i| state[i] + by * rate[i]);
    let a = rates(t, state);
    let b = rates(t + 0.5 * h, along(a, 0.5 * h));
    let c = rates(t + 0.5 * h, along(b, 0.5 * h));
    let d = rates(t + h, along(c, h));
    std::array::from_fn(|i| state[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
}
