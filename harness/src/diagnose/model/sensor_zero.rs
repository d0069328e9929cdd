//! What the sensor reads of a tip at rest, run by run: its zero.
//!
//! A displacement is measured from the tip's rest without contact, within a few percent of the motion. A vibrometer counts from where it
//! was switched on, an AC-coupled amplifier and a record less its mean from the mean of the motion: the force that bends the tip is off
//! by as much then. Friction opposes sliding whatever its law, so that a median coefficient in slip below zero,
//!
//! ```text
//! median over slip of -sign(v_r) F / F_N < 0,
//! ```
//!
//! in most runs contradicts the zero. It is open then and believed to be where friction in slip is the one expected,
//!
//! ```text
//! w_0 = -c K_s,   c = median over slip of (-sign(v_r) mu(|v_r|) F_N - F)
//! ```
//!
//! with the static compliance K_s (m/N) of where the sensor looks. Holds where springs balance the force; a mass that slides freely shows
//! its force by itself.

use crate::diagnose::model::friction_prior::{Belief, FOREIGN, StartFriction};
use crate::diagnose::model::further_sensors::OFFSET_STD;
use crate::diagnose::model::parameter::{Kind, Parameter, Scale};
use crate::error::Error;
use crate::measurement::{Measurand, Run};
use crate::metric::{median, standard_deviation};
use crate::observer::Structure;
use crate::parallel::parallel;
use crate::smoothing::{Smoothing, missing_force, slip_of_run, smooth_run};

/// What is believed of the zero of the first sensor.
pub struct SensorZero {
    /// Centre and standard deviation in each run, in the unit of what is measured.
    pub beliefs: Vec<Belief>,
    /// Whether the contact contradicts the one that is stated.
    pub is_open: bool,
    /// Standard deviation of what is measured, the mean over the runs.
    spread: f64,
}

impl SensorZero {
    /// The runs, smoothed from where their zero is believed to be, and that belief; `stated` is its standard deviation, where the
    /// campaign says more than the usual, and then counts beside what friction in slip tells.
    ///
    /// # Errors
    /// A run that can't be smoothed.
    pub fn and_smoothings(
        runs: &[Run],
        structure: &Structure,
        expected: StartFriction,
        stated: Option<f64>,
    ) -> Result<(Self, Vec<Smoothing>), Error> {
        let friction = |v: f64| expected.at(v);
        let smoothings = parallel(runs, |run| smooth_run(run, structure, &friction, 0.0))?;
        let spreads = runs.iter().map(|run| standard_deviation(&run.measured));
        let spread = spreads.sum::<f64>() / runs.len() as f64;
        let believed = stated.unwrap_or(OFFSET_STD * spread);
        let looked: Vec<Option<Looked>> = runs
            .iter()
            .zip(&smoothings)
            .map(|(run, smoothing)| Looked::at(run, structure, smoothing, expected))
            .collect();
        let slipping = looked.iter().flatten().count();
        let contradict = looked.iter().flatten().filter(|l| l.coefficient < 0.0);
        let is_open = 2 * contradict.count() > slipping;
        let belief = |looked: &Option<Looked>| match (looked, stated) {
            (Some(looked), _) if is_open => looked.zero,
            (Some(looked), Some(std)) => both((0.0, std), looked.zero),
            _ => (0.0, believed),
        };
        let beliefs: Vec<Belief> = looked.iter().map(belief).collect();
        let pairs: Vec<(&Run, &Belief)> = runs.iter().zip(&beliefs).collect();
        let smoothings = match beliefs.iter().all(|(centre, _)| *centre == 0.0) {
            true => smoothings,
            false => parallel(&pairs, |(run, (centre, _))| {
                smooth_run(run, structure, &friction, *centre)
            })?,
        };
        let zero = Self {
            beliefs,
            is_open,
            spread,
        };
        Ok((zero, smoothings))
    }

    /// What a reader should know of an open zero.
    pub fn remark(&self, runs: &[Run]) -> String {
        let all = runs.iter().zip(&self.beliefs);
        let all =
            all.map(|(run, (centre, std))| format!("{} {centre:.2e} +- {std:.0e} m", run.name));
        let all: Vec<String> = all.collect();
        format!(
            "With the sensor's zero as stated, friction would drive the sliding in most runs instead of opposing it: the readings do not count \
             from the tip's rest. The zero was taken as unknown, where friction in slip is the one that the FMU's start values expect ({}). The \
             mean friction follows from that belief; where it matters, record the tip at rest without contact and take it off the readings.",
            all.join(", ")
        )
    }

    /// The zero of a run as a parameter of this name, in `unit`, for these variables of the FMU.
    pub fn parameter(
        &self,
        run: usize,
        (name, unit): (&str, &str),
        targets: Vec<(u32, f64)>,
    ) -> Parameter {
        let (prior, prior_std) = self.beliefs[run];
        Parameter {
            name: name.into(),
            unit: unit.into(),
            kind: Kind::Offset,
            targets,
            scale: Scale::Linear,
            prior,
            prior_std,
            min: prior - 10.0 * self.spread,
            max: prior + 10.0 * self.spread,
            step: 1e-3 * self.spread,
            support: None,
        }
    }
}

/// Two beliefs of one quantity together.
fn both(one: Belief, other: Belief) -> Belief {
    let (a, b) = (one.1.powi(-2), other.1.powi(-2));
    ((a * one.0 + b * other.0) / (a + b), (a + b).sqrt().recip())
}

/// What slip tells of the zero of a run.
struct Looked {
    /// Median coefficient of friction in slip with the zero as stated (1).
    coefficient: f64,
    /// The zero with which it is the one expected.
    zero: Belief,
}

impl Looked {
    /// `None` where something else than a displacement is measured, where no spring balances the force, and where nothing slips.
    fn at(
        run: &Run,
        structure: &Structure,
        smoothing: &Smoothing,
        expected: StartFriction,
    ) -> Option<Self> {
        if run.measurand != Measurand::Displacement || structure.is_free() {
            return None;
        }
        let slip = slip_of_run(run, smoothing);
        let missing = missing_force(&slip, run, &|v| expected.at(v))?;
        let over_load = slip
            .iter()
            .map(|s| -s.relative_velocity.signum() * s.force / run.normal_force);
        let mut coefficients: Vec<f64> = over_load.collect();
        let sizes = slip.iter().map(|s| {
            let coefficient = expected.at(s.relative_velocity.abs());
            coefficient * run.normal_force
        });
        let mut sizes: Vec<f64> = sizes.collect();
        let compliance = structure.sensor_compliance();
        let std = FOREIGN * median(&mut sizes).abs() * compliance.abs();
        (std > 0.0).then(|| Self {
            coefficient: median(&mut coefficients),
            zero: (-missing * compliance, std),
        })
    }
}
