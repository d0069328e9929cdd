//! Times at which the model is read over a segment: at the samples, and for each further sensor when these are by its clock.

/// Times in s nearer than this are the same: rounding of times of some thousand seconds is smaller.
const SAME: f64 = 1e-12;

/// Times of a prediction, and which of them each sensor reads.
pub(super) struct Instants {
    /// Times in s, increasing.
    pub times: Vec<f64>,
    /// Place among them of each sample.
    pub samples: Vec<usize>,
    /// For each clock the places of the times at which it reads the samples.
    pub late: Vec<Vec<usize>>,
}

impl Instants {
    /// Times of `samples` in s, increasing, and for clocks that are `late` by so many s: such a clock reads at `t - late`, not before the
    /// first sample nor after `end`.
    pub fn new(samples: Vec<f64>, end: f64, late: &[f64]) -> Self {
        let begin = samples.first().copied().unwrap_or(end);
        let of_clock = |late: &f64| {
            samples
                .iter()
                .map(|t| (t - late).clamp(begin, end))
                .collect()
        };
        let mut lists: Vec<Vec<f64>> = late.iter().map(of_clock).collect();
        lists.insert(0, samples);
        let mut places: Vec<Vec<usize>> = vec![Vec::new(); lists.len()];
        let mut times = Vec::with_capacity(lists[0].len());
        let next = |places: &[Vec<usize>], i: usize| lists[i].get(places[i].len()).copied();
        loop {
            let waiting = (0..lists.len()).filter_map(|i| next(&places, i));
            let Some(time) = waiting.reduce(f64::min) else {
                break;
            };
            for i in 0..lists.len() {
                while next(&places, i).is_some_and(|t| t <= time + SAME) {
                    places[i].push(times.len());
                }
            }
            times.push(time);
        }
        let late = places.split_off(1);
        Self {
            times,
            samples: places.swap_remove(0),
            late,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_clocks_times_are_those_of_the_samples() {
        let samples = vec![0.1, 0.2, 0.35];
        let instants = Instants::new(samples.clone(), 0.35, &[]);
        assert_eq!(instants.times, samples);
        assert_eq!(instants.samples, [0, 1, 2]);
        assert!(instants.late.is_empty());
    }

    #[test]
    fn a_late_clock_reads_earlier_times_and_none_outside_the_segment() {
        let instants = Instants::new(vec![0.0, 1.0, 2.0], 2.25, &[0.25, -0.5, 0.0]);
        assert_eq!(instants.times, [0.0, 0.5, 0.75, 1.0, 1.5, 1.75, 2.0, 2.25]);
        assert_eq!(instants.samples, [0, 3, 6]);
        let read = |clock: usize| -> Vec<f64> {
            let places = instants.late[clock].iter();
            places.map(|&place| instants.times[place]).collect()
        };
        assert_eq!(read(0), [0.0, 0.75, 1.75]);
        assert_eq!(read(1), [0.5, 1.5, 2.25]);
        assert_eq!(instants.late[2], instants.samples);
    }
}
