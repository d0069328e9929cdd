//! Times at which the model is read over a segment: at the samples, and for each further sensor when these are by its clock.

/// Times in s nearer than this are the same: rounding of times of some thousand seconds is smaller.
const SAME: f64 = 1e-12;

/// Change of a delay in s over which derivatives by it are taken: a motion of 1 kHz is straight over it to a thousandth.
pub(super) const DELAY_STEP: f64 = 1e-7;

/// Times of a prediction, and which of them each sensor reads.
pub(super) struct Instants {
    /// Times in s, increasing.
    pub times: Vec<f64>,
    /// Place among them of each sample.
    pub samples: Vec<usize>,
    /// For each clock the places of the times at which it reads the samples.
    pub late: Vec<Vec<usize>>,
    /// The same of a clock that is late by [`DELAY_STEP`] more, where derivatives by a delay are asked for.
    pub later: Vec<Vec<usize>>,
}

impl Instants {
    /// Times of `samples` in s, increasing, and for clocks that are `late` by so many s: such a clock reads at `t - late`, not before the
    /// first sample nor after `end`.
    pub fn new(samples: &[f64], end: f64, late: &[f64], with_later: bool) -> Self {
        if late.is_empty() {
            return Self {
                times: samples.to_vec(),
                samples: (0..samples.len()).collect(),
                late: Vec::new(),
                later: Vec::new(),
            };
        }
        let begin = samples.first().copied().unwrap_or(end);
        let of_clock = |late: f64| -> Vec<f64> {
            let read = samples.iter().map(|t| (t - late).clamp(begin, end));
            read.collect()
        };
        let of_clocks = |more: f64| -> Vec<Vec<f64>> {
            late.iter().map(|late| of_clock(late + more)).collect()
        };
        let later = match with_later {
            true => of_clocks(DELAY_STEP),
            false => Vec::new(),
        };
        let late = of_clocks(0.0);
        let mut times = samples.to_vec();
        times.extend(late.iter().chain(&later).flatten());
        times.sort_by(f64::total_cmp);
        times.dedup_by(|next, time| *next - *time <= SAME);
        let place = |t: &f64| times.partition_point(|time| *time < t - SAME);
        let places = |list: &Vec<f64>| list.iter().map(place).collect();
        Self {
            samples: samples.iter().map(place).collect(),
            late: late.iter().map(places).collect(),
            later: later.iter().map(places).collect(),
            times,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_clocks_times_are_those_of_the_samples() {
        let samples = vec![0.1, 0.2, 0.35];
        let instants = Instants::new(&samples, 0.35, &[], false);
        assert_eq!(instants.times, samples);
        assert_eq!(instants.samples, [0, 1, 2]);
        assert!(instants.late.is_empty());
    }

    #[test]
    fn a_late_clock_reads_earlier_times_and_none_outside_the_segment() {
        let instants = Instants::new(&[0.0, 1.0, 2.0], 2.25, &[0.25, -0.5, 0.0], false);
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

    #[test]
    fn derivatives_by_a_delay_read_a_little_earlier_still() {
        let instants = Instants::new(&[0.0, 1.0], 1.0, &[0.25], true);
        let at = |places: &[usize]| -> Vec<f64> {
            places.iter().map(|&place| instants.times[place]).collect()
        };
        assert_eq!(at(&instants.late[0]), [0.0, 0.75]);
        assert_eq!(at(&instants.later[0]), [0.0, 1.0 - (0.25 + DELAY_STEP)]);
        assert_eq!(at(&instants.samples), [0.0, 1.0]);
    }
}
