//! Length, time and mass of a machine, and values with a unit on machines of other scales.

use crate::metric::{median, standard_deviation};
use crate::observer::{Mode, Smoothed, Structure};

/// Length, time and mass of a machine, in m, s and kg, or ratios of those of two machines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// Spread of the displacement of the contact.
    pub length: f64,
    /// That over the spread of its velocity.
    pub time: f64,
    /// Mass that a force on the contact moves at once.
    pub mass: f64,
}

impl Scales {
    /// Those of a machine with this structure, of which these are runs that move: medians over the runs of the spread l of the contact's
    /// displacement and of t = l/v, v the spread of its velocity, and the mass that a force at the contact moves at once,
    /// `1/m = sum_j phi_j^2/m_j`.
    pub fn of_runs<'s>(structure: &Structure, runs: impl Iterator<Item = &'s Smoothed>) -> Self {
        let (mut lengths, mut velocities): (Vec<f64>, Vec<f64>) = runs
            .map(|run| {
                let length = standard_deviation(&run.displacement);
                (length, standard_deviation(&run.velocity))
            })
            .unzip();
        let (length, velocity) = (median(&mut lengths), median(&mut velocities));
        let mobility = |m: &Mode| m.tip_value.powi(2) / m.mass_kg;
        Self {
            length,
            time: length / velocity,
            mass: structure.modes().iter().map(mobility).sum::<f64>().recip(),
        }
    }

    /// Ratios of these scales to those of another machine, each rounded to a decade; 1 where one is not known.
    pub fn over(self, other: Self) -> Self {
        let decade = |mine: f64, theirs: f64| match (mine / theirs).log10().round() {
            decades if decades.is_finite() => 10.0_f64.powf(decades),
            _ => 1.0,
        };
        Self {
            length: decade(self.length, other.length),
            time: decade(self.time, other.time),
            mass: decade(self.mass, other.mass),
        }
    }

    /// Factor on a value of this unit, for ratios of scales m, l and t: `m^a l^b t^c` for `kg^a m^b s^c`; 1 for a unit that is not known.
    pub fn factor(self, unit: &str) -> f64 {
        exponents(unit).map_or(1.0, |[kg, m, s]| {
            self.mass.powf(kg) * self.length.powf(m) * self.time.powf(s)
        })
    }
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

    #[test]
    fn ratios_are_decades() {
        let beam = Scales {
            length: 4e-4,
            time: 3e-3,
            mass: 0.05,
        };
        let other = Scales {
            length: 8e-4,
            time: 1.0,
            mass: f64::NAN,
        };
        let expected = Scales {
            length: 1.0,
            time: 1000.0,
            mass: 1.0,
        };
        assert_eq!(other.over(beam), expected);
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
}
