//! What the recorder did: constant and clipped channels, slow or uneven sampling, gaps, drift.

use super::examined::Examined;
use super::finding::{Finding, Severity, digits};
use super::thresholds::{
    CLIPPED_ERROR, DRIFT, FAULTY_WARNING, JITTER, LINE_NOISE, MISSING, NO_MOTION,
    SAMPLES_PER_FASTEST, SAMPLES_PER_PERIOD,
};
use crate::measurement::{BeamKnowledge, FaultKind, Measurand, Run};
use crate::metric::amplitude;

/// Whether a run's samples are even and none is missing, so that it has a spectrum.
pub fn is_even(run: &Run) -> bool {
    run.sampling.gaps.is_empty() && run.sampling.jitter < JITTER
}

/// Median amplitude that a run's noise has in a line of its spectrum, in the unit of what was measured.
pub fn line_noise(run: &Run) -> f64 {
    LINE_NOISE * run.noise.std / (run.measured.len() as f64).sqrt()
}

/// Findings on one run; `timed` tells whether its times can be trusted.
pub fn signal(run: &Examined, beam: &BeamKnowledge, timed: bool) -> Vec<Finding> {
    let mut found = Vec::new();
    let (motion, record) = (&run.motion, run.run);
    let mut say = |severity, id, measured: String, stated: String, remedy: &str| {
        let texts = (measured, stated, remedy.to_owned());
        found.push(Finding::of(severity, id, &record.name, texts));
    };
    let (quantity, unit) = (record.measurand.name(), record.measurand.unit());
    let first = record.measured[0];
    if record.measured.iter().all(|value| *value == first) {
        say(
            Severity::Error,
            if first == 0.0 { "zero" } else { "constant" },
            format!(
                "all {} samples are {} {unit}",
                record.measured.len(),
                digits(first)
            ),
            format!("a tip {quantity}"),
            &format!(
                "the channel is dead or another one: check the sensor, or name the right column with {}",
                record.measurand.column_key()
            ),
        );
        return found;
    }
    if motion.std < NO_MOTION * record.noise.std {
        say(
            Severity::Warning,
            "no_motion",
            format!(
                "a standard deviation of {} {unit}, {:.1} times the noise",
                digits(motion.std),
                motion.std / record.noise.std
            ),
            "a motion".into(),
            "leave the run out, or check that the sensor looks at the tip",
        );
    }
    let share = |kind: FaultKind| {
        let samples = record.faults.iter().filter(|f| f.kind == kind);
        samples.map(|f| f.samples).sum::<usize>() as f64 / record.measured.len() as f64
    };
    let faults = [
        (FaultKind::Clipped, "clipped", "at the end of the range"),
        (FaultKind::Held, "held", "equal to the one before"),
    ];
    for (kind, id, what) in faults {
        let share = share(kind);
        let severity = if kind == FaultKind::Clipped && share > CLIPPED_ERROR {
            Severity::Error
        } else {
            Severity::Warning
        };
        if share > FAULTY_WARNING {
            say(
                severity,
                id,
                format!("{:.1} % of the samples are {what}", 100.0 * share),
                "a motion within the range of the sensor".into(),
                match severity {
                    Severity::Error => {
                        "measure again with a larger range of sensor and recorder; with --force they are left out"
                    }
                    Severity::Warning => {
                        "they are left out; measure again with a larger range of sensor and recorder"
                    }
                },
            );
        }
    }
    let rate = 1.0 / record.sample_interval();
    if let Some(lowest) = run.lowest.filter(|_| timed) {
        let fastest = beam
            .natural_frequencies_hz
            .iter()
            .copied()
            .fold(lowest, f64::max);
        let too_slow = rate < SAMPLES_PER_PERIOD * lowest;
        if too_slow || rate < SAMPLES_PER_FASTEST * fastest {
            let (severity, frequency) = if too_slow {
                (Severity::Error, lowest)
            } else {
                (Severity::Warning, fastest)
            };
            say(
                severity,
                "slow_sampling",
                format!(
                    "{} samples per second, {:.1} in a period of {} Hz",
                    digits(rate),
                    rate / frequency,
                    digits(frequency)
                ),
                format!("natural_frequencies_hz = {:?}", beam.natural_frequencies_hz),
                "sample ten times in a period of the highest mode stated, or check time_scale",
            );
        }
    }
    let sampling = &record.sampling;
    if sampling.jitter > JITTER {
        say(
            Severity::Warning,
            "jitter",
            format!(
                "sample intervals scatter by {:.0} %",
                100.0 * sampling.jitter
            ),
            format!("{} s from sample to sample", digits(sampling.interval)),
            "let the recorder's clock give the times; the noise is overestimated otherwise",
        );
    }
    let missing: usize = sampling.gaps.iter().map(|gap| gap.missing).sum();
    let share = missing as f64 / (missing + record.time.len()) as f64;
    if share > MISSING {
        say(
            Severity::Warning,
            "missing_samples",
            format!("{:.0} % of the samples are missing", 100.0 * share),
            format!("{} s from sample to sample", digits(sampling.interval)),
            "pieces without gaps are used; measure again if these are short",
        );
    }
    let range = match record.measurand {
        Measurand::Displacement => motion.range,
        Measurand::Velocity => 2.0 * motion.fastest,
        Measurand::Acceleration => 2.0 * amplitude(&record.measured),
    };
    // A mass without a spring has no place that it returns to.
    let returns = beam.natural_frequencies_hz.iter().all(|f| *f > 0.0);
    if returns && motion.trend.abs() > DRIFT * range {
        say(
            Severity::Warning,
            "drift",
            format!(
                "the {quantity} rises by {} {unit} over the run, of a range of {} {unit}",
                digits(motion.trend),
                digits(range)
            ),
            "a motion about a mean that stays".into(),
            "let sensor and rig warm up, or take the trend off the column",
        );
    }
    found
}
