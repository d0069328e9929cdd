//! One run: the model at its operating point, aligned, with the metrics of both.

use serde::Serialize;

use super::driven_motion::driven_motions;
use super::follow::follow;
use super::from_start_states::{Held, nrmse, settings};
use super::further::{Further, FurtherComparison};
use super::model_motion::{Lead, model_motions};
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::{BeamKnowledge, Measurand, NoiseStd, Run};
use crate::metric::{
    Characteristics, Cycle, Spectrum, StickDetection, characteristics, mean_cycle, resample,
    spectrum, stick_of, whole_cycles,
};
use crate::watch::Watch;

/// Phases of the averaged cycle.
const PHASES: usize = 240;
/// Model and measurement of one run. Only the numbers go to JSON.
#[derive(Debug, Clone, Serialize)]
pub struct RunComparison {
    /// The run's name.
    pub name: String,
    /// Belt velocity, m/s.
    pub belt_velocity_m_per_s: f64,
    /// Normal force, N.
    pub normal_force_n: f64,
    /// Error of the model, each measured cycle against the most similar of the model's, 1.
    pub nrmse: f64,
    /// Error over short pieces of the run, each from a start state that the FMU holds for it
    /// ([`super::from_start_states`]); only FMUs that `diagnose` and `try` wrote from this record hold any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nrmse_from_start_states: Option<f64>,
    /// The NRMSE that a perfect model would have: noise over motion, 1.
    pub noise_floor: f64,
    /// Estimated noise.
    #[serde(flatten)]
    pub noise_std: NoiseStd,
    /// The measurement's metrics, SI units.
    pub measured: Characteristics,
    /// The model's metrics, SI units.
    pub model: Characteristics,
    /// Remarks on the data.
    pub remarks: Vec<String>,
    /// What further sensors read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub further_sensors: Vec<FurtherComparison>,
    /// The curves for the report.
    #[serde(skip)]
    pub curves: Curves,
}

impl RunComparison {
    /// Whether the run fails a gate; a run that cannot be scored does.
    pub fn exceeds(&self, limit: f64) -> bool {
        self.nrmse.is_nan() || self.nrmse > limit
    }
}

/// Curves of one run for the pictures, SI units.
#[derive(Debug, Clone)]
pub struct Curves {
    /// Sample times, s.
    pub time: Vec<f64>,
    /// What was measured.
    pub measurand: Measurand,
    /// Where, in words.
    pub place: &'static str,
    /// Its values, m or m/s.
    pub measured: Vec<f64>,
    /// Measured minus aligned model, m or m/s.
    pub residual: Vec<f64>,
    /// Stick and velocity of the measurement.
    pub measured_stick: StickDetection,
    /// The model at the same times, aligned: what was measured, m or m/s, ...
    pub model: Vec<f64>,
    /// ... and its velocity, m/s, beside a displacement, or its displacement, m, beside a velocity (NaN where two motions meet).
    pub model_other: Vec<f64>,
    /// Averaged cycles of the measurement and of the aligned model over the same times; `None` without cycles.
    pub cycles: Option<(Cycle, Cycle)>,
    /// For each phase of the measured cycle, whether it sticks in most cycles.
    pub cycle_sticks: Vec<bool>,
    /// Amplitude spectra, m or m/s.
    pub spectra: (Spectrum, Spectrum),
}

/// Runs the FMU at a run's operating point and compares; with the run's own parameters and start states where it holds them,
/// and with start values `given` before all.
pub(super) fn compare_run(
    fmu: &Fmu,
    beam: &BeamKnowledge,
    (run, further): (&Run, &Further),
    (held, given): (&Held, &[(String, f64)]),
    watch: &dyn Watch,
) -> Result<RunComparison, Error> {
    let set = held.of(run);
    let mut settings = settings(set);
    settings.extend_from_slice(given);
    let interval = run.sample_interval();
    let noise = run.noise.std;
    let time: Vec<f64> = run.time.iter().map(|t| t - run.time[0]).collect();
    let belt_velocity = beam.sensor.seen(run.belt_velocity);
    let measured = characteristics(&time, (run.measurand, &run.measured), belt_velocity, noise);
    // A motion with its place in time is not shifted to fit.
    let period = measured.period.filter(|_| run.sustains_itself());

    let lead = period.map_or(Lead::default(), |p| Lead::of(p, run.duration(), interval));
    let half = |second| Half { watch, second };
    let motions = if run.sustains_itself() {
        model_motions(fmu, beam, (run, further), lead, &settings, &half(false))?
    } else {
        driven_motions(fmu, beam, (run, further), &settings)?
    };
    let follower = follow(&time, run, &motions, period, &half(true))?;
    let measured_stick = stick_of(&time, (run.measurand, &run.measured), belt_velocity, noise);
    // The follower has the measured period by construction; what the model does by itself counts.
    let model = Characteristics {
        period: follower.own_period.map(|p| p.seconds),
        regularity: follower.own_period.map(|p| p.regularity),
        ..characteristics(
            &time,
            (run.measurand, &follower.measured),
            belt_velocity,
            0.0,
        )
    };
    let even = |values: &[f64]| spectrum(&resample(&time, values, interval), interval);
    let whole = period
        .map(|p| whole_cycles(&time, &run.measured, p))
        .unwrap_or_default();
    let average = |values: &[f64]| mean_cycle(&time, values, &whole, PHASES);
    let flags: Vec<f64> = measured_stick
        .sticks
        .iter()
        .map(|s| f64::from(u8::from(*s)))
        .collect();
    let further_sensors = further.compare(run, follower.further, &measured_stick.sticks);
    let curves = Curves {
        cycle_sticks: average(&flags)
            .map(|c| c.mean.iter().map(|share| *share > 0.5).collect())
            .unwrap_or_default(),
        cycles: average(&run.measured).zip(average(&follower.measured)),
        spectra: (even(&run.measured), even(&follower.measured)),
        measured: run.measured.clone(),
        measured_stick,
        measurand: run.measurand,
        place: beam.sensor.name(),
        model: follower.measured,
        model_other: follower.other,
        residual: follower.residual,
        time,
    };
    Ok(RunComparison {
        name: run.name.clone(),
        belt_velocity_m_per_s: run.belt_velocity,
        normal_force_n: run.normal_force,
        nrmse: follower.nrmse,
        nrmse_from_start_states: set.map(|s| nrmse(fmu, run, s)).transpose()?,
        noise_floor: noise / spread(&run.measured),
        noise_std: NoiseStd::of(run.measurand, noise),
        measured,
        model,
        remarks: remarks(run),
        further_sensors,
        curves,
    })
}

/// Half of the work on a run.
struct Half<'a> {
    watch: &'a dyn Watch,
    second: bool,
}

impl Watch for Half<'_> {
    fn step(&self, what: &str, done: usize, of: usize) {
        self.watch
            .step(what, done + if self.second { of } else { 0 }, 2 * of);
    }
    fn stop(&self) -> bool {
        self.watch.stop()
    }
}

/// Standard deviation.
pub(super) fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn remarks(run: &Run) -> Vec<String> {
    let mut remarks: Vec<String> = run
        .inputs
        .series()
        .map(|(name, series)| {
            let (column, between) = (&series.column, series.between.interpolation().words());
            format!("{name} from column '{column}', {between}")
        })
        .collect();
    if !run.sustains_itself() {
        remarks.push("compared sample by sample from its start".to_owned());
    }
    let missing: usize = run.sampling.gaps.iter().map(|g| g.missing).sum();
    if missing > 0 {
        remarks.push(format!(
            "{missing} samples missing in {} gaps",
            run.sampling.gaps.len()
        ));
    }
    if run.sampling.jitter > 0.01 {
        remarks.push(format!(
            "sample intervals scatter by {:.1} %",
            100.0 * run.sampling.jitter
        ));
    }
    if !run.faults.is_empty() {
        let samples: usize = run.faults.iter().map(|f| f.samples).sum();
        remarks.push(format!(
            "{samples} samples clipped or held in {} places",
            run.faults.len()
        ));
    }
    remarks
}
