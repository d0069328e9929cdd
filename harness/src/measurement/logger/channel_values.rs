//! A channel's values in SI units: the unit of the file or the one stated, and the scale behind it.

use super::super::unit::{Quantity, Unit};
use super::choice::Taking;
use super::role::{ACCELERATION, DISPLACEMENT, Role, VELOCITY};
use super::{Channel, Trouble, names};

impl Taking<'_> {
    /// Values in SI units.
    pub(super) fn values(
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
    pub(super) fn factor(
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
        let scales = self.wanted.scales.iter().filter(|s| is_meant(&s.0));
        let scale = scales.min_by_key(|s| s.0.is_none()).map(|s| s.1);
        let units = self.wanted.units.iter().filter(|u| is_meant(&u.0));
        let unit = units.min_by_key(|u| u.0.is_none());
        let stated: Option<Unit> = unit.and_then(|u| names::find(&u.1));
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
}
