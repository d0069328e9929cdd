//! What a run's own parameters make of the friction along the belt, and back.

use crate::diagnose::model::belt_profile::{PLACES, REACH, kernel};
use crate::diagnose::model::parameter::{Kind, Parameter};
use crate::fmu::effect_card::EffectCard;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Values of the FMU's nodes, by reference and so in their order, that a run has with these positions of its own parameters; empty
/// without a profile.
fn at_nodes(parameters: &[Parameter], own: &[f64]) -> BTreeMap<u32, f64> {
    let mut values = BTreeMap::new();
    let all = parameters.iter().zip(own);
    for (parameter, position) in all.filter(|(p, _)| p.support.is_some()) {
        for (reference, value) in parameter.settings(*position) {
            *values.entry(reference).or_insert(0.0) += value;
        }
    }
    values
}

/// What a run has of its own by name, values along the belt as the FMU has them.
pub(crate) fn named_values(
    catalogue: &[EffectCard],
    parameters: &[Parameter],
    own: &[f64],
) -> Vec<(String, f64)> {
    let all = parameters.iter().zip(own);
    let plain = all.filter(|(p, _)| p.support.is_none());
    let plain = plain.map(|(p, position)| (p.name.clone(), p.value(*position)));
    let name = |reference: u32| {
        let mut of_effects = catalogue.iter().flat_map(|effect| {
            let id = &effect.id;
            effect.parameters.iter().map(move |p| (id, p))
        });
        let (id, node) = of_effects.find(|(_, p)| p.reference == reference)?;
        Some(format!("{id}.{}", node.name))
    };
    let nodes = at_nodes(parameters, own).into_iter();
    let nodes = nodes.filter_map(|(reference, value)| Some((name(reference)?, value)));
    plain.chain(nodes).collect()
}

/// Places in m and values of the profile that a run has with these positions of its own parameters; empty without one.
pub(crate) fn values_along(parameters: &[Parameter], own: &[f64]) -> Vec<(f64, f64)> {
    let local = parameters.iter().find(|p| p.support.is_some());
    let id = local.and_then(|p| p.name.rsplit_once('.'));
    let place = |name: &str| {
        let name = format!("{}.{name}", id?.0);
        let i = parameters.iter().position(|p| p.name == name)?;
        Some(parameters[i].value(own[i]))
    };
    let [Some(length), Some(start), Some(count)] = PLACES.map(place) else {
        return Vec::new();
    };
    let spacing = length / (count - 1.0);
    let values = at_nodes(parameters, own).into_values().enumerate();
    values
        .map(|(i, value)| (start + spacing * i as f64, value))
        .collect()
}

/// Whether the values along the belt of two lists of a run's own parameters lie at the same places.
pub(crate) fn have_same_places(one: &[Parameter], other: &[Parameter]) -> bool {
    let places = |all: &[Parameter]| all.iter().filter_map(|p| p.support).collect::<Vec<_>>();
    places(one) == places(other)
}

/// Error of a profile (1) that is followed, against which its weights are kept small.
const CLOSE: f64 = 1e-5;

/// Sets the values along the belt among a run's own parameters to those of a profile with these places in m and values.
pub(crate) fn follow_profile(parameters: &[Parameter], profile: &[(f64, f64)], own: &mut [f64]) {
    let is_local = |&i: &usize| parameters[i].support.is_some();
    let local: Vec<usize> = (0..own.len()).filter(is_local).collect();
    let (Some(&first), false) = (local.first(), profile.is_empty()) else {
        return;
    };
    let middle = |i: usize| {
        let (low, high) = parameters[i].support.expect("chosen by it");
        (0.5 * (low + high), high - low)
    };
    let values = match parameters[first].kind {
        Kind::Node => local.iter().map(|&i| near(profile, middle(i).0)).collect(),
        _ => {
            let design = DMatrix::from_fn(profile.len(), local.len(), |row, c| {
                let (at, width) = middle(local[c]);
                kernel(2.0 * REACH * (profile[row].0 - at) / width)
            });
            let values = DVector::from_iterator(profile.len(), profile.iter().map(|p| p.1));
            let ridge = (CLOSE / parameters[first].prior_std).powi(2);
            let mut matrix = design.tr_mul(&design);
            (0..local.len()).for_each(|i| matrix[(i, i)] += ridge);
            let factor = matrix.cholesky().expect("positive definite by the ridge");
            factor.solve(&design.tr_mul(&values)).as_slice().to_vec()
        }
    };
    for (i, value) in local.into_iter().zip(values) {
        own[i] = parameters[i].clamp(value);
    }
}

/// Value of a profile at its place nearest to one in m.
fn near(profile: &[(f64, f64)], at: f64) -> f64 {
    let distance = |p: &&(f64, f64)| (p.0 - at).abs();
    let nearest = profile
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.map_or(0.0, |p| p.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::model::belt_profile::WEIGHTS_A_LENGTH;
    use crate::diagnose::model::belt_profile::tests::{
        COUNT, SHORT_TRACK, TRACK, card, of_runs, parameters,
    };

    /// Positions at which nothing is known.
    fn believed(parameters: &[Parameter]) -> Vec<f64> {
        parameters.iter().map(|p| p.prior).collect()
    }

    #[test]
    fn a_profile_is_followed_by_weights_of_another_correlation_length() {
        let (long, short) = (parameters(0.016), parameters(0.008));
        let mut known = believed(&long);
        for (i, value) in known.iter_mut().enumerate().skip(PLACES.len()) {
            *value = 0.1 * (1.7 * i as f64).sin();
        }
        let profile = values_along(&long, &known);
        assert_eq!(profile.len(), COUNT);
        assert!((profile[COUNT - 1].0 - 0.08).abs() < 1e-12);
        let mut own = believed(&short);
        follow_profile(&short, &profile, &mut own);
        for (there, here) in values_along(&short, &own).iter().zip(&profile) {
            assert!((there.1 - here.1).abs() < 1e-4, "{there:?} {here:?}");
        }
        assert!(!have_same_places(&long, &short));
        assert!(have_same_places(&long, &parameters(0.016)));
    }

    #[test]
    fn values_are_named_as_the_fmu_has_them() {
        let per_run = of_runs(0.016);
        assert!(per_run[1].len() < per_run[0].len());
        for (parameters, high) in per_run.iter().zip([TRACK, SHORT_TRACK]) {
            let mut own = believed(parameters);
            own[PLACES.len() + 6] = 0.1;
            let named = named_values(&[card()], parameters, &own);
            assert_eq!(named.len(), PLACES.len() + COUNT);
            assert_eq!(named[0], ("profile.length".to_owned(), high));
            let along = values_along(parameters, &own);
            for (i, (_, value)) in along.iter().enumerate() {
                let name = format!("profile.node[{}]", i + 1);
                assert!(named.contains(&(name, *value)));
            }
            // The seventh weight lies within the track, the first six before it.
            let (peak, _) = along.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            let expected = (6.0 / WEIGHTS_A_LENGTH - REACH) * 0.016;
            assert!((peak - expected).abs() <= 0.5 * high / (COUNT - 1) as f64);
        }
    }
}
