//! One measured run.

use super::faults::Fault;
use super::further_sensor::FurtherRecord;
use super::inputs::InputSignals;
use super::measurand::Measurand;
use super::noise::Noise;
use super::sampling::Sampling;
use std::path::PathBuf;

/// What a run is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Parameters may be fitted to it.
    Fit,
    /// It only checks.
    Holdout,
}

/// One measured run at one operating point.
#[derive(Debug, Clone)]
pub struct Run {
    /// Its name: the file's, without suffix, unless campaign.toml gives one.
    pub name: String,
    /// The CSV file.
    pub file: PathBuf,
    /// Files of further sensors with clocks of their own.
    pub further_files: Vec<PathBuf>,
    /// Its role, where campaign.toml gives one.
    pub role: Option<Role>,
    /// Belt velocity, m/s; any sign. The mean, where it varies.
    pub belt_velocity: f64,
    /// Normal force, N; never negative. The mean, where it varies.
    pub normal_force: f64,
    /// What varies in time, and external forces.
    pub inputs: InputSignals,
    /// Sample times, s; strictly increasing.
    pub time: Vec<f64>,
    /// What was measured at the tip.
    pub measurand: Measurand,
    /// Its values, in the measurand's SI unit; as long as `time`.
    pub measured: Vec<f64>,
    /// What each of the campaign's further sensors read; `None` where one read nothing.
    pub further: Vec<Option<FurtherRecord>>,
    /// How evenly it was sampled, and what is missing.
    pub sampling: Sampling,
    /// How noisy it is.
    pub noise: Noise,
    /// Samples that look clipped or held by the recorder.
    pub faults: Vec<Fault>,
    /// How the file was read, where it is not plain comma-separated values in SI units.
    pub understood: Option<String>,
}

impl Run {
    /// Typical sample interval, s.
    pub fn sample_interval(&self) -> f64 {
        self.sampling.interval
    }

    /// Last time minus first, s.
    pub fn duration(&self) -> f64 {
        self.time[self.time.len() - 1] - self.time[0]
    }

    /// Its first samples, at most so many; faults that reach beyond them are left out.
    pub fn beginning(&self, samples: usize) -> Run {
        if samples >= self.time.len() {
            return self.clone();
        }
        let is_within = |fault: &&Fault| fault.first + fault.samples <= samples;
        Run {
            name: self.name.clone(),
            file: self.file.clone(),
            further_files: self.further_files.clone(),
            inputs: self.inputs.beginning(samples),
            time: self.time[..samples].to_vec(),
            measured: self.measured[..samples].to_vec(),
            further: self
                .further
                .iter()
                .map(|record| record.as_ref().map(|r| r.beginning(samples)))
                .collect(),
            sampling: Sampling::of(&self.time[..samples]),
            faults: self.faults.iter().filter(is_within).cloned().collect(),
            understood: self.understood.clone(),
            ..*self
        }
    }

    /// The same with what is measured, and its noise, over `share`.
    pub fn over(&self, share: f64) -> Run {
        let mut run = self.clone();
        run.measured.iter_mut().for_each(|y| *y /= share);
        run.noise.std /= share.abs();
        run
    }

    /// For each sample, whether it can be trusted (not clipped, not held).
    pub fn trusted(&self) -> Vec<bool> {
        let mut trusted = vec![true; self.time.len()];
        for fault in &self.faults {
            trusted[fault.first..fault.first + fault.samples].fill(false);
        }
        trusted
    }
}
