//! modelDescription.xml and the binary: they must be the same thing said twice.

use beam_model_description::Layout;
use std::collections::{HashMap, HashSet};
use std::process::Command;
use stickslip_tests::variables::XML;
use stickslip_tests::{fmu_library, root};

/// The functions of FMI 2.0 (fmi2Functions.h).
const FUNCTIONS: [&str; 44] = [
    "fmi2CancelStep",
    "fmi2CompletedIntegratorStep",
    "fmi2DeSerializeFMUstate",
    "fmi2DoStep",
    "fmi2EnterContinuousTimeMode",
    "fmi2EnterEventMode",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2FreeFMUstate",
    "fmi2FreeInstance",
    "fmi2GetBoolean",
    "fmi2GetBooleanStatus",
    "fmi2GetContinuousStates",
    "fmi2GetDerivatives",
    "fmi2GetDirectionalDerivative",
    "fmi2GetEventIndicators",
    "fmi2GetFMUstate",
    "fmi2GetInteger",
    "fmi2GetIntegerStatus",
    "fmi2GetNominalsOfContinuousStates",
    "fmi2GetReal",
    "fmi2GetRealOutputDerivatives",
    "fmi2GetRealStatus",
    "fmi2GetStatus",
    "fmi2GetString",
    "fmi2GetStringStatus",
    "fmi2GetTypesPlatform",
    "fmi2GetVersion",
    "fmi2Instantiate",
    "fmi2NewDiscreteStates",
    "fmi2Reset",
    "fmi2SerializeFMUstate",
    "fmi2SerializedFMUstateSize",
    "fmi2SetBoolean",
    "fmi2SetContinuousStates",
    "fmi2SetDebugLogging",
    "fmi2SetFMUstate",
    "fmi2SetInteger",
    "fmi2SetReal",
    "fmi2SetRealInputDerivatives",
    "fmi2SetString",
    "fmi2SetTime",
    "fmi2SetupExperiment",
    "fmi2Terminate",
];

#[test]
fn the_committed_description_is_the_generated_one() {
    assert!(
        *XML == beam_model_description::xml(),
        "modelDescription.xml is out of date: \
         cargo run -p beam-model-description --example write_description"
    );
}

#[test]
fn the_binary_exports_the_functions_of_the_standard_and_a_few_of_its_own() {
    // nm comes with every C compiler.
    let out = Command::new("nm")
        .args(["-D", "--defined-only"])
        .arg(fmu_library())
        .output()
        .expect("nm is there");
    let text = String::from_utf8_lossy(&out.stdout);
    let mut names: Vec<_> = text
        .lines()
        .filter_map(|line| line.split_whitespace().last())
        .collect();
    names.sort_unstable();
    // Functions of our own, which masters never look for: docs/adr/0010-sweep.md, 0012-tangents.md.
    names.retain(|name| {
        ![
            "stickslipDrivenTangents",
            "stickslipEvaluate",
            "stickslipOutputTangents",
            "stickslipTangents",
        ]
        .contains(name)
    });
    assert_eq!(names, FUNCTIONS);
}

#[test]
fn the_binary_stays_loaded_after_dlclose() {
    let out = Command::new("readelf")
        .arg("-d")
        .arg(fmu_library())
        .output()
        .expect("readelf is there");
    let text = String::from_utf8_lossy(&out.stdout);
    assert!(text.contains("NODELETE"), "{text}");
    let needed: Vec<_> = text.lines().filter(|l| l.contains("(NEEDED)")).collect();
    for line in needed {
        let known = ["libc.so", "libm.so", "libgcc_s.so", "ld-linux"];
        assert!(known.iter().any(|name| line.contains(name)), "{line}");
    }
}

#[test]
fn names_and_value_references_are_unique_and_blocks_are_kept() {
    let document = roxmltree::Document::parse(&XML).unwrap();
    let (mut names, mut references) = (HashSet::new(), HashSet::new());
    let mut blocks: HashMap<u32, String> = HashMap::new();
    for node in document
        .descendants()
        .filter(|n| n.has_tag_name("ScalarVariable"))
    {
        let name = node.attribute("name").unwrap();
        let reference: u32 = node.attribute("valueReference").unwrap().parse().unwrap();
        assert!(names.insert(name), "{name} twice");
        assert!(references.insert(reference), "{reference} twice ({name})");
        assert!(
            reference < 9000,
            "{name}: the rest is for users' own effects"
        );
        if reference >= 1000 {
            let effect = name.trim_start_matches("der(").split('.').next().unwrap();
            let owner = blocks
                .entry(reference / 100)
                .or_insert_with(|| effect.to_owned());
            assert_eq!(owner, effect, "{name} lies in the block of {owner}");
        }
    }
}

#[test]
fn every_unit_and_declared_type_is_defined_and_used() {
    let document = roxmltree::Document::parse(&XML).unwrap();
    let all = |tag: &str, attribute: &str| -> HashSet<String> {
        document
            .descendants()
            .filter(|n| n.has_tag_name(tag))
            .filter_map(|n| n.attribute(attribute).map(str::to_owned))
            .collect()
    };
    assert_eq!(all("Unit", "name"), all("Real", "unit"));
    let declared: HashSet<_> = all("Real", "declaredType")
        .union(&all("Enumeration", "declaredType"))
        .cloned()
        .collect();
    assert_eq!(all("SimpleType", "name"), declared);
    for node in document.descendants().filter(|n| n.has_tag_name("Real")) {
        if node
            .parent_element()
            .unwrap()
            .has_tag_name("ScalarVariable")
        {
            assert!(node.has_attribute("declaredType"), "{node:?}");
        }
    }
}

#[test]
fn readers_that_stumble_over_rare_things_find_none() {
    assert!(!XML.contains("xmlns"));
    assert!(!XML.contains("<Annotations"));
    assert!(!XML.contains("NaN") && !XML.contains("inf\""));
}

#[test]
fn the_effects_travel_in_the_vendor_annotation() {
    let document = roxmltree::Document::parse(&XML).unwrap();
    let tool = document
        .descendants()
        .find(|n| n.has_tag_name("Tool"))
        .unwrap();
    assert_eq!(tool.attribute("name"), Some("StickSlip"));
    let variables: HashSet<_> = document
        .descendants()
        .filter(|n| n.has_tag_name("ScalarVariable"))
        .filter_map(|n| n.attribute("name"))
        .collect();
    let effects: Vec<_> = tool
        .descendants()
        .filter(|n| n.has_tag_name("Effect"))
        .collect();
    assert!(effects.len() >= 16, "{}", effects.len());
    for effect in effects {
        let id = effect.attribute("id").unwrap();
        for key in ["title", "equation", "description", "source", "signature"] {
            assert!(
                effect.attribute(key).is_some_and(|t| !t.is_empty()),
                "{id}: {key}"
            );
        }
        for node in effect.children().filter(roxmltree::Node::is_element) {
            let name = node.attribute("name").unwrap();
            let full = match node.tag_name().name() {
                "Parameter" => format!("{id}.{name}"),
                "State" => format!("{id}.state.{name}"),
                other => panic!("{other}"),
            };
            assert!(variables.contains(full.as_str()), "{full} is no variable");
        }
    }
}

#[test]
fn other_start_values_give_the_same_text_but_for_starts_and_guid() {
    let starts = [
        ("friction.mu_0", 0.61),
        ("mode_count", 3.0),
        ("third_mode.frequency", 1400.0),
    ];
    let (xml, guid) = Layout::plain().xml_with_starts(&starts).unwrap();
    assert!(!XML.contains(&guid) && xml.contains(&guid));
    let changed: Vec<_> = XML
        .lines()
        .zip(xml.lines())
        .filter(|(a, b)| a != b)
        .collect();
    assert_eq!(changed.len(), 4, "{changed:#?}");
    assert_eq!(XML.lines().count(), xml.lines().count());
    assert!(changed[1].1.contains("start=\"3\""));
    assert!(changed[2].1.contains("start=\"0.61\""));
    let none: [(&str, f64); 0] = [];
    let (same, _) = Layout::plain().xml_with_starts(&none).unwrap();
    assert_eq!(same, *XML);
    for (name, value, part) in [
        ("nonsense", 1.0, "no such variable"),
        ("tip_velocity", 1.0, "is a result"),
        ("friction.mu_0", f64::NAN, "finite"),
        ("normal_force", -1.0, "at least"),
        ("mode_count", 2.5, "whole number"),
    ] {
        let error = Layout::plain()
            .xml_with_starts(&[(name, value)])
            .unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    }
    let toml = Layout::plain().start_values_toml(&starts, &guid).unwrap();
    assert!(toml.contains("\"mode_count\" = 3.0") && toml.contains(&guid));
    assert!(
        root()
            .join("modelDescription/modelDescription.xml")
            .exists()
    );
}
