//! A hypothesis: the reference model plus some effects, with everything that may be turned.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::model::beam_constants;
use crate::diagnose::model::belt_profile::{PLACES, Roughness, Track, add_profile, is_profile};
use crate::diagnose::model::friction_prior::FrictionPrior;
use crate::diagnose::model::further_sensors::{constants_of_run, shared_constants};
use crate::diagnose::model::known_structure::structure;
use crate::diagnose::model::parameter::{Kind, Parameter, Scale};
use crate::diagnose::model::periodic::{Argument, argument, periodic};
use crate::diagnose::model::references::References;
use crate::diagnose::model::scales::Scales;
use crate::diagnose::model::sensor_ratios::sensor_ratios;
use crate::diagnose::model::sensor_zero::SensorZero;
use crate::diagnose::model::stated_constants::constants;
use crate::diagnose::model::unknown_function::{Smoothness, is_node, is_unknown_function, latent};
use crate::error::Error;
use crate::fmu::Fmu;
use crate::fmu::effect_card::{EffectCard, EffectParameter, Role};
use crate::measurement::{Campaign, DelayBelief, Measurand, Run};
use serde::Serialize;

/// An effect chosen, with the values of its settings.
#[derive(Debug, Clone, Serialize)]
pub struct Choice {
    /// Index in the FMU's list of effects.
    pub effect: usize,
    /// Setting values: parameter index and value.
    pub settings: Vec<(usize, f64)>,
    /// What is believed of values along the belt, for the effect that has such.
    pub roughness: Roughness,
    /// What is believed of the curve, for an unknown function.
    pub smoothness: Smoothness,
}

impl Choice {
    /// An effect with no setting.
    pub fn of(effect: usize) -> Self {
        Self {
            effect,
            settings: Vec::new(),
            roughness: Roughness::UNTOLD,
            smoothness: Smoothness::UNTOLD,
        }
    }
}

/// What is believed of values along the belt and of a curve is no part of what is chosen: it is found like a parameter.
impl PartialEq for Choice {
    fn eq(&self, other: &Self) -> bool {
        self.effect == other.effect && self.settings == other.settings
    }
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
    /// Indices of the shared parameters that scale belt velocity and normal force; `None` for one that is zero in every run, whose scale
    /// changes nothing.
    pub input_scales: [Option<usize>; 2],
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
    /// `tracks` says for each run what it passes of the belt, `zero` what is
    /// believed of the sensor's zero, `belt` the standard deviation of the belief in its belt speeds, as a share, `scales` those of the machine.
    ///
    /// # Errors
    /// An FMU without the variables named in the contract.
    pub fn new(
        fmu: &Fmu,
        campaign: &Campaign,
        catalogue: &[EffectCard],
        choices: &[Choice],
        tracks: &[Track],
        (zero, delays, belt, scales): (&SensorZero, &[DelayBelief], f64, Scales),
        friction: &FrictionPrior,
    ) -> Result<Self, Error> {
        let structure = structure(fmu, &campaign.beam)?;
        let known = &campaign.uncertainty;
        let modes = structure.modes();
        let side = fmu.side_file();
        let (mut shared, mut fixed) = match side {
            Some(side) => (constants(side, false), Vec::new()),
            None => beam_constants::of_structure(fmu, campaign, &structure, scales)?,
        };
        let (ratios, of_added_modes) = sensor_ratios(fmu, &campaign.beam.sensor, modes.len())?;
        shared.extend(ratios);
        fixed.extend(of_added_modes);
        if side.is_none() {
            for (j, share) in campaign.beam.clamp_shares.iter().enumerate() {
                let name = format!("mode[{}].clamp_share", j + 1);
                fixed.push((fmu.variable(&name)?.reference, *share));
            }
        }
        shared.extend(shared_constants(
            &campaign.further_sensors,
            delays,
            modes.len(),
        ));
        // What nothing presses on rubs nowhere: neither the scale of its load nor any constant of friction changes a motion.
        let is_pressed = campaign.runs.iter().any(Run::is_pressed);
        let stated = [
            (
                "belt_velocity.scale",
                belt,
                campaign.runs.iter().any(Run::belt_moves),
            ),
            ("normal_force.scale", known.normal_force_std, is_pressed),
        ];
        let input_scales = stated.map(|(name, std, acts)| {
            acts.then(|| {
                shared.push(Parameter {
                    kind: Kind::Input,
                    targets: Vec::new(),
                    ..Parameter::positive(name.into(), "1", 0, (1.0, std), 1.2)
                });
                shared.len() - 1
            })
        });
        let mut per_run = match side {
            Some(side) => vec![constants(side, true); campaign.runs.len()],
            None if !is_pressed => vec![Vec::new(); campaign.runs.len()],
            None => {
                shared.extend(beam_constants::of_friction(fmu, friction)?);
                beam_constants::levels(fmu, friction, known)?
            }
        };
        let measurand = campaign.measurand();
        let (offset_name, offset_target) = match measurand {
            // Where the FMU has no sensor of its own, as for velocities and accelerations, the predictor adds it.
            Measurand::Displacement => (
                "sensor.offset",
                match (side, fmu.variable("sensor.offset")) {
                    (Some(_), Err(_)) => Vec::new(),
                    (_, offset) => vec![(offset?.reference, 1.0)],
                },
            ),
            Measurand::Velocity => ("sensor.velocity_offset", Vec::new()),
            Measurand::Acceleration => ("sensor.acceleration_offset", Vec::new()),
        };
        let offset = (offset_name, measurand.unit());
        for (number, (own, run)) in per_run.iter_mut().zip(&campaign.runs).enumerate() {
            own.push(zero.parameter(number, offset, offset_target.clone()));
            own.extend(constants_of_run(&campaign.further_sensors, run));
        }
        let mut extra_states = Vec::new();
        // One of another make is started by its states alone: it finds out by itself whether it sticks.
        let mut has_memory = side.is_some();
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
                    // Where the values of a profile lie each run says itself.
                    Role::Setting if is_profile(effect) && PLACES.contains(&p.name.as_str()) => {}
                    Role::Setting => fixed.push((p.reference, p.start)),
                    Role::Amplitude | Role::Shape => shared.push(parameter),
                }
            }
            if is_unknown_function(&effect.id) {
                shared.extend(latent(effect, choice.smoothness));
            }
            add_profile(effect, choice.roughness, tracks, &mut per_run);
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
        let excitations = run.inputs.excitations().into_iter();
        let excited = excitations.zip(references.excitations);
        let excited = excited.filter_map(|((_, _, excitation), reference)| {
            let size = match &excitation.series {
                Some(_) => 1.0,
                None => excitation.constant,
            };
            Some((reference.filter(|_| size != 0.0)?, size))
        });
        let [belt, force] = [belt * belt_size, force * force_size];
        let [of_belt, of_force] = references.inputs;
        let stated = [of_belt.map(|r| (r, belt)), of_force.map(|r| (r, force))];
        let stated = stated.into_iter().flatten();
        stated.chain(excited)
    }

    /// Factors of belt velocity and normal force.
    pub fn scales(&self, shared: &[f64]) -> [f64; 2] {
        self.input_scales
            .map(|scale| scale.map_or(1.0, |i| self.shared[i].value(shared[i])))
    }

    /// Value reference of an input with a series, and the factor of its series.
    pub fn input_scale(&self, references: &References, name: &str, shared: &[f64]) -> (u32, f64) {
        let [belt, force] = self.scales(shared);
        let (reference, scale) = match name {
            "belt_velocity" => (references.inputs[0], belt),
            "normal_force" => (references.inputs[1], force),
            "external_force" => (references.excitations[0], 1.0),
            _ => (references.excitations[1], 1.0),
        };
        (reference.expect("a campaign is checked for it"), scale)
    }

    /// Distance in m that belt and tip have moved against each other when a segment of a run starts in `state`: the belt's part grows
    /// with its velocity, and the tip's is that of the start state where its displacement is not measured.
    pub fn travel(
        &self,
        references: &References,
        (run, segment): (&Run, &Segment),
        shared: &[f64],
        state: &[f64],
    ) -> f64 {
        let belt = self.scales(shared)[0];
        let (size, passed) = belt_part(run, segment);
        let as_smoothed = segment.travel + (belt * size - size) * passed;
        if !references.is_integrated {
            return as_smoothed;
        }
        let starts = state.iter().zip(&segment.state).step_by(2);
        let moved = references.tip_values.iter().zip(starts);
        let moved: f64 = moved.map(|(phi, (q, smoothed))| phi * (q - smoothed)).sum();
        as_smoothed - moved
    }

    /// Derivatives by start state `i` of all that is set from it.
    pub fn start_changes(&self, references: &References, i: usize) -> Vec<(u32, f64)> {
        let modal = 2 * self.modes;
        if i >= modal {
            return vec![(self.extra_states[i - modal].0, 1.0)];
        }
        let moves = references.is_integrated && i.is_multiple_of(2);
        let travel = references.history[0].filter(|_| moves);
        let of_travel = travel.map(|r| (r, -references.tip_values[i / 2]));
        let of_state = std::iter::once((references.starts[i], 1.0));
        of_state.chain(of_travel).collect()
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
        if self.input_scales[0] == Some(c) {
            let (size, passed) = belt_part(run, segment);
            let travel = references.history[0];
            let of_belt = belt.map(|r| (r, slope * belt_size));
            let of_travel = travel.map(|r| (r, slope * size * passed));
            of_belt.into_iter().chain(of_travel).collect()
        } else if self.input_scales[1] == Some(c) {
            let of_force = force.map(|r| (r, slope * force_size));
            of_force.into_iter().collect()
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
