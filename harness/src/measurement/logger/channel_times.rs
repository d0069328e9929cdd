//! Times of a channel's samples: a channel of times, the file's own rate, or the one stated.

use super::super::unit::Quantity;
use super::choice::Taking;
use super::role::{TIME, measures, plain};
use super::{Channel, Trouble};

pub(super) const RATES: [&str; 6] = [
    "fs",
    "rate",
    "samplerate",
    "samplingrate",
    "samplingfrequency",
    "sr",
];

pub(super) const INTERVALS: [&str; 5] =
    ["dt", "ts", "deltat", "sampleinterval", "samplinginterval"];

/// A rate without the rounding of `1 / interval`.
pub(super) fn rounded(rate: f64) -> f64 {
    let whole = rate.round();
    if (rate - whole).abs() < 1e-9 * rate {
        whole
    } else {
        rate
    }
}

impl Taking<'_> {
    pub(super) fn time(
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

    pub(super) fn times(
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

    pub(super) fn same_length(
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
}
