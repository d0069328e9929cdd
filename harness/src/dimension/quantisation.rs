//! Series that were rounded to few levels.

/// The steps of a rounded series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantisation {
    /// One step, unit of the series.
    pub step: f64,
    /// Number of steps in the range.
    pub levels: usize,
}

/// Levels above which rounding does not disturb a dimension at the radii used.
const COARSE: usize = 1 << 12;

/// Finds the step if all samples are multiples of it (from the first) and their range holds at most 4096 steps.
pub fn find_steps(series: &[f64]) -> Option<Quantisation> {
    let mut values: Vec<f64> = series.iter().copied().filter(|x| x.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let range = values.last()? - values.first()?;
    // More values than levels, or hardly a value twice: not rounded.
    if values.len() > COARSE || values.len() * 2 > series.len() {
        return None;
    }
    let steps = values.windows(2).map(|w| w[1] - w[0]);
    let step = steps.fold(f64::INFINITY, f64::min);
    let off = |v: &f64| {
        let multiple = (v - values[0]) / step;
        (multiple - multiple.round()).abs()
    };
    let regular = values.iter().all(|v| off(v) < 0.05);
    let levels = (range / step).round() as usize;
    (regular && levels <= COARSE).then_some(Quantisation { step, levels })
}

/// The series with an even random number of one step's width added: the steps vanish, and little else changes at
/// radii of several steps.
///
/// Source: Moeller and others, Phys. Lett. A 138 (1989) 176 (errors of the dimension by rounding).
pub fn dither(series: &[f64], step: f64, seed: u64) -> Vec<f64> {
    let mut random = fastrand::Rng::with_seed(seed);
    series
        .iter()
        .map(|x| x + step * (random.f64() - 0.5))
        .collect()
}
