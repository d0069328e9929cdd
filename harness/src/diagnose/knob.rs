//! Knobs: the quantities that a calibration turns, each with its scale, prior and bounds.

/// Name of the knob that is added to the displacement as it is.
pub const OFFSET: &str = "sensor.offset";

/// How a knob is turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// The value itself.
    Linear,
    /// Its natural logarithm: positive quantities known to a factor.
    Log,
}

/// One quantity to be calibrated.
#[derive(Debug, Clone, PartialEq)]
pub struct Knob {
    /// Name as reported.
    pub name: String,
    /// Unit symbol.
    pub unit: String,
    /// FMU variables set from it: value reference and factor.
    pub targets: Vec<(u32, f64)>,
    /// Scale on which it moves.
    pub scale: Scale,
    /// Value believed before the data.
    pub prior: f64,
    /// Standard deviation of that belief on the knob's scale.
    pub prior_std: f64,
    /// Smallest value allowed.
    pub min: f64,
    /// Largest value allowed.
    pub max: f64,
    /// Typical change on the knob's scale, for the first difference quotient.
    pub step: f64,
    /// Whether it belongs to an effect and not to the reference model.
    pub of_effect: bool,
    /// Places on the belt (m) outside which the knob has no influence.
    pub support: Option<(f64, f64)>,
}

impl Knob {
    /// Whether it is the phase of something that repeats.
    pub fn is_phase(&self) -> bool {
        self.name.ends_with(".phase")
    }

    /// Position on the knob's scale of a value.
    pub fn position(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Log => value.max(1e-300).ln(),
        }
    }

    /// Value at a position.
    pub fn value(&self, position: f64) -> f64 {
        match self.scale {
            Scale::Linear => position,
            Scale::Log => position.exp(),
        }
    }

    /// Derivatives by the position of the FMU's variables that are set from it.
    pub fn changes(&self, position: f64) -> impl Iterator<Item = (u32, f64)> + '_ {
        let slope = match self.scale {
            Scale::Linear => 1.0,
            Scale::Log => position.exp(),
        };
        let targets = self.targets.iter();
        targets.map(move |&(reference, factor)| (reference, factor * slope))
    }

    /// The nearest position within the bounds.
    pub fn clamp(&self, position: f64) -> f64 {
        let low = if self.scale == Scale::Log && self.min <= 0.0 {
            f64::NEG_INFINITY
        } else {
            self.position(self.min)
        };
        position.clamp(low, self.position(self.max))
    }

    /// Whether a position lies on a bound.
    pub fn is_at_bound(&self, position: f64) -> bool {
        let value = self.value(position);
        let width = 1e-6 * (self.max - self.min).abs();
        value <= self.min + width || value >= self.max - width
    }

    /// Whether it is a constant that the sensor adds.
    pub fn is_offset(&self) -> bool {
        self.name == OFFSET
    }
}
