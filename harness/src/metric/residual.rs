//! Residual of a self-excited motion: each measured cycle against the most similar cycle of the model.

use super::model_motion::ModelMotion;
use std::ops::Range;

use super::cycle::cycle_starts;
use super::nrmse::nrmse;

/// Model and measurement, aligned.
#[derive(Debug, Clone)]
pub struct AlignedResidual {
    /// The model at the measurement's sample times, after alignment.
    pub model: Vec<f64>,
    /// Measured minus model.
    pub residual: Vec<f64>,
    /// What was fitted to each stretch, in the order of time.
    pub fits: Vec<Fit>,
    /// [`nrmse`] of the aligned signals, 1.
    pub nrmse: f64,
}

/// The motion that fits a stretch of the measurement best.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Samples of the stretch.
    pub samples: Range<usize>,
    /// Which motion.
    pub motion: usize,
    /// By how much it is shifted: the motion at t + shift belongs to the measurement at t, s.
    pub shift: f64,
}

/// Grid points per period in the search for a shift: finer than the rise of a stick-slip cycle.
const POINTS_PER_PERIOD: f64 = 60.0;
/// Samples per stretch that the grid search looks at.
const GRID_SAMPLES: usize = 60;
/// Of so many motions that fit best on the grid, the shift is refined.
const REFINED: usize = 4;

/// Aligns motions of a model to a measurement, stretch by stretch.
///
/// A self-excited motion has no clock: model and measurement drift apart in phase however good the model is, an irregular
/// one never repeats, and a small push moves it from one of several coexisting motions to another. A plain difference
/// would show little else. So the measurement is cut at its cycle starts (or, where it has none, into pieces of one
/// `period`, s), and each stretch is compared with the motion and the shift that fit it best:
///
/// ```text
/// y_i = motion_k(t_i + s),   (k, s) minimise sum_(i in stretch) (m_i - y_i)^2
/// ```
///
/// What remains is the difference in shape and size between cycles that are measured and cycles that the model makes.
/// `motions` are motions of the model, settled or on their way; s runs over every shift with which they cover the whole
/// block of stretches and which is within their reach, so they should extend two periods beyond both ends of a block.
/// Errors of the period as such do not show here; they are a metric of their own.
pub fn aligned_residual(
    time: &[f64],
    measured: &[f64],
    motions: &[ModelMotion],
    period: f64,
) -> AlignedResidual {
    let fits = blocks(time, measured, period, f64::INFINITY)
        .iter()
        .flat_map(|block| align(time, measured, block, motions, period).fits)
        .collect();
    AlignedResidual::of(time, measured, motions, fits)
}

impl AlignedResidual {
    /// Puts the model together from what was fitted to each stretch; `fits` in the order of time.
    pub fn of(
        time: &[f64],
        measured: &[f64],
        motions: &[ModelMotion],
        fits: Vec<Fit>,
    ) -> AlignedResidual {
        let along = |fit: &Fit| {
            let (motion, shift) = (&motions[fit.motion], fit.shift);
            time[fit.samples.clone()]
                .iter()
                .map(move |t| motion.at(t + shift))
        };
        let model: Vec<f64> = fits.iter().flat_map(along).collect();
        let residual = measured.iter().zip(&model).map(|(m, y)| m - y).collect();
        AlignedResidual {
            nrmse: nrmse(measured, &model),
            model,
            residual,
            fits,
        }
    }
}

/// Stretches that are placed against the same piece of the motions: one after another, together not longer than the
/// block's length.
pub type Block = Vec<Range<usize>>;

/// Cuts a measurement into stretches, and puts these into blocks no longer than `length`, s. Each block can be aligned by
/// itself, so the work grows with the record and not with its square.
pub fn blocks(time: &[f64], measured: &[f64], period: f64, length: f64) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    for stretch in stretches(time, &cycle_starts(time, measured, period), period) {
        match blocks.last_mut() {
            Some(block) if time[stretch.end - 1] - time[block[0].start] <= length => {
                block.push(stretch);
            }
            _ => blocks.push(vec![stretch]),
        }
    }
    blocks
}

/// What was fitted to a block.
#[derive(Debug, Clone)]
pub struct AlignedBlock {
    /// One entry per stretch.
    pub fits: Vec<Fit>,
    /// How many samples of the motions were compared with samples of the block.
    pub compared: u64,
}

/// Fits every stretch of a block, see [`aligned_residual`].
pub fn align(
    time: &[f64],
    measured: &[f64],
    block: &[Range<usize>],
    motions: &[ModelMotion],
    period: f64,
) -> AlignedBlock {
    let span = (time[block[0].start], time[block[block.len() - 1].end - 1]);
    let bounds: Vec<(f64, f64)> = motions.iter().map(|m| m.shifts_covering(span)).collect();
    // The motion and the shift that fitted one stretch mostly fit the next: looked at first, they let the search give up
    // all others early. What it finds does not depend on the order.
    let mut order: Vec<usize> = (0..motions.len()).collect();
    let mut last: Vec<f64> = bounds.iter().map(|b| b.0).collect();
    let (mut fits, mut compared) = (Vec::with_capacity(block.len()), 0);
    for samples in block {
        let mut stretch = Stretch::new(&time[samples.clone()], &measured[samples.clone()]);
        let mut best: Vec<Place> = Vec::with_capacity(REFINED + 1);
        for &k in &order {
            let worst = best.get(REFINED - 1).map_or(f64::INFINITY, |p| p.misfit);
            let place = stretch.coarse(k, &motions[k], bounds[k], period, (last[k], worst));
            let rank = best.partition_point(|p| p.before(&place));
            best.insert(rank, place);
            best.truncate(REFINED);
        }
        for place in best.iter().rev() {
            let at = order.iter().position(|k| *k == place.motion);
            order[..=at.expect("every motion is in the order")].rotate_right(1);
            last[place.motion] = place.shift;
        }
        let refined: Vec<Place> = best
            .iter()
            .map(|p| stretch.refine(p, &motions[p.motion], bounds[p.motion], period))
            .collect();
        let best = refined
            .into_iter()
            .min_by(|a, b| a.misfit.total_cmp(&b.misfit))
            .expect("there is at least one motion");
        compared += stretch.compared;
        fits.push(Fit {
            samples: samples.clone(),
            motion: best.motion,
            shift: best.shift,
        });
    }
    AlignedBlock { fits, compared }
}

/// Index ranges from cycle start to cycle start. What is longer than one and a half periods is cut evenly; the pieces
/// before the first start and after the last go with their neighbours if they are shorter than half a period, since
/// anything fits a short piece.
fn stretches(time: &[f64], starts: &[f64], period: f64) -> Vec<Range<usize>> {
    let (begin, end) = (time[0], time[time.len() - 1]);
    let inner = starts
        .iter()
        .copied()
        .filter(|s| *s > begin + 0.5 * period && *s < end - 0.5 * period);
    let ends: Vec<f64> = std::iter::once(begin)
        .chain(inner)
        .chain(std::iter::once(end))
        .collect();
    let mut cuts = vec![0];
    for pair in ends.windows(2) {
        let pieces = ((pair[1] - pair[0]) / period).round().max(1.0);
        let evenly =
            (1..=pieces as usize).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / pieces);
        cuts.extend(evenly.map(|cut| time.partition_point(|t| *t < cut)));
    }
    // The last sample belongs to the last stretch.
    if let Some(last) = cuts.last_mut() {
        *last = time.len();
    }
    cuts.windows(2)
        .map(|w| w[0]..w[1])
        .filter(|r| !r.is_empty())
        .collect()
}

/// A shift of a motion, and how far it is from a stretch there.
#[derive(Debug, Clone, Copy)]
struct Place {
    motion: usize,
    shift: f64,
    misfit: f64,
}

impl Place {
    /// The better one first; of equal ones the earlier motion.
    fn before(&self, other: &Place) -> bool {
        let order = self.misfit.total_cmp(&other.misfit);
        order.then(self.motion.cmp(&other.motion)).is_lt()
    }
}

/// A piece of the measurement.
struct Stretch<'a> {
    time: &'a [f64],
    measured: &'a [f64],
    /// Times and values that the grid search looks at, scattered over the stretch: a cycle that differs is given up after a
    /// few of them, while neighbours would all say the same.
    scattered: Vec<(f64, f64)>,
    compared: u64,
}

impl<'a> Stretch<'a> {
    fn new(time: &'a [f64], measured: &'a [f64]) -> Self {
        let skip = (time.len() / GRID_SAMPLES).max(1);
        let looked_at: Vec<(f64, f64)> = time
            .iter()
            .copied()
            .zip(measured.iter().copied())
            .step_by(skip)
            .collect();
        let n = looked_at.len();
        // Steps of the golden section are far from all earlier ones; without a common divisor they reach every sample.
        let divides = |d: usize, s: usize| n.is_multiple_of(d) && s.is_multiple_of(d);
        let mut stride = ((0.618 * n as f64) as usize).max(1);
        while (2..=stride).any(|d| divides(d, stride)) {
            stride += 1;
        }
        Self {
            time,
            measured,
            scattered: (0..n).map(|i| looked_at[i * stride % n]).collect(),
            compared: 0,
        }
    }

    /// The shift within the bounds that fits best on a grid, of which the point next to `first` is tried first; a misfit of
    /// infinity stands for all above `worst`.
    fn coarse(
        &mut self,
        k: usize,
        motion: &ModelMotion,
        (lowest, highest): (f64, f64),
        period: f64,
        (first, worst): (f64, f64),
    ) -> Place {
        let step = period / POINTS_PER_PERIOD;
        let points = ((highest - lowest) / step).floor().max(0.0) as usize;
        let mut best = Place {
            motion: k,
            shift: lowest,
            misfit: f64::INFINITY,
        };
        let first = (((first - lowest) / step).round().max(0.0) as usize).min(points);
        for i in std::iter::once(first).chain(0..=points) {
            let shift = lowest + i as f64 * step;
            let misfit = self.glance(motion, shift, best.misfit.min(worst));
            if misfit < best.misfit {
                (best.shift, best.misfit) = (shift, misfit);
            }
        }
        best
    }

    /// Golden section about a shift of the grid.
    fn refine(
        &mut self,
        start: &Place,
        motion: &ModelMotion,
        (lowest, highest): (f64, f64),
        period: f64,
    ) -> Place {
        let step = period / POINTS_PER_PERIOD;
        let mut misfit = |shift| self.misfit(motion, shift);
        let (mut low, mut high) = (
            (start.shift - step).max(lowest),
            (start.shift + step).min(highest),
        );
        let golden = 0.618_033_988_75;
        for _ in 0..18 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if misfit(a) <= misfit(b) {
                high = b;
            } else {
                low = a;
            }
        }
        let shift = 0.5 * (low + high);
        Place {
            motion: start.motion,
            shift,
            misfit: misfit(shift),
        }
    }

    /// Sum of squares over the scattered samples; infinite where the model does not reach, and as soon as it passes `give_up`.
    fn glance(&mut self, motion: &ModelMotion, shift: f64, give_up: f64) -> f64 {
        let per_interval = 1.0 / motion.interval;
        let offset = (shift - motion.start) * per_interval;
        let mut sum = 0.0;
        for (i, (t, m)) in self.scattered.iter().enumerate() {
            let at = t * per_interval + offset;
            // A negative number becomes index 0 here, but no shift of the grid leads there.
            let k = at as usize;
            let Some([low, high]) = motion.values.get(k..k + 2) else {
                self.compared += i as u64 + 1;
                return f64::INFINITY;
            };
            let off = low + (at - k as f64) * (high - low) - m;
            sum += off * off;
            if sum > give_up {
                self.compared += i as u64 + 1;
                return f64::INFINITY;
            }
        }
        self.compared += self.scattered.len() as u64;
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    /// Sum of squares over all samples; infinite where the model does not reach.
    fn misfit(&mut self, motion: &ModelMotion, shift: f64) -> f64 {
        self.compared += self.time.len() as u64;
        let square = |(t, m): (&f64, &f64)| (motion.at(t + shift) - m).powi(2);
        let sum: f64 = self.time.iter().zip(self.measured).map(square).sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn wave(t: f64) -> f64 {
        (TAU * t).sin() + 0.3 * (2.0 * TAU * t).cos()
    }

    fn record() -> Vec<f64> {
        (0..6000).map(|i| f64::from(i) * 1e-4).collect()
    }

    fn motion(values: &[f64]) -> ModelMotion<'_> {
        ModelMotion {
            start: -0.1,
            interval: 1e-4,
            values,
            reach: f64::INFINITY,
        }
    }

    #[test]
    fn val_a_motion_one_percent_slow_and_shifted_aligns_to_a_small_residual() {
        let time = record();
        let measured: Vec<f64> = time.iter().map(|t| wave(t / 0.0303 + 0.4)).collect();
        let values: Vec<f64> = (0..8000)
            .map(|i| wave((f64::from(i) * 1e-4 - 0.1) / 0.03))
            .collect();
        let found = aligned_residual(&time, &measured, &[motion(&values)], 0.0303);
        // Within a cycle the phase runs off by up to half a percent of the period either way, 0.29 % rms; times the
        // relative slope of the wave, 2 pi sqrt((1 + 4 * 0.09) / 1.09), that is 2.0 %.
        assert!((found.nrmse - 0.0204).abs() < 2e-3, "{}", found.nrmse);
    }

    #[test]
    fn val_a_measurement_that_jumps_between_two_motions_is_followed() {
        let time = record();
        let measured: Vec<f64> = time
            .iter()
            .map(|t| {
                if *t < 0.3 {
                    wave(t / 0.03)
                } else {
                    0.1 * wave(t / 0.03)
                }
            })
            .collect();
        let large: Vec<f64> = (0..8000)
            .map(|i| wave(f64::from(i) * 1e-4 / 0.03))
            .collect();
        let small: Vec<f64> = large.iter().map(|v| 0.1 * v).collect();
        let found = aligned_residual(&time, &measured, &[motion(&large), motion(&small)], 0.03);
        assert!(found.nrmse < 0.02, "{}", found.nrmse);
        assert_eq!(
            (
                found.fits[0].motion,
                found.fits[found.fits.len() - 1].motion
            ),
            (0, 1)
        );
    }

    #[test]
    fn val_a_wrong_amplitude_shows_in_full() {
        let time = record();
        let measured: Vec<f64> = time.iter().map(|t| wave(t / 0.03)).collect();
        let values: Vec<f64> = (0..8000)
            .map(|i| 0.8 * wave(f64::from(i) * 1e-4 / 0.03))
            .collect();
        let found = aligned_residual(&time, &measured, &[motion(&values)], 0.03);
        assert!((found.nrmse - 0.2).abs() < 1e-3, "{}", found.nrmse);
    }

    /// Samples compared for an irregular record of this many samples, against short motions, block by block.
    fn compared(samples: usize) -> u64 {
        let time: Vec<f64> = (0..samples).map(|i| i as f64 * 1e-4).collect();
        let wobble = |t: f64| 1.0 + 0.1 * (TAU * t / 0.17).sin();
        let measured: Vec<f64> = time.iter().map(|t| wobble(*t) * wave(t / 0.03)).collect();
        let values: Vec<f64> = (0..8000)
            .map(|i| wave(f64::from(i) * 1e-4 / 0.03))
            .collect();
        let small: Vec<f64> = values.iter().map(|v| 0.8 * v).collect();
        let motions = [motion(&values), motion(&small)];
        blocks(&time, &measured, 0.03, 0.3)
            .iter()
            .map(|block| align(&time, &measured, block, &motions, 0.03).compared)
            .sum()
    }

    #[test]
    fn regress_the_search_grows_with_the_record_and_not_with_its_square() {
        let (short, long) = (compared(20_000), compared(160_000));
        let growth = long as f64 / short as f64;
        assert!((7.0..9.0).contains(&growth), "{growth}");
    }

    #[test]
    fn blocks_hold_every_sample_once_and_are_no_longer_than_asked_for() {
        let time = record();
        let measured: Vec<f64> = time.iter().map(|t| wave(t / 0.03)).collect();
        let blocks = blocks(&time, &measured, 0.03, 0.1);
        let mut next = 0;
        for block in &blocks {
            for stretch in block {
                assert_eq!(stretch.start, next);
                next = stretch.end;
            }
            let (first, last) = (block[0].start, block[block.len() - 1].end - 1);
            assert!(time[last] - time[first] <= 0.1);
        }
        assert_eq!((next, blocks.len() > 4), (time.len(), true));
    }
}
