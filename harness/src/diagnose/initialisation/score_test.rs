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

/// What a score test found of an effect on some segments, and where to look on others.
pub(crate) struct Lead {
    /// What it promises there; `None` where nothing tells of it.
    pub promise: Option<Promise>,
    /// The strongest lines there of what repeats.
    lines: Vec<Line>,
    /// The shape that promises most, as a factor on the typical one.
    shape: f64,
}

/// The last effect of `choices` beside a hypothesis that lacks it: in the shape, or at the line of what repeats, that promises
/// most. `None` where nothing switches it off by degrees.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(crate) fn look(problem: &Problem, choices: &[Choice], at: &At) -> Result<Option<Lead>, Error> {
    let h = problem.hypothesis(choices)?;
    let Some(mut test) = ScoreTest::new(problem, &h)? else {
        return Ok(None);
    };
    if test.card.repeats() {
        let lines = test.lines(at);
        let promise = Some(test.of_lines(&lines, at));
        let shape = SHAPES[0];
        return Ok(Some(Lead {
            promise,
            lines,
            shape,
        }));
    }
    let tried = if test.shapes().is_empty() {
        1
    } else {
        SHAPES.len()
    };
    let mut lead = Lead {
        promise: None,
        lines: Vec::new(),
        shape: SHAPES[0],
    };
    for shape in SHAPES.into_iter().take(tried) {
        let found = test.of_shape(shape, at);
        let gain = |promise: &Option<Promise>| promise.as_ref().map(|p| p.gain);
        if gain(&found) > gain(&lead.promise) {
            (lead.promise, lead.shape) = (found, shape);
        }
    }
    Ok(Some(lead))
}

/// The same on other segments, where `lead` points: a spectrum takes hundreds of motions of each segment, so that lines are
/// looked for on a part of them.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(crate) fn follow(
    problem: &Problem,
    choices: &[Choice],
    lead: &Lead,
    at: &At,
) -> Result<Option<Promise>, Error> {
    let h = problem.hypothesis(choices)?;
    let Some(mut test) = ScoreTest::new(problem, &h)? else {
        return Ok(None);
    };
    Ok(match test.card.repeats() {
        true => Some(test.of_lines(&lead.lines, at)),
        false => test.of_shape(lead.shape, at),
    })
}

/// The test of the last effect of a hypothesis.
struct ScoreTest<'a> {
    problem: &'a Problem<'a>,
    h: &'a Hypothesis,
    card: &'a EffectCard,
    predictor: Predictor<'a>,
}

impl<'a> ScoreTest<'a> {
    /// `None` where nothing switches the effect off by degrees.
    fn new(problem: &'a Problem<'a>, h: &'a Hypothesis) -> Result<Option<Self>, Error> {
        let card = &problem.catalogue[h.new_effect()];
        let test = Self {
            problem,
            h,
            card,
            predictor: problem.predictor(h)?,
        };
        let is_off = is_unknown_function(&card.id) || test.strength().is_some();
        Ok((card.repeats() || is_off).then_some(test))
    }

    /// Place of parameter `i` of the effect among the shared ones.
    fn index(&self, i: usize) -> Option<usize> {
        let name = &self.card.parameters[i].name;
        self.h.shared_index(&format!("{}.{name}", self.card.id))
    }

    /// What switches the effect off by degrees: its place among the effect's parameters and among the shared ones.
    fn strength(&self) -> Option<(usize, usize)> {
        let strength = self.card.switch()?;
        Some((strength, self.index(strength)?))
    }

    /// Parameters of the effect that have no meaning without any strength: those of a formula, and time constants of a curve.
    fn shapes(&self) -> Vec<usize> {
        if is_unknown_function(&self.card.id) {
            return self.of_curve(Kind::Shape);
        }
        let strength = self.card.switch();
        let is_shape =
            |i: &usize| Some(*i) != strength && self.card.parameters[*i].role == Role::Shape;
        let shapes = (0..self.card.parameters.len()).filter(is_shape);
        shapes.filter_map(|i| self.index(i)).collect()
    }

    /// Shared parameters of this kind that the effect, a curve, has.
    fn of_curve(&self, kind: Kind) -> Vec<usize> {
        let all = self.h.shared.iter().enumerate();
        let of_kind = all.filter(|(_, p)| p.kind == kind && p.name.starts_with(&self.card.id));
        of_kind.map(|(i, _)| i).collect()
    }

    /// The hypothesis without the effect, as a point of that with it.
    fn without(&self, at: &At) -> Point {
        widen(at.base, self.h, &Point::centre(self.h, at.segments))
    }

    /// The strongest lines of what repeats.
    fn lines(&mut self, at: &At) -> Vec<Line> {
        let (point, data) = (self.without(at), self.problem.data(at.segments));
        response_spectrum::lines(
            &mut self.predictor,
            self.h,
            self.card,
            &data,
            &point,
            STRIDE,
            SEEN_LINES,
            None,
        )
    }

    /// What repeats, at the line near these that gains most.
    fn of_lines(&mut self, lines: &[Line], at: &At) -> Promise {
        let (point, data) = (self.without(at), self.problem.data(at.segments));
        let tested = lines.iter().filter_map(|line| {
            let near = Some(line.value);
            let (h, card) = (self.h, self.card);
            let again =
                response_spectrum::lines(&mut self.predictor, h, card, &data, &point, 1, 1, near);
            again.into_iter().next()
        });
        let line = tested.max_by(|a, b| a.gain.total_cmp(&b.gain));
        let fall = line.as_ref().map_or(0.0, |line| line.gain);
        let start = line.and_then(|line| on_line(self.h, self.card, &point, &line));
        let independent = response_spectrum::independent_lines(self.card, at.segments);
        Promise {
            gain: gain_of_line(fall, independent, self.problem.fitted_runs()),
            fall,
            start: start.unwrap_or(point),
            strength: None,
        }
    }

    /// What has a strength, or a curve, in a shape.
    fn of_shape(&mut self, factor: f64, at: &At) -> Option<Promise> {
        let mut point = self.without(at);
        for i in self.shapes() {
            let parameter = &self.h.shared[i];
            point.shared[i] = parameter.clamp(parameter.position(factor * parameter.prior));
        }
        match is_unknown_function(&self.card.id) {
            true => self.of_values(point, at),
            false => self.of_strength(point, at),
        }
    }

    /// All values of a curve together.
    fn of_values(&mut self, mut point: Point, at: &At) -> Option<Promise> {
        let curve = self.of_curve(Kind::Latent);
        point.shared[*curve.first()?] = BARELY_ON;
        let (matrix, gradient) = self.reduced(&point, at);
        let (gain, fall) = gain_of_curve(matrix, gradient, &curve)?;
        Some(Promise {
            gain,
            fall,
            start: point,
            strength: None,
        })
    }

    fn of_strength(&mut self, mut point: Point, at: &At) -> Option<Promise> {
        let (strength, c) = self.strength()?;
        let (parameter, p) = (&self.h.shared[c], &self.card.parameters[strength]);
        point.shared[c] = parameter.clamp(parameter.position(BARELY_ON * p.typical));
        let (mut matrix, mut gradient) = self.reduced(&point, at);
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
    }

    /// Information and descent by all parameters, start states projected out.
    fn reduced(&mut self, point: &Point, at: &At) -> (DMatrix<f64>, DVector<f64>) {
        let data = self.problem.data(at.segments);
        let mut fitter = Fitter::new(&mut self.predictor, self.h, &data, one_step());
        fitter.reduced_beside(at.known(), point.clone())
    }
}

/// Options of the one step that a score test is.
fn one_step() -> FitOptions {
    FitOptions {
        robust: false,
        stride: 1,
        ..FitOptions::search(1)
    }
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
