//! What is read off a motion while it runs.

use super::Section;
use super::follow::{Crossing, Features, Follower};
use crate::contact::ContactMode;
use crate::error::PhysicsError;

/// Samples for the spectrum: twice as many are thinned to these by dropping every second.
const SAMPLES: usize = 8192;
/// Samples per period of the structure's highest mode.
const PER_PERIOD: f64 = 4.0;
/// Times that a motion that repeats must do so for its lines to be told apart: they are as many lines of the window apart.
const REPEATS: f64 = 8.0;

/// A stretch of motion, reduced as it goes.
pub(super) struct Stretch {
    section: Section,
    /// Points of the section.
    pub(super) points: Vec<Crossing>,
    /// Displacements in m at the peaks.
    pub(super) peaks: Vec<f64>,
    /// Displacements in m at the troughs.
    pub(super) troughs: Vec<f64>,
    /// Time in stick in s.
    stuck: f64,
    /// Begin and end in s.
    from: f64,
    pub(super) to: f64,
    /// Displacement in m at even times; none of a stretch that is discarded.
    pub(super) samples: Vec<f64>,
    sampled: bool,
    /// Sampling interval in s.
    pub(super) interval: f64,
    /// The last peak, from which the motion can be gone on with.
    pub(super) last: Option<Crossing>,
}

impl Stretch {
    /// A stretch that begins now; `sampled` where its spectrum will be wanted.
    pub(super) fn new(follower: &Follower, section: Section, sampled: bool) -> Self {
        let now = follower.run().piece().1;
        let modes = follower.run().model().beam().modes();
        let highest = modes.iter().fold(0.0, |a: f64, m| a.max(m.frequency));
        Self {
            section,
            points: Vec::new(),
            peaks: Vec::new(),
            troughs: Vec::new(),
            stuck: 0.0,
            from: now,
            to: now,
            samples: Vec::with_capacity(if sampled { 2 * SAMPLES } else { 0 }),
            sampled,
            interval: 1.0 / (PER_PERIOD * highest),
            last: None,
        }
    }

    /// Takes the next piece in.
    pub(super) fn next(
        &mut self,
        follower: &mut Follower,
        features: &mut Features,
    ) -> Result<(), PhysicsError> {
        follower.next(features)?;
        follower.section_points(self.section, features, &mut self.points);
        self.peaks
            .extend(features.peaks.iter().map(|p| p.displacement));
        self.troughs.extend(&features.troughs);
        if features.mode == Some(ContactMode::Stuck) {
            self.stuck += features.to - features.from;
        }
        if let Some(peak) = features.peaks.last() {
            self.last = Some(*peak);
        }
        self.to = features.to;
        if self.sampled {
            self.sample(follower);
        }
        Ok(())
    }

    fn sample(&mut self, follower: &mut Follower) {
        loop {
            let (from, interval) = (self.from, self.interval);
            let known = self.samples.len();
            let all = ((self.to - from) / interval).ceil() as usize;
            // Most pieces hold no sample, and to look into one may take as long as to make it.
            if all <= known {
                return;
            }
            let times =
                (known..all.min(2 * SAMPLES)).map(|i| from + f64::from(i as u32) * interval);
            follower.displacements(times, &mut self.samples);
            if self.samples.len() < 2 * SAMPLES {
                return;
            }
            let mut keep = false;
            self.samples.retain(|_| {
                keep = !keep;
                keep
            });
            self.interval *= 2.0;
        }
    }

    /// The samples that tell the strongest line: all, or the last that hold [`REPEATS`] times the time in s after which the
    /// motion repeats.
    pub(super) fn last_samples(&self, duration: Option<f64>) -> &[f64] {
        let all = self.samples.len();
        let enough = duration.map_or(all, |t| (REPEATS * t / self.interval).ceil() as usize);
        &self.samples[all - enough.min(all)..]
    }

    /// Half the distance in m between the highest peak and the lowest trough from the `skip`-th on.
    pub(super) fn amplitude_from(&self, skip: usize) -> f64 {
        let high = self
            .peaks
            .iter()
            .skip(skip)
            .copied()
            .fold(f64::NAN, f64::max);
        let low = self
            .troughs
            .iter()
            .skip(skip)
            .copied()
            .fold(f64::NAN, f64::min);
        let half = 0.5 * (high - low);
        if half.is_finite() { half } else { 0.0 }
    }

    /// Share of time in stick.
    pub(super) fn stick_fraction(&self) -> f64 {
        if self.to > self.from {
            self.stuck / (self.to - self.from)
        } else {
            0.0
        }
    }
}
