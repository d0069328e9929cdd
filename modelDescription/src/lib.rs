//! The FMU's variables and its modelDescription.xml (FMI 2.0), generated from one table.
//!
//! The table ([`variables`]) is built from the metadata of the physics and the cards of its effects; a
//! [`Layout`] adds the parameters of users' effects. The XML, the GUID (a hash of the XML) and the lookup
//! by value reference all follow from it.
#![forbid(unsafe_code)]

mod annotation;
pub mod belt_drive;
mod declared_type;
mod layout;
mod start_values;
mod structure;
mod table;
mod user_effect;
mod variable;
mod xml;

use std::sync::LazyLock;

pub use layout::{FIRST_USER_REFERENCE, Layout, MAX_USER_EFFECTS};
pub use start_values::{EFFECTS_FOLDER, START_VALUES_FILE, StartValueError};
pub use table::variables;
pub use user_effect::{UserCard, UserEffectError, UserEffectParameter};
pub use variable::{Causality, Initial, Kind, ModeItem, Quantity, Variability, Variable};
pub use xml::guid_of;

/// Name of the model and of its binary.
pub const MODEL_IDENTIFIER: &str = "StickSlipBeam";
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
    xml::generate(Layout::plain(), &starts)
});

/// The text of modelDescription.xml with the built-in start values.
pub fn xml() -> &'static str {
    &BUILT_IN.0
}

/// The GUID of the built-in description.
pub fn guid() -> &'static str {
    &BUILT_IN.1
}
