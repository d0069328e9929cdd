//! Length, velocity and force of a machine, and values with a unit on machines of other scales.

use crate::error::Error;
use crate::fmu::Fmu;
use crate::fmu::effect_card::annotation;
use crate::measurement::{Excitation, Run};
use crate::metric::{median, standard_deviation};
use crate::observer::{Mode, Smoothed, Structure};

/// Length, velocity and force of a machine, in m, m/s and N, or ratios of those of two machines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// How far the contact moves: the spread of its displacement, or that of its velocity over a natural angular frequency.
    pub length: f64,
    /// Spread of its velocity.
    pub velocity: f64,
    /// Force that changes this velocity over that length, or that drives the machine, if it is larger.
    pub force: f64,
}

impl Scales {
    /// Ratios of two machines of one size.
    pub const ALIKE: Self = Self {
        length: 1.0,
        velocity: 1.0,
        force: 1.0,
    };

    /// Length, velocity and force of the machine on which the values of the cards are met; `None` where the FMU does not say so.
    ///
    /// # Errors
    /// An annotation that can't be read, or a scale that is no positive number.
    pub fn of_catalogue(fmu: &Fmu) -> Result<Option<Self>, Error> {
        let Some(document) = annotation(fmu)? else {
            return Ok(None);
        };
        let mut nodes = document.descendants();
        let is_said = |node: &roxmltree::Node| {
            let scales = ["length", "velocity", "force"];
            node.has_tag_name("EffectCatalogue")
                && scales.iter().any(|name| node.has_attribute(*name))
        };
        let Some(catalogue) = nodes.find(is_said) else {
            return Ok(None);
        };
        let number = |name: &str| {
            let text = catalogue.attribute(name).unwrap_or_default();
            let value = text
                .parse()
                .ok()
                .filter(|v: &f64| *v > 0.0 && v.is_finite());
            value.ok_or_else(|| Error::FmuDescription {
                path: fmu.path().to_owned(),
                problem: format!(
                    "EffectCatalogue: {name} = '{text}' is no positive number; length (m), velocity (m/s) and force (N) say together on which machine its values are met"
                ),
            })
        };
        Ok(Some(Self {
            length: number("length")?,
            velocity: number("velocity")?,
            force: number("force")?,
        }))
    }

    /// Those of a machine with this structure, of which these are runs that move, with their smoothed motions. With the median v over the
    /// runs of the spread of the contact's velocity, the time t and the mass m that a force at the contact moves at once,
    ///
    /// ```text
    /// l = v t,   f = max(m v/t, P),   t = 1/w_1,   1/m = sum_j phi_j^2/m_j
    /// ```
    ///
    /// w_1 the lowest natural angular frequency; of masses without a spring l is the spread of the displacement. A sensor of velocities
    /// tells no slow displacement, hence t from the structure where it has one. P is the median spread of the force that drives the runs,
    /// that of a shaken clamp being m times its acceleration: where friction and dampers take most of it, inertia tells too little.
    pub fn of_runs<'s>(
        structure: &Structure,
        runs: impl Iterator<Item = (&'s Run, &'s Smoothed)>,
    ) -> Self {
        let inverse_mass = structure.inverse_tip_mass();
        let (mut lengths, mut velocities, mut pushes) = (Vec::new(), Vec::new(), Vec::new());
        for (run, smoothed) in runs {
            lengths.push(standard_deviation(&smoothed.displacement));
            velocities.push(standard_deviation(&smoothed.velocity));
            pushes.push(push(run, inverse_mass));
        }
        let velocity = median(&mut velocities);
        let sprung = structure.modes().iter().filter(|m| !m.is_free());
        let lowest = sprung.map(Mode::angular_frequency).reduce(f64::min);
        let length = lowest.map_or_else(|| median(&mut lengths), |rate| velocity / rate);
        let inertia = velocity * velocity / (length * inverse_mass);
        Self {
            length,
            velocity,
            force: inertia.max(median(&mut pushes)),
        }
    }

    /// Ratios of these scales to those of another machine; 1 for one that is not known, and for all of two machines of about one size: where
    /// none is off by half a decade ([`Self::ALIKE`]), since what is met on a machine is known to no more.
    pub fn over(self, other: Self) -> Self {
        let of = |mine: f64, theirs: f64| Some(mine / theirs).filter(|r| r.is_finite() && *r > 0.0);
        let ratio = |mine, theirs| of(mine, theirs).unwrap_or(1.0);
        let ratios = Self {
            length: ratio(self.length, other.length),
            velocity: ratio(self.velocity, other.velocity),
            force: ratio(self.force, other.force),
        };
        let all = [ratios.length, ratios.velocity, ratios.force];
        if all.iter().all(|r| r.log10().abs() < 0.5) {
            Self::ALIKE
        } else {
            ratios
        }
    }

    /// Factor on a value of this unit, for ratios l, v and f of scales: `kg = f l/v^2`, `m = l`, `s = l/v`; 1 for a unit that is not known.
    pub fn factor(self, unit: &str) -> f64 {
        exponents(unit).map_or(1.0, |[kg, m, s]| {
            self.force.powf(kg) * self.length.powf(kg + m + s) * self.velocity.powf(-2.0 * kg - s)
        })
    }
}

/// Spread of the force in N that drives a run: the external one, or that which the shaken clamp has the mass feel, if it is larger.
fn push(run: &Run, inverse_mass: f64) -> f64 {
    let spread = |e: &Excitation| {
        let values = e.series.as_ref().map(|s| standard_deviation(&s.values));
        values.unwrap_or(0.0)
    };
    let shaken = spread(&run.inputs.clamp_acceleration) / inverse_mass;
    spread(&run.inputs.external_force).max(shaken)
}

/// Exponents of kg, m and s of a unit in the notation of the FMI standard: factors with integer exponents, each after `.` or `/`, and a
/// bracket that may have a power; `None` for another.
fn exponents(unit: &str) -> Option<[f64; 3]> {
    let mut sum = [0.0; 3];
    let mut rest = unit;
    let mut sign = 1.0;
    loop {
        let (of_factor, after) = match rest.strip_prefix('(') {
            Some(inner) => {
                let (inner, after) = inner.split_once(')')?;
                let (power, after) = match after.strip_prefix('^') {
                    Some(power) => {
                        let is_other = |c: char| !c.is_ascii_digit() && c != '.';
                        power.split_at(power.find(is_other).unwrap_or(power.len()))
                    }
                    None => ("1", after),
                };
                let power: f64 = power.parse().ok()?;
                (exponents(inner)?.map(|e| e * power), after)
            }
            None => {
                let (factor, after) = rest.split_at(rest.find(['.', '/']).unwrap_or(rest.len()));
                (of_factor(factor)?, after)
            }
        };
        for (sum, e) in sum.iter_mut().zip(of_factor) {
            *sum += sign * e;
        }
        sign = match after.chars().next() {
            None => return Some(sum),
            Some('.') => 1.0,
            Some('/') => -1.0,
            Some(_) => return None,
        };
        rest = &after[1..];
    }
}

/// Exponents of one symbol with an integer exponent.
fn of_factor(factor: &str) -> Option<[f64; 3]> {
    let end = factor.find(|c: char| c.is_ascii_digit() || c == '-');
    let (symbol, exponent) = factor.split_at(end.unwrap_or(factor.len()));
    if symbol.is_empty() {
        return (exponent == "1").then_some([0.0; 3]);
    }
    let exponent: f64 = match exponent {
        "" => 1.0,
        digits => digits.parse().ok()?,
    };
    let base = match symbol {
        "rad" => [0.0, 0.0, 0.0],
        "kg" => [1.0, 0.0, 0.0],
        "m" => [0.0, 1.0, 0.0],
        "s" => [0.0, 0.0, 1.0],
        "Hz" => [0.0, 0.0, -1.0],
        "N" => [1.0, 1.0, -2.0],
        "J" => [1.0, 2.0, -2.0],
        "W" => [1.0, 2.0, -3.0],
        _ => return None,
    };
    Some(base.map(|e| e * exponent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::InputSignals;
    use crate::smoothing::pushed_run::pushed;

    #[test]
    fn machines_of_about_one_size_are_alike_and_others_are_not_rounded() {
        let beam = Scales {
            length: 4e-4,
            velocity: 0.1,
            force: 3.0,
        };
        let larger = Scales {
            length: 1e-3,
            velocity: 0.31,
            force: 1.0,
        };
        assert_eq!(larger.over(beam), Scales::ALIKE);
        let drive = Scales {
            length: 0.12,
            velocity: 0.05,
            force: f64::NAN,
        };
        let expected = Scales {
            length: 0.12 / 4e-4,
            velocity: 0.5,
            force: 1.0,
        };
        assert_eq!(drive.over(beam), expected);
    }

    #[test]
    fn what_drives_a_run_is_a_force_or_a_clamp_that_shakes() {
        // Ten periods: the spread of a sine is its amplitude over the square root of 2.
        let mut run = pushed(|t| 2.0 * (std::f64::consts::TAU * 10.0 * t).sin(), None);
        let of_mass = |run: &Run, mass: f64| push(run, 1.0 / mass) * 2.0_f64.sqrt();
        assert!((of_mass(&run, 3.0) - 2.0).abs() < 0.01);
        run.inputs.clamp_acceleration = run.inputs.external_force.clone();
        assert!((of_mass(&run, 3.0) - 6.0).abs() < 0.03);
        assert!((of_mass(&run, 0.5) - 2.0).abs() < 0.01);
        run.inputs = InputSignals::default();
        assert_eq!(push(&run, 1.0), 0.0);
    }

    #[test]
    fn a_value_is_scaled_as_its_unit_says() {
        let ratios = Scales {
            length: 10.0,
            velocity: 100.0,
            force: 1e-3,
        };
        for (unit, expected) in [
            ("N", 1e-3),
            ("m/s", 100.0),
            ("s", 0.1),
            ("Hz", 10.0),
            ("kg", 1e-6),
            ("N/m3", 1e-6),
            ("furlong", 1.0),
        ] {
            let factor = ratios.factor(unit);
            assert!((factor / expected - 1.0).abs() < 1e-12, "{unit}: {factor}");
        }
    }

    #[test]
    fn units_are_taken_apart() {
        for (unit, expected) in [
            ("1", [0.0, 0.0, 0.0]),
            ("N", [1.0, 1.0, -2.0]),
            ("N/m3", [1.0, -2.0, -2.0]),
            ("N.s2/m2", [1.0, -1.0, 0.0]),
            ("m/N", [-1.0, 0.0, 2.0]),
            ("1/W", [-1.0, -2.0, 3.0]),
            ("s/m", [0.0, -1.0, 1.0]),
            ("1/(N.m/s)^0.5", [-0.5, -1.0, 1.5]),
            ("s-1", [0.0, 0.0, -1.0]),
        ] {
            assert_eq!(exponents(unit), Some(expected), "{unit}");
        }
        for unit in ["K", "", "1//m", "(m", "m*s", "2"] {
            assert_eq!(exponents(unit), None, "{unit}");
        }
    }

    #[test]
    fn every_unit_of_the_library_is_known() {
        for file in crate::diagnose::model::library::FILES {
            let file: toml::Table = toml::from_str(file).unwrap();
            for parameter in file["parameter"].as_array().unwrap() {
                let unit = parameter["unit"].as_str().unwrap();
                assert!(exponents(unit).is_some(), "{}: {unit}", file["id"]);
            }
        }
    }
}
