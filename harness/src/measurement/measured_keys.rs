//! The keys of campaign.toml that say what the sensor at the tip measured.

use toml::Spanned;

use super::campaign_file::check::{Check, NOT_ZERO, line_of};
use super::csv_table::Measured;
use super::measurand::Measurand;
use crate::error::Error;

/// Column and scale of a measured quantity, as far as they are stated.
pub(super) type MeasuredKeys = (Option<Spanned<String>>, Option<Spanned<f64>>);

/// The keys of each of [`Measurand::ALL`].
pub(super) type KeysOfAll = [MeasuredKeys; Measurand::ALL.len()];

impl Check<'_> {
    /// What the sensor measured, in the order of [`Measurand::ALL`]: columns and scales of the run, and those of all runs. Keys of
    /// the run come before those of all runs; of one quantity alone there may be keys.
    pub(super) fn measured(&self, of_run: KeysOfAll, of_all: KeysOfAll) -> Result<Measured, Error> {
        let is_stated = |keys: &MeasuredKeys| keys.0.is_some() || keys.1.is_some();
        // Where the run names another quantity, the keys of all runs are not meant for it.
        let which = |keys: &KeysOfAll| -> Result<Option<usize>, Error> {
            let mut stated = (0..keys.len()).filter(|i| is_stated(&keys[*i]));
            match (stated.next(), stated.next()) {
                (Some(first), Some(second)) => Err(self.two_quantities(keys, [first, second])),
                (found, _) => Ok(found),
            }
        };
        let (own, common) = (which(&of_run)?, which(&of_all)?);
        let Some(which) = own.or(common) else {
            return Ok(Measured::default());
        };
        let (measurand, [run, all]) = (
            Measurand::ALL[which],
            [of_run, of_all].map(|keys| {
                let mut keys = keys;
                std::mem::take(&mut keys[which])
            }),
        );
        let scale = run.1.or(all.1);
        Ok(Measured {
            measurand: Some(measurand),
            column: run.0.or(all.0).map(Spanned::into_inner),
            scale: match scale {
                Some(value) => Some(self.number(measurand.scale_key(), "1", NOT_ZERO, value)?),
                None => None,
            },
        })
    }

    /// The error of keys for two quantities at once.
    fn two_quantities(&self, keys: &KeysOfAll, which: [usize; 2]) -> Error {
        let of = |i: usize| match (&keys[i].0, &keys[i].1) {
            (Some(column), _) => {
                let key = Measurand::ALL[i].column_key();
                (format!("{key} = {:?}", column.get_ref()), column.span())
            }
            (None, Some(scale)) => {
                let key = Measurand::ALL[i].scale_key();
                (format!("{key} = {}", scale.get_ref()), scale.span())
            }
            (None, None) => (String::new(), 0..0),
        };
        let [first, second] = which.map(of);
        Error::CampaignFile {
            path: self.path.to_owned(),
            line: line_of(self.text, second.1),
            problem: format!(
                "{} and {} are two measured quantities, and a run holds one; keep one of the two",
                first.0, second.0
            ),
        }
    }
}
