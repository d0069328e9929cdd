//! Where unknown functions act, and what they depend on.

/// Where an unknown function acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// Name in `diagnosis.json`.
    pub name: &'static str,
    /// Target in an effect's file.
    pub target: &'static str,
    /// The formula, with `G` for the curve.
    pub formula: &'static str,
    /// The mode, from 1, where it acts on one alone.
    pub mode: Option<usize>,
}

const fn place(name: &'static str, target: &'static str, formula: &'static str) -> Place {
    Place {
        name,
        target,
        formula,
        mode: None,
    }
}

pub(super) const FRICTION: Place = place("friction", "friction_factor", "1 + G");
/// Where it depends on the load alone it is a factor on each run's level of friction, which is fitted by its logarithm: the
/// valley in which the two trade is straight.
pub(super) const FRICTION_LEVEL: Place = place("friction", "friction_factor", "exp(G)");
/// A force that adds to the normal force, so that it counts less at a higher one; in shares of the mean one.
pub(super) const NORMAL_FORCE: Place = place(
    "normal_force",
    "normal_force_factor",
    "1 + G*MEAN_FORCE/F_N",
);
pub(super) const TIP_FORCE: Place = place("tip_force", "tip_force", "G");
pub(super) const FREQUENCY: Place = place("frequency", "frequency_factor", "1 + G");
/// Of the first mode alone: a mass that comes and goes, a contact that gives way, while temperature acts on all modes alike.
pub(super) const FIRST_FREQUENCY: Place = Place {
    mode: Some(1),
    ..FREQUENCY
};
pub(super) const DAMPING: Place = place("damping", "damping_factor", "1 + G");
pub(super) const MEASUREMENT: Place = place("measurement", "measurement", "w + G");
pub(super) const BELT: Place = place("belt", "belt_velocity", "v0*G");

/// What an unknown function depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Argument {
    /// Name in `diagnosis.json` and in the identifier.
    pub name: &'static str,
    /// The quantity of the formula; for one with a memory, what is low-passed.
    pub quantity: &'static str,
    pub unit: &'static str,
    /// Whether it is the quantity low-passed with a time constant.
    pub remembers: bool,
}

const fn argument(name: &'static str, quantity: &'static str, unit: &'static str) -> Argument {
    Argument {
        name,
        quantity,
        unit,
        remembers: false,
    }
}

const fn past(name: &'static str, quantity: &'static str, unit: &'static str) -> Argument {
    Argument {
        name,
        quantity,
        unit,
        remembers: true,
    }
}

pub(super) const DEFLECTION: Argument = argument("w", "w", "m");
pub(super) const VELOCITY: Argument = argument("w_dot", "w_dot", "m/s");
pub(super) const SPEED: Argument = argument("v_r", "v_abs", "m/s");
pub(super) const TIME: Argument = argument("time", "t", "s");
pub(super) const LOAD: Argument = argument("normal_force", "F_N", "N");
pub(super) const DWELL: Argument = argument("dwell", "t_stick", "s");
pub(super) const PAST_SPEED: Argument = past("low_passed_v_r", "v_abs", "m/s");
pub(super) const PAST_POWER: Argument = past("low_passed_power", "abs(F*v_r)", "W");
pub(super) const PAST_DEFLECTION: Argument = past("low_passed_w", "abs(w)", "m");

/// All that are tried.
pub(super) const ALL: [(Place, Argument); 22] = [
    (FRICTION, DEFLECTION),
    (FRICTION, VELOCITY),
    (FRICTION, SPEED),
    (FRICTION, TIME),
    (FRICTION, DWELL),
    (FRICTION_LEVEL, LOAD),
    (FRICTION, PAST_SPEED),
    (FRICTION, PAST_POWER),
    (NORMAL_FORCE, DEFLECTION),
    (NORMAL_FORCE, VELOCITY),
    (TIP_FORCE, DEFLECTION),
    (TIP_FORCE, VELOCITY),
    (TIP_FORCE, TIME),
    (FREQUENCY, TIME),
    (FREQUENCY, PAST_DEFLECTION),
    (FIRST_FREQUENCY, TIME),
    (FIRST_FREQUENCY, PAST_DEFLECTION),
    (DAMPING, DEFLECTION),
    (DAMPING, PAST_DEFLECTION),
    (MEASUREMENT, DEFLECTION),
    (MEASUREMENT, TIME),
    (BELT, TIME),
];
