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
use crate::diagnose::estimation::sensitivities::{Known, Linear};
use crate::diagnose::initialisation::response_spectrum;
use crate::diagnose::initialisation::starts::at as on_line;
use crate::diagnose::model::effect_card::{EffectCard, Role};
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::parameter::Kind;
use crate::diagnose::model::periodic::Line;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::is_unknown_function;
use crate::error::Error;
use crate::parallel::parallel;
use nalgebra::{DMatrix, DVector};

/// Strength at which derivatives are taken, as a share of the typical one: without any, shapes have no meaning.
const BARELY_ON: f64 = 1e-3;
/// Lines of the screen's spectrum that are tested on all data: what is worth its price there stands out of the noise's lines on a part
/// of them, but not always above all of these.
const SEEN_LINES: usize = 5;
/// Shapes that are tried, as factors on the typical one.
const SHAPES: [f64; 3] = [1.0, 0.2, 5.0];

/// What a score test promises of an effect.
pub(crate) struct Promise {
    /// Expected gain in evidence, nats.
    pub gain: f64,
    /// Expected fall of the negative logarithm of the likelihood, nats: the same without the price of what is free.
    pub fall: f64,
    /// The smaller model's optimum with the effect barely on, in the shape that promises most.
    pub start: Point,
    /// What the data would tell of its strength; `None` for what repeats.
    pub strength: Option<Strength>,
}

/// What the data tell of a strength that is none or weak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Strength {
    /// Its standard deviation, all else being free, in its unit.
    pub std: f64,
    /// Price in nats of leaving it free.
    pub occam: f64,
}

/// A hypothesis at its optimum on some segments.
pub(crate) struct At<'a> {
    /// The segments.
    pub segments: &'a [Segment],
    /// The fit to them.
    pub base: &'a FittedHypothesis,
    /// The segments linearised there.
    linear: Vec<Option<Linear>>,
}

impl<'a> At<'a> {
    /// The hypothesis of `base` at the optimum of its fit to `segments`.
    ///
    /// # Errors
    /// An FMU that can't be instantiated.
    pub fn new(
        problem: &Problem,
        segments: &'a [Segment],
        base: &'a FittedHypothesis,
    ) -> Result<Self, Error> {
        let h = &base.hypothesis;
        let places: Vec<usize> = (0..segments.len()).collect();
        let parts: Vec<&[usize]> = places.chunks(PART).collect();
        let linear = parallel(&parts, |part| {
            let some: Vec<Segment> = part.iter().map(|&k| segments[k].clone()).collect();
            let point = Point {
                states: part
                    .iter()
                    .map(|&k| base.fit.point.states[k].clone())
                    .collect(),
                stuck: part.iter().map(|&k| base.fit.point.stuck[k]).collect(),
                ..base.fit.point.clone()
            };
            let data = problem.data(&some);
            let mut predictor = problem.predictor(h)?;
            let mut fitter = Fitter::new(&mut predictor, h, &data, one_step());
            Ok(fitter.linearised_at(point))
        })?;
        Ok(Self {
            segments,
            base,
            linear: linear.into_iter().flatten().collect(),
        })
    }

    fn known(&self) -> Known<'_> {
        Known {
            hypothesis: &self.base.hypothesis,
            stuck: &self.base.fit.point.stuck,
            linear: &self.linear,
        }
    }
}

/// Segments that one thread linearises at a time: enough that an instance of the FMU is cheap beside them.
const PART: usize = 16;

/// The largest expected gain in evidence of the last effect of `choices` beside a hypothesis that lacks it, over its shapes or at
/// the strongest lines of what repeats; `None` where nothing switches it off by degrees. Lines are looked for on the segments of
/// `screen`, since a spectrum takes hundreds of motions of each, and tested on those of `at`.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(crate) fn promise(
    problem: &Problem,
    choices: &[Choice],
    screen: &At,
    at: &At,
) -> Result<Option<Promise>, Error> {
    let card = &problem.catalogue[choices.last().expect("one more effect").effect];
    let h = problem.hypothesis(choices)?;
    let data = problem.data(at.segments);
    let mut predictor = problem.predictor(&h)?;
    let from_base = widen(at.base, &h, &Point::centre(&h, at.segments));
    if card.repeats() {
        let line = best_line(problem, &h, card, &mut predictor, (screen, at, &from_base));
        let lines = response_spectrum::independent_lines(card, at.segments);
        let fall = line.as_ref().map_or(0.0, |line| line.gain);
        let start = line.and_then(|line| on_line(&h, card, &from_base, &line));
        return Ok(Some(Promise {
            gain: gain_of_line(fall, lines, problem.fitted_runs()),
            fall,
            start: start.unwrap_or(from_base),
            strength: None,
        }));
    }
    if is_unknown_function(&card.id) {
        return Ok(promise_of_curve(
            &h,
            card,
            &mut predictor,
            (&data, at),
            &from_base,
        ));
    }
    let index = |i: usize| h.shared_index(&format!("{}.{}", card.id, card.parameters[i].name));
    let Some(strength) = card.switch() else {
        return Ok(None);
    };
    let Some(c) = index(strength) else {
        return Ok(None);
    };
    let is_other_shape = |i: &usize| *i != strength && card.parameters[*i].role == Role::Shape;
    let shapes: Vec<usize> = (0..card.parameters.len()).filter(is_other_shape).collect();
    let barely_on = |base: &FittedHypothesis, segments: &[Segment], factor: f64| {
        let mut point = widen(base, &h, &Point::centre(&h, segments));
        let typical = card.parameters[strength].typical;
        point.shared[c] = h.shared[c].clamp(h.shared[c].position(BARELY_ON * typical));
        for &i in &shapes {
            if let Some(j) = index(i) {
                let value = factor * card.parameters[i].typical;
                point.shared[j] = h.shared[j].clamp(h.shared[j].position(value));
            }
        }
        point
    };
    let parameter = &h.shared[c];
    let p = &card.parameters[strength];
    let mut test = |of: &At, factor: f64| {
        let point = barely_on(of.base, of.segments, factor);
        let data = problem.data(of.segments);
        let mut fitter = Fitter::new(&mut predictor, &h, &data, one_step());
        let (mut matrix, mut gradient) = fitter.reduced_beside(of.known(), point.clone());
        let u = point.shared[c];
        // What is believed of it beforehand counts in the price alone.
        let precision = parameter.prior_std.powi(-2);
        matrix[(c, c)] -= precision;
        gradient[c] += precision * (u - parameter.position(parameter.prior));
        let std = (p.max - p.min) / 12.0_f64.sqrt() / parameter.slope(u);
        let found = gain(&matrix, &gradient, c, std, p.min >= 0.0)?;
        Some(Promise {
            gain: found.gain,
            fall: found.gain + found.occam,
            start: point,
            strength: Some(Strength {
                std: found.std * parameter.slope(u).abs(),
                occam: found.occam,
            }),
        })
    };
    if shapes.is_empty() {
        return Ok(test(at, 1.0));
    }
    let mut best: Option<(f64, Promise)> = None;
    for factor in SHAPES {
        if let Some(found) = test(screen, factor)
            && best.as_ref().is_none_or(|(_, b)| found.gain > b.gain)
        {
            best = Some((factor, found));
        }
    }
    // The shape that promises most on the screen is tested on all.
    let is_all = std::ptr::eq(screen.base, at.base);
    Ok(match best {
        Some((factor, _)) if !is_all => test(at, factor),
        best => best.map(|(_, found)| found),
    })
}

/// Options of the one step that a score test is.
fn one_step() -> FitOptions {
    FitOptions {
        robust: false,
        stride: 1,
        ..FitOptions::search(1)
    }
}

/// The same for the curve of an unknown function, over its time constants: all its values together.
fn promise_of_curve(
    h: &Hypothesis,
    card: &EffectCard,
    predictor: &mut Predictor,
    (data, at): (&Observations, &At),
    from_base: &Point,
) -> Option<Promise> {
    let of_kind = |kind: Kind| {
        let all = h.shared.iter().enumerate();
        all.filter(move |(_, p)| p.kind == kind && p.name.starts_with(&card.id))
            .map(|(i, _)| i)
    };
    let curve: Vec<usize> = of_kind(Kind::Latent).collect();
    let shapes: Vec<usize> = of_kind(Kind::Shape).collect();
    let mut best: Option<Promise> = None;
    for factor in SHAPES {
        let mut point = from_base.clone();
        point.shared[*curve.first()?] = BARELY_ON;
        for &i in &shapes {
            let parameter = &h.shared[i];
            point.shared[i] = parameter.clamp(parameter.position(factor * parameter.prior));
        }
        let mut fitter = Fitter::new(predictor, h, data, one_step());
        let (matrix, gradient) = fitter.reduced_beside(at.known(), point.clone());
        if let Some((gain, fall)) = gain_of_curve(matrix, gradient, &curve)
            && best.as_ref().is_none_or(|b| gain > b.gain)
        {
            best = Some(Promise {
                gain,
                fall,
                start: point,
                strength: None,
            });
        }
        if shapes.is_empty() {
            break;
        }
    }
    best
}

/// Expected gain in evidence and fall of the objective by constants `curve` with standard normal beliefs, which `matrix` and
/// `gradient` hold already: `1/2 g' (H + 1)^-1 g - 1/2 ln det(H + 1)`, all others projected out.
fn gain_of_curve(
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    curve: &[usize],
) -> Option<(f64, f64)> {
    let others: Vec<usize> = (0..matrix.nrows()).filter(|i| !curve.contains(i)).collect();
    let inner = matrix.select_rows(&others).select_columns(&others);
    let across = matrix.select_rows(&others).select_columns(curve);
    let own = matrix.select_rows(curve).select_columns(curve);
    let factor = inner.cholesky()?;
    let information = own - across.tr_mul(&factor.solve(&across));
    let score =
        gradient.select_rows(curve) - across.tr_mul(&factor.solve(&gradient.select_rows(&others)));
    let factor = information.cholesky()?;
    let fall = 0.5 * score.dot(&factor.solve(&score));
    let occam: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
    Some((fall - occam, fall))
}

/// The line of an effect that repeats which gains most on the segments tested, of the strongest ones of the screen.
fn best_line(
    problem: &Problem,
    h: &Hypothesis,
    card: &EffectCard,
    predictor: &mut Predictor,
    (screen, at, from_base): (&At, &At, &Point),
) -> Option<Line> {
    let seen = problem.data(screen.segments);
    let point = widen(screen.base, h, &Point::centre(h, screen.segments));
    let lines =
        response_spectrum::lines(predictor, h, card, &seen, &point, STRIDE, SEEN_LINES, None);
    let data = problem.data(at.segments);
    let tested = lines.iter().filter_map(|line| {
        let near = Some(line.value);
        let again = response_spectrum::lines(predictor, h, card, &data, from_base, 1, 1, near);
        again.into_iter().next()
    });
    tested.max_by(|a, b| a.gain.total_cmp(&b.gain))
}

/// Whether a score test can speak of an effect: something switches it off by degrees, or it repeats.
pub(crate) fn is_testable(card: &EffectCard) -> bool {
    card.repeats() || card.switch().is_some()
}

/// Expected gain in evidence of a line that lowers the objective by `fall`, found among so many independent ones, with a phase
/// in each of so many runs: amplitude and phases are each known to `1/sqrt(2 fall)` of themselves.
fn gain_of_line(fall: f64, lines: f64, runs: usize) -> f64 {
    let constants = 1.0 + runs as f64;
    fall - 0.5 * constants * (2.0 * fall / constants).ln_1p() - lines.max(1.0).ln()
}

/// Expected gain of a strength, its standard deviation on its own scale and the price of leaving it free.
#[derive(Debug, Clone, Copy)]
struct Gain {
    gain: f64,
    std: f64,
    occam: f64,
}

/// That of parameter `c` with the belief `std`, all others projected out; one that can't be negative gains nothing where the
/// data pull it there. `None` where the others are not determined, or nothing tells of it.
fn gain(
    matrix: &DMatrix<f64>,
    gradient: &DVector<f64>,
    c: usize,
    std: f64,
    is_positive: bool,
) -> Option<Gain> {
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
    let score = if is_positive { score.max(0.0) } else { score };
    let occam = 0.5 * (std * std * information.max(0.0)).ln_1p();
    (information > 0.0).then(|| Gain {
        gain: 0.5 * score * score / (information + std.powi(-2)) - occam,
        std: information.sqrt().recip(),
        occam,
    })
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
        let found = gain(&matrix, &gradient, 1, std[1], false).unwrap().gain;
        assert!(
            (found - expected).abs() < 1e-9 * expected.abs(),
            "{found} {expected}"
        );
    }

    /// Source: Bayes' theorem for a straight line with known noise, evidence of two waves with standard normal weights beside a
    /// level against the level alone.
    #[test]
    fn val_the_gain_of_a_curve_is_the_evidence_of_a_linear_model() {
        let n = 40;
        let x: Vec<f64> = (0..n).map(|i| f64::from(i) / 10.0).collect();
        let data = DVector::from_fn(n as usize, |i, _| 1.0 + 0.8 * x[i].sin() - 0.3 * x[i].cos());
        let design = DMatrix::from_fn(n as usize, 3, |i, j| match j {
            0 => 1.0,
            1 => x[i].sin(),
            _ => x[i].cos(),
        });
        let level_std = 2.0_f64;
        let evidence = |columns: usize| {
            let part = design.columns(0, columns).into_owned();
            let mut prior = DMatrix::identity(columns, columns);
            prior[(0, 0)] = level_std.powi(2);
            let covariance =
                DMatrix::identity(n as usize, n as usize) + &part * prior * part.transpose();
            let factor = covariance.cholesky().unwrap();
            let half_log: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
            -0.5 * data.dot(&factor.solve(&data)) - half_log
        };
        // At the optimum of the level alone.
        let level = design.column(0).dot(&data) / (f64::from(n) + level_std.powi(-2));
        let rest = &data - design.column(0) * level;
        let beliefs = DVector::from_vec(vec![level_std.powi(-2), 1.0, 1.0]);
        let matrix = design.tr_mul(&design) + DMatrix::from_diagonal(&beliefs);
        let mut gradient = design.tr_mul(&rest);
        gradient[0] -= level * level_std.powi(-2);
        let (found, fall) = gain_of_curve(matrix, gradient, &[1, 2]).unwrap();
        let expected = evidence(3) - evidence(1);
        assert!(
            (found - expected).abs() < 1e-9 * expected.abs(),
            "{found} {expected}"
        );
        assert!(fall > found);
    }
}
