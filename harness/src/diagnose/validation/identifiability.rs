//! What the data cannot separate: directions in which a fit has learned next to nothing beyond what was believed before.
//!
//! With C the covariance of the parameters that all runs share and S their beliefs' standard deviations, `S^-1 C S^-1` has
//! eigenvalues between 0 (the data decide) and 1 (belief alone). An eigenvector of a large eigenvalue names the
//! constants that act only together there. Flat beliefs (shapes, strengths) count with the standard deviation of their
//! range. Source: Raue et al., Bioinformatics 25 (2009) 1923, for the notion; the eigenvectors are those of the linearised
//! model, so a curved valley is seen at its bottom only.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::model::unknown_function::is_unknown_function;
use nalgebra::DMatrix;
use serde::Serialize;
use std::collections::BTreeMap;

/// Share of the variance believed that must be left for a direction to count as not determined: more belief than data.
const LEFT: f64 = 0.5;
/// Smallest share of a direction's length with which a constant is named: less than a tenth of its square.
const NAMED: f64 = 0.3;

/// A direction that the data do not determine.
#[derive(Debug, Clone, Serialize)]
pub struct Undetermined {
    /// The constants named in it.
    pub parameters: Vec<String>,
    /// The same in words.
    pub statement: String,
    /// Its components: by constant, in standard deviations of what is believed of it; length 1 with those left out.
    pub combination: BTreeMap<String, f64>,
    /// Share of the variance believed that is left.
    pub variance_left: f64,
}

/// All such directions of a fit, the least determined first; empty without a covariance.
pub fn undetermined(fitted: &FittedHypothesis) -> Vec<Undetermined> {
    let Some(covariance) = &fitted.fit.covariance else {
        return Vec::new();
    };
    let parameters = &fitted.hypothesis.shared;
    let free: Vec<usize> = (0..parameters.len())
        .filter(|&i| parameters[i].prior_std > 0.0)
        .collect();
    let scaled = DMatrix::from_fn(free.len(), free.len(), |i, j| {
        let (a, b) = (free[i], free[j]);
        covariance[(a, b)] / (parameters[a].volume_std() * parameters[b].volume_std())
    });
    let names: Vec<&str> = free.iter().map(|&i| parameters[i].name.as_str()).collect();
    directions(scaled, &names)
}

fn directions(scaled: DMatrix<f64>, names: &[&str]) -> Vec<Undetermined> {
    if scaled.iter().any(|v| !v.is_finite()) {
        return Vec::new();
    }
    let eigen = scaled.symmetric_eigen();
    let mut found: Vec<Undetermined> = (0..names.len())
        .filter(|&k| eigen.eigenvalues[k] > LEFT)
        .map(|k| {
            let vector = eigen.eigenvectors.column(k);
            let named = names.iter().zip(vector.iter());
            let named = named.filter(|(_, c)| c.abs() >= NAMED);
            let combination: BTreeMap<String, f64> =
                named.map(|(n, c)| ((*n).to_owned(), *c)).collect();
            let parameters: Vec<String> = combination.keys().cloned().collect();
            Undetermined {
                statement: match parameters.as_slice() {
                    [one] => format!("{one} is not determined"),
                    many => format!("{} act only together", many.join(", ")),
                },
                parameters,
                combination,
                variance_left: eigen.eigenvalues[k].min(1.0),
            }
        })
        .filter(|u| !u.combination.is_empty())
        .collect();
    found.sort_by(|a, b| b.variance_left.total_cmp(&a.variance_left));
    found
}

/// What a constant is called in words: the latent values of an unknown function are its curve.
fn called(name: &str) -> String {
    match name.split_once('.') {
        Some((id, _)) if is_unknown_function(id) => format!("the curve {id}"),
        _ => name.to_owned(),
    }
}

/// The directions in words; `None` where the data determine all. What the data leave of a curve alone is in the curve's own
/// standard deviations.
pub fn in_words(found: &[Undetermined]) -> Option<String> {
    let mut told: Vec<String> = Vec::new();
    for undetermined in found {
        let mut names: Vec<String> = undetermined.parameters.iter().map(|n| called(n)).collect();
        names.dedup();
        let is_curve = |name: &String| name.starts_with("the curve ");
        let statement = match names.as_slice() {
            all if all.iter().all(is_curve) => continue,
            [one] => format!("{one} is not determined"),
            many => format!("{} act only together", many.join(", ")),
        };
        if !told.contains(&statement) {
            told.push(statement);
        }
    }
    (!told.is_empty()).then(|| {
        format!(
            "The data leave more than half of what was believed before: {}. These values are those believed, not measured.",
            told.join("; ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_constants_that_only_their_sum_shows_are_named_together() {
        // Beliefs of unit variance, and a sum measured with variance 0.01: closed form of the posterior.
        let s = 1.0 / (2.0 + 0.01);
        let scaled =
            DMatrix::from_row_slice(3, 3, &[1.0 - s, -s, 0.0, -s, 1.0 - s, 0.0, 0.0, 0.0, 0.001]);
        let found = directions(scaled, &["a", "b", "c"]);
        assert_eq!(found.len(), 1);
        let names: Vec<&str> = found[0].combination.keys().map(String::as_str).collect();
        assert_eq!(names, ["a", "b"]);
        assert!((found[0].variance_left - 1.0).abs() < 1e-9);
        assert!(in_words(&found).unwrap().contains("a, b act only together"));
        assert_eq!(in_words(&[]), None);
    }

    #[test]
    fn a_curve_is_named_as_one_and_what_is_left_of_it_alone_is_not_told() {
        let of = |names: &[&str]| Undetermined {
            parameters: names.iter().map(|n| (*n).to_owned()).collect(),
            statement: String::new(),
            combination: BTreeMap::new(),
            variance_left: 0.9,
        };
        let curve = ["term_unknown_belt_time.z_1", "term_unknown_belt_time.z_4"];
        assert_eq!(in_words(&[of(&curve)]), None);
        let level = of(&["friction.mu_0", curve[0], curve[1]]);
        let told = in_words(&[level.clone(), of(&curve), level]).unwrap();
        let once =
            "before: friction.mu_0, the curve term_unknown_belt_time act only together. These";
        assert!(told.contains(once), "{told}");
    }
}
