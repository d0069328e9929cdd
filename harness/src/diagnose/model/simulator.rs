//! What a fit asks of a model: the displacement over a segment, and its derivatives.

use crate::diagnose::data::segment::Segment;
use crate::error::Error;

/// Deviation from the measurement, relative to the run's amplitude, at which a prediction is given up.
pub const RUNAWAY: f64 = 5.0;

/// One thing that can be turned in a segment.
#[derive(Debug, Clone, Copy)]
pub enum Turn {
    /// A component of its start state.
    State(usize),
    /// A shared parameter.
    Shared(usize),
    /// One of its run's own parameters.
    PerRun(usize),
}

/// Where a segment starts, besides its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentStart {
    /// Modal states, then deviations of the effects' states.
    pub state: Vec<f64>,
    /// Whether it starts in stick.
    pub stuck: bool,
}

/// All that the prediction of a segment depends on.
#[derive(Debug, Clone, Copy)]
pub struct SegmentValues<'v> {
    /// Positions of the shared parameters.
    pub shared: &'v [f64],
    /// Positions of the run's own parameters.
    pub per_run: &'v [f64],
    /// Start state.
    pub state: &'v [f64],
    /// Whether it starts in stick.
    pub stuck: bool,
}

/// Which samples of a segment are predicted: every `stride`-th from the first, `count` of them.
#[derive(Debug, Clone, Copy)]
pub struct Samples {
    /// Number of samples predicted.
    pub count: usize,
    /// Samples of the segment from one to the next.
    pub stride: usize,
    /// Whether what further sensors read is predicted too.
    pub further: bool,
}

impl Samples {
    /// Every `stride`-th of the first `used` samples of a segment.
    pub fn of(used: usize, stride: usize) -> Self {
        Self {
            count: used.div_ceil(stride),
            stride,
            further: false,
        }
    }

    /// The same of all sensors.
    pub fn of_all_sensors(self) -> Self {
        Self {
            further: true,
            ..self
        }
    }

    /// Every sample of a segment.
    pub fn all(segment: &Segment) -> Self {
        Self::of(segment.time.len(), 1)
    }
}

/// A model that predicts segments. The FMU is one ([`super::predictor::Predictor`]); the estimation knows no other side of it.
pub trait Simulator {
    /// Writes what is predicted to be measured, in m or m/s, at the samples asked for, and, where they are asked for, what the segment's
    /// further sensors read at the same samples, one after another; `false` if the motion ran away from the measurement and was given up,
    /// after the samples written.
    ///
    /// # Errors
    /// Values that the model refuses, or a motion that it can't follow.
    fn predict(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        samples: Samples,
        out: &mut Vec<f64>,
    ) -> Result<bool, Error>;

    /// Derivatives of what [`Self::predict`] writes by each of `turns`, one after another in `slopes`; `false`
    /// where the model does not offer them or can't follow the motion: they are then taken by differences.
    fn differentiate(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        turns: &[Turn],
        samples: Samples,
        slopes: &mut Vec<f64>,
    ) -> bool;

    /// Goes on from the end of the segment just predicted to the start of the next one and reads where the motion is then.
    ///
    /// # Errors
    /// A motion that the model can't follow.
    fn carry_on(
        &mut self,
        next: &Segment,
        shared: &[f64],
        per_run: &[f64],
    ) -> Result<SegmentStart, Error>;

    /// Deviation from the measurement at which a prediction of run `run` is given up.
    fn limit(&self, run: usize) -> f64;
}
