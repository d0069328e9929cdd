//! The channel of a recording that is meant, by its name or by what its name and unit say.

use super::super::unit::Quantity;
use super::choice::Taking;
use super::role::{DISPLACEMENT, Role, is_time_name, may_be_scaled, measures};
use super::{Channel, Trouble, names};
use crate::wording::{nearest, quoted, suggestion};

impl Taking<'_> {
    pub(super) fn displacement(&self) -> Result<&Channel, Trouble> {
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
    pub(super) fn there(&self) -> String {
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

    pub(super) fn several(&self, found: &[&Channel], role: &Role) -> Trouble {
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
    pub(super) fn named(&self, name: &str, role: &Role) -> Result<&Channel, Trouble> {
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
}
