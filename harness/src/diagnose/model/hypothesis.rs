//! A hypothesis: the reference model plus some effects, with everything that may be turned.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::model::belt_profile::{NODE_STD, Track, add_profile};
use crate::diagnose::model::effect_card::{EffectCard, EffectParameter, Role};
use crate::diagnose::model::friction_prior::{Belief, FrictionPrior};
use crate::diagnose::model::further_sensors::{FurtherSensors, constants_of_run, shared_constants};
use crate::diagnose::model::parameter::{Kind, Parameter, Scale};
use crate::diagnose::model::periodic::{Argument, argument, periodic};
use crate::diagnose::model::scales::Scales;
use crate::diagnose::model::sensor_ratios::sensor_ratios;
use crate::diagnose::model::unknown_function::{is_node, is_unknown_function, latent};
use crate::error::Error;
use crate::fmu::{Fmu, Variable};
use crate::measurement::{BeamKnowledge, Campaign, Measurand, Run};
use crate::observer::{Mode, Structure};
use serde::Serialize;
use std::sync::Arc;

/// An effect chosen, with the values of its settings.
#[derive(Debug, Clone, Serialize)]
pub struct Choice {
    /// Index in the FMU's list of effects.
    pub effect: usize,
    /// Setting values: parameter index and value.
    pub settings: Vec<(usize, f64)>,
    /// Standard deviation of the belief in each value along the belt, for the effect that has such.
    pub node_std: f64,
}

impl Choice {
    /// An effect with no setting.
    pub fn of(effect: usize) -> Self {
        Self {
            effect,
            settings: Vec::new(),
            node_std: NODE_STD,
        }
    }
}

/// What is believed of the values along the belt is no part of what is chosen: it is found like a parameter.
impl PartialEq for Choice {
    fn eq(&self, other: &Self) -> bool {
        self.effect == other.effect && self.settings == other.settings
    }
}

/// Value references of the FMU's variables that every hypothesis needs.
pub struct References {
    /// belt_velocity, normal_force.
    pub inputs: [u32; 2],
    /// external_force, where the FMU has it.
    pub external_force: Option<u32>,
    /// The output that the sensor measures ([`output_of`]).
    pub measured: u32,
    /// Whether the sensor's offset is to be added to that output: the FMU adds it to measured_displacement alone.
    pub lacks_offset: bool,
    /// contact_mode (an enumeration, 0 = stick).
    pub contact_mode: u32,
    /// start.contact (an enumeration).
    pub contact: u32,
    /// start.effects (an enumeration).
    pub start_effects: u32,
    /// mode_count (an integer).
    pub mode_count: u32,
    /// tolerance.
    pub tolerance: u32,
    /// belt_travel.start and dwell_time.start.
    pub history: [u32; 2],
    /// q[j], q_dot[j] in turn.
    pub states: Vec<u32>,
    /// What further sensors read.
    pub further: Arc<FurtherSensors>,
}

impl References {
    /// Looks the names up.
    ///
    /// # Errors
    /// A variable that the FMU does not have.
    pub fn new(fmu: &Fmu, structure: &Structure, campaign: &Campaign) -> Result<Self, Error> {
        let modes = structure.modes().len();
        let measurand = campaign.measurand();
        let tip_values = structure.modes().iter().map(|m| m.tip_value).collect();
        let one = |name: &str| fmu.variable(name).map(|v| v.reference);
        let mut states = Vec::new();
        for j in 1..=modes {
            states.push(one(&format!("q[{j}]"))?);
            states.push(one(&format!("q_dot[{j}]"))?);
        }
        Ok(Self {
            inputs: [one("belt_velocity")?, one("normal_force")?],
            external_force: one("external_force").ok(),
            measured: output_of(fmu, measurand)?.reference,
            lacks_offset: measurand != Measurand::Displacement,
            contact_mode: one("contact_mode")?,
            contact: one("start.contact")?,
            start_effects: one("start.effects")?,
            mode_count: one("mode_count")?,
            tolerance: one("tolerance")?,
            history: [one("belt_travel.start")?, one("dwell_time.start")?],
            states,
            further: Arc::new(FurtherSensors::new(
                fmu,
                &campaign.further_sensors,
                tip_values,
            )?),
        })
    }
}

impl References {
    /// The same names with another output in the place of the one measured.
    pub(crate) fn observing(&self, output: u32) -> Self {
        Self {
            measured: output,
            lacks_offset: false,
            states: self.states.clone(),
            further: self.further.clone(),
            ..*self
        }
    }
}

/// The FMU's output that the sensor measures; that of the tip where the FMU has no sensor.
///
/// # Errors
/// An FMU without either.
pub fn output_of(fmu: &Fmu, measurand: Measurand) -> Result<&Variable, Error> {
    let quantity = measurand.name();
    let measured = fmu.variable(&format!("measured_{quantity}"));
    measured.or_else(|_| fmu.variable(&format!("tip_{quantity}")))
}

/// The structure as a campaign gives it, with the FMU's start values for what is left out.
///
/// # Errors
/// Modal data that no structure can have.
pub fn structure(fmu: &Fmu, beam: &BeamKnowledge) -> Result<Structure, Error> {
    let start = |name: String| -> Result<f64, Error> {
        Ok(fmu.variable(&name)?.start_number().unwrap_or(f64::NAN))
    };
    let count = if beam.natural_frequencies_hz.is_empty() {
        start("mode_count".into())? as usize
    } else {
        beam.natural_frequencies_hz.len()
    };
    let mut modes = Vec::new();
    for j in 0..count {
        let of = |list: &[f64], item: &str| match list.get(j) {
            Some(value) => Ok(*value),
            None => start(format!("mode[{}].{item}", j + 1)),
        };
        modes.push(Mode {
            frequency_hz: of(&beam.natural_frequencies_hz, "frequency")?,
            damping_ratio: of(&beam.damping_ratios, "damping_ratio")?,
            mass_kg: match beam.masses_kg.len() {
                1 => beam.masses_kg[0],
                _ => of(&beam.masses_kg, "mass")?,
            },
            tip_value: of(&beam.tip_values, "tip_value")?,
            sensor_ratio: beam.sensor.ratios.get(j).copied().unwrap_or(1.0),
        });
    }
    Structure::new(modes).map_err(|source| Error::Observer {
        run: "[beam]".into(),
        source,
    })
}

/// The reference model with the effects chosen, ready to be fitted to a campaign.
#[derive(Clone)]
pub struct Hypothesis {
    /// Effects that are on.
    pub choices: Vec<Choice>,
    /// Parameters common to all runs.
    pub shared: Vec<Parameter>,
    /// Parameters of each run on its own.
    pub per_run: Vec<Vec<Parameter>>,
    /// Constant parameters: reference and value.
    pub fixed: Vec<(u32, f64)>,
    /// Extra states: reference and magnitude.
    pub extra_states: Vec<(u32, f64)>,
    /// Whether a law with memory replaces rigid stick.
    pub has_memory: bool,
    /// Number of structural modes.
    pub modes: usize,
    /// Scales of the modal states, q and q' in turn: 1 and the angular frequency in rad/s.
    pub state_scales: Vec<f64>,
    /// Indices of the shared parameters that scale belt velocity and normal force.
    pub input_scales: [usize; 2],
}

/// Strength of an effect that is as good as off, as a share of the typical one: far below anything measurable, also where a segment
/// that is lost magnifies it (a millionth of viscous friction changed the objective of a calibrated model by 0.07 nats).
pub(crate) const NEARLY_OFF: f64 = 1e-9;

/// Effects whose friction has a memory of its own: sticking is not rigid then.
const MEMORY_STATE: &str = "deflection";

/// Bounds of a frequency or wavelength: within the effect's, and such that some run sees a whole period of it. What has not come
/// round once is no repetition, and imitates whatever changes slowly.
fn seen_whole(
    effect: &EffectCard,
    p: &EffectParameter,
    campaign: &Campaign,
    tracks: &[Track],
) -> (f64, f64) {
    let longest = |spans: &mut dyn Iterator<Item = f64>| spans.fold(0.0, f64::max);
    let (least, most) = match argument(effect) {
        Some(Argument::Time) => {
            let duration = |r: &Run| r.time[r.time.len() - 1] - r.time[0];
            let longest = longest(&mut campaign.runs.iter().map(duration));
            (p.min.max(longest.recip()), p.max)
        }
        Some(Argument::Travel) => {
            let longest = longest(&mut tracks.iter().map(|t| t.high - t.low));
            (p.min, p.max.min(longest))
        }
        None => (p.min, p.max),
    };
    if least < most {
        (least, most)
    } else {
        (p.min, p.max)
    }
}

impl Hypothesis {
    /// The reference model with the effects of `choices`.
    ///
    /// `tracks` says for each run what it passes of the belt, `spread` the standard deviation of
    /// what was measured, `belt` the standard deviation of the belief in its belt speeds, as a share, `scales` those of the machine.
    ///
    /// # Errors
    /// An FMU without the variables named in the contract.
    pub fn new(
        fmu: &Fmu,
        campaign: &Campaign,
        catalogue: &[EffectCard],
        choices: &[Choice],
        tracks: &[Track],
        (spread, belt, scales): (f64, f64, Scales),
        friction: &FrictionPrior,
    ) -> Result<Self, Error> {
        let structure = structure(fmu, &campaign.beam)?;
        let reference = |name: &str| fmu.variable(name).map(|v| v.reference);
        let known = &campaign.uncertainty;
        let mut shared = Vec::new();
        let mut fixed = Vec::new();
        let log = |name: String, unit: &str, reference: u32, value: f64, std: f64, factor: f64| {
            Parameter {
                name,
                unit: unit.to_owned(),
                kind: Kind::Reference,
                targets: vec![(reference, 1.0)],
                scale: Scale::Log,
                prior: value,
                prior_std: std,
                min: value / factor,
                max: value * factor,
                step: 0.02 * std,
                support: None,
            }
        };
        let modes = structure.modes();
        for (j, mode) in modes.iter().enumerate() {
            let at = |item: &str| format!("mode[{}].{item}", j + 1);
            let (frequency, damping) = (
                reference(&at("frequency"))?,
                reference(&at("damping_ratio"))?,
            );
            let rate = fmu.variable(&at("damping_rate"));
            let stated_rate = campaign.beam.damping_rates_per_s.get(j).copied();
            match (rate, stated_rate) {
                (Ok(rate), Some(value)) if mode.is_free() && value > 0.0 => {
                    let std = known.damping_rate(j);
                    shared.push(log(
                        at("damping_rate"),
                        "1/s",
                        rate.reference,
                        value,
                        std,
                        30.0,
                    ));
                }
                // Where nothing is known of a guide, the rate at which the mass runs through its range, to a decade.
                (Ok(rate), None) if mode.is_free() => shared.push(log(
                    at("damping_rate"),
                    "1/s",
                    rate.reference,
                    rate.start_number()
                        .filter(|start| *start > 0.0)
                        .unwrap_or(scales.velocity / scales.length),
                    std::f64::consts::LN_10,
                    1e3,
                )),
                (Ok(rate), Some(value)) => fixed.push((rate.reference, value)),
                _ => {}
            }
            if mode.is_free() {
                fixed.extend([(frequency, 0.0), (damping, 0.0)]);
            } else {
                shared.push(log(
                    at("frequency"),
                    "Hz",
                    frequency,
                    mode.frequency_hz,
                    known.frequency(j),
                    1.06,
                ));
                shared.push(log(
                    at("damping_ratio"),
                    "1",
                    damping,
                    mode.damping_ratio.max(1e-6),
                    known.damping_ratio(j),
                    30.0,
                ));
            }
            fixed.push((reference(&at("tip_value"))?, mode.tip_value));
            shared.push(log(
                at("mass"),
                "kg",
                reference(&at("mass"))?,
                mode.mass_kg,
                known.participation(j),
                1.5,
            ));
        }
        let (ratios, of_added_modes) = sensor_ratios(fmu, &campaign.beam.sensor, modes.len())?;
        shared.extend(ratios);
        fixed.extend(of_added_modes);
        shared.extend(shared_constants(&campaign.further_sensors, modes.len()));
        let input_scales = [shared.len(), shared.len() + 1];
        for (name, std) in [
            ("belt_velocity.scale", belt),
            ("normal_force.scale", known.normal_force_std),
        ] {
            shared.push(Parameter {
                kind: Kind::Input,
                targets: Vec::new(),
                ..log(name.into(), "1", 0, 1.0, std, 1.2)
            });
        }
        for (item, unit, belief, factor) in [
            ("mu_0", "1", friction.mu_0, 3.0),
            ("v1", "m/s", friction.v1, 5.0),
            ("c2", "s/m", friction.c2, 6.0),
            ("a2", "1", friction.a2, 3.0),
        ] {
            let name = format!("friction.{item}");
            let reference = reference(&name)?;
            shared.push(log(name, unit, reference, belief.0, belief.1, factor));
        }
        shared.push(Parameter {
            name: "friction.a1".into(),
            unit: "1".into(),
            kind: Kind::Reference,
            targets: vec![(reference("friction.a1")?, 1.0)],
            scale: Scale::Linear,
            prior: friction.a1.0,
            prior_std: friction.a1.1,
            min: 0.0,
            max: 0.95,
            step: 0.002,
            support: None,
        });
        let level_reference = reference("friction.level")?;
        let level = |belief: Belief| {
            let name = "friction.level".to_owned();
            // Only the product of a run's level and its normal force acts.
            let std = belief.1.hypot(known.normal_force_run_std);
            Parameter {
                kind: Kind::Level,
                ..log(name, "1", level_reference, belief.0, std, 4.0)
            }
        };
        let measurand = campaign.measurand();
        let (offset_name, offset_target) = match measurand {
            Measurand::Displacement => ("sensor.offset", vec![(reference("sensor.offset")?, 1.0)]),
            // The FMU has no sensor of velocities or accelerations: the predictor adds it.
            Measurand::Velocity => ("sensor.velocity_offset", Vec::new()),
            Measurand::Acceleration => ("sensor.acceleration_offset", Vec::new()),
        };
        let offset = Parameter {
            name: offset_name.into(),
            unit: measurand.unit().into(),
            kind: Kind::Offset,
            targets: offset_target,
            scale: Scale::Linear,
            prior: 0.0,
            prior_std: 0.02 * spread,
            min: -10.0 * spread,
            max: 10.0 * spread,
            step: 1e-3 * spread,
            support: None,
        };
        let mut per_run: Vec<Vec<Parameter>> = friction
            .levels
            .iter()
            .map(|&belief| vec![level(belief), offset.clone()])
            .collect();
        for (own, run) in per_run.iter_mut().zip(&campaign.runs) {
            own.extend(constants_of_run(&campaign.further_sensors, run));
        }
        let mut extra_states = Vec::new();
        let mut has_memory = false;
        for choice in choices {
            let effect = &catalogue[choice.effect];
            has_memory |= effect.states.iter().any(|s| s.name == MEMORY_STATE);
            extra_states.extend(effect.states.iter().map(|s| (s.reference, s.nominal)));
            for &(index, value) in &choice.settings {
                fixed.push((effect.parameters[index].reference, value));
            }
            for (index, p) in effect.parameters.iter().enumerate() {
                let is_curve = is_unknown_function(&effect.id) && is_node(&p.name);
                if is_curve || choice.settings.iter().any(|s| s.0 == index) {
                    continue;
                }
                // What switches the effect off acts in proportion to itself, a delay as much as an amplitude: on a logarithmic
                // scale the way from a typical value to a small one would be a long one.
                let is_switch = effect.switch() == Some(index);
                let scale = if p.role == Role::Shape && p.min > 0.0 && !is_switch {
                    Scale::Log
                } else {
                    Scale::Linear
                };
                let typical = if scale == Scale::Log {
                    1.0
                } else {
                    p.typical.abs()
                };
                let (least, most) = match periodic(effect) {
                    Some((_, shape)) if shape == index => seen_whole(effect, p, campaign, tracks),
                    _ => (p.min, p.max),
                };
                let centre = if p.role == Role::Shape {
                    p.typical.clamp(least, most)
                } else {
                    0.0
                };
                let parameter = Parameter {
                    name: format!("{}.{}", effect.id, p.name),
                    unit: p.unit.clone(),
                    kind: match p.role {
                        Role::Amplitude => Kind::Amplitude,
                        Role::Shape => Kind::Shape,
                        Role::Phase => Kind::Phase,
                        Role::Node => Kind::Node,
                        Role::Setting => Kind::Constant,
                    },
                    targets: vec![(p.reference, 1.0)],
                    scale,
                    prior: centre,
                    prior_std: match (p.role, scale) {
                        (Role::Phase, _) => 100.0,
                        (_, Scale::Log) => (p.max / p.min).ln(),
                        (_, Scale::Linear) => 3.0 * p.max.abs().max(p.min.abs()),
                    },
                    min: match p.role {
                        Role::Phase => -1e3,
                        // Quite off an effect has no derivatives, which would look like certainty.
                        Role::Amplitude if p.min == 0.0 => NEARLY_OFF * p.typical,
                        _ => least,
                    },
                    max: if p.role == Role::Phase { 1e3 } else { most },
                    step: match p.role {
                        Role::Phase => 0.01,
                        _ => 0.01 * typical,
                    },
                    support: None,
                };
                match p.role {
                    Role::Phase => per_run
                        .iter_mut()
                        .for_each(|parameters| parameters.push(parameter.clone())),
                    Role::Node => {}
                    Role::Setting => fixed.push((p.reference, p.start)),
                    Role::Amplitude | Role::Shape => shared.push(parameter),
                }
            }
            if is_unknown_function(&effect.id) {
                shared.extend(latent(effect));
            }
            add_profile(effect, choice.node_std, tracks, &mut per_run)?;
        }
        Ok(Self {
            choices: choices.to_vec(),
            shared,
            per_run,
            fixed,
            extra_states,
            has_memory,
            modes: modes.len(),
            state_scales: modes.iter().flat_map(|m| [1.0, m.rate()]).collect(),
            input_scales,
        })
    }

    /// Inputs of a run by value reference: m/s and N. One with a series has its scale, by which the series acts.
    pub fn inputs(
        &self,
        references: &References,
        run: &Run,
        shared: &[f64],
    ) -> impl Iterator<Item = (u32, f64)> {
        let [belt, force] = self.scales(shared);
        let [belt_size, force_size] = sizes(run);
        let push = match &run.inputs.external_force {
            Some(_) => 1.0,
            None => run.inputs.constant_external_force,
        };
        let pushed = references.external_force.filter(|_| push != 0.0);
        [
            (references.inputs[0], belt * belt_size),
            (references.inputs[1], force * force_size),
        ]
        .into_iter()
        .chain(pushed.map(move |reference| (reference, push)))
    }

    /// Factors of belt velocity and normal force.
    fn scales(&self, shared: &[f64]) -> [f64; 2] {
        self.input_scales.map(|i| self.shared[i].value(shared[i]))
    }

    /// Value reference of an input with a series, and the factor of its series.
    pub fn input_scale(&self, references: &References, name: &str, shared: &[f64]) -> (u32, f64) {
        let [belt, force] = self.scales(shared);
        match name {
            "belt_velocity" => (references.inputs[0], belt),
            "normal_force" => (references.inputs[1], force),
            _ => (
                references
                    .external_force
                    .expect("a campaign is checked for it"),
                1.0,
            ),
        }
    }

    /// Distance in m that belt and tip have moved against each other when a segment of a run starts: the belt's part grows with
    /// its velocity.
    pub fn travel(&self, run: &Run, segment: &Segment, shared: &[f64]) -> f64 {
        let belt = self.scales(shared)[0];
        let (size, passed) = belt_part(run, segment);
        segment.travel + (belt * size - size) * passed
    }

    /// Derivatives by the position of shared parameter `c` of all that is set from it in a segment of a run.
    pub fn changes(
        &self,
        references: &References,
        (run, segment): (&Run, &Segment),
        c: usize,
        position: f64,
    ) -> Vec<(u32, f64)> {
        let parameter = &self.shared[c];
        let (slope, [belt, force]) = (parameter.slope(position), references.inputs);
        let [belt_size, force_size] = sizes(run);
        if c == self.input_scales[0] {
            let (size, passed) = belt_part(run, segment);
            vec![
                (belt, slope * belt_size),
                (references.history[0], slope * size * passed),
            ]
        } else if c == self.input_scales[1] {
            vec![(force, slope * force_size)]
        } else {
            parameter.changes(position).collect()
        }
    }

    /// The effect that was added last.
    ///
    /// # Panics
    /// For the reference model, which has none.
    pub fn new_effect(&self) -> usize {
        self.choices
            .last()
            .expect("a hypothesis with an effect")
            .effect
    }

    /// Position of the shared parameter with a name.
    pub fn shared_index(&self, name: &str) -> Option<usize> {
        self.shared.iter().position(|k| k.name == name)
    }
}

/// What the scales of belt velocity in m/s and normal force in N act on: 1 where the input has a series, which the scale multiplies.
fn sizes(run: &Run) -> [f64; 2] {
    let of = |is_series: bool, constant: f64| if is_series { 1.0 } else { constant };
    [
        of(run.inputs.belt_velocity.is_some(), run.belt_velocity),
        of(run.inputs.normal_force.is_some(), run.normal_force),
    ]
}

/// What the scale of the belt velocity acts on until a segment starts, as a product: a constant velocity in m/s and the time in s,
/// or 1 and the distance in m.
fn belt_part(run: &Run, segment: &Segment) -> (f64, f64) {
    match &run.inputs.belt_velocity {
        None => (run.belt_velocity, segment.time[0] - run.time[0]),
        Some(_) => (1.0, segment.belt_distance),
    }
}
