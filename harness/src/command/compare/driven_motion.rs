//! Runs that have their place in time: driven from outside, or free and dying out. There is nothing to settle and nothing to
//! align: the model starts as the record does, gets the same inputs, and is compared sample by sample.

use super::further::Further;
use super::model_motion::{Motion, Motions, model_run};
use crate::command::operating_point::OperatingPoint;
use crate::error::Error;
use crate::fmu::{Drive, Fmu};
use crate::measurement::{BeamKnowledge, Measurand, Run};
use crate::metric::{standard_deviation, velocity};

/// Samples from which the start state is fitted: some periods of what a record resolves.
const START_SAMPLES: usize = 64;
/// Samples to either side for the velocity from which the fit starts.
const HALF_WIDTH: usize = 2;
/// Steps of the fit, which is quadratic near its end.
const FIT_STEPS: usize = 6;
/// Change of the start, as a share of the record's standard deviation, by which the fit sees slopes.
const SLOPE: f64 = 1e-4;

/// The motion of the model beside a run with its own place in time.
pub(super) fn driven_motions(
    fmu: &Fmu,
    beam: &BeamKnowledge,
    (run, further): (&Run, &Further),
    settings: &[(String, f64)],
) -> Result<Motions, Error> {
    let drive = Drive::of_run(fmu, run)?;
    let mut point = OperatingPoint::of_beam(fmu, beam, run.belt_velocity, run.normal_force);
    for (name, _, excitation) in run.inputs.excitations() {
        if excitation.constant != 0.0 {
            point.settings.push((name.to_owned(), excitation.constant));
        }
    }
    let beside = Beside {
        fmu,
        run,
        further,
        drive,
        point: point.with(settings),
    };
    let start = beside.fitted_start()?;
    let steps = (run.duration() / run.sample_interval()).ceil() as usize + 2;
    Ok(Motions::of_one(beside.motion(start, steps)?))
}

/// The model beside a run.
struct Beside<'a> {
    fmu: &'a Fmu,
    run: &'a Run,
    further: &'a Further<'a>,
    drive: Drive,
    point: OperatingPoint,
}

impl Beside<'_> {
    /// From the tip at `start`: displacement in m, velocity in m/s.
    fn motion(&self, [displacement, velocity]: [f64; 2], steps: usize) -> Result<Motion, Error> {
        let point = self
            .point
            .clone()
            .starting_at(self.fmu, displacement, velocity);
        let interval = self.run.sample_interval();
        model_run(
            self.fmu,
            (self.run, self.further),
            &point,
            (interval, steps),
            Some(&self.drive),
        )
    }

    /// Model minus record over the first samples, m, m/s or m/s^2.
    fn error(&self, start: [f64; 2], time: &[f64]) -> Result<Vec<f64>, Error> {
        let interval = self.run.sample_interval();
        let steps = (time[time.len() - 1] / interval).ceil() as usize + 1;
        let motions = Motions::of_one(self.motion(start, steps)?);
        let model = motions.pieces()[0]
            .measured(self.run.measurand, interval)
            .at_all(time);
        let pairs = model.iter().zip(&self.run.measured);
        Ok(pairs.map(|(y, measured)| y - measured).collect())
    }

    /// Displacement and velocity of the tip with which the model meets the first samples best, by Gauss-Newton steps from the
    /// first sample and the slope there. A record at ten samples a period tells the velocity to a tenth by itself.
    fn fitted_start(&self) -> Result<[f64; 2], Error> {
        let run = self.run;
        let count = START_SAMPLES.min(run.time.len());
        let time: Vec<f64> = run.time[..count].iter().map(|t| t - run.time[0]).collect();
        let first = &run.measured[..count];
        let ends = 2 * HALF_WIDTH + 1;
        let slope = velocity(&time[..ends], &first[..ends], HALF_WIDTH)[0];
        let size = SLOPE * standard_deviation(&run.measured);
        let samples = 10.0 * run.sample_interval();
        // A velocity does not tell where the tip is, an acceleration not even how fast: the fit begins at rest.
        let (mut start, steps) = match run.measurand {
            Measurand::Displacement => ([first[0], slope], [size, size / samples]),
            Measurand::Velocity => ([0.0, first[0]], [size * samples, size]),
            Measurand::Acceleration => ([0.0; 2], [size * samples * samples, size * samples]),
        };
        let mut error = self.error(start, &time)?;
        if !(size > 0.0) {
            return Ok(start);
        }
        for _ in 0..FIT_STEPS {
            let slopes = [0, 1].map(|i| -> Result<Vec<f64>, Error> {
                let mut moved = start;
                moved[i] += steps[i];
                let there = self.error(moved, &time)?;
                let pairs = there.iter().zip(&error);
                Ok(pairs.map(|(a, b)| (a - b) / steps[i]).collect())
            });
            let [a, b] = slopes;
            let Some(change) = least_squares(&a?, &b?, &error) else {
                break;
            };
            let next = [start[0] - change[0], start[1] - change[1]];
            if !next.iter().all(|x| x.is_finite()) {
                break;
            }
            let after = self.error(next, &time)?;
            if !(square(&after) < (1.0 - 1e-6) * square(&error)) {
                break;
            }
            (start, error) = (next, after);
        }
        Ok(start)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn square(a: &[f64]) -> f64 {
    dot(a, a)
}

/// The two factors with which `a` and `b` add up to `y` best; `None` where they do not differ.
fn least_squares(a: &[f64], b: &[f64], y: &[f64]) -> Option<[f64; 2]> {
    let (aa, ab, bb) = (square(a), dot(a, b), square(b));
    let (ay, by) = (dot(a, y), dot(b, y));
    let determinant = aa * bb - ab * ab;
    let solved = [
        (bb * ay - ab * by) / determinant,
        (aa * by - ab * ay) / determinant,
    ];
    (determinant > 1e-12 * aa * bb).then_some(solved)
}
