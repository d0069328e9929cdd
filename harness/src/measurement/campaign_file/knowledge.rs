//! What is known of the beam, and how well.

use super::check::{ANY, Check, NOT_NEGATIVE, NOT_ZERO, POSITIVE, SHARE, line_of};
use super::keys::{OneOrEach, RawBeam, RawRig, RawUncertainty};
use crate::error::Error;
use crate::measurement::BeamKnowledge;
use crate::measurement::sensor_place::{RawSensor, SensorPlace};
use crate::measurement::uncertainty::{OfModes, Uncertainty};
use toml::Spanned;

impl Check<'_> {
    /// Corner frequency of the filter that the first sensor's reading has passed, Hz.
    pub(super) fn high_pass(&self, raw: &RawSensor) -> Result<Option<f64>, Error> {
        let stated = raw.high_pass_hz.clone();
        stated
            .map(|hz| self.number("[sensor] high_pass_hz", "Hz", POSITIVE, hz))
            .transpose()
    }

    pub(super) fn uncertainty(
        &self,
        raw: RawUncertainty,
        rig: RawRig,
        of_modes: OfModes,
    ) -> Result<Uncertainty, Error> {
        let usual = Uncertainty::default();
        let share = |key: &str, given: Option<Spanned<f64>>, usual: f64| match given {
            Some(value) => self.number(key, "1", SHARE, value),
            None => Ok(usual),
        };
        // The same key in both tables is one too many: neither is more right.
        let both = |key: &str, a: &Option<Spanned<f64>>, b: &Option<Spanned<f64>>| match (a, b) {
            (Some(_), Some(again)) => Err(Error::CampaignFile {
                path: self.path.to_owned(),
                line: line_of(self.text, again.span()),
                problem: format!("{key} stands under [rig] and under [uncertainty]; leave one out"),
            }),
            _ => Ok(()),
        };
        both(
            "belt_velocity_std",
            &rig.belt_velocity_std,
            &raw.belt_velocity_std,
        )?;
        both(
            "normal_force_std",
            &rig.normal_force_std,
            &raw.normal_force_std,
        )?;
        Ok(Uncertainty {
            zero_std: usual.zero_std,
            belt_velocity_std: share(
                "belt_velocity_std",
                rig.belt_velocity_std.or(raw.belt_velocity_std),
                usual.belt_velocity_std,
            )?,
            normal_force_std: share(
                "normal_force_std",
                rig.normal_force_std.or(raw.normal_force_std),
                usual.normal_force_std,
            )?,
            belt_velocity_run_std: share(
                "[rig] belt_velocity_run_std",
                rig.belt_velocity_run_std,
                usual.belt_velocity_run_std,
            )?,
            normal_force_run_std: share(
                "[rig] normal_force_run_std",
                rig.normal_force_run_std,
                usual.normal_force_run_std,
            )?,
            natural_frequencies_std: share(
                "[uncertainty] natural_frequencies_std",
                raw.natural_frequencies_std,
                usual.natural_frequencies_std,
            )?,
            participations_std: share(
                "[uncertainty] participations_std",
                raw.participations_std,
                usual.participations_std,
            )?,
            of_modes,
        })
    }

    /// Standard deviations of the modes as shares of `values`; empty where none are stated. One number stands for all modes.
    pub(super) fn shares_of_modes(
        &self,
        (key, unit): (&str, &'static str),
        given: Option<Spanned<OneOrEach>>,
        (values_key, values): (&str, &[f64]),
    ) -> Result<Vec<f64>, Error> {
        let Some(given) = given else {
            return Ok(Vec::new());
        };
        let span = given.span();
        let stds = match given.into_inner() {
            OneOrEach::One(std) => vec![std; values.len().max(1)],
            OneOrEach::Each(stds) => stds,
        };
        let stds = stds.into_iter().map(|s| Spanned::new(span.clone(), s));
        let stds = self.list(key, unit, POSITIVE, Some(stds.collect()))?;
        if values.is_empty() {
            return Err(Error::CampaignFile {
                path: self.path.to_owned(),
                line: line_of(self.text, span),
                problem: format!(
                    "{key} says how well {values_key} is known, which is not stated; state both under [beam]"
                ),
            });
        }
        if stds.len() != values.len() {
            return Err(Error::CampaignModes {
                path: self.path.to_owned(),
                key: key.to_owned(),
                found: stds.len(),
                expected: values.len(),
            });
        }
        // A damping ratio of zero has no share: its belief is as wide as where nothing is stated.
        let shares = stds.iter().zip(values);
        Ok(shares
            .map(|(std, value)| match *value == 0.0 {
                true => f64::NAN,
                false => (std / value.abs()).clamp(1e-6, 0.5),
            })
            .collect())
    }

    pub(super) fn beam(
        &self,
        raw: RawBeam,
        sensor: RawSensor,
    ) -> Result<(BeamKnowledge, OfModes), Error> {
        let mut beam = BeamKnowledge {
            natural_frequencies_hz: self.list(
                "[beam] natural_frequencies_hz",
                "Hz",
                NOT_NEGATIVE,
                raw.natural_frequencies_hz,
            )?,
            damping_ratios: self.list(
                "[beam] damping_ratios",
                "1",
                NOT_NEGATIVE,
                raw.damping_ratios,
            )?,
            damping_rates_per_s: self.list(
                "[beam] damping_rates_per_s",
                "1/s",
                NOT_NEGATIVE,
                raw.damping_rates_per_s,
            )?,
            masses_kg: self.list("[beam] masses_kg", "kg", POSITIVE, raw.masses_kg)?,
            tip_values: self.list("[beam] tip_values", "1", NOT_ZERO, raw.tip_values)?,
            clamp_shares: self.list("[beam] clamp_shares", "1", ANY, raw.clamp_shares)?,
            sensor: SensorPlace::default(),
        };
        let modes = beam.natural_frequencies_hz.len();
        if let Some(mass) = raw.mass_kg {
            let mass = self.number("[beam] mass_kg", "kg", POSITIVE, mass)?;
            if beam.masses_kg.is_empty() {
                // Without frequencies the number of modes is the FMU's to say; one entry then stands for all.
                beam.masses_kg = vec![mass; modes.max(1)];
            }
        }
        beam.sensor = self.sensor("[sensor]", sensor, modes)?;
        let lists = [
            ("damping_ratios", beam.damping_ratios.len()),
            ("damping_rates_per_s", beam.damping_rates_per_s.len()),
            ("masses_kg", beam.masses_kg.len()),
            ("tip_values", beam.tip_values.len()),
            ("clamp_shares", beam.clamp_shares.len()),
        ];
        match lists
            .into_iter()
            .find(|(_, n)| modes > 0 && *n > 0 && *n != modes)
        {
            None => {
                let of_modes = OfModes {
                    frequencies: self.shares_of_modes(
                        ("natural_frequencies_std_hz", "Hz"),
                        raw.natural_frequencies_std_hz,
                        ("natural_frequencies_hz", &beam.natural_frequencies_hz),
                    )?,
                    damping_ratios: self.shares_of_modes(
                        ("damping_ratios_std", "1"),
                        raw.damping_ratios_std,
                        ("damping_ratios", &beam.damping_ratios),
                    )?,
                    damping_rates: self.shares_of_modes(
                        ("damping_rates_std_per_s", "1/s"),
                        raw.damping_rates_std_per_s,
                        ("damping_rates_per_s", &beam.damping_rates_per_s),
                    )?,
                    masses: self.shares_of_modes(
                        ("mass_std_kg", "kg"),
                        raw.mass_std_kg,
                        ("mass_kg", &beam.masses_kg),
                    )?,
                    tip_values: self.shares_of_modes(
                        ("tip_values_std", "1"),
                        raw.tip_values_std,
                        ("tip_values", &beam.tip_values),
                    )?,
                };
                Ok((beam, of_modes))
            }
            Some((key, found)) => Err(Error::CampaignModes {
                path: self.path.to_owned(),
                key: key.to_owned(),
                found,
                expected: modes,
            }),
        }
    }
}
