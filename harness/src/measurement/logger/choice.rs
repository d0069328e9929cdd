//! Which channel of a recording is what, and its values in SI units.

use super::super::unit::{Quantity, Unit};
use super::super::{FEWEST_SAMPLES, Measurand};
use super::{Channel, Recording, Trouble, names};
use crate::error::Error;
use crate::wording::{nearest, quoted, suggestion};

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

/// What a channel is to be.
struct Role {
    words: &'static str,
    quantity: Quantity,
    unit: &'static str,
    option: &'static str,
    /// Names that say so, in lower case, letters and digits alone.
    names: &'static [&'static str],
}

const TIME: Role = Role {
    words: "the time",
    quantity: Quantity::Time,
    unit: "s",
    option: "--time",
    names: &[
        "time",
        "times",
        "t",
        "zeit",
        "timestamp",
        "timems",
        "timeus",
        "tms",
        "ts",
    ],
};
const DISPLACEMENT: Role = Role {
    words: "the displacement",
    quantity: Quantity::Length,
    unit: "m",
    option: "--displacement",
    names: &[
        "tipdisplacementm",
        "tipdisplacement",
        "displacement",
        "displacementm",
        "disp",
        "x",
        "w",
        "xm",
        "wm",
        "deflection",
        "position",
        "laser",
        "weg",
    ],
};
/// Found by name alone: the belt has a velocity too.
const VELOCITY: Role = Role {
    words: "the velocity",
    quantity: Quantity::Velocity,
    unit: "m/s",
    option: "--velocity",
    names: &[],
};
/// Found by name alone, as a velocity.
const ACCELERATION: Role = Role {
    words: "the acceleration",
    quantity: Quantity::Acceleration,
    unit: "m/s^2",
    option: "--acceleration",
    names: &[],
};
const BELT_VELOCITY: Role = Role {
    words: "the belt velocity",
    quantity: Quantity::Velocity,
    unit: "m/s",
    option: "--belt-velocity",
    names: &[
        "beltvelocitympers",
        "beltvelocity",
        "beltspeed",
        "vbelt",
        "vb",
        "v0",
        "belt",
    ],
};
const NORMAL_FORCE: Role = Role {
    words: "the normal force",
    quantity: Quantity::Force,
    unit: "N",
    option: "--normal-force",
    names: &[
        "normalforcen",
        "normalforce",
        "fn",
        "fnormal",
        "normalload",
        "load",
    ],
};
const EXTERNAL_FORCE: Role = Role {
    words: "the external force",
    quantity: Quantity::Force,
    unit: "N",
    option: "--external-force",
    names: &[
        "externalforcen",
        "externalforce",
        "fext",
        "shaker",
        "shakerforce",
        "hammer",
        "motorforce",
    ],
};
const CLAMP_ACCELERATION: Role = Role {
    words: "the acceleration of the clamp",
    quantity: Quantity::Acceleration,
    unit: "m/s^2",
    option: "--clamp-acceleration",
    names: &[
        "clampaccelerationmpers2",
        "clampacceleration",
        "baseacceleration",
        "aclamp",
        "abase",
    ],
};

const RATES: [&str; 6] = [
    "fs",
    "rate",
    "samplerate",
    "samplingrate",
    "samplingfrequency",
    "sr",
];
const INTERVALS: [&str; 5] = ["dt", "ts", "deltat", "sampleinterval", "samplinginterval"];

/// Letters and digits of a name, in lower case.
fn plain(name: &str) -> String {
    let kept = name.chars().filter(|c| c.is_alphanumeric());
    kept.flat_map(char::to_lowercase).collect()
}

pub(super) fn is_time_name(name: &str) -> bool {
    TIME.names.contains(&plain(name).as_str())
}

impl Role {
    fn is_named(&self, channel: &Channel) -> bool {
        self.names.contains(&plain(channel.last_name()).as_str())
    }
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

struct Taking<'a> {
    recording: &'a Recording,
    wanted: &'a Wanted,
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
    fn measurand(&self) -> Measurand {
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

    fn displacement(&self) -> Result<&Channel, Trouble> {
        let role = &DISPLACEMENT;
        if let Some(name) = &self.wanted.displacement {
            return self.named(name, role);
        }
        // A unit stated without a name is that of the displacement: it makes no channel one.
        let all = &self.recording.channels;
        let lengths: Vec<&Channel> = all
            .iter()
            .filter(|c| measures(c, Quantity::Length))
            .collect();
        let by_name = |among: &[&'_ Channel]| -> Vec<usize> {
            (0..among.len())
                .filter(|i| role.is_named(among[*i]))
                .collect()
        };
        match lengths.as_slice() {
            [one] => return Ok(one),
            [] => {}
            several => {
                return match by_name(several).as_slice() {
                    [one] => Ok(several[*one]),
                    _ => Err(self.several(several, role)),
                };
            }
        }
        let others: Vec<&Channel> = all
            .iter()
            .filter(|c| !is_time_name(c.last_name()) && !measures(c, Quantity::Time))
            .collect();
        let without: Vec<&Channel> = others
            .iter()
            .copied()
            .filter(|c| may_be_scaled(c))
            .collect();
        match by_name(&without).as_slice() {
            [one] => return Ok(without[*one]),
            [] => {}
            _ => {
                let named: Vec<&Channel> =
                    without.into_iter().filter(|c| role.is_named(c)).collect();
                return Err(self.several(&named, role));
            }
        }
        // The only channel there is, whatever it is called; what it measures is looked at later.
        if let [one] = others.as_slice() {
            return Ok(one);
        }
        Err(Trouble::new(
            format!(
                "no channel is {} by its unit or name{}",
                role.words,
                self.there()
            ),
            "name it with --displacement",
        ))
    }

    /// `; there are 'x' in V, 't' in s`.
    fn there(&self) -> String {
        let shown: Vec<String> = self
            .recording
            .channels
            .iter()
            .take(12)
            .map(|c| match c.unit() {
                "" => format!("'{}'", c.name),
                unit => format!("'{}' in {unit}", c.name),
            })
            .collect();
        let more = match self.recording.channels.len() {
            0..=12 => String::new(),
            many => format!(" and {} more (--list shows all)", many - 12),
        };
        format!(", there are {}{more}", shown.join(", "))
    }

    fn several(&self, found: &[&Channel], role: &Role) -> Trouble {
        let names: Vec<String> = found.iter().map(|c| c.name.clone()).collect();
        Trouble::new(
            format!(
                "{} may all be {}, and one is needed",
                quoted(&names),
                role.words
            ),
            format!("name it with {}", role.option),
        )
    }

    /// The channel of this name: whole, or without its groups where that is one.
    fn named(&self, name: &str, role: &Role) -> Result<&Channel, Trouble> {
        let all = &self.recording.channels;
        let (bare, _, _) = names::taken_apart(name);
        let ways: [&dyn Fn(&Channel) -> bool; 4] = [
            &|c| c.name == name,
            &|c| c.last_name() == name,
            &|c| c.name == bare || c.last_name() == bare,
            &|c| c.last_name().eq_ignore_ascii_case(name),
        ];
        for fits in ways {
            let found: Vec<&Channel> = all.iter().filter(|c| fits(c)).collect();
            match found.as_slice() {
                [] => {}
                [one] => return Ok(one),
                several => return Err(self.several(several, role)),
            }
        }
        let near = nearest(name, all.iter().map(|c| c.name.as_str()));
        Err(Trouble::new(
            format!(
                "no channel '{name}' for {}{}{}",
                role.words,
                self.there(),
                suggestion(&near)
            ),
            format!("give one of them with {}", role.option),
        ))
    }

    /// Values in SI units.
    fn values(
        &self,
        channel: &Channel,
        role: &Role,
        told: &mut Vec<String>,
    ) -> Result<Vec<f64>, Trouble> {
        let values = channel.values.as_ref().map_err(Clone::clone)?;
        if values.is_empty() || values.iter().all(|v| v.is_nan()) {
            return Err(Trouble::new(
                format!("{} samples and not one number among them", values.len()),
                format!(
                    "name another channel with {}, or record it again",
                    role.option
                ),
            )
            .of(&channel.name));
        }
        let factor = self.factor(channel, role, told)?;
        Ok(match factor == 1.0 {
            true => values.clone(),
            false => values.iter().map(|v| v * factor).collect(),
        })
    }

    /// The factor to SI units, in words too.
    fn factor(
        &self,
        channel: &Channel,
        role: &Role,
        told: &mut Vec<String>,
    ) -> Result<f64, Trouble> {
        let is_measured = [DISPLACEMENT.option, VELOCITY.option].contains(&role.option);
        let is_meant = |name: &Option<String>| match name {
            None => is_measured,
            Some(name) => channel.name == *name || channel.last_name() == name,
        };
        // What is stated for a channel by its name goes before what is stated for the measured one.
        let mut scales: Vec<_> = self
            .wanted
            .scales
            .iter()
            .filter(|s| is_meant(&s.0))
            .collect();
        scales.sort_by_key(|s| s.0.is_none());
        let scale = scales.first().map(|s| s.1);
        let mut units: Vec<_> = self
            .wanted
            .units
            .iter()
            .filter(|u| is_meant(&u.0))
            .collect();
        units.sort_by_key(|u| u.0.is_none());
        let stated: Option<Unit> = units.first().and_then(|u| names::find(&u.1));
        let mut words = format!(
            "{} '{}'",
            role.words.trim_start_matches("the "),
            channel.name
        );
        let unit = stated.or(channel.unit);
        let kind = match (stated, unit) {
            (Some(unit), _) | (None, Some(unit)) => Some(unit.quantity.words()),
            _ => channel
                .strange_unit
                .as_deref()
                .and_then(names::strange_quantity)
                .or(channel.kind),
        };
        let fits = unit.is_some_and(|unit| unit.quantity == role.quantity)
            || unit.is_none() && kind == Some(role.quantity.words());
        let may_be_scaled = unit.map_or(kind.is_none(), |unit| {
            matches!(unit.quantity, Quantity::Voltage | Quantity::Other)
        });
        let in_unit = stated.map_or(channel.unit(), |unit| unit.symbol);
        if !fits && !may_be_scaled {
            let in_unit = match in_unit {
                "" => String::new(),
                unit => format!("in {unit}, "),
            };
            let others = [&VELOCITY, &ACCELERATION].into_iter();
            let other = others
                .filter(|_| role.option == DISPLACEMENT.option)
                .find(|other| kind == Some(other.quantity.words()));
            let or_other = other.map_or_else(String::new, |other| {
                format!(
                    ", or state {} {} if {} was measured",
                    other.option,
                    channel.last_name(),
                    other.quantity.words()
                )
            });
            return Err(Trouble::new(
                format!(
                    "is {in_unit}{}, and can't be imported as {}, where {} is needed",
                    kind.unwrap_or("something else"),
                    role.words,
                    role.quantity.words()
                ),
                format!(
                    "name another channel with {}{or_other}, or state --unit {}={} if its unit is wrong",
                    role.option,
                    channel.last_name(),
                    role.unit
                ),
            )
            .of(&channel.name));
        }
        let own = unit.filter(|_| fits).map_or(1.0, |unit| unit.factor);
        if !fits && !in_unit.is_empty() && scale.is_none() {
            return Err(Trouble::new(
                format!("is in {in_unit}, which says nothing of {}", role.quantity.words()),
                format!(
                    "state {} per {in_unit} with --scale {}=FACTOR, or --unit {}={} if the unit is wrong",
                    role.unit,
                    channel.last_name(),
                    channel.last_name(),
                    role.unit
                ),
            )
            .of(&channel.name));
        }
        let factor = own * scale.unwrap_or(1.0);
        words += &match (in_unit, scale) {
            ("", None) => format!(" without a unit, taken as {}", role.unit),
            ("", Some(scale)) => format!(" times {scale} {}", role.unit),
            (unit, None) if own == 1.0 => format!(" in {unit}"),
            (unit, None) => format!(" in {unit} taken to {}", role.unit),
            (unit, Some(scale)) if fits => {
                format!(" in {unit} taken to {} and times {scale}", role.unit)
            }
            (unit, Some(scale)) => format!(" times {scale} {} per {unit}", role.unit),
        };
        told.push(words);
        Ok(factor)
    }

    fn time(
        &self,
        of: &Channel,
        count: usize,
        told: &mut Vec<String>,
    ) -> Result<Vec<f64>, Trouble> {
        if let Some(rate) = self.wanted.rate {
            told.push(format!("times from --rate {rate} Hz"));
            return Ok((0..count).map(|i| i as f64 / rate).collect());
        }
        if let Some(name) = &self.wanted.time {
            let channel = self.named(name, &TIME)?;
            return self.times(channel, of, count, told);
        }
        if let Some((start, rate)) = of.even {
            told.push(format!(
                "times from the file's sample rate {} Hz",
                rounded(rate)
            ));
            return Ok((0..count).map(|i| start + i as f64 / rate).collect());
        }
        let all = &self.recording.channels;
        let group = of.name.len() - of.last_name().len();
        let group = &of.name[..group];
        let inside =
            |c: &&Channel| c.name.starts_with(group) && !c.name[group.len()..].contains('/');
        let is_other = |c: &&Channel| c.name != of.name;
        let fits = |c: &&Channel| {
            measures(c, Quantity::Time)
                || c.unit.is_none() && c.strange_unit.is_none() && TIME.is_named(c)
        };
        let mut found: Vec<&Channel> = all
            .iter()
            .filter(is_other)
            .filter(fits)
            .filter(inside)
            .collect();
        if found.is_empty() {
            found = all.iter().filter(is_other).filter(fits).collect();
        }
        match found.as_slice() {
            [one] => return self.times(one, of, count, told),
            [] => {}
            several => return Err(self.several(several, &TIME)),
        }
        let scalar = |names: &[&str]| {
            let mut found = self.recording.scalars.iter().filter(|(name, value)| {
                let last = name.rsplit('/').next().unwrap_or(name);
                names.contains(&plain(last).as_str()) && *value > 0.0 && value.is_finite()
            });
            found.next()
        };
        let rate = scalar(&RATES).map(|(name, rate)| (name, *rate));
        let rate = rate.or_else(|| scalar(&INTERVALS).map(|(name, step)| (name, 1.0 / step)));
        if let Some((name, rate)) = rate {
            told.push(format!("times from '{name}', {} Hz", rounded(rate)));
            return Ok((0..count).map(|i| i as f64 / rate).collect());
        }
        Err(Trouble::new(
            format!("no channel is {}{}", TIME.words, self.there()),
            "name it with --time, or state --rate in samples per second",
        ))
    }

    fn times(
        &self,
        channel: &Channel,
        of: &Channel,
        count: usize,
        told: &mut Vec<String>,
    ) -> Result<Vec<f64>, Trouble> {
        let times = self.values(channel, &TIME, told)?;
        self.same_length(channel, times.len(), of, count)?;
        Ok(times)
    }

    fn same_length(
        &self,
        channel: &Channel,
        found: usize,
        of: &Channel,
        count: usize,
    ) -> Result<(), Trouble> {
        if found == count {
            return Ok(());
        }
        let what = self.measurand().name();
        Err(Trouble::new(
            format!("{found} samples, while the {what} '{}' has {count}", of.name),
            "channels of one run need the same samples: record them together, resample one, or name another",
        )
        .of(&channel.name))
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

fn role_of(measurand: Measurand) -> &'static Role {
    match measurand {
        Measurand::Displacement => &DISPLACEMENT,
        Measurand::Velocity => &VELOCITY,
        Measurand::Acceleration => &ACCELERATION,
    }
}

fn series(input: Option<&Input>) -> Option<&Vec<f64>> {
    match input {
        Some(Input::Series(values)) => Some(values),
        _ => None,
    }
}

fn measures(channel: &Channel, quantity: Quantity) -> bool {
    match channel.unit {
        Some(unit) => unit.quantity == quantity,
        None => channel.strange_unit.is_none() && channel.kind == Some(quantity.words()),
    }
}

/// Whether a channel may become anything by a factor.
fn may_be_scaled(channel: &Channel) -> bool {
    let strange = channel.strange_unit.as_deref();
    match channel.unit {
        Some(unit) => matches!(unit.quantity, Quantity::Voltage | Quantity::Other),
        None => channel.kind.is_none() && strange.and_then(names::strange_quantity).is_none(),
    }
}

/// A rate without the rounding of `1 / interval`.
fn rounded(rate: f64) -> f64 {
    let whole = rate.round();
    if (rate - whole).abs() < 1e-9 * rate {
        whole
    } else {
        rate
    }
}
