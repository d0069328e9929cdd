//! The largest Lyapunov exponent.

/// How neighbours part.
#[derive(Debug, Clone, PartialEq)]
pub struct Divergence {
    /// Mean of ln(distance) of neighbours 0, 1, 2, ... samples later.
    pub mean_log: Vec<f64>,
    /// First and last sample of the straight part.
    pub fitted: (usize, usize),
    /// Largest Lyapunov exponent, 1/sample. The slope of the straight part.
    pub exponent: f64,
    /// Its standard deviation over four parts of the reference points.
    pub std: f64,
}

/// Reference points: enough for a mean, few enough to search by brute force.
const POINTS: usize = 1200;
/// Parts of the reference points for the standard deviation.
const PARTS: usize = 4;

/// Follows nearest neighbours and fits the growth of their distance.
///
/// ```text
/// S(k) = < ln |x_(i+a+k) - x_(n(i)+a+k)| >,   S(k) = const + lambda k on the straight part;   a = (m-1) d
/// ```
///
/// n(i): nearest neighbour of the delay vector z_i in the maximum norm that is more than `theiler` samples away; lambda: exponent,
/// 1/sample. The straight part begins after one delay (the difference has then turned to the direction that grows) and ends
/// where S has come half way to its final level. `None` where there is no such part or neighbours do not part.
///
/// Holds for deterministic series with little noise; for noise S jumps to its level at once. Source: Rosenstein, Collins
/// and De Luca, Physica D 65 (1993) 117.
pub fn largest_exponent(
    series: &[f64],
    delay: usize,
    dimension: usize,
    theiler: usize,
    ahead: usize,
) -> Option<Divergence> {
    let span = (dimension - 1) * delay;
    let last = series.len().checked_sub(span + ahead)?;
    if last < 4 * theiler.max(10) {
        return None;
    }
    let every = (last / POINTS).max(1);
    let mut sums = vec![vec![(0.0, 0_u32); ahead]; PARTS];
    let points: Vec<usize> = (0..last).step_by(every).collect();
    for (number, i) in points.iter().enumerate() {
        let Some(j) = neighbour(series, *i, last, delay, dimension, theiler) else {
            continue;
        };
        let part = &mut sums[number * PARTS / points.len()];
        for (k, (sum, count)) in part.iter_mut().enumerate() {
            let distance = (series[i + span + k] - series[j + span + k]).abs();
            if distance > 0.0 {
                *sum += distance.ln();
                *count += 1;
            }
        }
    }
    let mean = |parts: &[Vec<(f64, u32)>], k: usize| {
        let (sum, count) = parts
            .iter()
            .fold((0.0, 0), |(s, c), p| (s + p[k].0, c + p[k].1));
        (count > 20).then(|| sum / f64::from(count))
    };
    let curve = |parts: &[Vec<(f64, u32)>]| -> Option<Vec<f64>> {
        (0..ahead).map(|k| mean(parts, k)).collect()
    };
    let mean_log = curve(&sums)?;
    let level = mean_log[ahead * 3 / 4..].iter().sum::<f64>() / (ahead - ahead * 3 / 4) as f64;
    let from = delay.min(ahead / 4);
    let half = mean_log[from] + 0.5 * (level - mean_log[from]);
    let to = mean_log.iter().position(|s| *s >= half)?.max(from + 3);
    if level - mean_log[from] < 1.0 || to >= ahead {
        return None;
    }
    let exponent = slope(&mean_log[from..=to]);
    let parts: Vec<f64> = sums
        .chunks(1)
        .filter_map(|part| Some(slope(&curve(part)?[from..=to])))
        .collect();
    let spread = parts.iter().map(|p| (p - exponent).powi(2)).sum::<f64>() / parts.len() as f64;
    Some(Divergence {
        mean_log,
        fitted: (from, to),
        exponent,
        std: (spread / (PARTS as f64 - 1.0)).sqrt(),
    })
}

fn neighbour(
    x: &[f64],
    i: usize,
    last: usize,
    delay: usize,
    dimension: usize,
    theiler: usize,
) -> Option<usize> {
    let mut best = (f64::INFINITY, None);
    for j in (0..last).filter(|j| j.abs_diff(i) > theiler) {
        let mut distance = 0.0_f64;
        for l in 0..dimension {
            let d = (x[i + l * delay] - x[j + l * delay]).abs();
            // What is not a number is no neighbour.
            distance = if d <= distance { distance } else { d };
            if !(distance < best.0) {
                break;
            }
        }
        if distance > 0.0 && distance < best.0 {
            best = (distance, Some(j));
        }
    }
    best.1
}

fn slope(y: &[f64]) -> f64 {
    let n = y.len() as f64;
    let (x0, y0) = (0.5 * (n - 1.0), y.iter().sum::<f64>() / n);
    let xy: f64 = y
        .iter()
        .enumerate()
        .map(|(i, y)| (i as f64 - x0) * (y - y0))
        .sum();
    let xx: f64 = (0..y.len()).map(|i| (i as f64 - x0).powi(2)).sum();
    xy / xx
}
