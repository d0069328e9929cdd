//! Whether further sensors read what the motion that the first one measured asks of them.

use crate::diagnose::data::clock_offset::ClockOffset;
use crate::diagnose::data::segment::Segment;
use crate::error::Error;
use crate::measurement::{
    Campaign, DelayBelief, FurtherRecord, FurtherSensor, LEAST_NOISE, Reading, Run, of_one_sensor,
};
use crate::metric::standard_deviation;
use crate::observer::{Smoothed, Structure};
use crate::smoothing::Smoothing;
use std::collections::BTreeMap;

/// Readings that change by this many times what the motion asks for, or by less than its inverse, are of another scale: means of smoothed
/// motions and forces are good to some ten percent.
const OTHER_SCALE: f64 = 2.0;
/// Least correlation of readings that follow the motion: half of their power.
const FOLLOWS: f64 = 0.7;
/// Standard deviation of what is expected or was read, in units of the sensor's noise, from which on one must follow the other, ...
const SEEN: f64 = 10.0;
/// ... and in units of the standard deviation that the smoother gives what is expected: three of these are no chance.
const CLEAR: f64 = 3.0;
/// Means that a correlation needs at least: of ten that have nothing to do with each other one in forty has more than [`FOLLOWS`].
const FEWEST_MEANS: usize = 10;
/// Parts of a period over which motions are averaged.
const PARTS_OF_A_PERIOD: f64 = 8.0;

/// Median standard deviation of what is expected, as far as the smoother tells it.
fn smoothed_std(sensor: &FurtherSensor, smoothed: &Smoothed) -> f64 {
    let mut stds = match sensor.reading {
        Reading::Displacement => smoothed.displacement_std.clone(),
        Reading::Velocity => smoothed.velocity_std.clone(),
        Reading::FrictionForce => smoothed.force_std.clone(),
        Reading::Acceleration => return 0.0,
    };
    stds.sort_by(f64::total_cmp);
    stds.get(stds.len() / 2).copied().unwrap_or(0.0)
}

/// What a sensor would read at the samples of the smoother's grid.
fn expected(sensor: &FurtherSensor, structure: &Structure, smoothed: &Smoothed) -> Vec<f64> {
    let (contact, modal) = match sensor.reading {
        Reading::Displacement => (&smoothed.displacement, &smoothed.q),
        Reading::Velocity => (&smoothed.velocity, &smoothed.q_dot),
        Reading::Acceleration => return smoothed.acceleration.clone(),
        Reading::FrictionForce => return smoothed.force.clone(),
    };
    if sensor.place.is_tip() {
        return contact.clone();
    }
    let ratios = sensor.place.ratios.iter().zip(structure.modes()).zip(modal);
    let at = |k: usize| {
        let parts = ratios.clone();
        parts
            .map(|((ratio, mode), q)| ratio * mode.tip_value * q[k])
            .sum()
    };
    (0..contact.len()).map(at).collect()
}

/// Refuses a campaign in which a further sensor reads something else than what is stated of it. Where none does, remarks on clocks that
/// seem to be off by more than the `delays` that fits look for.
///
/// # Errors
/// [`Error::FurtherSensorContradicts`] with the likely remedy.
pub fn follow_the_motion(
    campaign: &Campaign,
    structure: &Structure,
    smoothings: &[Smoothing],
    delays: &[DelayBelief],
) -> Result<Vec<String>, Error> {
    let mut remarks = Vec::new();
    let sprung = structure.modes().iter().filter(|mode| !mode.is_free());
    let slowest = sprung.map(|mode| 1.0 / mode.frequency_hz).reduce(f64::max);
    for (number, sensor) in campaign.further_sensors.iter().enumerate() {
        let mut of_all: Vec<Looked> = Vec::new();
        let mut clocks: Vec<Option<Clock>> = Vec::new();
        for (run, smoothing) in campaign.runs.iter().zip(smoothings) {
            let Some(record) = run.further.get(number).and_then(Option::as_ref) else {
                continue;
            };
            let expected = expected(sensor, structure, &smoothing.stick_slip.smoothed);
            let records = (record, &expected[..]);
            let looked = Looked::at(run, smoothing, sensor, records, slowest);
            clocks.push(Clock::of(run, smoothing, records));
            if looked.means.len() >= FEWEST_MEANS {
                let runs = format!("run '{}'", run.name);
                looked.verdict(campaign, sensor, runs, &clocks[clocks.len() - 1..])?;
            } else {
                of_all.push(looked);
            }
        }
        // Short runs say enough together.
        let together = Looked {
            least_spread: of_all
                .iter()
                .map(|l| l.least_spread.powi(2))
                .sum::<f64>()
                .sqrt()
                / (of_all.len() as f64).sqrt(),
            means: of_all.into_iter().flat_map(|l| l.means).collect(),
        };
        if together.means.len() >= FEWEST_MEANS {
            together.verdict(campaign, sensor, "all runs".into(), &clocks)?;
        }
        let is_beyond = |late: &f64| late.abs() > delays[number].most;
        if let Some(late) = Clock::agreed(&clocks).filter(is_beyond) {
            remarks.push(format!(
                "'{}' follows the motion better where its times are taken to be {}: if the two clocks were not started together, state \
                 delay_s = {:.4e}.",
                sensor.name,
                apart(late),
                sensor.delay + late
            ));
        }
    }
    Ok(remarks)
}

/// By how much a sensor's clock seems to be late in a run.
struct Clock {
    offset: ClockOffset,
    /// Interval of a sample, s.
    interval: f64,
}

impl Clock {
    fn of(
        run: &Run,
        smoothing: &Smoothing,
        (record, expected): (&FurtherRecord, &[f64]),
    ) -> Option<Self> {
        let interval = run.sample_interval();
        let mut read = vec![f64::NAN; expected.len()];
        for (t, y) in run.time.iter().zip(&record.values) {
            if let Some(slot) = read.get_mut(slot(smoothing, interval, *t)) {
                *slot = *y;
            }
        }
        let offset = ClockOffset::between(&read, expected)?;
        Some(Self { offset, interval })
    }

    /// The offset in s that most of the runs agree on, to a sample; `None` where they do not.
    fn agreed(clocks: &[Option<Clock>]) -> Option<f64> {
        let is_clear = |c: &&Clock| c.offset.is_clear() && c.offset.correlation >= FOLLOWS;
        let clear = clocks.iter().flatten().filter(is_clear);
        let mut late: Vec<(f64, f64)> = clear
            .map(|c| (c.offset.samples * c.interval, c.interval))
            .collect();
        late.sort_by(|a, b| a.0.total_cmp(&b.0));
        let middle = late.get(late.len() / 2)?.0;
        let alike = late
            .iter()
            .filter(|(late, interval)| (late - middle).abs() <= *interval);
        (2 * alike.count() > clocks.len()).then_some(middle)
    }
}

/// Words for times that are later by `late` in s than stated.
fn apart(late: f64) -> String {
    let side = if late < 0.0 { "earlier" } else { "later" };
    format!("{:.4e} s {side} than stated", late.abs())
}

/// The sample of the smoother's grid at a time in s.
fn slot(smoothing: &Smoothing, interval: f64, t: f64) -> usize {
    ((t - smoothing.first_time) / interval).round() as usize
}

/// What was read in a run beside what is expected.
struct Looked {
    /// Means of what is expected and of what was read, each less that of the run.
    means: Vec<(f64, f64)>,
    /// Least standard deviation of what is expected, or of what was read, from which on one must follow the other.
    least_spread: f64,
}

impl Looked {
    fn at(
        run: &Run,
        smoothing: &Smoothing,
        sensor: &FurtherSensor,
        (record, expected): (&FurtherRecord, &[f64]),
        slowest: Option<f64>,
    ) -> Self {
        let smoothed = &smoothing.stick_slip.smoothed;
        let slowest = slowest.unwrap_or_else(|| run.sample_interval());
        // A period that a force is averaged over leaves the balance with the spring's; motions of that period would be gone.
        let over = match sensor.reading {
            Reading::FrictionForce => slowest,
            _ => slowest / PARTS_OF_A_PERIOD,
        };
        let mut means = means(run, smoothing, (&record.values, expected), over);
        let count = means.len() as f64;
        let middle = means
            .iter()
            .fold((0.0, 0.0), |s, m| (s.0 + m.0 / count, s.1 + m.1 / count));
        means
            .iter_mut()
            .for_each(|m| *m = (m.0 - middle.0, m.1 - middle.1));
        Self {
            means,
            least_spread: (SEEN * record.noise_std).max(CLEAR * smoothed_std(sensor, smoothed)),
        }
    }

    fn verdict(
        &self,
        campaign: &Campaign,
        sensor: &FurtherSensor,
        runs: String,
        clocks: &[Option<Clock>],
    ) -> Result<(), Error> {
        let Some((slope, correlation, spread)) = line(&self.means) else {
            return Ok(());
        };
        let remedy = if spread < self.least_spread {
            return Ok(());
        } else if correlation < -FOLLOWS {
            "turn the sign of its scale".to_owned()
        } else if let (true, Some(late)) = (correlation < FOLLOWS, Clock::agreed(clocks)) {
            format!(
                "state the quantity that its column holds, or, as its times seem to be {}, delay_s = {:.4e}",
                apart(late),
                sensor.delay + late
            )
        } else if correlation < FOLLOWS {
            "state the quantity that its column holds, and look whether its clock is that of the first sensor (delay_s)".to_owned()
        } else if !(OTHER_SCALE.recip()..OTHER_SCALE).contains(&slope) {
            "correct its scale, the unit in its header, or its place".to_owned()
        } else {
            return Ok(());
        };
        Err(Error::FurtherSensorContradicts {
            campaign: campaign.folder.clone(),
            runs,
            sensor: sensor.name.clone(),
            slope,
            correlation,
            remedy,
        })
    }
}

/// Standard deviation of what a sensor read in a run.
pub fn spread(record: &FurtherRecord) -> f64 {
    let read = record.values.iter().copied().filter(|y| y.is_finite());
    standard_deviation(&read.collect::<Vec<_>>())
}

/// Which sensors read nothing that varies, in which run.
pub fn silent_sensors(campaign: &Campaign) -> Vec<String> {
    let of_run = |run: &Run| -> Vec<String> {
        let records = campaign.further_sensors.iter().zip(&run.further);
        let silent = records.filter(|(_, record)| record.is_none());
        let said = |name: &str| format!("{}: '{name}' read nothing that varies.", run.name);
        silent.map(|(sensor, _)| said(&sensor.name)).collect()
    };
    campaign.runs.iter().flat_map(of_run).collect()
}

/// Which sensors read something, but nothing that counts in any segment.
pub fn unread_sensors(campaign: &Campaign, segments: &[Segment]) -> Vec<String> {
    let unread = |(number, sensor): (usize, &FurtherSensor)| {
        let parts = segments.iter().flat_map(|s| &s.further);
        let parts: Vec<_> = parts.filter(|part| part.sensor == number).collect();
        let counts = parts.iter().any(|part| part.trusted.iter().any(|&t| t));
        let shortest = parts.iter().map(|part| part.trusted.len()).min()?;
        let left_out = parts.iter().map(|part| part.most_delay).max()?;
        (!counts).then(|| {
            format!(
                "No reading of '{}' counts: of segments of {shortest} samples {left_out} at each end are left out, by which its clock may \
                 be off. State its delay_s, and a smaller delay_std_s.",
                sensor.name
            )
        })
    };
    let sensors = campaign.further_sensors.iter().enumerate();
    sensors.filter_map(unread).collect()
}

/// Gives the records of each sensor the noise that its estimates from all runs agree on, as those of the first sensor ([`of_one_sensor`]).
pub fn agree_on_noise(runs: &mut [Run]) {
    let sensors = runs.iter().map(|run| run.further.len()).max();
    for number in 0..sensors.unwrap_or(0) {
        let records = runs
            .iter_mut()
            .filter_map(|run| run.further.get_mut(number)?.as_mut());
        let mut records: Vec<_> = records.collect();
        let estimates: Vec<f64> = records.iter().map(|record| record.noise_std).collect();
        let mut agreed = of_one_sensor(&estimates);
        if records.iter().any(|record| record.beside_jump > 0.0) {
            // Jumps every few samples are taken for noise, of any size: what the quietest runs agree on holds.
            let least = agreed.iter().copied().fold(f64::INFINITY, f64::min);
            agreed.fill(least);
        }
        let spreads = records.iter().map(|record| spread(record));
        let largest = spreads.fold(0.0, f64::max);
        for (record, noise) in records.iter_mut().zip(agreed) {
            record.noise_std = noise.max(LEAST_NOISE * largest);
        }
    }
}

/// Means of what is expected and of what was read, over samples with a reading, from one `period` in s to the next: what a model
/// without some mode makes of that mode's motion, or a smoother of noise, averages out.
fn means(
    run: &Run,
    smoothing: &Smoothing,
    (read, expected): (&[f64], &[f64]),
    period: f64,
) -> Vec<(f64, f64)> {
    let interval = run.sample_interval();
    let mut sums: BTreeMap<usize, (f64, f64, f64)> = BTreeMap::new();
    for (t, y) in run.time.iter().zip(read) {
        let Some(x) = expected
            .get(slot(smoothing, interval, *t))
            .filter(|x| x.is_finite() && y.is_finite())
        else {
            continue;
        };
        let block = ((t - smoothing.first_time) / period) as usize;
        let sum = sums.entry(block).or_default();
        *sum = (sum.0 + 1.0, sum.1 + x, sum.2 + y);
    }
    sums.values().map(|(n, x, y)| (x / n, y / n)).collect()
}

/// Slope of the second over the first, their correlation, and the larger of their standard deviations; `None` of what does not vary.
fn line(pairs: &[(f64, f64)]) -> Option<(f64, f64, f64)> {
    let count = pairs.len() as f64;
    let (x, y) = pairs
        .iter()
        .fold((0.0, 0.0), |s, p| (s.0 + p.0 / count, s.1 + p.1 / count));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (a, b) in pairs {
        xx += (a - x) * (a - x);
        xy += (a - x) * (b - y);
        yy += (b - y) * (b - y);
    }
    let larger = (xx.max(yy) / count).sqrt();
    (xx > 0.0 && yy > 0.0).then(|| (xy / xx, xy / (xx * yy).sqrt(), larger))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_stated_where_most_runs_agree_on_it() {
        const INTERVAL: f64 = 1e-4;
        let motion = |t: f64| (0.11 * t).sin() + 0.4 * (0.53 * t + 0.2).sin();
        let record = |late: f64| (0..1000).map(|i| motion(f64::from(i) - late)).collect();
        let expected: Vec<f64> = record(0.0);
        let clock = |late: f64| {
            let read: Vec<f64> = record(late);
            let offset = ClockOffset::between(&read, &expected)?;
            Some(Clock {
                offset,
                interval: INTERVAL,
            })
        };
        let late = Clock::agreed(&[clock(9.0), clock(9.2), clock(-3.0)]).unwrap();
        assert!((9e-4 - 1e-5..9.2e-4 + 1e-5).contains(&late), "{late}");
        let none = |clocks: &[Option<Clock>]| assert_eq!(Clock::agreed(clocks), None);
        none(&[clock(9.0), clock(5.0), clock(-3.0)]);
        none(&[clock(9.0), None, None]);
        none(&[clock(0.0), clock(0.0)]);
        none(&[]);
    }

    #[test]
    fn a_line_has_its_slope_and_noise_lowers_its_correlation() {
        let exact: Vec<(f64, f64)> = (0..100)
            .map(|i| (f64::from(i), 3.0 - 2.0 * f64::from(i)))
            .collect();
        let (slope, correlation, spread) = line(&exact).unwrap();
        assert!((slope + 2.0).abs() < 1e-12 && (correlation + 1.0).abs() < 1e-12);
        assert!((spread - 57.732).abs() < 1e-3, "{spread}");
        let other: Vec<(f64, f64)> = (0..100).map(|i| (f64::from(i), f64::from(i % 2))).collect();
        assert!(line(&other).unwrap().1.abs() < 0.1);
        assert!(line(&[(1.0, 2.0), (1.0, 3.0)]).is_none());
    }
}
