//! The second model of the binary: the belt drive. Its variables, and its modelDescription.xml.
//!
//! It offers co-simulation only. The table is small and has no users' effects, so it needs no layout.

use crate::declared_type::of_unit;
use crate::variable::Causality;
use crate::xml::{co_simulation, document, log_categories, number, real_types, units};
use beam_physics::unit::{
    KILOGRAM, METRE, METRE_PER_SECOND, METRE_PER_SECOND2, NEWTON, NEWTON_PER_METRE,
    NEWTON_SECOND_PER_METRE, Unit,
};
use quick_xml::Writer;
use std::io;
use std::sync::LazyLock;

/// Name of the model and of its binary.
pub const IDENTIFIER: &str = "BeltDrive";

/// What a variable of the drive stands for; its place in [`VARIABLES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Item {
    FrictionForce = 0,
    MotorVelocity,
    BeltVelocity,
    BeltAcceleration,
    Stretch,
    MotorForce,
    Mass,
    Stiffness,
    Damping,
    StretchStart,
    StretchRateStart,
}

/// A Real variable of the drive.
#[derive(Debug)]
pub struct Variable {
    /// Unique name.
    pub name: &'static str,
    /// Value reference, fixed for ever.
    pub reference: u32,
    /// What it stands for.
    pub item: Item,
    /// Unit.
    pub unit: Unit,
    /// Causality.
    pub causality: Causality,
    /// Start value of inputs and parameters.
    pub start: Option<f64>,
    /// Smallest allowed value.
    pub min: Option<f64>,
    /// Names of the inputs on which an output depends at once.
    depends_on: &'static [&'static str],
    description: &'static str,
}

const fn input(
    reference: u32,
    name: &'static str,
    item: Item,
    unit: Unit,
    start: f64,
    description: &'static str,
) -> Variable {
    Variable {
        name,
        reference,
        item,
        unit,
        causality: Causality::Input,
        start: Some(start),
        min: None,
        depends_on: &[],
        description,
    }
}

const fn output(
    reference: u32,
    name: &'static str,
    item: Item,
    unit: Unit,
    depends_on: &'static [&'static str],
    description: &'static str,
) -> Variable {
    Variable {
        name,
        reference,
        item,
        unit,
        causality: Causality::Output,
        start: None,
        min: None,
        depends_on,
        description,
    }
}

const fn parameter(
    reference: u32,
    name: &'static str,
    item: Item,
    unit: Unit,
    (start, min): (f64, Option<f64>),
    description: &'static str,
) -> Variable {
    Variable {
        name,
        reference,
        item,
        unit,
        causality: Causality::Parameter,
        start: Some(start),
        min,
        depends_on: &[],
        description,
    }
}

/// All variables, in the order of the XML and of [`Item`].
pub static VARIABLES: [Variable; 11] = [
    input(
        1,
        "friction_force",
        Item::FrictionForce,
        NEWTON,
        0.0,
        "friction force F on the beam's tip; its reaction brakes the belt",
    ),
    input(
        2,
        "motor_velocity",
        Item::MotorVelocity,
        METRE_PER_SECOND,
        0.1,
        "velocity v_m at which the motor pays out",
    ),
    output(
        10,
        "belt_velocity",
        Item::BeltVelocity,
        METRE_PER_SECOND,
        &[],
        "velocity u of the belt at the contact",
    ),
    output(
        11,
        "belt_acceleration",
        Item::BeltAcceleration,
        METRE_PER_SECOND2,
        &["friction_force", "motor_velocity"],
        "acceleration of the belt at the contact",
    ),
    output(
        12,
        "stretch",
        Item::Stretch,
        METRE,
        &[],
        "displacement x of the belt against the motor",
    ),
    output(
        13,
        "motor_force",
        Item::MotorForce,
        NEWTON,
        &["motor_velocity"],
        "force with which the motor pulls at the belt",
    ),
    parameter(
        100,
        "mass",
        Item::Mass,
        KILOGRAM,
        (1.5, Some(1e-6)),
        "mass M of belt and rollers at the contact",
    ),
    parameter(
        101,
        "stiffness",
        Item::Stiffness,
        NEWTON_PER_METRE,
        (2e4, Some(0.0)),
        "stiffness k of the belt between motor and contact",
    ),
    parameter(
        102,
        "damping",
        Item::Damping,
        NEWTON_SECOND_PER_METRE,
        (50.0, Some(0.0)),
        "damping c of the belt between motor and contact",
    ),
    parameter(
        110,
        "stretch.start",
        Item::StretchStart,
        METRE,
        (0.0, None),
        "displacement x at the start",
    ),
    parameter(
        111,
        "stretch_rate.start",
        Item::StretchRateStart,
        METRE_PER_SECOND,
        (0.0, None),
        "velocity of the belt against the motor at the start",
    ),
];

/// The description and its GUID.
static DESCRIPTION: LazyLock<(String, String)> = LazyLock::new(|| {
    let about = "Belt drive: a motor pulls an elastic belt that friction brakes";
    document(IDENTIFIER, about, 0, content)
});

/// The text of modelDescription.xml.
pub fn xml() -> &'static str {
    &DESCRIPTION.0
}

/// The GUID of the description.
pub fn guid() -> &'static str {
    &DESCRIPTION.1
}

/// Index of the variable with a value reference.
pub fn index_of_reference(reference: u32) -> Option<usize> {
    VARIABLES.iter().position(|v| v.reference == reference)
}

fn content(w: &mut Writer<Vec<u8>>) -> io::Result<()> {
    let used: Vec<Unit> = beam_physics::unit::ALL
        .iter()
        .copied()
        .filter(|unit| VARIABLES.iter().any(|v| v.unit == *unit))
        .collect();
    co_simulation(w, IDENTIFIER, false)?;
    units(w, &used)?;
    w.create_element("TypeDefinitions")
        .write_inner_content(|w| real_types(w, &used))?;
    log_categories(w)?;
    w.create_element("DefaultExperiment")
        .with_attributes([
            ("startTime", "0.0"),
            ("stopTime", "2.0"),
            ("stepSize", "1e-4"),
        ])
        .write_empty()?;
    w.create_element("ModelVariables")
        .write_inner_content(|w| VARIABLES.iter().try_for_each(|v| scalar(w, v)))?;
    structure(w)
}

fn scalar(w: &mut Writer<Vec<u8>>, variable: &Variable) -> io::Result<()> {
    let (causality, variability, initial) = match variable.causality {
        Causality::Input => ("input", "continuous", None),
        Causality::Parameter => ("parameter", "fixed", Some("exact")),
        _ => ("output", "continuous", Some("calculated")),
    };
    let reference = variable.reference.to_string();
    let mut attributes = vec![
        ("name", variable.name),
        ("valueReference", &reference),
        ("description", variable.description),
        ("causality", causality),
        ("variability", variability),
    ];
    attributes.extend(initial.map(|value| ("initial", value)));
    w.create_element("ScalarVariable")
        .with_attributes(attributes)
        .write_inner_content(|w| {
            let mut attributes = Vec::new();
            if let Some((name, _)) = of_unit(variable.unit) {
                attributes.push(("declaredType", name.to_owned()));
            }
            attributes.push(("unit", variable.unit.symbol.to_owned()));
            attributes.extend(variable.min.map(|min| ("min", number(min))));
            attributes.extend(variable.start.map(|start| ("start", number(start))));
            w.create_element("Real")
                .with_attributes(attributes.iter().map(|(k, v)| (*k, v.as_str())))
                .write_empty()?;
            Ok(())
        })?;
    Ok(())
}

fn structure(w: &mut Writer<Vec<u8>>) -> io::Result<()> {
    // Indices count from 1 (FMI 2.0.5, section 2.2.8).
    let place = |name: &str| VARIABLES.iter().position(|v| v.name == name);
    let number = |name: &&str| (place(name).expect("in the table") + 1).to_string();
    let outputs = || {
        let all = VARIABLES.iter().enumerate();
        all.filter(|(_, v)| v.causality == Causality::Output)
    };
    w.create_element("ModelStructure")
        .write_inner_content(|w| {
            w.create_element("Outputs").write_inner_content(|w| {
                for (index, variable) in outputs() {
                    let knowns: Vec<String> = variable.depends_on.iter().map(number).collect();
                    w.create_element("Unknown")
                        .with_attributes([
                            ("index", (index + 1).to_string().as_str()),
                            ("dependencies", &knowns.join(" ")),
                        ])
                        .write_empty()?;
                }
                Ok(())
            })?;
            // These depend on start values and parameters as well: no list.
            w.create_element("InitialUnknowns")
                .write_inner_content(|w| {
                    for (index, _) in outputs() {
                        w.create_element("Unknown")
                            .with_attribute(("index", (index + 1).to_string().as_str()))
                            .write_empty()?;
                    }
                    Ok(())
                })?;
            Ok(())
        })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_its_items() {
        for (index, variable) in VARIABLES.iter().enumerate() {
            assert_eq!(variable.item as usize, index, "{}", variable.name);
            assert_eq!(index_of_reference(variable.reference), Some(index));
        }
    }
}
