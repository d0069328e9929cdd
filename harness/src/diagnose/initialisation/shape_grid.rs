//! Values of an effect's shape constants from which its fits start.

use crate::diagnose::model::library::File;
use crate::diagnose::model::problem::Problem;
use crate::fmu::effect_card::EffectParameter;

/// Factors on the typical value of one shape constant, and of each of several.
const OF_ONE: [f64; 2] = [0.2, 5.0];
const OF_EACH: [f64; 2] = [0.3, 3.0];

/// Ratio from one threshold that is tried to the next. A fit comes down to a gap from half as much again, and not up to it: where the
/// spring acts too early, segments are lost that were met (a gap of 4 mm is found from 5 mm, from 3 and 6.6 mm it is not).
const THRESHOLD_RATIO: f64 = std::f64::consts::SQRT_2;
/// The first of them, as a share of what the tip reaches: what begins farther is hardly touched.
const FIRST_THRESHOLD: f64 = 0.95;
/// How many are tried: down to a sixth of what the tip reaches.
const THRESHOLDS: i32 = 6;

/// Points of the shape parameters `shapes` of an effect to start from: the typical one, and others spread over the plausible range. A
/// deflection beyond which something else holds, alone of its kind, is tried where the tip comes by, too.
pub(crate) fn shape_grid(problem: &Problem, effect: usize, shapes: &[usize]) -> Vec<Vec<f64>> {
    let card = &problem.catalogue[effect];
    let parameters = &card.parameters;
    let typical: Vec<f64> = shapes.iter().map(|&i| parameters[i].typical).collect();
    let mut grid = vec![typical.clone()];
    let factors: &[f64] = match shapes.len() {
        0 => &[],
        1 => &OF_ONE,
        _ => &OF_EACH,
    };
    for (axis, &i) in shapes.iter().enumerate() {
        for factor in factors {
            let value = typical[axis] * factor;
            if value >= parameters[i].min && value <= parameters[i].max {
                let mut point = typical.clone();
                point[axis] = value;
                grid.push(point);
            }
        }
    }
    if let [only] = shapes
        && card.states.is_empty()
        && is_threshold(&card.id, &parameters[*only])
    {
        grid.extend(thresholds(reach(problem), &parameters[*only]));
    }
    grid
}

/// Whether a shape constant is a length that the formula of a library's effect compares with the deflection; that of an effect with states
/// may count from where the motion turned.
fn is_threshold(id: &str, shape: &EffectParameter) -> bool {
    shape.unit == "m" && File::of_library(id).is_some_and(|file| file.argument == "w")
}

/// Largest deflection of the tip in m, smoothed.
fn reach(problem: &Problem) -> f64 {
    let smoothed = problem.smoothings.iter().map(|s| &s.stick_slip.smoothed);
    let all = smoothed.flat_map(|s| &s.displacement);
    all.filter(|w| w.is_finite())
        .fold(0.0, |a, w| a.max(w.abs()))
}

/// Thresholds in m below what is reached, within the bounds.
fn thresholds(reach: f64, shape: &EffectParameter) -> Vec<Vec<f64>> {
    let all = (0..THRESHOLDS).map(|i| FIRST_THRESHOLD * reach / THRESHOLD_RATIO.powi(i));
    let within = all.filter(|g| (shape.min..=shape.max).contains(g));
    within.map(|g| vec![g]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmu::effect_card::Role;

    fn gap() -> EffectParameter {
        EffectParameter {
            name: "g".into(),
            description: String::new(),
            reference: 0,
            unit: "m".into(),
            start: 0.0,
            typical: 5e-4,
            min: 1e-4,
            max: 5e-3,
            role: Role::Shape,
        }
    }

    #[test]
    fn thresholds_are_tried_where_the_tip_comes_by() {
        let found = thresholds(2e-3, &gap());
        assert_eq!(found.len(), 6, "{found:?}");
        assert!((found[0][0] - 1.9e-3).abs() < 1e-15, "{found:?}");
        assert!((found[2][0] - 0.95e-3).abs() < 1e-15, "{found:?}");
        // Within the bounds of 0.1 and 5 mm alone.
        assert_eq!(thresholds(8e-3, &gap()).len(), 4);
        assert!(thresholds(1e-4, &gap()).is_empty());
    }

    #[test]
    fn what_the_formula_compares_with_the_deflection_is_a_threshold() {
        assert!(is_threshold("term_stop", &gap()));
        assert!(is_threshold("term_clamp_clearance", &gap()));
        assert!(!is_threshold("term_slip_distance_lag", &gap()));
        let mut time = gap();
        time.unit = "s".into();
        assert!(!is_threshold("term_stop", &time));
    }
}
