//! The friction curve by shooting: sharper than binning the smoothed force.
//!
//! At break-away the tip runs through 0.1 m/s within a few samples, and there the smoothed force
//! is smeared. Here every slip event of the record is simulated from the stick before it to the
//! stick after it, with a friction curve given by its values at nodes; the node values and the
//! start state of every event are those that fit the displacement best (multiple shooting, Bock
//! 1983; Levenberg-Marquardt with the start states eliminated event by event). An exponential is
//! fitted first, because with free node values from the start the search gets stuck.
//!
//! Holds for rigid sticking, where friction in slip depends on the speed alone, equally in both
//! directions, and breaks away at `mu(0)`; what does not follow shows in
//! [`FrictionCurve::misfit`].

mod basis;
mod guess;
mod linear;
mod search;
mod shooting;

use super::characteristic::Contact;
use super::error::ObserverError;
use super::segmentation::PhaseMode;
use super::stick_slip::{BeltVelocity, StickSlip};
use super::structure::Structure;
use basis::Basis;
use guess::Guess;
use linear::Linear;
use search::Search;

/// A friction curve with its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionCurve {
    /// Node speeds in m/s: squares of evenly spaced values from 0.
    pub speed: Vec<f64>,
    /// Friction coefficient at the nodes (1); the first is the static coefficient.
    pub mu: Vec<f64>,
    /// Standard deviation of the node values (1), widened by the misfit.
    pub mu_std: Vec<f64>,
    /// Number of slip samples nearest to each node.
    pub count: Vec<usize>,
    /// Number of slip events used.
    pub events: usize,
    /// Root mean square deviation of the displacement over the sensor noise (1); about 1 where the
    /// curve explains the slip events.
    pub misfit: f64,
}

impl FrictionCurve {
    /// Coefficient at speed `v >= 0` in m/s (piecewise cubic in the root of the speed).
    pub fn at(&self, v: f64) -> f64 {
        let fastest = self.speed.last().copied().unwrap_or(1.0);
        Basis::new(fastest, self.speed.len()).value(&self.mu, v)
    }

    /// Standard deviation of the coefficient at speed `v >= 0` in m/s (1), straight from node to
    /// node.
    pub fn std_at(&self, v: f64) -> f64 {
        let above = self.speed.partition_point(|s| *s <= v);
        match above {
            0 => self.mu_std[0],
            n if n == self.speed.len() => self.mu_std[n - 1],
            n => {
                let share = (v - self.speed[n - 1]) / (self.speed[n] - self.speed[n - 1]);
                self.mu_std[n - 1] + share * (self.mu_std[n] - self.mu_std[n - 1])
            }
        }
    }
}

/// Choices for [`friction_curve`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveSettings {
    /// Number of nodes.
    pub nodes: usize,
    /// Most Levenberg-Marquardt steps.
    pub steps: usize,
    /// Most slip events used, spread over the record.
    pub events: usize,
}

impl Default for CurveSettings {
    fn default() -> Self {
        Self {
            nodes: 20,
            steps: 40,
            events: 60,
        }
    }
}

/// Samples of stick before the found break-away at which an event starts.
const LEAD: usize = 10;
/// Samples of stick after arrival that are still compared.
const TAIL: usize = 3;
/// Longest event in samples.
const LONGEST: usize = 2_000;
/// Standard deviation of the second differences of the node values' departure from an exponential
/// (1).
const BEND: f64 = 0.003;
/// Events whose misfit exceeds this multiple of the median count less.
const OUTLIER: f64 = 3.0;

/// Speeds in m/s over which the first guesses fall.
const FALLS: [f64; 3] = [0.03, 0.008, 0.12];
/// Misfit from which on no other first guess is tried.
const GOOD: f64 = 1.2;

/// Estimates the friction curve of a record.
///
/// `found` from [`super::smooth_stick_slip`] on the same displacement (m, NaN where missing).
pub fn friction_curve(
    structure: &Structure,
    displacement: &[f64],
    belt: BeltVelocity,
    contact: &Contact,
    found: &StickSlip,
    settings: &CurveSettings,
) -> Result<FrictionCurve, ObserverError> {
    contact.check()?;
    let search = Search::new(structure, displacement, belt, contact, found, settings)?;
    let mut first: Option<(Guess, Linear)> = None;
    for fall in FALLS {
        let start = search.exponential(fall, contact, found);
        let fit = search.optimise(start, settings.steps / 2);
        if first.as_ref().is_none_or(|f| fit.1.cost < f.1.cost) {
            first = Some(fit);
        }
        if first
            .as_ref()
            .is_some_and(|f| f.1.sum < GOOD * GOOD * f.1.count)
        {
            break;
        }
    }
    let Some((guess, _)) = first.map(|(guess, _)| search.optimise(guess, settings.steps)) else {
        return Err(ObserverError::TooFewEvents {
            what: "the friction curve",
            found: 0,
            needed: 1,
            unit: "converged fits",
            action: "use the binned characteristic",
        });
    };
    let (guess, best) = search.optimise(search.to_nodes(&guess), settings.steps);
    let misfit = (best.sum / best.count).sqrt();
    let inverse = search.reduced(&best, 0.0).0.pseudo_inverse(1e-14);
    let std = |i: usize| match &inverse {
        Ok(inverse) => inverse[(i, i)].max(0.0).sqrt() * misfit.max(1.0),
        Err(_) => f64::INFINITY,
    };
    let mut count = vec![0; settings.nodes];
    for phase in contact.phases.iter().filter(|p| p.mode != PhaseMode::Stick) {
        for v in &contact.relative_velocity[phase.first..phase.past] {
            let u = (v.abs().sqrt() / search.basis.step).round() as usize;
            count[u.min(settings.nodes - 1)] += 1;
        }
    }
    Ok(FrictionCurve {
        speed: (0..settings.nodes)
            .map(|i| (i as f64 * search.basis.step).powi(2))
            .collect(),
        mu_std: (0..settings.nodes).map(std).collect(),
        mu: guess.parameters,
        count,
        events: search.shots.len(),
        misfit,
    })
}
