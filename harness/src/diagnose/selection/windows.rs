//! Where a search takes place while its models are far from the data: on windows that the segments fall into.
//!
//! The objective of multiple shooting is the smoother the shorter the pieces are that are predicted from starts of their own: its
//! Lipschitz constants grow with their length, exponentially where the motion is irregular. Over a quarter of a segment a
//! wrong model errs by its forces alone, over a whole one also by the transitions that it misses. A fit on windows finds its
//! way from afar and is then continued on windows twice as long, and on the segments, which tell hypotheses apart.
//! Source: Ribeiro, Tiels, Umenberger, Schön and Aguirre, Automatica 121 (2020) 109158, theorems 1 and 3.

use crate::diagnose::initialisation::search_options::THOROUGH;
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::SAMPLES_OF_A_STATE;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::further_fits::{POLISH, refitting};
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::watch::Watch;

/// Windows of a segment where a search begins, and where it goes on: each twice as long as before.
const PARTS: [usize; 2] = [4, 2];

/// The windows of the segments on which hypotheses are compared.
pub(crate) struct Windows<'a> {
    /// The windows, as segments.
    pub screen: Screen<'a>,
    /// Which of them begins each of the segments.
    first: Vec<usize>,
}

impl<'a> Windows<'a> {
    /// The shortest ones.
    pub fn quarters(screen: &Screen<'a>) -> Self {
        Self::new(screen, PARTS[0])
    }

    /// Those twice as long.
    pub fn halves(screen: &Screen<'a>) -> Self {
        Self::new(screen, PARTS[1])
    }

    /// Whether window `k` is the first of its segment.
    pub fn begins_segment(&self, k: usize) -> bool {
        self.first.binary_search(&k).is_ok()
    }

    /// Windows of at most a `parts`-th of each segment of `screen`, and of as many samples as a start state asks for.
    fn new(screen: &Screen<'a>, parts: usize) -> Self {
        let problem = screen.problem;
        let (mut segments, mut indices, mut first) = (Vec::new(), Vec::new(), Vec::new());
        for (segment, &index) in screen.segments.iter().zip(&screen.indices) {
            first.push(segments.len());
            let least = SAMPLES_OF_A_STATE * segment.state.len();
            let length = (segment.time.len() / parts).max(least);
            let interval = problem.campaign.runs[segment.run].sample_interval();
            let smoothing = &problem.smoothings[segment.run];
            let windows = segment.windows(smoothing, interval, length);
            indices.resize(indices.len() + windows.len(), index);
            segments.extend(windows);
        }
        Self {
            screen: Screen::of_segments(problem, indices, segments),
            first,
        }
    }

    /// Logarithm of the evidence of a model on the windows, nats, where each segment has but one start state to pay for: the other
    /// windows begin where one ends.
    pub fn log_evidence(&self, model: &FittedModel) -> f64 {
        let fit = &model.fitted.fit;
        let prices = fit.state_prices.iter().enumerate();
        let later = prices.filter(|&(k, _)| !self.begins_segment(k));
        fit.log_evidence + later.map(|(_, price)| price).sum::<f64>()
    }

    /// A point of the segments on the windows: those within a segment start where the smoother has them.
    pub fn divided(&self, h: &Hypothesis, on_segments: &Point) -> Point {
        let mut point = Point::centre(h, &self.screen.segments);
        point.shared.clone_from(&on_segments.shared);
        point.per_run.clone_from(&on_segments.per_run);
        for (k, &window) in self.first.iter().enumerate() {
            point.put(window, on_segments.start(k));
        }
        point
    }

    /// A point of the windows on the segments.
    pub fn joined(&self, point: &Point) -> Point {
        let states = self.first.iter().map(|&k| point.states[k].clone());
        Point {
            shared: point.shared.clone(),
            per_run: point.per_run.clone(),
            states: states.collect(),
            stuck: self.first.iter().map(|&k| point.stuck[k]).collect(),
        }
    }

    /// A model fitted further on the windows, from a point of the segments.
    fn continued(&self, model: &FittedModel, on_segments: &Point) -> Result<FittedModel, Error> {
        let start = self.divided(&model.fitted.hypothesis, on_segments);
        let options = refitting(POLISH);
        self.screen.continued(&model.choices, start, options)
    }
}

/// Segments and the windows that they fall into.
pub(crate) struct Lengths<'a, 'b> {
    segments: &'b Screen<'a>,
    /// Windows from the shortest on.
    windows: [Windows<'a>; PARTS.len()],
}

impl<'a, 'b> Lengths<'a, 'b> {
    /// The windows of the segments of `screen`.
    pub fn of(segments: &'b Screen<'a>) -> Self {
        Self {
            segments,
            windows: PARTS.map(|parts| Windows::new(segments, parts)),
        }
    }

    /// The best of some hypotheses, each `base` with one effect more: searched for on the shortest windows, the best of them continued
    /// on longer ones and on the segments, to its end there. Nothing once the search is stopped.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn search(
        &self,
        jobs: &[Vec<Choice>],
        base: &FittedModel,
        watch: &dyn Watch,
    ) -> Result<Vec<FittedModel>, Error> {
        let shortest = &self.windows[0];
        let base = shortest.continued(base, &base.fitted.fit.point)?;
        let mut found = shortest.screen.compete(jobs, &base, THOROUGH, watch)?;
        shortest.screen.polish(&mut found, watch)?;
        let Some(best) = found.first() else {
            return Ok(Vec::new());
        };
        let mut point = shortest.joined(&best.fitted.fit.point);
        for windows in &self.windows[1..] {
            let further = windows.continued(best, &point)?;
            point = windows.joined(&further.fitted.fit.point);
        }
        let options = refitting(POLISH);
        let mut last = vec![self.segments.continued(&best.choices, point, options)?];
        self.segments.finish(&mut last, watch)?;
        Ok(last)
    }
}
