//! The effects that an FMU declares as candidates, read from its vendor annotation or from its side file.

use super::Fmu;
use crate::error::Error;

/// How a parameter enters, which tells the calibration what to do with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Strength: zero means off.
    Amplitude,
    /// A shape constant (time, length, frequency, stiffness).
    Shape,
    /// A phase, which differs from run to run.
    Phase,
    /// One of many values of a profile along the belt, which differs from run to run.
    Node,
    /// A choice or a size that is given, never calibrated.
    Setting,
}

/// A parameter of a candidate effect.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectParameter {
    /// Name within the effect.
    pub name: String,
    /// What it is.
    pub description: String,
    /// Value reference in the FMU.
    pub reference: u32,
    /// Unit symbol.
    pub unit: String,
    /// Value that means off or neutral.
    pub start: f64,
    /// A value as met in practice.
    pub typical: f64,
    /// Smallest plausible value.
    pub min: f64,
    /// Largest plausible value.
    pub max: f64,
    /// How it enters.
    pub role: Role,
}

/// An extra state of a candidate effect.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectState {
    /// Name within the effect.
    pub name: String,
    /// Value reference in the FMU.
    pub reference: u32,
    /// Typical magnitude.
    pub nominal: f64,
}

/// An effect that the FMU offers.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectCard {
    /// Identifier.
    pub id: String,
    /// Title in a few words.
    pub title: String,
    /// The equation in plain text.
    pub equation: String,
    /// What happens physically.
    pub description: String,
    /// Author, year, place.
    pub source: String,
    /// How it shows in the measured displacement.
    pub signature: String,
    /// Effects that look alike and what tells them apart.
    pub confounders: String,
    /// Its parameters.
    pub parameters: Vec<EffectParameter>,
    /// Its states.
    pub states: Vec<EffectState>,
    /// Whether it is none of the catalogue, but was put into the FMU beside that.
    pub is_own: bool,
}

impl Role {
    /// The role of this name.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "amplitude" => Role::Amplitude,
            "shape" => Role::Shape,
            "phase" => Role::Phase,
            "node" => Role::Node,
            "setting" => Role::Setting,
            _ => return None,
        })
    }
}

impl EffectCard {
    /// Index of the first parameter with a role.
    pub fn find_role(&self, role: Role) -> Option<usize> {
        self.parameters.iter().position(|p| p.role == role)
    }

    /// Index of the parameter that switches the effect off by degrees: its amplitude, or its only constant, a time after which
    /// something follows late, and which goes to zero.
    pub fn switch(&self) -> Option<usize> {
        if self.find_role(Role::Node).is_some() {
            return None;
        }
        let all = self.parameters.iter().enumerate();
        let mut shapes = all.filter(|(_, p)| p.role == Role::Shape);
        let time = match (shapes.next(), shapes.next()) {
            (Some((i, p)), None) if p.unit == "s" => Some(i),
            _ => None,
        };
        self.find_role(Role::Amplitude).or(time)
    }

    /// Whether it repeats in time or along the belt, with a phase of its own in each run.
    pub fn repeats(&self) -> bool {
        self.find_role(Role::Phase).is_some()
    }

    /// How long a search for it takes beside that for others, roughly: what is free in it, and a grid for a frequency.
    pub fn weight(&self) -> usize {
        const GRID: usize = 10;
        let free = self.parameters.iter().filter(|p| p.role != Role::Setting);
        let grid = if self.resonance().is_some() { GRID } else { 0 };
        free.count() + self.states.len() + grid
    }

    /// Index of the natural frequency in Hz, for an effect that has one and no amplitude of its own.
    pub fn resonance(&self) -> Option<usize> {
        let of_nothing = |role| self.find_role(role).is_none();
        let is_frequency = |p: &EffectParameter| p.role == Role::Shape && p.unit == "Hz";
        (of_nothing(Role::Amplitude) && of_nothing(Role::Phase))
            .then(|| self.parameters.iter().position(is_frequency))
            .flatten()
    }
}

/// All effects that the FMU declares, in its order.
///
/// # Errors
/// An annotation that can't be read or names variables that the FMU does not have.
pub fn candidates(fmu: &Fmu) -> Result<Vec<EffectCard>, Error> {
    if let Some(side) = fmu.side_file() {
        // A calibrated FMU may be run, but not searched for the effects that are on in it.
        for (effect, p) in side
            .effects
            .iter()
            .flat_map(|e| e.parameters.iter().map(move |p| (e, p)))
        {
            if p.role == Role::Amplitude && p.start != 0.0 {
                return Err(side.error(format!(
                    "{}.{} is {} where the FMU starts; an amplitude must be 0 there, which switches the effect off",
                    effect.id, p.name, p.start
                )));
            }
        }
        return Ok(side.effects.clone());
    }
    let Some(document) = annotation(fmu)? else {
        return Ok(Vec::new());
    };
    let broken = |problem: String| Error::FmuDescription {
        path: fmu.path().to_owned(),
        problem,
    };
    let text =
        |node: &roxmltree::Node, name: &str| node.attribute(name).unwrap_or_default().to_owned();
    let number = |node: &roxmltree::Node, name: &str| -> Result<f64, Error> {
        text(node, name).parse().map_err(|_| {
            broken(format!(
                "effect parameter {}: {name} is not a number",
                text(node, "name")
            ))
        })
    };
    let mut out = Vec::new();
    for node in document.descendants().filter(|n| n.has_tag_name("Effect")) {
        let id = text(&node, "id");
        let reference = |variable: String| fmu.variable(&variable).map(|v| v.reference);
        let mut parameters = Vec::new();
        for p in node.children().filter(|n| n.has_tag_name("Parameter")) {
            parameters.push(EffectParameter {
                name: text(&p, "name"),
                description: text(&p, "description"),
                reference: reference(format!("{id}.{}", text(&p, "name")))?,
                unit: text(&p, "unit"),
                start: number(&p, "start")?,
                typical: number(&p, "typical")?,
                min: number(&p, "min")?,
                max: number(&p, "max")?,
                role: Role::named(&text(&p, "role")).ok_or_else(|| {
                    broken(format!("effect {id}: unknown role '{}'", text(&p, "role")))
                })?,
            });
        }
        let mut states = Vec::new();
        for s in node.children().filter(|n| n.has_tag_name("State")) {
            states.push(EffectState {
                reference: reference(format!("{id}.state.{}", text(&s, "name")))?,
                name: text(&s, "name"),
                nominal: number(&s, "nominal")?,
            });
        }
        out.push(EffectCard {
            title: text(&node, "title"),
            equation: text(&node, "equation"),
            description: text(&node, "description"),
            source: text(&node, "source"),
            signature: text(&node, "signature"),
            confounders: text(&node, "confounders"),
            is_own: node.attribute("own") == Some("true"),
            id,
            parameters,
            states,
        });
    }
    Ok(out)
}

/// The annotation in which an FMU of this project declares its effects.
///
/// # Errors
/// One that is no XML.
pub(crate) fn annotation(fmu: &Fmu) -> Result<Option<roxmltree::Document<'_>>, Error> {
    let Some(xml) = fmu.description().vendor_annotation("StickSlip") else {
        return Ok(None);
    };
    let document = roxmltree::Document::parse(xml).map_err(|e| Error::FmuDescription {
        path: fmu.path().to_owned(),
        problem: format!("the list of effects can't be read: {e}"),
    })?;
    Ok(Some(document))
}
