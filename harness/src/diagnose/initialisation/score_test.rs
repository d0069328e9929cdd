//! Score test: what evidence an effect could gain beside a model at its optimum, without fitting it.
//!
//! At the optimum of the smaller model the effect is put barely on. With g and H the score of its strength and the
//! information on it, all nuisances and start states projected out (Schur complement), and s the standard deviation of
//! the belief in the strength, the evidence gained is to first order
//!
//! ```text
//! 1/2 g^2 / (H + 1/s^2) - 1/2 ln(1 + s^2 H)
//! ```
//!
//! Holds where the smaller model is down to the noise, so that the effect can only be weak. Sources: Rao, Proc. Camb. Phil.
//! Soc. 44 (1948) 50; the price is that of Laplace's approximation.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::{FitOptions, STRIDE};
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::nesting::widen;
use crate::diagnose::initialisation::response_spectrum;
use crate::diagnose::initialisation::starts::at;
use crate::diagnose::model::effect_card::{EffectCard, Role};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::error::Error;
use nalgebra::{DMatrix, DVector};

/// Strength at which derivatives are taken, as a share of the typical one: without any, shapes have no meaning.
const BARELY_ON: f64 = 1e-3;
/// Shapes that are tried, as factors on the typical one.
const SHAPES: [f64; 3] = [1.0, 0.2, 5.0];

/// What a score test promises of an effect.
pub(crate) struct Promise {
    /// Expected gain in evidence, nats.
    pub gain: f64,
    /// The smaller model's optimum with the effect barely on, in the shape that promises most.
    pub start: Point,
}

/// The largest expected gain in evidence of the last effect of `choices` beside `base`, over its shapes or at the strongest
/// line of what repeats; `None` where nothing switches it off by degrees.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(crate) fn promise(
    problem: &Problem,
    segments: &[Segment],
    choices: &[Choice],
    base: &FittedHypothesis,
) -> Result<Option<Promise>, Error> {
    let card = &problem.catalogue[choices.last().expect("one more effect").effect];
    let h = problem.hypothesis(choices)?;
    let data = problem.data(segments);
    let mut predictor = problem.predictor(&h)?;
    let from_base = widen(base, &h, &Point::centre(&h, segments));
    if card.find_role(Role::Phase).is_some() {
        let point = &from_base;
        let lines =
            response_spectrum::lines(&mut predictor, &h, card, &data, point, STRIDE, 1, None);
        let at_line = lines.first().map(|line| {
            let lines = response_spectrum::independent_lines(card, segments);
            let gain = gain_of_line(line.gain, lines, problem.fitted_runs());
            let start = at(&h, card, &from_base, line).unwrap_or(from_base.clone());
            Promise { gain, start }
        });
        let start = from_base.clone();
        let gain = f64::NEG_INFINITY;
        return Ok(Some(at_line.unwrap_or(Promise { gain, start })));
    }
    let index = |i: usize| h.shared_index(&format!("{}.{}", card.id, card.parameters[i].name));
    let Some(strength) = strength(card) else {
        return Ok(None);
    };
    let Some(c) = index(strength) else {
        return Ok(None);
    };
    let is_other_shape = |i: usize| i != strength && card.parameters[i].role == Role::Shape;
    let shapes: Vec<usize> = (0..card.parameters.len())
        .filter(|&i| is_other_shape(i))
        .collect();
    let mut best: Option<Promise> = None;
    for factor in SHAPES {
        let mut point = from_base.clone();
        let typical = card.parameters[strength].typical;
        point.shared[c] = h.shared[c].clamp(h.shared[c].position(BARELY_ON * typical));
        for &i in &shapes {
            if let Some(j) = index(i) {
                let value = factor * card.parameters[i].typical;
                point.shared[j] = h.shared[j].clamp(h.shared[j].position(value));
            }
        }
        let mut fitter = Fitter::new(&mut predictor, &h, &data, FitOptions::search(1));
        if let Some((mut matrix, mut gradient)) = fitter.reduced_at(point.clone()) {
            let (parameter, u) = (&h.shared[c], point.shared[c]);
            // What is believed of it beforehand counts in the price alone.
            let precision = parameter.prior_std.powi(-2);
            matrix[(c, c)] -= precision;
            gradient[c] += precision * (u - parameter.position(parameter.prior));
            let p = &card.parameters[strength];
            let std = (p.max - p.min) / 12.0_f64.sqrt() / parameter.slope(u);
            let gain = gain(&matrix, &gradient, c, std);
            if let Some(gain) = gain.filter(|g| best.as_ref().is_none_or(|b| *g > b.gain)) {
                best = Some(Promise { gain, start: point });
            }
        }
        if shapes.is_empty() {
            break;
        }
    }
    Ok(best)
}

/// The parameter that switches an effect off by degrees: its amplitude, or its only constant, a time that goes to zero.
fn strength(card: &EffectCard) -> Option<usize> {
    let shapes = || {
        let all = card.parameters.iter().enumerate();
        all.filter(|(_, p)| p.role == Role::Shape)
    };
    if card.find_role(Role::Node).is_some() {
        return None;
    }
    let time = || match (shapes().count(), shapes().next()) {
        (1, Some((i, p))) if p.unit == "s" => Some(i),
        _ => None,
    };
    card.find_role(Role::Amplitude).or_else(time)
}

/// Expected gain in evidence of a line that lowers the objective by `fall`, found among so many independent ones, with a phase
/// in each of so many runs: amplitude and phases are each known to `1/sqrt(2 fall)` of themselves.
fn gain_of_line(fall: f64, lines: f64, runs: usize) -> f64 {
    let constants = 1.0 + runs as f64;
    fall - 0.5 * constants * (2.0 * fall / constants).ln_1p() - lines.max(1.0).ln()
}

/// Expected gain of parameter `c` with the belief `std`, all others projected out; `None` where the others are not determined.
fn gain(matrix: &DMatrix<f64>, gradient: &DVector<f64>, c: usize, std: f64) -> Option<f64> {
    let others: Vec<usize> = (0..matrix.nrows()).filter(|&i| i != c).collect();
    let inner = matrix.select_rows(&others).select_columns(&others);
    let scale = DVector::from_iterator(
        others.len(),
        inner.diagonal().iter().map(|d| d.sqrt().recip()),
    );
    let scaled = DMatrix::from_fn(others.len(), others.len(), |i, j| {
        inner[(i, j)] * scale[i] * scale[j]
    });
    let factor = scaled.cholesky()?;
    let pick = |v: DVector<f64>| v.select_rows(&others).component_mul(&scale);
    let across = pick(matrix.column(c).into_owned());
    let solved = factor.solve(&across);
    let information = matrix[(c, c)] - across.dot(&solved);
    let score = gradient[c] - solved.dot(&pick(gradient.clone()));
    let price = 0.5 * (std * std * information.max(0.0)).ln_1p();
    (information > 0.0).then(|| 0.5 * score * score / (information + std.powi(-2)) - price)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Source: Bayes' theorem for a straight line with known noise, evidence of slope and level against level alone.
    #[test]
    fn val_the_gain_is_the_evidence_of_a_linear_model() {
        let n = 40;
        let x: Vec<f64> = (0..n).map(|i| f64::from(i) / 10.0).collect();
        let y: Vec<f64> = x.iter().map(|x| 1.0 + 0.3 * x + (7.0 * x).sin()).collect();
        let design = DMatrix::from_fn(n as usize, 2, |i, j| if j == 0 { 1.0 } else { x[i] });
        let std = [2.0, 0.7];
        let believed =
            DMatrix::from_diagonal(&DVector::from_vec(vec![std[0] * std[0], std[1] * std[1]]));
        let data = DVector::from_vec(y);
        let evidence = |columns: usize| {
            let part = design.columns(0, columns).into_owned();
            let prior = believed.view((0, 0), (columns, columns)).into_owned();
            let covariance =
                DMatrix::identity(n as usize, n as usize) + &part * prior * part.transpose();
            let factor = covariance.cholesky().unwrap();
            let half_log: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
            -0.5 * data.dot(&factor.solve(&data)) - half_log
        };
        // At the optimum of the level alone.
        let level = design.column(0).dot(&data) / (f64::from(n) + std[0].powi(-2));
        let rest = &data - design.column(0) * level;
        let prior = DMatrix::from_diagonal(&DVector::from_vec(vec![std[0].powi(-2), 1e-12]));
        let matrix = design.tr_mul(&design) + prior;
        let mut gradient = design.tr_mul(&rest);
        gradient[0] -= level * std[0].powi(-2);
        let expected = evidence(2) - evidence(1);
        let found = gain(&matrix, &gradient, 1, std[1]).unwrap();
        assert!(
            (found - expected).abs() < 1e-9 * expected.abs(),
            "{found} {expected}"
        );
    }
}
