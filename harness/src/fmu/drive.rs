//! Inputs that vary in time, given to an FMU piece by piece.

use std::ops::Range;

use super::{Causality, Fmu, Instance};
use crate::error::Error;
use crate::measurement::{InputTrack, Run};

/// Share of the shortest piece that is not worth a step of its own: rounding of sums of times.
const SLIVER: f64 = 1e-6;

/// What drives an instance, by value reference. Each piece of an input is a straight line: the FMU is given its value and
/// slope (`fmi2SetRealInputDerivatives`) where it can use them, and the value in the middle where it can't.
#[derive(Debug, Clone)]
pub struct Drive {
    inputs: Vec<Input>,
    has_slopes: bool,
}

/// One input: its value is `scale` times the track's.
#[derive(Debug, Clone)]
struct Input {
    reference: u32,
    track: InputTrack,
    scale: f64,
}

/// What inputs do over a motion, as the FMU's derivatives along a motion take it: over each piece an input acts as
/// `x (a + b (t - t_0))` with x the value of its variable.
#[derive(Debug, Clone, Default)]
pub struct Course {
    /// Value references of the inputs.
    pub references: Vec<u32>,
    /// Begins t_0 of the pieces in s.
    pub begins: Vec<f64>,
    /// Factors a, piece after piece, in the variables' units.
    pub factors: Vec<f64>,
    /// Their rates b per s.
    pub rates: Vec<f64>,
}

impl Drive {
    /// Of inputs by name.
    ///
    /// # Errors
    /// An FMU without such an input.
    pub fn of(fmu: &Fmu, tracks: Vec<(&str, InputTrack)>) -> Result<Drive, Error> {
        let with_reference = |(name, track): (&str, InputTrack)| {
            if fmu.variable(name)?.causality != Causality::Input {
                return Err(Error::VariableValue {
                    name: name.to_owned(),
                    kind: "not an input",
                    value: "a series".into(),
                    rule: "give columns of inputs alone: belt_velocity, normal_force, external_force, clamp_acceleration",
                });
            }
            Ok(Input {
                reference: fmu.real_references(&[name])?[0],
                track,
                scale: 1.0,
            })
        };
        Ok(Drive {
            inputs: tracks
                .into_iter()
                .map(with_reference)
                .collect::<Result<_, Error>>()?,
            has_slopes: fmu.description().capabilities.can_interpolate_inputs,
        })
    }

    /// What drove a run, its first sample at time 0.
    ///
    /// # Errors
    /// As [`Drive::of`].
    pub fn of_run(fmu: &Fmu, run: &Run) -> Result<Drive, Error> {
        let time: Vec<f64> = run.time.iter().map(|t| t - run.time[0]).collect();
        let tracks = run.inputs.series().map(|(name, series)| {
            let track = InputTrack::of(series, &time, least(name));
            (name, track)
        });
        Drive::of(fmu, tracks.collect())
    }

    /// What drove a run over the samples of `range` alone, each input times a scale; `references` gives both for an input's
    /// name. The run's first sample is at time 0.
    pub fn over(
        run: &Run,
        range: Range<usize>,
        has_slopes: bool,
        references: impl Fn(&str) -> (u32, f64),
    ) -> Drive {
        let input = |(name, series): (&str, &_)| {
            let (reference, scale) = references(name);
            Input {
                reference,
                track: InputTrack::within(series, &run.time, range.clone(), least(name)),
                scale,
            }
        };
        Drive {
            inputs: run.inputs.series().map(input).collect(),
            has_slopes,
        }
    }

    /// The pieces from `start` to `end`, both in s.
    pub fn course(&self, start: f64, end: f64) -> Course {
        let mut course = Course {
            references: self.inputs.iter().map(|i| i.reference).collect(),
            ..Course::default()
        };
        self.pieces(start, end, |t, next| {
            course.begins.push(t);
            for input in &self.inputs {
                let (value, rate) = input.track.piece(t, next);
                course.factors.push(value);
                course.rates.push(rate);
            }
            Ok(())
        })
        .expect("nothing can fail");
        course
    }

    /// Calls with begin and end of each piece from `now` to `next`, in s.
    fn pieces(
        &self,
        now: f64,
        next: f64,
        mut each: impl FnMut(f64, f64) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let sliver = SLIVER * (next - now);
        let mut t = now;
        while t < next {
            let knots = self.inputs.iter();
            let knot = knots.filter_map(|input| input.track.next_knot(t + sliver));
            let mut end = knot.fold(next, f64::min);
            if next - end < sliver {
                end = next;
            }
            each(t, end)?;
            t = end;
        }
        Ok(())
    }

    /// An instance that can be driven.
    ///
    /// # Errors
    /// An FMU that gives no instance.
    pub fn instance(&self, fmu: &Fmu, name: &str) -> Result<Instance, Error> {
        if self.has_slopes && !self.inputs.is_empty() {
            fmu.instantiate_driven(name)
        } else {
            fmu.instantiate(name)
        }
    }

    /// Sets the inputs as they are at `t` in s, before initialisation.
    ///
    /// # Errors
    /// Values that the FMU refuses.
    pub fn begin(&self, instance: &mut Instance, t: f64) -> Result<(), Error> {
        for input in &self.inputs {
            let value = input.scale * input.track.piece(t, t).0;
            instance.set_real(&[input.reference], &[value])?;
        }
        Ok(())
    }

    /// Takes an instance from `now` to `next`, both in s.
    ///
    /// # Errors
    /// Values that the FMU refuses, a motion that it can't follow.
    pub fn advance(&self, instance: &mut Instance, now: f64, next: f64) -> Result<(), Error> {
        self.pieces(now, next, |t, end| {
            for input in &self.inputs {
                let (value, rate) = input.track.piece(t, end);
                let (value, rate) = (input.scale * value, input.scale * rate);
                if self.has_slopes {
                    instance.set_real(&[input.reference], &[value])?;
                    instance.set_input_rates(&[input.reference], &[rate])?;
                } else {
                    let middle = value + 0.5 * rate * (end - t);
                    instance.set_real(&[input.reference], &[middle])?;
                }
            }
            instance.do_step(t, end - t)
        })
    }
}

/// Least value of an input: interpolation must not make a force pull that presses.
fn least(name: &str) -> f64 {
    match name {
        "normal_force" => 0.0,
        _ => f64::NEG_INFINITY,
    }
}
