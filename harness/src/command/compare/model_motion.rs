//! The motions that the model makes at a run's operating point.

use crate::command::operating_point::{OperatingPoint, record};
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::{BeamKnowledge, Run};
use crate::metric::{ModelMotion, quantile, velocity};

/// The model runs at least this many measured periods, and this share of the record, before it is compared: long enough
/// to forget that its start state is known at the tip only.
const SETTLE_PERIODS: f64 = 20.0;
const SETTLE_SHARE: f64 = 0.5;
/// The model can be shifted by this many periods either way to fit the record.
const SHIFT_PERIODS: f64 = 2.0;
/// Samples for the parabola that gives the velocity at the start.
const START_HALF_WIDTH: usize = 5;

/// One motion of the tip from its start on, evenly sampled.
pub(super) struct Motion {
    /// As the sensor shows it, m.
    pub displacement: Vec<f64>,
    /// m/s.
    pub velocity: Vec<f64>,
}

/// How much longer than the record the model runs, in samples.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Lead {
    /// After this the model has settled.
    settle: usize,
    /// By this much it can be shifted against the record, either way.
    shift: usize,
}

impl Lead {
    /// For a record of this `period`, `duration` and sample `interval`, s.
    pub fn of(period: f64, duration: f64, interval: f64) -> Lead {
        let samples = |time: f64| (time / interval).round() as usize;
        Lead {
            settle: samples((SETTLE_PERIODS * period).max(SETTLE_SHARE * duration)),
            shift: samples(SHIFT_PERIODS * period),
        }
    }
}

/// A piece of a motion, long enough to be shifted against the record.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    motion: &'a Motion,
    lead: Lead,
    settled: bool,
}

impl<'a> Piece<'a> {
    /// The pieces to compare: each motion from its start on, and each motion settled. A measured rig may still be on its
    /// way from an unknown start, which takes seconds, or have arrived.
    pub fn all(motions: &'a [Motion], lead: Lead) -> Vec<Piece<'a>> {
        let piece = |settled| {
            motions.iter().map(move |motion| Piece {
                motion,
                lead,
                settled,
            })
        };
        piece(true).chain(piece(false)).collect()
    }

    fn first(self) -> usize {
        if self.settled { self.lead.settle } else { 0 }
    }

    /// Displacement in the record's time, m.
    pub fn displacement(self, interval: f64) -> ModelMotion<'a> {
        self.view(&self.motion.displacement, interval)
    }

    /// Velocity in the record's time, m/s.
    pub fn velocity(self, interval: f64) -> ModelMotion<'a> {
        self.view(&self.motion.velocity, interval)
    }

    fn view(self, values: &'a [f64], interval: f64) -> ModelMotion<'a> {
        ModelMotion {
            start: -(self.lead.shift as f64) * interval,
            interval,
            values: &values[self.first()..],
        }
    }

    /// Even samples of the displacement (m) over the record.
    pub fn samples(self, count: usize) -> &'a [f64] {
        let first = self.first() + self.lead.shift;
        &self.motion.displacement[first..(first + count).min(self.motion.displacement.len())]
    }
}

/// Runs the model from every start state, with `settings` beside what is known of the beam and before it; without `lead` (no period to settle for) from the measured one only.
pub(super) fn model_motions(
    fmu: &Fmu,
    beam: &BeamKnowledge,
    run: &Run,
    lead: Lead,
    settings: &[(String, f64)],
) -> Result<Vec<Motion>, Error> {
    let interval = run.sample_interval();
    let steps = lead.settle + 2 * lead.shift + (run.duration() / interval).ceil() as usize + 2;
    let count = if lead.shift == 0 { 1 } else { usize::MAX };
    starts(fmu, beam, run, settings)
        .iter()
        .take(count)
        .map(|point| model_run(fmu, &run.name, point, interval, steps))
        .collect()
}

/// Start states to try: the measured one, and a grid up to the farthest bend and to the belt's velocity.
///
/// Several attractors coexist over wide ranges, large stick-slip cycles and a small one near the second mode, and a start
/// state known at the tip only may lead to any of them. All are compared, so that what the model can do is judged and not
/// the luck of its start.
fn starts(
    fmu: &Fmu,
    beam: &BeamKnowledge,
    run: &Run,
    settings: &[(String, f64)],
) -> Vec<OperatingPoint> {
    let ends = 2 * START_HALF_WIDTH;
    let measured_velocity = velocity(
        &run.time[..ends],
        &run.displacement[..ends],
        START_HALF_WIDTH,
    )[0];
    let farthest = quantile(
        &run.displacement,
        if run.belt_velocity < 0.0 {
            0.005
        } else {
            0.995
        },
    );
    // Released from farther than it ever was, it tends to the small motion.
    let bends = [0.0, 0.5, 0.8, 1.0, 1.3];
    let speeds = [0.0, 0.5, 1.0];
    let grid = bends.iter().flat_map(|bend| {
        speeds
            .iter()
            .map(move |speed| (bend * farthest, speed * run.belt_velocity))
    });
    let states = std::iter::once((run.displacement[0], measured_velocity)).chain(grid);
    let point = OperatingPoint::of_beam(fmu, beam, run.belt_velocity, run.normal_force);
    let point = point.with(settings);
    states
        .into_iter()
        .map(|(w, v)| point.clone().starting_at(fmu, w, v))
        .collect()
}

fn model_run(
    fmu: &Fmu,
    name: &str,
    point: &OperatingPoint,
    interval: f64,
    steps: usize,
) -> Result<Motion, Error> {
    let mut instance = fmu.instantiate(name)?;
    point.start(fmu, &mut instance)?;
    let has_sensor = fmu.description().find("measured_displacement").is_some();
    let displacement = if has_sensor {
        "measured_displacement"
    } else {
        "tip_displacement"
    };
    let recorded = record(
        fmu,
        &mut instance,
        &[displacement, "tip_velocity"],
        interval,
        steps,
    )?;
    let [displacement, velocity] =
        <[Vec<f64>; 2]>::try_from(recorded.values).expect("two outputs were asked for");
    Ok(Motion {
        displacement,
        velocity,
    })
}
