//! The motions that the model makes at a run's operating point.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::further::Further;
use super::measured_start::measured_start;
use crate::command::operating_point::{OperatingPoint, record_driven};
use crate::diagnose::model::references::output_of;
use crate::error::Error;
use crate::fmu::{Drive, Fmu};
use crate::measurement::{BeamKnowledge, Measurand, Run};
use crate::metric::ModelMotion;
use crate::parallel::parallel;
use crate::watch::Watch;

/// The model runs at least this many measured periods, and this share of the record, before it is compared: long enough
/// to forget that its start state is known at the tip only.
const SETTLE_PERIODS: f64 = 20.0;
const SETTLE_SHARE: f64 = 0.5;
/// The model can be shifted by this many periods either way to fit the record.
const SHIFT_PERIODS: f64 = 2.0;

/// One motion of the tip from its start on, evenly sampled.
pub(super) struct Motion {
    /// As the sensor shows it, m.
    pub displacement: Vec<f64>,
    /// m/s.
    pub velocity: Vec<f64>,
    /// m/s^2; empty unless asked for.
    pub acceleration: Vec<f64>,
    /// What each further sensor reads, in its SI unit.
    pub further: Vec<Vec<f64>>,
}

impl Motion {
    /// What a sensor shows of it.
    fn of(&self, measurand: Measurand) -> &[f64] {
        match measurand {
            Measurand::Displacement => &self.displacement,
            Measurand::Velocity => &self.velocity,
            Measurand::Acceleration => &self.acceleration,
        }
    }
}

/// Records of up to this many samples are compared as a whole; longer ones block by block with the same motions, so that the
/// work grows with the record and not with its square.
const WHOLE_SAMPLES: f64 = 20_000.0;
/// Length of such a block, and of the motions' way from their start that is looked at, in measured periods.
const BLOCK_PERIODS: f64 = 32.0;

/// How much longer than what is compared with it the model runs, in samples.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Lead {
    /// After this the model has settled.
    settle: usize,
    /// By this much it can be shifted against the record, either way.
    shift: usize,
    /// Of the way from the start to the settled motion this much is compared.
    way: usize,
    /// Longest piece of the record that is compared at once; `None` is all of it.
    block: Option<usize>,
}

impl Lead {
    /// For a record of this `period`, `duration` and sample `interval`, s.
    pub fn of(period: f64, duration: f64, interval: f64) -> Lead {
        let samples = |time: f64| (time / interval).round() as usize;
        let shift = samples(SHIFT_PERIODS * period);
        if duration <= WHOLE_SAMPLES * interval {
            let settle = samples((SETTLE_PERIODS * period).max(SETTLE_SHARE * duration));
            return Lead {
                settle,
                shift,
                way: settle,
                block: None,
            };
        }
        let share = SETTLE_SHARE * WHOLE_SAMPLES * interval;
        let settle = samples(
            (SETTLE_PERIODS * period)
                .max(share)
                .min(SETTLE_SHARE * duration),
        );
        let block = samples((BLOCK_PERIODS * period).min(duration));
        Lead {
            settle,
            shift,
            way: settle.min(block),
            block: Some(block),
        }
    }

    /// Longest piece of the record that is compared at once, s.
    pub fn block(&self, interval: f64) -> f64 {
        self.block
            .map_or(f64::INFINITY, |samples| samples as f64 * interval)
    }

    /// Steps that the model makes from each start state, and from the measured one, for a record of `steps` intervals.
    fn model_steps(&self, steps: usize) -> (usize, usize) {
        let reach = 2 * self.shift + 2;
        match self.block {
            None => (self.settle + reach + steps, 0),
            Some(block) => (self.settle + reach + block, reach + steps),
        }
    }
}

/// The motions of the model at a run's operating point.
pub(super) struct Motions {
    /// From every start state.
    from_grid: Vec<Motion>,
    /// Through the whole of a long record, from the measured state: what changes slowly, such as friction that drifts, shows
    /// here at its time.
    throughout: Option<Motion>,
    lead: Lead,
}

/// A piece of a motion, long enough to be shifted against the record.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    motion: &'a Motion,
    first: usize,
    past: usize,
    shift: usize,
    has_clock: bool,
}

impl Motions {
    /// One motion that is compared as it is, from its start on.
    pub fn of_one(motion: Motion) -> Motions {
        Motions {
            from_grid: vec![motion],
            throughout: None,
            lead: Lead::default(),
        }
    }

    /// The pieces to compare: each motion settled, and each motion from its start on. A measured rig may still be on its
    /// way from an unknown start, which takes seconds, or have arrived.
    pub fn pieces(&self) -> Vec<Piece<'_>> {
        let Lead {
            settle, shift, way, ..
        } = self.lead;
        let whole = |motion| Piece {
            motion,
            first: 0,
            past: motion.displacement.len(),
            shift,
            has_clock: false,
        };
        let settled = self.from_grid.iter().map(|motion| Piece {
            first: settle,
            ..whole(motion)
        });
        let under_way = self.from_grid.iter().map(|motion| Piece {
            past: motion.displacement.len() + way - settle,
            ..whole(motion)
        });
        let throughout = self.throughout.iter().map(|motion| Piece {
            has_clock: true,
            ..whole(motion)
        });
        settled.chain(under_way).chain(throughout).collect()
    }

    /// Longest piece of the record that is compared at once, s.
    pub fn block(&self, interval: f64) -> f64 {
        self.lead.block(interval)
    }
}

impl<'a> Piece<'a> {
    /// What a sensor shows in the record's time, m, m/s or m/s^2.
    pub fn measured(self, measurand: Measurand, interval: f64) -> ModelMotion<'a> {
        self.view(self.motion.of(measurand), interval)
    }

    /// The velocity beside a displacement, m/s, or the displacement beside a velocity or an acceleration, m, in the record's time.
    pub fn other(self, measurand: Measurand, interval: f64) -> ModelMotion<'a> {
        let other = match measurand {
            Measurand::Displacement => Measurand::Velocity,
            Measurand::Velocity | Measurand::Acceleration => Measurand::Displacement,
        };
        self.measured(other, interval)
    }

    /// What each further sensor reads, in the record's time.
    pub fn further(self, interval: f64) -> Vec<ModelMotion<'a>> {
        let sensors = self.motion.further.iter();
        sensors.map(|values| self.view(values, interval)).collect()
    }

    fn view(self, values: &'a [f64], interval: f64) -> ModelMotion<'a> {
        let reach = self.shift as f64 * interval;
        ModelMotion {
            start: -reach,
            interval,
            values: &values[self.first..self.past],
            reach: if self.has_clock { reach } else { f64::INFINITY },
        }
    }

    /// Even samples of what a sensor shows over the record, or as far as the piece goes.
    pub fn samples(self, measurand: Measurand, count: usize) -> &'a [f64] {
        let first = self.first + self.shift;
        &self.motion.of(measurand)[first..(first + count).min(self.past)]
    }
}

/// Runs the model from every start state, with `settings` beside what is known of the beam and before it; without `lead` (no period to settle for) from the measured one only.
pub(super) fn model_motions(
    fmu: &Fmu,
    beam: &BeamKnowledge,
    (run, further): (&Run, &Further),
    lead: Lead,
    settings: &[(String, f64)],
    watch: &dyn Watch,
) -> Result<Motions, Error> {
    let interval = run.sample_interval();
    let (steps, throughout) = lead.model_steps((run.duration() / interval).ceil() as usize);
    let count = if lead.shift == 0 { 1 } else { usize::MAX };
    let starts = starts(fmu, beam, run, settings);
    let long = (throughout > 0).then_some((&starts[0], throughout));
    // The longest first, so that no processor waits for it at the end.
    let jobs: Vec<(&OperatingPoint, usize)> = long
        .into_iter()
        .chain(starts.iter().take(count).map(|point| (point, steps)))
        .collect();
    let done = AtomicUsize::new(0);
    let mut motions = parallel(&jobs, |(point, steps)| {
        let motion = model_run(fmu, (run, further), point, (interval, *steps), None)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        watch.step(&run.name, done, jobs.len());
        Ok(motion)
    })?;
    Ok(Motions {
        throughout: long.is_some().then(|| motions.remove(0)),
        from_grid: motions,
        lead,
    })
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
    let (first, farthest) = measured_start(fmu, beam, run);
    // Released from farther than it ever was, it tends to the small motion.
    let bends = [0.0, 0.5, 0.8, 1.0, 1.3];
    let speeds = [0.0, 0.5, 1.0];
    let grid = bends.iter().flat_map(|bend| {
        speeds
            .iter()
            .map(move |speed| (bend * farthest, speed * run.belt_velocity))
    });
    let states = std::iter::once(first).chain(grid);
    let point = OperatingPoint::of_beam(fmu, beam, run.belt_velocity, run.normal_force);
    let point = point.with(settings);
    states
        .into_iter()
        .map(|(w, v)| point.clone().starting_at(fmu, w, v))
        .collect()
}

/// The model from `point` on, with what the sensors of `run` show: samples at an interval in s, and how many steps.
pub(super) fn model_run(
    fmu: &Fmu,
    (run, further): (&Run, &Further),
    point: &OperatingPoint,
    samples: (f64, usize),
    drive: Option<&Drive>,
) -> Result<Motion, Error> {
    let mut instance = match drive {
        Some(drive) => drive.instance(fmu, &run.name)?,
        None => fmu.instantiate(&run.name)?,
    };
    point.start_driven(fmu, &mut instance, drive)?;
    let wanted = match run.measurand {
        Measurand::Displacement | Measurand::Velocity => &Measurand::ALL[..2],
        Measurand::Acceleration => &Measurand::ALL[..],
    };
    let outputs = wanted.iter().map(|measurand| output_of(fmu, *measurand));
    let mut outputs: Vec<&str> = outputs
        .map(|variable| variable.map(|found| found.name.as_str()))
        .collect::<Result<_, _>>()?;
    let own = outputs.len();
    outputs.extend(further.outputs().iter().map(String::as_str));
    let recorded = record_driven(fmu, &mut instance, &outputs, samples, drive, &())?;
    let mut recorded = recorded.values;
    let further = further.read(&recorded.split_off(own));
    let mut columns = recorded.into_iter();
    let mut next = || columns.next().unwrap_or_default();
    Ok(Motion {
        displacement: next(),
        velocity: next(),
        acceleration: next(),
        further,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of all motions of a record of `samples` samples at 10 kHz with cycles of 30 ms.
    fn all_steps(samples: usize) -> usize {
        let steps = samples - 1;
        let lead = Lead::of(0.03, steps as f64 * 1e-4, 1e-4);
        let (grid, throughout) = lead.model_steps(steps);
        16 * grid + throughout
    }

    #[test]
    fn regress_the_model_runs_no_longer_than_in_proportion_to_a_long_record() {
        // Twice the record may at most double the work; 100 times the longest one compared whole costs far less than 100 times.
        for samples in [25_000, 100_000, 1_000_000] {
            assert!(
                all_steps(2 * samples) <= 2 * all_steps(samples),
                "{samples}"
            );
        }
        assert!(all_steps(2_000_000) < 5 * all_steps(20_000));
    }

    #[test]
    fn a_short_record_is_compared_as_a_whole() {
        let lead = Lead::of(0.03, 0.8, 1e-4);
        assert_eq!(lead.block(1e-4), f64::INFINITY);
        assert_eq!(lead.model_steps(8000), (6000 + 2 * 600 + 2 + 8000, 0));
    }
}
