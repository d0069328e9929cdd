//! What is said of one variable.

use beam_physics::unit::Unit;

/// Causality (FMI 2.0.5, section 2.2.7).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set before the run.
    Parameter,
    /// Set during the run.
    Input,
    /// A result.
    Output,
    /// A quantity of the inside.
    Local,
}

/// Variability (FMI 2.0.5, section 2.2.7).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Constant after initialisation.
    Fixed,
    /// Constant between events or communication points.
    Tunable,
    /// Changes at transitions only.
    Discrete,
    /// Changes at any time.
    Continuous,
}

/// How the initial value comes about (FMI 2.0.5, section 2.2.7).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Initial {
    /// By the start value.
    Exact,
    /// By calculation.
    Calculated,
}

/// Data type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A number with a unit.
    Real(Unit),
    /// A count.
    Integer,
    /// One of the items of a declared type.
    Enumeration(&'static str),
}

impl Kind {
    /// Whether the variable is read and set as Integer.
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::Real(_))
    }
}

/// A quantity of one mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModeItem {
    /// Natural frequency in Hz.
    Frequency,
    /// Damping ratio.
    DampingRatio,
    /// Viscous damping per modal mass in 1/s, beside the ratio.
    DampingRate,
    /// Modal mass in kg.
    Mass,
    /// Value of the mode shape at the tip.
    TipValue,
    /// Mode shape where the sensor looks over that at the tip.
    SensorRatio,
    /// What the mode has of the tip's motion where the clamp moves.
    ClampShare,
    /// Modal displacement in m.
    Displacement,
    /// Modal velocity in m/s.
    Velocity,
}

/// What a variable stands for in the physics; tells the binary where its value comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Quantity {
    BeltVelocity,
    NormalForce,
    ExternalForce,
    /// Acceleration of the clamp.
    ClampAcceleration,
    TipDisplacement,
    TipVelocity,
    TipAcceleration,
    FrictionForce,
    RelativeVelocity,
    ContactMode,
    PowerIntoBeam,
    TransitionCount,
    LastTransitionTime,
    MeasuredDisplacement,
    MeasuredVelocity,
    MeasuredAcceleration,
    BeltTravel,
    DwellTime,
    EnergyStored,
    EnergyBeltWork,
    EnergyContactDissipation,
    EnergyStructuralDissipation,
    EnergyExternalWork,
    ModeCount,
    /// Item of the mode with this index (from 0).
    Mode(usize, ModeItem),
    FrictionLaw,
    Mu0,
    A1,
    V1,
    A2,
    C2,
    MuS,
    MuK,
    StribeckVelocity,
    StribeckExponent,
    Viscous,
    TableCount,
    /// Velocity of a row (from 0) of the friction table.
    TableVelocity(usize),
    /// Coefficient of a row (from 0) of the friction table.
    TableCoefficient(usize),
    FrictionLevel,
    SensorOffset,
    Tolerance,
    StartContact,
    StartEffects,
    BeltTravelStart,
    DwellTimeStart,
    /// Parameter of an effect: index of the card and of the parameter.
    EffectParameter(usize, usize),
    /// State of an effect: index of the card and of the state.
    EffectState(usize, usize),
    /// Parameter of a user's effect: index of the effect and of the parameter.
    UserParameter(usize, usize),
    /// State of a user's effect: index of the effect.
    UserState(usize, usize),
    BeltDistance,
    /// Rate of the state with this value reference.
    Rate(u32),
}

/// One variable of the FMU.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Unique name.
    pub name: String,
    /// Value reference, fixed for ever.
    pub reference: u32,
    /// What it stands for.
    pub quantity: Quantity,
    /// Data type and unit.
    pub kind: Kind,
    /// Causality.
    pub causality: Causality,
    /// Variability.
    pub variability: Variability,
    /// How the initial value comes about; `None` for inputs.
    pub initial: Option<Initial>,
    /// Start value, present where the variable can be set.
    pub start: Option<f64>,
    /// Smallest allowed value.
    pub min: Option<f64>,
    /// Largest allowed value.
    pub max: Option<f64>,
    /// Typical magnitude.
    pub nominal: Option<f64>,
    /// What it is, in words.
    pub description: String,
}

impl Variable {
    /// Whether it can be set while a run is under way, at events and communication points.
    pub fn is_settable_in_a_run(&self) -> bool {
        self.causality == Causality::Input || self.variability == Variability::Tunable
    }

    /// Whether it can be set before or during initialisation.
    pub fn is_settable(&self) -> bool {
        self.start.is_some()
    }
}
