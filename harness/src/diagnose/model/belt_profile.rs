//! The parameters of a friction profile along the belt.
//!
//! A profile g(s) is believed to be a Gaussian process along the belt with standard deviation sigma and correlation length l,
//!
//! ```text
//! E[g(s) g(t)] = sigma^2 exp(-((s - t)/l)^2),
//! ```
//!
//! as the sum of independent normal weights z_j, one every third of l, each spread by the root of that correlation:
//!
//! ```text
//! g(s) = sum_j z_j c exp(-2 ((s - s_j)/l)^2),   z_j ~ N(0, sigma^2),   c^2 sum_j exp(-4 ((s - s_j)/l)^2) = 1
//! ```
//!
//! so that each weight acts near its place alone. The FMU's nodes are set from these sums. Both sigma and l are found by the evidence.
//! Where break-aways map the friction along the belt, each node is a parameter of its own, believed as the map has it.
//! Source: Higdon, in Quantitative Methods for Current Environmental Issues (2002), p. 37 (process convolutions).

use crate::diagnose::data::place_map::PlaceMap;
use crate::diagnose::model::parameter::{Kind, Parameter};
use crate::fmu::effect_card::{EffectCard, EffectParameter, Role};
use serde::Serialize;

/// Nodes that a run is given where break-aways map its friction, ...
const NODES: usize = 32;
/// ... and more where the break-aways are so many that each node has so many of them.
const EVENTS_A_NODE: usize = 2;

/// Weights in a correlation length: at half of their frequency the spectrum of a kernel has fallen to 1e-5.
pub(super) const WEIGHTS_A_LENGTH: f64 = 3.0;
/// Nodes in a correlation length at least: a cubic spline through so many follows the process within 1e-3 of its spread.
const NODES_A_LENGTH: f64 = 5.0;
/// Correlation lengths within which a weight counts in derivatives: its kernel falls to 0.2 % of its height.
pub(super) const REACH: f64 = 1.75;
/// The same in the profile itself: 4e-6.
const WHOLE_REACH: f64 = 2.5;

/// What is believed of a profile before the data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Roughness {
    /// Standard deviation of its values (1).
    pub std: f64,
    /// Its correlation length in m; a run that can't resolve it has the least that its nodes resolve.
    pub length: f64,
    /// Whether the evidence told both.
    pub is_told: bool,
}

impl Roughness {
    /// What is believed where nothing told it: rough, and as short as the nodes resolve.
    pub const UNTOLD: Self = Self {
        std: 0.2,
        length: 0.0,
        is_told: false,
    };
}

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

impl Track {
    /// Belt travel covered in m.
    fn span(&self) -> f64 {
        (self.high - self.low).max(1e-9)
    }

    /// The map of the break-aways, where it is believed.
    fn believed_map(&self) -> Option<&PlaceMap> {
        self.map.as_ref().filter(|_| self.place_is_told)
    }
}

/// The least correlation length in m that a run's nodes resolve.
fn least_length(effect: &EffectCard, track: &Track) -> f64 {
    let nodes = effect.parameters.iter().filter(|p| p.role == Role::Node);
    let intervals = nodes.count().saturating_sub(1).max(1) as f64;
    NODES_A_LENGTH * track.span() / intervals
}

/// Belt travel in m of the longest track.
pub(crate) fn longest_track(tracks: &[Track]) -> f64 {
    tracks.iter().map(Track::span).fold(0.0, f64::max)
}

/// The least that they resolve in every run.
pub(crate) fn resolved_length(effect: &EffectCard, tracks: &[Track]) -> f64 {
    let all = tracks.iter().map(|track| least_length(effect, track));
    all.fold(0.0, f64::max)
}

/// Correlation lengths in m that are tried first: the least that nodes resolve, and in turn [`LONGER`] times as long; one where
/// break-aways tell the values.
pub(crate) fn tried_lengths(effect: &EffectCard, tracks: &[Track]) -> Vec<f64> {
    let least = resolved_length(effect, tracks);
    let count = match tracks.iter().any(|t| t.place_is_told) {
        true => 1,
        false => TRIED,
    };
    let longer = std::iter::successors(Some(least), |length| Some(LONGER * length));
    longer.take(count).collect()
}

/// Ratio of correlation lengths that are tried first, and their number.
const LONGER: f64 = 2.0;
const TRIED: usize = 3;

/// Gives each run the values of a profile over the belt travel that it covers.
pub(crate) fn add_profile(
    effect: &EffectCard,
    roughness: Roughness,
    tracks: &[Track],
    per_run: &mut [Vec<Parameter>],
) {
    let all = effect.parameters.iter();
    let nodes: Vec<_> = all.filter(|p| p.role == Role::Node).collect();
    let setting = |name: &str| {
        let mut all = effect.parameters.iter();
        all.find(|p| p.name == name).map(|p| p.reference)
    };
    let ([Some(length), Some(start), Some(count)], false) = (PLACES.map(setting), nodes.is_empty())
    else {
        return;
    };
    for (parameters, track) in per_run.iter_mut().zip(tracks) {
        let map = track.believed_map();
        let most = match map {
            Some(map) => NODES.max(map.events().len() / EVENTS_A_NODE),
            None => nodes.len(),
        };
        let used = &nodes[..nodes.len().min(most)];
        let spacing = track.span() / (used.len() - 1) as f64;
        let places = [
            (length, track.span()),
            (start, track.low),
            (count, used.len() as f64),
        ];
        let places = places.into_iter().zip(PLACES);
        parameters.extend(places.map(|((reference, value), name)| Parameter {
            kind: Kind::Constant,
            ..Parameter::linear(
                format!("{}.{name}", effect.id),
                "m",
                reference,
                (value, 0.0),
                0.0,
            )
        }));
        let at = |i: usize| track.low + spacing * i as f64;
        match map {
            Some(map) => {
                let all = used.iter().enumerate();
                parameters
                    .extend(all.map(|(i, node)| mapped(&effect.id, node, (at(i), spacing), map)));
            }
            None => {
                let all = used.iter().enumerate();
                let places: Vec<(u32, f64)> = all.map(|(i, n)| (n.reference, at(i))).collect();
                let length = roughness.length.max(least_length(effect, track));
                parameters.extend(weights(&effect.id, roughness.std, length, &places));
            }
        }
    }
}

/// A node at a place in m, the next one so far away, as the map of the break-aways has it.
fn mapped(
    id: &str,
    node: &EffectParameter,
    (at, spacing): (f64, f64),
    map: &PlaceMap,
) -> Parameter {
    Parameter {
        kind: Kind::Node,
        min: -0.9,
        max: 2.0,
        step: 1e-3,
        // A natural spline follows a node alone within two intervals.
        support: Some((at - 2.5 * spacing, at + 2.5 * spacing)),
        ..Parameter::linear(
            format!("{id}.{}", node.name),
            &node.unit,
            node.reference,
            (map.at(at), map.error / SURER),
            0.0,
        )
    }
}

/// The weights that make a profile with a correlation length in m, at nodes with these references and places.
fn weights<'a>(
    id: &'a str,
    std: f64,
    length: f64,
    nodes: &'a [(u32, f64)],
) -> impl Iterator<Item = Parameter> + 'a {
    let spacing = length / WEIGHTS_A_LENGTH;
    let low = nodes[0].1 - REACH * length;
    let span = nodes[nodes.len() - 1].1 + REACH * length - low;
    let count = 2 + (span / spacing) as usize;
    (0..count).map(move |j| {
        let at = low + spacing * j as f64;
        let near = nodes
            .iter()
            .filter(move |(_, place)| (place - at).abs() < WHOLE_REACH * length);
        Parameter {
            kind: Kind::Latent,
            targets: near
                .map(|&(reference, place)| (reference, kernel((place - at) / length)))
                .collect(),
            min: -0.9,
            max: 2.0,
            step: 1e-3,
            support: Some((at - REACH * length, at + REACH * length)),
            ..Parameter::linear(format!("{id}.weight[{}]", j + 1), "1", 0, (0.0, std), 0.0)
        }
    })
}

/// What a weight makes of the profile at a distance in correlation lengths.
pub(super) fn kernel(distance: f64) -> f64 {
    let squares = WEIGHTS_A_LENGTH * std::f64::consts::PI.sqrt() / 2.0;
    squares.sqrt().recip() * (-2.0 * distance * distance).exp()
}

/// Whether an effect has values along the belt.
pub(crate) fn is_profile(effect: &EffectCard) -> bool {
    effect.find_role(Role::Node).is_some()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    const FIRST_NODE: u32 = 100;
    pub(crate) const COUNT: usize = 81;
    /// Belt travel of a run in m, and of a shorter one.
    pub(crate) const TRACK: f64 = 0.08;
    pub(crate) const SHORT_TRACK: f64 = 0.04;

    pub(crate) fn card() -> EffectCard {
        let parameter = |name: String, reference: u32, role: Role| EffectParameter {
            name,
            description: String::new(),
            reference,
            unit: "1".into(),
            start: 0.0,
            typical: 0.05,
            min: -0.8,
            max: 0.8,
            role,
        };
        let places = (1..).zip(PLACES);
        let places = places.map(|(i, name)| parameter(name.into(), i, Role::Setting));
        let nodes = (0..COUNT).map(|i| {
            let name = format!("node[{}]", i + 1);
            parameter(name, FIRST_NODE + i as u32, Role::Node)
        });
        EffectCard {
            id: "profile".into(),
            title: String::new(),
            equation: String::new(),
            description: String::new(),
            source: String::new(),
            signature: String::new(),
            confounders: String::new(),
            parameters: places.chain(nodes).collect(),
            states: Vec::new(),
            is_own: false,
        }
    }

    /// Parameters of a run and of one on a shorter track, with a profile of this correlation length in m.
    pub(crate) fn of_runs(length: f64) -> Vec<Vec<Parameter>> {
        let tracks = [TRACK, SHORT_TRACK].map(|high| Track {
            low: 0.0,
            high,
            map: None,
            place_is_told: false,
        });
        let roughness = Roughness {
            std: 0.1,
            length,
            is_told: false,
        };
        let mut per_run = vec![Vec::new(); 2];
        add_profile(&card(), roughness, &tracks, &mut per_run);
        per_run
    }

    pub(crate) fn parameters(length: f64) -> Vec<Parameter> {
        of_runs(length).swap_remove(0)
    }

    #[test]
    fn val_the_weights_make_a_process_with_a_gaussian_correlation() {
        // Source: Higdon 2002: white noise smoothed by exp(-2 (d/l)^2) has the correlation exp(-(d/l)^2).
        let length = 0.012;
        let all = parameters(length);
        let weight_at = |node: usize| {
            let reference = FIRST_NODE + node as u32;
            let of = move |p: &Parameter| {
                let target = p.targets.iter().find(|t| t.0 == reference);
                target.map_or(0.0, |t| t.1 * p.prior_std)
            };
            all.iter().filter(|p| p.support.is_some()).map(of)
        };
        for (i, j) in [(40, 40), (40, 45), (33, 52), (20, 60), (0, 0), (0, 80)] {
            let found: f64 = weight_at(i).zip(weight_at(j)).map(|(a, b)| a * b).sum();
            let distance = TRACK * (j - i) as f64 / (COUNT - 1) as f64 / length;
            let expected = 0.01 * (-distance * distance).exp();
            assert!(
                (found - expected).abs() < 1e-5,
                "{i} {j}: {found} {expected}"
            );
        }
    }

    #[test]
    fn no_run_is_believed_smoother_than_asked_for_nor_rougher_than_its_nodes_resolve() {
        let width = |p: &Parameter| p.support.map(|(low, high)| 0.5 * (high - low) / REACH);
        let first = |run: &Vec<Parameter>| run.iter().find_map(width).unwrap();
        let untold = of_runs(0.0);
        assert!((first(&untold[0]) - NODES_A_LENGTH * TRACK / (COUNT - 1) as f64).abs() < 1e-12);
        assert!((first(&untold[1]) - 0.5 * first(&untold[0])).abs() < 1e-12);
        assert!((first(&of_runs(0.016)[1]) - 0.016).abs() < 1e-12);
    }
}
