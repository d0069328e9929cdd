//! The parameters of a friction profile along the belt: values of its own at the places that each run passes.

use crate::diagnose::data::place_map::PlaceMap;
use crate::diagnose::model::parameter::{Kind, Parameter, Scale};
use crate::error::Error;
use crate::fmu::effect_card::{EffectCard, Role};

/// Profile nodes that a run is given, ...
const NODES: usize = 32;
/// ... and more where the break-aways are so many that each node has so many of them.
const EVENTS_A_NODE: usize = 2;

/// Standard deviation of the belief in a node's value (1) where neither the break-aways nor the data have told it.
pub(crate) const NODE_STD: f64 = 0.2;

/// How much surer the map of the break-aways is of a node than of the next break-away: it is a mean over several.
const SURER: f64 = 3.0;

/// Settings that say where the values lie and how many there are; each run has its own.
pub(crate) const PLACES: [&str; 3] = ["length", "start", "count"];

/// What a run passes of the belt.
#[derive(Debug, Clone)]
pub struct Track {
    /// Smallest belt travel in m.
    pub low: f64,
    /// Largest belt travel in m.
    pub high: f64,
    /// Its break-aways along the belt, if they are enough to say anything.
    pub map: Option<PlaceMap>,
    /// Whether the break-aways of the whole campaign tell that friction depends on the place.
    pub place_is_told: bool,
}

/// Gives each run the nodes of a profile over the belt travel that it covers, believed to spread by `node_std` where the break-aways do not tell them.
pub(crate) fn add_profile(
    effect: &EffectCard,
    node_std: f64,
    tracks: &[Track],
    per_run: &mut [Vec<Parameter>],
) -> Result<(), Error> {
    let nodes: Vec<_> = effect
        .parameters
        .iter()
        .filter(|p| p.role == Role::Node)
        .collect();
    let setting = |name: &str| {
        effect
            .parameters
            .iter()
            .find(|p| p.name == name)
            .map(|p| p.reference)
    };
    let [Some(length), Some(start), Some(count)] = PLACES.map(setting) else {
        return Ok(());
    };
    if nodes.is_empty() {
        return Ok(());
    }
    for (parameters, track) in per_run.iter_mut().zip(tracks) {
        let low = track.low;
        let span = (track.high - low).max(1e-9);
        let map = track.map.as_ref().filter(|_| track.place_is_told);
        let events = map.map_or(0, |m| m.events().len());
        let used = nodes.len().min(NODES.max(events / EVENTS_A_NODE));
        let spacing = span / (used - 1) as f64;
        let constant = |reference: u32, name: &str, value: f64| Parameter {
            name: format!("{}.{name}", effect.id),
            unit: "m".into(),
            kind: Kind::Constant,
            targets: vec![(reference, 1.0)],
            scale: Scale::Linear,
            prior: value,
            prior_std: 0.0,
            min: value,
            max: value,
            step: 0.0,
            support: None,
        };
        parameters.push(constant(length, "length", span));
        parameters.push(constant(start, "start", low));
        parameters.push(constant(count, "count", used as f64));
        for (i, node) in nodes[..used].iter().enumerate() {
            let at = low + spacing * i as f64;
            parameters.push(Parameter {
                name: format!("{}.{}", effect.id, node.name),
                unit: node.unit.clone(),
                kind: Kind::Node,
                targets: vec![(node.reference, 1.0)],
                scale: Scale::Linear,
                prior: map.map_or(0.0, |m| m.at(at)),
                prior_std: map.map_or(node_std, |m| m.error / SURER),
                min: -0.9,
                max: 2.0,
                step: 1e-3,
                support: Some((at - 2.5 * spacing, at + 2.5 * spacing)),
            });
        }
    }
    Ok(())
}

/// Whether an effect has values along the belt.
pub(crate) fn is_profile(effect: &EffectCard) -> bool {
    effect.find_role(Role::Node).is_some()
}
