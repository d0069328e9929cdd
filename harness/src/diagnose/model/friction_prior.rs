//! What to believe of the friction constants before any fit.
//!
//! The FMU's start values describe the pair of surfaces it was made for. Measured on another pair, and so on a machine of another size,
//! friction and sliding speeds may be off by factors, and a fit that starts there is lost. So the smoothed slip force, which needs no
//! law, is compared first with `mu(v) F_N` at its sliding speeds: where the two agree within [`FOREIGN`] in the median, or
//! in a straight line through their ratio carried on to rest, the start values are the prior; else a law fitted to the observed
//! coefficient is, with wide spreads.

use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::Run;
use crate::metric::{line, median};
use crate::observer::{
    Bin, BinSettings, Contact, FrictionLaw, LawPoints, NormalForce, fit_laws,
    friction_characteristic,
};
use crate::smoothing::Smoothing;
use crate::smoothing::{SlipSample, slip_of_run};

/// Logarithm of the ratio of observed to expected friction beyond which the surfaces are others.
pub(crate) const FOREIGN: f64 = 0.25;

/// Whether observed over expected friction tells of other surfaces.
pub fn is_foreign(ratio: f64) -> bool {
    ratio > 0.0 && ratio.ln().abs() > FOREIGN
}

/// Standard deviation of the logarithm of a2: friction constants are known to a tenth at best.
const A2_STD: f64 = 0.1;

/// The friction law as the FMU's start values have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartFriction {
    mu_0: f64,
    v1: f64,
    c2: f64,
    a1: f64,
    a2: f64,
}

impl StartFriction {
    /// The constants of an FMU.
    ///
    /// One of another make has a constant coefficient: that of its side file, or none (NaN) where a displacement was measured,
    /// which needs none.
    ///
    /// # Errors
    /// An FMU without them.
    pub fn of(fmu: &Fmu) -> Result<Self, Error> {
        if let Some(side) = fmu.side_file() {
            let (v1, c2, a1, a2) = (1.0, 0.0, 0.0, 0.0);
            let mu_0 = side.friction_coefficient.unwrap_or(f64::NAN);
            return Ok(Self {
                mu_0,
                v1,
                c2,
                a1,
                a2,
            });
        }
        let start = |name: &str| -> Result<f64, Error> {
            Ok(fmu.variable(name)?.start_number().unwrap_or(f64::NAN))
        };
        Ok(Self {
            mu_0: start("friction.mu_0")?,
            v1: start("friction.v1")?,
            c2: start("friction.c2")?,
            a1: start("friction.a1")?,
            a2: start("friction.a2")?,
        })
    }

    /// Coefficient of friction (1) at a sliding speed in m/s.
    pub fn at(&self, v: f64) -> f64 {
        let &Self {
            mu_0,
            v1,
            c2,
            a1,
            a2,
        } = self;
        mu_0 * (1.0 - a1 + a1 * (-v / v1).exp()) * (1.0 - a2 + a2 * (-c2 * v).exp())
    }
}

/// Centre and standard deviation of a belief; of the logarithm, where the quantity is positive.
pub type Belief = (f64, f64);

/// Beliefs of the constants of `mu(v) = mu_0 [1 - a1 + a1 exp(-v/v1)] [1 - a2 + a2 exp(-c2 v)]` (Stelter 1992, eq. 7).
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionPrior {
    /// mu_0 (1).
    pub mu_0: Belief,
    /// v1 (m/s).
    pub v1: Belief,
    /// c2 (s/m).
    pub c2: Belief,
    /// a1 (1).
    pub a1: Belief,
    /// a2 (1).
    pub a2: Belief,
    /// Friction level of each run (1).
    pub levels: Vec<Belief>,
    /// Observed over expected friction, where surfaces or machine are not those of the start values.
    pub foreign: Option<f64>,
}

impl FrictionPrior {
    /// The beliefs for a campaign's runs, of the machine that the start values hold for or of another. Where a velocity was measured, the
    /// level of the smoothed force is that of the start values, so that other surfaces are not recognised.
    pub fn new(
        expected: StartFriction,
        is_other_machine: bool,
        runs: &[Run],
        smoothings: &[Smoothing],
    ) -> Self {
        let StartFriction {
            mu_0,
            v1,
            c2,
            a1,
            a2,
        } = expected;
        let mut speeds = Vec::new();
        let mut of_runs = Vec::new();
        let mut pooled = Vec::new();
        for (run, smoothing) in runs.iter().zip(smoothings) {
            let slip = slip_of_run(run, smoothing);
            let pairs = slip.iter().map(|s| {
                let v = s.relative_velocity.abs();
                (v, s.force.abs() / (run.normal_force * expected.at(v)))
            });
            let pairs: Vec<(f64, f64)> = pairs.filter(|(_, r)| r.is_finite()).collect();
            let mut ratios: Vec<f64> = pairs.iter().map(|(_, r)| *r).collect();
            pooled.extend(pairs);
            of_runs.push(median(&mut ratios));
            speeds.extend(slip.iter().map(|s| s.relative_velocity.abs()));
        }
        let mut seen: Vec<f64> = of_runs.iter().copied().filter(|r| *r > 0.0).collect();
        let ratio = median(&mut seen);
        let as_made = Self {
            mu_0: (mu_0, 0.1),
            v1: (v1, 0.2),
            c2: (c2, 0.4),
            a1: (a1, 0.06),
            a2: (a2, A2_STD),
            levels: vec![(1.0, 0.03); runs.len()],
            foreign: None,
        };
        // Friction that rises with the sliding speed is another effect on the same surfaces: at rest the two agree.
        let is_off = is_foreign(ratio) && is_foreign(line(&pooled).0);
        if !(is_off || is_other_machine && ratio > 0.0) {
            return as_made;
        }
        let typical_speed = median(&mut speeds);
        let scaled = || {
            let fall = Fall {
                mu_0: mu_0 * ratio,
                a1,
                v1: v1.min(typical_speed),
            };
            (fall, of_runs.iter().map(|r| r / ratio).collect())
        };
        let (fall, levels): (Fall, Vec<f64>) = observed(runs, smoothings).unwrap_or_else(scaled);
        let level = |r: f64| if r > 0.0 { r } else { 1.0 };
        Self {
            mu_0: (fall.mu_0, 0.3),
            v1: (fall.v1, 1.0),
            c2: (c2, 1.0),
            a1: (fall.a1, 0.3),
            a2: (a2, A2_STD),
            levels: levels.into_iter().map(|r| (level(r), 0.3)).collect(),
            foreign: Some(ratio),
        }
    }
}

/// How friction falls from rest to sliding: `mu_0 [1 - a1 + a1 exp(-v/v1)]`.
struct Fall {
    mu_0: f64,
    a1: f64,
    v1: f64,
}

/// The fall of the law that describes the observed coefficient best, and the level of each run beside that law; what rises with
/// the speed is left to effects. `None` where slip is too short or too even to tell.
fn observed(runs: &[Run], smoothings: &[Smoothing]) -> Option<(Fall, Vec<f64>)> {
    let mut bins: Vec<Bin> = Vec::new();
    for (run, smoothing) in runs.iter().zip(smoothings) {
        if run.normal_force == 0.0 {
            continue;
        }
        let contact = Contact {
            relative_velocity: &smoothing.stick_slip.relative_velocity,
            force: &smoothing.stick_slip.smoothed.force,
            normal_force: NormalForce::Constant(run.normal_force),
            phases: &smoothing.stick_slip.phases,
        };
        // A run without slip has nothing to tell.
        let of_run = friction_characteristic(&contact, &BinSettings::default());
        bins.extend(of_run.unwrap_or_default());
    }
    let speeds = || bins.iter().map(|b| b.relative_velocity.abs());
    let slowest = speeds().fold(f64::INFINITY, f64::min);
    let fastest = speeds().fold(0.0, f64::max);
    let fits = fit_laws(&LawPoints::from_bins(&bins, None)).ok()?;
    let is_table = |law: &FrictionLaw| matches!(law, FrictionLaw::Table { .. });
    let law = fits.into_iter().map(|fit| fit.law).find(|l| !is_table(l))?;
    let (mu_0, kinetic, v1) = match &law {
        FrictionLaw::Stelter { mu_0, a1, v1, .. } => (*mu_0, (1.0 - a1) * mu_0, *v1),
        FrictionLaw::Stribeck {
            mu_s,
            mu_k,
            stribeck_velocity,
            ..
        } => (*mu_s, *mu_k, *stribeck_velocity),
        FrictionLaw::Coulomb { mu_k, .. } => (*mu_k, *mu_k, slowest),
        FrictionLaw::Table { .. } => return None,
    };
    if !((slowest..=fastest).contains(&v1) && kinetic > 0.0 && mu_0.is_finite()) {
        return None;
    }
    let fall = Fall {
        mu_0: mu_0.max(kinetic),
        a1: (1.0 - kinetic / mu_0).max(0.0),
        v1,
    };
    let level = |(run, smoothing): (&Run, &Smoothing)| {
        let slip = slip_of_run(run, smoothing);
        let ratio =
            |s: &SlipSample| s.force.abs() / (run.normal_force * law.mu(s.relative_velocity.abs()));
        let mut ratios: Vec<f64> = slip.iter().map(ratio).filter(|r| r.is_finite()).collect();
        median(&mut ratios)
    };
    Some((fall, runs.iter().zip(smoothings).map(level).collect()))
}
