//! A run made ready for the smoother, and completed after it.

use super::belt_path::BeltPath;
use super::driven_motion::{differences, driven_motion, sampled};
use super::level::settle;
use super::smoothed_run::Smoothing;
use crate::measurement::{Measurand, Run};
use crate::metric::{Rest, rest};
use crate::observer::{
    BeltVelocity, Mode, PhaseMode, Settings, Smoothed, StickSlip, StickSlipSettings, Structure,
};

/// A run as the smoother takes it: even samples of a structure that the friction force alone moves.
///
/// The structure is linear, so what an external force and the clamp do by themselves is taken off the record, and off the belt's
/// velocity too; [`Prepared::complete`] puts it on again.
pub struct Prepared<'a> {
    run: &'a Run,
    structure: &'a Structure,
    friction: &'a dyn Fn(f64) -> f64,
    interval: f64,
    signal: Vec<f64>,
    /// Velocity of the belt in m/s at each sample, less the tip's by the excitations; `None` where it is constant.
    belt: Option<Vec<f64>>,
    path: BeltPath,
    settings: StickSlipSettings,
    driven: Option<Driven>,
}

/// What excitations alone make of the structure.
struct Driven {
    /// Modal displacements in m and velocities in m/s.
    modal: [Vec<Vec<f64>>; 2],
    /// Displacement, velocity and acceleration of the tip.
    tip: [Vec<f64>; 3],
}

impl<'a> Prepared<'a> {
    /// From even samples `signal` an `interval` in s apart (NaN where one is missing) in the unit of what the run measures.
    ///
    /// `friction` is the coefficient (1) expected over the relative speed in m/s, which sets the level of force and deflection where
    /// a velocity or an acceleration leaves it open. `offset` of the sensor is taken off, in the unit of the signal; an acceleration
    /// shows its own in stick.
    pub fn of(
        run: &'a Run,
        structure: &'a Structure,
        friction: &'a dyn Fn(f64) -> f64,
        (interval, mut signal): (f64, Vec<f64>),
        offset: f64,
    ) -> Self {
        let count = signal.len();
        let series = run.inputs.belt_velocity.as_ref();
        let mut belt = series.map(|series| sampled(series, run, interval, count));
        let resting = rest_of(run, structure, &signal, belt.as_deref(), interval);
        let path = BeltPath::of(run, interval, belt.as_deref());
        let driven = driven_motion(structure, run, interval, count).map(|modal| {
            let [w, v, a] = motion_of(structure, interval, &modal, Mode::sensor_value);
            let seen = match run.measurand {
                Measurand::Displacement => w,
                Measurand::Velocity => v,
                Measurand::Acceleration => a,
            };
            let tip = motion_of(structure, interval, &modal, |mode| mode.tip_value);
            let less = |values: &mut [f64], part: &[f64]| {
                values.iter_mut().zip(part).for_each(|(v, p)| *v -= p);
            };
            less(&mut signal, &seen);
            let belt = belt.get_or_insert_with(|| vec![run.belt_velocity; count]);
            less(belt, &tip[1]);
            Driven { modal, tip }
        });
        let settings = StickSlipSettings {
            smoother: Settings {
                offset: resting.as_ref().map_or(offset, |rest| rest.offset),
                ..smoother_settings(run)
            },
            known_stick: resting.map(|rest| rest.on),
            expected_force: expected_force(run, structure, friction, interval),
            ..StickSlipSettings::default()
        };
        Self {
            run,
            structure,
            friction,
            interval,
            signal,
            belt,
            path,
            settings,
            driven,
        }
    }

    /// What was measured, less what excitations do by themselves.
    pub fn signal(&self) -> &[f64] {
        &self.signal
    }

    /// Velocity of the belt against what excitations alone do to the tip.
    pub fn belt(&self) -> BeltVelocity<'_> {
        match &self.belt {
            Some(belt) => BeltVelocity::Sampled(belt),
            None => BeltVelocity::Constant(self.run.belt_velocity),
        }
    }

    /// What the smoother is told of the run.
    pub fn settings(&self) -> &StickSlipSettings {
        &self.settings
    }

    /// The run's motion from what the smoother found of it: with the level that its channel leaves open, and with what excitations do.
    pub fn complete(&self, stick_slip: StickSlip) -> Smoothing {
        let starts: Vec<f64> = stick_slip
            .phases
            .windows(2)
            .filter(|w| w[0].mode == PhaseMode::Stick && w[1].mode != PhaseMode::Stick)
            .map(|w| w[1].start)
            .collect();
        let mut cycles: Vec<f64> = starts.windows(2).map(|w| w[1] - w[0]).collect();
        cycles.sort_by(f64::total_cmp);
        let cycle = cycles.get(cycles.len() / 2).copied().unwrap_or(f64::NAN);
        let mut smoothing = Smoothing {
            stick_slip,
            cycle,
            first_time: self.run.time[0],
            belt_path: self.path.clone(),
        };
        settle(&mut smoothing, self.run, self.structure, self.friction);
        if let Some(driven) = &self.driven {
            driven.add_to(&mut smoothing.stick_slip.smoothed);
        }
        smoothing
    }

    /// Interval of the samples in s.
    pub fn interval(&self) -> f64 {
        self.interval
    }
}

impl Driven {
    /// Adds this motion to that of the friction force, which stays as it is.
    fn add_to(&self, smoothed: &mut Smoothed) {
        let sum = |to: &mut [f64], part: &[f64]| to.iter_mut().zip(part).for_each(|(a, b)| *a += b);
        for (to, part) in smoothed.q.iter_mut().zip(&self.modal[0]) {
            sum(to, part);
        }
        for (to, part) in smoothed.q_dot.iter_mut().zip(&self.modal[1]) {
            sum(to, part);
        }
        sum(&mut smoothed.displacement, &self.tip[0]);
        sum(&mut smoothed.velocity, &self.tip[1]);
        sum(&mut smoothed.acceleration, &self.tip[2]);
    }
}

/// What the smoother is told of a run. Beside a force that jumps it finds the noise of a displacement, but not the much smaller one
/// of a velocity or an acceleration, which the differences of the record show.
pub fn smoother_settings(run: &Run) -> Settings {
    let known = Some(run.noise.std).filter(|std| *std > 0.0);
    Settings {
        measurand: run.measurand,
        noise_std: match run.measurand {
            Measurand::Displacement => None,
            Measurand::Velocity | Measurand::Acceleration => known,
        },
        ..Settings::default()
    }
}

/// What an acceleration leaves open of the force, in N: the friction expected at the speed of the belt, known to no better than
/// its size in a period of the lowest mode, and so in each sample of it less by the root of their number. `None` where something
/// else was measured, which tells the motion by itself, and where no spring would turn a force into a deflection.
fn expected_force(
    run: &Run,
    structure: &Structure,
    friction: &dyn Fn(f64) -> f64,
    interval: f64,
) -> Option<(f64, f64)> {
    if run.measurand != Measurand::Acceleration || structure.is_free() {
        return None;
    }
    let modes = structure.modes().iter();
    let lowest = modes.map(|m| m.frequency_hz).fold(f64::INFINITY, f64::min);
    let samples = (1.0 / (lowest * interval)).max(1.0);
    let speed = run.belt_velocity;
    let force = speed.signum() * friction(speed.abs()) * run.normal_force;
    (force != 0.0 && force.is_finite()).then(|| (force, force.abs() * samples.sqrt()))
}

/// Stretches of a measured acceleration in which the tip rests on the belt, for a quarter of a period of the lowest mode or half a
/// period of the highest at least: a tip that does not stick turns within that. `None` where something else was measured, and where
/// no mode has a spring that would move it.
fn rest_of(
    run: &Run,
    structure: &Structure,
    signal: &[f64],
    belt: Option<&[f64]>,
    interval: f64,
) -> Option<Rest> {
    if run.measurand != Measurand::Acceleration || !structure.is_collocated() {
        return None;
    }
    let sprung = structure.modes().iter().filter(|mode| !mode.is_free());
    let frequencies = sprung.map(|mode| mode.frequency_hz);
    let (lowest, highest) = frequencies.fold((f64::INFINITY, 0.0), |(low, high), f| {
        (f.min(low), f.max(high))
    });
    let shortest = (0.25 / lowest).min(0.5 / highest) / interval;
    let mut against_belt = signal.to_vec();
    if let Some(belt) = belt {
        let of_belt = differences(belt, interval);
        against_belt
            .iter_mut()
            .zip(of_belt)
            .for_each(|(a, b)| *a -= b);
    }
    lowest
        .is_finite()
        .then(|| rest(&against_belt, run.noise.std, shortest.round() as usize))?
}

/// Displacement, velocity and acceleration, the latter by differences, of where the modes have the values `shape`; from modal displacements
/// and velocities.
fn motion_of(
    structure: &Structure,
    h: f64,
    modal: &[Vec<Vec<f64>>; 2],
    shape: fn(&Mode) -> f64,
) -> [Vec<f64>; 3] {
    let there = |columns: &Vec<Vec<f64>>| -> Vec<f64> {
        let at = |k: usize| {
            let modes = structure.modes().iter().zip(columns);
            modes.map(|(mode, column)| shape(mode) * column[k]).sum()
        };
        (0..columns[0].len()).map(at).collect()
    };
    let (displacement, velocity) = (there(&modal[0]), there(&modal[1]));
    let acceleration = differences(&velocity, h);
    [displacement, velocity, acceleration]
}
