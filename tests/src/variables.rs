//! Value references by name, read from the committed modelDescription.xml.

use crate::root;
use std::collections::HashMap;
use std::sync::LazyLock;

/// The committed description.
pub static XML: LazyLock<String> = LazyLock::new(|| {
    let file = root().join("modelDescription/modelDescription.xml");
    std::fs::read_to_string(file).expect("modelDescription.xml is committed")
});

static REFERENCES: LazyLock<HashMap<String, u32>> = LazyLock::new(|| {
    let document = roxmltree::Document::parse(&XML).expect("well-formed");
    document
        .descendants()
        .filter(|node| node.has_tag_name("ScalarVariable"))
        .map(|node| {
            let reference = node.attribute("valueReference").expect("required");
            (
                node.attribute("name").expect("required").to_owned(),
                reference.parse().expect("a number"),
            )
        })
        .collect()
});

static GUID: LazyLock<String> = LazyLock::new(|| {
    let document = roxmltree::Document::parse(&XML).expect("well-formed");
    let guid = document.root_element().attribute("guid");
    guid.expect("required").to_owned()
});

/// Value reference of a variable.
pub fn reference(name: &str) -> u32 {
    *REFERENCES
        .get(name)
        .unwrap_or_else(|| panic!("no variable '{name}'"))
}

/// The GUID of the committed description.
pub fn guid() -> &'static str {
    &GUID
}
