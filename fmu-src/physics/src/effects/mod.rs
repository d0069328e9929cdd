//! The catalogue of physical effects that the reference model leaves out.
//!
//! An effect is one file: a static [`Card`] that describes it to people and tools, and a type with
//! [`Effect`], whose hooks all default to "adds nothing". Off is bit-identical to absent, because an
//! effect that is off is never built.

pub mod series;
pub mod user_expression;

use crate::beam::Beam;
use crate::belt::Inputs;
use crate::error::PhysicsError;
use crate::real::{Real, ZERO, real};
use crate::unit::Unit;

include!(concat!(env!("OUT_DIR"), "/catalogue.rs"));

/// Builds an effect from its parameter values, or nothing where they mean "off".
pub type Build = fn(&Context) -> Result<Option<Box<dyn Effect>>, PhysicsError>;

/// Describes an effect: what it is called, what it does, which parameters and states it has.
pub struct Card {
    /// Identifier, fixed for ever.
    pub id: &'static str,
    /// Title in a few words.
    pub title: &'static str,
    /// The equation in plain text.
    pub equation: &'static str,
    /// What happens physically, in one or two sentences.
    pub description: &'static str,
    /// Author, year, equation or page.
    pub source: &'static str,
    /// How it shows in a measured tip displacement.
    pub signature: &'static str,
    /// Effects that look alike, by id, and what tells them apart.
    pub confounders: &'static str,
    /// First value reference of the effect's own block of 100, fixed for ever.
    pub first_value_reference: u32,
    /// Parameters; all at their start values means off.
    pub parameters: &'static [Parameter],
    /// Extra continuous states.
    pub states: &'static [StateVariable],
    /// Builds the effect from its parameter values, or `None` where they mean "off".
    pub build: Build,
}

/// How a parameter enters, which tells a calibration what to do with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Strength: zero means off, and the response is nearly linear in it.
    Amplitude,
    /// A shape constant (time, length, frequency, stiffness) without effect while the amplitude is zero.
    Shape,
    /// A phase, which differs from run to run.
    Phase,
    /// One of many values of a profile along the belt, which differs from run to run.
    Node,
    /// A choice or a size that is given, never calibrated.
    Setting,
}

/// Length in m, velocity in m/s and force in N of a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    /// Spread of the velocity of the contact over the lowest natural angular frequency.
    pub length: f64,
    /// Spread of its velocity.
    pub velocity: f64,
    /// Force that changes this velocity over that length.
    pub force: f64,
}

/// The machine on which the values of the cards are met: the nominal beam in stick-slip, belts of 0.04 to 0.2 m/s and 30 to 150 N. The
/// velocity is the middle of those of the practice campaigns, 0.06 to 0.18 m/s; its first mode has 80 Hz and a force at its tip moves
/// an eighth of its 0.427 kg: `v/w_1` and `m v w_1`.
pub const MACHINE: Machine = Machine {
    length: 2.4e-4,
    velocity: 0.12,
    force: 3.2,
};

/// One parameter of an effect.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name within the effect.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Value that means off or neutral.
    pub start: f64,
    /// A value as met in practice, at which the effect is plainly visible.
    pub typical: f64,
    /// Smallest plausible value.
    pub min: f64,
    /// Largest plausible value.
    pub max: f64,
    /// How it enters.
    pub role: Role,
}

/// One extra continuous state of an effect.
#[derive(Debug, Clone, Copy)]
pub struct StateVariable {
    /// Name within the effect.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Typical magnitude for the nominal beam, for scaling.
    pub nominal: f64,
}

/// What an effect may look at while it is built.
pub struct Context<'a> {
    /// The effect's parameter values in the order of its card.
    pub values: &'a [Real],
    /// The structure with the modes retained so far.
    pub beam: &'a Beam,
    card: &'static Card,
}

impl<'a> Context<'a> {
    /// A context for the effect of `card`.
    pub fn new(card: &'static Card, values: &'a [Real], beam: &'a Beam) -> Self {
        Self { values, beam, card }
    }

    /// Refuses a parameter that does not satisfy `ok`.
    ///
    /// # Errors
    /// [`PhysicsError::OutOfRange`] naming the parameter.
    pub fn require(
        &self,
        index: usize,
        ok: bool,
        required: &'static str,
    ) -> Result<(), PhysicsError> {
        let parameter = &self.card.parameters[index];
        crate::error::require(
            ok,
            &format!("{}.{}", self.card.id, parameter.name),
            self.values[index],
            parameter.unit.symbol,
            required,
        )
    }
}

/// The motion at one instant, as effects see it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Motion {
    /// Time in s.
    pub time: Real,
    /// Tip displacement w in m.
    pub displacement: Real,
    /// Tip velocity w' in m/s.
    pub velocity: Real,
    /// Displacement in m where the sensor looks; w for a sensor at the contact.
    pub sensor_displacement: Real,
    /// Velocity in m/s where the sensor looks.
    pub sensor_velocity: Real,
    /// Velocity v0 of the belt in m/s as given, before any effect.
    pub given_belt_velocity: Real,
    /// Velocity of the belt's surface in m/s, all effects included.
    pub belt_velocity: Real,
    /// Relative velocity v_r = w' - v_belt in m/s; exactly 0 in stick.
    pub relative_velocity: Real,
    /// Sliding speed |v_r| in m/s, continued smoothly through zero by the sign of the slip.
    pub speed: Real,
    /// Normal force F_N in N as given, before any effect.
    pub normal_force: Real,
    /// Place s on the belt where the tip stands, in m: s' = v_belt - w'.
    pub travel: Real,
    /// Time since stick began, in s; 0 in slip.
    pub dwell: Real,
}

/// The contact at one instant, given to the rates of an effect's states.
#[derive(Debug, Clone, Copy)]
pub struct ContactForce {
    /// Friction force F on the tip in N, positive along the belt's motion.
    pub force: Real,
    /// Friction capacity mu(|v_r|) F_N in N.
    pub capacity: Real,
    /// Whether the contact sticks.
    pub stuck: bool,
}

/// The contribution of a drive that gives way to the belt's motion.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BeltGive {
    /// Displacement x in m added to the belt.
    pub displacement: Real,
    /// Velocity x' in m/s.
    pub velocity: Real,
    /// Acceleration in m/s^2 without friction force.
    pub free_acceleration: Real,
    /// Mobility in 1/kg: acceleration lost per newton of friction force.
    pub mobility: Real,
}

impl BeltGive {
    /// What `x` times as much of a state gives.
    #[inline]
    pub fn times(self, x: Real) -> Self {
        Self {
            displacement: self.displacement * x,
            velocity: self.velocity * x,
            free_acceleration: self.free_acceleration * x,
            mobility: self.mobility * x,
        }
    }
    /// Adds what another part gives.
    #[inline]
    pub fn add(&mut self, part: Self) {
        self.displacement += part.displacement;
        self.velocity += part.velocity;
        self.free_acceleration += part.free_acceleration;
        self.mobility += part.mobility;
    }
}

/// The hooks of an effect. Every default adds nothing. `x` are the effect's own states.
pub trait Effect: Send + Sync {
    /// Adds modes to the structure, once.
    ///
    /// # Errors
    /// A mode that is not possible.
    fn extend_structure(&self, _beam: &mut Beam) -> Result<(), PhysicsError> {
        Ok(())
    }
    /// Works out, once, what depends on the complete structure.
    fn prepare(&mut self, _beam: &Beam) {}
    /// Adds to the modal accelerations (m/s^2), given the structure's states `modes`: displacement and velocity of each mode.
    fn add_modal_acceleration(
        &self,
        _m: &Motion,
        _x: &[Real],
        _modes: &[Real],
        _acceleration: &mut [Real],
    ) {
    }
    /// Force on the tip besides friction, in N.
    fn tip_force(&self, _m: &Motion, _x: &[Real]) -> Real {
        ZERO
    }
    /// Factor on the coefficient of friction.
    fn friction_factor(&self, _m: &Motion, _x: &[Real]) -> Real {
        real(1.0)
    }
    /// Slope in s/m of a term added to the kinetic coefficient of friction, linear in the sliding speed (|v_r|,
    /// or what a lag makes of it); asked for while the model is built.
    fn friction_slope(&self) -> Real {
        ZERO
    }
    /// Factor on the normal force.
    fn normal_factor(&self, _m: &Motion, _x: &[Real]) -> Real {
        real(1.0)
    }
    /// Factor on the static limit.
    fn static_factor(&self, _m: &Motion) -> Real {
        real(1.0)
    }
    /// Speed at which the kinetic law is evaluated instead of |v_r|.
    fn lagged_speed(&self, _x: &[Real]) -> Option<Real> {
        None
    }
    /// Whether friction has a memory of its own that replaces the rigid stick/slip automaton.
    fn replaces_stick(&self) -> bool {
        false
    }
    /// Friction force in N of a law with memory, for a capacity mu F_N in N.
    fn memory_force(&self, _m: &Motion, _capacity: Real, _x: &[Real]) -> Real {
        ZERO
    }
    /// Velocity in m/s imposed on the belt besides the given one, whatever the friction force; its
    /// integral is the `displacement` of [`Effect::belt_give`].
    fn belt_ripple(&self, _t: Real, _inputs: &Inputs) -> Real {
        ZERO
    }
    /// Whether [`Effect::belt_ripple`] is ever different from zero.
    fn has_belt_ripple(&self) -> bool {
        false
    }
    /// Motion added to the belt, linear in the states, with a constant mobility; asked for while the
    /// model is built.
    fn belt_give(&self, _x: &[Real]) -> BeltGive {
        BeltGive::default()
    }
    /// Rates of the effect's states.
    fn add_rates(&self, _m: &Motion, _contact: &ContactForce, _x: &[Real], _rates: &mut [Real]) {}
    /// Jump of the states at the arrival in stick.
    fn on_stick(&self, _x: &mut [Real]) {}
    /// Jump of the states at break-away.
    fn on_break_away(&self, _x: &mut [Real]) {}
    /// States in equilibrium with the start motion and contact force.
    fn settle(&self, _m: &Motion, _contact: &ContactForce, _x: &mut [Real]) {}
    /// What the sensor makes of a reading in m, which is the tip displacement or what an effect before has made of it.
    fn measured_displacement(&self, reading: Real, _m: &Motion, _x: &[Real]) -> Real {
        reading
    }
    /// Whether [`Effect::measured_displacement`] is linear in the states, the same at all times.
    fn measures_linearly(&self) -> bool {
        true
    }
    /// Fastest rate (1/s) or angular frequency (rad/s) that the effect brings into the equations.
    fn fastest_rate(&self) -> f64 {
        0.0
    }
    /// What is wrong with the effect at this instant, where it can't be evaluated.
    fn fault(&self, _m: &Motion, _x: &[Real]) -> Option<PhysicsError> {
        None
    }
    /// Whether the equations stay linear with constant coefficients while the contact sticks.
    fn is_linear_in_stick(&self) -> bool {
        true
    }
    /// Whether the static limit is constant during stick.
    fn keeps_limit_constant(&self) -> bool {
        true
    }
    /// The hooks on power series, for an effect that has them; slip is else integrated by a method
    /// that asks for the rates alone.
    fn series(&self) -> Option<&dyn series::EffectSeries> {
        None
    }
}

/// Finds `effect.parameter` in the catalogue: index of the card and of the parameter.
///
/// # Errors
/// [`PhysicsError::UnknownParameter`].
pub fn find_parameter(name: &str) -> Result<(usize, usize), PhysicsError> {
    let unknown = || PhysicsError::UnknownParameter {
        name: name.to_owned(),
    };
    let (id, parameter) = name.split_once('.').ok_or_else(unknown)?;
    let card = CATALOGUE
        .iter()
        .position(|c| c.id == id)
        .ok_or_else(unknown)?;
    let index = CATALOGUE[card]
        .parameters
        .iter()
        .position(|p| p.name == parameter)
        .ok_or_else(unknown)?;
    Ok((card, index))
}
