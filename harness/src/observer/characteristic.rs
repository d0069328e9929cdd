//! The friction characteristic `mu(v_r)` from the smoothed force (Stelter 1992, Figure 14).

use super::error::ObserverError;
use super::segmentation::{Phase, PhaseMode};

/// Normal force on the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NormalForce<'a> {
    /// The same throughout, in N.
    Constant(f64),
    /// One value per sample, in N.
    Sampled(&'a [f64]),
}

impl NormalForce<'_> {
    /// Value at sample `k` in N.
    pub fn at(&self, k: usize) -> f64 {
        match self {
            NormalForce::Constant(n) => *n,
            NormalForce::Sampled(values) => values[k],
        }
    }

    fn check(&self, count: usize) -> Result<(), ObserverError> {
        let found = match self {
            NormalForce::Constant(_) => count,
            NormalForce::Sampled(values) => values.len(),
        };
        if found != count {
            return Err(ObserverError::LengthMismatch {
                what: "normal force",
                expected: count,
                found,
            });
        }
        match (0..count)
            .map(|k| self.at(k))
            .find(|n| !(*n > 0.0 && n.is_finite()))
        {
            Some(value) => Err(ObserverError::BadSetting {
                name: "normal_force",
                value,
                unit: "N",
                rule: "must be above 0",
            }),
            None => Ok(()),
        }
    }
}

/// Samples of one record in slip and stick, as [`super::StickSlip`] gives them.
#[derive(Debug, Clone, Copy)]
pub struct Contact<'a> {
    /// Tip velocity less belt velocity in m/s.
    pub relative_velocity: &'a [f64],
    /// Contact force on the tip in N.
    pub force: &'a [f64],
    /// Normal force.
    pub normal_force: NormalForce<'a>,
    /// Phases that cover the record.
    pub phases: &'a [Phase],
}

impl Contact<'_> {
    pub(super) fn check(&self) -> Result<(), ObserverError> {
        let expected = self.relative_velocity.len();
        let past = self.phases.last().map_or(0, |p| p.past);
        for (what, found) in [("force", self.force.len()), ("phases", past)] {
            if found != expected {
                return Err(ObserverError::LengthMismatch {
                    what,
                    expected,
                    found,
                });
            }
        }
        self.normal_force.check(expected)
    }
}

/// The friction coefficient over one interval of relative velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    /// Lower border of the relative velocity in m/s.
    pub low: f64,
    /// Upper border in m/s.
    pub high: f64,
    /// Mean relative velocity of its samples in m/s (negative: the tip lags behind the belt).
    pub relative_velocity: f64,
    /// Mean friction coefficient `mu = -F sgn(v_r) / F_N` (1).
    pub mu: f64,
    /// Standard deviation of the samples about the mean (1).
    pub mu_std: f64,
    /// Standard error of the mean (1), from the means of single slip phases; samples within a
    /// phase are not independent.
    pub mu_error: f64,
    /// Number of samples.
    pub count: usize,
    /// Number of slip phases that contribute.
    pub phases: usize,
}

/// Choices for [`friction_characteristic`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BinSettings {
    /// Number of bins between zero and the largest relative velocity of either sign.
    pub bins: usize,
    /// Samples next to a transition that are left out: the force jumps there.
    pub guard_samples: usize,
    /// Bins with fewer samples are left out.
    pub least_samples: usize,
    /// Share of the record left out at either end, where the smoother has no neighbours.
    pub end_share: f64,
}

impl Default for BinSettings {
    fn default() -> Self {
        Self {
            bins: 40,
            guard_samples: 2,
            least_samples: 8,
            end_share: 0.02,
        }
    }
}

/// Bins the friction coefficient over the relative velocity, slip only.
///
/// The borders lie at `v_max (i / bins)^2`: narrow at low speed, where friction falls steeply. Bins
/// are sorted by relative velocity.
pub fn friction_characteristic(
    contact: &Contact,
    settings: &BinSettings,
) -> Result<Vec<Bin>, ObserverError> {
    contact.check()?;
    if settings.bins == 0 {
        return Err(ObserverError::BadSetting {
            name: "bins",
            value: 0.0,
            unit: "",
            rule: "must be at least 1",
        });
    }
    let count = contact.relative_velocity.len();
    let end = (settings.end_share * count as f64) as usize;
    let mut bins = Vec::new();
    for (mode, sign) in [
        (PhaseMode::BackwardSlip, -1.0),
        (PhaseMode::ForwardSlip, 1.0),
    ] {
        let phases: Vec<Vec<usize>> = contact
            .phases
            .iter()
            .filter(|p| p.mode == mode)
            .map(|p| {
                let first = (p.first + settings.guard_samples).max(end);
                let past = p
                    .past
                    .saturating_sub(settings.guard_samples)
                    .min(count - end);
                (first..past)
                    .filter(|k| contact.relative_velocity[*k] * sign > 0.0)
                    .collect()
            })
            .collect();
        let speeds = phases
            .iter()
            .flatten()
            .map(|k| contact.relative_velocity[*k].abs());
        let fastest = speeds.fold(0.0, f64::max);
        let border = |i: usize| fastest * (i as f64 / settings.bins as f64).powi(2);
        for i in 0..settings.bins {
            let (low, high) = (border(i), border(i + 1));
            if let Some(bin) = one_bin(contact, &phases, sign, low, high, settings) {
                bins.push(bin);
            }
        }
    }
    bins.sort_by(|a, b| a.relative_velocity.total_cmp(&b.relative_velocity));
    if bins.is_empty() {
        return Err(ObserverError::TooFewEvents {
            what: "the friction characteristic",
            found: 0,
            needed: settings.least_samples,
            unit: "slip samples in any bin",
            action: "record longer, or check belt velocity and sign of the displacement",
        });
    }
    Ok(bins)
}

fn one_bin(
    contact: &Contact,
    phases: &[Vec<usize>],
    sign: f64,
    low: f64,
    high: f64,
    settings: &BinSettings,
) -> Option<Bin> {
    let inside = |k: &usize| {
        let speed = contact.relative_velocity[*k].abs();
        speed > low && speed <= high
    };
    let mu = |k: usize| -contact.force[k] * sign / contact.normal_force.at(k);
    let mut samples = Vec::new();
    let mut phase_means = Vec::new();
    for phase in phases {
        let of_phase: Vec<usize> = phase.iter().copied().filter(inside).collect();
        if !of_phase.is_empty() {
            phase_means.push(mean(of_phase.iter().map(|k| mu(*k))));
            samples.extend(of_phase);
        }
    }
    if samples.len() < settings.least_samples {
        return None;
    }
    let centre = mean(samples.iter().map(|k| mu(*k)));
    let spread = |values: &[f64], centre: f64| {
        (values.iter().map(|v| (v - centre).powi(2)).sum::<f64>()
            / (values.len() as f64 - 1.0).max(1.0))
        .sqrt()
    };
    let mus: Vec<f64> = samples.iter().map(|k| mu(*k)).collect();
    let mu_std = spread(&mus, centre);
    let n = phase_means.len() as f64;
    let mu_error = if phase_means.len() >= 3 {
        spread(&phase_means, mean(phase_means.iter().copied())) / n.sqrt()
    } else {
        mu_std
    };
    let (a, b) = (sign * low, sign * high);
    Some(Bin {
        low: a.min(b),
        high: a.max(b),
        relative_velocity: mean(samples.iter().map(|k| contact.relative_velocity[*k])),
        mu: centre,
        mu_std,
        mu_error,
        count: samples.len(),
        phases: phase_means.len(),
    })
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    values.sum::<f64>() / count
}
