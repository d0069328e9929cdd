//! The interval that people are shown after a value.

/// Half the width of a normal distribution's 95 % interval in standard deviations: the 97.5 % quantile.
const HALF_WIDTH: f64 = 1.96;

/// Half the width of the 95 % interval of a value whose standard deviation is `std`, in its unit: what stands after "±" or "+-"
/// in every text for people. Holds for errors that are about normal; JSON and CSV files give the standard deviation itself.
pub fn half_width(std: f64) -> f64 {
    HALF_WIDTH * std
}
