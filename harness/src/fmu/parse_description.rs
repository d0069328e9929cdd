//! modelDescription.xml -> [`ModelDescription`].
//!
//! Lenient on purpose: unknown attributes, namespaces and annotations are legal FMI 2.0 and occur in real FMUs.

use std::collections::HashMap;
use std::str::FromStr;

use roxmltree::{Document, Node, ParsingOptions};

use super::description::*;

/// Why a description could not be used.
pub(crate) enum Problem {
    /// Malformed or incomplete.
    Broken(String),
    /// Well formed, but without `<CoSimulation>`.
    NotCoSimulation,
}

/// Parses the XML text.
pub(crate) fn parse(xml: &str) -> Result<ModelDescription, Problem> {
    let options = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(xml, options)
        .map_err(|e| Problem::Broken(format!("not well-formed XML: {e}")))?;
    let root = document.root_element();
    if root.tag_name().name() != "fmiModelDescription" {
        return Err(Problem::Broken(format!(
            "its root is <{}>, not <fmiModelDescription>",
            root.tag_name().name()
        )));
    }
    match root.attribute("fmiVersion") {
        Some("2.0") => {}
        Some(other) => {
            return Err(Problem::Broken(format!(
                "fmiVersion is \"{other}\", this tool runs FMI 2.0; export it as FMI 2.0"
            )));
        }
        None => return Err(Problem::Broken("fmiVersion is missing".into())),
    }
    let co_simulation = child(root, "CoSimulation").ok_or(Problem::NotCoSimulation)?;
    let types = child(root, "TypeDefinitions")
        .map(simple_types)
        .unwrap_or_default();
    let variables = match child(root, "ModelVariables") {
        Some(node) => elements(node, "ScalarVariable")
            .map(|v| variable(v, &types))
            .collect::<Result<Vec<_>, _>>()?,
        None => return Err(Problem::Broken("<ModelVariables> is missing".into())),
    };
    let experiment = child(root, "DefaultExperiment");
    let number = |name| {
        experiment
            .and_then(|node| node.attribute(name))
            .and_then(|text| text.parse().ok())
    };
    Ok(ModelDescription {
        model_name: required(root, "modelName")?.to_owned(),
        model_identifier: required(co_simulation, "modelIdentifier")?.to_owned(),
        guid: required(root, "guid")?.to_owned(),
        description: text(root, "description"),
        generation_tool: text(root, "generationTool"),
        default_experiment: DefaultExperiment {
            start: number("startTime"),
            stop: number("stopTime"),
            tolerance: number("tolerance"),
            step: number("stepSize"),
        },
        capabilities: Capabilities {
            can_get_and_set_state: flag(co_simulation, "canGetAndSetFMUstate"),
            can_serialize_state: flag(co_simulation, "canSerializeFMUstate"),
            can_handle_variable_step: flag(co_simulation, "canHandleVariableCommunicationStepSize"),
            can_interpolate_inputs: flag(co_simulation, "canInterpolateInputs"),
            only_one_instance_per_process: flag(
                co_simulation,
                "canBeInstantiatedOnlyOncePerProcess",
            ),
            can_not_use_memory_management_functions: flag(
                co_simulation,
                "canNotUseMemoryManagementFunctions",
            ),
        },
        index: variables
            .iter()
            .enumerate()
            .map(|(i, v)| (v.name.clone(), i))
            .collect(),
        variables,
        enumerations: types
            .into_iter()
            .filter_map(|(name, t)| Some((name.to_owned(), t.items?)))
            .collect(),
        vendor_annotations: child(root, "VendorAnnotations")
            .into_iter()
            .flat_map(|node| elements(node, "Tool"))
            .map(|tool| VendorAnnotation {
                tool: text(tool, "name"),
                xml: xml[tool.range()].to_owned(),
            })
            .collect(),
    })
}

/// The parts of a `<SimpleType>` that a variable can inherit.
struct SimpleType<'a> {
    body: Node<'a, 'a>,
    items: Option<Vec<EnumItem>>,
}

fn simple_types<'a>(node: Node<'a, 'a>) -> HashMap<&'a str, SimpleType<'a>> {
    elements(node, "SimpleType")
        .filter_map(|simple| {
            let body = simple.first_element_child()?;
            let items = (body.tag_name().name() == "Enumeration").then(|| {
                elements(body, "Item")
                    .filter_map(|item| {
                        Some(EnumItem {
                            name: text(item, "name"),
                            value: item.attribute("value")?.parse().ok()?,
                            description: text(item, "description"),
                        })
                    })
                    .collect()
            });
            Some((simple.attribute("name")?, SimpleType { body, items }))
        })
        .collect()
}

fn variable(node: Node, types: &HashMap<&str, SimpleType>) -> Result<Variable, Problem> {
    let name = required(node, "name")?;
    let broken = |what: &str| Problem::Broken(format!("variable '{name}': {what}"));
    let body = node
        .children()
        .find(|c| c.is_element() && kind(c.tag_name().name()).is_some())
        .ok_or_else(|| broken("has no <Real>, <Integer>, <Boolean>, <String> or <Enumeration>"))?;
    let declared_type = body.attribute("declaredType");
    let inherited = declared_type.and_then(|t| types.get(t)).map(|t| t.body);
    let attribute = |key| {
        body.attribute(key)
            .or_else(|| inherited.and_then(|t| t.attribute(key)))
    };
    let number = |key| attribute(key).and_then(|text| f64::from_str(text).ok());
    let reference = required(node, "valueReference")?
        .parse()
        .map_err(|_| broken("valueReference is not a non-negative integer"))?;
    let causality = match node.attribute("causality") {
        None | Some("local") => Causality::Local,
        Some("parameter") => Causality::Parameter,
        Some("calculatedParameter") => Causality::CalculatedParameter,
        Some("input") => Causality::Input,
        Some("output") => Causality::Output,
        Some("independent") => Causality::Independent,
        Some(other) => return Err(broken(&format!("unknown causality \"{other}\""))),
    };
    let variability = node.attribute("variability").unwrap_or("continuous");
    // The default of `initial` depends on the two others (FMI 2.0.5, table in section 2.2.7).
    let initial = node
        .attribute("initial")
        .or(match (causality, variability) {
            (Causality::Input | Causality::Independent, _) => None,
            (Causality::Parameter, _) | (_, "constant") => Some("exact"),
            _ => Some("calculated"),
        });
    Ok(Variable {
        name: name.to_owned(),
        reference,
        kind: kind(body.tag_name().name()).ok_or_else(|| broken("has no type"))?,
        causality,
        variability: variability.to_owned(),
        initial: initial.map(str::to_owned),
        start: body.attribute("start").map(str::to_owned),
        unit: attribute("unit").map(str::to_owned),
        declared_type: declared_type.map(str::to_owned),
        min: number("min"),
        max: number("max"),
        nominal: number("nominal"),
        description: text(node, "description"),
    })
}

fn kind(tag: &str) -> Option<Kind> {
    Some(match tag {
        "Real" => Kind::Real,
        "Integer" => Kind::Integer,
        "Boolean" => Kind::Boolean,
        "String" => Kind::String,
        "Enumeration" => Kind::Enumeration,
        _ => return None,
    })
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children()
        .find(|c| c.is_element() && c.tag_name().name() == tag)
}

fn elements<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children()
        .filter(move |c| c.is_element() && c.tag_name().name() == tag)
}

fn required<'a>(node: Node<'a, '_>, attribute: &str) -> Result<&'a str, Problem> {
    let missing = || {
        Problem::Broken(format!(
            "attribute {attribute} of <{}> is missing",
            node.tag_name().name()
        ))
    };
    node.attribute(attribute).ok_or_else(missing)
}

fn text(node: Node, attribute: &str) -> String {
    node.attribute(attribute).unwrap_or_default().to_owned()
}

fn flag(node: Node, attribute: &str) -> bool {
    matches!(node.attribute(attribute), Some("true" | "1"))
}
