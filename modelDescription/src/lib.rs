//! The FMU's variables and its modelDescription.xml (FMI 2.0), generated from one table.
//!
//! The table ([`variables`]) is built from the metadata of the physics and the cards of its effects.
//! The XML, the GUID (a hash of the XML) and the lookup by value reference all follow from it.
#![forbid(unsafe_code)]

mod annotation;
mod declared_type;
mod layout;
mod start_values;
mod table;
mod variable;
mod xml;

use std::sync::LazyLock;

pub use layout::{index_of_name, index_of_reference};
pub use start_values::{
    START_VALUES_FILE, StartValueError, check_start, start_values_toml, xml_with_starts,
};
pub use table::variables;
pub use variable::{Causality, Initial, Kind, ModeItem, Quantity, Variability, Variable};

/// Name of the model and of its binary.
pub const MODEL_IDENTIFIER: &str = "StickSlipBeam";
/// First value reference that is free for variables added by users' own effects.
pub const FIRST_USER_REFERENCE: u32 = 9000;
/// Log categories of the standard (FMI 2.0.5, section 2.2.4) that the FMU uses.
pub const LOG_CATEGORIES: [(&str, &str); 5] = [
    ("logEvents", "Initialisation, resets and restored states"),
    (
        "logStatusWarning",
        "Calls that were carried out with a remark",
    ),
    (
        "logStatusDiscard",
        "Steps that were not carried out in full",
    ),
    ("logStatusError", "Calls that were refused"),
    (
        "logStatusFatal",
        "Failures after which the instance is unusable",
    ),
];

/// The description with the built-in start values, and its GUID.
static BUILT_IN: LazyLock<(String, String)> = LazyLock::new(|| {
    let starts: Vec<Option<f64>> = variables().iter().map(|v| v.start).collect();
    xml::generate(&starts)
});

/// The text of modelDescription.xml with the built-in start values.
pub fn xml() -> &'static str {
    &BUILT_IN.0
}

/// The GUID of the built-in description.
pub fn guid() -> &'static str {
    &BUILT_IN.1
}
