//! Where on the structure the sensor looks: `[sensor]` of campaign.toml.

use serde::Deserialize;
use toml::Spanned;

use super::BeamKnowledge;
use super::campaign_file::check::{Check, Rule, line_of};
use super::uncertainty::TIP_VALUE_STD;
use crate::error::Error;

/// Modes for which a place on a cantilever has ratios: as many as the FMU may have.
const MODES: usize = 8;
/// Default standard deviation of a place, as a share of the length: half a percent, 5 mm on a metre, as a ruler beside a laser spot
/// gives it.
const POSITION_STD: f64 = 0.005;

/// Nearest to the clamp, as a share of the length: there the first mode moves by 0.4 % of what it does at the tip.
const LEAST_POSITION: f64 = 0.05;

/// The table as it is written.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSensor {
    pub position: Option<Spanned<f64>>,
    pub position_std: Option<Spanned<f64>>,
    pub mode_ratios: Option<Vec<Spanned<f64>>>,
    pub mode_ratios_std: Option<Spanned<f64>>,
    /// How well the zero is known, in the unit of what is measured.
    pub offset_std: Option<Spanned<f64>>,
    /// Corner frequency of a first-order high-pass filter that the reading has passed, Hz.
    pub high_pass_hz: Option<Spanned<f64>>,
}

/// Mode shapes where the sensor looks over those at the tip, `r_j = phi_j(s) / phi_j(1)`, from the first mode on.
///
/// Empty for a sensor at the tip. Holds for displacement and velocity; a sensor that turns with the beam sees slopes too.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SensorPlace {
    /// The ratios, 1.
    pub ratios: Vec<f64>,
    /// Their standard deviations, 1.
    pub stds: Vec<f64>,
}

impl SensorPlace {
    /// At the share `position` of the length of a uniform cantilever from its clamp, known to `std`; mode shapes of Bernoulli and Euler.
    ///
    /// `phi_j(x) = cosh(b_j x) - cos(b_j x) - s_j (sinh(b_j x) - sin(b_j x))`, `cos b_j cosh b_j = -1`
    /// (Stelter 1992, eq. 6). Deviations of the ratios follow from the slope of the shape.
    pub fn on_cantilever(position: f64, std: f64) -> Self {
        let of = |j: usize| {
            let (shape, slope) = shape(wave_number(j), position);
            let (tip, _) = self::shape(wave_number(j), 1.0);
            // At an antinode the bend counts, which is of the size of b^2 / 2 at most.
            let bend = 0.5 * wave_number(j).powi(2) * std * std;
            (shape / tip, (slope / tip * std).hypot(bend))
        };
        let (ratios, stds) = (0..MODES).map(of).unzip();
        Self { ratios, stds }
    }

    /// What the sensor reads of the belt's velocity in m/s while the tip sticks; NaN away from the tip, where stick does not show, since
    /// higher modes ring on.
    pub fn seen(&self, belt_velocity: f64) -> f64 {
        match self.is_tip() {
            true => belt_velocity,
            false => f64::NAN,
        }
    }

    /// What moves under it, in words.
    pub fn name(&self) -> &'static str {
        match self.is_tip() {
            true => "tip",
            false => "sensor",
        }
    }

    /// Whether the sensor looks at the tip.
    pub fn is_tip(&self) -> bool {
        self.ratios.iter().all(|ratio| *ratio == 1.0)
    }
}

impl BeamKnowledge {
    /// Deflection where the sensor looks over that of the tip, bent slowly by a force at the tip: with what is stated of the modes,
    ///
    /// ```text
    /// sum_j r_j phi_j^2 / (m_j f_j^2) / sum_j phi_j^2 / (m_j f_j^2)
    /// ```
    ///
    /// and of free masses alone, where there are any. In stick the sensor moves at about this share of the belt's speed; 1 for a sensor at the
    /// tip.
    pub fn seen_share(&self) -> f64 {
        if self.sensor.is_tip() {
            return 1.0;
        }
        let slides = self.natural_frequencies_hz.contains(&0.0);
        let of = |list: &[f64], j: usize| list.get(j).copied().unwrap_or(1.0);
        let (mut seen, mut tip) = (0.0, 0.0);
        for (j, ratio) in self.sensor.ratios.iter().enumerate() {
            // Beyond the modes stated, a cantilever hardly bends any more.
            let Some(frequency) = self.natural_frequencies_hz.get(j) else {
                break;
            };
            let mobility = of(&self.tip_values, j).powi(2) / of(&self.masses_kg, j);
            let bend = match (slides, *frequency == 0.0) {
                (true, true) => mobility,
                (true, false) => 0.0,
                (false, _) => mobility / (frequency * frequency),
            };
            seen += ratio * bend;
            tip += bend;
        }
        let larger = |a: f64, b: &f64| if b.abs() > a.abs() { *b } else { a };
        match tip > 0.0 && seen != 0.0 {
            true => seen / tip,
            false => self.sensor.ratios.iter().fold(0.0, larger),
        }
    }
}

/// Root `b_j` of `cos b cosh b = -1` of the mode with this index, from 0, by Newton's method on `cos b + 1 / cosh b`.
fn wave_number(j: usize) -> f64 {
    let mut b = (j as f64 + 0.5) * std::f64::consts::PI;
    for _ in 0..20 {
        let value = b.cos() + 1.0 / b.cosh();
        let slope = -b.sin() - b.tanh() / b.cosh();
        b -= value / slope;
    }
    b
}

/// The mode shape with wave number `b` at `x`, and its slope over `x`. In exponentials, since hyperbolic functions nearly cancel.
fn shape(b: f64, x: f64) -> (f64, f64) {
    // s = (cosh b + cos b) / (sinh b + sin b)
    let sum = b.sinh() + b.sin();
    let s = (b.cosh() + b.cos()) / sum;
    let rest = (b.sin() - b.cos() - (-b).exp()) / sum; // 1 - s
    let z = b * x;
    let (grow, fall) = (0.5 * rest * z.exp(), 0.5 * (1.0 + s) * (-z).exp());
    (
        grow + fall - z.cos() + s * z.sin(),
        b * (grow - fall + z.sin() + s * z.cos()),
    )
}

const ON_BEAM: Rule = (
    |v| (LEAST_POSITION..=1.0).contains(&v),
    "it is the share of the beam's length from the clamp, from 0.05 (nearer, nothing moves) to 1",
);
const STD: Rule = (
    |v| v > 0.0 && v <= 0.5,
    "it must be above 0 and at most 0.5",
);
const ANY: Rule = (|_| true, "it must be a finite number");

impl Check<'_> {
    /// Where the sensor of a table looks; `modes` is the number of natural frequencies stated, 0 for none.
    pub(super) fn sensor(
        &self,
        table: &str,
        raw: RawSensor,
        modes: usize,
    ) -> Result<SensorPlace, Error> {
        let problem = |span: std::ops::Range<usize>, problem: String| Error::CampaignFile {
            path: self.path.to_owned(),
            line: line_of(self.text, span),
            problem,
        };
        let key = |item: &str| format!("{table} {item}");
        match (raw.position, raw.mode_ratios) {
            (Some(position), Some(_)) => Err(problem(
                position.span(),
                format!(
                    "position and mode_ratios under {table} say the same; keep position for a uniform cantilever, mode_ratios for any other structure"
                ),
            )),
            (Some(position), None) => {
                let position = self.number(&key("position"), "1", ON_BEAM, position)?;
                let std = match raw.position_std {
                    Some(std) => self.number(&key("position_std"), "1", STD, std)?,
                    None => POSITION_STD,
                };
                Ok(match position == 1.0 {
                    true => SensorPlace::default(),
                    false => SensorPlace::on_cantilever(position, std),
                })
            }
            (None, Some(ratios)) => {
                if modes == 0 {
                    return Err(problem(
                        ratios.first().map_or(0..0, Spanned::span),
                        format!(
                            "mode_ratios under {table} belong to natural_frequencies_hz under [beam]; state these too"
                        ),
                    ));
                }
                if ratios.len() != modes {
                    return Err(Error::CampaignModes {
                        path: self.path.to_owned(),
                        key: key("mode_ratios"),
                        found: ratios.len(),
                        expected: modes,
                    });
                }
                let of = |ratio| self.number(&key("mode_ratios"), "1", ANY, ratio);
                let ratios: Vec<f64> = ratios.into_iter().map(of).collect::<Result<_, _>>()?;
                if ratios.iter().all(|ratio| ratio.abs() < 1e-6) {
                    return Err(problem(
                        0..0,
                        format!(
                            "all mode_ratios under {table} are 0: the sensor sees no mode; measure elsewhere"
                        ),
                    ));
                }
                let std = match raw.mode_ratios_std {
                    Some(std) => self.number(&key("mode_ratios_std"), "1", STD, std)?,
                    None => TIP_VALUE_STD,
                };
                let stds = vec![std; ratios.len()];
                Ok(SensorPlace { ratios, stds })
            }
            (None, None) => match raw.position_std.or(raw.mode_ratios_std) {
                Some(std) => Err(problem(
                    std.span(),
                    format!(
                        "{table} says how well a place is known that is not stated; give position or mode_ratios"
                    ),
                )),
                None => Ok(SensorPlace::default()),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Source: Blevins 1979, Formulas for Natural Frequency and Mode Shape, table 8-1: wave numbers of the clamped-free beam, and where
    // its second and third mode have their nodes (0.783; 0.504 and 0.868 of the length from the clamp).
    #[test]
    fn val_wave_numbers_and_nodes_are_those_of_the_tables() {
        let tabled = [1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839];
        for (j, b) in tabled.into_iter().enumerate() {
            assert!((wave_number(j) - b).abs() < 1e-8, "{}", wave_number(j));
        }
        for (mode, node) in [(1, 0.783), (2, 0.504), (2, 0.868)] {
            let at = |x: f64| SensorPlace::on_cantilever(x, 0.01).ratios[mode];
            assert!(
                at(node - 1e-3) * at(node + 1e-3) < 0.0,
                "mode {mode} {node}"
            );
        }
    }

    // Source: the defining properties: 1 at the tip, 0 with no slope at the clamp; tip values of the normalised shapes +2, -2, ...
    #[test]
    fn val_shapes_begin_at_the_clamp_and_end_at_two() {
        for j in 0..MODES {
            let b = wave_number(j);
            let sign = if j % 2 == 0 { 2.0 } else { -2.0 };
            assert!((shape(b, 1.0).0 - sign).abs() < 1e-5, "{j}");
            let (value, slope) = shape(b, 0.0);
            assert!(
                value.abs() < 1e-9 && slope.abs() < 1e-6,
                "{j}: {value} {slope}"
            );
            // The slope is that of the shape.
            let step = 1e-6;
            let by_differences = (shape(b, 0.6 + step).0 - shape(b, 0.6 - step).0) / (2.0 * step);
            assert!((shape(b, 0.6).1 - by_differences).abs() < 1e-5 * b, "{j}");
        }
    }
}
