//! System Structure Parameter Values 1.0 (SSP standard, section 6): values of an FMU's variables for system tools.

use crate::fmu::{Kind, ModelDescription};

/// The parameter set `name` with these values.
pub fn ssv(description: &ModelDescription, name: &str, values: &[(String, f64)]) -> String {
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
