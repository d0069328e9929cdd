//! The harness's view of a modelDescription.xml (FMI 2.0): plain data, the same whichever backend runs the binary.

use std::collections::HashMap;

use super::parse_description::{Problem, parse};
use crate::wording::nearest;

/// What an FMU says about itself.
#[derive(Debug, Clone)]
pub struct ModelDescription {
    /// Name of the model, for people.
    pub model_name: String,
    /// Name of the co-simulation library, without suffix.
    pub model_identifier: String,
    /// The identity shared by XML and binary.
    pub guid: String,
    /// One line about the model.
    pub description: String,
    /// The tool that wrote the FMU.
    pub generation_tool: String,
    /// Suggested start, stop, tolerance and step.
    pub default_experiment: DefaultExperiment,
    /// What the co-simulation can do.
    pub capabilities: Capabilities,
    /// All variables, in the order of the file.
    pub variables: Vec<Variable>,
    /// Enumerations by name.
    pub enumerations: HashMap<String, Vec<EnumItem>>,
    /// Every `<Tool>` under the model's `<VendorAnnotations>`.
    pub vendor_annotations: Vec<VendorAnnotation>,
    pub(super) index: HashMap<String, usize>,
}

/// `<DefaultExperiment>`; all optional. Times in s.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[allow(missing_docs)]
pub struct DefaultExperiment {
    pub start: Option<f64>,
    pub stop: Option<f64>,
    pub tolerance: Option<f64>,
    pub step: Option<f64>,
}

/// Capability flags of `<CoSimulation>`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Capabilities {
    pub can_get_and_set_state: bool,
    pub can_serialize_state: bool,
    pub can_handle_variable_step: bool,
    pub can_interpolate_inputs: bool,
    pub only_one_instance_per_process: bool,
    pub can_not_use_memory_management_functions: bool,
}

/// FMI 2.0 data types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Kind {
    Real,
    Integer,
    Boolean,
    String,
    Enumeration,
}

/// FMI 2.0 causalities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Causality {
    Parameter,
    CalculatedParameter,
    Input,
    Output,
    Local,
    Independent,
}

/// One `<ScalarVariable>`.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Unique name.
    pub name: String,
    /// The handle for get and set calls; unique within the kind only.
    pub reference: u32,
    /// Its type.
    pub kind: Kind,
    /// Its role.
    pub causality: Causality,
    /// `constant`, `fixed`, `tunable`, `discrete` or `continuous`.
    pub variability: String,
    /// `exact`, `approx` or `calculated`, where given.
    pub initial: Option<String>,
    /// Start value as written.
    pub start: Option<String>,
    /// Unit name, its own or its declared type's.
    pub unit: Option<String>,
    /// Name of the declared type.
    pub declared_type: Option<String>,
    /// Lower bound.
    pub min: Option<f64>,
    /// Upper bound.
    pub max: Option<f64>,
    /// Typical size.
    pub nominal: Option<f64>,
    /// One sentence.
    pub description: String,
}

impl Variable {
    /// The start value as a number (`true` is 1), if it is one.
    pub fn start_number(&self) -> Option<f64> {
        match self.start.as_deref()? {
            "true" => Some(1.0),
            "false" => Some(0.0),
            text => text.trim().parse().ok(),
        }
    }

    /// Whether a caller may set its start value before initialisation (FMI 2.0.5, section 4.2.4).
    pub fn is_settable(&self) -> bool {
        self.variability != "constant"
            && (self.causality == Causality::Input
                || matches!(self.initial.as_deref(), Some("exact" | "approx")))
    }
}

/// One item of an enumeration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EnumItem {
    /// Its name.
    pub name: String,
    /// Its integer.
    pub value: i32,
    /// One sentence.
    pub description: String,
}

/// What some tool wrote into the model-level `<VendorAnnotations>`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VendorAnnotation {
    /// The tool's name.
    pub tool: String,
    /// The whole `<Tool>` element, as written.
    pub xml: String,
}

impl ModelDescription {
    /// Reads the text of a modelDescription.xml; the error says what is wrong with it.
    pub fn parse(xml: &str) -> Result<ModelDescription, String> {
        parse(xml).map_err(|problem| match problem {
            Problem::Broken(what) => what,
            Problem::NotCoSimulation => "offers no co-simulation".into(),
        })
    }

    /// The variable of this name, if there is one.
    pub fn find(&self, name: &str) -> Option<&Variable> {
        self.index.get(name).map(|&i| &self.variables[i])
    }

    /// Names most like `name`, for messages.
    pub fn nearest(&self, name: &str) -> Vec<String> {
        nearest(name, self.variables.iter().map(|v| v.name.as_str()))
    }

    /// The name of an enumeration variable's value; `None` for other variables or values without a name.
    pub fn enum_name(&self, variable: &Variable, value: i32) -> Option<&str> {
        let items = self.enumerations.get(variable.declared_type.as_deref()?)?;
        items
            .iter()
            .find(|item| item.value == value)
            .map(|item| item.name.as_str())
    }

    /// The raw XML of a tool's annotation.
    pub fn vendor_annotation(&self, tool: &str) -> Option<&str> {
        self.vendor_annotations
            .iter()
            .find(|a| a.tool == tool)
            .map(|a| a.xml.as_str())
    }
}
