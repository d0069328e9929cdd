//! An unknown function as a user's effect.

use super::latent_values::MOST;
use super::places::{Argument, MEASUREMENT, Place, TIP_FORCE};

/// How the identifiers of all of them begin.
const PREFIX: &str = "term_unknown_";
/// Name of the state that low-passes an argument.
const STATE: &str = "x";
/// Time constant in s with which a memory is looked for first: a few periods of a beam of 80 Hz.
const TYPICAL_MEMORY: f64 = 0.05;
/// Bounds of a constant of a formula in units of its value: what follows from a curve is good to a factor.
const FORMULA_RANGE: f64 = 10.0;

/// An unknown function of a campaign, as an effect.
#[derive(Debug, Clone)]
pub struct UnknownFunction {
    /// Identifier of the effect.
    pub id: String,
    /// Where it acts, as `diagnosis.json` names it.
    pub place: &'static str,
    /// The mode, from 1, where it acts on one alone.
    pub mode: Option<usize>,
    /// What it depends on, as `diagnosis.json` names it.
    pub argument: &'static str,
    /// Unit of the argument.
    pub argument_unit: &'static str,
    /// Whether the argument is low-passed with a time constant.
    pub remembers: bool,
    /// Places of the nodes.
    pub at: Vec<f64>,
    /// The effect's file.
    pub file: String,
    /// Target in an effect's file.
    target: &'static str,
    /// The formula of that target, with `G` for the curve.
    formula: String,
    /// What it depends on.
    of: Argument,
}

/// A constant of a formula in place of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct FormulaConstant {
    /// Name within the effect.
    pub name: String,
    /// Unit symbol.
    pub unit: String,
    /// Value as it follows from the curve.
    pub value: f64,
    /// Whether it is no strength but a place on the argument's axis, which is positive.
    pub is_shape: bool,
}

impl UnknownFunction {
    /// A curve through nodes at `at` of what it depends on; `mean_force` in N is that of the runs.
    pub(super) fn new(
        place: Place,
        argument: Argument,
        at: Vec<f64>,
        strength: f64,
        mean_force: f64,
    ) -> Self {
        Self {
            id: id(place, argument),
            place: place.name,
            mode: place.mode,
            argument: argument.name,
            argument_unit: argument.unit,
            remembers: argument.remembers,
            file: file(place, argument, &at, strength, mean_force),
            target: place.target,
            formula: formula(place, mean_force),
            of: argument,
            at,
        }
    }

    /// The file with another identifier and these values at the nodes as typical ones, and as typical time constant.
    pub fn file_with(&self, id: &str, values: &[f64], memory_s: Option<f64>) -> String {
        let list: Vec<String> = values.iter().map(|v| format!("{v:e}")).collect();
        let most = values.iter().fold(1e-12, |m: f64, v| m.max(v.abs()));
        let line = |line: &str| match (line.split(" = ").next(), memory_s) {
            (Some("id"), _) => format!("id = \"{id}\""),
            (Some("typical"), _) if line.ends_with("# strength") => {
                format!("typical = [{}]", list.join(", "))
            }
            (Some("min"), _) if line.ends_with("# strength") => format!("min = {:e}", -10.0 * most),
            (Some("max"), _) if line.ends_with("# strength") => format!("max = {:e}", 10.0 * most),
            (Some("typical"), Some(tau)) => format!("typical = {tau:e}"),
            _ => line.to_owned(),
        };
        self.file.lines().map(|l| line(l) + "\n").collect()
    }

    /// What a formula calls the argument of the curve.
    pub fn variable(&self) -> &'static str {
        if self.of.remembers {
            STATE
        } else {
            self.of.quantity
        }
    }

    /// Unit of the curve's values.
    pub fn value_unit(&self) -> &'static str {
        value_unit(self.place)
    }

    /// An effect with the formula `curve` of [`Self::variable`] in place of the table; `memory_s` is the time constant found, in s.
    pub fn formula_file(
        &self,
        id: &str,
        curve: &str,
        constants: &[FormulaConstant],
        memory_s: Option<f64>,
    ) -> String {
        let mut out = format!(
            "id = \"{id}\"\ntitle = \"Formula in {} acting on {}\"\nfamily = \"unknown\"\n\
             target = \"{}\"\n{}expression = \"{}\"\n",
            self.argument.replace('_', " "),
            self.place.replace('_', " "),
            self.target,
            mode_line(self.mode),
            self.formula.replace('G', &format!("({curve})")),
        );
        for c in constants {
            let (least, most) = match c.is_shape {
                true => (c.value / FORMULA_RANGE, c.value * FORMULA_RANGE),
                false => (
                    -FORMULA_RANGE * c.value.abs(),
                    FORMULA_RANGE * c.value.abs(),
                ),
            };
            out += &format!(
                "\n[[parameter]]\nname = \"{}\"\nunit = \"{}\"\nmin = {least:e}\nmax = {most:e}\ntypical = {:e}\n",
                c.name, c.unit, c.value
            );
            if c.is_shape {
                out += "role = \"shape\"\n";
            }
        }
        out + &memory(&self.of, &self.at, memory_s.unwrap_or(TYPICAL_MEMORY))
    }
}

/// Whether an effect is an unknown function.
pub fn is_unknown_function(id: &str) -> bool {
    id.starts_with(PREFIX)
}

/// Unit of what acts on a place, as `diagnosis.json` names it.
pub(crate) fn value_unit(place: &str) -> &'static str {
    match place {
        "tip_force" => "N",
        "measurement" => "m",
        "clamp" => "m/s2",
        _ => "1",
    }
}

/// Identifier of the effect.
fn id(place: Place, of: Argument) -> String {
    let mode = place.mode.map_or(String::new(), |mode| format!("_{mode}"));
    format!("{PREFIX}{}{mode}_{}", place.name, of.name)
}

/// The line of a file that names the mode, if it is one alone.
fn mode_line(mode: Option<usize>) -> String {
    mode.map_or(String::new(), |mode| format!("mode = {mode}\n"))
}

/// The formula of a place, with `G` for the curve.
fn formula(place: Place, mean_force: f64) -> String {
    place
        .formula
        .replace("MEAN_FORCE", &format!("{mean_force:?}"))
}

/// Time constant and state of an argument with a memory; nothing for others.
fn memory(of: &Argument, at: &[f64], typical: f64) -> String {
    if !of.remembers {
        return String::new();
    }
    let nominal = at[at.len() - 1].abs().max(1e-9) / 4.0;
    format!(
        "\n[[parameter]]\nname = \"tau\"\nunit = \"s\"\nmin = 1e-3\nmax = 5.0\ntypical = {typical:?}\n\
         role = \"shape\"\n\n[[state]]\nname = \"{STATE}\"\nunit = \"{}\"\nnominal = {nominal:e}\n\
         rate = \"({} - {STATE})/tau\"\n",
        of.unit, of.quantity
    )
}

fn file(place: Place, of: Argument, at: &[f64], strength: f64, mean_force: f64) -> String {
    let variable = if of.remembers { STATE } else { of.quantity };
    let formula = formula(place, mean_force).replace('G', &format!("table({variable}, g)"));
    let unit = match place {
        TIP_FORCE => "N",
        MEASUREMENT => "m",
        _ => "1",
    };
    let list: Vec<String> = at.iter().map(|a| format!("{a:e}")).collect();
    let table = format!(
        "id = \"{}\"\ntitle = \"Unknown function of {} acting on {}\"\n\
         family = \"unknown\"\ntarget = \"{}\"\n{}expression = \"{formula}\"\n\n\
         [[table]]\nname = \"g\"\nunit = \"{unit}\"\nat = [{}]\nmin = {:e} # strength\n\
         max = {:e} # strength\ntypical = {strength:e} # strength\n",
        id(place, of),
        of.name.replace('_', " "),
        place.name.replace('_', " "),
        place.target,
        mode_line(place.mode),
        list.join(", "),
        -MOST * strength,
        MOST * strength,
    );
    table + &memory(&of, at, TYPICAL_MEMORY)
}
