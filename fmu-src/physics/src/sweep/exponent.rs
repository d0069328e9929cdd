//! The largest Lyapunov exponent: how a small difference to a motion grows from peak to peak.
//!
//! By the variational equation where the run carries a difference along, else by a second motion that starts close by. Either
//! way what happens at transitions (saltation) is in it.

use super::companion::Companion;
use super::follow::{Crossing, Follower};
use crate::contact::ContactMode;
use crate::error::PhysicsError;
use crate::integrate::{MAX_STATES, State};
use crate::model::Model;

/// Share of the growths at the begin that are left out, while the difference turns into its own direction.
const ALIGNING: usize = 10;
/// ln(growth) from which on a difference has clearly grown, or shrunk: one that turns on an ellipse, or has not found its
/// direction, may grow by less and die out all the same.
const CLEAR: f64 = 2.0;
/// Stretches of the growth from whose scatter the exponent's standard error is taken: few enough that each is longer than a
/// motion remembers, and enough for a scatter.
const STRETCHES: usize = 10;
/// Standard errors above zero from which on an exponent is positive: 97.7 % of normal errors lie below.
const BEYOND: f64 = 2.0;
/// What is left of a difference when the shift along the motion is taken out, in tolerances of the run, below which it is lost
/// in the run's error.
const LOST: f64 = 10.0;

/// How large a difference is: the sum of squares of what its states stand for.
pub(super) struct Norm {
    /// The size that counts of each state, in m per its unit.
    weight: State,
}

impl Norm {
    fn new(model: &Model, amplitude: f64) -> Self {
        let scales = model.state_scales();
        let mut weight = [0.0; MAX_STATES];
        let modes = model.beam().modes();
        for (j, m) in modes.iter().enumerate() {
            weight[2 * j] = m.tip_value.abs();
            weight[2 * j + 1] = m.tip_value.abs() / m.angular_frequency();
        }
        for i in 2 * modes.len()..model.dimension() {
            weight[i] = amplitude / (100.0 * scales[i]);
        }
        Self { weight }
    }

    /// The size in m.
    pub(super) fn of(&self, difference: &State) -> f64 {
        let parts = difference.iter().zip(&self.weight).map(|(d, w)| d * w);
        parts.map(|d| d * d).sum::<f64>().sqrt()
    }
}

/// What a difference is compared with.
enum Way {
    /// Itself, carried along; how it was at the last peak.
    Variation(Option<Last>),
    /// A second motion.
    Companion(Box<Companion>),
}

/// A difference at a peak.
struct Last {
    /// Its size in m without the shift along the motion.
    size: f64,
    /// That shift: the lead in s.
    lead: f64,
}

/// The growth of a difference, measured at every peak.
pub(super) struct Exponent {
    way: Way,
    norm: Norm,
    amplitude: f64,
    tolerance: f64,
    /// ln(growth) and time in s of each stretch.
    growths: Vec<(f64, f64)>,
    since: Option<f64>,
    lost: bool,
}

impl Exponent {
    /// Of a motion with this amplitude in m, from the end of its present piece on.
    pub(super) fn new(follower: &mut Follower, amplitude: f64, tolerance: f64) -> Self {
        let model = follower.run().model();
        let norm = Norm::new(model, amplitude);
        let any = any_direction(model);
        let way = if follower.run_mut().vary(&any) {
            Way::Variation(None)
        } else {
            Way::Companion(Box::new(Companion::new(follower, amplitude, tolerance)))
        };
        Self {
            way,
            norm,
            amplitude,
            tolerance,
            growths: Vec::new(),
            since: None,
            lost: false,
        }
    }

    /// Measures the difference at the peaks in the present piece of the motion.
    pub(super) fn meet(
        &mut self,
        follower: &mut Follower,
        peaks: &[Crossing],
        mode: ContactMode,
    ) -> Result<(), PhysicsError> {
        for peak in peaks {
            if !self.lost {
                self.measure(follower, peak, mode)?;
            }
        }
        // From the next piece on the difference is as large as 1 m, and no shift along the motion.
        if let Way::Variation(Some(last)) = &mut self.way
            && !(self.lost || peaks.is_empty())
        {
            let run = follower.run_mut();
            run.renew_difference(last.lead, 1.0 / last.size);
            last.size = 1.0;
        }
        Ok(())
    }

    fn measure(
        &mut self,
        follower: &mut Follower,
        peak: &Crossing,
        mode: ContactMode,
    ) -> Result<(), PhysicsError> {
        let growth = match &mut self.way {
            Way::Variation(last) => match follower.run().difference_at(peak.time) {
                Some(difference) => {
                    let whole = self.norm.of(&difference);
                    let (across, lead) = across(follower, peak, mode, &difference);
                    let size = self.norm.of(&across);
                    self.lost = !(size > LOST * self.tolerance * whole);
                    let last = last.replace(Last { size, lead });
                    last.map(|last| size / last.size)
                }
                // The run goes on in another way, which carries nothing along.
                None => {
                    let companion = Companion::new(follower, self.amplitude, self.tolerance);
                    self.way = Way::Companion(Box::new(companion));
                    return self.measure(follower, peak, mode);
                }
            },
            Way::Companion(companion) => {
                let growth = companion.meet(follower, peak, mode, &self.norm)?;
                self.lost = companion.is_lost();
                growth
            }
        };
        if let (Some(growth), Some(since)) = (growth, self.since) {
            self.growths.push((growth.ln(), peak.time - since));
        }
        self.since = Some(peak.time);
        Ok(())
    }

    /// The exponent in 1/s: `lambda = sum ln(growth) / time`; minus infinity where the difference died out.
    pub(super) fn value(&self) -> Option<f64> {
        let (growth, time) = self.total();
        (time > 0.0).then_some(growth / time)
    }

    /// Standard error of the exponent in 1/s, from the scatter of its values in ten stretches of the motion; `None` with less
    /// than two returns in a stretch.
    ///
    /// ```text
    /// s^2 = sum_b (g_b - lambda t_b)^2 / [g (g - 1)] / <t>^2
    /// ```
    ///
    /// g_b, t_b: ln(growth) and time in s of stretch b of g = 10. Stretches are taken as independent.
    /// Source: batch means, e.g. Law and Kelton, Simulation Modeling and Analysis (2000), sect. 9.5.3.
    pub(super) fn standard_error(&self) -> Option<f64> {
        let counted = self.counted();
        if self.lost || counted.len() < 2 * STRETCHES {
            return None;
        }
        let (growth, time) = self.total();
        let n = counted.len();
        let stretches =
            (0..STRETCHES).map(|b| sum(&counted[b * n / STRETCHES..(b + 1) * n / STRETCHES]));
        let squares: f64 = stretches
            .map(|(g, t)| (g - growth / time * t).powi(2))
            .sum();
        let count = STRETCHES as f64;
        Some((squares / (count * (count - 1.0))).sqrt() / (time / count))
    }

    /// Whether the difference has clearly grown: by more than a turn on an ellipse makes of it, and at a rate that is positive
    /// beyond its standard error.
    pub(super) fn has_grown(&self) -> bool {
        let (growth, time) = self.total();
        let error = self.standard_error().unwrap_or(0.0);
        growth > CLEAR && growth / time > BEYOND * error
    }

    /// Whether the difference has clearly shrunk.
    pub(super) fn has_shrunk(&self) -> bool {
        self.total().0 < -CLEAR
    }

    /// The growths that count.
    fn counted(&self) -> &[(f64, f64)] {
        &self.growths[self.growths.len() / ALIGNING..]
    }

    /// ln(growth) and time in s of all that counts.
    fn total(&self) -> (f64, f64) {
        let (growth, time) = sum(self.counted());
        if self.lost {
            return (f64::NEG_INFINITY, time.max(f64::MIN_POSITIVE));
        }
        (growth, time)
    }
}

/// ln(growth) and time in s of several growths.
fn sum(growths: &[(f64, f64)]) -> (f64, f64) {
    let add = |(g, t): (f64, f64), (a, b): &(f64, f64)| (g + a, t + b);
    growths.iter().fold((0.0, 0.0), add)
}

/// A difference that is no shift along the motion: any will turn into the one that grows most.
pub(super) fn any_direction(model: &Model) -> State {
    let mut out = [0.0; MAX_STATES];
    for (i, m) in model.beam().modes().iter().enumerate() {
        out[2 * i] = 1.0 / (1.0 + i as f64);
        out[2 * i + 1] = 0.3 * m.angular_frequency() / (2.0 + i as f64);
    }
    out
}

/// The difference of two motions each at its own peak, and the time in s by which the second is ahead there: a mere shift in
/// time is no difference.
pub(super) fn across(
    follower: &Follower,
    peak: &Crossing,
    mode: ContactMode,
    difference: &State,
) -> (State, f64) {
    let mut rates = [0.0; MAX_STATES];
    let model = follower.run().model();
    model.rates(peak.time, &peak.state, mode, &mut rates);
    let slope = follower.velocity(&rates);
    if slope == 0.0 {
        return (*difference, 0.0);
    }
    let lead = follower.velocity(difference) / slope;
    let mut out = *difference;
    for (d, rate) in out.iter_mut().zip(&rates) {
        *d -= lead * rate;
    }
    (out, lead)
}
