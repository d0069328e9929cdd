//! Writes modelDescription.xml.

use crate::declared_type::{ENUMERATIONS, display_units, of_unit, shown_in};
use crate::layout::Layout;
use crate::variable::{Causality, Initial, Kind, ModeItem, Quantity, Variability, Variable};
use crate::{LOG_CATEGORIES, MODEL_IDENTIFIER, annotation, structure};
use beam_physics::unit::{self, Unit};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use std::io;

/// Stands for the GUID while the text is hashed.
const PLACEHOLDER: &str = "{00000000-0000-0000-0000-000000000000}";

/// The description for given start values (in the order of the layout), and its GUID.
pub fn generate(layout: &Layout, starts: &[Option<f64>]) -> (String, String) {
    let about = "Elastic beam rubbed by a moving belt: stick and slip (Stelter 1992)";
    let indicators = beam_physics::hybrid::EVENT_FUNCTIONS;
    document(MODEL_IDENTIFIER, about, indicators, |w| {
        content(w, layout, starts)
    })
}

/// A description with what `content` writes into its root, and its GUID, which is made from the text.
pub(crate) fn document(
    name: &str,
    about: &str,
    event_indicators: usize,
    content: impl FnOnce(&mut Writer<Vec<u8>>) -> io::Result<()>,
) -> (String, String) {
    let text =
        write(name, about, event_indicators, content).expect("writing to memory cannot fail");
    let guid = guid_of(&text);
    (text.replacen(PLACEHOLDER, &guid, 1), guid)
}

/// A GUID made from a text: FNV-1a with 128 bits, written as a UUID.
pub fn guid_of(text: &str) -> String {
    let mut hash: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    for byte in text.bytes() {
        hash = (hash ^ u128::from(byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
    }
    let hex = format!("{hash:032x}");
    format!(
        "{{{}-{}-{}-{}-{}}}",
        &hex[..8],
        &hex[8..12],
        &hex[12..16],
        &hex[16..20],
        &hex[20..]
    )
}

fn write(
    name: &str,
    about: &str,
    event_indicators: usize,
    content: impl FnOnce(&mut Writer<Vec<u8>>) -> io::Result<()>,
) -> io::Result<String> {
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    writer
        .create_element("fmiModelDescription")
        .with_attributes([
            ("fmiVersion", "2.0"),
            ("modelName", name),
            ("guid", PLACEHOLDER),
            ("description", about),
            ("version", env!("CARGO_PKG_VERSION")),
            ("license", env!("CARGO_PKG_LICENSE")),
            (
                "generationTool",
                concat!("beam-model-description ", env!("CARGO_PKG_VERSION")),
            ),
            ("variableNamingConvention", "structured"),
            (
                "numberOfEventIndicators",
                event_indicators.to_string().as_str(),
            ),
        ])
        .write_inner_content(content)?;
    let mut text = String::from_utf8(writer.into_inner()).expect("the writer writes UTF-8");
    text.push('\n');
    Ok(text)
}

fn content(w: &mut Writer<Vec<u8>>, layout: &Layout, starts: &[Option<f64>]) -> io::Result<()> {
    interfaces(w)?;
    let used = used_units(layout);
    units(w, &used)?;
    types(w, &used)?;
    log_categories(w)?;
    w.create_element("DefaultExperiment")
        .with_attributes([
            ("startTime", "0.0"),
            ("stopTime", "2.0"),
            (
                "tolerance",
                format!("{:?}", beam_physics::simulate::DEFAULT_TOLERANCE).as_str(),
            ),
            ("stepSize", "1e-4"),
        ])
        .write_empty()?;
    w.create_element("VendorAnnotations")
        .write_inner_content(|w| annotation::write(w, layout))?;
    w.create_element("ModelVariables")
        .write_inner_content(|w| {
            let variables = layout.variables().iter();
            for (i, (variable, start)) in variables.zip(starts).enumerate() {
                w.write_event(Event::Comment(BytesText::new(&format!(" {} ", i + 1))))?;
                scalar_variable(w, layout, variable, *start)?;
            }
            Ok(())
        })?;
    structure::write(w, layout)
}

/// What both interfaces of a model offer.
fn common(identifier: &str, directional: bool) -> [(&str, &str); 7] {
    [
        ("modelIdentifier", identifier),
        ("needsExecutionTool", "false"),
        ("canBeInstantiatedOnlyOncePerProcess", "false"),
        ("canNotUseMemoryManagementFunctions", "true"),
        ("canGetAndSetFMUstate", "true"),
        ("canSerializeFMUstate", "true"),
        (
            "providesDirectionalDerivative",
            if directional { "true" } else { "false" },
        ),
    ]
}

/// The element of co-simulation.
pub(crate) fn co_simulation(
    w: &mut Writer<Vec<u8>>,
    identifier: &str,
    directional: bool,
) -> io::Result<()> {
    w.create_element("CoSimulation")
        .with_attributes(common(identifier, directional))
        .with_attributes([
            ("canHandleVariableCommunicationStepSize", "true"),
            ("canInterpolateInputs", "true"),
            ("maxOutputDerivativeOrder", "1"),
            ("canRunAsynchronuously", "false"),
        ])
        .write_empty()?;
    Ok(())
}

fn interfaces(w: &mut Writer<Vec<u8>>) -> io::Result<()> {
    w.create_element("ModelExchange")
        .with_attributes(common(MODEL_IDENTIFIER, true))
        .with_attribute(("completedIntegratorStepNotNeeded", "true"))
        .write_empty()?;
    co_simulation(w, MODEL_IDENTIFIER, true)
}

/// Units in use: first those of the physics' list in its order, then those that users' effects bring.
fn used_units(layout: &Layout) -> Vec<Unit> {
    let in_use = |v: &Variable| match v.kind {
        Kind::Real(unit) => Some(unit),
        _ => None,
    };
    let used: Vec<Unit> = layout.variables().iter().filter_map(in_use).collect();
    let has = |list: &[Unit], unit: &Unit| list.iter().any(|u| u.symbol == unit.symbol);
    let known = unit::ALL.iter().copied().filter(|u| has(&used, u));
    let mut units: Vec<Unit> = known.collect();
    for unit in used {
        if !has(&units, &unit) {
            units.push(unit);
        }
    }
    units
}

/// Writes the definitions of units.
pub(crate) fn units(w: &mut Writer<Vec<u8>>, used: &[Unit]) -> io::Result<()> {
    w.create_element("UnitDefinitions")
        .write_inner_content(|w| {
            for unit in used {
                if !unit::ALL.contains(unit) {
                    // A user's own: what it is made of is not known.
                    w.create_element("Unit")
                        .with_attribute(("name", unit.symbol))
                        .write_empty()?;
                    continue;
                }
                w.create_element("Unit")
                    .with_attribute(("name", unit.symbol))
                    .write_inner_content(|w| {
                        let exponents = [
                            ("kg", unit.kg),
                            ("m", unit.m),
                            ("s", unit.s),
                            ("rad", unit.rad),
                        ];
                        let texts: Vec<_> = exponents
                            .iter()
                            .filter(|(_, exponent)| *exponent != 0)
                            .map(|(base, exponent)| (*base, exponent.to_string()))
                            .collect();
                        w.create_element("BaseUnit")
                            .with_attributes(texts.iter().map(|(k, v)| (*k, v.as_str())))
                            .write_empty()?;
                        for (name, factor) in display_units(unit.symbol) {
                            w.create_element("DisplayUnit")
                                .with_attributes([("name", *name), ("factor", &number(*factor))])
                                .write_empty()?;
                        }
                        Ok(())
                    })?;
            }
            Ok(())
        })?;
    Ok(())
}

/// Writes the declared types of Real variables.
pub(crate) fn real_types(w: &mut Writer<Vec<u8>>, used: &[Unit]) -> io::Result<()> {
    for unit in used {
        if let Some((name, description)) = of_unit(*unit) {
            w.create_element("SimpleType")
                .with_attributes([("name", name), ("description", description)])
                .write_inner_content(|w| {
                    let mut attributes = vec![("quantity", name), ("unit", unit.symbol)];
                    attributes.extend(shown_in(unit.symbol).map(|u| ("displayUnit", u)));
                    w.create_element("Real")
                        .with_attributes(attributes)
                        .write_empty()?;
                    Ok(())
                })?;
        }
    }
    Ok(())
}

fn types(w: &mut Writer<Vec<u8>>, used: &[Unit]) -> io::Result<()> {
    w.create_element("TypeDefinitions")
        .write_inner_content(|w| {
            real_types(w, used)?;
            for (name, description, items) in ENUMERATIONS {
                w.create_element("SimpleType")
                    .with_attributes([("name", name), ("description", description)])
                    .write_inner_content(|w| {
                        w.create_element("Enumeration").write_inner_content(|w| {
                            for (item, value, meaning) in items {
                                w.create_element("Item")
                                    .with_attributes([
                                        ("name", *item),
                                        ("value", &value.to_string()),
                                        ("description", meaning),
                                    ])
                                    .write_empty()?;
                            }
                            Ok(())
                        })?;
                        Ok(())
                    })?;
            }
            Ok(())
        })?;
    Ok(())
}

/// Writes the log categories.
pub(crate) fn log_categories(w: &mut Writer<Vec<u8>>) -> io::Result<()> {
    w.create_element("LogCategories").write_inner_content(|w| {
        let all = [("logAll", "All messages")];
        for (name, description) in LOG_CATEGORIES.into_iter().chain(all) {
            w.create_element("Category")
                .with_attributes([("name", name), ("description", description)])
                .write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}

/// Shortest text that reads back as the same number.
pub(crate) fn number(value: f64) -> String {
    format!("{value:?}")
}

fn scalar_variable(
    w: &mut Writer<Vec<u8>>,
    layout: &Layout,
    variable: &Variable,
    start: Option<f64>,
) -> io::Result<()> {
    let causality = match variable.causality {
        Causality::Parameter => "parameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    };
    let variability = match variable.variability {
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    };
    let reference = variable.reference.to_string();
    let mut attributes = vec![
        ("name", variable.name.as_str()),
        ("valueReference", &reference),
        ("description", &variable.description),
        ("causality", causality),
        ("variability", variability),
    ];
    match variable.initial {
        Some(Initial::Exact) => attributes.push(("initial", "exact")),
        Some(Initial::Calculated) => attributes.push(("initial", "calculated")),
        None => {}
    }
    w.create_element("ScalarVariable")
        .with_attributes(attributes)
        .write_inner_content(|w| typed(w, layout, variable, start))?;
    Ok(())
}

type Attributes = Vec<(&'static str, String)>;
/// How a number is written in an attribute.
type Text = fn(f64) -> String;

fn typed(
    w: &mut Writer<Vec<u8>>,
    layout: &Layout,
    variable: &Variable,
    start: Option<f64>,
) -> io::Result<()> {
    let (element, mut attributes, text): (_, Attributes, Text) = match variable.kind {
        Kind::Real(unit) => {
            let declared = of_unit(unit).map(|(name, _)| ("declaredType", name.to_owned()));
            let mut attributes: Vec<_> = declared.into_iter().collect();
            attributes.push(("unit", unit.symbol.to_owned()));
            if let Quantity::Rate(state) = variable.quantity {
                // Indices count from 1 (FMI 2.0.5, section 2.2.8).
                let index = layout.index_of_reference(state).map_or(0, |i| i + 1);
                attributes.push(("derivative", index.to_string()));
            }
            if jumps(variable.quantity) {
                attributes.push(("reinit", "true".to_owned()));
            }
            ("Real", attributes, number)
        }
        Kind::Integer => ("Integer", Vec::new(), |v| format!("{v:.0}")),
        Kind::Enumeration(name) => (
            "Enumeration",
            vec![("declaredType", name.to_owned())],
            |v| format!("{v:.0}"),
        ),
    };
    let values = [
        ("min", variable.min),
        ("max", variable.max),
        ("nominal", variable.nominal),
        ("start", start),
    ];
    for (name, value) in values {
        if let Some(value) = value {
            attributes.push((name, text(value)));
        }
    }
    w.create_element(element)
        .with_attributes(attributes.iter().map(|(k, v)| (*k, v.as_str())))
        .write_empty()?;
    Ok(())
}

/// Whether the state may jump at an event: velocities at arrival and break-away, states of effects.
fn jumps(quantity: Quantity) -> bool {
    matches!(
        quantity,
        Quantity::Mode(_, ModeItem::Velocity) | Quantity::EffectState(..)
    )
}
