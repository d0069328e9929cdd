//! First looks at the starts of a search, and the climb from those that look best.

use crate::diagnose::estimation::fit::Fit;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::initialisation::search_options::SearchOptions;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::thresholds::LOST;

/// Jacobians after which a start must not be hopeless: ...
const FOOTHILL: usize = 2;
/// ... above this many times the objective without the effect.
const HOPELESS: f64 = 2.0;
/// A fit whose median error is below this many times the noise is about to arrive.
const FOUND: f64 = 1.5;

/// The search for one hypothesis.
pub(crate) struct FirstFits<'a, 'b> {
    hypothesis: &'a Hypothesis,
    data: &'b Observations<'b>,
    search: SearchOptions,
    /// The best fit that was followed.
    pub best: Option<Fit>,
}

impl<'a, 'b> FirstFits<'a, 'b> {
    /// A search that has seen nothing.
    pub fn new(
        hypothesis: &'a Hypothesis,
        data: &'b Observations<'b>,
        search: SearchOptions,
    ) -> Self {
        Self {
            hypothesis,
            data,
            search,
            best: None,
        }
    }

    fn fit(&self, predictor: &mut Predictor<'a>, start: Point, options: FitOptions) -> Fit {
        Fitter::new(predictor, self.hypothesis, self.data, options).run(start)
    }

    /// Whether a fit has come down to the noise: on all segments, where those that fit worst have a say.
    pub fn has_arrived(&self) -> bool {
        let arrived = |fit: &Fit| match self.search.trims {
            true => fit.error_quantile(self.data, 0.75) < FOUND,
            false => fit.error_quantile(self.data, 1.0) < LOST,
        };
        self.best.as_ref().is_some_and(arrived)
    }

    /// Looks at the starts and gives those that are left to follow, best first. What is about to arrive is followed at once, and
    /// ends it all when it has.
    pub fn of(&mut self, predictor: &mut Predictor<'a>, starts: Vec<Point>) -> Vec<Fit> {
        let options = self.search.first_fit();
        let mut found = Vec::new();
        for start in starts {
            let seen = self.fit(predictor, start, options);
            // Where most segments are met without the effect, that tells nothing of it.
            if self.search.trims && seen.error_quantile(self.data, 0.5) < FOUND {
                let climb = self.search.following(self.search.climb);
                let fit = self.fit(predictor, seen.point, climb);
                keep_better(&mut self.best, fit);
                if self.has_arrived() {
                    break;
                }
            } else {
                found.push(seen);
            }
        }
        found.sort_by(|a, b| a.trimmed.total_cmp(&b.trimmed));
        found
    }

    /// Follows a start to the end, unless it turns out hopeless beside the objective without the effect.
    pub fn follow(&mut self, predictor: &mut Predictor<'a>, start: Point, without: f64) {
        // Lost segments are not looked for before the start has shown promise: a model that is wrong loses many.
        let foothill = FitOptions {
            reinitialise: false,
            ..self.search.following(FOOTHILL)
        };
        let mut fit = self.fit(predictor, start, foothill);
        if fit.trimmed < HOPELESS * without {
            let rest = self.search.following(self.search.climb - FOOTHILL);
            fit = self.fit(predictor, fit.point, rest);
        }
        keep_better(&mut self.best, fit);
    }
}

pub(crate) fn keep_better(best: &mut Option<Fit>, fit: Fit) {
    if best.as_ref().is_none_or(|b| fit.trimmed < b.trimmed) {
        *best = Some(fit);
    }
}
