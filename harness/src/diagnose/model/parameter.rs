//! Parameters: the quantities that a calibration turns, each with its scale, prior and bounds.

/// What a parameter stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A constant of the structure or of the friction law.
    Reference,
    /// The scale of a stated input.
    Input,
    /// The friction level of a run.
    Level,
    /// A constant that the sensor adds to the displacement as it is.
    Offset,
    /// A constant of the further sensor with this number.
    Sensor(usize, SensorConstant),
    /// Strength of an effect: zero means off.
    Amplitude,
    /// A shape constant of an effect.
    Shape,
    /// The phase of something that repeats.
    Phase,
    /// One of many values of a profile along the belt, mapped by break-aways.
    Node,
    /// One of the values that make a profile along the belt or the curve of an unknown function; FMU variables are set from their sum.
    Latent,
    /// Given, never calibrated.
    Constant,
}

/// What a further sensor has of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorConstant {
    /// Factor of what it reads.
    Gain,
    /// Mode shape of the mode with this index where it looks, over that at the contact.
    Ratio(usize),
    /// What it adds in a run.
    Offset,
    /// Time in s by which its clock is later than stated.
    Delay,
}

/// How a parameter is turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// The value itself.
    Linear,
    /// Its natural logarithm: positive quantities known to a factor.
    Log,
}

/// One quantity to be calibrated.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name as reported.
    pub name: String,
    /// Unit symbol.
    pub unit: String,
    /// What it stands for.
    pub kind: Kind,
    /// FMU variables set from it: value reference and factor.
    pub targets: Vec<(u32, f64)>,
    /// Scale on which it moves.
    pub scale: Scale,
    /// Value believed before the data.
    pub prior: f64,
    /// Standard deviation of that belief on the parameter's scale.
    pub prior_std: f64,
    /// Smallest value allowed.
    pub min: f64,
    /// Largest value allowed.
    pub max: f64,
    /// Typical change on the parameter's scale, for the first difference quotient.
    pub step: f64,
    /// Places on the belt (m) outside which the parameter has no influence.
    pub support: Option<(f64, f64)>,
}

impl Parameter {
    /// A constant of the model that is positive: believed is `value`, with a standard deviation `std` of its logarithm, and
    /// allowed is what lies within `factor` of it.
    pub fn positive(
        name: String,
        unit: &str,
        target: u32,
        (value, std): (f64, f64),
        factor: f64,
    ) -> Self {
        Self {
            scale: Scale::Log,
            min: value / factor,
            max: value * factor,
            ..Self::linear(name, unit, target, (value, std), 0.0)
        }
    }

    /// A constant of the model on its own scale: believed is `value` with a standard deviation `std`, and allowed is what lies within
    /// `reach` of these.
    pub fn linear(
        name: String,
        unit: &str,
        target: u32,
        (value, std): (f64, f64),
        reach: f64,
    ) -> Self {
        Self {
            name,
            unit: unit.to_owned(),
            kind: Kind::Reference,
            targets: vec![(target, 1.0)],
            scale: Scale::Linear,
            prior: value,
            prior_std: std,
            min: value - reach * std,
            max: value + reach * std,
            step: 0.02 * std,
            support: None,
        }
    }

    /// Whether it is the phase of something that repeats.
    pub fn is_phase(&self) -> bool {
        self.kind == Kind::Phase
    }

    /// Whether it belongs to an effect and not to the reference model.
    pub fn of_effect(&self) -> bool {
        use Kind::{Amplitude, Latent, Node, Phase, Shape};
        matches!(self.kind, Amplitude | Shape | Phase | Node | Latent)
    }

    /// Position on the parameter's scale of a value.
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

    /// The FMU's variables that are set from it, with their values.
    pub fn settings(&self, position: f64) -> impl Iterator<Item = (u32, f64)> + '_ {
        let value = self.value(position);
        let targets = self.targets.iter();
        targets.map(move |&(reference, factor)| (reference, factor * value))
    }

    /// Where among variables that are set already a value of its own adds up: latent values make a curve together, all others
    /// stand alone.
    pub fn adds_to(&self, mut known: impl Iterator<Item = u32>, reference: u32) -> Option<usize> {
        if self.kind != Kind::Latent {
            return None;
        }
        known.position(|k| k == reference)
    }

    /// Derivative of its value by its position.
    pub fn slope(&self, position: f64) -> f64 {
        match self.scale {
            Scale::Linear => 1.0,
            Scale::Log => position.exp(),
        }
    }

    /// Derivatives by the position of the FMU's variables that are set from it.
    pub fn changes(&self, position: f64) -> impl Iterator<Item = (u32, f64)> + '_ {
        let slope = self.slope(position);
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

    /// Standard deviation of the belief in it that the evidence counts with, on the parameter's scale. Fits pull phases, shapes and
    /// strengths hardly at all, so that none is drawn to a middle that nobody believes in; believed is that they lie
    /// anywhere between their bounds (phases within one turn), a uniform density of that standard deviation.
    pub fn volume_std(&self) -> f64 {
        let uniform = |low: f64, high: f64| (high - low) / 12.0_f64.sqrt();
        match self.kind {
            Kind::Phase => uniform(0.0, std::f64::consts::TAU),
            Kind::Shape if self.scale == Scale::Log => {
                uniform(self.position(self.min), self.position(self.max))
            }
            Kind::Shape | Kind::Amplitude => uniform(self.min, self.max),
            _ => self.prior_std,
        }
    }

    /// Whether it is a constant that the sensor adds.
    pub fn is_offset(&self) -> bool {
        self.kind == Kind::Offset
    }
}
