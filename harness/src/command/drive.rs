//! Inputs that vary in time, given to an FMU piece by piece.

use crate::error::Error;
use crate::fmu::{Causality, Fmu, Instance};
use crate::measurement::{InputTrack, Run};

/// Share of the shortest piece that is not worth a step of its own: rounding of sums of times.
const SLIVER: f64 = 1e-6;

/// What drives an instance, by value reference. Each piece of an input is a straight line: the FMU is given its value and
/// slope (`fmi2SetRealInputDerivatives`) where it can use them, and the value in the middle where it can't.
#[derive(Debug, Clone)]
pub struct Drive {
    inputs: Vec<(u32, InputTrack)>,
    has_slopes: bool,
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
                    rule: "give columns of inputs alone: belt_velocity, normal_force, external_force",
                });
            }
            let reference = fmu.real_references(&[name])?[0];
            Ok((reference, track))
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
            let least = match name {
                "normal_force" => 0.0,
                _ => f64::NEG_INFINITY,
            };
            (name, InputTrack::of(series, &time, least))
        });
        Drive::of(fmu, tracks.collect())
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
        for (reference, track) in &self.inputs {
            instance.set_real(&[*reference], &[track.piece(t, t).0])?;
        }
        Ok(())
    }

    /// Takes an instance from `now` to `next`, both in s.
    ///
    /// # Errors
    /// Values that the FMU refuses, a motion that it can't follow.
    pub fn advance(&self, instance: &mut Instance, now: f64, next: f64) -> Result<(), Error> {
        let mut t = now;
        while t < next {
            let sliver = SLIVER * (next - now);
            let knots = self.inputs.iter();
            let knot = knots.filter_map(|(_, track)| track.next_knot(t + sliver));
            let mut end = knot.fold(next, f64::min);
            if next - end < sliver {
                end = next;
            }
            for (reference, track) in &self.inputs {
                let (value, rate) = track.piece(t, end);
                if self.has_slopes {
                    instance.set_real(&[*reference], &[value])?;
                    instance.set_input_rates(&[*reference], &[rate])?;
                } else {
                    let middle = value + 0.5 * rate * (end - t);
                    instance.set_real(&[*reference], &[middle])?;
                }
            }
            instance.do_step(t, end - t)?;
            t = end;
        }
        Ok(())
    }
}
