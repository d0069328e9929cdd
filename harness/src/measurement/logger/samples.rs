//! Runs given as samples in memory, by programs that call the library.

use std::path::Path;

use super::super::Measurand;
use super::{Imported, Input, Trouble};
use crate::error::Error;

impl Imported {
    /// A run of samples in SI units: times in s, what was measured at the tip, belt velocity in m/s, normal force in N, and external
    /// force in N and acceleration of the clamp in m/s^2 where there is one. `name` is what
    /// messages call it.
    ///
    /// # Errors
    /// [`Error::LoggerFile`] with the quantity: times that don't rise, values that are no numbers, lists of different lengths,
    /// a negative normal force.
    pub fn of_samples(
        name: &str,
        measurand: Measurand,
        (time, measured): (Vec<f64>, Vec<f64>),
        belt_velocity: Input,
        normal_force: Input,
        [external_force, clamp_acceleration]: [Option<Input>; 2],
    ) -> Result<Imported, Error> {
        let refuse = |quantity: &str, problem: String, remedy: &str| {
            let trouble = Trouble::new(problem, remedy);
            Err(trouble.of(quantity).at(Path::new(name)))
        };
        let samples = time.len();
        let mut lists = vec![("time", &time), (measurand.name(), &measured)];
        let constants = [
            ("belt_velocity", Some(&belt_velocity)),
            ("normal_force", Some(&normal_force)),
            ("external_force", external_force.as_ref()),
            ("clamp_acceleration", clamp_acceleration.as_ref()),
        ];
        for (quantity, input) in constants {
            match input {
                Some(Input::Series(values)) => lists.push((quantity, values)),
                Some(Input::Constant(value)) if !value.is_finite() => {
                    return refuse(
                        quantity,
                        format!("{value} is no number"),
                        "give a finite one",
                    );
                }
                _ => {}
            }
        }
        for (quantity, values) in lists {
            if values.len() != samples {
                let problem = format!("{} values for {samples} times", values.len());
                return refuse(quantity, problem, "give one for each time");
            }
            if let Some(k) = values.iter().position(|v| !v.is_finite()) {
                let problem = format!("sample {k} (counted from 0) is {}", values[k]);
                return refuse(
                    quantity,
                    problem,
                    "leave missing samples out, with their times",
                );
            }
        }
        if let Some(k) = time.windows(2).position(|pair| pair[1] <= pair[0]) {
            let problem = format!("{} s comes after {} s", time[k + 1], time[k]);
            return refuse("time", problem, "give times in s that rise");
        }
        let least = match &normal_force {
            Input::Constant(value) => *value,
            Input::Series(values) => values.iter().copied().fold(f64::INFINITY, f64::min),
        };
        if least < 0.0 {
            return refuse(
                "normal_force",
                format!("{least} N is negative"),
                "turn its sign where it points the other way",
            );
        }
        Ok(Imported {
            time,
            measurand,
            measured,
            belt_velocity,
            normal_force,
            external_force,
            clamp_acceleration,
            understood: "samples in SI units".to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(time: &[f64], displacement: &[f64], force: f64) -> Result<Imported, Error> {
        let lists = (time.to_vec(), displacement.to_vec());
        let (belt, load) = (Input::Series(vec![0.1; 3]), Input::Constant(force));
        Imported::of_samples(
            "run 7",
            Measurand::Displacement,
            lists,
            belt,
            load,
            [None, None],
        )
    }

    #[test]
    fn samples_that_make_no_run_are_refused_with_the_quantity_and_the_place() {
        assert!(of(&[0.0, 0.1, 0.2], &[1.0, 2.0, 3.0], 0.0).is_ok());
        for (time, displacement, force, said) in [
            (
                [0.0, 0.1, 0.2],
                &[1.0, 2.0][..],
                1.0,
                "2 values for 3 times",
            ),
            (
                [0.0, 0.2, 0.2],
                &[1.0, 2.0, 3.0],
                1.0,
                "0.2 s comes after 0.2 s",
            ),
            ([0.0, 0.1, 0.2], &[1.0, f64::NAN, 3.0], 1.0, "sample 1"),
            ([0.0, 0.1, 0.2], &[1.0, 2.0, 3.0], -1.0, "-1 N is negative"),
            (
                [0.0, 0.1, 0.2],
                &[1.0, 2.0, 3.0],
                f64::NAN,
                "NaN is no number",
            ),
        ] {
            let error = of(&time, displacement, force).unwrap_err().to_string();
            assert!(error.contains(said) && error.contains("run 7"), "{error}");
        }
    }
}
