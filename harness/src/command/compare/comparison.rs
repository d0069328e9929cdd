//! One run: the model at its operating point, aligned, with the metrics of both.

use serde::Serialize;

use super::model_motion::{Lead, Piece, model_motions};
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::{BeamKnowledge, Run};
use crate::metric::{
    Characteristics, Cycle, ModelMotion, Spectrum, StickDetection, aligned_residual, amplitude,
    characteristics, cycle_starts, detect_stick, mean_cycle, nrmse, resample, spectrum,
};

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
    /// The NRMSE that a perfect model would have: noise over motion, 1.
    pub noise_floor: f64,
    /// Estimated noise, m.
    pub noise_std_m: f64,
    /// The measurement's metrics, SI units.
    pub measured: Characteristics,
    /// The model's metrics, SI units.
    pub model: Characteristics,
    /// Remarks on the data.
    pub remarks: Vec<String>,
    /// The curves for the report.
    #[serde(skip)]
    pub curves: Curves,
}

/// Curves of one run for the pictures, SI units.
#[derive(Debug, Clone)]
pub struct Curves {
    /// Sample times, s.
    pub time: Vec<f64>,
    /// Measured displacement, m.
    pub measured: Vec<f64>,
    /// Measured minus aligned model, m.
    pub residual: Vec<f64>,
    /// Stick and velocity of the measurement.
    pub measured_stick: StickDetection,
    /// Model displacement, m, and velocity, m/s, as long as the record.
    pub model: (Vec<f64>, Vec<f64>),
    /// Averaged cycles, the model's turned to fit; `None` without cycles.
    pub cycles: Option<(Cycle, Cycle)>,
    /// For each phase of the measured cycle, whether it sticks in most cycles.
    pub cycle_sticks: Vec<bool>,
    /// Amplitude spectra, m.
    pub spectra: (Spectrum, Spectrum),
}

/// Runs the FMU at a run's operating point and compares.
pub fn compare_run(fmu: &Fmu, beam: &BeamKnowledge, run: &Run) -> Result<RunComparison, Error> {
    let interval = run.sample_interval();
    let noise = run.noise.std;
    let time: Vec<f64> = run.time.iter().map(|t| t - run.time[0]).collect();
    let measured = characteristics(&time, &run.displacement, run.belt_velocity, noise);
    let period = measured.period;

    let lead = period.map_or(Lead::default(), |p| Lead::of(p, run.duration(), interval));
    let motions = model_motions(fmu, beam, run, lead)?;
    let pieces = Piece::all(&motions, lead);
    let (aligned_nrmse, residual, shown) = match period {
        Some(period) => {
            let views: Vec<ModelMotion> = pieces.iter().map(|p| p.view(interval)).collect();
            let aligned = aligned_residual(&time, &run.displacement, &views, period);
            let used = pieces
                .iter()
                .enumerate()
                .filter(|(k, _)| aligned.fits.iter().any(|f| f.0 == *k))
                .map(|(_, p)| *p);
            let off =
                |p: &Piece| (amplitude(p.over_record(time.len()).0) - measured.amplitude).abs();
            let nearest = used.min_by(|a, b| off(a).total_cmp(&off(b)));
            (
                aligned.nrmse,
                aligned.residual,
                nearest.unwrap_or(pieces[0]),
            )
        }
        // Without a cycle there is nothing to align: the first motion starts from the measured state.
        None => {
            let (error, residual) =
                plain_residual(&time, &run.displacement, &pieces[0].view(interval));
            (error, residual, pieces[0])
        }
    };
    let (model, model_velocity) = shown.over_record(time.len());
    let (model, model_velocity) = (model.to_vec(), model_velocity.to_vec());
    let model_time: Vec<f64> = (0..model.len()).map(|i| i as f64 * interval).collect();
    let measured_stick = detect_stick(&time, &run.displacement, run.belt_velocity, noise);
    let model_metrics = characteristics(&model_time, &model, run.belt_velocity, 0.0);
    let cycles = cycles(
        (&time, &run.displacement, measured.period),
        (&model_time, &model, model_metrics.period),
    );
    let curves = Curves {
        cycle_sticks: cycle_sticks(&time, &run.displacement, &measured_stick, measured.period),
        spectra: (
            spectrum(&resample(&time, &run.displacement, interval), interval),
            spectrum(&model, interval),
        ),
        residual,
        measured_stick,
        model: (model, model_velocity),
        cycles,
        measured: run.displacement.clone(),
        time,
    };
    Ok(RunComparison {
        name: run.name.clone(),
        belt_velocity_m_per_s: run.belt_velocity,
        normal_force_n: run.normal_force,
        nrmse: aligned_nrmse,
        noise_floor: noise / spread(&run.displacement),
        noise_std_m: noise,
        measured,
        model: model_metrics,
        remarks: remarks(run),
        curves,
    })
}

fn plain_residual(time: &[f64], measured: &[f64], motion: &ModelMotion) -> (f64, Vec<f64>) {
    let model: Vec<f64> = time.iter().map(|t| motion.at(*t)).collect();
    let residual = measured.iter().zip(&model).map(|(m, y)| m - y).collect();
    (nrmse(measured, &model), residual)
}

fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

type Signal<'a> = (&'a [f64], &'a [f64], Option<f64>);

fn cycles(measured: Signal, model: Signal) -> Option<(Cycle, Cycle)> {
    let average = |(time, values, period): Signal| {
        mean_cycle(time, values, &cycle_starts(time, values, period?), PHASES)
    };
    let (measured, model) = (average(measured)?, average(model)?);
    let model = model.turned_to(&measured);
    Some((measured, model))
}

fn cycle_sticks(
    time: &[f64],
    values: &[f64],
    stick: &StickDetection,
    period: Option<f64>,
) -> Vec<bool> {
    let flags: Vec<f64> = stick
        .sticks
        .iter()
        .map(|s| f64::from(u8::from(*s)))
        .collect();
    let starts = period
        .map(|p| cycle_starts(time, values, p))
        .unwrap_or_default();
    mean_cycle(time, &flags, &starts, PHASES)
        .map(|c| c.mean.iter().map(|share| *share > 0.5).collect())
        .unwrap_or_default()
}

fn remarks(run: &Run) -> Vec<String> {
    let mut remarks = Vec::new();
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
