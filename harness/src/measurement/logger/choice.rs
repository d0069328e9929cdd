//! Which channel of a recording is what, and its values in SI units.

use super::super::Measurand;
use super::super::run_file::FEWEST_SAMPLES;
use super::role::{
    BELT_VELOCITY, CLAMP_ACCELERATION, EXTERNAL_FORCE, NORMAL_FORCE, Role, TIME, measures, role_of,
};
use super::{Channel, Recording, Trouble};
use crate::error::Error;

/// Where an input's values come from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// One value, SI units.
    Value(f64),
    /// A channel, sample by sample.
    Channel(String),
    /// The mean of a channel.
    Mean(String),
}

/// What to take from a recording; what is left out is found by names and units.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Channel of times.
    pub time: Option<String>,
    /// Channel of the displacement.
    pub displacement: Option<String>,
    /// Channel of the velocity, in place of a displacement.
    pub velocity: Option<String>,
    /// Channel of the acceleration, in place of a displacement.
    pub acceleration: Option<String>,
    /// Samples per second, for files without times.
    pub rate: Option<f64>,
    /// Belt velocity.
    pub belt_velocity: Option<Source>,
    /// Normal force.
    pub normal_force: Option<Source>,
    /// Force on the tip.
    pub external_force: Option<Source>,
    /// Acceleration of the clamp.
    pub clamp_acceleration: Option<Source>,
    /// Units in place of the file's: of what was measured at the tip, or of the channel named.
    pub units: Vec<(Option<String>, String)>,
    /// Factors behind the units: of what was measured at the tip, or of the channel named.
    pub scales: Vec<(Option<String>, f64)>,
    /// Whether samples without a number are left out, in place of an error.
    pub skip_missing: bool,
    /// First time that is taken, s.
    pub start: Option<f64>,
    /// Last time that is taken, s.
    pub end: Option<f64>,
}

/// An input of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// One value, SI units.
    Constant(f64),
    /// A value for each sample, SI units.
    Series(Vec<f64>),
}

/// A run in SI units.
#[derive(Debug, Clone)]
pub struct Imported {
    /// s; strictly increasing.
    pub time: Vec<f64>,
    /// What was measured at the tip.
    pub measurand: Measurand,
    /// Its values, m, m/s or m/s^2.
    pub measured: Vec<f64>,
    /// m/s.
    pub belt_velocity: Input,
    /// N.
    pub normal_force: Input,
    /// N, where there is one.
    pub external_force: Option<Input>,
    /// m/s^2, where there is one.
    pub clamp_acceleration: Option<Input>,
    /// What was understood, in one line.
    pub understood: String,
}

impl Recording {
    /// The run that a recording holds, in SI units.
    ///
    /// # Errors
    /// [`Error`] with file, channel, what was read and what to do: nothing fits, more than one channel does, units of something
    /// else, channels of different lengths, samples that are no numbers, times that do not rise.
    pub fn import(&self, wanted: &Wanted) -> Result<Imported, Error> {
        let taken = Taking {
            recording: self,
            wanted,
        };
        taken.run().map_err(|trouble| trouble.at(&self.path))
    }
}

pub(super) struct Taking<'a> {
    pub(super) recording: &'a Recording,
    pub(super) wanted: &'a Wanted,
}

impl Taking<'_> {
    /// What is stated of the tip's motion, and the channel.
    fn stated(&self) -> impl Iterator<Item = (Measurand, &String)> {
        let wanted = self.wanted;
        [
            (Measurand::Displacement, &wanted.displacement),
            (Measurand::Velocity, &wanted.velocity),
            (Measurand::Acceleration, &wanted.acceleration),
        ]
        .into_iter()
        .filter_map(|(measurand, name)| Some((measurand, name.as_ref()?)))
    }

    /// What was measured at the tip.
    pub(super) fn measurand(&self) -> Measurand {
        let stated = self.stated().next();
        stated.map_or_else(Measurand::default, |(measurand, _)| measurand)
    }

    fn run(&self) -> Result<Imported, Trouble> {
        let mut said: Vec<String> = Vec::new();
        let mut stated = self.stated();
        if let [Some((a, first)), Some((b, second))] = [stated.next(), stated.next()] {
            let (a, b) = (role_of(a).option, role_of(b).option);
            return Err(Trouble::new(
                format!(
                    "{a} {first} and {b} {second} are two measured quantities, and a run holds one"
                ),
                "leave one of the two out",
            ));
        }
        let measurand = self.measurand();
        let channel = match self.stated().next() {
            Some((Measurand::Velocity | Measurand::Acceleration, name)) => {
                self.named(name, role_of(measurand))?
            }
            _ => self.displacement()?,
        };
        let measured = self.values(channel, role_of(measurand), &mut said)?;
        let count = measured.len();
        let mut told = vec![self.recording.format.to_owned()];
        told.extend(self.recording.remarks.iter().cloned());
        let time = self.time(channel, count, &mut told)?;
        told.append(&mut said);
        let belt_velocity = self.input(
            &BELT_VELOCITY,
            &self.wanted.belt_velocity,
            channel,
            count,
            &mut told,
        )?;
        let normal_force = self.input(
            &NORMAL_FORCE,
            &self.wanted.normal_force,
            channel,
            count,
            &mut told,
        )?;
        let external_force = self.input(
            &EXTERNAL_FORCE,
            &self.wanted.external_force,
            channel,
            count,
            &mut told,
        )?;
        let clamp_acceleration = self.input(
            &CLAMP_ACCELERATION,
            &self.wanted.clamp_acceleration,
            channel,
            count,
            &mut told,
        )?;
        let needed = |input: Option<Input>, role: &Role, how: &str| {
            input.ok_or_else(|| {
                Trouble::new(
                    format!("no channel is {}{}", role.words, self.there()),
                    format!(
                        "state it with {} and a value in {} ({how}) or a channel's name",
                        role.option, role.unit
                    ),
                )
            })
        };
        let belt_velocity = needed(belt_velocity, &BELT_VELOCITY, "0 without a belt")?;
        let normal_force = needed(normal_force, &NORMAL_FORCE, "0 without contact")?;
        let mut run = Imported {
            time,
            measurand,
            measured,
            belt_velocity,
            normal_force,
            external_force,
            clamp_acceleration,
            understood: String::new(),
        };
        if let Input::Series(values) = &run.normal_force
            && let Some(at) = values.iter().position(|force| *force < 0.0)
        {
            return Err(Trouble::new(
                format!(
                    "sample {}: normal force {} N is below zero, which means no contact",
                    at + 1,
                    values[at]
                ),
                "turn its sign with --scale NAME=-1, or leave these samples out with --start and --end",
            ));
        }
        self.sort_out(&mut run, channel, &mut told)?;
        run.understood = told.join("; ");
        Ok(run)
    }

    /// Leaves out what is missing or beyond the ends, and checks the times.
    fn sort_out(
        &self,
        run: &mut Imported,
        channel: &Channel,
        told: &mut Vec<String>,
    ) -> Result<(), Trouble> {
        let start = self.wanted.start.unwrap_or(f64::NEG_INFINITY);
        let end = self.wanted.end.unwrap_or(f64::INFINITY);
        let mut missing = 0;
        let mut keep = Vec::with_capacity(run.time.len());
        let series = [
            (role_of(run.measurand).words, Some(&run.measured)),
            (TIME.words, Some(&run.time)),
            (BELT_VELOCITY.words, series(Some(&run.belt_velocity))),
            (NORMAL_FORCE.words, series(Some(&run.normal_force))),
            (EXTERNAL_FORCE.words, series(run.external_force.as_ref())),
            (
                CLAMP_ACCELERATION.words,
                series(run.clamp_acceleration.as_ref()),
            ),
        ];
        for i in 0..run.time.len() {
            let inside = run.time[i] >= start && run.time[i] <= end || run.time[i].is_nan();
            let lacking = series
                .iter()
                .find(|(_, values)| values.is_some_and(|v| !v[i].is_finite()));
            if inside && let Some((words, values)) = lacking {
                let value = values.map_or(f64::NAN, |v| v[i]);
                if value.is_infinite() || !self.wanted.skip_missing {
                    return Err(Trouble::new(
                        format!(
                            "sample {} of {words} is {value}, not a finite number",
                            i + 1
                        ),
                        "repair it, or leave such samples out as gaps with --skip-missing",
                    )
                    .of(&channel.name));
                }
                missing += 1;
            }
            keep.push(inside && lacking.is_none());
        }
        if missing > 0 {
            told.push(format!("{missing} of {} samples missing", run.time.len()));
        }
        let filter = |values: &mut Vec<f64>| {
            let mut kept = keep.iter();
            values.retain(|_| kept.next().copied().unwrap_or(false));
        };
        filter(&mut run.time);
        filter(&mut run.measured);
        let inputs = [
            Some(&mut run.belt_velocity),
            Some(&mut run.normal_force),
            run.external_force.as_mut(),
            run.clamp_acceleration.as_mut(),
        ];
        for input in inputs.into_iter().flatten() {
            if let Input::Series(values) = input {
                filter(values);
            }
        }
        if let Some(at) = (1..run.time.len()).find(|i| !(run.time[*i] > run.time[*i - 1])) {
            return Err(Trouble::new(
                format!(
                    "sample {}: time {} s does not come after {} s of the sample before",
                    at + 1,
                    run.time[at],
                    run.time[at - 1]
                ),
                "is this the channel of times? name it with --time, or state --rate",
            ));
        }
        if run.time.len() < FEWEST_SAMPLES {
            return Err(Trouble::new(
                format!(
                    "{} samples, at least {FEWEST_SAMPLES} are needed",
                    run.time.len()
                ),
                "is the file cut off, or do --start and --end leave too little?",
            )
            .of(&channel.name));
        }
        Ok(())
    }

    fn input(
        &self,
        role: &Role,
        source: &Option<Source>,
        of: &Channel,
        count: usize,
        told: &mut Vec<String>,
    ) -> Result<Option<Input>, Trouble> {
        let words = role.words.trim_start_matches("the ");
        let channel = match source {
            Some(Source::Value(value)) => {
                told.push(format!("{words} {value} {}", role.unit));
                return Ok(Some(Input::Constant(*value)));
            }
            Some(Source::Channel(name) | Source::Mean(name)) => self.named(name, role)?,
            None => {
                let fits = |c: &&Channel| {
                    role.is_named(c)
                        && c.name != of.name
                        && (measures(c, role.quantity) || c.unit().is_empty())
                };
                let found: Vec<&Channel> = self.recording.channels.iter().filter(fits).collect();
                match found.as_slice() {
                    [] => return Ok(None),
                    [one] => *one,
                    several => return Err(self.several(several, role)),
                }
            }
        };
        let values = self.values(channel, role, told)?;
        if let Some(Source::Mean(_)) = source {
            let there: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
            let mean = there.iter().sum::<f64>() / there.len() as f64;
            told.push(format!("its mean {mean:.6} {}", role.unit));
            return Ok(Some(Input::Constant(mean)));
        }
        self.same_length(channel, values.len(), of, count)?;
        Ok(Some(Input::Series(values)))
    }
}

fn series(input: Option<&Input>) -> Option<&Vec<f64>> {
    match input {
        Some(Input::Series(values)) => Some(values),
        _ => None,
    }
}
