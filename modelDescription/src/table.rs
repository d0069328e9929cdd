//! The fixed part of the table of variables, in the order of the XML. Value references are fixed for ever:
//!
//! | from | what |
//! |---|---|
//! | 1 | inputs |
//! | 10 | outputs |
//! | 30 | energies, their rates from 36 on; 40: distance of the belt and its rate |
//! | 100 | modes: 100 + 10 j + item, j = 1..8; rates of the states at items 6, 7 |
//! | 200 | friction |
//! | 300 | sensor, tolerance, start |
//! | 1000 | effects, each its block of 100: parameter i at +i, state j at +60 + j, its rate at +80 + j; without states all 100 are for parameters |
//! | 9000 | users' effects, each its block of 100 (see `layout`) |

use crate::declared_type::enumeration;
use crate::variable::{Causality, Initial, Kind, ModeItem, Quantity, Variability, Variable};
use beam_physics::beam::{Beam, MAX_MODES, cantilever_clamp_share};
use beam_physics::effects::CATALOGUE;
use beam_physics::friction::{Exponential, FrictionLaw, MAX_TABLE};
use beam_physics::unit::{
    HERTZ, JOULE, KILOGRAM, METRE, METRE_PER_SECOND, METRE_PER_SECOND2, NEWTON, ONE, PER_SECOND,
    SECOND, SECOND_PER_METRE, Unit, WATT,
};
use std::sync::LazyLock;

/// Place of an effect's states within its block of value references.
const FIRST_STATE: u32 = 60;
/// Place of their rates.
const FIRST_RATE: u32 = 80;

static TABLE: LazyLock<Vec<Variable>> = LazyLock::new(build);

/// All variables that every FMU has, in the order of the XML.
pub fn variables() -> &'static [Variable] {
    &TABLE
}

fn build() -> Vec<Variable> {
    let mut table = Vec::new();
    inputs(&mut table);
    outputs(&mut table);
    energies(&mut table);
    modes(&mut table);
    friction(&mut table);
    run(&mut table);
    effects(&mut table);
    for variable in &mut table {
        if is_tunable(variable) {
            variable.variability = Variability::Tunable;
        }
        if let Kind::Enumeration(name) = variable.kind {
            let items = enumeration(name);
            variable.min = items.iter().map(|item| f64::from(item.1)).reduce(f64::min);
            variable.max = items.iter().map(|item| f64::from(item.1)).reduce(f64::max);
        }
    }
    table
}

/// Real parameters of the model; counts and choices, tolerance and start values hold for a whole run.
fn is_tunable(variable: &Variable) -> bool {
    let of_the_start = matches!(
        variable.quantity,
        Quantity::Tolerance | Quantity::BeltTravelStart | Quantity::DwellTimeStart
    );
    variable.causality == Causality::Parameter
        && matches!(variable.kind, Kind::Real(_))
        && !of_the_start
}

/// The rate of a state (FMI 2.0.5, section 2.2.7, attribute `derivative`).
pub(crate) fn rate(reference: u32, state: &Variable) -> Variable {
    let Kind::Real(unit) = state.kind else {
        unreachable!("states are Real")
    };
    rate_in(unit.per_second(), reference, state)
}

/// The same in this unit.
pub(crate) fn rate_in(unit: Unit, reference: u32, state: &Variable) -> Variable {
    Variable {
        causality: Causality::Local,
        nominal: None,
        ..output(
            reference,
            &format!("der({})", state.name),
            Quantity::Rate(state.reference),
            Kind::Real(unit),
            Variability::Continuous,
            &format!("Rate of {}", state.name),
        )
    }
}

/// A fixed parameter; the other kinds are changes of it.
fn parameter(
    reference: u32,
    name: impl Into<String>,
    quantity: Quantity,
    kind: Kind,
    start: f64,
    description: impl Into<String>,
) -> Variable {
    Variable {
        name: name.into(),
        reference,
        quantity,
        kind,
        causality: Causality::Parameter,
        variability: Variability::Fixed,
        initial: Some(Initial::Exact),
        start: Some(start),
        min: None,
        max: None,
        nominal: None,
        description: description.into(),
    }
}

fn output(
    reference: u32,
    name: &str,
    quantity: Quantity,
    kind: Kind,
    variability: Variability,
    description: &str,
) -> Variable {
    Variable {
        causality: Causality::Output,
        variability,
        initial: Some(Initial::Calculated),
        start: None,
        ..parameter(reference, name, quantity, kind, 0.0, description)
    }
}

fn state(
    reference: u32,
    name: String,
    quantity: Quantity,
    unit: Unit,
    description: impl Into<String>,
    nominal: f64,
) -> Variable {
    Variable {
        causality: Causality::Local,
        variability: Variability::Continuous,
        nominal: Some(nominal),
        ..parameter(
            reference,
            name,
            quantity,
            Kind::Real(unit),
            0.0,
            description,
        )
    }
}

trait Bounds: Sized {
    fn at_least(self, min: f64) -> Self;
    fn at_most(self, max: f64) -> Self;
}

impl Bounds for Variable {
    fn at_least(mut self, min: f64) -> Self {
        self.min = Some(min);
        self
    }
    fn at_most(mut self, max: f64) -> Self {
        self.max = Some(max);
        self
    }
}

fn inputs(table: &mut Vec<Variable>) {
    let input = |reference, name: &str, quantity, unit, start, description: &str| Variable {
        causality: Causality::Input,
        variability: Variability::Continuous,
        initial: None,
        ..parameter(
            reference,
            name,
            quantity,
            Kind::Real(unit),
            start,
            description,
        )
    };
    table.push(input(
        1,
        "belt_velocity",
        Quantity::BeltVelocity,
        METRE_PER_SECOND,
        0.1,
        "Velocity v0 of the belt; zero and negative values are allowed",
    ));
    table.push(
        input(
            2,
            "normal_force",
            Quantity::NormalForce,
            NEWTON,
            100.0,
            "Force F_N that presses the tip on the belt",
        )
        .at_least(0.0),
    );
    table.push(Variable {
        nominal: Some(10.0),
        ..input(
            3,
            "external_force",
            Quantity::ExternalForce,
            NEWTON,
            0.0,
            "Force on the tip beside friction (shaker, hammer, motor), positive along the belt's motion",
        )
    });
    table.push(Variable {
        nominal: Some(1.0),
        ..input(
            4,
            "clamp_acceleration",
            Quantity::ClampAcceleration,
            METRE_PER_SECOND2,
            0.0,
            "Acceleration of the clamp, along the belt's motion; displacements are relative to the clamp, and the belt moves with it",
        )
    });
}

fn outputs(table: &mut Vec<Variable>) {
    use Variability::{Continuous, Discrete};
    let real = |reference, name, quantity, unit, variability, description| {
        let nominal = match quantity {
            Quantity::TipDisplacement | Quantity::MeasuredDisplacement => 1e-3,
            Quantity::TipAcceleration | Quantity::MeasuredAcceleration => 100.0,
            Quantity::FrictionForce => 50.0,
            Quantity::PowerIntoBeam => 5.0,
            Quantity::DwellTime => 1e-2,
            _ => 0.1,
        };
        Variable {
            nominal: Some(nominal),
            ..output(
                reference,
                name,
                quantity,
                Kind::Real(unit),
                variability,
                description,
            )
        }
    };
    table.extend([
        real(
            10,
            "tip_displacement",
            Quantity::TipDisplacement,
            METRE,
            Continuous,
            "Displacement w of the tip",
        ),
        real(
            11,
            "tip_velocity",
            Quantity::TipVelocity,
            METRE_PER_SECOND,
            Continuous,
            "Velocity w' of the tip",
        ),
        real(
            12,
            "tip_acceleration",
            Quantity::TipAcceleration,
            METRE_PER_SECOND2,
            Continuous,
            "Acceleration w'' of the tip",
        ),
        real(
            13,
            "friction_force",
            Quantity::FrictionForce,
            NEWTON,
            Continuous,
            "Friction force on the tip, positive along the belt's motion",
        ),
        real(
            14,
            "relative_velocity",
            Quantity::RelativeVelocity,
            METRE_PER_SECOND,
            Continuous,
            "Relative velocity v_r = w' - v_belt; exactly 0 in stick",
        ),
        output(
            15,
            "contact_mode",
            Quantity::ContactMode,
            Kind::Enumeration("ContactMode"),
            Discrete,
            "Mode of the contact: stick, slip, or a friction law with memory (bristle)",
        ),
        real(
            16,
            "power_into_beam",
            Quantity::PowerIntoBeam,
            WATT,
            Continuous,
            "Power that friction feeds into the beam, friction_force * tip_velocity",
        ),
        output(
            17,
            "transition_count",
            Quantity::TransitionCount,
            Kind::Integer,
            Discrete,
            "Number of transitions between stick and slip since the start",
        ),
        real(
            18,
            "last_transition_time",
            Quantity::LastTransitionTime,
            SECOND,
            Discrete,
            "Time of the last transition; the start time before the first",
        ),
        real(
            19,
            "measured_displacement",
            Quantity::MeasuredDisplacement,
            METRE,
            Continuous,
            "Displacement where the sensor looks (mode[j].sensor_ratio), after the measuring chain (lag, offset)",
        ),
        real(
            20,
            "belt_travel",
            Quantity::BeltTravel,
            METRE,
            Continuous,
            "Place s on the belt where the tip stands, s' = v_belt - w'",
        ),
        real(
            21,
            "dwell_time",
            Quantity::DwellTime,
            SECOND,
            Continuous,
            "Time since arrival in the present stick; 0 in slip",
        ),
        real(
            22,
            "measured_velocity",
            Quantity::MeasuredVelocity,
            METRE_PER_SECOND,
            Continuous,
            "Velocity where the sensor looks (mode[j].sensor_ratio)",
        ),
        real(
            23,
            "measured_acceleration",
            Quantity::MeasuredAcceleration,
            METRE_PER_SECOND2,
            Continuous,
            "Acceleration where the sensor looks (mode[j].sensor_ratio)",
        ),
    ]);
}

fn energies(table: &mut Vec<Variable>) {
    let items = [
        (
            "stored",
            Quantity::EnergyStored,
            "Kinetic and potential energy of the structure",
        ),
        (
            "belt_work",
            Quantity::EnergyBeltWork,
            "Work of the friction force at the belt's velocity since the start",
        ),
        (
            "contact_dissipation",
            Quantity::EnergyContactDissipation,
            "Heat in the contact since the start",
        ),
        (
            "structural_dissipation",
            Quantity::EnergyStructuralDissipation,
            "Heat in the structure since the start",
        ),
        (
            "external_work",
            Quantity::EnergyExternalWork,
            "Work of the external force and of the clamp's acceleration since the start",
        ),
    ];
    let first = table.len();
    for (i, (name, quantity, description)) in items.into_iter().enumerate() {
        table.push(Variable {
            causality: Causality::Local,
            nominal: Some(0.1),
            ..output(
                30 + i as u32,
                &format!("energy.{name}"),
                quantity,
                Kind::Real(JOULE),
                Variability::Continuous,
                description,
            )
        });
    }
    whole(table, first);
}

/// States of the whole: the energies that add up, and the distance that the belt has run.
fn whole(table: &mut Vec<Variable>, energies: usize) {
    // The stored energy follows from the other states.
    for (i, reference) in [36, 37, 38, 39].into_iter().enumerate() {
        let of = table[energies + 1 + i].clone();
        table.push(rate(reference, &of));
    }
    let distance = Variable {
        causality: Causality::Local,
        nominal: Some(0.1),
        ..output(
            40,
            "belt_distance",
            Quantity::BeltDistance,
            Kind::Real(METRE),
            Variability::Continuous,
            "Distance that the belt has run by its given velocity, from the place under the undeflected tip on",
        )
    };
    let of = rate(41, &distance);
    table.extend([distance, of]);
}

fn modes(table: &mut Vec<Variable>) {
    let nominal = Beam::default();
    let first = nominal.modes();
    let all = Beam::nominal(MAX_MODES);
    table.push(
        parameter(
            100,
            "mode_count",
            Quantity::ModeCount,
            Kind::Integer,
            first.len() as f64,
            "Number of modes of the structure",
        )
        .at_least(1.0)
        .at_most(MAX_MODES as f64),
    );
    for (j, mode) in all.modes().iter().enumerate() {
        let base = 110 + 10 * j as u32;
        let n = j + 1;
        let data = [
            (
                "frequency",
                ModeItem::Frequency,
                HERTZ,
                mode.frequency,
                Some(0.0),
                "Natural frequency",
            ),
            (
                "damping_ratio",
                ModeItem::DampingRatio,
                ONE,
                mode.damping_ratio,
                Some(0.0),
                "Damping ratio",
            ),
            (
                "mass",
                ModeItem::Mass,
                KILOGRAM,
                mode.mass,
                Some(0.0),
                "Modal mass",
            ),
            (
                "tip_value",
                ModeItem::TipValue,
                ONE,
                mode.tip_value,
                None,
                "Value of the mode shape at the tip",
            ),
        ];
        for (i, (name, item, unit, start, min, what)) in data.into_iter().enumerate() {
            table.push(Variable {
                min,
                ..parameter(
                    base + i as u32,
                    format!("mode[{n}].{name}"),
                    Quantity::Mode(j, item),
                    Kind::Real(unit),
                    start,
                    format!("{what} of mode {n}"),
                )
            });
        }
        table.push(Variable {
            min: Some(0.0),
            ..parameter(
                base + 9,
                format!("mode[{n}].damping_rate"),
                Quantity::Mode(j, ModeItem::DampingRate),
                Kind::Real(PER_SECOND),
                0.0,
                format!("Viscous damping per modal mass of mode {n}, c/m beside 2 D w: that of a mass without a spring"),
            )
        });
        table.push(parameter(
            base + 8,
            format!("mode[{n}].sensor_ratio"),
            Quantity::Mode(j, ModeItem::SensorRatio),
            Kind::Real(ONE),
            1.0,
            format!("Value of the mode shape where the sensor looks over that at the tip, mode {n}; 1 for a sensor at the tip"),
        ));
        table.push(state(
            base + 4,
            format!("q[{n}]"),
            Quantity::Mode(j, ModeItem::Displacement),
            METRE,
            format!("Modal displacement of mode {n}; w = sum of tip_value * q"),
            1e-3,
        ));
        table.push(state(
            base + 5,
            format!("q_dot[{n}]"),
            Quantity::Mode(j, ModeItem::Velocity),
            METRE_PER_SECOND,
            format!("Modal velocity of mode {n}"),
            0.1,
        ));
        let states = table[table.len() - 2..].to_vec();
        for (i, state) in states.iter().enumerate() {
            table.push(rate(base + 6 + i as u32, state));
        }
        table.push(parameter(
            190 + j as u32,
            format!("mode[{n}].clamp_share"),
            Quantity::Mode(j, ModeItem::ClampShare),
            Kind::Real(ONE),
            cantilever_clamp_share(j),
            format!("Part of mode {n} in the tip's motion where the clamp moves, tip_value * g with q'' = ... - g clamp_acceleration; all modes of a cantilever together give 1, and so does a mass on a spring"),
        ));
    }
}

/// Velocity in m/s of a row of the default friction table: dense where eq. (7) falls.
fn table_velocity(row: usize) -> f64 {
    let share = row as f64 / (MAX_TABLE - 1) as f64;
    // Rounded, so that the description stays readable.
    (0.5 * share * share * 1e4).round() / 1e4
}

fn friction(table: &mut Vec<Variable>) {
    let constants = Exponential::default();
    let law = FrictionLaw::default();
    let at_high_speed = 0.34;
    table.push(parameter(
        200,
        "friction.law",
        Quantity::FrictionLaw,
        Kind::Enumeration("FrictionLaw"),
        1.0,
        "Friction law in use",
    ));
    let stelter = "(Stelter 1992, eq. 7)";
    let rows = [
        (
            "mu_0",
            Quantity::Mu0,
            ONE,
            constants.mu_0,
            format!("Static coefficient mu_0 {stelter}"),
        ),
        (
            "a1",
            Quantity::A1,
            ONE,
            constants.a1,
            format!("Share of friction that falls fast with speed {stelter}"),
        ),
        (
            "v1",
            Quantity::V1,
            METRE_PER_SECOND,
            constants.v1,
            format!("Speed over which the fast share falls {stelter}"),
        ),
        (
            "a2",
            Quantity::A2,
            ONE,
            constants.a2,
            format!("Share of friction that falls slowly with speed {stelter}"),
        ),
        (
            "c2",
            Quantity::C2,
            SECOND_PER_METRE,
            constants.c2,
            format!("Rate at which the slow share falls {stelter}"),
        ),
        (
            "mu_s",
            Quantity::MuS,
            ONE,
            constants.mu_0,
            "Static coefficient (Coulomb, Stribeck)".into(),
        ),
        (
            "mu_k",
            Quantity::MuK,
            ONE,
            at_high_speed,
            "Kinetic coefficient (Coulomb, Stribeck)".into(),
        ),
        (
            "stribeck_velocity",
            Quantity::StribeckVelocity,
            METRE_PER_SECOND,
            constants.v1,
            "Speed over which friction falls (Stribeck)".into(),
        ),
        (
            "stribeck_exponent",
            Quantity::StribeckExponent,
            ONE,
            1.0,
            "Exponent of the Stribeck curve".into(),
        ),
        (
            "viscous",
            Quantity::Viscous,
            SECOND_PER_METRE,
            0.0,
            "Viscous coefficient (Stribeck)".into(),
        ),
        (
            "level",
            Quantity::FrictionLevel,
            ONE,
            1.0,
            "Factor on friction as a whole; differs from run to run on a real rig".into(),
        ),
    ];
    for (i, (name, quantity, unit, start, description)) in rows.into_iter().enumerate() {
        table.push(
            parameter(
                201 + i as u32,
                format!("friction.{name}"),
                quantity,
                Kind::Real(unit),
                start,
                description,
            )
            .at_least(0.0),
        );
    }
    table.push(
        parameter(
            220,
            "friction.table.count",
            Quantity::TableCount,
            Kind::Integer,
            MAX_TABLE as f64,
            "Number of rows of the friction table in use",
        )
        .at_least(2.0)
        .at_most(MAX_TABLE as f64),
    );
    for row in 0..MAX_TABLE {
        let v = table_velocity(row);
        let mu = (law.coefficient(v) * 1e6).round() / 1e6;
        let n = row + 1;
        table.push(
            parameter(
                221 + row as u32,
                format!("friction.table.velocity[{n}]"),
                Quantity::TableVelocity(row),
                Kind::Real(METRE_PER_SECOND),
                v,
                format!("Speed of row {n} of the friction table; rising"),
            )
            .at_least(0.0),
        );
        table.push(
            parameter(
                261 + row as u32,
                format!("friction.table.coefficient[{n}]"),
                Quantity::TableCoefficient(row),
                Kind::Real(ONE),
                mu,
                format!("Coefficient of row {n} of the friction table; row 1 is the static one"),
            )
            .at_least(0.0),
        );
    }
}

fn run(table: &mut Vec<Variable>) {
    let real = |reference, name: &str, quantity, unit, start, description: &str| {
        parameter(
            reference,
            name,
            quantity,
            Kind::Real(unit),
            start,
            description,
        )
    };
    table.extend([
        real(
            300,
            "sensor.offset",
            Quantity::SensorOffset,
            METRE,
            0.0,
            "Offset added to measured_displacement",
        ),
        real(
            301,
            "tolerance",
            Quantity::Tolerance,
            ONE,
            beam_physics::simulate::DEFAULT_TOLERANCE,
            "Relative tolerance of the integration; a master's tighter one takes precedence",
        )
        .at_least(1e-14)
        .at_most(0.1),
        parameter(
            302,
            "start.contact",
            Quantity::StartContact,
            Kind::Enumeration("StartContact"),
            0.0,
            "Mode of the contact at the start",
        ),
        parameter(
            303,
            "start.effects",
            Quantity::StartEffects,
            Kind::Enumeration("StartEffects"),
            0.0,
            "Meaning of the start values of the effects' states",
        ),
        real(
            304,
            "belt_travel.start",
            Quantity::BeltTravelStart,
            METRE,
            0.0,
            "Place on the belt where the tip stands at the start",
        ),
        real(
            305,
            "dwell_time.start",
            Quantity::DwellTimeStart,
            SECOND,
            0.0,
            "Time for which the contact has stuck already at the start",
        )
        .at_least(0.0),
    ]);
}

fn effects(table: &mut Vec<Variable>) {
    for (index, card) in CATALOGUE.iter().enumerate() {
        for (i, p) in card.parameters.iter().enumerate() {
            table.push(parameter(
                card.first_value_reference + i as u32,
                format!("{}.{}", card.id, p.name),
                Quantity::EffectParameter(index, i),
                Kind::Real(p.unit),
                p.start,
                format!("{}: {}", card.title, p.description),
            ));
        }
        let first = table.len();
        for (i, s) in card.states.iter().enumerate() {
            table.push(state(
                card.first_value_reference + FIRST_STATE + i as u32,
                format!("{}.state.{}", card.id, s.name),
                Quantity::EffectState(index, i),
                s.unit,
                format!("{}: {}", card.title, s.description),
                s.nominal,
            ));
        }
        for i in 0..card.states.len() {
            let of = table[first + i].clone();
            table.push(rate(
                card.first_value_reference + FIRST_RATE + i as u32,
                &of,
            ));
        }
    }
}
