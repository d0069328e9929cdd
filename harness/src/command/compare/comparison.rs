//! One run: the model at its operating point, aligned, with the metrics of both.

use serde::Serialize;

use crate::command::operating_point::{OperatingPoint, record};
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::{BeamKnowledge, Run};
use crate::metric::{
    Characteristics, Cycle, ModelMotion, Spectrum, StickDetection, aligned_residual,
    characteristics, cycle_starts, detect_stick, mean_cycle, nrmse, quantile, resample, spectrum,
    velocity,
};

/// Phases of the averaged cycle.
const PHASES: usize = 240;
/// The model runs at least this many measured periods, and this share of the record, before it is compared: long enough
/// to forget that its start state is known in the first mode only.
const SETTLE_PERIODS: f64 = 20.0;
const SETTLE_SHARE: f64 = 0.5;
/// The model can be shifted by this many periods either way to fit the record.
const SHIFT_PERIODS: f64 = 4.0;
/// Samples for the parabola that gives the velocity at the start.
const START_HALF_WIDTH: usize = 5;

/// Model and measurement of one run. Only the numbers go to JSON.
#[derive(Debug, Clone, Serialize)]
pub struct RunComparison {
    /// The run's name.
    pub name: String,
    /// Belt velocity, m/s.
    pub belt_velocity_m_per_s: f64,
    /// Normal force, N.
    pub normal_force_n: f64,
    /// Error of the model after alignment cycle by cycle, 1.
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
    /// Model displacement, m, and velocity, m/s, settled, as long as the record.
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

    // What lies before time 0 of the record is for settling, and then for shifting the model.
    let settle = period.map_or(0.0, |p| {
        (SETTLE_PERIODS * p).max(SETTLE_SHARE * run.duration())
    });
    let settle_steps = (settle / interval).round() as usize;
    let shift_steps = period.map_or(0, |p| (SHIFT_PERIODS * p / interval).round() as usize);
    let steps = settle_steps + 2 * shift_steps + (run.duration() / interval).ceil() as usize + 2;
    let model_runs = starts(fmu, beam, run).into_iter().map(|point| {
        let recorded = model_run(fmu, &run.name, &point, interval, steps)?;
        let motion = ModelMotion {
            start: -(shift_steps as f64) * interval,
            interval,
            values: &recorded.0[settle_steps..],
        };
        let aligned = match period {
            Some(period) => {
                let aligned = aligned_residual(&time, &run.displacement, &motion, period);
                (aligned.nrmse, aligned.residual)
            }
            // Without a cycle there is nothing to align: both start from the same state.
            None => plain_residual(&time, &run.displacement, &motion),
        };
        Ok((aligned, recorded))
    });
    let model_runs = model_runs.collect::<Result<Vec<_>, Error>>()?;
    let best = model_runs
        .into_iter()
        .min_by(|a, b| a.0.0.total_cmp(&b.0.0));
    let ((aligned_nrmse, residual), (displacement, tip_velocity)) =
        best.expect("there is at least one start state");

    let first = settle_steps + shift_steps;
    let settled = first..(first + time.len()).min(displacement.len());
    let (model, model_velocity) = (
        displacement[settled.clone()].to_vec(),
        tip_velocity[settled].to_vec(),
    );
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

/// Start states to try: the measured one, and a grid up to the farthest bend and to the belt's velocity.
///
/// Several attractors coexist over wide ranges, large stick-slip cycles and a small one near the second mode, and a start
/// state known at the tip only may lead to any of them. The motion that fits the measurement best is compared: what the
/// model can do is judged, not the luck of its start.
fn starts(fmu: &Fmu, beam: &BeamKnowledge, run: &Run) -> Vec<OperatingPoint> {
    let ends = 2 * START_HALF_WIDTH;
    let measured_velocity = velocity(
        &run.time[..ends],
        &run.displacement[..ends],
        START_HALF_WIDTH,
    )[0];
    let farthest = quantile(
        &run.displacement,
        if run.belt_velocity < 0.0 {
            0.005
        } else {
            0.995
        },
    );
    let bends = [0.0, 0.5, 0.8, 1.0];
    let speeds = [0.0, 0.5, 1.0];
    let grid = bends.iter().flat_map(|bend| {
        speeds
            .iter()
            .map(move |speed| (bend * farthest, speed * run.belt_velocity))
    });
    let states = std::iter::once((run.displacement[0], measured_velocity)).chain(grid);
    let point = OperatingPoint::of_beam(fmu, beam, run.belt_velocity, run.normal_force);
    states
        .into_iter()
        .map(|(w, v)| point.clone().starting_at(fmu, w, v))
        .collect()
}

/// Displacement (m) as measured, and velocity (m/s), of the tip.
fn model_run(
    fmu: &Fmu,
    name: &str,
    point: &OperatingPoint,
    interval: f64,
    steps: usize,
) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let mut instance = fmu.instantiate(name)?;
    point.start(fmu, &mut instance)?;
    let has_sensor = fmu.description().find("measured_displacement").is_some();
    let displacement = if has_sensor {
        "measured_displacement"
    } else {
        "tip_displacement"
    };
    let recorded = record(
        fmu,
        &mut instance,
        &[displacement, "tip_velocity"],
        interval,
        steps,
    )?;
    let [displacement, velocity] =
        <[Vec<f64>; 2]>::try_from(recorded.values).expect("two outputs were asked for");
    Ok((displacement, velocity))
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

type Motion<'a> = (&'a [f64], &'a [f64], Option<f64>);

fn cycles(measured: Motion, model: Motion) -> Option<(Cycle, Cycle)> {
    let average = |(time, values, period): Motion| {
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
