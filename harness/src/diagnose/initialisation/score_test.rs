//! Score test: what evidence an effect could gain beside a model at its optimum, without fitting it.
//!
//! At the optimum of the smaller model the effect is put barely on; [`super::expected_gain`] tells the gain from the score of its
//! strength and the information on it. Holds where the smaller model is down to the noise, so that the effect can only be weak.
//! Source: Rao, Proc. Camb. Phil. Soc. 44 (1948) 50.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::{FitOptions, STRIDE};
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::nesting::widen;
use crate::diagnose::estimation::sensitivities::{Known, Linear};
use crate::diagnose::initialisation::expected_gain::{
    Gain, gain, gain_of_curve, gain_of_line, gain_of_profile,
};
use crate::diagnose::initialisation::response_spectrum::{ResponseSpectrum, independent_lines};
use crate::diagnose::initialisation::starts::at as on_line;
use crate::diagnose::model::belt_profile::{Roughness, is_profile, tried_lengths};
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::parameter::{Kind, Parameter};
use crate::diagnose::model::periodic::Line;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::is_unknown_function;
use crate::error::Error;
use crate::fmu::effect_card::{EffectCard, Role};
use crate::parallel::parallel;
use nalgebra::{DMatrix, DVector};

/// Strength at which derivatives are taken, as a share of the typical one: without any, shapes have no meaning. A typical strength changes a
/// prediction by up to a thousand times the noise, this share of it by less than [`UNSEEN`]: what an effect does beyond what other
/// constants do may be no more than how its derivative changes by a thousandth of the typical strength.
pub(crate) const BARELY_ON: f64 = 1e-6;
/// Lines of the screen's spectrum that are tested on all data: what is worth its price there stands out of the noise's lines on a part
/// of them, but not always above all of these.
const SEEN_LINES: usize = 5;
/// Shapes that are tried, as factors on the typical one.
const SHAPES: [f64; 3] = [1.0, 0.2, 5.0];

/// Change of a prediction, as a share of the noise, that a million samples do not show.
const UNSEEN: f64 = 1e-3;

/// What a score test promises of an effect.
pub(crate) struct Promise {
    /// Expected gain in evidence, nats.
    pub gain: f64,
    /// Expected fall of the negative logarithm of the likelihood, nats: the same without the price of what is free.
    pub fall: f64,
    /// The smaller model's optimum with the effect barely on, in the shape that promises most.
    pub start: Point,
    /// What the data would tell of its strength; `None` for what repeats, has many values or leaves no trace.
    pub strength: Option<Strength>,
    /// What promises most to be believed of values along the belt; `None` for what has none.
    roughness: Option<Roughness>,
}

impl Promise {
    /// Whether the data would tell anything of the effect.
    pub fn leaves_trace(&self) -> bool {
        self.gain != 0.0 || self.strength.is_some()
    }

    /// The hypothesis tested, believed as it promises most.
    pub fn choices(&self, tested: &[Choice]) -> Vec<Choice> {
        let mut choices = tested.to_vec();
        if let (Some(last), Some(roughness)) = (choices.last_mut(), self.roughness) {
            last.roughness = roughness;
        }
        choices
    }
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

    /// The segments, linearised there.
    pub(crate) fn linear(&self) -> &[Option<Linear>] {
        &self.linear
    }

    /// The same, for a larger hypothesis.
    pub(crate) fn known(&self) -> Known<'_> {
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
        // What leaves no trace in one shape may leave one in another.
        let worth =
            |promise: &Option<Promise>| promise.as_ref().map(|p| (p.leaves_trace(), p.gain));
        if worth(&found) > worth(&lead.promise) {
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
    /// `None` where nothing switches the effect off by degrees, nor has it values along the belt that may all be zero.
    fn new(problem: &'a Problem<'a>, h: &'a Hypothesis) -> Result<Option<Self>, Error> {
        let card = &problem.catalogue[h.new_effect()];
        let test = Self {
            problem,
            h,
            card,
            predictor: problem.predictor(h)?,
        };
        let is_curve = is_unknown_function(&card.id) || test.is_profile();
        let is_off = is_curve || test.strength().is_some();
        Ok((card.repeats() || is_off).then_some(test))
    }

    /// Whether it is of values along the belt, all of which may be zero. Where break-aways tell them they are not.
    fn is_profile(&self) -> bool {
        is_open_profile(self.problem, self.card)
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
        let (predictor, h, card) = (&mut self.predictor, self.h, self.card);
        let spectrum = ResponseSpectrum::new(predictor, h, card, &data, &point, STRIDE);
        spectrum.map_or(Vec::new(), |mut s| s.strongest(SEEN_LINES))
    }

    /// What repeats, at the line near these that gains most.
    fn of_lines(&mut self, lines: &[Line], at: &At) -> Promise {
        let (point, data) = (self.without(at), self.problem.data(at.segments));
        let (predictor, h, card) = (&mut self.predictor, self.h, self.card);
        let mut spectrum = match lines {
            [] => None,
            _ => ResponseSpectrum::new(predictor, h, card, &data, &point, 1),
        };
        let again = lines.iter();
        let again = again.filter_map(|line| spectrum.as_mut()?.near(line.value));
        let line = again.max_by(|a, b| a.gain.total_cmp(&b.gain));
        let fall = line.as_ref().map_or(0.0, |line| line.gain);
        let start = line.and_then(|line| on_line(self.h, self.card, &point, &line));
        let independent = independent_lines(self.card, at.segments);
        Promise {
            gain: gain_of_line(fall, independent, self.problem.fitted_runs()),
            fall,
            start: start.unwrap_or(point),
            strength: None,
            roughness: None,
        }
    }

    /// What has a strength, a curve or values along the belt, in a shape.
    fn of_shape(&mut self, factor: f64, at: &At) -> Option<Promise> {
        let mut point = self.without(at);
        for i in self.shapes() {
            let parameter = &self.h.shared[i];
            point.shared[i] = parameter.clamp(parameter.position(factor * parameter.prior));
        }
        if is_unknown_function(&self.card.id) {
            return self.of_values(point, at);
        }
        match self.is_profile() {
            true => self.of_profile(at),
            false => self.of_strength(point, at),
        }
    }

    /// All values along the belt together, with the spread and the correlation length that gain most.
    fn of_profile(&self, at: &At) -> Option<Promise> {
        let lengths = tried_lengths(self.card, &self.problem.tracks);
        let price = (lengths.len() as f64).ln();
        let of_length = |length: f64| {
            let mut choices = self.h.choices.clone();
            choices.last_mut()?.roughness.length = length;
            let h = self.problem.hypothesis(&choices).ok()?;
            let mut test = ScoreTest {
                problem: self.problem,
                h: &h,
                card: self.card,
                predictor: self.problem.predictor(&h).ok()?,
            };
            test.of_roughness(length, at)
        };
        let all = lengths.into_iter().filter_map(of_length);
        let mut best = all.max_by(|a, b| a.gain.total_cmp(&b.gain))?;
        best.gain -= price;
        Some(best)
    }

    /// All values along the belt together at a correlation length in m, with the spread that gains most.
    fn of_roughness(&mut self, length: f64, at: &At) -> Option<Promise> {
        let (h, point) = (self.h, self.without(at));
        let all = h.shared.iter().chain(h.per_run.iter().flatten());
        let own = format!("{}.", self.card.id);
        let is_value =
            |(_, p): &(usize, &Parameter)| p.support.is_some() && p.name.starts_with(&own);
        let values: Vec<usize> = all.enumerate().filter(is_value).map(|(i, _)| i).collect();
        let believed = h.choices.last()?.roughness.std;
        let (mut matrix, gradient) = self.reduced(&point, at);
        // The values are zero here, so that their belief has no part in the gradient.
        for &i in &values {
            matrix[(i, i)] -= believed.powi(-2);
        }
        let found = gain_of_profile(&matrix, &gradient, &values, Roughness::UNTOLD.std)?;
        Some(Promise {
            gain: found.gain,
            fall: found.gain + found.occam,
            start: point,
            strength: None,
            roughness: Some(Roughness {
                std: found.std,
                length,
                is_told: false,
            }),
        })
    }

    /// All values of a curve together.
    fn of_values(&mut self, mut point: Point, at: &At) -> Option<Promise> {
        let curve = self.of_curve(Kind::Latent);
        point.shared[*curve.first()?] = BARELY_ON;
        let (matrix, gradient) = self.reduced(&point, at);
        let (gain, fall) = gain_of_curve(&matrix, &gradient, &curve)?;
        Some(Promise {
            gain,
            fall,
            start: point,
            strength: None,
            roughness: None,
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
        if found.std.is_infinite() {
            let mut on = point.clone();
            on.shared[c] = parameter.clamp(parameter.position(p.typical));
            if self.acts(&on, at) {
                // Not by degrees: beyond a gap, or a threshold.
                return None;
            }
        }
        let strength = |found: Gain| Strength {
            std: found.std * parameter.slope(u).abs(),
            occam: found.occam,
        };
        Some(Promise {
            gain: found.gain,
            fall: found.gain + found.occam,
            start: point,
            strength: found.std.is_finite().then(|| strength(found)),
            roughness: None,
        })
    }

    /// Whether the effect changes any prediction from what the hypothesis without it gives.
    fn acts(&mut self, on: &Point, at: &At) -> bool {
        let data = self.problem.data(at.segments);
        let mut fitter = Fitter::new(&mut self.predictor, self.h, &data, one_step());
        let mut segments = at.linear.iter().enumerate();
        segments.any(|(k, known)| {
            let (Some(known), Some(now)) = (known, fitter.residual(k, on)) else {
                return true;
            };
            let least = UNSEEN * data.noise[data.segments[k].run];
            let mut pairs = now.iter().zip(&known.residual);
            pairs.any(|(now, known)| (now - known).abs() > least)
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
pub(crate) fn one_step() -> FitOptions {
    FitOptions {
        robust: false,
        stride: 1,
        ..FitOptions::search(1)
    }
}

/// Whether a score test can speak of an effect: something switches it off by degrees, it repeats, or all its values along the belt may
/// be zero.
pub(crate) fn is_testable(problem: &Problem, effect: usize) -> bool {
    let card = &problem.catalogue[effect];
    let is_switched = card.repeats() || card.switch().is_some();
    is_switched || is_open_profile(problem, card)
}

fn is_open_profile(problem: &Problem, card: &EffectCard) -> bool {
    is_profile(card) && !problem.place_is_told()
}
