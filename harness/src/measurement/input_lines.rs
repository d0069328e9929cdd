//! An input as straight lines over several samples each.

use super::inputs::{Between, InputSeries, InputTrack, REFINEMENT};

/// The continuous function that is nearest to an input in the least-squares sense among those that are straight from each `samples`-th
/// sample to the next.
///
/// ```text
/// sum_j c_j (h_i, h_j) = (h_i, u),   h_i the hat of knot i,   (f, g) = integral of f g dt
/// ```
///
/// u the input (unit of its values) at even `time` in s, the integrals by the midpoints of eight parts of each sample interval. The first
/// moments of u over each hat are kept, hence what it does to a mass that is slow. Source: de Boor 1978, A Practical Guide to Splines,
/// ch. III (least-squares approximation by broken lines).
pub fn on_lines(series: &InputSeries, time: &[f64], samples: usize) -> InputSeries {
    let last = time.len() - 1;
    let track = InputTrack::of(series, time, f64::NEG_INFINITY);
    let lines = last.div_ceil(samples);
    let (mut diagonal, mut beside) = (vec![0.0; lines + 1], vec![0.0; lines]);
    let mut moments = vec![0.0; lines + 1];
    let place = |line: usize| (line * samples).min(last);
    for line in 0..lines {
        let (from, to) = (place(line), place(line + 1));
        let parts = (to - from) * REFINEMENT;
        let width = (time[to] - time[from]) / parts as f64;
        for part in 0..parts {
            let share = (part as f64 + 0.5) / parts as f64;
            let t = time[from] + share * (time[to] - time[from]);
            let value = track.piece(t, t).0;
            moments[line] += (1.0 - share) * value * width;
            moments[line + 1] += share * value * width;
            diagonal[line] += (1.0 - share).powi(2) * width;
            diagonal[line + 1] += share * share * width;
            beside[line] += share * (1.0 - share) * width;
        }
    }
    // Elimination without pivots: the matrix is dominant.
    for i in 0..lines {
        let factor = beside[i] / diagonal[i];
        diagonal[i + 1] -= factor * beside[i];
        moments[i + 1] -= factor * moments[i];
    }
    let mut knots = moments;
    knots[lines] /= diagonal[lines];
    for i in (0..lines).rev() {
        knots[i] = (knots[i] - beside[i] * knots[i + 1]) / diagonal[i];
    }
    let at = |k: usize| {
        let line = (k / samples).min(lines - 1);
        let (from, to) = (place(line), place(line + 1));
        let share = (k - from) as f64 / (to - from) as f64;
        (1.0 - share) * knots[line] + share * knots[line + 1]
    };
    InputSeries {
        column: series.column.clone(),
        values: (0..=last).map(at).collect(),
        between: Between::Linear(samples),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::Interpolation;

    fn series(interpolation: Interpolation, of: impl Fn(f64) -> f64) -> (InputSeries, Vec<f64>) {
        let time: Vec<f64> = (0..203).map(|k| 1.0 + 0.5 * f64::from(k)).collect();
        let series = InputSeries {
            column: "u".into(),
            values: time.iter().map(|t| of(*t)).collect(),
            between: interpolation.into(),
        };
        (series, time)
    }

    #[test]
    fn val_a_line_stays_a_line_and_a_held_input_comes_half_a_sample_later() {
        // Source: closed form; what holds u(t_k) = t_k until the next sample is t less half an interval in the mean.
        for (interpolation, late) in [(Interpolation::Linear, 0.0), (Interpolation::Held, 0.25)] {
            let (series, time) = series(interpolation, |t| t);
            let coarse = on_lines(&series, &time, 4);
            let track = InputTrack::of(&coarse, &time, f64::NEG_INFINITY);
            // Far from both ends, where half a step more or less is felt.
            for t in [41.0, 52.3, 61.8] {
                let found = track.piece(t, t).0;
                assert!((found - (t - late)).abs() < 1e-9, "{t}: {found}");
            }
        }
    }

    #[test]
    fn a_part_has_the_knots_of_the_whole_and_the_impulse_is_kept() {
        let wave = |t: f64| (0.4 * t).sin() + 0.3 * (1.1 * t).cos();
        let (series, time) = series(Interpolation::Held, wave);
        let coarse = on_lines(&series, &time, 8);
        let since: Vec<f64> = time.iter().map(|t| t - time[0]).collect();
        let whole = InputTrack::of(&coarse, &since, f64::NEG_INFINITY);
        let part = InputTrack::within(&coarse, &time, 61..131, f64::NEG_INFINITY);
        for k in 61..130 {
            let (t, end) = (since[k], since[k + 1]);
            let (a, b) = (whole.piece(t, end), part.piece(t, end));
            assert!(
                (a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12,
                "{k}"
            );
        }
        assert_eq!(whole.next_knot(30.5), Some(32.0));
        let impulse = |track: &InputTrack| -> f64 {
            let middles = (0..8 * 202).map(|i| (f64::from(i) + 0.5) / 16.0);
            middles.map(|t| track.piece(t, t).0 / 16.0).sum()
        };
        let fine = InputTrack::of(&series, &since, f64::NEG_INFINITY);
        assert!((impulse(&whole) - impulse(&fine)).abs() < 1e-9);
    }
}
