//! Effects that repeat: what with, and at which lines of a spectrum.

use crate::fmu::effect_card::{EffectCard, Role};
use std::sync::Mutex;

/// A line in the spectrum: where to start a fit.
#[derive(Debug, Clone)]
pub struct Line {
    /// Frequency in Hz, or wavelength in m.
    pub value: f64,
    /// Amplitude in the effect's unit.
    pub amplitude: f64,
    /// Phase in rad of each run.
    pub phase: Vec<f64>,
    /// Expected fall of the objective.
    pub gain: f64,
}

/// What varies: time at a frequency or place at a wavelength.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Argument {
    /// Time in s, at a frequency in Hz.
    Time,
    /// Belt travel in m, at a wavelength in m.
    Travel,
}

/// What a periodic effect repeats with.
pub fn argument(effect: &EffectCard) -> Option<Argument> {
    let (_, shape) = periodic(effect)?;
    Some(if effect.parameters[shape].unit == "Hz" {
        Argument::Time
    } else {
        Argument::Travel
    })
}

/// Indices of amplitude and frequency or wavelength, if the effect is periodic.
pub fn periodic(effect: &EffectCard) -> Option<(usize, usize)> {
    effect.find_role(Role::Phase)?;
    Some((
        effect.find_role(Role::Amplitude)?,
        effect.find_role(Role::Shape)?,
    ))
}

/// What was asked of [`lines`]: argument, range and number of lines.
pub type Question = (Argument, (f64, f64), usize);

/// Lines found before: they are the same for every candidate of a problem.
#[derive(Debug, Default)]
pub struct Spectra(pub Mutex<Vec<(Question, Vec<Line>)>>);
