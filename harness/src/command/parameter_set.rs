//! System Structure Parameter Values 1.0 (SSP standard, section 6): values of an FMU's variables for system tools.

use quick_xml::escape::escape;

use crate::fmu::{Kind, ModelDescription};

/// The parameter set `name` with these values.
pub fn ssv(description: &ModelDescription, name: &str, values: &[(String, f64)]) -> String {
    let name = escape(name);
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<ssv:ParameterSet version=\"1.0\" name=\"{name}\" xmlns:ssv=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\">\n  <ssv:Parameters>\n"
    );
    for (name, value) in values {
        let variable = description.find(name);
        let whole = variable.is_some_and(|v| matches!(v.kind, Kind::Integer | Kind::Enumeration));
        let element = if whole {
            format!("<ssv:Integer value=\"{value:.0}\"/>")
        } else {
            let unit = variable
                .and_then(|v| v.unit.clone())
                .map_or(String::new(), |u| format!(" unit=\"{u}\""));
            format!("<ssv:Real value=\"{value:?}\"{unit}/>")
        };
        out += &format!("    <ssv:Parameter name=\"{name}\">{element}</ssv:Parameter>\n");
    }
    out + "  </ssv:Parameters>\n</ssv:ParameterSet>\n"
}

/// Name and numbers of a parameter set.
///
/// # Errors
/// What is not well-formed, not a parameter set, or holds other than numbers, in words.
pub fn read_ssv(text: &str) -> Result<(String, Vec<(String, f64)>), String> {
    let document = roxmltree::Document::parse(text).map_err(|e| e.to_string())?;
    let root = document.root_element();
    if root.tag_name().name() != "ParameterSet" {
        return Err("it is not an SSP parameter set".to_owned());
    }
    let parameters = root
        .descendants()
        .filter(|n| n.tag_name().name() == "Parameter")
        .map(|parameter| {
            let name = parameter.attribute("name").unwrap_or_default().to_owned();
            let value = parameter
                .children()
                .find_map(|v| v.attribute("value")?.parse().ok());
            let value = value.ok_or_else(|| format!("parameter '{name}' has no number"))?;
            Ok((name, value))
        })
        .collect::<Result<_, String>>()?;
    let name = root.attribute("name").unwrap_or_default();
    Ok((name.to_owned(), parameters))
}

/// The start values of all parameters of an FMU.
pub fn defaults(description: &ModelDescription) -> Vec<(String, f64)> {
    use crate::fmu::Causality;
    description
        .variables
        .iter()
        .filter(|v| v.causality == Causality::Parameter)
        .filter_map(|v| Some((v.name.clone(), v.start_number()?)))
        .collect()
}
