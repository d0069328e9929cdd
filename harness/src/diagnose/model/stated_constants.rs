//! Constants of an FMU of another make, as its side file states them, which every hypothesis on it calibrates.

use crate::diagnose::model::parameter::{Kind, Parameter};
use crate::fmu::{Belief, Constant, SideFile};

/// Standard deviations from the stated value within which a constant is sought, within its bounds: beyond, the file states another
/// model.
const REACH: f64 = 6.0;

/// The constants that all runs share, or those of which each run has its own.
pub fn constants(side: &SideFile, per_run: bool) -> Vec<Parameter> {
    let wanted = side.constants.iter().filter(|c| c.per_run == per_run);
    wanted.map(parameter).collect()
}

fn parameter(constant: &Constant) -> Parameter {
    let &Constant {
        reference, value, ..
    } = constant;
    let unit = &constant.unit;
    let name = constant.variable.clone();
    let out = match constant.belief {
        Belief::Relative(std) => {
            Parameter::positive(name, unit, reference, (value, std), (REACH * std).exp())
        }
        Belief::Absolute(std) => Parameter::linear(name, unit, reference, (value, std), REACH),
    };
    Parameter {
        kind: if constant.per_run {
            Kind::Level
        } else {
            Kind::Reference
        },
        min: constant.min.map_or(out.min, |min| min.max(out.min)),
        max: constant.max.map_or(out.max, |max| max.min(out.max)),
        ..out
    }
}
